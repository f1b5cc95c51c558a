"""What grading gives: a grade a student, kept as JSON so that an interrupted run goes on, and as one table for all."""

from __future__ import annotations

import csv
import hashlib
import json
import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path

from mcdenoise.classroom.checking.exercise import Outcome
from mcdenoise.samples.storage import write_beside

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")


@dataclass(frozen=True)
class ExerciseGrade:
    """One exercise of one student.

    Attributes
    ----------
    exercise, chapter : names. outcomes : what each test said, in the order of the tests.
    printed : the first 4 kB of what the answer printed while it was graded.
    """

    exercise: str
    chapter: str
    outcomes: tuple[Outcome, ...]
    printed: str = ""

    @property
    def points(self) -> float:
        """The points of the tests that passed."""
        return sum(outcome.points for outcome in self.outcomes if outcome.passed)

    @property
    def of(self) -> float:
        """What all its tests are worth."""
        return sum(outcome.points for outcome in self.outcomes)

    @property
    def unwritten(self) -> bool:
        """Whether there is no answer yet."""
        return all(outcome.unwritten for outcome in self.outcomes)


@dataclass(frozen=True)
class Grade:
    """One student's grade; plain data, so that it travels between processes and machines.

    Attributes
    ----------
    student : name. exercises : in the order of the tests.
    sandbox : "bwrap" or "fence", see `sandbox`. problem : why the submission could not be read, or "".
    seconds : how long grading took. remark : what of it could not be read though the rest could, or "".
    """

    student: str
    exercises: tuple[ExerciseGrade, ...]
    sandbox: str
    problem: str = ""
    seconds: float = 0.0
    remark: str = ""

    @property
    def total(self) -> float:
        """All points."""
        return sum(exercise.points for exercise in self.exercises)

    @property
    def of(self) -> float:
        """All points that could be had."""
        return sum(exercise.of for exercise in self.exercises)

    @property
    def note(self) -> str:
        """One line for the table: what could not be read, what is not written, how it was run."""
        if self.problem:
            return self.problem
        missing = [exercise.exercise for exercise in self.exercises if exercise.unwritten]
        sandbox = "bubblewrap" if self.sandbox == "bwrap" else "no sandbox (fence only)"
        unwritten = (
            "nothing written yet" if len(missing) == len(self.exercises) else f"not written yet: {', '.join(missing)}"
        )
        return "; ".join([self.remark] * bool(self.remark) + [unwritten] * bool(missing) + [f"graded in: {sandbox}"])


def grade_to_json(grade: Grade) -> str:
    """Return a grade as JSON text.

    Examples
    --------
    >>> grade = Grade("ada", (ExerciseGrade("half", "ch02", (Outcome("test", "Half.", "half", 1, False, True),)),), "bwrap")
    >>> grade_from_json(grade_to_json(grade)) == grade
    True
    """
    return json.dumps(asdict(grade), indent=1)


def grade_from_json(text: str) -> Grade:
    """Read what `grade_to_json` wrote; raises ValueError, KeyError or TypeError if it is something else."""
    facts = json.loads(text)
    exercises = []
    for one in facts.pop("exercises"):
        outcomes = tuple(Outcome(**outcome) for outcome in one.pop("outcomes"))
        exercises.append(ExerciseGrade(outcomes=outcomes, **one))
    return Grade(exercises=tuple(exercises), **facts)


class ResultStore:
    """A folder with one JSON file a submission, named after all that its grade depends on.

    Parameters
    ----------
    folder : made when the first grade is stored. facts : what all have in common: limits, sandbox, tests.
    """

    def __init__(self, folder: Path, facts: Mapping[str, object], tests: Mapping[str, bytes]) -> None:
        self.folder = folder
        common = {**facts, "version": version("mcdenoise"), "tests": _digests(tests)}
        self._common = json.dumps(common, sort_keys=True)

    def path(self, student: str, contents: Mapping[str, bytes]) -> Path:
        """Return where the grade of a submission stands or would stand."""
        key = json.dumps([self._common, student, _digests(contents)])
        return self.folder / f"{hashlib.sha256(key.encode()).hexdigest()[:32]}.json"

    def load(self, student: str, contents: Mapping[str, bytes]) -> Grade | None:
        """Return the stored grade, or None if there is none that can be read."""
        try:
            return grade_from_json(self.path(student, contents).read_text(encoding="utf-8"))
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def save(self, grade: Grade, contents: Mapping[str, bytes]) -> None:
        """Store a grade."""
        self.folder.mkdir(parents=True, exist_ok=True)
        with write_beside(self.path(grade.student, contents)) as temporary:
            temporary.write_text(grade_to_json(grade), encoding="utf-8")


def _digests(contents: Mapping[str, bytes]) -> dict[str, str]:
    return {name: hashlib.sha256(content).hexdigest() for name, content in sorted(contents.items())}


def write_csv(grades: Sequence[Grade], path: Path) -> None:
    """Write the table: one row a student; columns student, total, of, one an exercise, note.

    Written beside `path` and renamed. A text that a spreadsheet would take for a formula gets an apostrophe in front.
    """
    exercises = list(dict.fromkeys(one.exercise for grade in grades for one in grade.exercises))
    with write_beside(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["student", "total", "of", *exercises, "note"])
        for grade in grades:
            points = {one.exercise: f"{one.points:g}" for one in grade.exercises}
            numbers = [f"{grade.total:g}", f"{grade.of:g}", *(points.get(name, "") for name in exercises)]
            rows.writerow([_cell(grade.student), *numbers, _cell(grade.note)])


def _cell(text: str) -> str:
    """Make a text safe for a spreadsheet: one line, no formula, no characters that a file cannot hold or nobody sees."""
    text = "".join(one for one in " ".join(text.split()) if unicodedata.category(one) not in ("Cc", "Cf"))
    text = re.sub(r";(?=[=+\-@])", "; ", text)  # some spreadsheets begin a new cell there
    text = text.encode("utf-8", "replace").decode("utf-8")
    return f"'{text}" if text.startswith(FORMULA_STARTS) else text


def summary(grades: Iterable[Grade]) -> str:
    """Return what a run gave in a few lines for the terminal."""
    grades = list(grades)
    problems = [f"  {_cell(grade.student)}: {_cell(grade.problem)}" for grade in grades if grade.problem]
    mean = sum(grade.total for grade in grades) / len(grades)
    lines = [f"{len(grades)} submissions, {mean:.3g} of {grades[0].of:g} points in the mean."]
    return "\n".join(lines + ([f"{len(problems)} could not be graded:", *problems] if problems else []))
