"""How good is learning-based filtering? relMSE on scenes that it never saw, beside what global bandwidths and an oracle reach.

The oracle knows the reference and searches the bandwidths of every pixel: the same filter, with the same features and the
same theta of colour if the model keeps that fixed, cannot do better. How much of the way from the noisy image to it a model
goes is told in logarithms: halving the error counts the same anywhere.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from tqdm import tqdm

from mcdenoise.lbf import primary_features, shipped_model
from mcdenoise.lbf.layer import VARIANTS
from mcdenoise.lbf.oracle import oracle
from mcdenoise.metrics import relmse
from mcdenoise.render import capture, render_reference
from mcdenoise.render.scenes.cornell import SCENE as CORNELL
from mcdenoise.render.toyscene import ToyScene
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.study.bench_accuracy import UNFILTERED, Row, error_table
from mcdenoise.study.bench_measure import reached
from mcdenoise.study.bench_rpf_accuracy import GEOMETRIC, geometric_mean
from mcdenoise.study.methods import METHODS
from mcdenoise.study.peers import OIDN, find_oidn
from mcdenoise.study.tune import tune

STEPS = 40  # of the oracle
TUNED = ("cross_bilateral", "cross_bilateral_prefiltered")
RPF = METHODS["rpf"].label
WAY = 0.6  # target: share of the way to the oracle
LBF = {"cross_bilateral": METHODS["lbf"].label, "nlm": METHODS["lbf_nlm"].label}
ORACLE = {variant: f"oracle of {label}" for variant, label in LBF.items()}
Errors = dict[str, dict[str, float]]  # label -> scene -> relMSE
Way = Callable[[SampleBuffer, np.ndarray], float]  # samples and reference -> relMSE


def oracle_error(variant: str, samples: SampleBuffer, reference: np.ndarray, steps: int) -> float:
    """relMSE of the best bandwidths of every pixel, for the filter of the model that comes with the package."""
    model = shipped_model(variant)
    layer = model.layer(primary_features(samples))
    found = oracle(layer, reference, colour_theta=model.colour_theta, steps=steps)
    return relmse(found.image, reference)


def ways(steps: int) -> dict[str, Way | None]:
    """Label -> how its relMSE comes about; None for a peer that is not installed.

    Examples
    --------
    >>> list(ways(1))[:2]
    ['unfiltered', 'cross-bilateral']
    """
    oidn = find_oidn()

    def tuned(name: str) -> Way:
        return lambda samples, reference: tune(METHODS[name], samples, reference).error

    def plain(run: Callable[[SampleBuffer], np.ndarray]) -> Way:
        return lambda samples, reference: relmse(run(samples), reference)

    def best(variant: str) -> Way:
        return lambda samples, reference: oracle_error(variant, samples, reference, steps)

    found: dict[str, Way | None] = {UNFILTERED: plain(lambda samples: pixel_mean(samples.radiance))}
    found |= {METHODS[name].label: tuned(name) for name in TUNED}
    found |= {METHODS[name].label: plain(METHODS[name].run) for name in ("rpf", "lbf", "lbf_nlm")}
    found |= {ORACLE[v]: best(v) for v in VARIANTS}
    return {**found, OIDN: oidn and plain(oidn)}


def measure_errors(scenes: Sequence[str | ToyScene], size: int, spp: int, reference_spp: int, steps: int) -> Errors:
    """relMSE of everybody on every scene; {} for a peer that is not installed."""
    asked = ways(steps)
    errors: Errors = {label: {} for label in asked}
    bar = tqdm(total=len(scenes) * len(asked), desc=f"LBF, {spp} spp", unit="method", disable=None, leave=False)
    with bar:
        for scene in scenes:
            name = scene.name if isinstance(scene, ToyScene) else scene
            samples = capture(scene, size, size, spp, seed=0)
            reference = render_reference(scene, size, size, spp=reference_spp, seed=0)
            for label, way in asked.items():
                bar.set_postfix_str(f"{name}, {label}")
                if way:
                    errors[label][name] = way(samples, reference)
                bar.update()
    return errors


def accuracy_of_lbf(
    scenes: Sequence[str], size: int, reference_spp: int, *, spps: Sequence[int], steps: int
) -> dict[int, Errors]:
    """Spp -> errors, of the toy scenes and of the scene from outside."""
    return {spp: measure_errors([*scenes, CORNELL], size, spp, reference_spp, steps) for spp in spps}


def share_of_way(unfiltered: float, filtered: float, best: float) -> float:
    """Share of the way from the noisy image to the best, in logarithms: 0 where nothing is gained, 1 at the best.

    Examples
    --------
    >>> round(share_of_way(0.16, 0.04, 0.01), 6)
    0.5
    """
    return float(np.log(unfiltered / filtered) / np.log(unfiltered / best))


def with_mean(errors: Errors, scenes: Sequence[str]) -> Errors:
    """Add the geometric mean over `scenes` to each label that has errors.

    Examples
    --------
    >>> round(with_mean({"a": {"dof": 0.01, "motion": 0.04}, "b": {}}, ["dof", "motion"])["a"]["geom. mean"], 6)
    0.02
    """
    means = {label: geometric_mean([of[scene] for scene in scenes]) for label, of in errors.items() if of}
    return {label: of | ({GEOMETRIC: means[label]} if of else {}) for label, of in errors.items()}


def accuracy_lines(found: Mapping[int, Errors], scenes: Sequence[str], size: int, reference_spp: int) -> list[str]:
    """Tables of errors and shares at each spp, then the verdicts; the mean is over the toy scenes alone."""
    lines, full = [], {spp: with_mean(errors, scenes) for spp, errors in found.items()}
    columns = [*scenes, GEOMETRIC, CORNELL.name]
    for spp, errors in full.items():
        lines.append(
            f"relMSE x 1000, {size}x{size}, {spp} spp, reference {reference_spp} spp; global bandwidths and the oracle "
            f"know the reference, nobody else does; the mean leaves {CORNELL.name} out"
        )
        lines += error_table([Row(label, None, of) for label, of in errors.items()], columns)
        lines += [share_line(errors, variant, columns) for variant in VARIANTS]
        lines.append("")
    for variant in VARIANTS:
        lines += verdict_lines(full, variant, scenes)
    return lines


def share_line(errors: Errors, variant: str, columns: Sequence[str]) -> str:
    """How much of the way to its oracle a variant goes, in percent."""
    shares = (
        share_of_way(*(errors[label][name] for label in (UNFILTERED, LBF[variant], ORACLE[variant])))
        for name in columns
    )
    label = f"way to the {ORACLE[variant]}, %"
    return f"  {label:36s}" + "".join(f"{100 * share:13.0f}" for share in shares)


def verdict_lines(found: Mapping[int, Errors], variant: str, scenes: Sequence[str]) -> list[str]:
    """Targets of one variant beside what was reached, at each spp."""
    ours, lines = LBF[variant], []
    for spp, errors in found.items():
        rivals = {
            "the best global bandwidths, on every scene": _best_tuned(errors, scenes),
            f"{RPF}, on average": {GEOMETRIC: errors[RPF][GEOMETRIC]},
            "the noisy image, on a scene from outside": {CORNELL.name: errors[UNFILTERED][CORNELL.name]},
        }
        for words, rival in rivals.items():
            times = {name: errors[ours][name] / error for name, error in rival.items()}
            parts = ", ".join(f"{name} {ratio:.2f}" for name, ratio in times.items())
            verdict = reached(max(times.values()) < 1)
            lines.append(f"  target: {ours}, {spp} spp, better than {words}: {verdict} ({parts} x its relMSE)")
        share = share_of_way(*(errors[label][GEOMETRIC] for label in (UNFILTERED, ours, ORACLE[variant])))
        words = f"{100 * WAY:.0f} % of the way to its oracle"
        lines.append(f"  target: {ours}, {spp} spp, {words}: {100 * share:.0f} %, {reached(share >= WAY)}")
        if errors[OIDN]:
            times = errors[ours][GEOMETRIC] / errors[OIDN][GEOMETRIC]
            lines.append(f"  far target: {ours}, {spp} spp, {times:.2f} x the relMSE of {OIDN}")
    return lines


def _best_tuned(errors: Errors, scenes: Sequence[str]) -> dict[str, float]:
    """For each scene the smaller error of the two filters with global bandwidths."""
    return {scene: min(errors[METHODS[name].label][scene] for name in TUNED) for scene in scenes}
