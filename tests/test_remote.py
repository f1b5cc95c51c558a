"""A student's function in another process behaves as in this one, and no child can harm the grader."""

import copy
import linecache
import os
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from mcdenoise.classroom.checking.exercise import LocalImplementation
from mcdenoise.classroom.checking.finding import Finding, Unwritten
from mcdenoise.classroom.grading import remote, wire
from mcdenoise.classroom.grading.process import MARK, ChildProcess, NoAnswerError, sweep
from mcdenoise.classroom.grading.remote import Budget, RemoteAnswer, turn, words_for_exit
from mcdenoise.classroom.grading.sandbox import Limits, choose_sandbox

SANDBOX = choose_sandbox()
LIMITS = Limits(seconds=2, total_seconds=60)
IMAGE = np.arange(6.0).reshape(2, 3)


def remote_answer(source, name="f", **changes):
    settings = {"limits": LIMITS, "sandbox": SANDBOX, "budget": Budget(60)} | changes
    return RemoteAnswer(name, source, **settings)


def outcome(call):
    """What a call gives, or the words of its finding."""
    try:
        return call()
    except Finding as finding:
        return type(finding).__name__, str(finding)


@pytest.mark.parametrize(
    ("body", "arguments"),
    [
        ("return image * factor", (IMAGE, 2.0)),
        ("return image.tolist(), {'norm': image.sum(axis=0), 3: None}, image.max(), 'text'", (IMAGE, 2)),
        ("return image / 0 * factor", (IMAGE, np.float32(2))),
        ("image += 1; return image", (IMAGE, 2)),
        ("factor['a'][0] = 7; return image", (IMAGE, {"a": [1, (2, 3)]})),
        ("return imge", (IMAGE, 2)),
        ("return image + np.ones(7)", (IMAGE, 2)),
        ("raise NotImplementedError('f is not written yet')", (IMAGE, 2)),
        ("return f(image, factor)", (IMAGE, 2)),
        ("raise SystemExit(3)", (IMAGE, 2)),
        ("return image", (IMAGE, 2, 3)),
        ("pass", (IMAGE, None)),
    ],
)
def test_the_same_results_and_words_as_in_this_process(body, arguments):
    source = f"#@ line 5\nimport numpy as np\n#@ line 8\ndef f(image, factor):\n    {body}\n"
    names = {}
    exec(compile(source, "<answer>", "exec"), names)
    linecache.cache["<answer>"] = (len(source), None, source.splitlines(keepends=True), "<answer>")
    local = LocalImplementation("f", names["f"])
    expected = outcome(lambda: local(*copy.deepcopy(arguments)))
    with remote_answer(source) as answer:
        impl = answer.impl()
        received = outcome(lambda: impl(*arguments))
        assert repr(received) == repr(expected)
        assert impl.warned == local.warned
        assert repr(impl.returned if isinstance(received, np.ndarray) else None) == repr(
            local.returned if isinstance(expected, np.ndarray) else None
        )


def test_keywords_cross_too():
    with remote_answer("def f(a, *, b=1):\n    return a - b") as answer:
        assert answer.impl()(5, b=3) == 2


@pytest.mark.parametrize(
    ("source", "value"), [("f = 0.5", 0.5), ("f = None", None), ("f = ...", None), ("f = (1, [2])", (1, [2]))]
)
def test_a_value_is_handed_over_as_it_is(source, value):
    with remote_answer(source) as answer:
        assert answer.impl() == value


@pytest.mark.parametrize("future", ["", "from __future__ import annotations\n"])
def test_an_answer_runs_as_main_without_our_own_future(future):
    source = f"""{future}
from dataclasses import InitVar, dataclass

@dataclass
class Pair:
    left: float
    scale: InitVar[float] = 2.0

    def __post_init__(self, scale):
        self.left *= scale

if __name__ == "__main__":
    factor = 3

def f(x: int):
    return Pair(x).left * factor, __name__, type(f.__annotations__["x"]).__name__
"""
    with remote_answer(source) as answer:
        assert answer.impl()(2) == (12.0, "__main__", "str" if future else "type")


