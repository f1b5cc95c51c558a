"""Chapter 06, figures of maps: shares in a large and in a small box, alpha and beta, and what makes our bandwidths."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.rpf.passes import prepare
from mcdenoise.study.figures._ch04_data import noisy, picture, samples
from mcdenoise.study.figures._ch05_data import feature_columns, share_bar, share_picture
from mcdenoise.study.figures._ch06_data import ADAPTIVE, OPEN, analysis, filtered

FEATURES = ("world_position", "shading_normal", "albedo", "visibility")
REGIONS = {"focus": np.s_[56:84, 56:80], "front": np.s_[100:124, 104:124]}  # of dof: balls in focus and in front


def shares() -> tuple[Figure, dict]:
    """What lens and light explain of radiance, in the largest and in the smallest box, beside the output."""
    figure, numbers = Figure(figsize=(9.8, 5.2), layout="constrained"), {}
    grid = figure.subplots(2, 4)
    for row, turn in zip(grid, (0, len(OPEN.boxes) - 1), strict=True):
        found, box = analysis("dof", OPEN, turn), OPEN.boxes[turn]
        lens, light = (sum(found[f"{name}_{k}"] for k in "uv").mean(axis=-1) for name in ("lens", "light"))
        whole = found.share_c_r.mean(axis=-1)
        titles = ("W$_c^{r,1}$: lens", "W$_c^{r,2}$: light", "W$_c^r$: all")
        for axes, values, title in zip(row, (lens, light, whole), titles, strict=False):
            shown = share_picture(axes, values, title)
        row[0].set_ylabel(f"box {box}")
        numbers[f"box_{box}"] = {
            region: {"lens": lens[where].mean(), "all": whole[where].mean()} for region, where in REGIONS.items()
        }
    share_bar(figure, shown, grid[:, :3])
    picture(grid[0, 3], noisy("dof"), "input")
    picture(grid[1, 3], filtered("dof", OPEN), "output (RPF)")
    return figure, numbers


def alpha_beta() -> tuple[Figure, dict]:
    """Alpha and beta as images, for the report's constants and for ours."""
    figure, numbers = Figure(figsize=(9.8, 7.4), layout="constrained"), {}
    grid = figure.subplots(4, 6)
    last = len(OPEN.boxes) - 1
    cases = [(scene, label, *of) for scene in ("dof", "motion") for label, of in
             (("report", (OPEN, last, 5)), ("adaptive", (ADAPTIVE, 0, 1)))]  # fmt: skip
    for row, (scene, label, config, turn, gain) in zip(grid, cases, strict=True):
        found = analysis(scene, config, turn)
        picture(row[0], filtered(scene, config), "output")
        row[0].set_ylabel(f"{scene}: {label},\nbox {config.boxes[turn]}", fontsize=9)
        shown = share_picture(row[1], found.alpha.mean(axis=-1), "α")
        numbers[f"{scene}_{label}"] = {"alpha": found.alpha.mean(), "alpha_zero": 100 * (found.alpha == 0).mean()}
        for axes, name in zip(row[2:], FEATURES, strict=True):
            if name not in samples(scene).feature_names:
                axes.remove()
                continue
            values = found.beta[..., feature_columns(scene, name)].mean(axis=-1)
            words = f"β: {name.replace('_', ' ')}"
            share_picture(axes, gain * values, f"{words} x {gain}" if gain > 1 else words)
            axes.title.set_fontsize(8.5)
            numbers[f"{scene}_{label}"][name] = values.mean()
    share_bar(figure, shown, grid, "α, β")
    for region, where in REGIONS.items():
        found = analysis("dof", ADAPTIVE, 0)
        numbers[region] = {
            "alpha": found.alpha[where].mean(),
            "albedo": found.beta[..., feature_columns("dof", "albedo")][where].mean(),
            "world": found.beta[..., feature_columns("dof", "world_position")][where].mean(),
        }
    return figure, numbers


def idea() -> tuple[Figure, dict]:
    """Variance within pixels, the share of the random parameters, and their product, for albedo and radiance."""
    figure, numbers = Figure(figsize=(9.4, 5.4), layout="constrained"), {}
    grid = figure.subplots(2, 4)
    found, noise = analysis("dof", ADAPTIVE, 0), prepare(samples("dof"), ADAPTIVE, 0).noise
    column, n_f = feature_columns("dof", "albedo").start, found.share_f_r.shape[-1]
    cases = {"albedo": (found.share_f_r[..., column], noise[..., column], 0.3)}
    cases["radiance"] = (found.share_c_r[..., 0], noise[..., n_f], 0.6)
    picture(grid[0, 0], noisy("dof"), "input")
    picture(grid[1, 0], filtered("dof", ADAPTIVE), "output, adaptive")
    for row, (name, (share, variance, top)) in zip(grid, cases.items(), strict=True):
        deviation, widened = np.sqrt(variance), np.sqrt(share * variance)
        share_picture(row[1], deviation, f"{name}, red: $\\sqrt{{v}}$", top)
        shown = share_picture(row[3], widened, r"$\sqrt{W^r v}$", top)
        figure.colorbar(shown, ax=row[3], shrink=0.7)
        figure.colorbar(share_picture(row[2], share, "share W$^r$"), ax=row[2], shrink=0.7)
        numbers[name] = {
            region: {
                "deviation": np.sqrt(variance[where].mean()),
                "widened": np.sqrt((share * variance)[where].mean()),
                "kept": 100 * (share * variance)[where].mean() / variance[where].mean(),
            }
            for region, where in REGIONS.items()
        }
    return figure, numbers
