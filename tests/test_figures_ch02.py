"""Chapter 02's figures: what they show is what the formulas say, and what the text quotes is what is stored."""

import json
from pathlib import Path

import numpy as np
import pytest

from mcdenoise.classroom.checking.exercise import load_tests
from mcdenoise.filters import gaussian
from mcdenoise.filters.gaussian import gaussian_sums
from mcdenoise.metrics import relmse
from mcdenoise.study.figures import _ch02_cost as cost
from mcdenoise.study.figures import _ch02_data as data
from mcdenoise.study.figures import _ch02_errors as errors
from mcdenoise.study.figures import ch02

pytestmark = pytest.mark.ch02

ROOT = Path(__file__).parents[1]
STORED = json.loads((ROOT / "lectures" / "figures" / "ch02.json").read_text("utf-8"))


def check_stored(name, numbers, only=None):
    """The numbers of a figure made now are those stored, but for rounding to four digits."""
    for key in only or numbers:
        assert STORED[name][key] == pytest.approx(float(numbers[key]), rel=1e-3, abs=1e-8), key


@pytest.mark.parametrize("sigma_space", [1.0, 2.0, 4.0])
def test_impulse_response_is_the_closed_form(sigma_space):
    x = np.arange(121) - 60
    expected = ch02.lecture_bell(np.hypot(x[:, np.newaxis], x), sigma_space)
    response = ch02.impulse_response(sigma_space, size=121)
    # The window ends at 6 sigma, and a sum is no integral: exp(-18) and exp(-2 pi^2 sigma^2), both below 3e-8.
    np.testing.assert_allclose(response, expected, rtol=0, atol=3e-8 * expected.max())
    assert response.sum() == pytest.approx(1, rel=1e-12)


def test_cheap_figures_give_the_stored_numbers():
    figure, numbers = ch02.make_impulse()
    check_stored("impulse", numbers, ["peak_2", "closed_2", "mass", "sum_0_3", "sum_0_5", "sum_1_0", "sum_2_0"])
    assert numbers["difference_twice"] < 1e-8
    assert len(figure.axes) == 4
    _, numbers = ch02.make_frequency()
    check_stored("frequency", numbers, ["difference_0_5", "difference_1_0", "half_times_sigma"])
    _, numbers = cost.make_noise_left()
    check_stored("noise_left", numbers)


def test_every_figure_is_stored():
    assert set(STORED) == set(ch02.FIGURES)
    for name in ch02.FIGURES:
        path = ROOT / "lectures" / "figures" / f"ch02_{name}.{'html' if name == 'sigma' else 'png'}"
        assert 10_000 < path.stat().st_size < (600_000 if name == "sigma" else 210_000)


def test_every_number_that_the_text_quotes_is_stored():
    text = (ROOT / "lectures" / "ch02_gaussian.md").read_text("utf-8")
    quoted = {expression.split("|")[0] for expression in text.split("{{")[1:]}
    paths = [
        part for one in quoted for part in one.replace("(", " ").split("}}")[0].split() if part.startswith("ch02.")
    ]
    assert len(paths) > 30
    for path in paths:
        value = STORED
        for key in path.removeprefix("ch02.").replace("[0]", "").replace("[2]", "").strip(")").split("."):
            value = value[key]


@pytest.mark.parametrize("sigma_space", [0.5, 1.0, 3.0])
def test_noise_left_is_the_closed_form_within_4_standard_errors(sigma_space):
    share, standard_error = cost.measured_share(sigma_space, seed=11)
    exact = cost.share_left(sigma_space, int(np.ceil(3 * sigma_space)))
    assert abs(share - exact) < 4 * standard_error
    if sigma_space >= 1:
        assert exact == pytest.approx(1 / (4 * np.pi * sigma_space**2), rel=0.01)


def test_standard_error_of_the_share_is_that_of_repeated_measurements(monkeypatch):
    monkeypatch.setattr(cost, "NOISE_SIZE", 128)
    measured = [cost.measured_share(1.5, seed) for seed in range(60)]
    shares, claimed = np.transpose(measured)
    # The standard deviation of 60 values is itself known to 1 / sqrt(2 * 59), 9 %: 4 of those.
    assert shares.std(ddof=1) == pytest.approx(claimed.mean(), rel=0.37)


