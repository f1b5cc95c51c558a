"""Chapter 04, figures about the dials of NL-means: k, the size of patches, the size of the search window."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from mcdenoise.filters import nlm
from mcdenoise.study.figures._ch04_data import (
    BILATERAL,
    CROSS,
    GAUSSIAN,
    JOINT,
    PREFILTERED,
    SCENES,
    error,
    log_axis,
    noise,
    noisy,
)
from mcdenoise.study.figures._ch04_patches import DIALS


def nlm_error(scene: str, **dials: float) -> float:
    """RelMSE of NL-means with these dials, and the others as they are in all figures."""
    return error(nlm(noisy(scene), noise(scene), **{**DIALS, **dials}), scene)


def search() -> tuple[Figure, dict]:
    """RelMSE against the search radius: does near matter?"""
    radii, numbers = (1, 2, 3, 4, 5, 7, 10, 14), {}
    figure = Figure(figsize=(7.6, 3.9), layout="constrained")
    axes = figure.subplots()
    for scene, colour, marker in zip(SCENES, (GAUSSIAN, BILATERAL, CROSS, PREFILTERED, JOINT), "os^Dv", strict=True):
        errors = [nlm_error(scene, search_radius=radius) for radius in radii]
        axes.plot(radii, errors, marker + "-", color=colour, label=scene)
        numbers[scene] = {"best": radii[int(np.argmin(errors))], "errors": errors}
    log_axis(axes, 0.002, 0.03)
    axes.set(xlabel="search_radius (pixels)")
    axes.grid(color="#e5e5e5")
    axes.legend(frameon=False, ncols=5, loc="upper center", fontsize=9)
    return figure, numbers | {"radii": radii}


def k_patch() -> tuple[Figure, dict]:
    """RelMSE over k and patch_radius on two scenes."""
    values, radii, numbers = (0.2, 0.3, 0.45, 0.6, 0.8, 1.2, 2.0), (0, 1, 2, 3, 4, 5), {}
    figure = Figure(figsize=(9.4, 4.0), layout="constrained")
    for axes, scene in zip(figure.subplots(1, 2), ("dof", "soft_shadow"), strict=True):
        errors = np.array([[nlm_error(scene, patch_radius=r, k=k) for k in values] for r in radii])
        scale = LogNorm(errors.min(), errors.max())
        axes.imshow(errors, cmap="viridis_r", norm=scale, origin="lower", aspect="auto")
        for (i, j), one in np.ndenumerate(errors):
            light = one > np.sqrt(errors.min() * errors.max())
            colour = "white" if light else "black"
            axes.text(j, i, f"{one:.4f}"[1:], ha="center", va="center", fontsize=8, color=colour)
        i, j = np.unravel_index(errors.argmin(), errors.shape)
        axes.plot(j, i, "s", markersize=26, markerfacecolor="none", markeredgecolor="#EE3333", markeredgewidth=2)
        axes.set_xticks(range(len(values)), [f"{k:g}" for k in values])
        axes.set_yticks(range(len(radii)), [f"{r} ({2 * r + 1} x {2 * r + 1})" for r in radii])
        axes.set(xlabel="k (standard deviations)", ylabel="patch_radius (pixels)")
        axes.set_title(f"{scene}: relMSE, unfiltered {error(noisy(scene), scene):.4f}", fontsize=10)
        numbers[scene] = {"k": values[j], "patch_radius": radii[i], "relmse": errors[i, j], "radius_0": errors[0].min()}
    return figure, numbers
