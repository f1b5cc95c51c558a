"""The figures of chapter 01, noise: a pixel as an integral, the error against spp, thin lens, light field, sample vector."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.metrics import relmse
from mcdenoise.render import capture, render_image
from mcdenoise.samples import pixel_mean
from mcdenoise.study.charts import COLOURS, MARKERS
from mcdenoise.study.display import tone_map
from mcdenoise.study.figures._ch01_adaptive import make_adaptive
from mcdenoise.study.figures._ch01_lens import dof_samples, lens_point, make_thin_lens
from mcdenoise.study.figures._ch01_lightfield import make_light_field, make_refocus
from mcdenoise.study.figures._ch01_reconstruct import make_same_surface
from mcdenoise.study.figures._ch01_vector import make_sample_vector
from mcdenoise.study.figures._references import reference
from mcdenoise.study.slider import Slider, slider

SCENES = ("pinhole", "soft_shadow", "motion", "dof", "glossy")
SMALL = 64  # side of the images whose error is measured
SPPS = (1, 2, 4, 8, 16, 32)
BLOCKS = 4  # independent sets of samples: the spread of their slopes gives a standard error
PIXEL = (15, 8)  # row and column, in an image 32 pixels wide: the green ball's blurred edge before the yellow ball


def make_integrand() -> tuple[Figure, dict[str, float]]:
    """Take one pixel apart: its radiance over the lens and over the light, and running means towards the integral."""
    samples = dof_samples(32, 512)
    radiance = samples.radiance[PIXEL]
    colours = tone_map(radiance[np.newaxis])[0]
    figure = Figure(figsize=(9.8, 3.1), layout="constrained")
    picture, lens, light, running = figure.subplots(1, 4, width_ratios=(1, 1, 1, 1.6))
    picture.imshow(tone_map(pixel_mean(samples.radiance)), interpolation="nearest")
    picture.plot(PIXEL[1], PIXEL[0], "s", color="white", markerfacecolor="none", markersize=7)
    picture.set(title="dof, 32 pixels wide", xticks=[], yticks=[])
    lens.scatter(*lens_point(samples["lens_u"][PIXEL], samples["lens_v"][PIXEL]), c=colours, s=9)
    lens.set(title="over the lens", xticks=[-1, 0, 1], yticks=[-1, 0, 1], aspect="equal", xlabel="right", ylabel="up")
    light.scatter(samples["light_u"][PIXEL], samples["light_v"][PIXEL], c=colours, s=9)
    light.set(title="over the light", xticks=[0, 1], yticks=[0, 1], aspect="equal", xlabel="u", ylabel="v")
    for axes in (lens, light):
        axes.set_facecolor("#cccccc")
    grey = radiance.mean(axis=1).astype(float)
    _draw_running_means(running, grey)
    return figure, {"spp": len(grey), "mean": grey.mean(), "std": grey.std(ddof=1)}


def _draw_running_means(axes: Axes, values: np.ndarray, runs: int = 8) -> None:
    """Running means of disjoint runs of samples, in the band of one standard deviation of the mean."""
    count = np.arange(1, len(values) // runs + 1)
    for run in values[: runs * len(count)].reshape(runs, -1):
        axes.plot(count, run.cumsum() / count, color=COLOURS[0], linewidth=0.8)
    band = values.std(ddof=1) / np.sqrt(count)
    axes.plot(count, values.mean() + band, color="black", linewidth=1, label=r"mean $\pm\,\sigma/\sqrt{N}$")
    axes.plot(count, values.mean() - band, color="black", linewidth=1)
    axes.set(xscale="log", title=f"{runs} runs of {len(count)} samples", xlabel="samples N", ylabel="mean of radiance")
    axes.legend(frameon=False)


def make_spp() -> tuple[Slider, dict[str, float]]:
    """Show dof and its error map at growing spp, and the point's way down the line of slope -1."""
    spps = (1, 4, 16, 64, 256)
    target = reference("dof")
    images = {spp: render_image("dof", width=128, height=128, spp=spp, seed=spp, progress=False) for spp in spps}
    errors = {spp: relmse(image, target) for spp, image in images.items()}

    def draw(spp: int) -> Figure:
        figure = Figure(figsize=(8, 3.7), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=(1, 1.1))
        left.imshow(tone_map(images[spp]), interpolation="nearest")
        left.set(title=f"{spp} spp", xticks=[], yticks=[])
        right.loglog(spps, [errors[spps[0]] / n for n in spps], "--", color="#777777", label="slope -1")
        right.loglog(spps, list(errors.values()), ".", color=COLOURS[0])
        right.loglog(spp, errors[spp], "o", color=COLOURS[1], markersize=10, label=f"relMSE {errors[spp]:.4f}")
        right.set(xlabel="spp", ylabel="relMSE", title="error against spp", xticks=spps, xticklabels=spps)
        right.minorticks_off()
        right.legend(frameon=False)
        return figure

    made = slider(draw, title="The same picture with more samples", spp=spps, start=4)
    return made, {f"relmse_{spp}": error for spp, error in errors.items()}


