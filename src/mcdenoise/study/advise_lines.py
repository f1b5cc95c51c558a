"""Advice in words: what `mcdenoise advise` prints."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence

from mcdenoise.samples import load_samples
from mcdenoise.samples.storage import write_beside
from mcdenoise.study.advise import ASKS, Advice, Drop, advise
from mcdenoise.study.entries import json_ready
from mcdenoise.study.methods import METHODS

SURE, FAIRLY_SURE = 0.9, 0.7  # shares of resamplings
FEW_TILES = 32  # of which resamplings say little


def run_advise(options: argparse.Namespace) -> int:
    """Run `mcdenoise advise`: print the advice; write its numbers if a file is named."""
    if options.json and options.json.suffix != ".json":
        raise ValueError(f"The numbers need a name that ends in .json, got {options.json.name!r}.")
    if options.json and not options.json.parent.is_dir():
        raise ValueError(
            f"The folder {options.json.parent} must exist before {options.json.name} is written. Create it."
        )
    advice = advise(load_samples(options.samples), seed=options.seed)
    print("\n".join(advice_lines(advice)))
    if options.json:
        with write_beside(options.json) as temporary:
            temporary.write_text(json.dumps(json_ready(advice.numbers()), indent=1) + "\n", encoding="utf-8")
    return 0


def advice_lines(advice: Advice) -> list[str]:
    """Return the advice as a table for the terminal, the recommendation last."""
    head = (
        f"{advice.height} x {advice.width} pixels, {advice.spp} spp. No reference: errors are estimates of relMSE from samples "
        "that the filter did not see."
    )
    return [head, "", *_names_lines(advice), *_methods_lines(advice), *_boxes_lines(advice), *recommendation(advice)]


def recommendation(advice: Advice) -> list[str]:
    """Return what to take, in a few sentences.

    Each line stands for itself: what to capture, which filter, how sure.
    """
    layout = advice.layout
    found = []
    for kind, drops in (("random_params", advice.random_params), ("features", advice.features)):
        dropped = [one.name for one in drops if not one.keep]
        keep, drop = ", ".join(layout[kind]) or "none", ", ".join(dropped) or "nothing"
        found.append(f"{kind.replace('_params', ' parameters').capitalize()}: keep {keep}; drop {drop}.")
    chosen, best = advice.method, advice.methods[advice.choice.best].name
    reason = (
        "the best" if chosen == best else f"as good as {METHODS[best].label}, the best, as far as these samples tell"
    )
    found.append(
        f"Filter: {METHODS[chosen].label} (chapter {METHODS[chosen].chapter:02}); asks for {ASKS[chosen]}; {reason}."
    )
    if chosen != "rpf" and advice.random_params:
        found.append(f"{METHODS[chosen].label} reads no random parameters: they need not be captured for it.")
    if advice.box_choice:
        found.append(f"RPF, if you use it: boxes {advice.boxes[advice.box_choice.chosen].name}.")
    tiles = len(advice.methods[0].tiles)
    sure, fairly = tiles >= FEW_TILES and advice.sure >= SURE, advice.sure >= FAIRLY_SURE
    word = "sure" if sure else "fairly sure" if fairly else "not sure"
    share = f"{100 * advice.sure:.0f} % of the resamplings of the image's {tiles} tiles"
    found.append(f"How sure: {share} choose that filter: {word}.")
    if not sure:
        found.append("More samples per pixel, or a larger crop, would tell.")
    return found


def _names_lines(advice: Advice) -> list[str]:
    """What each random parameter and feature says, costs and saves."""
    informations = {one.name: one for one in advice.informations}
    lines = []
    filters = (
        ("random_params", "RPF"),
        ("features", METHODS[advice.feature_filter].label if advice.feature_filter else ""),
    )
    for kind, filter_ in filters:
        drops: Sequence[Drop] = getattr(advice, kind)
        if not drops:
            continue
        lines.append(
            f"{kind.replace('_params', ' parameters')}: what they say about radiance, and {filter_} without each"
        )
        lines.append(f"  {'':18} {'nats beyond chance':>18} {'p':>6} {'relMSE':>10} {'+-':>8} {'seconds':>8}")
        for one in drops:
            about = informations[one.name]
            lines.append(
                f"  {one.name:18} {about.nats:18.4f} {about.p_value:6.3f} {one.behind:+10.5f} {one.standard_error:8.5f} "
                f"{-one.seconds:+8.3f}  {'keep' if one.keep else 'drop'}"
            )
        lines.append("")
    return lines


def _methods_lines(advice: Advice) -> list[str]:
    """All methods, the simplest first."""
    lines = [
        "filters, the one that asks for least first",
        f"  {'':28} {'seconds':>8} {'relMSE':>9} {'behind':>9} {'+-':>8}",
    ]
    choice = advice.choice
    for k, one in enumerate(advice.methods):
        marks = [
            words
            for words, holds in (
                ("front", choice.on_front[k]),
                ("best", k == choice.best),
                ("chosen", k == choice.chosen),
            )
            if holds
        ]
        lines.append(
            f"  {METHODS[one.name].label:28} {one.seconds:8.3f} {advice.error(one):9.5f} {choice.behind[k]:9.5f} "
            f"{choice.standard_error[k]:8.5f}  {', '.join(marks)}".rstrip()
        )
    return [*lines, ""]


def _boxes_lines(advice: Advice) -> list[str]:
    """The boxes of RPF."""
    if advice.box_choice is None:
        return []
    lines = ["boxes of RPF, the cheapest first"]
    for k, one in enumerate(advice.boxes):
        mark = "  chosen" if k == advice.box_choice.chosen else ""
        lines.append(f"  {one.name:28} {one.seconds:8.3f} {advice.box_error(one):9.5f}{mark}")
    return [*lines, ""]
