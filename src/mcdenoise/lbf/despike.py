"""Chapter 09: spikes. A pixel far from all of its neighbours is replaced by their median."""

from __future__ import annotations

import numpy as np

from mcdenoise.filters.window import check_range, with_channels
from mcdenoise.samples.gate import check_bandwidth, check_count

ROUNDING = 1e-13  # share of the squares that float64 may lose: a deviation below it is no deviation


def despike(image: np.ndarray, *, radius: int, deviations: float, together: bool = False) -> np.ndarray:
    """Replace what stands out of its window by the median of 3 x 3 pixels, channel by channel.

    x_i is a spike where |x_i - m_i| > deviations s_i, with m_i and s_i (divisor n - 1) the mean and standard deviation of
    the n pixels of the window around i without i itself: a spike must not hide by widening its own yardstick.

    Parameters
    ----------
    image : (h, w) or (h, w, c), any unit.
    radius : the window has (2 radius + 1)^2 - 1 pixels, fewer at borders; >= 1.
    deviations : how many standard deviations are too many, > 0; infinity replaces nothing.
    together : where one channel is a spike, replace all channels (each by its own median), as the authors' code does.

    Returns
    -------
    Array of the shape and dtype of `image`, a new one.

    Raises
    ------
    ValueError
        For an image that is not finite, not (h, w) or (h, w, c), or beyond 1e30; for a radius that is no whole number
        >= 1; for deviations that are not above 0.

    Notes
    -----
    Bias: **energy is lost.** Rare bright samples carry part of the true mean, and here they are taken out: of fireflies
    of height a on a share p of the pixels, far apart, the mean loses nearly all of p a. With radius 1 and 2 deviations
    white log-normal noise (sigma 1) loses 28 % of its mean. Symmetric noise keeps its mean, because dark outliers count
    like bright ones; a tenth of its pixels are replaced.

    As in the authors' code both sides count, and the median is that of the whole square, its centre too. Ours: where the
    square is clipped it has fewer pixels (theirs adds zeros), and the median of an even number is the mean of the middle
    two; where the window has no deviation beyond rounding nothing is replaced, so a spike on a perfectly flat ground
    stays, and so does every flat image, bit for bit.

    References
    ----------
    Kalantari, Bako and Sen 2015, https://doi.org/10.1145/2766977, authors' code: radius 27 and 10 deviations for the
    variance of colour, radius 1 and 2 deviations for the filtered image.

    Examples
    --------
    >>> image = np.array([[1.0, 2.0, 1.0], [2.0, 90.0, 1.0], [1.0, 2.0, 2.0]])
    >>> despike(image, radius=1, deviations=2)[1]
    array([2., 2., 1.])
    """
    image = check_range(image)
    radius, deviations = check_count(radius, "radius"), check_bandwidth(deviations, "deviations")
    cleaned = image.copy()
    planes, cleaned_planes = np.moveaxis(with_channels(image), -1, 0), np.moveaxis(with_channels(cleaned), -1, 0)
    spikes = np.stack([find_spikes(plane, radius, deviations) for plane in planes])
    if together:
        spikes[:] = spikes.any(axis=0)
    for plane, cleaned_plane, is_spike in zip(planes, cleaned_planes, spikes, strict=True):
        cleaned_plane[is_spike] = median_3x3(plane, *np.nonzero(is_spike))
    return cleaned


def find_spikes(plane: np.ndarray, radius: int, deviations: float) -> np.ndarray:
    """Where a plane stands out of its window; parameters as for `despike`, (h, w) in, (h, w) bool out.

    Examples
    --------
    >>> find_spikes(np.array([[1.0, 2.0, 90.0, 2.0, 1.0]]), radius=2, deviations=3)
    array([[False, False,  True, False, False]])
    """
    centred = plane - np.median(plane).astype(np.float64)  # a difference of squares loses fewer digits near 0
    count = np.maximum(window_count(*plane.shape, radius) - 1, 1)
    total, squares = sums_around(centred, radius), sums_around(centred**2, radius)
    mean = total / count
    spread = squares - total * mean  # (n - 1) s^2
    with np.errstate(invalid="ignore"):  # infinitely many deviations of nothing
        limit = deviations * np.sqrt(np.maximum(spread, 0) / np.maximum(count - 1, 1))
    return (spread > ROUNDING * squares) & (np.abs(centred - mean) > limit)


def median_3x3(plane: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Median of the 3 x 3 square around each named pixel, clipped at the borders of the plane (h, w).

    Examples
    --------
    >>> median_3x3(np.array([[1.0, 2.0, 9.0]]), np.array([0, 0]), np.array([1, 2]))
    array([2. , 5.5])
    """
    padded = np.pad(plane, 1, constant_values=np.inf)  # sorts behind all pixels of the image
    around = np.stack([padded[rows + dy, columns + dx] for dy in range(3) for dx in range(3)], axis=-1)
    around.sort(axis=-1)
    count = np.isfinite(around).sum(axis=-1)
    each = np.arange(rows.size)
    return 0.5 * around[each, (count - 1) // 2] + 0.5 * around[each, count // 2]


def sums_around(plane: np.ndarray, radius: int) -> np.ndarray:
    """Sum over the square window around each pixel without the pixel itself, clipped at the borders, in float64.

    Each sum adds nothing but its own window: no running sum, which would keep the rounding of every bright pixel that
    it has passed, and no subtraction of the centre, which would lose its small neighbours.

    Parameters
    ----------
    plane : (h, w). radius : pixels, >= 1; may exceed the image.

    Examples
    --------
    >>> sums_around(np.array([[1.0, 2.0, 4.0]]), radius=1)
    array([[2., 5., 2.]])
    """
    reach_y, reach_x = (min(radius, max(size - 1, 1)) for size in plane.shape)
    padded = np.pad(plane.astype(np.float64), ((reach_y, reach_y), (0, 0)))
    above_or_below = run_sums(padded, reach_y)
    beside = np.pad(run_sums(padded, 2 * reach_y + 1), ((0, 0), (reach_x, reach_x)))
    left_or_right = run_sums(beside.T, reach_x).T
    height, width = plane.shape
    total = above_or_below[:height] + above_or_below[reach_y + 1 :]
    total += left_or_right[:, :width]
    total += left_or_right[:, reach_x + 1 :]
    return total


def window_count(height: int, width: int, radius: int) -> np.ndarray:
    """How many pixels the window of each pixel has, itself included, clipped at the borders: (height, width).

    Examples
    --------
    >>> window_count(1, 4, radius=1)
    array([[2, 3, 3, 2]])
    """
    along = [
        np.minimum(np.arange(n) + radius, n - 1) - np.maximum(np.arange(n) - radius, 0) + 1 for n in (height, width)
    ]
    return np.outer(*along)


def run_sums(rows: np.ndarray, length: int) -> np.ndarray:
    """Sums of `length` consecutive rows, from sums of 1, 2, 4, 8, ... rows.

    Parameters
    ----------
    rows : (n, ...). length : 1 .. n.

    Returns
    -------
    (n - length + 1, ...)

    Examples
    --------
    >>> run_sums(np.array([1.0, 2.0, 4.0, 8.0]), 3)
    array([ 7., 14.])
    """
    count = len(rows) - length + 1
    total, start, step = None, 0, 1
    while True:
        if length & step:
            part = rows[start : start + count]
            total = part if total is None else total + part
            start += step
        if 2 * step > length:
            return total
        rows = rows[:-step] + rows[step:]
        step *= 2
