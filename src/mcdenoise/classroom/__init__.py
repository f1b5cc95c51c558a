"""The classroom: exercises, their tests, checking and grading, the student's tree and the lecture site."""

from mcdenoise.classroom.exercise import Finding, graded, picture

__all__ = ["Finding", "graded", "picture"]
