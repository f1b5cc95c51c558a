"""A toy exercise, as an author writes one: a Gaussian blur, and one predicted number. Tests copy it to test_ch02.py."""

import numpy as np

from mcdenoise.classroom import assert_matches, graded, picture


def _blurred(image, sigma_space, radius):
    total, norm = np.zeros_like(image), np.zeros(image.shape[:2])
    height, width = norm.shape
    for dy in range(-radius, radius + 1):
        for dx in range(-radius, radius + 1):
            weight = np.exp(-(dy**2 + dx**2) / (2 * sigma_space**2))
            here = slice(max(0, -dy), height - max(0, dy)), slice(max(0, -dx), width - max(0, dx))
            there = slice(max(0, dy), height + min(0, dy)), slice(max(0, dx), width + min(0, dx))
            total[here] += weight * image[there]
            norm[here] += weight
    return total / norm[..., np.newaxis]


def _impulse():
    image = np.zeros((19, 19, 1))
    image[9, 9] = 1.0
    return image


def _scene():
    return np.random.default_rng(4).gamma(2.0, 0.3, (14, 17, 3))


@graded("blur", points=1)
def test_an_impulse_gives_the_bell(impl):
    "The response to an impulse is the bell itself, centred."
    assert_matches(impl(_impulse(), 1.5, 4), _blurred(_impulse(), 1.5, 4), "the response to an impulse")


@graded("blur", points=1)
def test_flat_stays_flat(impl):
    "A flat image stays as it is."
    assert_matches(impl(np.full((12, 13, 2), 0.7), 1.0, 3), np.full((12, 13, 2), 0.7), "a flat image")


@graded("blur", points=2)
def test_any_image(impl):
    "Every pixel is the weighted mean of its window."
    assert_matches(impl(_scene(), 1.0, 3), _blurred(_scene(), 1.0, 3), "a random image")


@graded("blur", points=2, hidden=True)
def test_a_wide_window(impl):
    "The window may reach beyond the image on all sides."
    assert_matches(impl(_impulse(), 2.0, 12), _blurred(_impulse(), 2.0, 12), "a wide window")


@graded("blur_sums", points=1)
def test_sums_apart(impl):
    "The sums of w c and of w come apart."
    total, norm = impl(_impulse(), 1.5, 4)
    assert_matches(total / norm[..., np.newaxis], _blurred(_impulse(), 1.5, 4), "total / norm")


@graded("peak", points=1)
def test_peak(impl):
    "The centre of the bell keeps about 1 / (2 pi sigma^2) of the impulse."
    assert abs(impl - 0.0707) < 0.002, f"the peak is near 0.0707, you said {impl:.4f}"


@picture("blur")
def picture_blur(impl):
    return impl(_scene(), 1.0, 3), _blurred(_scene(), 1.0, 3)
