"""Execute the notebooks: `python -m mcdenoise.classroom.publishing.execute` runs each in a kernel of its own, two at a time.

They are executed as an instructor has them, on the reference functions, in the form that the lecture site shows; the first
error stops everything.
"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

from tqdm import tqdm

from mcdenoise.classroom.building.build import write_notebooks, write_tests
from mcdenoise.classroom.building.chapters import find_root, read_chapters
from mcdenoise.classroom.building.notebook import Kind
from mcdenoise.samples.storage import write_beside
from mcdenoise.study.arguments import OneLineParser

CELL_SECONDS = 300
WORKERS = 2


def build_notebooks(root: Path, folder: Path, kind: Kind = "site") -> list[Path]:
    """Write every chapter's notebook, not yet executed, with its data and public tests.

    Parameters
    ----------
    root : the clone. folder : gets notebooks/ and tests/; what it held before is removed.
    kind : as in `mcdenoise.classroom.building.notebook`: ``"site"`` or ``"solution"``.

    Returns
    -------
    Paths of the notebooks, in order.

    Raises
    ------
    ValueError
        If a chapter has a mistake; says which and where.
    """
    chapters = read_chapters(root)
    shutil.rmtree(folder, ignore_errors=True)
    write_notebooks(chapters, root, folder / "notebooks", kind)
    write_tests(chapters, folder)
    return [folder / "notebooks" / f"{chapter.name}.ipynb" for chapter in chapters]


def execute(notebook: Path, target: Path) -> Path:
    """Run a notebook in its own folder, with failing checks as errors, and write it with its outputs to `target`.

    Raises
    ------
    ValueError
        If a cell raises, runs longer than 300 seconds, or the kernel dies; the message has the cell and the error.
    """
    import nbformat
    from nbclient import NotebookClient
    from nbclient.exceptions import CellExecutionError, CellTimeoutError, DeadKernelError

    content = nbformat.read(notebook, as_version=4)
    client = NotebookClient(
        content,
        timeout=CELL_SECONDS,
        kernel_name="python3",
        resources={"metadata": {"path": str(notebook.parent)}},
        extra_arguments=["--log-level=ERROR"],
    )
    environment = {name: value for name, value in os.environ.items() if name != "MPLBACKEND"}  # the kernel has its own
    try:
        client.execute(env=environment | {"MCDENOISE_STRICT": "1"})
    except CellExecutionError as error:
        raise ValueError(f"{notebook.name} stops with {error.ename}: {error.evalue}\n{error.traceback}") from None
    except (CellTimeoutError, DeadKernelError) as error:
        raise ValueError(f"{notebook.name} could not be executed: {error}") from None
    with write_beside(target) as temporary:
        nbformat.write(content, temporary)
    return target


def execute_all(notebooks: Sequence[Path], folder: Path) -> list[Path]:
    """Execute notebooks, two at a time, into `folder` (made if missing); returns the written paths in the given order.

    Raises
    ------
    ValueError
        As `execute`, for the first notebook that fails; those not begun are not executed.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(WORKERS, mp_context=get_context("spawn")) as pool:
        jobs = [pool.submit(execute, notebook, folder / notebook.name) for notebook in notebooks]
        try:
            for job in tqdm(as_completed(jobs), total=len(jobs), desc="notebooks", unit="notebook", disable=None):
                job.result()
        finally:
            pool.shutdown(cancel_futures=True)
    return [job.result() for job in jobs]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code: 2 with the cell and its error if a notebook fails."""
    parser = OneLineParser(
        prog="python -m mcdenoise.classroom.publishing.execute", description="Execute all notebooks into out/notebooks."
    )
    parser.parse_args(arguments)
    try:
        root = find_root()
        for path in execute_all(build_notebooks(root, root / "out" / "notebooks-source"), root / "out" / "notebooks"):
            print(path.relative_to(root))
    except (ValueError, OSError) as error:
        print(f"notebooks: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
