"""Chapter 04: NL-means. Near does not matter, alike does: and alike are two pixels whose surroundings are alike.

One noisy pixel is a poor witness of likeness; the patch around it is a better one. And a difference says little until
one knows how much of it is noise: so patches are compared in units of their variance.
"""

from __future__ import annotations

import numpy as np

from mcdenoise.filters.albedo import safe_albedo
from mcdenoise.filters.gaussian import gaussian_sums
from mcdenoise.filters.guides import check_variance
from mcdenoise.filters.window import check_range, divide, window_offsets, with_channels
from mcdenoise.samples.gate import (
    ENGINES,
    check_bandwidth,
    check_choice,
    check_count,
    check_same_size,
    check_share,
)

LIMIT = 1e4  # largest magnitude of the distance of two pixels: a patch of one such pixel has the weight 0


def nlm(
    image: np.ndarray,
    variance: np.ndarray | float,
    *,
    search_radius: int = 5,
    patch_radius: int = 3,
    k: float = 0.6,
    guide: np.ndarray | None = None,
    weight_radius: int = 0,
    cancellation: float = 1.0,
    albedo: np.ndarray | None = None,
    engine: str = "numba",
) -> np.ndarray:
    """Replace every pixel by the mean of the pixels around it, weighted by the likeness of the patches around both.

    out_p = sum_q w_pq c_q / sum_q w_pq,   w_pq = exp(-max(0, d^2(p, q)))

    d^2(p, q) = mean over the patch of ((u_p - u_q)^2 - a (var_p + min(var_p, var_q))) / (k^2 (var_p + var_q))

    with q over the square search window, u the guide, squares and variances averaged over channels, and the patch
    running along both pixels. Two noisy views of one truth differ by var_p + var_q on average; a = `cancellation`
    takes that off, so that only what noise does not explain counts. With min(var_p, var_q) a firefly p accepts its
    neighbours, but they do not accept it. Windows and patches are clipped at the borders.

    As k -> infinity this is the plain mean of the window. With patch_radius = 0 and variance -> 0 at constant
    k^2 variance it is `bilateral` with sigma_space infinite and sigma_radiance = k sqrt(c variance).

    Parameters
    ----------
    image : (h, w) or (h, w, c), float32 or float64. Scene-linear radiance, or any other quantity.
    variance : of the pixels that are compared, those of `guide` or else of `image`: (h, w), the shape of that image, or
        one number; >= 0, in its unit squared. For samples take `noise_variance`. Where it is 0, only equal values are
        alike.
    search_radius : the search window has (2 search_radius + 1)^2 pixels. In a rendered image those nearby are the best;
        21 x 21, usual for photographs, did worse on four of five toy scenes.
    patch_radius : patches have (2 patch_radius + 1)^2 pixels.
    k : > 0, how many standard deviations still pass; infinity switches the comparison off.
    guide : (h, w) or (h, w, c'): compare the patches of this image instead of those of `image`.
    weight_radius : average the weights of equal offset over (2 weight_radius + 1)^2 pixels p: neighbouring patches
        have a say too. 0: do not.
    cancellation : share a of the expected noise that is taken off, in [0, 1].
    albedo : (h, w) or as `image`: divide `image` (and with it the variance) before filtering, multiply after. Not
        together with `guide`. Default: do not.
    engine : ``"numba"``, in float32, or ``"numpy"``, the formula as it reads and in float64.

    Returns
    -------
    Array of the shape and dtype of `image`. (A float64 image therefore passes through float32 with ``engine="numba"``.)

    Raises
    ------
    ValueError
        For an image or guide that is not finite, has another shape, or goes beyond 1e30; for a variance that does not
        fit, or is negative; for a radius that is no whole number >= 0; for k not above 0; for a cancellation or albedo
        outside [0, 1]; for both albedo and guide; for an unknown engine.

    Notes
    -----
    Each pixel's part of d^2 is kept within +-1e4, so that no number overflows.

    References
    ----------
    Buades, Coll and Morel, CVPR 2005, https://doi.org/10.1109/CVPR.2005.38 (NL-means); Rousselle, Knaus and Zwicker,
    "Adaptive rendering with non-local means filtering", TOG 31(6), 2012, https://doi.org/10.1145/2366145.2366214 (the
    distance, with k = 0.45; they treat channels apart, which made no difference here). `weight_radius` as in Kalantari,
    Bako and Sen 2015.

    Examples
    --------
    A step of many standard deviations survives, noise of one does not:

    >>> image = np.array([[1.0, 1.2, 1.0, 5.0, 5.2, 5.0]])
    >>> nlm(image, 0.02, search_radius=2, patch_radius=0, engine="numpy").round(2)
    array([[1.07, 1.07, 1.07, 5.07, 5.07, 5.07]])
    """
    image = check_range(image)
    compared = image if guide is None else check_same_size(check_range(guide, "guide"), "guide", image)
    variance = check_variance(variance, "variance", compared)
    safe = safe_albedo(albedo, image)
    if safe is not None and guide is not None:
        raise ValueError("nlm takes an albedo or a guide, not both: divide the guide by its albedo yourself.")
    if check_choice(engine, ENGINES, "engine") == "numpy":
        sums = nlm_sums
    else:
        from mcdenoise.kernels.nlm import nlm_sums as sums
    colour, compared = with_channels(image), with_channels(compared)
    if safe is not None:
        colour = compared = colour / safe
        variance = variance / safe**2
    total, norm = sums(
        colour, compared, variance, *check_patches(search_radius, patch_radius, k, weight_radius, cancellation)
    )
    return divide(total, norm, image, safe)


