"""The two pictures of a comparison: seconds against relMSE, and every image beside its crops and error map."""

from __future__ import annotations

from collections.abc import Callable
from itertools import cycle, groupby, pairwise, zip_longest
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from mcdenoise.samples.storage import write_beside
from mcdenoise.study.compare import REPEATS, Comparison, Result
from mcdenoise.study.display import error_colours, error_scale, tone_map

# Paul Tol's "bright" scheme, then some of his "vibrant" and "muted": distinguishable with any colour vision.
COLOURS = (
    "#4477AA", "#EE6677", "#228833", "#AA3377", "#66CCEE", "#CCBB44", "#EE7733", "#332288", "#CC3311", "#009988",
)  # fmt: skip
MARKERS = ("o", "s", "^", "D", "v", "P", "*", "X", "p", "<")
GREY = "#777777"
CROP_COLOURS = ("#FFD700", "#00E5FF")
MANY_DECADES = 1e3  # from end to end of an axis: beyond, numbers at 2 and 5 would touch
SMALLEST_ERROR = 1e-9  # where a logarithmic axis needs a number for 0
ABOVE_LABELS = 4  # zorder
POINT_WEIGHT = 4  # a point must not be covered; a line may be, if need be
Point = tuple[float, float, str, str]  # seconds, relMSE, label, colour
Line = list[tuple[float, float]]
CROP_SHARE = 4  # a crop is a quarter of the image's side


def save_figure(figure: Figure, path: Path) -> None:
    """Write `figure` as a PNG beside `path`, then rename."""
    FigureCanvasAgg(figure)
    with write_beside(path) as temporary:
        figure.savefig(temporary, dpi=150)


def error_ceiling(comparison: Comparison) -> float:
    """Return the top of the error scale that all error maps share: the 99th percentile of the unfiltered image's errors."""
    return max(float(np.percentile(comparison.error_map(comparison.unfiltered), 99)), 1e-6)


def heading(comparison: Comparison) -> str:
    """Return the line that says what was measured."""
    return (
        f"scene {comparison.scene}, {comparison.size} x {comparison.size} pixels, {comparison.spp} spp, "
        f"{comparison.provenance.get('variant', '?')}, {comparison.provenance['cores']} cores"
    )


def speed_accuracy_figure(comparison: Comparison) -> Figure:
    """Chart seconds against relMSE, both logarithmic: left with rendering and the Monte Carlo rival, right the filters alone."""
    figure = Figure(figsize=(12, 5.6), layout="constrained")
    figure.suptitle(f"Speed against accuracy: {heading(comparison)}")
    whole, alone = figure.subplots(1, 2, width_ratios=(1.5, 1), sharey=True)
    errors = [max(result.relmse, SMALLEST_ERROR) for result in comparison.results]
    whole.set(yscale="log", ylim=(min(errors) / 1.5, max(errors) * 2.5))
    charts = [(whole, *_chart_whole(whole, comparison)), (alone, *_chart_filters(alone, comparison))]
    FigureCanvasAgg(figure)
    figure.draw_without_rendering()  # lays out: labels are put where the points will be
    for axes, points, lines in charts:
        _label_points(axes, points, lines)
    return figure


def _chart_whole(axes: Axes, comparison: Comparison) -> tuple[list[Point], list[Line]]:
    """Rendering and filtering together, the Monte Carlo line, the Pareto front."""
    unfiltered = comparison.unfiltered
    spp = comparison.spp * np.geomspace(1, 32, 64)
    axes.plot(
        comparison.render_fixed_seconds + spp * comparison.render_seconds_per_spp,
        unfiltered.relmse * comparison.spp / spp,
        "--",
        color=GREY,
        label="Monte Carlo, error proportional to 1/N",
    )
    front = comparison.front()
    places = [(result.seconds, result.relmse) for result in front]
    corners = [(after[0], before[1]) for before, after in pairwise(places)]
    stairs = [place for pair in zip_longest(places, corners) for place in pair if place]
    axes.plot(*zip(*stairs, strict=True), color="black", linewidth=1, label="Pareto front")
    for result in (unfiltered, *comparison.rivals):
        axes.plot(result.seconds, result.relmse, "o", color=GREY, markersize=5, zorder=ABOVE_LABELS)
    points = [(r.seconds, r.relmse, r.label, GREY) for r in (unfiltered, *comparison.rivals)]
    found, lines = _draw_filters(axes, comparison.filters, lambda result: result.seconds)
    points += found
    _log_axes(axes, points)
    axes.set(title="Rendering + filtering", xlabel="seconds", ylabel="relMSE (lower is better)")
    axes.legend(loc="upper right", frameon=False)
    return points, [*lines, stairs]


