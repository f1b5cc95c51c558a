"""How one entry of the catalogue is run: every level, seed and method, and what is kept of it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import Any

import numpy as np

from mcdenoise.metrics import relmse_map
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.study.methods import METHODS, Parameters, bandwidths, feature_spreads
from mcdenoise.study.robust import bias_and_variance
from mcdenoise.study.stability_measures import outside
from mcdenoise.study.stability_scenes import Scene, like, plain
from mcdenoise.study.stability_settings import Settings

EPSILON = 0.01  # of relMSE
MESSAGE = 160  # characters kept of one
NO_ERRORS = {"relmse": None, "bias_squared": None, "variance": None}
Base = Callable[[Settings, int], SampleBuffer]
Measure = Callable[[np.ndarray, "np.ndarray | None", Scene], float]


@dataclass(frozen=True)
class Case:
    """One entry of the catalogue: one way in which methods fail.

    Attributes
    ----------
    title : for headings
    varied : what the levels are
    levels : their labels
    expected : what should happen, in words
    guarantee : what we promise, in words with the number; `unit` is what the number is, `bound` the number
    make : (settings, number of the level, seed) -> Scene
    measure : (filtered image, that of `base` or None, scene) -> the number that must not exceed `bound`
    base : (settings, seed) -> the buffer without the trouble, filtered too; None: not needed
    special : settings -> what `run_case` returns, for an entry that has no scenes
    """

    title: str
    varied: str
    levels: tuple[str, ...]
    expected: str
    guarantee: str
    unit: str
    bound: float
    make: Callable[[Settings, int, int], Scene] | None = None
    measure: Measure | None = None
    base: Base | None = None
    special: Callable[[Settings], list[dict[str, Any]]] | None = None


def dials(name: str, samples: SampleBuffer, settings: Settings) -> Parameters:
    """Return the moderate bandwidths that a method has in the whole catalogue: what is tested is the filter, not the search.

    They are candidates of `compare` that do well on the toy scenes at 8 spp.

    Examples
    --------
    >>> dials("gaussian", plain(Settings.quick(), 0).samples, Settings.quick())
    {'sigma_space': 0.7}
    """
    spreads = feature_spreads(samples)
    return {
        "gaussian": {"sigma_space": 0.7},
        "bilateral": {"sigma_space": 0.7, "sigma_radiance": 0.8},
        "cross_bilateral": {
            "sigma_space": 1.4,
            "sigma_radiance": 1.6,
            "sigma_features": bandwidths(spreads, 1.0, np.inf),
        },
        "cross_bilateral_prefiltered": {
            "sigma_space": 1.4,
            "sigma_radiance": 1.6,
            "sigma_features": bandwidths(spreads, 0.2, 0.4),
        },
        "nlm": {"search_radius": 3, "patch_radius": 3, "k": 0.6, "weight_radius": 1},
        "joint_nlm": {
            "search_radius": 5,
            "sigma_space": 2.0,
            "k": 0.8,
            "weight_radius": 1,
            "sigma_features": bandwidths(spreads, 0.3, 0.4),
        },
        "rpf_report": {"draws": settings.draws},
    }.get(name, {})


def run_method(name: str, samples: SampleBuffer, settings: Settings) -> np.ndarray:
    """Samples in, image out, with the dials of the catalogue."""
    return METHODS[name].run(samples, **dials(name, samples, settings))


@dataclass(frozen=True, eq=False)
class Run:
    """One method on one buffer: the image, its seconds, the number of the guarantee, and what went wrong (None: nothing)."""

    image: np.ndarray | None
    seconds: float
    value: float = np.inf
    failure: str | None = None


def timed(name: str, samples: SampleBuffer, settings: Settings) -> Run:
    """Run a method; a message or a warning in place of an image, or NaN in it, is what the catalogue looks for."""
    start = time.perf_counter()
    try:
        image = run_method(name, samples, settings)
    except (ValueError, ArithmeticError, RuntimeWarning) as error:
        return Run(None, time.perf_counter() - start, failure=f"{type(error).__name__}: {str(error)[:MESSAGE]}")
    seconds = time.perf_counter() - start
    bad = int(np.count_nonzero(~np.isfinite(image)))
    return Run(image, seconds, failure=f"{bad} of {image.size} values are NaN or infinite" if bad else None)


def run_case(case: Case, settings: Settings) -> dict[str, Any]:
    """Run an entry: ``{"levels": [{"level", "unfiltered", "methods": {name: numbers}}]}``.

    Numbers of a method: `value` (the worst over the seeds), `bound` and `held` of the guarantee; `relmse` with mean, spread
    (standard deviation) and worst; `bias_squared` and `variance` as shares of the truth, as relMSE is; `outside`, how
    far the image leaves the range of the unfiltered one; `failure`, the message in place of an image (None: there was none);
    `seconds` (the shortest run) and `times_normal`.
    """
    if case.special is not None:
        return {"levels": case.special(settings)}
    found: list[dict[str, list[Run]]] = [{} for _ in case.levels]
    scenes: list[list[Scene]] = [[] for _ in case.levels]
    for seed in range(settings.seeds):
        bases = _base_images(case.base, settings, seed) if case.base else {}
        for number in range(len(case.levels)):
            scene = case.make(settings, number, seed)
            scenes[number].append(scene)
            for name in METHODS:
                normal_seconds(name, layout_of(scene.samples), settings)
                run = timed(name, scene.samples, settings)
                if run.failure is None:
                    run = replace(run, value=float(case.measure(run.image, bases.get(name), scene)))
                found[number].setdefault(name, []).append(run)
    return {
        "levels": [
            level_numbers(case, label, own, runs, settings)
            for label, own, runs in zip(case.levels, scenes, found, strict=True)
        ]
    }


@lru_cache(maxsize=32)
def _base_images(base: Base, settings: Settings, seed: int) -> dict[str, np.ndarray]:
    """Every method on the buffer without the trouble."""
    samples = base(settings, seed)
    return {name: run_method(name, samples, settings) for name in METHODS}


def level_numbers(
    case: Case,
    label: str,
    scenes: Sequence[Scene],
    runs: Mapping[str, Sequence[Run]],
    settings: Settings,
) -> dict[str, Any]:
    """What is kept of one level."""
    truths = [scene.truth for scene in scenes]
    noisy = [pixel_mean(scene.samples.radiance) for scene in scenes]
    methods = {}
    for name, own in runs.items():
        seconds = min(run.seconds for run in own)
        normal = normal_seconds(name, layout_of(scenes[0].samples), settings)
        failures = [run.failure for run in own if run.failure]
        methods[name] = {
            **judged(max(run.value for run in own), case.bound),
            **(NO_ERRORS if failures else errors([run.image for run in own], truths)),
            "outside": None
            if failures
            else max(outside(run.image, None, one) for run, one in zip(own, scenes, strict=True)),
            "failure": failures[0] if failures else None,
            "seconds": seconds,
            "times_normal": seconds / normal,
        }
    return {"level": label, "unfiltered": errors(noisy, truths), "methods": methods}


def judged(value: float, bound: float) -> dict[str, Any]:
    """The number of a guarantee, its bound, and whether it held.

    Examples
    --------
    >>> judged(0.5, 1.0)
    {'value': 0.5, 'bound': 1.0, 'held': True}
    """
    return {"value": float(value), "bound": bound, "held": bool(value <= bound)}


def errors(images: Sequence[np.ndarray], truths: Sequence[np.ndarray]) -> dict[str, Any]:
    """relMSE over the seeds, and squared bias and variance in the same unit: their sum is the mean relMSE.

    Examples
    --------
    >>> one, truth = np.full((1, 1, 3), 1.1), np.ones((1, 1, 3))
    >>> found = errors([one, one], [truth, truth])
    >>> round(found["bias_squared"], 4), found["variance"]
    (0.0099, 0.0)
    """
    truths = [truth.astype(np.float64) for truth in truths]
    each = [float(relmse_map(image, truth).mean()) for image, truth in zip(images, truths, strict=True)]
    scaled = [
        (image.astype(np.float64) - truth) / np.sqrt(truth**2 + EPSILON)
        for image, truth in zip(images, truths, strict=True)
    ]
    bias, variance = bias_and_variance(np.stack(scaled), np.zeros(truths[0].shape))
    return {
        "relmse": {"mean": float(np.mean(each)), "spread": float(np.std(each, ddof=1)), "worst": max(each)},
        "bias_squared": float(bias.mean()),
        "variance": float(variance.mean()),
    }


Layout = tuple[int, int, int, tuple[str, ...], tuple[tuple[str, int], ...]]


def layout_of(samples: SampleBuffer) -> Layout:
    """What decides a method's normal time: size, spp, and the numbers that a sample carries."""
    features = tuple((one.name, one.channels) for one in samples.layout.features)
    return (samples.height, samples.width, samples.spp, samples.random_param_names, features)


@lru_cache(maxsize=512)
def normal_seconds(name: str, layout: Layout, settings: Settings) -> float:
    """The shortest of some runs on a plain buffer of the same layout, in this process."""
    height, width, spp, params, features = layout
    samples = like(_empty(height, width, spp, params, features))
    compiled(name, settings)
    return min(timed(name, samples, settings).seconds for _ in range(settings.normal_runs))


@cache
def compiled(name: str, settings: Settings) -> None:
    """Run a method once in this process, so that no measured time contains compiling or loading."""
    run_method(name, plain(settings, 0).samples, settings)


def _empty(
    height: int, width: int, spp: int, params: tuple[str, ...], features: tuple[tuple[str, int], ...]
) -> SampleBuffer:
    """A black buffer of a layout."""
    size = (height, width, spp)
    corner = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)[:, :, np.newaxis]
    return SampleBuffer.from_arrays(
        np.zeros((*size, 3)),
        np.repeat(corner + 0.5, spp, axis=2),
        {name: np.zeros(size) for name in params},
        {name: np.zeros((*size, channels)) for name, channels in features},
    )