def test_two_passes_are_the_window():
    image = np.random.default_rng(3).random((11, 8, 3))
    for total_or_norm, expected in zip(cost.separable_sums(image, 1.7, 9), gaussian_sums(image, 1.7, 9), strict=True):
        np.testing.assert_allclose(total_or_norm, expected, rtol=1e-12)


def test_exponents_are_those_of_the_taps():
    assert STORED["cost"]["direct"]["exponent"] == pytest.approx(2, abs=0.3)
    assert STORED["cost"]["passes"]["exponent"] == pytest.approx(1, abs=0.3)
    assert 0.5 < STORED["cost"]["numba"]["exponent"] < 1.2


def test_error_splits_into_blur_and_noise():
    rng = np.random.default_rng(5)
    target = rng.random((64, 64, 3)) ** 2
    images = target + 0.2 * rng.standard_normal((30, 64, 64, 3))
    blurred = gaussian(target, sigma_space=1.0, engine="numpy")
    parts = np.array([data.split_error(gaussian(image, sigma_space=1.0), blurred, target) for image in images])
    total, blur, noise = parts.T
    np.testing.assert_allclose(total, [relmse(gaussian(image, sigma_space=1.0), target) for image in images])
    cross = total - blur - noise
    assert abs(cross.mean()) < 4 * cross.std(ddof=1) / np.sqrt(len(images))
    assert cross.std() < 0.05 * total.mean()
    assert np.ptp(blur) == 0


@pytest.mark.parametrize("scene", data.SCENES)
def test_stored_errors_have_their_minimum_where_blur_meets_noise(scene):
    numbers = STORED["error_sigma"]
    assert numbers[f"least_{scene}"] < numbers[f"unfiltered_{scene}"]
    assert errors.SIGMAS[0] < numbers[f"best_{scene}"] < errors.SIGMAS[-1]
    assert numbers[f"cross_{scene}"] < 0.02
    few, some, many = STORED["best_sigma"][scene]["best"]
    assert few > some > many


def test_gaussian_harms_pinhole_from_half_a_pixel_on():
    numbers = STORED["error_sigma"]
    assert numbers["half_pinhole"] > 1.5 * numbers["unfiltered_pinhole"]
    assert STORED["fails"]["pinhole_filtered"] > 3 * STORED["fails"]["pinhole_unfiltered"]
    assert STORED["fails"]["dof_filtered"] < 0.5 * STORED["fails"]["dof_unfiltered"]


def test_exercise_on_the_order_of_scenes_quotes_the_figure():
    test = load_tests(ROOT / "tests" / "exercises" / "test_ch02.py")["predicted_order"].tests[0]
    best = test.__globals__["BEST_SIGMA"]
    assert best == {scene: round(STORED["error_sigma"][f"best_{scene}"], 2) for scene in best}


def test_renders_share_no_samples(monkeypatch):
    samples = np.random.default_rng(0).random((data.SIZE, data.SIZE, data.MOST_SPP, 3), np.float32)
    monkeypatch.setattr(data, "_radiance", lambda scene: samples)
    images = data.renders("dof", 8)
    assert images.shape == (4, data.SIZE, data.SIZE, 3)
    np.testing.assert_allclose(images[1], samples[:, :, 8:16].mean(axis=2), rtol=1e-6)
    np.testing.assert_allclose(images.mean(axis=0), samples.mean(axis=2), rtol=1e-6)


def test_borders_of_a_flat_image():
    flat = np.full((40, 30, 3), 0.5)
    black, ours, mirror = ch02.at_borders(flat, 2.0).values()
    np.testing.assert_allclose(ours, flat, rtol=1e-6)
    np.testing.assert_allclose(mirror, flat, rtol=1e-6)
    assert black[0, 0, 0] / 0.5 == pytest.approx(STORED["borders"]["corner"], rel=1e-3)
    assert black[20, 0, 0] / 0.5 == pytest.approx(STORED["borders"]["edge"], rel=1e-3)
    norm = gaussian_sums(flat, 2.0, 6)[1]
    assert norm[0, 0] / norm[20, 15] == pytest.approx(STORED["borders"]["measured_corner"], rel=1e-3)


def test_slider_has_a_frame_for_each_sigma():
    html = (ROOT / "lectures" / "figures" / "ch02_sigma.html").read_text("utf-8")
    assert html.count("<img") == len(ch02.SLIDER_SIGMAS)
