"""The entries of the study: every setting on one scene at one spp, Monte Carlo on one scene, and the growth of time."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from functools import lru_cache
from time import perf_counter
from typing import Any

import numpy as np

from mcdenoise.metrics import relmse
from mcdenoise.render import capture, render_image, render_reference
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.study.bench_scaling import straight_line
from mcdenoise.study.compare import timed, timed_often
from mcdenoise.study.methods import Parameters
from mcdenoise.study.speed_accuracy_curves import Curve, Setting, all_curves
from mcdenoise.study.speed_accuracy_settings import Settings
from mcdenoise.study.tune import choose_parameters

CHOOSING_SEED = 0  # of the samples that bandwidths are chosen on; the seeds that are judged are 1, 2, ...
CORNER = 16  # pixels a side: what every setting runs on once before it is timed
ENOUGH_SECONDS = 0.1  # of timing one setting on one seed
CAPTURES = 4  # samples of one scene that are kept in memory


@lru_cache(maxsize=CAPTURES)
def captured(scene: str, size: int, spp: int, seed: int) -> SampleBuffer:
    """Return the samples of a scene, from memory if they were asked for a short while ago."""
    return capture(scene, size, size, spp, seed=seed)


@lru_cache(maxsize=1)
def warmed_curves(few: bool) -> tuple[list[Curve], list[str]]:
    """Return `all_curves` after every setting ran once on a small image: nobody's time has a compiler in it."""
    curves, missing = all_curves(few=few)
    corner = capture("dof", CORNER, CORNER, 2, seed=CHOOSING_SEED)
    for curve in curves:
        for setting in curve.settings:
            curve.method.run(corner, **_with_dial(_middle(curve, corner), setting))
    return curves, missing


def measure_scene(settings: Settings, scene: str, spp: int) -> dict[str, Any]:
    """Run every setting of every curve on all seeds of one scene at one spp.

    Returns
    -------
    ``{"scene", "spp", "choose_seconds", "missing", "unfiltered": [relMSE of each seed], "rows": [...]}``; a row is one
    setting: names of the method and of the setting, chosen parameters, seconds (median over seeds and repeats), how many
    runs that median is of, and relMSE of each seed.
    """
    curves, missing = warmed_curves(settings.few_settings)
    reference = _reference(settings, scene)
    start = perf_counter()
    choosing = _samples(settings, scene, spp, CHOOSING_SEED)
    chosen = [choose_parameters(curve.method, choosing) for curve in curves]
    choose_seconds = perf_counter() - start
    buffers = [_samples(settings, scene, spp, seed) for seed in judged_seeds(settings)]
    rows = []
    for curve, parameters in zip(curves, chosen, strict=True):
        for setting in curve.settings:
            if spp == settings.chart_spp or not setting.slow:
                dialled = _with_dial(parameters, setting)
                rows.append(
                    _about(curve, setting, parameters) | _run(curve, dialled, buffers, reference, settings.repeats)
                )
    return {
        "scene": scene,
        "spp": spp,
        "choose_seconds": choose_seconds,
        "missing": missing,
        "unfiltered": [relmse(pixel_mean(samples.radiance), reference) for samples in buffers],
        "rows": rows,
    }


def measure_monte_carlo(settings: Settings, scene: str) -> dict[str, Any]:
    """Measure the honest rival on one scene: relMSE of each seed at every spp, and what rendering costs.

    Up to the largest of `spps` its images are the unfiltered means of the filters' own samples. Beyond, they are rendered
    and timed; fixed_seconds + spp seconds_per_spp is the straight line through the medians.
    """
    reference = _reference(settings, scene)
    seeds, view = judged_seeds(settings), {"width": settings.size, "height": settings.size}
    errors = [
        [relmse(pixel_mean(_samples(settings, scene, spp, seed).radiance), reference) for seed in seeds]
        for spp in settings.spps
    ]
    render_image(scene, spp=1, seed=0, **view)
    medians = []
    for spp in settings.monte_carlo_spps:
        found = [timed(lambda s=seed, n=spp: render_image(scene, spp=n, seed=s, **view)) for seed in seeds]
        errors.append([relmse(image, reference) for image, _ in found])
        medians.append(statistics.median(seconds for _, seconds in found))
    fixed, each = straight_line(settings.monte_carlo_spps, medians)
    return {
        "scene": scene,
        "spp": [*settings.spps, *settings.monte_carlo_spps],
        "relmse": errors,
        "timed_spp": settings.monte_carlo_spps,
        "timed_seconds": medians,
        "fixed_seconds": max(fixed, 0.0),
        "seconds_per_spp": max(each, 1e-9),
    }


