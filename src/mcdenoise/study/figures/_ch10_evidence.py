"""Chapter 10, evidence without a reference: chance by shuffling, samples left out, and differences in pairs."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from mcdenoise.filters import gaussian
from mcdenoise.metrics import relmse
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.study.charts import COLOURS, GREY
from mcdenoise.study.choice import TILE, simplest_like_best, tile_means
from mcdenoise.study.evidence import permutation_p_value
from mcdenoise.study.figures._ch10_data import LOOKS, captured, reference
from mcdenoise.study.information import BOX, NEIGHBOURHOODS, _of_neighbourhood, spread_corners
from mcdenoise.study.left_out import PARTS, LeftOut
from mcdenoise.study.methods import METHODS
from mcdenoise.study.tune import choose_parameters

SCENE, SPP = "dof", 8
DECOY = "time"  # a random number that this scene has no use for
SHUFFLES = 199
SIGMAS = (0.35, 0.4, 0.5, 0.6, 0.7, 0.85, 1.0, 1.2, 1.4)
PAIRED = ("gaussian", "bilateral", "nlm", "cross_bilateral_prefiltered", "joint_nlm")
FILTERED, JUDGES = "#4477AA", "#EE6677"


def samples_with_decoy() -> SampleBuffer:
    """Samples of the scene with a lens parameter, a light parameter, and a decoy; no features."""
    samples = captured(SCENE, SPP)
    kept = {name: samples[name] for name in ("lens_u", "light_u")}
    kept[DECOY] = np.random.default_rng(1).random(samples.hit.shape, np.float32)
    return SampleBuffer.from_arrays(samples.radiance, samples.screen_position, kept)


@cache
def shuffled() -> dict[str, np.ndarray]:
    """Name -> (1 + shuffles,) mean information with radiance: first as it is, then of each shuffle."""
    samples, rng = samples_with_decoy(), np.random.default_rng(0)
    names = list(samples.random_param_names)
    corners = spread_corners(samples.height, samples.width, NEIGHBOURHOODS, BOX)
    found = sum(_of_neighbourhood(samples.crop(y, x, BOX, BOX), names, SHUFFLES, rng) for y, x in corners)
    return dict(zip(names, found.T / len(corners), strict=True))


def permutation() -> tuple[Figure, dict]:
    """What chance gives, and what is observed: a lens number, a light number, a decoy."""
    figure, numbers = (
        Figure(figsize=(11, 3.6), layout="constrained"),
        {"shuffles": SHUFFLES, "scene": SCENE, "spp": SPP},
    )
    numbers |= {"smallest_p": 1 / (1 + SHUFFLES), "neighbourhoods": NEIGHBOURHOODS, "box": BOX}
    for axes, (name, values) in zip(figure.subplots(1, 3), shuffled().items(), strict=True):
        observed, chance = float(values[0]), values[1:]
        p = permutation_p_value(observed, chance)
        away = (observed - chance.mean()) / chance.std(ddof=1)
        axes.hist(chance, bins=16, color=GREY, label=f"{SHUFFLES} shuffles: chance")
        axes.axvline(observed, color=JUDGES, linewidth=2, label="observed")
        shown = "a decoy" if name == DECOY else f"{name} of {SCENE}"
        axes.set(title=f"{shown}: p = {p:.3f}", xlabel="nats, all channels together", yticks=[])
        axes.title.set_fontsize(10)
        numbers["decoy" if name == DECOY else name] = {
            "observed": observed,
            "chance": float(chance.mean()),
            "beyond": observed - float(chance.mean()),
            "p": p,
            "deviations": away,
        }
    figure.axes[0].legend(frameon=False, fontsize=9, loc="upper center")
    return figure, numbers


def left_out() -> tuple[Figure, dict]:
    """Parts of the samples judge what a filter makes of the others: how it is done, and what it finds."""
    figure = Figure(figsize=(11, 4.4), layout="constrained")
    scheme, chart = figure.subplots(1, 2, width_ratios=(1, 1.35))
    _draw_parts(scheme)
    samples, truth = captured(SCENE, SPP), reference(SCENE)
    true = [relmse(gaussian(pixel_mean(samples.radiance), sigma_space=s), truth) for s in SIGMAS]
    curves = {2: [], PARTS: []}
    for parts, errors in curves.items():
        split = LeftOut.of(samples, parts)
        for sigma in SIGMAS:
            found = split.error_of(lambda one, s=sigma: gaussian(pixel_mean(one.radiance), sigma_space=s))
            errors.append(float((found - split.noise).mean()))
    chart.plot(SIGMAS, true, "k--", marker=".", label=f"true: all {SPP} samples, by the reference")
    looks = {PARTS: ("o", COLOURS[0], f"{PARTS} parts: {SPP - SPP // PARTS} filtered, {SPP // PARTS} judge")}
    looks[2] = ("s", COLOURS[1], f"halves: {SPP // 2} filtered, {SPP // 2} judge")
    for parts, (marker, colour, label) in looks.items():
        chart.plot(SIGMAS, curves[parts], marker=marker, color=colour, label=label)
    for values, colour in ((true, "black"), (curves[PARTS], COLOURS[0]), (curves[2], COLOURS[1])):
        best = int(np.argmin(values))
        chart.plot(SIGMAS[best], values[best], "o", color=colour, markersize=14, fillstyle="none")
    chart.set(
        xlabel="sigma_space of a Gaussian, pixels",
        ylabel="relMSE",
        title=f"{SCENE}, {SPP} spp (rings: the best)",
        ylim=(0, None),
    )
    chart.grid(color="#e5e5e5", linewidth=0.6)
    chart.set_axisbelow(True)
    chart.legend(frameon=False, fontsize=9)
    best = {
        name: SIGMAS[int(np.argmin(values))]
        for name, values in (("true", true), ("parts", curves[PARTS]), ("halves", curves[2]))
    }
    return figure, {
        "parts": PARTS,
        "spp": SPP,
        "best": best,
        "true": true,
        "by_parts": curves[PARTS],
        "by_halves": curves[2],
    }


def _draw_parts(axes: Axes) -> None:
    """A row a turn: which samples are filtered, which judge."""
    for turn in range(PARTS):
        for sample in range(SPP):
            judge = sample * PARTS // SPP == turn
            place, colour = (sample, -turn), JUDGES if judge else FILTERED
            axes.add_patch(Rectangle(place, 0.86, 0.72, facecolor=colour))
        axes.text(-0.3, -turn + 0.36, f"turn {turn + 1}", ha="right", va="center", fontsize=9)
    for colour, label in ((FILTERED, "filtered"), (JUDGES, "judge what came out")):
        axes.plot([], [], "s", color=colour, label=label, markersize=9)
    axes.set(xlim=(-2.2, SPP), ylim=(-PARTS + 0.3, 1.0), title=f"the {SPP} samples of each pixel")
    axes.axis("off")
    axes.legend(frameon=False, ncols=2, loc="lower center", bbox_to_anchor=(0.55, -0.12), fontsize=9)


def paired() -> tuple[Figure, dict]:
    """Why differences are taken tile by tile: errors with their own standard errors, and differences with theirs."""
    samples = captured(SCENE, SPP)
    split = LeftOut.of(samples)
    tiles = []
    for name in PAIRED:
        method, chosen = METHODS[name], choose_parameters(METHODS[name], samples)
        tiles.append(tile_means(split.error_of(lambda one, m=method, c=chosen: m.run(one, **c)) - split.noise))
    errors = np.array(tiles)
    choice = simplest_like_best(errors)
    alone = errors.std(axis=1, ddof=1) / np.sqrt(errors.shape[1])
    figure = Figure(figsize=(11.5, 3.9), layout="constrained")
    first, second, third = figure.subplots(1, 3, width_ratios=(1, 1, 1))
    rival = int(np.argsort(errors.mean(axis=1))[1])
    first.plot(1e3 * errors[choice.best], 1e3 * errors[rival], "o", color=COLOURS[0], markersize=4, alpha=0.7)
    top = 1e3 * float(np.quantile(errors[[choice.best, rival]], 0.95))
    low = 1e3 * float(min(errors[[choice.best, rival]].min(), 0))
    first.plot([low, top], [low, top], color=GREY, linewidth=1)
    first.set(
        xlim=(low, top), ylim=(low, top), xlabel=f"relMSE x 1000, {METHODS[PAIRED[choice.best]].label}",
        ylabel=METHODS[PAIRED[rival]].label, title=f"a dot a tile of {TILE} x {TILE} pixels",
    )  # fmt: skip
    labels = [METHODS[name].label.replace(", ", ",\n") for name in PAIRED]
    places = np.arange(len(PAIRED))[::-1]
    for axes, values, spread in ((second, errors.mean(axis=1), alone), (third, choice.behind, choice.standard_error)):
        for place, name, value, one in zip(places, PAIRED, values, spread, strict=True):
            colour, marker = LOOKS[name]
            axes.errorbar(1e3 * value, place, xerr=1e3 * one, fmt=marker, color=colour, capsize=3, markersize=7)
        axes.set_yticks(places, labels if axes is second else [""] * len(labels), fontsize=8.5)
        axes.grid(axis="x", color="#e5e5e5")
        axes.set_axisbelow(True)
    second.set(title="each for itself", xlabel="relMSE x 1000, standard error")
    third.axvline(0, color=GREY, linewidth=1)
    third.set(title="behind the best, in pairs", xlabel="difference x 1000, its standard error")
    for axes in figure.axes:
        axes.title.set_fontsize(10)
    pairs = {
        name: {
            "error": float(errors[k].mean()),
            "alone": float(alone[k]),
            "behind": float(choice.behind[k]),
            "paired": float(choice.standard_error[k]),
        }
        for k, name in enumerate(PAIRED)
    }
    numbers = {
        "best": METHODS[PAIRED[choice.best]].label,
        "second": METHODS[PAIRED[rival]].label,
        "chosen": METHODS[PAIRED[choice.chosen]].label,
        "tiles": errors.shape[1],
        "correlation": float(np.corrcoef(errors[choice.best], errors[rival])[0, 1]),
        "narrower": float(alone[rival] / choice.standard_error[rival]),
        "behind": 1e3 * float(choice.behind[rival]),
        "alone": 1e3 * float(np.hypot(alone[rival], alone[choice.best])),
        "paired": 1e3 * float(choice.standard_error[rival]),
    }
    return figure, numbers | {"methods": pairs, "scene": f"`{SCENE}`", "spp": SPP}
