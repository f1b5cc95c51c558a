"""Short words for a value: what kind of thing it is, and how large."""

from __future__ import annotations

import numpy as np


def describe(value: object) -> str:
    """Say in a few words what a value is.

    Examples
    --------
    >>> describe(np.zeros((2, 3))), describe((1.5, None)), describe(print)
    ('an array of shape (2, 3)', 'a tuple of 2 (the number 1.5, None)', 'the function `print`')
    """
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    if value is None or isinstance(value, bool | np.bool_):
        return str(value)
    if isinstance(value, int | float | complex | np.number):
        return f"the number {value:.6g}"
    if isinstance(value, str):
        return f"the text {_short(repr(value))}"
    if isinstance(value, tuple | list):
        kind = type(value).__name__
        inside = f" ({', '.join(describe(one) for one in value)})" if 0 < len(value) <= 3 else ""
        return f"a {kind} of {len(value)}{inside}"
    if isinstance(value, dict):
        return f"a dict with the keys {_short(', '.join(map(str, value)))}"
    if callable(value):
        return f"the function `{getattr(value, '__name__', type(value).__name__)}`"
    return f"an object of type {type(value).__name__}"


def _short(text: str, limit: int = 60) -> str:
    return text if len(text) <= limit else text[: limit - 3] + "..."


def number(value: float) -> str:
    """Write a number with four digits, as a student reads it.

    Examples
    --------
    >>> number(0.1234567), number(2.0), number(1e-9)
    ('0.1235', '2', '1e-09')
    """
    return f"{value:.4g}"


def count(amount: int, noun: str) -> str:
    """Say how many of something.

    Examples
    --------
    >>> count(1, "entry"), count(3, "pixel")
    ('1 entry', '3 pixels')
    """
    plural = noun[:-1] + "ies" if noun.endswith("y") else noun + "s"
    return f"{amount} {noun if amount == 1 else plural}"


def index(entry: object) -> str:
    """Write an index as a student would.

    Examples
    --------
    >>> index(np.array([8, 9])), index((4,))
    ('(8, 9)', '4')
    """
    entry = tuple(int(k) for k in entry)
    return str(entry[0]) if len(entry) == 1 else str(entry)
