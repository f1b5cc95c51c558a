"""What a check finds out, in words meant for the student."""

from __future__ import annotations


class Finding(AssertionError):
    """What is wrong with a student's answer, in words meant for the student."""


class Unwritten(Finding):
    """The answer is still the empty exercise."""


NOT_WRITTEN = "not written yet."
NOT_ANSWERED = "not answered yet."
