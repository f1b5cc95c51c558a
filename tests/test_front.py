"""The chart of speed against accuracy: laws of the front, of equal error and of equal time, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdenoise.study.compare import Comparison, Result
from mcdenoise.study.front import equal_error_spp, equal_time_error, pareto_front

pytestmark = pytest.mark.ch10
SPP, MC_ERRORS = np.array([4, 16, 64]), np.array([0.16, 0.04, 0.02])
POINTS = st.lists(st.tuples(st.integers(1, 9), st.integers(1, 9)), min_size=1, max_size=30)


@st.composite
def curves(draw):
    """A falling curve of Monte Carlo at one to six spp."""
    spp = np.cumsum(draw(st.lists(st.integers(1, 50), min_size=1, max_size=6))).astype(float)
    falls = draw(st.lists(st.floats(0.1, 2.0), min_size=len(spp), max_size=len(spp)))
    return spp, 0.5 * np.exp(-np.cumsum(falls))


# --- pareto_front


@given(POINTS)
def test_off_the_front_somebody_on_it_is_better(points):
    seconds, errors = np.array(points, float).T
    on = pareto_front(seconds, errors)
    for s, e, stays in zip(seconds, errors, on, strict=True):
        beaten = on & (seconds <= s) & (errors <= e) & ((seconds < s) | (errors < e))
        assert beaten.any() != stays


@given(POINTS)
def test_the_front_does_not_ask_for_units_or_order(points):
    seconds, errors = np.array(points, float).T
    on = pareto_front(seconds, errors)
    np.testing.assert_array_equal(pareto_front(1000 * seconds, np.log(errors)), on)
    np.testing.assert_array_equal(pareto_front(errors, seconds), on)
    np.testing.assert_array_equal(pareto_front(seconds[::-1], errors[::-1]), on[::-1])
    np.testing.assert_array_equal(pareto_front(np.tile(seconds, 2), np.tile(errors, 2)), np.tile(on, 2))


def test_the_front_is_that_of_a_comparison(rng):
    image = np.zeros((1, 1, 3))
    results = [
        Result(str(k), str(k), "filter", 8, float(a), float(b), 0.0, 0.0, 0.0, image)
        for k, (a, b) in enumerate(rng.random((20, 2)))
    ]
    comparison = Comparison("made up", 1, 8, 0, 64, 0.0, 0.0, 1.0, {}, tuple(results), image)
    on = pareto_front(np.array([r.seconds for r in results]), np.array([r.relmse for r in results]))
    assert {r.name for r in comparison.front()} == {r.name for r, stays in zip(results, on, strict=True) if stays}


def test_nothing_has_an_empty_front():
    assert pareto_front(np.array([]), np.array([])).shape == (0,)


@pytest.mark.parametrize(
    ("seconds", "errors"),
    [([1.0, 2.0], [1.0]), ([[1.0]], [[1.0]]), ([1.0, np.nan], [1.0, 2.0]), ([1.0, 2.0], [np.inf, 2.0])],
)
def test_a_front_needs_finite_points(seconds, errors):
    with pytest.raises(ValueError, match=r"must be finite and of one shape \(n,\), got .* Leave out what was not"):
        pareto_front(np.array(seconds), np.array(errors))


# --- equal_error_spp and equal_time_error


@given(curves(), st.floats(1e-4, 10.0))
def test_a_smaller_error_needs_more_samples(curve, error):
    spp, mc_errors = curve
    assert equal_error_spp(error / 2, spp, mc_errors) > equal_error_spp(error, spp, mc_errors) > 0


@given(curves(), st.floats(1e-4, 10.0))
def test_equal_time_undoes_equal_error(curve, error):
    """Monte Carlo in the time of as many samples as equal the error has that error."""
    spp, mc_errors = curve
    n = equal_error_spp(error, spp, mc_errors)
    assert equal_time_error(0.3 + 0.01 * n, 0.3, 0.01, spp, mc_errors) == pytest.approx(error, rel=1e-6)


@given(st.floats(-1.5, -0.5), st.floats(1.0, 64.0))
def test_a_power_law_between_its_points(slope, n):
    spp = np.array([1.0, 5.0, 64.0])
    assert equal_error_spp(n**slope, spp, spp**slope) == pytest.approx(n)


def test_where_noise_makes_the_curve_rise_its_first_way_down_counts():
    spp, mc_errors = np.array([4, 8, 16, 32]), np.array([0.16, 0.04, 0.08, 0.02])
    assert equal_error_spp(0.08, spp, mc_errors) == pytest.approx(4 * np.sqrt(2))
    assert equal_error_spp(0.01, spp, mc_errors) == pytest.approx(64)
    assert equal_error_spp(0.04, spp, mc_errors) == pytest.approx(8)


def test_both_ends_have_the_slope_minus_one():
    assert equal_error_spp(0.64, SPP, MC_ERRORS) == pytest.approx(1.0)
    assert equal_error_spp(0.005, SPP, MC_ERRORS) == pytest.approx(256.0)
    assert equal_time_error(256.0, 0.0, 1.0, SPP, MC_ERRORS) == pytest.approx(0.005)
    assert equal_time_error(1.0, 0.0, 1.0, SPP, MC_ERRORS) == pytest.approx(0.64)


def test_time_that_pays_for_no_sample_gives_no_image():
    assert equal_time_error(0.3, 0.3, 0.01, SPP, MC_ERRORS) == np.inf
    assert equal_time_error(0.1, 0.3, 0.01, SPP, MC_ERRORS) == np.inf


@pytest.mark.parametrize("call", [equal_error_spp, lambda error, *curve: equal_time_error(1.0, 0.1, error, *curve)])
@pytest.mark.parametrize(
    ("error", "spp", "mc_errors", "words"),
    [
        (0.1, [4, 16], [0.1], r"must be \(m,\), spp above 0 and ascending, got .* Sort both"),
        (0.1, [16, 4], [0.1, 0.2], r"ascending, got \[16\.  4\.\]"),
        (0.1, [0, 4], [0.1, 0.2], "spp above 0"),
        (0.1, [], [], "above 0, got"),
        (0.1, [4, 16], [0.1, 0.0], r"above 0, got .*0\.1 0\. "),
        (0.1, [4, 16], [0.1, np.nan], "above 0, got"),
        (0.0, [4, 16], [0.1, 0.2], "above 0, got"),
        (np.nan, [4, 16], [0.1, 0.2], "above 0, got"),
    ],
)
def test_a_curve_that_is_none_is_refused(call, error, spp, mc_errors, words):
    with pytest.raises(ValueError, match=words):
        call(error, np.array(spp), np.array(mc_errors))


def test_negative_fixed_seconds_are_refused():
    with pytest.raises(ValueError, match=r"fixed_seconds must be at least 0.* Measure at two spp that differ more"):
        equal_time_error(1.0, -0.1, 0.01, SPP, MC_ERRORS)
