"""How fast does this machine multiply and add, and raise 2 to a power, where nothing else is in the way?

That is the limit a filter's time is held against: the same compiler and threads, numbers that never leave the first
level of cache, and more independent chains of work than the units have stages. The factors come as arguments: two
constant multiply-adds in a row would be folded into one.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from mcdenoise.kernels.jit import kernel
from mcdenoise.kernels.rows import ZERO, exp2, place

CHAIN = 16  # multiply-adds of each value a round: one load and one store for so many


@kernel(parallel=True)
def multiply_adds(values, rounds, a, b, c, d):
    """CHAIN * rounds multiply-adds of each of `values` (threads, n), n a multiple of 4: v -> (v a + b) c + d, repeated.

    Examples
    --------
    >>> values = np.zeros((1, 4), np.float32)
    >>> multiply_adds(values, 1, *np.float32([1, 2, 0.5, 0]))  # CHAIN / 2 steps from 0 towards 2
    >>> float(values[0, 0])
    1.9921875
    """
    for thread in prange(values.shape[0]):
        chain_row(values[thread], rounds, a, b, c, d)


@kernel(parallel=True)
def exponentials(values, rounds):
    """Replace each of `values` (threads, n), all >= 0, by 2^-(value + 0 .. 7), `rounds` times.

    Examples
    --------
    >>> values = np.array([[0, 1]], np.float32)
    >>> exponentials(values, 1)
    >>> values
    array([[1. , 0.5]], dtype=float32)
    """
    for thread in prange(values.shape[0]):
        power_row(values[thread], rounds)


@kernel
def chain_row(row, rounds, a, b, c, d):
    """The multiply-adds of one row, a value of each quarter at a time: four chains."""
    n = place(row.size) // place(4)
    second, third, fourth = n, n + n, n + n + n
    for _ in range(rounds):
        for x in range(ZERO, n):
            row[x], row[second + x], row[third + x], row[fourth + x] = (
                chain(row[x], a, b, c, d),
                chain(row[second + x], a, b, c, d),
                chain(row[third + x], a, b, c, d),
                chain(row[fourth + x], a, b, c, d),
            )


@kernel
def chain(v, a, b, c, d):
    """CHAIN multiply-adds in a row."""
    v = (((v * a + b) * c + d) * a + b) * c + d
    v = (((v * a + b) * c + d) * a + b) * c + d
    v = (((v * a + b) * c + d) * a + b) * c + d
    return (((v * a + b) * c + d) * a + b) * c + d


@kernel
def power_row(row, rounds):
    """The exponentials of one row; the step keeps the compiler from doing them once for all rounds."""
    n = place(row.size)
    for turn in range(rounds):
        step = -np.float32(turn % 8)
        for x in range(ZERO, n):
            row[x] = exp2(step - row[x])
