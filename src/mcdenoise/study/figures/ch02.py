"""The figures of chapter 02: what the Gaussian filter does to a point, to a frequency, to an image, to noise, at borders."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.filters.gaussian import gaussian, gaussian_sums
from mcdenoise.metrics import relmse, relmse_map
from mcdenoise.study.charts import COLOURS, GREY
from mcdenoise.study.display import tone_map
from mcdenoise.study.figures._ch02_cost import make_cost, make_noise_left
from mcdenoise.study.figures._ch02_data import renders
from mcdenoise.study.figures._ch02_errors import make_best_sigma, make_error_sigma, make_fails
from mcdenoise.study.figures._references import reference
from mcdenoise.study.slider import Slider, slider

SHOWN_SIGMAS = (0.5, 1.0, 2.0, 4.0)
SLIDER_SIGMAS = (0.3, 0.4, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0)
BORDER_SIGMA = 2.0
DPI = 150  # of `save_figure`


def lecture_bell(distance: np.ndarray, sigma_space: float) -> np.ndarray:
    """G_sigma(x) of the lecture, with its constant: exp(-x^2 / (2 sigma^2)) / (2 pi sigma^2)."""
    return np.exp(-(distance**2) / (2 * sigma_space**2)) / (2 * np.pi * sigma_space**2)


def impulse_response(sigma_space: float, size: int = 61) -> np.ndarray:
    """Filter one bright pixel in the middle of a black image; window of 6 sigma, so that nothing is cut off."""
    image = np.zeros((size, size))
    image[size // 2, size // 2] = 1.0
    return gaussian(image, sigma_space=sigma_space, radius=int(np.ceil(6 * sigma_space)), engine="numpy")


def make_impulse() -> tuple[Figure, dict]:
    """Show the response to one bright pixel, its cut against the closed form, and two filters in a row."""
    figure = Figure(figsize=(10, 3.4), layout="constrained")
    plane, cut, row = figure.subplots(1, 3)
    x, fine = np.arange(61) - 30, np.linspace(-10, 10, 201)
    wide = impulse_response(2.0)
    shown = plane.imshow(wide[20:41, 20:41], extent=(-10.5, 10.5, 10.5, -10.5), cmap="viridis")
    figure.colorbar(shown, ax=plane, shrink=0.85)
    plane.set(xticks=range(-10, 11, 5), yticks=range(-10, 11, 5), xlabel="x (pixels)", ylabel="y (pixels)")
    plane.set_title("response to one bright pixel, sigma 2", fontsize=10)
    for sigma, colour in zip((1.0, 2.0, 4.0), COLOURS, strict=False):
        cut.plot(fine, lecture_bell(fine, sigma), color=colour)
        cut.plot(x, impulse_response(sigma)[30], "o", color=colour, markersize=4, label=f"sigma {sigma:g}")
    cut.set_title("a cut: filter (dots), closed form (lines)", fontsize=10)
    cut.legend(frameon=False)
    twice = gaussian(impulse_response(1.5), sigma_space=2.0, radius=12, engine="numpy")
    row.plot(fine, lecture_bell(fine, 2.5), color=COLOURS[3], label="closed form, sigma 2.5")
    row.plot(x, twice[30], "o", color=COLOURS[3], markersize=4, label="sigma 1.5, then sigma 2")
    row.set_title("two in a row: 1.5² + 2² = 2.5²", fontsize=10)
    row.legend(frameon=False, loc="upper center")
    for axes, top in ((cut, 0.18), (row, 0.034)):
        axes.set(xlabel="x (pixels)", xlim=(-10, 10), ylim=(0, top))
    numbers = {
        "peak_2": wide.max(),
        "closed_2": 1 / (8 * np.pi),
        "difference_2": np.abs(wide[30] - lecture_bell(x, 2.0)).max() / wide.max(),
        "difference_twice": np.abs(twice[30] - lecture_bell(x, 2.5)).max() / twice.max(),
        "mass": wide.sum(),
    }
    numbers |= {f"sum_{str(s).replace('.', '_')}": lecture_sum(s) for s in (0.3, 0.5, 1.0, 2.0)}
    return figure, numbers


def lecture_sum(sigma_space: float) -> float:
    """Return the sum of the lecture's weights, constant included, over the default window of 3 sigma."""
    d = np.arange(-np.ceil(3 * sigma_space), np.ceil(3 * sigma_space) + 1)
    return float(lecture_bell(np.hypot(*np.meshgrid(d, d)), sigma_space).sum())


