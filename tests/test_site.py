"""The lecture site: a small course and the real one, built with warnings as errors; nothing comes from the network."""

import json
import re
import shutil
from html.parser import HTMLParser

import numpy as np
import pytest

import mcdenoise as mcd
from fake_course import make_course, replace
from mcdenoise.classroom.publishing import pages, paper, site
from real_course import ROOT, executed_notebooks

PAGE = r"""# 08 Fake

A number: {{ ch08.bell.peak }}, and two of them: {{ (2 * ch08.bell.peak) | round(2) }}.

## A formula

$$ y = 2 x $$ (eq-double)

See {eq}`eq-double` and {numref}`fig-bell`. WORDS

```{figure} figures/ch08_bell.png
:name: fig-bell
The bell.
```

### A dial

```{raw} html
:file: figures/ch08_dial.html
```
"""
PAGE = PAGE.replace("WORDS", "word " * 200)  # more than one slide holds
INDEX = """# Fake course

[08](ch08_fake.md), [its notebook](notebooks/ch08_fake.ipynb)

```{toctree}
ch08_fake
notebooks/ch08_fake
```
"""
SLIDES = "# Slides\n\n```{toctree}\nch08_fake\n```\n"


def _lectures(root):
    """Give a course a lecture page with a figure, a slider and quoted numbers."""
    folder = root / "lectures"
    (folder / "figures").mkdir(parents=True)
    shutil.copy(ROOT / "lectures" / "conf.py", folder)
    shutil.copytree(ROOT / "lectures" / "_static", folder / "_static")
    for name, text in {"ch08_fake": PAGE, "index": INDEX, "slides": SLIDES}.items():
        (folder / f"{name}.md").write_text(text)
    (folder / "figures" / "ch08.json").write_text(json.dumps({"bell": {"peak": 0.0177}, "dial": {}}))
    mcd.show_images({"bell": np.eye(8)}).savefig(folder / "figures" / "ch08_bell.png")
    dial = mcd.slider(lambda level: np.full((4, 4), level), level=[0, 0.5, 1])
    (folder / "figures" / "ch08_dial.html").write_text(dial.html)
    return root


@pytest.fixture
def course(tmp_path):
    return _lectures(make_course(tmp_path / "course"))


def _assemble(course, tmp_path):
    """Assemble with the notebook as it is, not executed."""
    from mcdenoise.classroom.publishing.execute import build_notebooks

    return site.assemble(course, build_notebooks(course, tmp_path / "notebooks"), tmp_path / "source")


class _Loads(HTMLParser):
    """What a page loads by itself (not what it links to), and its images."""

    def __init__(self, path):
        super().__init__()
        self.found = []
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        loads = [attributes.get(name) for name in ("src", "srcset", "data", "poster")]
        loads += [attributes.get("href")] if tag == "link" else []
        loads += re.findall(r"url\(([^)]*)\)", attributes.get("style") or "")
        self.found += [one for one in loads if one]


