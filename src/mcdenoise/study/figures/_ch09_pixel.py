"""Chapter 09, the chain rule at one pixel: a covariance, and what each factor is in numbers."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from mcdenoise.lbf import shipped_model
from mcdenoise.lbf.pixel import filter_pixel, filtered_by_theta, filtered_error_gradient, softplus_link
from mcdenoise.nn import MLP
from mcdenoise.study.charts import GREY
from mcdenoise.study.figures._ch09_data import (
    BLUE,
    GREEN,
    PLACES,
    RED,
    SPP,
    WORDS,
    layer_of,
    neighbours,
    primary,
)
from mcdenoise.study.figures._references import reference

EPSILON = 0.01


class Chain(NamedTuple):
    """Everything that the chain rule needs at one pixel, in float64.

    network : of the shipped model. x : (inputs,), normalised. columns : which of its outputs the scene's filter uses.
    names, theta : of the filter's dials, (m,). distances : (m, n), to the neighbours. colours : (n, 3), theirs.
    reference : (3,).
    """

    network: MLP
    x: np.ndarray
    columns: list[int]
    names: tuple[str, ...]
    theta: np.ndarray
    distances: np.ndarray
    colours: np.ndarray
    reference: np.ndarray

    def forward(self, network: MLP) -> tuple[float, np.ndarray, list]:
        """Error, theta of all dials, and what the network saved."""
        y, saved = network.forward(self.x[np.newaxis])
        theta = self.theta.copy()
        theta[self.places] = y[0, self.columns]
        filtered, _ = filter_pixel(theta, self.distances, self.colours)
        return self.error(filtered), theta, saved

    @property
    def places(self) -> list[int]:
        """Which dials are predicted."""
        outputs = shipped_model().outputs
        return [k for k, name in enumerate(self.names) if name in outputs]

    def error(self, filtered: np.ndarray) -> float:
        """E of this pixel."""
        return float(SPP / 2 * np.sum((filtered - self.reference) ** 2 / (self.reference**2 + EPSILON)))


@cache
def chain_at(place: tuple[int, int] = PLACES["out of focus"]) -> Chain:
    """The shipped model at one pixel of dof."""
    model, layer, (y, x) = shipped_model(), layer_of("dof"), place
    distances, colours, _ = neighbours(layer, y, x)
    network = model.network.replace({k: v.astype(np.float64) for k, v in model.network.parameters.items()})
    columns = [model.outputs.index(name) for name in layer.names if name in model.outputs]
    theta = model.theta(primary("dof"))[y, x].astype(np.float64)
    inputs = model.inputs(primary("dof"))[y, x].astype(np.float64)
    return Chain(
        network, inputs, columns, layer.names, theta, distances.reshape(len(theta), -1), colours.reshape(-1, 3),
        reference("dof")[y, x].astype(np.float64),
    )  # fmt: skip


class Terms(NamedTuple):
    """The factors of the chain rule, from left to right; `gradients` are those of all parameters of the network."""

    d_filtered: np.ndarray
    filtered_by_theta: np.ndarray
    d_theta: np.ndarray
    d_z: np.ndarray
    gradients: dict[str, np.ndarray]


def terms_of(chain: Chain) -> Terms:
    """The backward pass, one factor after the other."""
    _, theta, saved = chain.forward(chain.network)
    filtered, _ = filter_pixel(theta, chain.distances, chain.colours)
    d_filtered = filtered_error_gradient(filtered, chain.reference, SPP, EPSILON)
    by_theta = filtered_by_theta(theta, chain.distances, chain.colours)
    d_theta = by_theta @ d_filtered
    d_y = np.zeros((1, len(chain.network.parameters[last_bias(chain.network)])))
    d_y[0, chain.columns] = d_theta[chain.places]
    gradients = chain.network.gradients(d_y, saved)
    return Terms(d_filtered, by_theta, d_theta, softplus_link(d_theta, theta), gradients)


def last_bias(network: MLP) -> str:
    """The name of the last layer's bias."""
    return max((name for name in network.parameters if name.startswith("bias")), key=lambda name: int(name[5:]))


