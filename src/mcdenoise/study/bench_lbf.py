"""What does learning-based filtering cost? Its parts, forward against backward, and what bandwidths of every pixel cost.

The bandwidths are those that the model predicts for a toy scene: the kernel leaves out rows of the window whose weights are
all 0, so random ones would tell another time.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from mcdenoise.filters import cross_bilateral
from mcdenoise.lbf import FilterLayer, LBFModel, Primary, lbf, primary_features, shipped_model
from mcdenoise.lbf.layer import RADIUS, VARIANTS
from mcdenoise.lbf.primary import GROUPS
from mcdenoise.render import capture
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.bench_lbf_accuracy import find_oidn
from mcdenoise.study.bench_measure import Contestant, Target, Work, measure, reached, table

SCENE, SIZE, SPP = "dof", 256, 8  # the targets are stated for this size, spp, and the usual radius
SECONDS, TIMES = 1.5, 3.0  # targets: all of it; forward and backward over forward
REST = 0.1  # seconds before each run, see `measure`
WHOLE, OIDN = "mcd.lbf", "Intel OIDN, colour, albedo and normal"
PRIMARY, INPUTS, NETWORK = "primary features", "secondary features, normalised", "network"
FORWARD, BACKWARD, GLOBAL = "filter, forward", "filter, backward", "mcdenoise.cross_bilateral"
PARTS = (PRIMARY, INPUTS, NETWORK, FORWARD)


def compile_lbf() -> float:
    """Run both variants once on a tiny image, forward and backward; return the seconds that took.

    Examples
    --------
    >>> compile_lbf() > 0
    True
    """
    start = time.perf_counter()
    corner = np.stack(np.meshgrid(np.arange(4), np.arange(4)), axis=-1)[:, :, np.newaxis] + 0.5
    noise = np.random.default_rng(0).random((4, 4, 2, 3))
    samples = SampleBuffer.from_arrays(noise, np.repeat(corner, 2, axis=2), features={"albedo": noise})
    for variant in VARIANTS:
        model = LBFModel.random(["albedo"], hidden=[2], rng=np.random.default_rng(0), variant=variant, radius=1)
        for contestant in contestants(model, samples):
            contestant.run()
    return time.perf_counter() - start


def lbf_works(size: int, spp: int, radius: int) -> list[Work]:
    """Both variants of the filter with the models of the package, on a scene captured with all groups of features.

    Raises
    ------
    ValueError
        For a size, spp or radius that cannot be captured or filtered.
    """
    samples = capture(SCENE, size, size, spp, seed=0, features=GROUPS)
    judged = (size, spp, radius) == (SIZE, SPP, RADIUS)
    targets, side = (Target(WHOLE, seconds=SECONDS),) if judged else (), 2 * radius + 1
    works = []
    for variant in VARIANTS:
        model = replace(shipped_model(variant), radius=radius)
        title = f"LBF, {variant}, {SCENE}, {size}x{size}, {spp} spp, window {side}x{side}, {len(model.groups)} groups"
        works.append(Work(title, [*contestants(model, samples), *peers(model, samples)], targets=targets))
    return works


def contestants(model: LBFModel, samples: SampleBuffer) -> list[Contestant]:
    """All of it, then its parts; the last two on a layer that is kept, as in training."""
    primary, theta, layer = _prepared(model, samples)
    inputs = model.inputs(primary).reshape(-1, model.network.inputs)
    filtered, saved = layer.forward(theta)
    pull = np.random.default_rng(0).normal(size=filtered.shape).astype(np.float32)
    groups = len(model.groups)
    return [
        Contestant(WHOLE, lambda: lbf(samples, model), "samples in, image out"),
        Contestant(PRIMARY, lambda: primary_features(samples), f"means, variances, NL-means of {groups} groups"),
        Contestant(INPUTS, lambda: model.inputs(primary), f"{model.network.inputs} numbers a pixel"),
        Contestant(NETWORK, lambda: model.network.forward(inputs), f"{model.network.size} parameters"),
        Contestant(FORWARD, lambda: layer.forward(theta), f"theta of {len(layer.names)} distances a pixel"),
        Contestant(BACKWARD, lambda: layer.backward(pull, saved), "the gradient of every theta; training only"),
    ]


def peers(model: LBFModel, samples: SampleBuffer) -> list[Contestant]:
    """The cross-bilateral filter of chapter 04 with one setting for all pixels and the same window; Intel's denoiser."""
    primary, theta, _ = _prepared(model, samples)
    image, oidn = primary.colour, find_oidn()
    sigma_space = float(1 / np.sqrt(2 * max(np.median(theta[..., 0]), 1e-6)))
    variances = {**primary.variances, "radiance": primary.colour_variance}
    dials = {"sigma_space": sigma_space, "sigma_radiance": 0.5, "sigma_features": dict.fromkeys(primary.groups, 0.5)}

    def run() -> np.ndarray:
        return cross_bilateral(image, primary.features, **dials, variances=variances, radius=model.radius)

    return [
        Contestant(GLOBAL, run, "one setting for all pixels: a weight serves two pixels"),
        Contestant(OIDN, oidn and (lambda: oidn(samples)), "its network has about a million weights"),
    ]


