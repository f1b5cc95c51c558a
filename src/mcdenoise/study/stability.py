"""Stability where methods fail: a catalogue of failures, each measured for every method.

| part | where |
|---|---|
| what can go wrong, what we guarantee | `stability_catalogue.py`; where we do not, and why: `stability_limits.py` |
| buffers with a known truth | `stability_scenes.py`, and with trouble `stability_troubles.py` |
| what a guarantee measures | `stability_measures.py` |
| a run of one entry | `stability_run.py`; entries without scenes `stability_special.py`, `stability_threads.py` |
| tables, charts, pictures | `stability_tables.py`, `stability_charts.py`, `stability_pictures.py` |
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from mcdenoise.study.entries import run_entries
from mcdenoise.study.stability_catalogue import CATALOGUE
from mcdenoise.study.stability_charts import charts
from mcdenoise.study.stability_limits import LIMITS, broken_in, limit_of
from mcdenoise.study.stability_pictures import PICTURED, pictures
from mcdenoise.study.stability_run import run_case
from mcdenoise.study.stability_settings import Settings
from mcdenoise.study.stability_tables import lines

__all__ = [
    "CATALOGUE",
    "LIMITS",
    "PICTURED",
    "Settings",
    "broken_in",
    "charts",
    "entries",
    "limit_of",
    "lines",
    "pictures",
    "study",
]

NAME = "stability"


def entries(settings: Settings) -> dict[str, Callable[[], dict[str, Any]]]:
    """Return name -> a function that runs that entry, in the order of the catalogue.

    Examples
    --------
    >>> list(entries(Settings.quick()))[:2]
    ['firefly_count', 'firefly_value']
    """
    return {name: partial(run_case, case, settings) for name, case in CATALOGUE.items()}


def study(settings: Settings, path: Path, *, progress: bool | None = None) -> dict[str, Any]:
    """Run what is not yet in the file `path`; return all of it, as `run_entries` does."""
    return run_entries(path, NAME, asdict(settings), entries(settings), progress=progress)
