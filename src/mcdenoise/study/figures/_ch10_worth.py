"""Chapter 10, what a filter is worth: in samples, over spp, over the size of the work, and where its bias ends it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.metrics import relmse
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.study.bench_rpf_accuracy import geometric_mean
from mcdenoise.study.charts import GREY
from mcdenoise.study.figures._ch10_data import (
    GAINED,
    LOOKS,
    captured,
    key_of,
    mean_over_scenes,
    reference,
    study,
    table,
    usual_points,
    words,
)
from mcdenoise.study.methods import METHODS, bandwidths, feature_spreads
from mcdenoise.study.speed_accuracy_laws import equal_error_figure, growth_figure, slopes_figure, slopes_scenes_figure
from mcdenoise.study.speed_accuracy_results import (
    NOISE_FREE,
    QUANTITIES,
    UNFILTERED,
    equal_spp,
    error_slopes,
    growth,
    pooled_monte_carlo,
    scene_monte_carlo,
    usual_errors,
)
from mcdenoise.study.speed_accuracy_style import log_axes

SCENE, SIGMA = "dof", 0.7  # of the break-even; sigma_space of the Gaussian there
FITTED, FORETOLD = (4, 8, 16), (32, 64)  # spp
FIXED = ("gaussian", "cross_bilateral_prefiltered", "nlm")
DRAWN = np.geomspace(3, 1024, 60)


def equal_error() -> tuple[Figure, dict]:
    """What each filter is worth in samples at the smallest, the chart's and the largest spp."""
    found = study("speed-accuracy")
    settings = found["settings"]
    spps = list(dict.fromkeys((settings["spps"][0], settings["chart_spp"], settings["spps"][-1])))
    worth = {}
    for spp in spps:
        at = equal_spp(found, spp)
        worth[spp] = {key_of(label): mean_over_scenes(at[p.label]) for label, p in usual_points(found, spp).items()}
    ratios = {spp: {name: value / spp for name, value in of.items()} for spp, of in worth.items()}
    ours = [name for name in METHODS if all(name in of for of in worth.values())]
    best = {str(spp): METHODS[max(ours, key=of.get)].label for spp, of in worth.items()}
    peers = {label: key_of(label) for label, point in usual_points(found).items() if point.peer}
    best_peer = {}
    for spp, of in worth.items():
        label = max((one for one in peers if peers[one] in of), key=lambda one, of=of: of[peers[one]], default="none")
        best_peer[str(spp)] = f"{label}, {of[peers[label]]:.0f} spp" if label in peers else label
    numbers = {"spps": spps, "worth": worth, "times": ratios, "best": best, "best_peer": best_peer}
    return equal_error_figure(found), numbers | {
        "less_than_nothing": {
            str(spp): words(METHODS[n].label for n in ours if of[n] < spp) for spp, of in worth.items()
        }
    }


def slopes() -> tuple[Figure, dict]:
    """Error over spp, pooled, and the exponents."""
    found = study("speed-accuracy")
    exponents, errors = error_slopes(found), usual_errors(found)
    spps, clean = found["settings"]["spps"], found["settings"]["reference_spp"] / NOISE_FREE
    numbers = {
        "spps": spps,
        "monte_carlo": pooled_monte_carlo(found).slope(clean),
        "clean": clean,
        "pooled": {key_of(label): of[""] for label, of in exponents.items()},
        "gain_first": _gains(errors, 0),
        "gain_last": _gains(errors, -1),
    }
    scenes = found["settings"]["scenes"]
    rows = [
        (label, f"{of['']:.2f}", *(f"{of[scene]:.2f}" for scene in scenes))
        for label, of in exponents.items()
        if label == UNFILTERED or key_of(label) in METHODS
    ]
    numbers["table"] = table(("exponent of relMSE over spp", "pooled", *(f"`{scene}`" for scene in scenes)), rows)
    return slopes_figure(found), numbers


def _gains(errors: dict[str, Any], place: int) -> dict[str, float]:
    """How many times smaller the error of each method is than the unfiltered one, at one of the spp."""
    means = {label: geometric_mean(list(of[place])) for label, of in errors.items()}
    return {key_of(label): means[UNFILTERED] / mean for label, mean in means.items() if label != UNFILTERED}


def slopes_scenes() -> tuple[Figure, dict]:
    """Error over spp scene by scene, and Monte Carlo's exponents."""
    found = study("speed-accuracy")
    clean = found["settings"]["reference_spp"] / NOISE_FREE
    exponents = error_slopes(found)
    flattest = {
        scene: max((of[scene], label) for label, of in exponents.items() if key_of(label) in METHODS)
        for scene in found["settings"]["scenes"]
    }
    return slopes_scenes_figure(found), {
        scene: {
            "monte_carlo": scene_monte_carlo(found, scene).slope(clean),
            "flattest": flattest[scene][1],
            "flattest_slope": flattest[scene][0],
        }
        for scene in found["settings"]["scenes"]
    }


