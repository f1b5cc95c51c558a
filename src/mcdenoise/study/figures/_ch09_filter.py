"""Chapter 09, the filter and its dials: the chain in one picture, weights of one pixel, one bandwidth for all pixels."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from mcdenoise.lbf import secondary_features, secondary_names, shipped_model
from mcdenoise.lbf.pixel import filter_pixel
from mcdenoise.metrics import relmse_map
from mcdenoise.study.display import tone_map
from mcdenoise.study.figures._ch04_data import error, error_picture, picture, plain
from mcdenoise.study.figures._ch09_data import (
    GREEN,
    PLACE_COLOURS,
    PLACES,
    PURPLE,
    VARIANTS,
    analysis,
    bandwidth_scale,
    effective,
    error_of,
    filtered,
    layer_of,
    neighbours,
    noisy,
    primary,
    sigma,
    widths_of,
)
from mcdenoise.study.figures._references import reference
from mcdenoise.study.slider import Slider, slider

GAMMAS = (0.3, 0.6, 1.2, 2.5, 5.0, 10.0, np.inf)  # standard deviations
ALPHA = 8.0  # pixels, beside them
WINDOW = 13  # pixels to each side that are shown of 27


def chain() -> tuple[Figure, dict]:
    """Features, network, bandwidths, filter, error: forward in green, the gradient back in purple."""
    model, found = shipped_model(), analysis("dof")
    shown = {
        0.0: ("samples", tone_map(noisy("dof"))),
        1.85: ("features", _mosaic()),
        5.1: ("bandwidths", bandwidth_scale().to_rgba(np.clip(_four_maps(found.bandwidths), 0.3, 30))),
        8.35: ("filtered", tone_map(found.image)),
    }
    figure = Figure(figsize=(9.8, 2.5))
    axes = figure.add_axes((0, 0, 1, 1))
    for left, (name, image) in shown.items():
        axes.imshow(image, extent=(left, left + 1.3, 0, 1.3), interpolation="nearest", zorder=2)
        axes.text(left + 0.65, 1.38, name, ha="center", fontsize=10)
    network = "-".join(map(str, widths_of(model)))
    for middle, text in ((4.15, f"network\n{network}"), (7.4, "filter"), (10.65, "error E")):
        axes.add_patch(FancyBboxPatch((middle - 0.42, 0.4), 0.84, 0.5, "round,pad=0.05", facecolor="white", zorder=2))
        axes.text(middle, 0.65, text, ha="center", va="center", fontsize=9.5, zorder=3)
    ways = ((1.3, 1.85), (3.15, 3.68), (4.62, 5.1), (6.4, 6.93), (7.87, 8.35), (9.65, 10.18))
    for start, end in ways:
        _arrow(axes, (start + 0.04, 0.8), (end - 0.04, 0.8), GREEN)
    backward = ((10.18, 9.65, "d_filtered"), (8.35, 7.87, ""), (6.93, 6.4, "d_theta"), (5.1, 4.62, ""))
    for start, end, name in backward:
        _arrow(axes, (start - 0.04, 0.5), (end + 0.04, 0.5), PURPLE)
        axes.text((start + end) / 2, -0.1, name, ha="center", va="top", fontsize=9, color=PURPLE)
    _arrow(axes, (4.15, 0.35), (4.15, -0.28), PURPLE)
    axes.text(4.15, -0.32, "d_weight", ha="center", va="top", fontsize=9, color=PURPLE)
    _arrow(axes, (10.65, -0.3), (10.65, 0.33), GREEN)
    axes.text(10.65, -0.34, "reference", ha="center", va="top", fontsize=9, color=GREEN)
    _bent(axes)
    axes.set(xlim=(-0.15, 11.25), ylim=(-0.6, 2.25), aspect="equal")
    axes.axis("off")
    weights = [one for name, one in model.network.parameters.items() if name.startswith("weight")]
    return figure, {
        "network": network,
        "parameters": model.network.size,
        "weights": sum(one.size for one in weights),
        "noisy": error(noisy("dof"), "dof"),
        "filtered": error_of("dof"),
    }


def _bent(axes: Axes) -> None:
    """The samples go into the filter, too."""
    axes.plot((0.65, 0.65, 7.4, 7.4), (1.62, 1.95, 1.95, 1.1), color=GREEN, linewidth=1.3)
    _arrow(axes, (7.4, 1.2), (7.4, 0.98), GREEN)
    axes.text(4.0, 2.0, "noisy colours, primary features", ha="center", va="bottom", fontsize=9, color=GREEN)


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], colour: str) -> None:
    """A straight arrow."""
    axes.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=11, color=colour, shrinkA=0, shrinkB=0))


def _mosaic() -> np.ndarray:
    """Four of the secondary features of dof, each on its own range."""
    values, names = secondary_features(primary("dof")), secondary_names(primary("dof").groups)
    tiles = []
    for name in ("mean albedo", "mad albedo", "std 7x7 world_position", "gradient shading_normal"):
        tile = np.sqrt(np.abs(values[::2, ::2, names.index(name)]))
        tiles.append(np.clip(tile / np.percentile(tile, 99), 0, 1))
    grey = np.block([[tiles[0], tiles[1]], [tiles[2], tiles[3]]])
    return np.repeat(grey[..., np.newaxis], 3, axis=-1)


def _four_maps(bandwidths: dict[str, np.ndarray]) -> np.ndarray:
    """Position and the first-hit features, every second pixel."""
    maps = [bandwidths[name][::2, ::2] for name in ("position", "world_position", "shading_normal", "albedo")]
    return np.block([[maps[0], maps[1]], [maps[2], maps[3]]])


def settings_of(place: tuple[int, int]) -> dict[str, np.ndarray]:
    """Theta of one pixel of dof: by position alone, with colour, with features, and the model's own."""
    names, (y, x) = layer_of("dof").names, place
    of = {name: k for k, name in enumerate(names)}
    near = np.zeros(len(names))
    near[0] = 1 / (2 * 4.0**2)
    colour, features = near.copy(), near.copy()
    colour[of["colour"]] = 0.5
    features[2:] = 1 / (2 * 2.0**2)
    return {
        "position, α = 4": near,
        "and colour, β = 1": colour,
        "and features, γ = 2": features,
        "the model's choice": np.array([analysis("dof").theta[name][y, x] for name in names], np.float64),
    }


