"""Marks, loading and running of exercise tests; the guard around a student's function; the pytest plugin."""

import functools
import json
import linecache
import pickle
import signal
import sys
import threading
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

import toy_exercise
from mcdenoise.classroom import Finding, graded
from mcdenoise.classroom.checking.exercise import (
    LocalImplementation,
    Unwritten,
    as_impl,
    load_tests,
    run_test,
    sentence_of,
)
from mcdenoise.classroom.checking.implementation import place, place_in_source, time_limit
from mcdenoise.classroom.checking.pytest_plugin import load_answer

TOY = Path(toy_exercise.__file__).read_text()
EXERCISES = Path(__file__).parent / "exercises"


def call(function, *arguments, **keywords):
    """What the guard says when the function is called."""
    with pytest.raises(Finding) as raised:
        LocalImplementation("f", function)(*arguments, **keywords)
    return str(raised.value)


@pytest.fixture
def folder(tmp_path):
    exercises = tmp_path / "tests" / "exercises"
    exercises.mkdir(parents=True)
    (exercises / "test_ch02.py").write_text(TOY)
    return exercises


def test_exercises_come_in_the_order_of_the_file(folder):
    exercises = load_tests(folder)
    assert list(exercises) == ["blur", "blur_sums", "peak"]
    blur = exercises["blur"]
    assert (blur.name, blur.chapter, blur.points) == ("blur", "ch02", 6)
    assert [test.__name__ for test in blur.tests] == [
        "test_an_impulse_gives_the_bell",
        "test_flat_stays_flat",
        "test_any_image",
        "test_a_wide_window",
    ]
    assert [test.graded.hidden for test in blur.tests] == [False, False, False, True]
    assert [draw.__name__ for draw in blur.pictures] == ["picture_blur"]
    assert list(load_tests(folder / "test_ch02.py")) == list(exercises)


def test_loading_leaves_nothing_behind_and_sees_every_change(folder):
    modules = set(sys.modules)
    load_tests(folder)
    assert set(sys.modules) == modules
    assert [one.name for one in folder.iterdir()] == ["test_ch02.py"]
    (folder / "test_ch02.py").write_text(TOY.replace('"peak"', '"summit"'))
    assert "summit" in load_tests(folder)


def test_folders_that_hold_no_tests_are_refused(folder, tmp_path):
    for place_ in (tmp_path, tmp_path / "gone", tmp_path / "test_ch09.py"):
        with pytest.raises(ValueError, match=r"holds no exercise tests: a file test_chNN\.py is needed"):
            load_tests(place_)
    (folder / "test_ch03.py").write_text(TOY)
    with pytest.raises(ValueError, match=r"test_ch03\.py: the exercise blur already has tests in test_ch02\.py"):
        load_tests(folder)
    for source, words in (("def", "SyntaxError"), ("1 / 0", "ZeroDivisionError"), ("raise SystemExit", "SystemExit")):
        (folder / "test_ch03.py").write_text(source)
        with pytest.raises(ValueError, match=rf"test_ch03\.py does not run: {words}"):
            load_tests(folder)


@pytest.mark.parametrize("points", [0, -1, float("nan")])
def test_points_are_above_0(points):
    with pytest.raises(ValueError, match="points must be above 0, got"):
        graded("f", points=points)


def test_a_test_without_docstring_is_named_by_its_name():
    def test_the_sky_is_blue(impl):
        pass

    assert sentence_of(test_the_sky_is_blue) == "the sky is blue"


@pytest.fixture
def needs_two(tmp_path):
    path = tmp_path / "test_ch09.py"
    path.write_text(
        "from mcdenoise.classroom import graded\n@graded('f', points=1)\ndef test_two(impl):\n    'Two results.'\n"
        "    first, second = impl(1)\n    assert first < second\n"
    )
    return load_tests(path)["f"].tests[0]


