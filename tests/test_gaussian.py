"""The Gaussian filter against its formula, its symmetries, its limits and scipy."""

import re
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy import ndimage

from conftest import assert_close, noise
from mcdenoise.filters import gaussian

pytestmark = pytest.mark.ch02

ENGINES = ("numpy", "numba")
# Largest relative error allowed: rounding of a float64 sum, and of a float32 sum of up to a few hundred terms.
PRECISION = {"numpy": 1e-13, "numba": 2e-6}
close = partial(assert_close, PRECISION)


def test_impulse_response_is_the_closed_form(engine):
    sigma, radius = 1.7, 5
    image = np.zeros((15, 17))
    image[7, 8] = 3.0
    y, x = np.mgrid[:15, :17]
    in_window = (abs(y - 7) <= radius) & (abs(x - 8) <= radius)
    bell = np.exp(-((y - 7) ** 2 + (x - 8) ** 2) / (2 * sigma**2))

    def inside(position, size):
        return sum(np.exp(-(d**2) / (2 * sigma**2)) for d in range(-radius, radius + 1) if 0 <= position + d < size)

    norm = np.array([[inside(row, 15) * inside(column, 17) for column in range(17)] for row in range(15)])
    close(engine, gaussian(image, sigma_space=sigma, radius=radius, engine=engine), 3.0 * bell * in_window / norm)


def test_mass_far_from_the_border_is_kept(engine):
    image = np.zeros((40, 40))
    image[12:28, 12:28] = noise(16, 16)
    close(engine, gaussian(image, sigma_space=1.5, radius=5, engine=engine).sum(), image.sum())


def test_flat_image_stays_flat_up_to_the_corners(engine):
    flat = np.full((9, 14, 2), 0.37)
    close(engine, gaussian(flat, sigma_space=3.0, engine=engine), flat)


@pytest.mark.parametrize("turn", [np.flipud, np.fliplr, np.rot90, lambda image: image[::-1, ::-1]])
def test_commutes_with_mirror_and_turn(engine, turn):
    image = noise(11, 16, 3)
    filtered = gaussian(image, sigma_space=2.0, engine=engine)
    close(engine, gaussian(turn(image), sigma_space=2.0, engine=engine), turn(filtered))


def test_default_radius_is_three_sigma(engine):
    image = noise(20, 20)
    default = gaussian(image, sigma_space=1.5, engine=engine)
    np.testing.assert_array_equal(default, gaussian(image, sigma_space=1.5, radius=5, engine=engine))
    assert np.abs(default - gaussian(image, sigma_space=1.5, radius=4, engine=engine)).max() > 1e-4


def test_infinite_sigma_is_the_mean_of_the_window(engine):
    image = noise(8, 9)
    close(engine, gaussian(image, sigma_space=np.inf, radius=20, engine=engine), np.full((8, 9), image.mean()))


@pytest.mark.parametrize("sigma", [1e-3, 1e-30, 5e-324])
def test_tiny_sigma_returns_the_image(engine, sigma):
    image = noise(6, 7, 3)
    close(engine, gaussian(image, sigma_space=sigma, radius=2, engine=engine), image)


def test_radius_zero_is_identity(engine):
    image = noise(6, 7, 3).astype(np.float32)
    np.testing.assert_array_equal(gaussian(image, sigma_space=2.0, radius=0, engine=engine), image)


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (2, 3, 4), (5, 5, 1)])
def test_image_smaller_than_the_window(engine, shape):
    image = noise(*shape)
    wide = gaussian(image, sigma_space=4.0, radius=1000, engine=engine)
    close(engine, wide, gaussian(image, sigma_space=4.0, radius=9, engine=engine))
    assert wide.shape == shape


