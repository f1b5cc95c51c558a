"""Chapter 09, is the backward pass right? Each factor of the chain rule, and the whole of it, against differences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.lbf import LBFModel, primary_features
from mcdenoise.lbf.loss import Example, FilterLoss
from mcdenoise.lbf.pixel import filter_pixel, softplus_link
from mcdenoise.nn import Pair, check_gradient
from mcdenoise.nn.gradcheck import STEP
from mcdenoise.nn.layers import softplus
from mcdenoise.study.figures._ch04_data import samples
from mcdenoise.study.figures._ch09_data import (
    BLUE,
    GREEN,
    PURPLE,
    SPP,
)
from mcdenoise.study.figures._ch09_pixel import Chain, chain_at, last_bias, terms_of
from mcdenoise.study.figures._references import reference

STEPS = 10.0 ** np.arange(-11, 0.1, 0.5)
SIZE = (7, 6)  # pixels of the small image on which the whole chain is checked, borders included


def errors_over_step(function: Callable, x: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Relative error of central differences of `function` at x, for each of STEPS; `exact` has a row for each entry of x."""
    found = []
    for step in STEPS:
        rows = []
        for k in range(x.size):
            move = np.zeros(x.size)
            move[k] = step * max(abs(x.ravel()[k]), 1e-3)
            up, down = (np.asarray(function(x + s * move.reshape(x.shape))) for s in (1, -1))
            rows.append(((up - down) / (2 * move[k])).ravel())
        found.append(np.linalg.norm(np.array(rows) - exact.reshape(x.size, -1)) / np.linalg.norm(exact))
    return np.array(found)


def checks_of(chain: Chain) -> dict[str, np.ndarray]:
    """Relative error over the step, of each factor and of the whole chain (a weight of each hidden unit and output)."""
    found, used = terms_of(chain), chain.places
    _, theta, _ = chain.forward(chain.network)
    filtered, _ = filter_pixel(theta, chain.distances, chain.colours)
    z = np.log(np.expm1(theta[used]))
    name = last_bias(chain.network).replace("bias", "weight")
    weight = chain.network.parameters[name]

    def of_weight(changed: np.ndarray) -> float:
        return chain.forward(chain.network.replace({**chain.network.parameters, name: changed}))[0]

    return {
        "∂E/∂ĉ": errors_over_step(chain.error, filtered, found.d_filtered),
        "∂ĉ/∂θ": errors_over_step(
            lambda one: filter_pixel(one, chain.distances, chain.colours)[0], theta, found.filtered_by_theta
        ),
        "∂θ/∂z": errors_over_step(softplus, z, np.diag(softplus_link(np.ones(len(used)), theta[used]))),
        "∂E/∂w": errors_over_step(of_weight, weight, found.gradients[name]),
    }


def gradient_check() -> tuple[Figure, dict]:
    """Each factor of the chain rule against differences, over the step."""
    found = checks_of(chain_at())
    figure, numbers = Figure(figsize=(8.4, 3.7), layout="constrained"), {"check_gradient": whole_chain()}
    axes = figure.subplots()
    keys = ("error_by_filtered", "filtered_by_theta", "theta_by_z", "error_by_weight")
    for (label, errors), colour, key in zip(found.items(), (BLUE, GREEN, "#CCBB44", PURPLE), keys, strict=True):
        axes.loglog(STEPS, np.maximum(errors, 1e-16), "o-", color=colour, label=label, markersize=4)
        numbers[key] = {"best": errors.min(), "step": STEPS[int(errors.argmin())]}
    numbers |= {"weights": chain_at().network.size, "height": SIZE[0], "width": SIZE[1], "step": STEP}
    numbers["memory"] = memory()
    axes.set(
        title="each factor at one pixel of dof, against differences, float64",
        xlabel="step, as a share of the number that is changed",
        ylabel="relative error",
        ylim=(1e-14, 10),
    )
    axes.grid(color="#e5e5e5")
    axes.legend(frameon=False, fontsize=9, loc="lower left", ncols=2)
    return figure, numbers


def small_example(variant: str) -> tuple[LBFModel, Example]:
    """A small piece of dof whose windows are cut by the border, and an untrained model of float64."""
    found = primary_features(samples("dof", SPP).crop(62, 52, *SIZE))
    truth = reference("dof")[62 : 62 + SIZE[0], 52 : 52 + SIZE[1]]
    model = LBFModel.random(
        found.groups, hidden=[3], rng=np.random.default_rng(0), dtype=np.float64, variant=variant, radius=2,
        patch_radius=1, colour_theta=None,
    )  # fmt: skip
    layer = model.layer(found, engine="numpy")
    inputs = model.inputs(found).astype(np.float64)
    return model, Example(layer, inputs.reshape(-1, inputs.shape[-1]), truth.reshape(-1, 3).astype(np.float64))


def whole_chain() -> dict[str, float]:
    """Worst relative error of all parameters, through network and filter, on a small image; both variants."""
    found = {}
    for variant in ("cross_bilateral", "nlm"):
        model, example = small_example(variant)
        loss = FilterLoss(model, [example])

        def forward(loss=loss, model=model, example=example, **parameters: np.ndarray) -> tuple[float, tuple]:
            network = model.network.replace(parameters)
            y, saved = network.forward(example.inputs)
            value, saved_by_loss = loss.forward(y, example.target)
            return value, (network, saved, saved_by_loss)

        def backward(d_y: float, saved: tuple, loss=loss) -> dict[str, np.ndarray]:
            network, saved_by_network, saved_by_loss = saved
            return network.gradients(d_y * loss.backward(saved_by_loss), saved_by_network)

        found[variant] = check_gradient(Pair(forward, backward, "LBF"), dict(model.network.parameters), tolerance=1e-5)
    return found


def memory() -> dict[str, float]:
    """Megabytes for an image of 256 x 256: all weights of a window of 55 x 55, and what `forward` hands to `backward`."""
    pixels = 256 * 256
    return {"weights": 4 * pixels * 55**2 / 1e6, "saved": 4 * pixels * (7 + 3 + 1) / 1e6}