def weights_of_one_pixel() -> tuple[Figure, dict]:
    """Filter weights of three pixels of dof under four settings."""
    figure, numbers = Figure(figsize=(9.8, 5.6), layout="constrained"), {}
    grid = figure.subplots(len(PLACES), 5)
    layer = layer_of("dof")
    for row, (place, (y, x)) in zip(grid, PLACES.items(), strict=True):
        distances, colours, window = neighbours(layer, y, x)
        part = tuple(np.s_[max(at - WINDOW, 0) : at + WINDOW + 1] for at in (y, x))
        inside = tuple(slice(a.start - b.start, a.stop - b.start) for a, b in zip(part, window, strict=True))
        picture(row[0], noisy("dof")[part], "noisy, 4 spp" if y == PLACES["texture in focus"][0] else "")
        row[0].plot(x - part[1].start, y - part[0].start, "s", markersize=7, fillstyle="none", color="#FF00FF")
        row[0].set_ylabel(place, fontsize=9.5)
        for spine in row[0].spines.values():
            spine.set(edgecolor=PLACE_COLOURS[place], linewidth=2.5)
        numbers[place.replace(" ", "_")] = {}
        for axes, (label, theta) in zip(row[1:], settings_of((y, x)).items(), strict=True):
            value, weights = filter_pixel(theta, distances.reshape(len(theta), -1), colours.reshape(-1, 3))
            shown = axes.imshow(weights.reshape(colours.shape[:2])[inside], vmin=0, vmax=1, cmap="viridis")
            off = pixel_error(value, reference("dof")[y, x])
            above = f"{label}\n" if row[0] is grid[0, 0] else ""
            plain(axes, f"{above}{effective(weights):.0f} pixels, error {small(off)}")
            axes.title.set_fontsize(8.8)
            key = label.split(",")[0].replace("and ", "").replace("the model's choice", "model")
            numbers[place.replace(" ", "_")][key] = {"pixels": effective(weights), "error": off, "theta": theta}
    figure.colorbar(shown, ax=grid[:, 1:], shrink=0.5, label="weight; that of the pixel itself is 1")
    return figure, numbers


