"""Take an answer out of a notebook: the last binding of its name, and what that needs, as source. Nothing is run.

What is taken, and what is not:

- the last top-level binding of the exercise's name counts; of every other name the last one before its use;
- a name that a function uses may be bound again below the answer by what no answer may use (such as a loop that tries
  things out): then its binding before that counts. The name of an import stays that of the import;
- imports, functions, classes, assignments (also `+=`, and to an element or attribute), calls of a variable's methods
  (such as ``table.append(2)``), and whole `if` and `try` statements are taken, each only where the answer needs it,
  directly or through others;
- a variable is taken only where its value needs no more than literals, NumPy, Python's own modules, the given modules
  of mcdenoise, and other names taken by this rule. One made with anything else of mcdenoise (a rendered image, say), or
  bound by a loop, is no part of an answer: the student reads to use the function's arguments instead;
- a cell with a syntax error never ran: it matters only where no other cell binds what it seems to bind.
"""

from __future__ import annotations

import ast
import difflib
import re
import sys
import warnings
from bisect import bisect_left, bisect_right
from collections import defaultdict
from collections.abc import Iterator
from functools import lru_cache

from mcdenoise.classroom.checking.cells import PARSE_ERRORS, Cell, parse, parse_cells, read_cells
from mcdenoise.classroom.checking.finding import Finding
from mcdenoise.classroom.checking.implementation import place_in_source
from mcdenoise.classroom.checking.statements import Statement, block_depth, statements_of

__all__ = ["Cell", "answer_source", "parse_cells", "read_cells"]

GIVEN = ("mcdenoise.filters.window",)  # what an answer may use of mcdenoise, also in grading
DEEPEST = 18  # blocks inside each other
MOST = 10_000  # steps from need to need; no sensible notebook comes near
MOST_PASSED_OVER = 100


def answer_source(cells: list[Cell], name: str) -> str:
    """Return the Python source of an answer: the last top-level binding of `name` with all that it needs, in order.

    A comment ``#@ line 3`` before each statement says where it stood in its cell (see `implementation.place`).

    Raises
    ------
    Finding
        If nothing binds the name, the only cell that does has a syntax error, or the answer needs a variable or module that
        an answer may not use. The words are meant for the student.

    Examples
    --------
    >>> cells = [Cell("import numpy as np, sys"), Cell("k = 2\\nk.real\\ndef f(x):\\n    return np.abs(k * x)"), Cell("f(3)")]
    >>> print(answer_source(cells, "f"))
    #@ line 1
    import numpy as np
    #@ line 1
    k = 2
    #@ line 3
    def f(x):
        return np.abs(k * x)
    """
    statements, broken = _parsed(tuple(cell.source if cell.kind == "code" else "" for cell in cells))
    needs = _Needs(statements, broken, name)
    wanted = needs.last(name, len(statements))
    if wanted is None:
        needs.look_in_broken(name)
        raise Finding(_missing_words(name, statements))
    taken = needs.taken(wanted)
    future = [one for one in statements if isinstance(one.node, ast.ImportFrom) and one.node.module == "__future__"]
    chosen = dict.fromkeys([*future, *(statements[k] for k in sorted(taken))])
    source = "\n".join(f"#@ line {one.line}\n{one.source}" for one in chosen)
    _check_compiles(source, name)
    _check_library(source, name)
    return source


def _check_compiles(source: str, name: str) -> None:
    """Raise Finding for what only the compiler finds, such as a `break` outside a loop."""
    try:
        if block_depth(parse(source)) > DEEPEST:  # CPython 3.12 and 3.13 crash on 21 blocks with comprehensions
            raise RecursionError
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            compile(source, "<answer>", "exec", dont_inherit=True)
    except SyntaxError as error:
        place = place_in_source(source, error.lineno or 1)
        raise Finding(f"`{name}` has a syntax error ({error.msg}) in {place}") from None
    except PARSE_ERRORS:
        raise Finding(f"`{name}` is nested too deeply for Python.") from None