def test_an_outcome_crosses_between_processes(needs_two):
    outcome = run_test(needs_two, LocalImplementation("f", lambda x: (x, x + 1)))
    assert (outcome.passed, outcome.message, outcome.sentence, outcome.points) == (True, "", "Two results.", 1)
    assert pickle.loads(pickle.dumps(outcome)) == outcome


def test_an_assertion_without_words_is_quoted(needs_two):
    assert (
        run_test(needs_two, LocalImplementation("f", lambda x: (x, x))).message == "this does not hold: first < second"
    )


def test_an_interrupt_of_the_student_passes(needs_two):
    def stop(x):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_test(needs_two, LocalImplementation("f", stop))


def test_values_are_handed_on_and_functions_are_guarded():
    assert as_impl("peak", 0.5) == 0.5
    assert isinstance(as_impl("f", max), LocalImplementation)


def change(image):
    image[0, 0] = -0.0
    return image


def test_a_change_of_the_input_is_found_bit_by_bit():
    assert call(change, np.zeros((2, 2))) == "modified its input `image`: work on a copy (`image = image.copy()`)."
    assert "modified its input `images`" in call(lambda images: images.append(1), [np.ones(2)])
    assert "modified its input `layout`" in call(lambda layout: layout.update(a=1), {"a": np.ones(2)})
    assert "modified its input `image`" in call(lambda image: image.sort(), image=np.array([2.0, np.nan, 1.0]))
    assert "modified its input `image`" in call(lambda image: setattr(image, "shape", (4,)), np.ones((2, 2)))
    assert "modified its input `rest`" in call(lambda *rest: change(rest[1]), 1, np.ones((2, 2)))


def test_returning_the_input_itself_is_no_change():
    image = np.array([1.0, np.nan])
    assert LocalImplementation("f", lambda image: image)(image) is image


def in_line(source, *arguments):
    """What is said about a function of this source, with the name of its file left out."""
    namespace = {"np": np}
    linecache.cache["<student>"] = (len(source), None, source.splitlines(keepends=True), "<student>")
    exec(compile(source, "<student>", "exec"), namespace)
    return call(namespace["f"], *arguments)


ERRORS = {
    "own line": (
        "def f(x):\n    y = x\n    return y[5]",
        "IndexError: tuple index out of range, in line 3: `return y[5]`",
    ),
    "in a helper": ("def g(x):\n    return x.nothing\ndef f(x):\n    return g(x)", "in line 2: `return x.nothing`"),
    "in NumPy": ("def f(x):\n    return np.reshape(x, (7, 7))", "into shape (7,7), in line 2: `return np"),
    "without words": ("def f(x):\n    assert 1 > 2", "stopped with AssertionError, in line 2: `assert 1 > 2`"),
    "recursion": ("def f(x):\n    return f(x)", "calls itself without end (RecursionError), in line 2: `return f(x)`"),
    "memory": ("def f(x):\n    raise MemoryError", "asks for more memory than there is (MemoryError), in line 2"),
    "exit": (
        "def f(x):\n    raise SystemExit(3)",
        "ends the whole program (SystemExit), in line 2: `raise SystemExit(3)`: use",
    ),
    "quit": ("def f(x):\n    exit()", "ends the whole program (SystemExit), in line 2"),
    "long": ("def f(x):\n    raise ValueError('long ' * 1000)", "long lo"),
    "lines": ("def f(x):\n    raise ValueError('one\\ntwo')", "stopped with ValueError: one two, in line 2"),
    "strange": ("class E(Exception):\n    def __str__(self): 1 / 0\ndef f(x):\n    raise E", "stopped with E"),
    "decorated": (
        "import functools\ndef d(g):\n    @functools.wraps(g)\n    def h(x):\n        return g(x)\n    return h\n"
        "@d\ndef f(x):\n    return x + 1",
        "in line 9: `return x + 1`",
    ),
    "arguments": ("def f(x, y):\n    pass", "cannot be called as the exercise asks (missing a required argument: 'y')"),
    "a class": (
        "class f:\n    def __init__(self, x):\n        x.nothing",
        "stopped with AttributeError: 'tuple' object",
    ),
}


