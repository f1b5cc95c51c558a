"""nbgrader from end to end, without a browser: assign, submit, autograde, feedback; no student's code in its kernel."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from fake_course import make_course
from mcdenoise.classroom.building.build import build
from mcdenoise.classroom.building.nbgrader_course import grade_cell
from mcdenoise.classroom.building.nbgrader_grade import write_grades

pytest.importorskip("nbgrader", reason="nbgrader is not installed: pip install 'mcdenoise[grading]'")
from nbformat.v4 import new_code_cell, new_notebook

RIGHT = {
    "doubled_image": "def doubled_image(image):\n    return 2.0 * image\n",
    "bell_at_one": "def bell_at_one(sigma_space):\n    return np.exp(-0.5 / sigma_space**2)\n",
    "predicted_mean": "predicted_mean = 0.31\n",
}
# One process for all commands, because each needs seconds of imports. Nothing may be graded in a kernel.
DRIVER = """
import functools, json, os, nbclient, nbgrader.api
from nbgrader.apps import NbGraderAPI
from nbgrader.converters import Autograde
from traitlets.config.loader import PyFileConfigLoader

nbclient.NotebookClient.execute = None
nbgrader.api.get_alembic_version = functools.cache(nbgrader.api.get_alembic_version)  # a process each time
config = PyFileConfigLoader("nbgrader_config.py", path=os.getcwd()).load_config()
config.CourseDirectory.root = os.getcwd()
config.NbGraderAPI.log_level = "ERROR"
api = NbGraderAPI(config=config)
said = {"assign": api.generate_assignment("ch08")}
for student, notebook in json.load(open("submissions.json")).items():
    folder = f"submitted/{student}/ch08"
    os.makedirs(folder)
    released = json.load(open("release/ch08/ch08_fake.ipynb"))
    exec(notebook, {"nb": released, "cells": {c["metadata"].get("nbgrader", {}).get("grade_id"): c for c in released["cells"]}})
    text = json.dumps(released) if student != "broken" else "{"
    open(f"{folder}/ch08_fake.ipynb", "w").write(text)
    said[student] = api.autograde("ch08", student)
    if student in ("half", "narrow", "script"):
        said[student + " feedback"] = api.generate_feedback("ch08", student)
with api.gradebook as book:
    scores = {}
    for submission in book.assignment_submissions("ch08"):
        grades = [grade for notebook in submission.notebooks for grade in notebook.grades]
        scores[submission.student.id] = {grade.name: [grade.auto_score, grade.max_score] for grade in grades}
        scores[submission.student.id]["open"] = submission.needs_manual_grade
