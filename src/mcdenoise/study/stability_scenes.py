"""Buffers whose truth is known, for the catalogue of failures: the truth in closed form, noise drawn with a seed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from math import gamma

import numpy as np

from mcdenoise.render import capture, render_reference
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.stability_settings import Settings

SPREAD = 1.0  # standard deviation of one sample, as a share of the truth
FLOOR = 0.6  # of the height: where the wall ends and the floor begins
Features = Mapping[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Scene:
    """What one entry, level and seed gives a method to filter.

    Attributes
    ----------
    samples : the buffer
    truth : (h, w, 3), what the filtered image should be
    mask : (h, w) bool, the pixels that the measure looks at
    scale : how many times brighter than the plain scene
    """

    samples: SampleBuffer
    truth: np.ndarray
    mask: np.ndarray
    scale: float = 1.0


def scene(samples: SampleBuffer, truth: np.ndarray, mask: np.ndarray | None = None, scale: float = 1.0) -> Scene:
    """Return a Scene; without `mask` all pixels count."""
    return Scene(samples, truth, np.ones(truth.shape[:2], bool) if mask is None else mask, scale)


def noise_factors(u: np.ndarray, spread: float) -> np.ndarray:
    """Factors of mean 1 and standard deviation `spread` that are a function of a random number in [0, 1).

    Weibull's: (-log(1 - u))^k / Gamma(1 + k), so spread^2 = Gamma(1 + 2 k) / Gamma(1 + k)^2 - 1. Never negative; k = 1 is the
    exponential, spread 1; the larger the spread, the rarer and brighter the samples that carry the mean.

    Examples
    --------
    >>> factors = noise_factors(np.random.default_rng(0).random(100_000), 2.0)
    >>> round(float(factors.mean()), 1), round(float(factors.std()), 1)
    (1.0, 2.0)
    """
    k = weibull_power(spread)
    return (-np.log1p(-u)) ** k / gamma(1 + k)


@lru_cache
def weibull_power(spread: float) -> float:
    """The k of `noise_factors`, by halving an interval.

    Examples
    --------
    >>> round(weibull_power(1.0), 6)
    1.0
    """
    low, high = 0.0, 20.0
    for _ in range(60):
        k = (low + high) / 2
        low, high = (low, k) if gamma(1 + 2 * k) / gamma(1 + k) ** 2 - 1 > spread**2 else (k, high)
    return (low + high) / 2


def build(
    truth: np.ndarray,
    features: Features,
    spp: int,
    seed: int,
    *,
    spread: float = SPREAD,
    explained: bool = True,
    random_params: bool = True,
) -> SampleBuffer:
    """Return samples truth x noise, with the features of each pixel.

    Parameters
    ----------
    truth : (h, w, 3). features : name -> (h, w, c), or (h, w, spp, c). spp, seed : samples a pixel, and of their noise.
    spread : of one sample, as a share of the truth; 0: no noise.
    explained : the noise is a function of light_u, light_v says nothing; else neither does.
    random_params : the buffer has light_u, light_v.

    Examples
    --------
    >>> samples = build(np.ones((2, 3, 3)), {"albedo": np.ones((2, 3, 3))}, spp=4, seed=0)
    >>> samples
    SampleBuffer(2 x 3 pixels, 4 spp; random_params: light_u, light_v; features: albedo)
    """
    rng = np.random.default_rng([seed, 10])
    size = (*truth.shape[:2], spp)
    corner = np.stack(np.meshgrid(np.arange(size[1]), np.arange(size[0])), axis=-1)[:, :, np.newaxis]
    u, v, hidden = rng.random((3, *size))
    noise = noise_factors(u if explained else hidden, spread) if spread else np.ones(size)
    return SampleBuffer.from_arrays(
        radiance=truth[:, :, np.newaxis] * noise[..., np.newaxis],
        screen_position=corner + 0.999 * rng.random((*size, 2)),
        random_params={"light_u": u, "light_v": v} if random_params else {},
        features={name: _every_sample(values, spp) for name, values in features.items()},
    )


def room(height: int, width: int) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """A wall and a floor, left of one colour and right of another, lit from the left: truth (h, w, 3) and features.

    Examples
    --------
    >>> truth, features = room(10, 10)
    >>> truth.shape, sorted(features)
    ((10, 10, 3), ['albedo', 'shading_normal', 'world_position'])
    """
    x, y = places(height, width)
    is_right, is_floor = x >= 0.5, y >= FLOOR
    albedo = np.where(is_right[..., np.newaxis], (0.3, 0.4, 0.6), (0.8, 0.7, 0.5))
    light = (1.4 - 0.8 * x) * np.where(is_floor, 0.6, 1.0)
    features = {
        "albedo": albedo,
        "shading_normal": np.where(is_floor[..., np.newaxis], (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        "world_position": np.stack([x, np.minimum(y, FLOOR), np.maximum(y - FLOOR, 0)], axis=-1),
    }
    return albedo * light[..., np.newaxis], features


def flat_features(height: int, width: int) -> dict[str, np.ndarray]:
    """Features of one flat grey wall: only the position varies."""
    x, y = places(height, width)
    ones = np.ones((height, width, 3))
    return {
        "albedo": 0.5 * ones,
        "shading_normal": ones * (0.0, 0.0, 1.0),
        "world_position": np.stack([x, y, 0 * x], axis=-1),
    }


def places(height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Centres of the pixels as shares of width and height: x, y, each (h, w).

    Examples
    --------
    >>> places(1, 2)[0]
    array([[0.25, 0.75]])
    """
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    return x, y