@pytest.mark.parametrize("case", ERRORS)
def test_an_error_comes_with_the_students_own_line(case):
    source, words = ERRORS[case]
    said = in_line(source, ())
    assert words in said
    assert len(said) < 500


def test_not_written_is_no_error():
    def f():
        raise NotImplementedError("f is not written yet")

    with pytest.raises(Unwritten, match=r"not written yet\."):
        LocalImplementation("f", f)()


def test_callables_without_a_signature_or_globals_are_called():
    assert LocalImplementation("f", max)(1, 2) == 2
    assert LocalImplementation("f", functools.partial(np.add, 2))(3) == 5
    assert "stopped with UFuncTypeError: ufunc 'add'" in call(functools.partial(np.add, 2), "x")


def test_warnings_of_numpy_become_a_hint_and_nothing_else():
    def f(image):
        warnings.warn("old", DeprecationWarning, stacklevel=1)
        return image / image

    answer = LocalImplementation("f", f)
    assert np.isnan(answer(np.zeros(2))).all()
    assert answer.warned.startswith("invalid value encountered in divide, line ")
    assert answer.warned.endswith(": `return image / image`")
    answer(np.ones(2))
    assert answer.warned == ""


def test_lines_of_extracted_source_are_those_of_the_cell():
    source = "#@ line 1\nimport numpy\n#@ line 7\ndef f(x):\n\n    return y"
    assert place_in_source(source, 6) == "line 9: `return y`"
    assert place_in_source(source, 2) == "line 1: `import numpy`"
    assert place_in_source("return y", 1) == "line 1: `return y`"
    assert place_in_source("", 3) == "line 3"
    assert place("<nowhere>", 4) == "line 4"


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timers on this system")
def test_the_time_limit_leaves_the_earlier_handler():
    earlier = signal.getsignal(signal.SIGALRM)
    with time_limit(5.0):
        assert signal.getsignal(signal.SIGALRM) is not earlier
    assert signal.getsignal(signal.SIGALRM) is earlier
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    answer = LocalImplementation("f", lambda: time.sleep(5), seconds=0.05)
    with pytest.raises(Finding, match=r"more than 0\.05 s: is there an endless loop\?"):
        answer()
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_outside_the_main_thread_there_is_no_time_limit():
    results = []
    thread = threading.Thread(target=lambda: results.append(LocalImplementation("f", lambda: 3, seconds=0.001)()))
    thread.start()
    thread.join()
    assert results == [3]


@pytest.mark.parametrize("file", sorted(EXERCISES.glob("test_ch*.py")), ids=lambda file: file.stem)
def test_the_course_keeps_its_own_rules(file):
    for exercise in load_tests(file).values():
        public = [test for test in exercise.tests if not test.graded.hidden]
        assert public, f"{exercise.name} needs a public test"
        for test in exercise.tests:
            assert test.__code__.co_varnames[: test.__code__.co_argcount] == ("impl",)
            assert test.__doc__, f"{test.__name__} needs a sentence for students"
            assert len(sentence_of(test)) <= 120, f"{test.__name__}: one line"


@pytest.fixture
def course(pytester):
    """A small tree with tests and a notebook, as in the repository, to run pytest in."""
    root = pytester.path
    for name in ("tests/exercises", "notebooks", "empty"):
        (root / name).mkdir(parents=True)
    (root / "tests" / "exercises" / "test_ch02.py").write_text(TOY)
    (root / "notebooks" / "ch02_gaussian.py").write_text(
        "# %%\nimport numpy as np\n"
        '# %% exercise="blur"\ndef weighted(image): return 2 * image\ndef blur(image, s, r): return weighted(image)\n'
        '# %% exercise="peak"\npeak = None\n### BEGIN SOLUTION\npeak = 0.07\n### END SOLUTION\n'
    )
    pytester.makeini("[pytest]\nmarkers =\n    ch02: chapter 02\naddopts = --strict-markers -q --import-mode=importlib")
    return pytester


