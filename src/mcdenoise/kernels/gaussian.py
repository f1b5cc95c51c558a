"""The fast twin of the Gaussian filter: its weight is a product of one factor in y and one in x, so two short sums
replace one long one, 2 (2 radius + 1) taps a pixel instead of (2 radius + 1)^2.

Rows stay interleaved (x, then channel): a step of dx pixels is a step of dx * channels places, so colour needs no
planes.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from mcdenoise.kernels.jit import kernel
from mcdenoise.kernels.rows import add_pair, add_scaled, place, scale

ROWS_PER_BLOCK = 8


def gaussian_sums(image: np.ndarray, sigma_space: float, radius: int) -> tuple[np.ndarray, np.ndarray]:
    """Sum of w c (h, w, c) and sum of w (h, w) in float32; the twin of `filters.gaussian.gaussian_sums`.

    Examples
    --------
    >>> total, norm = gaussian_sums(np.ones((1, 2, 1)), sigma_space=np.inf, radius=1)
    >>> norm
    array([[2., 2.]], dtype=float32)
    """
    height, width, channels = image.shape
    weight_y, weight_x = (space_weight(sigma_space, min(radius, size - 1)) for size in (height, width))
    image = np.ascontiguousarray(image, np.float32)
    total = np.empty_like(image)
    separable_sums(total.ravel(), image.ravel(), weight_y, weight_x, height, channels)
    return total, np.outer(_sums_inside(weight_y, height), _sums_inside(weight_x, width))


def space_weight(sigma_space: float, reach: int) -> np.ndarray:
    """One factor of the weight, exp(-d^2 / (2 sigma^2)) for d = 0 .. reach.

    Examples
    --------
    >>> space_weight(1.0, 2).round(4)
    array([1.    , 0.6065, 0.1353], dtype=float32)
    """
    with np.errstate(over="ignore", divide="ignore", under="ignore"):
        return np.exp(-0.5 * (np.arange(reach + 1) / sigma_space) ** 2).astype(np.float32)


def _sums_inside(weight: np.ndarray, size: int) -> np.ndarray:
    """Sum of the weights that fall inside a line of `size` pixels, for each of them."""
    both = np.concatenate([weight[:0:-1], weight])
    return np.convolve(np.ones(size, np.float32), both)[len(weight) - 1 : len(weight) - 1 + size]


@kernel(parallel=True)
def separable_sums(total, image, weight_y, weight_x, height, channels):
    """Fill `total` from the flat, interleaved image, in blocks of rows."""
    for block in prange((height + ROWS_PER_BLOCK - 1) // ROWS_PER_BLOCK):
        top = block * ROWS_PER_BLOCK
        sum_rows(total, image, weight_y, weight_x, height, channels, top, min(top + ROWS_PER_BLOCK, height))


@kernel
def sum_rows(total, image, weight_y, weight_x, height, channels, top, bottom):
    """For each row: down the columns into a padded row, then along that row."""
    length = image.size // height
    margin = (weight_x.size - 1) * channels
    column_sum = np.zeros(length + 2 * margin, np.float32)
    for y in range(top, bottom):
        sum_columns(column_sum, image, weight_y, y, height, length, margin)
        at = place(y * length)
        scale(total, at, weight_x[0], column_sum, place(margin), place(length))
        for dx in range(1, weight_x.size):
            left, right = place(margin - dx * channels), place(margin + dx * channels)
            add_pair(total, at, weight_x[dx], column_sum, left, right, place(length))


@kernel
def sum_columns(column_sum, image, weight_y, y, height, length, margin):
    """Weighted sum of the rows around row y that lie inside the image."""
    scale(column_sum, place(margin), weight_y[0], image, place(y * length), place(length))
    for dy in range(1, weight_y.size):
        above, below, weight = (y - dy) * length, (y + dy) * length, weight_y[dy]
        if y - dy >= 0 and y + dy < height:
            add_pair(column_sum, place(margin), weight, image, place(above), place(below), place(length))
        elif y - dy >= 0:
            add_scaled(column_sum, place(margin), weight, image, place(above), place(length))
        elif y + dy < height:
            add_scaled(column_sum, place(margin), weight, image, place(below), place(length))
