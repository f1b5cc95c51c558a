"""A student's answer in a process of its own: what a test of the grader calls in place of the function."""

from __future__ import annotations

import contextlib
import signal
import threading
import time
from collections.abc import Iterator

from mcdenoise.classroom.checking.finding import Finding, Unwritten
from mcdenoise.classroom.grading import wire
from mcdenoise.classroom.grading.process import PRINTED, ChildProcess, NoAnswerError
from mcdenoise.classroom.grading.sandbox import Limits

DEATHS = 3
GRACE = 2.0  # seconds beyond the limit that the child keeps itself, before it is killed
UNREADABLE = "sent the grader something it cannot read"
LONGEST = 2000  # characters of a finding that come from the child

_turn = threading.Lock()
_mine = threading.local()


@contextlib.contextmanager
def turn() -> Iterator[None]:
    """Let one thread of this process at a time run tests; it gives way while a student's function runs.

    Tests may call the library's parallel kernels, which not every threading layer allows from two threads at once. They
    take little time beside the students' functions, so that nothing is lost.
    """
    with _turn:
        _mine.held = True
        try:
            yield
        finally:
            _mine.held = False


@contextlib.contextmanager
def _others_turn() -> Iterator[None]:
    """Give way inside `turn`, and take the turn again at the end; nothing to do outside."""
    held = getattr(_mine, "held", False)
    if held:
        _turn.release()
    try:
        yield
    finally:
        if held:
            _turn.acquire()


class Budget:
    """The seconds that are left to a submission.

    Examples
    --------
    >>> budget = Budget(60)
    >>> budget.spend(59.5)
    >>> budget.left
    0.5
    """

    def __init__(self, seconds: float) -> None:
        self.seconds = self.left = seconds

    def spend(self, seconds: float) -> None:
        """Take off what a call took."""
        self.left -= seconds


class RemoteAnswer:
    """The answer to one exercise, run in a child process that is started when first needed, and again after a death.

    Parameters
    ----------
    name : of the exercise. source : everything that it needs, from `extract.answer_source`.
    limits, sandbox : of the process ("bwrap" or "fence"). budget : of the whole submission.

    Attributes
    ----------
    trouble : what went wrong that is no fault of the answer (no process could be started), or None.
    """

    def __init__(self, name: str, source: str, limits: Limits, sandbox: str, budget: Budget) -> None:
        self.name, self.source, self.limits, self.sandbox, self.budget = name, source, limits, sandbox, budget
        self.trouble: Exception | None = None
        self._child: ChildProcess | None = None
        self._loaded: dict = {}
        self._printed = b""
        self._deaths = self._asked = 0
        self._given_up: Finding | None = None

    def __enter__(self) -> RemoteAnswer:
        return self

    def __exit__(self, *details: object) -> None:
        self.close()

    @property
    def printed(self) -> str:
        """The first bytes of what the answer printed, in all its processes."""
        data = self._printed + (self._child.printed if self._child else b"")
        return data[:PRINTED].decode("utf-8", "replace")

    def impl(self) -> object:
        """Return what a test is handed: a RemoteImplementation for a function, the value for a value.

        Raises
        ------
        Finding
            If the answer cannot be loaded, or has ended its process too often.
        """
        self._start()
        return RemoteImplementation(self) if self._loaded.get("kind") == "function" else self._loaded["value"]

    def call(self, arguments: tuple, keywords: dict) -> dict:
        """Call the function in the child: a reply with the "result" or a "finding"; raises Finding if it died."""
        self._start()
        reply = self._ask({"arguments": arguments, "keywords": keywords})
        if "finding" not in reply and "result" not in reply:
            raise self._died(UNREADABLE)
        return reply

    def close(self) -> None:
        """End the process."""
        if self._child is not None:
            self._child.kill()
            self._printed = (self._printed + self._child.printed)[:PRINTED]
            self._child = None

    def _start(self) -> None:
        if self._given_up is not None:
            raise self._given_up
        if self._child is not None:
            return
        try:
            self._child = ChildProcess(self.sandbox, self.limits)
        except (OSError, RuntimeError) as error:
            self.trouble = error
            raise
        try:
            self._loaded = self._ask({"source": self.source, "name": self.name})
            raise_finding(self._loaded)
            if self._loaded.get("kind") != "function" and "value" not in self._loaded:
                raise self._died(UNREADABLE)
        except Finding as finding:
            self._given_up = finding
            raise

    def _ask(self, request: dict) -> dict:
        """Send a request with a number of its own; whatever fails is a death of the child."""
        self._asked += 1
        try:
            frame = wire.pack({**request, "id": self._asked})
        except wire.WireError as error:
            self.trouble = TypeError(f"a test hands over {error}: only arrays, numbers, text and lists of these cross")
            raise self.trouble from error
        most = min(self.limits.seconds + GRACE, self.budget.left)
        if most <= 0:
            raise Finding(f"the {self.budget.seconds:g} s for the whole notebook were used up before this.")
        begin = time.monotonic()
        try:
            reply = self._child.ask(frame, most)
        except NoAnswerError:
            words = f"gave no answer within {self.limits.seconds:g} s: is there an endless loop?"
            raise self._died(words, DEATHS) from None  # once is enough: the other tests need not wait as long
        except wire.Ended:
            raise self._died(words_for_exit(self._child.exit_code(), self.limits)) from None
        except wire.WireError:
            raise self._died(UNREADABLE) from None
        finally:
            self.budget.spend(time.monotonic() - begin)
        if not isinstance(reply, dict) or reply.get("id") != self._asked:
            raise self._died(UNREADABLE)
        return reply

    def _died(self, words: str, deaths: int = 1) -> Finding:
        """Clear the process away; after the third time it is not started again."""
        self.close()
        self._deaths += deaths
        finding = Finding(words)
        if self._deaths >= DEATHS:
            self._given_up = finding
        return finding


