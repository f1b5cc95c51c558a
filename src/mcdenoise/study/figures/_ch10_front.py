"""Chapter 10, speed against accuracy: how to read the chart, the charts of the study over seconds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mcdenoise.study.charts import GREY, _label_points
from mcdenoise.study.figures._ch10_data import (
    THOUSAND,
    key_of,
    mean_over_scenes,
    milliseconds,
    samples_worth,
    study,
    table,
    usual_points,
    words,
)
from mcdenoise.study.front import equal_error_spp, equal_time_error
from mcdenoise.study.speed_accuracy_charts import budget_figure, draw_front, pooled_figure, scenes_figure
from mcdenoise.study.speed_accuracy_results import (
    UNFILTERED,
    Point,
    best_for_a_time,
    equal_spp,
    equal_time,
    front,
    missing,
    pays_from,
    pooled,
    pooled_monte_carlo,
    scene_monte_carlo,
    scene_points,
)
from mcdenoise.study.speed_accuracy_style import ERROR, log_axes, styles
from mcdenoise.study.studies import STUDIES

READ = "dof"  # the scene that the chart is explained with


def reading() -> tuple[Figure, dict]:
    """One scene, usual settings: the front, and what equal error and equal time mean for one filter."""
    found = study("speed-accuracy")
    spp, look = found["settings"]["chart_spp"], styles(found)
    points = [p for p in scene_points(found, READ, spp).values() if p.usual and not p.peer and p.curve != UNFILTERED]
    rival = scene_monte_carlo(found, READ)
    told = min(points, key=lambda point: point.relmse)
    samples = equal_error_spp(told.relmse, rival.spp, rival.relmse)
    error = equal_time_error(told.seconds, 0.0, rival.seconds_per_spp, rival.spp, rival.relmse)
    figure = Figure(figsize=(9.6, 5.4), layout="constrained")
    axes = figure.subplots()
    for point in points:
        axes.plot(point.seconds, point.relmse, **look[point.curve].line(markersize=9, linewidth=0, zorder=4))
    seen = rival.spp >= spp / 2
    axes.plot(rival.seconds[seen], rival.relmse[seen], "--", marker=".", markersize=9, color=GREY)
    best = front(points, rival)
    stairs = draw_front(axes, [one for one in best if one[1] >= rival.seconds[seen][0]])
    axes.fill_between([told.seconds, 1e3], told.relmse, 1e3, color=look[told.curve].colour, alpha=0.07, linewidth=0)
    arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 2, "shrinkA": 6, "shrinkB": 0}
    for x, y in ((samples * rival.seconds_per_spp, told.relmse), (told.seconds, error)):
        axes.annotate("", (x, y), (told.seconds, told.relmse), arrowprops=arrow)
    axes.set(
        xlim=(rival.seconds[seen][0] / 1.3, max(2 * samples * rival.seconds_per_spp, 1.5 * max(p.seconds for p in points))),
        ylim=(min(told.relmse, error, rival.relmse[rival.spp <= 4 * samples].min()) / 1.3, rival.relmse[seen][0] * 1.4),
        title=f"{READ}, {spp} spp", xlabel="seconds: rendering the samples + filtering", ylabel=ERROR,
    )  # fmt: skip
    log_axes(axes)
    names = [(p.seconds, p.relmse, p.curve, look[p.curve].colour) for p in points]
    names += [
        (x, y, f"Monte Carlo, {n:g} spp", GREY)
        for n, x, y in zip(rival.spp, rival.seconds, rival.relmse, strict=True)
        if n in (spp, 16 * spp)
    ]
    names.append((samples * rival.seconds_per_spp, told.relmse, f"equal error: {samples:.0f} spp", "black"))
    names.append((told.seconds, error, f"equal time: relMSE {error:.4f}", "black"))
    curve = list(zip(rival.seconds[seen], rival.relmse[seen], strict=True))
    draw_labels(figure, axes, names, [stairs, curve])
    numbers = {"method": told.curve, "seconds": told.seconds, "relmse": told.relmse, "equal_spp": samples}
    more = {"equal_time": error, "spp": spp, "ms_a_spp": THOUSAND * rival.seconds_per_spp, "scene": f"`{READ}`"}
    return figure, {**numbers, **more, "front": words(label for label, *_ in best if "Monte Carlo" not in label)}


def draw_labels(figure: Figure, axes: Axes, names: Sequence[Any], lines: Sequence[Any]) -> None:
    """Labels, once the layout is known."""
    FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    _label_points(axes, names, lines)


def chart_pooled() -> tuple[Figure, dict]:
    """The study's chart over all scenes, with every number of the usual settings, and the tables that the page shows."""
    found = study("speed-accuracy")
    settings, rival = found["settings"], pooled_monte_carlo(found)
    spp, points = settings["chart_spp"], pooled(found, found["settings"]["chart_spp"])
    best = front(points.values(), rival)
    usual = usual_points(found)
    numbers = {
        "spp": spp,
        "size": settings["size"],
        "choosing_seconds": sum(entry.get("choose_seconds", 0.0) for entry in found["entries"].values()),
        "seeds": settings["seeds"],
        "minutes": {name: sum(study(name)["seconds"].values()) / 60 for name in STUDIES},
        "cores": found["cores"],
        "scenes": len(settings["scenes"]),
        "reference_spp": settings["reference_spp"],
        "ms_a_spp": THOUSAND * rival.seconds_per_spp,
        "unfiltered": points[UNFILTERED].relmse,
        "front": words(label for label, *_ in best if "Monte Carlo" not in label),
        "missing": ", ".join(missing(found)) or "none",
        "methods": _numbers(found, usual, spp),
    }
    worth = {label: one["equal_spp"] for label, one in numbers["methods"].items()}
    ours = [key_of(label) for label, point in usual.items() if not point.peer]
    numbers["best"] = next(label for label in usual if key_of(label) == max(ours, key=worth.get))
    numbers["best_equal_spp"] = max(worth[key] for key in ours)
    on_front = {one[0] for one in best}
    for key, peer in (("table", False), ("peers", True)):
        some = {label: point for label, point in usual.items() if point.peer == peer}
        numbers[key] = _table(some, numbers["methods"], on_front)
    return pooled_figure(found), numbers


