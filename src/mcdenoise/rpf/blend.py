"""Chapter 06, third step: blend each sample of a pixel with all of its neighbourhood, then take out spikes."""

from __future__ import annotations

import numpy as np


def pair_weights(
    standardised: np.ndarray, factors: np.ndarray, spp: int, space: np.ndarray | None = None
) -> np.ndarray:
    """Weights of each of the pixel's samples with every sample of the neighbourhood, itself included.

    w_ij = exp(-sum over k of factor_k (x_ik - x_jk)^2), times the spatial factor where every sample of a box is taken.

    Parameters
    ----------
    standardised : (n, k), features and radiance of all samples, those of the pixel first.
    factors : (k,), beta and alpha over twice their sigma squared.
    spp : how many samples the pixel has.
    space : (spp, n), factors of screen distance; None: 1.

    Returns
    -------
    (spp, n)

    Examples
    --------
    Two alike, and one far away:

    >>> pair_weights(np.array([[0.0], [0.0], [9.0]]), np.ones(1), spp=1).round(6)
    array([[1., 1., 0.]])
    """
    ### BEGIN SOLUTION
    weights = np.empty((spp, len(standardised)))
    for i in range(spp):
        weights[i] = np.exp(-((standardised - standardised[i]) ** 2) @ factors)
    return weights if space is None else weights * space
    ### END SOLUTION


def blend_sums(weights: np.ndarray, radiance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sums over the neighbourhood for each of the pixel's samples, apart.

    Returns
    -------
    total : (spp, 3), sum over j of w_ij c_j. norm : (spp,), sum over j of w_ij.

    Examples
    --------
    >>> blend_sums(np.array([[1.0, 0.5]]), np.array([[1.0, 1.0, 1.0], [4.0, 4.0, 4.0]]))
    (array([[3., 3., 3.]]), array([1.5]))
    """
    return weights @ radiance, weights.sum(axis=1)


def remove_spikes(blended: np.ndarray, spikes: str, limit: float = 1.0) -> np.ndarray:
    """Change samples of one pixel that are far from its mean.

    What that does to the mean: ``"mean"`` may move it either way, and the colour with it, since channels are judged one by
    one; ``"joint"`` leaves it as it is; ``"clamp"`` only lowers it.

    Parameters
    ----------
    blended : (spp, 3). spikes : as in `RPFConfig`. limit : standard deviations of the pixel's samples.

    Returns
    -------
    (spp, 3)

    Examples
    --------
    >>> remove_spikes(np.repeat([[0.0], [0.0], [0.0], [8.0]], 3, axis=1), "joint")[:, 0]
    array([1.5, 1.5, 1.5, 3.5])
    """
    if spikes == "none":
        return blended
    mean, deviation = blended.mean(axis=0), blended.std(axis=0)
    if spikes == "clamp":
        return np.minimum(blended, mean + limit * deviation)
    far = np.abs(blended - mean) > limit * deviation
    if spikes == "mean":
        return np.where(far, mean, blended)
    kept = np.where(far.all(axis=1, keepdims=True), mean, blended)
    return kept + (mean - kept.mean(axis=0))
