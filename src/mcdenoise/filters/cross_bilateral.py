"""Chapter 04: the cross-bilateral filter. Three ideas: near, alike in colour, and alike in features.

Radiance is noisy, so likeness of radiance is a noisy witness. The renderer knows more about a pixel: what was hit,
where, and which way the surface faces. Each such feature adds one more bell curve to the weight.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mcdenoise.filters.albedo import safe_albedo
from mcdenoise.filters.guides import RADIANCE, Guide, check_guides, check_variance
from mcdenoise.filters.window import bell, check_range, divide, window_offsets, with_channels
from mcdenoise.samples.buffer import SampleBuffer
from mcdenoise.samples.gate import ENGINES, check_bandwidth, check_choice, check_radius


def cross_bilateral(
    image: np.ndarray,
    features: Mapping[str, np.ndarray] | SampleBuffer,
    *,
    sigma_space: float,
    sigma_radiance: float,
    sigma_features: Mapping[str, float],
    variances: Mapping[str, np.ndarray] | None = None,
    albedo: np.ndarray | None = None,
    radius: int | None = None,
    engine: str = "numba",
) -> np.ndarray:
    """Replace every pixel by the mean of its neighbourhood, weighted by closeness, radiance and features.

    out_i = sum_j w_ij c_j / sum_j w_ij
    w_ij  = G_sigma_space(|p_i - p_j|) G_sigma_radiance(|c_i - c_j|) prod_k G_sigma_k(|f_k,i - f_k,j|)

    with G_s(d) = exp(-d^2 / (2 s^2)), Euclidean (L2) distances over all channels of a quantity together, and j over the
    pixels of the square window that lie inside the image. With every sigma_k -> infinity this is `bilateral`.

    Where a quantity has a variance, each squared difference is divided by what bandwidth and noise together explain:

    sum over channels of (f_i - f_j)^2 / (sigma_k^2 + var_i + var_j)   in place of   |f_i - f_j|^2 / sigma_k^2

    so that a noisy feature loses its say just where it is noisy. With no variance this is the plain filter again; with
    sigma_k -> 0 only the noise counts, and distances are measured in its standard deviations.

    Parameters
    ----------
    image : (h, w) or (h, w, c), float32 or float64. Scene-linear radiance.
    features : name -> array (h, w) or (h, w, c), each with an entry in `sigma_features`; or a SampleBuffer, of which
        the pixel means of the features named in `sigma_features` are taken.
    sigma_space : in pixels, > 0; infinity switches the term off, here and below.
    sigma_radiance : in the unit of `image`, > 0.
    sigma_features : name -> bandwidth in the unit of that feature (scene units for world_position), > 0.
    variances : name -> variance of that feature's pixel values, (h, w) or as the feature, >= 0, in its unit squared;
        ``"radiance"`` is that of `image`. Names left out count as free of noise. Four times the variance lets twice
        the standard deviations pass.
    albedo : (h, w) or as `image`: divide `image` by it before filtering and multiply after, so that texture is not
        blurred (see `safe_albedo`). `sigma_radiance` is then a bandwidth of the quotient. Default: do not.
    radius : the window has (2 radius + 1)^2 pixels. Default: ceil(3 sigma_space).
    engine : ``"numba"``, in float32, or ``"numpy"``, the formula as it reads and in float64.

    Returns
    -------
    Array of the shape and dtype of `image`. (A float64 image therefore passes through float32 with ``engine="numba"``.)

    Raises
    ------
    ValueError
        As `bilateral`; also for features that are neither a mapping nor a SampleBuffer, that differ from the image in
        size, or whose names are not those of `sigma_features`; for variances that fit nothing or are negative; for an
        albedo outside [0, 1].

    References
    ----------
    Petschnigg et al., SIGGRAPH 2004, https://doi.org/10.1145/1015706.1015777, and Eisemann and Durand, SIGGRAPH 2004,
    https://doi.org/10.1145/1015706.1015778 (the second image as guide); Sen and Darabi, TOG 31(3), 2012,
    https://doi.org/10.1145/2167076.2167083 (scene features as guides); Kalantari, Bako and Sen, TOG 34(4), 2015,
    https://doi.org/10.1145/2766977 (distances divided by variances).

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
    guides = check_guides(features, sigma_features, variances, image, own=(RADIANCE,))
    noise = None
    if variances and RADIANCE in variances:
        noise = check_variance(variances[RADIANCE], f"variances[{RADIANCE!r}]", image)
    safe = safe_albedo(albedo, image)
    radius = check_radius(radius, sigma_space)
    if check_choice(engine, ENGINES, "engine") == "numpy":
        sums = cross_bilateral_sums
    else:
        from mcdenoise.kernels.bilateral import cross_bilateral_sums as sums
    colour = with_channels(image)
    if safe is not None:
        colour, noise = colour / safe, None if noise is None else noise / safe**2
    total, norm = sums(colour, guides, sigma_space, sigma_radiance, radius, noise)
    return divide(total, norm, image, safe)


def cross_bilateral_sums(
    image: np.ndarray,
    guides: list[Guide],
    sigma_space: float,
    sigma_radiance: float,
    radius: int,
    radiance_variance: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """The reference: sum of w c and sum of w of every pixel, in float64.

    Parameters
    ----------
    image : (h, w, c). guides : one a feature. radiance_variance : (h, w, c). The rest as for `bilateral_sums`.

    Returns
    -------
    total, norm : (h, w, c) and (h, w).

    Examples
    --------
    >>> guide = Guide(np.array([[[0.0], [2.0]]]), 2.0)
    >>> total, norm = cross_bilateral_sums(np.ones((1, 2, 1)), [guide], np.inf, np.inf, radius=1)
    >>> norm.round(3)
    array([[1.607, 1.607]])
    """
    image = image.astype(np.float64)
    height, width, _ = image.shape
    guides = [Guide(image, sigma_radiance, radiance_variance), *guides]
    total, norm = np.zeros_like(image), np.zeros((height, width))
    for dy, dx, here, there in window_offsets(height, width, radius):
        weight = bell(np.array([dy, dx]), sigma_space)
        for guide in guides:
            weight = weight * likeness(guide, here, there)
        total[here] += weight[..., np.newaxis] * image[there]
        norm[here] += weight
    return total, norm


def likeness(guide: Guide, here: tuple, there: tuple) -> np.ndarray:
    """Weight in (0, 1] of each pixel of `there` for the one of `here`, by one guide.

    exp(-1/2 sum over channels of (f_i - f_j)^2 / (sigma^2 + var_i + var_j))

    Examples
    --------
    Two standard deviations of the difference, 2 = sqrt(2 + 1 + 1):

    >>> guide = Guide(np.array([[[0.0], [4.0]]]), np.sqrt(2.0), np.ones((1, 2, 1)))
    >>> likeness(guide, np.s_[:, :1], np.s_[:, 1:]).round(4)
    array([[0.1353]])
    """
    difference = guide.values[here].astype(np.float64) - guide.values[there]
    if guide.variance is None:
        return bell(difference, guide.sigma)
    noise = guide.variance[here].astype(np.float64) + guide.variance[there]
    return bell(difference, np.sqrt(np.float64(guide.sigma) ** 2 + noise))
