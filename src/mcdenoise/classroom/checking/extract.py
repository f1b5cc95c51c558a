"""Take an answer out of a notebook: the last binding of its name, and what that needs, as source. Nothing is run.

What is taken, and what is not:

- the last top-level binding of the exercise's name counts; of every other name the last one before its use;
- imports, functions, classes, assignments (also `+=`, and to an element or attribute), and whole `if` and `try`
  statements are taken, each only where the answer needs it, directly or through others;
- a variable is taken only where its value needs no more than literals, NumPy, Python's own modules, the given modules
  of mcdenoise, and other names taken by this rule. One made with anything else of mcdenoise (a rendered image, say), or
  bound by a loop, is no part of an answer: the student reads to use the function's arguments instead;
- a cell with a syntax error matters only where it is the cell of the answer.
"""

from __future__ import annotations

import ast
import difflib
import re
import sys
import warnings
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterator
from functools import lru_cache

from mcdenoise.classroom.checking.cells import PARSE_ERRORS, Cell, parse, parse_cells, read_cells
from mcdenoise.classroom.checking.finding import Finding
from mcdenoise.classroom.checking.implementation import place_in_source
from mcdenoise.classroom.checking.statements import BrokenCell, Statement, block_depth, statements_of

__all__ = ["Cell", "answer_source", "parse_cells", "read_cells"]

GIVEN = ("mcdenoise.filters.window", "mcdenoise.samples")  # what an answer may use of mcdenoise, also in grading
DEEPEST = 18  # blocks inside each other
MOST = 10_000  # steps from need to need; no sensible notebook comes near


def answer_source(cells: list[Cell], name: str) -> str:
    """Return the Python source of an answer: the last top-level binding of `name` with all that it needs, in order.

    A comment ``#@ line 3`` before each statement says where it stood in its cell (see `implementation.place`).

    Raises
    ------
    Finding
        If nothing binds the name, the cell that does has a syntax error, or the answer needs a variable or module that
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
    for cell, error in broken:
        if _seems_to_bind(cell.source, name) and (wanted is None or cell.number > statements[wanted].cell):
            raise Finding(_syntax_words(name, error))
    if wanted is None:
        raise Finding(_missing_words(name, statements))
    taken = needs.taken(wanted)
    future = [one for one in statements if isinstance(one.node, ast.ImportFrom) and one.node.module == "__future__"]
    chosen = dict.fromkeys([*future, *(statements[k] for k in sorted(taken))])
    source = "\n".join(f"#@ line {one.line}\n{one.source}" for one in chosen)
    _check_compiles(source, name)
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
def _parsed(sources: tuple[str, ...]) -> tuple[list[Statement], list[tuple[BrokenCell, Exception]]]:
    return statements_of([Cell(source) for source in sources])


class _Needs:
    """The walk from the answer to everything that it needs."""

    def __init__(self, statements: list[Statement], broken: list, name: str) -> None:
        self.statements, self.broken, self.name = statements, broken, name
        self.bindings: dict[str, list[int]] = defaultdict(list)
        for k, one in enumerate(statements):
            for bound in one.binds:
                self.bindings[bound].append(k)
        self.stars = [k for k in self.bindings["*"] if _is_allowed(statements[k].module)]

    def last(self, name: str, before: int) -> int | None:
        """Return the number of the last statement before `before` that binds the name."""
        numbers = self.bindings.get(name, [])
        k = bisect_left(numbers, before)
        return numbers[k - 1] if k else None

    def taken(self, wanted: int) -> set[int]:
        """Return the numbers of the statements to take.

        Each step is (statement, before, through): its functions see the bindings before statement `before`;
        `through` is the variable on the way, if any.
        """
        end = len(self.statements)
        steps, seen = [(wanted, end, self.name if self.statements[wanted].is_variable else "")], set()
        while steps:
            step = steps.pop()
            if step in seen:
                continue
            seen.add(step)
            if len(seen) > MOST:
                raise Finding(f"`{self.name}` needs too much of the notebook around it: use only its arguments.")
            k, before, through = step
            self._refuse(self.statements[k], through, running=before < end)
            for name, limit in self._names(k, before):
                found = self.last(name, limit)
                if found is None:
                    self._look_in_broken(name)
                    steps += [(star, limit, through) for star in self.stars if star < limit]
                else:
                    one = self.statements[found]
                    limit = (
                        limit if one.later or limit == end else found
                    )  # without functions of its own it sees no others
                    steps.append((found, limit, through or (name if one.is_variable else "")))
        return {k for k, _, _ in seen}

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

    def _refuse(self, statement: Statement, through: str, *, running: bool) -> None:
        """Raise Finding for a statement that no answer may need."""
        module = statement.module
        if module is not None:
            if running and _is_mcdenoise(statement):
                raise Finding(self._variable_words(through, "is made with mcdenoise"))
            if not _is_allowed(module):
                raise Finding(
                    f"`{self.name}` uses the module `{module}`: an answer may use NumPy and Python's own modules alone."
                )
        elif not statement.is_taken:
            raise Finding(self._variable_words(through, f"is bound by a {statement.kind}"))

    def _variable_words(self, variable: str, how: str) -> str:
        if variable == self.name:
            return f"`{self.name}` {how}: write the answer itself, with NumPy and plain numbers alone."
        if not variable:
            return f"`{self.name}` needs mcdenoise while it is defined: write it with NumPy alone."
        return (
            f"`{self.name}` uses the notebook's variable `{variable}`, which {how}: an answer may use only its arguments, "
            f"NumPy, and constants and functions of the notebook."
        )

    def _look_in_broken(self, name: str) -> None:
        for cell, error in self.broken:
            if _seems_to_bind(cell.source, name):
                raise Finding(_syntax_words(name, error))


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
