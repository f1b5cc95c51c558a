"""The study of parsimony, its quick run, and the command that runs studies."""

import copy
import re

import pytest

from mcdenoise.cli import STUDIES as NAMES
from mcdenoise.cli import main
from mcdenoise.study import parsimony
from mcdenoise.study.advise import ASKS
from mcdenoise.study.methods import METHODS
from mcdenoise.study.parsimony import Settings, charts, lines, study
from mcdenoise.study.studies import STUDIES, settings_of, study_module

pytestmark = pytest.mark.ch10


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("study")


@pytest.fixture(scope="module")
def found(folder):
    return study(Settings.quick(), folder / "parsimony.json", progress=False)


def test_every_pair_of_scene_and_spp_is_an_entry():
    settings = Settings(scenes=("dof", "motion"), spp=(4, 8))
    assert list(parsimony.entries(settings)) == ["dof, 4 spp", "dof, 8 spp", "motion, 4 spp", "motion, 8 spp"]


def test_light_is_kept_and_a_lens_that_is_not_there_is_not(found):
    for entry in found["entries"].values():
        assert entry["advice"]["layout"]["random_params"] == ["light_u", "light_v"]
        assert set(entry["decoys"]) == {"lens_u", "lens_v", "time"}
        assert min(decoy["p_value"] for decoy in entry["decoys"].values()) >= 0.05


def test_every_method_has_an_error_both_ways(found):
    for entry in found["entries"].values():
        for source in (entry["advice"], entry["reference"]):
            assert [one["name"] for one in source["methods"]] == list(ASKS)
            assert min(one["behind"] for one in source["methods"]) == 0
            assert source["method"] in ASKS
        assert entry["agree"] == (entry["advice"]["method"] == entry["reference"]["method"])
        assert min(entry["relmse"].values()) < entry["unfiltered"]


def test_the_reference_tries_bandwidths_that_halves_may_miss(found):
    for entry in found["entries"].values():
        for one in entry["reference"]["methods"]:
            assert one["error"] <= entry["relmse"][one["name"]] * (1 + 1e-5)


def test_a_layout_is_judged_by_other_seeds(found):
    for entry in found["entries"].values():
        between = entry["between_seeds"]
        assert between["all"]["behind"] == between["all"]["standard_error"] == 0
        kept = between["kept"]
        assert kept["behind"] <= max(3 * kept["standard_error"], 0.2 * between["all"]["error"])
        assert len(entry["other_seeds"]) == 1


def test_the_tables_count_and_list(found):
    changed = copy.deepcopy(found)
    for entry, advised in zip(changed["entries"].values(), ("gaussian", "nlm"), strict=True):
        entry["advice"]["method"], entry["reference"]["method"] = advised, "nlm"
        entry["agree"] = advised == "nlm"
    text = "\n".join(lines(changed))
    assert "the same in 1 of 2 cases" in text
    assert re.search(r"pinhole +8 spp +Gaussian +\S+ +NL-means", text)
    assert re.search(r"soft_shadow +8 spp +NL-means +\S+ +the same", text)
    assert "decoys taken for information: 0 of 6" in text


def test_charts_are_made_from_the_numbers(found):
    drawn = charts(found)
    assert list(drawn) == ["information", "dropping", "simplest", "boxes"]
    simplest = drawn["simplest"].axes
    assert [axes.get_title() for axes in simplest] == ["pinhole", "soft_shadow"]
    assert [label.get_text() for label in simplest[0].get_yticklabels()][::-1] == [METHODS[name].label for name in ASKS]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"scenes": ("attic",)}, "scenes has no 'attic'"),
        ({"spp": (1,)}, "each spp must be at least 2, got 1."),
        ({"seeds": (1,)}, "seeds must be two or more, to compare layouts between them, got 1."),
        ({"size": 8}, "size must be at least 16, got 8."),
    ],
)
def test_settings_are_checked(changes, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        Settings(**changes)


def test_the_command_goes_on_and_writes_a_page(found, folder, capsys, monkeypatch):
    """Everything is there already: nothing is measured again, tables and page are made from it."""
    monkeypatch.setattr(parsimony, "advise", None)
    assert main(["study", "parsimony", "--quick", "--out", str(folder)]) == 0
    output = capsys.readouterr().out
    assert "No more than a scene needs: 32 x 32 pixels" in output
    assert "decoys taken for information: 0 of 6" in output
    page = (folder / "report.html").read_text()
    assert page.count("data:image/png;base64,") == 4 == len(list((folder / "parsimony").glob("*.png")))
    assert "decoys taken for information" in page
    assert "http" not in page


def test_a_folder_with_another_study_is_refused(found, folder, capsys):
    assert main(["study", "parsimony", "--quick", "--size", "48", "--out", str(folder)]) == 2
    error = capsys.readouterr().err
    assert "holds a study with another size. Use the same options, or another --out." in error
    assert error.count("\n") == 1


def test_the_size_is_checked(capsys, tmp_path):
    assert main(["study", "all", "--quick", "--size", "8", "--out", str(tmp_path)]) == 2
    assert "size must be at least 32, got 8." in capsys.readouterr().err


def test_the_command_line_knows_the_studies():
    assert (*STUDIES, "all") == NAMES


@pytest.mark.parametrize("name", STUDIES)
def test_every_study_has_the_same_shape(name):
    module = study_module(name)
    for quick in (True, False):
        settings = settings_of(module, quick, 64)
        assert 64 in (settings.size, getattr(settings, "picture", None))
        assert all(callable(run) for run in module.entries(settings).values())
    assert name == module.NAME
