"""How the charts of the study look: a style a method, logarithmic axes with plain numbers, labels that do not touch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from mcdenoise.study.charts import COLOURS, MANY_DECADES, MARKERS
from mcdenoise.study.methods import METHODS

PEER_GREYS = ("#333333", "#555555", "#777777", "#999999")
PEER_MARKERS = ("o", "s", "^", "D", "v", "P")
ERROR = "relMSE (lower is better)"


@dataclass(frozen=True)
class Style:
    """How a method is drawn: ours full and in colour, peers open and grey."""

    colour: str
    marker: str
    peer: bool = False

    def line(self, **more: Any) -> dict[str, Any]:
        """Arguments of `plot`."""
        face = "white" if self.peer else self.colour
        return {"color": self.colour, "marker": self.marker, "markerfacecolor": face, "linewidth": 1.2, **more}


def styles(found: Mapping[str, Any]) -> dict[str, Style]:
    """Return label of a method -> its style: ours as in all figures, peers in the order in which the study met them."""
    ours = {
        method.label: Style(colour, marker)
        for method, colour, marker in zip(METHODS.values(), cycle(COLOURS), cycle(MARKERS), strict=False)
    }
    rows = [row for entry in found["entries"].values() for row in entry.get("rows", ()) if row["peer"]]
    peers = zip(dict.fromkeys(row["label"] for row in rows), cycle(PEER_GREYS), cycle(PEER_MARKERS), strict=False)
    return ours | {label: Style(colour, marker, peer=True) for label, colour, marker in peers}


def log_axes(axes: Axes, *, x: Sequence[float] | None = None) -> None:
    """Both axes logarithmic, plain numbers, thin grid; `x`: write these values alone along x."""
    axes.set(xscale="log", yscale="log")
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < MANY_DECADES * low else (1,)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    if x is not None:
        axes.set_xticks(x, [f"{value:g}" for value in x])
        axes.set_xticks([], minor=True)
    axes.grid(visible=True, color="#e5e5e5", linewidth=0.6)
    axes.set_axisbelow(True)


def plain_log(axes: Axes) -> None:
    """A logarithmic axis along x with plain numbers, and room at both ends."""
    axes.set_xscale("log")
    low, high = axes.get_xlim()
    axes.set_xlim(low / 1.1, high * 1.1)
    axes.xaxis.set_major_locator(
        LogLocator(subs=(1, 2, 5) if high < 30 * low else (1, 3) if high < 1e3 * low else (1,))
    )
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def heading(found: Mapping[str, Any]) -> str:
    """Return the line that says what was measured."""
    settings = found["settings"]
    return f"{settings['size']} x {settings['size']} pixels, {settings['seeds']} seeds, {found['cores']} cores"


def spread(values: np.ndarray, gap: float) -> np.ndarray:
    """Move values apart until neighbours are `gap` apart, each as little as that takes, in their order.

    Examples
    --------
    >>> spread(np.array([0.0, 0.1, 5.0]), 1.0).round(2)
    array([-0.45,  0.55,  5.  ])
    """
    order = np.argsort(values, kind="stable")
    groups: list[list[float]] = []  # sum of (value - its place in the group), count
    for value in values[order]:
        groups.append([float(value), 1])
        while len(groups) > 1 and groups[-1][0] / groups[-1][1] < groups[-2][0] / groups[-2][1] + gap * groups[-2][1]:
            total, count = groups.pop()
            groups[-1] = [groups[-1][0] + total - gap * groups[-1][1] * count, groups[-1][1] + count]
    moved = np.concatenate([total / count + gap * np.arange(count) for total, count in groups])
    result = np.empty_like(moved)
    result[order] = moved
    return result