def test_agrees_with_scipy_by_normalised_convolution(engine):
    image = noise(31, 45)

    def scipy_sum(values):
        return ndimage.gaussian_filter(values, sigma=2.3, radius=7, mode="constant", cval=0.0)

    expected = scipy_sum(image) / scipy_sum(np.ones_like(image))
    close(engine, gaussian(image, sigma_space=2.3, radius=7, engine=engine), expected)
    interior = ndimage.gaussian_filter(image, sigma=2.3, truncate=7.0 / 2.3)[7:-7, 7:-7]
    close(engine, gaussian(image, sigma_space=2.3, radius=7, engine=engine)[7:-7, 7:-7], interior)


@settings(max_examples=60)
@given(
    image=array_shapes(min_dims=2, max_dims=3, max_side=12).flatmap(
        lambda shape: arrays(np.float32, shape, elements=st.floats(-1e6, 1e6, width=32))
    ),
    sigma_space=st.floats(0.01, 50.0),
    radius=st.integers(0, 15),
)
def test_engines_agree_and_stay_in_range(image, sigma_space, radius):
    before = image.copy()
    fast, plain = (gaussian(image, sigma_space=sigma_space, radius=radius, engine=engine) for engine in ENGINES)
    np.testing.assert_array_equal(image, before)
    tolerance = 2e-6 * np.abs(image).max()
    np.testing.assert_allclose(fast, plain, rtol=0, atol=tolerance)
    assert fast.dtype == plain.dtype == np.float32
    assert fast.shape == plain.shape == image.shape
    assert (fast >= image.min() - tolerance).all()
    assert (fast <= image.max() + tolerance).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_keeps_dtype_and_layout(engine, dtype):
    image = noise(8, 9, 3).astype(dtype)
    filtered = gaussian(image, sigma_space=1.0, engine=engine)
    assert filtered.dtype == dtype
    assert filtered.flags.c_contiguous
    assert not np.shares_memory(filtered, image)


def test_any_memory_layout_gives_the_same(engine):
    image = noise(16, 18, 3).astype(np.float32)
    view = image[::2, ::-3]
    assert not view.flags.c_contiguous
    view.flags.writeable = False
    expected = gaussian(view.copy(), sigma_space=2.0, engine=engine)
    np.testing.assert_array_equal(gaussian(view, sigma_space=2.0, engine=engine), expected)
    np.testing.assert_array_equal(gaussian(np.asfortranarray(view), sigma_space=2.0, engine=engine), expected)
    constant = np.broadcast_to(np.float32(0.5), (5, 6, 3))
    close(engine, gaussian(constant, sigma_space=2.0, engine=engine), constant)


def test_channels_do_not_mix(engine):
    image = noise(10, 11, 5)
    together = gaussian(image, sigma_space=2.0, engine=engine)
    for k in range(5):
        close(engine, gaussian(image[..., k], sigma_space=2.0, engine=engine), together[..., k])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"image": np.ones(4)}, "image must have shape (h, w) or (h, w, c), got (4,)"),
        ({"image": np.ones((0, 3))}, "image must hold at least one pixel"),
        ({"image": [["a"]]}, "image must be a real-valued numeric array"),
        ({"image": [[1.0, np.nan]]}, "image must be finite: 1 of 2 values"),
        ({"image": [[1.0, -2e30]]}, "image must stay within 1e+30 in magnitude (sums in float32 overflow beyond)"),
        ({"sigma_space": 0}, "sigma_space must be greater than 0"),
        ({"sigma_space": -1.0}, "sigma_space must be greater than 0"),
        ({"sigma_space": np.nan}, "sigma_space must be a number, got NaN"),
        ({"sigma_space": "wide"}, "sigma_space must be a number, got 'wide'"),
        ({"sigma_space": np.inf}, "radius must be given when sigma_space is infinite"),
        ({"radius": -1}, "radius must be at least 0, got -1"),
        ({"radius": 1.5}, "radius must be a whole number, got 1.5"),
        ({"engine": "cuda"}, "engine must be one of 'numba', 'numpy', got 'cuda'"),
    ],
)
def test_bad_input_is_refused(changes, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        gaussian(**({"image": np.ones((3, 3)), "sigma_space": 1.0} | changes))
