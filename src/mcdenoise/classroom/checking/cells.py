"""Read the cells of a notebook (.ipynb, or .py in percent form) without Jupyter, and clean them of magics."""

from __future__ import annotations

import ast
import json
import re
import textwrap
import warnings
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Literal

LARGEST = 64 * 2**20  # bytes of a notebook; only forgotten outputs make it larger
LARGEST_CODE = 2**17  # characters of code in all cells together
MOST_CELLS = 2000

_MARKER = re.compile(r"^# %%(?P<header>( .*)?)$")
_ENTRY = re.compile(r'(?<![\w.-])(?P<key>[\w.-]+)=(?P<value>"(?:[^"\\]|\\.)*"|\[[^\]]*\]|\{[^}]*\}|\S+)')
_MAGIC = re.compile(r"^\s*([%!?].*|[\w.]+ *= *[%!].*|%{0,2}[\w.*]+\?{1,2}[\s;]*)$")
_PYTHON_CELL_MAGICS = ("time", "capture", "prun", "python", "python3")  # the others hold no names of the notebook
PARSE_ERRORS = (SyntaxError, ValueError, RecursionError, MemoryError)  # ValueError: null bytes


@dataclass(frozen=True)
class Cell:
    """One cell of a notebook: its source, id, kind and metadata."""

    source: str
    id: str = ""
    kind: Literal["code", "markdown"] = "code"
    metadata: dict = field(default_factory=dict)


def read_cells(path: Path | str) -> list[Cell]:
    """Read a notebook (.ipynb), a percent script, or any Python file (one cell).

    Raises
    ------
    ValueError
        If the file is missing, too large, not UTF-8, broken, or a notebook of a format before 4.
    """
    path = Path(path)
    if not path.is_file():
        raise ValueError(f"{path.name}: there is no such file; give a notebook (.ipynb) or a Python file (.py).")
    if path.stat().st_size > LARGEST:
        raise ValueError(
            f"{path.name} has more than {LARGEST >> 20} MB: clear the outputs of the notebook and save it."
        )
    return parse_cells(path.read_bytes(), path.suffix, path.name)


def parse_cells(content: bytes | str, suffix: str, name: str = "the notebook") -> list[Cell]:
    """Split the content of a file into cells; `suffix` is ".ipynb" or ".py", `name` is used in messages.

    Raises
    ------
    ValueError
        If the content is not UTF-8, broken, of a format before 4, or has too many cells or too much code.

    Examples
    --------
    >>> script = '# %% [markdown]\\n# Near.\\n# %% exercise="gaussian_sums"\\nx = 1\\n'
    >>> [(cell.kind, cell.source, cell.metadata) for cell in parse_cells(script, ".py")]
    [('markdown', 'Near.', {}), ('code', 'x = 1', {'exercise': 'gaussian_sums'})]
    """
    if suffix not in (".ipynb", ".py"):
        raise ValueError(f"{name} must be a notebook (.ipynb) or a Python file (.py), got {suffix or 'no ending'!r}.")
    if isinstance(content, bytes):
        try:
            content = content.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise ValueError(f"{name} is not UTF-8 text (byte {error.start}): save it again as UTF-8.") from None
    cells = _notebook_cells(content, name) if suffix == ".ipynb" else _script_cells(content)
    if len(cells) > MOST_CELLS:
        raise ValueError(f"{name} has {len(cells)} cells, more than {MOST_CELLS}: remove those that hold no answer.")
    if sum(len(cell.source) for cell in cells if cell.kind == "code") > LARGEST_CODE:
        raise ValueError(f"{name} has more than {LARGEST_CODE >> 10} kB of code: remove data pasted into its cells.")
    return cells


def _notebook_cells(text: str, name: str) -> list[Cell]:
    try:
        notebook = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{name} is no whole notebook ({error}): save it again in Jupyter.") from None
    if isinstance(notebook, dict) and "worksheets" in notebook:
        raise ValueError(
            f"{name} is a notebook of the old format 3: open it in Jupyter and save it, which converts it."
        )
    cells = notebook.get("cells") if isinstance(notebook, dict) else None
    if not isinstance(cells, list):
        raise ValueError(f"{name} is no notebook: it has no list of cells.")
    return [_notebook_cell(cell, k, name) for k, cell in enumerate(cells)]


