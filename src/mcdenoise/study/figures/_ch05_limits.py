"""Chapter 05, figures about the limits: second hits, where shares mislead, and what all of it costs."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.kernels.dependency import information_of_pairs as compiled_pairs
from mcdenoise.rpf import dependency, dependency_of, mutual_information
from mcdenoise.rpf.dependency import information_of_pairs, quantise
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.figures._ch05_data import (
    CHANCE,
    LIGHT,
    PLACES,
    POSITION,
    RANDOM,
    column,
    feature_columns,
    input_picture,
    neighbourhood,
    share_bar,
    share_maps,
    share_picture,
)

LAMP_NEAR = ("dof", 11, 89)  # a box of wall with one sample on a lamp
WALL = ("pinhole", 40, 90)  # a plane: world y is constant but for rounding
SHADOWS = {"narrow penumbra": ("soft_shadow", 42, 95), "wide penumbra": ("soft_shadow", 40, 100)}
METAL, WALLS = np.s_[26:40, 6:20], np.s_[2:22, 2:62]  # of the maps of glossy
SIDES = (3, 5, 7, 11, 15, 21)
ROUNDS, TURN = 8, 0.1  # seconds


def second_hits() -> tuple[Figure, dict]:
    """Glossy: the share of random parameters in the features of the first and of the second hit."""
    figure = Figure(figsize=(9.8, 2.6), layout="constrained")
    grid, numbers, each = figure.subplots(1, 4), {}, share_maps("glossy")["c_r_each"]
    input_picture(grid[0], "glossy", "glossy")
    shown = share_picture(grid[1], each[..., 2:].sum(axis=-1), "radiance: bsdf_u, bsdf_v")
    for axes, name in zip(grid[2:], ("world_position", "world_position_2"), strict=True):
        columns = feature_columns("glossy", name)
        values = share_maps("glossy")["f_r"][..., columns.start : columns.stop : 2].mean(axis=-1)  # x and z
        share_picture(axes, values, f"{name}, x and z")
        numbers[name] = {
            "median": np.median(values),
            "metal": values[METAL].mean(),
            "walls": values[WALLS].mean(),
        }
    share_bar(figure, shown, list(grid))
    return figure, numbers


def one_bright_sample() -> dict[str, dict[str, float]]:
    """What red says about light and screen in a box of wall, with and without the one sample on the lamp."""
    box = neighbourhood(*LAMP_NEAR)
    red = column(box, "radiance")
    kept = red < red.max()
    found = {}
    for name, where in (("with", np.ones_like(kept)), ("without", kept)):
        others = {"light": ("light_u", "light_v"), "lens": ("lens_u", "lens_v")}
        of = {
            kind: sum(mutual_information(red[where], column(box, one)[where]) for one in names)
            for kind, names in others.items()
        }
        screen = sum(mutual_information(red[where], column(box, "screen_position", k)[where]) for k in (0, 1))
        found[name] = of | {"screen": screen, "deviation": float(red[where].std()), "samples": int(where.sum())}
    return found


def fails() -> tuple[Figure, dict]:
    """One bright sample hides all; rounding noise is taken for a variable; a wide box drowns a narrow penumbra."""
    figure = Figure(figsize=(9.8, 3.6), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    bright = one_bright_sample()
    _bright_bars(left, bright)
    numbers = {"bright": bright, "wall": flat_wall()}
    _wall_bars(middle, numbers["wall"])
    numbers["penumbra"] = {"sides": SIDES}
    for (name, where), marker in zip(SHADOWS.items(), "os", strict=True):
        values = [dependency_of(neighbourhood(*where, side)).share_c_r.mean() for side in SIDES]
        right.plot(SIDES, values, f"{marker}-", color=(POSITION, RANDOM)[marker == "s"], label=name)
        numbers["penumbra"][name.split()[0]] = values
    right.set(ylim=(0, 1), xlabel="side of the box (pixels)", ylabel="W$_c^r$", xticks=SIDES)
    right.set_title("soft_shadow", fontsize=10)
    right.legend(frameon=False, fontsize=9)
    return figure, numbers


def flat_wall() -> dict[str, np.ndarray]:
    """W_{f,k}^r of the world position on a wall, and the same if float rounding counts as a variable."""
    box = neighbourhood(*WALL)
    p, r, f, c = blocks_of(box)
    columns = feature_columns(WALL[0], "world_position")
    world = f[:, columns].astype(float)
    centred = dependency(p, r, world - world.mean(axis=0), c)  # nothing left to compare the last bits with
    return {
        "shares": dependency_of(box).share_f_r[columns],
        "rounding_counted": centred.share_f_r,
        "deviations": world.std(axis=0),
    }


def _wall_bars(axes: Axes, wall: dict) -> None:
    """Bars of W for x, y, z on the wall; grey: with rounding as a variable."""
    names = [f"{axis}\n{deviation:.0e}" for axis, deviation in zip("xyz", wall["deviations"], strict=True)]
    for shift, (kind, colour, label) in enumerate(
        (
            ("rounding_counted", CHANCE, "rounding taken for a variable"),
            ("shares", POSITION, "rounding taken for constant"),
        )
    ):
        bars = axes.bar(np.arange(3) + 0.4 * (shift - 0.5), wall[kind], 0.38, color=colour, label=label)
        axes.bar_label(bars, fmt="%.2f", fontsize=8.5)
    axes.set_xticks(range(3), names)
    axes.set(ylim=(0, 1), ylabel="W$_{f,k}^r$", xlabel="standard deviation (scene units)")
    axes.set_title("world position on a flat wall", fontsize=10)
    axes.legend(frameon=False, fontsize=9, loc="upper left")


def _bright_bars(axes: Axes, bright: dict) -> None:
    """Bars of D with and without the one bright sample."""
    for shift, (kind, colour) in enumerate((("light", LIGHT), ("lens", RANDOM), ("screen", POSITION))):
        for place, name in enumerate(bright):
            bar = axes.bar(
                place + 0.27 * (shift - 1), bright[name][kind], 0.25, color=colour, label=kind if not place else None
            )
            axes.bar_label(bar, fmt="%.2f", fontsize=8.5)
    axes.set_xticks((0, 1), [f"{name}\n{bright[name]['samples']} samples" for name in bright])
    axes.set(ylabel="D of red (nats)")
    axes.margins(y=0.12)
    axes.set_title("a wall, one sample on a lamp", fontsize=10)
    axes.legend(frameon=False, fontsize=9, loc="upper left")


def amount() -> tuple[Figure, dict]:
    """A share says nothing about an amount: W_c^r of soft_shadow beside the deviation of the radiance in each box."""
    figure = Figure(figsize=(9.8, 3.4), layout="constrained")
    grid, shares = figure.subplots(1, 4, width_ratios=(1, 1, 1, 1.3)), share_maps("soft_shadow")["c_r"]
    spread = np.array(
        [
            [neighbourhood("soft_shadow", y, x).radiance.std(axis=(0, 1, 2)).mean() for x in range(1, 128, 2)]
            for y in range(1, 128, 2)
        ]
    )
    input_picture(grid[0], "soft_shadow", "soft_shadow")
    share_bar(figure, share_picture(grid[1], shares, "W$_c^r$"), grid[1], label="")
    shown = grid[2].imshow(spread, cmap="magma", vmin=0, interpolation="nearest")
    grid[2].set(xticks=[], yticks=[])
    grid[2].set_title("standard deviation\nof the radiance in the box", fontsize=10)
    figure.colorbar(shown, ax=grid[2], shrink=0.7, pad=0.01)
    grid[3].plot(spread.ravel(), shares.ravel(), ".", markersize=2, color="#777777")
    grid[3].set(xlabel="standard deviation", ylabel="W$_c^r$", ylim=(0, 1), xlim=(0, None))
    quiet, loud = spread < np.percentile(spread, 25), spread > np.percentile(spread, 75)
    return figure, {
        "quiet": {"share": np.median(shares[quiet]), "deviation": np.median(spread[quiet])},
        "loud": {"share": np.median(shares[loud]), "deviation": np.median(spread[loud])},
    }


def blocks_of(box: SampleBuffer) -> list[np.ndarray]:
    """Position, random parameters, features and radiance of a box, (n, k) each."""
    blocks = (box.screen_position, box.random_params, box.features, box.radiance)
    return [block.reshape(-1, block.shape[-1]) for block in blocks]


def levels_of(box: SampleBuffer) -> list[np.ndarray]:
    """Levels of position, random parameters, features and radiance of a box, cut at one go as `dependency` does it."""
    blocks = blocks_of(box)
    ends = np.cumsum([block.shape[1] for block in blocks[:-1]])
    return np.split(quantise(np.concatenate(blocks, axis=1)), ends, axis=1)


def all_pairs(pairs: Callable, levels: list[np.ndarray]) -> int:
    """Everything that `dependency` needs; returns the number of pairs."""
    p, r, f, c = levels
    return sum(pairs(x, y).size for x, y in ((c, r), (c, p), (c, f), (f, r), (f, p)))


def scikit_pairs(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The same pairs by scikit-learn."""
    from sklearn.metrics import mutual_info_score

    return np.array([[mutual_info_score(one, other) for other in y.T] for one in x.T])


