"""The chapters as their authors write them: notebooks/chNN_name.py with tests/exercises/test_chNN.py, read and checked."""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from pathlib import Path

from mcdenoise.classroom.building.hidden import TestMark, read_marks
from mcdenoise.classroom.building.stubs import (
    BEGIN,
    END,
    binds,
    bound,
    parse,
    solution_blocks,
    strip_solutions,
    stub_source,
)
from mcdenoise.classroom.checking.cells import parse_cells

_CHECK = re.compile(r"check\([\"'](\w+)[\"']\)")
_CELL_MARK = re.compile(r"^# %%( .*)?$")


@dataclass(frozen=True)
class SourceCell:
    """One cell of a source notebook.

    Attributes
    ----------
    kind : "code" or "markdown". source : its text; that of an exercise still holds the solution.
    line : where the text begins in the file, from 1. tags : Jupyter's cell tags.
    exercise : name of the exercise that the cell holds, or "". stub : what a student gets in its place.
    checks : name of the exercise, if the cell is its `check("name")`, or "".
    """

    kind: str
    source: str
    line: int
    tags: tuple[str, ...] = ()
    exercise: str = ""
    stub: str = ""
    checks: str = ""


@dataclass(frozen=True)
class Chapter:
    """One chapter: its notebook's cells and its tests.

    Attributes
    ----------
    name, number : "ch02_gaussian" and "ch02". script, test_file : where they stand, relative to the repository.
    tests : text of the test file. marks : its graded tests, in order.
    """

    name: str
    script: str
    test_file: str
    cells: tuple[SourceCell, ...]
    tests: str
    marks: tuple[TestMark, ...]

    @property
    def number(self) -> str:
        """The chapter's number, such as "ch02"."""
        return self.name.partition("_")[0]

    def points(self, exercise: str) -> float:
        """What all tests of an exercise are worth, public and hidden."""
        return sum(mark.points for mark in self.marks if mark.exercise == exercise)


def find_root(start: Path | None = None) -> Path:
    """Return the clone of the repository that holds `start` (default: the working directory).

    Raises
    ------
    ValueError
        If neither that folder nor one above it is a clone.
    """
    start = (start or Path.cwd()).resolve()
    for folder in [start, *start.parents]:
        if (folder / "pyproject.toml").is_file() and (folder / "notebooks").is_dir() and (folder / "tests").is_dir():
            return folder
    raise ValueError(
        f"This command needs a clone of the repository (a folder with pyproject.toml, notebooks and tests), and {start} is "
        f"not inside one. Go there, or name it with --root."
    )


def read_chapters(root: Path) -> list[Chapter]:
    """Read and check every chapter of the repository at `root`.

    Raises
    ------
    ValueError
        For the first mistake of an author, with file, line and cure: a notebook without tests or the reverse, an exercise
        without tests, tests without an exercise cell, an exercise that stands twice or that its cell does not define, a
        `check` of an unknown exercise or none after an exercise, marks that do not pair up or stand in another cell.
    """
    scripts = sorted((root / "notebooks").glob("ch[0-9][0-9]_*.py"))
    files = sorted((root / "tests" / "exercises").glob("test_ch[0-9][0-9].py"))
    if not scripts:
        raise ValueError(f"{root / 'notebooks'} holds no notebook chNN_name.py. Write one, or name another --root.")
    numbers = [path.name[:4] for path in scripts]
    for path in files:
        if path.stem[-4:] not in numbers:
            raise ValueError(f"tests/exercises/{path.name}: no notebook {path.stem[-4:]}_name.py uses it. Write one.")
    chapters, seen = [], {}
    for path in scripts:
        if numbers.count(path.name[:4]) > 1:
            raise ValueError(f"notebooks/{path.name}: another notebook has the number {path.name[:4]}. Choose another.")
        chapter = _read_chapter(path, root)
        for cell in chapter.cells:
            if cell.exercise in seen:
                raise ValueError(
                    f"{chapter.script}:{cell.line}: the exercise {cell.exercise} already stands in {seen[cell.exercise]}. "
                    f"Give it another name."
                )
            if cell.exercise:
                seen[cell.exercise] = f"{chapter.script}:{cell.line}"
        chapters.append(chapter)
    return chapters


def _read_chapter(path: Path, root: Path) -> Chapter:
    script, number = path.relative_to(root).as_posix(), path.name[:4]
    test_file = f"tests/exercises/test_{number}.py"
    if not (root / test_file).is_file():
        raise ValueError(f"{script}:1: the notebook has no tests. Write {test_file}.")
    tests = (root / test_file).read_text(encoding="utf-8")
    marks = tuple(read_marks(tests, test_file))
    cells = tuple(_read_cells(path.read_text(encoding="utf-8"), script, root))
    chapter = Chapter(path.stem, script, test_file, cells, tests, marks)
    _check_pairs(chapter)
    return chapter


