"""The leak check finds planted leaks of every kind, and nothing where nothing is."""

import json

import pytest

from fake_course import make_course, replace
from mcdenoise.classroom.building.build import build, refuse_leaks, write_student
from mcdenoise.classroom.building.chapters import read_chapters
from mcdenoise.classroom.building.leaks import find_leaks, find_secrets

NOTEBOOK = "student/notebooks/ch08_fake.ipynb"
BELL = "return float(np.exp(-distance_squared / (2 * sigma_space**2)))"


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    return make_course(tmp_path_factory.mktemp("course"))


@pytest.fixture
def tree(course, tmp_path):
    """A built tree and the secrets of its sources."""
    build(course, tmp_path / "out")
    return tmp_path / "out", find_secrets(read_chapters(course), course)


def _add_cell(out, cell):
    path = out / NOTEBOOK
    notebook = json.loads(path.read_text())
    notebook["cells"].append({"cell_type": "code", "metadata": {}, "source": [], "outputs": [], **cell})
    path.write_text(json.dumps(notebook))


def test_a_built_tree_holds_no_secret(tree):
    out, secrets = tree
    assert find_leaks(out / "student", secrets) == []
    assert find_leaks(out / "nbgrader" / "source", secrets) == []


def test_the_check_is_not_blind(tree):
    out, secrets = tree
    leaks = find_leaks(out / "solution", secrets)
    assert any("the solution in notebooks/ch08_fake.py" in leak for leak in leaks)
    leaks = find_leaks(out / "nbgrader" / "tests", secrets)
    assert any("test_pi_is_doubled_as_well" in leak for leak in leaks)


@pytest.mark.parametrize(
    ("name", "text", "found"),
    [
        ("notes.md", f"The answer is `{BELL}`.", "the solution in notebooks/ch08_fake.py:27"),
        ("exercises/ch08.py", f"    # {BELL}", "the solution in notebooks/ch08_fake.py:27"),
        (
            "wrapped.py",
            BELL.replace("(-", "(\n    -").replace("* ", "*\n  "),
            "the solution in notebooks/ch08_fake.py:27",
        ),
        ("short.py", "predicted_mean  =  0.3125   # mine", "the solution in notebooks/ch08_fake.py:39"),
        ("source.txt", "    return np.add(copied_image, copied_image)", "the solution in src/mcdenoise/twice.py:10"),
        ("names.txt", "run test_pi_is_doubled_as_well first", "the hidden test test_pi_is_doubled_as_well"),
        ("body.py", "  assert_matches(impl(_secret_image()), 2 * _secret_image(), 'x')", None),
        (
            "body.py",
            '  assert_matches(impl(_secret_image()), 2 * _secret_image(), "doubled pi")',
            "the hidden test test_pi",
        ),
        ("remark.py", "# a last hidden remark", "the hidden test test_pi_is_doubled_as_well"),
        ("mark.py", "### BEGIN SOLUTION", "a mark of a solution"),
        ("binary.exr", "\0\x01" + BELL, "the solution in notebooks/ch08_fake.py:27"),
    ],
)
def test_a_planted_file_is_found(tree, name, text, found):
    out, secrets = tree
    path = out / "student" / name
    path.write_text((path.read_text() if path.exists() else "") + text)
    leaks = find_leaks(out / "student", secrets)
    assert [leak for leak in leaks if found and found in leak and leak.startswith(name)] or (not found and not leaks)


@pytest.mark.parametrize(
    ("cell", "found"),
    [
        ({"source": ["x = 1\n", "    " + BELL]}, "cell 11, holds the solution in"),
        ({"source": BELL, "cell_type": "markdown"}, "cell 11, holds the solution in"),
        ({"outputs": [{"data": {"text/plain": ["...\n", BELL]}}]}, "cell 11, holds the solution in"),
        ({"outputs": [{"text": "fine"}]}, "holds outputs"),
        ({"metadata": {"note": {"deep": ["test_the_bell_at_a_narrow_sigma"]}}}, "cell 11, holds the hidden test"),
        ({"metadata": {"predicted_mean = 0.3125": 1}}, "cell 11, holds the solution in"),
        ({"id": "test_the_bell_at_a_narrow_sigma"}, "cell 11, holds the hidden test"),
    ],
)
def test_a_leak_inside_a_notebook_is_found(tree, cell, found):
    out, secrets = tree
    _add_cell(out, cell)
    assert any(found in leak for leak in find_leaks(out / "student", secrets))


def test_a_leak_in_the_metadata_of_a_notebook_is_found(tree):
    out, secrets = tree
    notebook = json.loads((out / NOTEBOOK).read_text())
    notebook["metadata"]["made_from"] = BELL
    (out / NOTEBOOK).write_text(json.dumps(notebook))
    assert "notebooks/ch08_fake.ipynb, metadata, holds the solution in notebooks/ch08_fake.py:27" in find_leaks(
        out / "student", secrets
    )


def test_lines_that_authors_also_write_in_public_are_no_secret(tmp_path):
    course = make_course(tmp_path / "course")
    replace(course, "notebooks/ch08_fake.py", "picture = np.ones", "distance_squared = 1.0**2\npicture = np.ones")
    write_student(read_chapters(course), course, tmp_path / "student")
    refuse_leaks(read_chapters(course), course, [tmp_path / "student"])


@pytest.mark.parametrize(
    ("name", "old", "new", "where"),
    [
        ("notebooks/ch08_fake.py", "# Write it.", f"# Write `{BELL}`.", "notebooks/ch08_fake.py:14"),
        (
            "notebooks/ch08_fake.py",
            "picture = np.ones((2, 2))",
            "result = [\n    np.add(copied_image,\n           copied_image)\n]",
            "notebooks/ch08_fake.py:35",
        ),
        ("tests/exercises/test_ch08.py", "    # public helper", f"    # {BELL}", "tests/exercises/test_ch08.py:11"),
    ],
)
def test_solution_text_outside_the_marks_is_refused_with_its_place(tmp_path, name, old, new, where):
    course = make_course(tmp_path)
    replace(course, name, old, new)
    chapters = read_chapters(course)
    with pytest.raises(ValueError, match=rf"{where}: this text is also the solution in .*:\d+\. Reword it, or move it"):
        find_secrets(chapters, course)


def test_a_build_with_a_leak_writes_nothing(tmp_path, monkeypatch):
    course = make_course(tmp_path / "course")
    monkeypatch.setattr("mcdenoise.classroom.building.build.public_tests", lambda text, path: text)
    with pytest.raises(
        ValueError, match=r"Nothing was written, because students would get a secret: student/tests/.* more"
    ):
        build(course, tmp_path / "out")
    assert [path.name for path in tmp_path.iterdir()] == ["course"]
