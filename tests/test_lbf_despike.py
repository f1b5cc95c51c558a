"""Spikes: what stands out of its window goes, the rest stays bit for bit."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conftest import noise
from mcdenoise.lbf.despike import despike, median_3x3, run_sums, sums_around, window_count

pytestmark = pytest.mark.ch09


def slow(plane, radius, deviations):
    """The definition, pixel by pixel."""
    cleaned = plane.copy()
    for y, x in np.ndindex(plane.shape):
        top, left = max(y - radius, 0), max(x - radius, 0)
        window = plane[top : y + radius + 1, left : x + radius + 1].astype(np.float64)
        others = np.delete(window.ravel(), (y - top) * window.shape[1] + x - left)
        if others.size > 1 and abs(plane[y, x] - others.mean()) > deviations * others.std(ddof=1) > 0:
            cleaned[y, x] = np.median(plane[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2])
    return cleaned


@given(st.integers(1, 9), st.integers(1, 9), st.integers(1, 6), st.integers(0, 99))
def test_it_is_the_definition(height, width, radius, seed):
    plane = np.random.default_rng(seed).lognormal(sigma=1.5, size=(height, width))
    np.testing.assert_allclose(despike(plane, radius=radius, deviations=2.0), slow(plane, radius, 2.0), rtol=1e-15)


def test_the_large_window_of_the_variance():
    plane = noise(70, 61)
    plane[5, 60], plane[65, 2] = 1e9, -50.0  # out of each other's window
    cleaned = despike(plane, radius=27, deviations=10)
    np.testing.assert_allclose(cleaned, slow(plane, 27, 10), rtol=1e-15)
    assert (cleaned != plane).sum() == 2


@pytest.mark.parametrize("level", [0.0, 0.1, 1e20, -3.0])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_flat_image_stays_bit_for_bit(level, dtype):
    image = np.full((30, 31, 3), level, dtype)
    for radius in (1, 27):
        cleaned = despike(image, radius=radius, deviations=2)
        assert cleaned.dtype == dtype
        np.testing.assert_array_equal(cleaned, image)
    image[15:] += dtype(0.1)  # flat windows off the image's median
    np.testing.assert_array_equal(despike(image, radius=1, deviations=2.9)[:14], image[:14])


@pytest.mark.parametrize("size", [(1, 1), (1, 2), (2, 1), (1, 1, 3)])
def test_one_or_two_pixels_have_no_deviation(size):
    image = np.arange(np.prod(size), dtype=float).reshape(size)
    np.testing.assert_array_equal(despike(image, radius=27, deviations=0.1), image)


def test_fireflies_lose_their_energy():
    """The mean loses all of p a, up to the difference of a ground pixel and the median that takes its place."""
    ground = 1 + 0.01 * noise(60, 60)
    image = ground.copy()
    image[2::6, 2::6] += 100.0  # p = 1 / 36
    cleaned = despike(image, radius=1, deviations=2)
    lost = image.mean() - cleaned.mean()
    assert abs(lost - 100 / 36) < 0.01
    far = despike(image, radius=27, deviations=10)  # so many fireflies widen the yardstick: 6.0 deviations above
    np.testing.assert_array_equal(far, image)


def test_skewed_noise_loses_energy():
    """Log-normal noise, sigma 1: 28 % of the mean."""
    image = np.random.default_rng(0).lognormal(size=(200, 200))
    assert abs(despike(image, radius=1, deviations=2).mean() / image.mean() - 0.72) < 0.02


def test_symmetric_noise_keeps_its_mean():
    """Replaced are some 10 % of the pixels, but the mean moves by less than 4 standard errors."""
    image = 5 + np.random.default_rng(3).normal(size=(200, 200))
    cleaned = despike(image, radius=1, deviations=2)
    assert 0.05 < (cleaned != image).mean() < 0.15
    assert abs(cleaned.mean() - image.mean()) < 4 / 200


def test_a_smooth_image_is_hardly_changed():
    y, x = np.mgrid[:64, :64] / 64
    image = np.sin(5 * x) + np.cos(4 * y)
    np.testing.assert_array_equal(despike(image, radius=27, deviations=10), image)
    assert np.abs(despike(image, radius=1, deviations=2) - image).max() < 0.01


def test_channels_apart_or_together():
    image = noise(9, 9, 3)
    image[4, 4, 1] = 50
    apart = despike(image, radius=4, deviations=5)
    together = despike(image, radius=4, deviations=5, together=True)
    assert (apart != image).sum() == 1
    np.testing.assert_array_equal(np.argwhere(together != image), [[4, 4, 0], [4, 4, 1], [4, 4, 2]])
    for k in range(3):
        assert together[4, 4, k] == np.median(image[3:6, 3:6, k])
    assert image[4, 4, 1] == 50  # the input is left alone


def test_it_does_not_depend_on_unit_or_direction():
    plane = np.random.default_rng(1).lognormal(sigma=2, size=(12, 17)).astype(np.float32)
    cleaned = despike(plane, radius=3, deviations=2)
    np.testing.assert_array_equal(despike(plane * 1024, radius=3, deviations=2), cleaned * 1024)
    np.testing.assert_array_equal(despike(plane[::-1, ::-1].T, radius=3, deviations=2), cleaned[::-1, ::-1].T)
    np.testing.assert_array_equal(despike(plane, radius=3, deviations=np.inf), plane)


@given(st.integers(1, 8), st.integers(1, 8), st.integers(1, 9))
def test_sums_and_counts_of_windows(height, width, radius):
    plane = np.random.default_rng(height).integers(-9, 9, (height, width)).astype(float)
    sums, counts = np.zeros(plane.shape), np.zeros(plane.shape)
    for y, x in np.ndindex(plane.shape):
        window = plane[max(y - radius, 0) : y + radius + 1, max(x - radius, 0) : x + radius + 1]
        sums[y, x], counts[y, x] = window.sum() - plane[y, x], window.size
    np.testing.assert_array_equal(sums_around(plane, radius), sums)
    np.testing.assert_array_equal(window_count(height, width, radius), counts)
    for length in range(1, height + 1):
        expected = [plane[k : k + length].sum(axis=0) for k in range(height - length + 1)]
        np.testing.assert_array_equal(run_sums(plane, length), expected)


def test_a_bright_centre_does_not_swallow_its_neighbours():
    plane = np.full((3, 3), 1e-6)
    plane[1, 1] = 1e15
    assert sums_around(plane, 1)[1, 1] == pytest.approx(8e-6, rel=1e-15)


def test_median_where_the_square_is_clipped():
    plane = np.arange(12.0).reshape(3, 4) ** 2
    everywhere = median_3x3(plane, *np.indices(plane.shape).reshape(2, -1)).reshape(plane.shape)
    for y, x in np.ndindex(plane.shape):
        assert everywhere[y, x] == np.median(plane[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"image": np.ones((2, 3, 4, 3))}, "image must have shape (h, w) or (h, w, c), got (2, 3, 4, 3)"),
        ({"image": np.full((2, 3), np.nan)}, "image must be finite"),
        ({"image": np.full((2, 3), 1e31)}, "image must stay within 1e+30 in magnitude"),
        ({"radius": 0}, "radius must be at least 1, got 0"),
        ({"radius": 1.5}, "radius must be a whole number, got 1.5"),
        ({"deviations": 0}, "deviations must be greater than 0"),
    ],
)
def test_bad_input_is_refused(arguments, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        despike(**{"image": np.ones((2, 3)), "radius": 1, "deviations": 2.0, **arguments})
