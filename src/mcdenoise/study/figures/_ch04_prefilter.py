"""Chapter 04, figures about features with less noise: what filtering them, and dividing by their noise, gains."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.filters import cross_bilateral, noise_variance
from mcdenoise.samples import pixel_mean
from mcdenoise.study.figures._ch04_data import (
    BILATERAL,
    CROSS,
    GAUSSIAN,
    NOISY,
    PATCHES,
    PREFILTERED,
    SCENES,
    bars,
    error,
    feature_noise,
    log_axis,
    noisy,
    picture,
    plain,
    prefiltered,
    raw_features,
    samples,
    shares,
    tuned,
    tuned_variant,
)
from mcdenoise.study.figures._ch04_features import RADIANCE, SHARE, SPACE, filtered

PART = np.s_[48:128, 48:128]


def rms_error(feature: np.ndarray, truth: np.ndarray, own: np.ndarray, where: np.ndarray) -> float:
    """Root mean square error of a feature at the pixels `where`, without the variance `own` of the truth itself."""
    square = ((feature - truth) ** 2 - own).sum(axis=-1)[where].mean()
    return float(np.sqrt(max(square, 0)))


def prefilter() -> tuple[Figure, dict]:
    """Albedo and normal of dof as the renderer gives them, after their own NL-means, and at more samples."""
    more, (after, _) = samples("dof", 32, 2), prefiltered("dof")
    before = raw_features("dof")
    figure = Figure(figsize=(9.0, 4.9), layout="constrained")
    grid, numbers = figure.subplots(2, 4), {}
    noisy_there = feature_noise("dof", share=SHARE) > 1
    for row, name in zip(grid, ("albedo", "shading_normal"), strict=True):
        truth = pixel_mean(more[name])
        images = {"8 spp": before[name], "after NL-means": after[name], "32 spp, other seed": truth}
        for axes, (title, image) in zip(row, images.items(), strict=False):
            if name == "albedo":
                picture(axes, image[PART], title)
            else:
                axes.imshow(np.clip(image[PART] / 2 + 0.5, 0, 1), interpolation="nearest")
                plain(axes)
        row[0].set_ylabel(name)
        own = noise_variance(more[name], radius=0)
        numbers[name] = {
            kind: {
                "before": rms_error(before[name], truth, own, where),
                "after": rms_error(after[name], truth, own, where),
            }
            for kind, where in (("noisy", noisy_there), ("clean", ~noisy_there))
        }
        for place, values in enumerate(numbers[name].values()):
            for shift, value in enumerate(values.values()):
                bar = row[3].bar(place + 0.4 * shift - 0.2, value, 0.36, color=(NOISY, PREFILTERED)[shift])
                row[3].bar_label(bar, fmt="%.3f", fontsize=8)
        row[3].set_xticks((0, 1), ("noisy\npixels", "other\npixels"), fontsize=9)
        row[3].set_ylabel(f"RMS error of\n{name}", fontsize=9)
        row[3].margins(y=0.15)
    grid[0, 3].bar(0, 0, color=NOISY, label="8 spp")
    grid[0, 3].bar(0, 0, color=PREFILTERED, label="after")
    grid[0, 3].legend(frameon=False, fontsize=8)
    return figure, numbers


GAINS = {
    "best Gaussian": GAUSSIAN,
    "raw": CROSS,
    "raw, variances": BILATERAL,
    "prefiltered": PATCHES,
    "prefiltered, variances": PREFILTERED,
}


def gains() -> tuple[Figure, dict]:
    """Cross-bilateral with features raw and prefiltered, with and without their variances; best parameters of each."""
    rows = {}
    for scene in SCENES:
        own = {name: noise_variance(samples(scene)[name]) for name in raw_features(scene, tuple(prefiltered(scene)[0]))}
        clean, left = prefiltered(scene)
        rows[scene] = {
            "best Gaussian": tuned("gaussian", scene).error,
            "raw": tuned("cross_bilateral", scene).error,
            "raw, variances": tuned_variant("cross_bilateral", scene, variances=own).error,
            "prefiltered": tuned_variant("cross_bilateral", scene, features=clean).error,
            "prefiltered, variances": tuned_variant("cross_bilateral", scene, features=clean, variances=left).error,
        }
    figure = Figure(figsize=(9.4, 3.9), layout="constrained")
    axes = figure.subplots()
    bars(axes, rows, GAINS)
    log_axis(axes, 0.002, 0.06)
    axes.legend(frameon=False, ncols=5, loc="upper center", fontsize=8.5)
    keys = dict(zip(GAINS, ("gaussian", "raw", "raw_variances", "prefiltered", "both"), strict=True))
    numbers = {scene: {keys[name]: value for name, value in one.items()} for scene, one in rows.items()}
    for scene in SCENES:
        numbers[scene] |= {
            "fixed_raw": error(filtered(scene), scene),
            "fixed_variances": error(with_variances(scene), scene),
        }
    return figure, numbers


def with_variances(scene: str) -> np.ndarray:
    """The one filter of the five scenes, with the variances of its features."""
    return cross_bilateral(
        noisy(scene),
        raw_features(scene),
        sigma_space=SPACE,
        sigma_radiance=RADIANCE,
        sigma_features=shares(scene, SHARE),
        variances={name: noise_variance(samples(scene)[name]) for name in raw_features(scene)},
    )
