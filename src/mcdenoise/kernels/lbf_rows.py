"""Loops over one row of a pixel's window, for filters whose bandwidths differ from pixel to pixel; rules as in `rows`."""

from __future__ import annotations

import numpy as np

from mcdenoise.kernels.jit import kernel
from mcdenoise.kernels.rows import ZERO, exp2

LIMIT = np.float32(1e6)  # as lbf.distances.PATCH_LIMIT
NOTHING, THIRD = np.float32(0), np.float32(1 / 3)


@kernel
def start_row(exponent, length, steps, outside, border, there, theta, square):
    """exponent[t] = theta (dx^2 + dy^2), beyond every bound outside the window (`outside`) and the image (`border`)."""
    for t in range(ZERO, length):
        exponent[t] = theta * (steps[t] + square) + outside[t] + border[there + t]


@kernel
def add_pixel_colour(exponent, at, length, theta, colour, spread, there, plane, c, v):
    """exponent[at + t] += theta sum over channels of (c_i - c_j)^2 / (v_i + v_j); c, v: three numbers of the centre."""
    (c_0, c_1, c_2), (v_0, v_1, v_2) = c, v
    there_1, there_2 = there + plane, there + plane + plane
    for t in range(ZERO, length):
        a = colour[there + t] - c_0
        b = colour[there_1 + t] - c_1
        d = colour[there_2 + t] - c_2
        exponent[at + t] += theta * (
            a * a / (spread[there + t] + v_0)
            + b * b / (spread[there_1 + t] + v_1)
            + d * d / (spread[there_2 + t] + v_2)
        )


@kernel
def add_patch_colour(exponent, at, length, theta, box, share, column, scale):
    """exponent[at + t] += theta max(0, mean distance of the two patches), from its sum and the numbers of columns."""
    for t in range(ZERO, length):
        exponent[at + t] += theta * max(NOTHING, scale * (share[column + t] * box[column + t]))


@kernel
def add_feature(exponent, at, length, feature, there, plane, f, scale):
    """exponent[at + t] += sum over three planes of scale (f_i - f_j)^2."""
    (f_0, f_1, f_2), (s_0, s_1, s_2) = f, scale
    there_1, there_2 = there + plane, there + plane + plane
    for t in range(ZERO, length):
        a = feature[there + t] - f_0
        b = feature[there_1 + t] - f_1
        c = feature[there_2 + t] - f_2
        exponent[at + t] += s_0 * (a * a) + s_1 * (b * b) + s_2 * (c * c)


@kernel
def add_times(exponent, at, length, theta, distance, first):
    """exponent[at + t] += theta distance[first + t]."""
    for t in range(ZERO, length):
        exponent[at + t] += theta * distance[first + t]


@kernel
def sum_weighted(exponent, length, colour, there, plane):
    """Sum of w = 2^-exponent, and sums of w c for three planes."""
    there_1, there_2 = there + plane, there + plane + plane
    norm, total_0, total_1, total_2 = NOTHING, NOTHING, NOTHING, NOTHING
    for t in range(ZERO, length):
        weight = exp2(-exponent[t])
        norm += weight
        total_0 += weight * colour[there + t]
        total_1 += weight * colour[there_1 + t]
        total_2 += weight * colour[there_2 + t]
    return norm, total_0, total_1, total_2


@kernel
def turn_to_pull(exponent, length, colour, there, plane, g, level):
    """exponent[t] becomes w (g . c_j - level), w = 2^-exponent: how the loss changes if this tap weighs more."""
    g_0, g_1, g_2 = g
    there_1, there_2 = there + plane, there + plane + plane
    for t in range(ZERO, length):
        away = g_0 * colour[there + t] + g_1 * colour[there_1 + t] + g_2 * colour[there_2 + t] - level
        exponent[t] = exp2(-exponent[t]) * away


@kernel
def inner_product(a, b, first, length):
    """Sum of a[t] b[first + t]."""
    total = NOTHING
    for t in range(ZERO, length):
        total += a[t] * b[first + t]
    return total


@kernel
def position_product(a, steps, square, length):
    """Sum of a[t] (dx^2 + dy^2)."""
    total = NOTHING
    for t in range(ZERO, length):
        total += a[t] * (steps[t] + square)
    return total


@kernel
def add_noisy_difference(sums, at, length, colour, level, inside, there, column, plane, c, v):
    """sums[at + t] += (mean over channels of (c_p - c_q)^2 - (v_p + min(v_p, v_q))) / (v_p + v_q), 0 outside the image."""
    c_0, c_1, c_2 = c
    there_1, there_2 = there + plane, there + plane + plane
    for t in range(ZERO, length):
        a = colour[there + t] - c_0
        b = colour[there_1 + t] - c_1
        d = colour[there_2 + t] - c_2
        q = level[there + t]
        ratio = (THIRD * (a * a + b * b + d * d) - (v + min(v, q))) / (v + q)
        sums[at + t] += inside[column + t] * max(min(ratio, LIMIT), -LIMIT)
