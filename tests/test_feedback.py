"""The page that a student gets: readable, whole, and harmless whatever the submission holds."""

import re
from html.parser import HTMLParser

import pytest

from mcdenoise.classroom.checking.exercise import Outcome
from mcdenoise.classroom.grading.feedback import feedback_page, shown, write_feedback
from mcdenoise.classroom.grading.results import ExerciseGrade, Grade

EVIL = "<script>alert('x')</script><img src=x onerror=alert(1)> \"'&"
FINDING = "response to an impulse: transposed: rows come first; worst entry (0, 3): yours 1, expected 2."


def outcome(points=1.0, hidden=False, passed=False, message=FINDING, sentence="The bell, centred.", unwritten=False):
    return Outcome("test_it", sentence, "blur", points, hidden, passed, "" if passed else message, unwritten)


def grade(*outcomes, student="ada", printed="", **changes):
    return Grade(student, (ExerciseGrade("blur", "ch02", outcomes, printed),), **{"sandbox": "bwrap", **changes})


class Page(HTMLParser):
    """Collects the tags and the text of a page."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes, self.words = [], [], []
        self.feed(text)
        self.text = " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes += [name for name, _ in attributes]

    def handle_data(self, data):
        self.words.append(data)


def test_a_page_says_points_tests_and_diagnosis():
    page = Page(feedback_page(grade(outcome(2, passed=True), outcome(1.5))))
    assert "2 of 3.5 points" in page.text
    assert "✓ holds The bell, centred. 2 of 2" in page.text
    assert f"✗ fails The bell, centred. {FINDING} 0 of 1.5" in page.text
    assert "bubblewrap" in page.text


def test_code_in_words_is_shown_as_code():
    page = feedback_page(grade(outcome(message="modified its input `image<1>`: work on a copy.")))
    assert "modified its input <code>image&lt;1&gt;</code>: work on a copy." in page


def test_nothing_that_a_student_writes_becomes_html():
    evil = grade(outcome(message=EVIL), outcome(hidden=True, message=EVIL), student=EVIL, printed=EVIL, problem="")
    for text in (feedback_page(evil), feedback_page(grade(student=EVIL, problem=EVIL))):
        page = Page(text)
        assert not {"script", "img"} & set(page.tags)
        assert not [name for name in page.attributes if name.startswith("on")]
        assert page.text.count("<script>alert('x')</script>") >= 2
        assert "Content-Security-Policy\" content=\"default-src 'none'" in text


def test_a_page_needs_no_other_file_and_no_network():
    assert not re.search(r"https?:|src=|href=|url\(|@import", feedback_page(grade(outcome())))


def test_what_all_tests_say_alike_is_said_once():
    page = Page(feedback_page(grade(*[outcome(message="not written yet.", unwritten=True)] * 4)))
    assert page.text.count("not written yet.") == 1
    assert page.text.count("○ open") == 4


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (FINDING, "transposed: rows come first"),
        (
            "the mean: 3 entries of 9 are NaN (0/0?), first at (4, 3), all others are right; worst entry",
            "3 entries of 9 are NaN",
        ),
        ("modified its input `image`: work on a copy.", "modified its input `image`"),
        ("more than 2 s on an array of shape (9, 7): is there an endless loop?", "more than 2 s"),
        ("stopped with IndexError: index 9 is out of bounds, in line 3: `x[9]`", "stopped with IndexError"),
        ("gives back an object of type Evil: return an array", "gives back an object of type Evil"),
        ("not written yet.", "not written yet."),
    ],
)
def test_of_a_hidden_test_the_diagnosis_is_shown_without_inputs(message, words):
    assert shown(outcome(hidden=True, message=message)) == words
    assert shown(outcome(message=message)) == message
    page = Page(feedback_page(grade(outcome(hidden=True, message=message), outcome(passed=True))))
    assert "(hidden test)" in page.text
    assert "worst entry" not in page.text


def test_prints_are_shown_and_their_absence_is_not():
    assert "Printed while it was graded: hello <b>" in Page(feedback_page(grade(outcome(), printed="hello <b>\n"))).text
    assert "Printed" not in feedback_page(grade(outcome(), printed=" \n"))


def test_a_missing_sandbox_and_a_problem_are_said():
    assert "Graded without a sandbox." in feedback_page(grade(outcome(), sandbox="fence"))
    page = Page(feedback_page(grade(outcome(message="x"), problem="ada.ipynb is no whole notebook.")))
    assert page.text.count("is no whole notebook") == 1
    assert "✗" not in page.text


def test_pages_are_files_named_after_students(tmp_path):
    paths = write_feedback([grade(outcome()), grade(outcome(), student="$total \udcff")], tmp_path / "new" / "feedback")
    assert [path.name for path in paths] == ["ada.html", "$total \udcff.html"]
    assert "<h1>$total ?</h1>" in paths[1].read_text(encoding="utf-8")
    (tmp_path / "file").touch()
    with pytest.raises(ValueError, match="folder that can be written to is needed for the feedback"):
        write_feedback([grade(outcome())], tmp_path / "file")