def tiles(columns: int, rows: int, side: int, gap: int = 6, title: int = 28) -> tuple[Figure, list[Axes]]:
    """Return a figure of square axes of exactly `side` pixels when saved: whole factors keep noise sharp and PNGs small."""
    width, height = columns * (side + gap) + gap, rows * (side + title) + gap
    figure = Figure(figsize=(width / DPI, height / DPI))
    corners = [
        (gap + x * (side + gap), gap + y * (side + title)) for y in reversed(range(rows)) for x in range(columns)
    ]
    return figure, [figure.add_axes((x / width, y / height, side / width, side / height)) for x, y in corners]


def make_sigmas() -> tuple[Figure, dict]:
    """Show a part of the dof scene at 8 spp under growing sigma_space, beside its reference; relMSE of the whole image."""
    target, noisy, part = reference("dof"), renders("dof", 8)[0], slice(16, 112)
    images = {"8 spp": noisy} | {f"sigma {s:g}": gaussian(noisy, sigma_space=s) for s in SHOWN_SIGMAS}
    figure, grid = tiles(3, 2, side=3 * 96)
    numbers = {}
    for axes, (name, image) in zip(grid, (images | {"reference": target}).items(), strict=True):
        error = relmse(image, target)
        numbers[name.replace(" ", "_").replace(".", "_")] = error
        axes.imshow(tone_map(image[part, part]), interpolation="nearest")
        axes.axis("off")
        axes.set_title(
            "reference, 4096 spp" if name == "reference" else f"{name}: relMSE {error:.3f}", fontsize=8, pad=3
        )
    return figure, numbers


def make_sigma() -> tuple[Slider, dict]:
    """Put the dof scene under a slider of sigma_space."""
    target, noisy = reference("dof"), renders("dof", 8)[0]

    def draw(sigma_space: float) -> Figure:
        filtered = gaussian(noisy, sigma_space=sigma_space)
        figure = Figure(figsize=(6.4, 3.6), layout="constrained")
        left, right = figure.subplots(1, 2)
        left.imshow(tone_map(filtered), interpolation="nearest")
        left.set_title(f"sigma_space {sigma_space:g}: relMSE {relmse(filtered, target):.4f}", fontsize=10)
        right.imshow(relmse_map(filtered, target).mean(-1), cmap="magma", vmin=0, vmax=0.3, interpolation="nearest")
        right.set_title("relative squared error (0 to 0.3)", fontsize=10)
        for axes in (left, right):
            axes.set(xticks=[], yticks=[])
        return figure

    errors = {str(s).replace(".", "_"): relmse(gaussian(noisy, sigma_space=s), target) for s in SLIDER_SIGMAS}
    return slider(draw, title="dof, 8 spp", sigma_space=SLIDER_SIGMAS), errors


def make_frequency() -> tuple[Figure, dict]:
    """Show what the filter leaves of each frequency: a zone plate before and after, and the response."""
    y, x = np.mgrid[-48:49, -48:49]
    plate = 0.5 + 0.5 * np.cos(0.45 * np.pi * (x**2 + y**2) / 48)
    figure = Figure(figsize=(9.2, 3.3), layout="constrained")
    before, after, chart = figure.subplots(1, 3)
    shown = {"rings, finer and finer": plate, "the same after sigma 2": gaussian(plate, sigma_space=2.0)}
    for axes, (name, image) in zip((before, after), shown.items(), strict=True):
        axes.imshow(image, cmap="gray", vmin=0, vmax=1, interpolation="nearest")
        axes.set(xticks=[], yticks=[], title=name)
    frequency = np.fft.rfftfreq(61)
    numbers = {}
    for sigma, colour in zip((0.5, 1.0, 2.0), COLOURS, strict=False):
        response = np.abs(np.fft.rfft(impulse_response(sigma).sum(axis=0)))
        formula = np.exp(-2 * np.pi**2 * sigma**2 * frequency**2)
        chart.plot(frequency, formula, color=colour)
        chart.plot(frequency, response, "o", color=colour, markersize=4, label=f"sigma {sigma:g}")
        numbers[f"difference_{str(sigma).replace('.', '_')}"] = np.abs(response - formula).max()
    chart.set(title="amplitude that is left", xlabel="frequency (cycles per pixel)", xlim=(0, 0.5), ylim=(0, 1.3))
    chart.legend(frameon=False, title="filter: dots, formula: lines", ncol=3, columnspacing=0.8, handletextpad=0.1)
    numbers["half_times_sigma"] = np.sqrt(np.log(2) / 2) / np.pi
    return figure, numbers


