"""Loops over one image row: the only places where a windowed kernel spends time.

Measured rules that every loop here follows, each worth a factor of 1.5 to 4:

- All arrays are flat, contiguous and float32; a row is a place (its first index) in one of them. A slice per row would
  cost more than the row: numba counts references to it, atomically, in every thread.
- Places and counters are unsigned (`place`). For a signed index numba asks whether it is negative, and the loop stays
  scalar.
- Each loop writes to one row. For several, the compiler cannot rule out that they overlap, and gives up vectorising.
- No bare float literals: one 0.5 promotes the whole expression to float64.
"""

from __future__ import annotations

import numpy as np

from mcdenoise.kernels.jit import kernel

place = np.uint64
ZERO = place(0)

# 2^f = sum_k EXP2[k] f^k on (-1, 0]: the smallest largest relative error, 8.4e-8, with EXP2[0] = 1 (linear
# programming).
EXP2 = (1.0, 6.931437242e-01, 2.401801688e-01, 5.529743525e-02, 9.205891324e-03, 9.449426442e-04)
A0, A1, A2, A3, A4, A5 = (np.float32(a) for a in EXP2)
LOWEST = np.float32(-127)
BIAS, MANTISSA_BITS = np.int32(127), np.int32(23)


@kernel
def exp2(t):
    """2^t for t <= 0, relative error below 4e-7; exactly 1 at t = 0 and exactly 0 for t <= -127.

    The whole part of t goes into the exponent bits of a float32, the fraction through a polynomial.
    """
    t = max(t, LOWEST)
    whole = np.int32(t)
    f = t - np.float32(whole)
    power = np.int32((whole + BIAS) << MANTISSA_BITS).view(np.float32)
    return (A0 + f * (A1 + f * (A2 + f * (A3 + f * (A4 + f * A5))))) * power


@kernel
def add_squares(distance, at, length, guide, here, there, plane):
    """distance[at + x] += squared distance of three guide planes between the rows at `here` and `there`."""
    here_1, here_2, there_1, there_2 = here + plane, here + plane + plane, there + plane, there + plane + plane
    for x in range(ZERO, length):
        a = guide[here + x] - guide[there + x]
        b = guide[here_1 + x] - guide[there_1 + x]
        c = guide[here_2 + x] - guide[there_2 + x]
        distance[at + x] += a * a + b * b + c * c


@kernel
def add_normalised(distance, at, length, guide, spread, here, there, plane):
    """As `add_squares`, each square divided by the sum of the two pixels' `spread`."""
    here_1, here_2, there_1, there_2 = here + plane, here + plane + plane, there + plane, there + plane + plane
    for x in range(ZERO, length):
        a = guide[here + x] - guide[there + x]
        b = guide[here_1 + x] - guide[there_1 + x]
        c = guide[here_2 + x] - guide[there_2 + x]
        distance[at + x] += (
            a * a / (spread[here + x] + spread[there + x])
            + b * b / (spread[here_1 + x] + spread[there_1 + x])
            + c * c / (spread[here_2 + x] + spread[there_2 + x])
        )


@kernel
def weigh(weight, at, length, exponent, guide, here, there, plane):
    """weight[at + x] = 2^(exponent - squared distance of three guide planes between the rows at `here`, `there`)."""
    here_1, here_2, there_1, there_2 = here + plane, here + plane + plane, there + plane, there + plane + plane
    for x in range(ZERO, length):
        a = guide[here + x] - guide[there + x]
        b = guide[here_1 + x] - guide[there_1 + x]
        c = guide[here_2 + x] - guide[there_2 + x]
        weight[at + x] = exp2(exponent - (a * a + b * b + c * c))


@kernel
def weigh_on(weight, at, length, exponent, guide, here, there, plane):
    """As `weigh`, with the squared distance of earlier planes found in weight[at + x]."""
    here_1, here_2, there_1, there_2 = here + plane, here + plane + plane, there + plane, there + plane + plane
    for x in range(ZERO, length):
        a = guide[here + x] - guide[there + x]
        b = guide[here_1 + x] - guide[there_1 + x]
        c = guide[here_2 + x] - guide[there_2 + x]
        weight[at + x] = exp2(exponent - (weight[at + x] + a * a + b * b + c * c))


@kernel
def add_two(total, at, length, weight, one, other):
    """total[at + x] += the weights at `one` and at `other`."""
    for x in range(ZERO, length):
        total[at + x] += weight[one + x] + weight[other + x]


@kernel
def add_two_weighted(total, at, length, weight, one, other, colour, there_one, there_other):
    """total[at + x] += weight * colour for the weights at `one` and at `other`."""
    for x in range(ZERO, length):
        total[at + x] += weight[one + x] * colour[there_one + x] + weight[other + x] * colour[there_other + x]


@kernel
def scale(total, at, weight, image, there, length):
    """total[at + x] = weight * image[there + x]: one weight for the whole row."""
    for x in range(ZERO, length):
        total[at + x] = weight * image[there + x]


@kernel
def add_scaled(total, at, weight, image, there, length):
    """total[at + x] += weight * image[there + x]: one weight for the whole row."""
    for x in range(ZERO, length):
        total[at + x] += weight * image[there + x]


@kernel
def add_pair(total, at, weight, image, one, other, length):
    """total[at + x] += weight * (image[one + x] + image[other + x]): two rows at the same distance."""
    for x in range(ZERO, length):
        total[at + x] += weight * (image[one + x] + image[other + x])
