"""The scenes of the catalogue, one maker an entry: (settings, number of the level, seed) -> Scene."""

from __future__ import annotations

import numpy as np

from mcdenoise.samples import SampleBuffer
from mcdenoise.study.stability_scenes import (
    Scene,
    at_spp,
    build,
    flat_features,
    places,
    plain,
    room,
    scene,
    some_pixels,
    toy,
    with_radiance,
)
from mcdenoise.study.stability_settings import Settings

FIREFLY_SHARES = (0.0, 1e-3, 2e-2)  # of the pixels, at least one: 1000 and 20 000 per megapixel
FIREFLY = 1e4  # radiance of the sample, where their number is varied
FIREFLY_VALUES = (1e2, 1e4, 1e6)
NONFINITE_SHARE = 0.01  # of the pixels
SPP = (1, 2)
BLACK = (0.0, 0.1)  # light in the dark half
SCALES = (1e-4, 1e4)
DECADES = (2, 4, 8)
BANDS = 8  # of different brightness, side by side
FAINT = (1e-10, 1e-30, 1e-40)
FLAT = (1e-4, 1.0, 1e4)
SQUARES = (1, 2, 4)  # pixels
STRIPE = 4  # pixels
DISTINCT = (8, 2, 1)  # different samples among those of a pixel
NOISE_LEVELS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
SIZES = ((1, 1), (2, 3), (5, 5))
UNEXPLAINED_SPP = (1, 2, 8)
TOY_SPP = (8, 4, 2)


def firefly_count(settings: Settings, level: int) -> int:
    """How many pixels of the image have a firefly: at least one.

    Examples
    --------
    >>> [firefly_count(Settings(), level) for level in range(3)]
    [1, 4, 82]
    """
    return max(1, round(FIREFLY_SHARES[level] * settings.size**2))


def many_fireflies(settings: Settings, level: int, seed: int) -> Scene:
    """Some pixels with one sample of 1e4; the mask leaves them out."""
    return _fireflies(settings, some_pixels(settings, firefly_count(settings, level), seed), FIREFLY, seed)


def bright_firefly(settings: Settings, level: int, seed: int) -> Scene:
    """One pixel with one sample of a value."""
    return _fireflies(settings, some_pixels(settings, 1, seed), FIREFLY_VALUES[level], seed)


def _fireflies(settings: Settings, pixels: np.ndarray, value: float, seed: int) -> Scene:
    """The room with one sample of `value` in each of these pixels, which the mask leaves out."""
    good = plain(settings, seed)
    radiance, mask = good.samples.radiance.copy(), good.mask.copy()
    radiance.reshape(-1, *radiance.shape[2:])[pixels, 0] = value
    mask.reshape(-1)[pixels] = False
    return scene(with_radiance(good.samples, radiance), good.truth, mask)


def plain_samples(settings: Settings, seed: int) -> SampleBuffer:
    """The buffer without trouble."""
    return plain(settings, seed).samples


def broken_radiance(settings: Settings, seed: int) -> tuple[Scene, np.ndarray]:
    """The room, and its radiance with one NaN or infinite sample, in turns, in a hundredth of the pixels."""
    good = plain(settings, seed)
    radiance = good.samples.radiance.copy()
    pixels = some_pixels(settings, max(2, round(NONFINITE_SHARE * settings.size**2)), seed)
    samples = radiance.reshape(-1, *radiance.shape[2:])
    samples[pixels[::2], 0], samples[pixels[1::2], 0] = np.nan, np.inf
    return good, radiance


def nonfinite(settings: Settings, _: int, seed: int) -> Scene:
    """Refused by the gate, then let in with the broken samples set to 0."""
    good, radiance = broken_radiance(settings, seed)
    return scene(with_radiance(good.samples, radiance, "zero"), good.truth)


def few_spp(settings: Settings, level: int, seed: int) -> Scene:
    """The room with few samples."""
    return plain(settings, seed, SPP[level])


def black(settings: Settings, level: int, seed: int) -> Scene:
    """The right half of the room has hardly any light, or none; the features know where; the mask is that half."""
    truth, features = room(settings.size, settings.size)
    dark = places(settings.size, settings.size)[0] >= 0.5
    truth = np.where(dark[..., np.newaxis], BLACK[level], truth)
    return scene(build(truth, features, settings.spp, seed), truth, dark)


def scaled(settings: Settings, level: int, seed: int) -> Scene:
    """The room, darker or brighter."""
    return _scaled(settings, SCALES[level], seed)


def faint(settings: Settings, level: int, seed: int) -> Scene:
    """The room, so dark that float32 runs out of digits."""
    return _scaled(settings, FAINT[level], seed)


def _scaled(settings: Settings, scale: float, seed: int) -> Scene:
    """Every sample times `scale`."""
    good = plain(settings, seed)
    radiance = (good.samples.radiance.astype(np.float64) * scale).astype(np.float32)
    return scene(with_radiance(good.samples, radiance), good.truth * scale, scale=scale)