def measure_growth(settings: Settings, quantity: str) -> dict[str, Any]:
    """Time the usual setting of every curve while one quantity grows: "pixels", "spp", or the radius of the "window".

    Returns
    -------
    ``{"quantity", "rows": [{"method", "label", "peer", "values", "seconds"}]}``, without curves that have no such window.
    """
    curves, _ = warmed_curves(settings.few_settings)
    largest = max(settings.growth_sizes)
    if quantity == "pixels":
        whole = captured(settings.growth_scene, largest, settings.chart_spp, CHOOSING_SEED)
        work = {size**2: whole.crop(0, 0, size, size) for size in settings.growth_sizes}
    elif quantity == "spp":
        whole = captured(settings.growth_scene, settings.size, settings.spps[-1], CHOOSING_SEED)
        work = {spp: whole.subset(0, spp) for spp in settings.spps}
    else:
        whole = captured(settings.growth_scene, settings.size, settings.chart_spp, CHOOSING_SEED)
        work = {}
    rows = []
    for curve in curves:
        if work:
            usual = curve.settings[curve.usual]
            runs = {value: (samples, _with_dial(_middle(curve, samples), usual)) for value, samples in work.items()}
        elif curve.window:
            middle = _middle(curve, whole)
            runs = {radius: (whole, {**middle, **curve.window(radius)}) for radius in curve.radii}
        else:
            continue
        seconds = [_median_seconds(curve, samples, dials, settings.repeats) for samples, dials in runs.values()]
        about = {"method": curve.name, "label": curve.label, "peer": curve.peer}
        rows.append({**about, "values": list(runs), "seconds": seconds})
    return {"quantity": quantity, "rows": rows}


def judged_seeds(settings: Settings) -> range:
    """Return the seeds that are judged.

    Examples
    --------
    >>> list(judged_seeds(Settings()))
    [1, 2, 3]
    """
    return range(CHOOSING_SEED + 1, CHOOSING_SEED + 1 + settings.seeds)


def _samples(settings: Settings, scene: str, spp: int, seed: int) -> SampleBuffer:
    """The first `spp` of the samples that are captured once for all spp."""
    return captured(scene, settings.size, settings.spps[-1], seed).subset(0, spp)


def _reference(settings: Settings, scene: str) -> np.ndarray:
    """The reference, cached on disk."""
    return render_reference(scene, settings.size, settings.size, spp=settings.reference_spp, seed=0)


def _middle(curve: Curve, samples: SampleBuffer) -> Parameters:
    """Parameters for where nothing is chosen."""
    candidates = curve.method.candidates(samples)
    return candidates[len(candidates) // 2]


def _with_dial(parameters: Parameters, setting: Setting) -> dict[str, Any]:
    """Chosen parameters with the dial of a setting."""
    return {**parameters, **setting.dial}


def _about(curve: Curve, setting: Setting, parameters: Parameters) -> dict[str, Any]:
    """Names of one setting, and what halves of the samples chose."""
    usual = setting == curve.settings[curve.usual]
    names = {"method": curve.name, "label": curve.label, "setting": setting.label, "usual": usual, "peer": curve.peer}
    return {**names, "parameters": {name: value for name, value in parameters.items() if name not in setting.dial}}


def _run(
    curve: Curve, dials: Parameters, buffers: Sequence[SampleBuffer], reference: np.ndarray, repeats: int
) -> dict[str, Any]:
    """Seconds and errors of one setting over all seeds."""
    seconds: list[float] = []
    errors = []
    for samples in buffers:
        image, taken = timed_often(lambda s=samples: curve.method.run(s, **dials), repeats, ENOUGH_SECONDS)
        seconds += taken
        errors.append(relmse(image, reference))
    return {"seconds": statistics.median(seconds), "repeats": len(seconds), "relmse": errors}


def _median_seconds(curve: Curve, samples: SampleBuffer, dials: Parameters, repeats: int) -> float:
    """Median of the seconds of a method."""
    return statistics.median(timed_often(lambda: curve.method.run(samples, **dials), repeats, ENOUGH_SECONDS)[1])
