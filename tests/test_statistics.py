"""Pixel statistics against closed forms and NumPy, and what they promise of Monte Carlo samples."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from mcdenoise.samples import half_means, pixel_mean, sample_variance, variance_of_mean

pytestmark = pytest.mark.ch01
ALL = [pixel_mean, sample_variance, variance_of_mean, half_means]


def test_closed_form():
    samples = np.array([[[1.0, 2.0, 4.0, 5.0]]])
    assert pixel_mean(samples) == 3
    assert sample_variance(samples) == pytest.approx((4 + 1 + 1 + 4) / 3)
    assert variance_of_mean(samples) == pytest.approx(10 / 3 / 4)
    assert [half.item() for half in half_means(samples)] == [1.5, 4.5]


def test_odd_spp_leaves_the_last_sample_out_of_the_halves():
    half_a, half_b = half_means(np.array([[[1.0, 2.0, 9.0]]]))
    assert (half_a.item(), half_b.item()) == (1, 2)


@given(arrays(np.float64, array_shapes(min_dims=4, max_dims=4, min_side=2, max_side=5), elements=st.floats(-1e3, 1e3)))
def test_shapes_dtype_and_numpy(samples):
    np.testing.assert_allclose(pixel_mean(samples), samples.mean(axis=2))
    np.testing.assert_allclose(sample_variance(samples), samples.var(axis=2, ddof=1), atol=1e-9)
    single = pixel_mean(samples.astype(np.float32))
    assert single.dtype == np.float32
    assert single.shape == samples.shape[:2] + samples.shape[3:]
    if samples.shape[2] % 2 == 0:
        np.testing.assert_allclose(sum(half_means(samples)) / 2, pixel_mean(samples), atol=1e-9)


def test_mean_is_summed_in_double_precision():
    samples = np.full((1, 1, 100_000), 0.1, np.float32)
    assert pixel_mean(samples).item() == np.float32(0.1)


def test_variances_are_unbiased(rng):
    variance, spp, pixels = 0.25, 8, 40_000
    samples = rng.normal(1.0, np.sqrt(variance), (pixels, 1, spp))
    error_of_estimate = variance * np.sqrt(2 / (spp - 1) / pixels)
    assert abs(sample_variance(samples).mean() - variance) < 4 * error_of_estimate
    assert abs(variance_of_mean(samples).mean() - variance / spp) < 4 * error_of_estimate / spp
    assert abs(pixel_mean(samples).var() - variance / spp) < 4 * variance / spp * np.sqrt(2 / pixels)


def test_halves_are_independent(rng):
    half_a, half_b = half_means(rng.normal(size=(40_000, 1, 8)))
    assert abs(np.corrcoef(half_a.ravel(), half_b.ravel())[0, 1]) < 4 / np.sqrt(40_000)


@pytest.mark.parametrize("statistic", ALL)
def test_bad_samples_are_refused(statistic):
    with pytest.raises(ValueError, match=r"samples must have shape \(h, w, spp\).*got \(2, 2\)"):
        statistic(np.ones((2, 2)))
    with pytest.raises(ValueError, match="samples must be finite"):
        statistic(np.full((2, 2, 2), np.nan))


@pytest.mark.parametrize("statistic", ALL[1:])
def test_one_sample_has_no_variance(statistic):
    with pytest.raises(ValueError, match="At least 2 samples per pixel are needed, got 1"):
        statistic(np.ones((2, 2, 1)))


def test_input_is_left_alone(rng):
    samples = rng.random((2, 3, 4, 3))
    before = samples.copy()
    for statistic in ALL:
        statistic(samples)
    np.testing.assert_array_equal(samples, before)
