"""Grade one student: the answers are taken out of the notebooks, run in processes of their own, and tested from here."""

from __future__ import annotations

import ast
import atexit
import functools
import re
import shutil
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from mcdenoise.classroom.checking.cells import parse
from mcdenoise.classroom.checking.exercise import ExerciseTests, Outcome, load_tests, run_test, sentence_of
from mcdenoise.classroom.checking.extract import Cell, answer_source, parse_cells
from mcdenoise.classroom.checking.finding import Finding, Unwritten
from mcdenoise.classroom.grading.remote import Budget, RemoteAnswer, turn
from mcdenoise.classroom.grading.results import ExerciseGrade, Grade
from mcdenoise.classroom.grading.sandbox import Limits, choose_sandbox

MOST_LINES = 3000  # of code in one notebook; the chapters have about 300


def grade_submission(
    name: str, content: bytes | str, suffix: str, tests: Path | Mapping[str, bytes], limits: Limits | None = None
) -> Grade:
    """Grade one notebook; never raises for anything that the notebook holds or does.

    Parameters
    ----------
    name : of the student. content : of the file. suffix : ".ipynb" or ".py".
    tests : file or folder of exercise tests, or file name -> content (for another machine).
    limits : what the submission may use (default: `Limits()`).

    Returns
    -------
    Grade
        Plain data: it can be pickled.

    Raises
    ------
    ValueError
        If the tests cannot be read, or the sandbox that `limits` asks for does not work.
    RuntimeError
        If no process can be started here.
    """
    content = content.encode() if isinstance(content, str) else content
    return grade_files(name, {f"{name}{suffix}": content}, tests, limits or Limits())


def grade_files(
    student: str, contents: Mapping[str, bytes], tests: Path | Mapping[str, bytes], limits: Limits, problem: str = ""
) -> Grade:
    """Grade the notebooks of one student (such as one a chapter); as `grade_submission`."""
    begin = time.monotonic()
    sandbox = choose_sandbox(limits.sandbox)
    exercises = exercises_of(tests)
    notebooks, unread = [], []
    for name, content in contents.items():
        try:
            notebooks.append(_read(name, content))
        except ValueError as error:
            unread.append(str(error))
    if unread and not notebooks:
        problem = problem or unread[0]
    if problem:
        grades = [failed(one, Finding(problem)) for one in exercises.values()]
    else:
        budget = Budget(limits.total_seconds)
        grades = [_grade_exercise(one, notebooks, limits, sandbox, budget) for one in exercises.values()]
    remark = "" if problem else " ".join(unread)
    return Grade(student, tuple(grades), sandbox, problem, round(time.monotonic() - begin, 3), remark)


def _read(name: str, content: bytes) -> list[Cell]:
    """Read the cells; refuse what no student writes and what would take the grader long to read."""
    if re.search(rb"^# %%.{2000}", content, re.MULTILINE):
        raise ValueError(f"{name} has a cell mark (# %%) of more than 2000 characters: shorten it.")
    cells = parse_cells(content, Path(name).suffix.lower(), name)
    lines = sum(len(re.findall(r"[^\r\n;]+", cell.source)) for cell in cells if cell.kind == "code")
    if lines > MOST_LINES:
        raise ValueError(f"{name} has {lines} lines of code, the limit is {MOST_LINES}: hand in the exercises alone.")
    return cells


def _grade_exercise(
    exercise: ExerciseTests, notebooks: list[list[Cell]], limits: Limits, sandbox: str, budget: Budget
) -> ExerciseGrade:
    try:
        source = _source(notebooks, exercise.name)
    except Finding as finding:
        return failed(exercise, finding)
    with RemoteAnswer(exercise.name, source, limits, sandbox, budget) as answer:
        outcomes = tuple(_run(test, answer) for test in exercise.tests)
        answer.close()
        return ExerciseGrade(exercise.name, exercise.chapter, outcomes, answer.printed)


def _source(notebooks: list[list[Cell]], name: str) -> str:
    """The answer from the last notebook that has one, else a stub; otherwise the first finding of why there is none."""
    findings, stubs = [], []
    for cells in reversed(notebooks):
        try:
            source = answer_source(cells, name)
        except Finding as finding:
            findings.append(finding)
            continue
        if not is_stub(source, name):
            return source
        stubs.append(source)
    if stubs:
        return stubs[0]
    raise findings[-1]


def is_stub(source: str, name: str) -> bool:
    """Whether an answer is still the one that was handed out: a function that raises NotImplementedError, or None.

    Examples
    --------
    >>> is_stub("def f(x):\\n    raise NotImplementedError('f is not written yet')", "f"), is_stub("f = 3", "f")
    (True, False)
    """
    last = parse(source).body[-1]
    if isinstance(last, ast.FunctionDef):
        end = last.body[-1]
        return last.name == name and isinstance(end, ast.Raise) and "NotImplementedError" in ast.unparse(end)
    return isinstance(last, ast.Assign) and isinstance(last.value, ast.Constant) and last.value.value in (None, ...)


def _run(test: Callable, answer: RemoteAnswer) -> Outcome:
    """Run one test, and let trouble of the grader itself be no fault of the student."""
    try:
        impl = answer.impl()
        with turn():
            outcome = run_test(test, impl)
    except Finding as finding:
        outcome = _fail(test, finding)
    if answer.trouble is not None:
        raise RuntimeError(str(answer.trouble)) from answer.trouble
    return outcome


def failed(exercise: ExerciseTests, finding: Finding) -> ExerciseGrade:
    """No test was run: all say the same."""
    return ExerciseGrade(exercise.name, exercise.chapter, tuple(_fail(test, finding) for test in exercise.tests))


def _fail(test: Callable, finding: Finding) -> Outcome:
    unwritten = isinstance(finding, Unwritten)
    return Outcome(test.__name__, sentence_of(test), *vars(test.graded).values(), False, str(finding), unwritten)


def read_tests(place: Path) -> dict[str, bytes]:
    """Return file name -> content of the exercise tests: one file, or all `test_ch*.py` of a folder.

    Raises
    ------
    ValueError
        If there is none.
    """
    files = sorted(place.glob("test_ch*.py")) if place.is_dir() else [place]
    if not files or not all(file.is_file() for file in files):
        raise ValueError(
            f"Exercise tests are needed (test_chNN.py, or a folder of them), got {place}. Name it with --tests."
        )
    return {file.name: file.read_bytes() for file in files}


def exercises_of(tests: Path | Mapping[str, bytes]) -> dict[str, ExerciseTests]:
    """Load exercise tests from a file, a folder, or file name -> content; errors as for `exercise.load_tests`."""
    return _load_copies(tuple(tests.items())) if isinstance(tests, Mapping) else load_tests(tests)


@functools.lru_cache(maxsize=8)
def _load_copies(tests: tuple[tuple[str, bytes], ...]) -> dict[str, ExerciseTests]:
    """Load tests from their text; the files stay until the process ends, because messages quote their lines."""
    folder = Path(tempfile.mkdtemp(prefix="mcdenoise-tests-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    for name, content in tests:
        (folder / name).write_bytes(content)
    return load_tests(folder if len(tests) > 1 else folder / tests[0][0])
