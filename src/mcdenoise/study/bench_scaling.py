"""How does time grow with radius, number of feature channels and pixels? Exponents from one run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from mcdenoise.filters import nlm
from mcdenoise.study.bench_filters import count_taps
from mcdenoise.study.bench_guided import FEATURES, NOISE, PATCH_RADIUS, SEARCH_RADIUS, cross
from mcdenoise.study.bench_measure import Contestant, Work, measure

CROSS_RADII = (4, 6, 9, 13, 19, 27)
CHANNELS = (0, 3, 6, 9, 12, 18)
SEARCH_RADII = (3, 5, 7, 10, 14, 20)
PATCH_RADII = (1, 2, 3, 5, 7, 10)
FIXED_RADIUS = 9  # of the cross-bilateral while channels or pixels vary
USUAL_CHANNELS = 9


@dataclass
class Series:
    """One quantity varied, everything else fixed.

    Attributes
    ----------
    title : the filter, and what is fixed
    symbol : of the quantity in the printed law, and of its values in the range
    values : that it takes, ascending
    run : value -> the work to time
    taps : value -> pairs of pixels that must be looked at; None: they do not depend on it, or are not what counts
    linear : fit a + b * value instead of a power
    """

    title: str
    symbol: tuple[str, str]
    values: Sequence[int]
    run: Callable[[int], Callable[[], object]]
    taps: Callable[[int], int] | None = None
    linear: bool = False


def power_law(values: Sequence[float], seconds: Sequence[float]) -> tuple[float, float]:
    """Fit seconds = factor * value^exponent by least squares in log-log; return (factor, exponent).

    Examples
    --------
    >>> factor, exponent = power_law([1, 2, 4], [3, 12, 48])
    >>> round(factor, 6), round(exponent, 6)
    (3.0, 2.0)
    """
    exponent, offset = np.polyfit(np.log(values), np.log(seconds), 1)
    return float(np.exp(offset)), float(exponent)


def straight_line(values: Sequence[float], seconds: Sequence[float]) -> tuple[float, float]:
    """Fit seconds = a + b * value by least squares; return (a, b).

    Examples
    --------
    >>> a, b = straight_line([0, 3, 6], [1.0, 2.5, 4.0])
    >>> round(a, 6), round(b, 6)
    (1.0, 0.5)
    """
    b, a = np.polyfit(values, seconds, 1)
    return float(a), float(b)


def scaling_lines(size: int, repeats: int) -> list[str]:
    """Measure every series, contestants of a series in turns, and return the fitted laws with the medians behind them."""
    lines = ["growth of time (windows are clipped at the border, so that taps grow slower than radius^2)"]
    for series in all_series(size):
        contestants = [Contestant(str(value), series.run(value)) for value in series.values]
        measure([Work(series.title, contestants)], repeats, f"growth with {series.symbol[0]}")
        lines += law(series, [contestant.median() for contestant in contestants])
    return lines


def law(series: Series, seconds: Sequence[float]) -> list[str]:
    """Return the fitted law and the measured medians, in two lines.

    Examples
    --------
    >>> series = Series("blur, 8x8", ("radius", "r"), (1, 2, 4), print)
    >>> print(*law(series, [0.003, 0.012, 0.048]), sep="\\n")
      blur, 8x8: time ~ radius^2.00 (r = 1 .. 4)
        r: ms   1: 3.0   2: 12.0   4: 48.0
    """
    name, letter = series.symbol
    span = f"{letter} = {series.values[0]} .. {series.values[-1]}"
    if series.linear:
        a, b = straight_line(series.values, seconds)
        share = a / (a + b * USUAL_CHANNELS)
        words = (
            f"time = {1e3 * a:.1f} ms + {1e3 * b:.2f} ms x {name} ({span}); "
            f"the constant is {100 * share:.0f} % of the time at {USUAL_CHANNELS} {name}"
        )
    else:
        words = f"time ~ {name}^{power_law(series.values, seconds)[1]:.2f} ({span})"
    if series.taps:
        taps = [series.taps(value) for value in series.values]
        words += (
            f"; taps ~ {name}^{power_law(series.values, taps)[1]:.2f}, so time ~ taps^{power_law(taps, seconds)[1]:.2f}"
        )
    medians = "   ".join(f"{value}: {1e3 * one:.1f}" for value, one in zip(series.values, seconds, strict=True))
    return [f"  {series.title}: {words}", f"    {letter}: ms   {medians}"]


def all_series(size: int) -> list[Series]:
    """Return what is varied: three series of the cross-bilateral filter and three of NL-means."""
    rng = np.random.default_rng(0)
    image = rng.random((size, size, 3), dtype=np.float32)
    planes = rng.random((max(CHANNELS) // 3, size, size, 3), dtype=np.float32)
    variance = (NOISE**2 * rng.uniform(0.5, 1.5, image.shape)).astype(np.float32)
    half = max(4, size // 2)
    return [*_cross_series(image, planes, half), *_nlm_series(image, variance, half)]


def _crop(array: np.ndarray, size: int) -> np.ndarray:
    """The upper left corner, contiguous."""
    return np.ascontiguousarray(array[..., :size, :size, :])


def _sizes(size: int) -> tuple[int, ...]:
    """Heights for the series over pixels."""
    return tuple(sorted({max(2, size // part) for part in (8, 4, 2, 1)}))


def _cross_series(image: np.ndarray, planes: np.ndarray, half: int) -> list[Series]:
    """Cross-bilateral: radius, channels, pixels."""

    def run(size: int, channels: int, radius: int) -> Callable[[], object]:
        features = {f"feature_{k}": _crop(plane, size) for k, plane in enumerate(planes[: channels // 3])}
        cut = _crop(image, size)
        return lambda: cross(cut, features, radius)

    usual = 3 * len(FEATURES)
    side = {height**2: height for height in _sizes(len(image))}
    return [
        Series(
            f"cross-bilateral, {usual} feature channels, {half}x{half}",
            ("radius", "r"),
            CROSS_RADII,
            lambda radius: run(half, usual, radius),
            lambda radius: count_taps(half, radius),
        ),
        Series(
            f"cross-bilateral, radius {FIXED_RADIUS}, {half}x{half}",
            ("channels", "n"),
            CHANNELS,
            lambda channels: run(half, channels, FIXED_RADIUS),
            linear=True,
        ),
        Series(
            f"cross-bilateral, {usual} feature channels, radius {FIXED_RADIUS}",
            ("pixels", "N"),
            tuple(side),
            lambda pixels: run(side[pixels], usual, FIXED_RADIUS),
            lambda pixels: count_taps(side[pixels], FIXED_RADIUS),
        ),
    ]


def _nlm_series(image: np.ndarray, variance: np.ndarray, half: int) -> list[Series]:
    """NL-means: search radius, patch radius, pixels."""

    def run(size: int, search_radius: int, patch_radius: int) -> Callable[[], object]:
        cut, noise = _crop(image, size), _crop(variance, size)
        return lambda: nlm(cut, noise, search_radius=search_radius, patch_radius=patch_radius)

    side = {height**2: height for height in _sizes(len(image))}
    return [
        Series(
            f"NL-means, patch radius {PATCH_RADIUS}, {half}x{half}",
            ("search radius", "r"),
            SEARCH_RADII,
            lambda radius: run(half, radius, PATCH_RADIUS),
            lambda radius: count_taps(half, radius),
        ),
        Series(
            f"NL-means, search radius {SEARCH_RADIUS}, {half}x{half}",
            ("patch radius", "r"),
            PATCH_RADII,
            lambda radius: run(half, SEARCH_RADIUS, radius),
        ),
        Series(
            f"NL-means, search radius {SEARCH_RADIUS}, patch radius {PATCH_RADIUS}",
            ("pixels", "N"),
            tuple(side),
            lambda pixels: run(side[pixels], SEARCH_RADIUS, PATCH_RADIUS),
            lambda pixels: count_taps(side[pixels], SEARCH_RADIUS),
        ),
    ]
