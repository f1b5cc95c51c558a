"""No more than a scene needs: is the advice that samples give about themselves the one that a reference would give?

    mcdenoise study parsimony [--quick] [--out DIR]

For each toy scene and spp: the advice (`advise`), the choice of method by the same rule with a reference, what following the
advice costs, the layouts that samples of other seeds ask for, and the error of the advised layout between seeds. Random numbers
that a scene does not use are added as decoys: the test must not find anything in them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from mcdenoise.metrics import relmse, relmse_map
from mcdenoise.render import capture, render_reference
from mcdenoise.samples import SampleBuffer, pixel_mean, variance_of_mean
from mcdenoise.samples.gate import check_count, check_names
from mcdenoise.study.advise import Advice, Trial, advise, drop_features
from mcdenoise.study.choice import mean_and_error, simplest_like_best, tile_means
from mcdenoise.study.entries import run_entries
from mcdenoise.study.information import information
from mcdenoise.study.left_out import LeftOut
from mcdenoise.study.methods import METHODS, Method
from mcdenoise.study.parsimony_results import charts, lines
from mcdenoise.study.tune import error_scale, reference_error

__all__ = ["NAME", "Settings", "charts", "entries", "lines", "study"]

NAME = "parsimony"
SCENES = ("dof", "pinhole", "soft_shadow", "glossy", "motion")
DECOYS = ("lens_u", "lens_v", "time")


@dataclass(frozen=True)
class Settings:
    """How the study is done.

    Attributes
    ----------
    scenes, spp : every pair is an entry
    size : height and width, pixels
    seeds : the first gives the advice; layouts are compared between all of them, two at least
    reference_spp : of the reference
    variant : of Mitsuba, see `mcd.capture`

    Examples
    --------
    >>> Settings(scenes=("dof",), spp=(1,))
    Traceback (most recent call last):
    ValueError: each spp must be at least 2, got 1.
    """

    scenes: Sequence[str] = SCENES
    spp: Sequence[int] = (8, 16)
    size: int = 128
    seeds: Sequence[int] = (100, 101, 102)
    reference_spp: int = 1024
    variant: str = "auto"

    def __post_init__(self) -> None:
        """Check every number."""
        check_names(self.scenes, SCENES, "scenes")
        check_count(self.size, "size", least=16)
        for spp in self.spp:
            check_count(spp, "each spp", least=2)
        if len(self.seeds) < 2:
            raise ValueError(f"seeds must be two or more, to compare layouts between them, got {len(self.seeds)}.")

    @classmethod
    def quick(cls) -> Settings:
        """Small, for tests: with a variant that gives the same numbers on every machine."""
        few = {"scenes": ("pinhole", "soft_shadow"), "spp": (8,), "size": 32, "seeds": (100, 101)}
        return cls(**few, reference_spp=256, variant="scalar_rgb")


def study(settings: Settings, path: Path, *, progress: bool | None = None) -> dict[str, Any]:
    """Run what is not yet in the JSON file `path`, as `run_entries`."""
    return run_entries(path, NAME, asdict(settings), entries(settings), progress=progress)


def entries(settings: Settings) -> dict[str, Callable[[], dict[str, Any]]]:
    """Name -> what runs it: one entry a scene and spp."""
    return {
        f"{scene}, {spp} spp": partial(_entry, scene, spp, settings)
        for scene in settings.scenes
        for spp in settings.spp
    }


@lru_cache(maxsize=4)
def _captured(scene: str, size: int, spp: int, seed: int, variant: str) -> SampleBuffer:
    """Samples of a toy scene."""
    return capture(scene, size, size, spp, seed=seed, variant=variant)


def _entry(scene: str, spp: int, settings: Settings) -> dict[str, Any]:
    """All about one scene at one spp."""
    size, most, variant = settings.size, max(settings.spp), settings.variant
    buffers = [_captured(scene, size, most, seed, variant).subset(0, spp) for seed in settings.seeds]
    samples = buffers[0]
    reference = render_reference(scene, size, size, spp=settings.reference_spp, seed=0, variant=variant)
    advice = advise(samples, progress=False)
    found = by_reference(advice, samples, reference)
    images = {one.name: METHODS[one.name].run(samples, **one.parameters) for one in advice.methods}
    errors = {name: relmse(image, reference) for name, image in images.items()}
    return {
        "scene": scene,
        "spp": spp,
        "unfiltered": relmse(pixel_mean(samples.radiance), reference),
        "advice": advice.numbers(),
        "reference": found,
        "agree": advice.method == found["method"],
        "relmse": errors,
        "decoys": decoys(samples, seed=spp + 1000 * SCENES.index(scene)),
        "other_seeds": [_layout_of(other, advice) for other in buffers[1:]],
        "between_seeds": between_seeds(advice, buffers),
    }


def by_reference(advice: Advice, samples: SampleBuffer, reference: np.ndarray) -> dict[str, Any]:
    """Choose by the rule of `advise`, but bandwidths and errors by the reference.

    Times, and the order of simplicity, are those of the advice.
    """
    tiles, errors = [], []
    for trial in advice.methods:
        method = METHODS[trial.name]
        best = min(method.candidates(samples), key=reference_error(method, samples, reference))
        errors.append(relmse_map(method.run(samples, **best), reference).mean(axis=-1))
        tiles.append(tile_means(errors[-1]))
    choice = simplest_like_best(np.array(tiles), [one.seconds for one in advice.methods])
    methods = [
        {"name": one.name, "error": float(error.mean()), "behind": behind, "standard_error": spread}
        for one, error, behind, spread in zip(advice.methods, errors, choice.behind, choice.standard_error, strict=True)
    ]
    names = [one.name for one in advice.methods]
    return {"method": names[choice.chosen], "best": names[choice.best], "methods": methods}


def decoys(samples: SampleBuffer, seed: int = 0) -> dict[str, dict[str, float]]:
    """Test random numbers that have nothing to do with the scene, under names of parameters that it lacks.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(16), np.arange(16)), axis=-1)[:, :, np.newaxis]
    >>> position, light = corner + rng.random((16, 16, 4, 2)), rng.random((16, 16, 4))
    >>> samples = SampleBuffer.from_arrays(rng.random((16, 16, 4, 3)), position, {"lens_u": light, "lens_v": light})
    >>> list(decoys(samples))
    ['time']
    """
    rng = np.random.default_rng(seed)
    params = {name: samples[name] for name in samples.random_param_names}
    added = {name: rng.random(samples.hit.shape, np.float32) for name in DECOYS if name not in params}
    joined = SampleBuffer.from_arrays(samples.radiance, samples.screen_position, {**params, **added})
    tested = information(joined)
    return {one.name: {"nats": one.nats, "p_value": one.p_value} for one in tested if one.name in added}


def _layout_of(samples: SampleBuffer, advice: Advice) -> dict[str, list[str]]:
    """The layout that samples of another seed ask for, with the filter and the bandwidths of the advice."""
    informative = [one.name for one in information(samples.select(features=[])) if one.informative]
    whole = _feature_trial(advice)
    kept = drop_features(whole, LeftOut.of(samples)) if whole else ()
    return {"random_params": informative, "features": [one.name for one in kept if one.keep]}


def _feature_trial(advice: Advice) -> Trial | None:
    """The trial of the filter that features are judged with."""
    return next((one for one in advice.methods if one.name == advice.feature_filter), None)


def between_seeds(advice: Advice, buffers: Sequence[SampleBuffer]) -> dict[str, Any] | None:
    """Filter the samples of each seed with all features, those kept, and none; judge by the mean of the other seeds.

    Those samples had no part in the choice of the layout, except the first seed's, nor in the filtering.
    """
    trial = _feature_trial(advice)
    if trial is None:
        return None
    method, judge = METHODS[trial.name], _judge(buffers)
    layouts = {"all": list(buffers[0].feature_names), "kept": list(advice.layout["features"]), "none": []}
    tiles = {
        name: tile_means(judge.error_map(_filtered(method, trial, buffers, kept))) for name, kept in layouts.items()
    }
    noise = float(tile_means(judge.noise).mean())
    result = {"filter": trial.name}
    for name, values in tiles.items():
        behind, spread = mean_and_error(values - tiles["all"])
        result[name] = {"error": values.mean() - noise, "behind": behind, "standard_error": spread}
    return result


def _filtered(method: Method, trial: Trial, buffers: Sequence[SampleBuffer], names: Sequence[str]) -> list[np.ndarray]:
    """Filter each buffer with some of its features."""
    return [method.run(one.select(features=names), **trial.parameters) for one in buffers]


def _judge(buffers: Sequence[SampleBuffer]) -> LeftOut:
    """Buffers of several seeds in place of parts: each is judged by the mean of all others."""
    means = [pixel_mean(one.radiance) for one in buffers]
    variances = [variance_of_mean(one.radiance) for one in buffers]
    others = [[k for k in range(len(buffers)) if k != own] for own in range(len(buffers))]
    scales = [error_scale(mean) for mean in means]
    judged_by = tuple(np.mean([means[k] for k in rest], axis=0) for rest in others)
    noises = [sum(variances[k] for k in rest) / len(rest) ** 2 for rest in others]
    noise = np.mean([(one / scale).mean(axis=-1) for one, scale in zip(noises, scales, strict=True)], axis=0)
    return LeftOut(tuple(buffers), judged_by, tuple(scales), noise)
