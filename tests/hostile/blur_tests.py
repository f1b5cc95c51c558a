"""The exercise of the hostile set: a Gaussian blur of a grey image with 4 public and 2 hidden tests, and one prediction."""

import numpy as np

from mcdenoise.classroom import assert_matches, graded

SIZE = (9, 7)


def _blurred(image, sigma_space, radius):
    total, norm = np.zeros(image.shape), np.zeros(image.shape)
    rows, columns = np.indices(image.shape)
    for y, x in np.ndindex(image.shape):
        near = (abs(rows - y) <= radius) & (abs(columns - x) <= radius)
        weight = near * np.exp(-((rows - y) ** 2 + (columns - x) ** 2) / (2 * sigma_space**2))
        total[y, x], norm[y, x] = (weight * image).sum(), weight.sum()
    return total / norm


def _image(seed, size=SIZE):
    return np.random.default_rng(seed).random(size)


@graded("blur", points=1)
def test_an_impulse_gives_the_bell(impl):
    "The response to an impulse is the bell itself, centred."
    image = np.zeros(SIZE)
    image[4, 3] = 1
    assert_matches(impl(image, 1.0, 2), _blurred(image, 1.0, 2), "response to an impulse")


@graded("blur", points=1)
def test_a_flat_image_stays_as_it_is(impl):
    "A flat image stays as it is, up to its borders."
    assert_matches(impl(np.full(SIZE, 0.75), 1.5, 2), np.full(SIZE, 0.75), "blur of a flat image")


@graded("blur", points=1)
def test_noise_in_the_middle(impl):
    "Noise is averaged, away from the borders."
    image = _image(1, (12, 11))
    assert_matches(
        np.asarray(impl(image, 1.0, 2))[2:-2, 2:-2], _blurred(image, 1.0, 2)[2:-2, 2:-2], "the middle of blurred noise"
    )


@graded("blur", points=1)
def test_the_input_stays(impl):
    "The input is the same afterwards, and the result has its shape."
    image = _image(2)
    assert np.shape(impl(image, 2.0, 1)) == image.shape, f"shape {np.shape(impl(image, 2.0, 1))}, needed {image.shape}."


@graded("blur", points=2, hidden=True)
def test_noise_at_the_borders(impl):
    "At a border the window is cut off, and its weights still sum to one."
    assert_matches(impl(_image(3), 1.3, 2), _blurred(_image(3), 1.3, 2), "blurred noise with borders")


@graded("blur", points=1, hidden=True)
def test_a_wide_bell_is_the_mean(impl):
    "A very wide bell gives the mean of the window."
    image = _image(4, (5, 6))
    assert_matches(impl(image, 1e6, 9), np.full((5, 6), image.mean()), "blur with a very wide bell", rtol=1e-5)


@graded("predicted_peak", points=1)
def test_the_peak_is_predicted(impl):
    "Height of the bell in the middle for sigma_space 1 and radius 1."
    assert_matches(impl, _blurred(np.eye(3)[1][:, None] * np.eye(3)[1], 1.0, 1)[1, 1], "your prediction", rtol=0.02)
