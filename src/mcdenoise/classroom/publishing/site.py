"""The lecture site: `python -m mcdenoise.classroom.publishing.site` builds pages, executed notebooks, slides and PDFs.

One function a step: the notebooks are built and executed (`execute`), `assemble` gathers the sources, `build_pages` runs
Sphinx (once for the site, once for the slides), `release` packs what students work on, and
`paper.print_pages` prints. All of it goes into out/lectures of the clone and is made again each time.
"""

from __future__ import annotations

import contextlib
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path

from mcdenoise.classroom.building.chapters import find_root
from mcdenoise.classroom.building.release import release
from mcdenoise.classroom.publishing.execute import build_notebooks, execute_all
from mcdenoise.classroom.publishing.paper import find_chromium, print_pages
from mcdenoise.study.arguments import OneLineParser

NEEDED = (
    "sphinx",
    "myst_nb",
    "sphinx_book_theme",
    "sphinx_revealjs",
    "sphinx-mathjax-offline",
    "nbclient",
    "ipykernel",
)
SLIDE_THEME = "white"


def check_tools() -> None:
    """Make sure that everything the site needs is installed.

    Raises
    ------
    ValueError
        If something is missing; says what, and how to install it.
    """
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise ValueError(
            f"The lecture site needs {', '.join(missing)}: python -m pip install 'mcdenoise[lectures]' "
            "(in a clone: make lectures)."
        )


def assemble(root: Path, notebooks: Sequence[Path], source: Path) -> Path:
    """Copy the lectures, the executed notebooks and the notation into one source folder for Sphinx.

    Parameters
    ----------
    root : the clone, with lectures/ and NOTATION.md.
    notebooks : executed notebooks.
    source : the folder to make; what it held before is removed.

    Raises
    ------
    ValueError
        If `root` has no lectures.
    """
    if not (root / "lectures" / "conf.py").is_file():
        raise ValueError(f"The lectures are built in the root of a clone, which has lectures/conf.py; {root} has not.")
    shutil.rmtree(source, ignore_errors=True)
    shutil.copytree(root / "lectures", source, ignore=shutil.ignore_patterns("README.md", "__pycache__"))
    (source / "notebooks").mkdir()
    for notebook in notebooks:
        shutil.copyfile(notebook, source / "notebooks" / notebook.name)
    if (root / "NOTATION.md").is_file():
        shutil.copyfile(root / "NOTATION.md", source / "notation.md")
    return source


def build_pages(source: Path, target: Path, builder: str, tags: Sequence[str] = ()) -> None:
    """Run Sphinx with warnings as errors.

    Parameters
    ----------
    source : an assembled folder.
    target : the folder for the pages; what it held before is removed.
    builder : ``"html"`` or ``"revealjs"``.
    tags : Sphinx tags: ``"slides"`` leaves out what is no slide, ``"pdf"`` links to the PDFs.

    Raises
    ------
    ValueError
        With Sphinx's own lines, if anything is wrong in the pages.
    """
    shutil.rmtree(target, ignore_errors=True)
    doctrees = source.parent / "doctrees" / builder
    shutil.rmtree(doctrees, ignore_errors=True)
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", builder, "-d", str(doctrees)]
    command += [part for tag in tags for part in ("-t", tag)]
    done = subprocess.run([*command, str(source), str(target)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = (done.stderr.strip() or done.stdout.strip()).replace(f"{source}/", "lectures/")
        faults = len(re.findall(r"\b(?:WARNING|ERROR|CRITICAL|SEVERE): ", lines))
        raise ValueError(f"The {builder} pages have {faults} faults:\n{lines}")
    if builder == "revealjs":
        for theme in (target / "_static").glob("revealjs/dist/theme/*.css"):
            if theme.stem != SLIDE_THEME:
                theme.unlink()  # some would load fonts from the network


def build_site(root: Path, *, pdf: bool = True) -> Path:
    """Build everything and return the folder of the site, `root`/out/lectures.

    Raises
    ------
    ValueError
        If a tool is missing, a notebook stops, or a page has a fault.
    """
    check_tools()
    out, chromium = root / "out", find_chromium() if pdf else None
    site, source = out / "lectures", out / "lectures-source"
    with _step("execute the notebooks"):
        sources = build_notebooks(root, out / "notebooks-source")
        notebooks = execute_all(sources, out / "notebooks")
    with _step("build the pages"):
        assemble(root, notebooks, source)
        build_pages(source, site, "html", ["pdf"] if chromium else [])
    with _step("build the slides"):
        build_pages(source, site / "slides", "revealjs", ["slides"])
    with _step("pack the notebooks to work on"):
        release(root, site / "downloads")
    if chromium:
        with _step("print PDFs"):
            names = sorted(page.stem for page in source.glob("*.md"))
            print_pages(site, [name for name in names if (site / f"{name}.html").is_file()], site / "pdf", chromium)
    elif pdf:
        print("PDF left out: neither Chromium nor Chrome was found (Debian: apt install chromium).")
    return site


@contextlib.contextmanager
def _step(name: str) -> Iterator[None]:
    """Say what is being done, and how long it took."""
    print(f"{name} ...", flush=True)
    begin = time.perf_counter()
    yield
    print(f"{name}: {time.perf_counter() - begin:.0f} s", flush=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code: 2 for what could not be built, with the reason on standard error."""
    parser = OneLineParser(
        prog="python -m mcdenoise.classroom.publishing.site", description="Build the lecture site into out/lectures."
    )
    parser.add_argument("--no-pdf", action="store_true", help="leave out the PDFs")
    options = parser.parse_args(arguments)
    try:
        site = build_site(find_root(), pdf=not options.no_pdf)
    except (ValueError, OSError) as error:
        print(f"lectures: {error}", file=sys.stderr)
        return 2
    print(f"Open {site / 'index.html'} in a browser; it needs no network. Slides: {site / 'slides' / 'slides.html'}.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
