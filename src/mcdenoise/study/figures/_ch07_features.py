"""Chapter 07, figures about decisions without a line: XOR, a feature that helps, and features made by perceptrons."""

from __future__ import annotations

from itertools import product

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.nn import MLP, Linear, Step, all_of, half_planes, train_perceptron
from mcdenoise.study.figures._ch07_data import FOURTH, GREY, THIRD, draw_network, points, wrong
from mcdenoise.study.neurons import (
    BOUNDARY,
    CLASS_COLOURS,
    COARSE,
    REGION_COLOURS,
    Window,
    decision_of,
    draw_neuron,
    draw_points,
    draw_regions,
    layer_outputs,
    window_of,
)

CORNERS = np.array(list(product((0, 1), repeat=2)), float)
GATES = {"AND": (0, 0, 0, 1), "OR": (0, 1, 1, 1), "XOR": (0, 1, 1, 0)}
THRESHOLDS = (-1.0, 0.0, 1.0)
SIGNS = (1.0, -1.0, 1.0)


def gates() -> tuple[Figure, dict]:
    """AND, OR and XOR on the corners of a square, and all sixteen functions of two inputs."""
    figure = Figure(figsize=(9.8, 2.9), layout="constrained")
    *planes, table = figure.subplots(1, 4)
    window, numbers = Window(-0.6, 1.6, -0.6, 1.6), {}
    for axes, (name, labels) in zip(planes, GATES.items(), strict=True):
        labels, done = np.array(labels), train_perceptron(CORNERS, labels, epochs=100)
        if done.separated:
            draw_regions(axes, decision_of(done.perceptron), window)
            title = f"{name}: {len(done.history) - 1} corrections"
        else:
            axes.set(aspect="equal", xlim=window[:2], ylim=window[2:], xlabel="$x_1$", ylabel="$x_2$")
            title = f"{name}: no line"
        draw_points(axes, CORNERS, labels, size=110)
        axes.set_title(title, fontsize=10)
        axes.set(xticks=(0, 1), yticks=(0, 1))
        numbers[name.lower()] = {
            "separated": done.separated,
            "corrections": len(done.history) - 1,
            "weight": done.perceptron.weight,
            "bias": done.perceptron.bias,
        }
    with_line = [separable_by_rule(CORNERS, labels) for labels in product((0, 1), repeat=4)]
    _draw_sixteen(table, with_line)
    numbers |= {"of_2": sum(with_line), "best_xor": best_of_lines(GATES["XOR"])}
    cube = np.array(list(product((0, 1), repeat=3)), float)
    return figure, numbers | {"of_3": sum(separable_by_rule(cube, one) for one in product((0, 1), repeat=8))}


def separable_by_rule(x: np.ndarray, labels: tuple[int, ...]) -> bool:
    """Whether the rule finds a line (within 30 epochs; functions of three inputs need fewer).

    Examples
    --------
    >>> separable_by_rule(CORNERS, (0, 0, 0, 1)), separable_by_rule(CORNERS, (1, 0, 0, 1))
    (True, False)
    """
    return train_perceptron(x, labels, epochs=30).separated


def best_of_lines(labels: tuple[int, ...], tries: int = 20_000) -> int:
    """The most corners that any of many random lines gets right.

    Examples
    --------
    >>> best_of_lines((0, 1, 1, 0), tries=1000)
    3
    """
    lines = np.random.default_rng(0).standard_normal((tries, 3))
    answers = CORNERS @ lines[:, :2].T + lines[:, 2] >= 0
    return int((answers == np.array(labels)[:, np.newaxis]).sum(axis=0).max())


def _draw_sixteen(axes: Axes, with_line: list[bool]) -> None:
    """All functions of two inputs as small squares; those without a line in a frame."""
    for k, (labels, line) in enumerate(zip(product((0, 1), repeat=4), with_line, strict=True)):
        corner = np.array([1.5 * (k % 4), -1.5 * (k // 4)])
        for place, label in zip(CORNERS, labels, strict=True):
            marker = ("o", "s")[label]
            axes.plot(*(corner + 0.6 * place + 0.2), marker, markersize=5.5, color=CLASS_COLOURS[label])
        if not line:
            axes.plot(*(corner + np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)])).T, color="#222222")
    axes.set(aspect="equal", xticks=[], yticks=[], xlim=(-0.4, 5.9), ylim=(-4.9, 1.4))
    axes.set_title(f"all 16: {sum(with_line)} have a line", fontsize=10)


