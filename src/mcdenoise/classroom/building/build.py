"""Build what goes out: the student tree, the same notebooks with solutions, and nbgrader's course."""

from __future__ import annotations

import ast
import shutil
from collections.abc import Sequence
from pathlib import Path

from mcdenoise.classroom.building.chapters import Chapter, read_chapters
from mcdenoise.classroom.building.folders import new_folder
from mcdenoise.classroom.building.hidden import public_tests
from mcdenoise.classroom.building.leaks import find_leaks, find_secrets
from mcdenoise.classroom.building.nbgrader_course import CONFIG
from mcdenoise.classroom.building.notebook import Kind, notebook_text
from mcdenoise.classroom.building.stubs import binds, parse

README = """# Exercises

You need the package mcdenoise with its extra `notebooks`: `pip install '.[notebooks]'` in a clone of the course, or
`pip install 'FILE.whl[notebooks]'` with the file that you were given. Then, in this folder, three commands:

    jupyter lab notebooks
    mcdenoise classroom check notebooks/{notebook}
    pytest

The first opens the notebooks: read, write, and see at once whether it holds. A cell with `check("name")` says in about a
second what holds and what does not, and shows your result beside the target. The second runs all checks of one notebook. The
third is for those who would rather write in an editor: the same exercises stand in exercises/*.py.

Hand in the notebooks (or exercises/*.py). Grading runs the same tests and some more. It takes from your file only the functions
and values that the exercises name, with what these need. An answer may use NumPy, Python's own modules, and `bell` and
`window_offsets` of mcdenoise.filters.window; the other functions of mcdenoise are not there when it is graded.
"""
PYTEST_INI = """[pytest]
addopts = -p mcdenoise.classroom.checking.pytest_plugin --impl exercises
testpaths = tests
markers =
"""
_NOT_IN_MODULES = ("matplotlib", "mcdenoise.classroom")


def build(root: Path, out: Path) -> list[Chapter]:
    """Write the trees `student`, `solution` and `nbgrader` into the folder `out`.

    Parameters
    ----------
    root : the clone of the repository. out : replaced if an earlier build made it and nobody worked in it since.

    Returns
    -------
    The chapters built.

    Raises
    ------
    ValueError
        As `read_chapters` for a mistake in the sources, `find_leaks` if a tree for students holds anything secret, and
        `new_folder` for `out`. Nothing is written then.
    """
    chapters = read_chapters(root)
    with new_folder(out) as folder:
        write_student(chapters, root, folder / "student")
        write_notebooks(chapters, root, folder / "solution" / "notebooks", "solution")
        write_tests(chapters, folder / "solution")
        write_course(chapters, root, folder / "nbgrader")
        refuse_leaks(chapters, root, [folder / "student", folder / "nbgrader" / "source"])
    return chapters


def refuse_leaks(chapters: Sequence[Chapter], root: Path, folders: Sequence[Path]) -> None:
    """Raise ValueError if one of the folders holds anything of a solution or of a hidden test."""
    secrets = find_secrets(chapters, root)
    leaks = [f"{folder.name}/{leak}" for folder in folders for leak in find_leaks(folder, secrets)]
    if leaks:
        more = f" ({len(leaks) - 1} more like this)" if leaks[1:] else ""
        raise ValueError(f"Nothing was written, because students would get a secret: {leaks[0]}{more}.")


def write_student(chapters: Sequence[Chapter], root: Path, folder: Path) -> None:
    """Write what students get: notebooks with stubs, the same stubs as modules, public tests, and how to start."""
    write_notebooks(chapters, root, folder / "notebooks", "student")
    write_tests(chapters, folder)
    for chapter in chapters:
        write(folder / "exercises" / f"{chapter.number}.py", exercise_module(chapter))
    marks = "".join(f"    {chapter.number}: chapter {chapter.number[2:]}\n" for chapter in chapters)
    write(folder / "pytest.ini", PYTEST_INI + marks)
    write(folder / "README.md", README.format(notebook=f"{chapters[0].name}.ipynb"))


def write_notebooks(chapters: Sequence[Chapter], root: Path, folder: Path, kind: Kind) -> None:
    """Write the notebooks of one kind (see `notebook_text`) and the data beside them."""
    for chapter in chapters:
        write(folder / f"{chapter.name}.ipynb", notebook_text(chapter, kind))
    copy_data(root, folder / "data")


def write_course(chapters: Sequence[Chapter], root: Path, folder: Path) -> None:
    """Write nbgrader's course: a source folder a chapter, the configuration, and all tests for the grader."""
    write(folder / "nbgrader_config.py", CONFIG)
    for chapter in chapters:
        source = folder / "source" / chapter.number
        write_notebooks([chapter], root, source, "nbgrader")
        write_tests([chapter], source)
        write(folder / "tests" / "exercises" / Path(chapter.test_file).name, chapter.tests)


def write_tests(chapters: Sequence[Chapter], folder: Path) -> None:
    """Write the public tests where `check` finds them."""
    for chapter in chapters:
        write(folder / chapter.test_file, public_tests(chapter.tests, chapter.test_file))


def copy_data(root: Path, folder: Path) -> None:
    """Copy the shipped references of notebooks/data."""
    for path in sorted((root / "notebooks" / "data").glob("*")):
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, folder / path.name)


def exercise_module(chapter: Chapter) -> str:
    """Return the exercises of a chapter as one plain module of stubs, with the imports of the notebook."""
    imports: dict[str, None] = {}
    for cell in chapter.cells:
        for node in (
            parse(cell.source, chapter.script, cell.line).body if cell.kind == "code" and not cell.exercise else ()
        ):
            wanted = isinstance(node, ast.Import | ast.ImportFrom) and not ast.unparse(node).split()[1].startswith(
                _NOT_IN_MODULES
            )
            imports |= {ast.unparse(node): None} if wanted and binds(node) else {}
    heading = (
        f'"""Exercises of chapter {chapter.number[2:]}: write them here, then run pytest in the folder above."""\n'
    )
    stubs = [f"{cell.stub.strip()}\n" for cell in chapter.cells if cell.exercise]
    return "\n\n".join(["\n".join([heading, *imports, ""]), *stubs])


def write(path: Path, text: str) -> None:
    """Write a text file as UTF-8 with plain line ends, its folder made if missing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8", newline="\n")