def test_a_generator_that_stops_is_a_finding_and_the_process_lives_on():
    source = "calls = []\n\ndef f(x):\n    calls.append(x)\n    return (len(calls) / (x - k) for k in range(2))"
    with remote_answer(source) as answer:
        impl = answer.impl()
        words = "gives back a generator that stops with ZeroDivisionError: return an array"
        assert outcome(lambda: impl(1))[1].startswith(words)
        assert impl(2) == [1.0, 2.0]


def test_a_process_lives_on_between_calls():
    source = "calls = []\n\ndef f():\n    calls.append(1)\n    return len(calls)"
    with remote_answer(source) as answer:
        impl = answer.impl()
        assert [impl(), impl(), answer.impl()()] == [1, 2, 3]


def test_a_dead_process_is_started_again_three_times_at_most():
    source = "import os\n\ndef f(die):\n    if die:\n        os._exit(7)\n    return 'alive'"
    with remote_answer(source) as answer:
        for _ in range(2):
            with pytest.raises(Finding, match="ended Python \\(exit code 7\\)"):
                answer.impl()(True)
            assert answer.impl()(False) == "alive"
        with pytest.raises(Finding, match="exit code 7"):
            answer.impl()(True)
        with pytest.raises(Finding, match="exit code 7"):
            answer.impl()


def test_an_answer_that_does_not_load_says_the_same_for_every_test():
    with remote_answer("x = 1 / 0\n\ndef f():\n    return 1") as answer:
        for _ in range(2):
            with pytest.raises(Finding, match=r"ZeroDivisionError: division by zero, in line 1: `x = 1 / 0`"):
                answer.impl()


def test_what_is_unwritten_stays_unwritten():
    with (
        remote_answer("def f():\n    raise NotImplementedError") as answer,
        pytest.raises(Unwritten, match="not written yet"),
    ):
        answer.impl()()


def test_the_budget_of_a_submission_is_used_up():
    budget = Budget(1.0)
    source = "import time\n\ndef f():\n    time.sleep(0.6)"
    with remote_answer(source, budget=budget) as answer:
        answer.impl()()
        with pytest.raises(Finding, match=r"gave no answer|the 1 s for the whole notebook were used up"):
            answer.impl()()
    assert budget.left <= 0
    again = pytest.raises(Finding, match="the 1 s for the whole notebook were used up")
    with remote_answer(source, budget=budget) as answer, again:
        answer.impl()


def test_prints_of_all_processes_are_kept_up_to_a_limit():
    source = "import os\nprint('loaded')\n\ndef f(die):\n    print('called', flush=True)\n    die and os._exit(1)"
    with remote_answer(source) as answer:
        outcome(lambda: answer.impl()(True))
        answer.impl()(False)
        answer.close()
        assert answer.printed.split() == ["loaded", "called"] * 2
    with remote_answer("import os\n\ndef f():\n    os.write(1, b'x' * 60_000)") as answer:
        answer.impl()()
        answer.close()
        assert len(answer.printed) == 4096


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (0, "ended Python (exit code 0)"),
        (-9, "used up its processor time or the memory (2048 MB)"),
        (-24, "used up its processor time"),
        (-11, "crashed Python (SIGSEGV)"),
        (-64, "crashed Python (SIGRTMAX)"),
        (-200, "crashed Python (signal 200)"),
        (None, "cut its connection"),
    ],
)
def test_the_end_of_a_process_in_words(code, words):
    assert words in words_for_exit(code, Limits())


def test_what_a_test_hands_over_must_cross():
    with (
        remote_answer("def f(x):\n    return x") as answer,
        pytest.raises(TypeError, match="a test hands over an object of type"),
    ):
        answer.impl()(len)


class Forger:
    """Takes the place of ChildProcess: answers with what it is given."""

    printed = b""

    def __init__(self, *replies):
        self.replies = list(replies)

    def ask(self, request, seconds):
        reply = self.replies.pop(0)
        if isinstance(reply, Exception):
            raise reply
        return {"id": wire.unpack(request)["id"], **reply} if isinstance(reply, dict) else reply

    def exit_code(self):
        return 1

    def kill(self):
        pass


