"""Chapter 10, no more than a scene needs: the study's charts, its tables, and the printed advice."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.study.advise import ASKS, Advice, Drop, Trial
from mcdenoise.study.advise_lines import advice_lines
from mcdenoise.study.choice import Choice, tile_means
from mcdenoise.study.figures._ch10_data import (
    THOUSAND,
    study,
    table,
    words,
)
from mcdenoise.study.information import SIGNIFICANT, Information
from mcdenoise.study.methods import METHODS
from mcdenoise.study.parsimony import charts

PRINTED = "soft_shadow"  # the scene whose advice is printed
ORDER = ("random_params", "features")


def entries() -> list[dict[str, Any]]:
    """All cases of the stored study."""
    return list(study("parsimony")["entries"].values())


def chart(name: str) -> Figure:
    """One of the study's charts."""
    return all_charts()[name]


@cache
def all_charts() -> dict[str, Figure]:
    """The study's charts."""
    return charts(study("parsimony"))


def case_of(one: dict[str, Any]) -> str:
    """A case in words.

    Examples
    --------
    >>> case_of({"scene": "dof", "spp": 8})
    '`dof`, 8 spp'
    """
    return f"`{one['scene']}`, {one['spp']} spp"


def chart_information() -> tuple[Figure, dict]:
    """What carries information, and what the decoys say."""
    found, settings = entries(), study("parsimony")["settings"]
    least = min(settings["spp"])
    p_values = [decoy["p_value"] for one in found for decoy in one["decoys"].values()]
    rows = []
    numbers: dict[str, Any] = {
        "spp": settings["spp"],
        "least": least,
        "seeds": len(settings["seeds"]),
        "significant": SIGNIFICANT,
        "decoys": len(p_values),
        "decoys_taken": sum(p < SIGNIFICANT for p in p_values),
        "decoys_smallest_p": min(p_values),
    }
    for one in found:
        if one["spp"] == least:
            told = {about["name"]: about for about in one["advice"]["informations"]}
            numbers[one["scene"]] = {
                **{name: {"nats": about["nats"], "p": about["p_value"]} for name, about in told.items()},
                "random_params": words(
                    n for n, a in told.items() if a["kind"] == "random_params" and a["p_value"] < SIGNIFICANT
                ),
                "nothing": words((n for n, a in told.items() if a["p_value"] >= SIGNIFICANT), "nothing"),
            }
            by_kind = [
                [n for n, a in told.items() if a["kind"] == kind and a["p_value"] < SIGNIFICANT] for kind in ORDER
            ]
            rest = [name for name, about in told.items() if about["p_value"] >= SIGNIFICANT]
            rows.append((f"`{one['scene']}`", *(names(given) for given in (*by_kind, rest, one["decoys"]))))
    head = ("scene", "random parameters beyond chance", "features beyond chance", "not beyond chance", "decoys")
    return chart("information"), numbers | {"table": table(head, rows)}


def chart_dropping() -> tuple[Figure, dict]:
    """What dropping costs: layouts of every case, whether other seeds agree, and what the kept features cost between seeds."""
    rows, costs = [], []
    count = {kind: [0, 0] for kind in ORDER}
    for one in entries():
        cells = [case_of(one)]
        for kind in ORDER:
            kept = one["advice"]["layout"][kind]
            dropped = [drop["name"] for drop in one["advice"][kind] if not drop["keep"]]
            same = sum(sorted(other[kind]) == sorted(kept) for other in one["other_seeds"])
            count[kind][0] += same
            count[kind][1] += len(one["other_seeds"])
            cells += [names(kept), names(dropped), f"{same} of {len(one['other_seeds'])}"]
        rows.append(cells)
        if between := one["between_seeds"]:
            costs.append(_between_row(one, between))
    head = ("case", "random parameters kept", "dropped", "seeds", "features kept", "dropped", "seeds")
    beside = ("case", "filter", "relMSE x 1000, all features", "those kept", "none")
    numbers = {
        "table": table(head, rows),
        "between": table(beside, costs),
        "filters": words(dict.fromkeys(METHODS[one["advice"]["feature_filter"]].label for one in entries())),
        "seeds_agree": {kind: {"same": same, "of": of} for kind, (same, of) in count.items()},
    }
    return chart("dropping"), numbers | _costs()


def names(given: Sequence[str]) -> str:
    """Names as code in a cell.

    Examples
    --------
    >>> names(["lens_u", "time"]), names([])
    ('`lens_u` `time`', 'none')
    """
    return " ".join(f"`{name}`" for name in given) or "none"


def _between_row(one: dict[str, Any], between: dict[str, Any]) -> tuple[str, ...]:
    """Error with all features, and what fewer of them change, judged by samples of other seeds."""
    changed = (
        f"{THOUSAND * between[name]['behind']:+.2f} ± {THOUSAND * between[name]['standard_error']:.2f}"
        for name in ("kept", "none")
    )
    label = METHODS[between["filter"]].label
    return (case_of(one), label, f"{THOUSAND * between['all']['error']:.2f}", *changed)


