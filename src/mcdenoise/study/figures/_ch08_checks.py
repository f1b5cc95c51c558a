"""Chapter 08, gradient checks: how long a step, kinks, what typical faults look like, float32."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.nn import MLP, GradientError, Pair, ReLU, SquaredError, check_gradient, loss_and_gradients
from mcdenoise.nn.gradcheck import STEP
from mcdenoise.study.charts import COLOURS, GREY

BLUE, RED, GREEN, PURPLE = COLOURS[:4]
STEPS = 10.0 ** np.arange(-15, 0.1, 0.25)


def numerical(step: float, dtype: type, central: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """Gradient of the loss of a small network for its first weights: by differences, and by the backward pass."""
    rng = np.random.default_rng(0)
    network = MLP.random([3, 5, 1], rng=rng)
    x, target = rng.standard_normal((20, 3)), rng.standard_normal((20, 1))
    exact = loss_and_gradients(network, x, target, SquaredError())[1]["weight_1"]
    weight = network.parameters["weight_1"].astype(dtype)

    def loss(changed: np.ndarray) -> np.floating:
        parameters = {name: one.astype(dtype) for name, one in network.parameters.items()}
        y = network.replace(parameters | {"weight_1": changed}).forward(x)[0]
        return np.sum((y - target.astype(dtype)) ** 2, dtype=dtype) / dtype(2 * len(x))

    found = np.empty_like(exact)
    for place in np.ndindex(weight.shape):
        up, down = weight.copy(), weight.copy()
        up[place] += dtype(step)
        down[place] -= dtype(step) if central else 0
        found[place] = (loss(up) - loss(down)) / dtype(2 * step if central else step)
    return found, exact


def relative_error(found: np.ndarray, exact: np.ndarray) -> float:
    """|found - exact| / |exact|, lengths of vectors."""
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact))


def step() -> tuple[Figure, dict]:
    """The error of a difference over its step: rounding on the left, curvature on the right."""
    kinds = {
        "central, float64": (np.float64, True, BLUE),
        "forward, float64": (np.float64, False, GREEN),
        "central, float32": (np.float32, True, RED),
    }
    figure, numbers = Figure(figsize=(8.4, 3.8), layout="constrained"), {"ours": STEP}
    axes = figure.subplots()
    for label, (dtype, central, colour) in kinds.items():
        steps = STEPS if dtype is np.float64 else STEPS[STEPS > 1e-7]
        errors = np.array([relative_error(*numerical(one, dtype, central)) for one in steps])
        axes.loglog(steps, errors, ".-", color=colour, label=label, markersize=4)
        best = int(np.argmin(errors))
        numbers[label.replace(", ", "_")] = {"best_step": steps[best], "best": errors[best]}
        if label == "central, float64":
            far = (steps > 1e-3) & (steps < 0.2)
            numbers["power"] = np.polyfit(np.log(steps[far]), np.log(errors[far]), 1)[0]
    axes.axvline(STEP, color=GREY, linewidth=0.9, linestyle=":")
    axes.text(STEP * 1.2, 3e-1, "check_gradient", color=GREY, fontsize=9)
    axes.set(
        title="gradient of the first weights, a network 3 → 5 → 1",
        xlabel="step h",
        ylabel="relative error of the difference",
        ylim=(1e-12, 10),
    )
    axes.legend(frameon=False, fontsize=9, loc="lower left")
    return figure, numbers


def kinks() -> tuple[Figure, dict]:
    """The difference quotient of a ReLU near its kink, for three steps."""
    x = np.linspace(-0.3, 0.3, 601)
    figure = Figure(figsize=(8.4, 2.9), layout="constrained")
    axes = figure.subplots()
    for h, colour in ((0.2, PURPLE), (0.1, RED), (0.02, BLUE)):
        axes.plot(x, (np.maximum(x + h, 0) - np.maximum(x - h, 0)) / (2 * h), color=colour, label=f"h = {h:g}")
    axes.plot(x, x > 0, color="#222222", linewidth=1, linestyle="--", label="backward pass")
    axes.set(title="(f(x + h) − f(x − h)) / 2h of a ReLU", xlabel="x", ylabel="derivative")
    axes.legend(frameon=False, fontsize=9)
    numbers = {"at_kink": (max(STEP, 0) - max(-STEP, 0)) / (2 * STEP)}
    try:
        check_gradient(ReLU(), {"x": [[1.0, 0.0]]})
    except GradientError as error:
        numbers["message"] = str(error)
    numbers["away"] = check_gradient(ReLU(), {"x": [[1.0, -1e-3]]})
    rng = np.random.default_rng(0)
    near = np.abs(rng.standard_normal((100_000, 10))) < STEP
    numbers["share_near"] = near.mean()
    return figure, numbers


def forward(x: np.ndarray, weight: np.ndarray, bias: np.ndarray) -> tuple[np.ndarray, tuple]:
    """tanh(x W^T + b), and what its backward pass needs."""
    y = np.tanh(x @ weight.T + bias)
    return y, (x, weight, y)


def right(d_y: np.ndarray, saved: tuple) -> dict[str, np.ndarray]:
    """The backward pass as it should be."""
    x, weight, y = saved
    d_a = d_y * (1 - y**2)
    return {"x": d_a @ weight, "weight": d_a.T @ x, "bias": d_a.sum(axis=0)}


def _wrong_sign(d_y: np.ndarray, saved: tuple) -> dict[str, np.ndarray]:
    found = right(d_y, saved)
    return found | {"weight": -found["weight"]}


def _mean_of_rows(d_y: np.ndarray, saved: tuple) -> dict[str, np.ndarray]:
    found = right(d_y, saved)
    return found | {"weight": found["weight"] / len(d_y)}


def _transposed(d_y: np.ndarray, saved: tuple) -> dict[str, np.ndarray]:
    found = right(d_y, saved)
    return found | {"weight": found["weight"].T}


def _no_local(d_y: np.ndarray, saved: tuple) -> dict[str, np.ndarray]:
    x, weight, _ = saved
    return {"x": d_y @ weight, "weight": d_y.T @ x, "bias": d_y.sum(axis=0)}


def _no_upstream(d_y: np.ndarray, saved: tuple) -> dict[str, np.ndarray]:
    return right(np.ones_like(d_y), saved)


FAULTS: dict[str, Callable] = {
    "wrong sign": _wrong_sign,
    "mean in place of sum": _mean_of_rows,
    "transposed": _transposed,
    "local gradient forgotten": _no_local,
    "upstream gradient forgotten": _no_upstream,
}


def message_of(backward: Callable) -> str:
    """What check_gradient says; empty if it finds no fault."""
    rng = np.random.default_rng(1)
    inputs = {"weight": rng.standard_normal((3, 3)), "x": rng.standard_normal((8, 3)), "bias": rng.standard_normal(3)}
    try:
        check_gradient(Pair(forward, backward, "layer"), inputs)
    except GradientError as error:
        return str(error)
    return ""


def faults() -> tuple[Figure, dict]:
    """Five faults: each entry of d_W as received, against what differences expect."""
    rng = np.random.default_rng(6)
    weight, x, bias = rng.standard_normal((3, 3)), rng.standard_normal((8, 3)), rng.standard_normal(3)
    d_y = rng.standard_normal((8, 3))
    saved = forward(x, weight, bias)[1]
    expected = right(d_y, saved)["weight"].ravel()
    figure = Figure(figsize=(9.4, 2.6), layout="constrained")
    ends = 1.15 * np.abs(expected).max() * np.array([-1, 1])
    for axes, (name, backward) in zip(figure.subplots(1, 5, sharey=True), FAULTS.items(), strict=True):
        axes.plot(ends, ends, color=GREY, linewidth=0.8)
        axes.plot(expected, backward(d_y, saved)["weight"].ravel(), "o", color=RED, markersize=4)
        axes.set(xlabel="expected", xlim=ends, ylim=2 * ends, box_aspect=1)
        axes.set_title(name.replace(" gradient", "\ngradient").replace(" in place", "\nin place"), fontsize=9)
    figure.axes[0].set_ylabel("received")
    messages = {name.replace(" ", "_"): message_of(backward) for name, backward in FAULTS.items()}
    return figure, {**messages, "right": message_of(right) == ""}
