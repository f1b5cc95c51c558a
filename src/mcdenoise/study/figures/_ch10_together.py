"""Chapter 10, all methods at the end: accuracy, stability and speed in one chart, and the table of the course."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.study.advise import ASKS
from mcdenoise.study.charts import GREY
from mcdenoise.study.figures._ch10_data import (
    LOOKS,
    mean_over_scenes,
    milliseconds,
    samples_worth,
    study,
    table,
    usual_points,
)
from mcdenoise.study.figures._ch10_front import draw_labels
from mcdenoise.study.methods import METHODS
from mcdenoise.study.speed_accuracy_results import equal_spp, error_slopes, front, pooled, pooled_monte_carlo
from mcdenoise.study.speed_accuracy_style import plain_log
from mcdenoise.study.stability_tables import each


def together() -> tuple[Figure, dict]:
    """All methods at the end: accuracy, stability and speed in one chart, and the table of the course."""
    speed, stable = study("speed-accuracy"), study("stability")
    spp = speed["settings"]["chart_spp"]
    points, slopes, worth = usual_points(speed), error_slopes(speed), equal_spp(speed, spp)
    on_front = {label for label, *_ in front(pooled(speed, spp).values(), pooled_monte_carlo(speed))}
    held = {name: [one["held"] for _, _, method, one in each(stable) if method == name] for name in METHODS}
    figure = Figure(figsize=(9.6, 5.2), layout="constrained")
    axes = figure.subplots()
    labels, rows, numbers = [], [], {}
    for name, method in METHODS.items():
        point, (colour, marker) = points[method.label], LOOKS[name]
        equal, share = mean_over_scenes(worth[point.label]), 100 * float(np.mean(held[name]))
        size = 6 + 3 * np.log10(point.filter_seconds / 1e-3)
        axes.plot(equal, share, marker, color=colour, markersize=float(np.clip(size, 5, 24)), alpha=0.85)
        labels.append((equal, share, f"{method.label}: {milliseconds(point.filter_seconds)} ms", colour))
        curve = [one for one in pooled(speed, spp).values() if one.curve == method.label]
        front_words = "yes" if any(one.label in on_front for one in curve) else ""
        numbers[name] = {"equal_spp": equal, "held": share, "seconds": point.filter_seconds}
        asks, slope = ASKS.get(name, ASKS["rpf"]), f"{slopes[method.label]['']:.2f}"
        time, kept = milliseconds(point.filter_seconds), f"{sum(held[name])} of {len(held[name])}"
        rows.append((method.label, f"{method.chapter:02}", asks, time, samples_worth(equal), front_words, slope, kept))
    axes.axvline(spp, color=GREY, linestyle="--")
    axes.set(
        xlabel=f"equal-error spp at {spp} spp: to the right more accurate (dashed: unfiltered)", ylabel="guarantees held, %",
        title="Accuracy, stability, and speed: the larger the marker, the slower",
    )  # fmt: skip
    plain_log(axes)
    axes.set_xlim(axes.get_xlim()[0] / 1.15, axes.get_xlim()[1] * 1.3)
    axes.margins(y=0.15)
    axes.grid(color="#e5e5e5", linewidth=0.6)
    axes.set_axisbelow(True)
    draw_labels(figure, axes, labels, [])
    head = (
        "method",
        "chapter",
        "asks for",
        "ms",
        "equal-error spp",
        "on the front",
        "exponent over spp",
        "guarantees held",
    )
    return figure, {"methods": numbers, "spp": spp, "table": table(head, rows)}
