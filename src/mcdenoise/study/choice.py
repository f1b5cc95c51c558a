"""The simplest that is as good as the best, as far as the image can tell: errors tile by tile, compared in pairs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcdenoise.samples.gate import check_float_array, check_nonfinite
from mcdenoise.study.front import pareto_front

TILE = 16  # pixels; windows of filters reach about as far, so tiles err nearly independently
RESAMPLINGS = 1000


def tile_means(errors: np.ndarray) -> np.ndarray:
    """Means of an error map over tiles of about 16 x 16 pixels, of 8 x 8 in images below 64 pixels: (tiles,), float64.

    Parameters
    ----------
    errors : (h, w)

    Examples
    --------
    >>> tile_means(np.kron([[0.0, 1.0], [2.0, 3.0]], np.ones((8, 8))))
    array([0., 1., 2., 3.])
    """
    rows, columns = (max(1, side // (TILE if side >= 4 * TILE else TILE // 2)) for side in errors.shape)
    blocks = [np.array_split(row, columns, axis=1) for row in np.array_split(errors, rows, axis=0)]
    return np.array([block.mean(dtype=np.float64) for row in blocks for block in row])


def mean_and_error(values: np.ndarray) -> tuple[float, float]:
    """Return the mean of independent values, two or more, and its standard error, from their spread.

    Examples
    --------
    >>> mean_and_error(np.array([1.0, 3.0]))
    (2.0, 1.0)
    """
    return float(values.mean()), float(values.std(ddof=1) / np.sqrt(len(values)))


@dataclass(frozen=True, eq=False)
class Choice:
    """Which model to take, out of several in order of simplicity, the simplest first.

    Attributes
    ----------
    chosen, best : indices of the one to take and of the one with the smallest mean error
    behind : (m,), mean error less that of the best
    standard_error : (m,), of `behind`, from the spread of the differences between tiles
    on_front : (m,) bool, no other is both faster and better
    """

    chosen: int
    best: int
    behind: np.ndarray
    standard_error: np.ndarray
    on_front: np.ndarray


def simplest_like_best(errors: np.ndarray, seconds: Sequence[float] | None = None) -> Choice:
    """Choose the first model that the tiles cannot tell from the best: less than one standard error behind it.

    Differences are taken tile by tile, because tiles differ in difficulty far more than models do: the rule of one standard
    error (`capacity.smallest_model`) with the spread of the differences in place of the spread of errors.

    Parameters
    ----------
    errors : (m, tiles), two tiles or more; models in order of simplicity, the simplest first
    seconds : (m,), if only models on the Pareto front may be chosen

    Raises
    ------
    ValueError
        If the shapes do not fit or an error is not finite.

    Examples
    --------
    >>> found = simplest_like_best(np.array([[0.9, 0.9, 0.8], [0.2, 0.3, 0.4], [0.3, 0.2, 0.3]]))
    >>> found.chosen, found.best, found.behind.round(2).tolist()
    (1, 2, [0.6, 0.03, 0.0])
    """
    errors = check_nonfinite(check_float_array(errors, "errors"), "errors").astype(np.float64)
    if (
        errors.ndim != 2
        or len(errors) == 0
        or errors.shape[1] < 2
        or (seconds is not None and len(seconds) != len(errors))
    ):
        count = "" if seconds is None else f", with {len(seconds)} times"
        raise ValueError(f"errors must be (models, tiles), a model and two tiles at least, got {errors.shape}{count}.")
    means = errors.mean(axis=1)
    best = int(np.argmin(means))
    differences = errors - errors[best]
    standard_error = differences.std(axis=1, ddof=1) / np.sqrt(errors.shape[1])
    front = np.ones(len(errors), bool) if seconds is None else pareto_front(np.asarray(seconds), means)
    behind = means - means[best]
    chosen = int(np.flatnonzero(front & (behind <= standard_error))[0])
    return Choice(chosen, best, behind, standard_error, front)


def how_sure(errors: np.ndarray, seconds: Sequence[float] | None = None, seed: int = 0) -> float:
    """Return in which share of resamplings of the tiles `simplest_like_best` chooses the same (bootstrap).

    Examples
    --------
    >>> how_sure(np.array([[0.9, 0.9, 0.8], [0.2, 0.3, 0.4]]))
    1.0
    """
    rng = np.random.default_rng(seed)
    tiles = errors.shape[1]
    chosen = simplest_like_best(errors, seconds).chosen
    turns = (rng.integers(tiles, size=tiles) for _ in range(RESAMPLINGS))
    return float(np.mean([simplest_like_best(errors[:, turn], seconds).chosen == chosen for turn in turns]))