def chart_growth() -> tuple[Figure, dict]:
    """Time over pixels, spp and window, with the fitted exponents as a table."""
    found = study("speed-accuracy")
    exponents: dict[str, dict[str, float]] = {}
    spans = {}
    for quantity in QUANTITIES:
        rows = growth(found, quantity)
        spans[quantity] = [float(rows[0][2][0]), float(rows[0][2][-1])]
        for label, _, _, _, exponent in rows:
            exponents.setdefault(label, {})[quantity] = exponent
    cells = [
        (label, *(f"{of[quantity]:.2f}" if quantity in of else "" for quantity in QUANTITIES))
        for label, of in exponents.items()
        if key_of(label) in METHODS
    ]
    numbers = {key_of(label): of for label, of in exponents.items()}
    head = ("exponent of seconds over", "pixels", "spp", "width of the window")
    return growth_figure(found), {
        "exponents": numbers,
        "spans": spans,
        "scene": f"`{found['settings']['growth_scene']}`",
        "table": table(head, cells),
    }


def fixed_dials(samples: SampleBuffer) -> dict[str, Callable[[SampleBuffer], np.ndarray]]:
    """Three filters whose dials stay where they are, however many samples there are."""
    spreads = feature_spreads(samples)
    dials = {
        "gaussian": {"sigma_space": SIGMA},
        "cross_bilateral_prefiltered": {
            "sigma_space": 1.4, "sigma_radiance": 1.6, "sigma_features": bandwidths(spreads, 0.1, 0.4),
        },
        "nlm": {"search_radius": 3, "patch_radius": 3, "k": 0.6, "weight_radius": 1},
    }  # fmt: skip
    return {name: lambda one, name=name: METHODS[name].run(one, **dials[name]) for name in FIXED}


def bias_and_noise(spp: np.ndarray, errors: np.ndarray) -> tuple[float, float]:
    """Fit b + v / n to errors over spp, by relative least squares; neither is negative.

    Examples
    --------
    >>> n = np.array([2.0, 4.0, 8.0])
    >>> [round(one, 6) for one in bias_and_noise(n, 0.01 + 0.2 / n)]
    [0.01, 0.2]
    """
    terms = np.stack([np.ones_like(errors), 1 / spp], axis=1) / errors[:, np.newaxis]
    b, v = np.linalg.lstsq(terms, np.ones_like(errors), rcond=None)[0]
    if b < 0:
        b, v = 0.0, float(terms[:, 1].sum() / (terms[:, 1] ** 2).sum())
    return float(b), float(v)


def break_even() -> tuple[Figure, dict]:
    """With dials that stay: b + v / n against V / n, fitted at few samples and foretold at more; and dials chosen anew."""
    measured, truth = (*FITTED, *FORETOLD), reference(SCENE)
    whole, spp, few = captured(SCENE, measured[-1]), np.array(measured, float), len(FITTED)
    parts = [whole.subset(0, n) for n in measured]
    noisy = np.array([relmse(pixel_mean(one.radiance), truth) for one in parts])
    total = geometric_mean(noisy[:few] * spp[:few])
    figure = Figure(figsize=(11, 4.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(DRAWN, total / DRAWN, "--", color=GREY, label="Monte Carlo: V / n")
    left.plot(spp, noisy, ".", color=GREY, markersize=9)
    numbers: dict[str, Any] = {
        "scene": f"`{SCENE}`",
        "noise": total,
        "sigma": SIGMA,
        "fitted": FITTED,
        "foretold": FORETOLD,
        "fixed": {},
    }
    for name, run in fixed_dials(whole).items():
        errors = np.array([relmse(run(one), truth) for one in parts])
        (b, v), (colour, marker) = bias_and_noise(spp[:few], errors[:few]), LOOKS[name]
        crossing = (total - v) / b if b > 0 else np.inf
        left.plot(spp[:few], errors[:few], marker, color=colour, label=METHODS[name].label, markersize=7)
        left.plot(spp[few:], errors[few:], marker, color=colour, markersize=7, fillstyle="none")
        left.plot(DRAWN, b + v / DRAWN, color=colour, linewidth=1.2)
        if DRAWN[0] < crossing < DRAWN[-1]:
            left.plot(crossing, total / crossing, "o", color="black", markersize=11, fillstyle="none")
        off = float(np.abs(errors[few:] / (b + v / spp[few:]) - 1).max())
        found = {
            "bias_squared": b,
            "noise": v,
            "crossing": crossing,
            "less_noise": total / v,
            "foretold_off": 100 * off,
        }
        numbers["fixed"][name] = found
    left.set(title=f"{SCENE}: dials that stay", xlabel="n, samples per pixel", ylabel="relMSE")
    log_axes(left)
    left.set_xlim(DRAWN[0], DRAWN[-1])
    left.legend(frameon=False, fontsize=9)
    return figure, numbers | {"gains": _draw_gains(right)}


def _draw_gains(axes: Axes) -> dict[str, list[float]]:
    """How many times smaller the error is than the unfiltered one, with dials chosen at each spp: pooled over the scenes."""
    found = study("speed-accuracy")
    errors, spps = usual_errors(found), found["settings"]["spps"]
    gains = {name: [_gains(errors, place)[name] for place in range(len(spps))] for name in GAINED}
    for name, gain in gains.items():
        colour, marker = LOOKS[name]
        axes.plot(spps, gain, marker=marker, color=colour, linewidth=1.2, label=METHODS[name].label, markersize=6)
    axes.axhline(1, color=GREY, linestyle="--")
    axes.set(
        title="all scenes: dials chosen anew at every n",
        xlabel="n, samples per pixel",
        ylabel="relMSE unfiltered / filtered",
    )
    log_axes(axes, x=np.array(spps, float))
    axes.set_ylim(0.45, None)
    axes.legend(frameon=False, fontsize=8.5, ncols=2, loc="lower left")
    return gains
