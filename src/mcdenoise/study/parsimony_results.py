"""What the study of parsimony found, in tables and charts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from mcdenoise.study.charts import COLOURS, GREY
from mcdenoise.study.information import SIGNIFICANT
from mcdenoise.study.methods import METHODS

Found = dict[str, Any]
KEPT, DROPPED = COLOURS[0], COLOURS[1]
LEAST_NATS = 1e-4  # left end of the axis: less is drawn as an arrow


def lines(found: Found) -> list[str]:
    """Tables: advice beside the reference's choice, layouts, their error between seeds, boxes of RPF.

    Examples
    --------
    >>> lines({"entries": {}})
    ['no entry is done yet']
    """
    entries = list(found["entries"].values())
    if not entries:
        return ["no entry is done yet"]
    return [
        *agreement_lines(entries),
        "",
        *layout_lines(entries),
        "",
        *between_lines(entries),
        "",
        *boxes_lines(entries),
    ]


def agreement_lines(entries: Sequence[Found]) -> list[str]:
    """Method that samples advise, and that a reference would choose by the same rule."""
    rows = [
        "method that samples advise, with relMSE; what the same rule chooses with a reference, with relMSE; how sure"
    ]
    for one in entries:
        advised, chosen = one["advice"]["method"], one["reference"]["method"]
        with_it = next(method["error"] for method in one["reference"]["methods"] if method["name"] == chosen)
        other = "the same" if advised == chosen else METHODS[chosen].label
        rows.append(
            f"  {one['scene']:12} {one['spp']:3} spp  {METHODS[advised].label:28} {one['relmse'][advised]:8.5f}  "
            f"{other:28} {with_it:8.5f}  {100 * one['advice']['sure']:3.0f} %"
        )
    same = sum(one["agree"] for one in entries)
    rows.append(f"  the same in {same} of {len(entries)} cases" + (": target 8 of 10" if len(entries) == 10 else ""))
    cost = [one["relmse"][one["advice"]["method"]] / min(one["relmse"].values()) for one in entries]
    rows.append(
        f"  relMSE of what is advised over that of the best method: {np.mean(cost):.2f} on average, {max(cost):.2f} at most"
    )
    return rows


def layout_lines(entries: Sequence[Found]) -> list[str]:
    """What each scene keeps and drops, what other seeds say, and the decoys."""
    rows = ["layout: what is kept (dropped in brackets); seeds that say the same"]
    for one in entries:
        for kind in ("random_params", "features"):
            kept = one["advice"]["layout"][kind]
            dropped = [drop["name"] for drop in one["advice"][kind] if not drop["keep"]]
            same = sum(sorted(other[kind]) == sorted(kept) for other in one["other_seeds"])
            words = ", ".join(kept) + (f" ({', '.join(dropped)})" if dropped else "")
            rows.append(
                f"  {one['scene']:12} {one['spp']:3} spp  {words or 'none'}; {same} of {len(one['other_seeds'])}"
            )
    p_values = [decoy["p_value"] for one in entries for decoy in one["decoys"].values()]
    taken = sum(p < SIGNIFICANT for p in p_values)
    rows.append(
        f"  decoys taken for information: {taken} of {len(p_values)}; smallest p {min(p_values, default=1.0):.3f}"
    )
    return rows


def between_lines(entries: Sequence[Found]) -> list[str]:
    """Error of the layouts, judged by samples of other seeds."""
    rows = ["features between seeds: estimated relMSE with all; more with those kept; more with none"]
    for one in entries:
        if between := one["between_seeds"]:
            more = "; ".join(
                f"{between[name]['behind']:+.5f} +- {between[name]['standard_error']:.5f}" for name in ("kept", "none")
            )
            label = METHODS[between["filter"]].label
            rows.append(f"  {one['scene']:12} {one['spp']:3} spp  {label:28} {between['all']['error']:.5f}; {more}")
    return rows


def boxes_lines(entries: Sequence[Found]) -> list[str]:
    """Boxes of RPF: error and seconds of each, and which is taken."""
    rows = ["boxes of RPF: estimated relMSE (seconds), the one to take marked"]
    for one in entries:
        words = []
        for box in one["advice"]["rpf_boxes"]:
            mark = " *" if box["boxes"] == one["advice"]["rpf_choice"] else ""
            words.append(f"{box['boxes']}{mark}: {box['error']:.4f} ({box['seconds']:.2f})")
        rows.append(f"  {one['scene']:12} {one['spp']:3} spp  {'; '.join(words)}")
    return rows


def charts(found: Found) -> dict[str, Figure]:
    """Information, cost of dropping, and methods, one small chart a scene each, at the smallest spp of the study."""
    entries = list(found["entries"].values())
    if not entries:
        return {}
    least = min(one["spp"] for one in entries)
    some = [one for one in entries if one["spp"] == least]
    return {
        "information": information_figure(some),
        "dropping": dropping_figure(some),
        "simplest": simplest_figure(some),
        "boxes": boxes_figure(entries),
    }


def _row(some: Sequence[Found], title: str, height: float) -> tuple[Figure, Sequence[Axes]]:
    """A figure with a chart a scene, side by side."""
    figure = Figure(figsize=(12.5, height), layout="constrained")
    figure.suptitle(f"{title}, {some[0]['spp']} spp")
    row = figure.subplots(1, len(some), squeeze=False)[0]
    for axes, one in zip(row, some, strict=True):
        axes.set_title(one["scene"])
        axes.grid(axis="x", color="#e5e5e5")
        axes.set_axisbelow(True)
    return figure, row


def information_figure(some: Sequence[Found]) -> Figure:
    """How much each random parameter, feature and decoy says about radiance."""
    figure, row = _row(some, "Mutual information with radiance beyond chance (nats, three channels together)", 3.9)
    for axes, one in zip(row, some, strict=True):
        told = {about["name"]: about for about in one["advice"]["informations"]}
        told |= {f"{name} (decoy)": about for name, about in one["decoys"].items()}
        names = list(told)[::-1]
        for place, name in enumerate(names):
            nats, beyond = told[name]["nats"], told[name]["p_value"] < SIGNIFICANT
            colour, shown = KEPT if beyond else DROPPED, max(nats, LEAST_NATS)
            axes.plot([LEAST_NATS, shown], [place, place], color=colour, linewidth=5, solid_capstyle="butt")
            axes.plot(shown, place, "o" if nats > LEAST_NATS else "<", color=colour, markersize=6, clip_on=False)
        axes.set_yticks(range(len(names)), [name.replace("_", " ") for name in names], fontsize=8)
        axes.set(xscale="log", xlim=(LEAST_NATS, 10), xlabel="nats")
    _legend(figure, "beyond chance (p < 0.05)", "not beyond chance")
    return figure


def dropping_figure(some: Sequence[Found]) -> Figure:
    """What the error does without each random parameter (RPF) and each feature (a feature filter)."""
    figure, row = _row(some, "Leaving one out: change of the estimated relMSE, one standard error", 3.9)
    for axes, one in zip(row, some, strict=True):
        drops = [*one["advice"]["random_params"], *one["advice"]["features"]][::-1]
        for k, drop in enumerate(drops):
            colour = KEPT if drop["keep"] else DROPPED
            axes.errorbar(1e3 * drop["behind"], k, xerr=1e3 * drop["standard_error"], fmt="o", color=colour, capsize=3)
        axes.axvline(0, color=GREY, linewidth=1)
        axes.axhline(len(one["advice"]["features"]) - 0.5, color=GREY, linewidth=0.6, linestyle=":")
        axes.set_yticks(range(len(drops)), [drop["name"].replace("_", " ") for drop in drops], fontsize=8)
        label = METHODS[one["advice"]["feature_filter"]].label
        axes.set_xscale("symlog", linthresh=0.1)
        axes.margins(x=0.1)
        axes.xaxis.set_major_formatter("{x:g}")
        axes.set_xlabel(f"relMSE x 1000\nabove: RPF\nbelow: {label}", fontsize=8)
    _legend(figure, "kept", "dropped")
    return figure


def simplest_figure(some: Sequence[Found]) -> Figure:
    """How far each method is behind the best: estimated from the samples, and by the reference."""
    figure, row = _row(some, "How far behind the best, one standard error; the simplest method on top", 4.4)
    for axes, one in zip(row, some, strict=True):
        sources = ((one["advice"], COLOURS[0], "o", 0.15), (one["reference"], COLOURS[1], "s", -0.15))
        names = [method["name"] for method in one["advice"]["methods"]][::-1]
        for source, colour, marker, shift in sources:
            for method in source["methods"]:
                place = names.index(method["name"]) + shift
                fill = colour if method["name"] == source["method"] else "white"
                axes.errorbar(
                    1e3 * method["behind"],
                    place,
                    xerr=1e3 * method["standard_error"],
                    fmt=marker,
                    color=colour,
                    markerfacecolor=fill,
                    capsize=2,
                )
        axes.axvline(0, color=GREY, linewidth=1)
        labels = [METHODS[name].label for name in names] if axes is row[0] else [""] * len(names)
        axes.set_yticks(range(len(names)), labels, fontsize=8)
        axes.set(xlabel="relMSE x 1000", xlim=(-0.1 * axes.get_xlim()[1], None))
    for colour, marker, words in ((COLOURS[0], "o", "from the samples"), (COLOURS[1], "s", "by the reference")):
        row[-1].plot([], [], marker, color=colour, label=words)
    row[-1].plot([], [], "o", color=GREY, label="filled: chosen")
    row[-1].legend(frameon=False, fontsize=8, loc="lower right")
    return figure


def boxes_figure(entries: Sequence[Found]) -> Figure:
    """Error of RPF with more and larger boxes, over that with the smallest, beside its seconds."""
    figure = Figure(figsize=(10, 4), layout="constrained")
    figure.suptitle("Boxes of RPF: what larger boxes and more passes gain (filled: advised)")
    spps = sorted({one["spp"] for one in entries})
    axes_of = dict(zip(spps, figure.subplots(1, len(spps), squeeze=False)[0], strict=True))
    scenes = list(dict.fromkeys(one["scene"] for one in entries))
    for one in entries:
        colour, axes = COLOURS[scenes.index(one["scene"])], axes_of[one["spp"]]
        boxes = one["advice"]["rpf_boxes"]
        errors = np.array([box["error"] for box in boxes]) / boxes[0]["error"]
        seconds = [box["seconds"] for box in boxes]
        axes.plot(seconds, errors, "-o", color=colour, markerfacecolor="white", label=one["scene"])
        for box, x, y in zip(boxes, seconds, errors, strict=True):
            if box["boxes"] == one["advice"]["rpf_choice"]:
                axes.plot(x, y, "o", color=colour)
    for spp, axes in axes_of.items():
        axes.set(title=f"{spp} spp", xlabel="seconds", ylabel="relMSE over that of one box of 3", xscale="log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.grid(color="#e5e5e5")
        axes.legend(frameon=False, fontsize=8)
    return figure


def _legend(figure: Figure, kept: str, dropped: str) -> None:
    """What the two colours mean, below the charts."""
    handles = [Line2D([], [], marker="s", linestyle="", color=colour) for colour in (KEPT, DROPPED)]
    figure.legend(handles, (kept, dropped), loc="outside lower center", ncols=2, frameon=False, fontsize=9)
