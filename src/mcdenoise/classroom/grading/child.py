"""The process of a student's function: runs the source it is sent, answers calls, and decides nothing about points.

Started by `process.ChildProcess` as a script, in the base interpreter without site-packages. What it imports lies beside
it (`wire`, `fence`) and in the folder of packages: NumPy, and the stub `mcdenoise` with the guard around a function that
`check` uses too, so that a student reads the same words from both. The grader checks or escapes all that comes from here.
"""

from __future__ import annotations

import json
import linecache
import os
import resource
import sys
import types

SOURCE = "<answer>"


def main(packages: str, settings: str) -> None:
    """Set the limits, put up the fence, say that all is ready, and answer until the grader closes its end."""
    facts = json.loads(settings)
    set_limits(facts)
    here = os.path.dirname(os.path.abspath(__file__))
    sys.path[:0] = [here, packages]
    import fence
    import numpy
    import wire

    from mcdenoise.classroom.checking import implementation  # of the stub package, not of the library

    sys.path.remove(here)
    del sys.modules["fence"], sys.modules["wire"]  # no answer is to find them
    sys.stdout.reconfigure(line_buffering=True)
    requests, answers = os.fdopen(facts["requests"], "rb"), os.fdopen(facts["answers"], "wb")
    if facts["fence"]:
        fence.install([os.path.dirname(os.__file__), packages, os.path.dirname(os.path.realpath(numpy.__file__))])
    student = Student(implementation, facts["seconds"])
    reply = {"id": 0}
    while True:
        answers.write(pack_reply(wire, reply))
        answers.flush()
        try:
            request = wire.read_frame(requests.read)
        except wire.Ended:
            return
        reply = student.load(request) if "source" in request else student.call(request)
        reply["id"] = request["id"]
        sys.stdout.flush()


def set_limits(facts: dict) -> None:
    """Limit this process, for good: memory, processor time, no files written, few open, no core, few processes.

    The last does not bind root, and would count all processes of a user outside a sandbox: it is set inside only.
    """
    memory = facts["memory_mb"] << 20
    limits = {
        resource.RLIMIT_AS: memory,
        resource.RLIMIT_CPU: facts["cpu_seconds"],
        resource.RLIMIT_FSIZE: 0,
        resource.RLIMIT_NOFILE: 64,
        resource.RLIMIT_CORE: 0,
    }
    if facts["sandboxed"]:
        limits[resource.RLIMIT_NPROC] = 64
    for what, most in limits.items():
        try:
            resource.setrlimit(what, (most, most))
        except (OSError, ValueError):
            if sys.platform != "darwin":  # macOS knows no limit on address space
                raise


def pack_reply(wire: types.ModuleType, reply: dict) -> bytes:
    """Return the frame of a reply; a result that does not cross becomes a finding."""
    try:
        return wire.pack(reply)
    except wire.WireError as error:
        words = f"gives back {error}: return an array of numbers, a number, or a tuple, list or dict of these."
        return wire.pack({"id": reply["id"], "finding": words, "unwritten": False})


class Student:
    """The student's function or value, once loaded. `guard` is the module `implementation`."""

    def __init__(self, guard: types.ModuleType, seconds: float) -> None:
        self.guard, self.seconds = guard, seconds
        self.impl = None

    def load(self, request: dict) -> dict:
        """Run the source as `__main__`, as a notebook does; say whether its name is a function, or what value it has."""
        source, module = request["source"], types.ModuleType("__main__")
        sys.modules["__main__"] = module  # where dataclasses, among others, look for it
        names = vars(module)
        linecache.cache[SOURCE] = (len(source), None, source.splitlines(keepends=True), SOURCE)
        code = compile(source, SOURCE, "exec", dont_inherit=True)
        try:
            with self.guard.time_limit(self.seconds):
                exec(code, names)
        except self.guard.TooSlowError:
            return found(self.guard.too_slow_message(self.seconds, []))
        except (Exception, SystemExit) as error:
            return found(self.guard.finding_of(error, types.FunctionType(code, names)))
        answer = names.get(request["name"])
        if callable(answer):
            self.impl = self.guard.LocalImplementation(request["name"], answer, seconds=self.seconds)
            return {"kind": "function"}
        return {"kind": "value", "value": None if answer is ... else answer}

    def call(self, request: dict) -> dict:
        """Call the function: its result and NumPy's first warning, or a finding."""
        try:
            result = self.impl(*request["arguments"], **request["keywords"])
        except self.guard.Finding as finding:
            return found(finding) | {"warned": self.impl.warned}
        return {"result": result, "warned": self.impl.warned}


def found(finding: Exception | str) -> dict:
    """Return the reply for a finding: its words, and whether the answer is still the empty exercise."""
    return {"finding": str(finding), "unwritten": type(finding).__name__ == "Unwritten"}


if __name__ == "__main__":
    main(*sys.argv[1:])
