"""Folders that this command makes: whole or not at all, and never in place of somebody's work."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

MARKER = ".mcdenoise-classroom.json"
CACHES = ("__pycache__", ".ipynb_checkpoints", ".pytest_cache")  # programs leave these behind; they are nobody's work


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file as 64 hexadecimal digits.

    Examples
    --------
    >>> with tempfile.TemporaryDirectory() as place:
    ...     _ = (Path(place) / "empty").write_bytes(b"")
    ...     sha256(Path(place) / "empty")[:8]
    'e3b0c442'
    """
    return hashlib.sha256(path.read_bytes()).hexdigest()


def files_below(folder: Path) -> list[Path]:
    """List the files below a folder, sorted, without those of caches and without the marker."""
    return [
        path
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != MARKER and not set(path.relative_to(folder).parts) & set(CACHES)
    ]


@contextmanager
def new_folder(out: Path) -> Iterator[Path]:
    """Give an empty folder beside `out`; when the block ends well, it takes the place of `out`.

    A marker file in it lists what was made. Only a folder with that marker is replaced, and only if nothing in it was
    changed or added since.

    Raises
    ------
    ValueError
        If `out` is a file, a folder that this command did not make, or one that holds work done since.

    Examples
    --------
    >>> with tempfile.TemporaryDirectory() as place:
    ...     with new_folder(Path(place) / "out") as folder:
    ...         _ = (folder / "note.txt").write_text("whole")
    ...     sorted(path.name for path in (Path(place) / "out").iterdir())
    ['.mcdenoise-classroom.json', 'note.txt']
    """
    out = Path(os.path.abspath(out))
    refuse_work(out)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(dir=out.parent, prefix=f".{out.name}-"))
    except OSError as error:
        raise ValueError(f"A folder that can be written to is needed, got {out}: {error}.") from error
    try:
        new, old = temporary / "new", temporary / "old"
        new.mkdir()
        yield new
        made = {path.relative_to(new).as_posix(): sha256(path) for path in files_below(new)}
        about = {"made_by": "mcdenoise classroom", "files": made}
        (new / MARKER).write_text(json.dumps(about, indent=1, sort_keys=True) + "\n", encoding="utf-8")
        if out.exists():
            out.rename(old)
        new.rename(out)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def refuse_work(out: Path) -> None:
    """Refuse to replace anything but a folder that `new_folder` made and nobody touched since; errors as there."""
    if not out.exists() or (out.is_dir() and not any(out.iterdir())):
        return
    elsewhere = "Choose another folder with --out, or move it away"
    if not (out / MARKER).is_file():
        raise ValueError(f"{out} was not made by this command and is not replaced. {elsewhere}.")
    try:
        made = dict(json.loads((out / MARKER).read_text(encoding="utf-8"))["files"])
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(
            f"{out / MARKER} is not readable ({error!r}), so {out} is not replaced. {elsewhere}."
        ) from error
    for path in files_below(out):
        name = path.relative_to(out).as_posix()
        if made.get(name) != sha256(path):
            raise ValueError(f"{out} holds work done since it was made ({name}) and is not replaced. {elsewhere}.")