def shortest_times(ways: dict[str, Callable[[], object]]) -> dict[str, float]:
    """CPU seconds of each, in turns: the run that other work disturbed least."""
    shortest = dict.fromkeys(ways, np.inf)
    for _ in range(ROUNDS):
        for name, run in ways.items():
            run()  # warms up
            ends, now = time.process_time() + TURN, 0.0
            while now < ends:
                start = time.process_time()
                run()
                now = time.process_time()
                shortest[name] = min(shortest[name], now - start)
    return shortest


def cost() -> tuple[Figure, dict]:
    """CPU time for all pairs of one neighbourhood, three ways, and for the bins before them."""
    box = neighbourhood("dof", *PLACES["out of focus"])
    levels = levels_of(box)
    ways = {
        "scikit-learn, pair by pair": (lambda: all_pairs(scikit_pairs, levels), CHANCE),
        "NumPy, pair by pair": (lambda: all_pairs(information_of_pairs, levels), POSITION),
        "numba, counting bits": (lambda: all_pairs(compiled_pairs, levels), RANDOM),
        "cutting into bins (NumPy)": (lambda: levels_of(box), LIGHT),
    }
    seconds = shortest_times({name: run for name, (run, _) in ways.items()})
    figure = Figure(figsize=(8.6, 2.7), layout="constrained")
    axes = figure.subplots()
    bars = axes.barh(
        list(seconds), [1e3 * one for one in seconds.values()], color=[colour for _, colour in ways.values()]
    )
    axes.bar_label(bars, fmt="%.2f ms", fontsize=9, padding=3)
    axes.invert_yaxis()
    axes.set(xscale="log", xlabel="CPU milliseconds for one neighbourhood (one core of this machine)")
    axes.margins(x=0.15)
    scikit, plain, fast, bins = seconds.values()
    pairs = all_pairs(information_of_pairs, levels)
    return figure, {"pairs": pairs, "scikit": scikit / fast, "numpy": plain / fast, "bins": bins / fast}
