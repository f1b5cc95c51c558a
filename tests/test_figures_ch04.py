"""The figures of chapter 04: what they claim holds, and what is stored is what the page shows."""

import numpy as np
import pytest

from mcdenoise.filters import bilateral
from mcdenoise.study.figures import _ch04_data as data
from mcdenoise.study.figures import _ch04_features as features
from mcdenoise.study.figures import _ch04_noise as noise
from mcdenoise.study.figures import _ch04_patches as patches
from mcdenoise.study.figures.__main__ import rounded
from mcdenoise.study.figures.ch04 import FIGURES
from stored_figures import (
    assert_quoted_numbers_exist,
    assert_same_numbers,
    assert_stored_shown_and_small,
    stored_numbers,
)

pytestmark = pytest.mark.ch04

STORED = stored_numbers("ch04")
CHEAP = ("features", "more_features", "window_weights", "feature_noise", "expected_difference")


@pytest.mark.parametrize("name", CHEAP)
def test_stored_numbers_are_those_of_the_code(name):
    assert_same_numbers(rounded(FIGURES[name]()[1], name), STORED[name])


def test_every_figure_is_stored_shown_and_small():
    assert_stored_shown_and_small("ch04", FIGURES)


def test_the_page_quotes_numbers_that_exist():
    assert_quoted_numbers_exist("ch04", at_least=60)


def test_the_one_filter_is_the_same_on_all_scenes_and_has_the_stored_errors():
    for scene in ("pinhole", "dof"):
        error = data.error(features.filtered(scene), scene)
        assert error == pytest.approx(STORED["five_errors"]["whole"][scene]["cross_bilateral"], rel=2e-3)


def test_noisy_features_fail_and_clean_ones_do_not():
    whole, part = (STORED["five_errors"][kind] for kind in ("whole", "part"))
    for scene in ("dof", "motion"):
        assert whole[scene]["cross_bilateral"] > 1.3 * whole[scene]["gaussian"]
        assert part[scene]["cross_bilateral"] > 1.8 * part[scene]["gaussian"]
    assert part["pinhole"]["cross_bilateral"] < 0.55 * part["pinhole"]["noisy"]
    assert whole["glossy"]["cross_bilateral"] < whole["glossy"]["gaussian"]
    assert part["glossy"]["cross_bilateral"] > 0.9 * part["glossy"]["gaussian"]
    assert STORED["five_errors"]["elsewhere"]["soft_shadow"]["cross_bilateral"] > 0.004
    assert STORED["five_errors"]["features_alone"]["soft_shadow"] > 1.1 * whole["soft_shadow"]["gaussian"]


def test_dials_of_its_own_beat_the_gaussian_by_blinding_the_features():
    of = STORED["five_errors"]
    for scene in data.SCENES:
        assert of["tuned"][scene] < min(of["whole"][scene]["cross_bilateral"], of["whole"][scene]["gaussian"])
    assert of["share"]["dof"] > 0.9
    assert of["share"]["soft_shadow"] > 2


def test_no_share_is_right_with_and_without_the_lens():
    dial = STORED["slider_share"]
    assert dial["dof_best"] >= 5 * dial["pinhole_best"]
    at = dial["share"].index(dial["dof_best"])
    assert at == 5  # as the page quotes it
    assert dial["pinhole"][at] > STORED["five_errors"]["whole"]["pinhole"]["noisy"]


def test_features_out_of_focus_are_noisy():
    with_lens, without = (data.feature_noise(scene) > 1 for scene in ("dof", "pinhole"))
    assert with_lens.mean() > 2.5 * without.mean()
    ratio = STORED["focus"]["dof"]["ratio"]
    assert max(ratio[:2]) < 0.5
    assert max(ratio) == ratio[5] > 3
    assert min(ratio[2:]) > 1
    assert max(STORED["focus"]["pinhole"]["ratio"]) < 1


def test_circle_of_confusion_is_zero_in_the_plane_of_focus():
    blur = noise.circle_of_confusion()
    assert blur.min() < 0.05
    assert blur[:30].min() > 8  # the wall


def test_both_limits_of_variances():
    distance = noise.distances_to_limits(np.array([1e-5, 1e-4, 1e5, 1e6]), np.array([1e-4, 2e-4, 1.0]))
    assert distance["plain"][1] / distance["plain"][0] == pytest.approx(10, rel=0.01)
    assert distance["bilateral"][2] / distance["bilateral"][3] == pytest.approx(10, rel=0.05)
    assert distance["standard_deviations"][1] / distance["standard_deviations"][0] == pytest.approx(4, rel=0.05)
    assert STORED["variance_limits"]["slope_sigma"] == pytest.approx(2, abs=0.05)


def test_prefiltered_features_are_better_and_gain():
    for feature in STORED["prefilter"].values():
        assert feature["noisy"]["after"] < 0.7 * feature["noisy"]["before"]
        assert feature["clean"]["after"] < feature["clean"]["before"]
    for scene in data.SCENES:
        gain = STORED["gains"][scene]
        assert gain["both"] < 0.95 * gain["raw"]
        assert gain["both"] < gain["gaussian"]
        assert gain["prefiltered"] < min(gain["raw"], gain["raw_variances"])
        assert gain["raw_variances"] > 0.94 * gain["raw"]
    assert STORED["gains"]["motion"]["fixed_variances"] < 0.8 * STORED["gains"]["motion"]["fixed_raw"]
    assert STORED["gains"]["dof"]["fixed_variances"] < 0.9 * STORED["gains"]["dof"]["fixed_raw"]