@lru_cache(maxsize=4)  # one notebook is asked for many exercises
def _parsed(sources: tuple[str, ...]) -> tuple[list[Statement], list[tuple[str, Exception]]]:
    return statements_of([Cell(source) for source in sources])


class _Needs:
    """The walk from the answer to everything that it needs."""

    def __init__(self, statements: list[Statement], broken: list, name: str) -> None:
        self.statements, self.broken, self.name = statements, broken, name
        self.bindings: dict[str, list[int]] = defaultdict(list)
        for k, one in enumerate(statements):
            for bound in one.binds | self._changed(one):
                self.bindings[bound].append(k)
        self.passed_over: set[int] = set()  # bindings below the answer that it may not use
        self.steps = 0
        self.stars = [k for k in self.bindings["*"] if _is_allowed(statements[k].module)]

    def _changed(self, statement: Statement) -> set[str]:
        """The variable that a call of its method may change; calls of functions of a module change no variable."""
        numbers = self.bindings.get(statement.changes, []) if statement.changes else []
        last = self.statements[numbers[-1]] if numbers else None
        return {statement.changes} if last is not None and last.is_variable and not last.imports else set()

    def last(self, name: str, before: int) -> int | None:
        """Return the number of the last statement before `before` that binds the name."""
        numbers = self.bindings.get(name, [])
        k = bisect_left(numbers, before)
        return numbers[k - 1] if k else None

    def _last_of_all(self, name: str, below: int) -> int | None:
        """Return the number of the binding that a function sees when the answer is used, the cells below it included.

        Of the bindings from statement `below` on, some do not count: see the head of this module.
        """
        above = self.last(name, below)
        is_import = above is not None and self.statements[above].module is not None
        for k in reversed(self.bindings.get(name, [])):
            if k < below or not (k in self.passed_over or (is_import and self.statements[k].is_variable)):
                return k
        return None

    def taken(self, wanted: int) -> set[int]:
        """Return the numbers of the statements to take."""
        cell = self.statements[wanted].cell
        below = bisect_right(self.statements, cell, key=lambda one: one.cell)
        while True:
            numbers, refusal, instead = self._walk(wanted, below)
            if refusal is None:
                return numbers
            if instead is None or len(self.passed_over) >= MOST_PASSED_OVER:
                raise refusal
            self.passed_over.add(instead)

    def _walk(self, wanted: int, below: int) -> tuple[set[int], Finding | None, int | None]:
        """Return the statements walked through; the refusal that ended the walk; the binding to pass over then.

        Each step is (statement, before, through): its functions see the bindings before statement `before`;
        `through` is the variable on the way, if any. Beside each stands the last binding on the way that lies below the
        answer and has another one before it.
        """
        end = len(self.statements)
        steps, seen = [((wanted, end, self.name if self.statements[wanted].is_variable else ""), None)], set()
        while steps:
            step, replaceable = steps.pop()
            if step in seen:
                continue
            seen.add(step)
            self._count()
            k, before, through = step
            refusal = self._refusal(self.statements[k], through, running=before < end)
            if refusal is not None:
                return set(), refusal, replaceable
            for name, limit in self._names(k, before):
                found = self._last_of_all(name, below) if limit == end else self.last(name, limit)
                if found is None:
                    self.look_in_broken(name)
                    steps += [((star, limit, through), replaceable) for star in self.stars if star < limit]
                    continue
                one = self.statements[found]
                is_replaceable = limit == end and found >= below and self.last(name, found) is not None
                limit = limit if one.later or limit == end else found  # without functions of its own it sees no others
                way = through or (name if one.is_variable else "")
                steps.append(((found, limit, way), found if is_replaceable else replaceable))
        return {k for k, _, _ in seen}, None, None

    def _count(self) -> None:
        self.steps += 1
        if self.steps > MOST:
            raise Finding(f"`{self.name}` needs too much of the notebook around it: use only its arguments.")

    def _names(self, k: int, before: int) -> Iterator[tuple[str, int]]:
        """The names that a statement needs, each with the statement before which it must be bound."""
        statement, end = self.statements[k], len(self.statements)
        for name in statement.now:
            yield name, k
        for name in statement.later:
            yield name, end
            if before < end:  # called while the answer is loaded
                yield name, before
        if statement.is_conditional:  # an earlier binding may stay
            yield from ((name, k) for name in statement.binds if self.last(name, k) is not None)

    def _refusal(self, statement: Statement, through: str, *, running: bool) -> Finding | None:
        """The words to a student whose answer needs what no answer may need."""
        module = statement.module
        if module is None:
            is_taken = statement.is_taken
            return None if is_taken else Finding(self._variable_words(through, f"is bound by a {statement.kind}"))
        if running and _is_mcdenoise(statement):
            return Finding(self._variable_words(through, "is made with mcdenoise"))
        if _is_allowed(module):
            return None
        return Finding(
            f"`{self.name}` uses the module `{module}`: an answer may use NumPy and Python's own modules alone."
        )

    def _variable_words(self, variable: str, how: str) -> str:
        if variable == self.name:
            return f"`{self.name}` {how}: write the answer itself, with NumPy and plain numbers alone."
        if not variable:
            return f"`{self.name}` needs mcdenoise while it is defined: write it with NumPy alone."
        return (
            f"`{self.name}` uses the notebook's variable `{variable}`, which {how}: an answer may use only its arguments, "
            f"NumPy, and constants and functions of the notebook."
        )

    def look_in_broken(self, name: str) -> None:
        for source, error in self.broken:
            if _seems_to_bind(source, name):
                raise Finding(_syntax_words(name, error))


