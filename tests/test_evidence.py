"""Chance as the opponent, and an error without a reference: laws, statistics at fixed seeds, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conftest import make_samples
from mcdenoise.filters import gaussian
from mcdenoise.metrics import mse
from mcdenoise.rpf import mutual_information
from mcdenoise.samples import half_means, variance_of_mean
from mcdenoise.study.evidence import error_against_other, permutation_p_value

pytestmark = pytest.mark.ch10


# --- permutation_p_value


@given(st.lists(st.floats(0, 1), min_size=1, max_size=50), st.floats(0, 1))
def test_p_is_a_share_of_all_orders_and_never_0(permuted, observed):
    p = permutation_p_value(observed, np.array(permuted))
    assert 1 / (len(permuted) + 1) <= p <= 1
    assert p * (len(permuted) + 1) == pytest.approx(1 + sum(one >= observed for one in permuted))


def test_under_chance_each_p_is_equally_likely(rng):
    """P(p <= a) = a for a on the grid of 20 orders, within four standard errors of 4000 experiments."""
    p = np.array([permutation_p_value(one[0], one[1:]) for one in rng.random((4000, 20))])
    for a in (0.05, 0.25, 0.5):
        assert abs(np.mean(p <= a + 1e-9) - a) < 4 * np.sqrt(a * (1 - a) / 4000)


def test_a_dependency_is_told_from_chance(rng):
    x, noise = rng.random(500), rng.random(500)
    for y, smallest in ((x + 0.5 * noise, True), (noise, False)):
        permuted = [mutual_information(rng.permutation(x), y) for _ in range(39)]
        p = permutation_p_value(mutual_information(x, y), np.array(permuted))
        assert (p == 1 / 40) == smallest


@pytest.mark.parametrize(
    ("observed", "permuted"), [(0.1, []), (0.1, [[0.1, 0.2]]), (np.nan, [0.1]), (0.1, [0.1, np.inf])]
)
def test_a_p_value_needs_a_shuffle(observed, permuted):
    with pytest.raises(ValueError, match=r"observed must be a finite number .* Shuffle at least once"):
        permutation_p_value(observed, np.array(permuted))


# --- error_against_other


def test_of_equals_it_is_minus_the_variance():
    image = np.ones((3, 4, 3))
    assert error_against_other(image, image, 0.25 * image) == pytest.approx(-0.25)


def test_against_the_truth_itself_it_is_the_mean_squared_error(rng):
    filtered, truth = rng.random((2, 4, 5, 3))
    assert error_against_other(filtered, truth, np.zeros_like(truth)) == pytest.approx(mse(filtered, truth))


def test_halves_of_samples_give_the_true_error_of_a_filter(rng):
    """Filter one half, compare with the other: on average of 40 buffers the true error, within four standard errors."""
    truth, away = np.full((16, 16, 3), 0.6), []
    truth[:, 8:] = 0.2
    for _ in range(40):
        radiance = truth[:, :, np.newaxis] * rng.gamma(2.0, 0.5, (16, 16, 8, 3))
        half_a, half_b = half_means(make_samples(rng, 16, 16, 8, radiance=radiance).radiance)
        filtered = gaussian(half_a, sigma_space=1.0)
        estimate = error_against_other(filtered, half_b, variance_of_mean(radiance[:, :, 4:]))
        away.append(estimate - mse(filtered, truth))
    assert abs(np.mean(away)) < 4 * np.std(away) / np.sqrt(40)


def test_sums_are_exact_enough_in_float32(rng):
    image = (1e4 + rng.random((8, 8, 3))).astype(np.float32)
    other = image + np.float32(0.5)
    found = error_against_other(image, other, np.zeros_like(image))
    assert found == pytest.approx(np.mean((other.astype(float) - image) ** 2), rel=1e-9)


@pytest.mark.parametrize("shape", [(2, 3), (2, 2, 1), ()])
def test_one_shape_is_needed(shape):
    image = np.ones((2, 2, 3))
    with pytest.raises(ValueError, match=r"must have one shape, not empty, got .* Filter half of the samples"):
        error_against_other(image, np.ones(shape), image)


def test_no_pixel_has_no_error():
    with pytest.raises(ValueError, match=r"not empty, got \[\(0, 3\)\]"):
        error_against_other(np.ones((0, 3)), np.ones((0, 3)), np.ones((0, 3)))