def _read_cells(text: str, script: str, root: Path) -> list[SourceCell]:
    """Read the cells with their lines, and make the stubs."""
    solution_blocks(text, script)
    lines = text.splitlines()
    starts = [index for index, line in enumerate(lines) if _CELL_MARK.match(line)]
    cells = parse_cells(text, ".py", script)
    starts = [-1] * (len(cells) - len(starts)) + starts  # text before the first mark is a cell too
    read = []
    for cell, start in zip(cells, starts, strict=True):
        first = next((k for k in range(start + 1, len(lines)) if lines[k].strip()), start + 1) + 1
        exercise, tags = cell.metadata.get("exercise", ""), tuple(cell.metadata.get("tags", ()))
        if not exercise and (BEGIN in cell.source or END in cell.source):
            raise ValueError(
                f'{script}:{first}: a solution stands in a cell that is no exercise. Write # %% exercise="name" above it.'
            )
        checked = _CHECK.fullmatch(cell.source.strip()) if cell.kind == "code" else None
        stub = _stub(cell.source, exercise, script, first, root) if exercise else ""
        read.append(SourceCell(cell.kind, cell.source, first, tags, exercise, stub, checked[1] if checked else ""))
    return read


def _stub(source: str, name: str, script: str, line: int, root: Path) -> str:
    """What a student gets in place of an exercise cell."""
    nodes = parse(source, script, line).body
    if not any(name in binds(node) for node in nodes):
        raise ValueError(
            f"{script}:{line}: the exercise cell must define {name}, but does not. Correct the name in the cell or in its "
            f"exercise mark."
        )
    stub = (
        strip_solutions(source, script, line) if BEGIN in source else _imported_stub(source, name, script, line, root)
    )
    if not any(name in binds(node) for node in parse(stub, script, line).body):
        raise ValueError(
            f"{script}:{line}: without its solution the cell no longer defines {name}. Leave a first line outside the "
            f"marks, such as: {name} = None  # your prediction"
        )
    return stub


def _imported_stub(source: str, name: str, script: str, line: int, root: Path) -> str:
    """The cell with the import of the reference replaced by the stub of the function in src."""
    lines = source.splitlines()
    for node in parse(source, script, line).body:
        if isinstance(node, ast.ImportFrom) and name in binds(node) and (node.module or "").startswith("mcdenoise."):
            here = f"{script}:{line + node.lineno - 1}"
            if [bound(alias) for alias in node.names] != [name] or node.names[0].asname:
                raise ValueError(f"{here}: import the reference on a line of its own: from {node.module} import {name}")
            module = f"src/{node.module.replace('.', '/')}.py"
            if not (root / module).is_file():
                raise ValueError(f"{here}: there is no {module} to take {name} from. Name the file that defines it.")
            stub = stub_source((root / module).read_text(encoding="utf-8"), name, module)
            lines[node.lineno - 1 : node.end_lineno] = stub.splitlines()
            return "\n".join(lines)
    raise ValueError(
        f"{script}:{line}: the exercise {name} has no marked solution. Write {BEGIN} and {END} around what students write, "
        f"or import the reference from src."
    )


def _check_pairs(chapter: Chapter) -> None:
    """Exercises, their tests and their checks belong together."""
    tested = {mark.exercise for mark in chapter.marks}
    written = {cell.exercise: cell for cell in chapter.cells if cell.exercise}
    for mark in chapter.marks:
        if mark.exercise not in written:
            raise ValueError(
                f"{chapter.test_file}:{mark.line}: {mark.name} tests {mark.exercise}, but {chapter.script} has no cell "
                f'marked # %% exercise="{mark.exercise}". Write it, or correct the name.'
            )
    known = set()
    for cell in chapter.cells:
        here = f"{chapter.script}:{cell.line}"
        if cell.exercise and cell.exercise not in tested:
            raise ValueError(
                f'{here}: the exercise {cell.exercise} has no tests. Write some in {chapter.test_file}, marked @graded("'
                f'{cell.exercise}", points=1).'
            )
        known.add(cell.exercise)
        for name in _CHECK.findall(cell.source) if cell.kind == "code" else ():
            if name not in known:
                raise ValueError(f"{here}: check({name!r}): there is no such exercise above. Correct the name.")
    for name, cell in written.items():
        if not any(one.checks == name for one in chapter.cells):
            raise ValueError(
                f"{chapter.script}:{cell.line}: no cell checks the exercise {name}. Write a cell below with the line "
                f'check("{name}") alone.'
            )
