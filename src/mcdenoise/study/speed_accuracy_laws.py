"""The charts of the study over everything but seconds: error over spp, growth of time, what a filter is worth in samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from mcdenoise.study.bench_rpf_accuracy import geometric_mean
from mcdenoise.study.charts import GREY
from mcdenoise.study.speed_accuracy_results import (
    NOISE_FREE,
    QUANTITIES,
    UNFILTERED,
    equal_spp,
    error_slopes,
    growth,
    pays_from,
    pooled,
    pooled_monte_carlo,
    scene_monte_carlo,
    usual_errors,
)
from mcdenoise.study.speed_accuracy_style import ERROR, Style, heading, log_axes, plain_log, spread, styles

AXES_WORDS = {"pixels": "pixels", "spp": "spp", "window": "width of the window, pixels (RPF: its box)"}
LABEL_GAP = 0.032  # of the height of an axes, between exponents beside it


def slopes_figure(found: Mapping[str, Any]) -> Figure:
    """Chart relMSE over spp, pooled over the scenes, with fitted exponents beside Monte Carlo's -1."""
    look, slopes = styles(found), error_slopes(found)
    figure = Figure(figsize=(12, 6.4), layout="constrained")
    figure.suptitle(
        f"Error against samples, usual settings, geometric means over {len(found['settings']['scenes'])} scenes "
        f"({heading(found)}; bars: from seed to seed)"
    )
    axes, beside = figure.subplots(1, 2, width_ratios=(2.2, 1))
    _draw_errors(axes, found, "", look, size=7)
    axes.set(xlabel="samples per pixel", ylabel=ERROR)
    last = {curve: errors[-1] for curve, errors in usual_errors(found).items()}
    order = sorted(last, key=lambda curve: -geometric_mean(last[curve]))
    entries = [
        Line2D([], [], label=f"{slopes[curve]['']:.2f}  {_named(curve)}", **_line(curve, look, markersize=7))
        for curve in order
    ]
    beside.axis("off")
    title = "exponent of relMSE over spp;\norder: error at the right end"
    beside.legend(handles=entries, loc="center left", frameon=False, fontsize=10, title=title, alignment="left")
    return figure


