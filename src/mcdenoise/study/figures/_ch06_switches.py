"""Chapter 06, figures of constants: the presets, every switch one by one, sigma_8, and the handling of spikes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from mcdenoise.rpf import RPFConfig
from mcdenoise.samples import pixel_mean
from mcdenoise.study.figures._ch04_data import bars, log_axis, noisy, picture, samples, tuned
from mcdenoise.study.figures._ch06_data import (
    COLOURS,
    NO_SPIKES,
    PRESETS,
    REPORT,
    SCENES,
    error_of,
    filtered,
    key,
    titled_picture,
    unfiltered,
    without,
)
from mcdenoise.study.figures._references import reference
from mcdenoise.study.slider import Slider, slider

SIGMAS = (0.0005, 0.002, 0.005, 0.02, 0.05, 0.1, 0.2, 0.5)
SPIKES = {
    "none": NO_SPIKES,
    "mean (report)": REPORT,
    "joint": RPFConfig.technical_report(spikes="joint"),
    "clamp": RPFConfig.technical_report(spikes="clamp", spike_limit=0.5),
}
CROPS = {"dof": np.s_[2:46, 40:84], "glossy": np.s_[42:86, 0:44]}
WHAT = {"dof": "lamps out of focus", "glossy": "rough metal"}


def presets() -> tuple[Figure, dict]:
    """RelMSE of the presets on five scenes, and the table of where they differ."""
    rows = {
        scene: {"unfiltered": unfiltered(scene)} | {name: error_of(scene, one) for name, one in PRESETS.items()}
        for scene in SCENES
    }
    figure = Figure(figsize=(9.8, 4.4), layout="constrained")
    axes = figure.subplots()
    bars(axes, rows, COLOURS)
    for place, scene in enumerate(SCENES):
        axes.plot([place - 0.42, place + 0.42], [tuned("gaussian", scene).error] * 2, color="#222222", linewidth=1.4)
    for text in axes.texts:  # readable across the lines
        text.set(zorder=5, path_effects=[withStroke(linewidth=2, foreground="white")])
    axes.plot([], [], color="#222222", label="best Gaussian")
    log_axis(axes, 0.003, 0.15)
    axes.legend(frameon=False, ncols=4, loc="upper center", fontsize=9)
    numbers = {scene: {key(name): value for name, value in of.items()} for scene, of in rows.items()}
    for scene in SCENES:
        numbers[scene]["gaussian"] = tuned("gaussian", scene).error
        published = [error_of(scene, one) for name, one in PRESETS.items() if name != "adaptive"]
        numbers[scene]["best_published"] = min(published)
    beaten = sum(numbers[scene]["best_published"] < numbers[scene]["gaussian"] for scene in SCENES)
    full = RPFConfig.technical_report(noisy=False, sample_fraction=0.5)  # the M as published
    numbers["published_m"] = {scene: error_of(scene, full) for scene in ("dof", "motion")}
    return figure, numbers | {"tables": preset_tables(), "published_beat_gaussian": int(beaten)}


def preset_tables() -> list[str]:
    """Where the presets differ, as two tables of the page: either fits on a slide."""
    head, rule, *rows = preset_rows().splitlines()
    half = (len(rows) + 1) // 2
    return ["\n".join([head, rule, *part]) for part in (rows[:half], rows[half:])]


def preset_rows(configs: dict[str, RPFConfig] | None = None) -> str:
    """Where configurations differ, as a table of the page.

    Examples
    --------
    >>> print(preset_rows({"a": RPFConfig.lecture(), "b": RPFConfig.lecture(levels=5)}))
    | | a | b |
    |---|---|---|
    | `levels` | 15 | 5 |
    """
    configs = PRESETS if configs is None else configs
    lines = ["| | " + " | ".join(configs) + " |", "|---" * (len(configs) + 1) + "|"]
    for one in fields(RPFConfig):
        values = [getattr(config, one.name) for config in configs.values()]
        if any(value != values[0] for value in values):
            lines.append(f"| `{one.name}` | " + " | ".join(_word(value) for value in values) + " |")
    return "\n".join(lines)


def _word(value: object) -> str:
    """A value in few characters."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return " ".join(_word(one) for one in value) or "-"
    if isinstance(value, (int, float)):
        return "none" if np.isinf(value) else f"{value:g}"
    return "-" if value is None else str(value)


def switches_of(scene: str) -> dict[str, RPFConfig | None]:
    """The report's constants without spike handling, and with one switch changed."""
    changed: Callable[..., RPFConfig] = lambda **changes: RPFConfig.technical_report(**{"spikes": "none", **changes})  # noqa: E731
    rest = without(scene, "light")
    return {
        "report, no spike handling": NO_SPIKES,
        "spikes: mean (as published)": REPORT,
        "spikes: joint": SPIKES["joint"],
        "spikes: clamp": SPIKES["clamp"],
        "no clustering": changed(clustering=False),
        "sigma_8^2 = 0.002": changed(sigma_8_squared=0.002),
        "sigma_8^2 = 0.1": changed(sigma_8_squared=0.1),
        "alpha = 1 - W": changed(alpha_start=1.0, alpha_step=0.1),
        "alpha = 1 - 4 W": changed(alpha_start=4.0, alpha_step=0.4),
        "beta without W_c^f": changed(by_feature_share=False),
        "only boxes 17 and 7": changed(passes=(2, 3)),
        "light numbers left out": changed(random_params=rest) if rest else None,
    }


