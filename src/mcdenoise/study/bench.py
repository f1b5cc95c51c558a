"""How fast are our filters beside those of scipy, scikit-image and OpenCV? One command, one run, one table:

    python -m mcdenoise.study.bench filters [--size 512] [--repeats 5]

Within a run the contestants take turns, so that whatever else the machine does hits all of them; each time is a median.
What numba compiles is compiled before, and that time is printed apart. Absolute times say little about another machine:
read ratios.
"""

from __future__ import annotations

import argparse
import importlib
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from types import ModuleType

import numpy as np
from tqdm import tqdm

from mcdenoise.filters import bilateral, cross_bilateral, gaussian
from mcdenoise.study.arguments import OneLineParser
from mcdenoise.study.machine import usable_cores

SIGMA_SPACE, GAUSSIAN_RADIUS = 3.0, 9
BILATERAL_SIGMA_SPACE, SIGMA_RADIANCE, BILATERAL_RADIUS = 5.0, 0.3, 10
CROSS_SIGMA_SPACE, SIGMA_FEATURE, CROSS_RADIUS = 9.0, 0.5, 27
FEATURES = ("world_position", "shading_normal", "albedo")


@dataclass
class Contestant:
    """One implementation of one piece of work."""

    name: str
    run: Callable[[], object] | None  # None: its library is not installed
    note: str = ""
    scale: float = 1.0  # the run does 1 / scale of the work
    once: bool = False
    seconds: list[float] = field(default_factory=list)

    def median(self) -> float:
        """Median of the measured seconds, scaled to the whole work."""
        return self.scale * statistics.median(self.seconds)


