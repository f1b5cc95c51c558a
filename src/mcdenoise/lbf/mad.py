"""Chapter 09: how noisy an image looks, without asking its samples: the median of its finest diagonal differences."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

NORMAL_MEDIAN = 0.6745  # median of |x| for a normal x of deviation 1
SORT_4 = ((0, 1), (2, 3), (0, 2), (1, 3), (1, 2))
MERGE_4_4 = ((0, 4), (1, 5), (2, 6), (3, 7), (2, 4), (3, 5), (1, 2), (3, 4), (5, 6))


def mad(image: np.ndarray) -> np.ndarray:
    """Standard deviation of the noise, from the median of Haar coefficients: flat ground and straight edges leave it small.

    The 8 x 8 block around a pixel (4 pixels to the left and up, 3 to the right and down) holds 16 squares of 2 x 2 pixels
    [[a, b], [c, d]] with coefficients abs(b + c - a - d) / 2; their median / 0.6745 is the deviation of normal noise. The
    pixels of each cell of 2 x 2 share their mean, then each pixel takes the largest of its 3 x 3 neighbours, which makes
    it larger than the deviation: by 11 % on average for white noise. Beyond its edge the image is mirrored about the
    outermost pixels. With one row or one column there is nothing to compare, and the result is 0.

    Parameters
    ----------
    image : (h, w, c), any unit.

    Returns
    -------
    Array of the same shape, float32, same unit.

    References
    ----------
    Donoho and Johnstone, Biometrika 81(3), 1994, https://doi.org/10.1093/biomet/81.3.425 (the median); block, cells and
    mirroring as in the authors' code of LBF, which leaves the last row and column of odd sizes outside of cells; here
    they are cells of one pixel's width.

    Examples
    --------
    >>> board = np.indices((8, 8)).sum(axis=0)[..., np.newaxis] % 2  # 0 and 1 by turns: each coefficient is 1
    >>> mad(board)[4, 4].round(4)
    array([1.4826], dtype=float32)
    """
    return by_plane(_mad_plane, image)


def by_plane(function: Callable[[np.ndarray], np.ndarray], image: np.ndarray) -> np.ndarray:
    """Apply `function` to each channel of (h, w, c), as a float64 plane that fits the cache.

    Parameters
    ----------
    function : (h, w) in, (h, w) out. image : (h, w, c).

    Returns
    -------
    Array of the shape of `image`, float32.

    Examples
    --------
    >>> by_plane(np.cumsum, np.ones((2, 1, 3)).T.reshape(1, 3, 2))[..., 0]
    array([[1., 2., 3.]], dtype=float32)
    """
    result = np.empty(image.shape, np.float32)
    for channel in range(image.shape[-1]):
        result[..., channel] = function(image[..., channel].astype(np.float64, order="C"))
    return result


def _mad_plane(plane: np.ndarray) -> np.ndarray:
    """Coefficients, their median around each pixel, the mean of each cell, the largest of neighbours."""
    height, width = plane.shape
    padded = np.pad(plane, (4, 3), mode="reflect").astype(np.float32)
    down = padded[1:] - padded[:-1]
    noise = _median_4x4(np.abs(down[:, 1:] - down[:, :-1]) / 2) / NORMAL_MEDIAN
    cells = _mean_of_pairs(_mean_of_pairs(noise).T).T
    return _largest_of_neighbours(_largest_of_neighbours(cells, height).T, width).T


def _median_4x4(values: np.ndarray) -> np.ndarray:
    """Median of every second of 7 x 7 values, in each direction: (h + 6, w + 6) in, (h, w) out.

    Four rows are sorted once, columns of them merged in pairs, and of two sorted halves of eight the k-th smallest of one
    meets the k-th largest of the other: the smaller ones are the lower eight.
    """
    height, width = (size - 6 for size in values.shape)
    column = _exchange([values[2 * k : 2 * k + height] for k in range(4)], SORT_4)
    pair = _exchange([rows[:, :-2] for rows in column] + [rows[:, 2:] for rows in column], MERGE_4_4)
    meet = [(pair[k][:, :width], pair[7 - k][:, 4:]) for k in range(8)]
    lower, upper = np.minimum(*meet[0]), np.maximum(*meet[0])
    for one, other in meet[1:]:
        np.maximum(lower, np.minimum(one, other), out=lower)
        np.minimum(upper, np.maximum(one, other), out=upper)
    return (lower + upper) / 2


def _exchange(values: list[np.ndarray], pairs: Sequence[tuple[int, int]]) -> list[np.ndarray]:
    """Put the smaller of each pair of places first, one pair after another."""
    for a, b in pairs:
        values[a], values[b] = np.minimum(values[a], values[b]), np.maximum(values[a], values[b])
    return values


def _mean_of_pairs(rows: np.ndarray) -> np.ndarray:
    """Mean of rows 0 and 1, of 2 and 3, ...; a last row without a partner stays."""
    mean = rows[::2].copy()
    mean[: len(rows) // 2] += rows[1::2]
    mean[: len(rows) // 2] /= 2
    return mean


def _largest_of_neighbours(cells: np.ndarray, height: int) -> np.ndarray:
    """Rows of cells, two pixels each, in; the largest of each row of pixels and its two neighbours out, `height` rows."""
    largest = np.empty((2 * len(cells), cells.shape[1]), cells.dtype)
    largest[::2], largest[1::2] = cells, cells
    np.maximum(cells[1:], cells[:-1], out=largest[2::2])
    np.maximum(cells[1:], cells[:-1], out=largest[1:-1:2])
    return largest[:height]
