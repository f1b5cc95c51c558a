"""A child process that answers frames: started in the sandbox, waited for by the clock, killed with all that it started."""

from __future__ import annotations

import contextlib
import json
import math
import os
import secrets
import select
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

from mcdenoise.classroom.grading import wire
from mcdenoise.classroom.grading.sandbox import ENVIRONMENT, Limits, child_command

PRINTED = 4096  # bytes of what a child prints that are kept
CHUNK = 1 << 16
START_SECONDS = 60.0
MARK = "MCDENOISE_GRADING"


class NoAnswerError(Exception):
    """The child did not answer in time."""


class ChildProcess:
    """One process of `child.py`, to be used as a context manager.

    Parameters
    ----------
    sandbox : "bwrap" or "fence", or "wall": bubblewrap without the fence inside, for tests of the wall.
    limits : of memory and time.

    Raises
    ------
    RuntimeError
        If it does not start: that is the grader's trouble, not a student's.
    """

    def __init__(self, sandbox: str, limits: Limits) -> None:
        self.printed = b""
        self._mark = f"{os.getpid()}-{secrets.token_hex(16)}"
        self._sandboxed = sandbox != "fence"
        self._answers_left = bytearray()
        requests, self._request_end = os.pipe()
        self._answer_end, answers = os.pipe()
        settings = {
            "requests": requests,
            "answers": answers,
            "memory_mb": limits.memory_mb,
            "cpu_seconds": math.ceil(limits.total_seconds) + 10,
            "seconds": limits.seconds,
            "fence": sandbox != "wall",
            "sandboxed": self._sandboxed,
        }
        self._folder = tempfile.mkdtemp(prefix="mcdenoise-child-")
        try:
            self._process = subprocess.Popen(
                child_command("bwrap" if self._sandboxed else "fence", [json.dumps(settings)]),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                bufsize=0,
                pass_fds=(requests, answers),
                cwd=self._folder,
                env={**ENVIRONMENT, MARK: self._mark},
                start_new_session=True,
            )
        finally:
            os.close(requests)
            os.close(answers)
        for end in (self._request_end, self._answer_end, self._process.stdout.fileno()):
            os.set_blocking(end, False)
        self._wait_until_ready()

    def _wait_until_ready(self) -> None:
        try:
            self.receive(START_SECONDS)
        except (wire.WireError, NoAnswerError) as error:
            self.kill()
            said = " ".join(self.printed.decode("utf-8", "replace").split())[-300:]
            raise RuntimeError(f"the process for a student's answer did not start ({error}): {said}") from error

    def __enter__(self) -> ChildProcess:
        return self

    def __exit__(self, *details: object) -> None:
        self.kill()

    def ask(self, request: bytes, seconds: float) -> object:
        """Send a frame and return the value of the one that comes back.

        Raises
        ------
        NoAnswerError
            If it is not there after so many seconds.
        wire.WireError
            If the child ended (`wire.Ended`), or what it sent is no frame.
        """
        frame = memoryview(request)
        deadline = time.monotonic() + seconds
        while frame:
            frame = frame[self._wait(self._request_end, select.POLLOUT, deadline, frame) :]
        return self.receive(deadline - time.monotonic())

    def receive(self, seconds: float) -> object:
        """Return the next frame from the child; errors as for `ask`."""
        deadline = time.monotonic() + seconds

        def read(count: int) -> bytes:
            while len(self._answers_left) < count:
                if not self._wait(self._answer_end, select.POLLIN, deadline):
                    break
            data = bytes(self._answers_left[:count])
            del self._answers_left[:count]
            return data

        return wire.read_frame(read)

    def _wait(self, end: int, event: int, deadline: float, data: memoryview | None = None) -> int:
        """Wait until `end` is ready, write `data` or read from it, and return how many bytes; keep prints flowing."""
        poll = select.poll()
        poll.register(end, event)
        prints = self._process.stdout
        if not prints.closed:
            poll.register(prints.fileno(), select.POLLIN)
        while True:
            left = deadline - time.monotonic()
            if left <= 0:
                raise NoAnswerError(f"no answer within the time, {-left:.1f} s over")
            ready = [file for file, _ in poll.poll(1000 * left)]
            if not prints.closed and prints.fileno() in ready and not self._keep_print():
                poll.unregister(prints.fileno())
                prints.close()
            if end in ready:
                return self._read() if data is None else self._write(data)

    def _read(self) -> int:
        data = os.read(self._answer_end, CHUNK)
        self._answers_left += data
        return len(data)

    def _write(self, data: memoryview) -> int:
        try:
            return os.write(self._request_end, data[:CHUNK])
        except BrokenPipeError as error:
            raise wire.Ended("the child closed its end") from error

    def _keep_print(self) -> int:
        """Read what was printed; keep the first bytes, drop the rest. Returns 0 at the end of the stream."""
        try:
            data = os.read(self._process.stdout.fileno(), CHUNK)
        except BlockingIOError:
            return 1
        self.printed += data[: max(0, PRINTED - len(self.printed))]
        return len(data)

    def exit_code(self, seconds: float = 1.0) -> int | None:
        """Return how the child ended, negative for a signal, or None if it still runs after so many seconds."""
        try:
            code = self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            return None
        return 128 - code if self._sandboxed and code > 128 else code  # bwrap reports a signal as 128 + its number

    def kill(self) -> None:
        """End the child and everything that it started, and close all ends. May be called twice."""
        with contextlib.suppress(ProcessLookupError):
            if self._process.poll() is None:
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        if not self._sandboxed:  # with bubblewrap all processes of the sandbox end with it
            sweep(self._mark)
        if not self._process.stdout.closed:
            while len(self.printed) < PRINTED and self._more_printed():
                pass
            self._process.stdout.close()
        for name in ("_request_end", "_answer_end"):
            if getattr(self, name) is not None:
                os.close(getattr(self, name))
                setattr(self, name, None)
        shutil.rmtree(self._folder, ignore_errors=True)

    def _more_printed(self) -> bool:
        return bool(select.select([self._process.stdout], [], [], 0)[0]) and self._keep_print() > 0


def sweep(mark: str) -> None:
    """Kill the processes that inherited `mark` in their environment, also those in sessions of their own (Linux)."""
    wanted = f"{MARK}={mark}".encode()
    for _ in range(20):
        found = [place for place in Path("/proc").glob("[0-9]*") if wanted in _environment(place)]
        if not found:
            return
        for place in found:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.kill(int(place.name), signal.SIGKILL)
        time.sleep(0.01)


def _environment(place: Path) -> bytes:
    try:
        return (place / "environ").read_bytes()
    except OSError:  # it ended, or is another user's
        return b""
