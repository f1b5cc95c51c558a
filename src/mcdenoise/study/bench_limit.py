"""How close do our filters come to what the machine's arithmetic allows?

The peak rates of float32 multiply-adds and of exponentials are measured in the same run as the filters; the operations
that a formula cannot do without are counted by hand. Both are worth a line each, not a law: an exponential keeps the
same units busy as multiply-adds do, and divisions, comparisons and memory are not counted at all.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mcdenoise.study.bench_filters import NLM, count_taps
from mcdenoise.study.bench_guided import CROSS, CROSS_RADIUS, FEATURES, SEARCH_RADIUS
from mcdenoise.study.bench_measure import Work

IN_CACHE = 2048  # float32 numbers a thread: 8 KiB
TRIES, SECONDS = 50, 0.01
COLOURS = 3


class Operations(NamedTuple):
    """What a filter must do at least, or does a second.

    Examples
    --------
    >>> Operations(multiply_adds=20.0, exponentials=1.0).multiply_adds
    20.0
    """

    multiply_adds: float  # an addition, subtraction or multiplication that stands alone counts as one
    exponentials: float


def cross_bilateral_operations(pairs: int, guide_channels: int, colours: int = COLOURS) -> Operations:
    """Count for `pairs` of different pixels; a pair is weighed once and used for both.

    A pair: a difference and a multiply-add for each channel of guides and colour, one exponential; then for both pixels
    a multiply-add for each colour and an addition to the norm.

    Examples
    --------
    >>> cross_bilateral_operations(pairs=1, guide_channels=9)
    Operations(multiply_adds=32, exponentials=1)
    """
    return Operations(pairs * (2 * (guide_channels + colours) + 2 * (colours + 1)), pairs)


def nlm_operations(pairs: int, colours: int = COLOURS) -> Operations:
    """Count for `pairs` of different pixels, with a variance of each pixel, by running sums over patches.

    A pair: a difference and a multiply-add for each colour, the sum of both variances, a multiply-add for the smaller
    one. Then for each of the two pixels, whose weights differ: a multiply-add for its own variance, a multiplication by
    1 / sum of the variances, 4 additions for the sums over the patch (one row or column comes, one goes), one
    exponential, a multiply-add for each colour and an addition to the norm.

    Examples
    --------
    >>> nlm_operations(pairs=1)
    Operations(multiply_adds=28, exponentials=2)
    """
    shared, single = 2 * colours + 2, 2 + 4 + colours + 1
    return Operations(pairs * (shared + 2 * single), 2 * pairs)


def peak_rates(tries: int = TRIES, seconds: float = SECONDS) -> Operations:
    """Measure the most multiply-adds and exponentials a second, all threads: the best of many short tries.

    Examples
    --------
    >>> min(peak_rates(tries=1, seconds=1e-4)) > 0
    True
    """
    from mcdenoise.kernels import peak
    from mcdenoise.kernels.jit import compiler_facts

    threads = int(compiler_facts()["threads"])
    values = np.random.default_rng(0).random((threads, IN_CACHE), dtype=np.float32)
    factors = np.float32([1.25, 0.125, 0.75, -0.0625])  # keep every value in range, however often
    return Operations(
        values.size
        * peak.CHAIN
        * most_rounds(lambda rounds: peak.multiply_adds(values, rounds, *factors), tries, seconds),
        values.size * most_rounds(lambda rounds: peak.exponentials(values, rounds), tries, seconds),
    )


def most_rounds(run: Callable[[int], object], tries: int, seconds: float) -> float:
    """Return how many rounds a second `run(rounds)` does at best, with enough rounds to fill `seconds` undisturbed.

    Examples
    --------
    >>> most_rounds(lambda rounds: sum(range(rounds)), tries=1, seconds=0.001) > 1000
    True
    """
    rounds = 1
    run(rounds)  # compiles
    while min(_seconds(run, rounds) for _ in range(3)) < seconds:  # one alone may be slow because others work
        rounds *= 2
    return rounds / min(_seconds(run, rounds) for _ in range(tries))


def _seconds(run: Callable[[int], object], rounds: int) -> float:
    """Time one call."""
    start = time.perf_counter()
    run(rounds)
    return time.perf_counter() - start


def limit_lines(works: Sequence[Work], size: int, peaks: Operations) -> list[str]:
    """Return the peaks and, for the cross-bilateral filter and NL-means, the shares that necessary work has in the time."""
    half, channels = max(4, size // 2), 3 * len(FEATURES)
    contestants = {contestant.name: contestant for work in works for contestant in work.contestants}
    pairs = {
        CROSS: (count_taps(half, CROSS_RADIUS) - half**2) // 2,
        NLM: (count_taps(size, SEARCH_RADIUS) - size**2) // 2,
    }
    needed = {CROSS: cross_bilateral_operations(pairs[CROSS], channels), NLM: nlm_operations(pairs[NLM])}
    ways = {
        CROSS: "a pair of pixels is weighed once",
        NLM: "a pair is compared once and weighed twice; patches by running sums; divisions not counted",
    }
    lines = [
        f"share of the arithmetic limit; peaks of this machine in this run, all threads, best of {TRIES}: "
        f"{peaks.multiply_adds / 1e9:.1f} billion float32 multiply-adds, {peaks.exponentials / 1e9:.2f} billion "
        f"exponentials (ours) a second"
    ]
    for name, operations in needed.items():
        a_pair = Operations(*(count / max(1, pairs[name]) for count in operations))
        words = f"{a_pair.multiply_adds:g} and {a_pair.exponentials:g} a pair of pixels; {ways[name]}"
        lines.append(f"  {name}: {share_words(operations, peaks, contestants[name].median())} ({words})")
    return lines


def share_words(needed: Operations, peaks: Operations, seconds: float) -> str:
    """Return which share of the measured time the necessary work would take at the peak rates.

    Examples
    --------
    >>> share_words(Operations(2e9, 1e8), Operations(40e9, 2e9), seconds=0.2)
    '2.00 billion multiply-adds are 25 % and 0.10 billion exponentials 25 % of 200 ms at the peaks'
    """
    shares = [100 * count / peak / seconds for count, peak in zip(needed, peaks, strict=True)]
    return (
        f"{needed.multiply_adds / 1e9:.2f} billion multiply-adds are {shares[0]:.0f} % and "
        f"{needed.exponentials / 1e9:.2f} billion exponentials {shares[1]:.0f} % of {1e3 * seconds:.0f} ms at the peaks"
    )
