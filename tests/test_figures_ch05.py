"""The figures of chapter 05: what they claim holds, and what is stored is what the page shows."""

import numpy as np
import pytest

from mcdenoise.rpf import dependency_of, mutual_information
from mcdenoise.study.figures import _ch05_bias as bias
from mcdenoise.study.figures import _ch05_data as data
from mcdenoise.study.figures import _ch05_information as information
from mcdenoise.study.figures import _ch05_limits as limits
from mcdenoise.study.figures import _ch05_maps as maps
from mcdenoise.study.figures import _ch05_neighbourhood as places
from mcdenoise.study.figures.__main__ import rounded
from mcdenoise.study.figures.ch05 import FIGURES
from stored_figures import (
    assert_quoted_numbers_exist,
    assert_same_numbers,
    assert_stored_shown_and_small,
    stored_numbers,
)

pytestmark = pytest.mark.ch05

STORED = stored_numbers("ch05")
CHEAP = (
    "panels_focus", "panels_blurred", "bins", "worked", "correlation", "joint", "widths", "pairs",
    "matrix_focus", "matrix_blurred", "fails",
)  # fmt: skip


@pytest.mark.parametrize("name", CHEAP)
def test_stored_numbers_are_those_of_the_code(name):
    assert_same_numbers(rounded(FIGURES[name]()[1], name), STORED[name])


def test_every_figure_is_stored_shown_and_small():
    assert_stored_shown_and_small("ch05", FIGURES)


def test_the_page_quotes_numbers_that_exist():
    assert_quoted_numbers_exist("ch05", at_least=80)


def test_the_example_by_hand():
    expected = 0.75 * np.log(1.5) - 0.25 * np.log(2)
    assert STORED["worked"]["nats"] == pytest.approx(expected, rel=1e-3)
    assert STORED["worked"]["by_code"] == STORED["worked"]["nats"]
    x, y = information.EXAMPLE
    assert np.sum(x == y) == 6 == 0.75 * len(x)
    assert mutual_information(x, y, base=2) == pytest.approx(STORED["worked"]["bits"], rel=1e-3)


def test_correlation_misses_what_information_sees():
    of = STORED["correlation"]
    for name in ("parabola", "circle", "spread"):
        assert of[name]["correlation"] < 0.06
        assert of[name]["information"] > 5 * of["nothing"]["information"]
    assert of["nothing"]["information"] < 2 * of["nothing"]["chance"]
    assert of["line"]["information"] == max(one["information"] for one in of.values())


def test_equal_variance_unequal_shares():
    focus, blurred = (STORED["variance_twins"][name] for name in ("in_focus", "out_of_focus"))
    assert focus["variance"] == pytest.approx(blurred["variance"], rel=0.01)
    assert blurred["share"] > 8 * focus["share"]
    assert abs(STORED["variance_twins"]["correlation"]) < 0.05
    assert places.pixel_variance()[places.TWINS["in focus"]] == pytest.approx(focus["variance"], rel=1e-3)
    found = dependency_of(data.neighbourhood("dof", *places.TWINS["out of focus"]))
    assert found.share_f_r[6:9].mean() == pytest.approx(blurred["share"], rel=1e-3)


def test_the_lens_explains_world_positions_out_of_focus_only():
    focus, blurred = STORED["joint"]["in_focus"], STORED["joint"]["out_of_focus"]
    assert focus["lens_u"] < 2 * focus["chance"]
    assert focus["screen_position"] > 50 * focus["lens_u"]
    assert blurred["lens_u"] > blurred["screen_position"] > 20 * blurred["chance"]
    path = STORED["slider_place"]["world_x"]
    assert max(path[:5]) < 0.07
    assert path[5] < path[6] < path[7] < path[8]


def test_the_matrix_says_what_the_page_says():
    focus, blurred = STORED["matrix_focus"], STORED["matrix_blurred"]
    assert max(focus["share_f_r"]) < 0.1 < 0.5 < min(blurred["share_f_r"])
    red, green, blue = focus["share_c_r"]
    assert blue > 1.9 * max(red, green)
    box = data.neighbourhood("dof", *data.PLACES["in focus"])
    paints = np.unique(box["albedo"].reshape(-1, 3), axis=0)
    assert len(paints) == 2
    assert np.ptp(paints, axis=0)[2] < 0.1 * np.ptp(paints, axis=0)[0]
    for k in range(3):  # normals repeat positions on a ball
        assert focus["share_f_r"][k] == focus["share_f_r"][k + 3]


@pytest.mark.parametrize("count", [256, 1024])
def test_chance_level_of_independent_variables(count):
    found = bias.independent(count, trials=100, seed=1)
    error = found.std() / np.sqrt(len(found))
    first, second = 16 / (2 * count), ((625 - 1) - 2 * (25 - 1)) / (12 * count**2)
    assert abs(found.mean() - first - second) < 4 * error
    assert STORED["bias"]["ratio"][0] > 1.15  # the page: the next term counts at 32 samples
    assert STORED["bias"]["ratio"][3] == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize("n_r", [2, 3, 4])
def test_share_of_nothing_is_the_share_of_variables(n_r):
    shares = bias.shares_of_nothing(256, n_r, trials=60, seed=2)
    error = shares.mean(axis=1).std() / np.sqrt(len(shares))
    assert abs(shares.mean() - n_r / (n_r + 2)) < 4 * error
    assert STORED["bias"][f"share_{n_r}"] == pytest.approx(n_r / (n_r + 2), abs=0.01)


