"""Chapter 08, training: four optimizers on one problem and on a bowl, step lengths, divergence, a curve that is learned."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.nn import MLP, RPROP, SGD, Adam, Diverged, SquaredError, Tanh, Training, loss_and_gradients, train
from mcdenoise.study.charts import COLOURS, GREY
from mcdenoise.study.slider import Slider, slider

BLUE, RED, GREEN, PURPLE = COLOURS[:4]
EPOCHS = 2000
OPTIMIZERS = {
    "SGD, rate 0.3": (SGD(0.3), BLUE),
    "SGD, rate 0.3, momentum 0.9": (SGD(0.3, momentum=0.9), GREEN),
    "Adam, rate 0.01": (Adam(0.01), RED),
    "RPROP": (RPROP(), PURPLE),
}
BOWL = np.array([1.0, 0.04])  # curvature along x and y: a valley 25 times as steep across as along
START = np.array([-1.4, 4.5])
FRAMES = (0, 1, 2, 4, 8, 14, 20, 30, 50, 80)
SHOWN = (0, 10, 30, 100, 200, 400, 700, 1000, 1500, 2000)


def problem() -> tuple[MLP, np.ndarray, np.ndarray]:
    """A network 1 -> 16 -> 1 and 64 points of a curve with a step in it."""
    x = np.linspace(-1, 1, 64)[:, np.newaxis]
    target = np.sin(5 * x) / 2 + 0.6 * (x > 0.2)
    return MLP.random([1, 16, 1], hidden=Tanh(), rng=np.random.default_rng(2), gain=2.0), x, target


@lru_cache(maxsize=8)
def trained(name: str) -> Training:
    """The problem, trained by one of the four optimizers."""
    return train(*problem(), loss=SquaredError(), optimizer=OPTIMIZERS[name][0], epochs=EPOCHS)


def optimizers() -> tuple[Figure, dict]:
    """Loss over epochs of four optimizers that start from the same weights."""
    figure, numbers = Figure(figsize=(8.4, 3.6), layout="constrained"), {"epochs": EPOCHS}
    axes = figure.subplots()
    for name, (_, colour) in OPTIMIZERS.items():
        losses = trained(name).losses
        axes.loglog(np.arange(1, EPOCHS + 1), losses, color=colour, label=name)
        reached = np.flatnonzero(losses < 0.005)
        numbers[_key(name)] = {
            "last": losses[-1],
            "reached": int(reached[0]) + 1 if len(reached) else "never",
            "worst_rise": float(np.max(losses[1:] / losses[:-1])),
        }
    axes.set(xlabel="epoch (one step, all 64 points)", ylabel="loss: half the mean squared error")
    axes.set_title("1 → 16 → 1, tanh, one start", fontsize=10)
    axes.legend(frameon=False, fontsize=9)
    return figure, numbers


def _key(name: str) -> str:
    """A name for numbers.

    Examples
    --------
    >>> _key("SGD, rate 0.3, momentum 0.9"), _key("SGD, rate 0.3"), _key("RPROP")
    ('momentum', 'sgd', 'rprop')
    """
    return "momentum" if "momentum" in name else name.split(",")[0].lower()


def path(optimizer: SGD | Adam | RPROP, steps: int) -> np.ndarray:
    """Where an optimizer goes on the bowl (x^2 + 0.04 y^2) / 2, (steps + 1, 2)."""
    parameters, places = {"w": START}, [START]
    state = optimizer.start(parameters)
    for _ in range(steps):
        parameters, state = optimizer.step(parameters, {"w": BOWL * parameters["w"]}, state)
        places.append(parameters["w"])
    return np.array(places)


def paths(steps: int) -> dict[str, np.ndarray]:
    """The paths of the four, each with a rate that suits the bowl."""
    return {
        "SGD, rate 1.8": path(SGD(1.8), steps),
        "SGD, rate 0.3, momentum 0.9": path(SGD(0.3, momentum=0.9), steps),
        "Adam, rate 0.3": path(Adam(0.3), steps),
        "RPROP, first 0.1": path(RPROP(first=0.1), steps),
    }


def slider_bowl() -> tuple[Slider, dict]:
    """Four optimizers in a long valley, step by step."""
    found = paths(FRAMES[-1])
    x, y = np.meshgrid(np.linspace(-2.2, 2.2, 120), np.linspace(-5, 5, 120))
    height = (BOWL[0] * x**2 + BOWL[1] * y**2) / 2

    def draw(steps: int) -> Figure:
        figure = Figure(figsize=(7.8, 3.2), layout="constrained")
        for axes, (name, places), (_, colour) in zip(
            figure.subplots(1, 4, sharey=True), found.items(), OPTIMIZERS.values(), strict=True
        ):
            axes.contour(x, y, height, np.geomspace(0.01, 3, 7), colors="#cccccc", linewidths=0.8)
            axes.plot(*places[: steps + 1].T, ".-", color=colour, markersize=4, linewidth=1)
            axes.plot(*places[steps], "o", color=colour, markersize=7)
            axes.plot(0, 0, "+", color="#222222")
            axes.set_title(name.replace(", momentum", ",\nmomentum"), fontsize=9)
            axes.set(xlabel="w₁", xlim=(-2.2, 2.2), ylim=(-5, 5))
        figure.axes[0].set_ylabel("w₂")
        return figure

    picture = slider(draw, title="A valley 25 times as steep across as along", start=20, steps=FRAMES)
    distance = {_key(name): np.hypot(*places.T)[list(FRAMES)] for name, places in found.items()}
    return picture, {"steps": list(FRAMES), "distance": distance, "ratio": BOWL[0] / BOWL[1]}


def loss_at_rate(rate: float, epochs: int = 300) -> tuple[float, bool]:
    """The loss after training with SGD, and whether it diverged (then that of the last good network)."""
    try:
        return train(*problem(), loss=SquaredError(), optimizer=SGD(rate), epochs=epochs).losses[-1], False
    except Diverged as error:
        network, x, target = error.training.network, *problem()[1:]
        return SquaredError().forward(network.forward(x)[0], target)[0], True


def rates() -> tuple[Figure, dict]:
    """Loss after 300 epochs over the rate; and one training that runs away, epoch by epoch."""
    tried = np.array([float(f"{rate:.2g}") for rate in np.geomspace(0.001, 30, 28)])
    found = [loss_at_rate(rate) for rate in tried]
    last, gone = (np.array(one) for one in zip(*found, strict=True))
    start = SquaredError().forward(problem()[0].forward(problem()[1])[0], problem()[2])[0]
    figure = Figure(figsize=(9.4, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.loglog(tried[~gone], last[~gone], "o-", color=BLUE, markersize=4, label="trained for 300 epochs")
    left.loglog(tried[gone], np.full(gone.sum(), 3.0), "x", color=RED, label="diverged")
    left.axhline(start, color=GREY, linewidth=0.8, linestyle=":", label="before")
    left.set(xlabel="rate of SGD", ylabel="loss", title="after 300 epochs")
    left.legend(frameon=False, fontsize=9)
    numbers = {"best_rate": tried[~gone][np.argmin(last[~gone])], "best": last[~gone].min(), "start": start}
    numbers |= {"first_diverged": tried[gone].min(), "slowest": last[0]}
    numbers |= {name: loss_at_rate(numbers["best_rate"] / k)[0] for name, k in (("tenth", 10), ("hundredth", 100))}
    for place, colour in ((np.argmin(last[~gone]), BLUE), (np.argmax(gone) - 1, PURPLE), (np.argmax(gone) + 1, RED)):
        rate = float(tried[place])
        try:
            losses = train(*problem(), loss=SquaredError(), optimizer=SGD(rate), epochs=300).losses
        except Diverged as error:
            losses = error.training.losses
            finite = [np.isfinite(one).all() for one in error.training.network.parameters.values()]
            numbers |= {
                "message": str(error),
                "epochs_kept": len(losses),
                "finite": all(finite),
                "last_kept": losses[-1],
            }
        right.loglog(np.arange(1, len(losses) + 1), losses, color=colour, label=f"rate {rate:.2g}")
    right.set(xlabel="epoch", ylabel="loss", title="three of the trainings")
    right.legend(frameon=False, fontsize=9)
    return figure, numbers


def on_the_way(epochs: tuple[int, ...]) -> dict[int, MLP]:
    """The network after some epochs of RPROP: training is nothing but this loop."""
    network, x, target = problem()
    optimizer, found = RPROP(), {}
    state = optimizer.start(network.parameters)
    for epoch in range(epochs[-1] + 1):
        if epoch in epochs:
            found[epoch] = network
        _, gradients = loss_and_gradients(network, x, target, SquaredError())
        parameters, state = optimizer.step(network.parameters, gradients, state)
        network = network.replace(parameters)
    return found


def slider_curve() -> tuple[Slider, dict]:
    """The function that a network computes, and its hidden units, after some epochs of RPROP."""
    _, x, target = problem()
    fine = np.linspace(-1, 1, 401)[:, np.newaxis]
    networks = on_the_way(SHOWN)
    losses = [SquaredError().forward(one.forward(x)[0], target)[0] for one in networks.values()]

    def draw(epoch: int) -> Figure:
        figure = Figure(figsize=(8.4, 3.6), layout="constrained")
        left, right = figure.subplots(1, 2)
        left.plot(x, target, "o", color=GREY, markersize=3.5, label="target")
        left.plot(fine, networks[epoch].forward(fine)[0], color=BLUE, label="network")
        left.set(xlabel="x", ylabel="y", ylim=(-1, 1.5), title="output")
        left.legend(frameon=False, fontsize=9, loc="upper left")
        first, activation, last = networks[epoch].layers
        hidden = activation.forward(first.forward(fine)[0])[0] * last.weight[0]
        right.plot(fine, hidden, linewidth=1, color=PURPLE, alpha=0.6)
        right.set(xlabel="x", ylim=(-1.2, 1.2), title="16 hidden units times their weights")
        return figure

    picture = slider(draw, title="A network 1 → 16 → 1 learns a curve with a step", start=400, epoch=SHOWN)
    return picture, {"epochs": list(SHOWN), "losses": losses}