def _costs() -> dict[str, Any]:
    """In how many cases the features kept do no worse than all, by one standard error, and no features do worse."""
    compared = [between for one in entries() if (between := one["between_seeds"])]
    fine = sum(between["kept"]["behind"] <= between["kept"]["standard_error"] for between in compared)
    needed = sum(between["none"]["behind"] > between["none"]["standard_error"] for between in compared)
    return {"compared": len(compared), "kept_no_worse": fine, "none_worse": needed}


def chart_simplest() -> tuple[Figure, dict]:
    """The simplest method like the best: by the samples, and by the reference; and what `mcdenoise advise` prints."""
    rows, found = [], entries()
    for one in found:
        advised, chosen = one["advice"]["method"], one["reference"]["method"]
        with_it = next(method["error"] for method in one["reference"]["methods"] if method["name"] == chosen)
        other = "the same" if advised == chosen else METHODS[chosen].label
        rows.append(
            (case_of(one), METHODS[advised].label, f"{THOUSAND * one['relmse'][advised]:.2f}", other,
             f"{THOUSAND * with_it:.2f}", f"{100 * one['advice']['sure']:.0f} %")
        )  # fmt: skip
    costs = [one["relmse"][one["advice"]["method"]] / min(one["relmse"].values()) for one in found]
    apart = [case_of(one) for one in found if not one["agree"]]
    head = ("case", "advised by samples", "relMSE x 1000", "by the reference", "relMSE x 1000", "sure")
    advised = dict.fromkeys(one["advice"]["method"] for one in found)
    on_front = {name: sum(name in one["advice"]["on_front"] for one in found) for name in ASKS}
    numbers = {
        "cases": len(found),
        "agree": sum(one["agree"] for one in found),
        "apart": "; ".join(apart) or "none",
        "mean_cost": float(np.mean(costs)),
        "largest_cost": max(costs),
        "advised": words(METHODS[name].label for name in ASKS if name in advised),
        "on_front": on_front,
        "never_on_front": words(METHODS[name].label for name, times in on_front.items() if not times),
        "table": table(head, rows),
        "printed": printed(),
    }
    return chart("simplest"), numbers


def chart_boxes() -> tuple[Figure, dict]:
    """Boxes of RPF: what is advised where."""
    found = [one for one in entries() if one["advice"]["rpf_boxes"]]
    rows = []
    for one in found:
        boxes = one["advice"]["rpf_boxes"]
        cells = (f"{THOUSAND * box['error']:.2f} ({box['seconds']:.2f} s)" for box in boxes)
        rows.append((case_of(one), *cells, one["advice"]["rpf_choice"]))
    head = ("case", *(f"boxes {box['boxes']}" for box in found[0]["advice"]["rpf_boxes"]), "enough")
    advised = [one["advice"]["rpf_choice"] for one in found]
    numbers = {
        "cases": len(found),
        "times": {name.replace(" ", "_"): advised.count(name) for name in dict.fromkeys(advised)},
    }
    return chart("boxes"), numbers | {"table": table(head, rows)}


def advice_of(numbers: dict[str, Any]) -> Advice:
    """The advice that stored numbers tell of, so that it can be printed: errors of tiles are replaced by their mean."""
    tiles = np.ones((1, tile_means(np.zeros((numbers["height"], numbers["width"]))).size))
    trials = {
        kind: tuple(
            Trial(one[label], (one["error"] + numbers["noise"]) * tiles, one["seconds"], {}) for one in numbers[kind]
        )
        for kind, label in (("methods", "name"), ("rpf_boxes", "boxes"))
    }
    order = [one.name for one in trials["methods"]]
    behind, spread = ([one[key] for one in numbers["methods"]] for key in ("behind", "standard_error"))
    on_front = np.array([name in numbers["on_front"] for name in order])
    choice = Choice(
        order.index(numbers["method"]), order.index(numbers["best"]), np.array(behind), np.array(spread), on_front
    )
    boxes = [one.name for one in trials["rpf_boxes"]]
    same = {name: numbers[name] for name in ("height", "width", "spp", "noise", "feature_filter", "sure")}
    nothing = np.zeros(len(boxes))
    return Advice(
        **same,
        informations=tuple(Information(**one) for one in numbers["informations"]),
        random_params=tuple(Drop(**one) for one in numbers["random_params"]),
        features=tuple(Drop(**one) for one in numbers["features"]),
        methods=trials["methods"],
        choice=choice,
        boxes=trials["rpf_boxes"],
        box_choice=Choice(boxes.index(numbers["rpf_choice"]), 0, nothing, nothing, nothing == 0) if boxes else None,
    )


def printed() -> dict[str, str]:
    """What `mcdenoise advise` prints for one case, in two parts, and what it advises for all scenes at that spp."""
    one = next(case for case in entries() if case["scene"] == PRINTED)
    lines = advice_lines(advice_of(one["advice"]))
    last = max(k for k, line in enumerate(lines) if not line)
    parts = {"tables": lines[:last], "recommendation": lines[last + 1 :]}
    return {"scene": f"`{PRINTED}`", "spp": one["spp"]} | {
        name: "```text\n" + "\n".join(part) + "\n```" for name, part in parts.items()
    }
