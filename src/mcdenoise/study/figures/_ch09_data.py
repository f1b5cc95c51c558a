"""What the figures of chapter 09 start from: features, filtered images, the oracle, one pixel's neighbours, colour scales."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from mcdenoise.lbf import FilterLayer, LBFAnalysis, LBFModel, Primary, lbf_analysis, primary_features, shipped_model
from mcdenoise.lbf.distances import offset_distances
from mcdenoise.lbf.oracle import Oracle, oracle
from mcdenoise.lbf.primary import GROUPS
from mcdenoise.study.figures._ch04_data import error, plain, samples
from mcdenoise.study.figures._references import reference

SCENES = ("dof", "motion", "soft_shadow", "glossy", "pinhole")
SPP, SPPS = 4, (4, 8)
VARIANTS = {"cross_bilateral": "LBF, cross-bilateral", "nlm": "LBF, NLM"}
WORDS = {"position": "position", "colour": "colour"}
WORDS |= dict(zip(GROUPS, ("world", "normal", "texture", "texture 2", "visibility"), strict=True))
STEPS = 15  # of the oracle: more gain little, see its errors
ROWS = range(1, 128, 8)  # every eighth row, where the oracle of a whole image would take too long
PLACES = {"texture in focus": (73, 63), "disc of a lamp": (13, 60), "out of focus": (108, 112)}  # of dof: row, column
PLACE_COLOURS = dict(zip(PLACES, ("#4477AA", "#CCBB44", "#EE6677"), strict=True))
BLUE, RED, GREEN, PURPLE, GREY = "#4477AA", "#EE6677", "#228833", "#AA3377", "#BBBBBB"
LOWEST, HIGHEST = 0.3, 30.0  # bandwidths that colours tell apart


@cache
def primary(scene: str, spp: int = SPP, seed: int = 0) -> Primary:
    """Primary features of a scene."""
    return primary_features(samples(scene, spp, seed))


def noisy(scene: str, spp: int = SPP) -> np.ndarray:
    """The unfiltered image."""
    return primary(scene, spp).colour


@cache
def analysis(scene: str, variant: str = "cross_bilateral", spp: int = SPP, seed: int = 0) -> LBFAnalysis:
    """What the shipped model makes of a scene: the image and the maps of theta."""
    return lbf_analysis(samples(scene, spp, seed), variant=variant)


def filtered(scene: str, variant: str = "cross_bilateral", spp: int = SPP) -> np.ndarray:
    """The image after the shipped model."""
    return analysis(scene, variant, spp).image


def error_of(scene: str, variant: str = "cross_bilateral", spp: int = SPP) -> float:
    """RelMSE after the shipped model."""
    return error(filtered(scene, variant, spp), scene)


def layer_of(scene: str, spp: int = SPP, seed: int = 0, **settings: object) -> FilterLayer:
    """The filter of the shipped cross-bilateral model."""
    return shipped_model().layer(primary(scene, spp, seed), **settings)


@cache
def best_theta(scene: str, spp: int = SPP, whole: bool = False, variant: str = "cross_bilateral") -> Oracle:
    """The oracle of the shipped model's filter: of every eighth row, or of the whole image. It looks at the reference."""
    model = shipped_model(variant)
    layer = model.layer(primary(scene, spp), rows=None if whole else ROWS)
    return oracle(layer, reference(scene), colour_theta=model.colour_theta, steps=STEPS)


def error_in_rows(image: np.ndarray, scene: str) -> float:
    """RelMSE on every eighth row; `image` is whole, or these rows alone."""
    rows = image[list(ROWS)] if len(image) == len(reference(scene)) else image
    truth = reference(scene)[list(ROWS)].astype(np.float64)
    return float(np.mean((rows - truth) ** 2 / (truth**2 + 0.01)))


def way(start: float, here: float, end: float) -> float:
    """Share of the way from `start` to `end`, in logarithms of relMSE, in percent.

    Examples
    --------
    >>> round(way(0.1, 0.01, 0.001))
    50
    """
    return float(100 * np.log(start / here) / np.log(start / end))


def neighbours(layer: FilterLayer, y: int, x: int) -> tuple[np.ndarray, np.ndarray, tuple[slice, slice]]:
    """What the filter compares at one pixel, in its window, clipped at borders.

    Returns
    -------
    distances : (m, h, w). colours : (h, w, 3), of which the filtered colour is the weighted mean; with a model that divides
    by albedo these have that of the pixel itself. window : rows and columns.
    """
    height, width = layer.primary.colour.shape[:2]
    window = tuple(
        np.s_[max(at - layer.radius, 0) : min(at + layer.radius + 1, size)] for at, size in ((y, height), (x, width))
    )
    found = offset_distances(layer, 0, 0, np.s_[y : y + 1, x : x + 1], window)
    rows, columns = (np.arange(part.start, part.stop) for part in window)
    found[..., 0] = (rows[:, np.newaxis] - y) ** 2 + (columns - x) ** 2
    own = 1.0 if layer.albedo is None else layer.albedo[y, x].astype(np.float64)
    return np.moveaxis(found, -1, 0), layer.primary.colour[window].astype(np.float64) * own, window


def effective(weights: np.ndarray) -> float:
    """How many pixels of equal weight would average noise as well: (sum w)^2 / sum w^2.

    Examples
    --------
    >>> effective(np.array([1.0, 1.0, 0.0]))
    2.0
    """
    return float(weights.sum() ** 2 / (weights**2).sum())


def sigma(theta: np.ndarray) -> np.ndarray:
    """Bandwidth of an inverse bandwidth: 1 / sqrt(2 theta); infinity for 0."""
    with np.errstate(divide="ignore"):
        return 1 / np.sqrt(2 * np.asarray(theta, np.float64))


def bandwidth_scale() -> ScalarMappable:
    """The one colour scale of bandwidth maps: logarithmic, dark is narrow."""
    return ScalarMappable(LogNorm(LOWEST, HIGHEST), "viridis")


def bandwidth_picture(axes: Axes, values: np.ndarray, title: str = "") -> None:
    """Show a map of bandwidths on the scale of all."""
    axes.imshow(bandwidth_scale().to_rgba(np.clip(values, LOWEST, HIGHEST)), interpolation="nearest")
    plain(axes, title)


def bandwidth_bar(figure: Figure, axes: object, label: str = "", **settings: object) -> None:
    """The colour bar of bandwidth maps."""
    bar = figure.colorbar(bandwidth_scale(), ax=axes, extend="both", **settings)
    bar.set_label(label or "bandwidth: α in pixels, β and γ in deviations", fontsize=8.5)
    bar.set_ticks([0.3, 1, 3, 10, 30], labels=["0.3", "1", "3", "10", "30"])


def symbol(name: str) -> str:
    """How a bandwidth is called in the lecture.

    Examples
    --------
    >>> symbol("position"), symbol("albedo")
    ('α', 'γ texture')
    """
    return {"position": "α", "colour": "β"}.get(name, f"γ {WORDS[name]}")


def widths_of(model: LBFModel) -> list[int]:
    """Inputs, hidden widths and outputs of a model's network."""
    weights = [one for name, one in model.network.parameters.items() if name.startswith("weight")]
    return [weights[0].shape[1], *(one.shape[0] for one in weights)]


def geometric_mean(values: object) -> float:
    """Exponential of the mean of logarithms."""
    return float(np.exp(np.mean(np.log(np.asarray(values)))))
