"""Chapter 06, figures of the draws: how many samples are enough, and what randomness adds."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from time import process_time

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from mcdenoise.metrics import relmse
from mcdenoise.rpf import RPFConfig, rpf
from mcdenoise.study.figures._ch04_data import error, picture, plain, samples
from mcdenoise.study.figures._ch06_data import (
    ADAPTIVE,
    OPEN,
    SCENE_COLOURS,
    analysis,
    error_of,
    filtered,
    titled_picture,
)
from mcdenoise.study.figures._references import reference

FRACTIONS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
SEEDS = (0, 1, 2, 3)
CROP = np.s_[48:112, 64:128]
HALF = 64  # pixels: side of the part that is timed
CORNER = {"dof": (64, 64), "glossy": (40, 0)}
SMALL = replace(OPEN, passes=(2, 3))
DRAWN = RPFConfig.adaptive(deterministic=False, sample_fraction=0.5)


@cache
def timed_crop(scene: str, share: float | None) -> tuple[float, float]:
    """RelMSE over a quarter of a scene, and CPU time, with M = share of box^2 spp (None: the default)."""
    y, x = CORNER[scene]
    part, true = samples(scene).crop(y, x, HALF, HALF), reference(scene)[y : y + HALF, x : x + HALF]
    start = process_time()
    image = rpf(part, replace(OPEN, sample_fraction=share), progress=False)
    return relmse(image, true), process_time() - start


def fraction() -> tuple[Figure, dict]:
    """RelMSE against CPU time, over the share of samples that is drawn."""
    rpf(samples("dof").crop(0, 0, 8, 8), OPEN, progress=False)  # compile before the clock runs
    figure, numbers = Figure(figsize=(7.6, 3.9), layout="constrained"), {"fractions": FRACTIONS}
    axes = figure.subplots()
    for scene in CORNER:
        errors, time = np.transpose([timed_crop(scene, one) for one in (*FRACTIONS, None)])
        errors, time = errors / errors[-2], time / time[-2]  # against the published M
        colour = SCENE_COLOURS[scene]
        axes.plot(time[:-1], errors[:-1], "o-", color=colour, label=f"{scene}, one share for all boxes")
        axes.plot(time[-1], errors[-1], "*", markersize=14, color=colour, label=f"{scene}, at most 64 spp")
        for x, y, one in zip(time, errors, FRACTIONS, strict=False):
            axes.annotate(f"{one:g}", (x, y), (3, 5), textcoords="offset points", fontsize=8, color=colour)
        numbers[scene] = {"errors": errors[:-1], "time": time[:-1], "default": errors[-1], "default_time": time[-1]}
    axes.set(xscale="log", xlabel="CPU time, against M = box² spp / 2", ylabel="relMSE, against M = box² spp / 2")
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(color="#e5e5e5")
    axes.legend(frameon=False, fontsize=8.5)
    return figure, numbers


def seeds() -> tuple[Figure, dict]:
    """Two seeds of the draws, their difference, and every sample of the box."""
    cases = {
        "report": (SMALL, replace(SMALL, deterministic=True)),
        "adaptive": (DRAWN, ADAPTIVE),
    }
    figure, numbers = Figure(figsize=(9.6, 4.5), layout="constrained"), {}
    grid = figure.subplots(2, 5)
    for row, (label, (drawn, whole)) in zip(grid, cases.items(), strict=True):
        images = [filtered("dof", drawn, seed=seed) for seed in SEEDS]
        for axes, image, title in zip(
            row, [*images[:2], filtered("dof", whole)], ("seed 0", "seed 1", "every sample"), strict=False
        ):
            titled_picture(axes, image, "dof", title, CROP)
        shown = row[3].imshow(np.abs(images[1] - images[0]).mean(axis=-1)[CROP], cmap="magma", vmin=0, vmax=0.1)
        plain(row[3], "|seed 1 - seed 0|\n")
        picture(row[4], reference("dof")[CROP], "reference\n")
        row[0].set_ylabel("report,\nboxes 17 and 7" if label == "report" else label)
        errors = [error(image, "dof") for image in images]
        mean = np.mean(images, axis=0)
        between = np.mean([relmse(image, reference("dof")) for image in images]) - relmse(mean, reference("dof"))
        numbers[label] = {
            "errors": errors,
            "spread": 100 * (max(errors) - min(errors)) / np.mean(errors),
            "by_draws": 100 * between * len(SEEDS) / (len(SEEDS) - 1) / np.mean(errors),
            "every": error_of("dof", whole),
            "share_drawn": analysis("dof", drawn, drawn.turns[0]).share_c_r.mean(),
            "share_every": analysis("dof", whole, whole.turns[0]).share_c_r.mean(),
        }
    figure.colorbar(shown, ax=grid[:, 3], shrink=0.6, label="radiance")
    return figure, numbers
