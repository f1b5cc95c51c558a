"""Chapter 10: the chart of speed against accuracy. Who is on the front, and what is a filter worth in samples?"""

from __future__ import annotations

import numpy as np


def pareto_front(seconds: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Whether each point of the chart is on the Pareto front: no other point dominates it.

    A point dominates another if it is at most as slow and at most as wrong, and better in one of the two.

    Parameters
    ----------
    seconds, errors : (n,), any order

    Returns
    -------
    on_front : (n,) bool

    Examples
    --------
    >>> pareto_front(np.array([1.0, 2.0, 3.0]), np.array([0.5, 0.6, 0.1]))
    array([ True, False,  True])
    """
    ### BEGIN SOLUTION
    seconds, errors = np.asarray(seconds), np.asarray(errors)
    if seconds.ndim != 1 or seconds.shape != errors.shape or not np.isfinite([seconds, errors]).all():
        raise ValueError(
            f"seconds and errors must be finite and of one shape (n,), got {seconds.shape} and {errors.shape}. "
            f"Leave out what was not measured."
        )
    slower = seconds[:, np.newaxis] - seconds  # this point in its row, the others in the columns
    wronger = errors[:, np.newaxis] - errors
    is_beaten = (slower >= 0) & (wronger >= 0) & ((slower > 0) | (wronger > 0))
    return ~is_beaten.any(axis=1)
    ### END SOLUTION


def equal_error_spp(error: float, spp: np.ndarray, mc_errors: np.ndarray) -> float:
    """How many samples per pixel plain Monte Carlo needs to come down to an error.

    The curve of Monte Carlo was measured at some spp. Between two of them log(error) is a straight line over log(spp);
    outside, error x spp is that of the first or the last point.

    Parameters
    ----------
    error : above 0
    spp, mc_errors : (m,), the measured curve; spp ascending, errors above 0

    Returns
    -------
    The smallest spp at which the curve is down to `error`, not rounded.

    Examples
    --------
    >>> spp, mc_errors = np.array([4, 16]), np.array([0.08, 0.02])
    >>> [round(equal_error_spp(error, spp, mc_errors), 6) for error in (0.16, 0.04, 0.01)]
    [2.0, 8.0, 32.0]
    """
    ### BEGIN SOLUTION
    spp, mc_errors = np.asarray(spp, float), np.asarray(mc_errors, float)
    if spp.ndim != 1 or spp.shape != mc_errors.shape or not (spp[:1] > 0).all() or not (np.diff(spp) > 0).all():
        raise ValueError(
            f"spp and mc_errors must be (m,), spp above 0 and ascending, got {spp} and {mc_errors}. Sort both."
        )
    if not spp.size or not (error > 0 and (mc_errors > 0).all()):
        raise ValueError(
            f"error and mc_errors must be numbers above 0, got {error} and {mc_errors}. Is it a logarithm?"
        )
    reached = np.flatnonzero(mc_errors <= error)
    if not len(reached) or reached[0] == 0:
        end = 0 if len(reached) else -1
        return float(spp[end] * mc_errors[end] / error)
    after, before = reached[0], reached[0] - 1
    share = np.log(mc_errors[before] / error) / np.log(mc_errors[before] / mc_errors[after])
    return float(spp[before] * (spp[after] / spp[before]) ** share)
    ### END SOLUTION


def equal_time_error(
    seconds: float, fixed_seconds: float, seconds_per_spp: float, spp: np.ndarray, mc_errors: np.ndarray
) -> float:
    """The error of plain Monte Carlo that takes `seconds`.

    Rendering n spp takes fixed_seconds + n seconds_per_spp. Between two measured spp log(error) is a straight line over
    log(spp); outside, error x spp is that of the first or the last point.

    Parameters
    ----------
    seconds : that Monte Carlo may take; n need not be whole. fixed_seconds : >= 0. seconds_per_spp : above 0.
    spp, mc_errors : as for `equal_error_spp`

    Returns
    -------
    The error, infinite if the time pays for no sample.

    Examples
    --------
    >>> round(equal_time_error(0.9, 0.1, 0.1, np.array([4, 16]), np.array([0.08, 0.02])), 6)
    0.04
    """
    spp, mc_errors = np.asarray(spp, float), np.asarray(mc_errors, float)
    if spp.ndim != 1 or spp.shape != mc_errors.shape or not (spp[:1] > 0).all() or not (np.diff(spp) > 0).all():
        raise ValueError(
            f"spp and mc_errors must be (m,), spp above 0 and ascending, got {spp} and {mc_errors}. Sort both."
        )
    if not spp.size or not (fixed_seconds >= 0 and seconds_per_spp > 0 and (mc_errors > 0).all()):
        raise ValueError(
            f"fixed_seconds must be at least 0, seconds_per_spp and mc_errors above 0, got {fixed_seconds}, "
            f"{seconds_per_spp} and {mc_errors}. Measure at two spp that differ more."
        )
    paid = (seconds - fixed_seconds) / seconds_per_spp
    if paid <= 0:
        return float("inf")
    inside = np.clip(paid, spp[0], spp[-1])
    return float(np.exp(np.interp(np.log(inside), np.log(spp), np.log(mc_errors))) * inside / paid)
