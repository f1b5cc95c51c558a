"""One scanline of `dof` as a light field: radiance and depth over lens u and screen x, and its refocusing.

A lens is many pinholes. The picture at lens (u, 1/2) is that of a pinhole camera moved sideways by A (1 - 2u), with its
film moved so that the plane of focus stays where it is. One such row of pixels for each u gives the light field without
any noise from the lens: u is stratified, v is 1/2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.render import capture, write_exr
from mcdenoise.render.scenes import dof, parts
from mcdenoise.render.toyscene import ToyScene
from mcdenoise.samples import pixel_mean
from mcdenoise.study.display import tone_map
from mcdenoise.study.figures import _ch01_lens as lens
from mcdenoise.study.figures._references import reference
from mcdenoise.study.slider import Slider, slider

PIXELS = 128  # width of the image that the scanline belongs to
FINER = 2  # columns of the light field to a pixel
VIEWS = 64  # strata of u
ROW = 60


@dataclass(frozen=True)
class LightField:
    """One scanline over the lens: row k is u = (k + 1/2) / VIEWS, column j is x = (j + 1/2) / FINER pixels.

    Attributes
    ----------
    radiance : (VIEWS, PIXELS * FINER, 3), of the samples in the cell, averaged
    depth : (VIEWS, PIXELS * FINER), of the first sample in the cell, scene units; infinite where it met nothing
    middle : (VIEWS, PIXELS * FINER), pixels: where on the screen the lens's centre would see what that sample hit
    """

    radiance: np.ndarray
    depth: np.ndarray
    middle: np.ndarray


def row_of_pinholes(u: float, row: int) -> ToyScene:
    """Return `dof` seen through the point (u, 1/2) of its lens by a film of one row, `PIXELS * FINER` wide.

    `row` counts as in a square image of `PIXELS` pixels; offsets of the film are in units of its own width and height.
    """
    right, _, forward = lens.camera_axes()
    aside = lens.LENS_RADIUS * float(lens.lens_point(u, 0.5)[0])
    origin = lens.ORIGIN + aside * right

    def build() -> dict:
        camera = parts.pinhole_camera(tuple(origin.tolist()), tuple((origin + forward).tolist()), dof.CAMERA["fov"])
        film = {
            "fov_axis": "x",
            "principal_point_offset_x": -aside * lens.pixels_per_unit(PIXELS) / PIXELS,
            "principal_point_offset_y": (row + 0.5 - PIXELS / 2) * FINER,
        }
        return {"type": "scene", "sensor": camera | film, **dof.stage()}

    return ToyScene("scanline", "One row of one view.", build, ("light_u", "light_v"), ("world_position",), max_depth=2)


@cache
def scanline(row: int = ROW, spp: int = 48) -> LightField:
    """Trace the light field of one row, `spp` samples in each cell of u and x."""
    views = []
    for k in range(VIEWS):
        view = row_of_pinholes((k + 0.5) / VIEWS, row)
        samples = capture(view, width=PIXELS * FINER, height=1, spp=spp, seed=k, progress=False)
        position = samples["world_position"][0, :, 0].astype(float)
        depth = np.where(samples.hit[0, :, 0], lens.depth_along_axis(position), np.inf)
        views.append((pixel_mean(samples.radiance)[0], depth, lens.pinhole_x(position, PIXELS)))
    return LightField(*(np.stack(field) for field in zip(*views, strict=True)))


def store_scanline(path: Path) -> None:
    """Write the radiance of the scanline as an EXR image, u down and x across: the notebook's `dof_scanline.exr`."""
    write_exr(path, scanline().radiance)


def lens_us() -> np.ndarray:
    """Return u of the rows of a light field."""
    return (np.arange(VIEWS) + 0.5) / VIEWS


def screen_xs() -> np.ndarray:
    """Return x of the columns of a light field, pixels."""
    return (np.arange(PIXELS * FINER) + 0.5) / FINER


def sheared(radiance: np.ndarray, slope: float) -> np.ndarray:
    """Shift each row so that trajectories of this slope stand upright: reads at x + slope (u - 1/2), linearly.

    `radiance` is (VIEWS, PIXELS * FINER, 3); the border pixel is repeated beyond the border.
    """
    xs = screen_xs()
    rows = zip(radiance, lens_us(), strict=True)
    return np.stack([[np.interp(xs + slope * (u - 0.5), xs, row[:, k]) for k in range(3)] for row, u in rows]).swapaxes(
        1, 2
    )


