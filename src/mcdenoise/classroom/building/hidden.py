"""Which tests stay with the instructor, read from the text of a test file without running it."""

from __future__ import annotations

import ast
from dataclasses import dataclass

from mcdenoise.classroom.building.stubs import binds, bound, parse, span


@dataclass(frozen=True)
class TestMark:
    """One `@graded` test as it stands in its file: exercise, points, hidden or public, name and line."""

    __test__ = False

    exercise: str
    points: float
    hidden: bool
    name: str
    line: int


def read_marks(source: str, path: str = "source") -> list[TestMark]:
    """List the graded tests of a test file in their order.

    Raises
    ------
    ValueError
        If a mark is not written out in plain values, or the text is no valid Python.

    Examples
    --------
    >>> read_marks('@graded("double", points=2)\\ndef test_two(impl):\\n    assert impl(1) == 2')
    [TestMark(exercise='double', points=2, hidden=False, name='test_two', line=2)]
    """
    return [mark for node in parse(source, path).body if (mark := _mark(node, path))]


def public_tests(source: str, path: str = "source") -> str:
    """Return the text without hidden tests, without the helpers and imports that only they use, else unchanged.

    Comments of what stays, stay. A comment directly above something that goes, goes with it.

    Raises
    ------
    ValueError
        As `read_marks`.

    Examples
    --------
    >>> public_tests('import os\\n\\n@graded("f", points=1, hidden=True)\\ndef test_f(impl):\\n    os.sep\\n\\nx = 1')
    'x = 1\\n'
    """
    body = parse(source, path).body
    hidden = [node for node in body if (mark := _mark(node, path)) and mark.hidden]
    if not hidden:
        return source
    optional = {name: node for node in body for name in binds(node) if not _is_root(node, path)}
    kept = _reach([node for node in body if _is_root(node, path) and node not in hidden], optional)
    lost = _reach(hidden, optional) - kept
    lines = source.splitlines()
    for node in reversed(body):
        first, last = span(node, lines)
        if node in hidden or (binds(node) and binds(node) <= lost):
            while first and lines[first - 1].startswith("#"):
                first -= 1
            while first and not "".join(lines[first - 1 : first] + lines[last : last + 1]).strip():
                first -= 1
            lines[first:last] = []
        elif isinstance(node, ast.Import | ast.ImportFrom) and binds(node) & lost:
            node.names = [alias for alias in node.names if bound(alias) not in lost]
            lines[first:last] = [ast.unparse(node)]
    return "\n".join(lines).strip() + "\n"


def _mark(node: ast.stmt, path: str) -> TestMark | None:
    """The mark of a top-level function, if it has one."""
    if not isinstance(node, ast.FunctionDef):
        return None
    for call in node.decorator_list:
        if isinstance(call, ast.Call) and ast.unparse(call.func).split(".")[-1] == "graded":
            try:
                (exercise,) = map(ast.literal_eval, call.args)
                named = {word.arg: ast.literal_eval(word.value) for word in call.keywords}
                return TestMark(exercise, named["points"], bool(named.get("hidden", False)), node.name, node.lineno)
            except (ValueError, KeyError, TypeError) as error:
                raise ValueError(
                    f"{path}:{call.lineno}: the mark of {node.name} must be written out, such as "
                    f'@graded("name", points=1, hidden=True), got {ast.unparse(call)}.'
                ) from error
    return None


def _is_root(node: ast.stmt, path: str) -> bool:
    """Whether a statement is there for its own sake: a test, a picture, a mark of the module, its docstring."""
    if isinstance(node, ast.FunctionDef):
        return _mark(node, path) is not None or bool(node.decorator_list) or node.name.startswith("test_")
    return not binds(node) or bool(binds(node) & {"pytestmark", "annotations"})


def _reach(nodes: list[ast.stmt], optional: dict[str, ast.stmt]) -> set[str]:
    """The names that statements use, directly or through other statements."""
    names, waiting = set(), list(nodes)
    while waiting:
        used = {one.id for one in ast.walk(waiting.pop()) if isinstance(one, ast.Name) and one.id in optional}
        waiting += [optional[name] for name in used - names]
        names |= used
    return names
