"""What the study of stability found, as lines for the terminal: every number, what did not hold, times, breakdown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from mcdenoise.study.methods import METHODS
from mcdenoise.study.stability_catalogue import CATALOGUE
from mcdenoise.study.stability_limits import limit_of
from mcdenoise.study.stability_troubles import FIREFLY, NOISE_LEVELS

Found = Mapping[str, Any]
SHORT = {
    "gaussian": "gauss",
    "bilateral": "bilat",
    "cross_bilateral": "cross",
    "cross_bilateral_prefiltered": "cross-p",
    "nlm": "nlm",
    "joint_nlm": "joint",
    "rpf": "rpf",
    "rpf_report": "rpf-rep",
    "lbf": "lbf",
    "lbf_nlm": "lbf-nlm",
}
MOST_TIMES = 3.0  # the target: no method takes longer than this many times its normal time
SHORTEST = 1e-3  # seconds: below, a ratio of times is one of the system's habits


def lines(found: Found) -> list[str]:
    """Return the tables for the terminal.

    Examples
    --------
    >>> print(*lines({"entries": {}})[:1])
    Stability where methods fail: * not held
    """
    return [
        "Stability where methods fail: * not held",
        *(line for name in CATALOGUE if name in found["entries"] for line in entry_lines(name, found["entries"][name])),
        *breakdown_lines(found),
        *firefly_lines(found),
        *time_lines(found),
        *verdict_lines(found),
    ]


def entry_lines(name: str, entry: Found) -> list[str]:
    """One entry: what is varied and guaranteed, then a row a level with the worst number of every method."""
    case = CATALOGUE[name]
    width = max(len(level) for level in case.levels)
    head = " ".join(f"{SHORT[method]:>8}" for method in METHODS)
    rows = []
    for level in entry["levels"]:
        cells = " ".join(f"{cell(level['methods'][method]):>8}" for method in METHODS)
        rows.append(f"  {level['level']:{width}}  {cells}")
    return [
        "",
        f"{case.title} ({name}). Varied: {case.varied}.",
        f"  Expected: {case.expected}",
        f"  Guaranteed: {case.guarantee} Number: {case.unit}, worst over seeds; bound {case.bound:g}.",
        f"  {'':{width}}  {head}",
        *rows,
        *spread_lines(entry, width),
    ]


def spread_lines(entry: Found, width: int) -> list[str]:
    """relMSE where there is a truth: mean and spread over the seeds, squared bias and variance, at the last level."""
    level = entry["levels"][-1]
    if "unfiltered" not in level:
        return []
    plain = level["unfiltered"]["relmse"]
    rows = [
        f"  {level['level']}: relMSE unfiltered {plain['mean']:.3g} +- {plain['spread']:.1g}; "
        f"filtered: mean, spread, worst, squared bias, variance"
    ]
    for key, pick in {
        "mean": lambda one: one["relmse"]["mean"],
        "spread": lambda one: one["relmse"]["spread"],
        "worst": lambda one: one["relmse"]["worst"],
        "bias^2": lambda one: one["bias_squared"],
        "variance": lambda one: one["variance"],
    }.items():
        numbers = [level["methods"][method] for method in METHODS]
        cells = " ".join(f"{short(None if one['relmse'] is None else pick(one)):>8}" for one in numbers)
        rows.append(f"  {key:>{max(width, 8)}}  {cells}")
    return rows


def cell(numbers: Found) -> str:
    """The number of a guarantee, with a star where it was not held.

    Examples
    --------
    >>> cell({"value": 2.34, "held": False}), cell({"value": None, "held": False, "failure": "ValueError"})
    ('2.3*', 'failed*')
    """
    if numbers["value"] is None:
        return "failed*"
    return short(numbers["value"]) + ("" if numbers["held"] else "*")


def short(value: float | None) -> str:
    """A number in few characters.

    Examples
    --------
    >>> short(0.0), short(1.3e-7), short(0.0234), short(12345.0), short(None)
    ('0', '1e-07', '0.023', '1e+04', '-')
    """
    if value is None:
        return "-"
    if 0.95 < value < 1.05:
        return f"{value:.3g}"
    return (
        f"{value:.0e}"
        if value and not 1e-3 <= abs(value) < 1e4
        else f"{value:.2g}"
        if abs(value) < 100
        else f"{value:.0f}"
    )


def each(found: Found) -> Iterator[tuple[str, str, str, Found]]:
    """Walk over name, level, method and numbers."""
    for name, entry in found["entries"].items():
        for level in entry["levels"]:
            for method, numbers in level["methods"].items():
                yield name, level["level"], method, numbers


def noise_curves(found: Found) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Mean relMSE at every noise level: unfiltered, and of every method."""
    levels = found["entries"]["noise_level"]["levels"]
    unfiltered = np.array([level["unfiltered"]["relmse"]["mean"] for level in levels])
    return unfiltered, {
        method: np.array([level["methods"][method]["relmse"]["mean"] for level in levels]) for method in METHODS
    }


