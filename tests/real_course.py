"""The real notebooks, executed once for all tests that need them."""

import atexit
import functools
import shutil
import tempfile
from pathlib import Path

from mcdenoise.classroom.publishing.execute import build_notebooks, execute_all

ROOT = Path(__file__).resolve().parents[1]


@functools.cache
def executed_notebooks():
    """Return the paths of all notebooks, built for the site (solutions run, stubs shown) and executed."""
    folder = Path(tempfile.mkdtemp(prefix="mcdenoise-notebooks-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return tuple(execute_all(build_notebooks(ROOT, folder / "source"), folder / "executed"))
