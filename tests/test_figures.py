"""The figures of the lectures: what is stored is what FIGURES makes, with its numbers; and how the command behaves."""

import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import mcdenoise as mcd
from conftest import noise
from mcdenoise.study.figures import __main__ as figures
from mcdenoise.study.slider import LARGEST

STORED = Path(__file__).resolve().parents[1] / "lectures" / "figures"


def _chart():
    figure = Figure(figsize=(3, 2))
    figure.subplots().plot([0, 1])
    return figure, {"peak": np.float32(0.0176843), "spp": 8, "per_scene": {"dof": [1.23456, 2]}}


def _slider():
    return mcd.slider(lambda level: np.full((4, 4), level), level=[0, 1]), {}


@pytest.fixture
def chapter(monkeypatch):
    """A made-up chapter 99 with a chart and a slider."""
    made = {"chart": _chart, "dial": _slider}
    monkeypatch.setattr(figures, "CHAPTERS", ("ch99",))
    monkeypatch.setattr(figures, "figures_of", lambda chapter: made)
    return made


@pytest.mark.parametrize("chapter", figures.CHAPTERS)
def test_the_stored_figures_are_those_that_figures_makes(chapter):
    makers = set(figures.figures_of(chapter))
    files = [path.stem.removeprefix(f"{chapter}_") for path in STORED.glob(f"{chapter}_*")]
    assert sorted(files) == sorted(makers), f"python -m mcdenoise.study.figures {chapter}"
    assert set(json.loads((STORED / f"{chapter}.json").read_text("utf-8"))) == makers


def test_every_stored_file_belongs_to_a_chapter():
    strays = [path.name for path in STORED.iterdir() if path.name[:4] not in figures.CHAPTERS]
    assert not strays


@pytest.mark.parametrize("path", sorted(STORED.glob("ch*_*")), ids=lambda path: path.name)
def test_stored_figures_are_small(path):
    assert path.suffix in (".png", ".html")
    assert path.stat().st_size <= (figures.LARGEST if path.suffix == ".png" else LARGEST)


def test_a_chart_a_slider_and_their_numbers_are_stored(chapter, tmp_path, capsys):
    assert figures.main(["--out", str(tmp_path)]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ch99.json", "ch99_chart.png", "ch99_dial.html"]
    assert (tmp_path / "ch99_chart.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "ch99_dial.html").read_text("utf-8") == _slider()[0].html
    stored = json.loads((tmp_path / "ch99.json").read_text("utf-8"))
    assert stored == {"chart": {"peak": 0.01768, "spp": 8, "per_scene": {"dof": [1.235, 2]}}, "dial": {}}
    assert capsys.readouterr().out.splitlines() == [
        str(tmp_path / f"ch99{end}") for end in (".json", "_chart.png", "_dial.html")
    ]


def test_a_figure_full_of_noise_is_made_to_fit(chapter, tmp_path):
    def noisy():
        figure = Figure(figsize=(9, 5))
        for axes in figure.subplots(1, 2):
            axes.imshow(noise(128, 128, 3), interpolation="nearest")
        return figure, {}

    chapter["chart"] = noisy
    figures.main(["ch99", "--out", str(tmp_path)])
    assert (tmp_path / "ch99_chart.png").stat().st_size <= figures.LARGEST


def test_one_figure_made_again_leaves_the_numbers_of_the_others(chapter, tmp_path):
    figures.main(["ch99", "--out", str(tmp_path)])
    chapter["chart"] = lambda: (_chart()[0], {"peak": 2})
    chapter["dial"] = lambda: pytest.fail("not asked for")
    assert figures.main(["ch99", "--only", "chart", "--out", str(tmp_path)]) == 0
    assert json.loads((tmp_path / "ch99.json").read_text("utf-8")) == {"chart": {"peak": 2}, "dial": {}}


def test_numbers_of_a_figure_that_is_no_more_are_dropped(chapter, tmp_path):
    figures.main(["ch99", "--out", str(tmp_path)])
    del chapter["chart"]
    figures.main(["ch99", "--out", str(tmp_path)])
    assert set(json.loads((tmp_path / "ch99.json").read_text("utf-8"))) == {"dial"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["ch42"], "There are figures for ch99; got 'ch42'"),
        (["ch99", "--only", "none"], "ch99 has the figures chart, dial; got 'none'"),
        (["ch99", "ch99", "--only", "chart"], "--only needs one chapter"),
    ],
)
def test_what_does_not_exist_takes_one_line(chapter, tmp_path, capsys, arguments, message):
    assert figures.main([*arguments, "--out", str(tmp_path)]) == 2
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("value", [np.nan, None, np.array([0, np.nan]), 1j])
def test_numbers_that_json_cannot_hold_are_refused(chapter, tmp_path, capsys, value):
    chapter["chart"] = lambda: (_chart()[0], {"peak": {"dof": value}})
    assert figures.main(["--out", str(tmp_path)]) == 2
    assert "ch99.chart.peak.dof must be a number" in capsys.readouterr().err
    assert not (tmp_path / "ch99.json").exists()


def test_a_missing_folder_is_named(chapter, tmp_path, capsys):
    assert figures.main(["--out", str(tmp_path / "none")]) == 2
    assert "must exist" in capsys.readouterr().err
