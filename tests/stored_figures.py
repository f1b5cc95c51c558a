"""What the tests of the chapters' figures share: stored numbers, files, and the page that quotes and shows them."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "lectures" / "figures"


def stored_numbers(chapter):
    """The numbers that were stored with the figures of a chapter."""
    return json.loads((FOLDER / f"{chapter}.json").read_text("utf-8"))


def page_of(chapter):
    """The text of the lecture page."""
    (path,) = (ROOT / "lectures").glob(f"{chapter}_*.md")
    return path.read_text("utf-8")


def assert_same_numbers(made, stored):
    """Equal up to the digits that are stored."""
    if isinstance(stored, dict):
        assert made.keys() == stored.keys()
        for name in stored:
            assert_same_numbers(made[name], stored[name])
    elif isinstance(stored, str):
        assert made == stored
    else:
        np.testing.assert_allclose(made, stored, rtol=2e-3, atol=1e-6)


def assert_stored_shown_and_small(chapter, figures):
    """Every figure of a chapter has its numbers and its file, is on the page, and is small."""
    stored, page = stored_numbers(chapter), page_of(chapter)
    assert stored.keys() == figures.keys()
    for name in figures:
        (path,) = FOLDER.glob(f"{chapter}_{name}.*")
        assert f"figures/{path.name}" in page, f"{path.name} is on no page"
        assert path.stat().st_size < (600_000 if path.suffix == ".html" else 200_000), path.name


def assert_quoted_numbers_exist(chapter, at_least):
    """Everything that the page quotes can be filled in."""
    jinja2 = pytest.importorskip("jinja2")
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined)
    quoted = re.findall(r"\{\{.*?\}\}", page_of(chapter), re.DOTALL)
    assert len(quoted) > at_least
    for one in quoted:
        assert environment.from_string(one).render(**{chapter: stored_numbers(chapter)}).strip()
