"""Patterns that explain a wrong result as a whole: a constant factor, a shift, a flip, the border, and the like.

Each pattern answers with words only if it turns the expected values into the student's within the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from mcdenoise.classroom.checking import geometry
from mcdenoise.classroom.checking.describe import number

FACTORS = {
    "2": 2,
    "1/2": 1 / 2,
    "3": 3,
    "1/3": 1 / 3,
    "4": 4,
    "1/4": 1 / 4,
    "pi": pi,
    "1/pi": 1 / pi,
    "2 pi": 2 * pi,
    "1/(2 pi)": 1 / (2 * pi),
    "sqrt 2": sqrt(2),
    "1/sqrt 2": 1 / sqrt(2),
    "sqrt(2 pi)": sqrt(2 * pi),
    "1/sqrt(2 pi)": 1 / sqrt(2 * pi),
    "255": 255,
    "1/255": 1 / 255,
}
LARGE = 10_000  # entries
MOST_SAMPLES = 64  # N of the factor (N - 1) / N


@dataclass(frozen=True, eq=False)
class Comparison:
    """A student's values beside the expected ones, float arrays of one shape, with the tolerances."""

    yours: np.ndarray
    expected: np.ndarray
    rtol: float
    atol: float

    def wrong(self) -> np.ndarray:
        """Where they differ."""
        return ~np.isclose(self.yours, self.expected, rtol=self.rtol, atol=self.atol, equal_nan=True)

    @property
    def is_truth(self) -> bool:
        """Whether both hold nothing but 0 and 1."""
        return bool(np.isin(self.yours, (0, 1)).all() and np.isin(self.expected, (0, 1)).all())

    @property
    def largest(self) -> float:
        """Largest magnitude expected."""
        return float(np.abs(self.expected).max(initial=0.0))

    def fits(self, yours: np.ndarray, model: np.ndarray) -> bool:
        """Whether a model explains the student's values: the same tolerances, on the model's own scale."""
        scale = float(np.abs(model).max(initial=0.0))
        atol = self.atol / self.largest * scale if self.largest > 0 else self.atol
        tolerance = {"rtol": max(self.rtol, 1e-6), "atol": max(atol, 1e-9 * scale)}
        if yours.ndim >= 2 and yours.size > LARGE:  # most models are refused by a few of their entries
            few = np.s_[:: 1 + yours.shape[0] // 32, :: 1 + yours.shape[1] // 32]
            if not np.allclose(yours[few], model[few], **tolerance):
                return False
        return bool(np.allclose(yours, model, **tolerance))


def explain(both: Comparison, *, single: bool = False) -> str:
    """Return the first pattern that explains the difference, in words, or "".

    Parameters
    ----------
    both : all finite in `yours`.
    single : the student's result is float32.

    Examples
    --------
    >>> image = np.arange(12.0).reshape(3, 4)
    >>> explain(Comparison(-image, image, 1e-6, 1e-6))
    'the sign is flipped'
    >>> explain(Comparison(image[:, ::-1], image, 1e-6, 1e-6))
    'flipped left-right'
    """
    if not np.isfinite(both.expected).all():
        return ""
    if both.is_truth:
        return _exchanged(both) or geometry.explain(both) or geometry.border(both)
    return _rounding(both, single) or next((words for find in PATTERNS if (words := find(both))), "")


def _rounding(both: Comparison, single: bool) -> str:
    if not np.allclose(both.yours, both.expected, rtol=1e-5, atol=1e-5 * both.largest):
        return ""
    error = np.abs(both.yours - both.expected).max() / (both.largest or 1.0)
    cause = ": computed in float32, float64 is needed" if single else ""
    return f"nearly right, up to {number(error)} of the largest value{cause}"


def _exchanged(both: Comparison) -> str:
    return "True and False are exchanged" if both.yours.size > 1 and both.fits(both.yours, 1 - both.expected) else ""


def _sign(both: Comparison) -> str:
    return "the sign is flipped" if both.fits(both.yours, -both.expected) else ""


def _factor(both: Comparison) -> str:
    factor = factor_between(both)
    if factor is None:
        return ""
    sign = "-" if factor < 0 else ""
    for name, value in FACTORS.items():
        if abs(abs(factor) - value) < 1e-5 * value:
            return f"a constant factor of {sign}{name}"
    if both.expected.size == 1:
        return ""  # one number is a multiple of any other
    if factor > 0 and (words := _special_factor(both, factor)):
        return words
    return f"not normalised: a constant factor of {number(factor)}"


def factor_between(both: Comparison, inside: tuple = ...) -> float | None:
    """Return the one number that times the expected values gives the student's, if there is one."""
    yours, expected = both.yours[inside], both.expected[inside]
    energy = np.vdot(expected, expected)
    if not energy > 0:
        return None
    factor = float(np.vdot(yours, expected) / energy)
    return factor if factor != 0 and both.fits(yours, factor * expected) else None


def _special_factor(both: Comparison, factor: float) -> str:
    largest = 0.0 if geometry.is_bell(both.expected) else both.largest  # bells peak at 1 where they are not normalised
    for value, what in ((both.expected.sum(), "the sum of all entries"), (largest, "the largest entry")):
        if value > 0 and abs(factor * value - 1) < 1e-5:
            return f"divided by {what}: a constant factor of {number(factor)}"
    for n in range(3, MOST_SAMPLES + 1):
        for top, bottom in ((n - 1, n), (n, n - 1)):
            if abs(factor * bottom / top - 1) < 1e-6:
                divided = "N where N - 1 is" if top < bottom else "N - 1 where N is"
                return f"a constant factor of {top}/{bottom}: divided by {divided} needed (N = {n})?"
    return ""


def _simple(both: Comparison) -> str:
    """Functions of one entry that students apply once too often, or forget."""
    expected, words = both.expected, ""
    with np.errstate(all="ignore"):
        models = {
            "the square of what is expected (for a bell: is the 2 of 2 sigma^2 missing?)": expected**2,
            "the square root of what is expected": np.sqrt(expected),
            "the reciprocal of what is expected": 1 / expected,
            "tone-mapped (sRGB): radiance stays linear": _display(expected),
            "clipped to [0, 1]: radiance may be above 1": np.clip(expected, 0, 1),
            "the sign is lost (an absolute value)": np.abs(expected),
            "values below 0 are cut off": np.maximum(expected, 0),
            "all entries are 0": np.zeros_like(expected),
        }
    for words, model in models.items():
        if np.isfinite(model).all() and both.fits(both.yours, model):
            return words
    return ""


def _display(linear: np.ndarray) -> np.ndarray:
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def _offset(both: Comparison) -> str:
    if both.expected.size < 2 or not np.ptp(both.expected) > 0:
        return ""
    offset = float(np.mean(both.yours - both.expected))
    return f"a constant is added: {offset:+.4g} everywhere" if both.fits(both.yours, both.expected + offset) else ""


def _power(both: Comparison) -> str:
    """Yours = c expected^p, as between bells of different width."""
    yours, expected = both.yours, both.expected
    used = expected > 0
    if (yours < 0).any() or (expected < 0).any() or not np.array_equal(used, yours > 0):
        return ""
    if len(np.unique(expected[used].round(12))) < 4:
        return ""
    power, constant = np.polyfit(np.log(expected[used]), np.log(yours[used]), 1)
    model = np.where(used, np.exp(constant) * np.where(used, expected, 1.0) ** power, 0.0)
    if not power > 0 or not both.fits(yours, model):
        return ""
    if geometry.is_bell(expected):
        return f"the bell is {number(1 / sqrt(power))} times as wide as it should be"
    return f"every entry is the expected one to the power {number(power)}" if abs(constant) < 1e-5 else ""


def _channels(both: Comparison) -> str:
    if both.expected.ndim < 3 or both.expected.shape[-1] != 3:
        return ""
    for order, name in (
        ((2, 1, 0), "BGR"),
        ((1, 0, 2), "GRB"),
        ((0, 2, 1), "RBG"),
        ((1, 2, 0), "GBR"),
        ((2, 0, 1), "BRG"),
    ):
        if both.fits(both.yours, both.expected[..., list(order)]):
            return f"channels exchanged: {name} came back, RGB is needed"
    if both.fits(both.yours, np.broadcast_to(both.expected.mean(axis=-1, keepdims=True), both.expected.shape)):
        return "all channels hold their mean: each must be filtered by itself"
    return ""


def _inner_factor(both: Comparison) -> str:
    """A constant factor away from the border only: a sum that was not divided by its weights."""
    for margin, inside in geometry.insides(both.expected.shape):
        if (factor := factor_between(both, inside)) is not None and np.ptp(both.expected[inside]) > 0:
            band = both.expected.copy()
            band[inside] = 0.0
            if abs(factor - 1) < 1e-3 or np.abs(band).max() < 1e-3 * both.largest:
                return ""
            return (
                f"a constant factor of {number(factor)} inside, another within {margin} px of the border: "
                f"not divided by norm (the sum of the weights)?"
            )
    return ""


def _order(both: Comparison) -> str:
    if both.expected.size < 3 or not np.ptp(both.expected) > 0:
        return ""
    if both.fits(np.sort(both.yours, axis=None), np.sort(both.expected, axis=None)):
        return "the right values in the wrong places"
    return ""


PATTERNS: tuple[Callable[[Comparison], str], ...] = (
    _sign,
    _factor,
    geometry.explain,
    _channels,
    _simple,
    _offset,
    _power,
    geometry.border,
    _inner_factor,
    _order,
    geometry.moments,
)