def test_narrow_bins_find_chance_and_wide_bins_nothing():
    for pair in ("lens_u_world_x", "light_v_red"):
        of = STORED["widths"][pair]
        part = np.array(of["chance"]) / of["found"]
        assert part[0] > 0.8
        assert part[STORED["widths"]["widths"].index(1)] < 0.1
        assert of["found"][-1] < 0.25 * of["found"][STORED["widths"]["widths"].index(1)]


def test_sums_of_pairs_miss_xor_and_count_copies_twice():
    of = STORED["pairs"]
    assert of["xor"]["pairs"] == 0
    assert of["xor"]["joint"] == pytest.approx(np.log(2), rel=1e-3)
    assert of["copy"]["pairs"] == pytest.approx(2 * of["copy"]["joint"], rel=1e-3)
    assert of["world_x"]["pairs"] == pytest.approx(of["world_x"]["joint"], rel=0.1)
    assert of["red"]["joint_chance"] > 10 * of["red"]["pairs_chance"]
    assert of["red"]["joint_chance"] > 0.5 * of["red"]["joint"]


def test_maps_tell_focus_motion_and_shadow():
    lens, each, feature = (STORED[name] for name in ("lens_and_light", "shares_radiance", "shares_features"))
    assert lens["front"]["lens"] > 5 * lens["focus"]["lens"]
    assert lens["rim"]["lens"] > 1.5 * lens["lamp"]["lens"]
    assert lens["wall"]["light"] > 0.8
    assert each["fast"]["time"] > 8 * each["slow"]["time"]
    assert each["lit"]["all"] > 2 * each["penumbra"]["all"]
    assert feature["front"]["world_position"] > 10 * feature["focus"]["world_position"]
    assert feature["fast"]["world_position"] > 5 * feature["slow"]["world_position"]
    assert all(one["median"] < 0.03 for one in feature["pinhole"].values())
    of = STORED["shares_of_features"]["penumbra"]
    assert max(of, key=of.get) == "visibility"
    assert STORED["shares_of_features"]["motion"]["albedo"]["mean"] > 0.5


def test_stored_maps_are_those_of_the_code():
    """One region, box by box, without the whole map."""
    _, rows, columns = maps.REGIONS["focus"]
    centres = [(2 * y + 1, 2 * x + 1) for y in range(rows.start, rows.stop) for x in range(columns.start, columns.stop)]
    found = [dependency_of(data.samples("dof").crop(*data.window(y, x))) for y, x in centres]
    lens = np.mean([one.share_c_r_each[:, :2].sum(axis=1).mean() for one in found])
    world = np.mean([one.share_f_r[:3].mean() for one in found])
    assert lens == pytest.approx(STORED["lens_and_light"]["focus"]["lens"], rel=1e-3)
    assert world == pytest.approx(STORED["shares_features"]["focus"]["world_position"], rel=1e-3)


def test_second_hits_are_random_first_hits_are_not():
    first, second = (STORED["second_hits"][name] for name in ("world_position", "world_position_2"))
    assert first["median"] < 0.05 < 0.85 < second["median"]
    assert 0.2 < second["metal"] < 0.6 < 0.95 < second["walls"]


def test_box_size_trades_chance_for_place():
    of = STORED["slider_box"]
    assert of["focus"][0] > 8 * of["focus"][3]
    assert of["front"][0] > of["front"][3] > of["front"][6]
    assert of["sides"][3] == data.BOX


def test_few_samples_drift_towards_chance():
    of = STORED["spp"]
    assert of["plain"] == sorted(of["plain"], reverse=True)
    assert max(of["plain"]) < 4 / 6
    assert np.ptp(of["corrected"]) < 0.4 * np.ptp(of["plain"])
    assert all(corrected < plain for corrected, plain in zip(of["corrected"], of["plain"], strict=True))


def test_a_share_is_no_amount():
    quiet, loud = STORED["amount"]["quiet"], STORED["amount"]["loud"]
    assert quiet["share"] > 3 * loud["share"]
    assert loud["deviation"] > 5 * quiet["deviation"]


def test_one_bright_sample_hides_the_light():
    bright = limits.one_bright_sample()
    assert bright["with"]["samples"] == bright["without"]["samples"] + 1
    assert bright["without"]["light"] > 20 * bright["with"]["light"]
    assert bright["with"]["deviation"] > 15 * bright["without"]["deviation"]


def test_rounding_would_be_taken_for_a_variable():
    wall = STORED["fails"]["wall"]
    assert wall["deviations"][1] < 1e-5 * wall["deviations"][0]
    assert wall["rounding_counted"][1] == pytest.approx(0.5, abs=0.1)
    assert wall["shares"][1] == 0
    for k in (0, 2):
        assert wall["shares"][k] == pytest.approx(wall["rounding_counted"][k], rel=1e-2)


def test_a_wide_box_drowns_a_narrow_penumbra():
    penumbra = STORED["fails"]["penumbra"]
    assert penumbra["sides"][1] == 5
    assert penumbra["sides"][3] == 11
    for name in ("narrow", "wide"):
        assert penumbra[name][3] < 0.7 * penumbra[name][1]


def test_the_compiled_loop_is_fastest_and_all_find_the_same():
    levels = limits.levels_of(data.neighbourhood("dof", *data.PLACES["out of focus"]).crop(0, 0, 5, 5))
    p, _, _, c = levels
    for pairs in (limits.scikit_pairs, limits.information_of_pairs, limits.compiled_pairs):
        np.testing.assert_allclose(pairs(c, p), limits.scikit_pairs(c, p), atol=1e-9)
        assert limits.all_pairs(pairs, levels) == STORED["cost"]["pairs"]
    assert STORED["cost"]["scikit"] > STORED["cost"]["numpy"] > 5
