"""What `compare` can run: one entry a method, samples in, image out. A later chapter joins by adding its entry here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdenoise.filters import bilateral, cross_bilateral, gaussian
from mcdenoise.samples import SampleBuffer, pixel_mean


@dataclass(frozen=True)
class Method:
    """One way from samples to an image.

    Attributes
    ----------
    name : what the command line calls it
    label : what charts and tables call it
    chapter : where the course explains it
    parameters : samples -> the keyword arguments of `run`, chosen without the reference
    run : (samples, **parameters) -> (h, w, 3) float32
    """

    name: str
    label: str
    chapter: int
    parameters: Callable[[SampleBuffer], Mapping[str, Any]]
    run: Callable[..., np.ndarray]


def feature_bandwidths(samples: SampleBuffer) -> dict[str, float]:
    """Choose one bandwidth per first-hit feature: half the spread of its pixel means over the image.

    The spread is the root mean square distance from the mean, over all channels, so that the choice follows the units of the
    scene. Features that do not vary over the image are left out; so are second hits, which chapter 04 takes up.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(8), np.arange(8)), axis=-1)[:, :, np.newaxis]
    >>> noise = rng.random((8, 8, 1, 3))
    >>> samples = SampleBuffer.from_arrays(noise, corner + 0.5, features={"albedo": noise, "depth": 0 * noise})
    >>> {name: round(sigma, 1) for name, sigma in feature_bandwidths(samples).items()}
    {'albedo': 0.2}
    """
    bandwidths = {}
    for name in samples.feature_names:
        if name.endswith("_2"):
            continue
        mean = pixel_mean(samples[name]).reshape(samples.height * samples.width, -1)
        spread = float(np.sqrt(mean.var(axis=0, dtype=np.float64).sum()))
        if spread > 0:
            bandwidths[name] = FEATURE_SHARE * spread
    return bandwidths


def _gaussian(samples: SampleBuffer, **parameters: float) -> np.ndarray:
    return gaussian(pixel_mean(samples.radiance), **parameters)


def _bilateral(samples: SampleBuffer, **parameters: float) -> np.ndarray:
    return bilateral(pixel_mean(samples.radiance), **parameters)


def _cross_bilateral(samples: SampleBuffer, **parameters: Any) -> np.ndarray:
    return cross_bilateral(pixel_mean(samples.radiance), samples, **parameters)


FEATURE_SHARE = 0.25

METHODS = {
    method.name: method
    for method in (
        Method("gaussian", "Gaussian", 2, lambda samples: {"sigma_space": 1.5}, _gaussian),
        Method("bilateral", "bilateral", 3, lambda samples: {"sigma_space": 2.5, "sigma_radiance": 0.5}, _bilateral),
        Method(
            "cross_bilateral",
            "cross-bilateral",
            4,
            lambda samples: {"sigma_space": 4.0, "sigma_radiance": 1.0, "sigma_features": feature_bandwidths(samples)},
            _cross_bilateral,
        ),
    )
}
