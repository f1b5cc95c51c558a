"""check("name"): typical wrong students get the words meant for them; the report as text, HTML and in a real kernel."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import toy_exercise
from mcdenoise.classroom import Finding, check
from mcdenoise.classroom.checking.check import find_tests
from mcdenoise.classroom.checking.report import Report

RIGHT = """
import numpy as np
def blur(image, sigma_space, radius):
    image = np.asarray(image, float)
    total, norm = np.zeros_like(image), np.zeros(image.shape[:2])
    height, width = norm.shape
    for y in range(height):
        for x in range(width):
            top, bottom = max(0, y - radius), min(height, y + radius + 1)
            left, right = max(0, x - radius), min(width, x + radius + 1)
            dy, dx = np.mgrid[top - y:bottom - y, left - x:right - x]
            weight = np.exp(-(dy**2 + dx**2) / (2 * sigma_space**2))
            total[y, x] = (weight[..., np.newaxis] * image[top:bottom, left:right]).sum(axis=(0, 1))
            norm[y, x] = weight.sum()
    return total / norm[..., np.newaxis]
"""


def but(old, new):
    """The right answer with one mistake."""
    assert RIGHT.count(old) == 1
    return RIGHT.replace(old, new)


RETURN = "return total / norm[..., np.newaxis]"
WRONG = {
    "empty": (but(RETURN, "raise NotImplementedError('blur')"), "not written yet."),
    "no return": (but("    " + RETURN, ""), "nothing came back (None): is the `return` missing?"),
    "typing error": (but("= weight.sum()", "= wieght.sum()"), "NameError: name 'wieght' is not defined, in line"),
    "own line": (but("= weight.sum()", "= wieght.sum()"), "`norm[y, x] = wieght.sum()`"),
    "both sums": (but(RETURN, "return total, norm"), "a tuple of 2 (an array of shape (19, 19, 1), an array of shape"),
    "not divided": (but(RETURN, "return total"), "not normalised: a constant factor of 14.07; worst"),
    "no 2": (but("(2 * sigma_space**2)", "sigma_space**2"), "the bell is 0.7071 times as wide as it should be"),
    "sigma for sigma^2": (but("sigma_space**2", "sigma_space"), "the bell is 0.8165 times as wide as it should be"),
    "sign in the exponent": (but("np.exp(-(", "np.exp(("), "relative error"),
    "off centre": (
        but(RETURN, "return np.roll(total / norm[..., np.newaxis], 1, axis=1)"),
        "off centre by (dy, dx) = (0, +1)",
    ),
    "transposed": (
        but(RETURN, "return (total / norm[..., np.newaxis]).swapaxes(0, 1)"),
        "transposed: shape (13, 12, 2)",
    ),
    "factor": (but(RETURN, "return 2 * total / norm[..., np.newaxis]"), "a constant factor of 2; worst entry"),
    "sign": (but(RETURN, "return -total / norm[..., np.newaxis]"), "the sign is flipped"),
    "one channel": (
        but(RETURN, "return (total / norm[..., np.newaxis])[..., 0]"),
        "the last axis (channels) is missing",
    ),
    "BGR": (but(RETURN, "return (total / norm[..., np.newaxis])[..., ::-1]"), "channels exchanged: BGR"),
    "integers": (but(RETURN, "return (total / norm[..., np.newaxis]).astype(int)"), "whole numbers came back (int64)"),
    "NaN": (but("= weight.sum()", "= weight.sum() * (y > 0)"), "19 entries of 361 are NaN (0/0?), first at (0, 0, 0)"),
    "NaN warned": (
        but("= weight.sum()", "= weight.sum() * (y > 0)"),
        "(NumPy warned: invalid value encountered in divide, line",
    ),
    "own input": (
        but("= np.asarray(image, float)", "*= 1.0; image /= 2"),
        "modified its input `image`: work on a copy",
    ),
    "centre skipped": (but("weight = np", "weight = (dy**2 + dx**2 > 0) * np"), "relative error"),
    "window too small": (but("y + radius + 1", "y + radius"), "relative error"),
    "padded with 0": (
        but("norm[y, x] = weight.sum()", "norm[y, x] = 1 / 6.2690").replace("total / norm", "total * norm"),
        "a constant factor of",
    ),
    "wrong arguments": (
        but("(image, sigma_space, radius)", "(image, sigma_space)"),
        "`blur(image, sigma_space)` cannot be called",
    ),
    "exits": (but(RETURN, "raise SystemExit"), "ends the whole program (SystemExit), in line 15: `raise SystemExit`"),
    "recursion": (
        but(RETURN, "return blur(image, sigma_space, radius)").replace("for y in range(height)", "for y in ()"),
        "calls itself",
    ),
    "wrong shapes": (
        but("norm[..., np.newaxis]", "norm[3:]"),
        "stopped with ValueError: operands could not be broadcast",
    ),
    "used for a result": (
        RIGHT + "blur = blur(np.ones((3, 3, 1)), 1.0, 1)",
        "`blur` is no function but an array of shape (3, 3, 1)",
    ),
    "a text": (but(RETURN, "return 'done'"), "the text 'done' came back"),
    "not a number": ("peak = 'large'", "`peak` is the text 'large', which does not fit the question"),
    "another number": ("peak = 0.5", "the peak is near 0.0707, you said 0.5000"),
    "no answer": ("peak = None", "not answered yet."),
    "dots": ("peak = ...", "not answered yet."),
    "function for a number": ("def peak(): return 0.07", "`peak` is a function; a value is asked for."),
    "one for two": (
        "def blur_sums(image, s, r): return image",
        "returned an array of shape (19, 19, 1); 2 results are needed",
    ),
    "none for two": ("def blur_sums(image, s, r): image", "returned nothing (None): is the `return` missing?"),
    "three for two": (
        "def blur_sums(image, s, r): return 1, 2, 3",
        "returned a tuple of 3 (the number 1, the number 2",
    ),
    "number for two": ("def blur_sums(image, s, r): return 7.5", "returned the number 7.5; several results are needed"),
    "no arrays": (
        "def blur_sums(image, s, r): return 1, 2",
        "which does not fit (TypeError: 'int' object is not subscriptable)",
    ),
}


@pytest.fixture
def course(tmp_path):
    """A student's folder: tests/exercises/test_ch02.py, and notebooks beside it."""
    folder = tmp_path / "tests" / "exercises"
    folder.mkdir(parents=True)
    (folder / "test_ch02.py").write_text(Path(toy_exercise.__file__).read_text())
    (tmp_path / "notebooks").mkdir()
    return tmp_path