@dataclass
class Work:
    """One piece of work; the first contestant is ours."""

    title: str
    contestants: list[Contestant]
    taps: int = 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code (2, with one line on stderr, for bad arguments)."""
    parser = OneLineParser(prog="python -m mcdenoise.study.bench", description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True, metavar="filters")
    filters = commands.add_parser("filters", help="Gaussian, bilateral and cross-bilateral filter beside their peers")
    filters.add_argument("--size", type=_count(8), default=512, help="height and width in pixels (default 512)")
    filters.add_argument("--repeats", type=_count(1), default=5, help="runs to take the median of (default 5)")
    try:
        chosen = parser.parse_args(arguments)
    except SystemExit as leaving:
        return int(leaving.code or 0)
    bench_filters(chosen.size, chosen.repeats)
    return 0


def bench_filters(size: int, repeats: int) -> None:
    """Time all contestants on `size` x `size` x 3 float32 (the cross-bilateral on half of that) and print the table."""
    peers = {name: _import(name) for name in ("scipy.ndimage", "skimage", "cv2")}
    for line in machine_facts(peers):
        print(line)
    print(f"compiling or loading our kernels: {_compile():.1f} s (not counted below)\n", flush=True)
    works = filter_works(size, peers)
    measure(works, repeats)
    for work in works:
        print("\n".join(table(work, repeats)), end="\n\n")


def filter_works(size: int, peers: dict[str, ModuleType | None]) -> list[Work]:
    """The three pieces of work, with every contestant that is installed."""
    rng = np.random.default_rng(0)
    image = rng.random((size, size, 3), dtype=np.float32)
    half = max(4, size // 2)
    small = np.ascontiguousarray(image[:half, :half])
    features = {name: rng.random((half, half, 3), dtype=np.float32) for name in FEATURES}
    window = 2 * CROSS_RADIUS + 1
    return [
        Work(
            f"Gaussian, sigma {SIGMA_SPACE:g}, radius {GAUSSIAN_RADIUS}, {size}x{size}x3 float32",
            _gaussians(image, peers),
        ),
        Work(
            f"bilateral, radius {BILATERAL_RADIUS}, {size}x{size}x3 float32",
            _bilaterals(image, peers),
            taps=_taps(size, BILATERAL_RADIUS),
        ),
        Work(
            f"cross-bilateral, window {window}x{window}, 9 feature channels + colour, {half}x{half}",
            [Contestant("mcdenoise.cross_bilateral", lambda: _cross(small, features, CROSS_RADIUS))],
            taps=_taps(half, CROSS_RADIUS),
        ),
    ]


def _gaussians(image: np.ndarray, peers: dict[str, ModuleType | None]) -> list[Contestant]:
    """Return Gaussian filters: all with the same sigma and radius, differing at the border only."""
    ndimage, skimage, cv2 = peers.values()
    truncate, width = GAUSSIAN_RADIUS / SIGMA_SPACE, 2 * GAUSSIAN_RADIUS + 1
    sigmas = (SIGMA_SPACE, SIGMA_SPACE, 0)
    return [
        Contestant("mcdenoise.gaussian", lambda: gaussian(image, sigma_space=SIGMA_SPACE, radius=GAUSSIAN_RADIUS)),
        Contestant(
            "scipy.ndimage.gaussian_filter",
            ndimage and (lambda: ndimage.gaussian_filter(image, sigmas, truncate=truncate)),
        ),
        Contestant(
            "skimage.filters.gaussian",
            skimage and (lambda: skimage.filters.gaussian(image, SIGMA_SPACE, truncate=truncate, channel_axis=-1)),
        ),
        Contestant("cv2.GaussianBlur", cv2 and (lambda: cv2.GaussianBlur(image, (width, width), SIGMA_SPACE))),
    ]


def _bilaterals(image: np.ndarray, peers: dict[str, ModuleType | None]) -> list[Contestant]:
    """Return bilateral filters. Theirs are approximations, of which each note says what is left out."""
    _, skimage, cv2 = peers.values()
    sigmas = {"sigma_space": BILATERAL_SIGMA_SPACE, "sigma_radiance": SIGMA_RADIANCE}
    width, crop = 2 * BILATERAL_RADIUS + 1, image[: max(8, len(image) // 4), : max(8, len(image) // 4)]
    return [
        Contestant("mcdenoise.bilateral", lambda: bilateral(image, radius=BILATERAL_RADIUS, **sigmas), "exact formula"),
        Contestant(
            "skimage.restoration.denoise_bilateral",
            skimage
            and (
                lambda: skimage.restoration.denoise_bilateral(
                    crop, width, SIGMA_RADIANCE, BILATERAL_SIGMA_SPACE, channel_axis=-1
                )
            ),
            f"weights from tables; one run on {len(crop)}x{len(crop)}, scaled by pixels",
            scale=image.size / crop.size,
            once=True,
        ),
        Contestant(
            "cv2.bilateralFilter",
            cv2 and (lambda: cv2.bilateralFilter(image, width, SIGMA_RADIANCE, BILATERAL_SIGMA_SPACE)),
            "round window (0.7 of the taps), L1 distance, weights from a table",
        ),
    ]


def _cross(image: np.ndarray, features: dict[str, np.ndarray], radius: int) -> np.ndarray:
    """Run the cross-bilateral filter of the benchmark."""
    return cross_bilateral(
        image,
        features,
        sigma_space=CROSS_SIGMA_SPACE,
        sigma_radiance=SIGMA_FEATURE,
        sigma_features=dict.fromkeys(features, SIGMA_FEATURE),
        radius=radius,
    )


def _compile() -> float:
    """Run every kernel once on a tiny image; return the seconds that took."""
    tiny = np.ones((4, 4, 3), np.float32)
    start = time.perf_counter()
    gaussian(tiny, sigma_space=1.0)
    bilateral(tiny, sigma_space=1.0, sigma_radiance=1.0)
    _cross(tiny, dict.fromkeys(FEATURES, tiny), radius=1)
    return time.perf_counter() - start


def measure(works: list[Work], repeats: int) -> None:
    """Warm every contestant up, then time them in turns; the progress bar goes to stderr, if that is a terminal."""
    runs = [
        (contestant, turn)
        for work in works
        for turn in range(-1, repeats)
        for contestant in work.contestants
        if contestant.run and (turn <= 0 or not contestant.once)
    ]
    for contestant, turn in tqdm(runs, desc="filters", unit="run", disable=None, leave=False):
        start = time.perf_counter()
        contestant.run()
        if turn >= 0:
            contestant.seconds.append(time.perf_counter() - start)


def table(work: Work, repeats: int) -> list[str]:
    """Return the lines for one piece of work.

    Examples
    --------
    >>> print(*table(Work("blur", [Contestant("a", print, seconds=[0.002]), Contestant("b", None)]), 1), sep="\\n")
    blur; median of 1
      a                                            2.0 ms
      b                                      not installed
    """
    ours = work.contestants[0].median()
    lines = [f"{work.title}; median of {repeats}"]
    for contestant in work.contestants:
        if contestant.run is None:
            lines.append(f"  {contestant.name:38s} {'not installed':>12s}")
            continue
        seconds = contestant.median()
        ratio = "" if contestant is work.contestants[0] else f"{seconds / ours:7.1f} x our time"
        lines.append(f"  {contestant.name:38s} {1e3 * seconds:9.1f} ms  {ratio:18s}  {contestant.note}".rstrip())
    if work.taps:
        lines.append(f"  ours: {work.taps / ours / 1e9:.2f} billion taps (pixel, neighbour inside the image) a second")
    return lines


def machine_facts(peers: dict[str, ModuleType | None]) -> list[str]:
    """Return what a reader must know about the machine: cores, threads, instruction sets, versions."""
    from mcdenoise.kernels.jit import compiler_facts

    facts = compiler_facts()
    cores = usable_cores()
    cv2 = peers["cv2"]
    versions = {"Python": sys.version.split()[0], "numpy": np.__version__, "numba": facts["numba"]}
    for label, name in (("scipy", "scipy.ndimage"), ("scikit-image", "skimage"), ("OpenCV", "cv2")):
        module = importlib.import_module(name.partition(".")[0]) if peers[name] else None
        versions[label] = module.__version__ if module else "not installed"
    threads = f"numba {facts['threads']}" + (f", OpenCV {cv2.getNumThreads()}" if cv2 else "")
    return [
        f"cores: {cores}; threads: {threads}, scipy and scikit-image 1; CPU: {facts['cpu']}; SIMD: {facts['simd']}",
        "versions: " + ", ".join(f"{name} {version}" for name, version in versions.items()),
    ]


def _taps(size: int, radius: int) -> int:
    """Count pairs (pixel, neighbour in its window and inside the image)."""
    return sum(size - abs(d) for d in range(-radius, radius + 1) if abs(d) < size) ** 2


def _import(name: str) -> ModuleType | None:
    """Return a peer's module, or None if it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


def _count(least: int) -> Callable[[str], int]:
    """Return a reader of whole numbers of at least `least`, for argparse."""

    def read(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"a whole number of at least {least} is needed, got {text!r}")
        return int(text)

    return read


if __name__ == "__main__":
    sys.exit(main())
