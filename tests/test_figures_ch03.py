"""The figures of chapter 03: what they claim holds, and what is stored is what the page shows."""

import numpy as np
import pytest

from conftest import noise
from mcdenoise.filters import bilateral, gaussian
from mcdenoise.study.figures import _ch03_data as data
from mcdenoise.study.figures import _ch03_guide as guide
from mcdenoise.study.figures import _ch03_limits as limits
from mcdenoise.study.figures import _ch03_museum as museum
from mcdenoise.study.figures import _ch03_toys as toys
from mcdenoise.study.figures.__main__ import rounded
from mcdenoise.study.figures.ch03 import FIGURES
from stored_figures import (
    assert_quoted_numbers_exist,
    assert_same_numbers,
    assert_stored_shown_and_small,
    stored_numbers,
)

pytestmark = pytest.mark.ch03

STORED = stored_numbers("ch03")
CHEAP = ("kernels", "weights", "halo", "outlier")


@pytest.mark.parametrize("name", CHEAP)
def test_stored_numbers_are_those_of_the_code(name):
    assert_same_numbers(rounded(FIGURES[name]()[1], name), STORED[name])


def test_every_figure_is_stored_shown_and_small():
    assert_stored_shown_and_small("ch03", FIGURES)


def test_the_page_quotes_numbers_that_exist():
    assert_quoted_numbers_exist("ch03", at_least=30)


def test_both_limits():
    image = noise(12, 14, 3)
    to_image, to_gaussian = limits.distances_to_limits(image, np.array([1e-3, 1.0, 100.0, 1000.0]))
    assert to_image[0] < 1e-4 < to_image[1] < to_image[2]
    assert to_gaussian[0] > to_gaussian[1] > to_gaussian[2]
    assert to_gaussian[2] / to_gaussian[3] == pytest.approx(100, rel=1e-3)  # slope -2


def test_range_kernel_stops_at_the_edge():
    image, clean = toys.noisy_step()
    near, alike = toys.step_weights(image)
    across = clean < 0.5
    assert near[across].sum() > 0.2 * near.sum()
    assert (near * alike)[across].sum() < 0.002 * (near * alike).sum()
    assert (near * alike)[toys.HALF, toys.HALF] == 1


def test_outlier_closed_form_is_the_filter():
    for height in (0.5, 2.0, 5.0):
        image = np.zeros((9, 9))
        image[4, 4] = height
        filtered = bilateral(image, sigma_space=1.2, sigma_radiance=0.8, radius=4, engine="numpy")[4, 4]
        assert toys.outlier_after(np.array([height]), 1.2, 0.8, 4)[0] == pytest.approx(filtered, rel=1e-12)
    blurred = gaussian(image, sigma_space=1.2, radius=4, engine="numpy")[4, 4]
    assert toys.outlier_after(np.array([height]), 1.2, np.inf, 4)[0] == pytest.approx(blurred, rel=1e-12)


def test_staircase_and_halo():
    steepness = FIGURES["staircase"]()[1]["clean"]
    assert steepness == pytest.approx(STORED["staircase"]["clean"], rel=0.02)  # twenty passes magnify rounding
    assert steepness == sorted(steepness)
    assert steepness[-1] > 5
    of = STORED["halo"]
    assert of["gaussian"]["overshoot"] > 5 * of["bilateral"]["overshoot"]
    assert of["bilateral"]["slope_in_the_middle"] < 0 < of["image_slope"] < of["gaussian"]["slope_in_the_middle"]


def test_our_impulse_response_is_centred_and_as_wide_as_asked():
    for engine in ("numpy", "numba"):
        response = bilateral(
            museum.impulse(), sigma_space=museum.SIGMA, sigma_radiance=museum.WIDE, radius=6, engine=engine
        )
        at = museum.centre_and_spread(response)
        assert np.hypot(at["y"], at["x"]) < 1e-5
        assert at["std_y"] == pytest.approx(at["std_x"], abs=1e-5) == pytest.approx(2.0, abs=0.02)


def test_the_library_is_centred_or_explained():
    response = museum.library_response()
    at = museum.centre_and_spread(response)
    centred = np.hypot(at["y"], at["x"]) < 0.01
    explained = np.abs(response - museum.misread_response()).max() < 1e-6
    assert centred != explained


def test_an_oracle_beats_the_noisy_guide():
    image = data.noisy("soft_shadow", 1)
    own, (oracle, *_) = data.best_bilateral("soft_shadow", image), guide.best_oracle("soft_shadow", image)
    assert oracle < 0.3 * own[0]
    assert own[0] > 0.85 * data.best_gaussian("soft_shadow", image)[0]


def test_noise_hides_edges():
    truth = data.reference("dof")
    wrong = {spp: guide.confusion(*guide.neighbour_differences(data.noisy("dof", spp), truth)) for spp in (1, 32)}
    assert wrong[1] > 0.15
    assert wrong[32] < 0.05


def test_confusion_of_alike_and_of_separate_values():
    assert guide.confusion(np.array([0.1, 0.2]), np.array([0.7, 0.9])) == 0
    assert guide.confusion(np.array([0.1, 0.9]), np.array([0.1, 0.9])) == 0.5


def test_fireflies_survive_the_bilateral():
    numbers = guide.firefly()[1]
    assert numbers["bilateral"] > 0.8
    assert abs(numbers["gaussian"]) < 0.2
