"""Chapter 07, figures about one perceptron: an answer for each pixel, weight and bias in one and in two dimensions."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from mcdenoise.metrics import relmse
from mcdenoise.nn import MLP, Adam, CrossEntropy, Perceptron, train
from mcdenoise.nn.layers import sigmoid
from mcdenoise.study.figures._ch04_data import SIZE, noisy, picture, plain, reference
from mcdenoise.study.figures._ch07_data import GREY, NARROW, ONE, SCENE, THIRD, WIDE, ZERO, pixels
from mcdenoise.study.neurons import Window, decision_of, draw_boundary, draw_points, draw_regions

SHOWN = 700  # points of the scatter plot
LINES = ((2.0, -1.0), (-2.0, 1.0), (8.0, -4.0), (2.0, 1.0))  # weight and bias
WEIGHT, BIAS = np.array([1.2, 0.9]), -1.05
POINT = np.array([0.2, 1.5])


@cache
def best_line() -> Perceptron:
    """The perceptron that chapter 08 finds for the pixels of `answers`: descent on a smooth step."""
    x, labels, _ = pixels()
    start = MLP.random([2, 1], rng=np.random.default_rng(0))
    found = train(start, x, labels[:, np.newaxis], loss=CrossEntropy(), optimizer=Adam(0.05), epochs=300).network
    return Perceptron(found.parameters["weight_1"][0], float(found.parameters["bias_1"][0]))


def answers() -> tuple[Figure, dict]:
    """Which of two filters errs less, pixel by pixel; two features of the pixels; what a line makes of them."""
    x, labels, errors = pixels()
    line = best_line()
    answer = line.classify(x)
    figure = Figure(figsize=(9.8, 3.1), layout="constrained")
    image, truth, plane, given = figure.subplots(1, 4)
    picture(image, noisy(SCENE), f"{SCENE}, 8 spp")
    for axes, values, title in ((truth, labels, "which filter errs less"), (given, answer, "what the line answers")):
        axes.imshow(
            values.reshape(SIZE, SIZE), cmap=ListedColormap((ZERO, ONE)), vmin=0, vmax=1, interpolation="nearest"
        )
        plain(axes, title)
    some = np.random.default_rng(0).choice(len(x), SHOWN, replace=False)
    window = Window(-2.5, 2.5, -2.5, 2.5)
    draw_regions(plane, decision_of(line), window)
    draw_points(plane, x[some], labels[some], size=6)
    plane.set(xlabel="relative noise", ylabel="slope of the image", xticks=(), yticks=())
    plane.set_title(f"{SHOWN} pixels", fontsize=10)
    figure.suptitle(
        f"red: the Gaussian with sigma_space = {WIDE:g} pixels errs less; blue: that with {NARROW:g} does", fontsize=10
    )
    return figure, {"right": np.mean(answer == labels)} | _worth(labels, answer, errors) | {
        "pixels": len(x),
        "wide": labels.mean(),
        "weight": line.weight,
        "bias": line.bias,
    }


def _worth(labels: np.ndarray, answer: np.ndarray, errors: np.ndarray) -> dict:
    """RelMSE by who chooses the filter, and what answers of "wide" cost or save on average where wrong and where right."""
    pick = lambda chosen: float(errors[np.arange(len(errors)), chosen].mean())  # noqa: E731
    narrow, lost = np.zeros(len(errors), int), errors[:, 1] - errors[:, 0]
    chosen = {"narrow": narrow, "wide": narrow + 1, "line": answer, "labels": labels}
    return {
        "relmse": {"noisy": relmse(noisy(SCENE), reference(SCENE))} | {name: pick(one) for name, one in chosen.items()},
        "saved": -lost[(labels == 1) & (answer == 1)].mean(),
        "cost": lost[(labels == 0) & (answer == 1)].mean(),
        "share_saved": (pick(narrow) - pick(answer)) / (pick(narrow) - pick(labels)),
    }


def one_dimension() -> tuple[Figure, dict]:
    """A perceptron of one input at four choices of weight and bias; dashed, the smooth step."""
    figure = Figure(figsize=(9.6, 2.7), layout="constrained")
    x = np.linspace(-2, 2, 801)
    for axes, (weight, bias) in zip(figure.subplots(1, 4, sharey=True), LINES, strict=True):
        at = -bias / weight
        axes.axvspan(*((at, 2) if weight > 0 else (-2, at)), color=ONE, alpha=0.15, linewidth=0)
        axes.axvspan(*((-2, at) if weight > 0 else (at, 2)), color=ZERO, alpha=0.15, linewidth=0)
        axes.plot(x, (weight * x + bias >= 0).astype(float), color="#222222", linewidth=1.8, label="step")
        axes.plot(x, sigmoid(weight * x + bias), "--", color=THIRD, label="sigmoid")
        axes.axvline(at, color=GREY, linestyle=":")
        axes.set(xlabel="x", xlim=(-2, 2), ylim=(-0.08, 1.08))
        axes.set_title(f"w = {weight:g}, b = {bias:g}\nboundary at x = {at:g}", fontsize=10)
    figure.axes[0].set_ylabel("y = f(w x + b)")
    figure.axes[2].legend(frameon=False, fontsize=8.5, loc="upper left")
    return figure, {"boundary": [-bias / weight for weight, bias in LINES]}


def geometry() -> tuple[Figure, dict]:
    """The line of a perceptron: its weight at right angles, its distance from the origin, the distance of a point."""
    length = float(np.hypot(*WEIGHT))
    line, unit = Perceptron(WEIGHT, BIAS), WEIGHT / length
    figure = Figure(figsize=(9.4, 4.3), layout="constrained")
    left, right = figure.subplots(1, 2)
    window = Window(-1, 2.4, -1, 2.4)
    draw_regions(left, decision_of(line), window)
    foot, far = -BIAS / length, float(POINT @ WEIGHT + BIAS) / length
    _measure(left, (0, 0), unit * foot, "-b / |w|", (-0.28, 0.22))
    start = unit * foot + 1.0 * np.array([unit[1], -unit[0]])
    left.annotate("", start + WEIGHT * 0.7, start, arrowprops={"arrowstyle": "-|>", "color": ONE, "linewidth": 2})
    left.text(*(start + WEIGHT * 0.7 + [0.05, 0.0]), "w", color=ONE, fontsize=13)
    _measure(left, POINT - unit * far, POINT, "(w · x + b) / |w|", (0.12, -0.16))
    left.plot(*POINT, "o", color="#222222")
    left.plot(0, 0, "+", color="#222222", markersize=10)
    left.set_title("a line, and what its numbers mean", fontsize=10)
    values = window.grid(241) @ WEIGHT + BIAS
    shown = right.contourf(
        *window.sides(241), values.reshape(241, 241), levels=np.arange(-4, 4.5, 0.5), cmap="RdBu_r", alpha=0.7
    )
    draw_boundary(right, values.reshape(241, 241), window)
    right.set(aspect="equal", xlabel="$x_1$", ylabel="$x_2$")
    right.set_title("w · x + b before the step", fontsize=10)
    figure.colorbar(shown, ax=right, shrink=0.85)
    return figure, {"length": length, "distance": foot, "point": far, "weight": WEIGHT, "bias": BIAS, "at": POINT}


def _measure(axes: Axes, start: np.ndarray, end: np.ndarray, text: str, shift: tuple[float, float]) -> None:
    """A double arrow with its length beside it."""
    axes.annotate("", end, start, arrowprops={"arrowstyle": "<->", "color": "#222222", "shrinkA": 0, "shrinkB": 0})
    axes.text(*(np.add(start, end) / 2 + shift), text, fontsize=10.5)