@pytest.mark.parametrize(
    "reply",
    [7, None, [], {}, {"id": 99, "kind": "function"}, {"kind": "test"}, {"kind": "value"}, wire.WireError("garbage")],
    ids=repr,
)
def test_replies_that_make_no_sense_are_a_finding(monkeypatch, reply):
    monkeypatch.setattr(remote, "ChildProcess", lambda *arguments: Forger(reply))
    with remote_answer("") as answer, pytest.raises(Finding, match="sent the grader something it cannot read"):
        answer.impl()


@pytest.mark.parametrize(
    "reply", [{"warned": 3, "result": 5}, {"warned": "w" * 10**6, "result": 5}], ids=["number", "long"]
)
def test_words_of_a_child_are_cut(monkeypatch, reply):
    monkeypatch.setattr(
        remote, "ChildProcess", lambda *arguments: Forger({"kind": "function"}, reply, {"finding": "x" * 10**6})
    )
    with remote_answer("") as answer:
        impl = answer.impl()
        assert impl() == 5
        assert len(impl.warned) <= 2000
        with pytest.raises(Finding) as caught:
            impl()
        assert len(str(caught.value)) == 2000


def test_a_call_without_a_result_is_a_finding(monkeypatch):
    monkeypatch.setattr(remote, "ChildProcess", lambda *arguments: Forger({"kind": "function"}, {"warned": ""}))
    with remote_answer("") as answer, pytest.raises(Finding, match="cannot read"):
        answer.impl()()


def test_trouble_of_the_grader_is_no_finding(monkeypatch):
    monkeypatch.setattr(
        "mcdenoise.classroom.grading.process.child_command", lambda *arguments: ["/bin/sh", "-c", "echo no python here"]
    )
    with remote_answer("f = 1") as answer:
        with pytest.raises(RuntimeError, match=r"did not start .*no python here"):
            answer.impl()
        assert isinstance(answer.trouble, RuntimeError)


@pytest.mark.parametrize("sandbox", sorted({SANDBOX, "fence"}))
def test_half_an_answer_ends_by_the_clock(sandbox):
    """The head of an answer of 64 MB that never comes."""
    source = """
import os, time

def f(data):
    for end in range(3, 64):
        try:
            os.write(end, data)
        except OSError:
            pass
    time.sleep(30)
"""
    head = np.frombuffer(struct.pack("<4sIQ", b"mcd1", 8, 64 << 20), np.uint8)
    with ChildProcess(sandbox, LIMITS) as child:
        child.ask(wire.pack({"id": 1, "source": source, "name": "f"}), 30)
        with pytest.raises(NoAnswerError):
            child.ask(wire.pack({"id": 2, "arguments": (head,), "keywords": {}}), 1.0)


def test_closing_twice_does_no_harm_and_leaves_no_file_open():
    before = set(os.listdir("/proc/self/fd"))
    with remote_answer("f = 1") as answer:
        answer.impl()
        answer.close()
        answer.close()
    child = ChildProcess(SANDBOX, LIMITS)
    folder = child._folder
    child.kill()
    child.kill()
    assert not os.path.exists(folder)
    assert set(os.listdir("/proc/self/fd")) <= before


def test_sweep_ends_a_process_in_a_session_of_its_own():
    process = subprocess.Popen(
        [sys.executable, "-c", "import os, time; os.setsid(); time.sleep(20)"],
        env={MARK: "test-mark"},
        start_new_session=False,
    )
    other = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(20)"], env={MARK: "another-mark"})
    try:
        while b"test-mark" not in Path(f"/proc/{process.pid}/environ").read_bytes():
            time.sleep(0.01)
        sweep("test-mark")
        assert process.wait(5) == -9
        assert other.poll() is None
    finally:
        for one in (process, other):
            one.kill()
            one.wait()


def test_one_thread_at_a_time_tests_and_gives_way_while_a_function_runs():
    inside, most, order = [], [], []

    def work(name):
        with remote_answer("import time\n\ndef f():\n    time.sleep(0.5)\n    return 1") as answer:
            impl = answer.impl()
            with turn():
                inside.append(name)
                most.append(len(inside))
                inside.remove(name)
                order.append("call")
                impl()
                order.append("back")
                inside.append(name)
                most.append(len(inside))
                inside.remove(name)

    threads = [threading.Thread(target=work, args=(name,)) for name in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert set(most) == {1}
    assert sorted(order) == ["back"] * 3 + ["call"] * 3
