"""Chapter 02: the Gaussian filter. One idea: near.

Two pixels that lie close together probably show the same thing, so average them.
"""

from __future__ import annotations

import numpy as np

from mcdenoise.filters.window import bell, check_range, divide, window_offsets, with_channels
from mcdenoise.samples.gate import ENGINES, check_bandwidth, check_choice, check_radius


def gaussian(image: np.ndarray, *, sigma_space: float, radius: int | None = None, engine: str = "numba") -> np.ndarray:
    """Replace every pixel by the mean of its neighbourhood, weighted by closeness alone.

    out_i = sum_j w_ij c_j / sum_j w_ij,   w_ij = G_sigma_space(|p_i - p_j|) = exp(-|p_i - p_j|^2 / (2 sigma_space^2))

    over the pixels j of the square window that lie inside the image. The constant 1 / (2 pi sigma^2) of the lecture's
    formula cancels in the quotient.

    Parameters
    ----------
    image : (h, w) or (h, w, c), float32 or float64. Scene-linear radiance, or any other quantity.
    sigma_space : standard deviation of the weights in pixels, > 0. Infinity gives the plain mean of the window.
    radius : the window has (2 radius + 1)^2 pixels. Default: ceil(3 sigma_space).
    engine : ``"numba"``, separable and in float32, or ``"numpy"``, the formula as it reads and in float64.

    Returns
    -------
    Array of the shape and dtype of `image`. (A float64 image therefore passes through float32 with ``engine="numba"``.)

    Raises
    ------
    ValueError
        For an image that is not finite, not (h, w) or (h, w, c), or beyond 1e30; for a sigma that is not positive; for
        a radius that is no whole number >= 0, or is missing with an infinite sigma; for an unknown engine.

    References
    ----------
    Lecture, "Gaussian filter". Borders by normalised convolution: Knutsson and Westin, CVPR 1993,
    https://doi.org/10.1109/CVPR.1993.341081

    Examples
    --------
    >>> gaussian([[0.0, 1.0, 0.0]], sigma_space=1.0, radius=1, engine="numpy").round(3)
    array([[0.378, 0.452, 0.378]])
    """
    image = check_range(image)
    sigma_space = check_bandwidth(sigma_space, "sigma_space")
    radius = check_radius(radius, sigma_space)
    if check_choice(engine, ENGINES, "engine") == "numpy":
        sums = gaussian_sums
    else:
        from mcdenoise.kernels.gaussian import gaussian_sums as sums
    total, norm = sums(with_channels(image), sigma_space, radius)
    return divide(total, norm, image)


def gaussian_sums(image: np.ndarray, sigma_space: float, radius: int) -> tuple[np.ndarray, np.ndarray]:
    """Sum of the weighted pixels and sum of the weights around every pixel, in float64.

    total_p = sum_q w_pq image_q,   norm_p = sum_q w_pq,   w_pq = exp(-|p - q|^2 / (2 sigma_space^2))

    over the pixels q inside the image that lie at most `radius` rows and columns away from p (p is one of them).

    Parameters
    ----------
    image : (h, w, c), floats or whole numbers; it is not changed.
    sigma_space : pixels, > 0; may be infinite.
    radius : pixels, a whole number >= 0; may exceed the image.

    Returns
    -------
    total, norm : (h, w, c) and (h, w).

    Examples
    --------
    >>> total, norm = gaussian_sums(np.ones((1, 2, 1)), sigma_space=np.inf, radius=1)
    >>> total[..., 0], norm
    (array([[2., 2.]]), array([[2., 2.]]))
    """
    ### BEGIN SOLUTION
    image = image.astype(np.float64)
    height, width, _ = image.shape
    total, norm = np.zeros_like(image), np.zeros((height, width))
    for dy, dx, here, there in window_offsets(height, width, radius):
        weight = bell(np.array([dy, dx]), sigma_space)
        total[here] += weight * image[there]
        norm[here] += weight
    return total, norm
    ### END SOLUTION
