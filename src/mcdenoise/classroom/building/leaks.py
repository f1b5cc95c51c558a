"""Does a tree that goes to students hold anything of a solution or of a hidden test?

The secrets are read from the repository by means of their own, simpler than those of the build, so that a mistake there
shows here. A line counts as secret

- if it is long enough to carry the answer, wherever it stands, also inside other text or broken into several lines;
- if it is short, where it stands as a whole line and authors have not written the same line outside the marks as well
  (``return total, norm``).
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mcdenoise.classroom.building.chapters import Chapter
from mcdenoise.classroom.building.folders import files_below
from mcdenoise.classroom.building.stubs import BEGIN, END, parse, solution_blocks, span

SHORT, LONG = 8, 32  # characters without spaces: below, a line says nothing; from here on, it says the answer
_PROMPT = re.compile(r"^(?:>>>|\.\.\.|[#>*`-])\s*|`$")


@dataclass(frozen=True)
class Secrets:
    """What students must not get: lines (without spaces) and names of hidden tests, each with the place it is from."""

    long: dict[str, str]
    short: dict[str, str]
    names: dict[str, str]


def find_secrets(chapters: list[Chapter], root: Path) -> Secrets:
    """Collect the secrets of the repository at `root`: marked solutions in src and notebooks, and hidden tests.

    Raises
    ------
    ValueError
        If the text of a solution also stands outside the marks of a notebook or in a public test.
    """
    secret: dict[str, str] = {}
    hidden: dict[str, str] = {}
    names: dict[str, str] = {}
    public: dict[str, list[str]] = {}
    for path in [*sorted((root / "src").rglob("*.py")), *(root / chapter.script for chapter in chapters)]:
        where = path.relative_to(root).as_posix()
        text = path.read_text(encoding="utf-8")
        blocks = solution_blocks(text, where) if path.parent.parent.name != "classroom" else []
        inside = {index for begin, end in blocks for index in range(begin + 1, end)}
        lines = [_bare(line) for line in text.splitlines()]
        secret |= {_core(lines[index]): f"the solution in {where}:{index + 1}" for index in inside}
        if path.parent.name == "notebooks":
            public[where] = ["" if index in inside else line for index, line in enumerate(lines)]
    for chapter in chapters:
        public[chapter.test_file] = _read_tests(chapter, hidden, names)
    for where, lines in public.items():
        _refuse_outside(where, lines, secret)
    known = {line for lines in public.values() for line in lines}
    text = "\n".join("".join(lines) for lines in public.values())
    secret = {line: origin for line, origin in (hidden | secret).items() if len(line) >= SHORT}
    return Secrets(
        {line: origin for line, origin in secret.items() if len(line) >= LONG and line not in text},
        {line: origin for line, origin in secret.items() if len(line) < LONG and line not in known},
        names,
    )


def _refuse_outside(where: str, lines: list[str], secret: dict[str, str]) -> None:
    """Refuse public text that holds a long line of a solution, whole or wrapped."""
    text = "".join(lines)
    for line, origin in secret.items():
        if len(line) >= LONG and line in text and not line.startswith(("import", "from")):
            start, number = text.index(line), 0
            while start >= 0:
                start -= len(lines[number])
                number += 1
            raise ValueError(
                f"{where}:{number}: this text is also {origin}. Reword it, or move it between {BEGIN} and {END} (in a "
                f"test: hide the test)."
            )


def find_leaks(folder: Path, secrets: Secrets) -> list[str]:
    """Search every file below `folder` for the secrets.

    Notebooks are searched in every text they hold: sources, outputs, metadata. An output is a leak by itself, because
    notebooks go out without any.

    Returns
    -------
    One sentence a leak: file, and what was found. Empty if there is none.

    Examples
    --------
    >>> import tempfile
    >>> secrets = Secrets({}, {"x=3.125": "the solution in ch09.py:7"}, {})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = (Path(folder) / "notes.txt").write_text("first\\n> x = 3.125\\n")
    ...     find_leaks(Path(folder), secrets)
    ['notes.txt holds the solution in ch09.py:7']
    """
    leaks = []
    for path in files_below(folder):
        name = path.relative_to(folder).as_posix()
        text = _text(path.read_bytes())
        for where, part in _parts(text) if path.suffix == ".ipynb" else [("", text)]:
            leaks += [f"{name}{where} holds {found}" for found in _search(part, secrets)]
        if path.suffix == ".ipynb" and any(cell.get("outputs") for cell in json.loads(text)["cells"]):
            leaks.append(f"{name} holds outputs")
    return leaks


def _text(content: bytes) -> str:
    """A file's text; of a binary file what can be read in it."""
    if b"\0" in content:
        content = b"\n".join(re.findall(rb"[\t -~]{%d,}" % SHORT, content))
    return content.decode("utf-8", errors="replace")


def _search(text: str, secrets: Secrets) -> Iterator[str]:
    """What of the secrets a text holds."""
    bare = "\n".join(re.sub(r"\s+", "", one) for one in (text, "".join(map(_unprompted, text.splitlines()))))
    lines = {_bare(line) for line in text.splitlines()}
    words = set(re.findall(r"\w+", text))
    yield from (origin for line, origin in secrets.long.items() if line in bare)
    yield from (origin for line, origin in secrets.short.items() if line in lines)
    yield from (origin for name, origin in secrets.names.items() if name in words)
    if BEGIN in text or END in text:
        yield "a mark of a solution"


def _read_tests(chapter: Chapter, hidden: dict[str, str], names: dict[str, str]) -> list[str]:
    """Add the lines and names of hidden tests; return the public lines, empty where one was hidden."""
    lines = chapter.tests.splitlines()
    public = [_bare(line) for line in lines]
    secret = {mark.name for mark in chapter.marks if mark.hidden}
    for node in parse(chapter.tests, chapter.test_file).body:
        if isinstance(node, ast.FunctionDef) and node.name in secret:
            where = f"the hidden test {node.name} in {chapter.test_file}:{node.lineno}"
            names[node.name] = where
            for index in range(*span(node, lines)):
                hidden.setdefault(public[index], where)
                public[index] = ""
    return public


def _parts(text: str) -> Iterator[tuple[str, str]]:
    """Every text of a notebook with its place: joined source lines, and all other strings."""
    notebook = json.loads(text)
    for index, cell in enumerate(notebook["cells"]):
        yield f", cell {index + 1},", "".join(cell["source"])
        yield f", cell {index + 1},", "\n".join(_strings({**cell, "source": ""}))
    yield ", metadata,", "\n".join(_strings(notebook["metadata"]))


def _strings(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        yield from (text for pair in value.items() for one in pair for text in _strings(one))
    elif isinstance(value, list):
        yield from ["".join(value)] if all(isinstance(one, str) for one in value) else ()
        yield from (text for one in value for text in _strings(one))


def _bare(line: str) -> str:
    """A line without spaces, without a trailing comment, and without the sign of a comment or prompt before it."""
    code = re.sub(r"\s+#.*$", "", _unprompted(line))
    return re.sub(r"\s+", "", code)


def _core(bare: str) -> str:
    """What a line without spaces computes, without the name for it, if that alone is long."""
    core = re.sub(r"^(?:return|[\w,.]+[-+*/]?=)(?!=)", "", bare)
    return core if len(core) >= LONG else bare


def _unprompted(line: str) -> str:
    return _PROMPT.sub("", line.strip())
