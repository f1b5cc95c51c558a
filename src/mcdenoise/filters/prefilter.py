"""Chapter 04: how noisy is a pixel, and features with less noise: what NL-means and the features need from samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcdenoise.filters.gaussian import gaussian
from mcdenoise.filters.nlm import nlm
from mcdenoise.filters.window import with_channels
from mcdenoise.samples.buffer import SampleBuffer
from mcdenoise.samples.gate import check_count, check_float_array
from mcdenoise.samples.statistics import pixel_mean, variance_of_mean


def noise_variance(samples: np.ndarray, *, radius: int = 1, engine: str = "numba") -> np.ndarray:
    """Variance of the pixel means, averaged over a small window: how far each pixel may be off.

    The variance estimated from few samples is itself noisy, and small just where a pixel happens to be too dark. Its
    mean over neighbours is steadier. With one sample a pixel there is no variance within pixels; then the variance
    between the pixels of the window, at least 3 x 3, stands in: too large at edges, but never blind.

    Parameters
    ----------
    samples : (h, w, spp) or (h, w, spp, c), such as ``buffer.radiance``.
    radius : average over (2 radius + 1)^2 pixels; 0: do not.
    engine : of the average, ``"numba"`` or ``"numpy"``.

    Returns
    -------
    (h, w) or (h, w, c), >= 0, same dtype, in the unit of the samples squared.

    Raises
    ------
    ValueError
        As `pixel_mean`, or for a radius that is no whole number >= 0.

    Examples
    --------
    >>> noise_variance([[[1.0, 3.0], [5.0, 5.0]]], engine="numpy")
    array([[0.5, 0.5]])
    """
    radius = check_count(radius, "radius", least=0)
    window = {"sigma_space": np.inf, "engine": engine}
    samples = check_float_array(samples, "samples")
    mean = pixel_mean(samples)
    if samples.shape[2] > 1:
        variance = variance_of_mean(samples)
        return gaussian(variance, radius=radius, **window) if radius else variance
    radius = max(radius, 1)
    centred = mean - mean.mean(axis=(0, 1))  # a difference of squares loses fewer digits near 0
    spread = gaussian(centred**2, radius=radius, **window) - gaussian(centred, radius=radius, **window) ** 2
    return np.maximum(spread, 0)


def prefilter_features(
    samples: SampleBuffer, names: Sequence[str] | None = None, *, engine: str = "numba"
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Pixel means of features with their own noise removed by NL-means, and the variances that are left.

    Each feature is compared with itself: search window 11 x 11, patches 7 x 7, k = 1, nothing taken off, weights
    averaged over 5 x 5. The same weights average the feature and its variance.

    Parameters
    ----------
    samples : whose features to take.
    names : the features to take; default: all.
    engine : of NL-means, ``"numba"`` or ``"numpy"``.

    Returns
    -------
    features, variances : two dicts with the same names, each array (h, w) or (h, w, c), ready for `cross_bilateral` and
        `joint_nlm`. The variance is an upper bound: that of an average of equals would be smaller.

    Raises
    ------
    ValueError
        For a name that the samples lack, or one named twice.

    References
    ----------
    Kalantari, Bako and Sen 2015, the authors' released code (windows and k); they estimate variances from two halves.

    Examples
    --------
    >>> corner = np.stack(np.meshgrid(np.arange(3), np.arange(2)), axis=-1)[:, :, np.newaxis]
    >>> albedo = np.full((2, 3, 1, 3), 0.5)
    >>> samples = SampleBuffer.from_arrays(np.ones((2, 3, 1, 3)), corner + 0.5, features={"albedo": albedo})
    >>> features, variances = prefilter_features(samples)
    >>> float(features["albedo"].max()), float(variances["albedo"].max())
    (0.5, 0.0)
    """
    features, variances = {}, {}
    for field in samples.layout.chosen("features", names):
        mean = pixel_mean(samples[field.name])
        variance = noise_variance(samples[field.name], radius=0, engine=engine)
        features[field.name], variances[field.name] = prefilter_feature(mean, variance, engine)
    return features, variances


def prefilter_feature(mean: np.ndarray, variance: np.ndarray, engine: str = "numba") -> tuple[np.ndarray, np.ndarray]:
    """One feature with its noise removed by NL-means, as `prefilter_features` does for each, and the variance left.

    Parameters
    ----------
    mean, variance : (h, w) or (h, w, c), pixel means and how far they may be off, squared.
    engine : ``"numba"`` or ``"numpy"``.

    Returns
    -------
    filtered, variance : both of the shape of `mean`; `filtered` stays within the range of `mean`.

    Raises
    ------
    ValueError
        As `nlm`.

    Examples
    --------
    >>> filtered, variance = prefilter_feature(np.array([[1.0, 1.2]]), np.full((1, 2), 0.5), "numpy")
    >>> filtered.round(2), variance
    (array([[1.1, 1.1]]), array([[0.5, 0.5]]))
    """
    channels = with_channels(mean).shape[-1]
    both = np.concatenate([with_channels(mean), with_channels(variance)], axis=-1)
    filtered = nlm(
        both, variance, guide=mean, search_radius=5, patch_radius=3, k=1.0, weight_radius=2, cancellation=0.0,
        engine=engine,
    )  # fmt: skip
    inside = np.clip(filtered[..., :channels], mean.min(), mean.max())  # rounding must not leave the range
    return inside.reshape(mean.shape), np.maximum(filtered[..., channels:], 0).reshape(mean.shape)
