"""Bias and variance apart, and the median of means: laws, statistics at fixed seeds, and what is refused."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mcdenoise.samples import pixel_mean
from mcdenoise.study.robust import bias_and_variance, median_of_means

pytestmark = pytest.mark.ch10
STACKS = arrays(float, st.tuples(st.integers(2, 6), st.integers(1, 3), st.integers(1, 3)), elements=st.floats(0, 10))
SAMPLES = arrays(
    np.float32, st.tuples(st.just(1), st.just(2), st.integers(1, 12), st.just(3)), elements=st.floats(0, 8, width=32)
)


# --- bias_and_variance


@given(STACKS)
def test_both_add_up_to_the_error(images):
    truth = np.ones(images.shape[1:])
    bias_squared, variance = bias_and_variance(images, truth)
    np.testing.assert_allclose(bias_squared + variance, ((images - 1) ** 2).mean(axis=0), atol=1e-9)
    assert (variance >= 0).all()


@given(STACKS, st.floats(-3, 3))
def test_light_that_is_added_changes_the_bias_alone(images, light):
    truth = images.mean(axis=0)
    bias_squared, variance = bias_and_variance(images + light, truth)
    before = bias_and_variance(images, truth)
    np.testing.assert_allclose(variance, before[1], atol=1e-9)
    np.testing.assert_allclose(bias_squared, before[0] + light**2, atol=1e-9)


def test_on_average_both_are_right(rng):
    """Mean of many estimates from three images each, within four standard errors of bias^2 = 0.25 and variance = 4."""
    images = 1.5 + 2 * rng.normal(size=(3, 20_000))
    for found, right in zip(bias_and_variance(images, np.ones(20_000)), (0.25, 4.0), strict=True):
        assert abs(found.mean() - right) < 4 * found.std() / np.sqrt(20_000)
    assert (bias_and_variance(images, np.ones(20_000))[0] < 0).any()


@pytest.mark.parametrize("images", [np.ones((1, 2, 2)), np.ones((3, 2, 3)), np.ones((0, 2, 2)), np.float64(1.0)])
def test_two_images_of_the_shape_of_the_truth_are_needed(images):
    with pytest.raises(ValueError, match=r"images must be \(n, \.\.\.\) with n >= 2 .* Stack the images of two seeds"):
        bias_and_variance(images, np.ones((2, 2)))


# --- median_of_means


@given(SAMPLES)
def test_one_group_is_the_mean_and_as_many_as_samples_the_median(radiance):
    np.testing.assert_allclose(median_of_means(radiance, 1), pixel_mean(radiance), rtol=1e-6)
    median = np.median(radiance, axis=2)
    np.testing.assert_allclose(median_of_means(radiance, radiance.shape[2]), median, rtol=1e-6)


@given(SAMPLES, st.integers(1, 12))
def test_it_stays_among_the_samples_and_follows_scale_and_shift(radiance, groups):
    groups = min(groups, radiance.shape[2])
    found = median_of_means(radiance.astype(float), groups)
    assert (found >= radiance.min(axis=2) - 1e-9).all()
    assert (found <= radiance.max(axis=2) + 1e-9).all()
    np.testing.assert_allclose(median_of_means(2.0 * radiance.astype(float) + 3, groups), 2 * found + 3, atol=1e-9)


@pytest.mark.parametrize("groups", range(1, 17))
def test_it_bears_bad_samples_in_less_than_half_of_the_groups(rng, groups):
    radiance = rng.random((2, 2, 16, 3))
    firsts = [part[0] for part in np.array_split(np.arange(16), groups)]
    borne = (groups - 1) // 2
    radiance[:, :, firsts[:borne]] = 1e12
    assert (median_of_means(radiance, groups) < 1).all()
    radiance[:, :, firsts[: borne + 1]] = 1e12
    assert (median_of_means(radiance, groups) > 1e9).all()


def test_on_skewed_light_more_groups_are_darker(rng):
    """The price: radiance with the mean 1, most of it in few samples."""
    radiance = rng.gamma(0.25, 4.0, (64, 64, 16, 3))
    means = [median_of_means(radiance, groups).mean() for groups in (1, 4, 8, 16)]
    assert abs(means[0] - 1) < 0.02
    assert all(b < 0.95 * a for a, b in pairwise(means))


def test_dtype_stays_and_nothing_is_changed(rng):
    radiance = rng.random((2, 3, 5, 3)).astype(np.float32)
    before = radiance.copy()
    assert median_of_means(radiance, 2).dtype == np.float32
    np.testing.assert_array_equal(radiance, before)


@pytest.mark.parametrize("radiance", [np.ones((2, 2, 3)), np.full((1, 1, 2, 3), np.nan)])
def test_samples_are_needed(radiance):
    with pytest.raises(ValueError, match=r"radiance must be \(h, w, spp, 3\) and finite, got .* Pass samples such as"):
        median_of_means(radiance, 1)


@pytest.mark.parametrize("groups", [0, 5, -1])
def test_a_group_needs_a_sample(groups):
    with pytest.raises(
        ValueError, match=rf"groups must be from 1 to the spp, 4, got {groups}\. A group needs a sample"
    ):
        median_of_means(np.ones((1, 1, 4, 3)), groups)
