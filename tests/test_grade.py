"""Grading a folder: what counts as a submission, the table, going on after an interruption, other executors."""

import argparse
import csv
import html
import inspect
import json
import re
import shutil
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import pytest

from mcdenoise.classroom.building.chapters import read_chapters
from mcdenoise.classroom.checking.exercise import Outcome
from mcdenoise.classroom.grading import grade as grading
from mcdenoise.classroom.grading import submissions as submissions_module
from mcdenoise.classroom.grading.feedback import feedback_page, write_feedback
from mcdenoise.classroom.grading.grade import add_arguments, grade_folder, grade_submission, run_grade
from mcdenoise.classroom.grading.results import ExerciseGrade, Grade, ResultStore, summary, write_csv
from mcdenoise.classroom.grading.sandbox import Limits, choose_sandbox
from mcdenoise.classroom.grading.submissions import find_submissions

ROOT = Path(__file__).resolve().parents[1]
CHAPTERS = sorted(path.stem.removeprefix("test_") for path in (ROOT / "tests" / "exercises").glob("test_ch*.py"))
LIMITS = Limits(seconds=5, total_seconds=60)
TESTS = '''
"""Two exercises."""

from mcdenoise.classroom import graded


@graded("double", points=2)
def test_twice(impl):
    "Twice the number."
    assert impl(4) == 8, f"twice 4 is 8, yours is {impl(4)}."


@graded("double", points=1.5, hidden=True)
def test_twice_a_negative(impl):
    "Also of a negative number."
    assert impl(-4) == -8, f"wrong sign: yours is {impl(-4)}."


@graded("guess", points=1)
def test_guess(impl):
    "Three."
    assert impl == 3, "think again."
'''
RIGHT = "def double(x):\n    return 2 * x\n\n\nguess = 3\n"
PARTLY = "def double(x):\n    return 2 * abs(x)\n\n\nguess = None\n"


@pytest.fixture
def tests(tmp_path):
    place = tmp_path / "exercises"
    place.mkdir()
    (place / "test_ch02.py").write_text(TESTS)
    return place


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "submissions"
    place.mkdir()
    (place / "ada.py").write_text(RIGHT)
    (place / "bob.py").write_text(PARTLY)
    return place


def notebook(*sources):
    cells = [{"cell_type": "code", "source": source, "metadata": {}, "outputs": []} for source in sources]
    return json.dumps({"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5})


def points(grades):
    return {grade.student: grade.total for grade in grades}


def test_points_are_those_of_the_tests_that_pass(tests):
    right = grade_submission("ada", RIGHT, ".py", tests, LIMITS)
    assert (right.total, right.of, right.problem) == (4.5, 4.5, "")
    partly = grade_submission("bob", notebook(PARTLY).encode(), ".ipynb", tests, LIMITS)
    assert [(one.exercise, one.points, one.of, one.unwritten) for one in partly.exercises] == [
        ("double", 2, 3.5, False),
        ("guess", 0, 1, True),
    ]
    assert partly.exercises[0].outcomes[1].message == "wrong sign: yours is 8."
    assert partly.note.startswith("not written yet: guess; graded in: ")
    assert partly.sandbox == choose_sandbox()


@pytest.mark.parametrize(
    ("content", "suffix", "words"),
    [
        (b"", ".ipynb", "no whole notebook"),
        (b"[]", ".ipynb", "no list of cells"),
        (b'{"cells": [{"cell_type": "code", "source": 3}]}', ".ipynb", "cell 1 has no source"),
        (b"\xff\xfe", ".py", "not UTF-8"),
        (b"[" * 100_000, ".ipynb", "no whole notebook"),
        (b"x = 1", ".exe", "must be a notebook"),
    ],
)
def test_what_cannot_be_read_gets_nothing_and_a_sentence(tests, content, suffix, words):
    grade = grade_submission("eve", content, suffix, tests, LIMITS)
    assert (grade.total, grade.of) == (0, 4.5)
    assert words in grade.problem
    assert grade.note == grade.problem


@pytest.mark.parametrize(
    "source",
    [
        "",
        "\x00",
        "double = " + "(" * 10_000,
        "double = " + "-" * 200_000 + "1",
        "double = " + "+1" * 50_000,
        "def double(x):\n    return " + "[" * 90 + "x" + "]" * 90 + "\n" + "double.a = 1\n" * 2_000,
        "# %%\n" + "%" * 100_000,
        "\n".join(f"a{k} = a{k - 1}" for k in range(1, 1_000)) + "\ndouble = a999",
        "double = '" + "\\N{DIGIT ONE}" * 20_000,
        "x = 10 ** 10 ** 9\ndouble = 3",
    ],
    ids=lambda source: repr(source[:20]),
)
def test_odd_sources_cost_the_grader_nothing(tests, source):
    grade = grade_submission("eve", source, ".py", tests, LIMITS)
    assert grade.total == 0
    assert grade.exercises[0].outcomes[0].message


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("# %% " + "a" * 2_000, r"a cell mark \(# %%\) of more than 2000 characters"),
        ("a = 1\n" * 3_001, "3001 lines of code, the limit is 3000"),
        ("a = 1;" * 3_001, "3001 lines of code, the limit is 3000"),
    ],
    ids=["long mark", "many lines", "many statements"],
)
def test_what_would_take_long_to_read_is_refused(tests, source, words):
    assert re.search(words, grade_submission("eve", source, ".py", tests, LIMITS).problem)


