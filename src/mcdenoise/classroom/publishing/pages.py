"""A Sphinx extension for the lecture pages: a bar of links under each title, local MathJax, and slides that are not too full.

Sphinx and docutils are imported inside functions: they come with the extra `lectures`.
"""

from __future__ import annotations

import html
import math
import re
import shutil
import struct
from importlib.util import find_spec
from pathlib import Path

from mcdenoise.samples.storage import write_beside

CHAPTER = re.compile(r"(notebooks/)?(ch\d\d_\w+)")
LINE = 35  # pixels of a line of text on a slide, as slides.css sets it
LINE_CHARACTERS = 100
SLIDE_LINES = 18  # what one slide holds below its title
WIDEST, HIGHEST = 1220, 400  # pixels of a figure on a slide
SLIDER_LINES = 14


def setup(app: object) -> dict[str, object]:
    """Register with Sphinx."""
    app.connect("html-page-context", add_links)
    app.connect("doctree-resolved", break_slides)
    app.connect("build-finished", copy_mathjax)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def add_links(app: object, page: str, template: str, context: dict, doctree: object) -> None:
    """Put the chapter's other forms (notebook, slides, PDF, download) under the title of its pages."""
    found = CHAPTER.fullmatch(page)
    if app.builder.name == "html" and found and "body" in context:
        bar = links(found[2], in_notebook=found[1] is not None, pdf=app.tags.has("pdf"))
        context["body"] = context["body"].replace("</h1>", f"</h1>\n{bar}", 1)


def links(chapter: str, *, in_notebook: bool, pdf: bool) -> str:
    """Return the bar of links of a chapter, as seen from its lecture page or from its notebook.

    Examples
    --------
    >>> links("ch02_gaussian", in_notebook=False, pdf=False).count("<a ")
    3
    """
    up = "../" if in_notebook else ""
    targets = [
        (f"{up}{chapter}.html", "lecture page")
        if in_notebook
        else (f"notebooks/{chapter}.html", "notebook with results"),
        (f"{up}downloads/{chapter}.zip", "notebook to work on (zip)"),
        (f"{up}slides/{chapter}.html", "slides"),
        *([(f"{up}pdf/{chapter}.pdf", "PDF")] if pdf else []),
    ]
    shown = " · ".join(f'<a href="{html.escape(target)}">{text}</a>' for target, text in targets)
    return f'<p class="chapter-links">{shown}</p>'


def break_slides(app: object, doctree: object, page: str) -> None:
    """Start another slide, under the same title, where a section holds more than one slide can show."""
    if app.builder.name != "revealjs":
        return
    from docutils import nodes
    from sphinx_revealjs.nodes import revealjs_break

    for section in list(doctree.findall(nodes.section)):
        used = 0.0
        for child in list(section.children):
            if isinstance(child, nodes.section):
                break
            lines = height(child, Path(app.srcdir))
            if used and used + lines > SLIDE_LINES:
                section.insert(section.index(child), revealjs_break())
                used = 0.0
            used += lines


def height(node: object, folder: Path) -> float:
    """Return about how many lines of text a docutils node takes on a slide; `folder` is where its images lie."""
    from docutils import nodes

    if isinstance(node, (nodes.title, nodes.comment, nodes.target, nodes.Invisible)):
        return 0.0
    if isinstance(node, nodes.raw):
        return float(SLIDER_LINES if "<img" in node.astext() else 2)
    if isinstance(node, nodes.image):
        width, rows = png_size(folder / node["uri"])
        return 0.5 + min(HIGHEST, rows * WIDEST / width, rows) / LINE
    if isinstance(node, nodes.caption):
        return 0.3 + 0.75 * math.ceil(len(node.astext()) / (LINE_CHARACTERS * 1.3))
    if isinstance(node, nodes.math_block):
        return 2.5 + 1.4 * node.astext().count(r"\\")
    if isinstance(node, nodes.literal_block):
        return 1.0 + 0.8 * len(node.astext().splitlines())
    if isinstance(node, nodes.row):
        return 0.7 + max(math.ceil(len(entry.astext()) * len(node) / LINE_CHARACTERS) for entry in node)
    if isinstance(node, (nodes.paragraph, nodes.term)):
        return 0.5 + math.ceil(len(node.astext()) / LINE_CHARACTERS)
    return sum(height(child, folder) for child in getattr(node, "children", ()))


def png_size(path: Path) -> tuple[int, int]:
    """Return width and height in pixels of a PNG, a square for anything else."""
    start = path.read_bytes()[:24] if path.is_file() else b""
    return struct.unpack(">II", start[16:24]) if start.startswith(b"\x89PNG") else (1000, 1000)


def copy_mathjax(app: object, failure: Exception | None) -> None:
    """Put MathJax beside the pages: one file with its fonts inside (tex-svg.js)."""
    if failure is None and app.builder.format == "html":
        target = Path(app.outdir, "_static", "mathjax", "tex-svg.js")
        target.parent.mkdir(parents=True, exist_ok=True)
        with write_beside(target) as temporary:
            shutil.copyfile(mathjax_file(), temporary)


def mathjax_file() -> Path:
    """Return MathJax as installed by the package sphinx-mathjax-offline.

    Raises
    ------
    ValueError
        If it is not installed.
    """
    package = find_spec("sphinx-mathjax-offline")
    if package is None or package.origin is None:
        raise ValueError(
            "Formulas need the package sphinx-mathjax-offline: python -m pip install 'mcdenoise[lectures]'."
        )
    return Path(package.origin).parent / "static" / "mathjax" / "tex-svg.js"
