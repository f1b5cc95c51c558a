"""Sphinx configuration of the lecture site. Run in a copy of this folder by mcdenoise.classroom.publishing.site."""

import json
from importlib.metadata import version as installed_version
from pathlib import Path

project = "Monte Carlo denoising"
author = "The mcdenoise authors"
project_copyright = author
version = release = installed_version("mcdenoise")

slides = tags.has("slides")  # noqa: F821 - Sphinx puts `tags` here
extensions = ["myst_nb", "sphinx_revealjs", "mcdenoise.classroom.publishing.pages"]
root_doc = "slides" if slides else "index"
exclude_patterns = [
    "README.md",
    *(["notebooks", "index.md", "instructor.md", "notation.md"] if slides else ["slides.md"]),
]

# Pages are MyST; numbers that the text quotes come from the files written with the figures: {{ ch02.impulse.peak }}.
myst_enable_extensions = ["amsmath", "attrs_inline", "colon_fence", "deflist", "dollarmath", "substitution"]
myst_heading_anchors = 3
myst_substitutions = {
    path.stem: json.loads(path.read_text("utf-8")) for path in sorted(Path(__file__).parent.glob("figures/ch*.json"))
}
numfig = True
nb_execution_mode = "off"  # the notebooks come executed
nb_merge_streams = True

# One local file for all formulas; sites of this package need no network.
mathjax_path = "mathjax/tex-svg.js"
mathjax3_config = {"svg": {"fontCache": "global"}, "options": {"enableMenu": False}}

html_theme = "sphinx_book_theme"
html_title = project
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = html_show_sourcelink = False
html_show_search_summary = False  # a page opened from a disk may not read the text of others
html_theme_options = {
    "show_toc_level": 2,
    "use_download_button": False,
    "use_fullscreen_button": False,
    "navbar_persistent": [],  # the search field stands in the side bar
}
pygments_style = "default"

revealjs_style_theme = "white"
revealjs_static_path = ["_static"]
revealjs_css_files = ["slides.css"]
revealjs_script_conf = {
    "width": 1280,
    "height": 720,
    "margin": 0.02,
    "center": False,
    "controls": True,
    "hash": True,
    "slideNumber": "c/t",
    "transition": "none",
    "navigationMode": "linear",
}
