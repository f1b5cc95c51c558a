"""`assert_matches`: compare a student's result with what it should be, and say what is wrong in the field's words.

One diagnosis only, the most likely one, and only what fits within the tolerance: kind, shape and NaN here, patterns such
as a shift or a constant factor in `patterns`.
"""

from __future__ import annotations

import numpy as np

from mcdenoise.classroom.checking.describe import count, describe, index, number
from mcdenoise.classroom.checking.finding import Finding
from mcdenoise.classroom.checking.patterns import Comparison, explain
from mcdenoise.classroom.checking.shapes import explain_shape


def assert_matches(
    received: object, expected: object, what: str, *, rtol: float = 1e-6, atol: float | None = None
) -> None:
    """Raise Finding, with a diagnosis, unless a result is what it should be: |received - expected| <= atol + rtol |expected|.

    Parameters
    ----------
    received : what the student's function returned: a number, an array, or nested lists of numbers.
    expected : a number or array of any shape (or a text). Of three axes and more the first two are read as rows (y) and
        columns (x), a last one of three as RGB.
    what : names the result in the message, for example ``"total for an impulse"``.
    rtol, atol : tolerances; `atol` is rtol times the largest magnitude of `expected` by default.

    Raises
    ------
    Finding
        ``what: diagnosis; worst entry (y, x): yours ..., expected ...``

    Examples
    --------
    >>> bell = [0.1, 0.6, 1.0, 0.6, 0.1, 0.0]
    >>> assert_matches([0.1, 0.6, 1.0, 0.6, 0.1, 1e-9], bell, "the bell")
    >>> assert_matches([0.2, 1.2, 2.0, 1.2, 0.2, 0.0], bell, "the bell")
    Traceback (most recent call last):
    ...
    mcdenoise.classroom.checking.finding.Finding: the bell: a constant factor of 2; worst entry 2: yours 2, expected 1.
    """
    if isinstance(expected, str):
        if not (isinstance(received, str) and received == expected):
            raise Finding(f"{what}: yours is {describe(received)}, expected is {describe(expected)}.")
        return
    expected = np.asarray(expected)
    values = _numbers(received, expected, what)
    if values.shape != expected.shape:
        raise Finding(f"{what}: {explain_shape(values.shape, expected.shape)}")
    largest = float(np.abs(expected[np.isfinite(expected)]).max(initial=0.0))
    both = Comparison(values.astype(float), expected.astype(float), rtol, rtol * largest if atol is None else atol)
    wrong = both.wrong()
    if wrong.any():
        with np.errstate(all="ignore"):
            cause = _truncated(values, both) or _not_finite(both) or explain(both, single=values.dtype == np.float32)
            raise Finding(f"{what}: {cause or _size_of_error(both, wrong)}; {_worst(both, wrong)}.")


def _numbers(received: object, expected: np.ndarray, what: str) -> np.ndarray:
    """The result as an array of real numbers (or truth values)."""
    needed = f"an array of shape {expected.shape}" if expected.ndim else "a number"
    if received is None:
        raise Finding(f"{what}: nothing came back (None): is the `return` missing?")
    if isinstance(received, tuple) and any(np.ndim(one) for one in received if isinstance(one, np.ndarray)):
        raise Finding(f"{what}: {describe(received)} came back; {needed} is needed.")
    try:
        values = np.asarray(received)
    except ValueError:
        raise Finding(f"{what}: a list with rows of different lengths came back; {needed} is needed.") from None
    if values.dtype.kind == "c":
        raise Finding(
            f"{what}: complex numbers came back (imaginary parts up to {number(np.abs(values.imag).max(initial=0))}); "
            f"real ones are needed."
        )
    if values.dtype.kind not in "biuf":
        inside = f" holding {describe(values.flat[0])}" if values.ndim and values.size else ""
        kind = describe(received) if isinstance(received, str) or not values.ndim else f"an array or list{inside}"
        raise Finding(f"{what}: {kind} came back; {needed} is needed.")
    return values


def _truncated(values: np.ndarray, both: Comparison) -> str:
    if values.dtype.kind not in "iu":
        return ""
    for name, whole in (("cut off", np.trunc), ("cut off", np.floor), ("rounded away", np.rint)):
        if both.fits(values, whole(both.expected)):
            return f"whole numbers came back ({values.dtype}), the decimals are {name}: make the result a float array"
    return ""


def _not_finite(both: Comparison) -> str:
    bad = ~np.isfinite(both.yours) & (both.yours != both.expected) & ~(np.isnan(both.yours) & np.isnan(both.expected))
    if not bad.any():
        return ""
    kinds = [(np.isnan(both.yours) & bad, "NaN (0/0?)"), (np.isinf(both.yours) & bad, "infinite (division by 0?)")]
    mask, name = next((mask, name) for mask, name in kinds if mask.any())
    if not both.yours.ndim:
        return f"the result is {name}"
    where = f"{count(int(mask.sum()), 'entry')} of {mask.size} {'is' if mask.sum() == 1 else 'are'} {name}"
    rest = ", all others are right" if not (both.wrong() & ~bad).any() and not bad.all() else ""
    return f"{where}, first at {index(np.argwhere(mask)[0])}{rest}"


def _size_of_error(both: Comparison, wrong: np.ndarray) -> str:
    if not wrong.ndim:
        return f"off by {number(both.yours - both.expected)}"
    if both.is_truth:
        return f"{count(int(wrong.sum()), 'entry')} of {wrong.size} {'differs' if wrong.sum() == 1 else 'differ'}"
    size = np.linalg.norm(np.nan_to_num(both.expected))
    error = np.linalg.norm(np.nan_to_num(both.yours - both.expected))
    relative = f"relative error {number(error / size)}" if size > 0 else f"error {number(error)} where all is 0"
    return f"{relative}, {100 * (1 - wrong.mean()):.0f} % of the entries are right"


def _worst(both: Comparison, wrong: np.ndarray) -> str:
    error = np.where(np.isfinite(both.yours), np.abs(both.yours - both.expected), np.inf)
    worst = np.unravel_index(np.argmax(np.where(wrong, error, -1.0)), wrong.shape)
    yours, expected = both.yours[worst], both.expected[worst]
    values = f"yours {number(yours)}, expected {number(expected)}"
    if both.is_truth:
        values = f"yours {bool(yours)}, expected {bool(expected)}"
    elif number(yours) == number(expected):
        values = f"yours {yours:.10g}, expected {expected:.10g}"
    return f"worst entry {index(worst)}: {values}" if wrong.ndim else values
