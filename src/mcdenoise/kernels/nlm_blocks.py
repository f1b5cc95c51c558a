"""The kernels of NL-means: shift and box.

For one offset (dy, dx) the distance of every pixel to the pixel dy, dx away is a whole image, and the distance of
patches is a box sum of it. So the loop over offsets stands outside, and patches cost next to nothing, whatever their
size. Per block of rows and offset:

    distances of pixels -> sums of 2 patch_x + 1 columns -> sums of 2 patch_y + 1 rows -> weights
    (-> the mean weight of a small box) (-> times the likeness of features) -> total and norm

All buffers have the padded rows of the planes, so that a block is one long row to most loops; what they compute in the
margins is finite and never used. A box of 2 r + 1 rows is r pairs of rows and a single one; each pair is added up once
and used by r boxes. (A running sum would be cheaper still, but never loses the rounding errors of a steep edge it has
passed.)

Weights are not symmetric (see `filters.nlm`), so each pixel gathers for itself: no two threads write to one row.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import prange

from mcdenoise.kernels.jit import kernel
from mcdenoise.kernels.patch_rows import (
    NONE,
    add_three_weighted,
    average,
    compare,
    compare_on,
    fill,
    multiply_by_likeness,
    pair_up,
    sum_odd,
    weigh_patches,
)
from mcdenoise.kernels.planes import GROUP
from mcdenoise.kernels.rows import ZERO, add_normalised, add_squares, place

ROWS_PER_BLOCK = 32
ONE, LOG2_E = np.float32(1), np.float32(math.log2(math.e))


class Planes(NamedTuple):
    """What the kernels read: flat, padded planes."""

    colour: np.ndarray  # what is averaged, and the ones
    compared: np.ndarray  # what patches are made of
    level: np.ndarray  # its variance
    plain: np.ndarray  # features without noise
    noisy: np.ndarray  # features with a variance
    spread: np.ndarray  # what divides the squares of noisy features


class Sizes(NamedTuple):
    """Every whole number that the kernels need."""

    height: int
    width: int
    stride: int  # columns of a padded row
    margin: int  # columns before the first one of the image
    length: int  # columns that the loop over one row runs over
    channels: int  # averaged planes, the ones included
    compared: int  # planes of the patches, in groups
    plain: int  # planes of features without noise, in groups
    noisy: int  # planes of features with a variance, in groups
    search_y: int
    search_x: int
    patch_y: int
    patch_x: int
    weight_y: int
    weight_x: int
    joint: int  # 1: weights are multiplied by the likeness of features and the nearness


@kernel(parallel=True)
def sum_blocks(total, planes, exponent, patch_share, weight_share, cancelled, s):
    """Fill `total`, flat padded planes, in blocks of rows."""
    for block in prange((s.height + ROWS_PER_BLOCK - 1) // ROWS_PER_BLOCK):
        block_sums(total, planes, exponent, patch_share, weight_share, cancelled, s, block * ROWS_PER_BLOCK)


@kernel
def block_sums(total, planes, exponent, patch_share, weight_share, cancelled, s, top):
    """Sums of the rows from `top` on, over all offsets, three steps in x at a time."""
    bottom, plane = min(top + ROWS_PER_BLOCK, s.height), ROWS_PER_BLOCK * s.stride
    weight, likeness = np.zeros(GROUP * plane, np.float32), np.zeros(plane, np.float32)
    rows = ROWS_PER_BLOCK + 2 * s.weight_y
    patches, smooth = empty_box(rows + 2 * s.patch_y, s.stride), empty_box(rows, s.stride)
    for dy in range(-s.search_y, s.search_y + 1):
        first, last = max(0, -dy), min(s.height, s.height - dy)  # the rows that have a row dy further down
        if max(top, first) >= min(bottom, last):
            continue
        clear_rows(patches[2], top - s.weight_y - s.patch_y, first, last, s.stride)
        clear_rows(smooth[2], top - s.weight_y, first, last, s.stride)
        for dx in range(-s.search_x, s.search_x + 1, GROUP):
            for tap in range(GROUP):
                at = tap * plane - top * s.stride  # where row 0 of the image would be
                if dx + tap > s.search_x:
                    fill(weight, place(tap * plane), place(plane), NONE)
                    continue
                box_distances(patches, planes, cancelled, s, top - s.weight_y - s.patch_y, first, last, dy, dx + tap)
                if s.weight_y + s.weight_x > 0:
                    box_weights(smooth, patches, patch_share, s, top, first, last, dx + tap)
                    average_weights(weight, at, smooth, weight_share, s, top, bottom, first, last, dx + tap)
                else:
                    weigh(weight, at, patches, patch_share, s, top, top, bottom, first, last, dx + tap)
                if s.joint > 0:
                    near = exponent[abs(dy), dx + tap + s.search_x]
                    weigh_features(
                        weight, at, likeness, near, planes, s, max(top, first), min(bottom, last), dy, dx + tap
                    )
            add_taps(total, weight, planes.colour, s, max(top, first), min(bottom, last), top, dy, dx)


@kernel
def empty_box(rows, stride):
    """Room for box sums over rows: values, pairs of columns, sums of columns, pairs of rows of those.

    Both kinds of pairs end in zeros: the place of a pair that there is not. (The four arrays are taken out of their
    tuple once an offset, not once a row: that would count references.)
    """
    size = rows * stride
    values, column_sums = np.zeros(size, np.float32), np.zeros(size, np.float32)
    return values, np.zeros(2 * size, np.float32), column_sums, np.zeros(2 * size, np.float32)


@kernel
def clear_rows(rows, begin, first, last, stride):
    """Set the rows to 0 whose image rows (from `begin` on) lie outside [first, last)."""
    for k in range(rows.size // stride):
        if not first <= begin + k < last:
            fill(rows, place(k * stride), place(stride), NONE)


@kernel
def span(rows, s):
    """Columns of a long row, from the first of the image in its first row to the last in its last row."""
    return place(rows * s.stride - 2 * s.margin)


@kernel
def box_distances(box, planes, cancelled, s, begin, first, last, dy, dx):
    """Distances of pixels for one offset, summed over the columns of patches, and pairs of such rows."""
    values = box[0]
    start, stop = max(begin, first), min(begin + values.size // s.stride, last)
    at, n = place((start - begin) * s.stride + s.margin), span(stop - start, s)
    here, there = place(start * s.stride + s.margin), place((start + dy) * s.stride + s.margin + dx)
    compared, level, plane, last_group = planes.compared, planes.level, place(s.height * s.stride), s.compared - GROUP
    if last_group == 0:
        compare(values, at, n, compared, level, here, there, here, there, plane, cancelled)
    else:
        fill(values, at, n, NONE)
        for k in range(0, last_group, GROUP):
            add_squares(values, at, n, compared, here + place(k) * plane, there + place(k) * plane, plane)
        shift = place(last_group) * plane
        compare_on(values, at, n, compared, level, here + shift, there + shift, here, there, plane, cancelled)
    sum_columns(box, s, start - begin, stop - begin, s.patch_x, dx)


@kernel
def sum_columns(box, s, start, stop, reach, dx):
    """Sums over 2 reach + 1 columns of the values in rows start .. stop - 1, and pairs of neighbouring rows of sums.

    Columns that have no column dx further right count as 0, as far as a box may touch them.
    """
    values, column_pairs, sums, row_pairs = box
    left, right = s.margin + max(0, -dx), s.margin + min(s.width, s.width - dx)
    for k in range(start, stop):
        for x in range(k * s.stride + left - reach, k * s.stride + left):
            values[x] = NONE
        for x in range(k * s.stride + right, k * s.stride + right + reach):
            values[x] = NONE
    at, n, far = place(start * s.stride + s.margin), span(stop - start, s), place(reach)
    if reach > 0:
        pair_up(column_pairs, at - far, n + far + far - place(1), values, at - far, at - far + place(1))
    sum_odd(sums, at, n, column_pairs, at - far, place(2), reach, place(values.size), values, at + far)
    pair_up(row_pairs, ZERO, place(sums.size - s.stride), sums, ZERO, place(s.stride))


@kernel
def sum_rows(total, at, rows, box, s, k, reach):
    """Sums over 2 reach + 1 rows of the sums over columns, for `rows` rows from row k of the box on."""
    sums, row_pairs = box[2], box[3]
    first, single = place((k - reach) * s.stride + s.margin), place((k + reach) * s.stride + s.margin)
    sum_odd(total, at, span(rows, s), row_pairs, first, place(2 * s.stride), reach, place(sums.size), sums, single)


@kernel
def rows_inside(y, reach, first, last):
    """How many of the rows y - reach .. y + reach lie in [first, last)."""
    return np.float32(min(y + reach, last - 1) - max(y - reach, first) + 1)


@kernel
def weigh(weight, at, patches, share, s, top, begin, end, first, last, dx):
    """Weights of the image rows begin .. end - 1 that have a row below, from the boxes; row y goes to at + y * stride."""
    start, stop = max(begin, first), min(end, last)
    to = place(at + start * s.stride + s.margin)
    sum_rows(weight, to, stop - start, patches, s, start - top + s.weight_y + s.patch_y, s.patch_y)
    n, column = place(s.length), place((dx + s.search_x) * s.length)
    for y in range(start, stop):
        weigh_patches(weight, to, n, share, column, LOG2_E / rows_inside(y, s.patch_y, first, last))
        to += place(s.stride)


@kernel
def box_weights(smooth, patches, share, s, top, first, last, dx):
    """Weights of the rows of a block and around it, summed over columns, and pairs of such rows."""
    begin = top - s.weight_y
    end = begin + smooth[0].size // s.stride
    weigh(smooth[0], -begin * s.stride, patches, share, s, top, begin, end, first, last, dx)
    sum_columns(smooth, s, max(begin, first) - begin, min(end, last) - begin, s.weight_x, dx)


@kernel
def average_weights(weight, at, smooth, share, s, top, bottom, first, last, dx):
    """Mean weights over a small box, of the rows top .. bottom - 1 that have a row below."""
    start, stop = max(top, first), min(bottom, last)
    to = place(at + start * s.stride + s.margin)
    sum_rows(weight, to, stop - start, smooth, s, start - top + s.weight_y, s.weight_y)
    n, column = place(s.length), place((dx + s.search_x) * s.length)
    for y in range(start, stop):
        average(weight, to, n, share, column, ONE / rows_inside(y, s.weight_y, first, last))
        to += place(s.stride)


@kernel
def weigh_features(weight, at, distance, near, planes, s, start, stop, dy, dx):
    """Multiply weights by the likeness of all features, and by the nearness."""
    plain, noisy, spread = planes.plain, planes.noisy, planes.spread
    n, plane = span(stop - start, s), place(s.height * s.stride)
    here, there = place(start * s.stride + s.margin), place((start + dy) * s.stride + s.margin + dx)
    fill(distance, ZERO, n, NONE)
    for k in range(0, s.plain, GROUP):
        add_squares(distance, ZERO, n, plain, here + place(k) * plane, there + place(k) * plane, plane)
    for k in range(0, s.noisy, GROUP):
        add_normalised(distance, ZERO, n, noisy, spread, here + place(k) * plane, there + place(k) * plane, plane)
    multiply_by_likeness(weight, place(at + start * s.stride + s.margin), n, near, distance)


@kernel
def add_taps(total, weight, colour, s, start, stop, top, dy, dx):
    """Average three taps into the rows start .. stop - 1 of every plane of `total`."""
    n, plane, step, one = span(stop - start, s), s.height * s.stride, place(ROWS_PER_BLOCK * s.stride), place(1)
    first = place((start - top) * s.stride + s.margin)
    second, third = first + step, first + step + step
    for k in range(s.channels):
        to = place(k * plane + start * s.stride + s.margin)
        there = place(k * plane + (start + dy) * s.stride + s.margin + dx)
        add_three_weighted(total, to, n, weight, first, second, third, colour, there, there + one, there + one + one)
