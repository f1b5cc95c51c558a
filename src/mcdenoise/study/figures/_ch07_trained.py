"""Chapter 07, figures about trained networks: neurons, four data sets, new coordinates, too few and too many neurons."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.nn import MLP, Perceptron
from mcdenoise.study.figures._ch07_data import GREY, ONE, points, trained, wrong
from mcdenoise.study.neurons import (
    BOUNDARY,
    CLASS_COLOURS,
    CLASS_MARKERS,
    Window,
    decision_of,
    draw_points,
    draw_regions,
    layer_outputs,
    show_decision,
    show_neurons,
)
from mcdenoise.study.slider import Slider, slider

CHOSEN = {"moons": (4,), "rings": (4,), "xor": (6,), "checker": (8, 8)}
LONGER = {"xor": {"epochs": 1500, "seed": 3}, "checker": {"epochs": 1500, "n": 600, "rate": 0.03, "seed": 0}}
NEURONS = (1, 2, 3, 4, 5, 6, 8, 12)
SIZES = (3, 8, 64)
NOISE, FEW, MANY, DRAWS = 0.5, 100, 4000, 4


def neurons_moons() -> tuple[Figure, dict]:
    """What each neuron of a network gives that was trained on the moons."""
    network = trained("moons", (4,)).network
    x, labels = points("moons", 240)
    few = slice(0, 120)
    return show_neurons(network, x[few], labels[few]), {"wrong": wrong(network, x, labels), "weights": network.size}


def neurons_checker() -> tuple[Figure, dict]:
    """The same for two hidden layers, trained on the checkerboard."""
    network = trained("checker", CHOSEN["checker"], **LONGER["checker"]).network
    x, labels = points("checker", 600)
    few = slice(0, 150)
    return show_neurons(network, x[few], labels[few]), {"wrong": wrong(network, x, labels), "weights": network.size}


def four_sets() -> tuple[Figure, dict]:
    """Decision boundaries of trained networks on the four data sets, and errors on points that they have not seen."""
    figure, numbers = Figure(figsize=(9.8, 3.0), layout="constrained"), {}
    for axes, (name, hidden) in zip(figure.subplots(1, 4), CHOSEN.items(), strict=True):
        options = LONGER.get(name, {})
        network = trained(name, hidden, **options).network
        x, labels = points(name, options.get("n", 240))
        unseen = wrong(network, *points(name, MANY, seed=9))
        show_decision(network, x, labels, axes=axes)
        axes.set_title(
            f"{name}: {'-'.join(map(str, (2, *hidden, 1)))}\nunseen: {100 * unseen:.1f} % wrong", fontsize=10
        )
        axes.set(xlabel="", ylabel="", xticks=(-1, 0, 1), yticks=(-1, 0, 1))
        numbers[name] = {"train": wrong(network, x, labels), "unseen": unseen, "weights": network.size}
    return figure, numbers


def coordinates() -> tuple[Figure, dict]:
    """Points before and after the hidden layer: four clouds by two neurons, rings by three."""
    figure, numbers = Figure(figsize=(9.8, 2.9), layout="constrained"), {}
    grid = figure.add_gridspec(1, 4)
    for place, (name, width, seed) in enumerate((("clouds", 2, 1), ("rings", 3, 1))):
        network = trained(name, (width,), epochs=1500, seed=seed).network
        x, labels = points(name, 240)
        left = figure.add_subplot(grid[2 * place])
        show_decision(network, x, labels, axes=left, title=f"{name}: the input")
        left.set(xlabel="", ylabel="")
        hidden, output = layer_outputs(network, x)
        last = Perceptron(network.layers[-1].weight[0], float(network.layers[-1].bias[0]))
        if width == 2:
            right = figure.add_subplot(grid[2 * place + 1])
            draw_regions(right, decision_of(last), Window(-0.12, 1.12, -0.12, 1.12))
            draw_points(right, hidden.after, labels, size=12)
            right.set(xlabel="$y_1$", ylabel="$y_2$")
        else:
            right = figure.add_subplot(grid[2 * place + 1], projection="3d")
            _draw_cube(right, hidden.after, labels, last)
        right.set_title(f"{width} hidden neurons", fontsize=10)
        numbers[name] = {
            "wrong": wrong(network, x, labels),
            "same": bool(np.array_equal(last.classify(hidden.after), output.before[:, 0] >= 0)),
        }
    return figure, numbers


def _draw_cube(axes: Axes, y: np.ndarray, labels: np.ndarray, plane: Perceptron) -> None:
    """Draw points of the unit cube, and the part of a plane that is in it."""
    for k, (colour, marker) in enumerate(zip(CLASS_COLOURS, CLASS_MARKERS, strict=True)):
        axes.scatter(*y[labels == k].T, s=12, color=colour, marker=marker, depthshade=False)
    a, b = np.meshgrid(np.linspace(0, 1, 60), np.linspace(0, 1, 60))
    c = -(plane.weight[0] * a + plane.weight[1] * b + plane.bias) / plane.weight[2]
    axes.plot_surface(a, b, np.where((c >= 0) & (c <= 1), c, np.nan), color=GREY, alpha=0.35, linewidth=0)
    axes.set(xlabel="$y_1$", ylabel="$y_2$", zlabel="$y_3$", xlim=(0, 1), ylim=(0, 1), zlim=(0, 1))
    axes.view_init(elev=24, azim=-62)
    axes.set_box_aspect(None, zoom=0.85)
    axes.set_xticks((0, 1))
    axes.set_yticks((0, 1))
    axes.set_zticks((0, 1))


def slider_hidden() -> tuple[Slider, dict]:
    """Rings: one hidden layer of 1 to 12 neurons, the lines of the neurons, and errors on unseen points."""
    networks = {count: trained("rings", (count,), epochs=1000).network for count in NEURONS}
    x, labels = points("rings", 240)
    unseen = points("rings", MANY, seed=9)
    train, test = ([wrong(networks[count], *data) for count in NEURONS] for data in ((x, labels), unseen))

    def draw(neurons: int) -> Figure:
        figure = Figure(figsize=(8.6, 3.9), layout="constrained")
        plane, curve = figure.subplots(1, 2, width_ratios=(1, 1.1))
        show_decision(networks[neurons], x, labels, axes=plane, title=f"rings: {neurons} hidden neurons")
        _draw_lines(plane, networks[neurons])
        k = NEURONS.index(neurons)
        for values, colour, label in ((train, GREY, "the 240 points"), (test, ONE, f"{MANY} unseen points")):
            curve.plot(NEURONS, 100 * np.array(values), ".-", color=colour, label=label)
            curve.plot(neurons, 100 * values[k], "o", color=colour, markersize=9)
        curve.set(xlabel="hidden neurons", ylabel="wrong (%)", ylim=(-1, None))
        curve.legend(frameon=False)
        return figure

    picture = slider(draw, title="How many hidden neurons do rings need?", start=3, neurons=NEURONS)
    return picture, {"neurons": NEURONS, "train": train, "unseen": test}


def _draw_lines(axes: Axes, network: MLP) -> None:
    """Draw where each neuron of the first layer is at its boundary."""
    for weight, bias in zip(network.layers[0].weight, network.layers[0].bias, strict=True):
        length = np.hypot(*weight)
        middle, along = -bias * weight / length**2, np.array([weight[1], -weight[0]]) / length
        ends = np.array([middle - 9 * along, middle + 9 * along])
        axes.plot(*ends.T, "--", color=BOUNDARY, linewidth=0.8, scalex=False, scaley=False)


def overfit() -> tuple[Figure, dict]:
    """Noisy moons, 100 points: boundaries of 3, 8 and 64 hidden neurons, errors on these points and on 4000 others."""
    figure, numbers = Figure(figsize=(9.8, 3.9), layout="constrained"), {"hidden": SIZES}
    rates = np.array([[noisy_moons(width, draw) for draw in range(DRAWS)] for width in SIZES])
    for axes, width, (train, unseen) in zip(figure.subplots(1, 3), SIZES, rates[:, 0], strict=True):
        show_decision(noisy_network(width, 0), *points("moons", FEW, noise=NOISE), axes=axes)
        axes.set(xlabel="", ylabel="")
        axes.set_title(
            f"{width} hidden neurons, {4 * width + 1} numbers\n"
            f"wrong: {100 * train:.0f} % of {FEW}, {100 * unseen:.1f} % of unseen",
            fontsize=10,
        )
    names = ("train", "unseen", "mean_train", "mean_unseen")
    columns = (*rates[:, 0].T, *rates.mean(axis=1).T)
    return figure, numbers | dict(zip(names, columns, strict=True)) | {"draws": DRAWS}


def noisy_network(width: int, draw: int) -> MLP:
    """A network with one hidden layer, trained on one draw of noisy moons."""
    return trained("moons", (width,), n=FEW, epochs=1500, noise=NOISE, data_seed=draw).network


def noisy_moons(width: int, draw: int) -> tuple[float, float]:
    """Share of wrong points: of those it was trained on, and of unseen ones."""
    network = noisy_network(width, draw)
    return wrong(network, *points("moons", FEW, draw, noise=NOISE)), wrong(
        network, *points("moons", MANY, seed=99, noise=NOISE)
    )
