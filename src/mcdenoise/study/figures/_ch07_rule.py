"""Chapter 07, figures about the learning rule: step by step, its bound, and data that has no line."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mcdenoise.nn import Perceptron, PerceptronTraining, train_perceptron
from mcdenoise.study.figures._ch07_classifiers import best_line
from mcdenoise.study.figures._ch07_data import FOURTH, GREY, ONE, THIRD, ZERO, pixels
from mcdenoise.study.neurons import BOUNDARY, decision_of, draw_points, draw_regions, window_of
from mcdenoise.study.slider import Slider, slider

GAPS = (0.4, 0.2, 0.1, 0.05, 0.025)  # half the width of the empty strip
ORDERS, COUNT = 30, 60
EPOCHS, SOME = 40, 1500


def separable(
    n: int, gap: float, rng: np.random.Generator, reach: float = 0.6
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points on both sides of a random line, at least `gap` away from it; half of them in a tenth of what is beyond.

    Returns x (n, 2), labels (n,), and the line (w_1, w_2, b) with a weight of length 1.

    Examples
    --------
    >>> x, labels, line = separable(50, 0.1, np.random.default_rng(0))
    >>> bool(np.all((2 * labels - 1) * (x @ line[:2] + line[2]) >= 0.1 - 1e-12))
    True
    """
    angle = rng.uniform(0, 2 * np.pi)
    line = np.array([np.cos(angle), np.sin(angle), rng.uniform(-0.3, 0.3)])
    labels = rng.integers(0, 2, n)
    across = (2 * labels - 1) * (gap + reach * rng.random(n) ** 3) - line[2]
    along = rng.uniform(-1, 1, n)
    return across[:, np.newaxis] * line[:2] + along[:, np.newaxis] * [-line[1], line[0]], labels, line


def novikoff(x: np.ndarray, labels: np.ndarray, line: np.ndarray) -> float:
    """The bound (R / gamma)^2 that a line of the given numbers proves: no more corrections than that, in any order.

    Examples
    --------
    >>> novikoff(np.array([[1.0], [-1.0]]), np.array([1, 0]), np.array([1.0, 0.0]))
    2.0
    """
    rows = np.column_stack([x, np.ones(len(x))])
    gamma = np.min((2 * labels - 1) * (rows @ line)) / np.linalg.norm(line)
    return float(np.round(np.square(rows).sum(axis=1).max() / gamma**2, 9))


def slider_rule() -> tuple[Slider, dict]:
    """Every correction of the rule on 40 points: the sample, the line before and after, and how many points are wrong."""
    x, labels, line = separable(40, 0.2, np.random.default_rng(0), reach=1.0)
    done = train_perceptron(x, labels)
    left_wrong = [int(np.sum(_of(done, k).classify(x) != labels)) for k in range(len(done.history))]

    def draw(correction: int) -> Figure:
        figure = Figure(figsize=(8.6, 3.9), layout="constrained")
        plane, curve = figure.subplots(1, 2, width_ratios=(1, 1.1))
        window = window_of(x)
        now = _of(done, correction)
        draw_regions(plane, decision_of(now), window)
        draw_points(plane, x, labels, wrong=now.classify(x) != labels)
        title = "start: w = 0, b = 0, every answer is 1"
        if correction:
            before, change = _of(done, correction - 1), done.history[correction] - done.history[correction - 1]
            sample, sign = change[:2] / change[2], "+" if change[2] > 0 else "-"
            plane.plot(*sample, "o", markersize=14, fillstyle="none", color=FOURTH, markeredgewidth=2)
            if np.any(before.weight):
                _draw_line(plane, before)
            title = f"({sample[0]:.2f}, {sample[1]:.2f}) was wrong: w {sign} x, b {sign} 1"
        plane.set_title(title, fontsize=10)
        curve.plot(left_wrong, ".-", color=GREY)
        curve.plot(correction, left_wrong[correction], "o", color=FOURTH, markersize=9)
        curve.set(xlabel="corrections", ylabel=f"points that are wrong, of {len(x)}", ylim=(-0.5, None))
        curve.yaxis.set_major_locator(MaxNLocator(integer=True))
        curve.set_title(f"w = ({now.weight[0]:.2f}, {now.weight[1]:.2f}), b = {now.bias:.0f}", fontsize=10)
        return figure

    picture = slider(draw, title="The rule, correction by correction", start=0, correction=range(len(done.history)))
    return picture, {
        "points": len(x),
        "corrections": len(done.history) - 1,
        "epochs": len(done.mistakes),
        "mistakes": done.mistakes,
        "wrong": left_wrong,
        "bound": novikoff(x, labels, line),
        "separated": done.separated,
    }


