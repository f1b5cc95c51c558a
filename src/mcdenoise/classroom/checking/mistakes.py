"""`name_mistake`: recognise a usual mistake by the numbers that it gives; and what tests of several chapters need beside it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from mcdenoise.classroom.checking.describe import number
from mcdenoise.classroom.checking.finding import Finding

RELATIVE, ABSOLUTE = 1e-5, 1e-9
FEW = 12  # numbers that are all written out


def name_mistake(received: object, expected: object, mistakes: Mapping[str, object], what: str) -> None:
    """Raise Finding if a result is what one of the mistakes gives, and not what it should be.

    Anything else passes, also what is no array of numbers at all: `assert_matches`, called next, says so better.

    Parameters
    ----------
    received : what the student's function returned
    expected : a number or array
    mistakes : words -> the number or array that this mistake gives
    what : names the result in the message

    Raises
    ------
    Finding
        ``what: words; yours ..., expected ...``

    Examples
    --------
    >>> name_mistake([1.0, 4.0], [1.0, 2.0], {"squared": [1.0, 4.0]}, "the roots")
    Traceback (most recent call last):
    ...
    mcdenoise.classroom.checking.finding.Finding: the roots: squared; yours [1.0, 4.0], expected [1.0, 2.0].
    """
    values = as_numbers(received)
    if values is None or _same(values, expected):
        return
    for words, value in mistakes.items():
        if _same(values, value):
            raise Finding(f"{what}: {words}; yours {_text(values)}, expected {_text(expected)}.")


def as_numbers(found: object) -> np.ndarray | None:
    """The answer as a float array, or None where it is none.

    Examples
    --------
    >>> as_numbers((1, True)), as_numbers("two"), as_numbers([[1], [2, 3]])
    (array([1., 1.]), None, None)
    """
    if found is None or isinstance(found, str):
        return None
    try:
        values = np.asarray(found)
    except ValueError:
        return None
    return values.astype(float) if values.dtype.kind in "biuf" else None


def as_parts(found: object, names: Sequence[str]) -> Sequence[object]:
    """The parts of an answer of several things.

    Raises
    ------
    Finding
        If nothing came back, or another number of parts.

    Examples
    --------
    >>> as_parts((1, 2), ["d_x", "d_weight"])
    (1, 2)
    >>> as_parts(1, ["d_x", "d_weight"])
    Traceback (most recent call last):
    ...
    mcdenoise.classroom.checking.finding.Finding: 2 things are needed, d_x, d_weight, in this order; something else came back.
    """
    if found is None:
        raise Finding("nothing came back (None): is the `return` missing?")
    if not isinstance(found, (tuple, list)) or len(found) != len(names):
        raise Finding(f"{len(names)} things are needed, {', '.join(names)}, in this order; something else came back.")
    return found


def central_differences(function: Callable[[np.ndarray], float], x: np.ndarray, step: float = 1e-5) -> np.ndarray:
    """Slopes of a function of arrays to one number, with respect to every entry of x.

    Examples
    --------
    >>> central_differences(lambda x: x[0] * x[1], np.array([2.0, 3.0])).round(6)
    array([3., 2.])
    """
    slopes = np.zeros(x.shape)
    for place in np.ndindex(x.shape):
        ends = []
        for sign in (1, -1):
            moved = x.copy()
            moved[place] += sign * step
            ends.append(function(moved))
        slopes[place] = (ends[0] - ends[1]) / (2 * step)
    return slopes


def _same(values: np.ndarray, others: object) -> bool:
    """Of one shape, and equal up to rounding; NaN is NaN."""
    return values.shape == np.shape(others) and np.allclose(values, others, RELATIVE, ABSOLUTE, equal_nan=True)


def _text(values: object) -> str:
    """A few numbers in full, of many the first and the last."""
    values = np.asarray(values, float)
    if values.ndim == 0:
        return number(float(values))
    if values.size <= FEW:
        return str(np.round(values, 3).tolist())
    return np.array2string(values, precision=3, separator=", ", threshold=FEW).replace("\n", "")
