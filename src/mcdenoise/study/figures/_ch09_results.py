"""Chapter 09, results: images of both filters, maps of bandwidths, all methods beside the oracle, samples per pixel."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.filters import gaussian
from mcdenoise.lbf import lbf_analysis, shipped_model
from mcdenoise.lbf.distances import LEAST_VARIANCE
from mcdenoise.lbf.primary import GROUPS
from mcdenoise.samples import pixel_mean
from mcdenoise.study.figures._ch04_data import error, log_axis, picture, plain, samples
from mcdenoise.study.figures._ch06_data import ADAPTIVE
from mcdenoise.study.figures._ch06_data import filtered as rpf_filtered
from mcdenoise.study.figures._ch09_data import (
    GREEN,
    GREY,
    PURPLE,
    RED,
    SCENES,
    SPPS,
    VARIANTS,
    analysis,
    bandwidth_bar,
    bandwidth_picture,
    best_theta,
    error_in_rows,
    error_of,
    filtered,
    geometric_mean,
    noisy,
    symbol,
    way,
)
from mcdenoise.study.figures._references import reference
from mcdenoise.study.slider import Slider, slider

MAPPED = ("dof", "motion", "soft_shadow", "glossy")
REGIONS = {
    "dof": {"focus": np.s_[56:84, 56:80], "front": np.s_[100:124, 104:124]},
    "motion": {"slow": np.s_[40:56, 54:80], "fast": np.s_[66:82, 56:80]},
    "soft_shadow": {"floor": np.s_[8:40, 80:120], "penumbra": np.s_[64:84, 60:80]},
}
SIGMAS = (0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8)
LOOKS = {  # words, colour, marker
    "noisy": ("unfiltered", GREY, "_"),
    "gaussian": ("best Gaussian", "#66CCEE", "v"),
    "rpf": ("RPF, adaptive", "#CCBB44", "s"),
    "shared": ("best for all pixels", GREEN, "D"),
    "cross_bilateral": ("LBF, cross-bilateral", RED, "o"),
    "nlm": ("LBF, NLM", PURPLE, "P"),
    "oracle": ("best for each pixel", "#222222", "*"),
}
SWEEP = (1, 2, 4, 8, 16)


def results() -> tuple[Figure, dict]:
    """The other scenes at 4 spp: input, both filters, reference."""
    figure, numbers = Figure(figsize=(8.4, 8.9), layout="constrained"), {}
    grid = figure.subplots(4, 4)
    for column, scene in zip(grid.T, SCENES[1:], strict=True):
        images = {"input, 4 spp": noisy(scene)} | {
            words: filtered(scene, variant) for variant, words in VARIANTS.items()
        }
        for axes, (label, image) in zip(column, images.items(), strict=False):
            above = f"{scene}\n" if label == "input, 4 spp" else ""
            picture(axes, image, f"{above}{error(image, scene):.4f}")
            if scene == SCENES[1]:
                axes.set_ylabel(label)
        picture(column[3], reference(scene))
    grid[3, 0].set_ylabel("reference")
    for scene in SCENES:
        numbers[scene] = {"noisy": error(noisy(scene), scene)} | {one: error_of(scene, one) for one in VARIANTS}
    return figure, numbers


def theta_maps() -> tuple[Figure, dict]:
    """Predicted bandwidths of four scenes, as images."""
    figure, numbers = Figure(figsize=(9.8, 6.1), layout="constrained"), {}
    names = [name for name in shipped_model().outputs if name in ("position", "colour", *GROUPS)]
    grid = figure.subplots(len(MAPPED), len(names) + 1)
    for row, scene in zip(grid, MAPPED, strict=True):
        found = analysis(scene).bandwidths
        picture(row[0], filtered(scene), "output" if scene == MAPPED[0] else "")
        row[0].set_ylabel(scene)
        numbers[scene] = {}
        for axes, name in zip(row[1:], names, strict=True):
            if name not in found:
                axes.imshow(np.ones((128, 128, 3)))
                plain(axes)
                axes.spines[:].set_visible(False)
                continue
            bandwidth_picture(axes, found[name])
            numbers[scene][name] = {"median": float(np.median(found[name]))} | {
                region: float(np.median(found[name][where])) for region, where in REGIONS.get(scene, {}).items()
            }
    for axes, name in zip(grid[0, 1:], names, strict=True):
        axes.set_title(symbol(name), fontsize=9.5)
    bandwidth_bar(figure, grid, shrink=0.6, pad=0.01)
    return figure, numbers


@cache
def best_gaussian(scene: str, spp: int) -> np.ndarray:
    """The image after the Gaussian that is best for this scene."""
    images = [gaussian(noisy(scene, spp), sigma_space=one) for one in SIGMAS]
    return min(images, key=lambda image: error(image, scene))


def images_of(scene: str, spp: int) -> dict[str, np.ndarray]:
    """Images of all methods by key; those of the two searches are every eighth row alone."""
    found = best_theta(scene, spp)
    return {
        "noisy": noisy(scene, spp),
        "gaussian": best_gaussian(scene, spp),
        "rpf": rpf_filtered(scene, ADAPTIVE, spp),
        "shared": found.shared_image,
        **{variant: filtered(scene, variant, spp) for variant in VARIANTS},
        "oracle": found.image,
    }


def measured(spp: int) -> dict:
    """RelMSE of all methods and scenes, on every eighth row and, but for the searches, of whole images; and the way."""
    images = {scene: images_of(scene, spp) for scene in SCENES}
    rows = {scene: {key: error_in_rows(one, scene) for key, one in of.items()} for scene, of in images.items()}
    whole = {
        scene: {key: error(one, scene) for key, one in of.items() if key not in ("shared", "oracle")}
        for scene, of in images.items()
    }
    ways = {
        key: {scene: way(of["noisy"], of[key], of["oracle"]) for scene, of in rows.items()}
        for key in ("gaussian", "rpf", "shared", *VARIANTS)
    }
    return {
        "errors": rows,
        "mean": {key: geometric_mean([rows[scene][key] for scene in SCENES]) for key in rows["dof"]},
        "whole": whole,
        "whole_mean": {key: geometric_mean([whole[scene][key] for scene in SCENES]) for key in whole["dof"]},
        "way": ways,
        "mean_way": {key: float(np.mean(list(one.values()))) for key, one in ways.items()},
    }


def methods() -> tuple[Figure, dict]:
    """RelMSE of all methods at 4 and 8 spp, from unfiltered to the best of every pixel; every eighth row."""
    figure, numbers = Figure(figsize=(9.8, 4.6), layout="constrained"), {}
    for axes, spp in zip(figure.subplots(1, 2, sharey=True), SPPS, strict=True):
        numbers[f"spp_{spp}"] = measured(spp)
        _dots(axes, numbers[f"spp_{spp}"]["errors"])
        axes.set_title(f"{spp} spp", fontsize=10)
    log_axis(figure.axes[0], 0.0003, 0.2)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, frameon=False, ncols=4, loc="outside lower center", fontsize=9)
    return figure, numbers


def _dots(axes: Axes, rows: dict[str, dict[str, float]]) -> None:
    """A column of markers for each scene."""
    places = np.arange(len(rows))
    for shift, (key, (name, colour, marker)) in zip(np.linspace(-0.27, 0.27, len(LOOKS)), LOOKS.items(), strict=True):
        values = [one[key] for one in rows.values()]
        size = {"_": 12, "*": 11}.get(marker, 7)
        axes.plot(
            places + shift, values, marker, color=colour, markersize=size, label=name, linestyle="none",
            markeredgewidth=2.5 if marker == "_" else 0.5, markeredgecolor=colour if marker == "_" else "white",
        )  # fmt: skip
    for place in places[1:]:
        axes.axvline(place - 0.5, color="#e5e5e5", linewidth=1)
    axes.set_xticks(places, list(rows), fontsize=9)
    axes.grid(axis="y", color="#e5e5e5")
    axes.set_axisbelow(True)


@cache
def sweep() -> dict[int, tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Spp -> noisy and filtered dof, map of alpha, and where the texture has no noise; parts of one capture of 16 spp."""
    found, buffer = {}, samples("dof", SWEEP[-1])
    for spp in SWEEP:
        part = buffer.subset(0, spp)
        of = lbf_analysis(part)
        quiet = of.primary.variances["albedo"].max(axis=-1) <= LEAST_VARIANCE
        found[spp] = (pixel_mean(part.radiance), of.image, of.bandwidths["position"], quiet)
    return found