def slopes_scenes_figure(found: Mapping[str, Any]) -> Figure:
    """Chart relMSE over spp, a panel a scene: the exponents of Monte Carlo and of the method that is best at the end."""
    settings, look, slopes = found["settings"], styles(found), error_slopes(found)
    rows = -(-(len(settings["scenes"]) + 1) // 3)
    figure = Figure(figsize=(12, 3.9 * rows + 0.4), layout="constrained")
    figure.suptitle(f"Error against samples, usual settings, scene by scene ({heading(found)})")
    grid = figure.subplots(rows, 3, squeeze=False).ravel()
    for axes, scene in zip(grid, settings["scenes"], strict=False):
        errors = usual_errors(found, scene)
        _draw_errors(axes, found, scene, look, size=4)
        best = min(
            (curve for curve in errors if curve != UNFILTERED), key=lambda curve: geometric_mean(errors[curve][-1])
        )
        rival = scene_monte_carlo(found, scene).slope(settings["reference_spp"] / NOISE_FREE)
        axes.set(xlabel="samples per pixel", ylabel="relMSE")
        axes.set_title(
            f"{scene}: exponent of Monte Carlo {rival:.2f},\nof {best} {slopes[best][scene]:.2f}", fontsize=10
        )
    for axes in grid[len(settings["scenes"]) :]:
        axes.axis("off")
    entries = [Line2D([], [], label=_named(curve), **_line(curve, look, markersize=6)) for curve in usual_errors(found)]
    grid[len(settings["scenes"])].legend(handles=entries, loc="center", frameon=False, fontsize=9)
    return figure


def _draw_errors(axes: Axes, found: Mapping[str, Any], scene: str, look: Mapping[str, Style], size: float) -> None:
    """Draw relMSE over spp of every method, on one scene or pooled, and the law of Monte Carlo."""
    spps = np.array(found["settings"]["spps"], float)
    for curve, per_seed in usual_errors(found, scene).items():
        errors = [geometric_mean(seeds) for seeds in per_seed]
        style = _line(curve, look, markersize=size)
        axes.vlines(spps, [min(s) for s in per_seed], [max(s) for s in per_seed], color=style["color"], linewidth=1)
        axes.plot(spps, errors, **style)
    log_axes(axes, x=spps)


def _named(curve: str) -> str:
    """What the legend calls a method."""
    return f"{UNFILTERED}: Monte Carlo" if curve == UNFILTERED else curve


def _line(curve: str, look: Mapping[str, Style], **more: Any) -> dict[str, Any]:
    """How a method is drawn; the unfiltered image as Monte Carlo is."""
    if curve == UNFILTERED:
        return {"color": GREY, "linestyle": "--", "marker": ".", "linewidth": 1.5, **more}
    return look[curve].line(**more)


def growth_figure(found: Mapping[str, Any]) -> Figure:
    """Chart seconds over pixels, spp and window: measured points, and beside the right end the fitted exponents."""
    look, settings = styles(found), found["settings"]
    figure = Figure(figsize=(12, 7.6), layout="constrained")
    figure.suptitle(
        f"How time grows: filter seconds on the scene {settings['growth_scene']}, usual settings, and fitted exponents "
        f"({found['cores']} cores)"
    )
    panels = figure.subplots(1, 3, sharey=True)
    for axes, quantity in zip(panels, QUANTITIES, strict=True):
        rows = growth(found, quantity)
        ends = []
        for label, _, values, seconds, exponent in rows:
            axes.plot(values, seconds, **look[label].line(markersize=5))
            ends.append((seconds[-1], f"{exponent:.2f}", look[label].colour))
        wide = max((row[2] for row in rows), key=len)
        axes.set(title=f"over {quantity}", xlabel=AXES_WORDS[quantity])
        log_axes(axes, x=wide)
        if quantity == "pixels":
            axes.set_xticks(wide, [f"{np.sqrt(pixels):g}²" for pixels in wide])
    panels[0].set_ylabel("seconds: samples in, image out")
    for axes, quantity in zip(panels, QUANTITIES, strict=True):
        _write_exponents(axes, growth(found, quantity), look)
    labels = [row[0] for row in growth(found, "pixels")]
    entries = [Line2D([], [], label=label, **look[label].line(markersize=6)) for label in labels]
    figure.legend(handles=entries, loc="outside lower center", ncols=4, frameon=False, fontsize=9)
    return figure


def _write_exponents(axes: Axes, rows: Sequence[Any], look: Mapping[str, Style]) -> None:
    """Write each exponent to the right of the axes, at the height of its curve's end, moved apart where they would touch."""
    low, high = np.log(axes.get_ylim())
    ends = np.array([(np.log(seconds[-1]) - low) / (high - low) for _, _, _, seconds, _ in rows])
    for (label, *_, exponent), height, end in zip(rows, spread(ends, LABEL_GAP), ends, strict=True):
        axes.annotate(
            f"{exponent:.2f}",
            (1.0, end),
            xycoords="axes fraction",
            xytext=(1.045, height),
            textcoords="axes fraction",
            color=look[label].colour,
            fontsize=9,
            va="center",
            arrowprops={"arrowstyle": "-", "color": look[label].colour, "linewidth": 0.6, "shrinkA": 1, "shrinkB": 0},
            annotation_clip=False,
        )


def equal_error_figure(found: Mapping[str, Any]) -> Figure:
    """Chart how many Monte Carlo samples each filter is worth at three spp, and from which price of a sample it pays."""
    settings, look = found["settings"], styles(found)
    spps = dict.fromkeys((settings["spps"][0], settings["chart_spp"], settings["spps"][-1]))
    usual = {one.label: one for one in pooled(found, settings["chart_spp"]).values() if one.usual}
    usual.pop(UNFILTERED)
    worth = {label: geometric_mean(list(equal_spp(found, settings["chart_spp"])[label].values())) for label in usual}
    order = sorted(usual, key=worth.get)
    figure = Figure(figsize=(12, 1.6 + 0.32 * len(order)), layout="constrained")
    figure.suptitle(
        f"What a filter is worth in samples: usual settings, pooled, small dots single scenes ({heading(found)})"
    )
    panels = figure.subplots(1, len(spps) + 1, sharey=True)
    for axes, spp in zip(panels, spps, strict=False):
        at = equal_spp(found, spp)
        for place, label in enumerate(order):
            if label in at:
                _dot(axes, place, list(at[label].values()), look[usual[label].curve])
        axes.axvline(spp, color=GREY, linestyle="--", zorder=0)
        axes.set(title=f"{spp} spp filtered", xlabel="Monte Carlo spp of equal error")
        plain_log(axes)
    _draw_prices(panels[-1], found, [usual[label] for label in order], [worth[label] for label in order], look)
    panels[0].set_yticks(range(len(order)), [_two_words(usual[label].curve) for label in order])
    for axes in panels:
        axes.grid(visible=True, axis="both", color="#e5e5e5", linewidth=0.6)
        axes.set_axisbelow(True)
    return figure


def _two_words(label: str) -> str:
    """A label without what its neighbours say as well."""
    return label.replace("scikit-image", "skimage").replace(", fast mode", "")


def _dot(axes: Axes, place: int, values: Sequence[float], style: Style) -> None:
    """One method in one panel: small dots, and a large one for their geometric mean with its number."""
    axes.plot(values, [place] * len(values), ".", color=style.colour, alpha=0.45, markersize=5)
    mean = geometric_mean(values)
    axes.plot([mean], [place], **style.line(markersize=8, linewidth=0))
    axes.annotate(
        f"{mean:.{0 if mean >= 10 else 1}f}",
        (mean, place),
        xytext=(0, 6),
        textcoords="offset points",
        ha="center",
        fontsize=8,
    )


def _draw_prices(
    axes: Axes, found: Mapping[str, Any], points: Sequence[Any], worth: Sequence[float], look: Mapping[str, Style]
) -> None:
    """From which rendering milliseconds a spp each filter beats more samples, beside what our scenes cost."""
    for place, (point, equal) in enumerate(zip(points, worth, strict=True)):
        price = 1e3 * pays_from(point.filter_seconds, point.spp, equal)
        if np.isfinite(price):
            axes.plot([price], [place], **look[point.curve].line(markersize=8, linewidth=0))
        else:
            axes.annotate(
                "never", (0.5, place), xycoords=("axes fraction", "data"), ha="center", va="center", fontsize=8
            )
    own = 1e3 * pooled_monte_carlo(found).seconds_per_spp
    axes.axvline(own, color=GREY, linestyle="--", zorder=0)
    axes.set_xlabel("rendering, ms a spp")
    plain_log(axes)
    axes.set_title(f"{points[0].spp} spp filtered: pays from\nthis price on; ours: {own:.1f}", fontsize=10)
