"""Stubs: what goes, what stays, what is refused, and the package that answers may use while they are graded."""

import subprocess
import sys
from pathlib import Path

import pytest

import mcdenoise as mcd
from mcdenoise.classroom.building.hidden import public_tests, read_marks
from mcdenoise.classroom.building.stubs import solution_blocks, strip_solutions, stub_package, stub_source

SRC = Path(mcd.__file__).parent


@pytest.mark.parametrize(("module", "name"), [("gaussian", "gaussian_sums"), ("bilateral", "bilateral_sums")])
def test_the_stub_of_a_filter_keeps_its_contract_and_loses_its_body(module, name):
    source = (SRC / "filters" / f"{module}.py").read_text()
    stub = stub_source(source, name, module)
    assert stub.startswith(f"def {name}(")
    assert "total, norm : (h, w, c) and (h, w)." in stub
    assert stub.endswith(f'    # Your code here.\n    raise NotImplementedError("{name} is not written yet")\n')
    assert "bell(np.array" not in stub
    assert "SOLUTION" not in stub


def test_only_what_is_marked_goes():
    source = (
        "def half(x):\n    '''Half.'''\n    y = x\n    if y:\n"
        "        ### BEGIN SOLUTION\n        y = y / 2\n        ### END SOLUTION\n"
        "    return y  # stays\n\n\nname = None  # yours\n### BEGIN SOLUTION\nname = 3\n### END SOLUTION\n"
    )
    assert strip_solutions(source) == (
        "def half(x):\n    '''Half.'''\n    y = x\n    if y:\n        # Your code here.\n"
        '        raise NotImplementedError("half is not written yet")\n'
        "    return y  # stays\n\n\nname = None  # yours\n"
    )


def test_text_without_marks_stays_as_it_is():
    assert strip_solutions("no python: (\n") == "no python: (\n"


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("x = 1\n### BEGIN SOLUTION\nx = 2\n", r"f\.py:11: ### BEGIN SOLUTION has no end\. Write ### END SOLUTION"),
        ("### END SOLUTION\n", r"f\.py:10: ### END SOLUTION without a beginning"),
        ("### BEGIN SOLUTION\nx = 1\n### BEGIN SOLUTION\n", r"f\.py:12: .* inside a solution that is still open"),
        ("### BEGIN SOLUTION\n\n### END SOLUTION\n", r"f\.py:12: no solution stands between the marks"),
        ("x = 1  ### BEGIN SOLUTION\n", r"f\.py:10: a mark must stand alone on its line"),
    ],
)
def test_marks_that_do_not_pair_up_are_refused(source, message):
    with pytest.raises(ValueError, match=message):
        solution_blocks(source, "f.py", first_line=10)


def test_marked_text_that_is_no_python_is_refused():
    with pytest.raises(ValueError, match=r"f\.py:5: this is no valid Python"):
        strip_solutions("x = 1\n### BEGIN SOLUTION\nx = (\n### END SOLUTION\n", "f.py", first_line=3)


def test_a_reference_without_marks_and_a_missing_one_are_refused():
    with pytest.raises(ValueError, match=r"f\.py:2: half is an exercise but has no marked solution"):
        stub_source("\ndef half(x):\n    return x / 2\n", "half", "f.py")
    with pytest.raises(ValueError, match=r"f\.py: an exercise needs the function half here, but there is none"):
        stub_source("half = 2\n", "half", "f.py")


PUBLIC = '''"""Tests."""

import math
from os import path, sep

from mcdenoise.classroom import graded

LIMIT = 3  # used by both
SECRET = 4


def _both():
    return LIMIT


# About the hidden one.
@graded("f", points=1, hidden=True)
def test_hidden(impl):
    assert impl(SECRET) == _both() + math.pi, path
    # its last word


# A heading that stays.

@graded("f", points=2)
def test_public(impl):
    """Says SECRET in words only."""
    # a remark that stays
    assert impl(sep) == _both()
'''


def test_public_tests_keep_all_but_the_hidden_and_what_only_they_use():
    public = public_tests(PUBLIC)
    assert (
        public
        == '''"""Tests."""

from os import sep

from mcdenoise.classroom import graded

LIMIT = 3  # used by both


def _both():
    return LIMIT


# A heading that stays.

@graded("f", points=2)
def test_public(impl):
    """Says SECRET in words only."""
    # a remark that stays
    assert impl(sep) == _both()
'''
    )
    assert public_tests(public) == public


def test_marks_are_read_without_running_the_file():
    marks = read_marks("raise SystemExit\n" + PUBLIC)
    assert [(mark.name, mark.points, mark.hidden) for mark in marks] == [
        ("test_hidden", 1, True),
        ("test_public", 2, False),
    ]


@pytest.mark.parametrize("call", ['graded("f", points=1, hidden=SECRET)', 'graded("f")', "graded(name, points=1)"])
def test_a_mark_that_is_not_written_out_is_refused(call):
    with pytest.raises(ValueError, match=r"t\.py:1: the mark of test_f must be written out, such as @graded"):
        read_marks(f"@{call}\ndef test_f(impl):\n    assert impl\n", "t.py")


def _run(folder, code):
    command = [sys.executable, "-I", "-c", f"import sys; sys.path.insert(0, {str(folder)!r})\n{code}"]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder)


def test_the_stub_package_gives_what_is_given_and_refuses_the_rest(tmp_path):
    stub_package(tmp_path)
    done = _run(
        tmp_path,
        "import numpy as np, mcdenoise as mcd\n"
        "from mcdenoise import gaussian\n"
        "from mcdenoise.filters.window import bell, window_offsets\n"
        "assert mcd.__file__.startswith(sys.path[0])\n"
        "print(len(list(window_offsets(3, 3, 1))), bell(np.zeros(2), 1.0))\n"
        "for refused in (gaussian, mcd.filters.bilateral, mcd.variance_of_mean):\n"
        "    try:\n        refused(1, spp=2)\n    except RuntimeError as error:\n        print(error)\n",
    )
    assert done.stderr == ""
    assert done.stdout.splitlines() == [
        "9 1.0",
        "mcdenoise.gaussian is not available while grading: write it yourself.",
        "mcdenoise.bilateral is not available while grading: write it yourself.",
        "mcdenoise.variance_of_mean is not available while grading: write it yourself.",
    ]


def test_the_bell_is_there_after_the_front_door_alone(tmp_path):
    stub_package(tmp_path)
    done = _run(tmp_path, "import mcdenoise as mcd; print(mcd.filters.window.bell(0.0, 1.0))")
    assert (done.stderr, done.stdout) == ("", "1.0\n")


def test_the_stub_package_holds_no_reference(tmp_path):
    stub_package(tmp_path)
    done = _run(tmp_path, "from mcdenoise.filters.gaussian import gaussian_sums")
    assert "No module named 'mcdenoise.filters.gaussian'" in done.stderr
    texts = [path.read_text() for path in tmp_path.rglob("*.py")]
    assert not any("SOLUTION" in text or "total[here]" in text for text in texts)


def test_the_stub_package_has_every_name_of_the_front_door(tmp_path):
    stub_package(tmp_path)
    done = _run(tmp_path, "import mcdenoise; print(*vars(mcdenoise))")
    assert set(mcd.__all__) <= set(done.stdout.split())
