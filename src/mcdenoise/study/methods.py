"""What `compare` can run: one entry a method, samples in, image out. A later chapter joins by adding its entry here."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from tqdm import tqdm

from mcdenoise.filters import bilateral, cross_bilateral, gaussian
from mcdenoise.samples import SampleBuffer, pixel_mean

Parameters = Mapping[str, Any]


@dataclass(frozen=True)
class Method:
    """One way from samples to an image.

    Attributes
    ----------
    name : what the command line calls it
    label : what charts and tables call it
    chapter : where the course explains it
    candidates : samples -> parameters worth trying; the middle one serves where nothing can be tried
    run : (samples, **parameters) -> (h, w, 3) float32
    """

    name: str
    label: str
    chapter: int
    candidates: Callable[[SampleBuffer], Sequence[Parameters]]
    run: Callable[..., np.ndarray]


def choose_parameters(method: Method, samples: SampleBuffer) -> Parameters:
    """Choose the candidate with the smallest error that two independent halves of the samples let us expect: no reference.

    For halves A and B, E |F(A) - B|^2 = E |F(A) - truth|^2 + variance of B, and the last term is the same for every candidate.
    What is left is squared bias plus the variance of F(A). All samples together have half that variance, and |F(A) - F(B)|^2
    is twice it on average, so a quarter of it is taken off (exact for a linear filter). Errors are relative as in relMSE,
    with a slightly blurred A in the denominator: it must not know B. With 1 spp there are no halves: the middle candidate.

    Returns
    -------
    One of ``method.candidates(samples)``.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(16), np.arange(16)), axis=-1)[:, :, np.newaxis]
    >>> flat = SampleBuffer.from_arrays(1 + 0.5 * rng.random((16, 16, 4, 3)), np.repeat(corner + 0.5, 4, axis=2))
    >>> choose_parameters(METHODS["gaussian"], flat)
    {'sigma_space': 2.8}
    """
    candidates = method.candidates(samples)
    if samples.spp < 2:
        return candidates[len(candidates) // 2]
    half = samples.spp // 2
    halves = samples.subset(0, half), samples.subset(half, 2 * half)
    means = [pixel_mean(one.radiance) for one in halves]
    scales = [gaussian(mean, sigma_space=0.7) ** 2 + 0.01 for mean in means]

    def error(parameters: Parameters) -> float:
        filtered = [method.run(one, **parameters) for one in halves]
        excess = (filtered[0] - filtered[1]) ** 2 / 4
        pairs = zip(filtered, reversed(means), scales, strict=True)
        return sum(float((((image - other) ** 2 - excess) / scale).mean()) for image, other, scale in pairs)

    return min(tqdm(candidates, f"bandwidths of {method.label}", disable=None, leave=False), key=error)


def feature_spreads(samples: SampleBuffer) -> dict[str, float]:
    """Return how far the pixel means of each first-hit feature spread over the image: the scale of its bandwidth.

    The spread is the root mean square distance from the mean, over all channels, in the feature's own unit. Features that
    do not vary over the image are left out; so are second hits, which chapter 04 takes up.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(8), np.arange(8)), axis=-1)[:, :, np.newaxis]
    >>> noise = rng.random((8, 8, 1, 3))
    >>> samples = SampleBuffer.from_arrays(noise, corner + 0.5, features={"albedo": noise, "depth": 0 * noise})
    >>> {name: round(spread, 1) for name, spread in feature_spreads(samples).items()}
    {'albedo': 0.5}
    """
    spreads = {}
    for name in samples.feature_names:
        if not name.endswith("_2"):
            mean = pixel_mean(samples[name]).reshape(samples.height * samples.width, -1)
            spreads[name] = float(np.sqrt(mean.var(axis=0, dtype=np.float64).sum()))
    return {name: spread for name, spread in spreads.items() if spread > 0}


def _gaussian_candidates(_: SampleBuffer) -> list[Parameters]:
    return [{"sigma_space": sigma} for sigma in (0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8)]


def _bilateral_candidates(_: SampleBuffer) -> list[Parameters]:
    grid = product((0.7, 1.4, 2.8), (0.1, 0.2, 0.4, 0.8, 1.6))
    return [{"sigma_space": space, "sigma_radiance": radiance} for space, radiance in grid]


def _cross_bilateral_candidates(samples: SampleBuffer) -> list[Parameters]:
    spreads = feature_spreads(samples)
    grid = product((0.7, 1.4, 2.8), (0.1, 0.4, 1.6), (0.1, 0.3, 1.0))
    return [
        {
            "sigma_space": space,
            "sigma_radiance": radiance,
            "sigma_features": {name: share * spread for name, spread in spreads.items()},
        }
        for space, radiance, share in grid
    ]


def _run_gaussian(samples: SampleBuffer, **parameters: Any) -> np.ndarray:
    return gaussian(pixel_mean(samples.radiance), **parameters)


def _run_bilateral(samples: SampleBuffer, **parameters: Any) -> np.ndarray:
    return bilateral(pixel_mean(samples.radiance), **parameters)


def _run_cross_bilateral(samples: SampleBuffer, **parameters: Any) -> np.ndarray:
    return cross_bilateral(pixel_mean(samples.radiance), samples, **parameters)


METHODS = {
    method.name: method
    for method in (
        Method("gaussian", "Gaussian", 2, _gaussian_candidates, _run_gaussian),
        Method("bilateral", "bilateral", 3, _bilateral_candidates, _run_bilateral),
        Method("cross_bilateral", "cross-bilateral", 4, _cross_bilateral_candidates, _run_cross_bilateral),
    )
}
