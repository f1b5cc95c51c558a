"""A folder of submissions: who handed in what. One file a student, or one folder a student; nothing in them is run."""

from __future__ import annotations

import os
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
    student : the file's name without its ending, or the folder's name.
    files : the notebooks and scripts, sorted. problem : why there is nothing to grade, or "".
    """

    student: str
    files: tuple[Path, ...]
    problem: str = ""

    def read(self) -> tuple[dict[str, bytes], str]:
        """Return name -> content of the files, and a problem, or ""."""
        contents = {}
        for path in self.files if not self.problem else ():
            try:
                if path.stat().st_size > LARGEST:
                    return {}, (
                        f"{path.name} has {path.stat().st_size >> 20} MB, the limit is {LARGEST >> 20} MB: clear the "
                        f"outputs of the notebook and save it."
                    )
                contents[path.name] = path.read_bytes()
            except OSError as error:
                return {}, f"{path.name} cannot be read ({error.strerror})."
        return contents, self.problem


def find_submissions(folder: Path) -> list[Submission]:
    """List what a folder holds, sorted by student.

    Hidden entries are passed over. A link is not followed: it may lead out of the submission.

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
    places = [place for place in places if place.is_symlink() or place.is_dir() or place.suffix in SUFFIXES]
    if not places:
        raise ValueError(f"{folder} holds no submission: put a notebook (.ipynb or .py) or a folder a student there.")
    names = Counter(_student(place) for place in places)
    found = [_submission(place, place.name if names[_student(place)] > 1 else _student(place)) for place in places]
    return sorted(found, key=lambda one: one.student)


def _student(place: Path) -> str:
    return place.stem if place.suffix in SUFFIXES else place.name


def _submission(place: Path, student: str) -> Submission:
    if place.is_symlink():
        return Submission(student, (), f"{place.name} is a link, not a file.")
    if place.is_dir():
        files = _files_in(place)
        return Submission(student, files, "" if files else "the folder holds no notebook (.ipynb or .py).")
    if not place.is_file():
        return Submission(student, (), f"{place.name} is no file.")
    return Submission(student, (place,))


def _files_in(folder: Path) -> tuple[Path, ...]:
    found = []
    for here, folders, names in os.walk(folder):  # does not follow links
        depth = len(Path(here).relative_to(folder).parts)
        folders[:] = sorted(name for name in folders if not name.startswith(".") and depth < DEEPEST)
        found += [Path(here) / name for name in sorted(names) if not name.startswith(".")]
    return tuple(path for path in found if path.suffix in SUFFIXES and path.is_file() and not path.is_symlink())
