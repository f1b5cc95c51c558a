"""Chapter 10, stability: the catalogue as tables, the study's charts, pages of pictures, and the median of means."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.study.figures._ch10_data import study, table, words
from mcdenoise.study.methods import METHODS
from mcdenoise.study.slider import Slider, slider
from mcdenoise.study.stability_catalogue import CATALOGUE
from mcdenoise.study.stability_charts import (
    SHOWN_APART,
    _telling_level,
    bias_variance,
    breakdown_chart,
    overview,
    times_chart,
)
from mcdenoise.study.stability_limits import limit_of
from mcdenoise.study.stability_pictures import PICTURED, pictures
from mcdenoise.study.stability_settings import Settings
from mcdenoise.study.stability_tables import (
    MOST_TIMES,
    SHORTEST,
    breakdown,
    each,
    noise_curves,
    short,
    slowest,
)
from mcdenoise.study.stability_troubles import NOISE_LEVELS

UNEXPLAINED = "the tests' small study holds it"
PICTURE = 48  # pixels a side of the pictures
TOPICS = {  # heading -> entries of the catalogue
    "samples": (
        "firefly_count",
        "firefly_value",
        "nonfinite",
        "few_spp",
        "correlated",
        "mutual_information",
        "noise_level",
    ),
    "range": ("black", "scale", "high_range", "faint", "flat", "noise_free"),
    "features": ("texture", "noisy_features", "missing_features", "constant_feature", "misleading_features"),
    "light": ("second_hit", "penumbra", "bokeh"),
    "machine": ("bandwidths", "small_image", "engines", "threads"),
}


def stability() -> dict[str, Any]:
    """The stored study."""
    return study("stability")


def catalogue() -> tuple[Figure, dict]:
    """Entries and methods: what held. Tables of the catalogue by topic, and of what is not guaranteed, method by method."""
    found = stability()
    everything = list(each(found))
    broken = [one for one in everything if not one[3]["held"]]
    settings = found["settings"]
    numbers = {
        "entries": len(CATALOGUE),
        "checks": len(everything),
        "held": len(everything) - len(broken),
        "seeds": settings["seeds"],
        "size": settings["size"],
        "no_image": _no_image(found),
        "by_method": {
            name: {
                "checks": sum(one[2] == name for one in everything),
                "held": sum(one[2] == name and one[3]["held"] for one in everything),
            }
            for name in METHODS
        },
        "tables": {topic: catalogue_table(names, found) for topic, names in TOPICS.items()},
        "limits": {name: limits_table(name, found) for name in METHODS},
    }
    least = min(METHODS, key=lambda name: numbers["by_method"][name]["checks"] - numbers["by_method"][name]["held"])
    complete = words(METHODS[name].label for name, of in numbers["by_method"].items() if of["held"] == of["checks"])
    return overview(found), numbers | {"steadiest": METHODS[least].label, "complete": complete}


def _no_image(found: dict) -> str:
    """What came out as a message, not as an image."""
    seen: dict[str, list[str]] = {}
    for name, level, method, one in each(found):
        if one.get("failure"):
            seen.setdefault(f"{CATALOGUE[name].title} ({level})", []).append(METHODS[method].label)
    return "; ".join(f"{case}: {words(dict.fromkeys(labels))}" for case, labels in seen.items()) or "none"


def catalogue_table(names: Sequence[str], found: dict) -> str:
    """Rows of the catalogue: what is varied, what is guaranteed, for how many methods it held, who breaks it."""
    rows = []
    for name in names:
        case, entry = CATALOGUE[name], found["entries"][name]
        broken = [m for m in METHODS if any(not level["methods"][m]["held"] for level in entry["levels"])]
        held = f"{len(METHODS) - len(broken)} of {len(METHODS)}"
        rows.append(
            (case.title, case.varied, case.guarantee, held, words((METHODS[m].label for m in broken), "nobody"))
        )
    return table(("failure", "varied", "guarantee", "held by", "broken by"), rows)


def limits_table(method: str, found: dict) -> str:
    """What is not guaranteed for one method: where, the largest numbers of this study and of the tests' small one, and why."""
    rows = []
    for name, case in CATALOGUE.items():
        levels = {level["level"]: level["methods"][method] for level in found["entries"][name]["levels"]}
        reasons: dict[str, list[str]] = {}
        for level, numbers in levels.items():
            limit = limit_of(name, method, level)
            if limit or not numbers["held"]:
                reasons.setdefault(limit.reason if limit else UNEXPLAINED, []).append(level)
        for reason, where in reasons.items():
            limits = [limit for level in where if (limit := limit_of(name, method, level))]
            tests = max((limit.seen for limit in limits if limit.quick), default=None)
            which = "" if len(where) == len(case.levels) else f" ({', '.join(where)})"
            here = _worst([levels[level] for level in where])
            there = "held" if tests is None else "no image" if np.isinf(tests) else short(tests)
            rows.append((f"{case.title}{which}", f"{case.unit}, at most {case.bound:.4g}", here, there, reason))
    head = ("not guaranteed", "number and bound", "this study", "the tests", "why")
    return table(head, rows) if rows else "Everything in the catalogue is guaranteed."


