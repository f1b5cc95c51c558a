"""Chapter 06, figures of single pixels: which samples are drawn, kept, left out, and how much each counts."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mcdenoise.rpf import RPFConfig, rpf_neighbourhood
from mcdenoise.rpf.analysis import Neighbourhood
from mcdenoise.study.display import tone_map
from mcdenoise.study.figures._ch04_data import noisy, picture, plain, samples
from mcdenoise.study.figures._ch05_data import PLACES
from mcdenoise.study.figures._ch05_neighbourhood import PANELS
from mcdenoise.study.figures._ch06_data import ADAPTIVE, NO_SPIKES
from mcdenoise.study.slider import Slider, slider

PASS = 2  # the box of 17 pixels
PIXELS = {"in focus": (70, 60), "edge in focus": (67, 57), "out of focus": (108, 112), "disc of a lamp": (12, 58)}
WINDOW = 17
BETAS = (0.0, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0)


@cache
def chosen(place: str, config: RPFConfig, turn: int = PASS) -> Neighbourhood:
    """What RPF looks at for one pixel of dof."""
    return rpf_neighbourhood(samples("dof"), PIXELS.get(place) or PLACES[place], config, turn)


def choose() -> tuple[Figure, dict]:
    """The samples that the four passes draw for one pixel."""
    figure, numbers = Figure(figsize=(9.8, 3.1), layout="constrained"), {}
    for turn, (axes, box) in enumerate(zip(figure.subplots(1, 4), NO_SPIKES.boxes, strict=True)):
        found = chosen("in focus", NO_SPIKES, turn)
        picture(axes, noisy("dof"), f"box {box}: M = {len(found.places)}")
        x, y = (found.position - 0.5).T
        for keep, colour in ((~found.accepted, "#EE6677"), (found.accepted, "#00FFFF")):
            axes.plot(x[keep], y[keep], ".", markersize=2.5, color=colour)
        row, column = PIXELS["in focus"]
        axes.set(xlim=(column - 30, column + 30), ylim=(row + 30, row - 30))
        numbers[f"box_{box}"] = {"drawn": len(found.places), "kept": 100 * found.accepted.mean()}
    return figure, numbers


def panels_focus() -> tuple[Figure, dict]:
    """The samples of one neighbourhood in focus in six spaces: kept, with their weights, or left out."""
    return _panels("in focus")


def panels_blurred() -> tuple[Figure, dict]:
    """The same, out of focus."""
    return _panels("out of focus")


def _panels(place: str) -> tuple[Figure, dict]:
    """Six scatter plots: size is the mean weight with the pixel's samples, a cross was left out by the clustering."""
    found = chosen(place, NO_SPIKES)
    weights = found.weights.mean(axis=0)
    weights = weights / weights.max()
    figure = Figure(figsize=(9.4, 5.5), layout="constrained")
    y, x = found.pixel
    kept = found.accepted
    figure.suptitle(
        f"{place}: row {y}, column {x}, box 17; of {len(kept)} samples {kept.sum()} kept (discs: area is weight), "
        f"{(~kept).sum()} left out (crosses)",
        fontsize=10.5,
    )
    colours = tone_map(found.radiance[np.newaxis])[0]
    for axes, (title, (first, second, xlabel, ylabel)) in zip(figure.subplots(2, 3).flat, PANELS.items(), strict=True):
        a, b = _column(found, *first), _column(found, *second)
        axes.scatter(a[~kept], b[~kept], marker="x", c="#AAAAAA", s=9, linewidths=0.7)
        axes.scatter(a[kept], b[kept], c=colours[kept], s=2 + 26 * weights[kept], edgecolors="#333333", linewidths=0.35)
        spp = len(found.weights)
        axes.scatter(a[:spp], b[:spp], s=60, facecolors="none", edgecolors="#FF00FF", linewidths=1.1)
        axes.set(xlabel=xlabel, ylabel=ylabel)
        axes.set_title(title, fontsize=10)
        axes.xaxis.set_major_locator(MaxNLocator(4))
    figure.axes[0].invert_yaxis()
    figure.axes[4].set(xlim=(-0.05, 1), ylim=(-0.05, 1))
    return figure, {
        "drawn": len(kept),
        "kept": int(kept.sum()),
        "left_out": int((~kept).sum()),
        "effective": effective(found.weights),
        "share": found.share_c_r.mean(),
        "alpha": found.alpha,
        "unseen": 100 * unseen(found).mean(),
        "unseen_kept": 100 * unseen(found)[kept].mean(),
    }


