"""Charts of the study of stability, made from the stored numbers alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, NullFormatter

from mcdenoise.study.charts import COLOURS, GREY, MARKERS
from mcdenoise.study.methods import METHODS
from mcdenoise.study.stability_catalogue import CATALOGUE
from mcdenoise.study.stability_tables import (
    MOST_TIMES,
    each,
    firefly_damage,
    noise_curves,
    short,
)
from mcdenoise.study.stability_troubles import FIREFLY_VALUES, NOISE_LEVELS

Found = Mapping[str, Any]
LOOKS = dict(zip(METHODS, zip(COLOURS, MARKERS, strict=True), strict=True))
HELD, BROKEN = "#4477AA", "#EE7733"
DECADES_SHOWN = 3  # of value / bound, to both sides
SHOWN_APART = ("few_spp", "texture", "penumbra", "bokeh", "high_range", "mutual_information")
NUMBER = FuncFormatter(lambda value, _: f"{value:g}")


def charts(found: Found) -> dict[str, Figure]:
    """Return name -> chart, of those whose entries are there.

    Examples
    --------
    >>> charts({"entries": {}})
    {}
    """
    made: dict[str, tuple[Callable[[Found], Figure], set[str]]] = {
        "overview": (overview, set(CATALOGUE)),
        "breakdown": (breakdown_chart, {"noise_level"}),
        "fireflies": (firefly_chart, {"firefly_value", "firefly_count", "noise_level"}),
        "bias_variance": (bias_variance, set(SHOWN_APART)),
        "times": (times_chart, {"few_spp"}),
    }
    return {name: draw(found) for name, (draw, needed) in made.items() if needed <= found["entries"].keys()}


def margin(numbers: Mapping[str, Any]) -> float:
    """How far a number is from its bound, in decades, cut off: below 0 it is held.

    Examples
    --------
    >>> margin({"value": 0.1, "bound": 1.0, "held": True}), margin({"value": None, "bound": 1.0, "held": False})
    (-1.0, 3.0)
    """
    if numbers["value"] is None:
        return float(DECADES_SHOWN)
    if numbers["value"] <= 0 or numbers["bound"] == 0:
        return float(-DECADES_SHOWN if numbers["held"] else DECADES_SHOWN)
    return float(np.clip(np.log10(numbers["value"] / numbers["bound"]), -DECADES_SHOWN, DECADES_SHOWN))


def worst_level(entry: Found, method: str) -> Mapping[str, Any]:
    """The numbers of the level with the largest number of a method."""
    return max(
        (level["methods"][method] for level in entry["levels"]),
        key=lambda one: np.inf if one["value"] is None else one["value"],
    )


def overview(found: Found) -> Figure:
    """Entries x methods: the worst number of each, blue where the guarantee is held, orange with a cross where not."""
    names = [name for name in CATALOGUE if name in found["entries"]]
    cells = [[worst_level(found["entries"][name], method) for method in METHODS] for name in names]
    figure = Figure(figsize=(12, 0.36 * len(names) + 1.9), layout="constrained")
    axes = figure.subplots()
    colours = LinearSegmentedColormap.from_list("held", [HELD, "#f7f7f7", BROKEN])
    shown = axes.imshow(
        [[margin(one) for one in row] for row in cells],
        colours,
        TwoSlopeNorm(0, -DECADES_SHOWN, DECADES_SHOWN),
        aspect="auto",
    )
    for y, row in enumerate(cells):
        for x, one in enumerate(row):
            text = "no image" if one["value"] is None else short(one["value"])
            axes.text(
                x, y, text if one["held"] else f"× {text}", ha="center", va="center", fontsize=8.5,
                weight="normal" if one["held"] else "bold",
            )  # fmt: skip
    axes.set_xticks(range(len(METHODS)), [method.label.replace(", ", ",\n") for method in METHODS.values()], fontsize=9)
    axes.set_yticks(range(len(names)), [_row_label(name) for name in names], fontsize=8.5)
    axes.tick_params(length=0, top=True, labeltop=True, bottom=False, labelbottom=False)
    axes.set_xticks(np.arange(len(METHODS) + 1) - 0.5, minor=True)
    axes.set_yticks(np.arange(len(names) + 1) - 0.5, minor=True)
    axes.grid(which="minor", color="white", linewidth=1.5)
    axes.tick_params(which="minor", length=0)
    bar = figure.colorbar(shown, ax=axes, pad=0.01, fraction=0.02, ticks=range(-DECADES_SHOWN, DECADES_SHOWN + 1))
    bar.ax.set_yticklabels([f"{10.0**k:g} x" for k in range(-DECADES_SHOWN, DECADES_SHOWN + 1)], fontsize=8)
    bar.set_label("number / bound (blue: held, orange and ×: not)")
    settings = found["settings"]
    figure.suptitle(
        f"Guarantees where methods fail: the worst number over levels and {settings['seeds']} seeds, "
        f"{settings['size']} x {settings['size']} pixels",
        fontsize=12,
    )
    return figure


def _row_label(name: str) -> str:
    """What the row is, and its guarantee."""
    case = CATALOGUE[name]
    return f"{case.title}\n{case.unit} ≤ {case.bound:.4g}"


def breakdown_chart(found: Found) -> Figure:
    """Noise against error, and against what filtering makes of it."""
    unfiltered, curves = noise_curves(found)
    levels = found["entries"]["noise_level"]["levels"]
    figure = Figure(figsize=(12, 5.2), layout="constrained")
    whole, ratio = figure.subplots(1, 2)
    whole.plot(NOISE_LEVELS, unfiltered, "--", color=GREY, linewidth=1.5)
    ratio.axhline(1, color=GREY, linestyle="--", linewidth=1.5)
    for method, curve in curves.items():
        colour, marker = LOOKS[method]
        spread = [level["methods"][method]["relmse"]["spread"] for level in levels]
        style = {"color": colour, "marker": marker, "linewidth": 1.2, "markersize": 6}
        whole.errorbar(NOISE_LEVELS, curve, np.minimum(spread, 0.9 * curve), capsize=2, **style)
        ratio.plot(NOISE_LEVELS, curve / unfiltered, **style)
    for axes in (whole, ratio):
        axes.set(xscale="log", yscale="log", xlabel="standard deviation of one sample / truth")
        _plain_numbers(axes)
    whole.set(ylabel="relMSE", title="Error: mean and standard deviation over the seeds")
    ratio.set(ylabel="relMSE / unfiltered", title="Above 1 filtering does harm")
    _method_legend(figure, "unfiltered")
    return figure


def firefly_chart(found: Found) -> Figure:
    """What one firefly does to other pixels, and what many do to the error of the image."""
    figure = Figure(figsize=(12, 5.2), layout="constrained")
    damage, many = figure.subplots(1, 2)
    levels = found["entries"]["firefly_value"]["levels"]
    counts = np.geomspace(1, 1000, 4)
    for method, (colour, marker) in LOOKS.items():
        style = {"color": colour, "marker": marker, "linewidth": 1.2, "markersize": 6}
        damage.plot(FIREFLY_VALUES, [level["methods"][method]["value"] for level in levels], **style)
        before, added = firefly_damage(found)[method]
        many.plot(counts, before + added * counts, **style)
    damage.axhline(CATALOGUE["firefly_value"].bound, color="black", linewidth=1, linestyle=":")
    damage.text(FIREFLY_VALUES[-1], 1.15 * CATALOGUE["firefly_value"].bound, "guarantee", fontsize=9, ha="right")
    before, added = firefly_damage(found)["unfiltered"]
    many.plot(counts, before + added * counts, "--", color=GREY, linewidth=1.5)
    damage.set(
        xlabel="radiance of one sample in one pixel (white is 1)", ylabel="largest change of another pixel",
        title="One firefly: damage to others, worst over the seeds",
    )  # fmt: skip
    many.set(
        xlabel="fireflies of 10 000 a megapixel, far apart", ylabel="relMSE of the image, fireflies included",
        title="Many: spread out (low) or left where they are (high)",
    )  # fmt: skip
    for axes in (damage, many):
        axes.set(xscale="log", yscale="log")
        _plain_numbers(axes)
    _method_legend(figure, "unfiltered")
    return figure


def bias_variance(found: Found) -> Figure:
    """Squared bias below, variance above, of every method in some entries, with the unfiltered image beside them."""
    figure = Figure(figsize=(12, 6.6), layout="constrained")
    grid = figure.subplots(2, 3, sharex=True)
    for axes, name in zip(grid.flat, SHOWN_APART, strict=True):
        level = _telling_level(found["entries"][name])
        bars = [level["unfiltered"], *(level["methods"][method] for method in METHODS)]
        bias = np.array([max(one["bias_squared"] or 0, 0) for one in bars])
        variance = np.array([one["variance"] or 0 for one in bars])
        colours = [GREY, *(LOOKS[method][0] for method in METHODS)]
        places = np.arange(len(bars))
        axes.bar(places, bias, color=colours, edgecolor="black", linewidth=0.6)
        axes.bar(places, variance, bottom=bias, color="white", edgecolor=colours, linewidth=1.2, hatch="////")
        top = 1.6 * max(bias[0] + variance[0], float(np.median(bias + variance)))
        axes.set_ylim(0, top)
        for place, height in zip(places, bias + variance, strict=True):
            if height > top:
                text = axes.text(place, 0.97 * top, short(height), ha="center", va="top", fontsize=8.5, rotation=90)
                text.set_path_effects([withStroke(linewidth=2.5, foreground="white")])
        axes.axhline(bias[0] + variance[0], color=GREY, linestyle="--", linewidth=1)
        labels = ["unfiltered", *(method.label for method in METHODS.values())]
        axes.set_xticks(places, labels, rotation=50, ha="right", rotation_mode="anchor", fontsize=8.5)
        axes.set_title(f"{CATALOGUE[name].title}: {level['level']}", fontsize=10)
        axes.tick_params(axis="x", labelbottom=axes in grid[1])
    for axes in grid[:, 0]:
        axes.set_ylabel("relMSE")
    handles = [
        Patch(facecolor=GREY, edgecolor="black", label="squared bias: wrong"),
        Patch(facecolor="white", edgecolor=GREY, hatch="////", label="variance: restless"),
        Line2D([], [], color=GREY, linestyle="--", label="unfiltered"),
        Line2D([], [], linestyle="none", label="a number: of a bar that goes on"),
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=4, frameon=False)
    return figure


def _telling_level(entry: Found) -> Mapping[str, Any]:
    """The level where most methods break the guarantee; the first of equals."""
    return max(entry["levels"], key=lambda level: sum(not one["held"] for one in level["methods"].values()))


def times_chart(found: Found) -> Figure:
    """Seconds against a method's normal time, a point an entry and level."""
    figure = Figure(figsize=(12, 4.4), layout="constrained")
    axes = figure.subplots()
    rng = np.random.default_rng(0)
    for place, (method, (colour, marker)) in enumerate(LOOKS.items()):
        ratios = [one["times_normal"] for _, _, name, one in each(found) if name == method and one.get("times_normal")]
        x = place + rng.uniform(-0.28, 0.28, len(ratios))
        axes.plot(x, ratios, marker, color=colour, markersize=4, alpha=0.8, markeredgewidth=0)
    axes.axhline(MOST_TIMES, color="black", linestyle=":", linewidth=1)
    axes.text(len(LOOKS) - 0.55, MOST_TIMES * 1.05, f"target: {MOST_TIMES:g} x", ha="right", fontsize=9)
    axes.axhline(1, color=GREY, linestyle="--", linewidth=1)
    axes.set_xticks(range(len(METHODS)), [method.label.replace(", ", ",\n") for method in METHODS.values()], fontsize=9)
    axes.set(
        yscale="log",
        ylabel="seconds / normal seconds",
        title="Time on every entry and level, against a plain image of the same layout",
    )
    _plain_numbers(axes)
    axes.grid(visible=False, axis="x")
    return figure


def _plain_numbers(axes: Axes) -> None:
    """Plain numbers on logarithmic axes, and a grid."""
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_formatter(NullFormatter())
    if axes.get_yscale() == "log" and np.ptp(np.log10(axes.get_ylim())) < 4:
        axes.yaxis.set_major_formatter(NUMBER)
    if axes.get_xscale() == "log":
        axes.xaxis.set_major_formatter(NUMBER)
    axes.grid(visible=True, color="#e5e5e5", linewidth=0.6)
    axes.set_axisbelow(True)


def _method_legend(figure: Figure, dashed: str) -> None:
    """One legend for all axes, on the right."""
    handles = [
        Line2D([], [], color=colour, marker=marker, linewidth=1.2, markersize=6, label=METHODS[method].label)
        for method, (colour, marker) in LOOKS.items()
    ]
    handles.append(Line2D([], [], color=GREY, linestyle="--", linewidth=1.5, label=dashed))
    figure.legend(handles=handles, loc="outside right center", frameon=False, fontsize=9)