def _numbers(found: dict, usual: dict[str, Point], spp: int) -> dict[str, dict[str, Any]]:
    """Key of a method -> what its usual setting reaches, pooled."""
    equal, rivals = equal_spp(found, spp), equal_time(found, spp)
    numbers = {}
    for label, point in usual.items():
        worth = mean_over_scenes(equal[point.label])
        numbers[key_of(label)] = {
            "relmse": point.relmse,
            "seconds": point.filter_seconds,
            "equal_spp": worth,
            "equal_time": mean_over_scenes(rivals[point.label]),
            "pays_from_ms": THOUSAND * pays_from(point.filter_seconds, spp, worth),
            "setting": point.setting,
            "peer": point.peer,
        }
    return numbers


def _table(usual: dict[str, Point], numbers: dict[str, dict[str, Any]], on_front: set[str]) -> str:
    """Usual settings, a row each."""
    head = (
        "method",
        "filtering, ms",
        "relMSE x 1000",
        "equal-error spp",
        "equal-time relMSE x 1000",
        "pays from, ms a spp",
        "front",
    )
    rows = []
    for label, point in usual.items():
        one = numbers[key_of(label)]
        pays = "never" if np.isinf(one["pays_from_ms"]) else f"{one['pays_from_ms']:.2g}"
        worth, rival = samples_worth(one["equal_spp"]), f"{THOUSAND * one['equal_time']:.2f}"
        filtered, error = milliseconds(one["seconds"]), f"{THOUSAND * one['relmse']:.2f}"
        rows.append((label, filtered, error, worth, rival, pays, "yes" if point.label in on_front else ""))
    return table(head, rows)


def chart_scenes() -> tuple[Figure, dict]:
    """The study's chart scene by scene; who is on each front, and the best of ours."""
    found, numbers = study("speed-accuracy"), {}
    spp = found["settings"]["chart_spp"]
    for scene in found["settings"]["scenes"]:
        points, rival = scene_points(found, scene, spp), scene_monte_carlo(found, scene)
        ours = [p for p in points.values() if not p.peer and p.curve != UNFILTERED]
        best = min(ours, key=lambda point: point.relmse)
        names = dict.fromkeys(points[label].curve for label, *_ in front(points.values(), rival) if label in points)
        numbers[scene] = {
            "best": words([best.label]),
            "relmse": best.relmse,
            "unfiltered": points[UNFILTERED].relmse,
            "equal_spp": equal_error_spp(best.relmse, rival.spp, rival.relmse),
            "front": words(names),
        }
    head = (
        "scene",
        "unfiltered x 1000",
        "the most accurate of ours",
        "relMSE x 1000",
        "equal-error spp",
        "filters on the front",
    )
    rows = [
        (f"`{scene}`", f"{THOUSAND * of['unfiltered']:.2f}", of["best"], f"{THOUSAND * of['relmse']:.2f}",
         f"{of['equal_spp']:.0f}", of["front"])
        for scene, of in numbers.items()
    ]  # fmt: skip
    return scenes_figure(found), numbers | {"table": table(head, rows)}


def chart_budget() -> tuple[Figure, dict]:
    """The study's chart over all spp: the front of everything, as a list of what to do with how much time."""
    found = study("speed-accuracy")
    best = best_for_a_time(found)
    rows, seen = [], set()
    for point in best:
        name = ("Monte Carlo" if point.curve == UNFILTERED else point.curve, point.spp)
        if name not in seen:
            seen.add(name)
            rows.append((f"{point.seconds:.3g}", name[0], f"{point.spp}", f"{THOUSAND * point.relmse:.2f}"))
    filtered = [point for point in best if point.curve != UNFILTERED]
    last = max(filtered, key=lambda point: point.seconds)
    numbers = {
        "points": len(best),
        "filtered": len(filtered),
        "last": last.curve,
        "last_spp": last.spp,
        "last_seconds": last.seconds,
        "longest": max(point.seconds for point in best),
        "methods": words(dict.fromkeys(point.curve for point in filtered)),
        "table": _two_halves(("seconds, from", "method", "spp", "relMSE x 1000"), rows),
    }
    figure = budget_figure(found)
    figure.suptitle(
        "What to do with a given time: all spp, geometric means over the scenes (large markers: on the front)"
    )
    return figure, numbers


def _two_halves(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A long table as two side by side.

    Examples
    --------
    >>> print(_two_halves(("a", "b"), [("1", "2"), ("3", "4"), ("5", "6")]))
    | a | b | a | b |
    |---|---|---|---|
    | 1 | 2 | 5 | 6 |
    | 3 | 4 |  |  |
    """
    half = (len(rows) + 1) // 2
    right = [*rows[half:], ("",) * len(head)][:half]
    return table(head * 2, [a + b for a, b in zip(rows[:half], right, strict=True)])