def _check_library(source: str, name: str) -> None:
    """Raise Finding where the answer calls a function of mcdenoise's front door: it is not there when it is graded."""
    import mcdenoise

    nodes = list(ast.walk(parse(source)))
    imports = [one for one in nodes if isinstance(one, ast.Import)]
    doors = {alias.asname or alias.name for one in imports for alias in one.names if alias.name == "mcdenoise"}
    used = {
        one.attr
        for one in nodes
        if isinstance(one, ast.Attribute) and isinstance(one.value, ast.Name) and one.value.id in doors
    }
    for one in nodes:
        if isinstance(one, ast.ImportFrom) and one.module == "mcdenoise":
            used |= {alias.name for alias in one.names}
    if refused := sorted(used & set(mcdenoise.__all__)):
        raise Finding(f"`{name}` uses mcdenoise.{refused[0]}, which is not there when it is graded: write it yourself.")


def _is_allowed(module: str) -> bool:
    root = module.partition(".")[0]
    return root in ("numpy", "mcdenoise") or root in sys.stdlib_module_names


def _is_mcdenoise(statement: Statement) -> bool:
    """Whether an import brings in a part of mcdenoise that is not given to the student while grading."""
    full = f"{statement.module}.{statement.node.names[0].name}." if isinstance(statement.node, ast.ImportFrom) else ""
    names = (f"{statement.module}.", full)
    return statement.module.partition(".")[0] == "mcdenoise" and not any(
        name.startswith(f"{given}.") for name in names for given in GIVEN
    )


def _seems_to_bind(source: str, name: str) -> bool:
    """Whether a cell that cannot be parsed looks as if it bound the name at top level."""
    if name not in source:
        return False
    name = re.escape(name)
    forms = rf"((async +)?def|class) +{name}\b|{name} *(:[^=\n]*)?=(?!=)|(from|import) .*\b{name}\b"
    return bool(re.search(f"^({forms})", source, re.MULTILINE))


def _syntax_words(name: str, error: Exception) -> str:
    if not isinstance(error, SyntaxError):
        return f"the cell of `{name}` cannot be read by Python ({type(error).__name__})."
    line = (error.text or "").strip()
    return (
        f"the cell of `{name}` has a syntax error ({error.msg}) in line {error.lineno}{f': `{line}`' if line else ''}"
    )


def _missing_words(name: str, statements: list[Statement]) -> str:
    names = sorted({bound for one in statements for bound in one.binds})
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.75)
    return f"`{name}` is not in the notebook{f'; it has `{near[0]}`: was it renamed?' if near else '.'}"
