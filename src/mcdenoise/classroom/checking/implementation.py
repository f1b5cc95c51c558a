"""What a test calls: the student's function behind a guard that watches its inputs and turns errors into words.

The grader's child process runs this file too, with `describe` and `finding` alone beside it: it imports no more of
mcdenoise than these.
"""

from __future__ import annotations

import contextlib
import inspect
import io
import linecache
import re
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator

import numpy as np

from mcdenoise.classroom.checking.describe import describe
from mcdenoise.classroom.checking.finding import NOT_WRITTEN, Finding, Unwritten

SECONDS = 10.0  # of one call
PRINTED = 2000  # characters of the student's own prints that one check shows


class LocalImplementation:
    """A student's function, called in this process.

    Attributes
    ----------
    returned : what the last call returned.
    warned : the last call's first NumPy warning with its line, or "".

    Examples
    --------
    >>> half = LocalImplementation("half", lambda number: number / 2)
    >>> half(3)
    1.5
    >>> half("three")
    Traceback (most recent call last):
    ...
    mcdenoise.classroom.checking.finding.Finding: stopped with TypeError: unsupported operand type(s) for /: 'str' and 'int'...
    """

    def __init__(self, name: str, function: Callable, *, seconds: float = SECONDS) -> None:
        self.name, self.function, self.seconds = name, function, seconds
        self.returned: object = ...
        self.warned = ""
        self._printed = _Capped(PRINTED)
        self._too_slow = ""

    def __call__(self, *arguments: object, **keywords: object) -> object:
        """Call the student's function; raises Finding for whatever is wrong with how it runs."""
        if self._too_slow:  # once is enough: the other tests need not wait as long
            raise Finding(self._too_slow)
        named = _named(self.name, self.function, arguments, keywords)
        before = {name: _bits(value) for name, value in named.items()}
        self.returned, self.warned = None, ""
        with warnings.catch_warnings(record=True) as caught, contextlib.redirect_stdout(self._printed):
            warnings.simplefilter("always")
            self.returned = self._run(arguments, keywords)
        self.warned = _first_warning(caught, self.function)
        for name, value in named.items():
            if _bits(value) != before[name]:
                raise modified_finding(name)
        return self.returned

    def _run(self, arguments: tuple, keywords: dict) -> object:
        try:
            with time_limit(self.seconds), np.errstate(all="warn", under="ignore"):
                return self.function(*arguments, **keywords)
        except TooSlowError:
            self._too_slow = too_slow_message(self.seconds, [*arguments, *keywords.values()])
            raise Finding(self._too_slow) from None
        except Finding:
            raise
        except (Exception, SystemExit) as error:
            raise finding_of(error, self.function) from error


def as_impl(name: str, answer: object) -> object:
    """Return what a test is handed: a LocalImplementation for a function, the value itself for a value."""
    return LocalImplementation(name, answer) if callable(answer) else answer


def error_finding(kind: str, text: str, where: str = "") -> Finding:
    """Words for an exception of the student's code; the grader uses the same.

    Parameters
    ----------
    kind : name of the exception's type. text : its message. where : ``line 3: `total = imge` ``, from `place`.

    Examples
    --------
    >>> error_finding("NameError", "name 'imge' is not defined", "line 3: `total = imge`")
    Finding("stopped with NameError: name 'imge' is not defined, in line 3: `total = imge`")
    >>> error_finding("NotImplementedError", "")
    Unwritten('not written yet.')
    """
    if kind == "NotImplementedError":
        return Unwritten(NOT_WRITTEN)
    where = f", in {where}" if where else ""
    if kind == "RecursionError":
        return Finding(f"calls itself without end (RecursionError){where}")
    if kind == "MemoryError":
        return Finding(f"asks for more memory than there is (MemoryError){where}")
    if kind == "SystemExit":
        return Finding(f"ends the whole program (SystemExit){where}: use `return` to leave a function")
    text = " ".join(text.split())
    text = text if len(text) <= 300 else text[:297] + "..."
    return Finding(f"stopped with {kind}{': ' if text else ''}{text}{where}")


def modified_finding(argument: str) -> Finding:
    """Words for a function that changed one of its arguments.

    Examples
    --------
    >>> modified_finding("image")
    Finding('modified its input `image`: work on a copy (`image = image.copy()`).')
    """
    return Finding(f"modified its input `{argument}`: work on a copy (`{argument} = {argument}.copy()`).")