def test_files_and_folders_are_submissions(folder, tmp_path):
    (folder / "bob.ipynb").write_text(notebook("x = 1"))
    (folder / "cleo").mkdir()
    (folder / "cleo" / "ch02").mkdir()
    (folder / "cleo" / "ch02" / "work.ipynb").write_text(notebook(RIGHT))
    (folder / "cleo" / ".ipynb_checkpoints").mkdir()
    (folder / "cleo" / ".ipynb_checkpoints" / "work.ipynb").write_text(notebook(PARTLY))
    (folder / "cleo" / "link.py").symlink_to(tmp_path / "elsewhere.py")
    (folder / "empty").mkdir()
    (folder / "notes.txt").write_text("no submission")
    (folder / ".hidden.py").write_text(RIGHT)
    (folder / "link.py").symlink_to(folder / "ada.py")
    (folder / "looks_like.py").mkdir()
    found = {one.student: ([path.name for path in one.files], one.problem) for one in find_submissions(folder)}
    assert found == {
        "ada": (["ada.py"], ""),
        "bob.ipynb": (["bob.ipynb"], ""),
        "bob.py": (["bob.py"], ""),
        "cleo": (["work.ipynb"], ""),
        "empty": ([], "the folder holds no notebook (.ipynb or .py), at most 4 folders deep."),
        "link": ([], "link.py is a link, not a file."),
        "looks_like": ([], "the folder holds no notebook (.ipynb or .py), at most 4 folders deep."),
        "notes.txt": ([], "notes.txt is no notebook: a file that ends in .ipynb or .py is needed."),
    }


def test_no_two_students_have_one_name(tmp_path):
    files = ("x.ipynb", "x.py", "x.py.py", "ADA.IPYNB", "ada.py", "mo.Py")
    for name in files:
        (tmp_path / name).write_text("x = 1")
    found = {one.student: one.files[0].name for one in find_submissions(tmp_path)}
    assert found == {name: name for name in files[:-1]} | {"mo": "mo.Py"}


STUB = "def double(x):\n    raise NotImplementedError('double is not written yet')\nguess = None\n"


@pytest.mark.parametrize(
    ("others", "remark"),
    [
        ({"zz.py": STUB}, ""),
        ({"zz.ipynb": notebook(STUB), "old/work.ipynb": notebook(STUB)}, ""),
        ({"zz.ipynb": ""}, "zz.ipynb is no whole notebook"),
        ({"zz.py": "x = '\udce4'"}, "zz.py is not UTF-8 text"),
    ],
)
def test_a_stub_or_a_broken_file_does_not_hide_the_answer(tmp_path, tests, others, remark):
    ada = tmp_path / "class" / "ada"
    for name, text in {"work.ipynb": notebook(RIGHT), **others}.items():
        (ada / name).parent.mkdir(parents=True, exist_ok=True)
        (ada / name).write_bytes(text.encode("utf-8", "surrogateescape"))
    (grade,) = grade_folder(tmp_path / "class", tests, limits=LIMITS)
    assert grade.total == grade.of
    assert grade.remark.startswith(remark)
    assert bool(grade.remark) == bool(remark)
    assert html.escape(grade.remark) in feedback_page(grade)
    assert grade.note.startswith(grade.remark)


