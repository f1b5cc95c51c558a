"""Chapter 04: the cross-bilateral filter. Three ideas: near, alike in colour, and alike in features.

Radiance is noisy, so likeness of radiance is a noisy witness. The renderer knows more about a pixel: what was hit,
where, and which way the surface faces. Each such feature adds one more bell curve to the weight.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mcdenoise.filters.window import bell, check_range, divide, window_offsets, with_channels
from mcdenoise.samples.buffer import SampleBuffer
from mcdenoise.samples.gate import (
    ENGINES,
    check_bandwidth,
    check_choice,
    check_names,
    check_radius,
    check_same_size,
)
from mcdenoise.samples.statistics import pixel_mean


def cross_bilateral(
    image: np.ndarray,
    features: Mapping[str, np.ndarray] | SampleBuffer,
    *,
    sigma_space: float,
    sigma_radiance: float,
    sigma_features: Mapping[str, float],
    radius: int | None = None,
    engine: str = "numba",
) -> np.ndarray:
    """Replace every pixel by the mean of its neighbourhood, weighted by closeness, radiance and features.

    out_i = sum_j w_ij c_j / sum_j w_ij
    w_ij  = G_sigma_space(|p_i - p_j|) G_sigma_radiance(|c_i - c_j|) prod_k G_sigma_k(|f_k,i - f_k,j|)

    with G_s(d) = exp(-d^2 / (2 s^2)), Euclidean (L2) distances over all channels of a quantity together, and j over the
    pixels of the square window that lie inside the image. With every sigma_k -> infinity this is `bilateral`.

    Parameters
    ----------
    image : (h, w) or (h, w, c), float32 or float64. Scene-linear radiance.
    features : name -> array (h, w) or (h, w, c), each with an entry in `sigma_features`; or a SampleBuffer, of which
        the pixel means of the features named in `sigma_features` are taken.
    sigma_space : in pixels, > 0; infinity switches the term off, here and below.
    sigma_radiance : in the unit of `image`, > 0.
    sigma_features : name -> bandwidth in the unit of that feature (scene units for world_position), > 0.
    radius : the window has (2 radius + 1)^2 pixels. Default: ceil(3 sigma_space).
    engine : ``"numba"``, in float32, or ``"numpy"``, the formula as it reads and in float64.

    Returns
    -------
    Array of the shape and dtype of `image`. (A float64 image therefore passes through float32 with ``engine="numba"``.)

    Raises
    ------
    ValueError
        As `bilateral`; also for features that are neither a mapping nor a SampleBuffer, that differ from the image in
        size, or whose names are not those of `sigma_features`.

    References
    ----------
    Petschnigg et al., SIGGRAPH 2004, https://doi.org/10.1145/1015706.1015777, and Eisemann and Durand, SIGGRAPH 2004,
    https://doi.org/10.1145/1015706.1015778 (the second image as guide); Sen and Darabi, TOG 31(3), 2012,
    https://doi.org/10.1145/2167076.2167083 (scene features as guides).

    Examples
    --------
    The radiance alone cannot tell the last two pixels apart, the albedo can:

    >>> albedo = {"albedo": np.array([[0.2, 0.2, 0.8]])}
    >>> image, sigmas = [[1.0, 3.0, 4.0]], {"albedo": 0.1}
    >>> cross_bilateral(
    ...     image, albedo, sigma_space=9.0, sigma_radiance=np.inf, sigma_features=sigmas, radius=2, engine="numpy"
    ... ).round(1)
    array([[2., 2., 4.]])
    """
    image = check_range(image)
    sigma_space = check_bandwidth(sigma_space, "sigma_space")
    sigma_radiance = check_bandwidth(sigma_radiance, "sigma_radiance")
    guides = _check_guides(features, sigma_features, image)
    radius = check_radius(radius, sigma_space)
    if check_choice(engine, ENGINES, "engine") == "numpy":
        sums = cross_bilateral_sums
    else:
        from mcdenoise.kernels.bilateral import cross_bilateral_sums as sums
    total, norm = sums(with_channels(image), guides, sigma_space, sigma_radiance, radius)
    return divide(total, norm, image)


def cross_bilateral_sums(
    image: np.ndarray,
    guides: list[tuple[np.ndarray, float]],
    sigma_space: float,
    sigma_radiance: float,
    radius: int,
) -> tuple[np.ndarray, np.ndarray]:
    """The reference: sum of w c and sum of w of every pixel, in float64.

    Parameters
    ----------
    image : (h, w, c). guides : for each feature its array (h, w, c_k) and its sigma. The rest as for `bilateral_sums`.

    Returns
    -------
    total, norm : (h, w, c) and (h, w).

    Examples
    --------
    >>> guide = np.array([[[0.0], [2.0]]])
    >>> total, norm = cross_bilateral_sums(np.ones((1, 2, 1)), [(guide, 2.0)], np.inf, np.inf, radius=1)
    >>> norm.round(3)
    array([[1.607, 1.607]])
    """
    image = image.astype(np.float64)
    guides = [(feature.astype(np.float64), sigma) for feature, sigma in guides]
    height, width, _ = image.shape
    total, norm = np.zeros_like(image), np.zeros((height, width))
    for dy, dx, here, there in window_offsets(height, width, radius):
        weight = bell(np.array([dy, dx]), sigma_space) * bell(image[here] - image[there], sigma_radiance)
        for feature, sigma in guides:
            weight = weight * bell(feature[here] - feature[there], sigma)
        total[here] += weight[..., np.newaxis] * image[there]
        norm[here] += weight
    return total, norm


def _check_guides(features: object, sigma_features: object, image: np.ndarray) -> list[tuple[np.ndarray, float]]:
    """Bring features and bandwidths together: a list of (array (h, w, c_k), sigma)."""
    if not isinstance(sigma_features, Mapping):
        raise ValueError(
            f"sigma_features must be a mapping from name to bandwidth, got {sigma_features!r}. "
            f"Write sigma_features={{'albedo': 0.1}}."
        )
    if isinstance(features, SampleBuffer):
        names = check_names(sigma_features, features.feature_names, "sigma_features")
        features = {name: pixel_mean(features[name]) for name in names}
    elif isinstance(features, Mapping):
        names = check_names(sigma_features, tuple(features), "sigma_features")
        if missing := [name for name in features if name not in names]:
            raise ValueError(
                f"sigma_features must give a bandwidth for every feature, got none for "
                f"{', '.join(map(repr, missing))}. Give one (infinity ignores the feature) or leave the feature out."
            )
    else:
        raise ValueError(
            f"features must be a mapping from name to array or a SampleBuffer, got {type(features).__name__}. "
            f"Write features={{'albedo': array}}."
        )
    guides = []
    for name in names:
        feature = check_same_size(check_range(features[name], f"features[{name!r}]"), f"features[{name!r}]", image)
        guides.append((with_channels(feature), check_bandwidth(sigma_features[name], f"sigma_features[{name!r}]")))
    return guides
