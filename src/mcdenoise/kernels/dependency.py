"""The fast twin of mutual information, by counting bits: a level of a variable is a row of bits, one a sample.

The samples that have level a in one variable and level b in another are the bits that two rows have in common: an AND and
a count of bits handle 64 samples at once, where a joint histogram takes them one by one. With counts n_xy, n_x, n_y of N
samples, mu = log N + (sum n_xy log n_xy - sum n_x log n_x - sum n_y log n_y) / N, with n log n from a table.
"""

from __future__ import annotations

import numpy as np
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

from mcdenoise.kernels.jit import kernel
from mcdenoise.kernels.rows import ZERO, place

ROUNDING = 1e-12  # nats, as in rpf.dependency
WORD, ONE, FOUR = place(64), place(1), place(4)
ALL = ~ZERO


@intrinsic
def popcount(typing_context, word):
    """Count the bits of a 64 bit word."""

    def generate(context, builder, signature, arguments):
        return builder.ctpop(arguments[0])

    return types.uint64(types.uint64), generate


@intrinsic
def equal_bits(typing_context, codes, at, code):
    """One word: bit k says whether codes[at + k], of 64 bytes from codes[at] on, is `code`."""

    def generate(context, builder, signature, arguments):
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        bytes_64 = ir.VectorType(ir.IntType(8), 64)
        start = builder.bitcast(builder.gep(array.data, [arguments[1]]), bytes_64.as_pointer())
        first = builder.insert_element(ir.Constant(bytes_64, ir.Undefined), arguments[2], ir.IntType(32)(0))
        lanes = ir.Constant(ir.VectorType(ir.IntType(32), 64), [0] * 64)
        everywhere = builder.shuffle_vector(first, ir.Constant(bytes_64, ir.Undefined), lanes)
        same = builder.icmp_unsigned("==", builder.load(start, align=1), everywhere)
        return builder.bitcast(same, ir.IntType(64))

    return types.uint64(codes, types.uint64, types.uint8), generate


def information_of_pairs(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Mutual information, in nats, of each column of x (n, a) with each of y (n, b), whole numbers: (a, b), float64.

    Examples
    --------
    >>> x = np.array([[0, 0], [1, 0]])
    >>> information_of_pairs(x, x).round(2)
    array([[0.69, 0.  ],
           [0.  , 0.  ]])
    """
    samples = len(x)
    found = np.zeros((x.shape[1], y.shape[1]))
    if found.size:
        whole_words = np.zeros((x.shape[1] + y.shape[1], -(-samples // 64) * 64), np.uint8)
        for codes, values in ((whole_words[: x.shape[1]], x), (whole_words[x.shape[1] :], y)):
            codes[:, :samples] = (values - values.min(axis=0)).T
        most = int(whole_words.max())
        fill_pairs(found, whole_words.reshape(-1), place(samples), place(most), n_log_n(samples))
    return found


def n_log_n(most: int) -> np.ndarray:
    """n log n for n = 0 .. most.

    Examples
    --------
    >>> n_log_n(2).round(2)
    array([0.  , 0.  , 1.39])
    """
    n = np.arange(most + 1, dtype=np.float64)
    return n * np.log(np.maximum(n, 1))


@kernel
def set_rows(rows, at, words, counts, codes, codes_at, samples, least, most):
    """Rows of bits of the codes least .. most that occur, one after another from rows[at] on; return how many there are.

    There are `words` words a row, and counts[k] bits set in the k-th. `codes` has 64 bytes a word.
    """
    last = ALL >> (words * WORD - samples)
    found = ZERO
    for code in range(least, most + ONE):
        row = at + found * words
        total = ZERO
        for w in range(ZERO, words):
            bits = equal_bits(codes, codes_at + w * WORD, np.uint8(code))
            bits &= last if w + ONE == words else ALL
            rows[row + w] = bits
            total += popcount(bits)
        if total > ZERO:
            counts[found] = total
            found += ONE
    return found


@kernel
def count_common(rows, one, other, words):
    """Number of bits that the row at `one` has in common with each of four rows from `other` on."""
    second, third, fourth = other + words, other + words + words, other + words + words + words
    a = b = c = d = ZERO
    for w in range(ZERO, words):
        bits = rows[one + w]
        a += popcount(bits & rows[other + w])
        b += popcount(bits & rows[second + w])
        c += popcount(bits & rows[third + w])
        d += popcount(bits & rows[fourth + w])
    return a, b, c, d


@kernel
def sum_of_table(counts, number, table):
    """Sum of n log n over the levels of one variable."""
    total = 0.0
    for k in range(ZERO, number):
        total += table[counts[k]]
    return total


@kernel
def pair_information(rows, words, one, ones, other, others, x_counts, y_counts, rest, table, samples, chance):
    """Mutual information of two variables, in nats. The last level of each is what the other levels leave over.

    `ones` rows of bits stand from rows[one] on, `others` from rows[other] on; up to three rows beyond are read, not used.
    `chance` times the information that is expected by chance, (bins_x - 1) (bins_y - 1) / (2 samples), is taken off.
    """
    both = 0.0
    for k in range(ZERO, others):
        rest[k] = y_counts[k]
    for i in range(ZERO, ones - ONE):
        left = x_counts[i]
        for k in range(ZERO, others - ONE, FOUR):
            common = count_common(rows, one + i * words, other + k * words, words)
            for m in range(ZERO, min(FOUR, others - ONE - k)):
                both += table[common[m]]
                left -= common[m]
                rest[k + m] -= common[m]
        both += table[left]
        rest[others - ONE] -= left
    both += sum_of_table(rest, others, table)
    apart = sum_of_table(x_counts, ones, table) + sum_of_table(y_counts, others, table)
    expected = chance * (ones - ONE) * (others - ONE) / 2
    information = (table[samples] + both - apart - expected) / samples
    return information if information > ROUNDING else 0.0


@kernel
def fill_pairs(found, codes, samples, most, table):
    """Fill `found` (a, b) for the codes 0 to `most` of a + b variables, whole words each."""
    ones, others = place(found.shape[0]), place(found.shape[1])
    words = (samples + WORD - ONE) // WORD
    rows = np.empty(((ones + others) * (most + ONE) + FOUR) * words, np.uint64)
    counts = np.empty((ones + others, most + ONE), np.uint64)
    number, starts = np.empty(ones + others, np.uint64), np.empty(ones + others, np.uint64)
    rest = np.empty(most + ONE + FOUR, np.uint64)
    at = ZERO
    for k in range(ZERO, ones + others):
        starts[k] = at
        number[k] = set_rows(rows, at, words, counts[k], codes, k * words * WORD, samples, ZERO, most)
        at += number[k] * words
    for i in range(ZERO, ones):
        for k in range(ones, ones + others):
            found[i, k - ones] = pair_information(
                rows, words, starts[i], number[i], starts[k], number[k], counts[i], counts[k], rest, table, samples, 0.0
            )