@pytest.mark.parametrize(
    ("place", "words"), [("none", "no such folder"), ("ada.py", "no such folder"), ("", "no submission")]
)
def test_a_folder_of_submissions_is_needed(folder, tests, place, words):
    empty = folder / "empty"
    empty.mkdir()
    with pytest.raises(ValueError, match=words):
        grade_folder(folder / place if place else empty, tests, limits=LIMITS)


def test_files_too_large_or_gone_are_said(folder, monkeypatch):
    ada, bob = find_submissions(folder)
    monkeypatch.setattr(submissions_module, "LARGEST", 10)
    assert ada.read() == ({}, "ada.py has 0 MB, the limit is 0 MB: clear the outputs of the notebook and save it.")
    (folder / "bob.py").unlink()
    assert bob.read() == ({}, "bob.py cannot be read (No such file or directory).")


def test_several_notebooks_of_one_student_count_together(folder, tests):
    (folder / "ada.py").unlink()
    (folder / "ada").mkdir()
    (folder / "ada" / "ch01.py").write_text("def double(x):\n    return 2 * x\n")
    (folder / "ada" / "ch02.ipynb").write_text(notebook("guess = 3"))
    assert points(grade_folder(folder, tests, limits=LIMITS)) == {"ada": 4.5, "bob": 2}


def test_a_long_name_gets_a_page_of_its_own(tmp_path):
    grades = [Grade(name, (), "bwrap") for name in ("b" * 250, "b" * 249 + "c", "zoe")]
    pages = write_feedback(grades, tmp_path)
    assert len({page.name for page in pages}) == 3
    assert all(grade.student in page.read_text("utf-8") for grade, page in zip(grades, pages, strict=True))


