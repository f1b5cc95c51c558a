"""Where students' functions run: the choice of the sandbox, its files, and the fence."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from mcdenoise.classroom.checking.finding import Finding
from mcdenoise.classroom.grading import fence, sandbox
from mcdenoise.classroom.grading.remote import Budget, RemoteAnswer
from mcdenoise.classroom.grading.sandbox import Limits, bwrap_failure, choose_sandbox

needs_bwrap = pytest.mark.skipif(bool(bwrap_failure()), reason=f"bubblewrap: {bwrap_failure()}")
LIMITS = Limits(seconds=10, total_seconds=60)


def answer_to(source, where, *arguments):
    """What `f` of the source returns in the sandbox, or the words of its finding."""
    with RemoteAnswer("f", source, LIMITS, where, Budget(60)) as answer:
        try:
            return answer.impl()(*arguments)
        except Finding as finding:
            return str(finding)


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        ({"seconds": 0}, "seconds must be above 0, got 0"),
        ({"total_seconds": -1}, "total_seconds must be above 0"),
        ({"seconds": float("nan")}, "seconds must be above 0, got nan"),
        ({"memory_mb": 100}, "512 MB or more, got 100"),
        ({"sandbox": "docker"}, "one of auto, bwrap, fence, got 'docker'"),
    ],
)
def test_limits_say_what_they_need(limits, words):
    with pytest.raises(ValueError, match=words):
        Limits(**limits)


def test_the_best_sandbox_that_works_is_chosen(monkeypatch):
    monkeypatch.setattr(sandbox, "bwrap_failure", lambda: "")
    assert [choose_sandbox(wanted) for wanted in ("auto", "bwrap", "fence")] == ["bwrap", "bwrap", "fence"]
    monkeypatch.setattr(sandbox, "bwrap_failure", lambda: "there is no program bwrap")
    assert [choose_sandbox(wanted) for wanted in ("auto", "fence")] == ["fence", "fence"]
    with pytest.raises(
        ValueError, match=r"bubblewrap was asked for, but there is no program bwrap\. Use --sandbox auto"
    ):
        choose_sandbox("bwrap")


def test_a_system_without_posix_is_told_so(monkeypatch):
    monkeypatch.setattr(sandbox.os, "name", "nt")
    with pytest.raises(ValueError, match="WSL"):
        choose_sandbox("auto")


def test_a_missing_or_broken_bwrap_is_found_out(monkeypatch):
    look = bwrap_failure.__wrapped__
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert look() == "there is no program bwrap"
    monkeypatch.setattr(shutil, "which", lambda name: "/usr/bin/bwrap")
    monkeypatch.setattr(
        sandbox, "bwrap_command", lambda folder: [sys.executable, "-c", "raise SystemExit('no user namespaces')"]
    )
    assert look() == "it failed: no user namespaces"


def test_both_sandboxes_are_described_honestly():
    assert "bubblewrap" in sandbox.SENTENCES["bwrap"]
    assert "NONE" in sandbox.SENTENCES["fence"]
    assert "can be climbed" in sandbox.SENTENCES["fence"]


@needs_bwrap
def test_the_wall_shows_nothing_but_python_and_numpy():
    source = """
import os

def f(places):
    return [os.path.exists(place) for place in places], sorted(os.listdir("/home")), sorted(os.listdir("/packages"))
"""
    repository = Path(__file__).resolve().parents[1]
    installed = Path(pytest.__file__).resolve().parents[1]
    places = [
        str(place) for place in (repository / "src", repository / "tests", installed / "pytest", installed / "scipy")
    ]
    hidden = [*places, os.path.expanduser("~/.bashrc"), "/etc/passwd", "/var", tempfile.gettempdir()]
    found, home, packages = answer_to(source, "wall", hidden)
    assert found == [False] * len(hidden)
    assert home == ["student"]
    assert set(packages) <= {"mcdenoise", "numpy", "numpy.libs"}


@needs_bwrap
def test_nothing_can_be_written_behind_the_wall():
    source = """
import os

def f():
    written = []
    for folder in ("/", "/packages", "/child", "/dev", "/dev/shm", "/home/student", os.path.dirname(os.__file__)):
        try:
            os.mkdir(folder + "/made")
            written.append(folder)
        except OSError:
            pass
    return written, os.getuid(), os.getcwd(), sorted(os.environ)
