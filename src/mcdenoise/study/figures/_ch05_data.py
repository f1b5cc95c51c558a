"""What the figures of chapter 05 start from: neighbourhoods of samples, maps of shares, chance levels, small helpers."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from mcdenoise.rpf import dependency_of
from mcdenoise.rpf.dependency import information_of_levels, quantise
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.figures._ch04_data import SIZE, noisy, picture, plain, samples

BOX = 11  # pixels: side of a neighbourhood, unless a figure says otherwise
SCENES = ("dof", "motion", "soft_shadow", "pinhole")
PLACES = {"in focus": (70, 60), "out of focus": (108, 112)}  # of dof: row and column
PLACE_COLOURS = {"in focus": "#4477AA", "out of focus": "#EE6677"}
BOX_COLOURS = {"in focus": "#FFD700", "out of focus": "#00E5FF"}  # on images
POSITION, RANDOM, LIGHT, FEATURE, CHANCE = "#4477AA", "#EE6677", "#CCBB44", "#228833", "#BBBBBB"
AXES = ("x", "y", "z")


def window(y: int, x: int, side: int = BOX) -> tuple[int, int, int, int]:
    """Row, column, height and width of a box around a pixel, clipped at the borders of the image."""
    top, left = max(0, y - side // 2), max(0, x - side // 2)
    return top, left, min(SIZE, y + side // 2 + 1) - top, min(SIZE, x + side // 2 + 1) - left


@cache
def neighbourhood(scene: str, y: int, x: int, side: int = BOX, spp: int = 8) -> SampleBuffer:
    """All samples of a box around a pixel."""
    return samples(scene, spp).crop(*window(y, x, side))


def column(box: SampleBuffer, name: str, axis: int = 0) -> np.ndarray:
    """One variable of all samples of a box, (n,)."""
    values = box[name].reshape(box.height * box.width * box.spp, -1)
    return values[:, axis].astype(np.float64)


def chance(x: np.ndarray, y: np.ndarray) -> float:
    """What the estimator finds on average where there is nothing to find: (bins_x - 1) (bins_y - 1) / (2 n) nats.

    Examples
    --------
    >>> chance(np.array([0, 0, 1, 1]), np.array([0, 1, 2, 2]))
    0.25
    """
    return float((len(np.unique(x)) - 1) * (len(np.unique(y)) - 1) / (2 * len(x)))


def found_and_chance(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Mutual information of two variables, and its chance level."""
    x, y = quantise(x), quantise(y)
    return information_of_levels(x, y), chance(x, y)


@cache
def share_maps(scene: str, side: int = BOX, stride: int = 2, spp: int = 8, first: int = 0) -> dict[str, np.ndarray]:
    """Shares of the box around every pixel of a grid: c_r (h, w), c_r_each (h, w, n_r), f_r and c_f (h, w, n_f).

    Those of radiance are means over its channels. With `first` only so many of the spp samples of a pixel count.
    """
    places, buffer = range(stride // 2, SIZE, stride), samples(scene, spp).subset(0, first or spp)
    rows = [dependency_of(buffer.crop(*window(y, x, side))) for y in places for x in places]
    grid = (len(places), len(places), -1)
    return {
        "c_r": np.array([one.share_c_r.mean() for one in rows]).reshape(grid[:2]),
        "c_r_each": np.array([one.share_c_r_each.mean(axis=0) for one in rows]).reshape(grid),
        "f_r": np.array([one.share_f_r for one in rows]).reshape(grid),
        "c_f": np.array([one.share_c_f for one in rows]).reshape(grid),
    }


def feature_columns(scene: str, name: str) -> slice:
    """Where a feature stands among the columns of f_r and c_f."""
    widths = {one: samples(scene)[one].reshape(SIZE, SIZE, 8, -1).shape[-1] for one in samples(scene).feature_names}
    names = list(widths)
    start = sum(widths[one] for one in names[: names.index(name)])
    return slice(start, start + widths[name])


def share_picture(axes: Axes, values: np.ndarray, title: str = "", top: float = 1.0):
    """Show a map of shares on the one scale of all of them."""
    shown = axes.imshow(values, vmin=0, vmax=top, cmap="viridis", interpolation="nearest")
    plain(axes, title)
    return shown


def share_bar(figure: Figure, shown, axes, label: str = "share") -> None:
    """The colour bar of maps of shares."""
    there = [one for one in np.ravel(np.asarray(axes, object)) if one.figure is not None]  # others were removed
    figure.colorbar(shown, ax=there, label=label, shrink=0.7, pad=0.01)


def input_picture(axes: Axes, scene: str, title: str = "", boxes: dict | None = None) -> None:
    """The image at 8 spp, with boxes: colour -> (row, column)."""
    picture(axes, noisy(scene), title)
    for colour, (y, x) in (boxes or {}).items():
        top, left, height, width = window(y, x)
        axes.add_patch(Rectangle((left - 0.5, top - 0.5), width, height, fill=False, edgecolor=colour, linewidth=2))


def joint_counts(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Counts of a joint histogram (levels of y, levels of x), and the levels of both."""
    x, y = quantise(x), quantise(y)
    xs, ys = np.arange(x.min(), x.max() + 1), np.arange(y.min(), y.max() + 1)
    counts = np.zeros((len(ys), len(xs)), int)
    np.add.at(counts, (y - ys[0], x - xs[0]), 1)
    return counts, xs, ys


def count_picture(axes: Axes, x: np.ndarray, y: np.ndarray, labels: tuple[str, str], numbers: bool = True) -> float:
    """Draw a joint histogram with its counts; returns the mutual information."""
    counts, xs, ys = joint_counts(x, y)
    extent = (xs[0] - 0.5, xs[-1] + 0.5, ys[0] - 0.5, ys[-1] + 0.5)
    axes.imshow(counts, cmap="Blues", origin="lower", extent=extent, aspect="auto", vmin=0, interpolation="nearest")
    if numbers:
        for (i, j), count in np.ndenumerate(counts):
            colour = "white" if count > 0.6 * counts.max() else "#222222"
            axes.text(xs[j], ys[i], f"{count}", ha="center", va="center", fontsize=8, color=colour)
    axes.set(xlabel=labels[0], ylabel=labels[1], xticks=xs, yticks=ys)
    return found_and_chance(x, y)[0]
