"""The figures of chapter 09: what they claim holds, and what is stored is what the page shows."""

import re

import numpy as np
import pytest

from mcdenoise.lbf import shipped_model
from mcdenoise.lbf.pixel import filter_pixel
from mcdenoise.study.figures import _ch09_data as data
from mcdenoise.study.figures import _ch09_filter as dials
from mcdenoise.study.figures import _ch09_gradient as checks
from mcdenoise.study.figures import _ch09_limits as limits
from mcdenoise.study.figures import _ch09_pixel as pixel
from mcdenoise.study.figures.__main__ import rounded
from mcdenoise.study.figures.ch09 import FIGURES
from stored_figures import (
    assert_quoted_numbers_exist,
    assert_same_numbers,
    assert_stored_shown_and_small,
    page_of,
    stored_numbers,
)

pytestmark = pytest.mark.ch09

STORED = stored_numbers("ch09")
CHEAP = ("chain", "weights_of_one_pixel", "covariance", "terms")


@pytest.mark.parametrize("name", CHEAP)
def test_stored_numbers_are_those_of_the_code(name):
    assert_same_numbers(rounded(FIGURES[name]()[1], name), STORED[name])


def test_every_figure_is_stored_shown_and_small():
    assert_stored_shown_and_small("ch09", FIGURES)


def test_the_page_quotes_numbers_that_exist():
    assert_quoted_numbers_exist("ch09", at_least=80)


def test_nothing_of_the_page_is_lost():
    """In a table a bar ends the cell, also within a quoted number; a line that begins with a percent sign is a comment."""
    assert not [line for line in page_of("ch09").splitlines() if line.lstrip().startswith("%")]
    rows = [line for line in page_of("ch09").splitlines() if line.startswith("|")]
    assert len(rows) > 40
    for quoted in re.findall(r"\{\{.*?\}\}", "\n".join(rows)):
        assert "|" not in quoted


@pytest.mark.parametrize("place", data.PLACES.values())
def test_one_pixel_by_hand_is_the_filter(place):
    """The neighbours that figures show, filtered by the exercise's function, give the pixel of `mcd.lbf`."""
    (y, x), layer = place, data.layer_of("dof", rows=[place[0]])
    distances, colours, _ = data.neighbours(layer, y, x)
    theta = np.array([data.analysis("dof").theta[name][y, x] for name in layer.names], np.float64)
    value, weights = filter_pixel(theta, distances.reshape(len(theta), -1), colours.reshape(-1, 3))
    np.testing.assert_allclose(value, data.filtered("dof")[y, x], rtol=1e-4)
    assert 1 <= data.effective(weights) <= weights.size


def test_terms_are_the_layers_backward_pass():
    chain, (y, x) = pixel.chain_at(), data.PLACES["out of focus"]
    found, layer = pixel.terms_of(chain), data.layer_of("dof", rows=[y])
    theta = np.stack([data.analysis("dof").theta[name][y : y + 1] for name in layer.names], axis=-1)
    d_filtered = np.zeros((1, 128, 3))
    d_filtered[0, x] = found.d_filtered
    d_theta = layer.backward(d_filtered, layer.forward(theta)[1])[0, x]
    np.testing.assert_allclose(found.d_theta, d_theta, rtol=1e-3, atol=1e-5 * np.abs(d_theta).max())
    np.testing.assert_allclose(
        found.d_z, d_theta * -np.expm1(-chain.theta), rtol=1e-3, atol=1e-5 * np.abs(d_theta).max()
    )


def test_the_gradient_of_the_filter_is_minus_a_covariance():
    of = STORED["covariance"]
    for name in ("position", "albedo"):
        assert of[name]["gradient"] == -of[name]["covariance"] != 0


def test_every_factor_passes_its_check():
    of = STORED["gradient_check"]
    assert max(of["check_gradient"].values()) < 1e-5
    for name in ("error_by_filtered", "filtered_by_theta", "theta_by_z", "error_by_weight"):
        assert of[name]["best"] < 1e-6, name
    assert of["memory"]["weights"] == pytest.approx(4 * 256**2 * 55**2 / 1e6, rel=1e-3)
    assert of["memory"]["saved"] < 0.01 * of["memory"]["weights"]


def test_a_wrong_factor_would_fail():
    """The curve of a gradient that lacks its sign does not go down."""
    x = np.array([0.3, 0.7])
    assert checks.errors_over_step(np.sin, x, np.diag(np.cos(x))).min() < 1e-9
    assert checks.errors_over_step(np.sin, x, np.diag(-np.cos(x))).min() > 1.9


def test_one_bandwidth_does_not_fit_all():
    of = STORED["slider_gamma"]
    assert sum(of["shares"]) == pytest.approx(100, abs=0.1)
    assert min(of["shares"]) > 1
    assert 2 * of["each_its_best"] < min(of["errors"])
    assert of["blurred_best"] != of["sharp_best"]