def unseen(found: Neighbourhood) -> np.ndarray:
    """Which samples have an albedo that none of the pixel's own samples has, (n,) bool."""
    own = found["albedo"][: len(found.weights)]
    return np.abs(found["albedo"][:, np.newaxis] - own).sum(axis=-1).min(axis=1) > 0.1


def _column(found: Neighbourhood, name: str, axis: int) -> np.ndarray:
    """One variable of all samples."""
    if name in ("screen_position", "radiance"):
        return (found.position if name == "screen_position" else found.radiance)[:, axis]
    values = found[name]
    return values if values.ndim == 1 else values[:, axis]


def effective(weights: np.ndarray) -> float:
    """How many samples of equal weight would average noise as well: (sum w)^2 / sum w^2, mean over the pixel's samples.

    Examples
    --------
    >>> effective(np.array([[1.0, 1.0, 0.0]]))
    2.0
    """
    return float((weights.sum(axis=1) ** 2 / (weights**2).sum(axis=1)).mean())


def weight_map(found: Neighbourhood, side: int = WINDOW) -> np.ndarray:
    """Sum of the weights of the samples of each pixel around, mean over the pixel's own samples; its own pixel is 1."""
    total = np.zeros((side, side))
    places = found.places[:, :2] - np.array(found.pixel) + side // 2
    np.add.at(total, tuple(places.T), found.weights.mean(axis=0))
    return total / total[side // 2, side // 2]


def screen_weights() -> tuple[Figure, dict]:
    """Weights of four pixels on the screen: every sample of a box, with the spatial factor."""
    every = {"deterministic": True, "boxes": (WINDOW,), "sample_fraction": 1.0}
    configs = {
        "report": RPFConfig.technical_report(spikes="none", clustering=False, **every),
        "report,\nclustering": RPFConfig.technical_report(spikes="none", **every),
        "adaptive": ADAPTIVE,
    }
    figure, numbers = Figure(figsize=(8.8, 8.4), layout="constrained"), {}
    grid = figure.subplots(4, 4)
    for column, (place, (y, x)) in enumerate(PIXELS.items()):
        half = WINDOW // 2
        picture(grid[0, column], noisy("dof")[y - half : y + half + 1, x - half : x + half + 1], place)
        grid[0, column].plot(half, half, "s", markersize=8, fillstyle="none", color="#FF00FF", markeredgewidth=1.5)
        numbers[place.replace(" ", "_")] = {}
        for axes, (label, config) in zip(grid[1:, column], configs.items(), strict=True):
            found = chosen(place, config, 0)
            shown = axes.imshow(weight_map(found), vmin=0, vmax=1, cmap="viridis")
            plain(axes, f"{effective(found.weights):.0f} samples")
            name = label.replace(",\n", "_")
            numbers[place.replace(" ", "_")][name] = effective(found.weights)
            if column == 0:
                axes.set_ylabel(label)
    figure.colorbar(shown, ax=grid[1:], shrink=0.5, label="weight, relative to the pixel itself")
    return figure, numbers


def slider_beta() -> tuple[Slider, dict]:
    """Weights on the screen while beta, the say of the features, grows."""
    every = {"deterministic": True, "boxes": (WINDOW,), "sample_fraction": 1.0, "alpha": 0.0}
    places = ("edge in focus", "out of focus")
    configs = {beta: RPFConfig.technical_report(spikes="none", clustering=False, beta=beta, **every) for beta in BETAS}

    def draw(beta: float) -> Figure:
        figure = Figure(figsize=(9.0, 2.9), layout="constrained")
        grid = figure.subplots(1, 4)
        for k, place in enumerate(places):
            (y, x), half, found = PIXELS[place], WINDOW // 2, chosen(place, configs[beta], 0)
            picture(grid[2 * k], noisy("dof")[y - half : y + half + 1, x - half : x + half + 1], place)
            _show_weights(grid[2 * k + 1], found)
        return figure

    numbers = {"betas": BETAS}
    for place in places:
        numbers[place.replace(" ", "_")] = [effective(chosen(place, config, 0).weights) for config in configs.values()]
    return slider(
        draw, title="Weights of features alone (alpha = 0), box of 17 x 17 pixels", start=0.03, beta=BETAS
    ), numbers


def _show_weights(axes: Axes, found: Neighbourhood) -> None:
    """A weight map, and how many samples it amounts to."""
    axes.imshow(weight_map(found), vmin=0, vmax=1, cmap="viridis")
    plain(axes, f"weights: {effective(found.weights):.0f} samples")
