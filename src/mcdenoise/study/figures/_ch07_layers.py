"""Chapter 07, figures about networks made by hand: regions of m lines, polygons, a checkerboard."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.nn import MLP, all_of, any_of, half_planes
from mcdenoise.study.figures._ch07_data import GREY, ONE, ZERO, points, wrong
from mcdenoise.study.neurons import FINE, Window, draw_boundary, show_decision, show_neurons

LINES = (2, 4, 8)
MOST_LINES = 12
SIDES = (3, 4, 6)
RADIUS = 0.72  # of the circle inside the polygons: between the two rings
CUTS = (-0.5, 0.0, 0.5)  # of a checkerboard of 4 x 4


def random_lines(m: int, seed: int = 4) -> np.ndarray:
    """m lines (a, b, c) in general position: no two parallel, no three through one point."""
    rng = np.random.default_rng(seed)
    angle = np.pi * (np.arange(m) + rng.uniform(0.1, 0.9, m)) / m
    return np.stack([np.cos(angle), np.sin(angle), rng.uniform(-0.35, 0.35, m)], axis=1)


def count_regions(lines: np.ndarray) -> int:
    """In how many regions m >= 2 lines in general position cut the plane: patterns of a first layer, counted.

    Each region has a corner where two lines cross; so the four wedges at all crossings meet every region.

    Examples
    --------
    >>> count_regions(np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    4
    """
    places = []
    for one, other in combinations(lines, 2):
        both = np.array([one[:2], other[:2]])
        crossing = np.linalg.solve(both, -np.array([one[2], other[2]]))
        aside = np.linalg.solve(both, 1e-6 * np.array([[1, 1, -1, -1], [1, -1, 1, -1]]))
        places.append(crossing + aside.T)
    patterns = MLP(half_planes(lines)).forward(np.concatenate(places))[0]
    return len(np.unique(patterns, axis=0))


def regions() -> tuple[Figure, dict]:
    """Regions of 2, 4 and 8 lines, a grey for each; the count against m, and against all patterns of 0 and 1."""
    figure = Figure(figsize=(9.8, 2.9), layout="constrained")
    *planes, curve = figure.subplots(1, 4, width_ratios=(1, 1, 1, 1.3))
    window, rng = Window(-2, 2, -2, 2), np.random.default_rng(0)
    for axes, m in zip(planes, LINES, strict=True):
        lines = random_lines(m)
        patterns = MLP(half_planes(lines)).forward(window.grid(FINE))[0]
        _, number = np.unique(patterns, axis=0, return_inverse=True)
        axes.imshow(
            rng.permutation(number.max() + 1)[number.ravel()].reshape(FINE, FINE), cmap="viridis", alpha=0.55,
            origin="lower", extent=window.extent, interpolation="nearest",
        )  # fmt: skip
        for line in lines:
            draw_boundary(axes, (window.grid(FINE) @ line[:2] + line[2]).reshape(FINE, FINE), window)
        axes.set(xticks=[], yticks=[])
        axes.set_title(f"{m} lines: {count_regions(lines)} regions", fontsize=10)
    m = np.arange(2, MOST_LINES + 1)
    counted = np.array([count_regions(random_lines(k)) for k in m])
    curve.semilogy(m, 2.0**m, "--", color=GREY, label="patterns: $2^m$")
    curve.semilogy(m, 1 + m + m * (m - 1) // 2, color=ZERO, label="1 + m + m(m - 1)/2")
    curve.semilogy(m, counted, "o", color=ONE, label="counted")
    curve.set(xlabel="m, perceptrons", ylabel="regions")
    curve.legend(frameon=False, fontsize=8.5)
    return figure, {"m": m, "counted": counted, "formula": 1 + m + m * (m - 1) // 2, "patterns": 2**m}


def polygon(sides: int) -> MLP:
    """1 inside a regular polygon: half planes, then all of them."""
    angle = 2 * np.pi * (np.arange(sides) + 0.25) / sides
    lines = np.stack([-np.cos(angle), -np.sin(angle), np.full(sides, RADIUS)], axis=1)
    return MLP((*half_planes(lines), *all_of([range(sides)], sides)))


def polygons() -> tuple[Figure, dict]:
    """Rings: inside all of 3, 4 and 6 half planes."""
    x, labels = points("rings", 300)
    figure = Figure(figsize=(9.4, 3.3), layout="constrained")
    rates = [wrong(polygon(sides), x, labels) for sides in SIDES]
    for axes, sides, rate in zip(figure.subplots(1, 3), SIDES, rates, strict=True):
        show_decision(polygon(sides), x, labels, title=f"{sides} half planes: {100 * rate:.1f} % wrong", axes=axes)
    return figure, {"sides": SIDES, "wrong": rates, "weights": [polygon(sides).size for sides in SIDES]}


def board() -> MLP:
    """A checkerboard of 4 x 4 by hand: six lines, eight cells, their union."""
    lines = [[1, 0, -cut] for cut in CUTS] + [[0, 1, -cut] for cut in CUTS]
    cells = [[*_between(i, 0), *_between(j, len(CUTS))] for j in range(4) for i in range(4) if (i + j) % 2]
    return MLP((*half_planes(lines), *all_of(cells, len(lines)), *any_of([range(len(cells))], len(cells))))


def _between(k: int, first: int) -> list[int]:
    """Which lines say that a coordinate is in the k-th of four intervals: above the one below, not above the next.

    Examples
    --------
    >>> _between(0, 0), _between(1, 3)
    ([-1], [3, -5])
    """
    return ([first + k - 1] if k else []) + ([~(first + k)] if k < len(CUTS) else [])


def checker_by_hand() -> tuple[Figure, dict]:
    """What each perceptron of the checkerboard's network gives: lines, cells, and their union."""
    x, labels = points("checker", 400)
    network, few = board(), slice(0, 150)
    return show_neurons(network, x[few], labels[few]), {
        "wrong": wrong(network, x, labels),
        "weights": network.size,
        "neurons": [layer.bias.size for layer in network.layers[::2]],
    }
