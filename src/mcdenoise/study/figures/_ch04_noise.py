"""Chapter 04, figures about noise in features: how much there is, where, and the limits of dividing by it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from mcdenoise.filters import bilateral, cross_bilateral, noise_variance
from mcdenoise.render.scenes import dof
from mcdenoise.study.figures._ch04_data import (
    BILATERAL,
    CROSS,
    GAUSSIAN,
    PREFILTERED,
    SCENES,
    SIZE,
    best_gaussian,
    error,
    feature_noise,
    noise,
    noisy,
    plain,
    raw_features,
    samples,
    shares,
)
from mcdenoise.study.figures._ch04_features import RADIANCE, SHARE, filtered

BINS = (0, 0.5, 1, 2, 3, 4, 5, 6, 9)  # of the circle of confusion, pixels; the wall far behind is left out
CROP = np.s_[64:112, 40:88]


def feature_noise_maps() -> tuple[Figure, dict]:
    """How noisy are radiance and features? Standard deviations of pixels, in bandwidths."""
    figure = Figure(figsize=(9.4, 3.9), layout="constrained")
    grid, numbers = figure.subplots(2, 5), {}
    scale = LogNorm(0.05, 20)
    for (above, below), scene in zip(grid.T, SCENES, strict=True):
        own = np.sqrt(2 * noise(scene).sum(axis=-1)) / RADIANCE
        features = feature_noise(scene, share=SHARE)
        above.imshow(np.maximum(own, 1e-3), cmap="coolwarm", norm=scale, interpolation="nearest")
        shown = below.imshow(np.maximum(features, 1e-3), cmap="coolwarm", norm=scale, interpolation="nearest")
        share = 100 * (features > 1).mean()
        plain(above, scene)
        plain(below, f"{share:.0f} % above 1")
        numbers[scene] = {"percent": share, "radiance_percent": 100 * (own > 1).mean()}
    grid[0, 0].set_ylabel("radiance")
    grid[1, 0].set_ylabel("first-hit features")
    figure.colorbar(shown, ax=grid, label="distance of two views\nof one truth (bandwidths)", shrink=0.8)
    return figure, numbers


def circle_of_confusion() -> np.ndarray:
    """Diameter of the blur of each pixel of dof on the screen, in pixels, from the depth that pinhole sees there."""
    origin, target = np.array(dof.CAMERA["origin"]), np.array(dof.CAMERA["target"])
    axis = (target - origin) / np.linalg.norm(target - origin)
    depth = (raw_features("pinhole")["world_position"] - origin) @ axis
    focus = dof.LENS["focus_distance"]
    pixels_per_unit = SIZE / (2 * focus * np.tan(np.radians(dof.CAMERA["fov"]) / 2))
    return 2 * dof.LENS["aperture_radius"] * pixels_per_unit * np.abs(depth - focus) / depth


def focus() -> tuple[Figure, dict]:
    """In focus against out of focus: noise of the features, and the error beside that of the best Gaussian."""
    blur = circle_of_confusion()
    kinds = [(blur >= low) & (blur < high) for low, high in pairwise(BINS)]
    middle = [blur[kind].mean() for kind in kinds]
    figure = Figure(figsize=(9.4, 3.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    numbers = {"blur": middle}
    for scene, colour in (("dof", BILATERAL), ("pinhole", GAUSSIAN)):
        noisy_there = feature_noise(scene, share=SHARE) > 1
        share = [100 * noisy_there[kind].mean() for kind in kinds]
        ratio = [error(filtered(scene), scene, kind) / error(best_gaussian(scene), scene, kind) for kind in kinds]
        left.plot(middle, share, "o-", color=colour, label=scene)
        right.plot(middle, ratio, "o-", color=colour, label=scene)
        numbers[scene] = {"percent": share, "ratio": ratio}
    left.set(xlabel="circle of confusion (pixels)", ylabel="share of pixels (%)", ylim=(0, 105))
    left.set_title("features noisier than their bandwidth", fontsize=10)
    right.axhline(1, color="#222222", linestyle=":")
    right.text(7, 1.06, "as large as the Gaussian's", fontsize=8.5, ha="right")
    right.set(xlabel="circle of confusion (pixels)", ylabel="ratio of errors", ylim=(0, None))
    right.set_title("error after cross-bilateral / after best Gaussian", fontsize=10)
    for axes in (left, right):
        axes.grid(color="#e5e5e5")
    left.legend(frameon=False)
    return figure, numbers


def distances_to_limits(scale: np.ndarray, sigma_share: np.ndarray) -> dict[str, np.ndarray]:
    """RMS differences: to the plain filter and to the bilateral against scaled variances; to the limit of small bandwidths."""
    image = noisy("dof")[CROP].astype(np.float64)
    features = {name: feature[CROP] for name, feature in raw_features("dof").items()}
    variances = {name: noise_variance(samples("dof")[name])[CROP] + 1e-4 for name in features}
    near = {"sigma_space": 1.4, "sigma_radiance": RADIANCE, "engine": "numpy"}

    def run(share: float, factor: float) -> np.ndarray:
        scaled = {name: factor * variance for name, variance in variances.items()}
        return cross_bilateral(image, features, sigma_features=shares("dof", share), variances=scaled, **near)

    plain_filter = cross_bilateral(image, features, sigma_features=shares("dof", SHARE), **near)
    without = bilateral(image, **near)
    smallest = run(1e-8, 1.0)
    by_scale = [run(SHARE, factor) for factor in scale]
    by_sigma = [run(share, 1.0) for share in sigma_share]
    root = lambda one, other: np.sqrt(((one - other) ** 2).mean())  # noqa: E731
    return {
        "plain": np.array([root(one, plain_filter) for one in by_scale]),
        "bilateral": np.array([root(one, without) for one in by_scale]),
        "standard_deviations": np.array([root(one, smallest) for one in by_sigma]),
    }


def variance_limits() -> tuple[Figure, dict]:
    """No variance: the plain filter. Endless variance: the bilateral. sigma to 0: distance in standard deviations."""
    scale, sigma_share = np.geomspace(1e-5, 1e6, 12), np.geomspace(1e-4, 1, 13)
    distance = distances_to_limits(scale, sigma_share)
    figure = Figure(figsize=(9.4, 3.7), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.loglog(scale, distance["plain"], "s-", color=CROSS, label="from the filter without variances")
    left.loglog(scale, distance["bilateral"], "o-", color=BILATERAL, label="from the bilateral filter")
    left.set(xlabel="all variances multiplied by", ylabel="RMS difference (radiance)", ylim=(1e-9, 3))
    left.set_title(f"share {SHARE:g}", fontsize=10)
    left.legend(frameon=False, loc="lower center")
    right.loglog(sigma_share, distance["standard_deviations"], "^-", color=PREFILTERED, label="from sigma = 0")
    right.set(xlabel="share (sigma_features / spread)", ylabel="RMS difference (radiance)")
    right.set_title("variances as they are", fontsize=10)
    right.legend(frameon=False, loc="lower right")
    for axes in (left, right):
        axes.grid(color="#e5e5e5")
    slope = lambda x, y: float(np.polyfit(np.log(x), np.log(y), 1)[0])  # noqa: E731
    numbers = {
        "slope_plain": slope(scale[:3], distance["plain"][:3]),
        "slope_bilateral": slope(scale[-3:], distance["bilateral"][-3:]),
        "slope_sigma": slope(sigma_share[:3], distance["standard_deviations"][:3]),
    }
    return figure, numbers
