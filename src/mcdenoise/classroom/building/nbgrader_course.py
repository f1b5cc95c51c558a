"""What nbgrader needs to know of a chapter: the metadata of its cells, and the configuration of the course folder."""

from __future__ import annotations

CHECK = "check_"
CONFIG = '''"""nbgrader's configuration of this course: exercises are graded out of process, by mcdenoise."""

from pathlib import Path

from mcdenoise.classroom.building.nbgrader_grade import configure

c = get_config()  # noqa: F821
c.CourseDirectory.course_id = "mcdenoise"
configure(c, tests=Path(__file__).parent / "tests" / "exercises")
'''


def solution_cell(exercise: str) -> dict:
    """Return nbgrader's metadata (schema 3) for the cell in which a student answers.

    Examples
    --------
    >>> solution_cell("lens_blur")["grade_id"]
    'lens_blur'
    """
    return _metadata(exercise, solution=True)


def grade_cell(exercise: str, points: float) -> dict:
    """Return nbgrader's metadata (schema 3) for the locked cell that is worth the exercise's points.

    Examples
    --------
    >>> grade_cell("lens_blur", 3)["grade_id"]
    'check_lens_blur'
    """
    return _metadata(CHECK + exercise, grade=True, locked=True) | {"points": points}


def _metadata(grade_id: str, grade: bool = False, locked: bool = False, solution: bool = False) -> dict:
    return {
        "cell_type": "code",
        "grade": grade,
        "grade_id": grade_id,
        "locked": locked,
        "schema_version": 3,
        "solution": solution,
        "task": False,
    }
