"""Chapter 06, figures of where it fails: rare bright samples and the clustering, features that say the same."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.rpf import RPFConfig, rpf, rpf_neighbourhood
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.figures._ch04_data import error, noisy, picture, samples
from mcdenoise.study.figures._ch06_data import ADAPTIVE, NO_SPIKES, OPEN, filtered
from mcdenoise.study.figures._references import reference

BRIGHT = 2.0  # radiance of a sample that hit a lamp, at least
DISC, SKY = 0.2, 34  # discs of lamps: pixels of dof brighter than DISC in the reference, above row SKY
COUNTS = (0, 1, 2, 3, 4)
COPIES = (1, 2, 4)
LAMP = (12, 58)  # a pixel in a disc: one of its samples is on the lamp
FILTERS = {"with clustering": NO_SPIKES, "without": OPEN, "adaptive": ADAPTIVE}
COLOURS = {"input": "#BBBBBB", "with clustering": "#EE6677", "without": "#228833", "adaptive": "#000000"}


def discs() -> np.ndarray:
    """Pixels of dof in the discs of lamps, (h, w) bool."""
    inside = reference("dof").mean(axis=-1) > DISC
    inside[SKY:] = False
    inside[29:, :60] = False  # a ball
    return inside


def lamp_samples() -> np.ndarray:
    """How many samples of each pixel of dof are on a lamp, (h, w)."""
    return (samples("dof").radiance.max(axis=-1) > BRIGHT).sum(axis=-1)


def lamps() -> tuple[Figure, dict]:
    """Brightness of the discs after RPF, over how many of a pixel's own samples hit the lamp; and the weights behind it."""
    figure, numbers = Figure(figsize=(9.8, 3.6), layout="constrained"), {}
    image, left, right = figure.subplots(1, 3, width_ratios=(0.8, 1.1, 1.1))
    inside, count, true = discs(), lamp_samples(), reference("dof").mean(axis=-1)
    picture(image, np.where(inside[..., np.newaxis], noisy("dof"), 0.3 * noisy("dof"))[:64, :128], "pixels in question")
    images = {"input": noisy("dof")} | {name: filtered("dof", config) for name, config in FILTERS.items()}
    for name, one in images.items():
        ratio = [one.mean(axis=-1)[inside & (count == k)].mean() / true[inside & (count == k)].mean() for k in COUNTS]
        left.plot(COUNTS, ratio, "o-", color=COLOURS[name], label=name)
        numbers[name.replace(" ", "_")] = {
            "ratio": ratio,
            "all": one.mean(axis=-1)[inside].mean() / true[inside].mean(),
        }
    left.axhline(1, color="#222222", linestyle=":", linewidth=1)
    left.set(xlabel="samples of the pixel on the lamp, of 8", ylabel="mean radiance over the true one", ylim=(0, 3))
    left.legend(frameon=False, fontsize=8.5)
    bright = samples("dof").radiance.max(axis=-1)
    numbers["brighter"] = bright[bright > BRIGHT].mean() / np.median(bright[inside][bright[inside] < BRIGHT])
    numbers["none"] = 100 * (inside & (count == 0)).sum() / inside.sum()
    _bright_weights(right, numbers)
    return figure, numbers


def _bright_weights(axes: Axes, numbers: dict) -> None:
    """Mean weight between samples on and off the lamp, against that between samples off it."""
    places = np.argwhere(discs() & (lamp_samples() >= 1) & (lamp_samples() <= 4))[::25]
    for name, config in FILTERS.items():
        mixed = []
        for turn in range(len(config.boxes)):
            found = [_mixing(tuple(int(k) for k in pixel), config, turn) for pixel in places]
            mixed.append(float(np.mean(found)))
        at = np.arange(len(config.boxes)) + (4 - len(config.boxes))
        axes.plot(at, mixed, "o-", color=COLOURS[name], label=name)
        for x, y, box in zip(at, mixed, config.boxes, strict=True):
            axes.annotate(
                f"{box}", (x, y), (0, 6), textcoords="offset points", fontsize=8, ha="center", color=COLOURS[name]
            )
        numbers[name.replace(" ", "_")]["mixing"] = mixed
    axes.set_xticks(range(4), ["first", "second", "third", "last"])
    axes.set(
        xlabel="pass (numbers: side of the box)",
        ylabel="weight of on with off, against off with off",
        ylim=(-0.05, 1.15),
    )


def _mixing(pixel: tuple[int, int], config: RPFConfig, turn: int) -> float:
    """Mean weight of the pixel's samples off the lamp with all samples on it, over their mean weight with those off it."""
    found = rpf_neighbourhood(samples("dof"), pixel, config, turn)
    on, spp = found.radiance.max(axis=-1) > BRIGHT, len(found.weights)
    own = ~on[:spp]
    if not on[spp:].any():
        return 0.0
    return float(found.weights[own][:, spp:][:, on[spp:]].mean() / found.weights[own][:, spp:][:, ~on[spp:]].mean())


def with_copies(buffer: SampleBuffer, copies: int) -> SampleBuffer:
    """The same samples, their albedo repeated so often."""
    features = {name: buffer[name] for name in buffer.feature_names}
    features |= {f"albedo_copy_{k}": buffer["albedo"] for k in range(1, copies)}
    random_params = {name: buffer[name] for name in buffer.random_param_names}
    return SampleBuffer.from_arrays(buffer.radiance, buffer.screen_position, random_params, features)


@cache
def error_with_copies(scene: str, config: RPFConfig, copies: int) -> float:
    """RelMSE when the albedo is given so often."""
    return error(rpf(with_copies(samples(scene), copies), config, progress=False), scene)


def columns() -> tuple[Figure, dict]:
    """RelMSE over how often the same feature is given."""
    figure, numbers = Figure(figsize=(8.8, 3.5), layout="constrained"), {"copies": COPIES}
    for axes, scene in zip(figure.subplots(1, 2), ("dof", "motion"), strict=True):
        numbers[scene] = {}
        plain_beta = RPFConfig.technical_report(spikes="none", clustering=False, by_feature_share=False)
        for (name, config), colour in zip(
            {"report": OPEN, "report without W$_c^f$": plain_beta, "adaptive": ADAPTIVE}.items(),
            ("#228833", "#CCBB44", "#000000"),
            strict=True,
        ):
            errors = [error_with_copies(scene, config, one) for one in COPIES]
            axes.plot(range(len(COPIES)), np.array(errors) / errors[0], "o-", color=colour, label=name)
            numbers[scene][name.split("$")[0].strip().replace(" ", "_")] = errors
        axes.set_xticks(range(len(COPIES)), COPIES)
        axes.set(xlabel="how often the albedo is given", ylabel="relMSE, against once", ylim=(0.8, 1.1))
        axes.set_title(scene, fontsize=10)
        axes.grid(color="#e5e5e5")
    figure.axes[0].legend(frameon=False, fontsize=8.5)
    return figure, numbers
