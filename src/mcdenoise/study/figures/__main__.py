"""Make the figures of chapters, and store them with their numbers: `python -m mcdenoise.study.figures ch01 ch02`."""

from __future__ import annotations

import argparse
import importlib
import json
import pkgutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from tqdm import tqdm

import mcdenoise.study.figures as rooms
from mcdenoise.samples.storage import write_beside
from mcdenoise.study.arguments import OneLineParser
from mcdenoise.study.charts import save_figure

CHAPTERS = tuple(sorted(room.name for room in pkgutil.iter_modules(rooms.__path__) if room.name.startswith("ch")))


def figures_of(chapter: str) -> dict[str, Callable]:
    """Return the figures of a chapter: name -> function that makes it."""
    return importlib.import_module(f"mcdenoise.study.figures.{chapter}").FIGURES


def make(chapter: str, folder: Path, names: Sequence[str] | None = None) -> list[Path]:
    """Make the figures of a chapter (all, or those named) in `folder`; numbers of the others stay as they were."""
    stored = folder / f"{chapter}.json"
    numbers = json.loads(stored.read_text()) if stored.exists() else {}
    figures = figures_of(chapter)
    numbers = {name: value for name, value in numbers.items() if name in figures}
    written = [stored]
    for name in tqdm(names or figures, desc=chapter, unit="figure", disable=None):
        if name not in figures:
            raise ValueError(f"{chapter} has the figures {', '.join(figures)}; got {name!r}.")
        picture, numbers[name] = figures[name]()
        written.append(_save(picture, folder / f"{chapter}_{name}"))
    with write_beside(stored) as temporary:
        temporary.write_text(json.dumps(dict(sorted(numbers.items())), indent=1) + "\n")
    return written


def _save(picture: object, stem: Path) -> Path:
    """Store a Figure as a PNG, a Slider as an HTML fragment."""
    if hasattr(picture, "html"):
        path = stem.with_suffix(".html")
        with write_beside(path) as temporary:
            temporary.write_text(picture.html)
    else:
        path = stem.with_suffix(".png")
        save_figure(picture, path)
    return path


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    parser = OneLineParser(prog="python -m mcdenoise.study.figures", description="Make the figures of the lecture.")
    parser.add_argument("chapters", nargs="*", metavar="chNN", help=f"chapters (default: all: {' '.join(CHAPTERS)})")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="only these figures of the chapter")
    parser.add_argument("--out", type=Path, default=Path("lectures/figures"), help="folder (default lectures/figures)")
    options = parser.parse_args(arguments)
    try:
        for chapter in options.chapters or CHAPTERS:
            if chapter not in CHAPTERS:
                raise ValueError(f"There are figures for {', '.join(CHAPTERS)}; got {chapter!r}.")
            for path in make(chapter, options.out, options.only):
                print(path)
    except (ValueError, OSError) as error:
        print(f"figures: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