def _of(done: PerceptronTraining, correction: int) -> Perceptron:
    """The perceptron after so many corrections."""
    return Perceptron(done.history[correction, :2], float(done.history[correction, 2]))


def _draw_line(axes, one: Perceptron) -> None:
    """Draw the boundary of a perceptron as a dashed line."""
    length = np.hypot(*one.weight)
    middle, along = -one.bias * one.weight / length**2, np.array([one.weight[1], -one.weight[0]]) / length
    ends = np.array([middle - 9 * along, middle + 9 * along])
    axes.plot(*ends.T, "--", color=BOUNDARY, linewidth=1, scalex=False, scaley=False)


def bound() -> tuple[Figure, dict]:
    """Corrections until all points are right, for gaps of several widths, and Novikoff's bound."""
    found, limits = [], []
    for gap in GAPS:
        rng = np.random.default_rng(0)
        sets = [separable(COUNT, gap, rng) for _ in range(ORDERS)]
        done = [train_perceptron(x, labels, epochs=5000) for x, labels, _ in sets]
        assert all(one.separated for one in done)
        found.append([len(one.history) - 1 for one in done])
        limits.append([novikoff(*one) for one in sets])
    found, limits = np.array(found), np.array(limits)
    figure = Figure(figsize=(9.4, 3.7), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.loglog(GAPS, np.median(limits, axis=1), "s--", color=GREY, label="bound (R / γ)², median")
    left.loglog(GAPS, found.max(axis=1), "^-", color=ONE, label=f"measured, most of {ORDERS}")
    left.loglog(GAPS, np.median(found, axis=1), "o-", color=ZERO, label="measured, median")
    left.set(xlabel="half the width of the gap", ylabel="corrections")
    left.set_xticks(GAPS, [f"{gap:g}" for gap in GAPS])
    left.minorticks_off()
    ratio = found / limits
    right.loglog(limits.ravel(), np.maximum(found, 1).ravel(), ".", color=ZERO, label="one set of points")
    ends = np.array([limits.min(), limits.max()])
    right.loglog(ends, ends, "--", color=GREY, label="as many as the bound")
    right.set(xlabel="bound (R / γ)²", ylabel="corrections")
    for axes in (left, right):
        axes.grid(color="#e5e5e5")
        axes.legend(frameon=False, fontsize=9)
    return figure, {
        "gaps": GAPS,
        "median": np.median(found, axis=1),
        "most": found.max(axis=1),
        "bound": np.median(limits, axis=1),
        "closest": ratio.max(),
        "loosest": ratio.min(),
        "sets": found.size,
    }


def never_stops() -> tuple[Figure, dict]:
    """The rule on data with a line and on pixels without one: corrections in each epoch, and share right after it."""
    all_x, all_labels, _ = pixels()
    some = np.random.default_rng(1).choice(len(all_x), SOME, replace=False)
    x, labels = all_x[some], all_labels[some]
    clean = train_perceptron(*separable(SOME, 0.002, np.random.default_rng(3))[:2], epochs=EPOCHS)
    noisy = train_perceptron(x, labels, epochs=EPOCHS, rng=np.random.default_rng(0))
    ends = np.cumsum(noisy.mistakes)
    right = np.array([np.mean(_of(noisy, k).classify(x) == labels) for k in ends])
    best = float(np.mean(best_line().classify(x) == labels))
    figure = Figure(figsize=(9.4, 3.5), layout="constrained")
    left, other = figure.subplots(1, 2)
    left.plot(range(1, len(clean.mistakes) + 1), clean.mistakes, "o-", color=THIRD, label="a line exists")
    left.plot(range(1, EPOCHS + 1), noisy.mistakes, ".-", color=ONE, label="pixels: there is none")
    left.set(xlabel="epoch", ylabel=f"corrections, of {SOME} samples", ylim=(0, None))
    other.plot(range(1, EPOCHS + 1), 100 * right, ".-", color=ONE, label="the rule, after each epoch")
    other.axhline(100 * best, color=ZERO, linestyle="--", label="one line by chapter 08")
    other.set(xlabel="epoch", ylabel="pixels that are right (%)")
    for axes in (left, other):
        axes.legend(frameon=False, fontsize=9)
        axes.grid(color="#e5e5e5")
    other.legend(loc="lower left", frameon=False, fontsize=9)
    return figure, {
        "samples": SOME,
        "clean_epochs": len(clean.mistakes),
        "clean_separated": clean.separated,
        "last": noisy.mistakes[-1],
        "least": noisy.mistakes.min(),
        "right": {"worst": right.min(), "best": right.max(), "last": right[-1]},
        "line": best,
        "epochs": EPOCHS,
    }
