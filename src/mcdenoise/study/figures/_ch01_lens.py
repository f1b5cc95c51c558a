"""The thin lens of the scene `dof`: closed forms, and the figure that draws its rays and holds its samples to them.

All lengths across are measured on the plane of focus, where one scene unit is `PIXELS_PER_UNIT * width` pixels.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.render import capture
from mcdenoise.render.scenes import dof
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.charts import COLOURS, GREY

LENS_RADIUS = dof.LENS["aperture_radius"]
FOCUS_DISTANCE = dof.LENS["focus_distance"]
ORIGIN = np.array(dof.CAMERA["origin"])
TANGENT = float(np.tan(np.radians(dof.CAMERA["fov"] / 2)))


def camera_axes() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the unit vectors right, up and forward of the camera of `dof`."""
    forward = np.array(dof.CAMERA["target"]) - ORIGIN
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return right, np.cross(right, forward), forward


def pixels_per_unit(width: int) -> float:
    """Return how many pixels of an image `width` wide one scene unit on the plane of focus takes."""
    return width / (2 * FOCUS_DISTANCE * TANGENT)


def depth_along_axis(position: np.ndarray) -> np.ndarray:
    """Return the depth d of world positions (..., 3): their distance from the lens plane, scene units."""
    return (position - ORIGIN) @ camera_axes()[2]


def pinhole_x(position: np.ndarray, width: int) -> np.ndarray:
    """Return x on the screen, pixels, where the centre of the lens sees the world positions (..., 3)."""
    across = (position - ORIGIN) @ camera_axes()[0]
    return width / 2 + pixels_per_unit(width) * FOCUS_DISTANCE * across / depth_along_axis(position)


def circle_of_confusion(depth: object, focus_distance: float = FOCUS_DISTANCE) -> np.ndarray:
    """Return the diameter of the circle of confusion on the plane of focus, 2 A |d - d_f| / d, scene units.

    Source: similar triangles; the lens model is that of Cook, Porter & Carpenter 1984, section 4.2.
    """
    depth = np.asarray(depth, float)
    return 2 * LENS_RADIUS * np.abs(depth - focus_distance) / depth


def light_field_slope(depth: object, width: int, focus_distance: float = FOCUS_DISTANCE) -> np.ndarray:
    """Return dx/du of a point at `depth`, pixels of an image `width` wide while u goes from 0 to 1 (v = 1/2).

    Its magnitude is the circle of confusion in pixels; it is positive in front of the plane of focus, negative behind.
    """
    return 2 * LENS_RADIUS * pixels_per_unit(width) * (focus_distance / np.asarray(depth, float) - 1)


@cache
def dof_samples(size: int = 128, spp: int = 8) -> SampleBuffer:
    """Return the samples of `dof` that several figures look at."""
    return capture("dof", width=size, height=size, spp=spp, seed=0, progress=False)


