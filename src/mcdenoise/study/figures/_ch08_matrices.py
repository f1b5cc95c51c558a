"""Chapter 08, vectors and batches: Jacobians as pictures, what they would cost, shapes, the two-layer model."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch, Rectangle

from mcdenoise.nn import MLP, Linear, ReLU, Sigmoid
from mcdenoise.study.charts import COLOURS

BLUE, RED, GREEN, PURPLE = COLOURS[:4]
ROW = 65_536  # pixels of a 256 x 256 image: the rows of a batch
WIDTHS = (36, 10, 6)  # of the network of chapter 09


def example_layers() -> tuple[MLP, np.ndarray]:
    """A network 6 -> 8 -> 3 and one row."""
    rng = np.random.default_rng(3)
    return MLP.random([6, 8, 3], hidden=ReLU(), rng=rng), rng.standard_normal(6)


def jacobians() -> tuple[Figure, dict]:
    """The Jacobians of a Linear, a Sigmoid and a ReLU layer at one row, and that of all layers of a network together."""
    network, x = example_layers()
    first, _, last = network.layers
    a = first.forward(x[np.newaxis])[0][0]
    shown = {
        "Linear 6 → 8: the weight": first.jacobian(x),
        "Sigmoid: s (1 − s) on\nthe diagonal": Sigmoid().jacobian(a),
        "ReLU: 1 where x > 0": ReLU().jacobian(a),
        "Linear 8 → 3": last.jacobian(np.maximum(a, 0)),
        "Linear, ReLU, Linear:\nthe product": last.weight @ ReLU().jacobian(a) @ first.weight,
    }
    figure = Figure(figsize=(9.4, 2.9), layout="constrained")
    for axes, (title, matrix) in zip(figure.subplots(1, 5, width_ratios=(6, 8, 8, 8, 6)), shown.items(), strict=True):
        image = axes.imshow(matrix, cmap="RdBu_r", vmin=-1, vmax=1)
        axes.set(xlabel="input", xticks=range(matrix.shape[1]), yticks=range(matrix.shape[0]))
        axes.tick_params(labelsize=7)
        axes.set_title(title, fontsize=9)
    figure.axes[0].set_ylabel("output")
    figure.colorbar(image, ax=figure.axes, label="derivative", shrink=0.8)
    d_y = np.array([[1.0, -2.0, 0.5]])
    by_pass = network.backward(d_y, network.forward(x[np.newaxis])[1])[0]
    by_matrix = d_y @ list(shown.values())[-1]
    sigmoid = shown["Sigmoid: s (1 − s) on\nthe diagonal"]
    return figure, {
        "largest_slope": sigmoid.max(),
        "off_diagonal": np.abs(sigmoid - np.diag(np.diag(sigmoid))).max(),
        "live": int(np.trace(shown["ReLU: 1 where x > 0"])),
        "same": bool(np.abs(by_pass - by_matrix).max() < 1e-12),
        "linear_is_weight": bool(np.array_equal(shown["Linear 6 → 8: the weight"], first.weight)),
    }


def numbers_needed(rows: int, widths: tuple[int, ...]) -> dict[str, list[float]]:
    """How many numbers stand in Jacobians, and in what our backward pass saves, layer by layer.

    Layers are Linear, Sigmoid, Linear. `whole`: dy/dx of the batch, rows d_out by rows d_in; `blocks`: one Jacobian a
    row; `saved`: what `forward` keeps.

    Examples
    --------
    >>> numbers_needed(2, (3, 2, 1))["blocks"]
    [12, 8, 4]
    """
    d_in, hidden, d_out = widths
    pairs = [(d_in, hidden), (hidden, hidden), (hidden, d_out)]
    network = MLP.random(widths, rng=np.random.default_rng(0))
    saved = network.forward(np.zeros((rows, d_in)))[1]
    return {
        "whole": [rows * a * rows * b for a, b in pairs],
        "blocks": [rows * a * b for a, b in pairs],
        "saved": [one.size for one in saved],
    }


def never_built() -> tuple[Figure, dict]:
    """Numbers in the Jacobians of a batch, against those that a backward pass needs."""
    found = numbers_needed(ROW, WIDTHS)
    figure = Figure(figsize=(8.4, 3.2), layout="constrained")
    axes = figure.subplots()
    kinds = {
        "whole": ("Jacobian of the batch", PURPLE),
        "blocks": ("one Jacobian for each row", RED),
        "saved": ("what forward saves", GREEN),
    }
    places = np.arange(3)
    for shift, (kind, (label, colour)) in zip((-0.27, 0, 0.27), kinds.items(), strict=True):
        bars = axes.bar(places + shift, found[kind], 0.25, color=colour, label=label)
        axes.bar_label(bars, [f"{value:.1e}".replace("e+", "e") for value in found[kind]], fontsize=8)
    axes.set(yscale="log", ylabel="numbers", ylim=(1e5, 1e14), title=f"36 → 10 → 6, a batch of {ROW} rows")
    axes.set_xticks(places, ["Linear 36 → 10", "Sigmoid", "Linear 10 → 6"])
    axes.legend(frameon=False, ncols=3, fontsize=9)
    total = {kind: sum(values) for kind, values in found.items()}
    products = 3 * ROW * (WIDTHS[0] * WIDTHS[1] + WIDTHS[1] * WIDTHS[2]) - ROW * WIDTHS[0] * WIDTHS[1]
    return figure, {
        "whole_terabytes": total["whole"] * 8 / 1e12,
        "blocks_megabytes": total["blocks"] * 8 / 1e6,
        "saved_megabytes": total["saved"] * 8 / 1e6,
        "blocks_over_saved": total["blocks"] / total["saved"],
        "sigmoid_zeros": 1 - 1 / WIDTHS[1],
        "multiplications_forward_backward": products,
    }


def batch_shapes() -> tuple[Figure, dict]:
    """The three products of a fully connected layer's backward pass, as rectangles."""
    n, d_in, d_out = 12, 6, 4
    layer = Linear(np.ones((d_out, d_in)), np.ones(d_out))
    d_x, gradients = layer.backward(np.ones((n, d_out)), layer.forward(np.ones((n, d_in)))[1])
    figure = Figure(figsize=(9.4, 4.2), layout="constrained")
    rows = (
        ("forward", ("y", n, d_out), "=", ("x", n, d_in), "·", ("Wᵀ", d_in, d_out), "+", ("b", 1, d_out)),
        ("gradient of the weight", ("d_W", d_out, d_in), "=", ("d_yᵀ", d_out, n), "·", ("x", n, d_in)),
        ("gradient of the bias", ("d_b", 1, d_out), "=", ("1ᵀ", 1, n), "·", ("d_y", n, d_out)),
        ("gradient of the input", ("d_x", n, d_in), "=", ("d_y", n, d_out), "·", ("W", d_out, d_in)),
    )
    for axes, (title, *parts) in zip(figure.subplots(2, 2).flat, rows, strict=True):
        _rectangles(axes, parts)
        axes.set_title(title, fontsize=10)
    shapes = {"d_x": d_x.shape, **{f"d_{name}": one.shape for name, one in gradients.items()}}
    return figure, {name: list(shape) for name, shape in shapes.items()}


