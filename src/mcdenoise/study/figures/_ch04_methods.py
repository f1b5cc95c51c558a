"""Chapter 04, figures that close it: all methods beside each other, and what the best of them leaves."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.metrics import relmse_map
from mcdenoise.study.display import error_scale
from mcdenoise.study.figures._ch04_data import (
    COLOURS,
    SCENES,
    bars,
    by_halves,
    error,
    error_picture,
    log_axis,
    noisy,
    picture,
    samples,
    tuned,
)
from mcdenoise.study.figures._ch04_noise import circle_of_confusion
from mcdenoise.study.figures._references import reference
from mcdenoise.study.methods import METHODS

LAST = ("gaussian", "cross_bilateral", "cross_bilateral_prefiltered", "nlm", "joint_nlm")
HEIGHT_OF_LAMPS = 40  # rows of dof above which the lamps blur to discs


def methods() -> tuple[Figure, dict]:
    """All methods on all scenes: parameters by halves of the samples (bars), and with the reference (lines)."""
    rows = {scene: {METHODS[name].label: by_halves(name, scene) for name in COLOURS} for scene in SCENES}
    figure = Figure(figsize=(9.8, 4.4), layout="constrained")
    axes = figure.subplots()
    bars(axes, rows, {METHODS[name].label: colour for name, colour in COLOURS.items()})
    width = 0.84 / len(COLOURS)
    for place, scene in enumerate(SCENES):
        for shift, name in enumerate(COLOURS):
            at = place + width * (shift - (len(COLOURS) - 1) / 2)
            axes.plot(
                [at - 0.4 * width, at + 0.4 * width], [tuned(name, scene).error] * 2, color="#222222", linewidth=1.4
            )
    axes.plot([], [], color="#222222", label="with the reference")
    log_axis(axes, 0.002, 0.08)
    axes.legend(frameon=False, ncols=4, loc="upper center", fontsize=9)
    numbers = {}
    for scene in SCENES:
        numbers[scene] = {
            name: {"halves": by_halves(name, scene), "reference": tuned(name, scene).error} for name in COLOURS
        }
        numbers[scene]["noisy"] = error(noisy(scene), scene)
        numbers[scene]["best"] = min(by_halves(name, scene) for name in COLOURS)
    return figure, numbers


def left_over() -> tuple[Figure, dict]:
    """What is left on dof: images and errors of the chapter's filters at their best."""
    scene, crop, ceiling = "dof", np.s_[:, :], 0.1
    figure = Figure(figsize=(9.4, 4.2), layout="constrained")
    grid, numbers = figure.subplots(2, 6), {}
    images = {name: METHODS[name].run(samples(scene), **tuned(name, scene).parameters) for name in LAST}
    for (above, below), (name, image) in zip(grid.T, images.items(), strict=False):
        label = METHODS[name].label.replace(", ", ",\n")
        picture(above, image[crop], f"{label}\n{error(image, scene):.4f}")
        above.title.set_fontsize(9)
        error_picture(below, image, scene, ceiling, crop)
        numbers[name] = {"relmse": error(image, scene)} | parts(image, scene)
    picture(grid[0, 5], reference(scene)[crop], "reference\n4096 spp")
    grid[0, 5].title.set_fontsize(9)
    grid[1, 5].axis("off")
    grid[0, 0].set_ylabel("dof")
    grid[1, 0].set_ylabel("error")
    bar = figure.colorbar(error_scale(ceiling), cax=grid[1, 5].inset_axes((0.05, 0, 0.12, 1)))
    bar.set_label("(x - ref)² / (ref² + 0.01)", fontsize=8)
    best = min(tuned(name, scene).error for name in COLOURS)
    numbers["over_pinhole"] = best / min(tuned(name, "pinhole").error for name in COLOURS)
    numbers["best"] = best
    return figure, numbers


def parts(image: np.ndarray, scene: str) -> dict[str, float]:
    """Which share of the error stands where: in the discs of the lamps, elsewhere out of focus, in focus (percent)."""
    errors = relmse_map(image, reference(scene)).mean(axis=-1)
    lamps = np.zeros(errors.shape, bool)
    lamps[:HEIGHT_OF_LAMPS] = True
    blurred = ~lamps & (circle_of_confusion() >= 2)
    kinds = {"lamps": lamps, "blurred": blurred, "sharp": ~lamps & ~blurred}
    return {name: 100 * errors[kind].sum() / errors.sum() for name, kind in kinds.items()}
