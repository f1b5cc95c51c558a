"""pytest for exercises: the fixture `impl`, and the option ``--impl PATH`` to test a student's notebook or file.

The file's code runs in pytest's own process, so this is for one's own answers; `mcdenoise classroom grade` is for those
of others.
"""

from __future__ import annotations

import builtins
import linecache
import re
from collections.abc import Iterator
from pathlib import Path
from types import FunctionType

import pytest

from mcdenoise.classroom.checking.exercise import as_impl
from mcdenoise.classroom.checking.extract import answer_source, read_cells
from mcdenoise.classroom.checking.finding import NOT_ANSWERED, Finding, Unwritten
from mcdenoise.classroom.checking.implementation import finding_of
from mcdenoise.classroom.checking.running import words_of


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add ``--impl``."""
    parser.getgroup("exercises").addoption(
        "--impl",
        metavar="PATH",
        type=Path,
        help="a notebook (.ipynb) or Python file whose answers the exercise tests are run on, or a folder of them",
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Give the exercise tests of a file test_chNN.py the mark chNN, where there are such marks."""
    known = {line.partition(":")[0] for line in config.getini("markers")}
    for item in items:
        if _mark(item) is not None and _chapter(item) in known:
            item.add_marker(_chapter(item))


@pytest.fixture
def impl(request: pytest.FixtureRequest) -> object:
    """Return the answer under test, of ``--impl`` or else of the chapter's notebook in `notebooks` beside `tests`.

    A Finding instead of an answer makes the test fail with its words.
    """
    mark, chapter = _mark(request.node), _chapter(request.node)
    if mark is None:
        pytest.fail(f"{request.node.name} uses `impl` and needs the mark @graded(exercise, points=...).", pytrace=False)
    try:
        path = answer_file(request.config.getoption("--impl") or request.node.path.parents[2] / "notebooks", chapter)
        named = re.match(r"ch\d\d", path.name)
        if named and named[0] != chapter:
            pytest.skip(f"{path.name} is about another chapter")
        answer = load_answer(path, mark.exercise)
    except Finding as finding:
        return finding
    except ValueError as error:
        pytest.fail(f"{error} Give a notebook, a Python file or a folder of them by --impl.", pytrace=False)
    return Unwritten(NOT_ANSWERED) if answer is None or answer is ... else as_impl(mark.exercise, answer)


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> None:
    """Fail where there is no answer to test."""
    answer = pyfuncitem.funcargs.get("impl")
    if isinstance(answer, Finding):
        raise answer


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo) -> Iterator[None]:
    """Show what is wrong with an answer in words alone; ``--tb=long`` shows where it came from.

    Without ``--impl`` the answer is the course's own, and an exception that is no Finding keeps its traceback.
    """
    report = yield
    error, mark = call.excinfo.value if call.excinfo is not None else None, _mark(item)
    if mark is None or report.outcome != "failed" or item.config.getoption("tbstyle") == "long":
        return report
    if isinstance(error, Finding) or (call.when == "call" and item.config.getoption("--impl") is not None):
        report.longrepr = f"{mark.exercise}: {words_of(error, mark.exercise, item.funcargs.get('impl'))}"
    return report


def answer_file(path: Path, chapter: str) -> Path:
    """Return the file of a chapter's answers: `path` itself, or the file chNN*.py or chNN*.ipynb in that folder.

    Raises
    ------
    ValueError
        If there is none.
    """
    if not path.is_dir():
        return path
    for found in [*sorted(path.glob(f"{chapter}*.py")), *sorted(path.glob(f"{chapter}*.ipynb"))]:
        return found
    raise ValueError(f"{path} holds no answers for {chapter}: a file {chapter}*.py or {chapter}*.ipynb is needed.")


def load_answer(path: Path, name: str) -> object:
    """Take an answer out of a file and run its code in this process; raises Finding in words for the student."""
    source = answer_source(read_cells(path), name)
    filename = f"<{name} in {path.name}>"
    linecache.cache[filename] = (len(source), None, source.splitlines(keepends=True), filename)
    namespace = {"__name__": "answer", "__builtins__": builtins}
    run = FunctionType(compile(source, filename, "exec", dont_inherit=True), namespace)
    try:
        run()
    except (Exception, SystemExit) as error:
        raise finding_of(error, run) from error
    return namespace[name]


def _mark(item: pytest.Item) -> object | None:
    return getattr(getattr(item, "function", None), "graded", None)


def _chapter(item: pytest.Item) -> str:
    return item.path.stem.removeprefix("test_")