"""
    written, user, folder, names = answer_to(source, "wall")
    assert written == []
    assert user == 65534
    assert folder == "/home/student"
    assert set(names) <= {*sandbox.ENVIRONMENT, "MCDENOISE_GRADING", "PWD", "LC_CTYPE"}


@needs_bwrap
def test_behind_the_wall_there_are_no_other_processes():
    processes = "import os\n\ndef f():\n    return sorted(int(name) for name in os.listdir('/proc') if name.isdigit())"
    assert answer_to(processes, "wall") == [1, 2]


@pytest.mark.parametrize("where", [pytest.param("bwrap", marks=needs_bwrap), "fence"])
@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("open('/etc/hosts')", "may not open files: got '/etc/hosts'"),
        ("open('mine.txt', 'w')", "may not write files: got 'mine.txt'"),
        ("open(3)", "may not use file descriptors: got 3"),
        ("os.listdir('/')", "may not look into folders: got '/'"),
        ("os.mkdir('x')", "may not change files (os.mkdir)"),
        ("os.system('true')", "may not start other processes (os.system)"),
        ("__import__('subprocess').run(['true'])", "may not start other processes (subprocess.Popen)"),
        ("__import__('socket').socket()", "may not open network connections"),
        ("__import__('urllib.request').request.urlopen('http://127.0.0.1')", "may not"),
        ("__import__('resource').setrlimit(1, (1, 1))", "may not change its limits"),
        ("np.load('/etc/hosts')", "may not open files"),
        ("__import__('fence')", "`fence` is not there while grading"),
        ("__import__('wire')", "`wire` is not there while grading"),
        ("__import__('readline')", "may not use the module `readline`"),
        ("__import__('tkinter')", "may not use the module `_tkinter`"),
        ("__import__('pylab')", "`pylab` is not there while grading"),
        ("__import__('cv2')", "is to be written with NumPy alone: `cv2` is not there"),
        ("__import__('mcdenoise').gaussian(1)", "mcdenoise.gaussian is not available while grading: write it yourself"),
    ],
)
def test_the_fence_teaches(where, line, words):
    assert words in answer_to(f"import os\nimport numpy as np\n\ndef f():\n    {line}", where)


@pytest.mark.parametrize("where", [pytest.param("bwrap", marks=needs_bwrap), "fence"])
def test_honest_work_is_not_hindered(where):
    source = """
import collections, dataclasses, decimal, fractions, functools, itertools, json, lzma, math, random, re, statistics
import time, typing, warnings
import numpy as np
from mcdenoise.filters.window import bell

def f(image):
    spectrum = np.fft.irfft2(np.fft.rfft2(image), image.shape)
    np.testing.assert_allclose(spectrum, image)
    noise = np.random.default_rng(0).normal(size=image.shape)
    solved = np.linalg.solve(np.eye(len(image)), image)
    return spectrum + 0 * noise + 0 * solved, float(bell(np.array([0, 0]), 1.0)), np.polynomial.Polynomial([1, 2])(2.0)
"""
    import numpy as np

    image = np.arange(16.0).reshape(4, 4)
    blurred, middle, number = answer_to(source, where, image)
    assert np.allclose(blurred, image)
    assert (middle, number) == (1.0, 5.0)


def test_the_hook_allows_what_python_itself_needs(tmp_path):
    allowed = tmp_path / "packages"
    allowed.mkdir()
    hook = fence.make_hook((f"{allowed}{os.sep}",))
    hook("open", (str(allowed / "module.py"), "r", 0))
    hook("open", (bytes(allowed / "module.py"), "r", 0))
    hook("os.listdir", (str(allowed),))
    hook("import", ("json", None, None, None, None))
    for path in (str(tmp_path), str(allowed / ".." / "other"), f"{allowed}2/x"):
        with pytest.raises(PermissionError, match="may not open files"):
            hook("open", (path, "r", 0))
    link = allowed / "link"
    link.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(PermissionError, match="may not open files"):
        hook("open", (str(link), "r", 0))


def test_the_hook_keeps_copies_of_what_it_needs(monkeypatch, tmp_path):
    hook = fence.make_hook((f"{tmp_path}{os.sep}",))
    for name in ("READS", "REFUSED", "REFUSED_FAMILIES", "UNHEARD", "os", "WRITE_FLAGS", "make_check"):
        monkeypatch.setattr(fence, name, {})
    with pytest.raises(PermissionError, match="may not open files"):
        hook("open", ("/etc/hosts", "r", 0))
    with pytest.raises(PermissionError, match="may not write files"):
        hook("open", (str(tmp_path / "x"), "w", os.O_WRONLY))
    with pytest.raises(PermissionError, match="may not start other processes"):
        hook("os.system", ("true",))
    with pytest.raises(PermissionError, match="may not open network connections"):
        hook("socket.connect", ())
    with pytest.raises(ModuleNotFoundError, match="`readline`"):
        hook("import", ("readline", None, None, None, None))


@pytest.mark.parametrize("where", [pytest.param("bwrap", marks=needs_bwrap), "fence"])
def test_modules_that_can_do_without_readline_still_load(where):
    assert answer_to("import pdb, rlcompleter, doctest\n\ndef f():\n    return pdb.__name__", where) == "pdb"


def test_the_child_imports_no_library_of_ours():
    """The files that run beside a student's function must stand alone: only the stub package is there."""
    guard = Path(sandbox.__file__).parents[1] / "checking"
    files = [Path(sandbox.__file__).with_name(name) for name in sandbox.CHILD_FILES]
    for path in (*files, *(guard / name for name in sandbox.GUARD_FILES)):
        text = path.read_text()
        imported = set(re.findall(r"^\s*(?:from|import) (mcdenoise[\w.]*)", text, re.MULTILINE))
        assert imported <= {
            "mcdenoise.classroom.checking",
            "mcdenoise.classroom.checking.describe",
            "mcdenoise.classroom.checking.finding",
        }, path.name


def test_the_base_interpreter_runs_without_installed_packages():
    code = "import sys, importlib.util as u; print(u.find_spec('numpy'), [p for p in sys.path if 'packages' in p])"
    command = sandbox.python_command("-c", code)
    found = subprocess.run(command, capture_output=True, text=True, env=sandbox.ENVIRONMENT, check=True)
    assert found.stdout.strip() == "None []"
