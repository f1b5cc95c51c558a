"""Chapter 10: what speaks for a smaller model? Chance as the opponent, and an error that needs no reference."""

from __future__ import annotations

import numpy as np


def permutation_p_value(observed: float, permuted: np.ndarray) -> float:
    """How often chance alone does as well: the p-value of a permutation test.

    Shuffling one of two variables breaks whatever dependency they have, and leaves chance. The order observed counts as one
    of the orders that chance could have given.

    Parameters
    ----------
    observed : what was measured, such as a mutual information
    permuted : (n,), the same measure after each of n shuffles

    Returns
    -------
    p : the share of all orders whose measure is at least the observed one

    References
    ----------
    Phipson & Smyth 2010, "Permutation p-values should never be zero", https://doi.org/10.2202/1544-6115.1585

    Examples
    --------
    >>> permutation_p_value(0.5, np.array([0.1, 0.2, 0.6, 0.3]))
    0.4
    """
    ### BEGIN SOLUTION
    permuted = np.asarray(permuted)
    if permuted.ndim != 1 or not permuted.size or not (np.isfinite(observed) and np.isfinite(permuted).all()):
        raise ValueError(
            f"observed must be a finite number and permuted (n,) of them, got {observed} and {permuted.shape}. "
            f"Shuffle at least once."
        )
    return float((1 + np.sum(permuted >= observed)) / (1 + len(permuted)))
    ### END SOLUTION


def error_against_other(filtered: np.ndarray, other: np.ndarray, variance_of_other: np.ndarray) -> float:
    """Estimate the mean squared error of an image without a reference, from another image of the same scene.

    The other image must be unbiased and independent of the filtered one, such as the mean of samples that the filter did
    not see. The expected value of the estimate is the true mean squared error; on a small image it may come out below 0.

    Parameters
    ----------
    filtered, other : of one shape
    variance_of_other : same shape, `variance_of_mean` of its samples

    Returns
    -------
    error : radiance squared

    Examples
    --------
    >>> error_against_other(np.array([[1.0, 2.0]]), np.array([[1.5, 1.0]]), np.array([[0.25, 0.75]]))
    0.125
    """
    ### BEGIN SOLUTION
    shapes = {np.shape(filtered), np.shape(other), np.shape(variance_of_other)}
    if len(shapes) > 1 or not np.size(filtered):
        raise ValueError(
            f"filtered, other and variance_of_other must have one shape, not empty, got {sorted(shapes)}. Filter half "
            f"of the samples, and take the mean and the variance_of_mean of the other half."
        )
    difference = np.subtract(filtered, other, dtype=np.float64)
    return float(np.mean(difference**2 - variance_of_other))
    ### END SOLUTION
