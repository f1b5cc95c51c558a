"""What a test of an exercise is: a function of one argument, `impl`, marked with the exercise's name and its points.

The same test serves three uses. `pytest` runs it on the reference, `check("name")` in a notebook on the student's
function, and the grader on a proxy that calls the student's function in another process.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from mcdenoise.classroom.checking.finding import Finding, Unwritten
from mcdenoise.classroom.checking.implementation import LocalImplementation, as_impl
from mcdenoise.classroom.checking.running import Outcome, run_test, sentence_of

__all__ = [
    "ExerciseTests",
    "Finding",
    "Graded",
    "LocalImplementation",
    "Outcome",
    "Unwritten",
    "as_impl",
    "graded",
    "load_tests",
    "picture",
    "run_test",
    "sentence_of",
]


@dataclass(frozen=True)
class Graded:
    """The mark that `graded` leaves on a test: which exercise, how many points, hidden or public."""

    exercise: str
    points: float
    hidden: bool


@dataclass(frozen=True)
class ExerciseTests:
    """The tests of one exercise, in the order of their file, and the functions that draw its picture."""

    name: str
    chapter: str
    tests: tuple[Callable, ...]
    pictures: tuple[Callable, ...]

    @property
    def points(self) -> float:
        """What all tests together are worth."""
        return sum(test.graded.points for test in self.tests)


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


def load_tests(place: Path | str) -> dict[str, ExerciseTests]:
    """Read the exercises of one test file, or of all `test_ch*.py` of a folder.

    Parameters
    ----------
    place : a file such as ``tests/exercises/test_ch02.py``, or the folder. It is run as a module of its own, that
        nothing else can import; nothing is written beside it.

    Returns
    -------
    Exercise name -> ExerciseTests, in the order of the files and of the definitions in them.

    Raises
    ------
    ValueError
        If there is no test file, a file does not run, or an exercise has tests in two files.
    """
    place = Path(place)
    files = sorted(place.glob("test_ch*.py")) if place.is_dir() else [place]
    if not files or not all(file.is_file() for file in files):
        raise ValueError(f"{place} holds no exercise tests: a file test_chNN.py is needed.")
    found: dict[str, ExerciseTests] = {}
    for file in files:
        for name, tests in _tests_of(file).items():
            if name in found:
                raise ValueError(
                    f"{file.name}: the exercise {name} already has tests in test_{found[name].chapter}.py."
                )
            found[name] = tests
    return found


def _tests_of(file: Path) -> dict[str, ExerciseTests]:
    module = ModuleType(f"_mcdenoise_exercises_{file.stem}")
    module.__file__ = str(file)
    try:
        exec(compile(file.read_bytes(), str(file), "exec"), vars(module))  # not imported: no file is written
    except (Exception, SystemExit) as error:
        raise ValueError(f"{file.name} does not run: {type(error).__name__}: {error}") from error
    functions = [
        one for one in vars(module).values() if callable(one) and getattr(one, "__module__", "") == module.__name__
    ]
    tests = [one for one in functions if hasattr(one, "graded")]
    return {
        name: ExerciseTests(
            name,
            file.stem.removeprefix("test_"),
            tuple(one for one in tests if one.graded.exercise == name),
            tuple(one for one in functions if getattr(one, "picture", None) == name),
        )
        for name in dict.fromkeys(one.graded.exercise for one in tests)
    }