def _worst(numbers: Sequence[dict[str, Any]]) -> str:
    """The largest number, and whether it held."""
    values = [one["value"] for one in numbers]
    if None in values:
        return "no image"
    return short(max(values)) + (" (held)" if all(one["held"] for one in numbers) else "")


def noise_breakdown() -> tuple[Figure, dict]:
    """From next to no noise to nothing but noise: where each method does harm, and how its error grows at the end."""
    found = stability()
    unfiltered, curves = noise_curves(found)
    broken = breakdown(found)
    rows, numbers = [], {}
    for name, (harmed, slope) in broken.items():
        ratios = curves[name] / unfiltered
        best = int(np.argmin(ratios))
        numbers[name] = {"slope": slope, "best": float(ratios[best]), "best_at": NOISE_LEVELS[best], "harmed": harmed}
        where = ", ".join(f"{level:g}" for level in harmed) or "nowhere"
        rows.append((METHODS[name].label, where, f"{ratios[best]:.3f} at {NOISE_LEVELS[best]:g}", f"{slope:.1f}"))
    head = ("method", "does harm at noise", "smallest relMSE / unfiltered", "slope at the end")
    return breakdown_chart(found), {"methods": numbers, "levels": list(NOISE_LEVELS), "table": table(head, rows)}


def chart_bias() -> tuple[Figure, dict]:
    """Squared bias and variance apart, in some entries."""
    found, numbers = stability(), {}
    for name in SHOWN_APART:
        level = _telling_level(found["entries"][name])
        numbers[name] = {"level": level["level"], "unfiltered": level["unfiltered"]["variance"]}
        for method in METHODS:
            one = level["methods"][method]
            if one["variance"] is not None:
                whole = max(one["bias_squared"], 0) + one["variance"]
                numbers[name][method] = {
                    "bias_squared": one["bias_squared"],
                    "variance": one["variance"],
                    "share": 100 * max(one["bias_squared"], 0) / whole,
                }
    return bias_variance(found), numbers


def chart_times() -> tuple[Figure, dict]:
    """Time of every pair of entry and method against the method's normal time."""
    found = stability()
    times = slowest(found)
    over = [one for one in times if one[0] > MOST_TIMES]
    longer = [one for one in over if one[4] >= SHORTEST]
    numbers = {
        "pairs": len(times),
        "over": len(over),
        "target": MOST_TIMES,
        "long": len(longer),
        "shortest_ms": 1e3 * SHORTEST,
    }
    rows = [
        (METHODS[method].label, f"{CATALOGUE[name].title} ({level})", f"{ratio:.1f}", f"{1e3 * seconds:.2f}")
        for ratio, name, level, method, seconds in times[:5]
    ]
    numbers["table"] = table(("the five largest", "where", "times normal", "ms"), rows)
    return times_chart(found), numbers | {"largest": times[0][0]}


def _pictured(topic: str) -> Iterator[str]:
    """Entries of a topic that have pictures."""
    return (name for name in TOPICS[topic] if name in PICTURED)


def page_of_pictures(topic: str, title: str) -> tuple[Slider, dict]:
    """A slider over the entries of a topic: noisy image, every method, truth."""
    titles = {CATALOGUE[name].title: name for name in _pictured(topic)}
    made = slider(lambda failure: _frame(titles[failure]), title=title, start=next(iter(titles)), failure=titles)
    return made, {"entries": list(titles.values()), "size": _picture_settings().size}


def _picture_settings() -> Settings:
    """Those of the study, with smaller images."""
    settings = Settings(**stability()["settings"])
    return replace(settings, size=min(settings.size, PICTURE))


def _frame(name: str) -> Figure:
    """The pictures of one entry, smaller than those of the study, with titles that fit a page."""
    figure = pictures(name, _picture_settings())
    figure.set_size_inches(9.6, 4.5)
    for axes in figure.axes:
        axes.set_title(axes.get_title().replace(", ", ",\n"), fontsize=8.5)
    return figure


def slider_samples() -> tuple[Slider, dict]:
    """Failures of samples."""
    return page_of_pictures("samples", "Samples that are bad, few, or say too little")


def slider_range() -> tuple[Slider, dict]:
    """Failures of range."""
    return page_of_pictures("range", "Dark, bright, faint, flat")


def slider_features() -> tuple[Slider, dict]:
    """Failures of features."""
    return page_of_pictures("features", "Features that are fine, noisy, missing, misleading")


def slider_light() -> tuple[Slider, dict]:
    """Light that no first hit knows."""
    return page_of_pictures("light", "Light that no first hit knows")