def switches() -> tuple[Figure, dict]:
    """RelMSE of five scenes with each switch changed alone; colour: against the first row."""
    table = {name: [] for name in switches_of("dof")}
    for scene in SCENES:
        for name, config in switches_of(scene).items():
            table[name].append(error_of(scene, config) if config else np.nan)
    values = np.array(list(table.values()))
    figure = Figure(figsize=(8.6, 4.9), layout="constrained")
    axes = figure.subplots()
    shown = axes.imshow(values / values[0], norm=LogNorm(0.4, 2.5), cmap="RdYlGn_r", aspect="auto")
    for (i, j), value in np.ndenumerate(values):
        text = f"{1000 * value:.1f}" if np.isfinite(value) else "no other"
        axes.text(j, i, text, ha="center", va="center", fontsize=9)
    names = [name.replace("sigma_8^2", "σ$_8^2$").replace("alpha", "α").replace("beta", "β") for name in table]
    axes.set_yticks(range(len(table)), [name.replace("W_c^f", "W$_c^f$") for name in names], fontsize=9)
    axes.set_xticks(range(len(SCENES)), SCENES)
    axes.axhline(0.5, color="#222222")
    axes.set_title("relMSE x 1000", fontsize=10)
    bar = figure.colorbar(shown, ax=axes, label="against the first row", ticks=(0.5, 0.7, 1, 1.4, 2))
    bar.ax.set_yticklabels(["0.5", "0.7", "1", "1.4", "2"])
    bar.ax.minorticks_off()
    short = ("base", "mean", "joint", "clamp", "open", "sigma_small", "sigma_large", "alpha_1", "alpha_4", "plain_beta",
             "small_boxes", "no_light")  # fmt: skip
    return figure, {
        name: {scene: v for scene, v in zip(SCENES, row, strict=True) if np.isfinite(v)}
        for name, row in zip(short, values, strict=True)
    }


def slider_sigma() -> tuple[Slider, dict]:
    """The output of dof while sigma_8 grows."""
    config = lambda value: RPFConfig.technical_report(spikes="none", clustering=False, sigma_8_squared=value)  # noqa: E731

    def draw(value: float) -> Figure:
        figure = Figure(figsize=(8.4, 3.3), layout="constrained")
        image = filtered("dof", config(value))
        whole, *details = figure.subplots(1, 3)
        titled_picture(whole, image, "dof", "")
        for axes, crop, title in zip(
            details, (np.s_[48:88, 44:84], np.s_[84:124, 84:124]), ("in focus", "out of focus"), strict=True
        ):
            picture(axes, image[crop], title)
        return figure

    numbers = {"sigmas": SIGMAS, "relmse": [error_of("dof", config(value)) for value in SIGMAS]}
    numbers["best"] = SIGMAS[int(np.argmin(numbers["relmse"]))]
    title = "dof after RPF (the report's constants, no clustering, no spike handling)"
    return slider(draw, title=title, start=0.02, sigma_8_squared=SIGMAS), numbers


def spikes() -> tuple[Figure, dict]:
    """What the ways to handle spikes do to bright discs and to fireflies, and to the mean."""
    figure, numbers = Figure(figsize=(9.8, 4.6), layout="constrained"), {}
    grid = figure.subplots(2, 6)
    for row, (scene, crop) in zip(grid, CROPS.items(), strict=True):
        images = {"input": noisy(scene)} | {name: filtered(scene, config) for name, config in SPIKES.items()}
        for axes, (name, image) in zip(row, images.items(), strict=False):
            titled_picture(axes, image, scene, name, crop)
        picture(row[5], reference(scene)[crop], "reference\n")
        row[0].set_ylabel(f"{scene}:\n{WHAT[scene]}", fontsize=9)
        whole = pixel_mean(samples(scene).radiance).mean(dtype=np.float64)
        true = reference(scene)[crop].mean(dtype=np.float64)
        numbers[scene] = {
            key(name.split(" ")[0]): {
                "relmse": error_of(scene, config),
                "mean": 100 * (images[name].mean(dtype=np.float64) / whole - 1),
                "crop": 100 * (images[name][crop].mean(dtype=np.float64) / true - 1),
            }
            for name, config in SPIKES.items()
        }
    return figure, numbers | {"table": spike_rows(numbers)}


def spike_rows(numbers: dict) -> str:
    """Change of the mean of the image, in percent, as a table of the page.

    Examples
    --------
    >>> print(spike_rows({"dof": {"none": {"mean": -1.94}, "clamp": {"mean": 0.2}}}))
    | mean of the image, against the input | none | clamp |
    |---|---|---|
    | `dof` | -1.9 % | +0.2 % |
    """
    names = list(next(iter(numbers.values())))
    lines = ["| mean of the image, against the input | " + " | ".join(names) + " |", "|---" * (len(names) + 1) + "|"]
    for scene, of in numbers.items():
        lines.append(f"| `{scene}` | " + " | ".join(f"{of[name]['mean']:+.1f} %" for name in names) + " |")
    return "\n".join(lines)
