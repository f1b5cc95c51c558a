"""What does random parameter filtering cost? Time a pass and a pixel, how it grows, memory, and the counting of bits.

Others use the machine too, so each time comes twice: on the clock, and as the CPU seconds of all threads together, which
hardly depend on the others. Compiling, or loading what was compiled before, is done first and printed apart.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from tqdm import tqdm

from mcdenoise.render import capture
from mcdenoise.rpf import RPFConfig, rpf
from mcdenoise.rpf.config import PUBLISHED
from mcdenoise.rpf.passes import prepare, run_kernel
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.study.bench_measure import Contestant, Work, measure, reached
from mcdenoise.study.bench_scaling import Series, law
from mcdenoise.study.machine import usable_cores

SCENE, SPP, SIDES = "dof", 8, (128, 256)
ENOUGH_SECONDS = 10.0  # a run that takes longer is not repeated
FEATURES = ("world_position", "shading_normal", "albedo")
GROWTH_SPP, GROWTH_FRACTIONS, GROWTH_SIDES, GROWTH_BOX = (4, 8, 16), (0.02, 0.1, 0.5), (64, 128, 256), (55,)
ADAPTIVE, QUICK, WHOLE = "adaptive (default)", "technical report, quick", "technical report, published M"


@dataclass
class Timed:
    """One configuration on one buffer: seconds of preparing and of each pass, of several runs.

    Attributes
    ----------
    label, config, samples : what is timed
    wall, cpu : a list a run, of seconds: what is done before the passes, then each pass
    """

    label: str
    config: RPFConfig
    samples: SampleBuffer
    wall: list[list[float]] = field(default_factory=list)
    cpu: list[list[float]] = field(default_factory=list)

    @property
    def pixels(self) -> int:
        """How many there are."""
        return self.samples.height * self.samples.width

    def seconds(self) -> float:
        """Median over the runs, on the clock."""
        return statistics.median(sum(one) for one in self.wall)

    def cpu_milliseconds(self) -> list[float]:
        """CPU milliseconds a pixel: medians of what is done before the passes, then of each pass."""
        return [1e3 * statistics.median(column) / self.pixels for column in zip(*self.cpu, strict=True)]

    def run(self) -> None:
        """Run once, and write down what each part took."""
        clocks = [_clocks()]
        job = prepare(self.samples, self.config, seed=0)
        radiance, _ = job.radiance, job.records
        clocks.append(_clocks())
        for turn in self.config.turns:
            radiance, _ = run_kernel(job, turn, radiance)
            clocks.append(_clocks())
        pixel_mean(radiance)
        clocks[-1] = _clocks()
        wall, cpu = np.diff(clocks, axis=0).T
        self.wall.append(wall.tolist())
        self.cpu.append(cpu.tolist())


def compile_rpf() -> float:
    """Run RPF once on a tiny image; return the seconds that took.

    Examples
    --------
    >>> compile_rpf() > 0
    True
    """
    start = time.perf_counter()
    corner = np.stack(np.meshgrid(np.arange(4), np.arange(4)), axis=-1)[:, :, np.newaxis] + 0.5
    noise = np.random.default_rng(0).random((4, 4, 1, 3))
    rpf(SampleBuffer.from_arrays(noise, corner, {"lens_u": noise[..., 0]}, {"albedo": noise}), progress=False)
    return time.perf_counter() - start


def time_lines(repeats: int) -> list[str]:
    """Time the presets on the thin-lens scene; return a line each, and the targets."""
    small, large = (capture(SCENE, side, side, SPP, seed=0) for side in SIDES)
    whole = RPFConfig.technical_report(sample_fraction=PUBLISHED)
    timed = [
        Timed(ADAPTIVE, RPFConfig.adaptive(), small),
        Timed(QUICK, RPFConfig.technical_report(), small),
        Timed(WHOLE, whole, small),
        Timed(ADAPTIVE, RPFConfig.adaptive(), large),
        Timed(QUICK, RPFConfig.technical_report(), large),
    ]
    take_turns(timed, repeats)
    title = (
        f"RPF, scene {SCENE}, {SPP} spp; median of {repeats}, of 1 where a run takes more than {ENOUGH_SECONDS:g} s; "
        f"CPU ms a pixel: all threads together"
    )
    lines = [
        title,
        f"  {'':30s} {'pixels':>9s} {'seconds':>8s} {'CPU ms':>7s}   CPU ms a pixel: before, each pass (box)",
    ]
    return [*lines, *(time_line(one) for one in timed), *time_targets(*timed[1:3], timed[4])]


def take_turns(timed: Sequence[Timed], repeats: int) -> None:
    """Run all in turns; leave out those that are slow after their first run."""
    for _ in tqdm(range(repeats), desc="RPF presets", unit="round", disable=None, leave=False):
        for one in timed:
            if not one.wall or one.seconds() < ENOUGH_SECONDS:
                one.run()


def time_line(timed: Timed) -> str:
    """One configuration in one line."""
    before, *passes = timed.cpu_milliseconds()
    boxes = [timed.config.boxes[turn] for turn in timed.config.turns]
    parts = ", ".join(f"{cost:.3f} ({box})" for cost, box in zip(passes, boxes, strict=True))
    size = f"{timed.samples.height}x{timed.samples.width}"
    return f"  {timed.label:30s} {size:>9s} {timed.seconds():8.2f} {before + sum(passes):7.3f}   {before:.3f}, {parts}"


def time_targets(quick: Timed, whole: Timed, quick_large: Timed) -> list[str]:
    """Targets beside what was measured, and beside what that is on cores that nobody else uses."""
    lines = []
    for timed, limit in ((quick, 2.5), (quick_large, 10.0), (whole, 10.0)):
        size, seconds = f"{timed.samples.height}x{timed.samples.width}", timed.seconds()
        alone = 1e-3 * timed.pixels * sum(timed.cpu_milliseconds()) / usable_cores()
        lines.append(
            f"  target: {timed.label}, {size}, under {limit:g} s: {seconds:.2f} s, {reached(seconds < limit)} "
            f"(its CPU time, spread over all cores: {alone:.2f} s)"
        )
    cost = sum(quick.cpu_milliseconds())
    words = f"{quick.label} under 0.6 CPU ms a pixel (public C++ codes: 2.4 to 10)"
    return [*lines, f"  target: {words}: {cost:.2f} ms, {reached(cost < 0.6)}"]


def growth_lines(repeats: int) -> list[str]:
    """Vary spp, M, feature columns and pixels; return the fitted laws with the medians behind them."""
    lines = ["growth of the time of RPF, technical report, quick where nothing else is said"]
    for series in growth_series():
        contestants = [Contestant(str(value), series.run(value)) for value in series.values]
        measure([Work(series.title, contestants)], repeats, f"growth with {series.symbol[0]}")
        lines += law(series, [contestant.median() for contestant in contestants])
    return lines


def growth_series() -> list[Series]:
    """Return what is varied, everything else fixed."""
    report, side = RPFConfig.technical_report, GROWTH_SIDES[0]
    dense = capture(SCENE, side, side, GROWTH_SPP[-1], seed=0)
    large = capture(SCENE, GROWTH_SIDES[-1], GROWTH_SIDES[-1], SPP, seed=0)
    usual = dense.subset(0, SPP)
    fractions = {round(fraction * GROWTH_BOX[0] ** 2 * SPP): fraction for fraction in GROWTH_FRACTIONS}
    sides = {one * one: one for one in GROWTH_SIDES}
    counts = {3 * (k + 1): FEATURES[: k + 1] for k in range(len(FEATURES))}

    def job(samples: SampleBuffer, config: RPFConfig | None = None) -> Callable[[], object]:
        return lambda: rpf(samples, config or report(), progress=False)

    size = f"{side}x{side}"
    return [
        Series(f"{size}, M grows too", ("spp", "n"), GROWTH_SPP, lambda n: job(dense.subset(0, n))),
        Series(
            f"{size}, {SPP} spp, one box of {GROWTH_BOX[0]}",
            ("M", "M"),
            tuple(fractions),
            lambda m: job(usual, report(boxes=GROWTH_BOX, sample_fraction=fractions[m])),
        ),
        Series(
            f"{size}, {SPP} spp",
            ("feature columns", "n_f"),
            tuple(counts),
            lambda n: job(usual.select(features=counts[n])),
        ),
        Series(f"{SPP} spp", ("pixels", "N"), tuple(sides), lambda n: job(large.crop(0, 0, sides[n], sides[n]))),
    ]


def _clocks() -> tuple[float, float]:
    """Seconds on the clock, and CPU seconds of this process."""
    return time.perf_counter(), time.process_time()