def defined(source, course):
    """Run a student's code from a file, so that messages can quote its lines."""
    path = course / "notebooks" / "answer.py"
    path.write_text(source)
    namespace = {"__name__": "answer", "__file__": str(path), "check": check}
    exec(compile(source, str(path), "exec"), namespace)
    return namespace


def checked(name, source, course):
    return eval(f"check({name!r})", defined(source, course))


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_answer_gets_the_words_meant_for_it(case, course, capsys):
    source, words = WRONG[case]
    name = re.findall(r"^(?:def )?(peak|blur_sums|blur)\b", source, re.MULTILINE)[0]
    report = checked(name, source, course)
    assert not report.passed
    messages = [one.message for one in report.outcomes]
    assert any(words in message for message in messages), messages
    out = capsys.readouterr().out
    assert out == f"{report}\n"
    assert "Traceback" not in out + report._repr_html_()


def test_the_right_answer_passes(course, capsys):
    report = checked("blur", RIGHT, course)
    assert report.passed
    assert capsys.readouterr().out.startswith("blur: all tests hold.\n  holds  The response to an impulse is the bell")
    assert len(report.outcomes) == 3, "hidden tests stay out"
    assert checked("peak", "peak = 0.0708", course).passed
    assert "the test holds." in capsys.readouterr().out


def test_a_list_passes_where_an_array_is_meant(course):
    assert checked("blur", RIGHT.replace(RETURN, "return (total / norm[..., np.newaxis]).tolist()"), course).passed