def _chart_filters(axes: Axes, comparison: Comparison) -> tuple[list[Point], list[Line]]:
    """The filters' own seconds."""
    points, lines = _draw_filters(axes, comparison.filters, lambda result: result.filter_seconds)
    _log_axes(axes, points)
    level = [(seconds, comparison.unfiltered.relmse) for seconds in axes.get_xlim()]
    axes.plot(*zip(*level, strict=True), "--", color=GREY)
    axes.annotate(
        f"unfiltered, {comparison.spp} spp",
        (0.02, comparison.unfiltered.relmse),
        xycoords=("axes fraction", "data"),
        xytext=(0, -11),
        textcoords="offset points",
        color=GREY,
        fontsize=9,
    )
    axes.set(title=f"Filtering alone (median of {REPEATS} runs, fewer where slow)", xlabel="seconds")
    return points, [*lines, level]


def _draw_filters(
    axes: Axes, results: tuple[Result, ...], seconds: Callable[[Result], float]
) -> tuple[list[Point], list[Line]]:
    """Draw a point a result, the points of one method joined; return the points, and the lines.

    The last point of a curve has the name of the method, the others only what is theirs.
    """
    points, lines = [], []
    for (colour, marker), curve in zip(cycle(zip(COLOURS, MARKERS, strict=True)), _curves(results), strict=False):
        places = [(seconds(result), max(result.relmse, SMALLEST_ERROR)) for result in curve]
        axes.plot(*zip(*places, strict=True), "-", color=colour, linewidth=1)
        lines.append(places)
        for result, place in zip(curve, places, strict=True):
            axes.plot(*place, marker, color=colour, markersize=9, zorder=ABOVE_LABELS)
            points.append((*place, result.label if result is curve[-1] else result.point, colour))
    return points, lines


def _curves(results: tuple[Result, ...]) -> list[list[Result]]:
    """Results that belong together, in their order: the variants of one method, or one alone."""
    return [list(group) for _, group in groupby(results, key=lambda result: result.curve or result.name)]


def _log_axes(axes: Axes, points: list[Point]) -> None:
    """Logarithmic axes with room around the points for their labels, and plain numbers at 1, 2, 5 as far as they fit."""
    seconds = [point[0] for point in points] or [1e-3]
    axes.set(xscale="log", xlim=(min(seconds) / 1.6, max(seconds) * 1.6))
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < MANY_DECADES * low else (1,)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.grid(visible=True, color="#e5e5e5", linewidth=0.6)
    axes.set_axisbelow(True)


def _label_points(axes: Axes, points: list[Point], lines: list[Line]) -> None:
    """Write each point's label where it covers least: beside the point if there is room, else farther off with a leader."""
    extent, dots = axes.get_window_extent(), 72 / axes.figure.dpi
    corner, size = np.array([extent.x0, extent.y0]) * dots, np.array([extent.width, extent.height]) * dots
    places = [
        axes.transData.transform((seconds, max(error, SMALLEST_ERROR))) * dots - corner for seconds, error, *_ in points
    ]
    taken = [(*(place - 5), *(place + 5)) for place in places] * POINT_WEIGHT
    for line in lines:
        taken += _boxes_along(axes.transData.transform(line) * dots - corner)
    for place, (seconds, error, label, colour) in sorted(zip(places, points, strict=True), key=lambda one: -one[1][1]):
        box, reach = min(_label_boxes(place, label), key=lambda one: _covered(one[0], taken, size) + 0.3 * one[1])
        taken.append(box)
        shift = np.subtract(box[:2], place)
        text = axes.annotate(
            label,
            (seconds, max(error, SMALLEST_ERROR)),
            xytext=(shift[0], shift[1] + 2),
            textcoords="offset points",
            arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.6} if reach > 16 else None,
            color=colour,
            fontsize=9,
        )
        text.set_in_layout(False)
        text.set_path_effects([withStroke(linewidth=3, foreground="white")])


def _boxes_along(line: np.ndarray) -> list[tuple[float, ...]]:
    """Small boxes that cover a line of corners (n, 2), in points.

    Examples
    --------
    >>> len(_boxes_along(np.array([[0.0, 0.0], [40.0, 0.0]])))
    10
    """
    boxes = []
    for start, end in pairwise(line):
        steps = max(int(np.hypot(*(end - start)) / 4), 1)
        boxes += [(*(place - 2), *(place + 2)) for place in np.linspace(start, end, steps, endpoint=False)]
    return boxes


def _label_boxes(place: np.ndarray, label: str) -> list[tuple[tuple[float, ...], float]]:
    """Boxes (left, bottom, right, top) around a point that a label may take, in points, with their distance from it."""
    width, height = 5.4 * len(label), 11.0
    boxes = []
    for reach in (9.0, 18.0, 30.0, 45.0, 60.0):
        for right, up in ((1, 0), (-1, 0), (1, -1), (1, 1), (-1, -1), (-1, 1), (0, 1), (0, -1)):
            near = place + reach * np.array([right, up]) / np.hypot(right, up)
            left = near[0] - width * (1 - right) / 2
            boxes.append(((left, near[1] - height / 2, left + width, near[1] + height / 2), reach))
    return boxes


