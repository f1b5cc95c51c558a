"""What works on this machine, in plain words: `mcdenoise doctor`."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tempfile
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec

import numpy as np
from tqdm import tqdm

from mcdenoise.classroom.grading.sandbox import bwrap_failure
from mcdenoise.classroom.publishing.paper import find_chromium
from mcdenoise.classroom.publishing.site import NEEDED
from mcdenoise.filters import gaussian
from mcdenoise.render import render_image
from mcdenoise.render.variants import LIBRARY_VARIABLE, choose_variant
from mcdenoise.samples.storage import cache_folder
from mcdenoise.study.machine import usable_cores

PYTHON_FROM, PYTHON_BELOW = (3, 11), (3, 14)
EXTRAS = {
    "notebooks": (("jupyterlab", "nbclient"), "the notebooks in JupyterLab"),
    "lectures": (NEEDED, "building the lecture site and slides"),
    "grading": (("nbgrader",), "releasing and collecting with nbgrader; our own grader does not need it"),
}
LLVM_CURE = (
    "Debian and Ubuntu: apt install libllvm19. conda-forge: libllvm19, on Windows libllvm-c19. macOS: brew install llvm. "
    f"Or set {LIBRARY_VARIABLE} to the library's file."
)


@dataclass(frozen=True)
class Line:
    """One thing that was looked at.

    Attributes
    ----------
    state : "ok", "missing" or "broken". subject : what it is. verdict : what was found. use : what it is good for.
    cure : what to install or do, where it is not ok. essential : whether mcdenoise is of any use without.
    """

    state: str
    subject: str
    verdict: str
    use: str
    cure: str = ""
    essential: bool = False

    def text(self) -> str:
        """Return the line as printed, its ends wrapped under its beginning.

        Examples
        --------
        >>> print(Line("missing", "make", "not found", "the commands of the README", "apt install make").text())
        missing  make: not found (for the commands of the README)
                 To install: apt install make
        """
        first = f"{self.state:8} {self.subject}: {self.verdict} (for {self.use})"
        label = "To install" if self.state == "missing" else "What to do"
        lines = [first] if self.state == "ok" else [first, f"{'':8} {label}: {self.cure}"]
        return "\n".join(
            textwrap.fill(line, 110, subsequent_indent=" " * 9, break_on_hyphens=False, break_long_words=False)
            for line in lines
        )


def check_python() -> Line:
    """Is this a Python that mcdenoise is made for?"""
    found, fits = platform.python_version(), PYTHON_FROM <= sys.version_info[:2] < PYTHON_BELOW
    cure = "install Python 3.11, 3.12 or 3.13 and make a new environment with it (make PYTHON=python3.12 lab)"
    return Line("ok" if fits else "broken", "Python", found, "everything; 3.11 to 3.13", cure, essential=True)


def check_package() -> Line:
    """Which mcdenoise is this?"""
    try:
        return Line("ok", "mcdenoise", version("mcdenoise"), "the course", essential=True)
    except PackageNotFoundError:
        cure = "python -m pip install --editable . in the clone"
        return Line("missing", "mcdenoise", "found, but not installed", "the command line", cure, essential=True)


def check_mitsuba() -> Line:
    """Does Mitsuba render with the back end that needs nothing else?"""
    use = "rendering the scenes"
    try:
        found = version("mitsuba")
    except PackageNotFoundError:
        return Line("missing", "Mitsuba", "not found", use, "python -m pip install mitsuba", essential=True)
    try:
        image = render_image("pinhole", width=4, height=4, spp=1, seed=0, variant="scalar_rgb")
    except (ImportError, OSError, RuntimeError) as error:
        verdict = f"{found}, but scalar_rgb does not render: {_short(error)}"
        cure = "python -m pip install --force-reinstall mitsuba"
        return Line("broken", "Mitsuba", verdict, use, cure, essential=True)
    verdict = f"{found}, scalar_rgb renders"
    return Line("ok" if np.isfinite(image).all() else "broken", "Mitsuba", verdict, use, essential=True)


def check_llvm() -> Line:
    """Is there an LLVM library with which Mitsuba's fast back end renders?"""
    use = "rendering several times faster"
    try:
        choose_variant("llvm_ad_rgb")
    except (ValueError, ImportError) as error:
        found = "tried: none found" not in str(error)
        verdict = _short(error).partition("Install LLVM")[0] if found else "no library found; scalar_rgb works without"
        return Line("broken" if found else "missing", "LLVM for Mitsuba", verdict.strip(), use, LLVM_CURE)
    return Line("ok", "LLVM for Mitsuba", f"llvm_ad_rgb renders with {os.environ[LIBRARY_VARIABLE]}", use)