def at_borders(image: np.ndarray, sigma_space: float) -> dict[str, np.ndarray]:
    """Filter with three ideas of what lies outside: black, nothing (clip and divide by norm), the mirrored image."""
    margin = int(np.ceil(3 * sigma_space))
    around, inside = ((margin, margin), (margin, margin), (0, 0)), slice(margin, -margin)

    def padded(mode: str) -> np.ndarray:
        return gaussian(np.pad(image, around, mode=mode), sigma_space=sigma_space)[inside, inside]

    return {
        "black outside": padded("constant"),
        "nothing outside (ours)": gaussian(image, sigma_space=sigma_space),
        "mirror outside": padded("symmetric"),
    }


def make_borders() -> tuple[Figure, dict]:
    """Show what three treatments of the border do to a flat image and to a render, and the closed form of norm."""
    sigma, radius, corner = BORDER_SIGMA, int(np.ceil(3 * BORDER_SIGMA)), slice(80, None)
    flat, noisy, target = np.full((128, 128, 3), 0.5), renders("dof", 8)[0], reference("dof")
    figure = Figure(figsize=(9, 4.7), layout="constrained")
    grid = figure.subplots(2, 4, width_ratios=(1, 1, 1, 1.35))
    band, numbers = np.ones((128, 128), bool), {}
    band[radius:-radius, radius:-radius] = False
    renderings = at_borders(noisy, sigma)
    for column, short, (name, even) in zip(
        grid[:, :3].T, ("black", "ours", "mirror"), at_borders(flat, sigma).items(), strict=True
    ):
        numbers[f"band_{short}"] = relmse_map(renderings[name], target)[band].mean()
        numbers[f"flat_{short}"] = even[-1, -1, 0] / 0.5
        column[0].imshow(tone_map(even[corner, corner]), interpolation="nearest")
        column[0].set_title(name, fontsize=10)
        column[1].imshow(tone_map(renderings[name][corner, corner]), interpolation="nearest")
        column[1].set_title(f"relMSE along the border: {numbers[f'band_{short}']:.4f}", fontsize=8)
        for axes in column:
            axes.set(xticks=[], yticks=[])
    for axes, name in zip(grid[:, 0], ("flat grey, a corner", "dof, the same corner"), strict=True):
        axes.set_ylabel(name)
    whole = np.exp(-(np.arange(-radius, radius + 1) ** 2) / (2 * sigma**2)).sum()
    numbers["edge"], numbers["corner"] = (whole + 1) / (2 * whole), ((whole + 1) / (2 * whole)) ** 2
    norm = gaussian_sums(flat, sigma, radius)[1] / whole**2
    chart, empty = grid[:, 3]
    empty.axis("off")
    chart.plot(norm[64, :11], color=COLOURS[0], label="towards an edge")
    chart.plot(np.diagonal(norm)[:11], color=COLOURS[1], label="towards a corner")
    chart.plot([0, 0], [numbers["edge"], numbers["corner"]], "o", color=GREY, label="closed form", clip_on=False)
    chart.set(xlabel="distance from the border (pixels)", xlim=(0, 10), ylim=(0, 1.05))
    chart.set_title("norm, as a share of norm inside", fontsize=10)
    chart.legend(frameon=False, loc="lower right")
    figure.suptitle(f"What lies outside? sigma_space {sigma:g}")
    return figure, numbers | {"measured_corner": norm[0, 0]}


FIGURES = {
    "impulse": make_impulse,
    "sigmas": make_sigmas,
    "sigma": make_sigma,
    "frequency": make_frequency,
    "noise_left": make_noise_left,
    "cost": make_cost,
    "error_sigma": make_error_sigma,
    "best_sigma": make_best_sigma,
    "fails": make_fails,
    "borders": make_borders,
}
