"""The shipped references that the figures of all chapters measure against."""

from functools import cache
from pathlib import Path

import numpy as np

from mcdenoise.render import read_exr

FOLDER = Path(__file__).resolve().parents[4] / "notebooks" / "data"  # figures are made in a clone


@cache
def reference(scene: str) -> np.ndarray:
    """Return the reference of a toy scene, (128, 128, 3), 4096 spp.

    Raises
    ------
    ValueError
        Outside a clone of the repository, where the file is missing.
    """
    path = FOLDER / f"{scene}.exr"
    if not path.exists():
        raise ValueError(
            f"Figures need the references in notebooks/data of a clone of the repository; {path} is missing."
        )
    return read_exr(path)
