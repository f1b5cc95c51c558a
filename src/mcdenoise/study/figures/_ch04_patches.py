"""Chapter 04, figures about NL-means: patches as witnesses, distances in units of noise, fireflies, its dials."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.filters import bilateral, nlm, noise_variance
from mcdenoise.filters.nlm import box_mean, patch_distance
from mcdenoise.filters.window import window_offsets
from mcdenoise.study.figures._ch04_data import (
    BILATERAL,
    GAUSSIAN,
    NOISY,
    PATCHES,
    SCENES,
    SIZE,
    bars,
    error,
    log_axis,
    noise,
    noisy,
    picture,
    plain,
    samples,
    tuned,
)
from mcdenoise.study.figures._references import reference

DIALS = {"k": 0.6, "search_radius": 5, "patch_radius": 3, "weight_radius": 1}
REACH = 10
PIXELS = {"stripes in metal": ("glossy", 92, 57), "penumbra": ("soft_shadow", 62, 88), "bokeh": ("dof", 15, 18)}
CONSTANTS = tuple(np.geomspace(1e-5, 0.3, 12))


def weights_of(scene: str, y: int, x: int, patch_radius: int) -> np.ndarray:
    """Weights of NL-means around one pixel, (21, 21)."""
    image, variance = noisy(scene).astype(np.float64), noise(scene).mean(axis=-1, dtype=np.float64)
    weights = np.zeros((2 * REACH + 1, 2 * REACH + 1))
    for dy, dx, here, there in window_offsets(SIZE, SIZE, REACH):
        distance = patch_distance(image, variance, here, there, patch_radius, DIALS["k"])
        weights[dy + REACH, dx + REACH] = np.exp(-distance[y - here[0].start, x - here[1].start])
    return weights


def pixel_patch() -> tuple[Figure, dict]:
    """Who is alike? Asked pixel by pixel, and patch by patch."""
    figure = Figure(figsize=(8.2, 5.9), layout="constrained")
    grid, numbers = figure.subplots(3, 4), {}
    for row, (name, (scene, y, x)) in zip(grid, PIXELS.items(), strict=True):
        window = np.s_[y - REACH : y + REACH + 1, x - REACH : x + REACH + 1]
        alike = {f"by {kind}": weights_of(scene, y, x, r) for kind, r in (("pixel", 0), ("patch", 3))}
        truth = reference(scene)
        picture(row[0], noisy(scene)[window], f"{scene}, 8 spp")
        row[0].set_ylabel(name)
        picture(row[1], truth[window], "reference")
        numbers[name.replace(" ", "_")] = {}
        for axes, (title, weight) in zip(row[2:], alike.items(), strict=True):
            shown = axes.imshow(weight, vmin=0, vmax=1, cmap="viridis", interpolation="nearest")
            difference = np.linalg.norm(truth[window] - truth[y, x], axis=-1)
            away = float((weight * difference).sum() / weight.sum())
            plain(axes, f"{title}: W = {weight.sum():.0f},\ntruth differs by {away:.3f}")
            numbers[name.replace(" ", "_")][title.replace(" ", "_")] = {"norm": weight.sum(), "truth_differs": away}
        for axes in row:
            axes.plot(REACH, REACH, "s", markerfacecolor="none", markeredgecolor="#ff3333", markersize=5)
    figure.colorbar(shown, ax=grid, label="weight", shrink=0.6)
    return figure, numbers


def normal_views(seed: int = 4, size: int = 256) -> np.ndarray:
    """(u - v)^2 / (var + var) of two views of one truth, normal noise of known variance."""
    rng = np.random.default_rng(seed)
    deviation = rng.uniform(0.1, 1, (size, size))
    first, second = (deviation * rng.standard_normal((size, size)) for _ in range(2))
    return (first - second) ** 2 / (2 * deviation**2)


def rendered_views(scene: str) -> np.ndarray:
    """The same for two renders of a scene with other seeds; variances estimated from their samples."""
    other = noise_variance(samples(scene, seed=1).radiance).mean(axis=-1)
    square = ((noisy(scene) - noisy(scene, 1)) ** 2).mean(axis=-1)
    return square / np.maximum(noise(scene).mean(axis=-1) + other, 1e-12)


def expected_difference() -> tuple[Figure, dict]:
    """The squared difference of two views of one truth in units of its variance: by pixel, by patch, after cancellation."""
    views = {
        "normal noise, known variance": normal_views(),
        "two renders of dof, estimated variances": rendered_views("dof"),
    }
    figure = Figure(figsize=(9.4, 3.7), layout="constrained")
    numbers = {}
    for axes, (name, ratio) in zip(figure.subplots(1, 2, sharey=True), views.items(), strict=True):
        bins = np.linspace(0, 4, 61)
        for values, colour, label in (
            (ratio, NOISY, "one pixel"),
            (box_mean(ratio, 3), PATCHES, "mean of a 7 x 7 patch"),
        ):
            share = np.full(values.size, 100 / values.size)
            axes.hist(np.minimum(values.ravel(), 3.99), bins, weights=share, color=colour, alpha=0.8, label=label)
        mean = float(ratio.mean())
        axes.axvline(1, color="#222222", linestyle=":", label="expected: 1")
        axes.set(xlabel="$(u_p - u_q)^2 / (var_p + var_q)$", ylim=(0, 30))
        axes.set_title(f"{name}: mean {mean:.2f}", fontsize=10)
        axes.grid(color="#e5e5e5")
        patch = box_mean(ratio, 3)
        numbers["normal" if name.startswith("normal") else "rendered"] = {
            "mean": mean,
            "patch_5_95": np.percentile(patch, (5, 95)),
            "weight_with": np.exp(-np.maximum(patch - 1, 0) / DIALS["k"] ** 2).mean(),
            "weight_without": np.exp(-patch / DIALS["k"] ** 2).mean(),
        }
    figure.axes[0].set_ylabel("share (%)")
    figure.axes[0].legend(frameon=False)
    return figure, numbers


@cache
def best_constant(scene: str) -> tuple[float, float]:
    """RelMSE of NL-means that takes one variance for all pixels, and that variance. (It looks at the reference.)"""
    dials = {**DIALS, "k": 1.0}
    return min((error(nlm(noisy(scene), float(one), **dials), scene), float(one)) for one in CONSTANTS)


def variances_matter() -> tuple[Figure, dict]:
    """NL-means with one variance for all pixels, and with the variance of each, beside the best Gaussian."""
    rows = {
        scene: {
            "unfiltered": error(noisy(scene), scene),
            "best Gaussian": tuned("gaussian", scene).error,
            "one variance for all": best_constant(scene)[0],
            "the variance of each pixel": error(nlm(noisy(scene), noise(scene), **DIALS), scene),
        }
        for scene in SCENES
    }
    figure = Figure(figsize=(9.4, 3.9), layout="constrained")
    axes = figure.subplots()
    colours = dict(zip(rows["dof"], (NOISY, GAUSSIAN, BILATERAL, PATCHES), strict=True))
    bars(axes, rows, colours)
    log_axis(axes, 0.002, 0.25)
    axes.legend(frameon=False, ncols=4, loc="upper center", fontsize=9)
    keys = dict(zip(colours, ("noisy", "gaussian", "constant", "variances"), strict=True))
    numbers = {s: {keys[k]: v for k, v in one.items()} for s, one in rows.items()}
    return figure, numbers


def symmetric(scene: str) -> np.ndarray:
    """NL-means that takes off var_p + var_q instead of var_p + min(var_p, var_q)."""
    image, variance = noisy(scene).astype(np.float64), noise(scene).mean(axis=-1, dtype=np.float64)
    total, norm = np.zeros_like(image), np.zeros((SIZE, SIZE))
    for _, _, here, there in window_offsets(SIZE, SIZE, DIALS["search_radius"]):
        both = variance[here] + variance[there] + 1e-12
        square = ((image[here] - image[there]) ** 2).mean(axis=-1)
        distance = box_mean((square - both) / (DIALS["k"] ** 2 * both), DIALS["patch_radius"])
        weight = box_mean(np.exp(-np.maximum(distance, 0)), DIALS["weight_radius"])
        total[here] += weight[..., np.newaxis] * image[there]
        norm[here] += weight
    return total / norm[..., np.newaxis]


def brightest(scene: str, pixels: int = 50) -> tuple[tuple, np.ndarray]:
    """The pixels that are most too bright, and by how much."""
    excess = (noisy(scene) - reference(scene)).mean(axis=-1)
    where = np.unravel_index(np.argsort(excess, axis=None)[-pixels:], excess.shape)
    return where, excess[where]


def firefly() -> tuple[Figure, dict]:
    """What is left of the fireflies of rough metal, and what they do to others."""
    scene, (where, excess) = "glossy", brightest("glossy")
    image, variance = noisy(scene), noise(scene)
    one_for_all = {**DIALS, "k": 1.0}
    images = {
        "8 spp": ("noisy", image),
        "bilateral,\n1.4 px, 0.3": ("bilateral", bilateral(image, sigma_space=1.4, sigma_radiance=0.3)),
        "NL-means,\none variance": ("constant", nlm(image, best_constant(scene)[1], **one_for_all)),
        "variances,\nnothing taken off": ("kept", nlm(image, variance, cancellation=0.0, **DIALS)),
        "variances, taken\noff: the sum": ("symmetric", symmetric(scene)),
        "NL-means\n(min of the two)": ("nlm", nlm(image, variance, **DIALS)),
    }
    figure = Figure(figsize=(9.4, 2.55), layout="constrained")
    numbers = {"pixels": len(excess)}
    for axes, (title, (key, one)) in zip(figure.subplots(1, 6), images.items(), strict=True):
        left = float(((one - reference(scene)).mean(axis=-1)[where] / excess).mean())
        picture(axes, one[30:94, 64:128], title)
        axes.title.set_fontsize(9)
        axes.set_xlabel(f"excess left {100 * left:.0f} %\nrelMSE {error(one, scene):.4f}", fontsize=9)
        numbers[key] = {"left": left, "relmse": error(one, scene)}
    return figure, numbers