def run_pytest(course, *arguments):
    return course.runpytest_inprocess(
        "-p", "mcdenoise.classroom.checking.pytest_plugin", "-p", "no:cacheprovider", *arguments
    )


def test_pytest_runs_the_chapters_notebook_and_shows_words_alone(course):
    run = run_pytest(course, "-m", "ch02")
    run.assert_outcomes(passed=1, failed=5)
    out = run.stdout.str()
    assert "blur: a flat image: a constant factor of 2; worst entry (0, 0, 0): yours 1.4, expected 0.7." in out
    assert "blur_sums: `blur_sums` is not in the notebook; it has `blur`" not in out
    assert "blur_sums: `blur_sums` is not in the notebook." in out
    assert "Traceback" not in out + run.stderr.str()
    assert "assert_matches" not in out
    assert "assert_matches" in run_pytest(course, "-k", "flat", "--tb=long").stdout.str()


def test_pytest_runs_a_students_notebook_or_folder(course):
    cells = [{"cell_type": "code", "source": "peak = 0.0700"}, {"cell_type": "code", "source": "def blur("}]
    (course.path / "ch02_student.ipynb").write_text(json.dumps({"cells": cells}))
    run = run_pytest(course, "--impl", "ch02_student.ipynb")
    run.assert_outcomes(passed=1, failed=5)
    assert (
        "blur: the cell of `blur` has a syntax error ('(' was never closed) in line 1: `def blur(`" in run.stdout.str()
    )
    run_pytest(course, "--impl", "notebooks").assert_outcomes(passed=1, failed=5)
    (course.path / "ch03_student.py").write_text("x = 1")
    run_pytest(course, "--impl", "ch03_student.py").assert_outcomes(skipped=6)


def test_pytest_says_in_words_what_a_test_cannot_use(course):
    (course.path / "ch02.py").write_text("def blur_sums(image, s, r): image")
    run = run_pytest(course, "--impl", "ch02.py", "-k", "sums")
    assert "blur_sums: returned nothing (None): is the `return` missing?" in run.stdout.str()
    assert "Error" not in run.stdout.str()


def test_pytest_says_which_file_is_missing(course):
    run = run_pytest(course, "--impl", "empty", "-k", "flat")
    run.assert_outcomes(errors=1)
    assert "empty holds no answers for ch02: a file ch02*.py or ch02*.ipynb is needed." in run.stdout.str()
    run = run_pytest(course, "--impl", "gone.py", "-k", "flat")
    assert "gone.py: there is no such file" in run.stdout.str()
    assert "by --impl" in run.stdout.str()
    assert "pytest_plugin.py" not in run.stdout.str()
    (course.path / "tests" / "exercises" / "test_ch02.py").write_text("def test_flat(impl): pass")
    assert "test_flat uses `impl` and needs the mark @graded(exercise, points=...)" in run_pytest(course).stdout.str()


def test_pytest_names_what_has_not_been_answered(course):
    (course.path / "ch02.py").write_text("peak = None")
    run = run_pytest(course, "--impl", "ch02.py", "-k", "peak")
    run.assert_outcomes(failed=1)
    assert "peak: not answered yet." in run.stdout.str()


def test_an_answer_that_fails_while_it_is_loaded_is_said_in_words(tmp_path):
    path = tmp_path / "ch02.py"
    path.write_text("x = 1\ny = x / 0\ndef f(): return y\ng = None\n")
    with pytest.raises(Finding, match=r"stopped with ZeroDivisionError: division by zero, in line 2: `y = x / 0`"):
        load_answer(path, "f")
    assert load_answer(path, "g") is None
    path.write_text("def f(): return len(str(abs(-10)))")
    assert load_answer(path, "f")() == 2
