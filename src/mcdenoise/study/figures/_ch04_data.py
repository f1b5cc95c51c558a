"""What the figures of chapter 04 start from: samples with features at a fixed seed, references, bandwidths, small helpers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from mcdenoise.filters import gaussian, noise_variance, prefilter_features
from mcdenoise.metrics import relmse, relmse_map
from mcdenoise.render import capture
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.study.display import error_colours, tone_map
from mcdenoise.study.figures._references import reference
from mcdenoise.study.methods import METHODS, bandwidths, feature_spreads
from mcdenoise.study.tune import Tuned, choose_parameters, tune

SIZE, SPP = 128, 8
SCENES = ("pinhole", "dof", "motion", "glossy", "soft_shadow")  # from where features are right to where they are not
FIRST_HIT = ("world_position", "shading_normal", "albedo")
NOISY, GAUSSIAN, BILATERAL, CROSS, PREFILTERED, PATCHES, JOINT = (
    "#BBBBBB", "#4477AA", "#EE6677", "#CCBB44", "#228833", "#66CCEE", "#AA3377",
)  # fmt: skip
COLOURS = {
    "gaussian": GAUSSIAN,
    "bilateral": BILATERAL,
    "cross_bilateral": CROSS,
    "cross_bilateral_prefiltered": PREFILTERED,
    "nlm": PATCHES,
    "joint_nlm": JOINT,
}  # the methods up to this chapter


@cache
def samples(scene: str, spp: int = SPP, seed: int = 0) -> SampleBuffer:
    """All samples of a scene; the scalar variant, which gives the same numbers on every machine."""
    return capture(scene, SIZE, SIZE, spp, seed, variant="scalar_rgb", progress=False)


@cache
def noisy(scene: str, seed: int = 0) -> np.ndarray:
    """The unfiltered image at 8 spp."""
    return pixel_mean(samples(scene, seed=seed).radiance)


@cache
def noise(scene: str) -> np.ndarray:
    """Variance of the pixels of `noisy`."""
    return noise_variance(samples(scene).radiance)


def raw_features(scene: str, names: tuple[str, ...] = FIRST_HIT) -> dict[str, np.ndarray]:
    """Pixel means of features as the renderer gives them."""
    return {name: pixel_mean(samples(scene)[name]) for name in names}


@cache
def prefiltered(scene: str) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Features of a scene after their own NL-means, and the variances that are left."""
    return prefilter_features(samples(scene), list(feature_spreads(samples(scene))))


def shares(scene: str, share: float, names: tuple[str, ...] = FIRST_HIT) -> dict[str, float]:
    """Bandwidths: the same share of each feature's spread over the image."""
    chosen = bandwidths(feature_spreads(samples(scene)), share, share)
    return {name: chosen[name] for name in names}


@cache
def tuned(method: str, scene: str) -> Tuned:
    """The best parameters of a method for a scene. (It looks at the reference.)"""
    return tune(METHODS[method], samples(scene), reference(scene))


@cache
def by_halves(method: str, scene: str) -> float:
    """RelMSE of a method whose parameters are chosen by halves of the samples, without the reference."""
    chosen = choose_parameters(METHODS[method], samples(scene))
    return relmse(METHODS[method].run(samples(scene), **chosen), reference(scene))


def tuned_variant(method: str, scene: str, radiances: tuple[float, ...] = (), **arguments) -> Tuned:
    """The best parameters of a method that gets other arguments, and a wider choice of sigma_radiance, than its own."""
    base = METHODS[method]

    def candidates(one: SampleBuffer) -> list[dict]:
        own = [dict(parameters) for parameters in base.candidates(one)]
        others = [parameters for parameters in own if parameters["sigma_radiance"] == own[0]["sigma_radiance"]]
        return own + [{**parameters, "sigma_radiance": wider} for wider in radiances for parameters in others]

    changed = replace(base, prepare=lambda one: {**base.prepare(one), **arguments}, candidates=candidates)
    return tune(changed, samples(scene), reference(scene))


@cache
def tuned_first_hit(method: str, scene: str) -> Tuned:
    """The best parameters of a method that gets the features of the first hit alone."""
    if set(samples(scene).feature_names) == set(FIRST_HIT):
        return tuned(method, scene)
    return tune(METHODS[method], samples(scene).select(features=FIRST_HIT), reference(scene))


@cache
def best_gaussian(scene: str) -> np.ndarray:
    """The image after the Gaussian that is best for this scene."""
    return gaussian(noisy(scene), **tuned("gaussian", scene).parameters)


def error(image: np.ndarray, scene: str, where: np.ndarray | None = None) -> float:
    """RelMSE, or the part of it that stands at the pixels `where`, as a mean over them."""
    if where is None:
        return relmse(image, reference(scene))
    return float(relmse_map(image, reference(scene))[where].mean())


def feature_noise(scene: str, names: tuple[str, ...] = FIRST_HIT, share: float = 0.2) -> np.ndarray:
    """Root mean square distance of two noisy views of one pixel, in bandwidths: sqrt(sum of 2 var / sigma^2), (h, w)."""
    chosen, total = shares(scene, share, names), np.zeros((SIZE, SIZE))
    for name in names:
        total += 2 * noise_variance(samples(scene)[name], radius=0).sum(axis=-1) / chosen[name] ** 2
    return np.sqrt(total)


def picture(axes: Axes, image: np.ndarray, title: str = "") -> None:
    """Show radiance, or another quantity in [0, 1], under the one tone map, without ticks."""
    axes.imshow(tone_map(image), cmap="gray", vmin=0, vmax=1, interpolation="nearest")
    plain(axes, title)


def error_picture(axes: Axes, image: np.ndarray, scene: str, ceiling: float, crop: tuple = np.s_[:, :]) -> None:
    """Show the relative squared error of an image on the scale of all error maps."""
    errors = relmse_map(image, reference(scene)).mean(axis=-1)[crop]
    axes.imshow(error_colours(errors, ceiling), interpolation="nearest")
    plain(axes)


def plain(axes: Axes, title: str = "") -> None:
    """No ticks, and a title that stays small."""
    axes.set(xticks=[], yticks=[])
    axes.set_title(title, fontsize=10)


def log_axis(axes: Axes, low: float, high: float, label: str = "relMSE") -> None:
    """A logarithmic axis with plain numbers at 1, 2, 5 of every decade."""
    axes.set(yscale="log", ylim=(low, high), ylabel=label)
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def bars(axes: Axes, rows: Mapping[str, Mapping[str, float]], colours: Mapping[str, str], fmt: str = "%.4f") -> None:
    """Draw groups of bars: group -> bar -> value; one colour a bar, values written above."""
    names, width = list(colours), 0.84 / len(colours)
    for place, values in enumerate(rows.values()):
        for shift, name in enumerate(names):
            if name in values:
                at = place + width * (shift - (len(names) - 1) / 2)
                bar = axes.bar(at, values[name], 0.92 * width, color=colours[name])
                axes.bar_label(bar, fmt=fmt, fontsize=7.5, rotation=90, padding=3)
    for name in names:
        axes.bar(0, 0, color=colours[name], label=name)
    axes.set_xticks(range(len(rows)), rows)
    axes.grid(axis="y", color="#e5e5e5")
    axes.set_axisbelow(True)