def breakdown(found: Found) -> dict[str, tuple[list[float], float]]:
    """For every method: the noise levels at which it does harm, and how steeply its error grows at the end.

    The slope is that of the last decade of noise in log-log: 2 is that of the unfiltered image, whose error grows with the
    square of the noise.
    """
    unfiltered, curves = noise_curves(found)
    steps = np.log(NOISE_LEVELS[-1] / NOISE_LEVELS[-3])
    return {
        method: (
            [level for level, own, other in zip(NOISE_LEVELS, curve, unfiltered, strict=True) if own > other],
            float(np.log(curve[-1] / curve[-3]) / steps),
        )
        for method, curve in curves.items()
    }


def breakdown_lines(found: Found) -> list[str]:
    """Where filtering does harm."""
    if "noise_level" not in found["entries"]:
        return []
    rows = [
        "",
        "Breakdown: noise levels at which the filtered image is worse on average, and the slope of its error at the end",
    ]
    for method, (harmed, slope) in breakdown(found).items():
        where = ", ".join(f"{level:g}" for level in harmed) or "none"
        rows.append(f"  {METHODS[method].label:30} harm at {where}; slope {slope:.1f}")
    return rows


def firefly_damage(found: Found) -> dict[str, tuple[float, float]]:
    """relMSE of the plain room filtered, and what one firefly a megapixel adds to it: for every method and "unfiltered".

    One firefly in an image of n pixels adds (its relMSE - the plain one's) n / 10^6 to that of a megapixel, and many that lie
    apart add up.
    """
    plain = found["entries"]["noise_level"]["levels"][NOISE_LEVELS.index(1.0)]
    one = found["entries"]["firefly_count"]["levels"][0]
    share = found["settings"]["size"] ** 2 / 1e6
    pairs = {name: (plain["methods"][name], one["methods"][name]) for name in METHODS}
    pairs["unfiltered"] = plain["unfiltered"], one["unfiltered"]
    means = {name: [numbers["relmse"]["mean"] for numbers in pair] for name, pair in pairs.items()}
    return {name: (before, (after - before) * share) for name, (before, after) in means.items()}


def firefly_lines(found: Found) -> list[str]:
    """The damage of fireflies that lie apart, per megapixel."""
    if not {"firefly_count", "noise_level"} <= found["entries"].keys():
        return []
    rows = [
        "",
        f"relMSE of a megapixel with fireflies of {FIREFLY:g} that lie apart, from the damage of one",
        f"  {'':30} {0:>9} {1:>9} {10:>9} {100:>9} {1000:>9}",
    ]
    for name, (before, added) in firefly_damage(found).items():
        label = METHODS[name].label if name in METHODS else name
        rows.append(f"  {label:30} " + " ".join(f"{before + added * count:9.3g}" for count in (0, 1, 10, 100, 1000)))
    return rows


def slowest(found: Found) -> list[tuple[float, str, str, str, float]]:
    """Times normal, name, level, method and seconds of every run that was timed, the slowest first."""
    timed = [
        (numbers["times_normal"], name, level, method, numbers["seconds"])
        for name, level, method, numbers in each(found)
        if numbers.get("times_normal") is not None
    ]
    return sorted(timed, reverse=True)


def time_lines(found: Found) -> list[str]:
    """The largest ratio of a method's time to its normal time."""
    times = slowest(found)
    if not times:
        return []
    over = [one for one in times if one[0] > MOST_TIMES]
    longer = [one for one in over if one[4] >= SHORTEST]
    rows = [
        "",
        f"Time against the normal time of a method (a plain room of the same size, spp and layout): {len(times)} pairs, "
        f"{len(over)} above {MOST_TIMES:g}, of these {len(longer)} that take longer than {1e3 * SHORTEST:g} ms",
    ]
    for ratio, name, level, method, seconds in times[:5]:
        rows.append(f"  {ratio:5.1f} x  {METHODS[method].label}, {name}, {level}: {1e3 * seconds:.2f} ms")
    return rows


def verdict_lines(found: Found) -> list[str]:
    """How many guarantees were held, what was not and why, and what came out as no image at all."""
    everything = list(each(found))
    broken = [one for one in everything if not one[3]["held"]]
    rows = ["", f"{len(everything) - len(broken)} of {len(everything)} guarantees held. Not held:"]
    grouped: dict[tuple[str, str], list[str]] = {}
    for name, level, method, numbers in broken:
        grouped.setdefault((name, method), []).append(f"{level}: {short(numbers['value'])}")
    for (name, method), seen in grouped.items():
        limits = (limit_of(name, method, level) for level in CATALOGUE[name].levels)
        reason = next(
            (limit.reason for limit in limits if limit), "held in the quick study of the tests, not at this size"
        )
        rows.append(f"  {name}, {METHODS[method].label} ({'; '.join(seen)}): {reason}.")
    failures = [
        f"  {name}, {level}, {METHODS[method].label}: {numbers['failure']}"
        for name, level, method, numbers in broken
        if numbers.get("failure")
    ]
    return rows + (["No image at all:", *failures] if failures else ["No method failed to give an image."])
