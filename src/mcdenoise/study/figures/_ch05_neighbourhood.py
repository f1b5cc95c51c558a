"""Chapter 05, figures about one neighbourhood: its samples in six panels, all its dependencies, variance that can not tell."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from mcdenoise.rpf import dependency_of
from mcdenoise.samples import sample_variance
from mcdenoise.study.display import tone_map
from mcdenoise.study.figures._ch04_data import noisy, picture, samples
from mcdenoise.study.figures._ch05_data import (
    BOX,
    PLACE_COLOURS,
    PLACES,
    POSITION,
    RANDOM,
    column,
    count_picture,
    feature_columns,
    input_picture,
    neighbourhood,
    share_maps,
    window,
)
from mcdenoise.study.slider import Slider, slider

PANELS = {
    "(a) screen position": (("screen_position", 0), ("screen_position", 1), "x (pixels)", "y (pixels)"),
    "(b) random parameters": (("lens_u", 0), ("lens_v", 0), "lens_u", "lens_v"),
    "(c) world position": (("world_position", 0), ("world_position", 2), "x (scene units)", "z (scene units)"),
    "(d) shading normal": (("shading_normal", 0), ("shading_normal", 2), "x", "z"),
    "(e) texture: albedo": (("albedo", 0), ("albedo", 2), "red", "blue"),
    "(f) sample colour": (("radiance", 0), ("radiance", 2), "red", "blue"),
}
ROWS = ("c red", "c green", "c blue", *(f"{name} {axis}" for name in ("world", "normal") for axis in "xyz"))
ROWS += tuple(f"albedo {axis}" for axis in ("red", "green", "blue"))
STEPS = 9
TWINS = {"in focus": (67, 57), "out of focus": (91, 107)}  # pixels of nearly the same variance


def panels_focus() -> tuple[Figure, dict]:
    """The samples of the box in focus in six spaces, each sample in its own colour."""
    return _panels("in focus")


def panels_blurred() -> tuple[Figure, dict]:
    """The same for the box out of focus."""
    return _panels("out of focus")


def _panels(place: str) -> tuple[Figure, dict]:
    """Six scatter plots of one box, and the shares that belong to them."""
    y, x = PLACES[place]
    box = neighbourhood("dof", y, x)
    colours = tone_map(box.radiance.reshape(1, -1, 3))[0]
    figure = Figure(figsize=(9.4, 5.3), layout="constrained")
    figure.suptitle(f"{place}: box of 11 x 11 pixels around row {y}, column {x}", fontsize=11)
    for axes, (title, (first, second, xlabel, ylabel)) in zip(figure.subplots(2, 3).flat, PANELS.items(), strict=True):
        axes.scatter(column(box, *first), column(box, *second), c=colours, s=10, edgecolors="#888888", linewidths=0.25)
        axes.set(xlabel=xlabel, ylabel=ylabel)
        axes.set_title(title, fontsize=10)
        axes.xaxis.set_major_locator(MaxNLocator(4))
    figure.axes[0].invert_yaxis()  # as the image stands
    figure.axes[4].set(xlim=(-0.05, 1), ylim=(-0.05, 1))
    found = dependency_of(box)
    return figure, {
        "samples": BOX * BOX * 8,
        "c_r": found.share_c_r.mean(),
        "lens": found.share_c_r_each[:, :2].sum(axis=1).mean(),
        "world": found.share_f_r[[0, 2]].mean(),
        "albedo": found.share_f_r[6:9].mean(),
    }


def matrix_focus() -> tuple[Figure, dict]:
    """All pairwise dependencies of the box in focus as a table, and the shares that follow."""
    return _matrix("in focus")


def matrix_blurred() -> tuple[Figure, dict]:
    """The same for the box out of focus."""
    return _matrix("out of focus")


def _matrix(place: str) -> tuple[Figure, dict]:
    """The table of one box, and its numbers."""
    found = dependency_of(neighbourhood("dof", *PLACES[place]))
    figure = Figure(figsize=(9.4, 4.9), layout="constrained")
    axes = figure.subplots()
    left = np.concatenate([np.hstack([found.c_p, found.c_r]), np.hstack([found.f_p, found.f_r])])
    shares = np.concatenate([found.share_c_r, found.share_f_r])
    features = np.vstack([found.c_f, np.full((len(left) - 3, found.c_f.shape[1]), np.nan)])
    _table(axes, np.hstack([left, features]), shares, found.share_c_f)
    axes.set_title(f"{place}: D in thousandths of a nat, W in hundredths", fontsize=10.5)
    numbers = {"share_c_r": found.share_c_r, "share_f_r": found.share_f_r, "share_c_f": found.share_c_f}
    return figure, numbers | {"c_f": found.c_f.sum(), "c_r": found.c_r.sum(), "c_p": found.c_p.sum()}


def _table(axes: Axes, values: np.ndarray, shares: np.ndarray, below: np.ndarray) -> None:
    """Draw the matrix of D with a column W^r at its right and a row W_c^f below."""
    rows, columns = values.shape
    axes.imshow(np.sqrt(values), cmap="YlGn", vmin=0, vmax=1.1, aspect="auto")
    for (i, j), value in np.ndenumerate(values):
        if np.isfinite(value):
            colour = "white" if value > 0.45 else "black"
            axes.text(j, i, f"{1000 * value:.0f}", ha="center", va="center", fontsize=8, color=colour)
    for i, value in enumerate(shares):
        axes.text(columns + 0.1, i, f"{100 * value:.0f}", ha="center", va="center", fontsize=9, weight="bold")
    for j, value in enumerate(below):
        axes.text(6 + j, 3, f"{100 * value:.0f}", ha="center", va="center", fontsize=9, weight="bold")
    for at in (1.5, 5.5):
        axes.axvline(at, color="#222222", linewidth=1.2)
    axes.axhline(2.5, color="#222222", linewidth=1.2)
    names = ["screen x", "screen y", "lens_u", "lens_v", "light_u", "light_v"]
    axes.set_xticks(range(columns + 1), [*names, *ROWS[3:], "W$^r$"], rotation=55, ha="left", fontsize=8)
    axes.xaxis.tick_top()
    axes.set_yticks(range(rows), ROWS, fontsize=8)
    axes.set_xlim(-0.5, columns + 0.7)
    words = ("bold, above: W$_c^{f,k}$, of each feature", "bold, right: W$_{c,k}^r$ and W$_{f,k}^r$, of each row")
    for k, text in enumerate(words):
        axes.text(5.7, 4.4 + 0.9 * k, text, fontsize=9)


def variance_twins() -> tuple[Figure, dict]:
    """Variance of the albedo in a pixel against the share that random parameters explain of it; two pixels of one variance."""
    shares = share_maps("dof")["f_r"][..., feature_columns("dof", "albedo")].mean(axis=-1)
    variances = pixel_variance()[1::2, 1::2]
    figure = Figure(figsize=(9.4, 3.9), layout="constrained")
    left, *crops = figure.subplots(1, 3, width_ratios=(1.5, 1, 1))
    seen = variances > 1e-3
    left.plot(variances[seen], shares[seen], ".", markersize=3, color="#999999")
    numbers = {"correlation": np.corrcoef(variances[seen], shares[seen])[0, 1]}
    for axes, (place, (y, x)) in zip(crops, TWINS.items(), strict=True):
        top, at, height, width = window(y, x)
        picture(axes, noisy("dof")[top : top + height, at : at + width])
        axes.plot(x - at, y - top, "s", markersize=14, fillstyle="none", color="#222222", markeredgewidth=2)
        found = dependency_of(neighbourhood("dof", y, x))
        one = {"variance": pixel_variance()[y, x], "share": found.share_f_r[6:9].mean()}
        left.plot(one["variance"], one["share"], "o", markersize=9, color=PLACE_COLOURS[place], label=place)
        axes.set_title(
            f"{place}: variance {one['variance']:.3f},\nshare of lens and light {one['share']:.2f}", fontsize=10
        )
        numbers[place.replace(" ", "_")] = one
    left.set(
        xlabel="variance of the albedo in a pixel", ylabel="W$_{f,k}^r$ of the albedo", xlim=(0, None), ylim=(0, 1)
    )
    left.set_title("pixels of dof with more than one albedo", fontsize=10)
    left.legend(frameon=False)
    return figure, numbers


def pixel_variance() -> np.ndarray:
    """Variance of the albedo among the samples of each pixel of dof, summed over channels, (h, w)."""
    return sample_variance(samples("dof")["albedo"]).sum(axis=-1, dtype=np.float64)


def slider_place() -> tuple[Slider, dict]:
    """Move the box from the ball in focus to the one in front of it, and watch the two histograms change places."""
    start, end = (np.array(where) for where in PLACES.values())
    places = [tuple(np.rint(start + (end - start) * k / (STEPS - 1)).astype(int)) for k in range(STEPS)]
    found = [dependency_of(neighbourhood("dof", int(y), int(x))) for y, x in places]

    def draw(step: int) -> Figure:
        y, x = (int(one) for one in places[step - 1])
        box, one = neighbourhood("dof", y, x), found[step - 1]
        figure = Figure(figsize=(9.6, 3.2), layout="constrained")
        image, lens, screen, bars = figure.subplots(1, 4, width_ratios=(1, 1.1, 1.1, 0.8))
        input_picture(image, "dof", f"row {y}, column {x}")
        top, left, height, width = window(y, x)
        image.add_patch(Rectangle((left, top), width, height, fill=False, edgecolor="#ff3333", linewidth=2))
        for axes, (name, label) in zip(
            (lens, screen), (("lens_u", "lens_u"), ("screen_position", "screen x")), strict=True
        ):
            of = count_picture(
                axes, column(box, name), column(box, "world_position"), (label, "world x"), numbers=False
            )
            axes.set_title(f"µ = {of:.3f}", fontsize=10)
        values = [one.share_f_r[0], one.share_f_r[6:9].mean(), one.share_c_r_each[:, :2].sum(axis=1).mean()]
        bars.bar_label(bars.bar(range(3), values, color=(POSITION, POSITION, RANDOM)), fmt="%.2f", fontsize=9)
        bars.set_xticks(range(3), ("world\nx", "albedo", "radiance,\nlens"), fontsize=8.5)
        bars.set(ylim=(0, 1))
        bars.set_title("shares", fontsize=10)
        return figure

    title = "From the ball in focus to the ball in front of it"
    numbers = {"world_x": [one.share_f_r[0] for one in found], "first": 1, "last": STEPS}
    return slider(draw, title=title, start=1, step=range(1, STEPS + 1)), numbers