def test_the_table_is_stable_and_safe_for_spreadsheets(tmp_path):
    exercise = ExerciseGrade("double", "ch02", (Outcome("t", "s", "double", 2, False, True),))
    names = ["=1+1", "+a", "-b", "@c", "\td", "plain", 'quo"te, comma', "new\nline", "\udcff", "\x1b[2Ja;=1+1"]
    grades = [Grade(name, (exercise,), "bwrap", problem="=cmd()" if name == "+a" else "") for name in names]
    write_csv(grades, tmp_path / "grades.csv")
    first = (tmp_path / "grades.csv").read_bytes()
    write_csv(grades, tmp_path / "grades.csv")
    assert (tmp_path / "grades.csv").read_bytes() == first
    with (tmp_path / "grades.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["student", "total", "of", "double", "note"]
    assert [row[0] for row in rows[1:]] == [
        "'=1+1",
        "'+a",
        "'-b",
        "'@c",
        "d",
        "plain",
        'quo"te, comma',
        "new line",
        "?",
        "[2Ja; =1+1",
    ]
    assert rows[2] == ["'+a", "2", "2", "2", "'=cmd()"]
    assert rows[6] == ["plain", "2", "2", "2", "graded in: bubblewrap"]
    assert [path.name for path in tmp_path.iterdir()] == ["grades.csv"]


def test_the_fence_is_named_in_the_table(tests):
    grade = grade_submission("ada", RIGHT, ".py", tests, replace(LIMITS, sandbox="fence"))
    assert (grade.total, grade.note) == (4.5, "graded in: no sandbox (fence only)")


def test_a_student_who_wrote_nothing_is_said_in_two_words(tests):
    grade = grade_submission(
        "eve", "guess = None\ndef double(x):\n    raise NotImplementedError\n", ".py", tests, LIMITS
    )
    assert grade.note.startswith("nothing written yet; graded in: ")


@pytest.mark.parametrize("number", [pytest.param(name, marks=getattr(pytest.mark, name)) for name in CHAPTERS])
def test_the_solutions_of_a_chapter_get_full_points(number):
    """All that the tests hand over and get back crosses, and the answers need NumPy and the given modules alone."""
    (chapter,) = (one for one in read_chapters(ROOT) if one.number == number)
    cells = [cell for cell in chapter.cells if cell.kind == "code"]
    sources = [_with_reference(cell.source) if cell.exercise else cell.source for cell in cells]
    grade = grade_submission("instructor", notebook(*sources), ".ipynb", ROOT / chapter.test_file, Limits())
    failed = [(test.test, test.message) for one in grade.exercises for test in one.outcomes if not test.passed]
    assert failed == []
    assert grade.total == grade.of > 0


def _with_reference(source):
    """The cell with the reference itself in place of its import: the whole module, or of nn, lbf and study that one function."""
    found = re.search(
        r"^from mcdenoise\.(filters|rpf|nn|lbf|study)\.(?!window)(\w+) import (\w+).*$", source, re.MULTILINE
    )
    if not found:
        return source
    room, module, name = found.groups()
    if room in ("nn", "lbf", "study"):  # their modules need others
        text = inspect.getsource(getattr(import_module(f"mcdenoise.{room}.{module}"), name))
    else:
        text = (ROOT / "src" / "mcdenoise" / room / f"{module}.py").read_text()
    return text.replace("from __future__ import annotations", "") + source.replace(found[0], "")


class Counting(ThreadPoolExecutor):
    """Counts what is handed to it."""

    submitted = 0

    def submit(self, *arguments, **keywords):
        self.submitted += 1
        return super().submit(*arguments, **keywords)


def test_a_run_goes_on_where_it_stopped(folder, tests, tmp_path):
    def run(limits=LIMITS, fresh=False):
        with Counting(2) as executor:
            grades = grade_folder(
                folder, tests, executor=executor, limits=limits, results=tmp_path / "results", fresh=fresh
            )
            return executor.submitted, points(grades)

    everything = {"ada": 4.5, "bob": 2}
    assert run() == (2, everything)
    assert run() == (0, everything)
    assert run(fresh=True) == (2, everything)
    (folder / "bob.py").write_text(RIGHT)
    assert run() == (1, {"ada": 4.5, "bob": 4.5})
    assert run(limits=replace(LIMITS, seconds=6))[0] == 2
    (tests / "test_ch02.py").write_text(TESTS.replace("points=2", "points=3"))
    assert run() == (2, {"ada": 5.5, "bob": 5.5})
    for path in (tmp_path / "results").iterdir():
        path.write_text("{")
    assert run() == (2, {"ada": 5.5, "bob": 5.5})


def test_a_stored_grade_is_that_of_one_student_and_version(tmp_path, monkeypatch):
    store = ResultStore(tmp_path, {"seconds": 1}, {"test.py": b"x"})
    contents = {"work.py": b"y"}
    store.save(Grade("ada", (), "bwrap"), contents)
    assert store.load("ada", contents) == Grade("ada", (), "bwrap")
    assert store.load("bob", contents) is None
    assert ResultStore(tmp_path, {"seconds": 2}, {"test.py": b"x"}).load("ada", contents) is None
    monkeypatch.setattr("mcdenoise.classroom.grading.results.version", lambda name: "99")
    assert ResultStore(tmp_path, {"seconds": 1}, {"test.py": b"x"}).load("ada", contents) is None


class Failing(Executor):
    """Fails for one student, as a lost worker would."""

    def submit(self, function, student, *arguments, **keywords):
        future = Future()
        if student == "ada":
            future.set_exception(OSError("worker lost"))
        else:
            future.set_result(function(student, *arguments, **keywords))
        return future


def test_a_failure_of_the_grader_stops_nothing_and_is_not_kept(folder, tests, tmp_path):
    results = tmp_path / "results"
    ada, bob = grade_folder(folder, tests, executor=Failing(), limits=LIMITS, results=results)
    assert (ada.total, ada.of, bob.total) == (0, 4.5, 2)
    assert "not the student's fault; run it again (OSError: worker lost)" in ada.problem
    assert len(list(results.iterdir())) == 1
    assert "1 could not be graded:\n  ada: the grader failed" in summary([ada, bob])
    assert points(grade_folder(folder, tests, limits=LIMITS, results=results)) == {"ada": 4.5, "bob": 2}


def test_a_process_that_cannot_start_is_the_graders_failure(folder, tests, monkeypatch):
    monkeypatch.setattr("mcdenoise.classroom.grading.process.child_command", lambda *arguments: ["/bin/false"])
    ada, _ = grade_folder(folder, tests, limits=LIMITS)
    assert "the grader failed" in ada.problem
    assert ada.total == 0


def test_only_some_submissions_are_in_memory_at_once(folder, tests, monkeypatch):
    monkeypatch.setattr(grading, "AT_ONCE", 2)
    for k in range(5):
        shutil.copy(folder / "bob.py", folder / f"bob{k}.py")
    names = [grade.student for grade in grade_folder(folder, tests, limits=LIMITS, workers=2)]
    assert names == ["ada", "bob", "bob0", "bob1", "bob2", "bob3", "bob4"]


def test_a_class_grades_on_a_dask_cluster(folder, tests):
    distributed = pytest.importorskip("distributed")
    import dask

    quiet = {"distributed.worker.memory.terminate": False, "distributed.admin.tick.limit": "1h"}
    with (
        dask.config.set(quiet),
        distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            dashboard_address=None,
            worker_dashboard_address=None,
            silence_logs=50,
        ) as cluster,
        distributed.Client(cluster) as client,
        client.get_executor() as executor,
    ):
        grades = grade_folder(folder, tests, executor=executor, limits=LIMITS)
    assert points(grades) == {"ada": 4.5, "bob": 2}
    assert all(grade.sandbox == choose_sandbox() for grade in grades)