def _covered(box: tuple[float, ...], taken: list[tuple[float, ...]], size: np.ndarray) -> float:
    """How much of what is taken, and of the outside of the axes, a box would cover, in square points.

    Examples
    --------
    >>> _covered((0, 0, 10, 10), [(5, 5, 20, 20)], np.array([100, 100]))
    25.0
    """
    left, bottom, right, top = box
    inside = max(min(right, size[0]) - max(left, 0), 0) * max(min(top, size[1]) - max(bottom, 0), 0)
    over = [max(min(right, c) - max(left, a), 0) * max(min(top, d) - max(bottom, b), 0) for a, b, c, d in taken]
    return float(sum(over) + 4 * ((right - left) * (top - bottom) - inside))


def shown(comparison: Comparison) -> list[Result]:
    """Return the images worth a column: the input, each filter, and Monte Carlo at the time of the slowest filter.

    Of the variants of one method the slowest is shown.
    """
    slowest = max(comparison.filters, key=lambda r: r.seconds, default=None)
    rival = [r for r in comparison.rivals if slowest is not None and slowest.label in r.equal_time_with]
    return [comparison.unfiltered, *(curve[-1] for curve in _curves(comparison.filters)), *rival]


def images_figure(comparison: Comparison) -> Figure:
    """Show the input, every filter, the equal-time rival and the reference: whole, two crops, and error on one scale."""
    results = shown(comparison)
    crops, ceiling = crop_corners(comparison), error_ceiling(comparison)
    figure = Figure(figsize=(2.3 * (len(results) + 1) + 0.6, 9.6), layout="constrained")
    figure.suptitle(f"Images, crops and relative squared error: {heading(comparison)}\n(one tone map: clip, sRGB)")
    grid = figure.subplots(4, len(results) + 1, squeeze=False)
    for column, result in zip(grid.T, results, strict=False):
        _draw_image(column, f"{_two_lines(result)}\nrelMSE {result.relmse:.4f}", result.image, crops)
        column[3].imshow(error_colours(comparison.error_map(result), ceiling), interpolation="nearest")
    _draw_image(grid[:, -1], f"reference\n{comparison.reference_spp} spp", comparison.reference, crops)
    grid[3, -1].axis("off")
    for axes in grid.flat:
        axes.set(xticks=[], yticks=[])
    for axes, name in zip(grid[:, 0], ("whole image", "crop 1", "crop 2", "error"), strict=True):
        axes.set_ylabel(name)
    bar = figure.colorbar(error_scale(ceiling), ax=grid[3, -1], fraction=0.5, aspect=8)
    bar.set_label("(x - ref)² / (ref² + 0.01)")
    return figure


def _two_lines(result: Result) -> str:
    """The label, that of a curve above that of its point."""
    return f"{result.curve}\n{result.point}" if result.point else result.label


def _draw_image(column: np.ndarray, title: str, image: np.ndarray, crops: list[tuple[int, int]]) -> None:
    """Fill the first three axes of a column: the whole image with the crops marked, then the crops."""
    display, side = tone_map(image), len(image) // CROP_SHARE
    column[0].imshow(display, interpolation="nearest")
    column[0].set_title(title, fontsize=10)
    for axes, (y, x), colour in zip(column[1:3], crops, CROP_COLOURS, strict=True):
        column[0].add_patch(Rectangle((x - 0.5, y - 0.5), side, side, fill=False, edgecolor=colour))
        axes.imshow(display[y : y + side, x : x + side], interpolation="nearest")
        for spine in axes.spines.values():
            spine.set(edgecolor=colour, linewidth=2)


def crop_corners(comparison: Comparison) -> list[tuple[int, int]]:
    """Return (y, x) of two crops, chosen by the data: where the input errs most, and where the best filter errs most."""
    side, ceiling = comparison.size // CROP_SHARE, error_ceiling(comparison)
    best = min(comparison.filters, key=lambda r: r.relmse, default=comparison.unfiltered)
    corners: list[tuple[int, int]] = []
    for result in (comparison.unfiltered, best):
        error = np.minimum(comparison.error_map(result), ceiling)
        sums = np.pad(error, ((1, 0), (1, 0))).cumsum(0).cumsum(1)
        box = sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side]
        for y, x in corners:
            box[max(y - side + 1, 0) : y + side, max(x - side + 1, 0) : x + side] = -1
        y, x = np.unravel_index(np.argmax(box), box.shape)
        corners.append((int(y), int(x)))
    return corners