def high_range(settings: Settings, level: int, seed: int) -> Scene:
    """Bands side by side, each brighter than the one before, and a flat wall as far as features know."""
    size, decades = settings.size, DECADES[level]
    band = np.minimum((places(size, size)[0] * BANDS).astype(int), BANDS - 1)
    truth = 10.0 ** (decades * (band / (BANDS - 1) - 0.5))[..., np.newaxis] * np.ones(3)
    return scene(build(truth, flat_features(size, size), settings.spp, seed), truth)


def flat(settings: Settings, level: int, seed: int) -> Scene:
    """One value everywhere, in every sample."""
    truth = np.full((settings.size, settings.size, 3), FLAT[level])
    return scene(build(truth, flat_features(*truth.shape[:2]), settings.spp, seed, spread=0), truth)


def noise_free(settings: Settings, level: int, seed: int) -> Scene:
    """The room without noise."""
    return plain(settings, seed, (1, settings.spp)[level], spread=0)


def texture(settings: Settings, level: int, seed: int) -> Scene:
    """A chequered albedo, of which the features know, in smooth light."""
    size, side = settings.size, SQUARES[level]
    index = np.arange(size) // side
    chequered = np.where(((index[:, np.newaxis] + index) % 2)[..., np.newaxis], 0.8, 0.2) * np.ones(3)
    features = flat_features(size, size) | {"albedo": chequered}
    truth = chequered * (1.4 - 0.8 * places(size, size)[0])[..., np.newaxis]
    return scene(build(truth, features, settings.spp, seed), truth)


def missing_features(settings: Settings, level: int, seed: int) -> Scene:
    """The room without features, with constant ones, or with features that are noise and say nothing."""
    truth, features = room(settings.size, settings.size)
    if level == 0:
        features = {}
    elif level == 1:
        features = {name: np.full_like(values, 0.5) for name, values in features.items()}
    else:
        rng = np.random.default_rng([seed, 13])
        features = {name: rng.random((*truth.shape[:2], settings.spp, 3)) for name in features}
    return scene(build(truth, features, settings.spp, seed), truth)


def constant_feature(settings: Settings, _: int, seed: int) -> Scene:
    """The room with the features of one point."""
    return missing_features(settings, 1, seed)


def without_features(settings: Settings, seed: int) -> SampleBuffer:
    """The room without features."""
    return missing_features(settings, 0, seed).samples


def misleading(settings: Settings, level: int, seed: int) -> Scene:
    """Stripes: painted in a place where the radiance is smooth, or of light where no feature knows of them."""
    size = settings.size
    is_odd = ((np.arange(size) // STRIPE) % 2)[np.newaxis, :, np.newaxis] * np.ones((size, 1, 1))
    features = flat_features(size, size)
    smooth = (1.4 - 0.8 * places(size, size)[1])[..., np.newaxis] * np.ones(3) / 2
    if level == 0:
        features["albedo"] = np.where(is_odd, 0.8, 0.2) * np.ones(3)
        truth = smooth
    else:
        truth = smooth * np.where(is_odd, 1.0, 0.2)
    return scene(build(truth, features, settings.spp, seed), truth)


def correlated(settings: Settings, level: int, seed: int) -> Scene:
    """Few different samples, repeated until the pixel has its spp: as if one seed had been used again."""
    good = plain(settings, seed, DISTINCT[level])
    repeats = settings.spp // DISTINCT[level]
    again = {name: np.tile(good.samples[name], (1, 1, repeats, 1)) for name in ("radiance", "screen_position")}
    fields = {
        name: np.tile(good.samples[name], (1, 1, repeats) + (1,) * (good.samples[name].ndim - 3))
        for name in (*good.samples.random_param_names, *good.samples.feature_names)
    }
    params = {name: fields[name] for name in good.samples.random_param_names}
    features = {name: fields[name] for name in good.samples.feature_names}
    return scene(SampleBuffer.from_arrays(**again, random_params=params, features=features), good.truth)


def unexplained(settings: Settings, level: int, seed: int) -> Scene:
    """Stripes of light with a little noise that no random parameter explains, and too few samples to be sure of that."""
    size = settings.size
    is_odd = ((np.arange(size) // STRIPE) % 2)[np.newaxis, :, np.newaxis] * np.ones((size, 1, 1))
    truth = np.where(is_odd, 1.0, 0.4) * np.ones(3)
    samples = build(truth, {}, UNEXPLAINED_SPP[level], seed, spread=0.3, explained=False)
    return scene(samples, truth)


def noise_level(settings: Settings, level: int, seed: int) -> Scene:
    """The room with more and more noise."""
    return plain(settings, seed, spread=NOISE_LEVELS[level])


def small_image(settings: Settings, level: int, seed: int) -> Scene:
    """A room of a few pixels."""
    truth, features = room(*SIZES[level])
    return scene(build(truth, features, settings.spp, seed), truth)


def toy_scene(name: str):
    """The maker for a crop of a toy scene at fewer and fewer spp."""
    return lambda settings, level, seed: at_spp(toy(name, settings, seed), min(TOY_SPP[level], settings.spp))