def _notebook_cell(cell: object, k: int, name: str) -> Cell:
    source = cell.get("source") if isinstance(cell, dict) else None
    if isinstance(source, list) and all(isinstance(line, str) for line in source):
        source = "".join(source)
    if not isinstance(source, str):
        raise ValueError(f"{name}: cell {k + 1} has no source text: save the notebook again in Jupyter.")
    metadata = cell.get("metadata")
    kind = "code" if cell.get("cell_type") == "code" else "markdown"
    return Cell(source, str(cell.get("id", f"cell-{k}")), kind, metadata if isinstance(metadata, dict) else {})


def _script_cells(text: str) -> list[Cell]:
    lines = lines_of(text)
    if lines[:1] == ["# ---"] and "# ---" in lines[1:]:  # jupytext's header
        lines = lines[lines.index("# ---", 1) + 1 :]
    starts = [k for k, line in enumerate(lines) if _MARKER.match(line)]
    first = lines[: starts[0]] if starts else lines
    cells = [Cell("\n".join(first).strip("\n"), "cell-0")] if "".join(first).strip() else []
    for start, end in pairwise([*starts, len(lines)]):
        header = _MARKER.match(lines[start])["header"]
        kind = "markdown" if re.search(r"\[(markdown|md)\]", header) else "code"
        body = (
            [re.sub("^# ?", "", line) for line in lines[start + 1 : end]]
            if kind == "markdown"
            else lines[start + 1 : end]
        )
        metadata = {entry["key"]: _value(entry["value"]) for entry in _ENTRY.finditer(header[:1000])}
        cells.append(Cell("\n".join(body).strip("\n"), f"cell-{len(cells)}", kind, metadata))
    return cells


def _value(text: str) -> object:
    try:
        return json.loads(text)
    except ValueError:
        return text


def without_magics(source: str) -> str:
    """Return a cell's source as plain Python: IPython's magics, shell and help lines become `pass`.

    Only lines where Python's own parser stops are touched, so that a line of arithmetic that begins with % stays. Line
    numbers do not change.

    Examples
    --------
    >>> print(without_magics("%matplotlib inline\\nx = (7\\n  % 4)\\n!ls"))
    pass
    x = (7
      % 4)
    pass
    """
    lines = lines_of(source)
    first = next((k for k, line in enumerate(lines) if line.strip()), 0)
    if lines and lines[first].startswith("%%"):
        words = lines[first][2:].split()
        if not words or words[0] not in _PYTHON_CELL_MAGICS:
            return ""
        lines[first] = "pass"
    elif lines and lines[first].startswith((" ", "\t")):  # IPython takes an indented cell too
        lines = textwrap.dedent("\n".join(lines)).split("\n")
    for _ in range(min(100, 10 * LARGEST_CODE // (len(source) + 1))):
        try:
            parse("\n".join(lines))
        except SyntaxError as error:
            k = _first_of_continued(lines, (error.lineno or 0) - 1)
            if not (0 <= k < len(lines) and _MAGIC.match(lines[k])):
                break
            _drop_magic(lines, k)
        except PARSE_ERRORS:
            break
        else:
            break
    return "\n".join(lines)


def _first_of_continued(lines: list[str], k: int) -> int:
    """The line that line `k` continues, by backslashes at line ends; `k` itself if it continues none."""
    while 0 < k <= len(lines) and lines[k - 1].endswith("\\"):
        k -= 1
    return k


def _drop_magic(lines: list[str], k: int) -> None:
    """Replace line `k` by `pass`, and the lines that it is continued on (it ends in a backslash) by empty ones."""
    is_continued = lines[k].endswith("\\")
    lines[k] = re.match(r"\s*", lines[k])[0] + "pass"
    while is_continued and k + 1 < len(lines):
        k += 1
        is_continued = lines[k].endswith("\\")
        lines[k] = ""


def parse(source: str) -> ast.Module:
    """Parse a cell as IPython does: `await` may stand at top level."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # such as for "\\d" in a string
        return compile(source, "<cell>", "exec", ast.PyCF_ONLY_AST | ast.PyCF_ALLOW_TOP_LEVEL_AWAIT, dont_inherit=True)


def lines_of(source: str) -> list[str]:
    """Split text where Python's parser does (`str.splitlines` also splits at form feeds and other characters)."""
    return re.split("\r\n|\r|\n", source)
