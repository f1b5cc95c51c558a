"""The hostile set: none gets points it has not earned, none loses points it has, none harms the grader."""

import ast
import re

import pytest

from hostile import harness
from mcdenoise.classroom.grading.feedback import feedback_page
from mcdenoise.classroom.grading.remote import Budget, RemoteAnswer
from mcdenoise.classroom.grading.sandbox import bwrap_failure

pytestmark = pytest.mark.ch02
EXPECTED = harness.expected()
ATTACKS = {name: one for name, one in EXPECTED.items() if "wall" in one}
needs_bwrap = pytest.mark.skipif(bool(bwrap_failure()), reason=f"bubblewrap: {bwrap_failure()}")
SANDBOXES = [pytest.param("bwrap", marks=needs_bwrap), "fence"]


def grade_all(place, sandbox, names=None):
    """Grade the set (or some of it) once, and prove that it did no harm."""
    submissions, outside = place / "submissions", place / "outside"
    submissions.mkdir()
    outside.mkdir()
    (outside / "grades.csv").write_text("student,total\n")
    with harness.listener() as (port, visitors):
        texts = harness.sources(outside, port)
        if names is None:
            harness.write_submissions(submissions, texts)
        for name in names or ():
            (submissions / f"{name}.py").write_text(f"# %%\n{texts[name]}")
        before = {path: path.stat() for path in sorted(submissions.rglob("*"))}
        grades = harness.grade_set(submissions, sandbox, workers=4)
        assert visitors() == 0
    after = {path: path.stat() for path in sorted(submissions.rglob("*"))}
    assert {path: one.st_mtime_ns for path, one in after.items()} == {p: one.st_mtime_ns for p, one in before.items()}
    assert [path.name for path in outside.iterdir()] == ["grades.csv"]
    assert (outside / "grades.csv").read_text() == "student,total\n"
    assert harness.leftovers() == []
    return grades


def limits_inside(sandbox):
    """What the process of an answer says about its own limits."""
    source = "import resource\n\ndef f(name):\n    return resource.getrlimit(getattr(resource, name))\n"
    with RemoteAnswer("f", source, harness.LIMITS, sandbox, Budget(30)) as answer:
        return {name: answer.impl()(name) for name in ("RLIMIT_AS", "RLIMIT_CPU", "RLIMIT_FSIZE", "RLIMIT_CORE")}


@pytest.fixture(scope="module", params=SANDBOXES)
def graded_set(request, tmp_path_factory):
    assert limits_inside(request.param)["RLIMIT_AS"] == (1 << 30, 1 << 30)  # before the memory hog
    grades = grade_all(tmp_path_factory.mktemp(request.param), request.param)
    print("\n" + harness.table(grades))
    return request.param, grades


@pytest.fixture(scope="module")
def behind_the_wall(tmp_path_factory):
    """The attacks in bubblewrap without the fence."""
    return grade_all(tmp_path_factory.mktemp("wall"), "wall", ATTACKS)


def test_the_burst_of_processes_is_bounded():
    """At most 64 forks, in one loop; a child sleeps half a second and ends, and cannot reach the loop again."""
    tree = ast.parse(harness.sources("outside", 1)["starts_processes"])
    calls = [ast.unparse(node) for node in ast.walk(tree) if isinstance(node, ast.Call)]
    assert sorted(calls) == [
        "burst(64)",
        "os._exit(0)",
        "os.fork()",
        "range(most)",
        "started.append(True)",
        "time.sleep(0.5)",
    ]
    burst = next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == "burst")
    (loop,) = burst.body
    (choice,) = loop.body
    assert [ast.unparse(line) for line in choice.body] == ["time.sleep(0.5)", "os._exit(0)"]
    assert not choice.orelse


def test_every_file_of_the_set_is_in_the_table():
    files = {path.name.removesuffix(".py.txt") for path in harness.HERE.glob("submissions/*")}
    made = {"right_notebook", "broken_notebook", "not_utf8", "a_folder", "right_in_folder", "too_large", "a_link"}
    assert set(EXPECTED) == files | made
    assert len(EXPECTED) >= 24


@pytest.mark.parametrize("sandbox", [pytest.param("bwrap", marks=needs_bwrap), "fence"])
def test_a_process_has_its_limits(sandbox):
    limits = limits_inside(sandbox)
    assert limits.pop("RLIMIT_AS") == (1 << 30, 1 << 30)
    assert limits == {"RLIMIT_CPU": (40, 40), "RLIMIT_FSIZE": (0, 0), "RLIMIT_CORE": (0, 0)}


@pytest.mark.parametrize("name", EXPECTED)
def test_points_and_hint(graded_set, name):
    sandbox, grades = graded_set
    expected, grade = EXPECTED[name], grades[name]
    if sandbox == "fence" and expected.get("climbs"):
        pytest.skip("the fence can be climbed; bubblewrap is the wall")
    assert grade.sandbox == sandbox
    assert (grade.total, grade.of) == (expected["points"], harness.POINTS)
    assert all(0 <= one.points <= one.of for one in grade.exercises)
    assert any(expected.get("hint", "") in message for message in harness.messages(grade))
    if grade.total == harness.POINTS:
        assert not any(harness.messages(grade))


@needs_bwrap
@pytest.mark.parametrize("name", ATTACKS)
def test_the_wall_holds_without_the_fence(behind_the_wall, name):
    expected, grade = EXPECTED[name], behind_the_wall[name]
    assert grade.sandbox == "wall"
    assert grade.total == expected.get("wall_points", expected["points"])
    assert any(expected["wall"] in message for message in harness.messages(grade))


def test_no_traceback_reaches_a_student(graded_set):
    _, grades = graded_set
    for grade in grades.values():
        assert not any("Traceback" in message for message in harness.messages(grade)), grade.student


def test_feedback_of_the_set_runs_no_script(graded_set):
    _, grades = graded_set
    for grade in grades.values():
        page = feedback_page(grade)
        assert not re.search(r"<script|<img|<iframe|javascript:|\son\w+=", page), grade.student
        assert "default-src 'none'" in page
    assert "hello &lt;script&gt;" in feedback_page(grades["prints_megabytes"])
    assert len(feedback_page(grades["prints_megabytes"])) < 20_000


def test_output_is_cut(graded_set):
    _, grades = graded_set
    assert all(len(one.printed) <= 4096 for grade in grades.values() for one in grade.exercises)
