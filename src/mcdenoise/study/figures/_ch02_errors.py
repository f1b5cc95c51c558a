"""Chapter 02, blur against noise: the error over sigma_space, its best value over spp, and where the filter fails."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from mcdenoise.filters import gaussian
from mcdenoise.metrics import relmse, relmse_map
from mcdenoise.study.charts import COLOURS, GREY, MARKERS
from mcdenoise.study.display import error_colours, error_scale, tone_map
from mcdenoise.study.figures._ch02_data import SCENES, error_curves, renders, unfiltered_error
from mcdenoise.study.figures._references import reference

SIGMAS = np.geomspace(0.25, 4, 41)
SPP = (2, 8, 32)
TOTAL, BLUR, NOISE = COLOURS[0], COLOURS[1], COLOURS[2]


@cache
def curves_of(scene: str, spp: int) -> np.ndarray:
    """Return `error_curves` over SIGMAS, computed once."""
    return error_curves(scene, spp, SIGMAS)


def best_of(scene: str, spp: int) -> tuple[float, float]:
    """Return the sigma_space of SIGMAS with the smallest relMSE, and that relMSE."""
    total = curves_of(scene, spp)[0]
    return float(SIGMAS[total.argmin()]), float(total.min())


def plain_log(axes: Axes, *, subs: tuple[float, ...] = (1, 2, 5)) -> None:
    """Make both axes logarithmic with plain numbers and a light grid."""
    axes.set(xscale="log", yscale="log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=subs))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.grid(visible=True, color="#e5e5e5", linewidth=0.6)
    axes.set_axisbelow(True)


def make_error_sigma() -> tuple[Figure, dict]:
    """Chart relMSE over sigma_space with its two parts, on the five scenes at 8 spp; minima marked."""
    figure = Figure(figsize=(8.6, 5.2), layout="constrained")
    grid = figure.subplots(2, 3, sharex=True, sharey=True)
    numbers = {"spp": 8}
    for axes, scene in zip(grid.flat, SCENES, strict=False):
        total, blur, noise = curves_of(scene, 8)
        unfiltered, (best, least) = unfiltered_error(scene, 8), best_of(scene, 8)
        axes.axhline(unfiltered, color=GREY, linestyle="--", label="unfiltered")
        axes.plot(SIGMAS, noise, color=NOISE, label="noise that is left (variance)")
        axes.plot(SIGMAS, blur, color=BLUR, label="blur (bias²)")
        axes.plot(SIGMAS, total, color=TOTAL, linewidth=2.4, label="relMSE: the sum")
        axes.plot(best, least, "o", color=TOTAL, markersize=9)
        axes.set_title(f"{scene}: {unfiltered:.2g} → {least:.2g} at {best:.2f}", fontsize=10)
        plain_log(axes)
        axes.set_ylim(2e-4, 0.5)
        numbers[f"best_{scene}"], numbers[f"least_{scene}"] = best, least
        numbers[f"unfiltered_{scene}"], numbers[f"gain_{scene}"] = unfiltered, unfiltered / least
        numbers[f"half_{scene}"] = float(np.interp(0.5, SIGMAS, total))
        numbers[f"cross_{scene}"] = float(np.abs(total - blur - noise).max() / total.max())
    for axes in grid[-1]:
        axes.set_xlabel("sigma_space (pixels)")
    for axes in grid[:, 0]:
        axes.set_ylabel("relMSE")
    grid[0, 2].tick_params(labelbottom=True)
    grid[-1, -1].axis("off")
    grid[-1, -1].legend(*grid[0, 0].get_legend_handles_labels(), loc="center", frameon=False, fontsize=11)
    figure.suptitle("Blur against noise: the error of the Gaussian filter over sigma_space, 128 x 128 pixels, 8 spp")
    return figure, numbers


def make_best_sigma() -> tuple[Figure, dict]:
    """Chart how the curve and its minimum move when there are more samples."""
    figure = Figure(figsize=(8.8, 3.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    for spp, colour in zip(SPP, COLOURS, strict=False):
        total, (best, least) = curves_of("dof", spp)[0], best_of("dof", spp)
        left.plot(SIGMAS, total, color=colour, label=f"{spp} spp: best at {best:.2g}")
        left.plot(best, least, "o", color=colour, markersize=8)
    left.set(title="dof: relMSE over sigma_space", xlabel="sigma_space (pixels)", ylabel="relMSE")
    plain_log(left)
    left.legend(frameon=False)
    numbers = {}
    for scene, colour, marker in zip(SCENES, COLOURS, MARKERS, strict=False):
        best = [best_of(scene, spp)[0] for spp in SPP]
        slope = float(np.polyfit(np.log(SPP), np.log(best), 1)[0])
        right.plot(SPP, best, marker=marker, color=colour, label=f"{scene}: slope {slope:.2f}")
        numbers[scene] = {"best": best, "slope": slope}
    plain_log(right)
    right.set_ylim(0.25, 1.8)
    right.set_xticks(SPP, [str(spp) for spp in SPP])
    right.set(title="the best sigma_space falls as spp grows", xlabel="spp", ylabel="best sigma_space (pixels)")
    right.legend(frameon=False, fontsize=9)
    return figure, numbers


def make_fails() -> tuple[Figure, dict]:
    """Show the same sigma on a scene that it helps and on one that it harms."""
    sigma, half, ceiling, numbers = best_of("dof", 8)[0], slice(40, 96), 0.5, {}
    figure = Figure(figsize=(8.6, 3.9), layout="constrained")
    grid = figure.subplots(2, 5)
    for row, scene in zip(grid, ("dof", "pinhole"), strict=True):
        target, image = reference(scene), renders(scene, 8)[0]
        filtered = gaussian(image, sigma_space=sigma)
        errors = [relmse(image, target), relmse(filtered, target)]
        numbers[f"{scene}_unfiltered"], numbers[f"{scene}_filtered"] = errors
        pictures = {"reference": target, "8 spp": image, f"Gaussian, sigma {sigma:.2g}": filtered}
        for axes, (name, shown) in zip(row, pictures.items(), strict=False):
            axes.imshow(tone_map(shown[half, half]), interpolation="nearest")
            axes.set_title(name, fontsize=10)
        for axes, shown, error, name in zip(row[3:], (image, filtered), errors, ("8 spp", "Gaussian"), strict=True):
            axes.imshow(error_colours(relmse_map(shown, target).mean(-1)[half, half], ceiling), interpolation="nearest")
            axes.set_title(f"{name}: relMSE {error:.3g}", fontsize=9)
        row[0].set_ylabel(scene)
    for axes in grid.flat:
        axes.set(xticks=[], yticks=[])
    bar = figure.colorbar(error_scale(ceiling), ax=grid[:, -1], aspect=30)
    bar.set_label("(x - ref)² / (ref² + 0.01)")
    figure.suptitle("The same sigma_space helps one scene and harms the other")
    return figure, numbers | {"sigma": sigma}
