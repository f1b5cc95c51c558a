"""Albedo demodulation: divide, filter, multiply. Texture leaves before the filter and comes back unblurred."""

from __future__ import annotations

import numpy as np

from mcdenoise.filters.window import with_channels
from mcdenoise.samples.gate import check_image, check_same_size

DARKEST = 0.1


def safe_albedo(albedo: object, image: np.ndarray) -> np.ndarray | None:
    """What an image may be divided by before filtering: the albedo, but at least 0.1.

    Radiance of a diffuse surface is albedo times what arrives; what arrives is smoother. On metal, lamps and sky the
    albedo is 0, and a pixel on their rim has a little of it: divided by that, its radiance would outshine everything it
    is averaged with. With the floor no quotient is more than ten times the radiance, and there is no step where one
    pixel is divided and the next is not. Divide, filter, multiply by the same array: what is not filtered comes back.

    Take an albedo without noise, that of `prefilter_features`: the noise of raw pixel means would be divided by too.

    Parameters
    ----------
    albedo : (h, w) for all channels alike, or the shape of `image`; in [0, 1], pixel means. None: no demodulation.
    image : (h, w) or (h, w, c), what is to be divided.

    Returns
    -------
    (h, w, c) with the c of `image`, in [0.1, 1]; or None for None.

    Raises
    ------
    ValueError
        For another size or number of channels, NaN, infinity, or values outside [0, 1].

    References
    ----------
    Bako et al., "Kernel-predicting convolutional networks for denoising Monte Carlo renderings", TOG 36(4), 2017,
    https://doi.org/10.1145/3072959.3073708 (they add 0.00316 to the albedo, and divide the diffuse part of radiance only).

    Examples
    --------
    >>> safe_albedo([[0.5, 0.0]], np.ones((1, 2))).ravel().round(2).tolist()
    [0.5, 0.1]
    """
    if albedo is None:
        return None
    albedo = with_channels(check_same_size(check_image(albedo, "albedo"), "albedo", image))
    shape = with_channels(image).shape
    if albedo.shape[2] not in (1, shape[2]):
        raise ValueError(f"albedo must have shape (h, w) or that of image, {image.shape}, got {albedo.shape}.")
    if albedo.min() < 0 or albedo.max() > 1:
        raise ValueError(
            f"albedo must lie in [0, 1], got {albedo.min():g} to {albedo.max():g}. Pass the diffuse reflectance."
        )
    return np.broadcast_to(np.maximum(albedo, albedo.dtype.type(DARKEST)), shape)