def measured_slope(radiance: np.ndarray, x: float, reach: float = 3.0) -> float:
    """Return the slope at which the radiance around x (plus or minus `reach` pixels) varies least along u.

    Depth from radiance alone: no world position is used. The smallest of a row of variances, refined by a parabola.
    """
    near = np.abs(screen_xs() - x) < reach
    slopes = np.arange(-9.0, 9.01, 0.25)
    spread = np.array([sheared(radiance, slope)[:, near].var(axis=0).mean() for slope in slopes])
    k = int(np.clip(spread.argmin(), 1, len(slopes) - 2))
    before, least, after = spread[k - 1 : k + 2]
    return float(slopes[k] + 0.25 * 0.5 * (before - after) / (before - 2 * least + after))


# where the row crosses something with texture, pixels at u = 1/2
LANDMARKS = {"green ball": 23.0, "yellow ball": 40.0, "blue ball": 72.0, "red ball": 97.0}


def make_light_field() -> tuple[Figure, dict[str, object]]:
    """Show the scanline in the image, and over (x, u) its radiance and its depth with trajectories drawn in."""
    field = scanline()
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1, 1.7))
    picture = left.subplots()
    picture.imshow(tone_map(reference("dof")), extent=(0, PIXELS, PIXELS, 0))
    picture.axhline(ROW + 0.5, color="white", linewidth=1.5)
    picture.set(title=f"dof; white: row {ROW}", xlabel="screen x (pixels)", ylabel="screen y (pixels)")
    above, below = right.subplots(2, 1, sharex=True)
    extent = (0, PIXELS, 0, 1)
    above.imshow(tone_map(field.radiance), aspect="auto", origin="lower", extent=extent, interpolation="nearest")
    shown = below.imshow(
        field.depth, aspect="auto", origin="lower", extent=extent, interpolation="nearest", cmap="viridis", vmax=11
    )
    figure.colorbar(shown, ax=below, label="depth d", extend="max")
    numbers = {}
    for name, x in LANDMARKS.items():
        depth = float(field.depth[VIEWS // 2, int(x * FINER)])
        slope = float(lens.light_field_slope(depth, PIXELS))
        for axes in (above, below):
            axes.plot([x - slope / 2, x + slope / 2], [0, 1], color="white", linewidth=2.5)
            axes.plot([x - slope / 2, x + slope / 2], [0, 1], color="black", linewidth=1.2)
        found = measured_slope(field.radiance, x)
        implied = lens.FOCUS_DISTANCE / (1 + found / (2 * lens.LENS_RADIUS * lens.pixels_per_unit(PIXELS)))
        numbers[name.split()[0]] = {"depth": depth, "slope": slope, "measured": found, "depth_from_slope": implied}
    above.set(title="radiance; lines: closed-form trajectories", ylabel="lens u")
    below.set(title="depth: the same lines", xlabel="screen x (pixels)", ylabel="lens u")
    deviations = [abs(one["measured"] - one["slope"]) for one in numbers.values()]
    return figure, {"row": ROW, "views": VIEWS, **numbers, "largest_slope_deviation": max(deviations)}


def make_refocus() -> tuple[Slider, dict[str, float]]:
    """Shear the light field for several distances of focus: what stands upright becomes sharp in the mean over u."""
    field = scanline()

    def draw(focus_distance: float) -> Figure:
        slope = float(lens.light_field_slope(focus_distance, PIXELS))
        upright = sheared(field.radiance, slope)
        figure = Figure(figsize=(8, 3.4), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        extent = (0, PIXELS, 0, 1)
        above.imshow(tone_map(upright), aspect="auto", origin="lower", extent=extent, interpolation="nearest")
        below.imshow(tone_map(upright.mean(axis=0)[np.newaxis]), aspect="auto", extent=extent)
        above.set(title=f"light field sheared by {slope:+.1f} pixels", ylabel="lens u")
        below.set(title="mean over u: the scanline", xlabel="screen x (pixels)", yticks=[])
        return figure

    focus_distances = [3.9, 4.5, 5.3, 6.0, 7.0, 8.4, 10.5]
    made = slider(draw, title="Refocusing one scanline", focus_distance=focus_distances, start=lens.FOCUS_DISTANCE)
    return made, {"first": focus_distances[0], "last": focus_distances[-1], "frames": len(focus_distances)}
