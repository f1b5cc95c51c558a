"""The fast twin of random parameter filtering: one pass over some rows of the image, all pixels in parallel.

Each pixel reads the samples of its neighbourhood into rows of one number each, cuts them into bins, counts them into mutual
information, and blends. Samples are records of features, radiance, screen position, random parameters, in this order.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import prange

from mcdenoise.kernels.dependency import n_log_n, pair_information, set_rows
from mcdenoise.kernels.jit import kernel
from mcdenoise.kernels.neighbourhood import (
    cut,
    draw_samples,
    every_sample,
    gather,
    keep_alike,
    pixel_key,
    pixel_statistics,
)
from mcdenoise.kernels.rows import ZERO, exp2, place

LOG2_E = 1.4426950408889634
ONE, FOUR, WORD = place(1), place(4), place(64)
ROWS_AT_ONCE = 16  # between two reports of progress
LARGEST_SCALE = 1e30  # one over a denormal deviation leaves float32: what varies by less counts as constant


class Sizes(NamedTuple):
    """Whole numbers of one pass."""

    height: int
    width: int
    spp: int
    n_f: int
    n_r: int
    draws: int  # beyond the pixel's own samples; -1: every sample of the box
    half: int  # of the box
    levels: int  # of a histogram, odd
    spikes: int  # 0 none, 1 mean, 2 joint, 3 clamp
    seed: int
    turn: int


class Dials(NamedTuple):
    """Numbers of one pass; alpha and beta below 0 are not fixed."""

    sigma_space: float  # for every sample of the box
    precision: float  # 1 / (2 sigma^2)
    alpha_gain: float
    beta_gain: float
    alpha: float
    beta: float
    one_share: bool  # alpha from W_c^r, for all channels
    ratio_of_sums: bool  # W_c^r, else the mean over channels
    by_feature_share: bool  # beta times W_c^{f,k}
    spike_limit: float  # standard deviations
    noise_gain: float  # how much noise within pixels widens a bandwidth
    chance: float  # how many times the information expected by chance is taken off
    tolerance: float  # of the clustering; infinite: there is none


def map_columns(n_f: int, n_r: int) -> dict[str, slice]:
    """What the columns of `maps` hold.

    Examples
    --------
    >>> map_columns(9, 4)["share_c_f"]
    slice(28, 37, None)
    """
    widths = {
        "alpha": 3, "beta": n_f, "share_c_r": 3, "share_c_r_all": 1, "share_c_r_each": 3 * n_r,
        "share_c_f": n_f, "share_f_r": n_f, "accepted": 1,
    }  # fmt: skip
    ends = np.cumsum(list(widths.values())).tolist()
    return {name: slice(end - width, end) for (name, width), end in zip(widths.items(), ends, strict=True)}


def filter_image(
    records: np.ndarray,
    radiance: np.ndarray,
    noise: np.ndarray,
    limits: np.ndarray,
    gains: np.ndarray,
    table: np.ndarray,
    first: np.ndarray,
    sizes: Sizes,
    dials: Dials,
    done: Callable[[int], object],
    with_maps: bool,
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Do one pass over the image; the twin of `rpf.passes._numpy_pass`.

    Parameters
    ----------
    records : flat, a sample after the other. radiance : (h, w, spp, 3), to be blended. noise : (h, w, n_f + 3).
    limits, gains : (n_f,). table, first : of the draws. done : told the number of rows that are finished.

    Returns
    -------
    (h, w, spp, 3), and the maps: name -> (h, w, columns); {} unless they are asked for
    """
    filtered = np.empty_like(radiance)
    pixels = sizes.height * sizes.width
    columns = map_columns(sizes.n_f, sizes.n_r) if with_maps else {}
    maps = np.zeros((pixels if with_maps else 0, max((c.stop for c in columns.values()), default=0)), np.float32)
    most = sizes.spp + sizes.draws if sizes.draws >= 0 else (2 * sizes.half + 1) ** 2 * sizes.spp
    logs = n_log_n(most)
    inputs = records, radiance.reshape(-1), filtered.reshape(-1), maps, limits, gains
    inputs += noise.reshape(pixels, -1), table, first, logs, sizes, dials
    for row in range(0, sizes.height, ROWS_AT_ONCE):
        last = min(row + ROWS_AT_ONCE, sizes.height)
        filter_rows(row, last, *inputs)
        done(last - row)
    return filtered, {name: maps[:, c].reshape(sizes.height, sizes.width, -1) for name, c in columns.items()}


