"""Which Mitsuba back end to render with: `scalar_rgb` always works, `llvm_ad_rgb` only where a child process proved it.

Dr.Jit needs a libLLVM that fits its version. An unfit one does not raise: it may abort the whole process at the first
render. So every candidate library renders a few pixels in a child process first, and the verdict is kept on disk.
"""

import contextlib
import functools
import glob
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

from mcdenoise.samples.gate import check_choice
from mcdenoise.samples.storage import cache_folder, write_beside

VARIANTS = ("scalar_rgb", "llvm_ad_rgb")
LIBRARY_VARIABLE = "DRJIT_LIBLLVM_PATH"
PROBE_SECONDS = 120
_LIBRARY_NAME = re.compile(r"libLLVM([-.]\d+)*\.so(\.\d+)*|libLLVM([-.]\d+)*\.dylib|(lib)?LLVM-C(-?\d+)?\.dll")
_FOLDERS = (
    "/usr/lib/llvm*/lib*",
    "/usr/lib/*-linux-gnu",
    "/usr/lib64",
    "/usr/lib",
    "/usr/local/lib",
    "/opt/homebrew/opt/llvm*/lib",
    "/usr/local/opt/llvm*/lib",
    "C:/Program Files/LLVM/bin",
)
# The path length is a number nobody used before: it stands in the kernel, so the probe compiles instead of finding a
# kernel that another library left in Dr.Jit's own cache.
_PROBE = """
import sys, time
try:
    import resource
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
except ImportError:
    pass
import mitsuba as mi
mi.set_variant("llvm_ad_rgb")
import numpy as np
scene = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}, "light": {"type": "constant"},
                      "integrator": {"type": "path", "max_depth": 1000 + time.time_ns() % 1000000000},
                      "sensor": {"type": "perspective", "to_world": mi.ScalarTransform4f().translate([0, 0, -4]),
                                 "film": {"type": "hdrfilm", "width": 4, "height": 4}}})
sys.exit(0 if np.isfinite(np.array(mi.render(scene, spp=2))).all() else 3)
"""


def choose_variant(variant: str = "auto") -> str:
    """Return the Mitsuba variant to use, having made sure that it really renders.

    Parameters
    ----------
    variant : str
        ``"scalar_rgb"`` needs nothing but Mitsuba's wheel. ``"llvm_ad_rgb"`` compiles and needs a libLLVM, 17 or newer
        being the safe choice. ``"auto"`` takes the environment variable ``MCDENOISE_VARIANT`` if it is set, else
        ``llvm_ad_rgb`` if it works, else ``scalar_rgb``. Where ``DRJIT_LIBLLVM_PATH`` is set, only that file is tried.

    Returns
    -------
    str
        ``"scalar_rgb"`` or ``"llvm_ad_rgb"``. For the latter, ``DRJIT_LIBLLVM_PATH`` is set to the library that works.

    Raises
    ------
    ValueError
        For another name, or if ``llvm_ad_rgb`` was asked for and no library works.

    Examples
    --------
    >>> choose_variant("scalar_rgb")
    'scalar_rgb'
    """
    source = "variant"
    if variant == "auto" and os.environ.get("MCDENOISE_VARIANT"):
        variant, source = os.environ["MCDENOISE_VARIANT"], "the environment variable MCDENOISE_VARIANT"
    wanted = check_choice(variant, ("auto", *VARIANTS), source)
    if wanted == "scalar_rgb":
        return wanted
    tried = []
    for library in candidate_libraries():
        verdict = _verdict(*_identity(library))
        if verdict == "works":
            os.environ[LIBRARY_VARIABLE] = str(library)
            if _llvm_is_up():
                return "llvm_ad_rgb"
            verdict = "works, but Dr.Jit already failed to start in this process: restart Python"
        tried.append(f"{library} ({verdict})")
    if wanted == "auto":
        return "scalar_rgb"
    raise ValueError(
        f"variant 'llvm_ad_rgb' needs an LLVM library that Dr.Jit can use; tried: {', '.join(tried) or 'none found'}. "
        f"Install LLVM 17 or newer (Debian and Ubuntu: libllvm19; conda-forge: libllvm19) or set {LIBRARY_VARIABLE} to "
        f"its file; variant='scalar_rgb' works without."
    )