def lens_point(lens_u: np.ndarray, lens_v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the place on the unit disk, right and up, to which Mitsuba's thin lens takes u and v in [0, 1).

    The map is the concentric one of Shirley & Chiu 1997; Mitsuba's camera has its own x axis to the left, so that u = 0
    is the right rim. With v = 1/2 the point runs along the horizontal diameter: (1 - 2u, 0).
    """
    a, b = 2 * np.asarray(lens_u, float) - 1, 2 * np.asarray(lens_v, float) - 1
    wide = np.abs(a) > np.abs(b)
    radius, other = np.where(wide, a, b), np.where(wide, b, a)
    turn = np.pi / 4 * other / np.where(radius == 0, 1, radius)
    along, aside = radius * np.cos(turn), radius * np.sin(turn)
    return -np.where(wide, along, aside), np.where(wide, aside, along)


def displacements(samples: SampleBuffer) -> tuple[np.ndarray, np.ndarray]:
    """Return (depth, radius of the circle of confusion in pixels) of the samples far enough from the lens's middle.

    The radius is measured: how far the point that a sample hit stands on the screen from where the centre of the lens
    would see it, divided by the share of the lens radius at which its ray crossed the lens.
    """
    place = lens_point(samples["lens_u"], samples["lens_v"])[0]
    chosen = samples.hit & (np.abs(place) > 0.5)
    position = samples["world_position"][chosen].astype(float)
    shift = samples.screen_position[chosen][:, 0] - pinhole_x(position, samples.width)
    return depth_along_axis(position), np.abs(shift / place[chosen])


def make_thin_lens() -> tuple[Figure, dict[str, float]]:
    """Draw rays of one pixel and of three points (left), the circle of confusion against depth with samples (right)."""
    samples = dof_samples()
    figure = Figure(figsize=(9.6, 4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
    _draw_rays(left)
    depth, radius = displacements(samples)
    curve = np.linspace(2.4, 14, 400)
    scale = pixels_per_unit(samples.width)
    right.plot(depth[::20], 2 * radius[::20], ".", color=COLOURS[0], markersize=5, label="measured, samples of dof")
    right.plot(
        curve, scale * circle_of_confusion(curve), color="black", linewidth=1, label=r"$c = 2A\,|d - d_f|\,/\,d$"
    )
    right.axvline(FOCUS_DISTANCE, linestyle=":", color=GREY)
    right.annotate("plane of focus", (FOCUS_DISTANCE, 11), xytext=(6, 0), textcoords="offset points", color=GREY)
    right.axhline(2 * LENS_RADIUS * scale, linestyle="--", color=GREY)
    right.annotate(r"lens diameter $2A$: limit for $d \to \infty$", (5.6, 2 * LENS_RADIUS * scale + 0.3), color=GREY)
    right.set(
        title=f"Circle of confusion, {samples.width} pixels wide image",
        xlabel="depth d (scene units)",
        ylabel="diameter c (pixels)",
        ylim=(0, 20),
        xlim=(2.4, 14),
    )
    right.legend(frameon=False, loc="lower right")
    expected = scale * circle_of_confusion(depth) / 2
    numbers = {
        "lens_radius": LENS_RADIUS,
        "focus_distance": FOCUS_DISTANCE,
        "pixels_per_unit": scale,
        "samples": len(depth),
        "largest_deviation_pixels": float(np.abs(radius - expected).max()),
        "largest_radius_pixels": float(radius.max()),
        "far_limit_pixels": 2 * LENS_RADIUS * scale,
    }
    return figure, numbers


def _draw_rays(axes: Axes) -> None:
    """The lens, the plane of focus, and from each of three points the cone of rays that the lens collects."""
    axes.plot([0, 0], [-LENS_RADIUS, LENS_RADIUS], color="black", linewidth=4, solid_capstyle="butt")
    axes.annotate("lens,\nradius A", (0, -LENS_RADIUS), xytext=(0, -30), textcoords="offset points", ha="center")
    axes.axvline(FOCUS_DISTANCE, linestyle=":", color=GREY)
    axes.annotate(
        "plane of focus, $d_f$", (FOCUS_DISTANCE, 0.66), xytext=(5, 0), textcoords="offset points", color=GREY
    )
    for (depth, across, name), colour in zip(
        ((3.2, -0.3, "near"), (5.3, 0.0, "in focus"), (8.8, 0.55, "far")), COLOURS, strict=False
    ):
        lens = np.linspace(-LENS_RADIUS, LENS_RADIUS, 7)
        end = max(depth, FOCUS_DISTANCE)
        for start in lens:
            axes.plot([0, end], [start, start + (across - start) * end / depth], color=colour, linewidth=0.7)
        axes.plot(depth, across, "o", color=colour)
        axes.annotate(name, (depth, across), xytext=(4, 8), textcoords="offset points", color=colour)
        section = lens + (across - lens) * FOCUS_DISTANCE / depth
        axes.plot([FOCUS_DISTANCE] * 2, [section.min(), section.max()], color=colour, linewidth=5, alpha=0.6)
    axes.set(
        title="Cones of rays; bars: their sections with the plane of focus",
        xlabel="depth d (scene units)",
        ylabel="across (scene units)",
        xlim=(-0.9, 9.6),
        ylim=(-0.75, 0.75),
    )
