"""`mcdenoise doctor`: each verdict with fakes, the printed lines, the exit code; and once for real."""

import subprocess
import sys

import pytest

from mcdenoise import cli
from mcdenoise.classroom import doctor
from mcdenoise.classroom.doctor import Line


def _fake(**changes):
    line = Line(**{"state": "ok", "subject": "x", "verdict": "works", "use": "all", "cure": "install y"} | changes)
    return (lambda: line), ()


def _raise(error):
    def fail(*arguments, **named):
        raise error

    return fail


@pytest.mark.parametrize(
    ("changes", "code", "last"),
    [
        ({}, 0, "Everything works here."),
        ({"state": "missing"}, 0, "mcdenoise works here. For more, see above: x."),
        ({"state": "broken", "essential": True}, 1, "mcdenoise does not work here yet: see x above."),
    ],
)
def test_only_what_is_essential_fails(changes, code, last, capsys):
    assert doctor.run_doctor([_fake(), _fake(**changes)]) == code
    assert capsys.readouterr().out.splitlines()[-1] == last


def test_what_to_install_is_printed_only_where_it_helps(capsys):
    doctor.run_doctor([_fake(), _fake(state="missing"), _fake(state="broken")])
    out = capsys.readouterr().out
    assert out.startswith("ok       x: works (for all)\nmissing  x: works (for all)\n         To install: install y\n")
    assert "broken   x: works (for all)\n         What to do: install y\n" in out


def test_lines_are_short():
    text = Line("broken", "x", "word " * 60, "all", "do " * 60).text()
    assert max(map(len, text.splitlines())) <= 110


@pytest.mark.parametrize(
    ("found", "state"), [((3, 10), "broken"), ((3, 11), "ok"), ((3, 13), "ok"), ((3, 14), "broken")]
)
def test_python(monkeypatch, found, state):
    monkeypatch.setattr(doctor.sys, "version_info", (*found, 0))
    line = doctor.check_python()
    assert (line.state, line.essential) == (state, True)


def test_a_package_that_was_not_installed(monkeypatch):
    monkeypatch.setattr(doctor, "version", _raise(doctor.PackageNotFoundError()))
    assert doctor.check_package().state == "missing"
    line = doctor.check_mitsuba()
    assert (line.state, line.essential, line.cure) == ("missing", True, "python -m pip install mitsuba")


def test_mitsuba_that_does_not_render(monkeypatch):
    monkeypatch.setattr(doctor, "render_image", _raise(ImportError("no such symbol")))
    line = doctor.check_mitsuba()
    assert (line.state, line.essential) == ("broken", True)
    assert "scalar_rgb does not render: no such symbol" in line.verdict


def test_llvm(monkeypatch):
    monkeypatch.setenv(doctor.LIBRARY_VARIABLE, "libLLVM.so.19")
    monkeypatch.setattr(doctor, "choose_variant", lambda variant: variant)
    assert doctor.check_llvm().verdict == "llvm_ad_rgb renders with libLLVM.so.19"
    monkeypatch.setattr(doctor, "choose_variant", _raise(ValueError("tried: none found. Install LLVM 17 or newer")))
    line = doctor.check_llvm()
    assert (line.state, line.essential) == ("missing", False)
    assert "libllvm19" in line.cure
    tried = "tried: libLLVM.so.15 (killed the process, signal 6). Install LLVM 17 or newer"
    monkeypatch.setattr(doctor, "choose_variant", _raise(ValueError(tried)))
    line = doctor.check_llvm()
    assert (line.state, line.verdict) == ("broken", "tried: libLLVM.so.15 (killed the process, signal 6).")


def test_kernels_that_do_not_compile_or_do_not_agree(monkeypatch):
    monkeypatch.setattr(doctor, "gaussian", _raise(ImportError("numba needs NumPy 2.2 or less")))
    assert "does not compile: numba needs NumPy 2.2 or less" in doctor.check_kernels().verdict
    monkeypatch.setattr(doctor, "gaussian", lambda image, sigma_space, engine: image * (1 + (engine == "numba")))
    line = doctor.check_kernels()
    assert (line.state, line.essential) == ("broken", True)
    assert "their results are wrong" in line.verdict


def test_a_cache_that_cannot_be_written(monkeypatch, tmp_path):
    monkeypatch.setenv("MCDENOISE_CACHE", str(tmp_path / "cache"))
    assert doctor.check_cache().state == "ok"
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("MCDENOISE_CACHE", str(tmp_path / "file"))
    line = doctor.check_cache()
    assert (line.state, line.essential) == ("broken", False)
    assert "MCDENOISE_CACHE" in line.cure


def test_an_extra_that_is_not_installed(monkeypatch):
    monkeypatch.setattr(doctor, "find_spec", lambda name: None if name == "nbclient" else object())
    line = doctor.check_extra("notebooks")
    assert (line.state, line.verdict) == ("missing", "not found: nbclient")
    assert "mcdenoise[notebooks]" in line.cure
    assert doctor.check_extra("grading").state == "ok"


def test_chromium(monkeypatch):
    monkeypatch.setattr(doctor, "find_chromium", lambda: None)
    assert doctor.check_chromium().state == "missing"
    monkeypatch.setattr(doctor, "find_chromium", lambda: "chromium")
    for code, out, state in ((0, "Chromium 156.0 built on Debian", "ok"), (127, "", "broken")):
        done = subprocess.CompletedProcess([], code, out, "no such library")
        monkeypatch.setattr(doctor.subprocess, "run", lambda *arguments, done=done, **named: done)
        line = doctor.check_chromium()
        assert line.state == state
        assert line.verdict in ("Chromium 156.0", "chromium does not start: no such library")
    monkeypatch.setattr(doctor.subprocess, "run", _raise(OSError("not a program")))
    assert doctor.check_chromium().verdict == "chromium does not start: not a program"


def test_bubblewrap_and_make(monkeypatch):
    monkeypatch.setattr(doctor.shutil, "which", lambda name: None)
    assert doctor.check_bubblewrap().state == doctor.check_make().state == "missing"
    monkeypatch.setattr(doctor.shutil, "which", lambda name: f"/usr/bin/{name}")
    assert doctor.check_make().verdict == "/usr/bin/make"
    for failure, state in (("", "ok"), ("it failed: no permission", "broken")):
        monkeypatch.setattr(doctor, "bwrap_failure", lambda failure=failure: failure)
        assert doctor.check_bubblewrap().state == state


def test_the_machine_is_described_where_memory_is_not_known(monkeypatch):
    assert "GiB of memory" in doctor.check_machine().verdict
    monkeypatch.setattr(doctor.os, "sysconf_names", {})
    assert "memory not known" in doctor.check_machine().verdict


def test_the_command_runs_the_checks(monkeypatch, capsys):
    monkeypatch.setattr(doctor.run_doctor, "__defaults__", ([_fake(subject="made up")],))
    assert cli.main(["doctor"]) == 0
    assert "made up: works" in capsys.readouterr().out


def test_doctor_on_this_machine():
    done = subprocess.run(
        [sys.executable, "-m", "mcdenoise.cli", "doctor"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    subjects = [
        line.partition(":")[0].split()[-1] for line in done.stdout.splitlines() if line[:1] in "omb" and ":" in line
    ]
    assert {"Python", "mcdenoise", "machine", "Mitsuba", "numba", "folder", "bubblewrap", "make"} <= set(subjects)
