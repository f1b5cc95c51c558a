"""Where a student's function runs: a process of its own, behind bubblewrap where that works.

`bwrap` is the wall: no network, no other processes, and a file system, all of it read-only, that holds the interpreter,
its standard library, the system's libraries, NumPy and a stub of this package, nothing else. `fence` is a courtesy
(see the module `fence`): it stops mistakes and teaches, but a student who means to can climb over it, read the
instructor's files with the rights of whoever grades, and score. Grade a class that you do not trust with bubblewrap.
In both a process has limits on memory, processor time and files, and is killed with all that it started.
"""

from __future__ import annotations

import atexit
import compileall
import functools
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import threading
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from mcdenoise.classroom import checking

SANDBOXES = ("auto", "bwrap", "fence")
SENTENCES = {
    "bwrap": "Sandbox: bubblewrap; no network, no files but Python's and NumPy's, no other processes.",
    "fence": "Sandbox: NONE, graded without bubblewrap. A courtesy fence stops mistakes, not intent: "
    "it can be climbed. Install bubblewrap to grade submissions that you do not trust.",
}
ENVIRONMENT = {
    "PATH": os.defpath,
    "HOME": "/home/student",
    "LC_ALL": "C.UTF-8",
    "PYTHONHASHSEED": "0",
    **{f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "VECLIB_MAXIMUM")},
}
SYSTEM = ("/usr/lib", "/usr/lib64", "/lib", "/lib64", "/etc/alternatives", "/etc/ld.so.cache")
CHILD_FILES = ("child.py", "wire.py", "fence.py")
GUARD_FILES = ("implementation.py", "finding.py", "describe.py")


@dataclass(frozen=True)
class Limits:
    """What one submission may use.

    Parameters
    ----------
    seconds : wall time of one call of a function, and of running the cells that it needs; > 0.
    total_seconds : wall time of all calls of a submission together; once used up, what is left fails.
    memory_mb : address space of the process in MB (Python with NumPy takes about 300); macOS does not keep to it.
    sandbox : "auto" (bubblewrap where it works), "bwrap" or "fence".

    Raises
    ------
    ValueError
        If a limit is not above zero, or the sandbox has another name.

    Examples
    --------
    >>> Limits(seconds=2).memory_mb
    2048
    """

    seconds: float = 10.0
    total_seconds: float = 120.0
    memory_mb: int = 2048
    sandbox: str = "auto"

    def __post_init__(self):
        for name in ("seconds", "total_seconds", "memory_mb"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be above 0, got {getattr(self, name)!r}.")
        if self.memory_mb < 512:
            raise ValueError(f"Python with NumPy needs a memory limit of 512 MB or more, got {self.memory_mb}.")
        if self.sandbox not in SANDBOXES:
            raise ValueError(f"The sandbox must be one of {', '.join(SANDBOXES)}, got {self.sandbox!r}.")

    def facts(self) -> dict[str, float | str]:
        """Return the limits as a dict, for results and their keys."""
        return asdict(self)


def choose_sandbox(wanted: str = "auto") -> str:
    """Return "bwrap" or "fence": what was wanted, or the best that works on this machine.

    Raises
    ------
    ValueError
        If "bwrap" is wanted and does not work, with what bubblewrap said; on a system without POSIX processes.
    """
    if os.name != "posix":
        raise ValueError("Grading needs Linux or macOS (on Windows: WSL), for limits on memory and time.")
    if wanted == "fence":
        return "fence"
    failure = bwrap_failure()
    if wanted == "bwrap" and failure:
        raise ValueError(f"bubblewrap was asked for, but {failure}. Use --sandbox auto, or repair it.")
    return "fence" if failure else "bwrap"


@functools.cache
def bwrap_failure() -> str:
    """Return why bubblewrap cannot be used here, or "" if it ran Python with NumPy, with all the options we use."""
    if shutil.which("bwrap") is None:
        return "there is no program bwrap"
    command = [*bwrap_command(home()), *python_command("-c", "import sys; sys.path.append('/packages'); import numpy")]
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=60, env=ENVIRONMENT)
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"it could not be run ({error})"
    return "" if found.returncode == 0 else f"it failed: {' '.join(found.stderr.split())[-200:]}"


