"""What a guarantee is about: one number of one filtered image, to be held against the bound of its entry."""

from __future__ import annotations

import numpy as np

from mcdenoise.metrics import relmse_map
from mcdenoise.samples import pixel_mean
from mcdenoise.study.stability_scenes import Scene

Base = np.ndarray | None


def against_unfiltered(image: np.ndarray, _: Base, scene: Scene) -> float:
    """relMSE of the filtered image over that of the unfiltered one, among the pixels of the mask."""
    return _relmse(image, scene) / _relmse(noisy(scene), scene)


def relative_rms(image: np.ndarray, _: Base, scene: Scene) -> float:
    """Squared error of the filtered image over that of the unfiltered one: no epsilon, so it serves at any brightness."""
    scale = np.abs(scene.truth).max()
    squares = [np.mean((one.astype(np.float64) / scale - scene.truth / scale) ** 2) for one in (image, noisy(scene))]
    return float(squares[0] / squares[1])


def added_error(image: np.ndarray, _: Base, scene: Scene) -> float:
    """How much relMSE the filter adds among the pixels of the mask; below 0 where it takes some away."""
    return _relmse(image, scene) - _relmse(noisy(scene), scene)


def rise(image: np.ndarray, base: Base, scene: Scene) -> float:
    """How much larger the relMSE is than without the trouble."""
    return _relmse(image, scene) - float(relmse_map(base, scene.truth)[scene.mask].mean())


def largest_change(image: np.ndarray, base: Base, scene: Scene) -> float:
    """The largest change of a pixel of the mask against the image without the trouble, in radiance."""
    return float(np.abs(image.astype(np.float64) - base)[scene.mask].max())


def relative_change(image: np.ndarray, base: Base, scene: Scene) -> float:
    """The largest change of a pixel against the image without the trouble, as a share of the brightest pixel."""
    return largest_change(image, base, scene) / float(np.abs(base).max())


def unequal_scale(image: np.ndarray, base: Base, scene: Scene) -> float:
    """How far F(s c) is from s F(c), as a share of the brightest pixel; s from the truth, which holds it."""
    scale = np.float64(scene.scale)
    return float(np.abs(image / scale - base).max() / np.abs(base).max())


def off_the_truth(image: np.ndarray, _: Base, scene: Scene) -> float:
    """The largest relative error of a pixel."""
    return float(np.abs(image / scene.truth - 1).max())


def outside(image: np.ndarray, _: Base, scene: Scene) -> float:
    """How far the image leaves the range of the unfiltered one, as a share of the brightest pixel: an average can not."""
    unfiltered = noisy(scene).astype(np.float64)
    low, high = unfiltered.min(axis=(0, 1)), unfiltered.max(axis=(0, 1))
    return float(max((image - high).max(), (low - image).max(), 0) / np.abs(unfiltered).max())


def noisy(scene: Scene) -> np.ndarray:
    """The unfiltered image."""
    return pixel_mean(scene.samples.radiance)


def _relmse(image: np.ndarray, scene: Scene) -> float:
    """Among the pixels of the mask."""
    return float(relmse_map(image, scene.truth)[scene.mask].mean())
