"""The classroom: exercises, their tests, checking and grading, the student's tree and the lecture site."""

from mcdenoise.classroom.checking.check import check
from mcdenoise.classroom.checking.diagnose import assert_matches
from mcdenoise.classroom.checking.exercise import Finding, graded, picture
from mcdenoise.classroom.checking.mistakes import as_numbers, as_parts, central_differences, name_mistake

__all__ = [
    "Finding",
    "as_numbers",
    "as_parts",
    "assert_matches",
    "central_differences",
    "check",
    "graded",
    "name_mistake",
    "picture",
]
