"""A page of pictures: for one entry the noisy image, every method, and the truth, computed again for one seed."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.metrics import relmse
from mcdenoise.samples import pixel_mean
from mcdenoise.samples.gate import check_choice
from mcdenoise.study.display import tone_map
from mcdenoise.study.methods import METHODS
from mcdenoise.study.stability_catalogue import CATALOGUE
from mcdenoise.study.stability_run import timed
from mcdenoise.study.stability_settings import Settings
from mcdenoise.study.stability_tables import short

PICTURED = tuple(name for name, case in CATALOGUE.items() if case.make is not None and name != "small_image")
COLUMNS = 6
LOGARITHMIC = ("high_range", "flat")
LEVEL = {"noise_level": 5, "few_spp": 0, "texture": 1, "black": 0, "noise_free": 0}  # where not the last level is shown


def pictures(name: str, settings: Settings, level: int | None = None) -> Figure:
    """Noisy image, every method, truth, of one entry at one level: `settings.size` pixels, seed 0.

    Parameters
    ----------
    name : out of `PICTURED`
    settings : of the study
    level : its number; None: the last one, or the one that shows most

    Raises
    ------
    ValueError
        For an entry that has no pictures.

    Examples
    --------
    >>> from dataclasses import replace
    >>> figure = pictures("flat", replace(Settings.quick(), size=8))
    >>> len(figure.axes)
    12
    """
    case = CATALOGUE[check_choice(name, PICTURED, "name")]
    number = LEVEL.get(name, len(case.levels) - 1) if level is None else level
    scene = case.make(settings, number, 0)
    noisy = pixel_mean(scene.samples.radiance)
    images = [
        ("unfiltered", noisy),
        *((METHODS[one].label, timed(one, scene.samples, settings).image) for one in METHODS),
    ]
    figure = Figure(figsize=(10.8, 4.5), layout="constrained")
    shown = "; the logarithm is shown" if name in LOGARITHMIC else ""
    figure.suptitle(f"{case.title}: {case.levels[number]}{shown}", fontsize=11)
    for axes, (label, image) in zip(figure.subplots(2, COLUMNS).flat, [*images, ("truth", scene.truth)], strict=True):
        axes.set(xticks=[], yticks=[])
        if image is None or not np.isfinite(image).all():
            axes.text(0.5, 0.5, "no image", ha="center", va="center", transform=axes.transAxes)
            axes.set_title(label, fontsize=9)
            continue
        axes.imshow(display(name, image / scene.scale, scene.truth / scene.scale), interpolation="nearest")
        error = "" if label == "truth" else f"\nrelMSE {short(relmse(image / scene.scale, scene.truth / scene.scale))}"
        axes.set_title(label + error, fontsize=9)
    return figure


def display(name: str, image: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """An image as it is shown, the same for all methods: by the tone map, or by its logarithm over the truth's range."""
    if name not in LOGARITHMIC:
        return tone_map(image)
    low, high = np.log10(truth.min()) - 0.5, np.log10(truth.max()) + 0.5
    return np.clip((np.log10(np.maximum(image, truth.min() / 10)) - low) / (high - low), 0, 1)