def _outside(folder):
    """Everything that pages and style sheets below `folder` would load from elsewhere, or that does not exist."""
    faults = []
    for page in folder.rglob("*.html"):
        if "_static" in page.relative_to(folder).parts:
            continue
        for one in _Loads(page).found:
            place = one.partition("?")[0].partition("#")[0]
            if re.match(r"(https?:)?//", one) or not (
                one.startswith("data:") or (page.parent / place).is_file() or not place
            ):
                faults.append(f"{page.relative_to(folder)}: {one[:80]}")
    for style in folder.rglob("*.css"):
        text = re.sub(r"/\*.*?\*/", "", style.read_text("utf-8"), flags=re.DOTALL)
        faults += [
            f"{style.name}: {one}" for one in re.findall(r"(?:url\(|@import)\s*[\"']?((?:https?:)?//[^)\"']*)", text)
        ]
    return faults


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The site and slides of the small course."""
    folder = tmp_path_factory.mktemp("site")
    source = _assemble(_lectures(make_course(folder / "course")), folder)
    site.build_pages(source, folder / "out", "html", ["pdf"])
    site.build_pages(source, folder / "out" / "slides", "revealjs", ["slides"])
    return folder / "out"


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    """The real site and slides."""
    folder = tmp_path_factory.mktemp("real")
    source = site.assemble(ROOT, executed_notebooks(), folder / "source")
    site.build_pages(source, folder / "out", "html")
    site.build_pages(source, folder / "out" / "slides", "revealjs", ["slides"])
    return folder / "out"


def test_numbers_of_the_figures_stand_in_the_text(built):
    text = (built / "ch08_fake.html").read_text("utf-8")
    assert "A number: 0.0177, and two of them: 0.04." in text


def test_a_chapter_links_to_its_other_forms(built):
    page, notebook = ((built / name).read_text("utf-8") for name in ("ch08_fake.html", "notebooks/ch08_fake.html"))
    for target in ("notebooks/ch08_fake.html", "downloads/ch08_fake.zip", "slides/ch08_fake.html", "pdf/ch08_fake.pdf"):
        assert f'href="{target}"' in page
    assert 'href="../ch08_fake.html"' in notebook
    assert "chapter-links" not in (built / "index.html").read_text("utf-8")


def test_pages_show_stubs_and_no_solution(built):
    text = re.sub(r"<[^>]*>", "", (built / "notebooks" / "ch08_fake.html").read_text("utf-8"))
    assert "bell_at_one is not written yet" in text
    assert "distance_squared" not in text


def test_the_small_site_needs_no_network(built):
    assert _outside(built) == []


def test_formulas_are_set_by_the_local_mathjax(built):
    for page in (built / "ch08_fake.html", built / "slides" / "ch08_fake.html"):
        text = page.read_text("utf-8")
        assert r"\[ y = 2 x \]" in text
        assert 'src="_static/mathjax/tex-svg.js"' in text
        assert (page.parent / "_static/mathjax/tex-svg.js").stat().st_size > 1e6


def test_each_section_is_a_column_of_slides(built):
    text = (built / "slides" / "ch08_fake.html").read_text("utf-8")
    assert list(dict.fromkeys(re.findall(r"<h[123]>(.*?)</h", text))) == ["08 Fake", "A formula", "A dial"]
    assert 'class="mcd-slider"' in text
    assert "revealjs/dist/theme/white.css" in text


def test_a_full_section_goes_on_on_another_slide(built):
    text = (built / "slides" / "ch08_fake.html").read_text("utf-8")
    first, second = text.index("<h2>A formula</h2>"), text.rindex("<h2>A formula</h2>")
    assert first < text.rindex("word") < second < text.index("ch08_bell.png")


FAULTS = (
    ("A number: {{ ch08.bell.peak }}", "{{ ch08.bell.height }}", "no attribute 'height'"),
    ("{{ (2 * ch08.bell.peak) | round(2) }}", "{{ ch09.bell.peak }}", "'ch09' is undefined"),
    ("figures/ch08_bell.png", "figures/ch08_bells.png", "image file not readable: figures/ch08_bells.png"),
    ("figures/ch08_dial.html", "figures/ch08_dials.html", "ch08_dials.html"),
    ("{eq}`eq-double`", "{eq}`eq-triple`", "eq-triple"),
    ("See ", "[there](nowhere.md)", "nowhere.md"),
)


def test_faults_in_a_page_stop_the_build_and_are_all_named(course, tmp_path):
    for old, new, _ in FAULTS:
        replace(course, "lectures/ch08_fake.md", old, new)
    with pytest.raises(ValueError, match=rf"The html pages have {len(FAULTS)} faults:\n") as caught:
        site.build_pages(_assemble(course, tmp_path), tmp_path / "out", "html")
    for *_, message in FAULTS:
        assert message in str(caught.value)
    assert "lectures/ch08_fake.md:" in str(caught.value)


def test_lectures_are_built_in_a_clone(tmp_path, monkeypatch, capsys):
    with pytest.raises(ValueError, match=r"lectures/conf\.py"):
        site.assemble(tmp_path, [], tmp_path / "source")
    monkeypatch.chdir(tmp_path)
    assert site.main(["--no-pdf"]) == 2
    assert "lectures: " in capsys.readouterr().err


def test_missing_tools_are_named_with_what_to_install(monkeypatch, capsys):
    monkeypatch.setattr(site, "find_spec", lambda name: None if name == "myst_nb" else object())
    assert site.main([]) == 2
    err = capsys.readouterr().err
    assert "needs myst_nb: python -m pip install 'mcdenoise[lectures]'" in err
    assert err.count("\n") == 1


def test_missing_mathjax_is_named(monkeypatch):
    monkeypatch.setattr(pages, "find_spec", lambda name: None)
    with pytest.raises(ValueError, match="package sphinx-mathjax-offline"):
        pages.mathjax_file()


@pytest.fixture
def quick(course, monkeypatch):
    """A course whose site is built without executing its notebook or running Sphinx."""

    def pretend(source, target, builder, tags=()):
        target.mkdir(parents=True)
        (target / f"{builder}-{'-'.join(tags)}").touch()
        for page in ("ch08_fake", "index"):  # and none for slides.md, which is no page of the site
            (target / f"{page}.html").touch()

    monkeypatch.chdir(course)
    monkeypatch.setattr(site, "execute_all", lambda notebooks, folder: notebooks)
    monkeypatch.setattr(site, "build_pages", pretend)
    monkeypatch.setattr(site, "print_pages", lambda folder, pages, target, chromium: print("printed", *pages))
    return course


def test_the_command_builds_everything_in_order(quick, monkeypatch, capsys):
    monkeypatch.setattr(site, "find_chromium", lambda: "chromium")
    assert site.main([]) == 0
    out = capsys.readouterr().out
    assert "printed ch08_fake index\n" in out
    assert (quick / "out/lectures/html-pdf").exists()
    assert (quick / "out/lectures/slides/revealjs-slides").exists()
    assert sorted(path.name for path in (quick / "out/lectures/downloads").glob("*.zip")) == [
        "ch08_fake.zip",
        "exercises.zip",
    ]
    assert out.splitlines()[-1].startswith(f"Open {quick / 'out/lectures/index.html'} in a browser")


def test_without_chromium_there_are_no_pdfs_and_no_links_to_them(quick, monkeypatch, capsys):
    monkeypatch.setattr(site, "find_chromium", lambda: None)
    assert site.main([]) == 0
    assert "PDF left out" in capsys.readouterr().out
    assert (quick / "out/lectures/html-").exists()


@pytest.mark.skipif(paper.find_chromium() is None, reason="needs Chromium")
def test_pages_are_printed(built, tmp_path):
    (written,) = paper.print_pages(built, ["ch08_fake"], tmp_path / "pdf", paper.find_chromium())
    assert written == tmp_path / "pdf" / "ch08_fake.pdf"
    assert written.read_bytes().startswith(b"%PDF")
    assert written.stat().st_size > 10_000


def test_a_browser_that_fails_is_reported(built, tmp_path):
    with pytest.raises(ValueError, match=r"false could not print .*ch08_fake\.html: no PDF came out"):
        paper.print_pages(built, ["ch08_fake"], tmp_path / "pdf", shutil.which("false"))
    assert not list((tmp_path / "pdf").iterdir())


def test_the_server_answers_this_machine_alone_and_stops(tmp_path):
    from urllib.error import URLError
    from urllib.request import urlopen

    (tmp_path / "page.html").write_text("here")
    with paper.serve(tmp_path) as address:
        assert address.startswith("http://127.0.0.1:")
        assert urlopen(f"{address}/page.html").read() == b"here"
    with pytest.raises(URLError):
        urlopen(f"{address}/page.html", timeout=2)


def test_the_real_site_needs_no_network(real):
    assert _outside(real) == []


def test_the_real_pages_have_no_open_substitution(real):
    open_ones = [page.name for page in real.rglob("*.html") if re.search(r"\{\{ *ch\d\d", page.read_text("utf-8"))]
    assert not open_ones


def test_the_real_formulas_are_tex_for_the_local_mathjax(real):
    chapters = sorted(real.glob("ch*.html"))
    assert [page.stem for page in chapters] == sorted(path.stem for path in (ROOT / "lectures").glob("ch*.md"))
    for page in chapters:
        text = page.read_text("utf-8")
        assert 'src="_static/mathjax/tex-svg.js"' in text
        assert text.count(r"\[") + text.count(r"\(") >= 5, f"{page.name} has formulas"


def test_every_stored_figure_is_used_by_its_page():
    unused = []
    for path in sorted((ROOT / "lectures" / "figures").glob("ch*_*")):
        pages_of_chapter = (ROOT / "lectures").glob(f"{path.name[:4]}_*.md")
        if not any(f"figures/{path.name}" in page.read_text("utf-8") for page in pages_of_chapter):
            unused.append(path.name)
    assert not unused


@pytest.mark.parametrize("page", sorted((ROOT / "lectures").glob("ch*.md")), ids=lambda path: path.stem)
def test_each_chapter_has_its_notebook_and_figures_with_names(page):
    assert (ROOT / "notebooks" / f"{page.stem}.py").is_file()
    text = page.read_text("utf-8")
    figures = re.findall(r"```\{figure\} (\S+)\n((?::\w+:.*\n)*)", text)
    assert len(figures) >= 5
    assert not [path for path, options in figures if ":name: " not in options]
    assert text.startswith("# ")


def test_slides_of_the_real_chapters_exist(real):
    for page in (ROOT / "lectures").glob("ch*.md"):
        columns = len(re.findall(r"^## ", page.read_text("utf-8"), re.MULTILINE))
        assert (real / "slides" / f"{page.stem}.html").read_text("utf-8").count("<h2>") >= columns
