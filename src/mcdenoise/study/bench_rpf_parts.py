"""Two parts of the cost of random parameter filtering: its memory, and mutual information by counting bits."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from mcdenoise.kernels.dependency import information_of_pairs as pairs_by_bits
from mcdenoise.render import capture
from mcdenoise.rpf import RPFConfig, rpf, rpf_neighbourhood
from mcdenoise.rpf.config import PUBLISHED
from mcdenoise.rpf.dependency import information_of_pairs, quantise
from mcdenoise.rpf.neighbourhood import standardise
from mcdenoise.samples import SampleBuffer
from mcdenoise.samples.storage import load_samples, save_samples
from mcdenoise.study.bench_measure import Contestant, Target, Work, measure, reached, table

MEGABYTE = 1e6
RESET, STATUS = Path("/proc/self/clear_refs"), Path("/proc/self/status")
MEMORY_OF = {"adaptive (default)": RPFConfig.adaptive(), "technical report, quick": RPFConfig.technical_report()}
BITS, BY_FORMULA, SKLEARN = "bits, as in RPF", "NumPy, as the formula reads", "sklearn mutual_info_score"
Pairs = Callable[[np.ndarray, np.ndarray], np.ndarray]


def buffer_bytes(samples: SampleBuffer) -> int:
    """Count the bytes of the arrays of a buffer.

    Examples
    --------
    >>> corner = np.zeros((1, 1, 4, 2))
    >>> buffer_bytes(SampleBuffer.from_arrays(np.ones((1, 1, 4, 3)), corner))  # 4 samples of 5 float32 and one bool
    84
    """
    blocks = (samples.screen_position, samples.random_params, samples.features, samples.radiance, samples.hit)
    return sum(block.nbytes for block in blocks)


def memory_lines(scene: str, side: int, spp: int) -> list[str]:
    """Measure how much memory RPF needs beyond the buffer, in a process of its own; return a line a preset.

    The peak of a whole process is the only number that sees everything: `tracemalloc` is blind to what numba allocates
    inside compiled code. Linux can put that peak back to what is in use now, just before the run: otherwise importing
    numba, which needs more for a moment, would hide it. A new process, so that no renderer and no garbage is in it.
    """
    samples = capture(scene, side, side, spp, seed=0)
    size = buffer_bytes(samples)
    lines = [f"memory at the peak, {scene}, {side}x{side}, {spp} spp; the buffer has {size / MEGABYTE:.1f} MB"]
    if not RESET.exists():
        return [*lines, f"  not measured: {RESET} is needed, which only Linux has"]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "samples.npz"
        save_samples(samples, path)
        for label, config in MEMORY_OF.items():
            with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
                added = pool.submit(added_bytes, path, config).result()
            times = (size + added) / size
            lines.append(
                f"  {label}: buffer and {added / MEGABYTE:.1f} MB beyond it, {times:.1f} x the buffer; "
                f"target under 10 x: {reached(times < 10)}"
            )
    return lines


def added_bytes(path: Path, config: RPFConfig) -> int:
    """Load a buffer and filter it; return by how many bytes the memory of this process rose at most meanwhile."""
    samples = load_samples(path)
    corner = samples.crop(0, 0, min(4, samples.height), min(4, samples.width))
    rpf(corner, config, progress=False)  # what is compiled or loaded once is not charged
    return rise_of(lambda: rpf(samples, config, progress=False))


def rise_of(call: Callable[[], object]) -> int:
    """Return by how many bytes the memory of this process rose at most during a call. Linux alone can say."""
    RESET.write_text("5")
    before = _peak_bytes()
    call()
    return _peak_bytes() - before


def _peak_bytes() -> int:
    """The most memory that this process has had since the last reset."""
    for line in STATUS.read_text().splitlines():
        if line.startswith("VmHWM:"):
            return 1024 * int(line.split()[1])
    raise OSError(f"{STATUS} has no line VmHWM.")


def information_lines(scene: str, repeats: int) -> list[str]:
    """Time mutual information of all pairs that RPF needs at one pixel: by bits, by the formula, by scikit-learn."""
    samples = capture(scene, 64, 64, 8, seed=0)
    lines = []
    for fraction in (RPFConfig.technical_report().fraction(0), PUBLISHED):
        config = RPFConfig.technical_report(sample_fraction=fraction, clustering=False)
        found = rpf_neighbourhood(samples, (32, 32), config)
        blocks = (found.radiance, found.random_params, found.position, found.features)
        levels = [quantise(standardise(block.astype(np.float64))[0], 15) for block in blocks]
        work = information_work(*levels)
        measure([work], repeats, "mutual information")
        lines += table(work, repeats)
    return lines


def information_work(c: np.ndarray, r: np.ndarray, p: np.ndarray, f: np.ndarray) -> Work:
    """Return the contestants for levels of radiance, random parameters, position and features, (n, columns) each."""
    left, right = np.hstack([c, f]), np.hstack([r, p])
    count = left.shape[1] * right.shape[1] + c.shape[1] * f.shape[1]

    def every(pairs: Pairs) -> Callable[[], object]:
        return lambda: (pairs(left, right), pairs(c, f))

    contestants = [
        Contestant(BITS, every(pairs_by_bits)),
        Contestant(BY_FORMULA, every(information_of_pairs)),
        Contestant(SKLEARN, every(pairs_by_sklearn) if find_sklearn() else None, once=True),
    ]
    title = f"mutual information, {count} pairs of {len(c)} samples, one core"
    return Work(title, contestants, targets=(Target(BITS, rival=BY_FORMULA, times=5),))


def find_sklearn() -> Callable[[np.ndarray, np.ndarray], float] | None:
    """scikit-learn's function, or None where it is not installed."""
    try:
        from sklearn.metrics import mutual_info_score
    except ImportError:
        return None
    return mutual_info_score


def pairs_by_sklearn(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """As `rpf.dependency.information_of_pairs`, by scikit-learn."""
    score = find_sklearn()
    return np.array([[score(one, other) for other in y.T] for one in x.T])
