"""A folder to work in: `python -m mcdenoise.classroom.building.lab` puts the exercises into work/, never over somebody's work."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from mcdenoise.classroom.building.build import build
from mcdenoise.classroom.building.chapters import find_root
from mcdenoise.classroom.building.folders import MARKER, files_below, sha256
from mcdenoise.samples.storage import write_beside
from mcdenoise.study.arguments import OneLineParser

OWN = ("notebooks", "exercises")  # folders whose files a student changes


def refresh(fresh: Path, work: Path) -> list[Path]:
    """Copy the student tree `fresh` into `work`, except over notebooks and exercises that were changed there.

    Parameters
    ----------
    fresh : a newly built student tree.
    work : the folder to work in, made if missing. A marker file in it remembers what was copied, so that an untouched
        notebook is replaced by a newer one, and one that somebody worked in stays.

    Returns
    -------
    Paths, relative to `work`, of what stayed though the fresh one differs.

    Raises
    ------
    ValueError
        If the marker file cannot be read.
    """
    marker = work / MARKER
    try:
        copied = dict(json.loads(marker.read_text("utf-8"))) if marker.exists() else {}
    except (ValueError, TypeError) as error:
        raise ValueError(f"{marker} cannot be read ({error}). Delete it: then everything that exists stays.") from None
    kept = []
    for source in files_below(fresh):
        name = source.relative_to(fresh)
        target, digest = work / name, sha256(source)
        if target.exists() and name.parts[0] in OWN and sha256(target) not in (digest, copied.get(name.as_posix())):
            kept.append(name)
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)
        copied[name.as_posix()] = digest
    with write_beside(marker) as temporary:
        temporary.write_text(json.dumps(copied, indent=1, sort_keys=True) + "\n", "utf-8")
    return kept


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code: 2 with one line for what could not be done."""
    parser = OneLineParser(
        prog="python -m mcdenoise.classroom.building.lab",
        description="Put the notebooks to work on into work/ of the clone; what you changed there stays as it is.",
    )
    parser.parse_args(arguments)
    try:
        root = find_root()
        build(root, root / "out" / "classroom")
        kept = refresh(root / "out" / "classroom" / "student", root / "work")
    except (ValueError, OSError) as error:
        print(f"lab: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    for name in kept:
        print(f"work/{name.as_posix()} is yours and stays; a fresh one is out/classroom/student/{name.as_posix()}")
    print("The notebooks are in work/notebooks.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
