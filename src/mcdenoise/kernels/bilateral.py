"""The fast twin of the bilateral and the cross-bilateral filter: one kernel for any number of guides.

A guide is anything that likeness is judged by: radiance, or a feature. Each of its channels becomes one plane,
multiplied by sqrt(log2(e) / 2) / sigma, so that a weight is simply 2^(space - sum of squared differences over all
planes).

Planes are padded on both sides by the radius, so that every row operation runs over the same columns whatever the
offset. In the first guide the padding holds FAR: any real pixel is so far from it that the weight is exactly 0.

w_ij = w_ji: each pair of pixels is weighed once and used twice. Pairs look downwards, so a block of rows adds to itself
and to `radius` rows below it; it keeps all of that for itself, and a second pass adds the blocks up in a fixed order.
No two threads ever write to one place, and the bits do not depend on how many there are.
"""

from __future__ import annotations

import math

import numpy as np
from numba import prange

from mcdenoise.kernels.jit import kernel
from mcdenoise.kernels.rows import add_row, add_squares, add_weighted_row, place, weigh, weigh_on

FAR = 1e18
LARGEST_GUIDE = 1e17  # so that no difference squared overflows, and FAR is far from everything
SMALLEST = 1e-20
ROWS_PER_BLOCK = 16
COLUMN_STEP = 32
GROUP = 3


def bilateral_sums(
    image: np.ndarray, sigma_space: float, sigma_radiance: float, radius: int
) -> tuple[np.ndarray, np.ndarray]:
    """Sum of w c (h, w, c) and sum of w (h, w) in float32; the twin of `filters.bilateral.bilateral_sums`.

    Examples
    --------
    >>> total, norm = bilateral_sums(np.array([[[0.0], [2.0]]]), np.inf, 2.0, radius=1)
    >>> norm.round(3)
    array([[1.607, 1.607]], dtype=float32)
    """
    return cross_bilateral_sums(image, [], sigma_space, sigma_radiance, radius)


