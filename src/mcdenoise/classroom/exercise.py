"""What a test of an exercise is: a function of one argument, `impl`, marked with the exercise's name and its points.

The same test serves three uses. `pytest` runs it on the reference, `check("name")` in a notebook on the student's
function, and the grader on a proxy that calls the student's function in another process.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


class Finding(AssertionError):
    """What is wrong with a student's answer, in words meant for the student."""


@dataclass(frozen=True)
class Graded:
    """The mark that `graded` leaves on a test: which exercise, how many points, hidden or public."""

    exercise: str
    points: float
    hidden: bool


def graded(exercise: str, *, points: float, hidden: bool = False) -> Callable:
    """Mark a test as part of an exercise.

    Parameters
    ----------
    exercise : name of the function (or value) that the student writes.
    points : what passing this test is worth, > 0.
    hidden : a hidden test stays with the instructor; a public one goes out with the notebook.

    Examples
    --------
    >>> @graded("double", points=2)
    ... def test_double(impl):
    ...     assert impl(2) == 4
    >>> test_double.graded
    Graded(exercise='double', points=2, hidden=False)
    """
    if not points > 0:
        raise ValueError(f"points must be above 0, got {points!r} for {exercise}.")

    def mark(test: Callable) -> Callable:
        test.graded = Graded(exercise, points, hidden)
        return test

    return mark


def picture(exercise: str) -> Callable:
    """Mark a function (impl) -> (yours, target) of two images: `check` shows them side by side with their difference."""

    def mark(function: Callable) -> Callable:
        function.picture = exercise
        return function

    return mark
