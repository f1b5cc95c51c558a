"""The kernels of NL-means: shift and box.

For one offset (dy, dx) the distance of every pixel to the pixel dy, dx away is a whole image, and the distance of
patches is a box sum of it. So the loop over offsets stands outside, and patches cost next to nothing, whatever their
size. Per block of rows and offset, row by row:

    distances of pixels -> sums of 2 patch_x + 1 columns -> sums of 2 patch_y + 1 rows -> weights
    (-> the mean weight of a small box) (-> times the likeness of features) -> total and norm

A box of 2 r + 1 rows is r pairs of rows and a single one; each pair is added up once and used by r boxes. (A running
sum would be cheaper still, but never loses the rounding errors of a steep edge it has passed.)

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
    length: int  # columns that a row loop runs over
    margin: int  # columns before the first one of the image
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
    """Fill `total`, flat planes of (height, length), in blocks of rows."""
    for block in prange((s.height + ROWS_PER_BLOCK - 1) // ROWS_PER_BLOCK):
        block_sums(total, planes, exponent, patch_share, weight_share, cancelled, s, block * ROWS_PER_BLOCK)


@kernel
def block_sums(total, planes, exponent, patch_share, weight_share, cancelled, s, top):
    """Sums of the rows from `top` on, over all offsets, three steps in x at a time."""
    bottom, plane = min(top + ROWS_PER_BLOCK, s.height), ROWS_PER_BLOCK * s.length
    weight = np.zeros(GROUP * plane, np.float32)
    rows = ROWS_PER_BLOCK + 2 * s.weight_y
    patches = empty_box(rows + 2 * s.patch_y, s.patch_x, s.length)
    smooth = empty_box(rows, s.weight_x, s.length)
    likeness = np.zeros(s.length, np.float32)
    for dy in range(-s.search_y, s.search_y + 1):
        first, last = max(0, -dy), min(s.height, s.height - dy)  # the rows that have a row dy further down
        clear_rows(patches[2], top - s.weight_y - s.patch_y, first, last, s.length)
        clear_rows(smooth[2], top - s.weight_y, first, last, s.length)
        start, stop = max(top, first), min(bottom, last)
        for dx in range(-s.search_x, s.search_x + 1, GROUP):
            for tap in range(GROUP):
                at = tap * plane - top * s.length
                if dx + tap > s.search_x:
                    fill(weight, place(tap * plane), place(plane), NONE)
                    continue
                box_distances(patches, planes, cancelled, s, top - s.weight_y - s.patch_y, first, last, dy, dx + tap)
                if s.weight_y + s.weight_x > 0:
                    box_weights(smooth, patches, patch_share, s, top, first, last, dx + tap)
                    average_weights(weight, at, smooth, weight_share, s, start, stop, top, first, last, dx + tap)
                else:
                    weigh(weight, at, s.length, patches, patch_share, s, start, stop, top, first, last, dx + tap)
                if s.joint > 0:
                    near = exponent[abs(dy), dx + tap + s.search_x]
                    weigh_features(weight, at, likeness, near, planes, s, start, stop, dy, dx + tap)
            add_taps(total, weight, planes.colour, s, start, stop, top, dy, dx)


@kernel
def empty_box(rows, reach_x, length):
    """Room for box sums of an image of `rows` x `length`: a row with margins, pairs of columns, box rows, pairs of rows.

    Both kinds of pairs end in zeros: the place of a pair that there is not. (The four arrays are taken out of their
    tuple once an offset, not once a row: that would count references.)
    """
    row = np.zeros(length + 2 * reach_x, np.float32)
    column_pairs = np.zeros(2 * length + 2 * reach_x, np.float32)
    return row, column_pairs, np.zeros(rows * length, np.float32), np.zeros((rows + 1) * length, np.float32)


@kernel
def clear_rows(rows, start, first, last, length):
    """Set the box rows to 0 whose image rows (from `start` on) lie outside [first, last)."""
    for k in range(rows.size // length):
        if not first <= start + k < last:
            fill(rows, place(k * length), place(length), NONE)


@kernel
def box_distances(box, planes, cancelled, s, start, first, last, dy, dx):
    """Distances of pixels for one offset, summed over the columns of patches, and pairs of such rows."""
    row, column_pairs, rows, row_pairs = box
    compared, level, stride = planes.compared, planes.level, s.length + 2 * s.margin
    for y in range(max(start, first), min(start + rows.size // s.length, last)):
        here, there = place(y * stride + s.margin), place((y + dy) * stride + s.margin + dx)
        compare_rows(row, place(s.patch_x), place(s.length), compared, level, cancelled, here, there, s)
        clear_columns(row, s.patch_x, dx, s.width)
        sum_columns(rows, place((y - start) * s.length), place(s.length), row, column_pairs, s.patch_x)
    pair_up(row_pairs, ZERO, place(rows.size - s.length), rows, ZERO, place(s.length))


@kernel
def compare_rows(row, at, n, compared, level, cancelled, here, there, s):
    """Distances of the pixels of two rows, from all compared planes, three at a time."""
    plane, last = place(s.height * (s.length + 2 * s.margin)), s.compared - GROUP
    if last == 0:
        compare(row, at, n, compared, level, here, there, here, there, plane, cancelled)
        return
    fill(row, at, n, NONE)
    for k in range(0, last, GROUP):
        add_squares(row, at, n, compared, here + place(k) * plane, there + place(k) * plane, plane)
    shift = place(last) * plane
    compare_on(row, at, n, compared, level, here + shift, there + shift, here, there, plane, cancelled)


@kernel
def clear_columns(row, reach, dx, width):
    """Set to 0 what a box may touch of the columns that have no column dx further right; `row` has margins of `reach`."""
    for x in range(max(0, -dx), max(0, -dx) + reach):
        row[x] = NONE
    for x in range(min(width, width - dx) + reach, min(width, width - dx) + 2 * reach):
        row[x] = NONE


@kernel
def sum_columns(rows, at, n, row, pairs, reach):
    """One box row: sums over 2 reach + 1 columns of the row with margins."""
    margins = place(2 * reach)
    if reach > 0:
        pair_up(pairs, ZERO, n + margins - place(1), row, ZERO, place(1))
    sum_odd(rows, at, n, pairs, ZERO, place(2), reach, n + margins, row, margins)


@kernel
def sum_rows(total, at, length, rows, pairs, k, reach):
    """total = sum of the box rows k - reach .. k + reach."""
    first, single = place((k - reach) * length), place((k + reach) * length)
    sum_odd(total, at, place(length), pairs, first, place(2 * length), reach, place(rows.size), rows, single)


@kernel
def rows_inside(y, reach, first, last):
    """How many of the rows y - reach .. y + reach lie in [first, last)."""
    return np.float32(min(y + reach, last - 1) - max(y - reach, first) + 1)


@kernel
def weigh(weight, at, step, patches, share, s, start, stop, top, first, last, dx):
    """Weights of the rows start .. stop - 1 from the box rows of patches; row y goes to at + y * step."""
    _, _, rows, pairs = patches
    n, column = place(s.length), place((dx + s.search_x) * s.length)
    for y in range(start, stop):
        to = place(at + y * step)
        sum_rows(weight, to, s.length, rows, pairs, y - top + s.weight_y + s.patch_y, s.patch_y)
        weigh_patches(weight, to, n, share, column, LOG2_E / rows_inside(y, s.patch_y, first, last))


@kernel
def box_weights(smooth, patches, share, s, top, first, last, dx):
    """Weights of the rows of a block and around it, summed over columns, and pairs of such rows."""
    row, column_pairs, rows, row_pairs = smooth
    begin = top - s.weight_y
    for y in range(max(begin, first), min(begin + rows.size // s.length, last)):
        weigh(row, s.weight_x, 0, patches, share, s, y, y + 1, top, first, last, dx)
        clear_columns(row, s.weight_x, dx, s.width)
        sum_columns(rows, place((y - begin) * s.length), place(s.length), row, column_pairs, s.weight_x)
    pair_up(row_pairs, ZERO, place(rows.size - s.length), rows, ZERO, place(s.length))


@kernel
def average_weights(weight, at, smooth, share, s, start, stop, top, first, last, dx):
    """Mean weights of the rows start .. stop - 1, over a small box."""
    _, _, rows, pairs = smooth
    n, column = place(s.length), place((dx + s.search_x) * s.length)
    for y in range(start, stop):
        to = place(at + y * s.length)
        sum_rows(weight, to, s.length, rows, pairs, y - top + s.weight_y, s.weight_y)
        average(weight, to, n, share, column, ONE / rows_inside(y, s.weight_y, first, last))


@kernel
def weigh_features(weight, at, distance, near, planes, s, start, stop, dy, dx):
    """Multiply weights by the likeness of all features, and by the nearness."""
    plain, noisy, spread = planes.plain, planes.noisy, planes.spread
    stride, n = s.length + 2 * s.margin, place(s.length)
    plane = place(s.height * stride)
    for y in range(start, stop):
        here, there = place(y * stride + s.margin), place((y + dy) * stride + s.margin + dx)
        fill(distance, ZERO, n, NONE)
        for k in range(0, s.plain, GROUP):
            add_squares(distance, ZERO, n, plain, here + place(k) * plane, there + place(k) * plane, plane)
        for k in range(0, s.noisy, GROUP):
            add_normalised(distance, ZERO, n, noisy, spread, here + place(k) * plane, there + place(k) * plane, plane)
        multiply_by_likeness(weight, place(at + y * s.length), n, near, distance)


@kernel
def add_taps(total, weight, colour, s, start, stop, top, dy, dx):
    """Average three taps into the rows start .. stop - 1 of every plane of `total`."""
    stride, n, step, one = s.length + 2 * s.margin, place(s.length), place(ROWS_PER_BLOCK * s.length), place(1)
    for y in range(start, stop):
        first = place((y - top) * s.length)
        for k in range(s.channels):
            to = place((k * s.height + y) * s.length)
            there = place((k * s.height + y + dy) * stride + s.margin + dx)
            add_three_weighted(
                total,
                to,
                n,
                weight,
                first,
                first + step,
                first + step + step,
                colour,
                there,
                there + one,
                there + one + one,
            )