def python_command(*arguments: str) -> list[str]:
    """Return the command of the base interpreter: isolated, without site-packages, writing no bytecode."""
    return [str(base_python()), "-I", "-S", "-B", *arguments]


def base_python() -> Path:
    """Return the interpreter behind a virtual environment, all links resolved."""
    return Path(getattr(sys, "_base_executable", None) or sys.executable).resolve()


def child_command(sandbox: str, arguments: Sequence[str]) -> list[str]:
    """Return the command that starts `child.py` with `arguments` in the sandbox ("bwrap" or "fence")."""
    if sandbox == "bwrap":
        return [*bwrap_command(home()), *python_command("/child/child.py", "/packages", *arguments)]
    return python_command(str(home() / "child" / "child.py"), str(home() / "packages"), *arguments)


def bwrap_command(folder: Path) -> list[str]:
    """Return bubblewrap's part of the command: what is bound, everything read-only. Run it with `ENVIRONMENT`."""
    command = ["bwrap", "--unshare-all", "--unshare-user", "--uid", "65534", "--gid", "65534", "--cap-drop", "ALL"]
    command += ["--die-with-parent", "--new-session", "--hostname", "grading"]
    for place in system_folders():
        link = os.readlink(place) if place.is_symlink() else None
        command += ["--symlink", link, str(place)] if link else ["--ro-bind", str(place), str(place)]
    for place in hidden_folders():
        command += ["--tmpfs", str(place)]
    command += ["--ro-bind", str(base_python()), str(base_python())]
    for name in ("mcdenoise", "numpy", "numpy.libs"):
        place = folder / "packages" / name
        command += ["--ro-bind", str(place.resolve()), f"/packages/{name}"] if place.exists() else []
    command += ["--ro-bind", str(folder / "child"), "/child", "--proc", "/proc", "--dev", "/dev"]
    return [*command, "--dir", "/home/student", "--chdir", "/home/student", "--remount-ro", "/dev", "--remount-ro", "/"]


def system_folders() -> list[Path]:
    """Return the folders that hold the interpreter's libraries, each folder before what lies inside it."""
    base = Path(sys.base_prefix).resolve()
    candidates = {Path(place) for place in SYSTEM}
    candidates |= {base / "lib", Path(sysconfig.get_path("stdlib"))}
    found = sorted(place for place in candidates if place.exists())
    return [place for place in found if not any(place.is_relative_to(other) for other in found if other != place)]


def hidden_folders() -> list[Path]:
    """Return the folders of installed packages below the system's folders: they are covered by empty ones."""
    found = []
    for place in system_folders():
        if not place.is_symlink():
            found += [inner for inner in place.glob("python*/*-packages") if inner.is_dir() and not inner.is_symlink()]
    return sorted(found)


_lock = threading.Lock()


def home() -> Path:
    """Return a folder of this process with `child/` (the program) and `packages/` (NumPy by link, the stub package)."""
    with _lock:
        return _make_home()


@functools.cache
def _make_home() -> Path:
    from mcdenoise.classroom.building.stubs import stub_package

    folder = Path(tempfile.mkdtemp(prefix="mcdenoise-grading-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    for name in ("child", "packages"):
        (folder / name).mkdir()
    for name in CHILD_FILES:
        shutil.copyfile(Path(__file__).with_name(name), folder / "child" / name)
    stub_package(folder / "packages")
    stub = folder / "packages" / "mcdenoise"
    guard = stub / "classroom" / "checking"
    guard.mkdir(parents=True)
    for place in (guard.parent, guard):
        (place / "__init__.py").touch()
    for name in GUARD_FILES:
        shutil.copyfile(Path(checking.__file__).with_name(name), guard / name)
    for place in (folder / "child", stub):
        compileall.compile_dir(place, quiet=2)  # once here, rather than in every process
    numpy = Path(np.__file__).resolve().parent
    for place in (numpy, numpy.with_name("numpy.libs")):
        if place.is_dir():
            (folder / "packages" / place.name).symlink_to(place)
    return folder