def polynomial() -> tuple[Figure, dict]:
    """An interval is no half line of x, but a half plane of (x, x^2); a disc is a half line of the squared radius."""
    rng = np.random.default_rng(2)
    x = rng.uniform(-1.5, 1.5, 60)
    x = x[np.abs(np.abs(x - 0.2) - 0.6) > 0.05]
    labels = (np.abs(x - 0.2) < 0.6).astype(int)
    lifted = np.stack([x, x**2], axis=1)
    done = train_perceptron(lifted, labels, epochs=2000)
    figure = Figure(figsize=(9.8, 3.5), layout="constrained")
    line, plane, disc = figure.subplots(1, 3)
    draw_points(line, np.stack([x, np.zeros(len(x))], axis=1), labels, size=28)
    line.set(xlabel="x", yticks=[], ylim=(-1, 1))
    best, where = best_threshold(x, labels)
    line.axvline(where, color=BOUNDARY, linestyle="--", linewidth=1.2)
    line.set_title(f"x: the best threshold gets {100 * best:.0f} % right", fontsize=10)
    draw_regions(plane, decision_of(done.perceptron), Window(-1.7, 1.7, -0.5, 2.9))
    draw_points(plane, lifted, labels, size=28)
    plane.set(xlabel="x", ylabel="x²", aspect="auto")
    plane.set_title("(x, x²): a line", fontsize=10)
    rings, ring = points("rings", 200)
    of_radius = train_perceptron(np.square(rings).sum(axis=1, keepdims=True), ring, epochs=200)
    weight, bias = float(of_radius.perceptron.weight[0]), of_radius.perceptron.bias
    circle = lambda x: (weight * np.square(x).sum(axis=1) + bias >= 0).astype(float)  # noqa: E731
    draw_regions(disc, lambda x: weight * np.square(x).sum(axis=1) + bias, window_of(rings))
    draw_points(disc, rings, ring, size=12)
    disc.set_title("rings: threshold of $x_1^2 + x_2^2$", fontsize=10)
    roots = np.sort(np.roots([done.perceptron.weight[1], done.perceptron.weight[0], done.perceptron.bias]))
    return figure, {
        "threshold": best,
        "separated": done.separated,
        "corrections": len(done.history) - 1,
        "interval": roots,
        "radius": np.sqrt(-bias / weight),
        "rings_wrong": wrong(circle, rings, ring),
    }


def best_threshold(x: np.ndarray, labels: np.ndarray) -> tuple[float, float]:
    """The largest share of points that a threshold of x gets right, the 1 on either side, and the threshold.

    Examples
    --------
    >>> best_threshold(np.array([0.0, 1.0, 2.0, 3.0]), np.array([0, 1, 1, 0]))
    (0.75, 1.0)
    """
    right = np.array([np.mean((x >= t) == labels) for t in x])
    best = np.maximum(right, 1 - right)
    return float(best.max()), float(x[best.argmax()])


def sum_of_steps() -> MLP:
    """Three perceptrons of one input, and one of their outputs: 1 on [-1, 0) and from 1 on."""
    lines = [[1.0, -threshold] for threshold in THRESHOLDS]
    return MLP((*half_planes(lines), Linear(np.array([SIGNS]), np.array([-0.5])), Step()))


def perceptron_features() -> tuple[Figure, dict]:
    """A network of one input: its diagram, its three features, their weighted sum and the answer."""
    network, x = sum_of_steps(), np.linspace(-2, 2, 1601)
    hidden, output = layer_outputs(network, x[:, np.newaxis])
    figure = Figure(figsize=(9.6, 4.4), layout="constrained")
    diagram, right = figure.subfigures(1, 2, width_ratios=(1.15, 1))
    draw_network(diagram.subplots(), network, [["$x_1$"], ["$y_1$", "$y_2$", "$y_3$"], ["$y$"]])
    rows = right.subplots(5, 1, sharex=True)
    for k in range(3):
        rows[k].plot(x, hidden.after[:, k], color=THIRD)
        rows[k].set_ylabel(f"$y_{k + 1}$", rotation=0, ha="right", va="center")
    rows[3].plot(x, output.before[:, 0], color=FOURTH)
    rows[3].axhline(0, color=GREY, linestyle=":")
    rows[3].set_ylabel("sum", rotation=0, ha="right", va="center")
    rows[4].plot(x, output.after[:, 0], color="#222222")
    rows[4].set_ylabel("$y$", rotation=0, ha="right", va="center")
    for axes in rows:
        axes.fill_between(x, 0, 1, where=output.after[:, 0] > 0, transform=axes.get_xaxis_transform(),
                          color=REGION_COLOURS[1], linewidth=0)  # fmt: skip
        axes.margins(y=0.15)
        axes.set(yticks=(0, 1))
    rows[3].set(yticks=(-0.5, 0.5))
    rows[4].set(xlabel="$x_1$", xlim=(-2, 2))
    changes = x[np.flatnonzero(np.diff(output.after[:, 0]))]
    return figure, {"changes": np.round(changes, 2), "weights": network.size, "perceptrons": 4}


def xor_by_hand() -> MLP:
    """OR and AND of two inputs, then OR without AND."""
    return MLP((*half_planes([[1, 1, -0.5], [1, 1, -1.5]]), *all_of([[0, ~1]], 2)))


def xor_network() -> tuple[Figure, dict]:
    """XOR by two perceptrons and one that takes their outputs: diagram, and what each gives over the plane."""
    network = xor_by_hand()
    labels, window = np.array(GATES["XOR"]), Window(-0.6, 1.6, -0.6, 1.6)
    figure = Figure(figsize=(9.8, 2.9), layout="constrained")
    diagram, *maps = figure.subplots(1, 4, width_ratios=(1.45, 1, 1, 1))
    draw_network(diagram, network, [["$x_1$", "$x_2$"], ["$y_1$", "$y_2$"], ["$y$"]])
    hidden, output = layer_outputs(network, window.grid(COARSE))
    shown = (
        (hidden, 0, "$y_1$: $x_1$ or $x_2$"),
        (hidden, 1, "$y_2$: $x_1$ and $x_2$"),
        (output, 0, "$y$: $y_1$ and not $y_2$"),
    )
    for axes, (layer, k, title) in zip(maps, shown, strict=True):
        draw_neuron(axes, layer, k, window)
        draw_points(axes, CORNERS, labels, size=70)
        axes.set(xticks=(0, 1), yticks=(0, 1), xlabel="$x_1$")
        axes.set_title(title, fontsize=10)
    answers = network.forward(CORNERS)[0].ravel()
    return figure, {"answers": answers, "weights": network.size, "wrong": float(np.mean(answers != labels))}
