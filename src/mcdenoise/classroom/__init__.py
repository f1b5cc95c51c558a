"""The classroom: exercises, their tests, checking and grading, the student's tree and the lecture site."""

from mcdenoise.classroom.check import check
from mcdenoise.classroom.diagnose import assert_matches
from mcdenoise.classroom.exercise import Finding, graded, picture

__all__ = ["Finding", "assert_matches", "check", "graded", "picture"]
