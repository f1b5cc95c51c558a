"""`check("name")`: run an exercise's public tests on the student's answer and say in words what holds and what is wrong."""

from __future__ import annotations

import difflib
import inspect
import io
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from mcdenoise.classroom.checking.exercise import ExerciseTests, as_impl, load_tests, run_test
from mcdenoise.classroom.checking.extract import Cell, answer_source
from mcdenoise.classroom.checking.finding import Finding
from mcdenoise.classroom.checking.report import Report, running_shell

STRICT = "MCDENOISE_STRICT"  # with this variable set to 1, a check that does not pass raises


def check(name: str, answer: object = None, *, tests: Path | str | None = None) -> Report:
    """Check an answer by the public tests of its exercise: what holds, what is wrong, how far off, and a picture.

    Takes about a second. In a notebook the report is displayed, elsewhere printed. A mistake in the answer raises
    nothing, except where the environment variable MCDENOISE_STRICT is 1.

    Parameters
    ----------
    name : of the exercise, which is also the name of the function or value in the notebook.
    answer : what to check instead of the notebook's own `name`, such as ``my_module.bilateral_sums``.
    tests : a file ``test_chNN.py`` or a folder of them. Default: ``tests/exercises`` beside the notebook or above it.

    Returns
    -------
    Report, with `passed`, `outcomes`, and the text as ``str(report)``.

    Raises
    ------
    Finding
        With MCDENOISE_STRICT=1, if not all tests pass.

    Examples
    --------
    >>> report = check("no_such_exercise", tests=".")
    no_such_exercise: . holds no exercise tests: a file test_chNN.py is needed.
    >>> report.passed
    False
    """
    namespace = inspect.currentframe().f_back.f_globals
    report = _checked(name, answer, tests, namespace)
    report.show()
    if os.environ.get(STRICT) == "1" and not report.passed:
        raise Finding(str(report))
    return report


def find_tests(start: Path) -> Path:
    """Return the folder ``tests/exercises`` beside `start` or above it.

    Raises
    ------
    ValueError
        If there is none with a file test_chNN.py in it.
    """
    start = Path(start).resolve()
    for folder in [start, *start.parents]:
        if any((folder / "tests" / "exercises").glob("test_ch*.py")):
            return folder / "tests" / "exercises"
    raise ValueError(
        f"no tests found: looked for tests/exercises/test_chNN.py in {start} and in the folders above it. Open the "
        f"notebook in the folder that it came in, or say where the tests are: check(..., tests=FOLDER)."
    )


def _checked(name: str, answer: object, tests: Path | str | None, namespace: Mapping) -> Report:
    if not isinstance(name, str):
        own = getattr(name, "__name__", "name")
        return Report(own, problem=f'the name belongs in quotes: `check("{own}")`.')
    try:
        exercise = _exercise(name, tests or find_tests(_folder_of(namespace)))
    except ValueError as error:
        return Report(name, problem=str(error))
    public = [test for test in exercise.tests if not test.graded.hidden]
    own = answer is None
    if own and name not in namespace:
        return Report(name, problem=f"`{name}` is not defined yet: run its cell first, then check again.")
    impl = as_impl(name, namespace[name] if own else answer)
    outcomes = tuple(run_test(test, impl) for test in public)
    written = not any(one.unwritten for one in outcomes)
    image = _picture(exercise, impl) if written and running_shell() is not None else None
    return Report(name, outcomes, notes=_notes(name) if own and written else (), image=image)


def _folder_of(namespace: Mapping) -> Path:
    """The folder of the notebook or script that calls: a kernel's working folder, unless the caller's file is known."""
    file = namespace.get("__vsc_ipynb_file__") or namespace.get("__file__")
    return Path(file).parent if file else Path.cwd()


def _exercise(name: str, tests: Path | str) -> ExerciseTests:
    exercises = load_tests(tests)
    if name in exercises:
        return exercises[name]
    near = difflib.get_close_matches(name, exercises, n=2)
    meant = f" Did you mean {' or '.join(f'`{one}`' for one in near)}?" if near else ""
    raise ValueError(f"there is no exercise of this name.{meant} The exercises are: {', '.join(exercises)}.")


def _picture(exercise: ExerciseTests, impl: object) -> bytes | None:
    """The student's image, the target and the difference as PNG; None if the answer is not fit to be seen."""
    for draw in exercise.pictures:
        try:
            from mcdenoise.study.show import show_difference

            with np.errstate(all="ignore"):
                figure = show_difference(*draw(impl))
        except (
            AssertionError,
            ArithmeticError,
            AttributeError,
            LookupError,
            TypeError,
            ValueError,
        ):  # see the outcomes
            return None
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=80)
        return stream.getvalue()
    return None


def _notes(name: str) -> tuple[str, ...]:
    """What would go wrong in grading though it works in this notebook: read from the cells run so far."""
    shell = running_shell()
    if shell is None:
        return ()
    try:
        answer_source([Cell(source) for source in shell.user_ns.get("In", [])], name)
    except Finding as finding:
        return (f"when graded, this will not work: {finding}",)
    return ()