def plain(settings: Settings, seed: int, spp: int | None = None, **changes: float) -> Scene:
    """The room with its usual noise: what nothing is wrong with."""
    truth, features = room(settings.size, settings.size)
    return scene(build(truth, features, settings.spp if spp is None else spp, seed, **changes), truth)


def with_radiance(samples: SampleBuffer, radiance: np.ndarray, nonfinite: str = "raise") -> SampleBuffer:
    """The same samples with another radiance, which passes the gate again."""
    return SampleBuffer.from_arrays(
        radiance,
        samples.screen_position,
        {name: samples[name] for name in samples.random_param_names},
        {name: samples[name] for name in samples.feature_names},
        samples.hit,
        samples.provenance,
        nonfinite,
    )


def some_pixels(settings: Settings, count: int, seed: int) -> np.ndarray:
    """Places of `count` different pixels, flat, chosen by a seed; a larger count has those of a smaller one, and more."""
    return np.random.default_rng([seed, 11]).permutation(settings.size**2)[:count]


def like(samples: SampleBuffer, seed: int = 0) -> SampleBuffer:
    """A plain buffer of the same size, spp and layout: what a method's normal time is measured on.

    Examples
    --------
    >>> samples = build(np.ones((2, 3, 3)), {"visibility": np.ones((2, 3, 1))}, spp=4, seed=0)
    >>> like(samples)
    SampleBuffer(2 x 3 pixels, 4 spp; random_params: light_u, light_v; features: visibility)
    """
    truth, features = room(samples.height, samples.width)
    base = build(truth, features, samples.spp, seed)
    rng = np.random.default_rng([seed, 12])
    made = {}
    for field in samples.layout.features:
        source = base[field.name.removesuffix("_2")] if field.name.removesuffix("_2") in features else base["albedo"]
        noise = 1 + 0.05 * rng.standard_normal((*source.shape[:3], 1)) * field.name.endswith("_2")
        made[field.name] = np.clip(source[..., : field.channels] * noise, -1, 1)
    params = {
        name: base[name] if name in base.random_param_names else rng.random(base.hit.shape)
        for name in samples.random_param_names
    }
    return SampleBuffer.from_arrays(base.radiance, base.screen_position, params, made)


CROPS = {  # scene, and where the crop lies: shares of what is left beside it, down and right
    "defocus": ("dof", 1.0, 1.0),
    "bokeh": ("dof", 0.0, 0.85),
    "penumbra": ("soft_shadow", 0.45, 0.75),
    "second_hit": ("glossy", 0.8, 0.5),
}


@lru_cache(maxsize=2)
def toy(name: str, settings: Settings, seed: int) -> Scene:
    """A crop of a toy scene at the largest spp, with its reference; `at_spp` takes fewer of its samples."""
    what, down, right = CROPS[name]
    picture, size = settings.picture, settings.size
    y, x = round(down * (picture - size)), round(right * (picture - size))
    samples = capture(what, picture, picture, settings.spp, seed=1 + seed, variant=settings.variant, progress=False)
    samples = samples.crop(y, x, size, size)
    reference = render_reference(
        what, picture, picture, spp=settings.reference_spp, seed=0, variant=settings.variant, progress=False
    )
    return scene(samples, reference[y : y + size, x : x + size])


def at_spp(whole: Scene, spp: int) -> Scene:
    """The same scene with the first `spp` samples of every pixel."""
    return replace(whole, samples=whole.samples.subset(0, spp))


def _every_sample(values: np.ndarray, spp: int) -> np.ndarray:
    """A feature of pixels as one of samples."""
    return values if values.ndim == 4 else np.repeat(values[:, :, np.newaxis], spp, axis=2)
