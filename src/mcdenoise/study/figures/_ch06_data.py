"""What the figures of chapter 06 start from: configurations, filtered images, analyses, small helpers."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from time import process_time

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.rpf import RPFAnalysis, RPFConfig, rpf, rpf_analysis
from mcdenoise.study.display import error_scale
from mcdenoise.study.figures._ch04_data import SPP, error, error_picture, noisy, picture, samples
from mcdenoise.study.figures._references import reference

SCENES = ("dof", "motion", "soft_shadow", "glossy", "pinhole")
REPORT = RPFConfig.technical_report()  # as published, but for M
NO_SPIKES = RPFConfig.technical_report(spikes="none")
OPEN = RPFConfig.technical_report(spikes="none", clustering=False)
ADAPTIVE = RPFConfig.adaptive()
PRESETS = {
    "lecture": RPFConfig.lecture(),
    "report, noisy": REPORT,
    "report, smooth": RPFConfig.technical_report(noisy=False),
    "NVIDIA": RPFConfig.nvidia(),
    "authors' release": RPFConfig.authors_release(),
    "adaptive": ADAPTIVE,
}
COLOURS = dict(
    zip(
        ("unfiltered", *PRESETS),
        ("#BBBBBB", "#CCBB44", "#EE6677", "#AA3377", "#228833", "#66CCEE", "#4477AA"),
        strict=True,
    )
)
SCENE_COLOURS = dict(zip(SCENES, ("#4477AA", "#EE6677", "#228833", "#CCBB44", "#AA3377"), strict=True))
GAINS = (0.0, 1.5, 3.0, 6.0, 12.0, 24.0)
SPPS = (4, 8, 16)


@cache
def timed(scene: str, config: RPFConfig, spp: int = SPP, seed: int = 0) -> tuple[np.ndarray, float]:
    """The image after RPF, and the CPU time of all threads in seconds."""
    start = process_time()
    image = rpf(samples(scene, spp), config, seed=seed, progress=False)
    return image, process_time() - start


def filtered(scene: str, config: RPFConfig, spp: int = SPP, seed: int = 0) -> np.ndarray:
    """The image after RPF."""
    return timed(scene, config, spp, seed)[0]


def error_of(scene: str, config: RPFConfig, spp: int = SPP, seed: int = 0) -> float:
    """RelMSE of the image after RPF."""
    return error(filtered(scene, config, spp, seed), scene)


@cache
def analysis(scene: str, config: RPFConfig, turn: int) -> RPFAnalysis:
    """Maps of shares and weights in one pass."""
    return rpf_analysis(samples(scene), config, turn, progress=False)


def without(scene: str, start: str) -> tuple[str, ...]:
    """The random parameters of a scene but for those whose names begin so."""
    return tuple(name for name in samples(scene).random_param_names if not name.startswith(start))


def gallery(
    rows: Sequence[tuple[str, str, Sequence[tuple[str, np.ndarray]]]],
    size: tuple[float, float],
    crop: tuple = np.s_[:, :],
) -> Figure:
    """Rows of images: (scene, label, [(title, image), ...]); relMSE of the whole image below each title."""
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(len(rows), max(len(images) for _, _, images in rows), squeeze=False)
    for axes_of_row, (scene, label, images) in zip(grid, rows, strict=True):
        for axes, (title, image) in zip(axes_of_row, images, strict=False):
            titled_picture(axes, image, scene, title, crop)
        axes_of_row[0].set_ylabel(label, fontsize=10)
    return figure


def titled_picture(axes: Axes, image: np.ndarray, scene: str, title: str, crop: tuple = np.s_[:, :]) -> None:
    """An image, its name, and the relMSE of the whole image."""
    lines = [title] if image is reference(scene) else [title, f"{error(image, scene):.4f}"]
    picture(axes, image[crop], "\n".join(line for line in lines if line))
    axes.title.set_fontsize(9.5)


def error_row(figure: Figure, grid: Sequence[Axes], images: Sequence[np.ndarray], scene: str, ceiling: float) -> None:
    """Error maps of images on one scale, with its colour bar."""
    for axes, image in zip(grid, images, strict=False):
        error_picture(axes, image, scene, ceiling)
    bar = figure.colorbar(error_scale(ceiling), ax=list(grid), shrink=0.8, pad=0.01)
    bar.set_label("(x - ref)² / (ref² + 0.01)", fontsize=8)


def unfiltered(scene: str) -> float:
    """RelMSE without a filter."""
    return error(noisy(scene), scene)


def key(name: str) -> str:
    """A name as the page quotes it: letters, digits and low lines.

    Examples
    --------
    >>> key("report, noisy"), key("authors' release")
    ('report_noisy', 'authors_release')
    """
    return name.replace("'", "").replace(",", "").replace(" ", "_")
