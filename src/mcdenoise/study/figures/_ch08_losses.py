"""Chapter 08, losses: their curves and slopes, the relative error over brightness, saturation."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.nn import CrossEntropy, RelativeError, Sigmoid, SquaredError
from mcdenoise.nn.layers import sigmoid, softplus
from mcdenoise.nn.losses import relative_error_gradient
from mcdenoise.study.charts import COLOURS, GREY

BLUE, RED, GREEN, PURPLE = COLOURS[:4]
EPSILON = 0.01
REFERENCES = (0.0, 0.1, 1.0)


def curve(loss: object, y: np.ndarray, target: float) -> tuple[np.ndarray, np.ndarray]:
    """A loss and its gradient for each y, one row at a time."""
    values, slopes = np.empty(len(y)), np.empty(len(y))
    for k, one in enumerate(y):
        values[k], saved = loss.forward(np.array([[one]]), [[target]])
        slopes[k] = loss.backward(saved)[0, 0]
    return values, slopes


def losses() -> tuple[Figure, dict]:
    """Squared error, cross-entropy and relative error: value above, derivative below."""
    figure, numbers = Figure(figsize=(9.4, 4.8), layout="constrained"), {}
    grid = figure.subplots(2, 3, sharex="col")
    wide, near = np.linspace(-6, 6, 241), np.linspace(-0.5, 1.5, 401)
    drawn = (
        (0, SquaredError(), near, 0.5, "target 0.5", BLUE),
        (1, CrossEntropy(), wide, 1.0, "target 1", GREEN),
        (1, CrossEntropy(), wide, 0.0, "target 0", PURPLE),
        *((2, RelativeError(1.0, EPSILON), near, c, f"c = {c:g}", COLOURS[k]) for k, c in enumerate(REFERENCES)),
    )
    for column, loss, y, target, label, colour in drawn:
        for axes, values in zip(grid[:, column], curve(loss, y, target), strict=True):
            axes.plot(y, values, color=colour, label=label)
    for axes, title in zip(
        grid[0], ("squared error", "cross-entropy, on the sigmoid's input", "relative error, ε = 0.01"), strict=True
    ):
        axes.set_title(title, fontsize=10)
        axes.legend(frameon=False, fontsize=9)
    for axes in grid[1]:
        axes.axhline(0, color=GREY, linewidth=0.7)
        axes.set_xlabel("y")
    grid[0, 0].set_ylabel("E")
    grid[1, 0].set_ylabel("dE / dy")
    grid[0, 2].set_ylim(0, 6)
    grid[1, 2].set_ylim(-20, 20)
    for c in REFERENCES:
        numbers[f"slope_{c:g}"] = float(
            relative_error_gradient(np.array([[c + 0.1]]), np.array([[c]]), 1, EPSILON)[0, 0]
        )
    return figure, numbers


def relative() -> tuple[Figure, dict]:
    """The gradient over the brightness of the reference, for an error of 0.01 and for one of 10 %."""
    c = np.geomspace(1e-3, 100, 400)
    figure = Figure(figsize=(9.4, 3.2), layout="constrained")
    errors = {"y = c + 0.01: off by the same": np.full_like(c, 0.01), "y = 1.1 c: off by the same share": 0.1 * c}
    for axes, (title, off) in zip(figure.subplots(1, 2), errors.items(), strict=True):
        axes.loglog(c, off, color=BLUE, label="squared error")
        for epsilon, colour, style in ((0.01, RED, "-"), (0.0001, PURPLE, "--")):
            gradient = relative_error_gradient((c + off)[:, None], c[:, None], 1, epsilon)[:, 0]
            axes.loglog(c, gradient, style, color=colour, label=f"relative error, ε = {epsilon:g}")
        axes.axvline(0.1, color=GREY, linewidth=0.8, linestyle=":")
        axes.set(xlabel="reference c", title=title)
        axes.legend(frameon=False, fontsize=9)
    figure.axes[0].set_ylabel("gradient for one channel, n = 1")

    def at(c: float, off: float) -> float:
        return float(relative_error_gradient(np.array([[c + off]]), np.array([[c]]), 1, EPSILON)[0, 0])

    return figure, {
        "dark": at(0.001, 0.01), "bright": at(10, 0.01),
        "share_peak": at(0.1, 0.01), "share_bright": at(10, 1.0), "share_dark": at(0.001, 0.0001),
        "slope_at_black": 1 / EPSILON,
    }  # fmt: skip


def naive_sigmoid(x: np.ndarray) -> np.ndarray:
    """e^x / (1 + e^x), as one might write it: NaN where e^x overflows."""
    with np.errstate(over="ignore", invalid="ignore"):
        return np.exp(x) / (1 + np.exp(x))


def saturation() -> tuple[Figure, dict]:
    """A wrong and sure answer: slopes of three losses for target 1; and what e^x does at +-1e4."""
    y = np.linspace(-12, 6, 181)
    p, saved = Sigmoid().forward(y[:, np.newaxis])
    squared = Sigmoid().backward(p - 1, saved)[0][:, 0]
    entropy = CrossEntropy()
    direct = entropy.backward(entropy.forward(y[:, np.newaxis], np.ones((len(y), 1)))[1])[:, 0] * len(y)
    figure = Figure(figsize=(9.4, 3.3), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.semilogy(y, -direct, color=GREEN, label="cross-entropy: 1 − p")
    left.semilogy(y, -squared, color=RED, label="squared error of p: (1 − p)² p")
    left.set(xlabel="y, what goes into the sigmoid; the target is 1", ylabel="size of the gradient", ylim=(1e-6, 3))
    left.legend(frameon=False, fontsize=9)
    left.set_title("a gradient that does not vanish", fontsize=10)
    right.set_title("a loss that does not overflow", fontsize=10)
    x32 = np.linspace(-130, 60, 400, dtype=np.float32)
    with np.errstate(divide="ignore", over="ignore"):
        written = -np.log(sigmoid(x32))
    right.plot(x32, softplus(-x32), color=GREEN, label="softplus(y) − y")
    right.plot(x32, written, "--", color=RED, label="−log(sigmoid(y)), float32")
    lost = float(x32[np.isfinite(written)].min())
    right.axvline(lost, color=GREY, linewidth=0.8, linestyle=":")
    right.text(lost - 2, 20, "infinite", ha="right", color=RED, fontsize=9)
    right.set(xlabel="y", ylabel="cross-entropy, target 1")
    right.legend(frameon=False, fontsize=9)
    ends, sure = np.array([1e4, -1e4]), np.array([[-10.0]])
    s = sigmoid(sure)
    return figure, {
        "squared": float(((1 - s) ** 2 * s)[0, 0]), "entropy": float((1 - s)[0, 0]),
        "sigmoid": sigmoid(ends), "softplus": softplus(ends),
        "naive_is_nan": bool(np.isnan(naive_sigmoid(ends)[0])), "lost_below": lost,
        "loss_at_end": CrossEntropy().forward(ends[1:, np.newaxis], [[1.0]])[0],
        "gradient_at_end": float(Sigmoid().backward(np.ones((1, 1)), sigmoid(ends[:1, np.newaxis]))[0][0, 0]),
    }  # fmt: skip