class RemoteImplementation:
    """A student's function, called in another process; it behaves as `implementation.LocalImplementation`.

    Attributes
    ----------
    name : of the exercise. returned : what the last call returned. warned : its first NumPy warning, or "".
    """

    def __init__(self, answer: RemoteAnswer) -> None:
        self.name, self._answer = answer.name, answer
        self.returned: object = ...
        self.warned = ""

    def __call__(self, *arguments: object, **keywords: object) -> object:
        """Call the student's function; raises Finding for whatever is wrong with how it runs."""
        self.returned, self.warned = None, ""
        with _others_turn():
            reply = self._answer.call(arguments, keywords)
        warned = reply.get("warned")
        self.warned = warned[:LONGEST] if isinstance(warned, str) else ""
        raise_finding(reply)
        self.returned = reply["result"]
        return self.returned


def raise_finding(reply: dict) -> None:
    """Raise the finding that a reply brings, if it does."""
    if "finding" in reply:
        words = str(reply["finding"])[:LONGEST]
        raise (Unwritten if reply.get("unwritten") is True else Finding)(words)


def words_for_exit(code: int | None, limits: Limits) -> str:
    """Say how a process ended, from its exit code (negative: a signal; None: it closed its end and went on).

    Examples
    --------
    >>> words_for_exit(3, Limits())
    'ended Python (exit code 3) instead of returning a result'
    """
    if code is None:
        return "cut its connection to the grader"
    if code >= 0:
        return f"ended Python (exit code {code}) instead of returning a result"
    if -code in (signal.SIGKILL, signal.SIGXCPU):
        return f"was stopped: it used up its processor time or the memory ({limits.memory_mb} MB)"
    names = {one.value: one.name for one in signal.Signals}
    return f"crashed Python ({names.get(-code, f'signal {-code}')}): too much memory, or recursion without end?"
