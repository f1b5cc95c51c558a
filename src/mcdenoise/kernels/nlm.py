"""The fast twin of NL-means and of its joint form with features: how everything is laid out for `nlm_blocks`.

The image has its columns at `margin` in padded planes; the margins leave room for every offset and every box. A plane of
ones, padded with zeros, is averaged along with the colour: its sum is norm, and what lies outside adds nothing.
"""

from __future__ import annotations

import math

import numpy as np

from mcdenoise.kernels.nlm_blocks import Planes, Sizes, sum_blocks
from mcdenoise.kernels.planes import GROUP, SMALLEST, in_groups, in_units, padded_planes, place_planes, space_exponent

COLUMN_STEP = 32  # row loops run over whole vectors, four at a time


def nlm_sums(
    image: np.ndarray,
    guide: np.ndarray,
    variance: np.ndarray,
    search_radius: int,
    patch_radius: int,
    k: float,
    weight_radius: int = 0,
    cancellation: float = 1.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Sum of w c (h, w, c) and sum of w (h, w) in float32; the twin of `filters.nlm.nlm_sums`.

    Examples
    --------
    >>> image = np.array([[[0.0], [3.0]]])
    >>> total, norm = nlm_sums(image, image, np.ones((1, 2, 1)), 1, 0, k=2.0)
    >>> norm.round(4)
    array([[1.4169, 1.4169]], dtype=float32)
    """
    dials = search_radius, patch_radius, k, weight_radius, cancellation
    return _sums(image, guide, variance, [], math.inf, dials)


def joint_nlm_sums(
    image: np.ndarray,
    variance: np.ndarray,
    guides: list[tuple[np.ndarray, float, np.ndarray | None]],
    sigma_space: float,
    search_radius: int,
    patch_radius: int,
    k: float,
    weight_radius: int = 0,
    cancellation: float = 1.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Sum of w c (h, w, c) and sum of w (h, w) in float32; the twin of `filters.joint_nlm.joint_nlm_sums`.

    Examples
    --------
    >>> image, guide = np.array([[[0.0], [3.0]]]), (np.array([[[0.0], [1.0]]]), 1.0, None)
    >>> total, norm = joint_nlm_sums(image, np.ones((1, 2, 1)), [guide], np.inf, 1, 0, k=2.0)
    >>> norm.round(4)
    array([[1.2528, 1.2528]], dtype=float32)
    """
    dials = search_radius, patch_radius, k, weight_radius, cancellation
    return _sums(image, image, variance, guides, sigma_space, dials)


def _sums(
    image: np.ndarray, guide: np.ndarray, variance: np.ndarray, guides: list, sigma_space: float, dials: tuple
) -> tuple[np.ndarray, np.ndarray]:
    """Lay everything out in planes, and run the kernels."""
    search_radius, patch_radius, k, weight_radius, cancellation = dials
    height, width, channels = image.shape
    reach = [
        min(radius, side - 1) for radius in (search_radius, patch_radius, weight_radius) for side in (height, width)
    ]
    length = -(-width // COLUMN_STEP) * COLUMN_STEP
    margin = max(reach[1] + GROUP, reach[3], reach[5])  # taps go three at a time, and their number may be none of 3
    size = (height, length + 2 * margin, margin)
    inside = np.s_[..., margin : margin + width]

    colour = padded_planes(channels + 1, size)
    colour[:-1][inside] = np.moveaxis(image, -1, 0)
    colour[-1][inside] = 1
    compared, level, cancelled = _patch_planes(guide, variance, k, cancellation, size, width)
    plain, noisy, spread = place_planes(guides, size, width)
    exponent = space_exponent(sigma_space, *reach[:2])
    joint = len(plain) + len(noisy) > 0 or sigma_space < math.inf
    counts = channels + 1, len(compared), len(plain), len(noisy)
    sizes = Sizes(height, width, size[1], margin, length, *counts, *reach, int(joint))
    total = padded_planes(channels + 1, size)
    sum_blocks(
        total.ravel(),
        Planes(*(planes.ravel() for planes in (colour, compared, level, plain, noisy, spread))),
        exponent,
        *(column_shares(sizes.search_x, x, width, length).ravel() for x in (sizes.patch_x, sizes.weight_x)),
        np.float32(cancelled),
        sizes,
    )
    return np.moveaxis(total[:-1][inside], 0, -1), total[-1][inside]


def _patch_planes(
    guide: np.ndarray, variance: np.ndarray, k: float, cancellation: float, size: tuple[int, int, int], width: int
) -> tuple[np.ndarray, np.ndarray, float]:
    """Planes of the patches, in units that make the largest variance 1; the plane of the variances; what is taken off.

    With the mean variance v and its largest value v_max, level = v / v_max and guide / (k sqrt(c v_max)) give
    d^2 = (sum of squares - cancellation / k^2 (level_p + min)) / (level_p + level_q).
    """
    inside = np.s_[:, size[2] : size[2] + width]
    variance = variance.mean(axis=-1, dtype=np.float64)
    largest = float(variance.max())
    level = padded_planes(1, size, fill=1.0)
    level[0][inside] = np.maximum(variance / largest, SMALLEST) if largest > 0 else SMALLEST
    compared = padded_planes(in_groups(guide.shape[-1]), size)
    # `in_units` multiplies by sqrt(log2(e) / 2), which is meant for a bell; here it is taken out again.
    unit = k * math.sqrt(guide.shape[-1] * (largest or 1.0)) * math.sqrt(0.5 * math.log2(math.e))
    if unit < math.inf:
        for k_plane, plane in enumerate(in_units(guide, max(unit, 1e-200))):
            compared[k_plane][inside] = plane
    return compared, level, min(cancellation / k / k, 1e30)


def column_shares(search: int, reach: int, width: int, length: int) -> np.ndarray:
    """For each dx = -search .. search and column: 1 / number of columns of a box that lie inside with and without dx.

    Examples
    --------
    >>> (1 / column_shares(1, 1, 3, 3)).round().tolist()
    [[1.0, 2.0, 2.0], [2.0, 3.0, 2.0], [2.0, 2.0, 1.0]]
    """
    column = np.arange(width)
    shares = np.zeros((2 * search + 1, length), np.float32)
    for share, dx in zip(shares, range(-search, search + 1), strict=True):
        first, last = max(0, -dx), min(width, width - dx) - 1
        count = np.minimum(column + reach, last) - np.maximum(column - reach, first) + 1
        share[:width] = 1 / np.maximum(count, 1)
    return shares