def check_kernels() -> Line:
    """Does numba compile a kernel, and does it agree with NumPy?"""
    image = np.linspace(0, 1, 64, dtype=np.float32).reshape(8, 8)
    use, cure = "the fast filters", "python -m pip install --force-reinstall numba"
    try:
        fast = gaussian(image, sigma_space=1.0, engine="numba")
    except (ImportError, OSError, RuntimeError) as error:
        return Line("broken", "numba", f"does not compile: {_short(error)}", use, cure, essential=True)
    agrees = np.allclose(fast, gaussian(image, sigma_space=1.0, engine="numpy"), rtol=1e-4)
    verdict = f"{version('numba')}, kernels compile{'' if agrees else ', but their results are wrong'}"
    return Line("ok" if agrees else "broken", "numba", verdict, use, cure, essential=True)


def check_machine() -> Line:
    """How many cores and how much memory?"""
    cores = usable_cores()
    names = getattr(os, "sysconf_names", {})
    known = "SC_PAGE_SIZE" in names and "SC_PHYS_PAGES" in names
    gigabytes = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30 if known else None
    memory = f"{gigabytes:.0f} GiB of memory" if known else "memory not known"
    return Line(
        "ok", "machine", f"{cores} cores, {memory}, {platform.system()} {platform.machine()}", "rendering, grading"
    )


def check_cache() -> Line:
    """Can compiled kernels and references be kept?"""
    folder, use = cache_folder(), "compiled kernels and references, made once and kept"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return Line("ok", "cache folder", f"{folder} can be written to", use)
    except OSError as error:
        cure = "set MCDENOISE_CACHE to a folder that can be written to; until then all is made again each time"
        return Line("broken", "cache folder", f"{folder}: {error.strerror}", use, cure)


def check_extra(name: str) -> Line:
    """Is what an extra of the package brings installed?"""
    modules, use = EXTRAS[name]
    missing = [module for module in modules if find_spec(module) is None]
    verdict = f"not found: {', '.join(missing)}" if missing else "installed"
    cure = f"python -m pip install 'mcdenoise[{name}]', in a clone: python -m pip install -e '.[{name}]'"
    return Line("missing" if missing else "ok", f"extra {name}", verdict, use, cure)


def check_chromium() -> Line:
    """Is there a browser that prints pages?"""
    path, use = find_chromium(), "PDFs of the lecture pages"
    cure = "Debian: apt install chromium. Chrome serves as well, if chromium or google-chrome is on the path."
    if path is None:
        return Line("missing", "Chromium", "not found", use, cure)
    try:
        done = subprocess.run([path, "--version"], capture_output=True, text=True, timeout=60, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        return Line("broken", "Chromium", f"{path} does not start: {_short(error)}", use, cure)
    if done.returncode != 0:
        return Line("broken", "Chromium", f"{path} does not start: {_short(done.stderr)}", use, cure)
    return Line("ok", "Chromium", done.stdout.partition(" built on")[0].strip(), use)


def check_bubblewrap() -> Line:
    """Can the grader lock submissions in?"""
    use = "grading submissions that you do not trust"
    if shutil.which("bwrap") is None:
        cure = "Debian, Ubuntu, Fedora: the package bubblewrap (Linux only). Without it grading works, but is not locked in."
        return Line("missing", "bubblewrap", "not found", use, cure)
    failure = bwrap_failure()
    cure = "in a container, allow user namespaces (for Docker: --privileged or a seccomp profile that admits them)"
    return Line("broken" if failure else "ok", "bubblewrap", failure or "works", use, cure)


def check_make() -> Line:
    """Are the short commands at hand?"""
    path, use = shutil.which("make"), "the short commands: make lab, make lectures"
    cure = "Debian and Ubuntu: apt install make. macOS: xcode-select --install. Windows: use pip, as the README says."
    return Line("ok" if path else "missing", "make", path or "not found", use, cure)


CHECKS: tuple[tuple[Callable[..., Line], tuple[str, ...]], ...] = (
    (check_python, ()),
    (check_package, ()),
    (check_machine, ()),
    (check_mitsuba, ()),
    (check_llvm, ()),
    (check_kernels, ()),
    (check_cache, ()),
    *((check_extra, (name,)) for name in EXTRAS),
    (check_chromium, ()),
    (check_bubblewrap, ()),
    (check_make, ()),
)


def run_doctor(checks: Sequence[tuple[Callable[..., Line], tuple[str, ...]]] = CHECKS) -> int:
    """Print a line for each check and a summary; returns the exit code: 0 if all that is essential works, else 1."""
    lines = []
    with tqdm(checks, unit="check", leave=False, disable=None) as progress:
        for check, arguments in progress:
            progress.set_description(f"{check.__name__.removeprefix('check_')} {' '.join(arguments)}".strip())
            lines.append(check(*arguments))
            progress.write(lines[-1].text())
    lacking = [line.subject for line in lines if line.state != "ok"]
    broken = [line.subject for line in lines if line.state != "ok" and line.essential]
    if broken:
        print(f"\nmcdenoise does not work here yet: see {', '.join(broken)} above.")
    elif lacking:
        print(f"\nmcdenoise works here. For more, see above: {', '.join(lacking)}.")
    else:
        print("\nEverything works here.")
    return 1 if broken else 0


def _short(error: object) -> str:
    """Return the last part of a message, on one line."""
    return " ".join(str(error).split())[-300:]
