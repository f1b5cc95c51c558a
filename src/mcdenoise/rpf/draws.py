"""Which samples of the neighbourhood are drawn: offsets from a Gaussian, and random numbers that are a function of the pixel."""

from __future__ import annotations

from math import erf

import numpy as np

TABLE_BITS = 14
STEP, MIX_1, MIX_2 = (np.uint64(k) for k in (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB))  # SplitMix64


def offset_table(box: int, sigma: float) -> np.ndarray:
    """Offsets -box/2 .. box/2, each as often as a Gaussian rounded to whole pixels gives it, in ascending order.

    One of the 2^14 entries, chosen at random, is a draw; a part of the table draws from a clipped box.

    Examples
    --------
    >>> table = offset_table(3, 0.75)
    >>> [int((table == k).sum()) for k in (-1, 0, 1)]
    [3944, 8496, 3944]
    """
    half = box // 2
    edges = np.arange(-half, half + 2) - 0.5
    below = np.array([erf(edge / (sigma * np.sqrt(2))) for edge in edges])
    share = np.cumsum(np.diff(below)) / (below[-1] - below[0])
    middle = (np.arange(1 << TABLE_BITS) + 0.5) / (1 << TABLE_BITS)
    return (np.searchsorted(share, middle) - half).astype(np.int16)


def first_entries(table: np.ndarray, box: int) -> np.ndarray:
    """Where in `table` the offsets -box/2 .. box/2 begin, and its length.

    Examples
    --------
    >>> first_entries(offset_table(3, 0.75), 3)
    array([    0,  3944, 12440, 16384])
    """
    half = box // 2
    return np.searchsorted(table, np.arange(-half, half + 2))


def random_bits(key: int | np.uint64, number: object) -> np.ndarray:
    """64 random bits for each number: SplitMix64, the same for the same key and number.

    Examples
    --------
    >>> random_bits(0, np.array([1]))
    array([16294208416658607535], dtype=uint64)
    """
    with np.errstate(over="ignore"):
        z = np.uint64(key) + np.asarray(number, np.uint64) * STEP
        z = (z ^ (z >> np.uint64(30))) * MIX_1
        z = (z ^ (z >> np.uint64(27))) * MIX_2
    return z ^ (z >> np.uint64(31))


def pixel_key(seed: int, turn: int, pixel: int) -> np.uint64:
    """Return the key of one pixel (its number in the image) in one pass."""
    return random_bits(random_bits(seed, turn), pixel)[()]
