"""`mcdenoise classroom build | check | release` as typed: what they print, their exit codes, one line for what cannot be done."""

import argparse
import json
import subprocess
import sys
import zipfile

import pytest

from fake_course import make_course, replace
from mcdenoise.classroom.building.folders import sha256
from mcdenoise.classroom.command import add_commands, run


@pytest.fixture
def course(tmp_path, monkeypatch):
    monkeypatch.chdir(make_course(tmp_path / "course"))
    return tmp_path / "course"


def classroom(*words):
    parser = argparse.ArgumentParser()
    add_commands(parser.add_subparsers(dest="command"))
    return run(parser.parse_args(["classroom", *map(str, words)]))


ANSWERS = "import numpy as np\n\ndef doubled_image(image):\n    return 2 * image\n\npredicted_mean = 0.31\n"


def test_build_says_what_each_chapter_holds(course, capsys):
    assert classroom("build") == 0
    assert capsys.readouterr().out.splitlines() == [
        "ch08_fake: 3 exercises, 6.5 points, 3 public and 2 hidden tests",
        "Wrote out/classroom. Start with out/classroom/student/README.md.",
    ]
    assert (course / "out" / "classroom" / "student" / "README.md").exists()


def test_build_with_root_and_out_works_from_elsewhere(course, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert classroom("build", "--root", course / "notebooks", "--out", "there") == 0
    assert (tmp_path / "there" / "student").is_dir()
    with pytest.raises(ValueError, match="needs a clone of the repository"):
        classroom("build")
    with pytest.raises(ValueError, match="needs a clone of the repository"):
        classroom("release")


def test_the_commands_of_the_students_readme_work_in_the_built_tree(course, capsys):
    classroom("build")
    student = course / "out" / "classroom" / "student"
    (student / "exercises" / "ch08.py").write_text(ANSWERS + "def bell_at_one(sigma_space):\n    return 1.0\n")
    done = subprocess.run([sys.executable, "-m", "pytest", "-q"], cwd=student, capture_output=True, text=True)
    assert "3 passed" in done.stdout, done.stdout
    notebook = "notebooks/ch08_fake.ipynb"
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "--impl", notebook], cwd=student, capture_output=True, text=True
    )
    assert "3 failed" in done.stdout, done.stdout


def test_check_reports_every_exercise_of_a_module(course, capsys):
    classroom("build")
    module = course / "out/classroom/student/exercises/ch08.py"
    module.write_text(ANSWERS)
    capsys.readouterr()
    assert classroom("check", module) == 1
    out = capsys.readouterr().out
    assert "doubled_image: the test holds." in out
    assert "bell_at_one: " in out
    assert "predicted_mean: " in out
    assert "Traceback" not in out


def test_check_of_named_exercises_in_a_notebook(course, capsys):
    classroom("build")
    notebook = course / "out/classroom/student/notebooks/ch08_fake.ipynb"
    assert classroom("check", notebook, "doubled_image") == 1
    assert "not written yet" in capsys.readouterr().out
    content = json.loads(notebook.read_text())
    content["cells"][3]["source"] = "%time x = 1\ndef doubled_image(image):\n    return image + image\n"
    solved = notebook.with_name("ch08_solved.ipynb")
    solved.write_text(json.dumps(content))
    assert classroom("check", solved, "doubled_image") == 0
    assert "doubled_image: the test holds." in capsys.readouterr().out


def test_check_names_what_is_wrong_with_the_call(course, tmp_path):
    own = course / "tests" / "mine.py"
    own.write_text("something = 3\n")
    with pytest.raises(ValueError, match=r"gone\.py: there is no such file"):
        classroom("check", course / "gone.py")
    with pytest.raises(
        ValueError, match=r"no exercise 'blur'\. The exercises are doubled_image, bell_at_one, predicted"
    ):
        classroom("check", own, "blur")
    with pytest.raises(ValueError, match=r"mine\.py has no answer to any of the exercises doubled_image"):
        classroom("check", own)
    (tmp_path / "lonely.py").write_text(ANSWERS)
    with pytest.raises(ValueError, match="no tests found"):
        classroom("check", tmp_path / "lonely.py")


def test_release_writes_the_same_archives_every_time(course, capsys):
    assert classroom("release") == 0
    assert capsys.readouterr().out.splitlines() == [
        "out/release/ch08_fake.zip",
        "out/release/exercises.zip",
        "Their SHA-256 sums stand in out/release/SHA256SUMS.",
    ]
    release = course / "out" / "release"
    sums = (release / "SHA256SUMS").read_text()
    assert sums == "".join(f"{sha256(release / name)}  {name}\n" for name in ("ch08_fake.zip", "exercises.zip"))
    classroom("release", "--out", "again")
    assert (course / "again" / "SHA256SUMS").read_text() == sums
    with zipfile.ZipFile(release / "ch08_fake.zip") as archive:
        assert archive.testzip() is None
        assert archive.namelist() == [
            "ch08_fake/README.md",
            "ch08_fake/exercises/ch08.py",
            "ch08_fake/notebooks/ch08_fake.ipynb",
            "ch08_fake/notebooks/data/reference.exr",
            "ch08_fake/pytest.ini",
            "ch08_fake/tests/exercises/test_ch08.py",
        ]


def test_release_refuses_a_leak(course):
    replace(course, "notebooks/ch08_fake.py", "# Write it.", "# test_the_bell_at_a_narrow_sigma waits for you.")
    with pytest.raises(
        ValueError, match=r"students would get a secret: ch08_fake/notebooks/ch08_fake\.ipynb, cell 3, holds"
    ):
        classroom("release")
    assert not (course / "out" / "release").exists()
