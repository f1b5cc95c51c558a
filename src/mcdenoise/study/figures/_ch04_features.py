"""Chapter 04, figures about features as witnesses: what they are, the weights they give, and the five scenes."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.filters import cross_bilateral
from mcdenoise.filters.window import bell
from mcdenoise.study.display import error_scale
from mcdenoise.study.figures._ch04_data import (
    CROSS,
    FIRST_HIT,
    GAUSSIAN,
    NOISY,
    SCENES,
    bars,
    best_gaussian,
    error,
    error_picture,
    feature_noise,
    log_axis,
    noisy,
    picture,
    plain,
    raw_features,
    shares,
    tuned_first_hit,
)
from mcdenoise.study.figures._references import reference
from mcdenoise.study.slider import Slider, slider

SPACE, RADIANCE, SHARE = 1.0, 0.8, 0.2  # at 1 px the best of a grid on pinhole
REACH = 8
PIXELS = {  # scene, y, x
    "edge of a tile": ("pinhole", 108, 60),
    "silhouette": ("pinhole", 92, 74),
    "penumbra": ("soft_shadow", 62, 88),
    "out of focus": ("dof", 108, 112),
}


def features() -> tuple[Figure, dict]:
    """What the renderer knows about a pixel: means of first-hit features as images."""
    figure = Figure(figsize=(9.0, 2.75), layout="constrained")
    grid = figure.subplots(1, 4)
    position, normal, albedo = (pixel_mean_of("pinhole", name) for name in FIRST_HIT)
    low, high = (np.percentile(position, edge, axis=(0, 1)) for edge in (2, 98))
    picture(grid[0], noisy("pinhole"), "pinhole: radiance, 8 spp")
    grid[1].imshow(np.clip((position - low) / (high - low), 0, 1), interpolation="nearest")
    plain(grid[1], "world_position (scene units)\nred x, green y, blue z")
    grid[2].imshow(np.clip(normal / 2 + 0.5, 0, 1), interpolation="nearest")
    plain(grid[2], "shading_normal (unit vector)\n-1 dark, +1 bright")
    picture(grid[3], albedo, "albedo (in [0, 1])")
    values = {name: pixel_mean_of("pinhole", name) for name in FIRST_HIT}
    return figure, {name: {"low": value.min(), "high": value.max()} for name, value in values.items()}


def more_features() -> tuple[Figure, dict]:
    """Where the first hit does not know enough: features of the second hit, and visibility of the light."""
    figure = Figure(figsize=(9.0, 2.75), layout="constrained")
    grid = figure.subplots(1, 4)
    picture(grid[0], pixel_mean_of("glossy", "albedo"), "glossy: albedo,\nblack on metal")
    picture(grid[1], pixel_mean_of("glossy", "albedo_2"), "glossy: albedo_2,\nthe second hit")
    picture(grid[2], noisy("soft_shadow"), "soft_shadow:\nradiance, 8 spp")
    picture(
        grid[3], pixel_mean_of("soft_shadow", "visibility"), "soft_shadow: visibility\n(share of light samples seen)"
    )
    return figure, {"metal_percent": 100 * (pixel_mean_of("glossy", "albedo").max(axis=-1) == 0).mean()}


def pixel_mean_of(scene: str, name: str) -> np.ndarray:
    """Mean of one feature over the samples of each pixel."""
    return raw_features(scene, (name,))[name]


def window_weights() -> tuple[Figure, dict]:
    """The factors of the weights, and their product, at four instructive pixels."""
    figure = Figure(figsize=(9.4, 6.2), layout="constrained")
    grid, numbers = figure.subplots(len(PIXELS), 7), {}
    for row, (name, (scene, y, x)) in zip(grid, PIXELS.items(), strict=True):
        window = np.s_[y - REACH : y + REACH + 1, x - REACH : x + REACH + 1]
        factors = window_factors(scene, y, x)
        product = np.prod(list(factors.values()), axis=0)
        picture(row[0], noisy(scene)[window], f"{scene}")
        row[0].set_ylabel(name, fontsize=9)
        for axes, (title, weight) in zip(row[1:], {**factors, "product": product}.items(), strict=True):
            shown = axes.imshow(weight, vmin=0, vmax=1, cmap="viridis", interpolation="nearest")
            plain(axes, title if name == "edge of a tile" else "")
        row[-1].set_xlabel(f"sum {product.sum():.1f}", fontsize=9)
        for axes in row:
            axes.plot(REACH, REACH, "s", markerfacecolor="none", markeredgecolor="#ff3333", markersize=5)
        numbers[name.replace(" ", "_")] = {key: weight.sum() for key, weight in factors.items()} | {
            "product": product.sum()
        }
    figure.colorbar(shown, ax=grid, label="weight", shrink=0.6)
    return figure, numbers


def window_factors(scene: str, y: int, x: int, space: float = 4.0) -> dict[str, np.ndarray]:
    """Near, alike in colour, alike in each feature: the weights of the window around one pixel."""
    window = np.s_[y - REACH : y + REACH + 1, x - REACH : x + REACH + 1]
    reach = np.arange(-REACH, REACH + 1.0)[:, np.newaxis]
    factors = {"near": bell(reach, space)[:, np.newaxis] * bell(reach, space)}
    factors["colour"] = bell(noisy(scene)[window] - noisy(scene)[y, x], RADIANCE)
    sigmas = shares(scene, SHARE)
    for name, feature in raw_features(scene).items():
        factors[name.split("_")[-1]] = bell(feature[window] - feature[y, x], sigmas[name])
    return factors


@cache
def filtered(scene: str, sigma_radiance: float = RADIANCE, share: float = SHARE) -> np.ndarray:
    """The one filter of the five scenes: first-hit features as the renderer gives them."""
    return cross_bilateral(
        noisy(scene),
        raw_features(scene),
        sigma_space=SPACE,
        sigma_radiance=sigma_radiance,
        sigma_features=shares(scene, share),
    )


def five_scenes() -> tuple[Figure, dict]:
    """Five scenes, one filter with one setting: images, references, errors on one scale."""
    figure = Figure(figsize=(9.4, 7.7), layout="constrained")
    grid, ceiling = figure.subplots(4, 5), 0.25
    for column, scene in zip(grid.T, SCENES, strict=True):
        picture(column[0], noisy(scene), f"{scene}\nrelMSE {error(noisy(scene), scene):.4f}")
        picture(column[1], filtered(scene), f"relMSE {error(filtered(scene), scene):.4f}")
        picture(column[2], reference(scene))
        error_picture(column[3], filtered(scene), scene, ceiling)
    for axes, name in zip(grid[:, 0], ("8 spp", "cross-bilateral", "reference, 4096 spp", "error"), strict=True):
        axes.set_ylabel(name)
    bar = figure.colorbar(error_scale(ceiling), ax=grid[3], shrink=0.9)
    bar.set_label("(x - ref)²\n/ (ref² + 0.01)", fontsize=8)
    return figure, {"sigma_space": SPACE, "sigma_radiance": RADIANCE, "share": SHARE}


def where_it_matters(scene: str) -> np.ndarray:
    """The pixels that a scene is about: (h, w) bool."""
    if scene in ("dof", "motion"):
        return feature_noise(scene, share=SHARE) > 1
    if scene == "glossy":
        return pixel_mean_of(scene, "albedo").max(axis=-1) == 0
    if scene == "soft_shadow":
        seen = pixel_mean_of(scene, "visibility")
        return (seen > 0) & (seen < 1)
    return feature_noise(scene, share=SHARE) < 0.1


KEYS = ("noisy", "gaussian", "cross_bilateral")
PLACES = {
    "pinhole": "features clean",
    "dof": "features noisy",
    "motion": "features noisy",
    "glossy": "metal",
    "soft_shadow": "penumbra",
}


def five_errors() -> tuple[Figure, dict]:
    """The errors of the one filter, over the whole image and where each scene is difficult, beside the best Gaussian."""
    figure = Figure(figsize=(9.4, 6.4), layout="constrained")
    numbers = {"whole": {}, "part": {}, "elsewhere": {}, "features_alone": {}, "tuned": {}, "share": {}, "percent": {}}
    for scene in SCENES:
        where = where_it_matters(scene)
        images = {"unfiltered": noisy(scene), "best Gaussian": best_gaussian(scene), "cross-bilateral": filtered(scene)}
        numbers["whole"][scene] = {name: error(image, scene) for name, image in images.items()}
        numbers["part"][scene] = {name: error(image, scene, where) for name, image in images.items()}
        numbers["elsewhere"][scene] = {name: error(image, scene, ~where) for name, image in images.items()}
        numbers["percent"][scene] = 100 * where.mean()
        numbers["features_alone"][scene] = error(filtered(scene, np.inf), scene)
        best = tuned_first_hit("cross_bilateral", scene)
        numbers["tuned"][scene] = best.error
        numbers["share"][scene] = best.parameters["sigma_features"]["albedo"] / shares(scene, 1.0)["albedo"]
    colours = {"unfiltered": NOISY, "best Gaussian": GAUSSIAN, "cross-bilateral": CROSS}
    above, below = figure.subplots(2, 1)
    bars(above, numbers["whole"], colours)
    log_axis(above, 0.004, 0.3)
    above.set_title("whole image", fontsize=10)
    above.legend(frameon=False, ncols=3, loc="upper center")
    parts = {f"{scene}:\n{PLACES[scene]}": values for scene, values in numbers["part"].items()}
    bars(below, parts, colours)
    log_axis(below, 0.001, 0.5, "relMSE of these pixels")
    below.set_title("where the scene is difficult (pinhole: where it is not)", fontsize=10)
    for kind in ("whole", "part", "elsewhere"):
        numbers[kind] = {scene: dict(zip(KEYS, one.values(), strict=True)) for scene, one in numbers[kind].items()}
    return figure, numbers


def _slide(share: float) -> Figure:
    """One frame: both scenes after the filter with this share."""
    figure = Figure(figsize=(6.6, 3.7), layout="constrained")
    for axes, scene in zip(figure.subplots(1, 2), ("pinhole", "dof"), strict=True):
        image = filtered(scene, np.inf, share)
        picture(axes, image, f"{scene}: relMSE {error(image, scene):.4f}")
    return figure


def slider_share() -> tuple[Slider, dict]:
    """The bandwidth of features, from the image itself to the Gaussian, with and without the lens."""
    values = [0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, np.inf]
    frames = slider(_slide, title="How different may features be?", share=values, start=SHARE)
    numbers = {"share": values}
    for scene in ("pinhole", "dof"):
        numbers[scene] = [error(filtered(scene, np.inf, value), scene) for value in values]
        numbers[f"{scene}_best"] = values[int(np.argmin(numbers[scene]))]
    return frames, numbers
