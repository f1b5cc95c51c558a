"""What the figures of chapter 02 measure on: the five scenes at several spp, and the error split into blur and noise."""

from __future__ import annotations

from functools import cache

import numpy as np

from mcdenoise.filters import gaussian
from mcdenoise.metrics import relmse
from mcdenoise.render import capture
from mcdenoise.study.figures._references import reference

SCENES = ("pinhole", "soft_shadow", "motion", "dof", "glossy")
SIZE = 128
MOST_SPP = 32


@cache
def _radiance(scene: str) -> np.ndarray:
    """Return all samples' radiance (128, 128, 32, 3): rendered once, shared by all figures."""
    return capture(scene, width=SIZE, height=SIZE, spp=MOST_SPP, seed=2)["radiance"]


def renders(scene: str, spp: int) -> np.ndarray:
    """Return 32 / spp independent images (n, 128, 128, 3) of `spp` samples a pixel: the samples of one render, dealt out."""
    samples = _radiance(scene)
    groups = samples.reshape(SIZE, SIZE, MOST_SPP // spp, spp, 3)
    return np.moveaxis(groups.mean(axis=3), 2, 0)


def split_error(filtered: np.ndarray, blurred: np.ndarray, target: np.ndarray) -> tuple[float, float, float]:
    """Return relMSE, its blur part and its noise part, for a linear filter K.

    K image - target = (K target - target) + (K image - K target): what the filter does to the truth (bias), and what is
    left of the noise. The mean squares of the two add up to the relMSE but for the mean of twice their product, which
    averages to 0 over renders.

    Parameters
    ----------
    filtered, blurred, target : K image, K target and the reference, each (h, w, c).

    Examples
    --------
    >>> target = np.full((8, 8), 0.5)
    >>> split_error(target + 0.1, target, target)[1]
    0.0
    """
    noise = (filtered.astype(np.float64) - blurred) ** 2 / (target.astype(np.float64) ** 2 + 0.01)
    return relmse(filtered, target), relmse(blurred, target), float(noise.mean())


def error_curves(scene: str, spp: int, sigmas: np.ndarray) -> np.ndarray:
    """Return relMSE, blur part and noise part (3, len(sigmas)), each the mean over at most 4 renders."""
    target = reference(scene)
    together = np.concatenate([target, *renders(scene, spp)[:4]], axis=-1)  # channels do not mix: one call for all
    curves = []
    for sigma_space in sigmas:
        blurred, *filtered = np.split(gaussian(together, sigma_space=sigma_space), together.shape[-1] // 3, axis=-1)
        curves.append(np.mean([split_error(image, blurred, target) for image in filtered], axis=0))
    return np.transpose(curves)


def unfiltered_error(scene: str, spp: int) -> float:
    """Return the mean relMSE of the renders as they are."""
    return float(np.mean([relmse(image, reference(scene)) for image in renders(scene, spp)[:4]]))
