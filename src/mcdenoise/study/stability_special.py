"""Entries of the catalogue that have no scenes: bandwidths at their ends, float32 against float64, 1 against 2 threads."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from mcdenoise.filters import gaussian, noise_variance, prefilter_features
from mcdenoise.lbf import lbf
from mcdenoise.lbf.layer import FilterLayer
from mcdenoise.lbf.primary import primary_features
from mcdenoise.rpf import RPFConfig, rpf
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.methods import METHODS, Parameters, report_config
from mcdenoise.study.stability_run import dials, judged
from mcdenoise.study.stability_scenes import build, places, room
from mcdenoise.study.stability_settings import Settings

BANDWIDTHS = ("0", "infinity")
ENGINES = ("room", "8 decades")
THREADS = ("room", "8 decades")
SMALL, SMALL_SPP = 10, 2
LIMIT_TOLERANCE, ENGINE_TOLERANCE = 1e-4, 1e-3
SIGMA_SPACE = 1.4


def small_room(decades: float, size: int = SMALL) -> SampleBuffer:
    """A room of a few pixels, from left to right brighter by so many decades."""
    truth, features = room(size, size)
    across = 10.0 ** (decades * (places(size, size)[0] - 0.5))[..., np.newaxis]
    return build(truth * across, features, SMALL_SPP, seed=0)


def bandwidth_limits(settings: Settings) -> list[dict[str, Any]]:
    """Every bandwidth at 0, which must be refused, and at infinity, where the filter before must come out."""
    samples = small_room(0)
    refused = {name: float(_accepted_at_zero(name, samples, settings)) for name in METHODS}
    limits = {name: _off_limit(name, samples, settings) for name in METHODS}
    return [_level(label, found, LIMIT_TOLERANCE) for label, found in zip(BANDWIDTHS, (refused, limits), strict=True)]


def engines(settings: Settings) -> list[dict[str, Any]]:
    """The largest difference of the two engines of every method, as a share of the brightest pixel."""
    levels = []
    for label, decades in zip(ENGINES, (0, 8), strict=True):
        samples = small_room(decades, min(settings.size // 6, 8))  # the NumPy engine of RPF goes pixel by pixel
        found = {}
        for name in METHODS:
            fast, slow = (_by_engine(name, samples, settings, engine) for engine in ("numba", "numpy"))
            found[name] = _difference(fast, slow)
        levels.append(_level(label, found, ENGINE_TOLERANCE))
    return levels


def threads(settings: Settings) -> list[dict[str, Any]]:
    """How many numbers of every method's image differ between 1 and 2 threads: each runs in a process of its own."""
    with TemporaryDirectory() as folder:
        paths = [Path(folder) / f"{count}.npz" for count in (1, 2)]
        children = [
            subprocess.Popen(
                [
                    sys.executable,
                    "-m",
                    "mcdenoise.study.stability_threads",
                    str(path),
                    str(settings.size),
                    str(settings.draws),
                ],
                env={**os.environ, "NUMBA_NUM_THREADS": str(count)},
            )
            for count, path in enumerate(paths, 1)
        ]
        codes = [child.wait() for child in children]
        if any(codes):
            raise RuntimeError(
                "A process that was to run every method with 1 or 2 threads failed; it says why on stderr."
            )
        one, two = (dict(np.load(path)) for path in paths)
    return [
        _level(label, {name: _differing(one[f"{name} {label}"], two[f"{name} {label}"]) for name in METHODS}, 0.0)
        for label in THREADS
    ]


def _level(label: str, values: dict[str, float], bound: float) -> dict[str, Any]:
    """One level without scenes."""
    return {"level": label, "methods": {name: judged(value, bound) for name, value in values.items()}}


def _differing(one: np.ndarray, two: np.ndarray) -> float:
    """How many numbers differ in any bit."""
    return float(np.count_nonzero(one.view(np.uint32) != two.view(np.uint32)))


def _difference(image: np.ndarray, other: np.ndarray) -> float:
    """The largest, as a share of the brightest pixel."""
    return float(np.abs(image.astype(np.float64) - other).max() / np.abs(other).max())


def _by_engine(name: str, samples: SampleBuffer, settings: Settings, engine: str) -> np.ndarray:
    """One method by one engine, with everything that it prepares."""
    if name.startswith("rpf"):
        return rpf(samples, _config(name, settings), engine=engine, progress=False)
    if name.startswith("lbf"):
        return lbf(samples, variant=_variant(name), engine=engine)
    method = METHODS[name]
    prepared = method.prepare(samples)
    if "variances" in prepared:
        features, variances = prefilter_features(samples, list(prepared["features"]), engine=engine)
        prepared |= {"features": features, "variances": variances}
    if prepared.get("albedo") is not None:
        prepared["albedo"] = features["albedo"]
    if "variance" in prepared:
        prepared["variance"] = noise_variance(samples.radiance, engine=engine)
    return method.apply(prepared, **dials(name, samples, settings), engine=engine)