@contextlib.contextmanager
def use_variant(variant: str = "auto") -> Iterator[str]:
    """Work with a Mitsuba variant and give the caller's own back afterwards.

    Examples
    --------
    >>> with use_variant("scalar_rgb") as chosen:
    ...     import mitsuba
    ...     mitsuba.variant() == chosen
    True
    """
    chosen = choose_variant(variant)
    import mitsuba as mi

    before = mi.variant()
    mi.set_variant(chosen)
    try:
        yield chosen
    finally:
        if before is not None:
            mi.set_variant(before)


def candidate_libraries() -> list[Path]:
    """Return the LLVM libraries to try, newest first; only `DRJIT_LIBLLVM_PATH` where that is set."""
    if os.environ.get(LIBRARY_VARIABLE):
        named = Path(os.environ[LIBRARY_VARIABLE])
        return [named] if named.is_file() else []
    prefixes = {sys.prefix, sys.base_prefix, os.environ.get("CONDA_PREFIX", sys.prefix)}
    patterns = [os.path.join(glob.escape(p), *end) for p in prefixes for end in (("lib",), ("Library", "bin"))]
    found = set()
    for pattern in (*patterns, *_FOLDERS):
        for folder in glob.glob(pattern):
            names = os.listdir(folder) if os.access(folder, os.R_OK) and os.path.isdir(folder) else []
            found.update(Path(folder, n).resolve() for n in names if _LIBRARY_NAME.fullmatch(n))
    return sorted((p for p in found if p.is_file()), key=lambda p: (-_llvm_version(p), str(p)))


def _llvm_version(library: Path) -> float:
    """Return the major version that the path names (``libLLVM.so.19.1``, ``llvm@18/lib``); 16.5 if it names none."""
    number = re.search(r"llvm\D{0,4}(\d+)", str(library), re.IGNORECASE)
    return float(number[1]) if number else 16.5


def _llvm_is_up() -> bool:
    """Return whether Dr.Jit's LLVM back end runs in this process (a failed start is not retried)."""
    import drjit as dr

    return dr.has_backend(dr.JitBackend.LLVM)


def _identity(library: Path) -> tuple[str, int, int]:
    """Return what tells one build of a library from another: path, time of change, size."""
    status = library.stat()
    return str(library), status.st_mtime_ns, status.st_size


@functools.cache
def _verdict(library: str, changed: int, size: int) -> str:
    """Return ``"works"`` or what went wrong, from the verdicts on disk or else from a probe."""
    shelf = cache_folder() / "llvm_probes.json"
    key = f"mitsuba {version('mitsuba')}, drjit {version('drjit')}, {library}, {changed}, {size}"
    try:
        known = json.loads(shelf.read_text("utf-8"))
        known = known if isinstance(known, dict) else {}
    except (OSError, ValueError):
        known = {}
    if isinstance(known.get(key), str):
        return known[key]
    verdict = _probe(library)
    if verdict != "took too long":  # a busy machine is no fault of the library: ask again next time
        with contextlib.suppress(OSError):
            shelf.parent.mkdir(parents=True, exist_ok=True)
            with write_beside(shelf) as temporary:
                temporary.write_text(json.dumps(known | {key: verdict}, indent=1), "utf-8")
    return verdict


def _probe(library: str) -> str:
    """Render a few pixels with `library` in a child process and return how that went."""
    try:
        child = subprocess.run(
            [sys.executable, "-c", _PROBE],
            env=os.environ | {LIBRARY_VARIABLE: library},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=PROBE_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return "took too long"
    except (OSError, ValueError) as error:
        return f"could not be tried: {error}"
    if child.returncode == 0:
        return "works"
    return f"killed the process, signal {-child.returncode}" if child.returncode < 0 else "does not render"
