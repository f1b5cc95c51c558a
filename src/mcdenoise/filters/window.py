"""What every windowed filter shares: the offsets of the window, the bell curve, and the one division at the end.

Conventions of all filters here. The window of pixel i is the square of (2 radius + 1)^2 pixels around it. At the
borders it is clipped: only pixels inside the image count, nothing is padded or mirrored, and dividing by the sum of the
weights makes up for what is missing. Each filter exists twice, as plain NumPy and as a numba kernel; both return

    total_i = sum_j w_ij c_j        (h, w, c)
    norm_i  = sum_j w_ij            (h, w)

apart, because an average hides a neighbour that was counted twice, and because a gradient needs both. The weight of a
pixel with itself is 1, so norm >= 1 and the division in `divide` is always safe.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mcdenoise.samples.gate import check_image

LARGEST = 1e30


def window_offsets(height: int, width: int, radius: int) -> Iterator[tuple[int, int, tuple, tuple]]:
    """Walk over the offsets (dy, dx) of the window, each with the two parts of the image that it brings together.

    Yields
    ------
    dy, dx, here, there : `there` is `here` moved by (dy, dx); both are pairs of slices (rows, columns) inside the
        image.

    Examples
    --------
    >>> image = np.array([[1, 2, 3]])
    >>> for dy, dx, here, there in window_offsets(1, 3, radius=1):
    ...     print(dx, image[here], image[there])
    -1 [[2 3]] [[1 2]]
    0 [[1 2 3]] [[1 2 3]]
    1 [[1 2]] [[2 3]]
    """
    reach_y, reach_x = min(radius, height - 1), min(radius, width - 1)
    for dy in range(-reach_y, reach_y + 1):
        for dx in range(-reach_x, reach_x + 1):
            here = slice(max(0, -dy), height - max(0, dy)), slice(max(0, -dx), width - max(0, dx))
            there = slice(max(0, dy), height + min(0, dy)), slice(max(0, dx), width + min(0, dx))
            yield dy, dx, here, there


def bell(difference: np.ndarray, sigma: float | np.ndarray) -> np.ndarray:
    """G_sigma of a vector: exp(-|difference|^2 / (2 sigma^2)), with the vector's components on the last axis.

    `sigma` is one number, or one for each component. 1 at distance 0 (the constant in front of a normalised Gaussian
    cancels in total / norm). An infinite sigma gives 1 everywhere; where the exponent leaves the range of float64 the
    result is 0.

    Examples
    --------
    >>> bell(np.array([[3.0, 4.0], [0.0, 0.0]]), sigma=5.0).round(4)
    array([0.6065, 1.    ])
    """
    with np.errstate(over="ignore", divide="ignore", under="ignore"):
        return np.exp(-0.5 * np.sum((difference / sigma) ** 2, axis=-1))


def divide(total: np.ndarray, norm: np.ndarray, image: np.ndarray, factor: np.ndarray | None = None) -> np.ndarray:
    """The weighted mean total / norm, in the shape and dtype of `image`; times `factor` (h, w, c), if there is one.

    Examples
    --------
    >>> divide(np.array([[[6.0]]]), np.array([[2.0]]), image=np.zeros((1, 1), np.float32))
    array([[3.]], dtype=float32)
    """
    mean = np.empty(total.shape, image.dtype)
    for k in range(total.shape[-1]):
        np.divide(total[..., k], norm, out=mean[..., k], casting="same_kind")
    if factor is not None:
        np.multiply(mean, factor, out=mean, casting="same_kind")
    return mean.reshape(image.shape)


def check_range(image: object, name: str = "image") -> np.ndarray:
    """Return `image` as `check_image` does, if its values also leave room for sums of squares in float32.

    Raises
    ------
    ValueError
        As `check_image`, and for magnitudes above 1e30.

    Examples
    --------
    >>> check_range([[1.0, 2.0]]).shape
    (1, 2)
    """
    image = check_image(image, name)
    largest = np.abs(image).max()
    if largest > LARGEST:
        raise ValueError(
            f"{name} must stay within {LARGEST:g} in magnitude (sums in float32 overflow beyond), got {largest:g}. "
            f"Divide it by a constant first."
        )
    return image


def with_channels(image: np.ndarray) -> np.ndarray:
    """View an image (h, w) as (h, w, 1); one of shape (h, w, c) comes back as it is.

    Examples
    --------
    >>> with_channels(np.ones((2, 3))).shape
    (2, 3, 1)
    """
    return image[..., np.newaxis] if image.ndim == 2 else image
