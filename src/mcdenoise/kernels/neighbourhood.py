"""The samples around one pixel, drawn, tested and cut into bins: what `kernels.rpf` does first for every pixel.

Random numbers are a function of (seed, pass, pixel, number of the draw), not of a generator that goes on: the same
samples are drawn in whatever order, and by whatever thread, pixels are done.
"""

from __future__ import annotations

import numpy as np

from mcdenoise.kernels.jit import kernel
from mcdenoise.kernels.rows import ZERO, place

STEP, MIX_1, MIX_2 = place(0x9E3779B97F4A7C15), place(0xBF58476D1CE4E5B9), place(0x94D049BB133111EB)  # SplitMix64
BITS_24, BITS_16, MASK_24, MASK_16 = place(24), place(16), place(0xFFFFFF), place(0xFFFF)
BITS_48 = place(48)
CONSTANT = 1e-6  # a standard deviation below this share of the largest value is rounding of float32


@kernel
def random_bits(key, number):
    """64 random bits, the same for the same key and number (SplitMix64)."""
    z = key + number * STEP
    z = (z ^ (z >> place(30))) * MIX_1
    z = (z ^ (z >> place(27))) * MIX_2
    return z ^ (z >> place(31))


@kernel
def pixel_key(seed, turn, pixel):
    """The key of one pixel in one pass."""
    return random_bits(random_bits(place(seed), place(turn)), place(pixel))


@kernel
def pixel_statistics(records, at, columns, n_f, spp, mean, deviation):
    """Mean and standard deviation of each feature over the samples of the pixel whose first record is at `at`."""
    for k in range(ZERO, n_f):
        first, total, squares = np.float64(records[at + k]), 0.0, 0.0
        for s in range(ZERO, spp):
            d = np.float64(records[at + s * columns + k]) - first
            total += d
            squares += d * d
        mean[k] = first + total / spp
        deviation[k] = np.sqrt(max(squares / spp - (total / spp) ** 2, 0.0))


@kernel
def draw_samples(taken, y, x, height, width, spp, draws, key, table, first):
    """Enter the numbers of `draws` samples of other pixels of the box in `taken`, after those of the pixel itself."""
    half = (first.size - 2) // 2
    left, right = first[half - min(x, half)], first[half + min(width - 1 - x, half) + 1]
    top, bottom = first[half - min(y, half)], first[half + min(height - 1 - y, half) + 1]
    wide, high = place(right - left), place(bottom - top)
    count, number = spp, ZERO
    while count < spp + draws:
        bits = random_bits(key, number)
        number += place(1)
        dx = np.int64(table[left + np.int64(((bits & MASK_24) * wide) >> BITS_24)])
        dy = np.int64(table[top + np.int64((((bits >> BITS_24) & MASK_24) * high) >> BITS_24)])
        s = (bits >> BITS_48) * place(spp) >> BITS_16
        taken[count] = place((y + dy) * width + x + dx) * place(spp) + s
        count += dx != 0 or dy != 0
    return count


@kernel
def every_sample(taken, y, x, height, width, spp, half):
    """As `draw_samples`, with every sample of the box once, row by row."""
    count = spp
    for other_y in range(max(y - half, 0), min(y + half + 1, height)):
        for other_x in range(max(x - half, 0), min(x + half + 1, width)):
            if other_y != y or other_x != x:
                for s in range(spp):
                    taken[count] = place((other_y * width + other_x) * spp + s)
                    count += 1
    return count


@kernel
def keep_alike(taken, spp, count, records, columns, n_f, mean, reach):
    """Keep the samples whose features are all within `reach` of the mean, and those of the pixel; return how many."""
    kept = spp
    for n in range(spp, count):
        sample, far = taken[n], False
        for k in range(ZERO, n_f):
            far |= abs(np.float64(records[sample * columns + k]) - mean[k]) > reach[k]
        taken[kept] = sample
        kept += not far
    return kept


@kernel
def gather(values, room, taken, count, records, columns):
    """Enter the records of the samples in rows of one number each: values[k room + n]."""
    for n in range(ZERO, count):
        at = taken[n] * columns
        for k in range(ZERO, columns):
            values[k * room + n] = records[at + k]


@kernel
def cut(values, at, count, codes, codes_at, half):
    """Cut a row into bins of one standard deviation: the nearest whole number of deviations from the mean, +-half at most.

    Enters them, counted from -half, in `codes`; returns the least and the greatest of them, the mean, and one over the
    standard deviation. A row that is constant but for rounding has 0 there, and one bin.
    """
    first, total, squares, largest = np.float64(values[at]), 0.0, 0.0, np.float32(0)
    for n in range(ZERO, count):
        d = np.float64(values[at + n]) - first
        total += d
        squares += d * d
    for n in range(ZERO, count):
        largest = max(largest, abs(values[at + n]))
    mean = total / count
    deviation = np.sqrt(max(squares / count - mean * mean, 0.0))
    scale = 1 / deviation if deviation > CONSTANT * largest else 0.0
    least, most = np.int32(half), np.int32(half)
    limit, middle = np.float64(half), np.int32(half)
    for n in range(ZERO, count):
        z = (np.float64(values[at + n]) - first - mean) * scale
        code = np.int32(np.rint(min(max(z, -limit), limit))) + middle
        least, most = min(least, code), max(most, code)
        codes[codes_at + n] = np.uint8(code)
    return place(least), place(most), first + mean, scale
