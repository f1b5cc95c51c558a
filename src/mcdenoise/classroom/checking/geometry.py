"""Patterns of place: shifted, transposed, flipped, wrong at the border, centre of mass moved."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from mcdenoise.classroom.checking.patterns import Comparison

FARTHEST = 8  # pixels of a shift that is looked for


def explain(both: Comparison) -> str:
    """Say whether the values are right in other places: off centre, transposed, flipped or turned."""
    return _shift(both) or _turn(both)


def _shift(both: Comparison) -> str:
    shape = both.expected.shape
    axes = min(len(shape), 2)
    if not axes or np.ptp(both.expected) == 0:
        return ""
    for shift in _shifts(shape[:axes]):
        here = tuple(slice(max(0, d), n + min(0, d)) for d, n in zip(shift, shape, strict=False))
        there = tuple(slice(max(0, -d), n + min(0, -d)) for d, n in zip(shift, shape, strict=False))
        moved = both.expected[there]
        if both.fits(both.yours[here], moved) and not both.fits(both.expected[here], moved):
            if axes == 1:
                return f"shifted by {shift[0]:+d} along the axis"
            return f"off centre by (dy, dx) = ({', '.join(f'{d:+d}' if d else '0' for d in shift)}) pixels"
    return ""


def _shifts(shape: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Every whole shift up to FARTHEST that leaves more than half of each axis, the nearest first."""
    reach = [min(FARTHEST, (n - 1) // 2) for n in shape]
    grid = np.stack(np.meshgrid(*(np.arange(-r, r + 1) for r in reach), indexing="ij"), axis=-1).reshape(-1, len(shape))
    grid = grid[np.argsort((grid**2).sum(axis=1), kind="stable")]
    return [tuple(int(d) for d in one) for one in grid[1:]]


def _turn(both: Comparison) -> str:
    yours, expected = both.yours, both.expected
    if expected.ndim == 1:
        return "in reverse order" if expected.size > 2 and both.fits(yours, expected[::-1]) else ""
    if expected.ndim < 2:
        return ""
    models = {
        "flipped left-right": expected[:, ::-1],
        "flipped up-down": expected[::-1],
        "turned by 180 degrees (flipped along both axes)": expected[::-1, ::-1],
    }
    if expected.shape[0] == expected.shape[1]:
        models = {"transposed: x and y are exchanged": np.swapaxes(expected, 0, 1)} | models
        models["turned by 90 degrees"] = np.rot90(expected)
        models["turned by 270 degrees"] = np.rot90(expected, 3)
    return next((words for words, model in models.items() if both.fits(yours, model)), "")


def insides(shape: tuple[int, ...]) -> Iterator[tuple[int, tuple[slice, slice]]]:
    """Yield margins of 1, 2, ... pixels, up to a third of the image, with the part that each leaves inside."""
    if len(shape) >= 2:
        for margin in range(1, min(shape[:2]) // 3 + 1):
            yield margin, (slice(margin, shape[0] - margin), slice(margin, shape[1] - margin))


def border(both: Comparison) -> str:
    """Say whether all is right but for the pixels along the border (most of those of one side, at least)."""
    wrong = both.wrong()
    if wrong.ndim < 2 or max(side.mean() for side in (wrong[0], wrong[-1], wrong[:, 0], wrong[:, -1])) <= 0.5:
        return ""
    for margin, inside in insides(both.expected.shape):
        expected = both.expected[inside]
        if np.abs(expected).max(initial=0) > 0 and both.fits(both.yours[inside], expected):
            return f"right inside, wrong within {margin} px of the border: only pixels inside the image may count"
    return ""


def is_bell(values: np.ndarray) -> bool:
    """Whether values look like the response to an impulse: nothing below 0, one largest entry, next to nothing at the border."""
    plane = np.asarray(values)
    while plane.ndim > 2:
        plane = plane.sum(axis=-1)
    if plane.ndim == 0 or min(plane.shape) < 3 or (plane < 0).any():
        return False
    edge = np.ones(plane.shape, bool)
    edge[(slice(1, -1),) * plane.ndim] = False
    return bool((plane == plane.max()).sum() == 1 and plane[edge].max() < 0.2 * plane.max())


def moments(both: Comparison) -> str:
    """Say how far the centre of mass of a bell moved, or how much its width changed: measured, not fitted."""
    if both.expected.ndim < 2 or not is_bell(both.expected) or (both.yours < 0).any() or not both.yours.any():
        return ""
    (centre, width), (needed_centre, needed_width) = _moments(both.yours), _moments(both.expected)
    moved = centre - needed_centre
    if np.abs(moved).max() > 0.05 and abs(both.yours.sum() / both.expected.sum() - 1) < 1e-3:
        return f"off centre: the centre of mass moved by (dy, dx) = ({moved[0]:+.2f}, {moved[1]:+.2f}) pixels"
    if np.abs(moved).max() < 0.05 and is_bell(both.yours) and abs(width / needed_width - 1) > 0.05:
        wider = "wider" if width > needed_width else "narrower"
        return f"the bell is {wider} than expected: a standard deviation of {width:.2f} px instead of {needed_width:.2f} px"
    return ""


def _moments(values: np.ndarray) -> tuple[np.ndarray, float]:
    """Centre of mass (y, x) and standard deviation along one axis, in pixels."""
    plane = values.sum(axis=tuple(range(2, values.ndim)))
    share, grid = plane / plane.sum(), np.indices(plane.shape)
    centre = (share * grid).sum(axis=(1, 2))
    return centre, float(np.sqrt((share * (grid - centre[:, np.newaxis, np.newaxis]) ** 2).sum() / 2))