@cache
def errors_of(scene: str) -> np.ndarray:
    """Return the relMSE of a scene, (BLOCKS, len(SPPS)): each block's samples are its own, dealt out to images of N spp.

    The reference of 128 x 128 pixels is averaged over 2 x 2: with the box filter that is the image of half the size.
    """
    spp = max(SPPS)
    radiance = capture(
        scene, width=SMALL, height=SMALL, spp=BLOCKS * spp, seed=7, random_params=[], features=[], progress=False
    ).radiance
    target = reference(scene).reshape(SMALL, 2, SMALL, 2, 3).mean(axis=(1, 3))
    errors = np.empty((BLOCKS, len(SPPS)))
    for block, samples in enumerate(np.split(radiance, BLOCKS, axis=2)):
        for k, count in enumerate(SPPS):
            images = [pixel_mean(part) for part in np.split(samples, spp // count, axis=2)]
            errors[block, k] = np.mean([relmse(image, target) for image in images])
    return errors


def slope_of(errors: np.ndarray) -> tuple[float, float]:
    """Return the slope of log error against log spp, and its standard error, from blocks (BLOCKS, len(SPPS))."""
    slopes = np.polyfit(np.log(SPPS), np.log(errors).T, 1)[0]
    return float(slopes.mean()), float(slopes.std(ddof=1) / np.sqrt(len(slopes)))


def make_convergence() -> tuple[Figure, dict[str, dict[str, float]]]:
    """Chart relMSE against spp on five scenes with fitted slopes; and three integrals in one dimension for contrast."""
    figure = Figure(figsize=(10.5, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    numbers = {}
    for scene, colour, marker in zip(SCENES, COLOURS, MARKERS, strict=False):
        errors = errors_of(scene)
        slope, standard_error = slope_of(errors)
        label = f"{scene}: {slope:.3f} ± {standard_error:.3f}"
        left.loglog(SPPS, errors.mean(axis=0), marker=marker, color=colour, label=label)
        numbers[scene] = {"slope": slope, "se": standard_error, "relmse_1": errors[:, 0].mean()}
    left.set(title="relMSE against spp, and slopes", xlabel="spp N", ylabel="relMSE", xticks=SPPS, xticklabels=SPPS)
    left.minorticks_off()
    left.legend(frameon=False, fontsize=9, title="scene: slope ± standard error")
    for (name, (errors, expected)), colour in zip(_integrals().items(), COLOURS, strict=False):
        slope = float(np.polyfit(np.log(INTEGRAL_COUNTS), np.log(errors), 1)[0])
        right.loglog(INTEGRAL_COUNTS, errors, "o-", color=colour, label=f"{name}: {slope:.2f} ({expected})")
        numbers[name.split(",")[0].replace(" ", "_")] = {"slope": slope}
    right.set(title="three integrals over [0, 1]", xlabel="samples N", ylabel="typical error (median)")
    right.set_ylim(1e-7, 1e3)
    right.legend(frameon=False, fontsize=9, title="slope (theory)", loc="upper right")
    return figure, numbers


INTEGRAL_COUNTS = 4 ** np.arange(1, 7)
INTEGRAL_RUNS = 400


def _integrals() -> dict[str, tuple[np.ndarray, str]]:
    """Return the median error of 400 estimates of integrals that are 1: a mild integrand, stratified, and a wild one."""
    rng = np.random.default_rng(1)
    errors: dict[str, list[float]] = {"mild": [], "stratified": [], "wild": []}
    for count in INTEGRAL_COUNTS:
        numbers = rng.random((INTEGRAL_RUNS, count))
        strata = (np.arange(count) + numbers) / count
        errors["mild"].append(np.median(np.abs((3 * numbers**2).mean(axis=1) - 1)))
        errors["stratified"].append(np.median(np.abs((3 * strata**2).mean(axis=1) - 1)))
        errors["wild"].append(np.median(np.abs((0.2 * (1 - numbers) ** -0.8).mean(axis=1) - 1)))
    return {
        "mild, 3u²": (np.array(errors["mild"]), "-1/2"),
        "stratified, 3u²": (np.array(errors["stratified"]), "-3/2"),
        "wild, 0.2 u^-0.8": (np.array(errors["wild"]), "-0.2"),
    }


FIGURES = {
    "spp": make_spp,
    "integrand": make_integrand,
    "convergence": make_convergence,
    "thin_lens": make_thin_lens,
    "light_field": make_light_field,
    "refocus": make_refocus,
    "same_surface": make_same_surface,
    "adaptive": make_adaptive,
    "sample_vector": make_sample_vector,
}
