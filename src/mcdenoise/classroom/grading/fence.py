"""What a function may do while it is graded: a courtesy fence of audit hooks and an import guard, with teaching messages.

It says "while grading a function may not open files: got '/etc/hosts'" to a student who did not know. It is no wall:
Python code that means to can climb over it (by patching the functions that the hook itself calls, or with
`_posixsubprocess`, which raises no audit event). The wall is bubblewrap, see `sandbox`; the fence runs inside it too.
This file runs in the process of the student's function and needs the standard library alone.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from importlib.abc import MetaPathFinder
from types import MappingProxyType

WRITE_FLAGS = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
PROCESSES = "may not start other processes"
FILES = "may not change files"
REFUSED = {
    "os.fork": PROCESSES,
    "os.forkpty": PROCESSES,
    "os.exec": PROCESSES,
    "os.posix_spawn": PROCESSES,
    "os.spawn": PROCESSES,
    "os.system": PROCESSES,
    "subprocess.Popen": PROCESSES,
    "pty.spawn": PROCESSES,
    "os.kill": "may not send signals",
    "os.killpg": "may not send signals",
    "signal.pthread_kill": "may not send signals",
    "resource.setrlimit": "may not change its limits",
    "resource.prlimit": "may not change its limits",
    "sys.addaudithook": "may not add audit hooks",
    **{
        f"os.{name}": FILES
        for name in ("chmod", "chown", "link", "mkdir", "remove", "rename", "rmdir", "symlink", "truncate", "utime")
    },
}
REFUSED_FAMILIES = {"socket": "may not open network connections", "ctypes": "may not load other libraries (ctypes)"}
READS = frozenset({"open", "os.listdir", "os.scandir", "os.chdir"})
UNHEARD = frozenset({"readline", "_tkinter"})  # modules that read files without an audit event
ALLOWED_PACKAGES = frozenset({*sys.stdlib_module_names, "numpy", "mcdenoise"})


class Guard(MetaPathFinder):
    """Answers imports of other packages than the standard library, NumPy and the stub `mcdenoise` with a sentence."""

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> None:
        """Refuse `fullname` or leave it to the next finder."""
        package = fullname.partition(".")[0]
        if package not in ALLOWED_PACKAGES and not package.startswith("_sysconfigdata"):
            raise ModuleNotFoundError(
                f"this exercise is to be written with NumPy alone: `{package}` is not there while grading",
                name=fullname,
            )


def install(folders: Sequence[str]) -> None:
    """Put up the import guard and the fence; from then on only files under `folders` can be read."""
    sys.meta_path.insert(0, Guard())
    sys.addaudithook(make_hook(tuple(os.path.realpath(folder) + os.sep for folder in folders)))


def make_hook(folders: tuple[str, ...]) -> Callable[[str, tuple], None]:
    """Return the audit hook: it raises PermissionError for what `REFUSED` names, and for files outside `folders`.

    What it needs it keeps as copies of its own: to change this module's names later has no effect.
    """
    refused, families = MappingProxyType(dict(REFUSED)), MappingProxyType(dict(REFUSED_FAMILIES))
    reads, unheard, check = READS, UNHEARD, make_check(folders)

    def hook(event: str, arguments: tuple) -> None:
        words = refused.get(event) or families.get(event.partition(".")[0])
        if words is not None:
            raise PermissionError(f"while grading a function {words} ({event})")
        if event in reads:
            check(event, arguments)
        elif event == "import" and arguments[0] in unheard:
            raise ModuleNotFoundError(f"while grading a function may not use the module `{arguments[0]}`")

    return hook


def make_check(folders: tuple[str, ...]) -> Callable[[str, tuple], None]:
    """Return a function that raises PermissionError unless an audit event reads a file or folder under `folders`."""
    write, separator, realpath, fsdecode = WRITE_FLAGS, os.sep, os.path.realpath, os.fsdecode

    def check(event: str, arguments: tuple) -> None:
        path = arguments[0]
        if event == "open" and (arguments[2] or 0) & write:
            raise PermissionError(f"while grading a function may not write files: got {path!r}")
        if isinstance(path, int):
            raise PermissionError(f"while grading a function may not use file descriptors: got {path}")
        place = realpath(fsdecode("." if path is None else path))
        if not (place + separator).startswith(folders):
            what = "open files" if event == "open" else "look into folders"
            raise PermissionError(f"while grading a function may not {what}: got {path!r}")

    return check
