"""The figures of chapter 06: what they claim holds, and what is stored is what the page shows."""

import numpy as np
import pytest

from mcdenoise.rpf import RPFConfig, rpf_neighbourhood
from mcdenoise.study.figures import _ch06_adaptive as adaptive
from mcdenoise.study.figures import _ch06_data as data
from mcdenoise.study.figures import _ch06_limits as limits
from mcdenoise.study.figures import _ch06_neighbourhood as places
from mcdenoise.study.figures import _ch06_switches as switches
from mcdenoise.study.figures.__main__ import rounded
from mcdenoise.study.figures._ch04_data import samples
from mcdenoise.study.figures.ch06 import FIGURES
from stored_figures import (
    assert_quoted_numbers_exist,
    assert_same_numbers,
    assert_stored_shown_and_small,
    stored_numbers,
)

pytestmark = pytest.mark.ch06

STORED = stored_numbers("ch06")
CHEAP = ("choose", "panels_focus", "panels_blurred")


@pytest.mark.parametrize("name", CHEAP)
def test_stored_numbers_are_those_of_the_code(name):
    assert_same_numbers(rounded(FIGURES[name]()[1], name), STORED[name])


def test_every_figure_is_stored_shown_and_small():
    assert_stored_shown_and_small("ch06", FIGURES)


def test_the_page_quotes_numbers_that_exist():
    assert_quoted_numbers_exist("ch06", at_least=80)


@pytest.mark.parametrize("scene", ["dof", "glossy"])
def test_stored_errors_of_the_default_are_those_of_the_code(scene):
    """The one configuration that is quick enough for a test; it is the default of mcd.rpf."""
    found = data.error_of(scene, data.ADAPTIVE)
    assert found == pytest.approx(STORED["methods"][scene]["adaptive"], rel=2e-3)
    assert found == pytest.approx(STORED["presets"][scene]["adaptive"], rel=2e-3)


def test_the_table_of_the_page_is_the_presets():
    assert STORED["presets"]["tables"] == switches.preset_tables()
    assert RPFConfig.adaptive() == data.ADAPTIVE
    table = "\n".join(STORED["presets"]["tables"]).splitlines()
    (row,) = [line for line in table if line.startswith("| `alpha_start`")]
    cells = [cell.strip() for cell in row.split("|")[2:-1]]
    assert cells == [f"{config.alpha_start:g}" for config in data.PRESETS.values()]


def test_clustering_keeps_the_pixels_own_kind():
    focus, blurred = STORED["panels_focus"], STORED["panels_blurred"]
    for one in (focus, blurred):
        assert one["kept"] + one["left_out"] == one["drawn"]
        assert one["unseen_kept"] == 0  # what the pixel has not seen is left out
    assert blurred["kept"] > 2 * focus["kept"]
    assert blurred["unseen"] > 10
    own = places.chosen("out of focus", data.NO_SPIKES)["albedo"][:8]
    assert np.ptp(own, axis=0).max() < 0.01  # all eight of one paint


def test_effective_number_of_samples():
    assert places.effective(np.ones((2, 5))) == 5
    assert places.effective(np.array([[3.0, 0.0, 0.0]])) == 1
    of = STORED["slider_beta"]
    for place in ("edge_in_focus", "out_of_focus"):
        assert of[place] == sorted(of[place], reverse=True)
    assert of["edge_in_focus"][0] == of["out_of_focus"][0]  # no features, no radiance: the bell alone
    screen = STORED["screen_weights"]
    assert screen["out_of_focus"]["adaptive"] > 3 * screen["edge_in_focus"]["adaptive"]


def test_a_large_box_speaks_of_a_region():
    large, small = STORED["shares"]["box_55"], STORED["shares"]["box_7"]
    for region in ("focus", "front"):
        assert small[region]["all"] > 2 * large[region]["all"]
    assert small["front"]["lens"] > 2 * small["focus"]["lens"]


def test_alpha_and_beta_tell_focus_from_blur():
    of = STORED["alpha_beta"]
    assert of["focus"]["albedo"] > 4 * of["front"]["albedo"]
    assert of["focus"]["world"] > 4 * of["front"]["world"]
    assert of["dof_report"]["alpha_zero"] > 90


def test_the_four_corners():
    of = STORED["corners"]
    assert of["a0b0"] > 5 * of["noisy"]
    for corner in ("a1b0", "a1b1"):
        assert of[corner] == pytest.approx(of["noisy"], rel=0.05)
    assert of["rpf"] < 0.6 * min(of[corner] for corner in ("a0b0", "a1b0", "a0b1", "a1b1"))


def test_ablation():
    report, ours = STORED["ablation"]["report"], STORED["ablation"]["adaptive"]
    assert report["no_lens_parameters"] > 1.2 * report["RPF"]
    assert report["no_clustering"] < report["RPF"]
    assert ours["no_lens_parameters"] > 1.2 * ours["RPF"]
    assert ours["with_clustering"] > ours["RPF"]


def test_passes_end_where_the_report_ends():
    of = STORED["passes"]["errors"]
    for scene in data.SCENES:
        assert of[scene][4] == STORED["methods"][scene]["both_off"]
        assert of[scene][0] == STORED["methods"][scene]["noisy"]
    assert of["dof"][2] > 0.95 * of["dof"][0]
    assert of["glossy"] == sorted(of["glossy"], reverse=True)
    assert all(STORED["passes"]["only_17_and_7"][scene] < of[scene][4] for scene in data.SCENES)


