"""The slider: every frame in the fragment, one seen without JavaScript, the same bytes again, nothing from outside."""

import base64
import io
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import mcdenoise as mcd
from conftest import noise
from mcdenoise.classroom.publishing.paper import find_chromium, run_chromium
from mcdenoise.study.display import tone_map
from mcdenoise.study.slider import LARGEST

LEVELS = [0.0, 0.25, 1.0]


class _Elements(HTMLParser):
    """Collects (tag, attributes), and whether every element is closed."""

    def __init__(self, text):
        super().__init__()
        self.found, self.open = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes)))
        if tag not in ("img", "input", "meta", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def all(self, tag):
        return [attributes for name, attributes in self.found if name == tag]


def _grey(level):
    return np.full((4, 6), level)


def _curve(sigma_space):
    figure = Figure(figsize=(5, 3))
    figure.subplots().plot(np.exp(-(np.linspace(-3, 3, 50) ** 2) / (2 * sigma_space**2)))
    return figure


def _pixels(source):
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(source.partition("base64,")[2]))).convert("RGB"))


def test_each_value_has_its_frame_under_the_one_tone_map():
    frames = _Elements(mcd.slider(_grey, level=LEVELS).html).all("img")
    assert [frame["data-value"] for frame in frames] == ["level = 0", "level = 0.25", "level = 1"]
    for frame, level in zip(frames, LEVELS, strict=True):
        np.testing.assert_array_equal(_pixels(frame["src"]), np.rint(255 * tone_map(np.full((4, 6, 3), level))))


@pytest.mark.parametrize(("start", "first"), [(None, 1), (0.0, 0), (1.0, 2)])
def test_one_frame_is_seen_without_javascript(start, first):
    elements = _Elements(mcd.slider(_grey, start=start, level=LEVELS).html)
    seen = ["display:block" in frame["style"] for frame in elements.all("img")]
    assert seen == [index == first for index in range(3)]
    assert elements.all("input")[0]["value"] == str(first)
    assert elements.all("input")[0]["aria-valuetext"] == elements.all("img")[first]["data-value"]
    assert not elements.open


def test_the_label_has_name_value_and_unit():
    made = mcd.slider(_curve, title="Bell & tail", unit="pixels", sigma_space=[0.5, 2, np.inf]).html
    values = [frame["data-value"] for frame in _Elements(made).all("img")]
    assert values == ["sigma_space = 0.5 pixels", "sigma_space = 2 pixels", "sigma_space = ∞ pixels"]
    assert "<output" in made
    assert "Bell &amp; tail</strong>" in made


def test_nothing_comes_from_outside_and_nothing_is_named_twice_on_a_page():
    made = mcd.slider(_grey, title="Grey", level=LEVELS)
    assert made._repr_html_() == made.html
    assert "data-lm-suppress-shortcuts" in made.html  # or JupyterLab would take the arrow keys
    assert not re.search(r"https?:|//cdn|<script|<link|\bid=", made.html)


def test_the_same_frames_give_the_same_bytes():
    assert mcd.slider(_curve, sigma_space=[1, 2]).html == mcd.slider(_curve, sigma_space=[1, 2]).html


def test_figures_full_of_noise_still_fit():
    def draw(seed):
        figure = Figure(figsize=(8, 4))
        for axes in figure.subplots(1, 2):
            axes.imshow(noise(128, 128, 3, seed=seed), interpolation="nearest")
        return figure

    made = mcd.slider(draw, seed=[1, 2, 3, 4, 5])
    assert len(made.html) <= LARGEST
    assert _pixels(_Elements(made.html).all("img")[0]["src"]).shape[1] >= 8 * 60


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({}, "exactly one parameter with its values.*got none"),
        ({"a": [1, 2], "b": [1, 2]}, "exactly one parameter.*got a, b"),
        ({"level": [1]}, "level needs two or more values"),
        ({"level": 1.0}, "level needs two or more values"),
        ({"level": LEVELS, "start": 0.3}, "start must be one of level's values"),
    ],
)
def test_a_slider_needs_one_parameter_with_values(values, message):
    with pytest.raises(ValueError, match=message):
        mcd.slider(_grey, **values)


def test_a_frame_that_is_no_picture_is_named_by_its_value():
    with pytest.raises(ValueError, match="the frame for level = 0 must be a real-valued numeric array"):
        mcd.slider(lambda level: None, level=LEVELS)


@pytest.mark.skipif(find_chromium() is None, reason="needs Chromium")
def test_moving_a_slider_shows_its_frame_and_leaves_the_others_alone(tmp_path):
    page = tmp_path / "page.html"
    move = "const s=document.querySelectorAll('input')[1];s.value=2;s.dispatchEvent(new Event('input'))"
    made = mcd.slider(_grey, level=LEVELS).html
    page.write_text(f"<!doctype html><meta charset='utf-8'><body>{made}{made}<script>{move}</script>", "utf-8")
    elements = _Elements(run_chromium(find_chromium(), "--dump-dom", page.as_uri()).stdout)
    shown = ["display:block" in frame["style"].replace(" ", "") for frame in elements.all("img")]
    assert shown == [False, True, False, False, False, True]
    assert [one["aria-valuetext"] for one in elements.all("input")] == ["level = 0.25", "level = 1"]
