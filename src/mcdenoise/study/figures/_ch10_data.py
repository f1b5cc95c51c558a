"""What the figures of chapter 10 start from: the stored results of the three studies, samples, and tables for the page."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any

from mcdenoise.render import capture
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.bench_rpf_accuracy import geometric_mean
from mcdenoise.study.charts import COLOURS, MARKERS
from mcdenoise.study.entries import read_study
from mcdenoise.study.figures._references import FOLDER, reference
from mcdenoise.study.methods import METHODS
from mcdenoise.study.speed_accuracy_results import UNFILTERED, Point, pooled
from mcdenoise.study.studies import path_of

STUDIES = FOLDER.parents[1] / "lectures" / "studies"  # left there by `mcdenoise study all`
LOOKS = dict(zip(METHODS, zip(COLOURS, MARKERS, strict=True), strict=True))
GAINED = (
    "gaussian",
    "bilateral",
    "cross_bilateral_prefiltered",
    "nlm",
    "joint_nlm",
    "rpf",
    "lbf",
)  # drawn where room is short
THOUSAND = 1e3  # relMSE in thousandths, seconds in milliseconds
NAMES = {method.label: name for name, method in METHODS.items()}

__all__ = [
    "GAINED",
    "LOOKS",
    "NAMES",
    "THOUSAND",
    "captured",
    "key_of",
    "mean_over_scenes",
    "milliseconds",
    "reference",
    "samples_worth",
    "study",
    "table",
    "usual_points",
    "words",
]


@cache
def study(name: str) -> dict[str, Any]:
    """The stored results of one of the three studies: "speed-accuracy", "stability", "parsimony"."""
    return read_study(path_of(STUDIES, name), name)


@cache
def captured(scene: str, spp: int, seed: int = 0) -> SampleBuffer:
    """Samples of a toy scene, 128 x 128 pixels."""
    return capture(scene, 128, 128, spp, seed=seed, progress=False)


def key_of(label: str) -> str:
    """The name by which a page quotes what a label stands for.

    Examples
    --------
    >>> key_of("Joint NL-means"), key_of("OpenCV NL-means, 8 bits")
    ('joint_nl_means', 'opencv_nl_means_8_bits')
    """
    return NAMES.get(label) or re.sub(r"[^a-z0-9]+", "_", label.lower()).strip("_")


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown, which a page takes as a whole: numbers to the right, words to the left.

    Examples
    --------
    >>> print(table(["method", "s"], [["Gaussian", "0.1"], ["a | b", ""]]))
    | method | s |
    |---|---|
    | Gaussian | 0.1 |
    | a / b |  |
    """
    lines = [head, ["---"] * len(head), *rows]
    marked = [
        "|".join(["", *cells, ""]) if cells[0] == "---" else f"| {' | '.join(map(_cell, cells))} |" for cells in lines
    ]
    return "\n".join(marked)


def _cell(text: str) -> str:
    """Text without the sign that ends a cell."""
    return str(text).replace("|", "/")


def words(labels: Iterable[str], nothing: str = "none") -> str:
    """Labels as a list in a sentence, the commas within a label as brackets.

    Examples
    --------
    >>> words(["Gaussian, radius 1", "RPF"]), words([])
    ('Gaussian (radius 1), RPF', 'none')
    """
    shown = []
    for label in labels:
        name, *setting = label.rsplit(", ", 1)
        shown.append(f"{name} ({setting[0]})" if setting else name)
    return ", ".join(shown) or nothing


def milliseconds(seconds: float) -> str:
    """Seconds as a cell of a table shows them.

    Examples
    --------
    >>> milliseconds(0.0042), milliseconds(1.2345)
    ('4.2', '1230')
    """
    shown = 1e3 * seconds
    return f"{shown:.2g}" if shown < 10 else f"{float(f'{shown:.3g}'):.0f}"


def samples_worth(equal_spp: float) -> str:
    """Equal-error spp as a cell of a table shows it.

    Examples
    --------
    >>> samples_worth(7.84), samples_worth(42.3)
    ('7.8', '42')
    """
    return f"{equal_spp:.1f}" if equal_spp < 10 else f"{equal_spp:.0f}"


def usual_points(found: dict[str, Any], spp: int | None = None) -> dict[str, Point]:
    """Label of a method -> its usual setting pooled over the scenes, without the unfiltered image."""
    points = pooled(found, found["settings"]["chart_spp"] if spp is None else spp).values()
    return {point.curve: point for point in points if point.usual and point.curve != UNFILTERED}


def mean_over_scenes(by_scene: dict[str, float]) -> float:
    """Geometric mean."""
    return geometric_mean(list(by_scene.values()))
