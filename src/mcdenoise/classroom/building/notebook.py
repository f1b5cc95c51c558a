"""From a chapter's cells to a notebook file, in the four kinds that are needed; the same bytes on every run."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from typing import Literal

from mcdenoise.classroom.building.chapters import Chapter, SourceCell
from mcdenoise.classroom.building.nbgrader_course import grade_cell, solution_cell

Kind = Literal["student", "solution", "site", "nbgrader"]
KINDS = ("student", "solution", "site", "nbgrader")
_METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}


def notebook_text(chapter: Chapter, kind: Kind) -> str:
    """Return the notebook of a chapter as JSON text (format 4.5), without outputs.

    Parameters
    ----------
    chapter : as `read_chapters` gives it.
    kind : ``"student"``: stubs in the exercise cells. ``"solution"``: the references, to be executed. ``"site"``: as
        solution, but a page shows the stub (a text cell before it) and hides the reference (tag ``remove-input``).
        ``"nbgrader"``: as student, with nbgrader's metadata.

    Raises
    ------
    ValueError
        For another kind.

    Examples
    --------
    >>> chapter = Chapter("ch99_none", "", "", (SourceCell("markdown", "# Hello", 1),), "", ())
    >>> json.loads(notebook_text(chapter, "student"))["cells"][0]["source"]
    ['# Hello']
    """
    if kind not in KINDS:
        raise ValueError(f"kind must be one of {', '.join(KINDS)}, got {kind!r}.")
    seen: Counter = Counter()
    cells, graded = [], set()
    for cell in chapter.cells:
        if cell.exercise and kind == "site":
            shown = SourceCell("markdown", f"```python\n{cell.stub.rstrip()}\n```", cell.line)
            cells.append(_cell(shown, chapter, seen, tags=cell.tags))
        hidden = cell.exercise and kind == "site"
        made = _cell(cell, chapter, seen, tags=(*cell.tags, *(["remove-input"] if hidden else [])))
        if cell.exercise and kind in ("student", "nbgrader"):
            made["source"] = cell.stub.rstrip("\n").splitlines(keepends=True)
        if kind == "nbgrader" and cell.exercise:
            made["metadata"]["nbgrader"] = solution_cell(cell.exercise)
        elif kind == "nbgrader" and cell.checks and cell.checks not in graded:
            graded.add(cell.checks)
            made["metadata"]["nbgrader"] = grade_cell(cell.checks, chapter.points(cell.checks))
        cells.append(made)
    notebook = {"cells": cells, "metadata": _METADATA, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(notebook, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


def _cell(cell: SourceCell, chapter: Chapter, seen: Counter, tags: tuple[str, ...]) -> dict:
    """One cell as Jupyter stores it; its id comes from what it is, so that it stays when other cells move."""
    what = f"exercise {cell.exercise}" if cell.exercise else f"{cell.kind} {cell.source}"
    seen[what] += 1
    key = f"{chapter.name} {seen[what]} {what}".encode()
    made = {
        "cell_type": cell.kind,
        "id": hashlib.sha256(key).hexdigest()[:12],
        "metadata": {"tags": list(tags)} if tags else {},
        "source": cell.source.rstrip("\n").splitlines(keepends=True),
    }
    return made if cell.kind == "markdown" else made | {"execution_count": None, "outputs": []}
