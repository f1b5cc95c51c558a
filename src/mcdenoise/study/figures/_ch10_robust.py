"""Chapter 10, stability: what one firefly does, and the median of means that bounds it."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.metrics import relmse
from mcdenoise.study.charts import COLOURS, GREY, MARKERS
from mcdenoise.study.figures._ch10_data import captured, reference, study, words
from mcdenoise.study.methods import METHODS
from mcdenoise.study.robust import median_of_means
from mcdenoise.study.stability_catalogue import CATALOGUE
from mcdenoise.study.stability_charts import firefly_chart
from mcdenoise.study.stability_tables import firefly_damage
from mcdenoise.study.stability_troubles import FIREFLY, FIREFLY_VALUES

SIGMA = 0.7  # of the Gaussian in the study, pixels
GROUPS = (1, 4, 5, 16)
BAD, BAD_COUNTS = 100.0, (0, 1, 2, 3, 4, 6, 8)  # radiance of a bad sample; how many of 16
MEDIAN_SPP = 16
MEDIAN_SCENES = ("dof", "glossy")


def fireflies() -> tuple[Figure, dict]:
    """Damage of one firefly, and of many; with what a Gaussian must do by its formula."""
    found = study("stability")
    levels, spp = found["entries"]["firefly_value"]["levels"], found["settings"]["spp"]
    values = [float(value) for value in FIREFLY_VALUES]
    damage = {
        m: {f"{v:g}": level["methods"][m]["value"] for v, level in zip(values, levels, strict=True)} for m in METHODS
    }
    many = {name: {"plain": before, "added_by_one": added} for name, (before, added) in firefly_damage(found).items()}
    bounded = [METHODS[m].label for m in METHODS if all(level["methods"][m]["held"] for level in levels)]
    bell = np.exp(-(np.arange(-9, 10) ** 2) / (2 * SIGMA**2))
    share = bell[10] * bell[9] / bell.sum() ** 2  # of a pixel's light in its neighbour
    return firefly_chart(found), {
        "damage": damage,
        "many": many,
        "bound": CATALOGUE["firefly_value"].bound,
        "bounded": words(bounded),
        "unbounded": words(METHODS[m].label for m in METHODS if METHODS[m].label not in bounded),
        "value": FIREFLY,
        "spp": spp,
        "formula": {f"{v:g}": share * v / spp for v in values},
        "formula_at_border": {f"{v:g}": share * v / spp * bell.sum() / bell[9:].sum() for v in values},
        "sum_of_squares": float(np.square(np.outer(bell, bell) / bell.sum() ** 2).sum()),
        "sum_formula": 1 / (4 * np.pi * SIGMA**2),
    }


@cache
def _spoiled(scene: str) -> tuple[np.ndarray, np.ndarray]:
    """Samples, and in each pixel a random order of them."""
    radiance = captured(scene, MEDIAN_SPP, seed=3).radiance
    return radiance, np.random.default_rng(0).random(radiance.shape[:3]).argsort(axis=2)


def median() -> tuple[Figure, dict]:
    """The median of means: what it bears, and the light that it loses where nothing is wrong."""
    scene = MEDIAN_SCENES[0]
    radiance, order = _spoiled(scene)
    figure = Figure(figsize=(10.5, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    numbers: dict[str, Any] = {"spp": MEDIAN_SPP, "bad": BAD, "bears": {}, "relmse": {}, "light": {}, "clean": {}}
    for groups, colour, marker in zip(GROUPS, COLOURS, MARKERS, strict=False):
        errors = []
        for count in BAD_COUNTS:
            bad = np.where((order < count)[..., np.newaxis], np.float32(BAD), radiance)
            errors.append(relmse(median_of_means(bad, groups), reference(scene)))
        name = {1: "1 group: mean", MEDIAN_SPP: f"{MEDIAN_SPP} groups: median"}.get(groups, f"{groups} groups")
        left.plot(BAD_COUNTS, errors, marker=marker, color=colour, label=name)
        numbers["bears"][groups] = (groups - 1) // 2
        numbers["relmse"][groups] = dict(zip(map(str, BAD_COUNTS), errors, strict=True))
    for scene, colour, marker in zip(MEDIAN_SCENES, COLOURS[4:], MARKERS[4:], strict=False):
        whole = _spoiled(scene)[0]
        images = [median_of_means(whole, groups) for groups in GROUPS]
        light = [100 * (float(image.mean() / images[0].mean()) - 1) for image in images]
        right.plot(range(len(GROUPS)), light, marker=marker, color=colour, label=scene)
        numbers["light"][scene] = dict(zip(map(str, GROUPS), light, strict=True))
        numbers["clean"][scene] = {
            str(g): relmse(image, reference(scene)) for g, image in zip(GROUPS, images, strict=True)
        }
    left.set(
        yscale="log", xlabel=f"bad samples among the {MEDIAN_SPP} of each pixel", ylabel="relMSE",
        title=f"{MEDIAN_SCENES[0]}: what it bears (bad samples: {BAD:g})",
    )  # fmt: skip
    right.axhline(0, color=GREY, linestyle="--")
    right.set_xticks(range(len(GROUPS)), GROUPS)
    right.set(xlabel="groups", ylabel="light of the image, %", title="what it costs without any bad sample")
    for axes in (left, right):
        axes.grid(color="#e5e5e5", linewidth=0.6)
        axes.set_axisbelow(True)
    left.legend(frameon=False, fontsize=9, loc="center", bbox_to_anchor=(0.54, 0.4))
    right.legend(frameon=False, fontsize=9)
    return figure, numbers
