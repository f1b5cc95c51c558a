"""Chapter 07: points in the plane, of two classes, to draw decision boundaries through.

Each function returns the points (n, 2), within about [-1.5, 1.5]^2, and their classes (n,), 0 or 1, in random order.
"""

from __future__ import annotations

import numpy as np

from mcdenoise.samples.gate import check_count, check_nonfinite


def two_moons(n: int, *, rng: np.random.Generator, noise: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    """Two half circles, each with its end in the hollow of the other. noise: standard deviation of both coordinates.

    Examples
    --------
    >>> x, labels = two_moons(100, rng=np.random.default_rng(0))
    >>> x.shape, int(labels.sum())
    ((100, 2), 50)
    """
    labels = _labels(n, rng)
    angle = np.pi * rng.random(n)
    upper = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    lower = np.stack([1 - np.cos(angle), 0.5 - np.sin(angle)], axis=1)
    return np.where(labels[:, np.newaxis] == 0, upper, lower) - [0.5, 0.25] + _noise(n, rng, noise), labels


def rings(n: int, *, rng: np.random.Generator, noise: float = 0.08) -> tuple[np.ndarray, np.ndarray]:
    """A ring of radius 1 (class 0) around one of radius 0.45 (class 1).

    Examples
    --------
    >>> x, labels = rings(100, rng=np.random.default_rng(0), noise=0.0)
    >>> np.unique(np.hypot(*x.T).round(6)).tolist()
    [0.45, 1.0]
    """
    labels = _labels(n, rng)
    angle = 2 * np.pi * rng.random(n)
    radius = np.where(labels == 0, 1.0, 0.45)[:, np.newaxis]
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1) + _noise(n, rng, noise), labels


def xor(n: int, *, rng: np.random.Generator, noise: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """The square [-1, 1]^2; class 1 where exactly one coordinate is above 0.

    Examples
    --------
    >>> x, labels = xor(100, rng=np.random.default_rng(0))
    >>> bool(np.all(labels == (x[:, 0] * x[:, 1] < 0)))
    True
    """
    return checker(n, rng=rng, cells=2, noise=noise)


def checker(n: int, *, rng: np.random.Generator, cells: int = 4, noise: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """The square [-1, 1]^2 as a checkerboard of `cells` x `cells`; class 0 in the lower left corner.

    Examples
    --------
    >>> x, labels = checker(100, rng=np.random.default_rng(0), cells=1)
    >>> int(labels.sum())
    0
    """
    x = rng.uniform(-1, 1, (check_count(n, "n"), 2))
    cell = np.floor((x + 1) / 2 * check_count(cells, "cells")).astype(int)
    return x + _noise(n, rng, noise), cell.sum(axis=1) % 2


def _labels(n: int, rng: np.random.Generator) -> np.ndarray:
    """Half of the classes each, in random order."""
    return rng.permutation(np.arange(check_count(n, "n")) % 2)


def _noise(n: int, rng: np.random.Generator, noise: float) -> np.ndarray:
    """Normal noise in both coordinates."""
    check_nonfinite(np.asarray(noise, float), "noise")
    if noise < 0:
        raise ValueError(f"noise must be at least 0, got {noise:g}.")
    return noise * rng.standard_normal((n, 2))
