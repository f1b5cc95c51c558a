"""What `lbf_capacity` leaves behind: read its JSON file, and show it as tables and charts."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.study.capacity import Candidate, Capacity
from mcdenoise.study.choice import mean_and_error

FORMAT = "mcdenoise-lbf-capacity-1"
ALL = "all groups"
UNIT = "relMSE, after / before"


@dataclass(frozen=True, eq=False)
class Study:
    """What the study found.

    Attributes
    ----------
    settings : of the study, as JSON holds them
    architectures : the sweep over hidden layers
    groups : ``"all groups"``, then ``"without albedo"``, ...: the sweep over groups of features
    """

    settings: Mapping[str, object]
    architectures: Capacity
    groups: Mapping[str, Candidate]

    def harm(self, name: str) -> tuple[float, float]:
        """How much larger the error is without a group than with all, see `difference`."""
        return difference(self.groups[name], self.groups[ALL])

    @property
    def excess(self) -> tuple[tuple[float, float], ...]:
        """How much larger the error of each architecture is than that of the best, see `difference`."""
        best = self.architectures.candidates[self.architectures.best]
        return tuple(difference(one, best) for one in self.architectures.candidates)

    @property
    def enough(self) -> int:
        """Index of the smallest architecture whose excess is within the standard error of that excess.

        Folds are scenes, and scenes differ in difficulty: the spread of the errors themselves, by which `Capacity.chosen`
        goes, would let nearly everything pass.
        """
        passing = [k for k, (mean, spread) in enumerate(self.excess) if mean <= spread]
        return min(passing, key=lambda k: self.architectures.candidates[k].parameters)


def difference(one: Candidate, other: Candidate) -> tuple[float, float]:
    """Mean of how much larger the error of `one` is, and the standard error of that mean, fold by fold.

    Both were judged on the same folds: what one fold is harder than another cancels.

    Examples
    --------
    >>> here = Candidate((2,), 9, np.array([0.1, 0.5, 0.9]), np.zeros(3), 1.0)
    >>> there = Candidate((4,), 17, here.errors - [0.1, 0.12, 0.08], np.zeros(3), 1.0)
    >>> [round(value, 4) for value in difference(here, there)]
    [0.1, 0.0115]
    """
    more = one.errors - other.errors
    return mean_and_error(more)


def load_study(path: Path) -> Study:
    """Read what `study` wrote; a study that was interrupted has fewer candidates.

    Raises
    ------
    ValueError
        If there is no such file, or it holds something else.
    """
    found = read_json(path)
    candidates = {name: _from_json(one) for name, one in found["candidates"].items()}
    swept = tuple(one for name, one in candidates.items() if name.startswith("hidden "))
    groups = {name: one for name, one in candidates.items() if not name.startswith("hidden ")}
    settings = found["settings"]
    title = f"LBF, {settings['train']['variant']}, {settings['scenes']} random scenes"
    return Study(settings, Capacity(title, UNIT, swept), groups)


def difference_lines(found: Study) -> list[str]:
    """Two tables, fold by fold: architectures against the best, and groups left out against all."""
    names = [one.label for one in found.architectures.candidates]
    best, enough = names[found.architectures.best], names[found.enough]
    table = [f"fold by fold ({UNIT}): more than the best, {best}; enough, as far as one can tell: {enough}"]
    table += [_line(name, *more) for name, more in zip(names, found.excess, strict=True) if name != best]
    table += ["", f"fold by fold ({UNIT}): more than with all groups, {found.groups[ALL].mean:.4f}"]
    return table + [_line(name, *found.harm(name)) for name in found.groups if name != ALL]


def _line(name: str, mean: float, spread: float) -> str:
    """One difference."""
    return f"  {name:24s}{mean:+9.4f} +- {spread:.4f}"


def _from_json(one: Mapping[str, object]) -> Candidate:
    """A candidate from what the file holds."""
    errors, fitted = np.array(one["errors"]), np.array(one["fitted"])
    return Candidate(tuple(one["hidden"]), one["parameters"], errors, fitted, one["seconds"])


def read_json(path: Path) -> dict[str, object]:
    """Read the file and see that it is one of ours."""
    if not path.is_file():
        raise ValueError(f"A study of LBF's capacity is needed, but there is no file {path}.")
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path} is not the whole file of a study ({error}). Delete it, or name another.") from error
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        raise ValueError(f"{path} is no study of LBF's capacity (format {FORMAT}). Name another file.")
    return found


def differences_figure(found: Study) -> Figure:
    """Chart what smaller networks and missing groups cost, each with the standard error of the difference."""
    candidates, groups = found.architectures.candidates, [name for name in found.groups if name != ALL]
    best, enough = (candidates[k].label for k in (found.architectures.best, found.enough))
    figure = Figure(figsize=(10, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    _draw(left, {one.label: more for one, more in zip(candidates, found.excess, strict=True)})
    left.set(title=f"Hidden layers against the best, {best}; enough: {enough}", xlabel=f"more error ({UNIT})")
    _draw(right, {name: found.harm(name) for name in groups})
    right.set(title=f"A group left out; error with all: {found.groups[ALL].mean:.3f}", xlabel=f"more error ({UNIT})")
    return figure


def _draw(axes: Axes, differences: Mapping[str, tuple[float, float]]) -> None:
    """A row for each difference, the first on top."""
    places = np.arange(len(differences))[::-1]
    for place, (mean, spread) in zip(places, differences.values(), strict=True):
        axes.errorbar(mean, place, xerr=spread, fmt="o", ms=6, color="#4477AA", capsize=4)
    axes.axvline(0, color="#777777", ls="--", lw=1, zorder=0)
    axes.set_yticks(places, list(differences))
    axes.set_ylim(-0.6, len(differences) - 0.4)
    axes.grid(color="#e5e5e5", axis="x")
