"""The studies of chapter 10 behind one command, and the page that shows what they found.

    mcdenoise study all [--quick] [--size 128] [--out out/study]
    mcdenoise study speed-accuracy | stability | parsimony

Each study leaves its numbers in a JSON file, written entry by entry: a run that was stopped goes on where it was. Charts and
`report.html` are made from the numbers of all studies that the folder holds, and open offline.
"""

from __future__ import annotations

import argparse
import base64
import html
from collections.abc import Iterator
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from matplotlib.figure import Figure
from tqdm import tqdm

from mcdenoise.samples.gate import check_count
from mcdenoise.samples.storage import write_beside
from mcdenoise.study.entries import read_study
from mcdenoise.study.report import make_folder
from mcdenoise.study.show import indexed_png

STUDIES = {  # name -> module, heading
    "speed-accuracy": ("mcdenoise.study.speed_accuracy", "Speed against accuracy"),
    "stability": ("mcdenoise.study.stability", "Stability where methods fail"),
    "parsimony": ("mcdenoise.study.parsimony", "No more than a scene needs"),
}
SMALLEST = 32  # pixels a side
DOTS = 150  # an inch
PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>mcdenoise: studies</title>
<style>
  body {{ margin: 0 auto; max-width: 1240px; padding: 20px; font: 15px/1.45 system-ui, sans-serif; }}
  h1 {{ font-size: 22px; }} h2 {{ font-size: 18px; margin-top: 36px; }} h3 {{ font-size: 15px; }}
  figure {{ margin: 0 0 18px; }} img {{ max-width: 100%; }} .dim {{ color: #6a6a70; }}
  pre {{ overflow-x: auto; background: #f6f6f7; padding: 10px; font: 12.5px/1.4 ui-monospace, "DejaVu Sans Mono", monospace; }}
</style>
</head>
<body>
<h1>Speed, stability, parsimony</h1>
{body}
</body>
</html>
"""


def run_study(options: argparse.Namespace) -> int:
    """Run `mcdenoise study`: the named studies, their tables on the terminal, files into the folder."""
    if options.size is not None:
        check_count(options.size, "size", least=SMALLEST)
    folder = options.out or Path("out") / ("study-quick" if options.quick else "study")
    make_folder(folder)
    for name in STUDIES if options.study == "all" else (options.study,):
        module = study_module(name)
        found = module.study(settings_of(module, options.quick, options.size), path_of(folder, name))
        print("\n".join([heading(name, found), "", *module.lines(found), ""]))
        _write_charts(module, found, folder / name)
    written = write_report(folder)
    print(f"Wrote numbers, charts and tables into {folder}. Open {written} in a browser.")
    return 0


def study_module(name: str) -> ModuleType:
    """Return the module of a study; it has `Settings`, `study`, `lines`, `charts`."""
    return import_module(STUDIES[name][0])


def path_of(folder: Path, name: str) -> Path:
    """Where the numbers of a study stand in a folder.

    Examples
    --------
    >>> path_of(Path("out"), "speed-accuracy").name
    'speed_accuracy.json'
    """
    return folder / f"{name.replace('-', '_')}.json"


def settings_of(module: ModuleType, quick: bool, size: int | None) -> Any:
    """Return the settings of a study, with another size of images if one is given.

    The study of stability takes parts, half as wide, of images of that size.
    """
    settings = module.Settings.quick() if quick else module.Settings()
    if size is None:
        return settings
    return (
        replace(settings, size=size // 2, picture=size)
        if hasattr(settings, "picture")
        else replace(settings, size=size)
    )


def heading(name: str, found: dict[str, Any]) -> str:
    """Return the line that says what was run, and how long it took.

    Examples
    --------
    >>> heading("stability", {"settings": {"size": 64}, "cores": 2, "seconds": {"a": 61.0, "b": 29.0}})
    'Stability where methods fail: 64 x 64 pixels, 2 cores, 2 entries in 1.5 min'
    """
    size, minutes = found["settings"]["size"], sum(found["seconds"].values()) / 60
    cores, count = found["cores"], len(found["seconds"])
    return f"{STUDIES[name][1]}: {size} x {size} pixels, {cores} cores, {count} entries in {minutes:.1f} min"


def write_report(folder: Path) -> Path:
    """Write report.html from the numbers and charts of all studies in `folder`; return its path."""
    parts = [part for name in STUDIES if path_of(folder, name).exists() for part in _section(folder, name)]
    with write_beside(folder / "report.html") as temporary:
        temporary.write_text(PAGE.format(body="\n".join(parts)), encoding="utf-8")
    return folder / "report.html"


def _section(folder: Path, name: str) -> Iterator[str]:
    """HTML of one study: heading, charts, and the tables behind a click."""
    found = read_study(path_of(folder, name), name)
    yield f"<h2>{html.escape(STUDIES[name][1])}</h2>"
    yield f'<p class="dim">{html.escape(heading(name, found))}</p>'
    for path in sorted((folder / name).glob("*.png")):
        words = path.stem.replace("_", " ")
        data = base64.b64encode(path.read_bytes()).decode("ascii")
        yield f'<figure><img src="data:image/png;base64,{data}" alt="{html.escape(words)}"></figure>'
    tables = html.escape("\n".join(study_module(name).lines(found)))
    yield f"<details><summary>All numbers</summary><pre>{tables}</pre></details>"


def _write_charts(module: ModuleType, found: dict[str, Any], folder: Path) -> None:
    """Write every chart of a study, and what pictures it can make; charts of an earlier run go."""
    make_folder(folder)
    for old in folder.glob("*.png"):
        old.unlink()
    drawn = _drawn(module, found)
    for name, figure in tqdm(drawn, f"charts of {folder.name}", disable=None, leave=False):
        with write_beside(folder / f"{name}.png") as temporary:
            temporary.write_bytes(indexed_png(figure, DOTS))


def _drawn(module: ModuleType, found: dict[str, Any]) -> Iterator[tuple[str, Figure]]:
    """Charts from the numbers, then pictures, one at a time."""
    yield from module.charts(found).items()
    if hasattr(module, "pictures"):
        settings = module.Settings(**found["settings"])
        for name in module.PICTURED:
            yield f"picture_{name}", module.pictures(name, settings)
