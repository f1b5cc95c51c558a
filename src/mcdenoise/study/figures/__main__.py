"""Make the figures of chapters, and store them with their numbers: `python -m mcdenoise.study.figures ch01 ch02`."""

from __future__ import annotations

import importlib
import json
import math
import numbers
import pkgutil
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from tqdm import tqdm

import mcdenoise.study.figures as rooms
from mcdenoise.samples.storage import write_beside
from mcdenoise.study.arguments import OneLineParser
from mcdenoise.study.charts import save_figure
from mcdenoise.study.show import indexed_png
from mcdenoise.study.slider import Slider

DIGITS = 4
LARGEST = 200_000  # bytes of a PNG; noise does not compress, so that such a figure gets 256 colours and fewer dots
RESOLUTIONS = (150, 120, 100, 80)  # dots per inch, tried in this order
CHAPTERS = tuple(
    sorted(room.name for room in pkgutil.iter_modules(rooms.__path__) if re.fullmatch(r"ch\d\d", room.name))
)


def figures_of(chapter: str) -> dict[str, Callable]:
    """Return the figures of a chapter: name -> function that makes it."""
    return importlib.import_module(f"mcdenoise.study.figures.{chapter}").FIGURES


def make(chapter: str, folder: Path, names: Sequence[str] | None = None) -> list[Path]:
    """Make figures of a chapter and store them with their numbers.

    Parameters
    ----------
    chapter : such as "ch02".
    folder : gets chNN_name.png (a Figure) or chNN_name.html (a Slider) for each, and chNN.json with the numbers of all,
        rounded to four significant digits.
    names : the figures to make (default: all); numbers of the others stay as they were.

    Returns
    -------
    The paths written, the JSON file first.

    Raises
    ------
    ValueError
        For a name that the chapter does not have (before anything is made), or a number that JSON cannot hold.
    """
    figures = figures_of(chapter)
    for name in names or ():
        if name not in figures:
            raise ValueError(f"{chapter} has the figures {', '.join(figures)}; got {name!r}.")
    stored = folder / f"{chapter}.json"
    values = json.loads(stored.read_text("utf-8")) if stored.exists() else {}
    values = {name: value for name, value in values.items() if name in figures}
    written = [stored]
    for name in tqdm(names or figures, desc=chapter, unit="figure", disable=None):
        picture, quoted = figures[name]()
        values[name] = rounded(quoted, f"{chapter}.{name}")
        written.append(_save(picture, folder / f"{chapter}_{name}"))
    with write_beside(stored) as temporary:
        temporary.write_text(json.dumps(dict(sorted(values.items())), indent=1) + "\n", "utf-8")
    return written


def rounded(value: object, name: str) -> object:
    """Return numbers as JSON holds them and text quotes them: floats with four significant digits, in dicts and lists.

    Infinity, which JSON cannot hold, becomes the word.

    Raises
    ------
    ValueError
        For NaN, or what is no number, text, dict or list.

    Examples
    --------
    >>> rounded({"peak": 0.0176843, "spp": 8}, "ch02.impulse")
    {'peak': 0.01768, 'spp': 8}
    >>> rounded(math.inf, "ch03.guide")
    'infinity'
    """
    if isinstance(value, Mapping):
        return {str(key): rounded(inner, f"{name}.{key}") for key, inner in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [rounded(inner, name) for inner in value]
    if isinstance(value, (bool, str)):
        return value
    if isinstance(value, numbers.Integral):
        return int(value)
    if isinstance(value, numbers.Real) and not math.isnan(value):
        return "infinity" if math.isinf(value) else float(f"{float(value):.{DIGITS}g}")
    raise ValueError(f"{name} must be a number, text, or a dict or list of those, got {value!r}.")


def _save(picture: Figure | Slider, stem: Path) -> Path:
    """Store a Figure as a PNG, a Slider as an HTML fragment."""
    if isinstance(picture, Slider):
        path = stem.with_suffix(".html")
        with write_beside(path) as temporary:
            temporary.write_text(picture.html, "utf-8")
    else:
        path = stem.with_suffix(".png")
        save_figure(picture, path)
        smaller = iter(RESOLUTIONS)
        while path.stat().st_size > LARGEST and (dots := next(smaller, None)):
            with write_beside(path) as temporary:
                temporary.write_bytes(indexed_png(picture, dots))
    return path


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    parser = OneLineParser(prog="python -m mcdenoise.study.figures", description="Make the figures of the lecture.")
    parser.add_argument("chapters", nargs="*", metavar="chNN", help=f"chapters (default: all: {' '.join(CHAPTERS)})")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="only these figures of the chapter")
    parser.add_argument("--out", type=Path, default=Path("lectures/figures"), help="folder (default lectures/figures)")
    options = parser.parse_args(arguments)
    chapters = options.chapters or CHAPTERS
    try:
        for chapter in chapters:
            if chapter not in CHAPTERS:
                raise ValueError(f"There are figures for {', '.join(CHAPTERS)}; got {chapter!r}.")
        if options.only and len(chapters) > 1:
            raise ValueError("--only needs one chapter, such as: ch02 --only impulse.")
        for chapter in chapters:
            for path in make(chapter, options.out, options.only):
                print(path)
    except (ValueError, OSError) as error:
        print(f"figures: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