def options(*arguments):
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return parser.parse_args([str(one) for one in arguments])


def test_the_command_writes_table_feedback_and_summary(folder, tests, tmp_path, capsys):
    table, feedback = tmp_path / "grades.csv", tmp_path / "feedback"
    (folder / "eve.ipynb").write_text("{")
    chosen = options(folder, "--out", table, "--tests", tests, "--feedback", feedback, "--timeout", 5, "--memory", 1024)
    assert run_grade(chosen) == 0
    said = capsys.readouterr().out
    assert "3 submissions, 2.17 of 4.5 points in the mean." in said
    assert "1 could not be graded:\n  eve: eve.ipynb is no whole notebook" in said
    assert "Sandbox: " in said
    assert table.read_text().splitlines()[1].startswith("ada,4.5,4.5,3.5,1,")
    assert sorted(path.name for path in feedback.iterdir()) == ["ada.html", "bob.html", "eve.html"]
    assert len(list((tmp_path / "grades.csv.results").iterdir())) == 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--workers", "0"], "--workers must be 1 or more, got 0"),
        (["--timeout", "0"], "seconds must be above 0"),
        (["--memory", "1"], "512 MB or more"),
        (["--tests", "nowhere"], r"test_chNN\.py, or a folder of them\), got nowhere"),
        (["--out", "no/such/folder/grades.csv"], "--out must name a file in a folder that exists"),
        (["--out", "."], "--out must name a file"),
    ],
)
def test_wrong_arguments_are_refused_in_one_line(folder, tests, tmp_path, arguments, words):
    with pytest.raises(ValueError, match=words):
        run_grade(options(folder, "--out", tmp_path / "grades.csv", "--tests", tests, *arguments))
    assert not (tmp_path / "grades.csv").exists()


def test_the_whole_command_line_grades(folder, tests, tmp_path, monkeypatch, capsys):
    from mcdenoise.cli import main

    monkeypatch.chdir(tmp_path)
    Path("tests").mkdir()
    tests.rename("tests/exercises")
    assert main(["classroom", "grade", "submissions", "--out", "grades.csv"]) == 0
    assert "2 submissions, 3.25 of 4.5" in capsys.readouterr().out
    assert main(["classroom", "grade", "nothing", "--out", "grades.csv"]) == 2
    assert capsys.readouterr().err.splitlines()[-1].startswith("mcdenoise classroom")
