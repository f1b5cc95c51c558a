"""Chapter 04, figures about which features to use: second hits, visibility, and the albedo as a divisor."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.filters import safe_albedo
from mcdenoise.study.figures._ch04_data import (
    NOISY,
    PREFILTERED,
    SCENES,
    bars,
    log_axis,
    noisy,
    picture,
    prefiltered,
    raw_features,
    tuned,
    tuned_first_hit,
    tuned_variant,
)

GROUPS = {"glossy": "second hits", "soft_shadow": "visibility", "motion": "visibility"}
KINDS = {
    "raw, first hit": ("cross_bilateral", False, "#DDD6A0"),
    "raw, all": ("cross_bilateral", True, "#CCBB44"),
    "prefiltered, first hit": ("cross_bilateral_prefiltered", False, "#9BCBA5"),
    "prefiltered, all": ("cross_bilateral_prefiltered", True, PREFILTERED),
}
DIVISORS = {"no albedo": NOISY, "raw albedo": "#CC6677", "prefiltered albedo": PREFILTERED}
METHOD = "cross_bilateral_prefiltered"
WIDER = (6.4, np.inf)  # more choices of sigma_radiance: image / albedo is larger than the image


def groups() -> tuple[Figure, dict]:
    """What second hits and visibility add to the first hit; best parameters of each."""
    rows, numbers = {}, {}
    for scene, group in GROUPS.items():
        errors = {}
        for kind, (method, all_of_them, _) in KINDS.items():
            errors[kind] = (tuned if all_of_them else tuned_first_hit)(method, scene).error
        rows[f"{scene}\n+ {group}"] = errors
        numbers[scene] = {kind.replace(", ", "_").replace(" ", "_"): value for kind, value in errors.items()}
    figure = Figure(figsize=(8.4, 3.9), layout="constrained")
    axes = figure.subplots()
    bars(axes, rows, {kind: colour for kind, (_, _, colour) in KINDS.items()})
    log_axis(axes, 0.002, 0.03)
    axes.legend(frameon=False, ncols=2, loc="upper right")
    return figure, numbers


def quotient(scene: str, albedo: np.ndarray) -> np.ndarray:
    """The image divided by its albedo, scaled so that it can be shown."""
    divided = noisy(scene) / safe_albedo(albedo, noisy(scene))
    return divided / np.percentile(divided, 98)


def demodulation() -> tuple[Figure, dict]:
    """Divide by the albedo, filter, multiply: what is filtered, and what it gains or costs."""
    rows = {}
    for scene in SCENES:
        raw = raw_features(scene, ("albedo",))["albedo"]
        clean = np.clip(prefiltered(scene)[0]["albedo"], 0, 1)
        rows[scene] = {
            "no albedo": tuned_variant(METHOD, scene, WIDER).error,
            "raw albedo": tuned_variant(METHOD, scene, WIDER, albedo=raw).error,
            "prefiltered albedo": tuned_variant(METHOD, scene, WIDER, albedo=clean).error,
        }
    figure = Figure(figsize=(9.4, 5.4), layout="constrained")
    grid = figure.add_gridspec(2, 5, height_ratios=(1, 1.25))
    shown = {
        "pinhole: image": noisy("pinhole"),
        "pinhole:\nimage / albedo": quotient("pinhole", raw_features("pinhole")["albedo"]),
        "dof: image": noisy("dof"),
        "dof:\nimage / raw albedo": quotient("dof", raw_features("dof")["albedo"]),
        "glossy:\nimage / albedo": quotient("glossy", raw_features("glossy")["albedo"]),
    }
    for place, (title, image) in enumerate(shown.items()):
        picture(figure.add_subplot(grid[0, place]), image, title)
    axes = figure.add_subplot(grid[1, :])
    bars(axes, rows, DIVISORS)
    log_axis(axes, 0.002, 0.08, "relMSE, cross-bilateral,\nprefiltered features")
    axes.legend(frameon=False, ncols=3, loc="upper right")
    numbers = {s: {kind.replace(" ", "_"): value for kind, value in one.items()} for s, one in rows.items()}
    return figure, numbers
