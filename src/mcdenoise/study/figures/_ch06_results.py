"""Chapter 06, figures of whole images: input, RPF and reference; ablations; the four corners; pass by pass."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.rpf import RPFConfig
from mcdenoise.study.figures._ch04_data import noisy, picture
from mcdenoise.study.figures._ch06_data import (
    ADAPTIVE,
    NO_SPIKES,
    OPEN,
    SCENES,
    error_of,
    filtered,
    gallery,
    titled_picture,
    unfiltered,
)
from mcdenoise.study.figures._references import reference

CORNERS = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0))
DETAIL = np.s_[66:122, 72:128]  # of dof: balls in focus and in front
LENS_LEFT_OUT = {"random_params": ("light_u", "light_v")}


def first_look() -> tuple[Figure, dict]:
    """Input, RPF with the report's constants, RPF with ours, reference."""
    images = [
        ("input, 8 spp", noisy("dof")),
        ("RPF, the report's constants", filtered("dof", OPEN)),
        ("RPF, adaptive (ours)", filtered("dof", ADAPTIVE)),
        ("reference, 4096 spp", reference("dof")),
    ]
    figure = gallery([("dof", "", images)], (9.8, 3.15))
    return figure, {"noisy": unfiltered("dof"), "report": error_of("dof", OPEN), "adaptive": error_of("dof", ADAPTIVE)}


def other_scenes() -> tuple[Figure, dict]:
    """The same for the other scenes."""
    figure = Figure(figsize=(8.0, 8.7), layout="constrained")
    grid = figure.subplots(4, 4)
    for column, scene in zip(grid.T, SCENES[1:], strict=True):
        images = (noisy(scene), filtered(scene, OPEN), filtered(scene, ADAPTIVE), reference(scene))
        for axes, image, label in zip(column, images, ("input", "report", "adaptive", "reference"), strict=True):
            titled_picture(axes, image, scene, scene if label == "input" else "")
            if scene == SCENES[1]:
                axes.set_ylabel(label)
    numbers = {
        scene: {"noisy": unfiltered(scene), "report": error_of(scene, OPEN), "adaptive": error_of(scene, ADAPTIVE)}
        for scene in SCENES
    }
    return figure, numbers


def ablation() -> tuple[Figure, dict]:
    """The ablation row of the lecture, for the report's constants and for ours."""
    variants = {
        "report": (
            ("RPF", NO_SPIKES),
            ("no clustering", OPEN),
            ("no lens parameters", RPFConfig.technical_report(spikes="none", **LENS_LEFT_OUT)),
        ),
        "adaptive": (
            ("RPF", ADAPTIVE),
            ("with clustering", RPFConfig.adaptive(clustering=True)),
            ("no lens parameters", RPFConfig.adaptive(**LENS_LEFT_OUT)),
        ),
    }
    rows, numbers = [], {}
    for label, configs in variants.items():
        images = [("reference", reference("dof")), ("input", noisy("dof"))]
        images += [(title, filtered("dof", config)) for title, config in configs]
        rows.append(("dof", label, images))
        numbers[label] = {title.replace(" ", "_"): error_of("dof", config) for title, config in configs}
    return gallery(rows, (9.8, 4.8), DETAIL), numbers | {"noisy": unfiltered("dof")}


def corner(alpha: float, beta: float) -> RPFConfig:
    """The report's passes with fixed alpha and beta."""
    return RPFConfig.technical_report(spikes="none", clustering=False, alpha=alpha, beta=beta)


def corners() -> tuple[Figure, dict]:
    """Alpha and beta fixed to 0 or 1, beside what the dependency chooses."""
    images = [("input", noisy("dof")), ("RPF", filtered("dof", OPEN))]
    numbers = {"noisy": unfiltered("dof"), "rpf": error_of("dof", OPEN)}
    for alpha, beta in CORNERS:
        images.append((f"α = {alpha:g}, β = {beta:g}", filtered("dof", corner(alpha, beta))))
        numbers[f"a{alpha:g}b{beta:g}"] = error_of("dof", corner(alpha, beta))
    return gallery([("dof", "", images[:3]), ("dof", "", images[3:])], (8.6, 6.4)), numbers


def passes() -> tuple[Figure, dict]:
    """The image after one, two, three and four passes, and the errors of all scenes."""
    configs = [RPFConfig.technical_report(spikes="none", clustering=False, passes=tuple(range(k))) for k in range(1, 4)]
    configs.append(OPEN)
    figure = Figure(figsize=(9.8, 4.7), layout="constrained")
    grid = figure.subplots(2, 5)
    for axes, count in zip(grid[0], range(5), strict=True):
        image = filtered("dof", configs[count - 1]) if count else noisy("dof")
        titled_picture(axes, image, "dof", f"after box {OPEN.boxes[count - 1]}" if count else "input")
        picture(grid[1, count], image[DETAIL])
    errors = {scene: [unfiltered(scene)] + [error_of(scene, one) for one in configs] for scene in SCENES}
    alone = {
        scene: error_of(scene, RPFConfig.technical_report(spikes="none", clustering=False, passes=(2, 3)))
        for scene in SCENES
    }
    return figure, {"errors": errors, "only_17_and_7": alone}
