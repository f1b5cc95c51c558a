"""Chapter 09, training: scenes drawn at random, watching a model learn, and how large it must be."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.lbf import LBFModel, shipped_model
from mcdenoise.lbf.pixel import rprop_epoch
from mcdenoise.lbf.secondary import secondary_features
from mcdenoise.nn import RPROP
from mcdenoise.render import capture
from mcdenoise.render.scenes.random_scene import random_kind, random_scene
from mcdenoise.samples import pixel_mean
from mcdenoise.study.capacity import capacity_figure
from mcdenoise.study.figures._ch04_data import error, picture
from mcdenoise.study.figures._ch09_data import (
    BLUE,
    GREEN,
    RED,
    ROWS,
    VARIANTS,
    bandwidth_bar,
    bandwidth_picture,
    error_in_rows,
    noisy,
    primary,
    sigma,
    widths_of,
)
from mcdenoise.study.figures._references import FOLDER, reference
from mcdenoise.study.lbf_capacity_results import ALL, differences_figure, load_study
from mcdenoise.study.slider import Slider, slider

SHOWN = (0, 1, 2, 5, 10, 20, 40)  # epochs
RADIUS, HIDDEN = 13, 10
LEARNT, WATCHED = "dof", "pinhole"  # scenes with the same groups of features
GALLERY = (0, 1, 2, 4, 5, 6, 7, 8)  # seeds of training scenes
CAPACITY = FOLDER.parents[1] / "lectures" / "studies" / "lbf_capacity.json"
TRIALS = CAPACITY.with_name("lbf_trials.json")


def training_scenes() -> tuple[Figure, dict]:
    """Eight of the scenes that the shipped model learnt from."""
    figure = Figure(figsize=(9.8, 5.3), layout="constrained")
    for axes, seed in zip(figure.subplots(2, 4).flat, GALLERY, strict=True):
        found = capture(random_scene(seed), 64, 64, 8, seed, variant="scalar_rgb", nonfinite="zero", progress=False)
        picture(axes, pixel_mean(found.radiance), f"seed {seed}: {', '.join(sorted(random_kind(seed))) or 'diffuse'}")
    return figure, {"cards": {variant: card_numbers(variant) for variant in VARIANTS}, "spp": 8}


def card_numbers(variant: str) -> dict:
    """What the card of a shipped model says about its training, and the size of its network."""
    model = shipped_model(variant)
    card, widths = model.card, widths_of(model)
    return {
        "network": "-".join(map(str, widths)),
        "parameters": model.network.size,
        "inputs": widths[0],
        "outputs": widths[-1],
        "predicted": list(model.outputs),
        "scenes": len(card["training_scenes"]),
        "validation_scenes": len(card["validation_scenes"]),
        "spp": card["spp"],
    }


def training() -> tuple[Figure, dict]:
    """Losses of both shipped models while they were trained, from their cards."""
    figure, numbers = Figure(figsize=(9.4, 3.5), layout="constrained"), {}
    for axes, (variant, words) in zip(figure.subplots(1, 2, sharey=True), VARIANTS.items(), strict=True):
        card = shipped_model(variant).card
        learnt = np.array(card["curve"]["training"]) / card["loss"]["unfiltered"]
        looks, seen = np.array(card["curve"]["validation"]).T
        seen = seen / card["validation_loss"]["unfiltered"]
        best = int(np.argmin(seen))
        axes.plot(learnt, color=BLUE, label="training scenes")
        axes.plot(looks, seen, "o-", color=RED, markersize=4, label="validation scenes")
        axes.plot(looks[best], seen[best], "*", markersize=15, color="#CCBB44", markeredgecolor="black", label="kept")
        axes.set(xlabel="epochs of RPROP", title=f"{words}, {shipped_model(variant).network.size} parameters")
        axes.title.set_fontsize(10)
        axes.grid(color="#e5e5e5")
        numbers[variant] = {
            "epochs": len(learnt),
            "best_epoch": int(looks[best]),
            "start": 100 * seen[0],
            "best": 100 * seen[best],
            "last": 100 * seen[-1],
            "learnt_start": 100 * learnt[0],
            "learnt_best": 100 * learnt[min(int(looks[best]), len(learnt) - 1)],
            "learnt_last": 100 * learnt[-1],
        }
    figure.axes[0].set_ylabel("loss, share of the noisy images'")
    figure.axes[0].legend(frameon=False, fontsize=9)
    return figure, numbers


class Learning(NamedTuple):
    """A training on one scene: models after the epochs of SHOWN, losses of all epochs, relMSE on the other scene."""

    networks: dict[int, LBFModel]
    losses: list[float]
    watched: list[float]


@cache
def learning() -> Learning:
    """Learn from every eighth row of dof, with its reference; watch those of pinhole."""
    found, other = primary(LEARNT), primary(WATCHED)
    start = LBFModel.random(found.groups, hidden=[HIDDEN], rng=np.random.default_rng(0), radius=RADIUS)
    seen = secondary_features(start.prepared(found)[0], start.sees_colour)
    values = seen.reshape(-1, seen.shape[-1]).astype(np.float64)
    model = replace(start, mean=values.mean(axis=0), scale=values.std(axis=0))
    layer, beside = model.layer(found, rows=ROWS), model.layer(other, rows=ROWS)
    inputs, unseen = (model.inputs(one)[list(ROWS)].reshape(-1, values.shape[-1]) for one in (found, other))
    optimizer, network = RPROP(0.02), model.network
    state, networks, losses, watched = optimizer.start(network.parameters), {}, [], []
    for epoch in range(SHOWN[-1] + 1):
        if epoch in SHOWN:
            networks[epoch] = replace(model, network=network)
            image = beside.forward(network.forward(unseen)[0].reshape(beside.shape))[0]
            watched.append(error_in_rows(image, WATCHED))
        network, state, loss = rprop_epoch(network, inputs, layer, reference(LEARNT)[list(ROWS)], optimizer, state)
        losses.append(loss)
    return Learning(networks, losses, watched)


def slider_learning() -> tuple[Slider, dict]:
    """A model learns dof from every eighth row: image, the map of alpha, and the losses."""
    found = learning()
    images = {}
    for epoch, model in found.networks.items():
        theta = model.theta(primary(LEARNT))
        images[epoch] = (model.layer(primary(LEARNT)).forward(theta)[0], theta)
    start, errors = error_in_rows(noisy(WATCHED), WATCHED), [error(image, LEARNT) for image, _ in images.values()]

    def draw(epoch: int) -> Figure:
        figure = Figure(figsize=(9.4, 3.3), layout="constrained")
        left, middle, right = figure.subplots(1, 3, width_ratios=(1, 1, 1.15))
        image, theta = images[epoch]
        picture(left, image, f"filtered, relMSE {error(image, LEARNT):.4f}")
        bandwidth_picture(middle, sigma(theta[..., 2 + found.networks[0].groups.index("albedo")]), "γ of the texture")
        bandwidth_bar(figure, middle, shrink=0.8)
        curves = {
            f"E, {len(ROWS)} rows of {LEARNT}": (range(len(found.losses)), found.losses, "-", BLUE),
            f"relMSE, {LEARNT}": (SHOWN, errors, "o-", GREEN),
            f"relMSE, {WATCHED}, not learnt from": (SHOWN, found.watched, "s-", RED),
        }
        for label, (at, values, look, colour) in curves.items():
            right.plot(at, np.array(values) / values[0], look, color=colour, label=label, markersize=4)
        right.axvline(epoch, color="#777777", linewidth=1, linestyle=":")
        right.set(xlabel="epochs of RPROP", ylabel="share of epoch 0", ylim=(0.2, 1.25))
        right.legend(frameon=False, fontsize=8)
        return figure

    numbers = {
        "epochs": SHOWN,
        "losses": [found.losses[epoch] for epoch in SHOWN],
        "errors": errors,
        "watched": found.watched,
        "watched_noisy": start,
        "noisy": error(noisy(LEARNT), LEARNT),
        "rows": len(ROWS),
        "radius": RADIUS,
        "parameters": found.networks[0].network.size,
    }
    title = f"A network learns the dials of {LEARNT}, 4 spp, from {len(ROWS)} of its 128 rows"
    return slider(draw, title=title, start=20, epoch=SHOWN), numbers


def capacity() -> tuple[Figure, dict]:
    """What smaller networks and missing groups of features cost, from the stored study."""
    found = load_study(CAPACITY)
    sweep = found.architectures
    best, enough = sweep.candidates[sweep.best], sweep.candidates[found.enough]
    numbers = {
        "scenes": found.settings["scenes"],
        "folds": len(best.errors),
        "best": best.label,
        "best_error": best.mean,
        "best_parameters": best.parameters,
        "enough": enough.label,
        "enough_error": enough.mean,
        "enough_parameters": enough.parameters,
        "errors": {one.label.replace("-", "_"): one.mean for one in sweep.candidates},
        "without": {name.removeprefix("without "): found.harm(name)[0] for name in found.groups if name != ALL},
        "spread": {name.removeprefix("without "): found.harm(name)[1] for name in found.groups if name != ALL},
        "all_groups": found.groups[ALL].mean,
        "shipped": len(shipped_model().network.parameters["bias_1"]),
    }
    return differences_figure(found), numbers


def capacity_sizes() -> tuple[Figure, dict]:
    """Error and training time against the number of parameters, from the stored study."""
    sweep = load_study(CAPACITY).architectures
    return capacity_figure(sweep), {"plain_rule": sweep.candidates[sweep.chosen].label}


def trials() -> tuple[Figure, dict]:
    """What closes the gap, from the stored trainings: relMSE on the toy scenes, one bar a model."""
    found = json.loads(TRIALS.read_text(encoding="utf-8"))
    figure = Figure(figsize=(9, 3.2), layout="constrained")
    axes = figure.subplots()
    places = np.arange(len(found))[::-1]
    for spp, away, colour in (("4", 0.18, "#4477AA"), ("8", -0.18, "#EE6677")):
        errors = [one["toys"][spp] for one in found.values()]
        axes.barh(places + away, errors, 0.34, color=colour, label=f"{spp} spp")
        for place, one in zip(places + away, errors, strict=True):
            axes.text(one, place, f" {one:.4f}", va="center", fontsize=9)
    axes.set_yticks(places, [f"{one['words']} ({one['scenes']})" for one in found.values()])
    figure.suptitle(
        "Short trainings, judged on the toy scenes (in brackets: how many scenes to learn from)", fontsize=11
    )
    axes.set(xlabel="relMSE, geometric mean over five scenes", xlim=(0, 1.3 * max(found["paper"]["toys"].values())))
    axes.legend(frameon=False, loc="center right")
    axes.grid(color="#e5e5e5", axis="x")
    axes.set_axisbelow(True)
    numbers = {
        name: {"scenes": one["scenes"], "validation": one["validation"]}
        | {f"spp_{spp}": error for spp, error in one["toys"].items()}
        for name, one in found.items()
    }
    return figure, numbers
