"""Loops over one image row for NL-means; they follow the rules of `rows`."""

from __future__ import annotations

import numpy as np

from mcdenoise.kernels.jit import kernel
from mcdenoise.kernels.planes import SMALLEST
from mcdenoise.kernels.rows import ZERO, exp2, place

LIMIT = np.float32(1e4)  # as filters.nlm.LIMIT
NONE = np.float32(0)
LEAST = np.float32(
    2 * SMALLEST
)  # the noise of two pixels without noise: they differ by nothing, and nothing is taken off


@kernel
def compare(distance, at, length, compared, level, here, there, here_level, there_level, plane, cancelled):
    """distance[at + x] = (squares of three planes - noise that is taken off) / noise, between two rows.

    The noise is level_p + level_q; taken off is `cancelled` (level_p + min(level_p, level_q)).
    """
    here_1, here_2, there_1, there_2 = here + plane, here + plane + plane, there + plane, there + plane + plane
    for x in range(ZERO, length):
        a = compared[here + x] - compared[there + x]
        b = compared[here_1 + x] - compared[there_1 + x]
        c = compared[here_2 + x] - compared[there_2 + x]
        p, q = level[here_level + x], level[there_level + x]
        ratio = (a * a + b * b + c * c - cancelled * (p + min(p, q) - LEAST)) / (p + q)
        distance[at + x] = max(min(ratio, LIMIT), -LIMIT)


@kernel
def compare_on(distance, at, length, compared, level, here, there, here_level, there_level, plane, cancelled):
    """As `compare`, with the squares of earlier planes found in distance[at + x]."""
    here_1, here_2, there_1, there_2 = here + plane, here + plane + plane, there + plane, there + plane + plane
    for x in range(ZERO, length):
        a = compared[here + x] - compared[there + x]
        b = compared[here_1 + x] - compared[there_1 + x]
        c = compared[here_2 + x] - compared[there_2 + x]
        p, q = level[here_level + x], level[there_level + x]
        ratio = (distance[at + x] + a * a + b * b + c * c - cancelled * (p + min(p, q) - LEAST)) / (p + q)
        distance[at + x] = max(min(ratio, LIMIT), -LIMIT)


@kernel
def fill(row, at, length, value):
    """row[at + x] = value."""
    for x in range(at, at + length):
        row[x] = value


@kernel
def pair_up(pairs, at, length, row, one, other):
    """pairs[at + x] = row[one + x] + row[other + x]."""
    for x in range(ZERO, length):
        pairs[at + x] = row[one + x] + row[other + x]


@kernel
def add_pairs(total, at, length, pairs, first, second, third):
    """total[at + x] += three pairs."""
    for x in range(ZERO, length):
        total[at + x] += pairs[first + x] + pairs[second + x] + pairs[third + x]


@kernel
def sum_pairs(total, at, length, pairs, first, second, third, row, single):
    """total[at + x] = three pairs and a single number."""
    for x in range(ZERO, length):
        total[at + x] = pairs[first + x] + pairs[second + x] + pairs[third + x] + row[single + x]


@kernel
def sum_odd(total, at, length, pairs, first, step, reach, zero, row, single):
    """total[at + x] = `reach` pairs, from `first` on in steps, and a single number: a box of 2 reach + 1."""
    sum_pairs(
        total, at, length, pairs,
        first if reach > 0 else zero,
        first + step if reach > 1 else zero,
        first + step + step if reach > 2 else zero,
        row, single,
    )  # fmt: skip
    for done in range(3, reach, 3):
        one = first + place(done) * step
        two = one + step if reach > done + 1 else zero
        three = one + step + step if reach > done + 2 else zero
        add_pairs(total, at, length, pairs, one, two, three)


@kernel
def weigh_patches(weight, at, length, share, column, scale):
    """weight[at + x], a sum of distances, becomes 2^-(scale share distance), at most 1."""
    for x in range(ZERO, length):
        weight[at + x] = exp2(min(NONE, -scale * (share[column + x] * weight[at + x])))


@kernel
def average(weight, at, length, share, column, scale):
    """weight[at + x], a sum of weights, becomes their mean."""
    for x in range(ZERO, length):
        weight[at + x] *= scale * share[column + x]


@kernel
def multiply_by_likeness(weight, at, length, exponent, distance):
    """weight[at + x] *= 2^(exponent - distance[x])."""
    for x in range(ZERO, length):
        weight[at + x] *= exp2(exponent - distance[x])


@kernel
def add_three_weighted(total, at, length, weight, first, second, third, colour, there_1, there_2, there_3):
    """total[at + x] += weight * colour for three taps."""
    for x in range(ZERO, length):
        total[at + x] += (
            weight[first + x] * colour[there_1 + x]
            + weight[second + x] * colour[there_2 + x]
            + weight[third + x] * colour[there_3 + x]
        )
