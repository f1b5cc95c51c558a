"""What the tests of the chapters' exercises share: the reference, and what an answer is told."""

from pathlib import Path

from mcdenoise.classroom.checking.exercise import as_impl, load_tests, run_test
from mcdenoise.classroom.checking.pytest_plugin import load_answer

ROOT = Path(__file__).resolve().parents[1]
EXERCISES = load_tests(ROOT / "tests" / "exercises")


def reference(name):
    """The answer that stands in the notebook of the exercise."""
    (notebook,) = (ROOT / "notebooks").glob(f"{EXERCISES[name].chapter}_*.py")
    return load_answer(notebook, name)


def failures(name, answer, *, hidden):
    """The messages of the public, or of the hidden, tests that the answer fails."""
    impl = as_impl(name, answer)
    results = [run_test(test, impl) for test in EXERCISES[name].tests if test.graded.hidden == hidden]
    return [result.message for result in results if not result.passed]


def picture(name):
    """The picture that `check` shows for the reference: yours and target."""
    (draw,) = EXERCISES[name].pictures
    return draw(as_impl(name, reference(name)))


def assert_earns_every_point(name, answer):
    """A right answer fails neither a public nor a hidden test."""
    assert failures(name, answer, hidden=False) == failures(name, answer, hidden=True) == []


def assert_mistake_is_named(name, mistake, answer, words):
    """A typical mistake fails a public test, in words that help."""
    messages = failures(name, answer, hidden=False)
    assert messages, f"no public test notices: {mistake}"
    assert words in " ".join(messages), f"{mistake}: {messages}"
    assert not any("Traceback" in message for message in messages)
