"""Chapter 08: what a wrong gradient looks like. Each of the usual mistakes leaves its mark in the numbers."""

from __future__ import annotations

import numpy as np

LIKENESS = 1e-4  # relative; far above the error of central differences
ROWS = 64  # of a batch, that are tried one by one


def guess_numbers(
    found: np.ndarray, expected: np.ndarray, change: np.ndarray, d_y: np.ndarray, received: np.ndarray
) -> str:
    """Guess which mistake explains a gradient; an empty text if none does.

    Parameters
    ----------
    found, expected : (k,), the gradient's first k numbers and what they should be
    change : (k, *y.shape), dy / d number, from differences
    d_y : the gradient that came from above
    received : the whole gradient, in its shape

    Examples
    --------
    >>> change = np.array([[1.0, 2.0], [0.0, 1.0]])
    >>> d_y = np.array([3.0, 5.0])
    >>> guess_numbers(-change @ d_y, change @ d_y, change, d_y, -change @ d_y)
    'The sign is flipped.'
    >>> guess_numbers(change.T @ d_y, change @ d_y, change, d_y, change.T @ d_y)
    'It is multiplied by the transposed matrix.'
    """
    if not found.any():
        return "All zero: does d_y arrive?"
    if _like(found, -expected):
        return "The sign is flipped."
    whole = len(found) == received.size
    if whole and d_y.size == received.size and _like(found, change.reshape(len(found), -1).T @ d_y.ravel()):
        return "It is multiplied by the transposed matrix."
    square = whole and received.ndim == 2 and received.shape[0] == received.shape[1]
    if square and _like(received, expected.reshape(received.shape).T):
        return "It is transposed: rows and columns are exchanged."
    return _guess_factor(found, expected, d_y) or _guess_rows(found, change, d_y) or _guess_upstream(received, d_y)


def guess_shape(received: np.ndarray, shape: tuple[int, ...]) -> str:
    """Guess why a gradient has another shape than its input.

    Examples
    --------
    >>> guess_shape(np.ones((8, 3)), (3,))
    'The sum over the batch is missing: every row used this input.'
    """
    if received.ndim == len(shape) + 1 and received.shape[1:] == shape:
        return "The sum over the batch is missing: every row used this input."
    if len(shape) > 1 and received.shape == shape[::-1]:
        return "It is transposed: a gradient has the shape of its input."
    if received.ndim < len(shape):
        return "It is summed too often: a gradient has the shape of its input."
    return "A gradient has the shape of its input."


def _like(one: np.ndarray, other: np.ndarray) -> bool:
    """Equal, but for the error of differences."""
    return bool(np.linalg.norm(one - other) <= LIKENESS * np.linalg.norm(other))


def _guess_factor(found: np.ndarray, expected: np.ndarray, d_y: np.ndarray) -> str:
    """A constant factor: 2, 1/2, the number of rows, or another."""
    square = float(expected @ expected)
    factor = float(found @ expected) / square if square else 0.0
    if not factor or not _like(found, factor * expected):
        return ""
    rows = d_y.shape[0] if d_y.ndim > 1 else 0
    known = [
        (0.5, "Half of what is expected: is a factor of 2 missing?"),
        (2, "Twice what is expected: is there a factor of 2 too many?"),
    ]
    if rows:
        known += [
            (1 / rows, f"1/{rows} of what is expected, and the batch has {rows} rows: a mean in place of their sum?"),
            (rows, f"{rows} times what is expected, and the batch has {rows} rows: is a division by them missing?"),
        ]
    words = [text for value, text in known if np.isclose(factor, value, rtol=LIKENESS)]
    return words[0] if words else f"A constant factor of {factor:.4g}."


def _guess_rows(found: np.ndarray, change: np.ndarray, d_y: np.ndarray) -> str:
    """One row of the batch alone."""
    for row in range(d_y.shape[0] if d_y.ndim > 1 and 1 < d_y.shape[0] <= ROWS else 0):
        alone = np.tensordot(change[:, row], d_y[row], d_y.ndim - 1)
        if alone.any() and _like(found, alone):
            return f"Only row {row} of the batch counts: the gradient is the sum over all rows."
    return ""


def _guess_upstream(received: np.ndarray, d_y: np.ndarray) -> str:
    """d_y handed on as it came."""
    same = received.shape == d_y.shape and _like(received, d_y)
    return "It is d_y itself: the local gradient is missing." if same else ""
