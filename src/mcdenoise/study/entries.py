"""A study that takes minutes is made of entries: each is written down when it is done, and a second run goes on behind it."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tqdm import tqdm

from mcdenoise.samples.storage import write_beside
from mcdenoise.study.machine import usable_cores

FORMAT = "mcdenoise study 1"


def run_entries(
    path: Path,
    study: str,
    settings: Mapping[str, Any],
    entries: Mapping[str, Callable[[], Any]],
    *,
    progress: bool | None = None,
) -> dict[str, Any]:
    """Run what is not yet in the JSON file `path`, entry by entry, and return all of it.

    Parameters
    ----------
    path : written beside and renamed after each entry; its folder must exist.
    study : its name, which the file must have too.
    settings : what must be the same for a study to go on, as JSON can hold it.
    entries : name -> a function without arguments that returns what JSON can hold (NaN and infinity become null).
    progress : a bar on stderr; None: if that is a terminal.

    Returns
    -------
    ``{"format", "study", "settings", "cores", "entries": {name: result}, "seconds": {name: of that entry}}``

    Raises
    ------
    ValueError
        If `path` holds something else, another study, or one with other settings.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "sums.json"
    ...     first = run_entries(path, "sums", {"seed": 0}, {"two": lambda: {"sum": 1 + 1}})
    ...     again = run_entries(path, "sums", {"seed": 0}, {"two": lambda: 1 / 0, "inf": lambda: float("inf")})
    >>> again["entries"]
    {'two': {'sum': 2}, 'inf': None}
    """
    settings = json.loads(json.dumps(dict(settings)))
    done = _so_far(path, study, settings)
    if done["cores"] is None:
        done["cores"] = usable_cores()
    with tqdm(entries.items(), desc=study, unit="entry", disable=None if progress is None else not progress) as bar:
        for name, run in bar:
            if name in done["entries"]:
                continue
            bar.set_postfix_str(name)
            start = time.perf_counter()
            done["entries"][name] = json_ready(run())
            done["seconds"][name] = round(time.perf_counter() - start, 3)
            with write_beside(path) as temporary:
                temporary.write_text(json.dumps(done, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    return done


def read_study(path: Path, study: str) -> dict[str, Any]:
    """Return what `run_entries` left in `path`.

    Raises
    ------
    ValueError
        If there is no such file, it holds something else, or another study.
    """
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"The results of the study {study} are needed, {path} cannot be read: {error}.") from error
    except ValueError as error:
        raise ValueError(f"{path} must hold the results of the study {study} as JSON: {error}.") from error
    if not isinstance(found, dict) or found.get("format") != FORMAT or found.get("study") != study:
        raise ValueError(f"{path} must hold the results of the study {study}. Take another file, or delete this one.")
    return found


def json_ready(value: Any) -> Any:
    """Return `value` as JSON can hold it: numbers of NumPy become numbers, what is not finite null, tuples lists.

    Examples
    --------
    >>> json_ready({"a": (1, float("nan"))})
    {'a': [1, None]}
    """
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): json_ready(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [json_ready(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _so_far(path: Path, study: str, settings: dict[str, Any]) -> dict[str, Any]:
    """The study so far, or an empty one."""
    if not path.exists():
        return {"format": FORMAT, "study": study, "settings": settings, "cores": None, "entries": {}, "seconds": {}}
    found = read_study(path, study)
    if found["settings"] != settings:
        other = sorted(
            name for name in {*settings, *found["settings"]} if found["settings"].get(name) != settings.get(name)
        )
        raise ValueError(
            f"{path} holds a study with another {', '.join(other)}. Use the same options, or another --out."
        )
    return found