def slider_spp() -> tuple[Slider, dict]:
    """Samples per pixel: input, output, the map of alpha, and the errors."""
    images = sweep()
    errors = {name: [error(one[k], "dof") for one in images.values()] for k, name in enumerate(("noisy", "filtered"))}

    def draw(spp: int) -> Figure:
        figure = Figure(figsize=(9.8, 2.9), layout="constrained")
        grid = figure.subplots(1, 4, width_ratios=(1, 1, 1, 1.25))
        picture(grid[0], images[spp][0], f"input, {spp} spp")
        picture(grid[1], images[spp][1], "LBF, cross-bilateral")
        bandwidth_picture(grid[2], images[spp][2], symbol("position"))
        for name, colour in (("noisy", "#777777"), ("filtered", RED)):
            grid[3].plot(SWEEP, errors[name], "o-", color=colour, label=name, markersize=4)
            grid[3].plot(spp, errors[name][SWEEP.index(spp)], "o", color=colour, markersize=10, fillstyle="none")
        log_axis(grid[3], 0.003, 0.8)
        grid[3].set(xscale="log", xlabel="samples per pixel")
        grid[3].set_xticks(SWEEP, SWEEP, minor=False)
        grid[3].minorticks_off()
        grid[3].legend(frameon=False, fontsize=8.5)
        return figure

    power = {name: -float(np.polyfit(np.log(SWEEP[2:]), np.log(one[2:]), 1)[0]) for name, one in errors.items()}
    worth = [errors["noisy"][0] / one for one in errors["filtered"]]  # error of Monte Carlo goes as 1 / spp
    gains = [a / b for a, b in zip(errors["noisy"], errors["filtered"], strict=True)]
    return slider(draw, title="dof with 1 to 16 samples a pixel", start=4, spp=SWEEP), {
        "spp": SWEEP,
        **errors,
        "power": power,
        "worth": worth,
        "gains": gains,
        "missed": [100 * one[3][~images[SWEEP[-1]][3]].mean() for one in images.values()],
    }
