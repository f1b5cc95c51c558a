"""The charts of the study over seconds: scene by scene, pooled, and what to do with a given time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import groupby, pairwise
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from mcdenoise.study.charts import GREY, _label_points
from mcdenoise.study.speed_accuracy_results import (
    UNFILTERED,
    MonteCarlo,
    Point,
    best_for_a_time,
    front,
    pooled,
    pooled_monte_carlo,
    scene_monte_carlo,
    scene_points,
)
from mcdenoise.study.speed_accuracy_style import ERROR, Style, heading, log_axes, styles

SECONDS = "seconds: rendering the samples + filtering"


def curves_of(points: Iterable[Point]) -> list[list[Point]]:
    """Return the points that belong together, the settings of a method, without the unfiltered image.

    Examples
    --------
    >>> points = [Point(*names, True, False, 8, 0.1, 0.1, (0.1,)) for names in (("a", "1"), ("a", "2"), ("b", ""))]
    >>> [len(curve) for curve in curves_of(points)]
    [2, 1]
    """
    kept = (point for point in points if point.curve != UNFILTERED)
    return [list(group) for _, group in groupby(kept, key=lambda point: point.curve)]


def draw_curves(
    axes: Axes, points: Iterable[Point], look: Mapping[str, Style], seconds: Callable[[Point], float], size: float = 7
) -> list[list[tuple[float, float]]]:
    """Draw a curve a method, with bars from the best to the worst seed; return the corners of the curves."""
    lines = []
    for curve in curves_of(points):
        style, x, y = look[curve[0].curve], [seconds(one) for one in curve], [one.relmse for one in curve]
        reach = [(min(one.per_seed), max(one.per_seed)) for one in curve]
        axes.vlines(x, *zip(*reach, strict=True), color=style.colour, linewidth=1.2, alpha=0.7)
        axes.plot(x, y, **style.line(markersize=size, zorder=4))
        lines.append(list(zip(x, y, strict=True)))
    return lines


def draw_rival(axes: Axes, rival: MonteCarlo, size: float = 5) -> None:
    """Draw Monte Carlo: a dashed line through what was measured, with bars."""
    axes.vlines(rival.seconds, rival.per_seed.min(axis=1), rival.per_seed.max(axis=1), color=GREY, linewidth=1.2)
    axes.plot(rival.seconds, rival.relmse, "--", marker=".", markersize=size + 3, color=GREY)


def draw_front(axes: Axes, places: Sequence[tuple[str, float, float]]) -> list[tuple[float, float]]:
    """Draw the Pareto front as stairs, and return their corners: between two points the faster one is the best there is."""
    stairs = [places[0][1:]]
    for before, after in pairwise(places):
        stairs += [(after[1], before[2]), after[1:]]
    axes.plot(*zip(*stairs, strict=True), color="black", linewidth=1, zorder=1)
    return stairs


def legend_entries(labels: Iterable[str], look: Mapping[str, Style]) -> list[Line2D]:
    """Return what a legend shows of methods, Monte Carlo and the front."""
    entries = [Line2D([], [], label=label, **look[label].line(markersize=7)) for label in labels]
    rival = Line2D([], [], linestyle="--", marker=".", markersize=8, color=GREY, label="Monte Carlo, more samples")
    return [*entries, rival, Line2D([], [], color="black", linewidth=1, label="Pareto front")]


def scenes_figure(found: Mapping[str, Any]) -> Figure:
    """Chart seconds against relMSE, a panel a scene, at the spp of the charts."""
    settings, look = found["settings"], styles(found)
    spp, scenes = settings["chart_spp"], settings["scenes"]
    rows = -(-(len(scenes) + 1) // 3)
    figure = Figure(figsize=(12, 4.2 * rows + 0.4), layout="constrained")
    figure.suptitle(f"Speed against accuracy at {spp} spp, scene by scene ({heading(found)}; bars: from seed to seed)")
    grid = figure.subplots(rows, 3, squeeze=False).ravel()
    charts = []
    for axes, scene in zip(grid, scenes, strict=False):
        points, rival = scene_points(found, scene, spp), scene_monte_carlo(found, scene)
        charts.append((axes, *_chart(axes, points, rival, look, spp)))
        axes.set(title=scene, xlabel=SECONDS, ylabel="relMSE")
    for axes in grid[len(scenes) :]:
        axes.axis("off")
    met = {point.curve for scene in scenes for point in scene_points(found, scene, spp).values()}
    labels = [label for label in look if label in met]
    grid[len(scenes)].legend(handles=legend_entries(labels, look), loc="center", frameon=False, fontsize=9)
    return _labelled(figure, charts)


def pooled_figure(found: Mapping[str, Any]) -> Figure:
    """Chart seconds against relMSE pooled over the scenes: left with rendering and Monte Carlo, right the filters alone."""
    settings, look = found["settings"], styles(found)
    spp = settings["chart_spp"]
    points, rival = pooled(found, spp), pooled_monte_carlo(found)
    figure = Figure(figsize=(12, 6.6), layout="constrained")
    figure.suptitle(
        f"Speed against accuracy at {spp} spp, geometric means over {len(settings['scenes'])} scenes "
        f"({heading(found)}; bars: from seed to seed)"
    )
    whole, alone = figure.subplots(1, 2, width_ratios=(1.25, 1), sharey=True)
    names, lines = _chart(whole, points, rival, look, spp, every=True)
    whole.set(title="Rendering + filtering", xlabel=SECONDS, ylabel=ERROR)
    right = draw_curves(alone, points.values(), look, lambda point: point.filter_seconds)
    level = points[UNFILTERED].relmse
    alone.axhline(level, linestyle="--", color=GREY)
    alone.set(title="Filtering alone", xlabel="seconds: samples in, image out")
    log_axes(alone)
    ends = usual_names(points.values(), look, lambda point: point.filter_seconds)
    ends.append((alone.get_xlim()[0], level, f"unfiltered, {spp} spp", GREY))
    return _labelled(figure, [(whole, names, lines), (alone, ends, [*right, [(x, level) for x in alone.get_xlim()]])])


def budget_figure(found: Mapping[str, Any]) -> Figure:
    """Chart seconds against relMSE over all spp: what to do with a given time. The front is named."""
    settings, look, rival = found["settings"], styles(found), pooled_monte_carlo(found)
    tables = [pooled(found, spp) for spp in settings["spps"]]
    everybody = [point for table in tables for point in table.values() if point.curve != UNFILTERED]
    figure = Figure(figsize=(12, 6.6), layout="constrained")
    figure.suptitle(
        f"What to do with a given time: usual settings from {settings['spps'][0]} to {settings['spps'][-1]} spp, "
        f"pooled ({heading(found)})\nlarge markers: any setting that is on the front"
    )
    axes, beside = figure.subplots(1, 2, width_ratios=(3.2, 1))
    usual = [point for point in everybody if point.usual]
    usual.sort(key=lambda point: (list(look).index(point.curve), point.spp))
    lines = draw_curves(axes, usual, look, lambda point: point.seconds, size=5)
    draw_rival(axes, rival)
    best = best_for_a_time(found)
    lines.append(draw_front(axes, [(point.label, point.seconds, point.relmse) for point in best]))
    for point in best:
        if point.curve != UNFILTERED:
            axes.plot(point.seconds, point.relmse, **look[point.curve].line(markersize=9, zorder=5))
    axes.set(xlabel=SECONDS, ylabel=ERROR)
    log_axes(axes)
    last = {(point.curve, point.spp): point for point in best if point.curve != UNFILTERED}
    names = [(p.seconds, p.relmse, f"{p.curve}, {p.spp} spp", look[p.curve].colour) for p in last.values()]
    beside.axis("off")
    labels = dict.fromkeys(point.curve for point in usual)
    beside.legend(handles=legend_entries(labels, look), loc="center left", frameon=False, fontsize=9)
    return _labelled(figure, [(axes, names, lines)])


def usual_names(
    points: Iterable[Point], look: Mapping[str, Style], seconds: Callable[[Point], float]
) -> list[tuple[float, float, str, str]]:
    """Return the labels of the methods at their usual settings, as `_label_points` takes them."""
    usual = (point for point in points if point.usual and point.curve != UNFILTERED)
    return [(seconds(point), point.relmse, point.curve, look[point.curve].colour) for point in usual]


def _chart(
    axes: Axes,
    points: Mapping[str, Point],
    rival: MonteCarlo,
    look: Mapping[str, Style],
    spp: int,
    every: bool = False,
) -> tuple[list[Any], list[Any]]:
    """Curves, Monte Carlo and the front in one panel; return what is to be labelled, and lines to keep clear of.

    Named are the methods on the front, or every method at its usual setting, and some of Monte Carlo.
    """
    lines = draw_curves(axes, points.values(), look, lambda point: point.seconds, size=8 if every else 6)
    draw_rival(axes, rival)
    best = front(points.values(), rival)
    lines.append(draw_front(axes, best))
    shown = [point for point in points.values() if point.curve != UNFILTERED]
    slowest = max(point.seconds for point in shown)
    seen = rival.seconds <= 1.3 * slowest
    errors = [*(point.relmse for point in shown), points[UNFILTERED].relmse, *rival.relmse[seen & (rival.spp >= spp)]]
    axes.set(xscale="log", yscale="log")
    axes.set(xlim=(spp * rival.seconds_per_spp / 2, slowest * 1.6), ylim=(min(errors) / 1.4, max(errors) * 1.6))
    log_axes(axes)
    if every:
        names = usual_names(shown, look, lambda point: point.seconds)
    else:
        last = {points[label].curve: points[label] for label, *_ in best if label in points}
        names = [(point.seconds, point.relmse, point.curve, look[point.curve].colour) for point in last.values()]
    for n, seconds, error in zip(rival.spp, rival.seconds, rival.relmse, strict=True):
        if n == spp or (every and spp < n and seconds < slowest):
            names.append((seconds, error, f"MC {n:g} spp", GREY))
    return names, [*lines, list(zip(rival.seconds[seen], rival.relmse[seen], strict=True))]


def _labelled(figure: Figure, charts: Sequence[tuple[Axes, list[Any], list[Any]]]) -> Figure:
    """Put the labels where the points will be, once the layout is known."""
    FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    for axes, points, lines in charts:
        _label_points(axes, points, [line for line in lines if len(line) > 1])
    return figure
