"""The one way to compile a kernel, and the folder where compiled kernels are kept.

Numba keeps compiled code beside a file's time stamp and size, so it does not see that a function in ANOTHER file has
changed. Our cache folder is therefore named after a hash of all kernel sources and of numba's version: change anything
and it is a new folder.
"""

from __future__ import annotations

import functools
import hashlib
import tempfile
from collections.abc import Callable
from pathlib import Path

import llvmlite.binding as llvm
import numba
from numba import config

from mcdenoise.samples.storage import cache_folder

# Sums may be regrouped and multiply-adds fused. Not "fast": that would also promise that no NaN or infinity ever
# occurs.
FASTMATH = {"reassoc", "contract", "nsz", "arcp"}
# A division by zero gives infinity or NaN as in NumPy; the check for it that Python asks for would stop vectorisation.
ERROR_MODEL = "numpy"


def kernel(function: Callable | None = None, *, parallel: bool = False) -> Callable:
    """Compile `function` with numba: cached on disk where a folder can be written, `parallel` over its prange loops.

    Examples
    --------
    >>> @kernel
    ... def twice(x):
    ...     return x + x
    >>> twice(2)
    4
    """
    if function is None:
        return functools.partial(kernel, parallel=parallel)
    folder = _writable(kernel_folder()) if Path(function.__code__.co_filename).is_file() else None
    before, config.CACHE_DIR = config.CACHE_DIR, folder or ""
    try:
        options = {"fastmath": FASTMATH, "error_model": ERROR_MODEL, "nogil": True}
        return numba.njit(cache=folder is not None, parallel=parallel, **options)(function)
    finally:
        config.CACHE_DIR = before


@functools.cache
def kernel_folder() -> Path:
    """Return the folder of compiled kernels for these sources and this numba; it need not exist.

    Examples
    --------
    >>> kernel_folder().name.startswith("kernels-")
    True
    """
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.name.encode() + path.read_bytes())
    return cache_folder() / f"kernels-{digest.hexdigest()[:16]}"


@functools.cache
def _writable(folder: Path) -> str | None:
    """Return `folder` as text if a file can be written there, else None: then kernels are compiled once per process."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return str(folder)
    except OSError:
        return None


def compiler_facts() -> dict[str, str | int]:
    """Return what decides the speed of kernels here: numba's version, its threads, the CPU, its widest vector unit.

    Examples
    --------
    >>> sorted(compiler_facts())
    ['cpu', 'numba', 'simd', 'threads']
    """
    features = llvm.get_host_cpu_features()
    known = ("avx512f", "avx2", "fma", "avx", "sse4.2", "sve", "neon")
    simd = "+".join(name for name in known if features.get(name)) or "unknown"
    return {
        "numba": numba.__version__,
        "threads": numba.get_num_threads(),
        "cpu": llvm.get_host_cpu_name(),
        "simd": simd,
    }
