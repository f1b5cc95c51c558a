"""Chapter 06, third step: blend each sample of a pixel with all of its neighbourhood, then take out spikes."""

from __future__ import annotations

import numpy as np


def blend_sums(
    standardised: np.ndarray, factors: np.ndarray, radiance: np.ndarray, spp: int, space: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Sums over the neighbourhood for each of the pixel's samples, apart: w c and w.

    w_ij = exp(-sum over k of factor_k (x_ik - x_jk)^2), times the spatial factor where every sample of a box is taken.

    Parameters
    ----------
    standardised : (n, k), features and radiance of all samples, those of the pixel first.
    factors : (k,), alpha and beta over twice their sigma squared.
    radiance : (n, 3), what is blended.
    spp : how many samples the pixel has.
    space : (spp, n), factors of screen distance; None: 1.

    Returns
    -------
    total : (spp, 3), sum over j of w_ij c_j. norm : (spp,), sum over j of w_ij.

    Examples
    --------
    Two alike, and one far away:

    >>> total, norm = blend_sums(np.array([[0.0], [0.0], [9.0]]), np.ones(1), np.eye(3), spp=1)
    >>> total, norm
    (array([[1.00000000e+00, 1.00000000e+00, 6.63967720e-36]]), array([2.]))
    """
    ### BEGIN SOLUTION
    total, norm = np.zeros((spp, 3)), np.zeros(spp)
    for i in range(spp):
        distance = ((standardised - standardised[i]) ** 2) @ factors
        weight = np.exp(-distance) * (1 if space is None else space[i])
        total[i], norm[i] = weight @ radiance, weight.sum()
    return total, norm
    ### END SOLUTION


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
