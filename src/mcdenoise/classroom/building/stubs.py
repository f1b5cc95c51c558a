"""From a reference to its stub: the text between the marks goes, and a hole that fails loudly takes its place.

The marks are two comment lines, around the body of a function or around the value of a prediction:

    ### BEGIN SOLUTION
    ### END SOLUTION
"""

from __future__ import annotations

import ast
from pathlib import Path

BEGIN = "### BEGIN SOLUTION"
END = "### END SOLUTION"
_GIVEN = ("samples/gate.py", "filters/window.py")


def solution_blocks(source: str, path: str = "source", first_line: int = 1) -> list[tuple[int, int]]:
    """Find the marked blocks: pairs of line indices (BEGIN, END), counted from 0.

    Parameters
    ----------
    source : Python text.
    path, first_line : where the text stands, for the message.

    Raises
    ------
    ValueError
        For a mark without its partner, and for a block with nothing in it.

    Examples
    --------
    >>> solution_blocks("x = None\\n### BEGIN SOLUTION\\nx = 3\\n### END SOLUTION\\n")
    [(1, 3)]
    """
    blocks, begin = [], None
    lines = source.splitlines()
    for index, line in enumerate(lines):
        here = f"{path}:{first_line + index}"
        if line.strip() == BEGIN:
            if begin is not None:
                raise ValueError(f"{here}: {BEGIN} inside a solution that is still open. Write {END} before it.")
            begin = index
        elif line.strip() == END:
            if begin is None:
                raise ValueError(f"{here}: {END} without a beginning. Write {BEGIN} where the solution starts.")
            if not "".join(lines[begin + 1 : index]).strip():
                raise ValueError(f"{here}: no solution stands between the marks. Write it there, or remove the marks.")
            blocks.append((begin, index))
            begin = None
        elif BEGIN in line or END in line:
            raise ValueError(f"{here}: a mark must stand alone on its line. Move what stands beside it.")
    if begin is not None:
        raise ValueError(f"{path}:{first_line + begin}: {BEGIN} has no end. Write {END} after the solution.")
    return blocks


def strip_solutions(source: str, path: str = "source", first_line: int = 1) -> str:
    """Return the text without its marked solutions; inside a function a hole is left that names the function.

    Parameters, and errors for the marks, as for `solution_blocks`.

    Raises
    ------
    ValueError
        Also if the text is no valid Python.

    Examples
    --------
    >>> print(strip_solutions("def double(x):\\n    ### BEGIN SOLUTION\\n    return 2 * x\\n    ### END SOLUTION"))
    def double(x):
        # Your code here.
        raise NotImplementedError("double is not written yet")
    """
    blocks = solution_blocks(source, path, first_line)
    if not blocks:
        return source
    lines = source.splitlines()
    functions = [node for node in ast.walk(parse(source, path, first_line)) if isinstance(node, ast.FunctionDef)]
    for begin, end in reversed(blocks):
        indent = lines[begin][: len(lines[begin]) - len(lines[begin].lstrip())]
        around = [node for node in functions if node.lineno <= begin + 2 <= (node.end_lineno or 0)]
        hole = []
        if indent and around:
            name = max(around, key=lambda node: node.lineno).name
            hole = [f"{indent}# Your code here.", f'{indent}raise NotImplementedError("{name} is not written yet")']
        lines[begin : end + 1] = hole
    return "\n".join(lines) + ("\n" if source.endswith("\n") else "")


def stub_source(source: str, name: str, path: str = "source") -> str:
    """Return the stub of the top-level function `name`: its signature and docstring, then a hole.

    Parameters
    ----------
    source : text of the module that holds the reference. path : its file, for messages.

    Raises
    ------
    ValueError
        If the module has no such function, or the function no marks.

    Examples
    --------
    >>> text = "import math\\n\\ndef half(x):\\n    ### BEGIN SOLUTION\\n    return x / 2\\n    ### END SOLUTION\\n"
    >>> print(stub_source(text, "half").splitlines()[0])
    def half(x):
    """
    lines = source.splitlines()
    for node in parse(source, path).body:
        if isinstance(node, ast.FunctionDef) and node.name == name:
            first, last = span(node, lines)
            text = "\n".join(lines[first:last]) + "\n"
            if not solution_blocks(text, path, first + 1):
                raise ValueError(
                    f"{path}:{node.lineno}: {name} is an exercise but has no marked solution. Write {BEGIN} and {END} "
                    f"around the body that students write."
                )
            return strip_solutions(text, path, first + 1)
    raise ValueError(
        f"{path}: an exercise needs the function {name} here, but there is none at top level. Check the import in the "
        f"exercise cell."
    )


def parse(source: str, path: str = "source", first_line: int = 1) -> ast.Module:
    """Parse Python text; a syntax error becomes a ValueError with file and line."""
    try:
        return ast.parse(source)
    except SyntaxError as error:
        line = first_line + (error.lineno or 1) - 1
        raise ValueError(f"{path}:{line}: this is no valid Python ({error.msg}). Correct the line.") from error


def span(node: ast.stmt, lines: list[str]) -> tuple[int, int]:
    """Lines [first, last) of a top-level statement: with its decorators and with indented comments that follow."""
    first = min([node.lineno, *(one.lineno for one in getattr(node, "decorator_list", []))]) - 1
    last = node.end_lineno or node.lineno
    end = last
    while end < len(lines) and (not lines[end].strip() or lines[end][0].isspace()):
        end += 1
        if lines[end - 1].strip():
            last = end
    return first, last


def binds(node: ast.stmt) -> set[str]:
    """The names that a top-level statement gives a value."""
    if isinstance(node, ast.Import | ast.ImportFrom):
        return {bound(alias) for alias in node.names}
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return {node.name}
    return {one.id for one in ast.walk(node) if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)}


def bound(alias: ast.alias) -> str:
    """The name under which an import can be used."""
    return alias.asname or alias.name.split(".")[0]


def stub_package(folder: Path) -> None:
    """Write the package `mcdenoise` that a student's answer may use while it is graded, into `folder`.

    It holds what exercises are given (`mcdenoise.filters.window`, and the gate that it needs; without solutions). Every
    name of the front door is there too, but calling it says that it is not available.

    Parameters
    ----------
    folder : made if missing; put it on the path of the process that runs the answer.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     stub_package(Path(folder))
    ...     sorted(path.name for path in (Path(folder) / "mcdenoise").iterdir())
    ['__init__.py', 'filters', 'samples']
    """
    import mcdenoise
    from mcdenoise import filters

    package = Path(mcdenoise.__file__).parent
    target = Path(folder) / "mcdenoise"
    for pattern in _GIVEN:
        for path in sorted(package.glob(pattern)):
            copy = target / path.relative_to(package)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_text(strip_solutions(path.read_text(encoding="utf-8"), path.name), encoding="utf-8")
    (target / "samples" / "__init__.py").touch()
    (target / "__init__.py").write_text(
        "from mcdenoise.filters import window as _window  # makes `mcdenoise.filters.window` known\n"
        + "".join(map(_refusal, mcdenoise.__all__)),
        encoding="utf-8",
    )
    (target / "filters" / "__init__.py").write_text("".join(map(_refusal, filters.__all__)), encoding="utf-8")


def _refusal(name: str) -> str:
    """A function that takes the place of a public name while grading."""
    message = f"mcdenoise.{name} is not available while grading: write it yourself."
    return f"\n\ndef {name}(*args, **kwargs):\n    raise RuntimeError({message!r})\n"
