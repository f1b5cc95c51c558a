"""How far is an image from its reference? relMSE first: it weighs a dark pixel like a bright one."""

from __future__ import annotations

import numpy as np

from mcdenoise.samples.gate import check_bandwidth, check_image


def squared_error_map(image: object, reference: object) -> np.ndarray:
    """Squared error of every pixel and channel, (x - ref)^2, float64, shape of the image.

    Raises
    ------
    ValueError
        For unequal shapes, NaN or infinity, or arrays that are no images.

    Examples
    --------
    >>> squared_error_map([[1.0, 2.0]], [[1.0, 4.0]])
    array([[0., 4.]])
    """
    image, reference = _check_pair(image, reference)
    return (image - reference) ** 2


def relmse_map(image: object, reference: object, epsilon: float = 0.01) -> np.ndarray:
    """Relative squared error of every pixel and channel, (x - ref)^2 / (ref^2 + epsilon), float64, shape of the image.

    Parameters
    ----------
    image, reference : (h, w) or (h, w, c), scene-linear radiance.
    epsilon : in radiance squared, above 0: keeps black pixels from counting without bound.

    Raises
    ------
    ValueError
        As for `squared_error_map`, or for an `epsilon` that is not above 0.

    References
    ----------
    Rousselle, Knaus & Zwicker 2011, "Adaptive sampling and reconstruction using greedy error minimization"; the lecture's
    E_i is n/2 times the sum of this over a pixel's channels.

    Examples
    --------
    >>> relmse_map([[1.0, 2.0]], [[1.0, 0.0]], epsilon=1.0)
    array([[0., 4.]])
    """
    image, reference = _check_pair(image, reference)
    return (image - reference) ** 2 / (reference**2 + check_bandwidth(epsilon, "epsilon"))


def relmse(image: object, reference: object, epsilon: float = 0.01) -> float:
    """Relative mean squared error: the mean of `relmse_map` over pixels and channels.

    Parameters and errors as there.

    Examples
    --------
    >>> relmse([[1.0, 2.0]], [[1.0, 0.0]], epsilon=1.0)
    2.0
    """
    return float(relmse_map(image, reference, epsilon).mean())


def mse(image: object, reference: object) -> float:
    """Mean squared error over pixels and channels, in radiance squared.

    Parameters and errors as for `squared_error_map`.

    Examples
    --------
    >>> mse([[1.0, 2.0]], [[1.0, 4.0]])
    2.0
    """
    return float(squared_error_map(image, reference).mean())


def psnr(image: object, reference: object, peak: float = 1.0) -> float:
    """Peak signal-to-noise ratio, 10 log10(peak^2 / mse), in decibels; infinity for equal images.

    Parameters
    ----------
    image, reference : (h, w) or (h, w, c). Radiance has no peak of its own: say which value counts as white.
    peak : radiance of white.

    Raises
    ------
    ValueError
        As for `mse`, or for a `peak` that is not above 0.

    Examples
    --------
    >>> psnr([[0.0, 0.0]], [[0.1, 0.1]])
    20.0
    """
    peak, error = check_bandwidth(peak, "peak"), mse(image, reference)
    return float("inf") if error == 0 else float(10 * np.log10(peak**2 / error))


def ssim(image: object, reference: object, peak: float = 1.0) -> float:
    """Mean structural similarity, 1 for equal images; scikit-image's with its 7x7 window, per channel, then the mean.

    Parameters and errors as for `psnr`; both sides must measure at least 7 pixels.

    References
    ----------
    Wang, Bovik, Sheikh & Simoncelli 2004, "Image quality assessment: from error visibility to structural similarity".

    Examples
    --------
    >>> ssim(np.eye(8), np.eye(8))
    1.0
    """
    from skimage.metrics import structural_similarity

    image, reference = _check_pair(image, reference)
    if min(image.shape[:2]) < 7:
        raise ValueError(f"ssim needs images of at least 7 x 7 pixels, got {image.shape[0]} x {image.shape[1]}.")
    channel_axis = 2 if image.ndim == 3 else None
    peak = check_bandwidth(peak, "peak")
    return float(structural_similarity(image, reference, data_range=peak, channel_axis=channel_axis))


def _check_pair(image: object, reference: object) -> tuple[np.ndarray, np.ndarray]:
    """Return both in float64 after checking that they can be compared."""
    image, reference = check_image(image), check_image(reference, "reference")
    if image.shape != reference.shape:
        raise ValueError(
            f"image and reference must have the same shape, got {image.shape} and {reference.shape}. Render the "
            f"reference at the size of the image."
        )
    return image.astype(np.float64), reference.astype(np.float64)
