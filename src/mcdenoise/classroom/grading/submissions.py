"""A folder of submissions: who handed in what. One file a student, or one folder a student; nothing in them is run."""

from __future__ import annotations

import os
import unicodedata
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from mcdenoise.classroom.checking.cells import LARGEST

SUFFIXES = (".ipynb", ".py")
DEEPEST = 4  # folders below a student's own that are searched; nbgrader has one


@dataclass(frozen=True)
class Submission:
    """What one student handed in.

    Attributes
    ----------
    student : the file's name without its ending, or the folder's name; the whole name where that would fit two.
    files : the notebooks and scripts, sorted. problem : why there is nothing to grade, or "".
    folder : what the names of the files are relative to.
    """

    student: str
    files: tuple[Path, ...]
    problem: str = ""
    folder: Path = Path()

    def read(self) -> tuple[dict[str, bytes], str]:
        """Return name -> content of the files, and a problem, or ""."""
        contents = {}
        for path in self.files if not self.problem else ():
            try:
                name = path.relative_to(self.folder).as_posix()
                if path.stat().st_size > LARGEST:
                    return {}, (
                        f"{name} has {path.stat().st_size >> 20} MB, the limit is {LARGEST >> 20} MB: clear the "
                        f"outputs of the notebook and save it."
                    )
                contents[name] = path.read_bytes()
            except OSError as error:
                return {}, f"{path.name} cannot be read ({error.strerror})."
        return contents, self.problem


def find_submissions(folder: Path) -> list[Submission]:
    """List what a folder holds, sorted by student.

    Hidden entries are passed over. A link is not followed: it may lead out of the submission. What is no notebook is
    listed with a problem, so that nobody is missing from the table without a word.

    Raises
    ------
    ValueError
        If `folder` is no folder, cannot be read, or holds no submission.
    """
    if not folder.is_dir():
        raise ValueError(f"A folder of submissions is needed, got {folder}: there is no such folder.")
    try:
        places = sorted(place for place in folder.iterdir() if not place.name.startswith("."))
    except OSError as error:
        raise ValueError(f"The folder of submissions {folder} cannot be read ({error.strerror}).") from error
    if not any(place.is_dir() or _is_notebook(place) for place in places):
        raise ValueError(f"{folder} holds no submission: put a notebook (.ipynb or .py) or a folder a student there.")
    found = [_submission(place, student) for place, student in _students(places).items()]
    return sorted(found, key=lambda one: one.student)


def _students(places: list[Path]) -> dict[Path, str]:
    """Name the student of each place: no two alike, not even where a file system does not tell large from small."""
    names = {place: place.stem if _is_notebook(place) else place.name for place in places}
    while True:
        counts = Counter(_folded(name) for name in names.values())
        clash = [place for place, name in names.items() if counts[_folded(name)] > 1 and name != place.name]
        if not clash:
            return names
        names |= {place: place.name for place in clash}


def _folded(name: str) -> str:
    return unicodedata.normalize("NFC", name).casefold()


def _is_notebook(place: Path) -> bool:
    return place.suffix.lower() in SUFFIXES


def _submission(place: Path, student: str) -> Submission:
    if place.is_symlink():
        return Submission(student, (), f"{place.name} is a link, not a file.")
    if place.is_dir():
        files = _files_in(place)
        empty = f"the folder holds no notebook (.ipynb or .py), at most {DEEPEST} folders deep."
        return Submission(student, files, "" if files else empty, place)
    if not place.is_file():
        return Submission(student, (), f"{place.name} is no file.")
    if not _is_notebook(place):
        return Submission(student, (), f"{place.name} is no notebook: a file that ends in .ipynb or .py is needed.")
    return Submission(student, (place,), folder=place.parent)


def _files_in(folder: Path) -> tuple[Path, ...]:
    found = []
    for here, folders, names in os.walk(folder):  # does not follow links
        depth = len(Path(here).relative_to(folder).parts)
        folders[:] = sorted(name for name in folders if not name.startswith(".") and depth < DEEPEST)
        found += [Path(here) / name for name in sorted(names) if not name.startswith(".")]
    return tuple(path for path in found if _is_notebook(path) and path.is_file() and not path.is_symlink())
