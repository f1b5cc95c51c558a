"""Chapter 05, figures about mutual information itself: bins, an example by hand, correlation, joint histograms."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.rpf.dependency import information_of_levels, quantise
from mcdenoise.study.figures._ch05_data import (
    FEATURE,
    PLACES,
    POSITION,
    RANDOM,
    column,
    count_picture,
    found_and_chance,
    neighbourhood,
)

EXAMPLE = (np.array([0, 0, 0, 0, 1, 1, 1, 1]), np.array([0, 0, 0, 1, 1, 1, 1, 0]))
DRAWN = 1000


def bins() -> tuple[Figure, dict]:
    """Three variables of one neighbourhood, cut into bins of one standard deviation."""
    box = neighbourhood("dof", *PLACES["in focus"])
    shown = {
        "lens_u": (column(box, "lens_u"), RANDOM, "lens_u"),
        "radiance": (column(box, "radiance"), POSITION, "radiance, red"),
        "albedo": (column(box, "albedo"), FEATURE, "albedo, red"),
    }
    figure, numbers = Figure(figsize=(9.4, 3.1), layout="constrained"), {"samples": len(column(box, "lens_u"))}
    for axes, (name, (values, colour, label)) in zip(figure.subplots(1, 3), shown.items(), strict=True):
        levels = quantise(values)
        centre, deviation = values.mean(), values.std()
        axes.hist(values, 60, color=colour, alpha=0.5)
        low, high = axes.get_ylim()[0], 1.3 * axes.get_ylim()[1]
        for level in range(levels.min(), levels.max() + 2):
            axes.axvline(centre + (level - 0.5) * deviation, color="#222222", linewidth=0.9, linestyle=":")
        for level, count in zip(*np.unique(levels, return_counts=True), strict=True):
            axes.text(centre + level * deviation, 0.88 * high, f"{level}\n{count}", ha="center", fontsize=9)
        axes.set(xlabel=label, ylim=(low, high))
        numbers[name] = {"bins": len(np.unique(levels)), "deviation": deviation}
    figure.axes[0].set_ylabel("samples")
    figure.suptitle("Above each bin: its level and the number of its samples", fontsize=10)
    return figure, numbers


def worked() -> tuple[Figure, dict]:
    """Eight samples of two coins: the counts, and each term of the sum."""
    x, y = EXAMPLE
    counts = np.zeros((2, 2))
    np.add.at(counts, (y, x), 1)
    joint = counts / len(x)
    alone = np.outer(joint.sum(axis=1), joint.sum(axis=0))
    terms = joint * np.log(joint / alone)
    figure = Figure(figsize=(9.4, 2.5), layout="constrained")
    tables = {
        "counts of (x, y)": (counts, "{:.0f} of 8"),
        "p(x) p(y)": (alone, "{:.3f}"),
        "p(x, y)": (joint, "{:.3f}"),
        "terms of the sum": (terms, "{:+.4f}"),
    }
    for axes, (title, (values, text)) in zip(figure.subplots(1, 4), tables.items(), strict=True):
        ceiling = np.abs(values).max()
        axes.imshow(values, cmap="RdBu_r", vmin=-1.6 * ceiling, vmax=1.6 * ceiling, origin="lower")
        for (i, j), value in np.ndenumerate(values):
            axes.text(j, i, text.format(value), ha="center", va="center", fontsize=11)
        axes.set(xticks=(0, 1), yticks=(0, 1), xlabel="x", ylabel="y")
        axes.set_title(title, fontsize=10)
    total = float(terms.sum())
    figure.suptitle(f"sum of the four terms: {total:.4f} nats = {total / np.log(2):.4f} bits", fontsize=11)
    numbers = {"agree": terms[0, 0], "differ": terms[0, 1], "nats": total, "bits": total / np.log(2)}
    return figure, numbers | {
        "by_code": information_of_levels(x, y),
        "copy_bits": information_of_levels(x, x) / np.log(2),
    }


def shapes_of_relations(seed: int = 0) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Six relations of x and y, 1000 samples each."""
    rng = np.random.default_rng(seed)
    x, z = rng.uniform(-1, 1, DRAWN), rng.standard_normal(DRAWN)
    angle = rng.uniform(0, 2 * np.pi, DRAWN)
    return {
        "line": (x, x),
        "noisy line": (x, x + 0.6 * z),
        "parabola": (x, x**2),
        "circle": (np.cos(angle), np.sin(angle)),
        "spread": (x, x * z),
        "nothing": (x, rng.uniform(-1, 1, DRAWN)),
    }


def correlation() -> tuple[Figure, dict]:
    """Relations that correlation sees, and relations that it does not."""
    figure, numbers = Figure(figsize=(9.4, 5.0), layout="constrained"), {}
    for axes, (name, (x, y)) in zip(figure.subplots(2, 3).flat, shapes_of_relations().items(), strict=True):
        axes.plot(x, y, ".", markersize=2.5, color=POSITION)
        of = float(np.corrcoef(x, y)[0, 1])
        found, by_chance = found_and_chance(x, y)
        axes.set_title(f"{name}: correlation {abs(of):.2f}, µ {found:.3f}", fontsize=10)
        axes.set(xlabel="x", ylabel="y")
        numbers[name.replace(" ", "_")] = {"correlation": abs(of), "information": found, "chance": by_chance}
    return figure, numbers


def joint() -> tuple[Figure, dict]:
    """Joint histograms of world x with the lens and with the screen, in focus and out of focus."""
    figure, numbers = Figure(figsize=(8.0, 5.6), layout="constrained"), {}
    grid = figure.subplots(2, 2)
    for row, (place, where) in zip(grid, PLACES.items(), strict=True):
        box = neighbourhood("dof", *where)
        y, one = column(box, "world_position"), numbers.setdefault(place.replace(" ", "_"), {})
        for axes, (name, label) in zip(row, {"lens_u": "lens_u", "screen_position": "screen x"}.items(), strict=True):
            one[name] = _joint_of(axes, column(box, name), y, f"{place}: {label} and world x", label)
            one["chance"] = found_and_chance(column(box, name), y)[1]
    return figure, numbers


def _joint_of(axes: Axes, x: np.ndarray, y: np.ndarray, title: str, label: str) -> float:
    """One joint histogram under its mutual information."""
    found = count_picture(axes, x, y, (f"{label} (deviations)", "world x (deviations)"))
    axes.set_title(f"{title}: µ = {found:.3f}", fontsize=10)
    return found
