"""The fast twin of the filter layer: bandwidths of the centre pixel, so every pixel gathers for itself.

The loop over a window's columns stands inside: one row of the window is one run of memory, the numbers of the centre
stay in registers, and any rows of the image can be asked for. Rows of the window are `length` long, whole vectors;
what lies outside the window or the image gets an exponent beyond every bound, and the weight 0. Weights are
not kept: the backward pass computes them again.

Patches: for one offset dy the distances of pixels are summed over the rows of the patch, for every pixel of the image row
and every dx; boxes over columns of these sums are the distances of patches.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange

from mcdenoise.kernels.jit import kernel
from mcdenoise.kernels.lbf_rows import (
    add_feature,
    add_noisy_difference,
    add_patch_colour,
    add_pixel_colour,
    add_times,
    inner_product,
    position_product,
    start_row,
    sum_weighted,
    turn_to_pull,
)
from mcdenoise.kernels.patch_rows import fill, pair_up, sum_odd
from mcdenoise.kernels.planes import FAR, GROUP
from mcdenoise.kernels.rows import ZERO, place

STEP = 16
HIDDEN = np.float32(127)  # an exponent from which on the weight is 0
NONE = np.float32(0)
ONE = np.float32(1)


class Planes(NamedTuple):
    """What the kernels read: flat arrays; rows of the planes are padded, `reach` columns to the left."""

    colour: np.ndarray  # (3, h, stride)
    spread: np.ndarray  # (3, h, stride), what divides the squares of colour: variance plus half of epsilon
    level: np.ndarray  # (h, stride), the mean of `spread`, or nothing without patches
    features: np.ndarray  # (3 groups, h, stride)
    scale: np.ndarray  # (h, w, 3 groups), 1 / variance of the centre
    border: np.ndarray  # (stride,), 0 inside the image, FAR outside
    inside: np.ndarray  # (stride,), 1 inside the image, 0 outside
    steps: np.ndarray  # (length,), dx^2
    outside: np.ndarray  # (length,), 0 in the window, FAR outside
    share: np.ndarray  # (w, length), 1 / number of columns of two patches


class Sizes(NamedTuple):
    """Every whole number that the kernels need."""

    height: int
    width: int
    stride: int
    length: int
    reach_y: int
    reach_x: int
    groups: int
    patch_y: int  # -1: colours of pixels are compared, not of patches
    patch_x: int


def layer_planes(
    colour: np.ndarray,
    spread: np.ndarray,
    features: list[np.ndarray],
    scales: list[np.ndarray],
    radius: int,
    patch_radius: int | None,
) -> tuple[Planes, Sizes]:
    """Lay out colour (h, w, 3), what divides its squares, features (h, w, c) and the scales of their squares."""
    height, width, _ = colour.shape
    reach_y, reach_x = min(radius, height - 1), min(radius, width - 1)
    length = -(-(2 * reach_x + 1) // STEP) * STEP
    stride = width + length
    inside = np.s_[..., reach_x : reach_x + width]
    patch = (-1, -1) if patch_radius is None else (min(patch_radius, height - 1), min(patch_radius, width - 1))

    def padded(channels: list[np.ndarray], fill: float = 0.0) -> np.ndarray:
        planes = np.full((len(channels), height, stride), fill, np.float32)
        for plane, channel in zip(planes, channels, strict=True):
            plane[inside] = channel
        return planes.ravel()

    spreads = np.moveaxis(spread, -1, 0)
    column = np.arange(stride) - reach_x
    dx = np.arange(length) - reach_x
    within = (column >= 0) & (column < width)
    planes = Planes(
        colour=padded(np.moveaxis(colour, -1, 0)),
        spread=padded(spreads, 1.0),
        level=padded([spreads.mean(axis=0)], 1.0),
        features=padded(_in_threes(features)),
        scale=np.ascontiguousarray(
            np.moveaxis(np.array(_in_threes(scales), np.float32).reshape(-1, height, width), 0, -1)
        ).ravel(),
        border=np.where(within, 0, FAR).astype(np.float32),
        inside=within.astype(np.float32),
        steps=(dx**2).astype(np.float32),
        outside=np.where(dx <= reach_x, 0, FAR).astype(np.float32),
        share=_column_shares(width, dx, patch[1]).ravel(),
    )
    return planes, Sizes(height, width, stride, length, reach_y, reach_x, len(features), *patch)


def _in_threes(groups: list[np.ndarray]) -> list[np.ndarray]:
    """The channels of all groups, each group filled up to three."""
    return [
        group[..., k] if k < group.shape[-1] else np.zeros(group.shape[:2], np.float32)
        for group in groups
        for k in range(GROUP)
    ]


def _column_shares(width: int, dx: np.ndarray, reach: int) -> np.ndarray:
    """1 / number of columns of a patch that lie inside with and without dx, (w, length)."""
    column = np.arange(width)[:, np.newaxis]
    first = np.maximum(column - reach, np.maximum(0, -dx))
    last = np.minimum(column + reach, np.minimum(width, width - dx) - 1)
    return (1 / np.maximum(last - first + 1, 1)).astype(np.float32)


def layer_forward(planes: Planes, sizes: Sizes, theta: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sum of w c (rows, w, 3) and sum of w (rows, w); theta (rows, w, 2 + groups) in units of log 2."""
    total = np.empty((len(rows), sizes.width, 3), np.float32)
    norm = np.empty((len(rows), sizes.width), np.float32)
    forward_rows(total, norm, planes, sizes, theta, rows)
    return total, norm


