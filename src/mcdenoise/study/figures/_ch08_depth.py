"""Chapter 08, depth: gradients that vanish or explode, units that die, float32 beside float64."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.nn import MLP, SGD, Diverged, Layer, Linear, ReLU, Sigmoid, SquaredError, Tanh, loss_and_gradients, train
from mcdenoise.study.charts import COLOURS, GREY
from mcdenoise.study.figures._ch08_checks import relative_error

BLUE, RED, GREEN, PURPLE = COLOURS[:4]
DEPTHS = (1, 2, 4, 6, 8, 12, 16, 20)
GAINS = {0.5: ":", 1.0: "-", 2.0: "--"}
ACTIVATIONS = {"sigmoid": Sigmoid(), "tanh": Tanh(), "ReLU": ReLU()}
ACROSS = 32
DRAWS = 8


def first_gradient(depth: int, activation: Layer, gain: float) -> float:
    """|d_W| of the first layer for a random d_y of length 1 a row: root mean square over random networks."""
    squares = []
    for seed in range(DRAWS):
        rng = np.random.default_rng(seed)
        network = MLP.random([ACROSS] * (depth + 1) + [1], hidden=activation, rng=rng, gain=gain)
        x = rng.standard_normal((64, ACROSS))
        d_y = rng.standard_normal((64, 1)) / 64
        gradients = network.gradients(d_y, network.forward(x)[1])
        squares.append(np.sum(gradients["weight_1"] ** 2))
    return float(np.sqrt(np.mean(squares)))


def depth() -> tuple[Figure, dict]:
    """The first layer's gradient over the number of hidden layers, for three activations and three gains."""
    figure, numbers = Figure(figsize=(9.4, 3.5), layout="constrained"), {"depths": list(DEPTHS)}
    for axes, (name, activation) in zip(figure.subplots(1, 3, sharey=True), ACTIVATIONS.items(), strict=True):
        for (gain, style), colour in zip(GAINS.items(), (BLUE, GREEN, RED), strict=True):
            norms = np.array([first_gradient(one, activation, gain) for one in DEPTHS])
            axes.semilogy(DEPTHS, norms, style, marker=".", color=colour, label=f"gain {gain:g}")
            factor = (norms[-1] / norms[2]) ** (1 / (DEPTHS[-1] - DEPTHS[2]))
            numbers.setdefault(name, {})[f"{gain:g}"] = {"norms": norms, "factor": factor}
        axes.set(title=name, xlabel="hidden layers", xticks=(1, 4, 8, 12, 16, 20))
    norms = [first_gradient(one, ReLU(), np.sqrt(2)) for one in DEPTHS]
    figure.axes[2].semilogy(DEPTHS, norms, color=GREY, marker=".", label="gain √2")
    numbers["ReLU"]["root"] = {"norms": norms, "factor": (norms[-1] / norms[2]) ** (1 / (DEPTHS[-1] - DEPTHS[2]))}
    figure.axes[0].set_ylabel("|d_W| of the first layer")
    for axes in figure.axes:
        axes.legend(frameon=False, fontsize=8, loc="lower left")
    return figure, numbers


def share_dead(network: MLP, x: np.ndarray) -> float:
    """Share of the hidden units of the first layer that are 0 for every row."""
    first: Linear = network.layers[0]
    return float(np.mean((first.forward(x)[0] <= 0).all(axis=0)))


def after_training(rate: float, seed: int) -> tuple[float, float, bool]:
    """Share of dead units and the loss after 100 epochs of SGD, or where it diverged, and whether it did."""
    rng = np.random.default_rng(seed)
    network = MLP.random([2, 64, 1], hidden=ReLU(), rng=rng, gain=np.sqrt(2))
    x = rng.uniform(-1, 1, (256, 2))
    target = np.sin(3 * x[:, :1]) * x[:, 1:]
    try:
        done, gone = train(network, x, target, loss=SquaredError(), optimizer=SGD(rate), epochs=100).network, False
    except Diverged as error:
        done, gone = error.training.network, True
    return share_dead(done, x), SquaredError().forward(done.forward(x)[0], target)[0], gone