def _config(name: str, settings: Settings, **changes: Any) -> RPFConfig:
    """The configuration of one of the two RPFs, with changes."""
    if name == "rpf":
        return RPFConfig.adaptive(**changes)
    shares = report_config(settings.draws).sample_fraction
    return RPFConfig.technical_report(sample_fraction=shares, **changes)


def _variant(name: str) -> str:
    """What LBF compares."""
    return "nlm" if name == "lbf_nlm" else "cross_bilateral"


def _accepted_at_zero(name: str, samples: SampleBuffer, settings: Settings) -> int:
    """How many bandwidths of 0 were not refused in words."""
    if name.startswith("rpf"):
        return not _is_refused(lambda: _config(name, settings, sigma_8_squared=0.0), "sigma_8_squared")
    if name.startswith("lbf"):  # theta = 1 / (2 sigma^2)
        layer = FilterLayer(primary_features(samples), variant=_variant(name))
        return not _is_refused(lambda: layer.forward(np.full(layer.shape, np.inf)), "theta")
    usual, method = dials(name, samples, settings), METHODS[name]
    zeros = {dial: _all_at(usual, 0.0, dial) for dial in _bandwidth_names(usual)}
    prepared = method.prepare(samples)
    return sum(
        not _is_refused(lambda zero=zero: method.apply(prepared, **zero), dial.removesuffix("s"))
        for dial, zero in zeros.items()
    )


def _is_refused(call: Callable[[], object], word: str) -> bool:
    """Whether a call ends in a message with this word."""
    try:
        call()
    except ValueError as error:
        return word in str(error)
    return False


def _bandwidth_names(parameters: Parameters) -> list[str]:
    """The dials that are bandwidths."""
    return [name for name in parameters if name.startswith("sigma") or name == "k"]


def _all_at(parameters: Parameters, value: float, *names: str) -> dict[str, Any]:
    """A copy with these dials at a value."""
    changed = dict(parameters)
    for name in names:
        changed[name] = dict.fromkeys(parameters[name], value) if name == "sigma_features" else value
    return changed


def _off_limit(name: str, samples: SampleBuffer, settings: Settings) -> float:
    """How far a method with infinite bandwidths is from its limit: Gaussian, mean of the window, or RPF without weights."""
    if name.startswith("rpf"):
        configs = (_config(name, settings, sigma_8_squared=np.inf), _config(name, settings, alpha=0.0, beta=0.0))
        return _difference(*(rpf(samples, config, progress=False) for config in configs))
    image = METHODS["gaussian"].prepare(samples)["image"]
    if name.startswith("lbf"):
        layer = FilterLayer(primary_features(samples), variant=_variant(name), radius=math.ceil(3 * SIGMA_SPACE))
        theta = np.zeros(layer.shape)
        theta[..., 0] = 1 / (2 * SIGMA_SPACE**2)
        return _difference(layer.forward(theta)[0], gaussian(image, sigma_space=SIGMA_SPACE))
    usual = dials(name, samples, settings)
    infinite = _all_at(usual, np.inf, *(dial for dial in _bandwidth_names(usual) if dial != "sigma_space"))
    prepared = METHODS[name].prepare(samples)
    if "albedo" in prepared:
        prepared["albedo"] = None
    if name == "gaussian":
        return _difference(gaussian(image, sigma_space=np.inf, radius=3), window_mean(image, 3))
    if name in ("nlm", "joint_nlm"):
        flat_space = {"sigma_space": np.inf} if "sigma_space" in usual else {}
        return _difference(
            METHODS[name].apply(prepared, **infinite | flat_space), window_mean(image, usual["search_radius"])
        )
    return _difference(METHODS[name].apply(prepared, **infinite), gaussian(image, sigma_space=usual["sigma_space"]))


def window_mean(image: np.ndarray, radius: int) -> np.ndarray:
    """Mean of the square window, clipped at the borders, as it reads.

    Examples
    --------
    >>> window_mean(np.array([[[1.0], [2.0], [6.0]]]), radius=1)[..., 0]
    array([[1.5, 3. , 4. ]])
    """
    mean = np.empty(image.shape)
    for y, x in np.ndindex(*image.shape[:2]):
        mean[y, x] = image[max(y - radius, 0) : y + radius + 1, max(x - radius, 0) : x + radius + 1].mean(axis=(0, 1))
    return mean
