"""Chapter 10: is a filter wrong, or restless? Bias and variance apart; and a mean that bears bad samples."""

from __future__ import annotations

import numpy as np


def bias_and_variance(images: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Squared bias and variance of each pixel, estimated from images of independent seeds.

    What n images give is noisy itself: the square of their mean's error holds a part of the variance, which is taken off.
    So the expected value of the estimate is right for any n, and where the bias is small it may come out below 0.

    Parameters
    ----------
    images : (n, ...), one image a seed, n >= 2
    truth : (...), the shape of one image

    Returns
    -------
    bias_squared, variance : (...), float64; their sum is the expected squared error of one image

    Examples
    --------
    >>> bias_and_variance(np.array([[1.0], [3.0]]), np.array([0.0]))
    (array([3.]), array([2.]))
    """
    ### BEGIN SOLUTION
    images, truth = np.asarray(images, float), np.asarray(truth, float)
    if images.ndim < 1 or len(images) < 2 or images.shape[1:] != truth.shape:
        raise ValueError(
            f"images must be (n, ...) with n >= 2 and truth the shape of one, got {images.shape} and {truth.shape}. "
            f"Stack the images of two seeds or more."
        )
    variance = images.var(axis=0, ddof=1)
    return (images.mean(axis=0) - truth) ** 2 - variance / len(images), variance
    ### END SOLUTION


def median_of_means(radiance: np.ndarray, groups: int) -> np.ndarray:
    """The median of the means of groups of each pixel's samples, channel by channel.

    The samples are cut into groups in their order: the sizes differ by one at most, the larger groups come first.

    Parameters
    ----------
    radiance : (h, w, spp, 3)
    groups : from 1 (the mean) to spp (the median of the samples)

    Returns
    -------
    image : (h, w, 3), same dtype

    References
    ----------
    Nemirovsky & Yudin 1983, "Problem complexity and method efficiency in optimization".

    Examples
    --------
    >>> samples = np.array([1.0, 1.0, 2.0, 2.0, 3.0, 1000.0]).reshape(1, 1, 6, 1) * np.ones(3)
    >>> median_of_means(samples, 3)
    array([[[2., 2., 2.]]])
    """
    ### BEGIN SOLUTION
    if radiance.ndim != 4 or not np.isfinite(radiance).all():
        raise ValueError(
            f"radiance must be (h, w, spp, 3) and finite, got {radiance.shape}. Pass samples such as buffer.radiance."
        )
    if not 1 <= groups <= radiance.shape[2]:
        raise ValueError(
            f"groups must be from 1 to the spp, {radiance.shape[2]}, got {groups}. A group needs a sample."
        )
    means = [part.mean(axis=2, dtype=np.float64) for part in np.array_split(radiance, groups, axis=2)]
    return np.median(means, axis=0).astype(radiance.dtype)
    ### END SOLUTION
