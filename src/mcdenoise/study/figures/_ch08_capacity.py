"""Chapter 08, figures about size: how many weights are needed, for points in the plane and for one step of denoising."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.filters import gaussian
from mcdenoise.metrics import relmse
from mcdenoise.study.capacity import Capacity, capacity_figure
from mcdenoise.study.capacity_tasks import DENOISE, denoise_data, run_data, run_task
from mcdenoise.study.figures._ch04_data import noisy, samples
from mcdenoise.study.figures._references import reference

PIXELS, FOLDS = 4096, 5
SIGMA = 1.5  # pixels; a Gaussian of 5 x 5 pixels, what the network sees


def numbers_of(capacity: Capacity) -> dict:
    """What the text may quote: of every model, and of the best and the chosen."""
    found = {"candidates": len(capacity.candidates)}
    for one in capacity.candidates:
        name = one.label.replace("-", "_")
        found |= {f"error_{name}": one.mean, f"fitted_{name}": float(one.fitted.mean()), f"size_{name}": one.parameters}
    for word, place in (("best", capacity.best), ("chosen", capacity.chosen)):
        one = capacity.candidates[place]
        found |= {word: one.label, f"{word}_size": one.parameters, f"{word}_error": one.mean}
    return found | {"standard_error": capacity.candidates[capacity.best].standard_error}


def capacity_plane() -> tuple[Figure, dict]:
    """Rings: how many hidden neurons?"""
    found = run_task("rings")
    return capacity_figure(found), numbers_of(found)


def capacity_denoise() -> tuple[Figure, dict]:
    """One step of denoising: how many hidden neurons, and is a second layer worth it?"""
    data, image = denoise_data(samples("dof"), reference("dof"), PIXELS, seed=0), noisy("dof").astype(np.float64)
    found = run_data(data, DENOISE, FOLDS, seed=0)
    by_pixels = run_data(
        replace(data, groups=np.arange(PIXELS)), (found.candidates[found.chosen].hidden,), FOLDS, seed=0
    )
    blurred = gaussian(image, sigma_space=SIGMA, radius=2)
    beside = {
        "by_pixels": by_pixels.candidates[0].mean,
        "noisy": relmse(image, reference("dof")),
        "gaussian": relmse(blurred, reference("dof")),
    }
    return capacity_figure(found), numbers_of(found) | beside
