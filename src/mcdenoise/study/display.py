"""How images are shown: one tone map for all methods, for display only; no number is ever taken from a displayed image."""

from __future__ import annotations

import base64
import io

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import PowerNorm
from matplotlib.image import imsave

from mcdenoise.samples.gate import check_image


def tone_map(image: object) -> np.ndarray:
    """Turn scene-linear radiance into display values: clip to [0, 1], then the sRGB curve (IEC 61966-2-1).

    Parameters
    ----------
    image : (h, w) or (h, w, c), radiance; 1 is white.

    Returns
    -------
    Same shape, float32 in [0, 1].

    Raises
    ------
    ValueError
        If `image` is no finite image.

    Examples
    --------
    >>> tone_map([[0.0, 0.2140, 7.0]]).round(2)
    array([[0. , 0.5, 1. ]], dtype=float32)
    """
    linear = np.clip(check_image(image), 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055).astype(np.float32)


def error_scale(ceiling: float) -> ScalarMappable:
    """Return the one colour scale of error maps: matplotlib's magma over [0, ceiling], square root scale."""
    return ScalarMappable(PowerNorm(0.5, 0, ceiling), "magma")


def error_colours(error: np.ndarray, ceiling: float) -> np.ndarray:
    """Colour an error map (h, w) by `error_scale`; returns (h, w, 3) in [0, 1]."""
    return error_scale(ceiling).to_rgba(error)[..., :3]


def png_data_uri(display: np.ndarray) -> str:
    """Return display values (h, w, 3) in [0, 1] as the data URI of an 8-bit PNG, so that a page needs no other file."""
    stream = io.BytesIO()
    imsave(stream, np.rint(display * 255).astype(np.uint8), format="png")
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")
