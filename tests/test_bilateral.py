"""The bilateral filter against its formula, its limits, its symmetries and OpenCV."""

import re
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from conftest import assert_close, noise
from mcdenoise.filters import bilateral, gaussian

pytestmark = pytest.mark.ch03

ENGINES = ("numpy", "numba")
# Largest relative error allowed: rounding of a float64 sum, and of a float32 sum of up to a few hundred terms.
PRECISION = {"numpy": 1e-12, "numba": 4e-6}
close = partial(assert_close, PRECISION)


def test_impulse_response_is_the_closed_form(engine):
    """An impulse of height a is strange to all others: they see it with exp(-a^2 / 2 s^2) of the spatial weight."""
    sigma, sigma_radiance, radius, height = 1.7, 0.6, 4, 0.8
    image = np.zeros((13, 13, 1))
    image[6, 6] = height
    y, x = np.mgrid[-6:7, -6:7]
    near = np.exp(-(x**2 + y**2) / (2 * sigma**2)) * ((abs(x) <= radius) & (abs(y) <= radius))
    g = np.exp(-(height**2) / (2 * sigma_radiance**2))
    line = [
        sum(np.exp(-(d**2) / (2 * sigma**2)) for d in range(-radius, radius + 1) if 0 <= p + d < 13) for p in range(13)
    ]
    norm = np.outer(line, line)
    expected = height * near * g / (norm - near + near * g)
    expected[6, 6] = height / (1 + g * (norm[6, 6] - 1))
    filtered = bilateral(image, sigma_space=sigma, sigma_radiance=sigma_radiance, radius=radius, engine=engine)
    close(engine, filtered[..., 0], expected)


def test_distance_is_euclidean_over_channels(engine):
    """Two pixels, (0, 0, 0) and (3, 0, 4), are 5 apart; an L1 distance would say 7, one per channel would differ."""
    image = np.array([[[0.0, 0.0, 0.0], [3.0, 0.0, 4.0]]])
    g = np.exp(-25.0 / (2 * 2.5**2))
    expected = np.array([[image[0, 1] * g, image[0, 1]]]) / (1 + g)
    filtered = bilateral(image, sigma_space=np.inf, sigma_radiance=2.5, radius=1, engine=engine)
    close(engine, filtered, expected)


def test_infinite_sigma_radiance_is_the_gaussian(engine):
    image = noise(19, 23, 3)
    expected = gaussian(image, sigma_space=2.0, engine=engine)
    close(engine, bilateral(image, sigma_space=2.0, sigma_radiance=np.inf, engine=engine), expected)
    close(engine, bilateral(image, sigma_space=2.0, sigma_radiance=1e9, engine=engine), expected)


def test_approaches_the_gaussian_as_sigma_squared(engine):
    """The first term left out is proportional to 1 / sigma_radiance^2: twice the sigma, a quarter of the difference."""
    image = noise(19, 23, 3)
    limit = gaussian(image, sigma_space=2.0, engine="numpy")
    gaps = [
        np.abs(bilateral(image, sigma_space=2.0, sigma_radiance=sigma, engine=engine) - limit).max()
        for sigma in (8, 16)
    ]
    assert gaps[0] / gaps[1] == pytest.approx(4, rel=0.05)


@pytest.mark.parametrize("sigma_radiance", [1e-6, 1e-30, 5e-324])
def test_small_sigma_radiance_returns_the_image(engine, sigma_radiance):
    image = noise(9, 11, 3).astype(np.float32)
    filtered = bilateral(image, sigma_space=2.0, sigma_radiance=sigma_radiance, engine=engine)
    np.testing.assert_array_equal(filtered, image)


@pytest.mark.parametrize("largest", [1e6, 1e30])
@pytest.mark.parametrize("sigma_radiance", [1e-6, 1e-30, 1e30])
def test_extreme_radiance_stays_finite_and_in_range(engine, largest, sigma_radiance):
    image = noise(9, 11, 3).astype(np.float32)
    image[4, 5] = largest
    image[0, 0] = -largest
    filtered = bilateral(image, sigma_space=2.0, sigma_radiance=sigma_radiance, engine=engine)
    assert np.isfinite(filtered).all()
    assert np.abs(filtered).max() <= largest
    if sigma_radiance < 1e-3:
        np.testing.assert_array_equal(filtered, image)


def test_edge_survives_where_the_gaussian_blurs_it(engine):
    image = np.where(np.arange(20) < 10, 1.0, 5.0) + 0.1 * noise(12, 20)
    kept = bilateral(image, sigma_space=3.0, sigma_radiance=0.5, engine=engine)
    assert np.abs(kept - np.where(np.arange(20) < 10, 1.05, 5.05)).max() < 0.05
    assert np.abs(gaussian(image, sigma_space=3.0, engine=engine)[:, 9] - 1.05).min() > 1.0


def test_flat_image_stays_flat(engine):
    flat = np.full((9, 14, 2), 0.37)
    close(engine, bilateral(flat, sigma_space=3.0, sigma_radiance=0.1, engine=engine), flat)


@pytest.mark.parametrize("turn", [np.flipud, np.fliplr, np.rot90, lambda image: image[::-1, ::-1]])
def test_commutes_with_mirror_and_turn(engine, turn):
    image = noise(11, 37, 3)
    settings = {"sigma_space": 2.0, "sigma_radiance": 0.4, "engine": engine}
    close(engine, bilateral(turn(image), **settings), turn(bilateral(image, **settings)))