def layer_backward(
    planes: Planes, sizes: Sizes, theta: np.ndarray, rows: np.ndarray, pull: np.ndarray, level: np.ndarray
) -> np.ndarray:
    """d_theta (rows, w, 2 + groups): minus the sum of w E (pull . c - level)."""
    gradient = np.empty(theta.shape, np.float32)
    backward_rows(gradient, planes, sizes, theta, rows, pull, level)
    return gradient


@kernel(parallel=True)
def forward_rows(total, norm, planes, s, theta, rows):
    """Fill `total` and `norm`, one image row after the other."""
    for k in prange(len(rows)):
        forward_row(total[k], norm[k], planes, s, theta[k], rows[k])


@kernel(parallel=True)
def backward_rows(gradient, planes, s, theta, rows, pull, level):
    """Fill `gradient`, one image row after the other."""
    for k in prange(len(rows)):
        backward_row(gradient[k], planes, s, theta[k], rows[k], pull[k], level[k])


@kernel
def forward_row(total, norm, planes, s, theta, y):
    """One image row of the forward pass. (Arrays are taken out of their tuple here: that counts references.)"""
    colour, spread, features, scale = planes.colour, planes.spread, planes.features, planes.scale
    steps, outside, border, share = planes.steps, planes.outside, planes.border, planes.share
    n, plane = place(s.length), place(s.height * s.stride)
    exponent = np.empty(s.length, np.float32)
    sums, box, pairs = patch_buffers(s)
    total[:] = NONE
    norm[:] = NONE
    for dy in range(max(-s.reach_y, -y), min(s.reach_y, s.height - 1 - y) + 1):
        if s.patch_y >= 0:
            patch_distances(sums, box, pairs, planes, s, y, dy)
        square, patch_share = np.float32(dy * dy), ONE / np.float32(rows_inside(s, y, dy))
        for x in range(s.width):
            if theta[x, 0] * square >= HIDDEN:
                continue
            here, there = y * s.stride + s.reach_x + x, (y + dy) * s.stride + x
            start_row(exponent, n, steps, outside, border, place(x), theta[x, 0], square)
            add_colour(
                exponent,
                ZERO,
                theta[x, 1],
                colour,
                spread,
                box,
                share,
                patch_share,
                s,
                here,
                there,
                place(x * s.length),
            )
            for k in range(s.groups):
                add_group(exponent, ZERO, theta[x, 2 + k], features, scale, s, k, y * s.width + x, here, there)
            w, c_0, c_1, c_2 = sum_weighted(exponent, n, colour, place(there), plane)
            norm[x] += w
            total[x, 0] += c_0
            total[x, 1] += c_1
            total[x, 2] += c_2


