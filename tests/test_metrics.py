"""Metrics against closed forms and scikit-image."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from skimage.metrics import mean_squared_error, peak_signal_noise_ratio

from mcdenoise.metrics import mse, psnr, relmse, relmse_map, squared_error_map, ssim

pytestmark = pytest.mark.ch01
IMAGES = arrays(np.float32, (8, 9, 3), elements=st.floats(0, 100, width=32))


def test_relmse_by_hand():
    image, reference = np.array([[[3.0, 0.0]]]), np.array([[[1.0, 0.0]]])
    assert relmse(image, reference) == pytest.approx((4 / 1.01 + 0) / 2)
    assert relmse(image, reference, epsilon=1.0) == pytest.approx(1)
    assert relmse([[0.1]], [[0.0]]) == pytest.approx(1)


def test_relmse_of_relative_noise_does_not_depend_on_exposure(rng):
    reference = np.full((64, 64), 50.0)
    image = reference * (1 + 0.1 * rng.normal(size=reference.shape))
    assert relmse(image, reference) == pytest.approx(relmse(20 * image, 20 * reference), rel=1e-5)


def test_expected_relmse_of_noise_is_its_relative_variance(rng):
    reference, sigma = np.full((200, 200), 2.0), 0.3
    image = reference + sigma * rng.normal(size=reference.shape)
    expected = sigma**2 / (2.0**2 + 0.01)
    assert abs(relmse(image, reference) - expected) < 4 * expected * np.sqrt(2 / reference.size)


@given(IMAGES, IMAGES)
def test_maps_average_to_the_metrics_and_equal_images_have_none(image, reference):
    assert relmse(image, reference) == pytest.approx(relmse_map(image, reference).mean())
    assert mse(image, reference) == pytest.approx(squared_error_map(image, reference).mean())
    assert mse(image, reference) == pytest.approx(mean_squared_error(image, reference), rel=1e-5)
    assert relmse(image, image) == mse(image, image) == 0
    assert relmse_map(image, reference).shape == image.shape


def test_psnr_and_ssim_agree_with_scikit_image(rng):
    reference = rng.random((16, 17, 3))
    image = reference + 0.05 * rng.normal(size=reference.shape)
    assert psnr(image, reference) == pytest.approx(peak_signal_noise_ratio(reference, image, data_range=1.0))
    assert psnr(image, reference, peak=2.0) == pytest.approx(psnr(image, reference) + 20 * np.log10(2))
    assert 0.9 < ssim(image, reference) < 1
    assert ssim(image[..., 0], reference[..., 0]) < 1


def test_equal_images_have_infinite_psnr_and_ssim_one():
    image = np.eye(9)
    assert psnr(image, image) == np.inf
    assert ssim(image, image) == 1


@pytest.mark.parametrize("metric", [relmse, relmse_map, mse, squared_error_map, psnr, ssim])
@pytest.mark.parametrize(
    ("image", "reference", "message"),
    [
        (np.ones((8, 8)), np.ones((8, 9)), r"same shape, got \(8, 8\) and \(8, 9\)"),
        (np.ones((8, 8, 3)), np.ones((8, 8)), "same shape"),
        (np.full((8, 8), np.nan), np.ones((8, 8)), "image must be finite"),
        (np.ones((8, 8)), np.full((8, 8), np.inf), "reference must be finite"),
        (np.ones(8), np.ones(8), r"\(h, w\) or \(h, w, c\), got \(8,\).*mcd.pixel_mean"),
        (np.ones((0, 8)), np.ones((0, 8)), "at least one pixel"),
    ],
)
def test_bad_images_are_refused(metric, image, reference, message):
    with pytest.raises(ValueError, match=message):
        metric(image, reference)


@pytest.mark.parametrize("value", [0, -1, np.nan, "a", True, None])
def test_bad_numbers_are_refused(value):
    image = np.ones((8, 8))
    with pytest.raises(ValueError, match="epsilon must be"):
        relmse(image, image, epsilon=value)
    with pytest.raises(ValueError, match="peak must be"):
        psnr(image, image, peak=value)
    with pytest.raises(ValueError, match="peak must be"):
        ssim(image, image, peak=value)


def test_ssim_needs_room_for_its_window():
    with pytest.raises(ValueError, match="at least 7 x 7 pixels, got 6 x 9"):
        ssim(np.ones((6, 9)), np.ones((6, 9)))
