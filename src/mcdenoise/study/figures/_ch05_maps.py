"""Chapter 05, figures over whole images: which random parameters explain radiance and features, where."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.study.figures._ch04_data import SIZE, samples
from mcdenoise.study.figures._ch05_data import (
    BOX,
    BOX_COLOURS,
    PLACES,
    SCENES,
    feature_columns,
    input_picture,
    share_bar,
    share_maps,
    share_picture,
)
from mcdenoise.study.slider import Slider, slider

FEATURES = ("world_position", "shading_normal", "albedo", "visibility")
REGIONS = {  # of the maps with stride 2: name -> (scene, rows, columns)
    "wall": ("dof", slice(0, 3), slice(20, 25)),
    "lamp": ("dof", slice(5, 8), slice(28, 32)),
    "rim": ("dof", slice(5, 8), slice(34, 36)),
    "focus": ("dof", slice(28, 42), slice(28, 40)),
    "front": ("dof", slice(50, 62), slice(52, 62)),
    "slow": ("motion", slice(11, 22), slice(28, 42)),
    "fast": ("motion", slice(30, 45), slice(24, 46)),
    "lit": ("soft_shadow", slice(40, 60), slice(48, 62)),
    "penumbra": ("soft_shadow", slice(18, 24), slice(42, 52)),
}
SIDES = (3, 5, 7, 11, 17, 25, 35)


def in_region(name: str, kind: str) -> np.ndarray:
    """Mean of a map over a region; one number for each of the last axis."""
    scene, rows, columns = REGIONS[name]
    return share_maps(scene)[kind][rows, columns].mean(axis=(0, 1))


def lens_and_light() -> tuple[Figure, dict]:
    """The image, what the lens explains of its radiance, and what the light explains."""
    figure = Figure(figsize=(9.6, 3.4), layout="constrained")
    grid, each = figure.subplots(1, 3), share_maps("dof")["c_r_each"]
    boxes = {BOX_COLOURS[place]: where for place, where in PLACES.items()}
    input_picture(grid[0], "dof", "dof, 8 spp", boxes)
    share_picture(grid[1], each[..., :2].sum(axis=-1), "W$_c^r$ of the lens (u, v)")
    shown = share_picture(grid[2], each[..., 2:].sum(axis=-1), "W$_c^r$ of the light (u, v)")
    share_bar(figure, shown, list(grid))
    numbers = {}
    for region in ("wall", "lamp", "rim", "focus", "front"):
        of = in_region(region, "c_r_each")
        numbers[region] = {"lens": of[:2].sum(), "light": of[2:].sum()}
    return figure, numbers


def shares_radiance() -> tuple[Figure, dict]:
    """Four scenes: the share of each random parameter, and of all."""
    figure = Figure(figsize=(9.8, 6.7), layout="constrained")
    grid, numbers = figure.subplots(len(SCENES), 6), {}
    for row, scene in zip(grid, SCENES, strict=True):
        maps, names = share_maps(scene), samples(scene).random_param_names
        input_picture(row[0], scene, scene)
        for k, axes in enumerate(row[1:5]):
            if k < len(names):
                shown = share_picture(axes, maps["c_r_each"][..., k], names[k])
            else:
                axes.remove()
        share_picture(row[5], maps["c_r"], "all: W$_c^r$")
        each = dict(zip(names, maps["c_r_each"].mean(axis=(0, 1)), strict=True))
        numbers[scene] = {"all": maps["c_r"].mean()} | each
    share_bar(figure, shown, grid)
    for region in ("fast", "slow", "lit", "penumbra"):
        scene = REGIONS[region][0]
        each = dict(zip(samples(scene).random_param_names, in_region(region, "c_r_each"), strict=True))
        numbers[region] = {"all": in_region(region, "c_r")} | each
    return figure, numbers


def shares_features() -> tuple[Figure, dict]:
    """Four scenes: what the random parameters explain of each feature."""
    return _by_feature("f_r", 1.0, "W$_f^r$")


def shares_of_features() -> tuple[Figure, dict]:
    """Four scenes: what each feature explains of radiance."""
    return _by_feature("c_f", 1.0, "W$_c^f$")


def _by_feature(kind: str, top: float, symbol: str) -> tuple[Figure, dict]:
    """Maps of one number a feature: the mean over its columns of f_r, the sum over those of c_f."""
    figure = Figure(figsize=(9.2, 7.5), layout="constrained")
    grid, numbers = figure.subplots(len(SCENES), 5), {}
    for row, scene in zip(grid, SCENES, strict=True):
        input_picture(row[0], scene, scene)
        numbers[scene] = {}
        for axes, name in zip(row[1:], FEATURES, strict=True):
            if name not in samples(scene).feature_names:
                axes.remove()
                continue
            values = feature_map(scene, name, kind)
            shown = share_picture(axes, values, f"{symbol}: {name.replace('_', ' ')}", top)
            numbers[scene][name] = {"mean": values.mean(), "median": np.median(values)}
    share_bar(figure, shown, grid)
    for region, (scene, rows, columns) in REGIONS.items():
        names = [name for name in FEATURES if name in samples(scene).feature_names]
        numbers[region] = {name: feature_map(scene, name, kind)[rows, columns].mean() for name in names}
    return figure, numbers


def feature_map(scene: str, name: str, kind: str) -> np.ndarray:
    """One number a pixel and feature: mean of its columns of f_r, sum of those of c_f."""
    values = share_maps(scene)[kind][..., feature_columns(scene, name)]
    return values.mean(axis=-1) if kind == "f_r" else values.sum(axis=-1)


@cache
def at_side(side: int) -> dict[str, np.ndarray]:
    """Maps of dof for one side of the box."""
    maps = share_maps("dof", side, 3)
    return {
        "radiance": maps["c_r"],
        "lens": maps["c_r_each"][..., :2].sum(axis=-1),
        "world": maps["f_r"][..., (0, 2)].mean(axis=-1),
    }


def region_at_side(name: str, kind: str, side: int) -> float:
    """Mean over a region, whatever the stride of the map."""
    values = at_side(side)[kind]
    step = round(SIZE / len(values))
    _, rows, columns = REGIONS[name]
    rows, columns = (slice(2 * one.start // step, max(2 * one.stop // step, 1)) for one in (rows, columns))
    return float(values[rows, columns].mean())


def slider_box() -> tuple[Slider, dict]:
    """The shares of dof over the side of the box."""

    def draw(side: int) -> Figure:
        figure = Figure(figsize=(9.6, 3.3), layout="constrained")
        grid, maps = figure.subplots(1, 3), at_side(side)
        for axes, name, title in zip(
            grid, maps, ("radiance: all, W$_c^r$", "radiance: lens", "world x and z"), strict=True
        ):
            shown = share_picture(axes, maps[name], title)
        share_bar(figure, shown, list(grid))
        return figure

    numbers = {"sides": SIDES, "mean": [at_side(side)["radiance"].mean() for side in SIDES]}
    for region in ("focus", "front"):
        numbers[region] = [region_at_side(region, "world", side) for side in SIDES]
    title = "dof at 8 spp: shares from boxes of side x side pixels"
    return slider(draw, title=title, unit="pixels", start=BOX, side=SIDES), numbers
