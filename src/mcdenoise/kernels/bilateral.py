"""The fast twin of the bilateral and the cross-bilateral filter: one kernel for any number of guides.

Guides stand in planes as `planes` says: a weight is 2^(space - sum of squared differences over all planes).

Planes are padded on both sides by radius + 1, so that every row operation runs over the same columns whatever the
offset (the 1: taps go two at a time). In the first guide the padding holds FAR: any real pixel is so far from it that
the weight is exactly 0. One column at least follows the image before the padding proper, so `length` > width.

w_ij = w_ji: each pair of pixels is weighed once and used twice. Pairs look downwards, so a block of rows adds to itself
and to `radius` rows below it; it keeps all of that for itself, and a second pass adds the blocks up in a fixed order.
No two threads ever write to one place, and the bits do not depend on how many there are.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from mcdenoise.kernels.jit import kernel
from mcdenoise.kernels.planes import FAR, GROUP, padded_planes, place_planes, space_exponent
from mcdenoise.kernels.rows import (
    add_normalised,
    add_squares,
    add_two,
    add_two_weighted,
    place,
    weigh,
    weigh_on,
)

ROWS_PER_BLOCK = 16
COLUMN_STEP = 8


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
    guides: list[tuple[np.ndarray, float, np.ndarray | None]],
    sigma_space: float,
    sigma_radiance: float,
    radius: int,
    radiance_variance: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Sum of w c (h, w, c) and sum of w (h, w) in float32; the twin of `filters.cross_bilateral.cross_bilateral_sums`.

    Examples
    --------
    >>> guide = (np.array([[[0.0], [2.0]]]), 2.0, None)
    >>> total, norm = cross_bilateral_sums(np.ones((1, 2, 1)), [guide], np.inf, np.inf, radius=1)
    >>> norm.round(3)
    array([[1.607, 1.607]], dtype=float32)
    """
    height, width, channels = image.shape
    reach_y, reach_x = min(radius, height - 1), min(radius, width - 1)
    margin = reach_x + 1
    size = (height, (width // COLUMN_STEP + 1) * COLUMN_STEP + 2 * margin, margin)
    inside = np.s_[..., margin : margin + width]

    colour = padded_planes(channels, size)
    colour[inside] = np.moveaxis(image, -1, 0)
    plain, noisy, spread = place_planes([(image, sigma_radiance, radiance_variance), *guides], size, width)
    guide = plain if len(plain) else padded_planes(GROUP, size)
    guide[0, :, :margin] = guide[0, :, margin + width :] = FAR
    return _window_sums(colour, guide, noisy, spread, space_exponent(sigma_space, reach_y, reach_x), width)


def _window_sums(
    colour: np.ndarray, guide: np.ndarray, noisy: np.ndarray, spread: np.ndarray, exponent: np.ndarray, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """Run the kernels on padded planes: colour (c, h, padded), guide (k, h, padded), noisy and spread (q, h, padded)."""
    channels, height, padded = colour.shape
    reach_y, reach_x = len(exponent) - 1, exponent.shape[1] // 2 - 1
    rows = max(ROWS_PER_BLOCK, reach_y // 2)
    sums_rows = rows + reach_y
    sums = np.zeros((-(-height // rows), (channels + 1) * sums_rows * padded), np.float32)
    guides = guide.ravel(), noisy.ravel(), spread.ravel()
    sum_blocks(sums, colour.ravel(), *guides, exponent, channels, len(guide), len(noisy), height, rows)

    # Each pixel itself has the weight 1; then come the pairs, block after block.
    result = np.concatenate([colour, np.ones((1, height, padded), np.float32)])
    for block, block_sum in enumerate(sums.reshape(len(sums), channels + 1, sums_rows, padded)):
        reached = result[:, block * rows : block * rows + sums_rows]
        reached += block_sum[:, : reached.shape[1]]
    inside = result[:, :, reach_x + 1 : reach_x + 1 + width]
    return np.moveaxis(inside[:-1], 0, -1), inside[-1]


@kernel(parallel=True)
def sum_blocks(sums, colour, guide, noisy, spread, exponent, channels, planes, noisy_planes, height, rows):
    """Sums of each block of rows, for flat padded planes; guide and noisy hold whole groups of planes."""
    for block in prange(sums.shape[0]):
        block_sums(
            sums[block],
            colour,
            guide,
            noisy,
            spread,
            exponent,
            channels,
            planes,
            noisy_planes,
            height,
            block * rows,
            rows,
        )


@kernel
def block_sums(sums, colour, guide, noisy, spread, exponent, channels, planes, noisy_planes, height, top, rows):
    """Weigh the pairs whose upper pixel lies in one block; add both ways into `sums`, planes of rows + reach_y rows."""
    reach_y, reach_x = exponent.shape[0] - 1, exponent.shape[1] // 2 - 1
    padded = colour.size // (channels * height)
    plane, sums_plane = height * padded, (rows + reach_y) * padded
    length = padded - 2 * (reach_x + 1)
    weight = np.zeros(2 * length + 1, np.float32)
    for dy in range(reach_y + 1):
        for y in range(top, min(top + rows, height - dy)):
            here, sums_here = y * padded + reach_x + 1, (y - top) * padded + reach_x + 1
            for dx in range(-reach_x if dy > 0 else 1, reach_x + 1, 2):
                there, sums_there = here + dy * padded + dx, sums_here + dy * padded + dx
                space, next_space = exponent[dy, dx + reach_x], exponent[dy, dx + 1 + reach_x]
                for at, to, near in ((0, there, space), (length + 1, there + 1, next_space)):
                    if noisy_planes > 0:
                        weigh_noisy_row(
                            weight, at, length, near, guide, noisy, spread, here, to, plane, planes, noisy_planes
                        )
                    else:
                        weigh_row(weight, at, length, near, guide, here, to, plane, planes)
                add_both_ways(
                    sums, sums_here, sums_there, sums_plane, weight, length, colour, here, there, plane, channels
                )


@kernel
def add_both_ways(sums, sums_here, sums_there, sums_plane, weight, length, colour, here, there, plane, channels):
    """Add two taps to both pixels of each pair; `weight` holds those of dx, a zero, and those of dx + 1."""
    first, zero, second, n = place(0), place(length), place(length + 1), place(length)
    for k in range(channels):
        seen = place(there + k * plane)
        add_two_weighted(sums, place(sums_here), n, weight, first, second, colour, seen, seen + place(1))
        seen = place(here + k * plane)
        add_two_weighted(sums, place(sums_there), n, weight, first, zero, colour, seen, seen - place(1))
        sums_here += sums_plane
        sums_there += sums_plane
    add_two(sums, place(sums_here), n, weight, first, second)
    add_two(sums, place(sums_there), n, weight, first, zero)


@kernel
def weigh_row(weight, at, length, exponent, guide, here, there, plane, planes):
    """The weights of all pairs of two rows, from all guide planes, three at a time."""
    at, n, step = place(at), place(length), place(plane)
    last = planes - GROUP
    if last == 0:
        weigh(weight, at, n, exponent, guide, place(here), place(there), step)
        return
    for x in range(at, at + n):
        weight[x] = np.float32(0)
    for k in range(0, last, GROUP):
        add_squares(weight, at, n, guide, place(here + k * plane), place(there + k * plane), step)
    weigh_on(weight, at, n, exponent, guide, place(here + last * plane), place(there + last * plane), step)


@kernel
def weigh_noisy_row(weight, at, length, exponent, guide, noisy, spread, here, there, plane, planes, noisy_planes):
    """As `weigh_row`, where some guides have a variance: their squares are divided first."""
    at, n, step = place(at), place(length), place(plane)
    for x in range(at, at + n):
        weight[x] = np.float32(0)
    for k in range(0, noisy_planes, GROUP):
        add_normalised(weight, at, n, noisy, spread, place(here + k * plane), place(there + k * plane), step)
    last = planes - GROUP
    for k in range(0, last, GROUP):
        add_squares(weight, at, n, guide, place(here + k * plane), place(there + k * plane), step)
    weigh_on(weight, at, n, exponent, guide, place(here + last * plane), place(there + last * plane), step)
