"""The figures of chapter 01: what they measure, held against theory and against the numbers that the lecture quotes."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mcdenoise.metrics import relmse
from mcdenoise.render import capture, read_exr
from mcdenoise.samples import pixel_mean
from mcdenoise.study.figures import _ch01_adaptive as adaptive
from mcdenoise.study.figures import _ch01_lens as lens
from mcdenoise.study.figures import _ch01_lightfield as lightfield
from mcdenoise.study.figures import _ch01_reconstruct as reconstruction
from mcdenoise.study.figures import _ch01_vector as vector
from mcdenoise.study.figures import ch01

pytestmark = pytest.mark.ch01

ROOT = Path(__file__).parents[1]
STORED = json.loads((ROOT / "lectures" / "figures" / "ch01.json").read_text())


@pytest.fixture(scope="module")
def field():
    """The scanline with few samples a cell."""
    return lightfield.scanline(lightfield.ROW, spp=4)


@pytest.fixture
def quick_field(field, monkeypatch):
    """The shipped radiance with the depths of `field`, in place of the scanline that the figures trace."""
    field = replace(field, radiance=read_exr(ROOT / "notebooks" / "data" / "dof_scanline.exr"))
    monkeypatch.setattr(reconstruction, "scanline", lambda: field)
    return field


@pytest.mark.parametrize("scene", ch01.SCENES)
def test_stored_slopes_are_minus_one(scene):
    one = STORED["convergence"][scene]
    assert abs(one["slope"] + 1) < 4 * one["se"]
    assert one["se"] < 0.02


def test_slope_measured_again():
    slope, standard_error = ch01.slope_of(ch01.errors_of("soft_shadow"))
    stored = STORED["convergence"]["soft_shadow"]
    assert abs(slope + 1) < 4 * standard_error
    assert abs(slope - stored["slope"]) < 4 * np.hypot(standard_error, stored["se"])


def test_slopes_of_known_power_laws():
    blocks = np.array([[3.0], [5.0]]) / np.array(ch01.SPPS) ** 1.5
    assert ch01.slope_of(blocks) == pytest.approx((-1.5, 0))


def test_integrals_in_one_dimension_have_the_slopes_of_theory():
    errors = {name.split(",")[0]: values for name, (values, _) in ch01._integrals().items()}
    for name, theory in (("mild", -0.5), ("stratified", -1.5), ("wild", -0.2)):
        slope = np.polyfit(np.log(ch01.INTEGRAL_COUNTS), np.log(errors[name]), 1)[0]
        assert slope == pytest.approx(theory, abs=0.05)
        assert slope == pytest.approx(STORED["convergence"][name]["slope"], rel=1e-3)


def test_errors_of_the_slider_fall_as_one_over_spp():
    stored = STORED["spp"]
    for spp in (4, 16, 64, 256):
        assert stored[f"relmse_{spp}"] * spp == pytest.approx(stored["relmse_1"], rel=0.1)


def test_circle_of_confusion_in_closed_form():
    assert lens.circle_of_confusion(lens.FOCUS_DISTANCE) == 0
    assert lens.circle_of_confusion(lens.FOCUS_DISTANCE / 2) == pytest.approx(2 * lens.LENS_RADIUS)
    assert lens.circle_of_confusion(1e9) == pytest.approx(2 * lens.LENS_RADIUS)
    depth = np.array([2.0, 4.0, 6.0, 12.0])
    blur = lens.pixels_per_unit(128) * lens.circle_of_confusion(depth)
    np.testing.assert_allclose(lens.light_field_slope(depth, 128), blur * [1, 1, -1, -1])


def test_samples_blur_as_the_formula_says():
    samples = capture("dof", width=48, height=48, spp=4, seed=3)
    depth, radius = lens.displacements(samples)
    assert len(depth) > 2000
    np.testing.assert_allclose(radius, lens.pixels_per_unit(48) * lens.circle_of_confusion(depth) / 2, atol=1e-3)


def test_lens_points_fill_the_disc_evenly(rng):
    u, v = rng.random((2, 40_000))
    x, y = lens.lens_point(u, v)
    radius = np.hypot(x, y)
    assert radius.max() <= 1
    assert abs(np.mean(radius < 0.5) - 0.25) < 4 * np.sqrt(0.25 * 0.75 / len(u))
    np.testing.assert_allclose(lens.lens_point(np.array([0.0, 0.25, 1.0]), 0.5), [[1, 0.5, -1], [0, 0, 0]], atol=1e-12)


@pytest.mark.parametrize("row", [40, 94])
def test_the_middle_of_the_lens_sees_the_pinhole_image(row):
    view = lightfield.row_of_pinholes(0.5, row)
    seen = pixel_mean(capture(view, width=256, height=1, spp=32).radiance)[0].reshape(128, 2, 3).mean(axis=1)
    pinhole = read_exr(ROOT / "notebooks" / "data" / "pinhole.exr")
    differences = np.abs(pinhole - seen).mean(axis=(1, 2))
    assert differences.argmin() == row


def test_trajectories_of_the_light_field_are_lines_of_the_closed_form_slope(field):
    x = field.middle + lens.light_field_slope(field.depth, 128) * (lightfield.lens_us()[:, np.newaxis] - 0.5)
    is_hit = np.isfinite(field.depth)
    assert is_hit.mean() > 0.95
    # each sample lies somewhere in its column, half a pixel wide
    assert np.abs(x - lightfield.screen_xs())[is_hit].max() < 0.251


def test_slopes_read_from_radiance_give_the_depth(quick_field):
    for name, x in lightfield.LANDMARKS.items():
        stored = STORED["light_field"][name.split()[0]]
        slope = lens.light_field_slope(quick_field.depth[lightfield.VIEWS // 2, int(2 * x)], 128)
        assert lightfield.measured_slope(quick_field.radiance, x) == pytest.approx(slope, abs=0.1)
        # a column is half a pixel wide, and on a ball the depth changes across it
        assert stored["slope"] == pytest.approx(slope, abs=0.1)
        assert stored["measured"] == pytest.approx(slope, abs=0.1)


def test_shearing_moves_rows_about_the_middle_of_the_lens():
    xs, us = lightfield.screen_xs(), lightfield.lens_us()
    spot = np.exp(-((xs - 60 - 5.0 * (us[:, np.newaxis] - 0.5)) ** 2) / 8)
    upright = lightfield.sheared(np.repeat(spot[..., np.newaxis], 3, axis=2), 5.0)
    np.testing.assert_allclose(upright[:, :, 0], np.tile(np.exp(-((xs - 60) ** 2) / 8), (len(us), 1)), atol=0.01)


def test_the_shipped_scanline_is_the_one_that_the_figures_trace(field, tmp_path, monkeypatch):
    shipped = read_exr(ROOT / "notebooks" / "data" / "dof_scanline.exr")
    assert shipped.shape == field.radiance.shape
    difference = field.radiance - shipped
    assert np.abs(difference).mean() < 0.05
    assert abs(difference.mean()) < 0.002
    monkeypatch.setattr(lightfield, "scanline", lambda: field)
    lightfield.store_scanline(tmp_path / "row.exr")
    np.testing.assert_allclose(read_exr(tmp_path / "row.exr"), field.radiance, rtol=1e-6)


def _sparse(*rows):
    u, x, depth = np.array(rows, float).T
    slope = lens.light_field_slope(depth, 128)
    return reconstruction.Sparse(u, x, np.zeros((len(u), 3)), depth, slope)


def test_same_surface_is_told_by_crossing_on_the_lens():
    samples = _sparse((0.5, 60, 4.0), (0.5, 61, 4.0), (0.5, 60.5, 8.0), (0.5, 90, 8.0))
    found = reconstruction.same_surface(samples, 0, np.arange(4))
    np.testing.assert_array_equal(found, [True, True, False, True])


def test_the_front_layer_is_the_nearest_surface_that_covers_the_query():
    samples = _sparse((0.5, 59.8, 4.0), (0.5, 60.3, 4.0), (0.5, 59.9, 8.0), (0.5, 60.2, 8.0), (0.5, 60.5, 3.0))
    near = np.arange(5)
    covered = reconstruction.front_layer(samples, near, samples.at(0.5) - 60)
    assert sorted(covered) == [0, 1]
    right = reconstruction.front_layer(samples, near[2:], samples.at(0.5) - 60)
    assert sorted(right) == [2, 3]
    alone = reconstruction.front_layer(samples, near[[1, 4]], samples.at(0.5) - 60)
    assert list(alone) == [1]


def test_samples_carried_along_their_slopes_err_less(quick_field):
    truth = reconstruction.pixel_row(quick_field.radiance)
    _, _, rows = reconstruction.compare(seed=0)
    errors = {name: relmse(row[np.newaxis], truth[np.newaxis]) for name, row in rows.items()}
    assert errors["along_slopes"] < errors["without_surfaces"] < errors["without_slopes"]
    assert errors["input"] > 2 * errors["along_slopes"]
    assert STORED["same_surface"]["gain"] > 2


def test_adaptive_ways_keep_their_budget_and_are_right_on_average(field, rng):
    truth = reconstruction.pixel_row(field.radiance)
    x, u, _ = adaptive.image_space(field.radiance, 8, rng)
    assert len(x) == len(u) == 8 * 128
    cells = adaptive.grow_cells(field.radiance, 8, rng)
    assert sum(len(cell.places) for cell in cells) == 8 * 128
    assert sum(np.prod(cell.high - cell.low) for cell in cells) == pytest.approx(128)
    for cell in cells:
        assert all((cell.low <= place).all() and (place < cell.high).all() for place in cell.places)
    assert adaptive.integrate(cells).mean() == pytest.approx(truth.mean(), rel=0.03)


def test_multidimensional_beats_uniform(quick_field, monkeypatch):
    monkeypatch.setattr(adaptive, "SEEDS", 3)
    errors = adaptive.mean_errors(quick_field.radiance, 16)
    assert errors["multidimensional"][0] < errors["uniform"][0]
    stored = STORED["adaptive"]
    for way in ("uniform", "image_space"):
        error = np.hypot(stored["multidimensional_16_se"], stored[f"{way}_16_se"])
        assert stored[f"{way}_16"] - stored["multidimensional_16"] > 3 * error
    assert stored["multidimensional_16_noisy"] > stored["image_space_16_noisy"]


def test_the_lens_tells_the_surface_better_than_the_screen():
    _, numbers = vector.make_sample_vector()
    stored = STORED["sample_vector"]
    assert numbers["told_by_screen"] < numbers["told_by_lens"] < numbers["told_by_both"]
    samples = numbers["samples"]
    for name in ("told_by_screen", "told_by_lens", "told_by_both", "near_share"):
        spread = np.sqrt(stored[name] * (1 - stored[name]) / samples)
        assert abs(numbers[name] - stored[name]) < 5 * spread


def test_share_told_by_a_straight_cut(rng):
    columns = rng.random((500, 2))
    assert vector.share_told(columns, columns.sum(axis=1) > 1) > 0.95
    assert abs(vector.share_told(columns, rng.random(500) < 0.5) - 0.5) < 0.15