def check_patches(
    search_radius: object, patch_radius: object, k: object, weight_radius: object, cancellation: object
) -> tuple[int, int, float, int, float]:
    """Return the dials of NL-means, checked, in this order.

    Raises
    ------
    ValueError
        For a radius that is no whole number >= 0, k not above 0, or a cancellation outside [0, 1].

    Examples
    --------
    >>> check_patches(10, 3, 1, 0, 1)
    (10, 3, 1.0, 0, 1.0)
    """
    return (
        check_count(search_radius, "search_radius", least=0),
        check_count(patch_radius, "patch_radius", least=0),
        check_bandwidth(k, "k"),
        check_count(weight_radius, "weight_radius", least=0),
        check_share(cancellation, "cancellation"),
    )


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
    """The reference: sum of w c and sum of w of every pixel, in float64.

    Parameters
    ----------
    image : (h, w, c). guide : (h, w, c'), its patches are compared. variance : of the guide, same shape. The rest as
        for `nlm`.

    Returns
    -------
    total, norm : (h, w, c) and (h, w).

    Examples
    --------
    >>> image = np.array([[[0.0], [3.0]]])
    >>> total, norm = nlm_sums(image, image, np.ones((1, 2, 1)), 1, 0, k=2.0)
    >>> norm.round(4)  # 1 + exp(-(9 - 2) / (4 * 2))
    array([[1.4169, 1.4169]])
    """
    image, guide = image.astype(np.float64), guide.astype(np.float64)
    variance = variance.mean(axis=-1, dtype=np.float64)
    height, width, _ = image.shape
    total, norm = np.zeros_like(image), np.zeros((height, width))
    for _, _, here, there in window_offsets(height, width, search_radius):
        distance = patch_distance(guide, variance, here, there, patch_radius, k, cancellation)
        weight = box_mean(np.exp(-distance), weight_radius)
        total[here] += weight[..., np.newaxis] * image[there]
        norm[here] += weight
    return total, norm


def patch_distance(
    guide: np.ndarray,
    variance: np.ndarray,
    here: tuple,
    there: tuple,
    patch_radius: int,
    k: float,
    cancellation: float = 1.0,
    limit: float = LIMIT,
) -> np.ndarray:
    """d^2 >= 0 between the patch of each pixel of `here` and that of the pixel of `there` which it meets.

    Parameters
    ----------
    guide : (h, w, c), float64. variance : (h, w), the mean over its channels. here, there : pairs of slices, from
        `window_offsets`. The rest as for `nlm`.

    Returns
    -------
    Array of the shape of `here`.

    Examples
    --------
    >>> guide = np.array([[[0.0], [3.0]]])
    >>> patch_distance(guide, np.ones((1, 2)), np.s_[:, :1], np.s_[:, 1:], 0, k=2.0)
    array([[0.875]])
    """
    own, other = variance[here], variance[there]
    square = np.mean((guide[here] - guide[there]) ** 2, axis=-1)
    excess = square - cancellation * (own + np.minimum(own, other))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        distance = excess / (np.float64(k) ** 2 * (own + other))
    distance = np.clip(np.nan_to_num(distance, nan=0.0), -limit, limit)  # 0 / 0: equal, and without noise
    return np.maximum(box_mean(distance, patch_radius), 0.0)


def box_mean(values: np.ndarray, radius: int) -> np.ndarray:
    """Mean of `values` (h, w) over the square window around each pixel, clipped at the borders.

    Examples
    --------
    >>> box_mean(np.array([[1.0, 2.0, 6.0]]), radius=1)
    array([[1.5, 3. , 4. ]])
    """
    if radius == 0:
        return values
    total, norm = gaussian_sums(values[..., np.newaxis], np.inf, radius)
    return total[..., 0] / norm
