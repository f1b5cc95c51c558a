"""Chapter 10, what the price of a sample decides: gain over Monte Carlo of equal time, and who is on the front."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.study.charts import GREY
from mcdenoise.study.figures._ch10_data import GAINED, THOUSAND, key_of, study, usual_points, words
from mcdenoise.study.front import equal_time_error, pareto_front
from mcdenoise.study.speed_accuracy_results import UNFILTERED, MonteCarlo, Point, pooled, pooled_monte_carlo
from mcdenoise.study.speed_accuracy_style import log_axes, styles

PRICES = np.geomspace(1e-4, 10.0, 81)  # seconds a spp


def price() -> tuple[Figure, dict]:
    """What rendering costs decides: gain over Monte Carlo of equal time, and who is on the front, against seconds a spp."""
    found = study("speed-accuracy")
    rival, spp, look = pooled_monte_carlo(found), found["settings"]["chart_spp"], styles(found)
    usual = {key_of(label): point for label, point in usual_points(found).items()}
    own = rival.seconds_per_spp
    figure = Figure(figsize=(12, 5.6), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.15))
    numbers: dict[str, Any] = {"ms_a_spp": THOUSAND * own, "spp": spp, "gain": {}}
    for name in GAINED:
        point, style = usual[name], look[usual[name].curve]
        gains = [gain_at(one, point, rival) for one in PRICES]
        left.plot(THOUSAND * PRICES, gains, color=style.colour, linewidth=1.4)
        left.plot(
            THOUSAND * PRICES[::16], gains[::16], style.marker, color=style.colour, markersize=6, label=point.curve
        )
        numbers["gain"][name] = {"own": gain_at(own, point, rival), "costly": gains[-1], "cheap": gains[0]}
    left.axhline(1, color="black", linewidth=0.8)
    left.axvline(THOUSAND * own, color=GREY, linestyle="--")
    left.set(title=f"{spp} spp filtered, against Monte Carlo of equal time", xscale="log", yscale="log")
    left.set(xlabel="rendering, ms a spp (dashed: our scenes)", ylabel="relMSE of Monte Carlo / of the filter")
    log_axes(left)
    left.legend(frameon=False, fontsize=9)
    on_front = front_by_price(found, rival)
    shown = [label for label in (*look, "Monte Carlo") if label in on_front]
    for place, label in enumerate(shown[::-1]):
        colour = look[label].colour if label in look else GREY
        at = THOUSAND * PRICES[on_front[label]]
        right.plot(at, np.full(len(at), place), "s", color=colour, markersize=4)
    right.axvline(THOUSAND * own, color=GREY, linestyle="--")
    right.set_yticks(range(len(shown)), shown[::-1], fontsize=9)
    right.set(xscale="log", xlabel="rendering, ms a spp", title="On the front of all settings and all spp?")
    right.grid(color="#e5e5e5", linewidth=0.6)
    log_ticks = [10.0**k for k in range(-1, 5)]
    for axes in (left, right):
        axes.set_xticks(log_ticks, [f"{tick:g}" for tick in log_ticks])
        axes.set_xlim(THOUSAND * PRICES[0], THOUSAND * PRICES[-1])
    shares = {key_of(label): 100 * float(on.mean()) for label, on in on_front.items()}
    for which, at in (("cheap", 0), ("costly", -1)):
        numbers[f"front_{which}"] = words(label for label in shown if on_front[label][at])
    never = [label for label in usual_points(found) if label not in on_front]
    return figure, numbers | {"shares": shares, "never": words(never)}


def gain_at(seconds_per_spp: float, point: Point, rival: MonteCarlo) -> float:
    """How many times smaller the error of a filter is than that of Monte Carlo of equal time, if a sample costs that much."""
    seconds = point.spp * seconds_per_spp + point.filter_seconds
    return equal_time_error(seconds, 0.0, seconds_per_spp, rival.spp, rival.relmse) / point.relmse


def front_by_price(found: dict, rival: MonteCarlo) -> dict[str, np.ndarray]:
    """Label of a method, or "Monte Carlo" -> (prices,) bool: one of its settings at some spp is on the front, pooled."""
    points = [p for spp in found["settings"]["spps"] for p in pooled(found, spp).values() if p.curve != UNFILTERED]
    labels = np.array([point.curve for point in points] + ["Monte Carlo"] * len(rival.spp))
    spp = np.array([point.spp for point in points] + list(rival.spp), float)
    filtering = np.array([point.filter_seconds for point in points] + [0.0] * len(rival.spp))
    errors = np.array([point.relmse for point in points] + list(rival.relmse))
    on = np.array([pareto_front(spp * one + filtering, errors) for one in PRICES])
    kept = {label: on[:, labels == label].any(axis=1) for label in dict.fromkeys(labels)}
    return {str(label): one for label, one in kept.items() if one.any()}
