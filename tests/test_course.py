"""What belongs together over the chapters: the pages list what the notebooks ask for, and the plan adds up."""

import inspect
import re

import pytest

from answers import EXERCISES, ROOT, failures, reference
from mcdenoise.classroom.checking.exercise import as_impl, run_test

CHAPTERS = sorted(path.stem for path in (ROOT / "notebooks").glob("ch*.py"))
KINDS = {"write", "predict", "break"}


def _of(chapter):
    return {name: one for name, one in EXERCISES.items() if one.chapter == chapter[:4]}


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_the_lecture_lists_the_exercises_with_their_points(chapter):
    page = (ROOT / "lectures" / f"{chapter}.md").read_text("utf-8")
    rows = re.findall(r"^\| `(\w+)`[^|]*\| (\w+) \| ([\d.]+) \|$", page, re.MULTILINE)
    assert {name: float(points) for name, _, points in rows} == {name: one.points for name, one in _of(chapter).items()}
    assert {kind for _, kind, _ in rows} == KINDS


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_no_line_of_the_page_is_lost(chapter):
    """MyST takes a line that begins with % for a comment."""
    lines = (ROOT / "lectures" / f"{chapter}.md").read_text("utf-8").splitlines()
    assert not [line for line in lines if line.lstrip().startswith("%")]


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_numbers_in_tables_are_filtered_without_a_bar(chapter):
    """A | within {{ }} ends the cell of a table; write {{ "%.2f" % number }} there."""
    rows = (ROOT / "lectures" / f"{chapter}.md").read_text("utf-8").splitlines()
    assert not [row for row in rows if row.startswith("|") and re.search(r"\{\{[^}]*\|", row)]


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_the_teaching_plan_has_the_points_of_each_chapter(chapter):
    plan = (ROOT / "lectures" / "instructor.md").read_text("utf-8")
    (points,) = re.findall(rf"^\| \d+ \| \[[^|]*\({chapter}\.md\) \|[^|]*\|[^|]*\| ([\d.]+) \|", plan, re.MULTILINE)
    assert float(points) == sum(one.points for one in _of(chapter).values())


@pytest.mark.parametrize("name", EXERCISES)
def test_every_exercise_is_asked_for_and_checked_in_its_notebook(name):
    (notebook,) = (ROOT / "notebooks").glob(f"{EXERCISES[name].chapter}_*.py")
    cells = notebook.read_text("utf-8").split("\n# %%")
    (asked,) = (k for k, cell in enumerate(cells) if cell.startswith(f' exercise="{name}"'))
    assert any(f'check("{name}")' in cell for cell in cells[asked + 1 :])


@pytest.mark.parametrize("name", EXERCISES)
def test_hidden_tests_are_worth_less_than_public_ones(name):
    hidden = sum(test.graded.points for test in EXERCISES[name].tests if test.graded.hidden)
    assert hidden < EXERCISES[name].points / 2 + 1e-9


@pytest.mark.parametrize("name", EXERCISES)
def test_the_reference_earns_every_point(name):
    assert failures(name, reference(name), hidden=False) == failures(name, reference(name), hidden=True) == []


@pytest.mark.parametrize("name", EXERCISES)
def test_an_empty_answer_is_said_to_be_empty(name):
    def empty(*arguments):
        raise NotImplementedError(f"{name} is not written yet")

    impl = as_impl(name, empty if inspect.isfunction(reference(name)) else None)
    assert all(run_test(test, impl).unwritten for test in EXERCISES[name].tests)
