"""`mcdenoise classroom build | check | grade | release`: the classroom from the command line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mcdenoise.classroom.checking.exercise import ExerciseTests
    from mcdenoise.classroom.checking.report import Report

PASSED, NOT_PASSED = 0, 1


def add_commands(commands: argparse._SubParsersAction) -> None:
    """Add `classroom` and its own commands to the parser's commands."""
    from mcdenoise.classroom.grading.grade import add_arguments

    classroom = commands.add_parser("classroom", help="build, check, grade and release the exercises")
    actions = classroom.add_subparsers(dest="action", required=True, metavar="ACTION")
    build = actions.add_parser(
        "build",
        help="build the student tree, the solutions and nbgrader's course",
        description="Build from notebooks/ and tests/exercises/: student/ (stubs, public tests), solution/ (the same "
        "notebooks with solutions) and nbgrader/ (a course). Students' trees are searched for solutions and hidden tests.",
    )
    _add_places(build, "out/classroom")
    check = actions.add_parser(
        "check",
        help="run the public tests on a notebook or module",
        description="Run the public tests on the answers in FILE and say what holds and what does not. Exit code 0: all "
        "hold; 1: not all; 2: wrong call.",
    )
    check.add_argument("file", type=Path, metavar="FILE", help="a notebook (.ipynb) or Python file (.py)")
    check.add_argument("exercises", nargs="*", metavar="EXERCISE", help="exercises to check (default: all in FILE)")
    grade = actions.add_parser("grade", help="grade a folder of submissions out of process")
    add_arguments(grade)
    release = actions.add_parser(
        "release",
        help="write archives for students",
        description="Write one zip a chapter, one of all chapters, and their SHA-256 sums; always the same bytes.",
    )
    _add_places(release, "out/release")


def _add_places(parser: argparse.ArgumentParser, out: str) -> None:
    parser.add_argument("--out", type=Path, default=Path(out), metavar="DIR", help=f"folder to write (default {out})")
    parser.add_argument("--root", type=Path, metavar="DIR", help="clone of the repository (default: where you are)")


def run(options: argparse.Namespace) -> int:
    """Run the chosen command; returns the exit code.

    Raises
    ------
    ValueError
        For what cannot be done, in words for the command line (one line, exit code 2).
    """
    if options.action == "grade":
        from mcdenoise.classroom.grading.grade import run_grade

        return run_grade(options)
    if options.action == "check":
        return run_check(options.file, options.exercises)
    from mcdenoise.classroom.building.chapters import find_root

    root = find_root(options.root)
    if options.action == "build":
        return run_build(root, options.out)
    from mcdenoise.classroom.building.release import SUMS, release

    archives = release(root, options.out)
    for path in archives:
        print(path)
    print(f"Their SHA-256 sums stand in {options.out / SUMS}.")
    return PASSED


def run_build(root: Path, out: Path) -> int:
    """Run `mcdenoise classroom build`: build, and print what each chapter holds."""
    from mcdenoise.classroom.building.build import build

    for chapter in build(root, out):
        exercises = dict.fromkeys(mark.exercise for mark in chapter.marks)
        hidden = sum(mark.hidden for mark in chapter.marks)
        print(
            f"{chapter.name}: {len(exercises)} exercises, {sum(mark.points for mark in chapter.marks):g} points, "
            f"{len(chapter.marks) - hidden} public and {hidden} hidden tests"
        )
    print(f"Wrote {out}. Start with {out / 'student' / 'README.md'}.")
    return PASSED


def run_check(file: Path, exercises: Sequence[str]) -> int:
    """Run `mcdenoise classroom check`: print a report for each exercise; 0 if all hold, else 1.

    Parameters
    ----------
    file : a notebook or Python file; its code runs in this process. The tests are beside it or above it.
    exercises : which to check. By default those of the chapter that the file's name begins with, or else all that the
        file has an answer to.

    Raises
    ------
    ValueError
        If there is no such file, no tests for it, or no such exercise.
    """
    from mcdenoise.classroom.checking.check import find_tests
    from mcdenoise.classroom.checking.exercise import load_tests
    from mcdenoise.classroom.checking.extract import read_cells

    cells = read_cells(file)
    tests = load_tests(find_tests(file.absolute().parent))
    if unknown := [name for name in exercises if name not in tests]:
        raise ValueError(f"There is no exercise {unknown[0]!r}. The exercises are {', '.join(tests)}.")
    chosen = exercises or [name for name, one in tests.items() if file.name.startswith(one.chapter)]
    chosen = chosen or [name for name in tests if any(name in cell.source for cell in cells)]
    if not chosen:
        raise ValueError(f"{file.name} has no answer to any of the exercises {', '.join(tests)}. Name another file.")
    reports = [_report(file, tests[name]) for name in chosen]
    print("\n".join(map(str, reports)))
    return PASSED if all(report.passed for report in reports) else NOT_PASSED


def _report(file: Path, exercise: ExerciseTests) -> Report:
    """Check one exercise of a file."""
    from mcdenoise.classroom.checking.exercise import as_impl, run_test
    from mcdenoise.classroom.checking.finding import Finding
    from mcdenoise.classroom.checking.pytest_plugin import load_answer
    from mcdenoise.classroom.checking.report import Report

    try:
        impl = as_impl(exercise.name, load_answer(file, exercise.name))
    except Finding as finding:
        return Report(exercise.name, problem=str(finding))
    return Report(exercise.name, tuple(run_test(test, impl) for test in exercise.tests if not test.graded.hidden))