@kernel(parallel=True)
def filter_rows(
    first_row, last_row, records, radiance, filtered, maps, limits, gains, noise, table, first, logs, sizes, dials
):
    """Filter the samples of rows first_row .. last_row - 1: `radiance` in, `filtered` out, (h w spp 3) flat."""
    for y in prange(first_row, last_row):
        filter_row(y, records, radiance, filtered, maps, limits, gains, noise, table, first, logs, sizes, dials)


@kernel
def filter_row(y, records, radiance, filtered, maps, limits, gains, noise, table, first, logs, sizes, dials):
    """Filter the samples of one row of pixels."""
    n_f, n_r, spp, width = place(sizes.n_f), place(sizes.n_r), place(sizes.spp), sizes.width
    columns = n_f + place(5) + n_r
    box = (2 * sizes.half + 1) ** 2 * sizes.spp
    most = sizes.spp + sizes.draws if sizes.draws >= 0 else box
    room = place((most + 63) // 64 * 64)  # whole words of bits
    values = np.empty(columns * room, np.float32)
    codes = np.empty(columns * room, np.uint8)
    taken = np.empty(most + 1, np.uint64)
    rows = np.empty((columns * place(sizes.levels) + FOUR) * (room // WORD), np.uint64)
    counts = np.empty((columns, place(sizes.levels)), np.uint64)
    number, starts = np.empty(columns, np.uint64), np.empty(columns, np.uint64)
    rest = np.empty(sizes.levels + 4, np.uint64)
    mean, reach = np.empty(n_f), np.empty(n_f)
    means, scales = np.empty(columns), np.empty(columns)
    dependency = np.empty((n_f + place(3), n_f + n_r + place(2)))
    weights, shares = np.empty(n_f + place(3)), np.zeros(n_f + place(3))
    guide = np.empty((columns + FOUR) * room, np.float32)
    weight = np.empty(room, np.float32)
    colour = np.empty(place(3) * room, np.float32)
    blended = np.empty((sizes.spp, 3))
    find_levels = dials.alpha < 0 or dials.beta < 0 or maps.size > 0
    for x in range(width):
        pixel = place(y * width + x)
        own = pixel * spp
        pixel_statistics(records, own * columns, columns, n_f, spp, mean, reach)
        for k in range(n_f):
            far = limits[k] * reach[k]
            reach[k] = far if reach[k] > dials.tolerance else max(far, dials.tolerance)
        samples = choose(taken, y, x, sizes, dials, table, first, records, columns, mean, reach)
        count = place(samples)
        gather(values, room, taken, count, records, columns)
        words = (count + WORD - ONE) // WORD
        at = ZERO
        for k in range(ZERO, columns if find_levels else n_f + place(3)):
            least, greatest, means[k], scales[k] = cut(values, k * room, count, codes, k * room, sizes.levels // 2)
            if find_levels:
                starts[k] = at
                number[k] = set_rows(rows, at, words, counts[k], codes, k * room, count, least, greatest)
                at += number[k] * words
        if find_levels:
            measure(dependency, n_f, n_r, rows, words, starts, number, counts, rest, logs, count, dials.chance)
        share = set_weights(weights, shares, dependency, n_f, n_r, gains, dials)
        active = set_guides(
            guide, room, values, count, n_f, weights, shares, share, means, scales, noise[pixel], sizes, dials
        )
        for k in range(ZERO, count):
            for c in range(ZERO, place(3)):
                colour[c * room + k] = radiance[taken[k] * place(3) + c]
        for s in range(ZERO, spp):
            blend(blended[s], guide, active, room, s, count, weight, colour)
        calm(blended, sizes.spikes, dials.spike_limit)
        for s in range(sizes.spp):
            for c in range(3):
                filtered[(own + s) * place(3) + c] = blended[s, c]
        if maps.size:
            enter(maps, pixel, weights, shares, dependency, n_f, n_r, share, samples)


@kernel
def choose(taken, y, x, sizes, dials, table, first, records, columns, mean, reach):
    """Enter the numbers of the samples of one neighbourhood in `taken`, those of the pixel first; return how many."""
    spp, pixel = sizes.spp, y * sizes.width + x
    for s in range(spp):
        taken[s] = place(pixel * spp + s)
    if sizes.draws >= 0:
        key = pixel_key(sizes.seed, sizes.turn, pixel)
        samples = draw_samples(taken, y, x, sizes.height, sizes.width, spp, sizes.draws, key, table, first)
    else:
        samples = every_sample(taken, y, x, sizes.height, sizes.width, spp, sizes.half)
    if dials.tolerance < np.inf:
        samples = keep_alike(taken, spp, samples, records, columns, place(sizes.n_f), mean, reach)
    return samples


@kernel
def set_guides(guide, room, values, count, n_f, weights, shares, share, means, scales, noise, sizes, dials):
    """Enter the rows that count, scaled so that a weight is 2^-distance; return how many, a multiple of four."""
    certain = (1 - share) ** 2 * LOG2_E
    active = ZERO
    for k in range(ZERO, n_f + place(3)):
        if weights[k] > 0 and scales[k] > 0:
            widened = 1 / dials.precision + 2 * dials.noise_gain * shares[k] * noise[k] * scales[k] ** 2
            scale = scales[k] * np.sqrt(weights[k] * certain / widened)
            active = add_guide(guide, active, room, values, k * room, count, means[k], scale)
    if sizes.draws < 0:  # distance on the screen, in units of sigma_p
        scale = np.sqrt(LOG2_E / 2) / dials.sigma_space
        for k in range(n_f + place(3), n_f + place(5)):
            active = add_guide(guide, active, room, values, k * room, count, np.float64(values[k * room]), scale)
    while active % FOUR != ZERO:
        active = add_guide(guide, active, room, values, ZERO, count, 0.0, 0.0)
    return active


@kernel
def add_guide(guide, active, room, values, at, count, centre, scale):
    """Enter a row, less `centre` and times `scale`, as the next guide; return how many guides there are."""
    centre, scale = np.float32(centre), np.float32(min(scale, LARGEST_SCALE))
    for n in range(ZERO, count):
        guide[active * room + n] = (values[at + n] - centre) * scale
    return active + ONE


@kernel
def measure(dependency, n_f, n_r, rows, words, starts, number, counts, rest, logs, samples, chance):
    """Mutual information of features and radiance with position and random parameters, and of radiance with features.

    dependency[i, j]: i counts features, then channels; j counts features, then position, then random parameters.
    """
    for i in range(ZERO, n_f + place(3)):
        for j in range(n_f if i < n_f else ZERO, n_f + place(2) + n_r):
            k = j if j < n_f else j + place(3)
            dependency[i, j] = pair_information(
                rows,
                words,
                starts[i],
                number[i],
                starts[k],
                number[k],
                counts[i],
                counts[k],
                rest,
                logs,
                samples,
                chance,
            )


@kernel
def set_weights(weights, shares, dependency, n_f, n_r, gains, dials):
    """Set beta of each feature, then alpha of each channel, and their shares W^r; return W_c^r."""
    if dials.alpha >= 0 and dials.beta >= 0:
        weights[:n_f], weights[n_f:] = dials.beta, dials.alpha
        return 0.0
    position, random, end = n_f, n_f + place(2), n_f + place(2) + n_r
    total_r = total_p = total_f = mean_share = 0.0
    for k in range(ZERO, n_f + place(3)):
        d_r, d_p = span(dependency, k, random, end), span(dependency, k, position, random)
        shares[k] = share_of(d_r, d_r + d_p)
        if k >= n_f:
            total_r, total_p, total_f = total_r + d_r, total_p + d_p, total_f + span(dependency, k, ZERO, n_f)
            mean_share += shares[k] / 3
    share = share_of(total_r, total_r + total_p) if dials.ratio_of_sums else mean_share
    for k in range(n_f, n_f + place(3)):
        alpha = max(1 - dials.alpha_gain * (share if dials.one_share else shares[k]), 0.0)
        weights[k] = alpha if dials.alpha < 0 else dials.alpha
    for k in range(ZERO, n_f):
        beta = gains[k] * max(1 - dials.beta_gain * shares[k], 0.0)
        if dials.by_feature_share:
            beta *= share_of(column(dependency, k, n_f), total_r + total_p + total_f)
        weights[k] = beta if dials.beta < 0 else dials.beta
    return share


@kernel
def column(dependency, k, n_f):
    """D_c^{f,k}: sum over the channels."""
    return dependency[n_f, k] + dependency[n_f + ONE, k] + dependency[n_f + ONE + ONE, k]


@kernel
def span(dependency, i, first, end):
    """Sum of dependency[i, first .. end - 1]."""
    total = 0.0
    for j in range(first, end):
        total += dependency[i, j]
    return total


@kernel
def share_of(part, whole):
    """part / whole, and 0 where nothing depends on anything (0 / 0)."""
    return part / whole if whole > 0 else 0.0


@kernel
def blend(result, guide, active, room, centre, count, weight, colour):
    """Weighted mean of the colours of all samples, with the weights of the sample `centre`."""
    for n in range(ZERO, count):
        weight[n] = np.float32(0)
    for k in range(ZERO, active, FOUR):
        add_four(weight, guide, k * room, room, centre, count)
    norm, red, green, blue = sums(weight, colour, room, count)
    result[0], result[1], result[2] = red / norm, green / norm, blue / norm


@kernel
def add_four(weight, guide, at, room, centre, count):
    """weight[n] += squared distance of four guides between the samples `centre` and n."""
    second, third, fourth = at + room, at + room + room, at + room + room + room
    a, b, c, d = guide[at + centre], guide[second + centre], guide[third + centre], guide[fourth + centre]
    for n in range(ZERO, count):
        e, f, g, h = guide[at + n] - a, guide[second + n] - b, guide[third + n] - c, guide[fourth + n] - d
        weight[n] += e * e + f * f + g * g + h * h


@kernel
def sums(weight, colour, room, count):
    """Sum of w = 2^-distance, and of w times each of three colours."""
    norm, red, green, blue = np.float32(0), np.float32(0), np.float32(0), np.float32(0)
    for n in range(ZERO, count):
        w = exp2(-weight[n])
        norm += w
        red += w * colour[n]
        green += w * colour[room + n]
        blue += w * colour[room + room + n]
    return norm, red, green, blue


@kernel
def calm(blended, spikes, limit):
    """Take spikes out of the blended samples of one pixel, in place (see `rpf.spikes`)."""
    spp = blended.shape[0]
    if spikes == 0:
        return
    mean, deviation = np.zeros(3), np.zeros(3)
    for c in range(3):
        for s in range(spp):
            mean[c] += blended[s, c] / spp
        for s in range(spp):
            deviation[c] += (blended[s, c] - mean[c]) ** 2 / spp
        deviation[c] = np.sqrt(deviation[c])
    if spikes == 1:
        for s in range(spp):
            for c in range(3):
                if abs(blended[s, c] - mean[c]) > limit * deviation[c]:
                    blended[s, c] = mean[c]
    elif spikes == 2:
        lost = np.zeros(3)
        for s in range(spp):
            far = True
            for c in range(3):
                far = far and abs(blended[s, c] - mean[c]) > limit * deviation[c]
            if far:
                for c in range(3):
                    lost[c] += blended[s, c] - mean[c]
                    blended[s, c] = mean[c]
        for s in range(spp):
            for c in range(3):
                blended[s, c] += lost[c] / spp
    else:
        for s in range(spp):
            for c in range(3):
                blended[s, c] = min(blended[s, c], mean[c] + limit * deviation[c])


@kernel
def enter(maps, pixel, weights, shares, dependency, n_f, n_r, share, samples):
    """Enter what was found at one pixel into `maps`, columns as in `map_columns`."""
    to, random, end = maps[pixel], n_f + place(2), n_f + place(2) + n_r
    each = place(7) + n_f
    by_feature = each + place(3) * n_r
    whole = 0.0
    for c in range(ZERO, place(3)):
        to[c], to[place(3) + n_f + c] = weights[n_f + c], shares[n_f + c]
        whole += span(dependency, n_f + c, ZERO, end)
        for k in range(ZERO, n_r):
            to[each + c * n_r + k] = share_of(dependency[n_f + c, random + k], span(dependency, n_f + c, n_f, end))
    to[place(6) + n_f] = share
    for k in range(ZERO, n_f):
        to[place(3) + k], to[by_feature + n_f + k] = weights[k], shares[k]
        to[by_feature + k] = share_of(column(dependency, k, n_f), whole)
    to[by_feature + n_f + n_f] = samples