def test_radius_zero_is_identity(engine):
    image = noise(6, 7, 3).astype(np.float32)
    filtered = bilateral(image, sigma_space=2.0, sigma_radiance=1.0, radius=0, engine=engine)
    np.testing.assert_array_equal(filtered, image)


def test_default_radius_is_three_sigma(engine):
    image = noise(20, 20)
    default = bilateral(image, sigma_space=1.5, sigma_radiance=0.5, engine=engine)
    given = bilateral(image, sigma_space=1.5, sigma_radiance=0.5, radius=5, engine=engine)
    np.testing.assert_array_equal(default, given)


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (2, 3, 4), (5, 5, 1), (40, 70, 2)])
def test_engines_agree_for_every_shape(shape):
    """Also where the window is larger than the image, and where it spans several blocks of rows."""
    image = noise(*shape)
    fast, plain = (
        bilateral(image, sigma_space=9.0, sigma_radiance=0.5, radius=27, engine=engine) for engine in ENGINES
    )
    close("numba", fast, plain)


@settings(max_examples=60)
@given(
    image=array_shapes(min_dims=2, max_dims=3, max_side=12).flatmap(
        lambda shape: arrays(np.float32, shape, elements=st.floats(-1e6, 1e6, width=32))
    ),
    sigma_space=st.floats(0.01, 50.0),
    relative_sigma=st.floats(0.05, 100.0),
    radius=st.integers(0, 15),
)
def test_engines_agree_and_stay_in_range(image, sigma_space, relative_sigma, radius):
    largest = np.abs(image).max()
    before = image.copy()
    fast, plain = (
        bilateral(
            image,
            sigma_space=sigma_space,
            sigma_radiance=relative_sigma * max(largest, 1e-3),
            radius=radius,
            engine=engine,
        )
        for engine in ENGINES
    )
    np.testing.assert_array_equal(image, before)
    # The guide c / sigma is rounded to float32: an error of up to 2^-24 / 0.05 in a difference of up to 5 that counts.
    tolerance = 2e-5 * largest
    np.testing.assert_allclose(fast, plain, rtol=0, atol=tolerance)
    assert fast.dtype == plain.dtype == np.float32
    assert fast.shape == plain.shape == image.shape
    assert (fast >= image.min() - 1e-6 * largest).all()
    assert (fast <= image.max() + 1e-6 * largest).all()


def test_opencv_agrees_on_one_channel():
    """OpenCV leaves out the window's corners and reads the radiance weight from a table, linear between 4096 places.

    What lies outside its disc has a share of less than 1e-4 of any pixel's norm, and moves the result by no more than
    that share of the image's range. The table's error is at most (step / sigma_radiance)^2 / 8, below 1e-7.
    """
    cv2 = pytest.importorskip("cv2")
    image = noise(40, 50).astype(np.float32)
    radius, sigma, sigma_radiance = 8, 1.6, 0.5
    theirs = cv2.bilateralFilter(image, 2 * radius + 1, sigma_radiance, sigma)
    ours = bilateral(image, sigma_space=sigma, sigma_radiance=sigma_radiance, radius=radius)
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    near = np.exp(-(x**2 + y**2) / (2 * sigma**2))
    least_norm = near.sum() * np.exp(-1 / (2 * sigma_radiance**2))
    corners = near[x**2 + y**2 > radius**2].sum() / least_norm
    assert corners < 1e-4
    inside = np.s_[radius:-radius, radius:-radius]
    np.testing.assert_allclose(ours[inside], theirs[inside], rtol=0, atol=corners + 1e-6)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_keeps_dtype_and_layout(engine, dtype):
    image = noise(8, 9, 3).astype(dtype)
    filtered = bilateral(image, sigma_space=1.0, sigma_radiance=1.0, engine=engine)
    assert filtered.dtype == dtype
    assert filtered.flags.c_contiguous
    assert not np.shares_memory(filtered, image)


def test_any_memory_layout_gives_the_same(engine):
    image = noise(16, 18, 3).astype(np.float32)
    view = image[::2, ::-3]
    view.flags.writeable = False
    settings = {"sigma_space": 2.0, "sigma_radiance": 0.4, "engine": engine}
    expected = bilateral(view.copy(), **settings)
    np.testing.assert_array_equal(bilateral(view, **settings), expected)
    np.testing.assert_array_equal(bilateral(np.asfortranarray(view), **settings), expected)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"image": np.ones((2, 2, 2, 2))}, "image must have shape (h, w) or (h, w, c), got (2, 2, 2, 2)"),
        ({"image": [[np.inf]]}, "image must be finite"),
        ({"image": [[1e31]]}, "image must stay within 1e+30 in magnitude"),
        ({"sigma_space": 0.0}, "sigma_space must be greater than 0"),
        ({"sigma_radiance": 0.0}, "sigma_radiance must be greater than 0"),
        ({"sigma_radiance": -np.inf}, "sigma_radiance must be greater than 0"),
        ({"sigma_radiance": None}, "sigma_radiance must be a number, got None"),
        ({"sigma_space": np.inf}, "radius must be given when sigma_space is infinite"),
        ({"radius": True}, "radius must be a whole number, got True"),
        ({"engine": None}, "engine must be one of 'numba', 'numpy', got None"),
    ],
)
def test_bad_input_is_refused(changes, message):
    good = {"image": np.ones((3, 3)), "sigma_space": 1.0, "sigma_radiance": 1.0}
    with pytest.raises(ValueError, match=re.escape(message)):
        bilateral(**(good | changes))