def _prepared(model: LBFModel, samples: SampleBuffer) -> tuple[Primary, np.ndarray, FilterLayer]:
    """Features, theta and the filter of a model."""
    primary = model.known(primary_features(samples))
    return primary, model.theta(primary), model.layer(primary)


def lbf_lines(works: Sequence[Work], repeats: int, *, judged: bool) -> list[str]:
    """Tables of what was measured, with shares and ratios; ratios have verdicts where `judged`."""
    lines = []
    for work in works:
        lines += [*table(work, repeats), *ratio_lines(seconds_of(work), judged=judged), ""]
    return lines[:-1]


def measure_lbf(works: list[Work], repeats: int) -> None:
    """Run all contestants in turns."""
    measure(works, repeats, "LBF", rest=REST)


def seconds_of(work: Work) -> dict[str, float]:
    """Name -> median seconds of all contestants that ran.

    Examples
    --------
    >>> seconds_of(Work("w", [Contestant("a", print, seconds=[0.2, 0.1, 0.4]), Contestant("b", None)]))
    {'a': 0.2}
    """
    return {one.name: one.median() for one in work.contestants if one.run}


def ratios(seconds: Mapping[str, float]) -> dict[str, float]:
    """What one reads off the seconds: backward and both passes over forward, and bandwidths a pixel over global ones.

    Examples
    --------
    >>> found = ratios({FORWARD: 0.2, BACKWARD: 0.3, GLOBAL: 0.1})
    >>> {name: round(value, 2) for name, value in found.items()}
    {'backward / forward': 1.5, 'forward and backward / forward': 2.5, 'forward / global bandwidths': 2.0}
    """
    forward = seconds[FORWARD]
    return {
        "backward / forward": seconds[BACKWARD] / forward,
        "forward and backward / forward": (forward + seconds[BACKWARD]) / forward,
        "forward / global bandwidths": forward / seconds[GLOBAL],
    }


def ratio_lines(seconds: Mapping[str, float], *, judged: bool) -> list[str]:
    """Shares of the parts in the whole, then the ratios; the one with a target says so where `judged`."""
    whole, found = seconds[WHOLE], ratios(seconds)
    shares = {name: seconds[name] / whole for name in PARTS}
    shares["the rest"] = 1 - sum(shares.values())
    both = found["forward and backward / forward"]
    verdict = f"; target under {TIMES:g} x: {reached(both < TIMES)}" if judged else ""
    return [
        "  shares: " + ", ".join(f"{name} {100 * share:.0f} %" for name, share in shares.items()),
        f"  forward and backward: {both:.2f} x forward{verdict}",
        f"  bandwidths of every pixel: {found['forward / global bandwidths']:.2f} x the filter with global ones",
    ]


def lbf_numbers(works: Sequence[Work], **about: object) -> dict[str, object]:
    """Everything measured, by variant, as JSON can hold it."""
    found = {variant: seconds_of(work) for variant, work in zip(VARIANTS, works, strict=True)}
    return {**about, "seconds": found, "ratios": {variant: ratios(seconds) for variant, seconds in found.items()}}