def dead() -> tuple[Figure, dict]:
    """The share of ReLU units that are 0 for all data: over the bias at the start, and over the rate of training."""
    biases = np.linspace(-3, 1, 17)
    rates = np.geomspace(0.01, 1, 9)
    rng = np.random.default_rng(0)
    network = MLP.random([2, 2000, 1], hidden=ReLU(), rng=rng, gain=np.sqrt(2))
    x = rng.uniform(-1, 1, (256, 2))
    start = [share_dead(network.replace({**network.parameters, "bias_1": np.full(2000, b)}), x) for b in biases]
    found, losses, gone = np.moveaxis([[after_training(rate, seed) for seed in range(5)] for rate in rates], -1, 0)
    figure = Figure(figsize=(9.4, 3.0), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    left.plot(biases, start, ".-", color=BLUE)
    left.set(xlabel="bias of all units at the start", ylabel="share of dead units", ylim=(-0.03, 1.03))
    left.set_title("before training, 2000 units", fontsize=10)
    right.set_title("after 100 epochs, 64 units, 5 starts", fontsize=10)
    right.semilogx(rates, found, ".", color=RED, alpha=0.4)
    right.semilogx(rates, found.mean(axis=1), color=RED)
    right.set(xlabel="rate of SGD")
    numbers = {"rates": rates, "shares": found.mean(axis=1), "losses": losses.mean(axis=1)}
    numbers |= {"trainings": gone.size, "diverged": int(gone.sum())}
    return figure, numbers | {"bias": biases, "by_bias": start}


def gradients_in(dtype: type, network: MLP, x: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The first layer's gradient, all computed in one dtype."""
    parameters = {name: one.astype(dtype) for name, one in network.parameters.items()}
    return loss_and_gradients(network.replace(parameters), x, target.astype(dtype), SquaredError())[1]["weight_1"]


def precision() -> tuple[Figure, dict]:
    """float32 gradients against float64: over depth, and over how far training has come."""
    rng = np.random.default_rng(0)
    x, target = rng.standard_normal((512, ACROSS)), rng.standard_normal((512, 1))
    by_depth = []
    for one in DEPTHS:
        network = MLP.random([ACROSS] * (one + 1) + [1], hidden=Tanh(), rng=np.random.default_rng(one))
        by_depth.append(_difference(network, x, target))
    small, y = MLP.random([ACROSS, 16, 1], hidden=Tanh(), rng=rng), np.sin(x[:, :1])
    done, sizes, by_loss = small, [], []
    for _ in range(12):
        sizes.append(float(np.linalg.norm(gradients_in(np.float64, done, x, y))))
        by_loss.append(_difference(done, x, y))
        done = train(done, x, y, loss=SquaredError(), optimizer=SGD(0.3, momentum=0.9), epochs=100).network
    figure = Figure(figsize=(9.4, 3.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.semilogy(DEPTHS, by_depth, "o-", color=BLUE)
    left.set(xlabel="hidden layers", ylabel="relative difference", xticks=(1, 4, 8, 12, 16, 20))
    left.set_title("untrained networks, tanh", fontsize=10)
    right.set_title("one network, every 100 epochs", fontsize=10)
    right.loglog(sizes, by_loss, "o-", color=RED)
    right.set(xlabel="size of the gradient (training goes right)")
    right.invert_xaxis()
    for axes in figure.axes:
        axes.axhline(float(np.finfo(np.float32).eps), color=GREY, linewidth=0.8, linestyle=":")
    return figure, {"by_depth": by_depth, "sizes": sizes, "by_loss": by_loss, "eps": float(np.finfo(np.float32).eps)}


def _difference(network: MLP, x: np.ndarray, target: np.ndarray) -> float:
    """|float32 - float64| / |float64| of the first layer's gradient."""
    exact = gradients_in(np.float64, network, x, target)
    return relative_error(gradients_in(np.float32, network, x, target), exact)