def test_published_versions_beat_the_gaussian_on_one_scene_only():
    of = STORED["presets"]
    won = [scene for scene in data.SCENES if of[scene]["best_published"] < of[scene]["gaussian"]]
    assert won == ["glossy"]
    assert of["published_beat_gaussian"] == 1
    assert all(of[scene]["adaptive"] < of[scene]["gaussian"] for scene in data.SCENES)


def test_what_the_switches_say():
    of = STORED["switches"]
    for scene in data.SCENES:
        assert of["mean"][scene] > 1.05 * of["base"][scene]  # spike handling as published
        assert of["small_boxes"][scene] < 1.01 * of["base"][scene]
    assert of["clamp"]["glossy"] < of["base"]["glossy"] < of["open"]["glossy"]
    assert of["no_light"]["dof"] > of["base"]["dof"]
    assert of["no_light"]["glossy"] < of["base"]["glossy"]
    assert "pinhole" not in of["no_light"]  # it has no other random parameters
    assert of["alpha_1"]["glossy"] > of["base"]["glossy"]
    assert of["alpha_1"]["motion"] < of["base"]["motion"]
    best = {scene: min(of, key=lambda row: of[row].get(scene, np.inf)) for scene in data.SCENES}
    assert best == {
        "dof": "open",
        "motion": "open",
        "soft_shadow": "sigma_large",
        "glossy": "small_boxes",
        "pinhole": "sigma_small",
    }
    assert STORED["spikes"]["dof"]["mean"]["crop"] < -30  # percent: the discs of the lamps are gone


def test_draws_against_time():
    for scene in ("dof", "glossy"):
        of = STORED["fraction"][scene]
        assert of["errors"] == sorted(of["errors"], reverse=True)
        assert of["time"] == sorted(of["time"])
        assert of["default_time"] < 0.25
        assert of["default"] < of["errors"][3]  # the share that takes about as long
    report, ours = STORED["seeds"]["report"], STORED["seeds"]["adaptive"]
    assert report["every"] > max(report["errors"])
    assert ours["every"] < min(ours["errors"])
    assert report["share_every"] < 0.8 * report["share_drawn"]


def test_one_gain_serves_all_scenes():
    of = STORED["gain"]
    assert of["over_best"] < 25
    assert of["report_over_adaptive"] > 1
    for spp in data.SPPS:
        for scene in data.SCENES:
            assert of[f"spp_{spp}"][scene]["errors"][0] > 0.9 * of[f"spp_{spp}"][scene]["noisy"]


def test_copies_of_a_feature_count():
    of = STORED["columns"]["dof"]
    assert of["report"] == sorted(of["report"])
    assert of["adaptive"] == sorted(of["adaptive"], reverse=True)
    copied = limits.with_copies(samples("dof").crop(0, 0, 2, 2), 3)
    assert copied.features.shape[-1] == samples("dof").features.shape[-1] + 6


def test_a_pixel_that_missed_the_lamp_stays_dark():
    of = STORED["lamps"]
    assert of["with_clustering"]["ratio"][0] == pytest.approx(of["input"]["ratio"][0], rel=0.1)
    assert of["with_clustering"]["ratio"][0] < 0.5 * of["without"]["ratio"][0] < 0.5 * of["adaptive"]["ratio"][0]
    assert of["with_clustering"]["all"] < of["without"]["all"] < of["adaptive"]["all"] < of["input"]["all"]
    assert max(of["without"]["mixing"][:3]) < 1e-6
    assert min(of["adaptive"]["mixing"]) > 0.8
    inside, count = limits.discs(), limits.lamp_samples()
    assert 100 * (inside & (count == 0)).sum() / inside.sum() == pytest.approx(of["none"], rel=1e-3)


def test_lamps_are_left_out_by_a_pixel_without_one():
    """One pixel of those that the figure counts."""
    y, x = next(iter(np.argwhere(limits.discs() & (limits.lamp_samples() == 0))))
    found = rpf_neighbourhood(samples("dof"), (int(y), int(x)), data.NO_SPIKES, 3)
    on = found.radiance.max(axis=-1) > limits.BRIGHT
    assert on.sum() > 0
    assert not found.accepted[on].any()


def test_edges_within_pixels_hold_the_error():
    of = STORED["errors"]["edges"]
    assert of["pixels"] < 20 < 60 < of["adaptive"]
    assert of["adaptive"] > of["input"]
    assert of["adaptive_elsewhere"] < 0.6 * of["input_elsewhere"]
    assert of["adaptive_at_edges"] > 0.8 * of["input_at_edges"]
    assert adaptive.RIVALS.keys() <= STORED["methods"]["dof"].keys()


def test_ours_against_the_filters_before():
    of = STORED["methods"]
    for scene in data.SCENES:
        assert of[scene]["adaptive"] < of[scene]["gaussian"]
        assert of[scene]["joint_nlm"] == min(of[scene].values())
    assert set(of["won"]) | set(of["lost"]) == set(data.SCENES)
    assert all(of[scene]["adaptive"] < of[scene]["cross_bilateral"] for scene in of["won"])
    assert all(of[scene]["adaptive"] >= of[scene]["cross_bilateral"] for scene in of["lost"])


def test_share_and_variance_together():
    of = STORED["idea"]["albedo"]
    assert of["front"]["kept"] > 3 * of["focus"]["kept"]
    assert of["focus"]["deviation"] > of["front"]["deviation"]  # variance alone would blur the ball in focus
