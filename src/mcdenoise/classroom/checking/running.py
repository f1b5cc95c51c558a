"""Run a test of an exercise on an answer; whatever goes wrong becomes words in an Outcome."""

from __future__ import annotations

import linecache
import re
import traceback
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mcdenoise.classroom.checking.describe import describe
from mcdenoise.classroom.checking.finding import NOT_ANSWERED, Unwritten


@dataclass(frozen=True)
class Outcome:
    """What one test said about an answer.

    Attributes
    ----------
    test : name of the test function. sentence : first line of its docstring, what holds when it passes.
    exercise, points, hidden : as marked by `graded`.
    passed : whether it holds. message : what is wrong, in words for the student; empty when passed.
    unwritten : the answer is still the empty exercise.
    """

    test: str
    sentence: str
    exercise: str
    points: float
    hidden: bool
    passed: bool
    message: str = ""
    unwritten: bool = False


def sentence_of(test: Callable) -> str:
    """Return the first line of a test's docstring, or its name in words."""
    lines = (test.__doc__ or "").strip().splitlines()
    return lines[0].strip() if lines else test.__name__.removeprefix("test_").replace("_", " ")


def run_test(test: Callable, impl: object) -> Outcome:
    """Run one test on one answer; whatever goes wrong becomes words in the outcome.

    Parameters
    ----------
    test : a function marked by `graded`.
    impl : LocalImplementation, the grader's proxy, or the plain value of an exercise that asks for a value.

    Examples
    --------
    >>> from mcdenoise.classroom import graded
    >>> from mcdenoise.classroom.checking.exercise import LocalImplementation
    >>> @graded("double", points=2)
    ... def test_double(impl):
    ...     "Twice the number."
    ...     assert impl(2) == 4, f"twice 2 is 4, yours is {impl(2)}"
    >>> run_test(test_double, LocalImplementation("double", lambda number: number + 1)).message
    'twice 2 is 4, yours is 3'
    """
    mark = test.graded
    message, unwritten = "", False
    try:
        if impl is None or impl is ...:
            raise Unwritten(NOT_ANSWERED)
        with np.errstate(all="ignore"):  # what a test computes from a wrong result
            test(impl)
    except (Exception, SystemExit) as error:
        message, unwritten = words_of(error, mark.exercise, impl), isinstance(error, Unwritten)
    return Outcome(test.__name__, sentence_of(test), *vars(mark).values(), not message, message, unwritten)


def words_of(error: Exception | SystemExit, exercise: str, impl: object) -> str:
    """Say in words for the student why a test of an exercise failed with this exception."""
    if isinstance(error, Unwritten):
        return str(error)
    warned = getattr(impl, "warned", "")
    if not isinstance(error, AssertionError):
        words = _unusable(exercise, impl, error)
    else:
        words = str(error) or f"this does not hold: {_failing_line(error)}"
    return f"{words} (NumPy warned: {warned}.)" if warned else words


def _failing_line(error: AssertionError) -> str:
    frame = traceback.extract_tb(error.__traceback__)[-1]
    return linecache.getline(frame.filename, frame.lineno).strip().removeprefix("assert ") or "a condition of the test"


def _unusable(exercise: str, impl: object, error: Exception) -> str:
    """Words for an exception in the test itself: the answer is not of the kind that the test can use."""
    if not callable(impl):
        if "not callable" in str(error):
            return f"`{exercise}` is no function but {describe(impl)}: was its name used again for a result?"
        return f"`{exercise}` is {describe(impl)}, which does not fit the question ({type(error).__name__}: {error})."
    if getattr(impl, "returned", ...) is ...:
        return f"`{exercise}` is a function; a value is asked for."
    if impl.returned is None:
        return "returned nothing (None): is the `return` missing?"
    wanted = re.search(r"values to unpack \(expected (\d+)", str(error)) or re.search(r"cannot unpack", str(error))
    if wanted:
        count = wanted.group(1) if wanted.groups() else "several"
        return f"returned {describe(impl.returned)}; {count} results are needed, separated by commas."
    return f"returned {describe(impl.returned)}, which does not fit ({type(error).__name__}: {error})."
