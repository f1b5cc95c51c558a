"""nbgrader, but graded out of process: nothing of a submission runs in nbgrader's kernel, and no cell of it is believed.

nbgrader's own steps would run a submission in a kernel together with the tests. `configure` puts two steps of ours in
their place: one that takes over from a submission only the text of its cells, and one that grades with
`mcdenoise.classroom.grading.grade` and writes each exercise's points and feedback as the output of its locked cell,
where nbgrader reads them.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcdenoise.classroom.building.nbgrader_course import CHECK, grade_cell, solution_cell

if TYPE_CHECKING:
    from nbformat import NotebookNode


def configure(c: Any, tests: Path) -> None:
    """Set nbgrader's configuration `c` so that assignments are made from our stubs and graded by `tests`.

    Parameters
    ----------
    c : the configuration object of nbgrader_config.py.
    tests : folder with all tests, test_chNN.py; an assignment chNN is graded by its own file.
    """
    from nbgrader.preprocessors import (
        AssignLatePenalties,
        CheckCellMetadata,
        ClearOutput,
        ComputeChecksums,
        LockCells,
        NbGraderPreprocessor,
        OverwriteKernelspec,
        SaveAutoGrades,
        SaveCells,
    )

    class RestoreCells(NbGraderPreprocessor):
        """Take the text of the submission and everything else from the gradebook."""

        def preprocess(self, nb: NotebookNode, resources: dict) -> tuple[NotebookNode, dict]:
            return restore_cells(nb, **_cells_of_record(resources["nbgrader"])), resources

    class GradeOutOfProcess(NbGraderPreprocessor):
        """Write the points and the feedback of each exercise below its locked cell."""

        def preprocess(self, nb: NotebookNode, resources: dict) -> tuple[NotebookNode, dict]:
            about = resources["nbgrader"]
            return write_grades(nb, tests / f"test_{about['assignment']}.py", about["student"]), resources

    # Ours hold stubs already: nbgrader's ClearSolutions would replace them by its own.
    c.GenerateAssignment.preprocessors = [LockCells, ClearOutput, CheckCellMetadata, ComputeChecksums, SaveCells]
    c.Autograde.sanitize_preprocessors = [ClearOutput, OverwriteKernelspec, RestoreCells, CheckCellMetadata]
    c.Autograde.autograde_preprocessors = [GradeOutOfProcess, SaveAutoGrades, AssignLatePenalties, CheckCellMetadata]


def _cells_of_record(about: dict) -> dict[str, dict]:
    """What the gradebook knows of a notebook: its graded cells, and nbgrader's metadata of the cells for answers."""
    from nbformat.v4 import new_code_cell
    from nbgrader.api import Gradebook

    with Gradebook(about["db_url"]) as book:
        notebook = book.find_notebook(about["notebook"], about["assignment"])
        points = {cell.name: cell.max_score for cell in notebook.grade_cells}
        graded, answers = {}, {}
        for cell in notebook.source_cells:
            checksum = {"checksum": cell.checksum}
            if cell.name in points:
                marks = grade_cell(cell.name.removeprefix(CHECK), points[cell.name]) | checksum
                graded[cell.name] = new_code_cell(cell.source, metadata={"nbgrader": marks})
            else:
                answers[cell.name] = solution_cell(cell.name) | checksum
    return {"graded": graded, "answers": answers}


def restore_cells(nb: NotebookNode, graded: dict[str, dict], answers: dict[str, dict]) -> NotebookNode:
    """Return the notebook with every graded cell as it was released, wherever a student changed, moved or deleted it.

    Parameters
    ----------
    nb : a submission. graded : grade id -> cell as released. answers : grade id -> nbgrader's metadata of the cell.
    """
    left = {**graded, **answers}
    cells = []
    for cell in nb.cells:
        marks = cell.metadata.pop("nbgrader", None)
        name = marks.get("grade_id") if isinstance(marks, dict) else None
        released = left.pop(name, None) if isinstance(name, str) and cell.cell_type == "code" else None
        if released is not None and name in answers:
            cell.metadata["nbgrader"] = released
        cells.append(released if released is not None and name in graded else cell)
    nb.cells = cells + [cell for name, cell in left.items() if name in graded]
    return nb


def write_grades(nb: NotebookNode, tests: Path, student: str) -> NotebookNode:
    """Grade a restored notebook out of process; each graded cell gets its points and its feedback as output.

    Raises
    ------
    ValueError
        If the tests are worth something else than what was released.
    """
    import nbformat

    from mcdenoise.classroom.checking.report import Report
    from mcdenoise.classroom.grading.feedback import shown
    from mcdenoise.classroom.grading.marking import grade_submission

    grade = grade_submission(student, nbformat.writes(nb), ".ipynb", tests)
    exercises = {one.exercise: one for one in grade.exercises}
    for cell in nb.cells:
        marks = cell.metadata.get("nbgrader", {})
        if not marks.get("grade"):
            continue
        one = exercises.get(marks["grade_id"].removeprefix(CHECK))
        if one is None or one.of != marks["points"]:
            raise ValueError(
                f"{marks['grade_id']} was released for {marks['points']:g} points, but {tests.name} gives "
                f"{one.of if one else 0:g}. Build again and run nbgrader generate_assignment, or restore the old tests."
            )
        said = Report(one.exercise, tuple(replace(test, message=shown(test)) for test in one.outcomes))
        cell.outputs = [
            nbformat.v4.new_output("display_data", {"text/html": said._repr_html_(), "text/plain": str(said)}),
            nbformat.v4.new_output("execute_result", {"text/plain": repr(float(one.points))}),
        ]
    return nb