def test_more_witnesses_help_only_without_their_noise():
    for of in STORED["groups"].values():
        assert of["raw_all"] > 0.97 * of["raw_first_hit"]
        assert of["prefiltered_all"] < 0.97 * of["prefiltered_first_hit"]
    assert (
        STORED["groups"]["soft_shadow"]["prefiltered_all"]
        < 0.7 * STORED["groups"]["soft_shadow"]["prefiltered_first_hit"]
    )


def test_albedo_helps_where_it_is_clean_and_harms_where_it_is_noisy():
    of = STORED["demodulation"]
    for scene in ("pinhole", "dof", "motion", "glossy"):
        assert of[scene]["prefiltered_albedo"] < 0.97 * of[scene]["no_albedo"]
    assert of["soft_shadow"]["prefiltered_albedo"] == pytest.approx(of["soft_shadow"]["no_albedo"], rel=0.02)
    assert all(of[scene]["raw_albedo"] > of[scene]["no_albedo"] for scene in of)
    assert max(of, key=lambda scene: of[scene]["raw_albedo"] - of[scene]["no_albedo"]) == "dof"


def test_two_normal_views_differ_by_one():
    ratio = patches.normal_views(seed=1, size=128)
    assert ratio.mean() == pytest.approx(1, abs=4 * np.sqrt(2 / ratio.size))
    taken_off = STORED["expected_difference"]["normal"]
    assert taken_off["weight_with"] > 10 * taken_off["weight_without"]


@pytest.mark.parametrize("name", patches.PIXELS)
def test_patches_find_better_friends_but_not_in_the_bokeh(name):
    of = STORED["pixel_patch"][name.replace(" ", "_")]
    better = of["by_patch"]["truth_differs"] < 0.8 * of["by_pixel"]["truth_differs"]
    assert better == (name != "bokeh")
    weights = patches.weights_of(*patches.PIXELS[name], 3)
    assert weights[patches.REACH, patches.REACH] == 1
    assert weights.sum() == pytest.approx(of["by_patch"]["norm"], rel=2e-3)


def test_nl_means_needs_the_variance_of_each_pixel():
    of = STORED["variances_matter"]
    assert sorted(scene for scene in of if of[scene]["constant"] > of[scene]["gaussian"]) == ["dof", "glossy", "motion"]
    assert all(of[scene]["variances"] < 0.9 * min(of[scene]["gaussian"], of[scene]["constant"]) for scene in of)


def test_fireflies_after_the_bilateral_and_after_nl_means():
    where, excess = patches.brightest("glossy")
    kept = bilateral(data.noisy("glossy"), sigma_space=1.4, sigma_radiance=0.3)
    left = ((kept - data.reference("glossy")).mean(axis=-1)[where] / excess).mean()
    assert left == pytest.approx(STORED["firefly"]["bilateral"]["left"], rel=2e-3)
    assert STORED["firefly"]["nlm"]["left"] < 0.25 < 0.8 < left
    assert STORED["firefly"]["symmetric"]["left"] == pytest.approx(STORED["firefly"]["nlm"]["left"], abs=0.03)
    assert STORED["firefly"]["symmetric"]["relmse"] > 1.1 * STORED["firefly"]["nlm"]["relmse"]


def test_k_is_nearly_the_same_on_both_scenes_and_single_pixels_fail():
    of = STORED["k_patch"]
    assert max(of["dof"]["k"], of["soft_shadow"]["k"]) <= 1.5 * min(of["dof"]["k"], of["soft_shadow"]["k"])
    assert of["dof"]["radius_0"] > STORED["variances_matter"]["dof"]["gaussian"]
    assert of["dof"]["relmse"] < 0.3 * of["dof"]["radius_0"]


def test_near_matters_after_all():
    of = STORED["search"]
    assert of["radii"][2] == of["dof"]["best"] and of["radii"][6] == 10  # noqa: PT018 (as the page quotes them)
    assert of["dof"]["errors"][6] > 1.4 * min(of["dof"]["errors"])
    assert max(of[scene]["best"] for scene in ("motion", "glossy", "soft_shadow")) <= 5
    assert np.ptp(of["pinhole"]["errors"]) < 0.1 * min(of["pinhole"]["errors"])


def test_joint_nl_means_is_best_on_all_scenes():
    for scene in data.SCENES:
        errors = {name: STORED["methods"][scene][name]["halves"] for name in data.COLOURS}
        assert min(errors, key=errors.get) == "joint_nlm"
        assert errors["joint_nlm"] == STORED["methods"][scene]["best"] < 0.6 * STORED["methods"][scene]["noisy"]
    assert STORED["methods"]["pinhole"]["gaussian"]["halves"] > STORED["methods"]["pinhole"]["noisy"]


def test_the_lens_leaves_a_question():
    of = STORED["left_over"]
    assert of["over_pinhole"] > 1.2
    assert of["joint_nlm"]["lamps"] > of["joint_nlm"]["blurred"] > of["joint_nlm"]["sharp"]
