"""Every notebook is executed with the references in place of the exercises; one runs as plain Python too."""

import json
import os
import subprocess
import sys

import pytest

from fake_course import make_course, replace
from mcdenoise.classroom.building import lab
from mcdenoise.classroom.publishing import execute
from mcdenoise.classroom.publishing.execute import build_notebooks, execute_all
from real_course import ROOT, executed_notebooks

SCRIPTS = sorted((ROOT / "notebooks").glob("ch*.py"))
SCRIPT = "notebooks/ch08_fake.py"


@pytest.fixture
def course(tmp_path):
    """A course of one chapter whose notebook needs nothing but NumPy and matplotlib."""
    root = make_course(tmp_path / "course")
    replace(
        root,
        SCRIPT,
        "from mcdenoise.twice import doubled_image\n",
        "def doubled_image(image):\n    ### BEGIN SOLUTION\n    return 2 * image\n    ### END SOLUTION\n",
    )
    replace(root, SCRIPT, "picture = np.ones((2, 2))", "plt.plot([1, 2]);")
    return root


def _cells(path, kind="code"):
    return [cell for cell in json.loads(path.read_text("utf-8"))["cells"] if cell["cell_type"] == kind]


def test_a_notebook_runs_as_plain_python():
    """Nothing in it needs Jupyter. One is enough: all are executed below, cell by cell, with every check."""
    script = SCRIPTS[0]
    done = subprocess.run(
        [sys.executable, script.name],
        cwd=script.parent,
        env=os.environ | {"MPLBACKEND": "Agg", "MCDENOISE_STRICT": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_each_notebook_executes(script):
    (notebook,) = (path for path in executed_notebooks() if path.stem == script.stem)
    cells = _cells(notebook)
    assert all(cell["execution_count"] for cell in cells)
    assert not [output for cell in cells for output in cell["outputs"] if output["output_type"] == "error"]
    assert any("image/png" in output.get("data", {}) for cell in cells for output in cell["outputs"])


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_pages_of_notebooks_show_stubs_and_hide_solutions(script):
    (notebook,) = (path for path in executed_notebooks() if path.stem == script.stem)
    shown = [cell for cell in _cells(notebook) if "remove-input" not in cell["metadata"].get("tags", [])]
    assert "BEGIN SOLUTION" not in json.dumps(shown)


def test_a_fake_course_executes_with_figures_and_without_a_backend_of_ours(course, tmp_path, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "Agg")  # would keep figures out of the notebook
    (executed,) = execute_all(build_notebooks(course, tmp_path / "source"), tmp_path / "executed")
    outputs = [output for cell in _cells(executed) for output in cell["outputs"]]
    assert any("image/png" in output.get("data", {}) for output in outputs)
    assert executed == tmp_path / "executed" / "ch08_fake.ipynb"
    assert not [path for path in (tmp_path / "executed").iterdir() if path != executed]


def test_an_error_stops_and_is_told_with_its_cell(course, tmp_path):
    replace(course, SCRIPT, "plt.plot([1, 2]);", "nothing_of_that_name")
    with pytest.raises(ValueError, match=r"ch08_fake.ipynb stops with NameError(.|\n)*nothing_of_that_name"):
        execute_all(build_notebooks(course, tmp_path / "source"), tmp_path / "executed")
    assert not list((tmp_path / "executed").iterdir())


def test_a_check_that_fails_stops(course, tmp_path):
    replace(course, SCRIPT, "predicted_mean = 0.3125", "predicted_mean = 0.9")
    with pytest.raises(ValueError, match=r"ch08_fake\.ipynb stops with Finding"):
        execute_all(build_notebooks(course, tmp_path / "source"), tmp_path / "executed")


def test_a_cell_that_does_not_end_stops(course, tmp_path, monkeypatch):
    monkeypatch.setattr(execute, "CELL_SECONDS", 1)
    replace(course, SCRIPT, "plt.plot([1, 2]);", "while True: pass")
    (notebook,) = build_notebooks(course, tmp_path / "source")
    with pytest.raises(ValueError, match=r"ch08_fake\.ipynb could not be executed"):
        execute.execute(notebook, tmp_path / "ch08_fake.ipynb")


def test_the_command_executes_the_clone_it_stands_in(course, monkeypatch, capsys):
    monkeypatch.chdir(course)
    assert execute.main([]) == 0
    assert capsys.readouterr().out == "out/notebooks/ch08_fake.ipynb\n"
    (course / SCRIPT).unlink()
    assert execute.main([]) == 2
    assert "notebooks: " in capsys.readouterr().err


def test_the_lab_never_replaces_work_and_renews_what_nobody_touched(course, monkeypatch, capsys):
    monkeypatch.chdir(course)
    assert lab.main([]) == 0
    notebook, tests = course / "work/notebooks/ch08_fake.ipynb", course / "work/tests/exercises/test_ch08.py"
    first = notebook.read_text()
    assert lab.main([]) == 0  # again, with nothing new
    assert notebook.read_text() == first
    replace(course, SCRIPT, "# Write it.", "# Write it well.")
    capsys.readouterr()
    assert lab.main([]) == 0  # a newer notebook, and nobody worked in the old one
    assert "Write it well." in notebook.read_text()
    assert capsys.readouterr().out == "The notebooks are in work/notebooks.\n"
    notebook.write_text("mine")
    tests.write_text("changed")
    assert lab.main([]) == 0
    assert notebook.read_text() == "mine"
    assert tests.read_text() != "changed"
    assert "work/notebooks/ch08_fake.ipynb is yours and stays" in capsys.readouterr().out


def test_the_lab_says_what_it_cannot_read(course, monkeypatch, capsys):
    monkeypatch.chdir(course)
    lab.main([])
    (course / "work" / lab.MARKER).write_text("[")
    assert lab.main([]) == 2
    err = capsys.readouterr().err
    assert "cannot be read" in err
    assert err.count("\n") == 1
