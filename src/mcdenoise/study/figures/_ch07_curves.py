"""Chapter 07, figures about outputs that are numbers: sums of steps as a curve, and a step that has no gradient."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.nn import MLP, CrossEntropy, Layer, Linear, Sigmoid, Step
from mcdenoise.study.figures._ch07_data import GREY, ONE, THIRD, ZERO, points
from mcdenoise.study.slider import Slider, slider

COUNTS = (1, 2, 4, 8, 16, 32, 64)
STEEPNESS = 3.0  # of a smooth step, in units of 1 / the distance of two of them


def curve(x: np.ndarray) -> np.ndarray:
    """The curve to be approximated, on [0, 1]."""
    return np.sin(2 * np.pi * x) * np.exp(-x) + 0.6 * x


def steps_for(count: int, smooth: bool) -> MLP:
    """One hidden layer of `count` steps at equal distances, each as high as the curve climbs there.

    Examples
    --------
    >>> steps_for(3, smooth=False).forward(np.array([[0.0]]))[0].shape
    (1, 1)
    """
    edges = np.linspace(0, 1, count + 1)
    places, middles = (edges[:-1] + edges[1:]) / 2, curve(edges)
    steep = STEEPNESS * count if smooth else 1.0
    activation: Layer = Sigmoid() if smooth else Step()
    hidden = Linear(np.full((count, 1), steep), -steep * places)
    return MLP((hidden, activation, Linear(np.diff(middles)[np.newaxis], middles[:1])))


def distance(network: MLP) -> float:
    """Root mean square of the difference between a network and the curve."""
    x = np.linspace(0, 1, 4001)
    return float(np.sqrt(np.mean((network.forward(x[:, np.newaxis])[0][:, 0] - curve(x)) ** 2)))


def slider_steps() -> tuple[Slider, dict]:
    """A curve as a sum of 1 to 64 steps, hard and smooth, and how far off each sum is."""
    x = np.linspace(0, 1, 1001)
    hard, soft = ([distance(steps_for(count, smooth)) for count in COUNTS] for smooth in (False, True))

    def draw(steps: int) -> Figure:
        figure = Figure(figsize=(9.0, 3.6), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=(1.2, 1))
        left.plot(x, curve(x), color=GREY, linewidth=4, alpha=0.5, label="curve")
        for smooth, colour, name in ((False, ZERO, "steps"), (True, ONE, "sigmoids")):
            left.plot(x, steps_for(steps, smooth).forward(x[:, np.newaxis])[0][:, 0], color=colour, label=name)
        left.set(xlabel="x", ylabel="y", ylim=(-0.45, 1.15))
        left.set_title(f"{steps} hidden neuron{'s' if steps > 1 else ''}", fontsize=10)
        left.legend(frameon=False, fontsize=9)
        k = COUNTS.index(steps)
        for values, colour, marker, name in ((hard, ZERO, "o", "steps"), (soft, ONE, "s", "sigmoids")):
            right.loglog(COUNTS, values, f"{marker}-", color=colour, label=name, markersize=4)
            right.loglog(steps, values[k], marker, color=colour, markersize=10)
        right.set(xlabel="hidden neurons", ylabel="root mean square difference")
        right.set_xticks(COUNTS, COUNTS)
        right.minorticks_off()
        right.grid(color="#e5e5e5")
        right.legend(frameon=False, fontsize=9)
        return figure

    numbers = {"counts": COUNTS, "steps": hard, "sigmoids": soft}
    return slider(draw, title="A curve from steps", start=8, steps=COUNTS), numbers


def step_gradient() -> tuple[Figure, dict]:
    """Wrong points of the moons, and the loss of a smooth step, over one weight."""
    x, labels = points("moons", 60, noise=0.25)
    weights = np.linspace(-4, 4, 4001)
    levels = np.outer(x[:, 0], weights) - 2.0 * x[:, 1:]  # w_1 varies, w_2 and b stay
    missed = np.mean((levels >= 0) != labels[:, np.newaxis], axis=0)
    loss = np.array([CrossEntropy().forward(one[:, np.newaxis], labels[:, np.newaxis])[0] for one in levels.T])
    figure = Figure(figsize=(9.4, 3.3), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(weights, 100 * missed, color=ZERO)
    left.set(xlabel="weight $w_1$", ylabel="wrong (%)")
    left.set_title("step: flat, with jumps", fontsize=10)
    right.plot(weights, loss, color=ONE)
    best = int(loss.argmin())
    right.plot(weights[best], loss[best], "v", color=THIRD, markersize=9)
    right.set(xlabel="weight $w_1$", ylabel="cross entropy")
    right.set_title("sigmoid: a slope everywhere", fontsize=10)
    for axes in (left, right):
        axes.grid(color="#e5e5e5")
    slopes = np.diff(loss)
    return figure, {
        "flat": np.mean(np.diff(missed) == 0),
        "jumps": np.count_nonzero(np.diff(missed)),
        "values": len(np.unique(missed)),
        "smooth_flat": np.mean(slopes == 0),
        "turns": np.count_nonzero(np.diff(np.sign(slopes))),
        "best": weights[best],
        "wrong_at_best": missed[best],
        "least_wrong": missed.min(),
    }
