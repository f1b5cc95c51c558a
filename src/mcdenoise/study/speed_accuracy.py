"""Speed against accuracy: every method as a curve, peers and Monte Carlo beside it, over scenes, spp and seeds.

Each method has one dial that trades time for error; all others are chosen by halves of the samples, on a seed that is not
judged. Seconds are those of rendering the samples and of filtering them, measured in the same run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from mcdenoise.study.entries import run_entries
from mcdenoise.study.speed_accuracy_charts import budget_figure, pooled_figure, scenes_figure
from mcdenoise.study.speed_accuracy_laws import (
    equal_error_figure,
    growth_figure,
    slopes_figure,
    slopes_scenes_figure,
)
from mcdenoise.study.speed_accuracy_measure import measure_growth, measure_monte_carlo, measure_scene
from mcdenoise.study.speed_accuracy_results import QUANTITIES, Point, pooled
from mcdenoise.study.speed_accuracy_settings import Settings
from mcdenoise.study.speed_accuracy_tables import all_lines

NAME = "speed-accuracy"
CHARTS = {
    "speed_accuracy_pooled": pooled_figure,
    "speed_accuracy_scenes": scenes_figure,
    "speed_accuracy_budget": budget_figure,
    "error_spp_pooled": slopes_figure,
    "error_spp_scenes": slopes_scenes_figure,
    "time_growth": growth_figure,
    "equal_error_spp": equal_error_figure,
}

__all__ = ["NAME", "Point", "Settings", "charts", "entries", "lines", "pooled", "study"]


def entries(settings: Settings) -> dict[str, Callable[[], dict[str, Any]]]:
    """Return name -> what runs that entry: each scene at each spp, Monte Carlo on each scene, three kinds of growth.

    Examples
    --------
    >>> list(entries(Settings.quick()))[:3]
    ['dof, 2 spp', 'dof, 8 spp', 'dof, Monte Carlo']
    """
    found: dict[str, Callable[[], dict[str, Any]]] = {}
    for scene in settings.scenes:
        for spp in settings.spps:
            found[f"{scene}, {spp} spp"] = partial(measure_scene, settings, scene, spp)
        found[f"{scene}, Monte Carlo"] = partial(measure_monte_carlo, settings, scene)
    return found | {f"growth with {name}": partial(measure_growth, settings, name) for name in QUANTITIES}


def study(settings: Settings, path: Path, *, progress: bool | None = None) -> dict[str, Any]:
    """Run what the JSON file `path` does not hold yet, and return all of it, as `run_entries` does."""
    return run_entries(path, NAME, asdict(settings), entries(settings), progress=progress)


def lines(found: Mapping[str, Any]) -> list[str]:
    """Return the tables: errors at each spp, Monte Carlo, slopes, growth of time, who is not installed."""
    return all_lines(found)


def charts(found: Mapping[str, Any]) -> dict[str, Figure]:
    """Return name -> chart, made from the stored numbers alone."""
    return {name: draw(found) for name, draw in CHARTS.items()}
