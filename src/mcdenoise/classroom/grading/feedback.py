"""One page of feedback a student: a single HTML file without scripts, which opens offline."""

from __future__ import annotations

import hashlib
import html
import re
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from string import Template

from mcdenoise.classroom.checking.exercise import Outcome
from mcdenoise.classroom.grading.results import ExerciseGrade, Grade
from mcdenoise.samples.storage import write_beside

SANDBOXES = {"bwrap": "Graded in a sandbox (bubblewrap).", "fence": "Graded without a sandbox."}
MARKS = {"good": "✓ holds", "bad": "✗ fails", "open": "○ open"}

# How the words of the guard around a function begin; those of `assert_matches` begin with what was compared.
GUARD_WORDS = re.compile(
    r"stopped|modified|more than|ended|ends|calls|asks|gives|gave|returned|was |crashed|sent|cut|not "
)


def write_feedback(grades: Sequence[Grade], folder: Path) -> list[Path]:
    """Write one page a student, `STUDENT.html`, into `folder` (made if missing); returns the paths.

    Raises
    ------
    ValueError
        If the folder cannot be made or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        paths = []
        for grade in grades:
            paths.append(folder / page_name(grade.student))
            with write_beside(paths[-1]) as temporary:
                temporary.write_text(feedback_page(grade), encoding="utf-8", errors="replace")
    except OSError as error:
        raise ValueError(
            f"A folder that can be written to is needed for the feedback, got {folder}: {error}."
        ) from error
    return paths


def page_name(student: str) -> str:
    """Return the name of a student's page; a name too long for a file is cut, and told apart by a hash.

    Examples
    --------
    >>> page_name("ada"), len(page_name(300 * "b"))
    ('ada.html', 193)
    """
    written = student.encode("utf-8", "replace")
    if len(written) > 200:
        student = f"{written[:180].decode('utf-8', 'ignore')}-{hashlib.sha256(written).hexdigest()[:7]}"
    return f"{student}.html"


def feedback_page(grade: Grade) -> str:
    """Return a student's page as HTML; all that comes from the submission is escaped, and no script can run.

    Of a hidden test it shows the sentence and the first clause of the diagnosis: what went wrong, not the numbers.
    """
    template = Template(
        resources.files("mcdenoise.classroom.grading").joinpath("feedback_template.html").read_text("utf-8")
    )
    warning = grade.problem or grade.remark
    problem = f'<p class="warn">{html.escape(warning)}</p>' if warning else ""
    return template.substitute(
        student=html.escape(grade.student),
        total=f"{grade.total:g}",
        of=f"{grade.of:g}",
        problem=problem,
        exercises="" if problem else "\n".join(_exercise(one) for one in grade.exercises),
        sandbox=SANDBOXES.get(grade.sandbox, ""),
    )


def _exercise(grade: ExerciseGrade) -> str:
    """The box of one exercise; what all tests say alike is said once."""
    same = {outcome.message for outcome in grade.outcomes}
    alike = len(same) == 1 and "" not in same and not any(one.hidden for one in grade.outcomes[:1])
    parts = [
        "<section>",
        f"<header><h2><code>{html.escape(grade.exercise)}</code></h2>",
        f'<span class="points">{grade.points:g} of {grade.of:g}</span></header>',
    ]
    if alike:
        parts.append(f'<p class="what bad">{_words(same.pop())}</p>')
    parts += ["<ul>", *(_test(one, alike) for one in grade.outcomes), "</ul>"]
    if grade.printed.strip():
        parts.append(f'<p class="dim">Printed while it was graded:</p><pre>{html.escape(grade.printed)}</pre>')
    return "\n".join([*parts, "</section>"])


def _test(outcome: Outcome, alike: bool) -> str:
    """One line: passed or not, what holds, what is wrong."""
    state = "good" if outcome.passed else "open" if outcome.unwritten else "bad"
    mark = f'<span class="mark {state}">{MARKS[state]}</span>'
    kind = ' <span class="dim">(hidden test)</span>' if outcome.hidden else ""
    said = "" if outcome.passed or alike else shown(outcome)
    what = f'<p class="what bad">{_words(said)}</p>' if said else ""
    points = f"{outcome.points if outcome.passed else 0:g} of {outcome.points:g}"
    sentence = _words(outcome.sentence)
    return f'<li>{mark}<div>{sentence}{kind}{what}</div><span class="points dim">{points}</span></li>'


def shown(outcome: Outcome) -> str:
    """Return what a student may read of a diagnosis: all of it, or of a hidden test its first clause, without numbers.

    Examples
    --------
    >>> words = "the mean: a constant factor of 2; worst entry (0, 3): yours 4, expected 2."
    >>> shown(Outcome("test", "", "blur", 1, True, False, words))
    'a constant factor of 2'
    >>> shown(Outcome("test", "", "blur", 1, True, False, "modified its input `image`: work on a copy."))
    'modified its input `image`'
    """
    if not outcome.hidden:
        return outcome.message
    clause = re.split(r"; | \(|, first at |, in line | on an array", outcome.message)[0]
    first, _, second = clause.partition(": ")
    return first if GUARD_WORDS.match(clause) or not second else second


def _words(text: str) -> str:
    """Escape a text; what stands between back quotes is code."""
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", html.escape(text))