def test_an_answer_of_another_module_or_a_later_definition_can_be_given(course):
    namespace = defined(RIGHT, course)
    assert check("blur", namespace["blur"], tests=course / "tests" / "exercises").passed
    namespace["blur"] = lambda image, sigma_space, radius: -image
    assert not eval("check('blur')", namespace).passed


def test_messages_that_repeat_are_given_once(course, capsys):
    checked("blur", but("= weight.sum()", "= wieght.sum()"), course)
    out = capsys.readouterr().out
    assert out.count("NameError") == 1
    assert out.count("(as above)") == 2


def test_an_empty_exercise_is_one_line(course, capsys):
    checked("blur", WRONG["empty"][0], course)
    assert capsys.readouterr().out == ("blur: not written yet. Fill in the cell of blur, run it, and check again.\n")


def test_an_endless_loop_is_stopped_once_for_all_tests(course, monkeypatch):
    from mcdenoise.classroom.checking import implementation

    monkeypatch.setattr(implementation.LocalImplementation.__init__, "__kwdefaults__", {"seconds": 0.2})
    report = checked("blur", but("weight = np", "while True: pass\n            weight = np"), course)
    words = "more than 0.2 s on an array of shape (19, 19, 1): is there an endless loop?"
    assert [one.message for one in report.outcomes] == [words] * 3


def test_an_except_of_the_students_does_not_catch_the_time_limit(course, monkeypatch):
    from mcdenoise.classroom.checking import implementation

    monkeypatch.setattr(implementation.LocalImplementation.__init__, "__kwdefaults__", {"seconds": 0.2})
    source = "def blur(image, sigma_space, radius):\n while True:\n  try: 1 / 0\n  except Exception: pass"
    assert "endless loop" in checked("blur", source, course).outcomes[0].message


def test_prints_are_shown_up_to_a_limit(course, capsys):
    checked("blur", RIGHT.replace("    height, width", "    print('x' * 900)\n    height, width"), course)
    out = capsys.readouterr().out
    assert out.count("x" * 900) == 2
    assert "(the rest of your prints is not shown)" in out
    assert len(out) < 3000


PROBLEMS = {
    "check('blurr')": "there is no exercise of this name. Did you mean blur? The exercises are: blur, blur_sums, peak.",
    "check('zzz')": "there is no exercise of this name. The exercises are: blur, blur_sums, peak.",
    "check('peak')": "peak is not defined yet: run its cell first, then check again.",
    "check(blur)": 'the name belongs in quotes: check("blur").',
    "check('blur', tests='nowhere')": "nowhere holds no exercise tests: a file test_chNN.py is needed.",
}


@pytest.mark.parametrize("call", PROBLEMS)
def test_what_cannot_be_checked_is_said(call, course, capsys):
    report = eval(call, defined(RIGHT, course))
    assert not report.passed
    assert capsys.readouterr().out == f"{report.name}: {PROBLEMS[call]}\n"


def test_nothing_is_written_to_standard_error(course, capsys):
    checked("blur_sums", "def blur_sums(image, s, r):\n    return 0 * image / 0, 0 * image[..., 0]", course)
    assert capsys.readouterr().err == ""


def test_tests_are_found_beside_and_above(course, tmp_path_factory):
    assert find_tests(course) == find_tests(course / "notebooks") == course / "tests" / "exercises"
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    with pytest.raises(ValueError, match=r"no tests found: looked for tests/exercises/test_chNN\.py in .*elsewhere"):
        find_tests(elsewhere)


def test_a_notebook_of_another_editor_says_where_it_lies(course):
    namespace = defined(RIGHT, course)
    del namespace["__file__"]
    namespace["__vsc_ipynb_file__"] = str(course / "notebooks" / "ch02_gaussian.ipynb")
    assert eval("check('blur')", namespace).passed


def test_strict_raises_where_a_check_does_not_pass(course, monkeypatch):
    monkeypatch.setenv("MCDENOISE_STRICT", "1")
    assert checked("blur", RIGHT, course).passed
    with pytest.raises(Finding, match="a constant factor of 2"):
        checked("blur", WRONG["factor"][0], course)
    with pytest.raises(Finding, match="no exercise of this name"):
        checked("blurr", RIGHT, course)


