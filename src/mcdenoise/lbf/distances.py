"""Chapter 09: how far apart two pixels are, in position, in colour, and in each group of features."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mcdenoise.filters.nlm import patch_distance

if TYPE_CHECKING:
    from mcdenoise.lbf.layer import FilterLayer

COLOUR_EPSILON = 1e-10  # radiance squared
PATCH_LIMIT = 1e6  # of the distance of two pixels: one firefly in a patch of 49 must count, with a small theta too
LEAST_VARIANCE = 1e-4  # of a feature, unit of the feature squared


def offset_distances(layer: FilterLayer, dy: int, dx: int, here: tuple, there: tuple) -> np.ndarray:
    """Distances E_m between the pixels of `here` and those of `there`, which is `here` moved by (dy, dx).

    Parameters
    ----------
    layer : which says what is compared
    dy, dx, here, there : from `window_offsets`

    Returns
    -------
    (rows, columns, names), float64, >= 0

    Examples
    --------
    >>> from mcdenoise.lbf.layer import FilterLayer
    >>> from mcdenoise.lbf.primary import Primary
    >>> image = np.array([[[0.0] * 3, [1.0] * 3]], np.float32)
    >>> layer = FilterLayer(Primary(image, np.ones_like(image), {}, {}, {}, spp=4))
    >>> offset_distances(layer, 0, 1, np.s_[:, :1], np.s_[:, 1:]).ravel().round(3)
    array([1. , 1.5])
    """
    primary = layer.primary
    colour, spread = primary.colour.astype(np.float64), primary.colour_variance.astype(np.float64) + COLOUR_EPSILON / 2
    if layer.variant == "nlm":
        of_colour = patch_distance(
            colour, spread.mean(axis=-1), here, there, layer.patch_radius, k=1.0, limit=PATCH_LIMIT
        )
    else:
        of_colour = np.sum((colour[here] - colour[there]) ** 2 / (spread[here] + spread[there]), axis=-1)
    found = [np.full(of_colour.shape, float(dy**2 + dx**2)), of_colour]
    for name in primary.groups:
        feature = primary.features[name].astype(np.float64)
        variance = np.maximum(primary.variances[name].astype(np.float64), LEAST_VARIANCE)
        found.append(np.sum((feature[here] - feature[there]) ** 2 / variance[here], axis=-1))
    return np.stack(found, axis=-1)