json.dump({"said": said, "scores": scores}, open("result.json", "w"))
"""


def _answers(**changes):
    answers = {**RIGHT, **changes}
    return "".join(f"cells[{name!r}]['source'] = {text!r}\n" for name, text in answers.items())


LOW = {"predicted_mean": "predicted_mean = 3"}
SUBMISSIONS = {
    "untouched": "",
    "right": _answers(),
    "half": _answers(doubled_image="def doubled_image(image):\n    return 2.0 * np.minimum(image, 4)\n", **LOW),
    "narrow": _answers(bell_at_one="def bell_at_one(sigma_space):\n    return 1.0\n"),
    # Points, the text of the cells that count, or the cells themselves changed by hand:
    "points": "cells['check_doubled_image']['metadata']['nbgrader']['points'] = 99\n"
    "cells['check_bell_at_one']['metadata']['nbgrader'].update(grade=False, solution=True, locked=False)\n"
    "cells['check_predicted_mean']['source'] = '1.0'\n"
    "cells['check_doubled_image']['outputs'] = "
    "[{'output_type': 'execute_result', 'execution_count': 1, 'metadata': {}, 'data': {'text/plain': '3.0'}}]",
    "deleted": _answers()
    + "nb['cells'] = [c for c in nb['cells'] if 'nbgrader' not in c['metadata'] or c is cells['bell_at_one']]",
    "twice": _answers()
    + "nb['cells'].append(dict(cells['check_bell_at_one'], id='again', source='0.0'))\n"
    + "nb['cells'].append(dict(cells['bell_at_one'], id='more'))",
    "nonsense": _answers()
    + "cells['doubled_image']['metadata']['nbgrader'] = 'mine'\n"
    + "cells['check_bell_at_one']['metadata']['nbgrader'] = {'grade_id': ['x'], 'grade': True}\n"
    + "cells['check_predicted_mean'].update(cell_type='markdown')\n"
    + "[cells['check_predicted_mean'].pop(k) for k in ('outputs', 'execution_count')]",
    # Code that must not run at all, or only in the child:
    "exit": "nb['cells'][1]['source'] += '\\nimport os\\nos._exit(0)'\n"
    "nb['cells'].insert(0, dict(nb['cells'][1], id='loop', source='while True:\\n    pass'))\n"
    + _answers(bell_at_one="import os\ndef bell_at_one(sigma_space):\n    os._exit(0)\n"),
    "script": _answers(bell_at_one="def bell_at_one(sigma_space):\n    raise ValueError('<script>alert(1)</script>')\n"),
    "broken": "",
}  # fmt: skip
NOTHING = dict.fromkeys(("check_doubled_image", "check_bell_at_one", "check_predicted_mean"), 0)
FULL = {"check_doubled_image": 3, "check_bell_at_one": 2.5, "check_predicted_mean": 1}
EXPECTED = {
    "untouched": NOTHING,
    "right": FULL,
    "half": {**FULL, "check_doubled_image": 2, "check_predicted_mean": 0},
    "narrow": {**FULL, "check_bell_at_one": 1},
    "points": NOTHING,
    "deleted": {"check_doubled_image": 0, "check_bell_at_one": 2.5, "check_predicted_mean": 0},
    "twice": FULL,
    "nonsense": FULL,
    "exit": {**FULL, "check_bell_at_one": 0},
    "script": {**FULL, "check_bell_at_one": 0},
}


@pytest.fixture(scope="module")
def graded(tmp_path_factory):
    place = tmp_path_factory.mktemp("nbgrader")
    build(make_course(place / "course"), place / "out")
    course = place / "out" / "nbgrader"
    (course / "submissions.json").write_text(json.dumps(SUBMISSIONS))
    environment = os.environ | {name: str(place / name) for name in ("HOME", "JUPYTER_DATA_DIR", "JUPYTER_CONFIG_DIR")}
    environment["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])  # it calls alembic
    done = subprocess.run([sys.executable, "-c", DRIVER], cwd=course, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    return course, json.loads((course / "result.json").read_text())


def test_the_release_is_our_stubs(graded):
    course, result = graded
    assert result["said"]["assign"]["success"]
    source = json.loads((course / "source/ch08/ch08_fake.ipynb").read_text())
    release = json.loads((course / "release/ch08/ch08_fake.ipynb").read_text())
    assert [cell["source"] for cell in release["cells"]] == [cell["source"] for cell in source["cells"]]
    assert (course / "release/ch08/data/reference.exr").exists()
    assert (course / "release/ch08/tests/exercises/test_ch08.py").exists()


@pytest.mark.parametrize("student", EXPECTED)
def test_each_student_gets_what_is_earned(graded, student):
    _, result = graded
    assert result["said"][student]["success"], result["said"][student]
    scores = result["scores"][student]
    assert scores.pop("open") is False
    assert scores == {name: [points, FULL[name]] for name, points in EXPECTED[student].items()}


def test_a_broken_file_stops_nobody_else(graded):
    _, result = graded
    assert not result["said"]["broken"]["success"]
    assert list(SUBMISSIONS)[-1] == "broken"


def test_the_feedback_has_our_words_and_no_script_of_a_student(graded):
    course, _ = graded
    page = (course / "feedback/half/ch08/ch08_fake.html").read_text()
    assert "the mean lies elsewhere" in page
    assert "Every pixel is twice what it was." in page
    page = (course / "feedback/script/ch08/ch08_fake.html").read_text()
    assert "<script>alert(1)</script>" not in page
    assert "stopped with ValueError" in page


def test_hidden_tests_do_not_give_their_numbers_away(graded):
    course, _ = graded
    page = (course / "feedback/narrow/ch08/ch08_fake.html").read_text()
    assert "too wide or too narrow" in page
    assert "exp(-1/2)" not in page


def test_tests_that_are_worth_something_else_are_refused(graded):
    course, _ = graded
    cell = new_code_cell('check("doubled_image")', metadata={"nbgrader": grade_cell("doubled_image", 4)})
    with pytest.raises(
        ValueError, match=r"check_doubled_image was released for 4 points, but test_ch08\.py gives 3\. Build"
    ):
        write_grades(new_notebook(cells=[cell]), course / "tests" / "exercises" / "test_ch08.py", "ada")
