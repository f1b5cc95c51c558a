"""Chapter 09: colours without texture. What is divided out need not be told apart by the filter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mcdenoise.filters import safe_albedo
from mcdenoise.lbf.primary import Primary

ALBEDO = "albedo"


def untextured(primary: Primary) -> tuple[Primary, np.ndarray | None]:
    """Divide the colours by the prefiltered albedo, as `nlm` and `joint_nlm` do: light varies less than texture.

    Returns
    -------
    primary : with the colours divided, and their variance by the square
    albedo : (h, w, 3), what they were divided by, at least 0.1 (see `safe_albedo`); None, and nothing divided, without
        this group

    Examples
    --------
    >>> striped = np.array([[[0.2] * 3, [0.8] * 3]], np.float32)
    >>> albedo = {"albedo": striped}
    >>> primary, divided_by = untextured(Primary(0.5 * striped, 0 * striped, albedo, albedo, albedo, spp=4))
    >>> primary.colour[..., 0]
    array([[0.5, 0.5]], dtype=float32)
    """
    if ALBEDO not in primary.groups:
        return primary, None
    albedo = safe_albedo(np.clip(primary.features[ALBEDO], 0, 1), primary.colour).astype(np.float32)
    colour, variance = primary.colour / albedo, primary.colour_variance / albedo**2
    return replace(primary, colour=colour, colour_variance=variance), albedo