def covariance() -> tuple[Figure, dict]:
    """The neighbours of one pixel: their distance against their colour; the gradient is minus the weighted covariance."""
    chain = chain_at()
    _, theta, _ = chain.forward(chain.network)
    filtered, weights = filter_pixel(theta, chain.distances, chain.colours)
    by_theta, share = filtered_by_theta(theta, chain.distances, chain.colours), weights / weights.sum()
    figure, numbers = Figure(figsize=(9.4, 3.7), layout="constrained"), {}
    chosen, channel = ("position", "albedo"), int(np.argmax(np.abs(by_theta[0])))
    for axes, name in zip(figure.subplots(1, 2, sharey=True), chosen, strict=True):
        m = chain.names.index(name)
        distance, colour = chain.distances[m], chain.colours[:, channel]
        heavy = np.argsort(share)[-400:]
        axes.scatter(
            distance[heavy], colour[heavy], s=3 + 60 * share[heavy] / share.max(), color=BLUE, alpha=0.5,
            linewidths=0,
        )  # fmt: skip
        middle, far = share @ distance, np.argsort(distance)
        at = np.array([0.0, distance[far][np.searchsorted(np.cumsum(share[far]), 0.97)]])
        spread = share @ (distance - middle) ** 2
        line = filtered[channel] - by_theta[m, channel] / spread * (at - middle)
        axes.plot(at, line, color=RED, linewidth=2, label="weighted line of best fit")
        axes.axhline(filtered[channel], color=GREY, linewidth=1, linestyle=":", label="ĉ")
        axes.axhline(chain.reference[channel], color=GREEN, linewidth=1, linestyle="--", label="reference c")
        unit = "pixels²" if name == "position" else "in variances"
        axes.set(xlabel=f"distance E of {WORDS[name]}, {unit}", xlim=(-0.03 * at[1], 1.03 * at[1]),
                 ylim=np.quantile(colour[heavy], [0, 1]) + np.array([-0.05, 0.05]))  # fmt: skip
        axes.set_title(f"∂ĉ/∂θ = −covariance = {_short(by_theta[m, channel])}", fontsize=10)
        numbers[name] = {
            "gradient": by_theta[m, channel],
            "covariance": share @ (distance * (colour - filtered[channel])),
        }
    figure.axes[0].set_ylabel(f"colour of the neighbour, {('red', 'green', 'blue')[channel]}")
    figure.axes[0].legend(frameon=False, fontsize=8.5)
    numbers |= {"filtered": filtered[channel], "reference": chain.reference[channel]}
    return figure, numbers


def terms() -> tuple[Figure, dict]:
    """The factors of the chain rule at one pixel of dof, as matrices with their numbers."""
    chain = chain_at()
    found = terms_of(chain)
    error, theta, saved = chain.forward(chain.network)
    used, words = chain.places, [WORDS[chain.names[k]] for k in chain.places]
    hidden = saved[-2] if saved[-2].ndim == 2 else saved[-2][np.newaxis]
    figure = Figure(figsize=(9.8, 4.6), layout="constrained")
    grid = figure.subplot_mosaic(
        [["filtered", "by_theta", "d_theta", "link", "d_z"], ["last"] * 5],
        height_ratios=(3, 2),
        width_ratios=(1, 2.2, 1, 1, 1),
    )
    _matrix(grid["filtered"], found.d_filtered[:, np.newaxis], "∂E/∂ĉ", list("rgb"))
    _matrix(grid["by_theta"], found.filtered_by_theta[used], "∂ĉ/∂θ", words, list("rgb"))
    _matrix(grid["d_theta"], found.d_theta[used][:, np.newaxis], "∂E/∂θ", words)
    link = softplus_link(np.ones(len(used)), theta[used])
    _matrix(grid["link"], link[:, np.newaxis], "∂θ/∂z", words)
    _matrix(grid["d_z"], found.d_z[used][:, np.newaxis], "∂E/∂z", words)
    last = found.gradients[last_bias(chain.network).replace("bias", "weight")][chain.columns]
    _matrix(
        grid["last"], last, "∂E/∂w of the last layer: ∂E/∂z times the hidden units", words, range(1, last.shape[1] + 1)
    )
    return figure, {
        "error": error,
        "pixels": len(chain.colours),
        "theta": dict(zip([chain.names[k] for k in used], theta[used], strict=True)),
        "d_filtered": found.d_filtered,
        "d_theta": dict(zip([chain.names[k] for k in used], found.d_theta[used], strict=True)),
        "link": dict(zip([chain.names[k] for k in used], link, strict=True)),
        "d_z": dict(zip([chain.names[k] for k in used], found.d_z[used], strict=True)),
        "hidden": hidden.size,
    }


def _matrix(axes: Axes, values: np.ndarray, title: str, rows: list, columns: object = ()) -> None:
    """A matrix with its numbers; red is positive, blue negative, on its own range."""
    top = max(np.abs(values).max(), 1e-300)
    axes.imshow(values, cmap="RdBu_r", vmin=-1.6 * top, vmax=1.6 * top, aspect="auto")
    for (i, j), value in np.ndenumerate(values if values.shape[1] <= 14 else values[:, :0]):
        axes.text(j, i, _short(value), ha="center", va="center", fontsize=8)
        axes.add_patch(Rectangle((j - 0.5, i - 0.5), 1, 1, fill=False, edgecolor="white"))
    axes.set_yticks(range(len(rows)), rows, fontsize=8.5)
    axes.set_xticks(range(len(tuple(columns))), columns, fontsize=8.5)
    axes.tick_params(length=0)
    axes.set_title(title, fontsize=10)


def _short(value: float) -> str:
    """Two digits.

    Examples
    --------
    >>> _short(-0.03456), _short(123.4), _short(2e-7)
    ('−0.035', '123', '2.0e−7')
    """
    text = f"{value:.2g}" if 1e-3 <= abs(value) < 100 else f"{value:.0f}" if 100 <= abs(value) < 1e4 else f"{value:.1e}"
    return text.replace("e-0", "e-").replace("e+0", "e").replace("-", "−") if value else "0"
