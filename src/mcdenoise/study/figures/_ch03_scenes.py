"""Chapter 03, figures on rendered scenes: weights, bilateral against Gaussian, the error map, the guide, fireflies."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.filters import bilateral, gaussian
from mcdenoise.filters.window import bell
from mcdenoise.metrics import relmse, relmse_map
from mcdenoise.render import capture
from mcdenoise.study.display import error_colours, error_scale
from mcdenoise.study.figures._ch03_data import (
    BILATERAL,
    GAUSSIAN,
    NOISY,
    REFERENCE,
    SIZE,
    best_bilateral,
    best_gaussian,
    noisy,
    picture,
)
from mcdenoise.study.figures._references import reference
from mcdenoise.study.methods import METHODS
from mcdenoise.study.tune import choose_parameters

SCENE = "pinhole"
SCENES = ("dof", "pinhole", "soft_shadow", "glossy", "motion")
PIXELS = {"flat": (20, 20), "shadow": (70, 40), "penumbra": (52, 98)}  # y, x in soft_shadow
REACH = 10


def window_weights() -> tuple[Figure, dict]:
    """The two factors of the weights, and their product, at three pixels of a noisy image."""
    image, sigma_space, sigma_radiance = noisy("soft_shadow"), 4.0, 0.15
    figure = Figure(figsize=(7.8, 5.4), layout="constrained")
    grid, numbers = figure.subplots(3, 4), {}
    reach = np.arange(-REACH, REACH + 1.0)
    near = bell(reach[:, np.newaxis], sigma_space)[:, np.newaxis] * bell(reach[:, np.newaxis], sigma_space)
    for row, (name, (y, x)) in zip(grid, PIXELS.items(), strict=True):
        crop = image[y - REACH : y + REACH + 1, x - REACH : x + REACH + 1]
        alike = bell(crop - image[y, x], sigma_radiance)
        picture(row[0], crop, f"{name}: the window")
        for axes, weight, title in zip(row[1:], (near, alike, near * alike), ("near", "alike", "product"), strict=True):
            shown = axes.imshow(weight, vmin=0, vmax=1, cmap="viridis", interpolation="nearest")
            axes.set(xticks=[], yticks=[])
            axes.set_title(title, fontsize=10)
        row[3].set_title(f"product, W_p = {(near * alike).sum():.1f}", fontsize=10)
        for axes in row:
            axes.plot(REACH, REACH, "s", markerfacecolor="none", markeredgecolor="#ff3333", markersize=6)
        numbers[name] = (near * alike).sum()
    figure.colorbar(shown, ax=grid, label="weight", shrink=0.6)
    return figure, numbers | {"near": near.sum()}


def against_gaussian(scene: str = "soft_shadow") -> tuple[Figure, dict]:
    """Noisy, Gaussian, bilateral, reference, with error maps: each filter with the parameters that are best here."""
    image, truth = noisy(scene), reference(scene)
    (gauss_error, space), (error, near, alike) = best_gaussian(scene, image), best_bilateral(scene, image)
    kept = bilateral(image, sigma_space=near, sigma_radiance=alike)
    images = {
        f"8 spp\nrelMSE {relmse(image, truth):.4f}": image,
        f"Gaussian, {space:g} px\nrelMSE {gauss_error:.4f}": gaussian(image, sigma_space=space),
        f"bilateral, {near:g} px, {alike:g}\nrelMSE {error:.4f}": kept,
        "reference\n4096 spp": truth,
    }
    figure = Figure(figsize=(8.6, 4.8), layout="constrained")
    grid = figure.subplots(2, 4)
    crop, ceiling = (slice(24, 104), slice(34, 114)), float(np.percentile(relmse_map(image, truth).mean(axis=-1), 99))
    for (above, below), (title, one) in zip(grid.T, images.items(), strict=True):
        picture(above, one[crop], title)
        error_map = relmse_map(one, truth).mean(axis=-1)[crop]
        below.imshow(error_colours(error_map, ceiling), interpolation="nearest")
        below.set(xticks=[], yticks=[])
    grid[1, 3].clear()
    grid[1, 3].axis("off")
    grid[0, 0].set_ylabel(f"{scene} (part)")
    grid[1, 0].set_ylabel("relative squared error")
    bar = figure.colorbar(error_scale(ceiling), cax=grid[1, 3].inset_axes((0.05, 0, 0.1, 1)))
    bar.set_label("(x - ref)² / (ref² + 0.01)")
    numbers = {
        "noisy": relmse(image, truth),
        "gaussian": gauss_error,
        "bilateral": error,
        "gaussian_sigma_space": space,
        "sigma_space": near,
        "sigma_radiance": alike,
    }
    return figure, numbers


def cut(y: int = 76, sigma_space: float = 1.4, sigma_radiance: float = 0.3) -> tuple[Figure, dict]:
    """One row of pixels through the striped balls, and the error near edges and away from them; equal sigma_space."""
    image, truth = noisy(SCENE), reference(SCENE)
    smooth = gaussian(image, sigma_space=sigma_space)
    kept = bilateral(image, sigma_space=sigma_space, sigma_radiance=sigma_radiance)
    lines = {"8 spp": (image, NOISY), "Gaussian": (smooth, GAUSSIAN), "bilateral": (kept, BILATERAL)}
    figure = Figure(figsize=(9.4, 3.6), layout="constrained")
    where, axes = figure.subplots(1, 2, width_ratios=(1, 2.6))
    picture(where, truth, f"row {y} of the scene {SCENE}")
    where.axhline(y, color="#ff3333", linewidth=1)
    for name, (one, colour) in {**lines, "reference": (truth, REFERENCE)}.items():
        thick = 1.0 if name in ("8 spp", "reference") else 1.8
        axes.plot(one[y].mean(axis=-1), color=colour, linewidth=thick, label=name)
    axes.set(xlabel="x (pixels)", ylabel="radiance (mean of RGB)")
    axes.set_title(f"sigma_space = {sigma_space} px for both, sigma_radiance = {sigma_radiance}")
    axes.title.set_fontsize(10)
    axes.grid(color="#e5e5e5")
    axes.legend(frameon=False, ncols=4, loc="upper center")
    axes.set_ylim(top=axes.get_ylim()[1] * 1.12)
    brightness = truth.mean(axis=-1)
    steep = np.hypot(*np.gradient(brightness)) > 0.05
    numbers = {"edge_share": steep.mean()}
    for name, (one, _) in zip(("noisy", "gaussian", "bilateral"), lines.values(), strict=True):
        error = relmse_map(one, truth).mean(axis=-1)
        numbers[name] = {"edges": error[steep].mean(), "elsewhere": error[~steep].mean()}
    return figure, numbers


def scenes() -> tuple[Figure, dict]:
    """RelMSE on the five toy scenes at 8 spp; the parameters are chosen by halves of the samples, without the reference."""
    figure = Figure(figsize=(8, 3.6), layout="constrained")
    axes, numbers = figure.subplots(), {}
    for place, scene in enumerate(SCENES):
        settings = {"variant": "scalar_rgb", "features": [], "random_params": [], "progress": False}
        samples = capture(scene, SIZE, SIZE, 8, seed=0, **settings)
        errors = {"noisy": relmse(samples.radiance.mean(axis=2), reference(scene))}
        for name in ("gaussian", "bilateral"):
            chosen = choose_parameters(METHODS[name], samples)
            errors[name] = relmse(METHODS[name].run(samples, **chosen), reference(scene))
        numbers[scene] = errors
        for shift, (colour, error) in enumerate(zip((NOISY, GAUSSIAN, BILATERAL), errors.values(), strict=True)):
            bar = axes.bar(place + 0.27 * (shift - 1), error, 0.25, color=colour)
            axes.bar_label(bar, fmt="%.4f", fontsize=8, rotation=90, padding=3)
    for colour, name in zip((NOISY, GAUSSIAN, BILATERAL), ("8 spp", "Gaussian", "bilateral"), strict=True):
        axes.bar(0, 0, color=colour, label=name)
    axes.set(yscale="log", ylim=(0.004, 0.25), ylabel="relMSE (lower is better)")
    axes.set_xticks(range(len(SCENES)), SCENES)
    axes.legend(frameon=False, ncols=3, loc="upper center")
    axes.grid(axis="y", color="#e5e5e5")
    axes.set_axisbelow(True)
    return figure, numbers
