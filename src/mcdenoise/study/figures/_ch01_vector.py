"""The six panels of a neighbourhood's samples: screen position, lens, world position, normal, albedo, radiance."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.samples import SampleBuffer
from mcdenoise.study.charts import COLOURS
from mcdenoise.study.display import tone_map
from mcdenoise.study.figures._ch01_lens import depth_along_axis, dof_samples, lens_point

SIDE = 7  # pixels
CORNER = (90, 98)  # row and column: the blurred edge of the nearest ball, before the floor
EDGE = 3.9  # scene units: the ball is nearer, the floor farther


def neighbourhood() -> tuple[SampleBuffer, np.ndarray]:
    """Return the samples of the neighbourhood, and which of them (SIDE, SIDE, spp) hit the nearer surface."""
    samples = dof_samples(128, 8).crop(*CORNER, SIDE, SIDE)
    return samples, depth_along_axis(samples["world_position"].astype(float)) < EDGE


def share_told(columns: np.ndarray, is_near: np.ndarray) -> float:
    """Return the share of samples that the best straight cut through `columns` (n, k) puts on their own side.

    The cut is that of least squares on +1 and -1.
    """
    design = np.column_stack([np.ones(len(columns)), columns])
    target = np.where(is_near, 1.0, -1.0)
    weights, *_ = np.linalg.lstsq(design, target, rcond=None)
    return float(np.mean((design @ weights > 0) == is_near))


def make_sample_vector() -> tuple[Figure, dict[str, float]]:
    """Scatter p, (u, v), world position, shading normal, albedo and radiance of all samples of the neighbourhood."""
    samples, near = neighbourhood()
    is_near = near.ravel()

    def flat(name: str) -> np.ndarray:
        return samples[name].reshape(is_near.size, -1).astype(float)

    screen = flat("screen_position") + np.array(CORNER[::-1])
    lens = np.column_stack(lens_point(flat("lens_u")[:, 0], flat("lens_v")[:, 0]))
    panels = [
        ("(a) screen position p", screen, (0, 1), "x (pixels)", "y (pixels)"),
        ("(b) random: lens (u, v)", lens, (0, 1), "right", "up"),
        ("(c) world position", flat("world_position"), (0, 1), "x (scene units)", "y, away from camera"),
        ("(d) shading normal", flat("shading_normal"), (0, 2), "x", "z"),
        ("(e) texture: albedo", flat("albedo"), (1, 2), "green", "blue"),
        ("(f) colour: radiance", flat("radiance"), (1, 2), "green", "blue"),
    ]
    figure = Figure(figsize=(8.4, 5.2), layout="constrained")
    colours = tone_map(flat("radiance")[np.newaxis])[0]
    for axes, (title, columns, (i, j), xlabel, ylabel) in zip(figure.subplots(2, 3).flat, panels, strict=True):
        _scatter(axes, columns[:, i], columns[:, j], is_near, colours)
        axes.set(title=title, xlabel=xlabel, ylabel=ylabel)
    figure.axes[0].invert_yaxis()
    for axes in figure.axes[:2]:
        axes.set_aspect("equal")
    figure.axes[2].legend(frameon=False, fontsize=9)
    lit = flat("radiance").mean(axis=1) > 0
    return figure, {
        "samples": is_near.size,
        "side": SIDE,
        "near_share": is_near.mean(),
        "told_by_screen": share_told(screen, is_near),
        "told_by_lens": share_told(lens, is_near),
        "told_by_both": share_told(np.column_stack([screen, lens]), is_near),
        "lit_share": lit.mean(),
    }


def _scatter(axes: Axes, x: np.ndarray, y: np.ndarray, is_near: np.ndarray, colours: np.ndarray) -> None:
    """Points in their own colour; the outline and the shape say which surface the sample hit."""
    for chosen, shape, outline, label in (
        (is_near, "o", COLOURS[0], "ball (near)"),
        (~is_near, "^", COLOURS[3], "floor (far)"),
    ):
        axes.scatter(
            x[chosen], y[chosen], c=colours[chosen], s=11, marker=shape, edgecolors=outline, linewidths=0.6, label=label
        )