def too_slow_message(seconds: float, values: list) -> str:
    """Words for a call that did not come back.

    Examples
    --------
    >>> too_slow_message(10, [np.zeros((24, 24, 3)), 2.0])
    'more than 10 s on an array of shape (24, 24, 3): is there an endless loop?'
    """
    arrays = [value for value in values if isinstance(value, np.ndarray)]
    largest = f" on {describe(max(arrays, key=np.size))}" if arrays else ""
    return f"more than {seconds:g} s{largest}: is there an endless loop?"


def finding_of(error: Exception | SystemExit, function: Callable) -> Finding:
    """Turn an exception of the student's code into words, with the student's own line."""
    try:
        text = str(error)
    except Exception:  # an exception class of the student's own, without words
        text = ""
    return error_finding(type(error).__name__, text, _own_line(error, function))


def _own_line(error: Exception | SystemExit, function: Callable) -> str:
    """Where in the student's own code it happened: the deepest frame that shares the function's global names."""
    own = getattr(inspect.unwrap(function), "__globals__", None)
    frames = [
        (frame.f_code.co_filename, line)
        for frame, line in traceback.walk_tb(error.__traceback__)
        if frame.f_globals is own
    ]
    return place(*frames[-1]) if frames else ""


def place(filename: str, line: int) -> str:
    """Name a line of a student's code as the student sees it: its number in the cell, and its text.

    Code made by `extract.answer_source` says by its ``#@ line 3`` comments where each statement stood in its cell.
    """
    lines = linecache.getlines(filename)
    text = lines[line - 1].strip() if 0 < line <= len(lines) else ""
    return _place_in(lines, line, text)


def place_in_source(source: str, line: int) -> str:
    """As `place`, for source text: the grader gets the number of the line back from the other process.

    Examples
    --------
    >>> place_in_source("#@ line 7\\ndef f(x):\\n    return y", 3)
    'line 8: `return y`'
    """
    lines = source.splitlines()
    return _place_in(lines, line, lines[line - 1].strip() if 0 < line <= len(lines) else "")


def _place_in(lines: list[str], line: int, text: str) -> str:
    for above in range(min(line, len(lines)) - 1, -1, -1):
        if mark := re.match(r"#@ line (\d+)", lines[above]):
            line = int(mark.group(1)) + line - above - 2
            break
    return f"line {line}: `{text}`" if text else f"line {line}"


class TooSlowError(BaseException):
    """Time is up. No Exception, so that the student's own `except Exception` does not catch it."""


@contextlib.contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise TooSlowError after so many seconds; without effect outside the main thread and where there are no timers."""
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "setitimer"):
        yield
        return

    def stop(number: int, frame: object) -> None:
        raise TooSlowError

    earlier = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds, 1.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, earlier)


class _Capped(io.TextIOBase):
    """What the student's function prints, passed on up to a limit."""

    def __init__(self, limit: int) -> None:
        self._left, self._out = limit, sys.stdout

    def write(self, text: str) -> int:
        if self._left > 0:
            self._out.write(text[: self._left])
            if len(text) > self._left:
                self._out.write("\n... (the rest of your prints is not shown)\n")
        self._left -= len(text)
        return len(text)


def _named(name: str, function: Callable, arguments: tuple, keywords: dict) -> dict[str, object]:
    """The arguments under the student's names for them."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # builtins without a signature
        return {f"argument {k}": value for k, value in enumerate(arguments, 1)} | keywords
    try:
        return dict(signature.bind(*arguments, **keywords).arguments)
    except TypeError as error:
        raise Finding(
            f"`{name}{signature}` cannot be called as the exercise asks ({error}): keep the names and the order of its "
            f"arguments."
        ) from None


def _bits(value: object) -> object:
    """Something equal only for bitwise equal values: NaN equals NaN, -0 differs from 0."""
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, value.tobytes()
    if isinstance(value, tuple | list):
        return [_bits(one) for one in value]
    if isinstance(value, dict):
        return {key: _bits(one) for key, one in value.items()}
    return repr(value)


def _first_warning(caught: list[warnings.WarningMessage], function: Callable) -> str:
    for warning in caught:
        if issubclass(warning.category, RuntimeWarning):
            own = getattr(inspect.unwrap(function), "__code__", None)
            inside = own is not None and own.co_filename == warning.filename
            return f"{warning.message}{', ' + place(warning.filename, warning.lineno) if inside else ''}"
    return ""
