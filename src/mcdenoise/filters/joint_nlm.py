"""Chapter 04: patches and features together. Radiance is compared by patches, the scene's features pixel by pixel."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mcdenoise.filters.albedo import safe_albedo
from mcdenoise.filters.cross_bilateral import likeness
from mcdenoise.filters.guides import Guide, check_guides, check_variance
from mcdenoise.filters.nlm import box_mean, check_patches, patch_distance
from mcdenoise.filters.window import bell, check_range, divide, window_offsets, with_channels
from mcdenoise.samples.buffer import SampleBuffer
from mcdenoise.samples.gate import ENGINES, check_bandwidth, check_choice


def joint_nlm(
    image: np.ndarray,
    variance: np.ndarray | float,
    features: Mapping[str, np.ndarray] | SampleBuffer,
    *,
    sigma_features: Mapping[str, float],
    variances: Mapping[str, np.ndarray] | None = None,
    sigma_space: float = np.inf,
    search_radius: int = 5,
    patch_radius: int = 3,
    k: float = 0.6,
    weight_radius: int = 0,
    cancellation: float = 1.0,
    albedo: np.ndarray | None = None,
    engine: str = "numba",
) -> np.ndarray:
    """Replace every pixel by a mean over the search window, weighted by patches of radiance and by features.

    w_pq = exp(-max(0, d^2(p, q))) G_sigma_space(|p - q|) prod_k likeness_k(p, q)

    with the patch distance d^2 of `nlm` and the likeness of features of `cross_bilateral`, noise included. With every
    sigma_k and sigma_space infinite this is `nlm`; with k infinite it is `cross_bilateral` with sigma_radiance infinite.

    Parameters
    ----------
    image : (h, w) or (h, w, c), float32 or float64. Scene-linear radiance.
    variance : of `image`, as for `nlm`.
    features, sigma_features, variances : as for `cross_bilateral`; `prefilter_features` gives features and variances.
    sigma_space : in pixels, > 0; by default the search window is flat.
    search_radius, patch_radius, k, weight_radius, cancellation : as for `nlm`.
    albedo : as for `cross_bilateral`.
    engine : ``"numba"``, in float32, or ``"numpy"``, the formula as it reads and in float64.

    Returns
    -------
    Array of the shape and dtype of `image`. (A float64 image therefore passes through float32 with ``engine="numba"``.)

    Raises
    ------
    ValueError
        As `nlm` and `cross_bilateral`.

    References
    ----------
    Rousselle, Manzi and Zwicker, "Robust denoising using feature and color information", CGF 32(7), 2013,
    https://doi.org/10.1111/cgf.12219 (who take the smaller of the two weights instead of their product); Kalantari, Bako
    and Sen, TOG 34(4), 2015, https://doi.org/10.1145/2766977 (the product).

    Examples
    --------
    The radiance is all noise, the albedo tells the two surfaces apart:

    >>> image, albedo = np.array([[1.0, 3.0, 2.0, 4.0]]), np.array([[0.2, 0.2, 0.8, 0.8]])
    >>> joint_nlm(
    ...     image, 2.0, {"albedo": albedo}, sigma_features={"albedo": 0.1}, patch_radius=0, engine="numpy"
    ... ).round(1)
    array([[2., 2., 3., 3.]])
    """
    image = check_range(image)
    variance = check_variance(variance, "variance", image)
    guides = check_guides(features, sigma_features, variances, image)
    sigma_space = check_bandwidth(sigma_space, "sigma_space")
    patches = check_patches(search_radius, patch_radius, k, weight_radius, cancellation)
    safe = safe_albedo(albedo, image)
    if check_choice(engine, ENGINES, "engine") == "numpy":
        sums = joint_nlm_sums
    else:
        from mcdenoise.kernels.nlm import joint_nlm_sums as sums
    colour = with_channels(image)
    if safe is not None:
        colour, variance = colour / safe, variance / safe**2
    total, norm = sums(colour, variance, guides, sigma_space, *patches)
    return divide(total, norm, image, safe)


def joint_nlm_sums(
    image: np.ndarray,
    variance: np.ndarray,
    guides: list[Guide],
    sigma_space: float,
    search_radius: int,
    patch_radius: int,
    k: float,
    weight_radius: int = 0,
    cancellation: float = 1.0,
) -> tuple[np.ndarray, np.ndarray]:
    """The reference: sum of w c and sum of w of every pixel, in float64.

    Parameters
    ----------
    image, variance : (h, w, c). guides : one a feature. The rest as for `joint_nlm`.

    Returns
    -------
    total, norm : (h, w, c) and (h, w).

    Examples
    --------
    >>> image, guide = np.array([[[0.0], [3.0]]]), Guide(np.array([[[0.0], [1.0]]]), 1.0)
    >>> total, norm = joint_nlm_sums(image, np.ones((1, 2, 1)), [guide], np.inf, 1, 0, k=2.0)
    >>> norm.round(4)  # 1 + exp(-(9 - 2) / (4 * 2) - 1 / 2)
    array([[1.2528, 1.2528]])
    """
    image = image.astype(np.float64)
    variance = variance.mean(axis=-1, dtype=np.float64)
    height, width, _ = image.shape
    total, norm = np.zeros_like(image), np.zeros((height, width))
    for dy, dx, here, there in window_offsets(height, width, search_radius):
        distance = patch_distance(image, variance, here, there, patch_radius, k, cancellation)
        weight = box_mean(np.exp(-distance), weight_radius) * bell(np.array([dy, dx]), sigma_space)
        for guide in guides:
            weight = weight * likeness(guide, here, there)
        total[here] += weight[..., np.newaxis] * image[there]
        norm[here] += weight
    return total, norm
