"""Chapter 09, what the filter compares and what the network sees: primary features, prefiltered, and the secondary ones."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.filters.window import with_channels
from mcdenoise.lbf import Primary, primary_features, secondary_features, secondary_names, shipped_model
from mcdenoise.lbf.oracle import oracle
from mcdenoise.lbf.primary import scene_frame, two_buffer_variance
from mcdenoise.lbf.secondary import COLOUR, KINDS
from mcdenoise.render import capture
from mcdenoise.render.scenes.random_scene import random_scene
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.figures._ch04_data import picture, plain, samples
from mcdenoise.study.figures._ch09_data import ROWS, SPP, WORDS, primary
from mcdenoise.study.figures._references import reference

UNSEEN = 1005  # seed of a random scene that no model was trained on
SHARP, BLURRED = np.s_[56:84, 56:80], np.s_[100:124, 104:124]  # of dof: balls in focus and in front
KIND_WORDS = dict(
    zip(KINDS, ("MAD", "mean", "std", "mean 7 x 7", "std 7 x 7", "deviation 3 x 3", "gradient"), strict=True)
)


def raw_primary(scene: str) -> Primary:
    """Primary features without prefiltering: pixel means, and the variances of these."""
    kept = primary(scene)
    variances = {}
    for group in kept.groups:
        values = np.ascontiguousarray(samples(scene, SPP)[group])
        if group == "world_position":  # in units of the scene's size, as in `primary_features`
            values = values / scene_frame(values, samples(scene, SPP).hit)[1]
        variances[group] = with_channels(two_buffer_variance(values))
    return replace(kept, features=kept.raw, variances=variances)


def shared_best(scene: str, features: Primary) -> float:
    """RelMSE of the best single setting, on every eighth row."""
    model = shipped_model()
    found = oracle(
        model.layer(features, rows=ROWS), reference(scene), colour_theta=model.colour_theta, steps=0
    ).shared_image
    truth = reference(scene)[list(ROWS)].astype(np.float64)
    return float(np.mean((found - truth) ** 2 / (truth**2 + 0.01)))


def in_view(group: str, values: np.ndarray) -> np.ndarray:
    """A feature as colours: positions and normals from [-1.5, 1.5], all others as they are."""
    return values if group.startswith(("albedo", "visibility")) else np.clip(values / 3 + 0.5, 0, 1)


def prefilter() -> tuple[Figure, dict]:
    """Three groups of dof before and after prefiltering, and the noise of both: how far two captures are apart."""
    kept, other, numbers = primary("dof"), primary("dof", seed=1), {}
    figure = Figure(figsize=(8.8, 6.3), layout="constrained")
    grid = figure.subplots(3, 4)
    for row, group in zip(grid, ("world_position", "shading_normal", "albedo"), strict=True):
        numbers[group] = {}
        for k, (kind, title) in enumerate((("raw", "pixel mean, 4 spp"), ("features", "prefiltered"))):
            one, two = getattr(kept, kind)[group], getattr(other, kind)[group]
            noise = np.sqrt(((one - two) ** 2).mean(axis=-1) / 2)
            picture(row[k], in_view(group, one), title)
            shown = row[2 + k].imshow(noise, vmin=0, vmax=0.2, cmap="magma", interpolation="nearest")
            plain(row[2 + k], ("its noise", "noise left over")[k])
            numbers[group][kind] = {
                name: float(np.sqrt((noise[where] ** 2).mean()))
                for name, where in (("sharp", SHARP), ("blurred", BLURRED))
            }
        row[0].set_ylabel(WORDS[group])
        told = np.sqrt(kept.variances[group].mean(axis=-1))
        numbers[group]["told"] = {"sharp": float(told[SHARP].mean()), "blurred": float(told[BLURRED].mean())}
    for axes in grid[1:].flat:
        axes.set_title("")
    figure.colorbar(shown, ax=grid[:, 3], shrink=0.5, label="deviation between two captures")
    numbers["raw"], numbers["prefiltered"] = shared_best("dof", raw_primary("dof")), shared_best("dof", kept)
    return figure, numbers


@cache
def unseen() -> SampleBuffer:
    """Samples of a scene that has all groups."""
    return capture(random_scene(UNSEEN), 96, 96, SPP, 0, variant="scalar_rgb", progress=False)


def secondary() -> tuple[Figure, dict]:
    """The secondary features of one scene, each on its own range, numbered as the network's inputs."""
    found = primary_features(unseen())
    seen, _ = shipped_model().prepared(found)
    values, names = secondary_features(seen, colour=True), secondary_names([*found.groups, COLOUR])
    published = secondary_names(found.groups)
    figure = Figure(figsize=(9.8, 7.8), layout="constrained")
    grid = figure.subplots(len(found.groups) + 1, 8)
    for row, group in zip(grid, (*found.groups, COLOUR), strict=True):
        picture(row[0], seen.colour if group == COLOUR else in_view(group, found.raw[group]))
        row[0].set_ylabel(WORDS[group] if group in found.groups else "colour (ours)")
        for axes, kind in zip(row[1:], KINDS, strict=True):
            name = f"{kind} {group}"
            image = values[..., names.index(name)]
            low, high = np.percentile(image, [1, 99])
            axes.imshow(image, cmap="gray", vmin=low, vmax=max(high, low + 1e-6), interpolation="nearest")
            if name in published:
                box = {"facecolor": "white", "pad": 1}
                axes.text(3, 4, f"{published.index(name)}", fontsize=8, color="#222222", va="top", bbox=box)
            plain(axes, KIND_WORDS[kind] if group == found.groups[0] else "")
            axes.title.set_fontsize(9)
    grid[0, 0].set_title("pixel mean", fontsize=9)
    return figure, {
        "count": len(published),
        "rate": published.index("sampling rate"),
        "groups": len(found.groups),
        "with_colour": len(names),
        "dof_inputs": len(secondary_names(primary("dof").groups)),
    }
