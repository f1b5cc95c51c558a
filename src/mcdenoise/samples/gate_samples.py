"""The gate of SampleBuffer: what must hold for samples, beyond what `gate` asks of any array."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from mcdenoise.samples.layout import FEATURES, RANDOM_PARAMS, RESERVED

POSITION_SLACK = 1e-3  # pixels: what float32 may lose in images of some ten thousand pixels a side


def check_field(name: str, array: np.ndarray, size: tuple[int, int, int], kind: str) -> np.ndarray:
    """Return the array of one field as (h, w, spp, channels) after checking its name and shape.

    Raises
    ------
    ValueError
        If `name` is no Python name or is taken, or the shape does not fit `size` = (h, w, spp) or the house's layout.
    """
    known = {"random_params": RANDOM_PARAMS, "features": FEATURES}
    other = "features" if kind == "random_params" else "random_params"
    if not isinstance(name, str) or not name.isidentifier() or name in RESERVED or name in known[other]:
        raise ValueError(
            f"A name in {kind} must be a plain word that is not taken ({', '.join(RESERVED)}), got {name!r}."
        )
    channels = known[kind].get(name, (None,))[0]
    needed = f"(h, w, spp, {channels or 'channels'})" if channels != 1 else "(h, w, spp)"
    if array.shape == size:
        array = array[..., np.newaxis]
    if (
        array.ndim != 4
        or array.shape[:3] != size
        or array.shape[3] != (channels or array.shape[3])
        or not array.shape[3]
    ):
        raise ValueError(f"{kind} {name!r} must have shape {needed} with (h, w, spp) = {size}, got {array.shape}.")
    return array


def check_hit(hit: object, size: tuple[int, int, int]) -> np.ndarray:
    """Return `hit` as a bool array of its own."""
    if hit is None:
        return np.ones(size, bool)
    array = np.asarray(hit)
    if array.shape != size or not (array.dtype == bool or np.isin(array, (0, 1)).all()):
        raise ValueError(
            f"hit must be bool (or 0 and 1) of shape (h, w, spp) = {size}, got {array.dtype} of {array.shape}."
        )
    return array.astype(bool)


def check_provenance(provenance: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return a copy of `provenance`, which must be something that can be stored as JSON."""
    try:
        return json.loads(json.dumps(dict(provenance or {})))
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"provenance must hold what JSON can: text, numbers, lists ({error}). Got {provenance!r}."
        ) from error


def check_ranges(screen_position: np.ndarray, random_params: np.ndarray) -> None:
    """Refuse positions outside their pixel and random numbers outside [0, 1]."""
    height, width = screen_position.shape[:2]
    corner = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)[:, :, np.newaxis]
    outside = np.abs(screen_position - corner - 0.5).max(axis=-1) > 0.5 + POSITION_SLACK
    if outside.any():
        y, x, sample = (int(i) for i in np.argwhere(outside)[0])
        raise ValueError(
            f"Each screen_position must lie in its own pixel: (x, y) in pixels, x right, y down, pixel (0, 0) covers "
            f"[0, 1)^2. Got {screen_position[y, x, sample].tolist()} for the pixel in row {y}, column {x}. Are x and y "
            f"exchanged, or the units not pixels?"
        )
    if random_params.size and (random_params.min() < 0 or random_params.max() > 1):
        raise ValueError(
            f"Random parameters must lie in [0, 1], got {random_params.min():g} to {random_params.max():g}. Pass the "
            f"random numbers themselves, not what the renderer made of them."
        )
