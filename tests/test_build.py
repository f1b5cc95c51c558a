"""The build: what stands in each tree, the same bytes on every run, mistakes of authors refused, nobody's work replaced."""

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from fake_course import make_course, replace
from mcdenoise.classroom.building.build import build, exercise_module
from mcdenoise.classroom.building.chapters import find_root, read_chapters
from mcdenoise.classroom.building.folders import MARKER, new_folder
from mcdenoise.classroom.building.notebook import KINDS, notebook_text
from mcdenoise.classroom.checking.cells import parse_cells

ROOT = Path(__file__).resolve().parents[1]
SCRIPT, TESTS, MODULE = "notebooks/ch08_fake.py", "tests/exercises/test_ch08.py", "src/mcdenoise/twice.py"


@pytest.fixture
def course(tmp_path):
    return make_course(tmp_path / "course")


def _contents(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def _sources(folder, name="ch08_fake"):
    notebook = json.loads((folder / f"{name}.ipynb").read_text())
    return ["".join(cell["source"]) for cell in notebook["cells"]]


def test_the_student_tree_is_whole_and_holds_stubs(course, tmp_path):
    build(course, tmp_path / "out")
    student = tmp_path / "out" / "student"
    assert sorted(_contents(student)) == [
        "README.md",
        "exercises/ch08.py",
        "notebooks/ch08_fake.ipynb",
        "notebooks/data/reference.exr",
        "pytest.ini",
        "tests/exercises/test_ch08.py",
    ]
    sources = _sources(student / "notebooks")
    assert sources[0] == "# 08 Fake\n\nTwice a pixel: $y = 2 x$."
    assert sources[3] == (
        "def doubled_image(image: np.ndarray) -> np.ndarray:\n"
        '    """Twice the radiance of every pixel."""\n    # Your code here.\n'
        '    raise NotImplementedError("doubled_image is not written yet")'
    )
    assert sources[8] == "predicted_mean = None  # your prediction"
    assert (student / "notebooks" / "data" / "reference.exr").read_bytes() == bytes(range(256))
    assert "def test_every_pixel_is_doubled" in (student / TESTS).read_text()


def test_the_solution_tree_holds_the_source_as_it_is(course, tmp_path):
    build(course, tmp_path / "out")
    sources = _sources(tmp_path / "out" / "solution" / "notebooks")
    assert sources == [cell.source for cell in parse_cells((course / SCRIPT).read_bytes(), ".py")]


def test_a_page_shows_the_stub_and_hides_the_reference(course):
    (chapter,) = read_chapters(course)
    cells = json.loads(notebook_text(chapter, "site"))["cells"]
    shown, hidden = cells[3], cells[4]
    assert shown["cell_type"] == "markdown"
    assert "".join(shown["source"]).startswith("```python\ndef doubled_image(image")
    assert "".join(shown["source"]).endswith('not written yet")\n```')
    assert hidden["metadata"]["tags"] == ["remove-input"]
    assert "from mcdenoise.twice import doubled_image" in "".join(hidden["source"])
    assert cells[1]["metadata"]["tags"] == ["setup"]


def test_nbgrader_gets_one_solution_cell_and_one_locked_cell_with_all_points_for_each_exercise(course, tmp_path):
    build(course, tmp_path / "out")
    notebook = json.loads((tmp_path / "out/nbgrader/source/ch08/ch08_fake.ipynb").read_text())
    marked = [
        (cell["metadata"]["nbgrader"], "".join(cell["source"]))
        for cell in notebook["cells"]
        if "nbgrader" in cell["metadata"]
    ]
    assert [(mark["grade_id"], mark["solution"], mark["locked"], mark.get("points")) for mark, _ in marked] == [
        ("doubled_image", True, False, None),
        ("check_doubled_image", False, True, 3),
        ("bell_at_one", True, False, None),
        ("check_bell_at_one", False, True, 2.5),
        ("predicted_mean", True, False, None),
        ("check_predicted_mean", False, True, 1),
    ]
    assert marked[1][1] == 'check("doubled_image")'
    assert "hidden=True" in (tmp_path / "out/nbgrader/tests/exercises/test_ch08.py").read_text()
    assert "hidden=True" not in (tmp_path / "out/nbgrader/source/ch08/tests/exercises/test_ch08.py").read_text()


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_a_valid_notebook_without_outputs_or_paths(course, kind):
    nbformat = pytest.importorskip("nbformat")
    text = notebook_text(read_chapters(course)[0], kind)
    notebook = nbformat.reads(text, as_version=4)
    nbformat.validate(notebook)
    assert nbformat.writes(notebook) == text.rstrip("\n")
    assert all(not cell.outputs and cell.execution_count is None for cell in notebook.cells if cell.cell_type == "code")
    assert notebook.metadata.kernelspec == {"display_name": "Python 3", "language": "python", "name": "python3"}
    assert str(course) not in text


def test_another_kind_is_refused(course):
    with pytest.raises(ValueError, match="kind must be one of student, solution, site, nbgrader, got 'teacher'"):
        notebook_text(read_chapters(course)[0], "teacher")


def test_cell_ids_stay_when_other_cells_come_in(course):
    before = json.loads(notebook_text(read_chapters(course)[0], "student"))["cells"]
    replace(course, SCRIPT, "# Write it.", "# New.\n\n# %% [markdown]\n# Write it.")
    after = json.loads(notebook_text(read_chapters(course)[0], "solution"))["cells"]
    ids = [cell["id"] for cell in after]
    assert len(set(ids)) == len(ids)
    assert [one for one in ids if one in {cell["id"] for cell in before}] == [cell["id"] for cell in before]


def test_the_exercise_module_runs_and_has_the_imports_of_the_notebook(course):
    (chapter,) = read_chapters(course)
    names = {}
    exec(compile(exercise_module(chapter), "ch08.py", "exec"), names)
    assert names["predicted_mean"] is None
    assert names["np"].__name__ == "numpy"
    assert callable(names["bell"])
    assert "plt" not in names
    assert "check" not in names
    with pytest.raises(NotImplementedError, match="bell_at_one is not written yet"):
        names["bell_at_one"](2.0)


def test_a_build_has_the_same_bytes_anywhere_and_at_any_time(course, tmp_path):
    build(course, tmp_path / "first")
    before = _contents(tmp_path / "first")
    for number, place in ((7, tmp_path), (8, course / "src")):
        os.utime(course / SCRIPT, (1e9 * number, 1e9))
        code = (
            "import sys, pathlib; from mcdenoise.classroom.building.build import build; "
            "build(*map(pathlib.Path, sys.argv[1:]))"
        )
        environment = os.environ | {"PYTHONHASHSEED": str(number), "TZ": "Asia/Tokyo"}
        subprocess.run([sys.executable, "-c", code, course, f"again{number}"], cwd=place, env=environment, check=True)
        assert _contents(place / f"again{number}") == before
    build(course, tmp_path / "first")
    assert _contents(tmp_path / "first") == before


MISTAKES = [
    (SCRIPT, 'exercise="bell_at_one"', 'exercise="bell_at_two"', "py:23: the exercise cell must define bell_at_two"),
    (SCRIPT, 'check("bell_at_one")', 'check("bell")', r"py:31: check\('bell'\): there is no such exercise above"),
    (SCRIPT, 'check("bell_at_one")', "pass", r"py:23: no cell checks the exercise bell_at_one\. Write a cell"),
    (SCRIPT, "0.3125\n### END SOLUTION", "0.3125", r"py:38: ### BEGIN SOLUTION has no end\. Write ### END SOLUTION"),
    (SCRIPT, "predicted_mean = None  # your", "# your", "py:37: without its solution the cell no longer defines"),
    (SCRIPT, "import doubled_image", "import doubled_image, used_elsewhere", "py:17: import the reference on a line"),
    (SCRIPT, "mcdenoise.twice", "mcdenoise.thrice", r"py:17: there is no src/mcdenoise/thrice\.py"),
    (SCRIPT, "from mcdenoise.twice import", "import os as", "py:17: the exercise doubled_image has no marked solution"),
    (
        SCRIPT,
        "picture = np",
        "### BEGIN SOLUTION\nx = 1\n### END SOLUTION\ny = np",
        "py:34: a solution stands in a cell",
    ),
    (SCRIPT, "return float(", "return float((", r"ch08_fake\.py:27: this is no valid Python"),
    (TESTS, '"predicted_mean", points', '"mean", points', r"py:\d+: test_the_prediction_is_near tests mean, but"),
    (TESTS, '"predicted_mean", points=1', '"predicted_mean", points=ONE', r"py:\d+: the mark of test_the_prediction"),
    (MODULE, "def doubled_image", "def tripled_image", r"twice\.py: an exercise needs the function doubled_image"),
    (MODULE, "    ### BEGIN SOLUTION\n", "", r"twice\.py:10: ### END SOLUTION without a beginning"),
]


@pytest.mark.parametrize(("name", "old", "new", "message"), MISTAKES)
def test_a_mistake_in_the_sources_is_refused_with_its_place(course, tmp_path, name, old, new, message):
    replace(course, name, old, new)
    with pytest.raises(ValueError, match=message):
        build(course, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_an_exercise_without_tests_is_refused(course):
    extra = (
        '\n# %% exercise="more"\nmore = None\n### BEGIN SOLUTION\nmore = 7\n### END SOLUTION\n\n# %%\ncheck("more")\n'
    )
    (course / SCRIPT).write_text((course / SCRIPT).read_text() + extra)
    with pytest.raises(
        ValueError, match=r"ch08_fake\.py:46: the exercise more has no tests\. Write some in tests/exercises/"
    ):
        read_chapters(course)


def test_chapters_and_tests_come_in_pairs(course):
    (course / "tests/exercises/test_ch09.py").write_text("")
    with pytest.raises(ValueError, match=r"tests/exercises/test_ch09\.py: no notebook ch09_name\.py uses it"):
        read_chapters(course)
    (course / "tests/exercises/test_ch09.py").rename(course / "tests/exercises/other.py")
    (course / "notebooks/ch09_more.py").write_text((course / SCRIPT).read_text())
    with pytest.raises(
        ValueError, match=r"notebooks/ch09_more\.py:1: the notebook has no tests\. Write tests/exercises/test_ch09"
    ):
        read_chapters(course)
    (course / "tests/exercises/test_ch09.py").write_text((course / TESTS).read_text())
    with pytest.raises(
        ValueError, match=r"ch09_more\.py:17: the exercise doubled_image already stands in notebooks/ch08_fake\.py:17"
    ):
        read_chapters(course)
    (course / "notebooks/ch08_other.py").write_text((course / SCRIPT).read_text())
    with pytest.raises(ValueError, match=r"notebooks/ch08_fake\.py: another notebook has the number ch08"):
        read_chapters(course)
    for path in (course / "notebooks").glob("*.py"):
        path.unlink()
    (course / "tests/exercises/test_ch09.py").unlink()
    (course / TESTS).unlink()
    with pytest.raises(ValueError, match=r"holds no notebook chNN_name\.py"):
        read_chapters(course)


def test_the_repository_is_found_from_below_and_its_absence_said(course, tmp_path):
    assert find_root(course / "notebooks" / "data") == course
    with pytest.raises(
        ValueError, match=r"needs a clone of the repository .* is not inside one\. Go there, or name it with --root"
    ):
        find_root(tmp_path)


def test_a_folder_that_somebody_worked_in_is_not_replaced(course, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    build(course, out)
    (out / "student/notebooks/__pycache__").mkdir()
    (out / "student/notebooks/__pycache__/x.pyc").write_bytes(b"cache")
    build(course, out)
    (out / "student/exercises/ch08.py").write_text("my work")
    with pytest.raises(
        ValueError, match=r"out holds work done since it was made \(student/exercises/ch08\.py\) and is not replaced"
    ):
        build(course, out)
    assert (out / "student/exercises/ch08.py").read_text() == "my work"


def test_a_folder_of_somebody_else_is_not_replaced(course, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.tex").write_text("mine")
    with pytest.raises(ValueError, match="out was not made by this command and is not replaced"):
        build(course, tmp_path / "out")
    (tmp_path / "out" / MARKER).write_text("{")
    with pytest.raises(ValueError, match=rf"{MARKER} is not readable .*, so .*out is not replaced"):
        build(course, tmp_path / "out")
    with pytest.raises(ValueError, match="A folder that can be written to is needed"):
        build(course, tmp_path / "out" / "thesis.tex" / "deeper")


def test_a_build_that_fails_leaves_the_old_one_and_nothing_else(tmp_path):
    with new_folder(tmp_path / "out") as folder:
        (folder / "old.txt").write_text("old")
    with pytest.raises(ZeroDivisionError), new_folder(tmp_path / "out") as folder:
        (folder / "new.txt").write_text(str(1 / 0))
    assert sorted(_contents(tmp_path)) == [f"out/{MARKER}", "out/old.txt"]


REAL = sorted((ROOT / "notebooks").glob("ch[0-9][0-9]_*.py"))


def test_the_real_chapters_build_without_a_leak(tmp_path):
    chapters = build(ROOT, tmp_path / "out")
    assert [chapter.name for chapter in chapters] == [path.stem for path in REAL]
    for chapter in chapters:
        module = (tmp_path / "out/student/exercises" / f"{chapter.number}.py").read_text()
        names = {node.name for node in ast.parse(module).body if isinstance(node, ast.FunctionDef)}
        names |= {one.id for one in ast.walk(ast.parse(module)) if isinstance(one, ast.Name)}
        assert {mark.exercise for mark in chapter.marks} <= names
        exec(compile(module, f"{chapter.number}.py", "exec"), {})


@pytest.mark.parametrize("path", REAL, ids=lambda path: path.stem)
def test_jupytext_reads_our_notebooks_as_we_do(path):
    jupytext = pytest.importorskip("jupytext")
    theirs = jupytext.reads(path.read_text(), fmt="py:percent").cells
    ours = parse_cells(path.read_bytes(), ".py")
    assert [(cell.cell_type, cell.source) for cell in theirs] == [(cell.kind, cell.source) for cell in ours]