def cross_bilateral_sums(
    image: np.ndarray,
    guides: list[tuple[np.ndarray, float]],
    sigma_space: float,
    sigma_radiance: float,
    radius: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Sum of w c (h, w, c) and sum of w (h, w) in float32; the twin of `filters.cross_bilateral.cross_bilateral_sums`.

    Examples
    --------
    >>> guide = np.array([[[0.0], [2.0]]])
    >>> total, norm = cross_bilateral_sums(np.ones((1, 2, 1)), [(guide, 2.0)], np.inf, np.inf, radius=1)
    >>> norm.round(3)
    array([[1.607, 1.607]], dtype=float32)
    """
    height, width, channels = image.shape
    reach_y, reach_x = min(radius, height - 1), min(radius, width - 1)
    padded = -(-width // COLUMN_STEP) * COLUMN_STEP + 2 * reach_x
    inside = np.s_[:, :, reach_x : reach_x + width]

    colour = np.zeros((channels, height, padded), np.float32)
    colour[inside] = np.moveaxis(image, -1, 0)
    active = [(feature, sigma) for feature, sigma in [(image, sigma_radiance), *guides] if sigma < math.inf]
    planes = sum(feature.shape[-1] for feature, _ in active)
    guide = np.zeros((max(GROUP, -(-planes // GROUP) * GROUP), height, padded), np.float32)
    guide[0] = FAR
    guide[0][inside[1:]] = 0
    first = 0
    for feature, sigma in active:
        last = first + feature.shape[-1]
        guide[first:last][inside] = np.moveaxis(feature, -1, 0) * _scale(feature, sigma)
        first = last
    exponent = space_exponent(sigma_space, reach_y, reach_x)
    return window_sums(colour.ravel(), guide.ravel(), exponent, channels, len(guide), height, width)


def space_exponent(sigma_space: float, reach_y: int, reach_x: int) -> np.ndarray:
    """log2 of the spatial weight for dy = 0 .. reach_y (rows) and dx = -reach_x .. reach_x (columns).

    Examples
    --------
    >>> space_exponent(1.0, 0, 1)
    array([[-0.7213475,  0.       , -0.7213475]], dtype=float32)
    """
    dy, dx = np.ogrid[: reach_y + 1, -reach_x : reach_x + 1]
    with np.errstate(over="ignore", divide="ignore"):
        square = (dy / sigma_space) ** 2 + (dx / sigma_space) ** 2
    return -np.minimum(square * (0.5 * math.log2(math.e)), FAR).astype(np.float32)


def _scale(feature: np.ndarray, sigma: float) -> float:
    """Return sqrt(log2(e) / 2) / sigma, or less where the scaled feature would leave LARGEST_GUIDE.

    Less only if some value is more than 1e16 times sigma, where float32 has long lost differences as small as sigma.
    """
    largest = max(float(np.abs(feature).max()), SMALLEST)
    return min(math.sqrt(0.5 * math.log2(math.e)) / sigma, LARGEST_GUIDE / largest)


@kernel(parallel=True)
def window_sums(colour, guide, exponent, channels, planes, height, width):
    """Sums over the window for flat padded planes: colour (channels), guide (planes, a multiple of 3)."""
    reach_y, reach_x = exponent.shape[0] - 1, exponent.shape[1] // 2
    padded = colour.size // (channels * height)
    rows = max(ROWS_PER_BLOCK, reach_y // 2)
    blocks = (height + rows - 1) // rows
    sums = np.zeros((blocks, (channels + 1) * (rows + reach_y) * padded), np.float32)
    for block in prange(blocks):
        block_sums(sums[block], colour, guide, exponent, channels, planes, height, block * rows, rows)

    total, norm = np.empty((height, width, channels), np.float32), np.empty((height, width), np.float32)
    for y in prange(height):
        gather_row(total[y], norm[y], sums, colour, channels, height, padded, reach_x, y, rows, rows + reach_y)
    return total, norm


@kernel
def block_sums(sums, colour, guide, exponent, channels, planes, height, top, rows):
    """Weigh the pairs whose upper pixel lies in one block; add both ways into `sums`, planes of rows + reach_y rows."""
    reach_y, reach_x = exponent.shape[0] - 1, exponent.shape[1] // 2
    padded = colour.size // (channels * height)
    plane, sums_plane = height * padded, (rows + reach_y) * padded
    weight = np.empty(padded - 2 * reach_x, np.float32)
    for dy in range(reach_y + 1):
        for y in range(top, min(top + rows, height - dy)):
            here, sums_here = y * padded + reach_x, (y - top) * padded + reach_x
            for dx in range(-reach_x if dy > 0 else 1, reach_x + 1):
                step = dy * padded + dx
                there, sums_there = here + step, sums_here + step
                weigh_row(weight, exponent[dy, dx + reach_x], guide, here, there, plane, planes)
                for k in range(channels):
                    add_weighted_row(sums, place(sums_here + k * sums_plane), weight, colour, place(there + k * plane))
                    add_weighted_row(sums, place(sums_there + k * sums_plane), weight, colour, place(here + k * plane))
                add_row(sums, place(sums_here + channels * sums_plane), weight)
                add_row(sums, place(sums_there + channels * sums_plane), weight)


@kernel
def weigh_row(weight, exponent, guide, here, there, plane, planes):
    """The weights of all pairs of two rows, from all guide planes, three at a time."""
    if planes == GROUP:
        weigh(weight, exponent, guide, place(here), place(there), place(plane))
        return
    weight[:] = np.float32(0)
    last = planes - GROUP
    for k in range(0, last, GROUP):
        add_squares(weight, guide, place(here + k * plane), place(there + k * plane), place(plane))
    weigh_on(weight, exponent, guide, place(here + last * plane), place(there + last * plane), place(plane))


@kernel
def gather_row(total, norm, sums, colour, channels, height, padded, reach_x, y, rows, sums_rows):
    """Row y of the result: the pixel itself (weight 1), then what each block added to this row, in order."""
    for x in range(norm.size):
        norm[x] = np.float32(1)
        for k in range(channels):
            total[x, k] = colour[(k * height + y) * padded + reach_x + x]
    for block in range(max(0, (y - sums_rows) // rows + 1), y // rows + 1):
        row = y - block * rows
        for x in range(norm.size):
            norm[x] += sums[block, (channels * sums_rows + row) * padded + reach_x + x]
            for k in range(channels):
                total[x, k] += sums[block, (k * sums_rows + row) * padded + reach_x + x]