def test_the_oracle_is_a_bound_for_its_own_noise():
    of = STORED["oracle"]
    assert of["errors"] == sorted(of["errors"], reverse=True)
    assert of["oracle"] < min(of["model"], of["shared"]) < of["noisy"]
    assert of["oracle"] < of["other_noise"]["together"] < of["other_noise"]["oracle"]
    assert of["other_noise"]["model"] < of["other_noise"]["shared"]
    assert of["way"] == pytest.approx(data.way(of["noisy"], of["model"], of["oracle"]), abs=0.2)
    assert of["last_step"] < 1.05


def test_prefiltering_takes_noise_away_where_it_is():
    of = STORED["prefilter"]
    for group in ("world_position", "shading_normal", "albedo"):
        assert of[group]["features"]["blurred"] < 0.35 * of[group]["raw"]["blurred"]
        assert of[group]["features"]["sharp"] <= 1.001 * of[group]["raw"]["sharp"]
    assert of["prefiltered"] < 0.7 * of["raw"]


def test_the_inputs_are_the_36():
    of = STORED["secondary"]
    assert (of["count"], of["rate"], of["groups"], of["dof_inputs"], of["with_colour"]) == (36, 30, 5, 22, 43)
    network = "-".join(map(str, data.widths_of(shipped_model())))
    assert STORED["training_scenes"]["cards"]["cross_bilateral"]["network"] == network == STORED["chain"]["network"]


def test_learning_one_scene():
    of = STORED["slider_learning"]
    assert of["losses"][-1] < 0.5 * of["losses"][0]
    assert of["errors"][-1] < of["errors"][0] < of["noisy"]
    assert of["parameters"] == (7 * 4 + 1) * 10 + 10 + 10 * 5 + 5


@pytest.mark.parametrize("spp", data.SPPS)
def test_methods_are_between_the_noise_and_the_oracle(spp):
    of = STORED["methods"][f"spp_{spp}"]
    for scene in data.SCENES:
        errors = of["errors"][scene]
        assert errors["oracle"] == min(errors.values())
        assert errors["noisy"] == max(errors.values())
        assert of["whole"][scene]["rpf"] == stored_numbers("ch06")["gain"][f"spp_{spp}"][scene]["adaptive"]
        for name, ways in of["way"].items():
            assert ways[scene] == pytest.approx(data.way(errors["noisy"], errors[name], errors["oracle"]), abs=0.1)
    for variant in data.VARIANTS:
        assert of["mean_way"][variant] > of["mean_way"]["shared"] > of["mean_way"]["rpf"]
        assert of["whole_mean"][variant] < of["whole_mean"]["rpf"]
    for name, mean in of["mean"].items():
        assert mean == pytest.approx(data.geometric_mean([of["errors"][s][name] for s in data.SCENES]), rel=1e-3)


def test_images_and_chart_tell_the_same_errors():
    whole = STORED["methods"]["spp_4"]["whole"]
    for scene in data.SCENES:
        assert STORED["results"][scene] == {name: whole[scene][name] for name in ("noisy", *data.VARIANTS)}


def test_more_samples_make_less_error():
    of = STORED["slider_spp"]
    assert of["filtered"][2:] == sorted(of["filtered"][2:], reverse=True)
    assert of["filtered"][1] > of["filtered"][0]  # with 2 samples noise passes for none
    assert of["missed"][1] > 4 * of["missed"][2] >= 0 == of["missed"][-1]
    assert all(after < before for before, after in zip(of["noisy"], of["filtered"], strict=True))


def test_fireflies_stay_without_despiking():
    of = STORED["despike"]
    assert of["flies"] == limits.with_fireflies()[1].sum()
    assert of["left"]["lbf"] > 10 * abs(of["left"]["despiked"])
    assert of["soft_shadow"]["despiked"] < 0.3 * of["soft_shadow"]["lbf"]  # two side by side hide each other


def test_limits():
    of = STORED["limits"]
    assert of["no_noise"]["after"] < 1e-5
    assert of["left_half_black"]["largest_in_black"] < 1e-6
    assert of["1_spp"]["after"] < 0.5 * of["1_spp"]["before"]


def test_weights_of_a_bell_are_known():
    """Position alone: (sum w)^2 / sum w^2 of a bell of alpha pixels is 4 pi alpha^2."""
    assert STORED["weights_of_one_pixel"]["out_of_focus"]["position"]["pixels"] == pytest.approx(
        4 * np.pi * 4**2, rel=0.01
    )
    assert dials.pixel_error(np.zeros(3), np.ones(3)) == pytest.approx(1 / 1.01)