def pixel_error(value: np.ndarray, truth: np.ndarray) -> float:
    """Relative squared error of one pixel.

    Examples
    --------
    >>> pixel_error(np.array([0.2, 0.0, 0.0]), np.array([0.1, 0.0, 0.0])).__round__(4)
    0.1667
    """
    truth = truth.astype(np.float64)
    return float(np.mean((value - truth) ** 2 / (truth**2 + 0.01)))


def small(value: float) -> str:
    """Four digits behind the point, or that it is less.

    Examples
    --------
    >>> small(0.01234), small(3e-6)
    ('0.0123', '< 0.0001')
    """
    return f"{value:.4f}" if value >= 5e-5 else "< 0.0001"


@cache
def with_gamma(gamma: float) -> np.ndarray:
    """Filtered dof with one bandwidth for all features of all pixels."""
    layer = layer_of("dof")
    theta = np.full(layer.shape, 1 / (2 * gamma**2))
    theta[..., 0], theta[..., 1] = 1 / (2 * ALPHA**2), 0.01
    return layer.forward(theta)[0]


def slider_gamma() -> tuple[Slider, dict]:
    """The same bandwidth of features at all pixels: image and error map."""
    maps = {gamma: relmse_map(with_gamma(gamma), reference("dof")).mean(axis=-1) for gamma in GAMMAS}
    stack = np.stack(list(maps.values()))

    def draw(gamma: float) -> Figure:
        figure = Figure(figsize=(8.4, 3.6), layout="constrained")
        left, middle, right = figure.subplots(1, 3)
        image = with_gamma(gamma)
        picture(left, image, f"filtered, relMSE {error(image, 'dof'):.4f}")
        error_picture(middle, image, "dof", 0.1)
        plain(middle, "its error")
        best = np.argmin(stack, axis=0) == GAMMAS.index(gamma)
        right.imshow(best, cmap="gray", vmin=0, vmax=1, interpolation="nearest")
        plain(right, f"best of the {len(GAMMAS)} here: {100 * best.mean():.0f} %")
        return figure

    shares = np.bincount(np.argmin(stack, axis=0).ravel(), minlength=len(GAMMAS)) / stack[0].size
    numbers = {
        "gammas": GAMMAS,
        "alpha": ALPHA,
        "errors": [float(one.mean()) for one in stack],
        "shares": 100 * shares,
        "each_its_best": stack.min(axis=0).mean(),
        "best": GAMMAS[int(np.argmin(stack.mean(axis=(1, 2))))],
        "sharp_best": GAMMAS[int(np.argmin(stack[:, 56:84, 56:80].mean(axis=(1, 2))))],
        "blurred_best": GAMMAS[int(np.argmin(stack[:, 100:124, 104:124].mean(axis=(1, 2))))],
    }
    title = f"dof, 4 spp: one γ for all features and all pixels (α = {ALPHA:g} pixels)"
    return slider(draw, title=title, unit="deviations", start=2.5, gamma=GAMMAS), numbers


def first_look() -> tuple[Figure, dict]:
    """Input, LBF with both filters, reference, at 4 spp."""
    images = {
        "input, 4 spp": noisy("dof"),
        "LBF, cross-bilateral": filtered("dof"),
        "LBF, NLM": filtered("dof", "nlm"),
        "reference, 4096 spp": reference("dof"),
    }
    figure, errors = Figure(figsize=(9.8, 2.95), layout="constrained"), []
    for axes, (title, image) in zip(figure.subplots(1, 4), images.items(), strict=True):
        off = error(image, "dof")
        picture(axes, image, title if image is reference("dof") else f"{title}\n{off:.4f}")
        errors.append(off)
    numbers = dict(zip(("noisy", "cross_bilateral", "nlm"), errors, strict=False))
    return figure, numbers | {f"beta_{variant}": beta(variant) for variant in VARIANTS}


def beta(variant: str) -> float:
    """Bandwidth of colour that a model chooses for dof, the median over the pixels."""
    return float(np.median(sigma(analysis("dof", variant).theta["colour"])))
