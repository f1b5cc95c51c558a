"""Pictures in a notebook: images side by side under one tone map, a student's image beside its target, a slider."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.study.display import tone_map


def show_images(images: Mapping[str, object], *, title: str = "", columns: int = 4) -> Figure:
    """Show images side by side, all under the same tone map."""
    columns = min(columns, len(images))
    rows = -(-len(images) // columns)
    figure = Figure(figsize=(3.2 * columns, 3.4 * rows), layout="constrained")
    figure.suptitle(title)
    grid = figure.subplots(rows, columns, squeeze=False)
    for axes in grid.flat:
        axes.axis("off")
    for axes, (name, image) in zip(grid.flat, images.items(), strict=False):
        axes.imshow(tone_map(image), interpolation="nearest", cmap="gray", vmin=0, vmax=1)
        axes.set_title(name, fontsize=10)
    return figure


def show_difference(yours: object, target: object, *, title: str = "") -> Figure:
    """Show an image, the image it should be, and their difference on a scale of its own."""
    yours, target = np.asarray(yours, float), np.asarray(target, float)
    figure = Figure(figsize=(9.6, 3.4), layout="constrained")
    figure.suptitle(title)
    left, middle, right = figure.subplots(1, 3)
    left.imshow(tone_map(yours), cmap="gray", vmin=0, vmax=1)
    middle.imshow(tone_map(target), cmap="gray", vmin=0, vmax=1)
    difference = yours - target
    difference = difference.mean(axis=-1) if difference.ndim == 3 else difference
    bound = max(np.abs(difference).max(), 1e-6)
    shown = right.imshow(difference, cmap="RdBu_r", vmin=-bound, vmax=bound)
    figure.colorbar(shown, ax=right, label="yours - target (radiance)")
    for axes, name in zip((left, middle, right), ("yours", "target", "difference"), strict=True):
        axes.set(xticks=[], yticks=[], title=name)
    return figure
