"""Archives to hand out: one a chapter and one of all, the same bytes whenever and wherever they are made."""

from __future__ import annotations

import tempfile
import zipfile
from pathlib import Path

from mcdenoise.classroom.building.build import refuse_leaks, write, write_student
from mcdenoise.classroom.building.chapters import read_chapters
from mcdenoise.classroom.building.folders import files_below, new_folder, sha256

SUMS = "SHA256SUMS"
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the first moment that a zip can name


def release(root: Path, out: Path) -> list[Path]:
    """Write chNN_name.zip for each chapter, exercises.zip with all of them, and SHA256SUMS (as `sha256sum` reads it).

    Parameters
    ----------
    root : the clone of the repository. out : replaced if an earlier release made it.

    Returns
    -------
    The archives, in the order of the list.

    Raises
    ------
    ValueError
        As `mcdenoise.classroom.building.build.build`.
    """
    chapters = read_chapters(root)
    names = {chapter.name: [chapter] for chapter in chapters} | {"exercises": chapters}
    with new_folder(out) as folder, tempfile.TemporaryDirectory() as workshop:
        for name, chosen in names.items():
            tree = Path(workshop) / name
            write_student(chosen, root, tree)
            refuse_leaks(chapters, root, [tree])
            write_archive(tree, folder / f"{name}.zip")
        archives = sorted(folder.glob("*.zip"))
        write(folder / SUMS, "".join(f"{sha256(path)}  {path.name}\n" for path in archives))
    return [Path(out) / path.name for path in archives]


def write_archive(tree: Path, path: Path) -> None:
    """Write the files below `tree` into a zip, under the folder's name, without times, owners or compression.

    Stored and not compressed, because zlib's bytes differ from version to version.
    """
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for file in files_below(tree):
            entry = zipfile.ZipInfo(f"{tree.name}/{file.relative_to(tree).as_posix()}", _EPOCH)
            entry.external_attr = 0o100644 << 16
            archive.writestr(entry, file.read_bytes())