@kernel
def backward_row(gradient, planes, s, theta, y, pull, level):
    """One image row of the backward pass."""
    colour, spread, features, scale = planes.colour, planes.spread, planes.features, planes.scale
    steps, outside, border, share = planes.steps, planes.outside, planes.border, planes.share
    n, plane = place(s.length), place(s.height * s.stride)
    exponent, distance = np.empty(s.length, np.float32), np.empty((1 + s.groups) * s.length, np.float32)
    sums, box, pairs = patch_buffers(s)
    gradient[:] = NONE
    for dy in range(max(-s.reach_y, -y), min(s.reach_y, s.height - 1 - y) + 1):
        if s.patch_y >= 0:
            patch_distances(sums, box, pairs, planes, s, y, dy)
        square, patch_share = np.float32(dy * dy), ONE / np.float32(rows_inside(s, y, dy))
        for x in range(s.width):
            if theta[x, 0] * square >= HIDDEN:
                continue
            here, there = y * s.stride + s.reach_x + x, (y + dy) * s.stride + x
            start_row(exponent, n, steps, outside, border, place(x), theta[x, 0], square)
            fill(distance, ZERO, place(distance.size), NONE)
            add_colour(
                distance, ZERO, ONE, colour, spread, box, share, patch_share, s, here, there, place(x * s.length)
            )
            for k in range(s.groups):
                add_group(distance, place((1 + k) * s.length), ONE, features, scale, s, k, y * s.width + x, here, there)
            for k in range(1 + s.groups):
                add_times(exponent, ZERO, n, theta[x, 1 + k], distance, place(k * s.length))
            g = pull[x, 0], pull[x, 1], pull[x, 2]
            turn_to_pull(exponent, n, colour, place(there), plane, g, level[x])
            gradient[x, 0] -= position_product(exponent, steps, square, n)
            for k in range(1 + s.groups):
                gradient[x, 1 + k] -= inner_product(exponent, distance, place(k * s.length), n)


@kernel
def three(values, at, step):
    """Three numbers, `step` apart."""
    return values[at], values[at + step], values[at + step + step]


@kernel
def add_colour(exponent, at, theta, colour, spread, box, share, patch_share, s, here, there, column):
    """Add theta times the distance of the colours of two pixels, or of the patches around them."""
    n, plane = place(s.length), place(s.height * s.stride)
    if s.patch_y >= 0:
        add_patch_colour(exponent, at, n, theta, box, share, column, patch_share)
    else:
        c, v = three(colour, place(here), plane), three(spread, place(here), plane)
        add_pixel_colour(exponent, at, n, theta, colour, spread, place(there), plane, c, v)


@kernel
def add_group(exponent, at, theta, features, scale, s, k, pixel, here, there):
    """Add theta times the distance of one group of features."""
    plane, first = place(s.height * s.stride), GROUP * k * s.height * s.stride
    s_0, s_1, s_2 = three(scale, place((pixel * s.groups + k) * GROUP), place(1))
    centre = three(features, place(first + here), plane)
    scaled = theta * s_0, theta * s_1, theta * s_2
    add_feature(exponent, at, place(s.length), features, place(first + there), plane, centre, scaled)


@kernel
def rows_inside(s, y, dy):
    """How many rows of a patch around row y lie inside, with and without dy."""
    return min(y + s.patch_y, s.height - 1 - max(dy, 0)) - max(y - s.patch_y, max(0, -dy)) + 1


@kernel
def patch_buffers(s):
    """Room for sums over the rows of patches (`patch_x` empty columns on both sides), for boxes, and for pairs of columns."""
    if s.patch_y < 0:
        return np.empty(0, np.float32), np.empty(0, np.float32), np.empty(0, np.float32)
    size, more = s.width * s.length, 2 * s.patch_x * s.length
    return np.zeros(size + more, np.float32), np.empty(size, np.float32), np.zeros(2 * size + more, np.float32)


@kernel
def patch_distances(sums, box, pairs, planes, s, y, dy):
    """Distances of patches, not yet divided by their size: those of all pixels of row y from all in row y + dy."""
    colour, level, inside = planes.colour, planes.level, planes.inside
    n, plane = place(s.length), place(s.height * s.stride)
    first, last = max(y - s.patch_y, max(0, -dy)), min(y + s.patch_y, s.height - 1 - max(dy, 0))
    fill(sums, place(s.patch_x * s.length), place(s.width * s.length), NONE)
    for row in range(first, last + 1):
        for x in range(s.width):
            here, there = place(row * s.stride + s.reach_x + x), place((row + dy) * s.stride + x)
            to, c = place((s.patch_x + x) * s.length), three(colour, here, plane)
            add_noisy_difference(sums, to, n, colour, level, inside, there, place(x), plane, c, level[here])
    if s.patch_x > 0:
        pair_up(pairs, ZERO, place(sums.size - s.length), sums, ZERO, n)
    single, zero = place(2 * s.patch_x * s.length), place(sums.size)
    sum_odd(box, ZERO, place(box.size), pairs, ZERO, place(2 * s.length), s.patch_x, zero, sums, single)