def test_the_html_has_symbols_and_words_and_escapes(course):
    page = checked("blur", but(RETURN, "raise ValueError('<b>&')"), course)._repr_html_()
    assert "✗ wrong" in page
    assert "ValueError: &lt;b&gt;&amp;" in page
    assert "<code>raise ValueError(&#x27;&lt;b&gt;&amp;&#x27;)</code>" in page
    assert "✓ holds" in checked("blur", RIGHT, course)._repr_html_()
    assert "○ open" in Report("blur", problem="gone")._repr_html_()


def test_the_text_is_ascii_for_any_terminal(course):
    for name, source in (("blur", RIGHT), ("blur", WRONG["NaN"][0])):
        assert str(checked(name, source, course)).isascii()


def test_a_plain_script_prints_the_report_once_and_has_no_picture(course):
    script = course / "notebooks" / "ch02.py"
    script.write_text("from mcdenoise.classroom import check\n" + RIGHT + "report = check('blur')\nprint(report.image)")
    run = subprocess.run([sys.executable, script], cwd="/", capture_output=True, text=True, check=True)
    assert run.stderr == ""
    assert run.stdout.count("blur: all tests hold.") == 1
    assert run.stdout.endswith("None\n")


CELLS = [
    "from mcdenoise.classroom import check\nimport matplotlib.pyplot as plt",
    RIGHT,
    "check('blur')",  # last in its cell
    "report = check('blur')\n1 + 1",  # not last
    "report",  # asked for again
    "variable = [0.5]\nfor variable in [0.25]: pass\n"
    + RIGHT.replace("np.exp(", "variable / variable * np.exp(")
    + "check('blur');",
    "def blur(image, sigma_space, radius):\n    return 2 * imgae",
    "check('blur')",
    "%%time\ncheck('zzz')",
]


@pytest.fixture(scope="module")
def executed(tmp_path_factory):
    """The outputs of CELLS in a real kernel."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    folder = tmp_path_factory.mktemp("course")
    (folder / "tests" / "exercises").mkdir(parents=True)
    (folder / "tests" / "exercises" / "test_ch02.py").write_text(Path(toy_exercise.__file__).read_text())
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(source) for source in CELLS])
    resources = {"metadata": {"path": str(folder)}}
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("IPYTHONDIR", str(folder / "ipython"))
        nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3", resources=resources).execute()
    return [cell.outputs for cell in notebook.cells]


def shown(outputs):
    return [one.data["text/html"] for one in outputs if "text/html" in one.get("data", {})]


def test_in_a_kernel_a_report_is_displayed_once_wherever_the_call_stands(executed):
    last, inside, again = executed[2:5]
    assert len(last) == 1
    assert "✓ right" in shown(last)[0]
    assert last[0].data["text/plain"].startswith("blur: all tests hold.")
    assert len(shown(inside)) == 1
    assert inside[-1].data["text/plain"] == "2"
    assert len(shown(again)) == len(again) == 1


def test_in_a_kernel_the_picture_stands_in_the_report(executed):
    page = shown(executed[2])[0]
    assert page.count("data:image/png;base64,iVBOR") == 1
    assert "its target" in page or "what it should be" in page
    assert "data:image" not in shown(executed[7])[0]


def test_in_a_kernel_errors_quote_the_line_of_the_cell(executed):
    assert "in line 2: <code>return 2 * imgae</code>" in shown(executed[7])[0]
    assert all(one.output_type != "error" for outputs in executed for one in outputs)


def test_in_a_kernel_the_note_says_what_grading_will_not_take(executed):
    page = shown(executed[5])[0]
    assert "✓ right" in page
    assert (
        "when graded, this will not work: <code>blur</code> uses the notebook&#x27;s variable <code>variable</code>"
        in page
    )
    assert "when graded" not in shown(executed[2])[0]


def test_in_a_kernel_an_unknown_exercise_is_said(executed):
    assert "there is no exercise of this name" in shown(executed[8])[0]
