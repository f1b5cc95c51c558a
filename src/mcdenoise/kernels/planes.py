"""How numbers stand in memory for the windowed kernels: one plane a channel, rows padded left and right.

A guide is anything that likeness is judged by: radiance, or a feature. Each of its channels becomes one plane,
multiplied by sqrt(log2(e) / 2) / unit, so that with the unit sigma a weight is simply 2^(space - sum of squared
differences over all planes). A guide with a variance has a second plane a channel, (sigma^2 / 2 + variance) / unit^2:
the sum of two of them divides the squared difference.
"""

from __future__ import annotations

import math

import numpy as np

FAR = 1e18
KNEE = 1e10
SMALLEST = 1e-30  # of a plane that divides
GROUP = 3  # planes are taken three at a time


def in_groups(planes: int) -> int:
    """Round a number of planes up to whole groups.

    Examples
    --------
    >>> in_groups(4)
    6
    """
    return -(-planes // GROUP) * GROUP


def padded_planes(count: int, size: tuple[int, int, int], fill: float = 0.0) -> np.ndarray:
    """Make `count` float32 planes of (height, stride), all `fill`; `size` is (height, stride, margin).

    Examples
    --------
    >>> padded_planes(2, (3, 8, 1)).shape
    (2, 3, 8)
    """
    return np.full((count, *size[:2]), fill, np.float32)


def place_planes(guides: list, size: tuple[int, int, int], width: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lay out guides (values, sigma, variance or None): plain planes, noisy planes, and what divides the noisy ones.

    A bandwidth of infinity drops a guide. All three arrays hold whole groups of planes; planes that only fill a group
    never differ, so they add nothing.

    Parameters
    ----------
    guides : each (h, w, c), > 0, (h, w, c) or None.
    size : (height, stride, margin) of the padded planes; the image begins at column `margin`.
    width : of the image.

    Returns
    -------
    plain, noisy, spread : (p, h, stride), (q, h, stride), (q, h, stride), float32.

    Examples
    --------
    >>> values = np.ones((2, 3, 1))
    >>> plain, noisy, spread = place_planes([(values, 0.5, None), (values, np.inf, None)], (2, 8, 1), 3)
    >>> len(plain), len(noisy), len(spread)
    (3, 0, 0)
    """
    active = [guide for guide in guides if guide[1] < math.inf]
    plain_guides = [(values, sigma) for values, sigma, variance in active if variance is None]
    noisy_guides = [guide for guide in active if guide[2] is not None]
    inside = np.s_[:, size[2] : size[2] + width]
    plain = padded_planes(in_groups(sum(values.shape[-1] for values, _ in plain_guides)), size)
    noisy = padded_planes(in_groups(sum(guide[0].shape[-1] for guide in noisy_guides)), size)
    spread = padded_planes(len(noisy), size, fill=1.0)
    k = 0
    for values, sigma in plain_guides:
        for plane in in_units(values, sigma):
            plain[k][inside] = plane
            k += 1
    k = 0
    for values, sigma, variance in noisy_guides:
        unit = math.hypot(sigma, math.sqrt(float(variance.max())))
        share = (sigma / unit) ** 2 / 2
        for channel, plane in enumerate(in_units(values, unit)):
            noisy[k][inside] = plane
            spread[k][inside] = np.maximum(share + variance[..., channel] / unit / unit, SMALLEST)
            k += 1
    return plain, noisy, spread


def in_units(values: np.ndarray, unit: float) -> np.ndarray:
    """Return the channels (c, h, w) of `values` (h, w, c), multiplied by sqrt(log2(e) / 2) / unit.

    They are rounded to float32 after that, so a difference is off by up to 2^-24 of the larger value.
    Two float32 numbers that differ are at least 600 units apart if one is beyond KNEE units, so their weight is 0.
    Beyond KNEE a logarithm takes over: it keeps such numbers apart, and no square of a difference can overflow.

    Examples
    --------
    >>> in_units(np.array([[[2.0], [4.0]]]), 0.5).round(2).tolist()
    [[[3.4, 6.79]]]
    """
    planes, scale = np.moveaxis(values, -1, 0), min(math.sqrt(0.5 * math.log2(math.e)) / unit, 1e200)
    if max(float(np.abs(values).max()), 1e-20) * scale <= KNEE:
        return planes * scale
    planes = planes * np.float64(scale)
    beyond = np.abs(planes) > KNEE
    planes[beyond] = np.sign(planes[beyond]) * KNEE * (1 + np.log(np.abs(planes[beyond]) / KNEE))
    return planes


def space_exponent(sigma_space: float, reach_y: int, reach_x: int) -> np.ndarray:
    """log2 of the spatial weight for dy = 0 .. reach_y (rows) and dx = -reach_x .. reach_x (columns).

    One column more holds -FAR, a weight of 0: taps are taken two at a time, and their number may be odd.

    Examples
    --------
    >>> space_exponent(1.0, 0, 1)[:, :3]
    array([[-0.7213475, -0.       , -0.7213475]], dtype=float32)
    """
    dy, dx = np.ogrid[: reach_y + 1, -reach_x : reach_x + 1]
    with np.errstate(over="ignore", divide="ignore"):
        square = (dy / sigma_space) ** 2 + (dx / sigma_space) ** 2
    exponent = -np.minimum(square * (0.5 * math.log2(math.e)), FAR)
    return np.append(exponent, np.full((reach_y + 1, 1), -FAR), axis=1).astype(np.float32)
