"""The top-level statements of a notebook: what each binds, and which names it needs. Nothing is run."""

from __future__ import annotations

import ast
import symtable
import warnings
from dataclasses import dataclass
from functools import cached_property

from mcdenoise.classroom.checking.cells import PARSE_ERRORS, Cell, lines_of, parse, without_magics

_ASSIGNMENTS = (ast.Assign, ast.AugAssign, ast.AnnAssign, getattr(ast, "TypeAlias", ast.Assign))  # the last: 3.12
_DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
_OWN_SCOPES = (ast.Lambda, ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
_WORDS = {ast.For: "`for` loop", ast.While: "`while` loop", ast.With: "`with` block", ast.Delete: "`del`"}


@dataclass(frozen=True, eq=False)
class Statement:
    """One top-level statement (of an import: one of its names).

    Attributes
    ----------
    node : the statement. lines : source of its whole cell, split into lines and shared by all its statements.
    cell : number of that cell. line : its first line in it.
    binds : the names that it binds, or of which it changes an element or attribute.
    alone : no other statement stands on its lines.
    """

    node: ast.stmt
    lines: list[str]
    cell: int
    line: int
    binds: frozenset[str]
    alone: bool = True

    @cached_property
    def source(self) -> str:
        """Its own source."""
        if isinstance(self.node, ast.Import | ast.ImportFrom):
            return ast.unparse(self.node)
        if not self.alone:
            return _segment(self.lines, self.node)
        return "\n".join(self.lines[self.line - 1 : self.node.end_lineno])

    @property
    def kind(self) -> str:
        """What it is, in words."""
        return _WORDS.get(type(self.node), "statement of another kind")

    @property
    def module(self) -> str | None:
        """The module that an import names; None for any other statement."""
        if isinstance(self.node, ast.ImportFrom):
            return "." * self.node.level + (self.node.module or "")
        return self.node.names[0].name if isinstance(self.node, ast.Import) else None

    @property
    def is_conditional(self) -> bool:
        """Whether it may leave a name as it was."""
        return isinstance(self.node, ast.If | ast.Try)

    @property
    def is_variable(self) -> bool:
        """Whether it is neither import nor definition."""
        return not isinstance(self.node, (ast.Import, ast.ImportFrom, *_DEFINITIONS))

    @cached_property
    def changes(self) -> str | None:
        """The name of whose value it calls a method, such as `table` in ``table.update(two=2)``; None if none."""
        return _receiver(self.node)

    @cached_property
    def imports(self) -> bool:
        """Whether an import stands in it."""
        return any(isinstance(one, ast.Import | ast.ImportFrom) for one in ast.walk(self.node))

    @property
    def is_taken(self) -> bool:
        """Whether an answer may hold statements of this kind."""
        is_change = self.changes is not None
        return not self.is_variable or self.is_conditional or is_change or isinstance(self.node, _ASSIGNMENTS)

    @cached_property
    def now(self) -> frozenset[str]:
        """The names that it needs when it is run itself."""
        own = {name.id for name in _targets(self.node) if isinstance(self.node, ast.AugAssign)}
        if isinstance(self.node, ast.Import) and "." in self.node.names[0].name:
            own |= self.binds  # `import xml.sax` adds to an earlier `import xml.dom`
        return self._needs[0] | own

    @cached_property
    def later(self) -> frozenset[str]:
        """The names that its functions need when they are called."""
        return self._needs[1] - self._needs[0]

    @cached_property
    def _needs(self) -> tuple[frozenset[str], frozenset[str]]:
        now, later = set(), set()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                tables = [(symtable.symtable(self.source, "<cell>", "exec"), now)]
        except PARSE_ERRORS:  # such as `nonlocal` at top level: compiling the answer will say so
            return frozenset(), frozenset()
        while tables:
            table, names = tables.pop()
            is_top = table.get_type() == "module"
            names |= {
                one.get_name() for one in table.get_symbols() if (one.is_referenced() if is_top else one.is_global())
            }
            for child in table.get_children():
                is_called = child.get_type() == "function" and not child.get_name().endswith(("comp", "genexpr"))
                tables.append((child, later if is_called else names))
        return frozenset(now), frozenset(later)


def statements_of(cells: list[Cell]) -> tuple[list[Statement], list[tuple[str, Exception]]]:
    """Return all top-level statements of the code cells, and the sources of cells that cannot be parsed with their errors.

    Examples
    --------
    >>> statements, broken = statements_of([Cell("a, b = 1, 2\\n!ls"), Cell("def f(:"), Cell("f = lambda x: a + x")])
    >>> [(sorted(one.binds), sorted(one.later)) for one in statements if one.binds]
    [(['a', 'b'], []), (['f'], ['a'])]
    >>> [source for source, _ in broken]
    ['def f(:']
    """
    statements, broken = [], []
    for number, cell in enumerate(cells):
        if cell.kind != "code" or not cell.source.strip():
            continue
        source = without_magics(cell.source)
        try:
            body = parse(source).body
        except PARSE_ERRORS as error:
            broken.append((source, error))
        else:
            statements += _statements_of_cell(body, lines_of(source), number)
    return statements, broken


def _statements_of_cell(body: list[ast.stmt], lines: list[str], number: int) -> list[Statement]:
    found = []
    for k, node in enumerate(body):
        first = min([node.lineno, *(one.lineno for one in getattr(node, "decorator_list", []))])
        if isinstance(node, ast.Import | ast.ImportFrom):
            for alias in node.names:
                one = type(node)(**{**dict(ast.iter_fields(node)), "names": [alias]})
                found.append(Statement(one, lines, number, first, frozenset([_imported(alias)])))
        else:
            shared = k > 0 and body[k - 1].end_lineno == first
            shared = shared or (k + 1 < len(body) and body[k + 1].lineno == node.end_lineno)
            found.append(Statement(node, lines, number, first, frozenset(_bound(node)), not shared))
    return found


def _segment(lines: list[str], node: ast.stmt) -> str:
    """The source of a statement that shares its lines; columns count bytes of UTF-8."""
    own = [line.encode() for line in lines[node.lineno - 1 : node.end_lineno]]
    own[-1] = own[-1][: node.end_col_offset]
    own[0] = own[0][node.col_offset :]
    return b"\n".join(own).decode()


def _receiver(node: ast.stmt) -> str | None:
    one = node.value if isinstance(node, ast.Expr) else None
    if not (isinstance(one, ast.Call) and isinstance(one.func, ast.Attribute)):
        return None
    while isinstance(one, ast.Call | ast.Attribute | ast.Subscript):
        one = one.func if isinstance(one, ast.Call) else one.value
    return one.id if isinstance(one, ast.Name) else None


def _imported(alias: ast.alias) -> str:
    return alias.asname or alias.name.partition(".")[0]


def _bound(node: ast.stmt) -> set[str]:
    """The names that a statement binds in the notebook, not those of functions and comprehensions inside it."""
    names, rest = set(), [node]
    while rest:
        one = rest.pop()
        if isinstance(one, _DEFINITIONS):
            names.add(one.name)
            continue
        if isinstance(one, _OWN_SCOPES) or (isinstance(one, ast.AnnAssign) and one.value is None):
            continue
        if isinstance(one, ast.Import | ast.ImportFrom):
            names |= {_imported(alias) for alias in one.names}
        if isinstance(one, ast.ExceptHandler | ast.MatchAs | ast.MatchStar) and one.name:
            names.add(one.name)
        if isinstance(one, ast.Name | ast.Subscript | ast.Attribute) and not isinstance(one.ctx, ast.Load):
            names |= {root.id for root in [_root(one)] if isinstance(root, ast.Name)}
        rest.extend(ast.iter_child_nodes(one))
    return names


def _root(node: ast.expr) -> ast.expr:
    while isinstance(node, ast.Subscript | ast.Attribute):
        node = node.value
    return node


def _targets(node: ast.stmt) -> list[ast.Name]:
    target = _root(node.target) if isinstance(node, ast.AugAssign) else None
    return [target] if isinstance(target, ast.Name) else []


def block_depth(tree: ast.AST) -> int:
    """Return how many functions, comprehensions and blocks stand inside each other, as the compiler counts or more.

    Examples
    --------
    >>> block_depth(parse("def f():\\n  for k in range(3):\\n    return [x for x in (lambda: ())()]"))
    4
    """
    deepest, rest = 0, [(tree, 0)]
    while rest:
        node, depth = rest.pop()
        depth += _blocks(node)
        deepest = max(deepest, depth)
        rest.extend((child, depth) for child in ast.iter_child_nodes(node))
    return deepest


def _blocks(node: ast.AST) -> int:
    if isinstance(node, ast.With | ast.AsyncWith):
        return len(node.items)
    if isinstance(node, ast.Try | ast.TryStar):
        return 3  # finally, handler and its name
    if isinstance(node, ast.ListComp | ast.SetComp | ast.DictComp | ast.GeneratorExp):
        return len(node.generators)
    return isinstance(node, (*_DEFINITIONS, ast.Lambda, ast.For, ast.AsyncFor, ast.While))
