"""Chapter 09, where it fails: fireflies and what despiking takes away, no noise, no light, one sample, no features."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.lbf import lbf
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.study.figures._ch04_data import error, picture, samples
from mcdenoise.study.figures._ch06_limits import discs
from mcdenoise.study.figures._ch09_data import SPP, noisy
from mcdenoise.study.figures._references import reference

FLIES, HEIGHT = 24, 40.0  # samples of soft_shadow made fireflies, and their radiance
LAMPS = np.s_[0:40, 0:128]


def rebuilt(buffer: SampleBuffer, radiance: np.ndarray) -> SampleBuffer:
    """The same samples with other radiance."""
    features = {name: buffer[name] for name in buffer.feature_names}
    random_params = {name: buffer[name] for name in buffer.random_param_names}
    return SampleBuffer.from_arrays(radiance, buffer.screen_position, random_params, features, buffer.hit)


@cache
def with_fireflies() -> tuple[SampleBuffer, np.ndarray]:
    """Samples of soft_shadow, a few of which are bright beyond reason; and which pixels they are in."""
    buffer = samples("soft_shadow", SPP)
    rng = np.random.default_rng(5)
    radiance, where = buffer.radiance.copy(), np.zeros(buffer.radiance.shape[:2], bool)
    y, x = rng.integers(4, 124, (2, FLIES))
    radiance[y, x, 0] = HEIGHT
    where[y, x] = True
    return rebuilt(buffer, radiance), where


def despike() -> tuple[Figure, dict]:
    """Fireflies with and without despiking; and what it takes from the discs of lamps."""
    flies, where = with_fireflies()
    rows = {
        "soft_shadow": (pixel_mean(flies.radiance), lbf(flies), lbf(flies, despiked=True)),
        "dof": (noisy("dof"), lbf(samples("dof", SPP)), lbf(samples("dof", SPP), despiked=True)),
    }
    figure, numbers = Figure(figsize=(9.8, 4.3), layout="constrained"), {"flies": int(where.sum()), "height": HEIGHT}
    grid = figure.subplots(2, 4, height_ratios=(128, 44))
    titles = {"soft_shadow": ("input, 4 spp\n", "LBF\n", "LBF, despiked\n", "reference"), "dof": ("", "", "", "")}
    for row, (scene, images) in zip(grid, rows.items(), strict=True):
        part = np.s_[:, :] if scene == "soft_shadow" else LAMPS
        for axes, image, title in zip(row, images, titles[scene], strict=False):
            picture(axes, image[part], f"{title}{error(image, scene):.4f}")
        picture(row[3], reference(scene)[part], titles[scene][3])
        row[0].set_ylabel(f"{FLIES} fireflies" if scene == "soft_shadow" else "dof, lamps", fontsize=9.5)
        errors = [error(image, scene) for image in images]
        numbers[scene] = dict(zip(("noisy", "lbf", "despiked"), errors, strict=True))
    inside, true = discs(), reference("dof")
    bright = {name: image[inside].mean() / true[inside].mean() for name, image in
              zip(("noisy", "lbf", "despiked"), rows["dof"], strict=True)}  # fmt: skip
    numbers["lamps"] = {name: 100 * value for name, value in bright.items()}
    numbers["left"] = {
        name: 100 * (image[where].mean() - noisy("soft_shadow")[where].mean()) / (HEIGHT / SPP)
        for name, image in zip(("lbf", "despiked"), rows["soft_shadow"][1:], strict=True)
    }
    numbers["clean"] = {"lbf": error(lbf(samples("soft_shadow", SPP)), "soft_shadow")}
    numbers["clean"]["despiked"] = error(lbf(samples("soft_shadow", SPP), despiked=True), "soft_shadow")
    numbers["energy"] = {name: 100 * (image.mean() / noisy("dof").mean() - 1) for name, image in
                         zip(("lbf", "despiked"), rows["dof"][1:], strict=True)}  # fmt: skip
    return figure, numbers


def limits() -> tuple[Figure, dict]:
    """What goes in, and what comes out, where there is no noise, no light, one sample, or no feature."""
    buffer = samples("dof", SPP)
    still = np.repeat(reference("dof")[:, :, np.newaxis], SPP, axis=2)
    dark = samples("soft_shadow", SPP).radiance.copy()
    dark[:, :64] = 0
    cases = {
        "no noise": (rebuilt(buffer, still), "dof"),
        "left half black": (rebuilt(samples("soft_shadow", SPP), dark), "soft_shadow"),
        "1 spp": (buffer.subset(0, 1), "dof"),
        "no features": (buffer.select(features=()), "dof"),
    }
    figure, numbers = Figure(figsize=(9.8, 5.2), layout="constrained"), {}
    grid = figure.subplots(2, 4)
    for column, (name, (given, scene)) in zip(grid.T, cases.items(), strict=True):
        before, after = pixel_mean(given.radiance), lbf(given)
        picture(column[0], before, f"{name}\n{error(before, scene):.4f}" if "black" not in name else f"{name}\n")
        picture(column[1], after, f"{error(after, scene):.4f}" if "black" not in name else "")
        key = name.replace(" ", "_")
        numbers[key] = {"before": error(before, scene), "after": error(after, scene)}
        if "black" in name:
            numbers[key]["largest_in_black"] = float(after[:, :40].max())
        if name == "no noise":
            change = np.abs(after - before)
            numbers[key] |= {"largest": float(change.max()), "mean": float(100 * change.mean() / before.mean())}
    grid[0, 0].set_ylabel("in")
    grid[1, 0].set_ylabel("out")
    return figure, numbers
