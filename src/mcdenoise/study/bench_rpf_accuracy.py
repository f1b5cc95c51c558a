"""How good is random parameter filtering? Every preset beside the best of the filters before it, and how many samples pay.

The filters before it are tuned with the reference, which nobody has in earnest; the presets of RPF are taken as they are.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from tqdm import tqdm

from mcdenoise.metrics import relmse
from mcdenoise.render import capture, render_reference
from mcdenoise.rpf import RPFConfig, rpf
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.bench_accuracy import UNFILTERED, Row, error_table, fill
from mcdenoise.study.bench_measure import reached
from mcdenoise.study.methods import METHODS, Method, report_config, report_multiples

RIVALS = ("gaussian", "bilateral", "cross_bilateral", "cross_bilateral_prefiltered")
ADAPTIVE = "RPF, adaptive (default)"
GEOMETRIC = "geom. mean"
GAIN, GAIN_SCENES = 0.25, ("dof", "motion", "soft_shadow")
SPP = (4, 8, 16)
KNEE_MULTIPLES = (0.25, 0.5, 1.0, 2.0, 4.0)  # of the default draws
SLACK = 1.05  # how much worse the quick draws may be than the published M


def preset_methods() -> list[Method]:
    """Return every preset of RPF as a method without dials, our own first.

    Examples
    --------
    >>> [method.label for method in preset_methods()][:2]
    ['RPF, adaptive (default)', 'RPF, lecture']
    """
    configs = {
        ADAPTIVE: RPFConfig.adaptive(),
        "RPF, lecture": RPFConfig.lecture(),
        "RPF, technical report": RPFConfig.technical_report(),
        "RPF, technical report, not noisy": RPFConfig.technical_report(noisy=False),
        "RPF, NVIDIA": RPFConfig.nvidia(),
        "RPF, authors' release": RPFConfig.authors_release(),
    }

    def run(config: RPFConfig) -> Callable[..., np.ndarray]:
        return lambda samples: rpf(samples, config, progress=False)

    prepare = METHODS["rpf"].prepare
    return [Method(label, label, 6, lambda _: [{}], prepare, run(config)) for label, config in configs.items()]


def preset_lines(scenes: Sequence[str], size: int, reference_spp: int) -> list[str]:
    """Measure presets and rivals on every scene at 4, 8 and 16 spp; return two tables and the verdicts."""
    by_spp = {}
    for spp in SPP:
        rivals = [METHODS[name] for name in RIVALS] if spp == 8 else []
        rows = [Row(UNFILTERED, None), *(Row(one.label, one) for one in (*rivals, *preset_methods()))]
        fill(rows, scenes, size, spp, reference_spp)
        by_spp[spp] = with_mean(rows, scenes)
    title = (
        f"relMSE x 1000, {size}x{size}, 8 spp, reference {reference_spp} spp; filters without RPF tuned with the "
        f"reference, RPF as its presets are"
    )
    lines = [title, *error_table(by_spp[8], [*scenes, GEOMETRIC]), *gain_verdicts(by_spp[8], scenes), ""]
    return [*lines, *spp_lines({spp: mean_errors(rows) for spp, rows in by_spp.items()}, size)]


def with_mean(rows: Sequence[Row], scenes: Sequence[str]) -> list[Row]:
    """Add the geometric mean over the scenes to each row.

    Examples
    --------
    >>> row, = with_mean([Row("filter", None, {"dof": 0.01, "motion": 0.04})], ["dof", "motion"])
    >>> round(row.errors["geom. mean"], 6)
    0.02
    """
    means = [geometric_mean([row.errors[scene] for scene in scenes]) for row in rows]
    return [Row(row.label, row.method, {**row.errors, GEOMETRIC: mean}) for row, mean in zip(rows, means, strict=True)]


def geometric_mean(values: Sequence[float]) -> float:
    """Return the geometric mean: halving the error counts the same in every scene.

    Examples
    --------
    >>> round(geometric_mean([1.0, 4.0]), 6)
    2.0
    """
    return float(np.exp(np.mean(np.log(values))))


def mean_errors(rows: Sequence[Row]) -> dict[str, float]:
    """Geometric mean of each row, by its label."""
    return {row.label: row.errors[GEOMETRIC] for row in rows}


def gain_verdicts(rows: Sequence[Row], scenes: Sequence[str]) -> list[str]:
    """Return what the default gains over the best Gaussian and the best bilateral filter, and whether that is enough."""
    errors = {row.label: row.errors for row in rows}
    lines = []
    for name in RIVALS[:2]:
        rival = METHODS[name].label
        gains = {scene: 1 - errors[ADAPTIVE][scene] / errors[rival][scene] for scene in scenes}
        asked = [gains[scene] for scene in GAIN_SCENES if scene in gains]
        words = ", ".join(f"{scene} {100 * gain:.0f} %" for scene, gain in gains.items())
        verdict = reached(min(asked) >= GAIN) if asked else "not judged without these scenes"
        lines.append(
            f"  target: default at least {100 * GAIN:.0f} % below the best {rival} on {', '.join(GAIN_SCENES)}: {verdict} "
            f"({words})"
        )
    return lines


def spp_lines(errors: Mapping[int, Mapping[str, float]], size: int) -> list[str]:
    """Return the geometric mean over the scenes of every preset at several spp, and whether the default beats them all."""
    labels = [label for label in errors[SPP[0]] if label.startswith("RPF") or label == UNFILTERED]
    rows = [Row(label, None, {f"{spp} spp": errors[spp][label] for spp in errors}) for label in labels]
    lines = [f"relMSE x 1000, {size}x{size}, geometric mean over the scenes"]
    lines += error_table(rows, [f"{spp} spp" for spp in errors])
    fixed = [label for label in labels if label not in (ADAPTIVE, UNFILTERED)]
    best = {spp: min(fixed, key=lambda label: errors[spp][label]) for spp in errors}
    ratios = {spp: errors[spp][ADAPTIVE] / errors[spp][best[spp]] for spp in errors}
    words = "; ".join(f"{spp} spp: {ratios[spp]:.2f} x that of {best[spp]}" for spp in errors)
    return [*lines, f"  target: the default beats every fixed preset: {reached(max(ratios.values()) < 1)} ({words})"]


def knee_lines(scenes: Sequence[str], size: int, reference_spp: int) -> list[str]:
    """Run the technical report's preset with more and more draws; return relMSE, seconds, and the verdict on the default."""
    multiples = report_multiples(KNEE_MULTIPLES)
    rows = [Row(f"{draws:.3g} x the default, {100 * share:.0f} % of M", None) for draws, share in multiples.items()]
    seconds = [[] for _ in rows]
    for scene in tqdm(scenes, desc="draws of RPF", unit="scene", disable=None, leave=False):
        samples = capture(scene, size, size, 8, seed=0)
        reference = render_reference(scene, size, size, spp=reference_spp, seed=0)
        for row, draws, taken in zip(rows, multiples, seconds, strict=True):
            row.errors[scene], cpu = _error_and_cpu(samples, report_config(draws), reference)
            taken.append(cpu)
    rows = with_mean(rows, scenes)
    title, head, *lines = (
        f"relMSE x 1000 of RPF, technical report, against the samples drawn, {size}x{size}, 8 spp",
        *error_table(rows, [*scenes, GEOMETRIC]),
    )
    costs = [1e3 * np.mean(taken) / size**2 for taken in seconds]
    lines = [f"{line}{cost:19.2f}" for line, cost in zip(lines, costs, strict=True)]
    errors = list(mean_errors(rows).values())
    return [title, f"{head}     CPU ms a pixel", *lines, knee_verdict(errors[list(multiples).index(1.0)], errors[-1])]


def knee_verdict(quick: float, whole: float) -> str:
    """Say whether the default draws are good enough.

    Examples
    --------
    >>> knee_verdict(0.0103, 0.01)
    '  target: default draws less than 5 % worse than the published M: +3.0 %, reached'
    """
    words = f"default draws less than {100 * (SLACK - 1):.0f} % worse than the published M"
    return f"  target: {words}: {100 * (quick / whole - 1):+.1f} %, {reached(quick < SLACK * whole)}"


def _error_and_cpu(samples: SampleBuffer, config: RPFConfig, reference: np.ndarray) -> tuple[float, float]:
    """relMSE, and CPU seconds."""
    start = time.process_time()
    image = rpf(samples, config, progress=False)
    return relmse(image, reference), time.process_time() - start
