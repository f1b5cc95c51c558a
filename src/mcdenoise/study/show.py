"""Pictures in a notebook: images side by side under one tone map, and an image beside the one it should be."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Mapping

import numpy as np
import PIL.Image
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from mcdenoise.samples.gate import check_float_array, check_image, check_same_size
from mcdenoise.study.display import tone_map

NOT_FINITE = (0.9, 0.0, 0.9)  # magenta: no tone-mapped radiance of ours looks like it
DIFFERENCE_COLOURS = "RdBu_r"  # blue too low, red too high: told apart with any colour vision
SAME = 1e-7  # of the target's largest value: what rounding makes is no difference


class Picture(Figure):
    """A matplotlib Figure that a notebook shows whether or not `matplotlib.pyplot` was imported."""

    def _repr_png_(self) -> bytes:
        FigureCanvasAgg(self)
        stream = io.BytesIO()
        self.savefig(stream, format="png")
        return stream.getvalue()


def show_images(images: Mapping[str, object], *, title: str = "", columns: int = 4) -> Figure:
    """Show images side by side, all under the same tone map (clip to [0, 1], then the sRGB curve).

    Parameters
    ----------
    images : title of each image -> image (h, w), (h, w, 1) or (h, w, 3), scene-linear radiance; 1 is white. Sizes may
        differ.
    title : a line above all of them.
    columns : how many stand in one row, >= 1.

    Returns
    -------
    matplotlib Figure; as the last line of a notebook cell it is shown.

    Raises
    ------
    ValueError
        If there is no image, one is no finite image with 1 or 3 channels, or `columns` is below 1.

    Examples
    --------
    >>> import mcdenoise as mcd
    >>> figure = mcd.show_images({"black": np.zeros((4, 4)), "white": np.ones((4, 4, 3))})
    >>> [axes.get_title() for axes in figure.axes]
    ['black', 'white']
    """
    if not isinstance(images, Mapping) or not images:
        raise ValueError(
            f"show_images needs a dict of title -> image with at least one image, got {type(images).__name__}. "
            'Write mcd.show_images({"noisy": image}).'
        )
    if not isinstance(columns, int) or columns < 1:
        raise ValueError(f"columns must be a whole number of at least 1, got {columns!r}.")
    shown = {name: displayed(image, f"image {name!r}") for name, image in images.items()}
    columns = min(columns, len(shown))
    rows = -(-len(shown) // columns)
    tallest = max(_aspect(image) for image in shown.values())
    figure = Picture(figsize=(max(3.2 * columns, 4.0), (3.2 * tallest + 0.35) * rows + 0.3), layout="constrained")
    if title:
        figure.suptitle(textwrap.fill(title, 32 * columns))
    grid = figure.subplots(rows, columns, squeeze=False).flat
    for axes, (name, image) in zip(grid, shown.items(), strict=False):
        _draw(axes, image, name)
    for axes in grid[len(shown) :]:
        axes.remove()
    return figure


def show_difference(yours: object, target: object, *, title: str = "") -> Figure:
    """Show an image, the image it should be, and their difference (mean over channels) on a scale of its own.

    Parameters
    ----------
    yours, target : images of one shape, (h, w), (h, w, 1) or (h, w, 3), scene-linear radiance. `yours` may hold NaN or
        infinity: such pixels are magenta.
    title : a line above.

    Returns
    -------
    matplotlib Figure; as the last line of a notebook cell it is shown.

    Raises
    ------
    ValueError
        If the shapes differ or either is no image.

    Examples
    --------
    >>> import mcdenoise as mcd
    >>> figure = mcd.show_difference(np.zeros((4, 4)), np.ones((4, 4)))
    >>> [axes.get_title() for axes in figure.axes[:3]]
    ['yours', 'target', 'yours - target']
    """
    target = check_image(target, "target")
    yours = check_float_array(yours, "yours")
    check_same_size(yours, "yours", target, "target")
    if yours.shape != target.shape:
        raise ValueError(f"yours must have the shape of target, {target.shape}, got {yours.shape}.")
    finite = np.isfinite(yours).reshape(*yours.shape[:2], -1).all(axis=-1)
    display = displayed(np.nan_to_num(yours, nan=0, posinf=0, neginf=0), "yours")
    display[~finite] = NOT_FINITE
    difference = (yours.astype(float) - target).reshape(*yours.shape[:2], -1).mean(axis=-1)
    figure = Picture(figsize=(10.2, 3.0 * _aspect(display) + 0.8), layout="constrained")
    if title:
        figure.suptitle(textwrap.fill(title, 100))
    left, middle, right = figure.subplots(1, 3)
    broken = "" if finite.all() else f"\n{int((~finite).sum())} pixels not finite (magenta)"
    _draw(left, display, f"yours{broken}")
    _draw(middle, displayed(target, "target"), "target")
    largest = float(np.abs(difference[finite]).max(initial=0.0))
    same = largest <= SAME * max(float(np.abs(target).max()), SAME)
    right.set_facecolor(NOT_FINITE)
    scale = right.imshow(
        np.ma.array(difference, mask=~finite),
        cmap=DIFFERENCE_COLOURS,
        norm=Normalize(*((-1, 1) if same else (-largest, largest))),
        interpolation="nearest",
    )
    right.set(xticks=[], yticks=[])
    right.set_title("yours - target" + (": no difference" if same else ""), fontsize=10)
    beside = right.inset_axes((1.04, 0, 0.06, 1))  # as high as the image, whatever its shape
    figure.colorbar(scale, cax=beside).set_label("radiance\nblue: too low, red: too high", fontsize=8)
    return figure


def displayed(image: object, name: str) -> np.ndarray:
    """Return an image as display values (h, w, 3), float32 in [0, 1], by the one tone map.

    Raises
    ------
    ValueError
        If it is no finite image with 1 or 3 channels.

    Examples
    --------
    >>> displayed([[0.0, 1.0]], "image").shape
    (1, 2, 3)
    """
    array = check_image(image, name)
    array = array[..., np.newaxis] if array.ndim == 2 else array
    if array.shape[-1] not in (1, 3):
        raise ValueError(
            f"{name} must have 1 or 3 channels to be shown, got shape {array.shape}. Show channels one by one: "
            f"image[..., 0]."
        )
    return np.repeat(tone_map(array), 3 // array.shape[-1], axis=-1)


def _aspect(display: np.ndarray) -> float:
    """Return height / width of an image, within what makes a readable figure."""
    return float(np.clip(display.shape[0] / display.shape[1], 0.4, 2.0))


def indexed_png(figure: Figure, dots: int) -> bytes:
    """Return a figure as a PNG of at most 256 colours, about a third of the bytes, at `dots` per inch."""
    FigureCanvasAgg(figure)
    drawn, indexed = io.BytesIO(), io.BytesIO()
    figure.savefig(drawn, format="png", dpi=dots)
    with PIL.Image.open(drawn) as image:
        # Median cut, the default, leaves small bright things grey.
        fewer = {"method": PIL.Image.Quantize.MAXCOVERAGE, "kmeans": 2, "dither": PIL.Image.Dither.NONE}
        image.convert("RGB").quantize(256, **fewer).save(indexed, format="png", optimize=True)
    return indexed.getvalue()


def _draw(axes: Axes, display: np.ndarray, title: str) -> None:
    """Put display values into axes without ticks, under a title that wraps."""
    axes.imshow(display, interpolation="nearest")
    axes.set(xticks=[], yticks=[])
    axes.set_title("\n".join(textwrap.fill(line, 38) for line in title.splitlines()), fontsize=10)
