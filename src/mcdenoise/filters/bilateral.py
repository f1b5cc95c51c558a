"""Chapter 03: the bilateral filter. Two ideas: near, and alike in colour.

The Gaussian filter blurs edges because it also averages across them. A second bell curve, over the difference in
radiance, gives a neighbour on the other side of an edge no say.
"""

from __future__ import annotations

import numpy as np

from mcdenoise.filters.window import bell, check_range, divide, window_offsets, with_channels
from mcdenoise.samples.gate import ENGINES, check_bandwidth, check_choice, check_radius


def bilateral(
    image: np.ndarray, *, sigma_space: float, sigma_radiance: float, radius: int | None = None, engine: str = "numba"
) -> np.ndarray:
    """Replace every pixel by the mean of its neighbourhood, weighted by closeness and by likeness of radiance.

    out_i = sum_j w_ij c_j / sum_j w_ij,   w_ij = G_sigma_space(|p_i - p_j|) G_sigma_radiance(|c_i - c_j|)

    with G_s(d) = exp(-d^2 / (2 s^2)), the Euclidean (L2) distance over all channels together, and j over the pixels of
    the square window that lie inside the image. (OpenCV adds up absolute differences, L1, and takes a round window.)
    With sigma_radiance -> infinity this is `gaussian`; with sigma_radiance -> 0 it returns the image.

    Parameters
    ----------
    image : (h, w) or (h, w, c), float32 or float64. Scene-linear radiance.
    sigma_space : in pixels, > 0; infinity switches the term off.
    sigma_radiance : in the unit of `image`, > 0; infinity switches the term off.
    radius : the window has (2 radius + 1)^2 pixels. Default: ceil(3 sigma_space).
    engine : ``"numba"``, in float32, or ``"numpy"``, the formula as it reads and in float64.

    Returns
    -------
    Array of the shape and dtype of `image`. (A float64 image therefore passes through float32 with ``engine="numba"``.)

    Raises
    ------
    ValueError
        For an image that is not finite, not (h, w) or (h, w, c), or beyond 1e30; for a sigma that is not positive; for
        a radius that is no whole number >= 0, or is missing with an infinite sigma_space; for an unknown engine.

    References
    ----------
    Tomasi and Manduchi, "Bilateral filtering for gray and color images", ICCV 1998, equations (5) and (6),
    https://doi.org/10.1109/ICCV.1998.710815

    Examples
    --------
    A step survives, the small difference on its left does not:

    >>> bilateral([[1.0, 1.2, 9.0]], sigma_space=5.0, sigma_radiance=1.0, radius=2, engine="numpy").round(2)
    array([[1.1, 1.1, 9. ]])
    """
    image = check_range(image)
    sigma_space = check_bandwidth(sigma_space, "sigma_space")
    sigma_radiance = check_bandwidth(sigma_radiance, "sigma_radiance")
    radius = check_radius(radius, sigma_space)
    if check_choice(engine, ENGINES, "engine") == "numpy":
        sums = bilateral_sums
    else:
        from mcdenoise.kernels.bilateral import bilateral_sums as sums
    total, norm = sums(with_channels(image), sigma_space, sigma_radiance, radius)
    return divide(total, norm, image)


def bilateral_sums(
    image: np.ndarray, sigma_space: float, sigma_radiance: float, radius: int
) -> tuple[np.ndarray, np.ndarray]:
    """Sum of the weighted pixels and sum of the weights around every pixel, in float64.

    total_p = sum_q w_pq I_q,   norm_p = sum_q w_pq
    w_pq = exp(-|p - q|^2 / (2 sigma_space^2)) exp(-|I_p - I_q|^2 / (2 sigma_radiance^2))

    with I the image and |I_p - I_q| the Euclidean distance over its channels; q runs over the pixels inside the image
    that lie at most `radius` rows and columns away from p (p is one of them).

    Parameters
    ----------
    image : (h, w, c), floats or whole numbers; it is not changed.
    sigma_space : pixels, > 0; may be infinite.
    sigma_radiance : unit of `image`, > 0; may be infinite.
    radius : pixels, a whole number >= 0; may exceed the image.

    Returns
    -------
    total, norm : (h, w, c) and (h, w).

    Examples
    --------
    >>> total, norm = bilateral_sums(np.array([[[0.0], [2.0]]]), np.inf, 2.0, radius=1)
    >>> norm.round(3)
    array([[1.607, 1.607]])
    """
    ### BEGIN SOLUTION
    image = image.astype(np.float64)
    height, width, _ = image.shape
    total, norm = np.zeros_like(image), np.zeros((height, width))
    for dy, dx, here, there in window_offsets(height, width, radius):
        weight = bell(np.array([dy, dx]), sigma_space) * bell(image[here] - image[there], sigma_radiance)
        total[here] += weight[..., np.newaxis] * image[there]
        norm[here] += weight
    return total, norm
    ### END SOLUTION