def _rectangles(axes: Axes, parts: list) -> None:
    """Matrices to scale in one line, with signs between them; gradients are purple."""
    right, names = 0.0, {12: "n", 6: "d_in", 4: "d_out", 1: "1"}
    for part in parts:
        if isinstance(part, str):
            axes.text(right + 1.0, 0, part, ha="center", va="center", fontsize=14)
            right += 1.5
            continue
        name, height, width = part
        right += 3.6
        colour = PURPLE if name.startswith("d_") else BLUE
        axes.add_patch(Rectangle((right, -height / 2), width, height, facecolor=colour, alpha=0.25, edgecolor=colour))
        axes.text(right + width / 2, 0, name, ha="center", va="center", fontsize=10 if height > 1 else 9)
        axes.text(right + width / 2, height / 2 + 0.3, names[width], ha="center", va="bottom", fontsize=8)
        axes.text(right - 0.2, 0, names[height], ha="right", va="center", fontsize=8)
        right += width
    axes.set(xlim=(1, 42), ylim=(-6.5, 8), aspect="equal")
    axes.axis("off")


def two_layer() -> tuple[Figure, dict]:
    """The two-layer model as a graph of whole batches: values go right, gradients come back."""
    figure = Figure(figsize=(9.4, 3.3), layout="constrained")
    axes = figure.subplots()
    boxes = {1.9: "Linear\nW¹, b¹", 4.1: "Sigmoid", 6.3: "Linear\nW², b²", 8.5: "loss E"}
    for x, text in boxes.items():
        axes.add_patch(
            FancyBboxPatch((x - 0.55, -0.4), 1.1, 0.8, "round,pad=0.05", facecolor="white", edgecolor="#222222")
        )
        axes.text(x, 0, text, ha="center", va="center", fontsize=10)
    edges = {0.35: ("x", "n, 36"), 2.55: ("a", "n, 10"), 4.75: ("h", "n, 10"), 6.95: ("y", "n, 6"), 9.15: ("E", "1")}
    for x, (name, shape) in edges.items():
        _arrow(axes, (x, 0.14), (x + 0.9, 0.14), GREEN)
        axes.text(x + 0.45, 0.24, f"{name}\n({shape})", ha="center", va="bottom", fontsize=9, color=GREEN)
        if x > 1:
            _arrow(axes, (x + 0.9, -0.14), (x, -0.14), PURPLE)
            axes.text(x + 0.45, -0.28, f"d_{name}" if x < 9 else "1", ha="center", va="top", fontsize=9, color=PURPLE)
    for x, name in ((1.9, "1"), (6.3, "2")):
        _arrow(axes, (x, -0.48), (x, -1.05), PURPLE)
        axes.text(
            x,
            -1.12,
            f"d_W{'¹²'[int(name) - 1]}, d_b{'¹²'[int(name) - 1]}",
            ha="center",
            va="top",
            fontsize=9,
            color=PURPLE,
        )
    _arrow(axes, (8.5, 1.15), (8.5, 0.48), GREEN)
    axes.text(8.5, 1.2, "reference", ha="center", va="bottom", fontsize=9, color=GREEN)
    for x, text in ((1.9, "saves x"), (4.1, "saves h"), (6.3, "saves h"), (8.5, "saves y − target")):
        axes.text(
            x, 0.55 if x < 8 else -0.55, text, ha="center", va="bottom" if x < 8 else "top", fontsize=8, color="#555555"
        )
    axes.set(xlim=(0.2, 10.2), ylim=(-1.45, 1.5))
    axes.axis("off")
    network = MLP.random(WIDTHS, rng=np.random.default_rng(0))
    return figure, {"parameters": network.size, "weights": sum(a * b for a, b in ((36, 10), (10, 6)))}


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], colour: str) -> None:
    """A straight arrow."""
    axes.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=10, color=colour, shrinkA=0, shrinkB=0))
