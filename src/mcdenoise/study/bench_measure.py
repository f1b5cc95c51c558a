"""How the benchmark measures: contestants in turns, medians, ratios, and targets beside what was reached."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from tqdm import tqdm


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


@dataclass(frozen=True)
class Target:
    """What one contestant is meant to reach: at most `seconds`, or at least `times` the speed of a rival."""

    contestant: str
    seconds: float = math.inf
    rival: str = ""
    times: float = 0.0


@dataclass
class Work:
    """One piece of work; the first contestant is ours."""

    title: str
    contestants: list[Contestant]
    taps: int = 0
    targets: Sequence[Target] = ()

    def contestant(self, name: str) -> Contestant:
        """Return the contestant of this name."""
        return next(one for one in self.contestants if one.name == name)


def measure(works: list[Work], repeats: int, label: str = "filters", rest: float = 0.0) -> None:
    """Warm every contestant up, then time them in turns; the progress bar goes to stderr, if that is a terminal.

    Before each run the clock waits for `rest` seconds: the threads of BLAS go on spinning for some milliseconds after their
    work, on the cores that the next contestant needs.
    """
    runs = [
        (contestant, turn)
        for work in works
        for turn in range(-1, repeats)
        for contestant in work.contestants
        if contestant.run and (turn <= 0 or not contestant.once)
    ]
    for contestant, turn in tqdm(runs, desc=label, unit="run", disable=None, leave=False):
        time.sleep(rest)
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
    return lines + [f"  target: {verdict(work, target)}" for target in work.targets]


def verdict(work: Work, target: Target) -> str:
    """Return a target in words, with what was measured: reached, missed, or not measured.

    Examples
    --------
    >>> work = Work("blur", [Contestant("a", print, seconds=[0.002]), Contestant("b", print, seconds=[0.009])])
    >>> verdict(work, Target("a", seconds=0.001))
    'a under 0.001 s: 0.002 s, missed'
    >>> verdict(work, Target("a", rival="b", times=4))
    'a at least 4 x faster than b: 4.5 x, reached'
    """
    ours = work.contestant(target.contestant).median()
    if not target.rival:
        return f"{target.contestant} under {target.seconds:g} s: {ours:.3f} s, {reached(ours < target.seconds)}"
    words, rival = f"{target.contestant} at least {target.times:g} x faster than {target.rival}", target.rival
    if work.contestant(rival).run is None:
        return f"{words}: not measured, it is not installed"
    ratio = work.contestant(rival).median() / ours
    return f"{words}: {ratio:.1f} x, {reached(ratio >= target.times)}"


def reached(yes: bool) -> str:
    """Say whether a target was reached.

    Examples
    --------
    >>> reached(True), reached(False)
    ('reached', 'missed')
    """
    return "reached" if yes else "missed"
