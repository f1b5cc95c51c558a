"""What the figures of chapter 07 share: trained networks at fixed seeds, pixels with an answer, diagrams, small helpers."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes

from mcdenoise.filters import gaussian
from mcdenoise.metrics import relmse_map
from mcdenoise.nn import MLP, Adam, CrossEntropy, Linear, Training, checker, rings, train, two_moons, xor
from mcdenoise.samples import variance_of_mean
from mcdenoise.study.charts import COLOURS
from mcdenoise.study.figures._ch04_data import noisy, reference, samples
from mcdenoise.study.neurons import CLASS_COLOURS, decision_of

ZERO, ONE = CLASS_COLOURS
THIRD, FOURTH, GREY = COLOURS[2], COLOURS[3], "#777777"
SCENE, NARROW, WIDE = "soft_shadow", 0.7, 1.5  # sigma_space of the two answers, pixels


def clouds(n: int, *, rng: np.random.Generator, noise: float = 0.2) -> tuple[np.ndarray, np.ndarray]:
    """Four clouds around (-1, -1), (-1, 1), (1, -1) and (1, 1); class 1 where the signs differ.

    Examples
    --------
    >>> x, labels = clouds(50, rng=np.random.default_rng(0))
    >>> bool(np.all(labels == (x[:, 0] * x[:, 1] < 0)))
    True
    """
    centres = rng.choice((-1.0, 1.0), (n, 2))
    return centres + noise * rng.standard_normal((n, 2)), (centres[:, 0] != centres[:, 1]).astype(int)


SETS = {"moons": two_moons, "rings": rings, "xor": xor, "checker": checker, "clouds": clouds}


@cache
def points(name: str, n: int = 240, seed: int = 0, **options) -> tuple[np.ndarray, np.ndarray]:
    """Points of one of the data sets and their classes."""
    return SETS[name](n, rng=np.random.default_rng(seed), **options)


@cache
def trained(
    name: str,
    hidden: tuple[int, ...],
    *,
    n: int = 240,
    epochs: int = 600,
    rate: float = 0.05,
    seed: int = 1,
    data_seed: int = 0,
    **options,
) -> Training:
    """A network of sigmoids with these hidden layers, trained on one of the data sets as chapter 08 will explain."""
    x, labels = points(name, n, data_seed, **options)
    start = MLP.random([2, *hidden, 1], rng=np.random.default_rng(seed), gain=3.0)
    return train(start, x, labels[:, np.newaxis], loss=CrossEntropy(), optimizer=Adam(rate), epochs=epochs)


def wrong(classify, x: np.ndarray, labels: np.ndarray) -> float:
    """Share of points that a classifier gets wrong.

    Examples
    --------
    >>> wrong(lambda x: x[:, 0] > 0, np.array([[1.0, 0.0], [2.0, 0.0]]), np.array([1, 0]))
    0.5
    """
    return float(np.mean((decision_of(classify)(x) >= 0) != labels))


@cache
def pixels() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two features of each pixel of a scene, (h w, 2), standardised; the better of two filters, (h w,); errors (h w, 2).

    The features: logarithms of the relative variance of the pixel's mean, and of the relative slope of the blurred
    image. Neither looks at the reference. The answer is 1 where the wide Gaussian errs less than the narrow one, both
    errors averaged over a few pixels.
    """
    buffer, image, truth = samples(SCENE), noisy(SCENE), reference(SCENE)
    errors = [relmse_map(gaussian(image, sigma_space=s), truth).mean(axis=-1) for s in (NARROW, WIDE)]
    smooth = [gaussian(one, sigma_space=1.0) for one in errors]
    relative = variance_of_mean(buffer.radiance).mean(axis=-1) / (np.square(image).mean(axis=-1) + 0.01)
    blurred = gaussian(image.mean(axis=-1), sigma_space=1.5)
    slope = np.hypot(*np.gradient(blurred)) / (blurred + 0.1)
    features = [
        np.log10(gaussian(one, sigma_space=sigma) + least)
        for one, sigma, least in ((relative, 2.0, 1e-6), (slope, 1.0, 1e-3))
    ]
    x = np.stack([one.ravel() for one in features], axis=1).astype(np.float64)
    labels = (smooth[1] < smooth[0]).astype(int).ravel()
    return (x - x.mean(axis=0)) / x.std(axis=0), labels, np.stack([one.ravel() for one in errors], axis=1)


def draw_network(axes: Axes, network: MLP, names: list[list[str]]) -> None:
    """Draw a network as circles and lines: names of the numbers by layer, weights on the lines, biases from a 1.

    Red lines have weights above 0, blue ones below.
    """
    layers = [layer for layer in network.layers if isinstance(layer, Linear)]
    for number, layer in enumerate(layers):
        columns = (1.0 * number, 1.0 * number + 1)
        ends = _heights(len(names[number + 1]))
        for s, end in enumerate(ends):
            starts = [*_heights(len(names[number])), -1.45]
            for t, start in enumerate(starts):
                value = layer.bias[s] if t == len(starts) - 1 else layer.weight[s, t]
                if value:
                    _draw_weight(axes, (columns[0], start), (columns[1], end), value)
        axes.text(columns[0], -1.45, "1", **_circle("#EEEEEE"))
    for number, row in enumerate(names):
        for height, name in zip(_heights(len(row)), row, strict=True):
            axes.text(number, height, name, **_circle("white"))
    axes.set(xlim=(-0.2, len(layers) + 0.2), ylim=(-1.7, 1.2))
    axes.axis("off")


def _draw_weight(axes: Axes, start: tuple, end: tuple, value: float, along: float = 0.28) -> None:
    """One line with its number."""
    colour = ONE if value > 0 else ZERO
    axes.plot(*zip(start, end, strict=True), color=colour, linewidth=1.4, zorder=1)
    place = np.add(np.multiply(start, 1 - along), np.multiply(end, along))
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
    axes.text(*place, f"{value:g}", color=colour, fontsize=9.5, ha="center", va="center", bbox=box, zorder=2)


def _heights(count: int) -> np.ndarray:
    """Where the circles of a layer stand.

    Examples
    --------
    >>> _heights(1), _heights(3)
    (array([0.]), array([ 0.9,  0. , -0.9]))
    """
    return np.array([0.0]) if count == 1 else np.linspace(0.9, -0.9, count) if count > 2 else np.array([0.8, -0.5])


def _circle(face: str) -> dict:
    """How a number of a network is drawn."""
    box = {"boxstyle": "circle,pad=0.35", "facecolor": face, "edgecolor": "#222222"}
    return {"bbox": box, "ha": "center", "va": "center", "fontsize": 11, "zorder": 3}
