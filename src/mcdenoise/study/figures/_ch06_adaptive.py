"""Chapter 06, figures of our own bandwidths: the dial noise_gain, and all methods beside each other."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from mcdenoise.metrics import relmse_map
from mcdenoise.rpf import RPFConfig
from mcdenoise.samples import pixel_mean
from mcdenoise.study.display import error_scale
from mcdenoise.study.figures._ch04_data import bars, error, error_picture, log_axis, noisy, picture, samples, tuned
from mcdenoise.study.figures._ch04_methods import parts
from mcdenoise.study.figures._ch06_data import (
    ADAPTIVE,
    GAINS,
    OPEN,
    REPORT,
    SCENE_COLOURS,
    SCENES,
    SPPS,
    error_of,
    filtered,
    unfiltered,
)
from mcdenoise.study.figures._references import reference
from mcdenoise.study.methods import METHODS

RIVALS = {"gaussian": "#4477AA", "bilateral": "#EE6677", "cross_bilateral": "#CCBB44", "joint_nlm": "#AA3377"}
OURS = {"report, as published": "#DDAA33", "report, both off": "#228833", "adaptive": "#000000"}


def gain() -> tuple[Figure, dict]:
    """RelMSE over noise_gain at 4, 8 and 16 spp, beside the report's constants."""
    figure, numbers = Figure(figsize=(9.8, 3.9), layout="constrained"), {"gains": GAINS, "boxes": ADAPTIVE.boxes}
    grid = figure.subplots(1, len(SPPS), sharey=True)
    for axes, spp in zip(grid, SPPS, strict=True):
        numbers[f"spp_{spp}"] = {}
        for scene in SCENES:
            errors = [error_of(scene, RPFConfig.adaptive(noise_gain=one), spp) for one in GAINS]
            other = error_of(scene, OPEN, spp)
            axes.plot(range(len(GAINS)), errors, "o-", markersize=4, color=SCENE_COLOURS[scene], label=scene)
            axes.axhline(other, color=SCENE_COLOURS[scene], linestyle=":", linewidth=1)
            numbers[f"spp_{spp}"][scene] = {
                "errors": errors,
                "best": GAINS[int(np.argmin(errors))],
                "report": other,
                "noisy": error(pixel_mean(samples(scene, spp).radiance), scene),
                "adaptive": error_of(scene, ADAPTIVE, spp),
            }
        axes.set_xticks(range(len(GAINS)), [f"{one:g}" for one in GAINS])
        axes.set_title(f"{spp} spp", fontsize=10)
        axes.set_xlabel("noise_gain")
        axes.grid(color="#e5e5e5")
    rows = [one for spp in SPPS for one in numbers[f"spp_{spp}"].values()]
    numbers["over_best"] = 100 * max(one["adaptive"] / min(one["errors"]) - 1 for one in rows)
    numbers["report_over_adaptive"] = min(one["report"] / one["adaptive"] for one in rows)
    log_axis(grid[0], 0.002, 0.15)
    for axes in grid[1:]:
        axes.set_ylabel("")
        axes.yaxis.set_minor_formatter(NullFormatter())
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(handles, labels, frameon=False, ncols=5, loc="outside lower center", fontsize=9)
    return figure, numbers


def rival(name: str, scene: str) -> np.ndarray:
    """The image of a method of chapters 02 to 04 with the parameters that are best for the scene."""
    return METHODS[name].run(samples(scene), **tuned(name, scene).parameters)


def methods() -> tuple[Figure, dict]:
    """RelMSE of all methods so far; those of earlier chapters have parameters chosen with the reference, RPF has not."""
    rows, numbers = {}, {}
    for scene in SCENES:
        ours = {name: error_of(scene, one) for name, one in zip(OURS, (REPORT, OPEN, ADAPTIVE), strict=True)}
        values = {"unfiltered": unfiltered(scene)} | {METHODS[name].label: tuned(name, scene).error for name in RIVALS}
        rows[scene] = values | ours
        numbers[scene] = {"noisy": unfiltered(scene)} | {name: tuned(name, scene).error for name in RIVALS}
        numbers[scene] |= dict(zip(("report", "both_off", "adaptive"), ours.values(), strict=True))
    figure = Figure(figsize=(9.8, 4.6), layout="constrained")
    axes = figure.subplots()
    bars(axes, rows, {"unfiltered": "#BBBBBB"} | {METHODS[name].label: one for name, one in RIVALS.items()} | OURS)
    log_axis(axes, 0.002, 0.3)
    axes.legend(frameon=False, ncols=4, loc="upper center", fontsize=9)
    mean = {name: float(np.exp(np.mean([np.log(numbers[scene][name]) for scene in SCENES]))) for name in numbers["dof"]}
    won = [scene for scene in SCENES if numbers[scene]["adaptive"] < numbers[scene]["cross_bilateral"]]
    return figure, numbers | {"mean": mean, "won": won, "lost": [scene for scene in SCENES if scene not in won]}


def errors() -> tuple[Figure, dict]:
    """Images and errors of dof after the best Gaussian, RPF, and joint NL-means."""
    scene, ceiling = "dof", 0.1
    images = {
        "best Gaussian": rival("gaussian", scene),
        "report, published": filtered(scene, REPORT),
        "report, both off": filtered(scene, OPEN),
        "adaptive": filtered(scene, ADAPTIVE),
        "joint NL-means": rival("joint_nlm", scene),
    }
    figure, numbers = Figure(figsize=(9.8, 4.2), layout="constrained"), {}
    grid = figure.subplots(2, 6)
    for (above, below), (name, image) in zip(grid.T, images.items(), strict=False):
        picture(above, image, f"{name}\n{error(image, scene):.4f}")
        above.title.set_fontsize(8.5)
        error_picture(below, image, scene, ceiling)
        numbers[name.split(",")[-1].strip().replace(" ", "_").replace("-", "_")] = parts(image, scene)
    picture(grid[0, 5], reference(scene), "reference\n")
    grid[0, 5].title.set_fontsize(8.5)
    grid[1, 5].axis("off")
    bar = figure.colorbar(error_scale(ceiling), cax=grid[1, 5].inset_axes((0.05, 0, 0.12, 1)))
    bar.set_label("(x - ref)² / (ref² + 0.01)", fontsize=8)
    return figure, numbers | edges()


def edges() -> dict:
    """Which part of the error of pinhole stands at pixels whose samples differ in albedo or normal: sub-pixel edges."""
    scene = "pinhole"
    spread = sum(samples(scene)[name].std(axis=2).sum(axis=-1) for name in ("albedo", "shading_normal"))
    where = spread > 0.1
    found = {"pixels": 100 * where.mean()}
    for name, image in {
        "input": noisy(scene),
        "adaptive": filtered(scene, ADAPTIVE),
        "joint_nlm": rival("joint_nlm", scene),
    }.items():
        of = relmse_map(image, reference(scene)).mean(axis=-1)
        found[name] = 100 * of[where].sum() / of.sum()
        found[f"{name}_at_edges"] = of[where].mean()
        found[f"{name}_elsewhere"] = of[~where].mean()
    return {"edges": found}
