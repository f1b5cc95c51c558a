"""Chapter 05, figures about the estimator: chance levels, the width of bins, and sums of pairs in place of the whole."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.rpf import dependency, dependency_of
from mcdenoise.rpf.dependency import information_of_levels, quantise
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.figures._ch04_data import SIZE, samples
from mcdenoise.study.figures._ch05_data import (
    CHANCE,
    PLACES,
    POSITION,
    RANDOM,
    column,
    neighbourhood,
    share_bar,
    share_maps,
    share_picture,
    window,
)

COUNTS = (32, 64, 128, 256, 512, 1024, 2048, 4096)
TRIALS = 200
LEVELS = 5
WIDTHS = (0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0)
SPPS = (2, 4, 8, 16, 32)
STRIDE = 4


def independent(count: int, trials: int = TRIALS, seed: int = 5) -> np.ndarray:
    """Mutual information of pairs of independent variables of five equally likely levels, one number a trial."""
    rng = np.random.default_rng(seed)
    draw = lambda: rng.integers(0, LEVELS, count)  # noqa: E731
    return np.array([information_of_levels(draw(), draw()) for _ in range(trials)])


def shares_of_nothing(count: int, n_r: int, trials: int = TRIALS, seed: int = 6) -> np.ndarray:
    """Shares W_{c,k}^r of radiance that depends on nothing, all variables uniform."""
    rng = np.random.default_rng(seed)
    none = np.zeros((count, 0))
    draws = (
        dependency(rng.random((count, 2)), rng.random((count, n_r)), none, rng.random((count, 3)))
        for _ in range(trials)
    )
    return np.array([found.share_c_r for found in draws])


def bias() -> tuple[Figure, dict]:
    """What the estimator finds where there is nothing, and which share follows."""
    figure = Figure(figsize=(9.4, 3.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    found = np.array([independent(count).mean() for count in COUNTS])
    formula = (LEVELS - 1) ** 2 / (2 * np.array(COUNTS))
    left.loglog(COUNTS, formula, "--", color="#555555", label="(5 - 1)(5 - 1) / 2N")
    left.loglog(COUNTS, found, "o", color=RANDOM, label=f"measured, mean of {TRIALS}")
    left.set(xlabel="N, samples", ylabel="µ of independent variables (nats)")
    numbers = {"ratio": found / formula, "counts": COUNTS, "found": found}
    for n_r, colour, marker in ((2, POSITION, "o"), (3, RANDOM, "s"), (4, "#228833", "^")):
        shares = [shares_of_nothing(count, n_r, 40).mean() for count in COUNTS]
        right.semilogx(COUNTS, shares, marker, color=colour, label=f"n_r = {n_r}")
        right.axhline(n_r / (n_r + 2), color=colour, linestyle="--", linewidth=1)
        numbers[f"share_{n_r}"] = float(np.mean(shares))
    right.set(xlabel="N, samples", ylabel="W of radiance that depends on nothing", ylim=(0, 1))
    right.set_title("dashed: n_r / (n_r + 2)", fontsize=10)
    for axes in (left, right):
        axes.legend(frameon=False)
        axes.grid(color="#e5e5e5")
    return figure, numbers


def information_at_width(x: np.ndarray, y: np.ndarray, width: float) -> float:
    """Mutual information with bins `width` standard deviations wide."""
    cut = [np.rint((one - one.mean()) / one.std() / width).astype(int) for one in (x, y)]
    return information_of_levels(*cut)


def widths() -> tuple[Figure, dict]:
    """What is found and what chance alone would find, over the width of the bins."""
    box = neighbourhood("dof", *PLACES["out of focus"])
    pairs = {
        "lens_u, world x": (column(box, "lens_u"), column(box, "world_position")),
        "light_v, red": (column(box, "light_v"), column(box, "radiance")),
    }
    figure, numbers = Figure(figsize=(9.4, 3.7), layout="constrained"), {"widths": WIDTHS}
    rng = np.random.default_rng(0)
    for axes, (name, (x, y)) in zip(figure.subplots(1, 2), pairs.items(), strict=True):
        found = np.array([information_at_width(x, y, width) for width in WIDTHS])
        orders = [rng.permutation(len(y)) for _ in range(20)]
        none = np.array([[information_at_width(x, y[order], width) for order in orders] for width in WIDTHS])
        axes.semilogx(WIDTHS, found, "o-", color=RANDOM, label="found")
        axes.semilogx(WIDTHS, none.mean(axis=1), "s-", color="#888888", label="the same, y shuffled")
        axes.axvline(1, color="#222222", linestyle=":")
        axes.set(xlabel="width of the bins (standard deviations)", ylabel="µ (nats)", ylim=(0, None))
        axes.set_xticks(WIDTHS, [f"{width:g}" for width in WIDTHS], minor=False)
        axes.minorticks_off()
        axes.set_title(f"out of focus: {name}", fontsize=10)
        axes.legend(edgecolor="none", framealpha=1)
        signal = (found - none.mean(axis=1)) / none.std(axis=1)
        numbers[name.replace(", ", "_").replace(" ", "_")] = {
            "found": found,
            "chance": none.mean(axis=1),
            "deviations": signal,
            "best": WIDTHS[int(signal.argmax())],
        }
    return figure, numbers


def together(*levels: np.ndarray) -> np.ndarray:
    """One variable that stands for several: each combination of levels is one value.

    Examples
    --------
    >>> together(np.array([0, 0, 1]), np.array([5, 7, 5])).tolist()
    [0, 1, 2]
    """
    return np.unique(np.stack(levels, axis=1), axis=0, return_inverse=True)[1].ravel()


def pairs_and_joint(causes: list[np.ndarray], y: np.ndarray) -> tuple[float, float]:
    """The sum of the information of each cause with y, and the information of all of them together with y, in nats.

    Examples
    --------
    >>> a, b = np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1])
    >>> pairs, whole = pairs_and_joint([a, b], a ^ b)
    >>> pairs, float(round(whole / np.log(2), 6))
    (0.0, 1.0)
    """
    return sum(information_of_levels(x, y) for x in causes), information_of_levels(together(*causes), y)


def cases() -> dict[str, tuple[list[np.ndarray], np.ndarray]]:
    """Causes and effect: two of coins, two of rendered samples."""
    box = neighbourhood("dof", *PLACES["out of focus"])
    of = {name: quantise(column(box, name)) for name in box.random_param_names}
    a, b = np.tile([0, 0, 1, 1], 242), np.tile([0, 1, 0, 1], 242)
    return {
        "y = a xor b": ([a, b], a ^ b),
        "y = a = b": ([a, a], a),
        "world x\nof lens_u, lens_v": ([of["lens_u"], of["lens_v"]], quantise(column(box, "world_position"))),
        "red of\nlens and light": (list(of.values()), quantise(column(box, "radiance"))),
    }


def pairs() -> tuple[Figure, dict]:
    """Sums of pairs against the information of all causes together, found and by chance."""
    figure, numbers, rng = Figure(figsize=(9.4, 3.9), layout="constrained"), {}, np.random.default_rng(0)
    axes, given = figure.subplots(), cases()
    for place, (causes, y) in enumerate(given.values()):
        found = pairs_and_joint(causes, y)
        none = np.mean([pairs_and_joint(causes, rng.permutation(y)) for _ in range(10)], axis=0)
        for kind, (value, by_chance) in enumerate(zip(found, none, strict=True)):
            at = place + 0.4 * kind - 0.2
            _bar(axes, at, value, by_chance, (POSITION, RANDOM)[kind])
        key = ("xor", "copy", "world_x", "red")[place]
        numbers[key] = {"pairs": found[0], "joint": found[1], "pairs_chance": none[0], "joint_chance": none[1]}
    for colour, label in (
        (POSITION, "sum of pairs"),
        (RANDOM, "all causes together"),
        ("#00000055", "of that by chance (y shuffled)"),
    ):
        axes.bar(0, 0, color=colour, label=label)
    axes.set_xticks(range(len(given)), given)
    axes.set(ylabel="nats")
    axes.margins(y=0.12)
    axes.legend(frameon=False)
    return figure, numbers


def _bar(axes: Axes, at: float, value: float, by_chance: float, colour: str) -> None:
    """One bar, its value above, and its chance level as a darker foot."""
    bar = axes.bar(at, value, 0.36, color=colour)
    axes.bar_label(bar, fmt="%.2f", fontsize=9)
    axes.bar(at, by_chance, 0.36, color="#00000055")


def without_chance(box: SampleBuffer) -> float:
    """W_c^r, mean over channels, with the chance level taken off each pair (never below 0)."""
    count = box.height * box.width * box.spp
    p, r, c = (quantise(block.reshape(count, -1)) for block in (box.screen_position, box.random_params, box.radiance))
    found = dependency_of(box)
    levels = lambda values: np.array([len(np.unique(one)) for one in values.T])  # noqa: E731
    off = lambda x, y: np.outer(levels(x) - 1, levels(y) - 1) / (2 * count)  # noqa: E731
    of_r = np.maximum(found.c_r - off(c, r), 0).sum(axis=1)
    whole = of_r + np.maximum(found.c_p - off(c, p), 0).sum(axis=1)
    return float(np.mean(np.divide(of_r, whole, out=np.zeros(3), where=whole > 0)))


def spp() -> tuple[Figure, dict]:
    """The same maps from 2, 8 and 32 samples a pixel, and the means over the image from 2 to 32."""
    figure, numbers = Figure(figsize=(9.8, 3.3), layout="constrained"), {"spp": SPPS}
    grid = figure.subplots(1, 4, width_ratios=(1, 1, 1, 1.4))
    maps = {count: share_maps("dof", spp=32, stride=STRIDE, first=count)["c_r"] for count in SPPS}
    for axes, count in zip(grid, (2, 8, 32), strict=False):
        shown = share_picture(axes, maps[count], f"W$_c^r$ from {count} spp")
    share_bar(figure, shown, list(grid[:3]))
    places = range(STRIDE // 2, SIZE, STRIDE)
    corrected = [
        np.mean([without_chance(samples("dof", 32).crop(*window(y, x)).subset(0, n)) for y in places for x in places])
        for n in SPPS
    ]
    plain = [maps[count].mean() for count in SPPS]
    for values, colour, marker, label in (
        (plain, RANDOM, "o-", "as it is"),
        (corrected, POSITION, "s-", "chance taken off"),
    ):
        grid[3].semilogx(SPPS, values, marker, color=colour, label=label)
    grid[3].axhline(4 / 6, color=CHANCE, linestyle="--", label="nothing to find")
    grid[3].set_xticks(SPPS, SPPS)
    grid[3].minorticks_off()
    grid[3].set(xlabel="spp", ylim=(0.2, 0.8))
    grid[3].set_title("mean of W$_c^r$ over dof", fontsize=10)
    grid[3].legend(frameon=False, fontsize=8.5)
    return figure, numbers | {"plain": plain, "corrected": corrected}
