"""NL-means against its formula, its limits, its symmetries; what variances do; what it refuses."""

import re
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import assert_close, noise
from mcdenoise.filters import bilateral, gaussian, nlm, safe_albedo
from mcdenoise.filters.nlm import LIMIT, patch_distance
from mcdenoise.filters.window import window_offsets

pytestmark = pytest.mark.ch04

ENGINES = ("numpy", "numba")
# Largest relative error: rounding of a float64 sum, and of float32 sums of up to a few hundred terms.
PRECISION = {"numpy": 1e-12, "numba": 6e-6}
close = partial(assert_close, PRECISION)


def distance_by_hand(guide, variance, p, q, radius, k, cancellation):
    """d^2 of two pixels, position by position of their patches."""
    height, width, channels = guide.shape
    parts = []
    for dy in range(-radius, radius + 1):
        for dx in range(-radius, radius + 1):
            (a, b), (c, d) = (p[0] + dy, p[1] + dx), (q[0] + dy, q[1] + dx)
            if not all(0 <= y < height and 0 <= x < width for y, x in ((a, b), (c, d))):
                continue
            own, other = variance[a, b].mean(), variance[c, d].mean()
            square = sum((guide[a, b, i] - guide[c, d, i]) ** 2 for i in range(channels)) / channels
            parts.append((square - cancellation * (own + min(own, other))) / (k**2 * (own + other)))
    return max(0.0, sum(parts) / len(parts))


@pytest.mark.parametrize(("patch_radius", "cancellation"), [(0, 1.0), (1, 1.0), (2, 0.3), (5, 0.0)])
def test_formula_term_by_term(engine, patch_radius, cancellation):
    """Pixels in the middle and at the borders: every neighbour's weight from patches that are compared by hand."""
    image, guide = noise(12, 15, 2), noise(12, 15, 3, seed=4)
    variance, search, k = 0.1 * noise(12, 15, 3, seed=5) + 0.01, 4, 0.8
    filtered = nlm(
        image,
        variance,
        guide=guide,
        search_radius=search,
        patch_radius=patch_radius,
        k=k,
        cancellation=cancellation,
        engine=engine,
    )
    for p in ((0, 0), (6, 7), (11, 2), (3, 14)):
        total, norm = 0.0, 0.0
        for y in range(max(0, p[0] - search), min(12, p[0] + search + 1)):
            for x in range(max(0, p[1] - search), min(15, p[1] + search + 1)):
                weight = np.exp(-distance_by_hand(guide, variance, p, (y, x), patch_radius, k, cancellation))
                total, norm = total + weight * image[y, x], norm + weight
        close(engine, filtered[p], total / norm)


@pytest.mark.parametrize("weight_radius", [1, 3])
def test_weights_are_averaged_over_pixels_of_equal_offset(engine, weight_radius):
    image, variance, p, search = noise(9, 11, 1), 0.05 * noise(9, 11, 1, seed=5) + 0.01, (2, 8), 3
    total, norm = 0.0, 0.0
    for dy in range(-search, search + 1):
        for dx in range(-search, search + 1):
            weights = []
            for y in range(p[0] - weight_radius, p[0] + weight_radius + 1):
                for x in range(p[1] - weight_radius, p[1] + weight_radius + 1):
                    if all(0 <= a < 9 and 0 <= b < 11 for a, b in ((y, x), (y + dy, x + dx))):
                        distance = distance_by_hand(image, variance, (y, x), (y + dy, x + dx), 1, 0.7, 1.0)
                        weights.append(np.exp(-distance))
            if 0 <= p[0] + dy < 9 and 0 <= p[1] + dx < 11:
                total, norm = total + np.mean(weights) * image[p[0] + dy, p[1] + dx], norm + np.mean(weights)
    dials = {"search_radius": search, "patch_radius": 1, "k": 0.7, "weight_radius": weight_radius}
    close(engine, nlm(image, variance, engine=engine, **dials)[p], total / norm)


def test_infinite_k_is_the_mean_of_the_window(engine):
    image = noise(13, 18, 3)
    expected = gaussian(image, sigma_space=np.inf, radius=4, engine=engine)
    for k in (np.inf, 1e9, 1e300):
        close(engine, nlm(image, 0.1, search_radius=4, k=k, engine=engine), expected)


def test_pixels_without_noise_give_the_bilateral_with_a_box(engine):
    """patch_radius 0, variance -> 0 at constant k^2 variance: sigma_radiance = k sqrt(c variance)."""
    image, variance, sigma = noise(13, 18, 3), 1e-9, 0.4
    expected = bilateral(image, sigma_space=np.inf, sigma_radiance=sigma, radius=4, engine=engine)
    k = sigma / np.sqrt(3 * variance)
    filtered = nlm(image, variance, search_radius=4, patch_radius=0, k=k, engine=engine)
    np.testing.assert_allclose(filtered, expected, rtol=1e-6)
    exact = nlm(image, 1.0, search_radius=4, patch_radius=0, k=sigma / np.sqrt(3), cancellation=0.0, engine=engine)
    close(engine, exact, expected)


def test_without_search_window_the_image_comes_back(engine):
    image = noise(6, 7, 3).astype(np.float32)
    np.testing.assert_array_equal(nlm(image, 0.1, search_radius=0, engine=engine), image)


def test_with_zero_variance_only_equal_values_are_alike(engine):
    """0 / 0 is defined: equal is alike, different is not."""
    image = noise(13, 18, 3).astype(np.float32)
    np.testing.assert_array_equal(nlm(image, 0.0, search_radius=4, patch_radius=0, engine=engine), image)
    step = np.where(np.arange(18) < 9, 1.0, 2.0) * np.ones((13, 1))
    np.testing.assert_array_equal(nlm(step, 0.0, search_radius=4, patch_radius=0, engine=engine), step)
    part = np.where(np.arange(18) < 9, 0.0, 1.0) * np.ones((13, 1))
    filtered = nlm(image, part, search_radius=4, patch_radius=0, engine=engine)
    np.testing.assert_array_equal(filtered[:, :5], image[:, :5])
    assert np.abs(filtered[:, 10:] - image[:, 10:]).max() > 0.1


def test_cancellation_takes_off_what_two_noisy_views_differ_by():
    """Independent noise of one variance: without cancellation d^2 is 1 / k^2 on average, with it 0 before the cut-off."""
    rng = np.random.default_rng(20261125)
    size, variance, k = 200, 0.3, 0.7
    guide = rng.normal(scale=np.sqrt(variance), size=(size, size, 1))
    here, there = np.s_[:, :100], np.s_[:, 100:]
    distance = patch_distance(guide, np.full((size, size), variance), here, there, 0, k, cancellation=0.0)
    deviation = np.sqrt(2) / k**2 / np.sqrt(distance.size)  # chi squared with one degree of freedom has variance 2
    assert abs(distance.mean() - 1 / k**2) < 4 * deviation
    large = patch_distance(guide, np.full((size, size), variance), here, there, 40, k, cancellation=1.0)
    assert large[50, 50] < 0.05 / k**2


@pytest.mark.parametrize("height", [10.0, 1e3, 1e6])
def test_a_firefly_is_removed_and_does_not_spread(engine, height):
    """Variances h^2 at the firefly: it accepts its neighbours (d^2 <= 0), they do not accept it (d^2 = 1 / k^2 nearly)."""
    image, variance = np.ones((15, 15)), np.full((15, 15), 1e-4)
    image[7, 7], variance[7, 7] = 1 + height, height**2
    filtered = nlm(image, variance, search_radius=2, patch_radius=0, k=0.3, engine=engine)
    assert filtered[7, 7] == pytest.approx(1 + height / 25, rel=1e-4)
    weight = np.exp(-1 / 0.3**2)
    others = np.abs(np.delete(filtered.ravel(), 7 * 15 + 7) - 1)
    assert others.max() == pytest.approx(weight * height / (24 + weight), rel=1e-2)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_commutes_with_scale_and_shift(engine, scale):
    image, variance = noise(13, 18, 3), 0.05 * noise(13, 18, seed=5)
    dials = {"search_radius": 4, "patch_radius": 2, "engine": engine}
    expected = nlm(image, variance, **dials)
    close(engine, nlm(scale * image, scale**2 * variance, **dials), scale * expected)
    np.testing.assert_allclose(nlm(image + 1, variance, **dials), expected + 1, rtol=1e-5)


@pytest.mark.parametrize("turn", [np.flipud, np.fliplr, np.rot90, lambda image: image[::-1, ::-1]])
def test_commutes_with_mirror_and_turn(engine, turn):
    image, variance = noise(13, 18, 3), 0.05 * noise(13, 18, seed=5)
    dials = {"search_radius": 4, "patch_radius": 2, "weight_radius": 1, "engine": engine}
    close(engine, nlm(turn(image), turn(variance), **dials), turn(nlm(image, variance, **dials)))


@settings(max_examples=40)
@given(
    height=st.integers(1, 20),
    width=st.integers(1, 40),
    channels=st.sampled_from([None, 1, 3, 4]),
    scale=st.floats(1e-3, 1e6),
    k=st.floats(0.2, 10.0),
    radii=st.tuples(st.integers(0, 9), st.integers(0, 9), st.integers(0, 3)),
    cancellation=st.floats(0, 1),
    seed=st.integers(0, 99),
)
def test_engines_agree_and_stay_in_range(height, width, channels, scale, k, radii, cancellation, seed):
    rng = np.random.default_rng(seed)
    shape = (height, width) if channels is None else (height, width, channels)
    image = (scale * rng.normal(size=shape)).astype(np.float32)
    variance = (scale**2 * rng.random(size=shape)).astype(np.float32)
    before = image.copy(), variance.copy()
    dials = dict(zip(("search_radius", "patch_radius", "weight_radius"), radii, strict=True))
    fast, plain = (nlm(image, variance, k=k, cancellation=cancellation, engine=engine, **dials) for engine in ENGINES)
    np.testing.assert_array_equal(image, before[0])
    np.testing.assert_array_equal(variance, before[1])
    largest = np.abs(image).max()
    np.testing.assert_allclose(fast, plain, rtol=0, atol=2e-5 * largest)
    assert fast.dtype == plain.dtype == np.float32
    assert fast.shape == plain.shape == image.shape
    assert (fast >= image.min() - 1e-6 * largest).all()
    assert (fast <= image.max() + 1e-6 * largest).all()


@pytest.mark.parametrize("patch_radius", [0, 1, 3])
def test_equal_pixels_without_noise_have_the_distance_zero(engine, patch_radius):
    """As in a black shadow: 0 / 0 is 0, no gain that pays for a difference elsewhere in the patch."""
    image, variance = np.zeros((11, 12)), np.zeros((11, 12))
    image[:, 9:], variance[:, 9:] = noise(11, 3), 0.01
    filtered = nlm(image, variance, search_radius=2, patch_radius=patch_radius, engine=engine)
    for p in ((5, 8), (5, 7), (0, 9), (10, 10)):
        total, norm = 0.0, 0.0
        for y in range(max(0, p[0] - 2), min(11, p[0] + 3)):
            for x in range(p[1] - 2, min(12, p[1] + 3)):
                parts = []
                for dy, dx in np.ndindex(2 * patch_radius + 1, 2 * patch_radius + 1):
                    a = p[0] + dy - patch_radius, p[1] + dx - patch_radius
                    b = y + dy - patch_radius, x + dx - patch_radius
                    if all(0 <= one[0] < 11 and 0 <= one[1] < 12 for one in (a, b)):
                        excess = (image[a] - image[b]) ** 2 - variance[a] - min(variance[a], variance[b])
                        scale = 0.6**2 * (variance[a] + variance[b])
                        parts.append(excess / scale if scale else 0.0)
                weight = np.exp(-max(0, np.mean(np.clip(parts, -LIMIT, LIMIT))))
                total, norm = total + weight * image[y, x], norm + weight
        close(engine, filtered[p], total / norm)


@settings(max_examples=30)
@given(
    patch=st.integers(0, 3),
    steps=st.integers(1, 4),
    share=st.floats(0, 1),
    seed=st.integers(0, 99),
)
def test_engines_agree_where_there_is_no_noise(patch, steps, share, seed):
    """Values of a few steps, so that many pixels are equal; a share of them without variance."""
    rng = np.random.default_rng(seed)
    image = rng.integers(0, steps + 1, (15, 20, 3)) / steps
    variance = np.where(rng.random((15, 20)) < share, 0.0, 0.02 * rng.random((15, 20)))
    fast, plain = (nlm(image, variance, search_radius=3, patch_radius=patch, engine=engine) for engine in ENGINES)
    np.testing.assert_allclose(fast, plain, rtol=0, atol=2e-5)


@pytest.mark.parametrize("largest", [1.0, 1e30])
@pytest.mark.parametrize("variance", [0.0, 1e-30, 1e30, "mixed"])
@pytest.mark.parametrize("k", [1e-30, 1e-3, 1e3, 1e30])
def test_extremes_stay_finite(engine, largest, variance, k):
    image = (largest * (noise(9, 11, 3) - 0.5)).astype(np.float32)
    variance = np.where(noise(9, 11) < 0.5, 0.0, 1e30) if variance == "mixed" else variance
    filtered = nlm(image, variance, search_radius=3, patch_radius=1, k=k, engine=engine)
    assert np.isfinite(filtered).all()
    assert np.abs(filtered).max() <= np.abs(image).max() * (1 + 1e-6)


def test_one_number_is_a_variance_everywhere(engine):
    image = noise(9, 11, 3)
    dials = {"search_radius": 3, "patch_radius": 1, "engine": engine}
    expected = nlm(image, np.full((9, 11, 3), 0.04), **dials)
    for variance in (0.04, np.full((9, 11), 0.04), np.full((9, 11, 1), 0.04)):
        close(engine, nlm(image, variance, **dials), expected)


def test_albedo_leaves_before_and_comes_back_after(engine):
    image, albedo = noise(9, 11, 3), noise(9, 11, 3, seed=4)
    albedo[0, :3] = 0.0
    dials = {"search_radius": 3, "patch_radius": 1, "engine": engine}
    safe = safe_albedo(albedo, image)
    expected = safe * nlm(image / safe, 0.02 / safe**2, **dials)
    close(engine, nlm(image, 0.02, albedo=albedo, **dials), expected)


def test_keeps_dtype_and_takes_any_memory_layout(engine):
    wide = noise(26, 36, 3).astype(np.float32)
    image = wide[::2, ::-2]
    expected = nlm(image.copy(), 0.05, search_radius=3, engine=engine)
    np.testing.assert_array_equal(nlm(image, 0.05, search_radius=3, engine=engine), expected)
    assert expected.dtype == np.float32
    assert nlm(image.astype(np.float64), 0.05, search_radius=3, engine=engine).dtype == np.float64


def test_one_pixel_cannot_outweigh_a_patch_by_overflow():
    """The part of one pixel is limited; that of a whole patch is still 0 in weight."""
    guide = np.zeros((1, 2, 1))
    guide[0, 1] = 1e20
    (here, there) = next((h, t) for dy, dx, h, t in window_offsets(1, 2, 1) if dx == 1)
    assert patch_distance(guide, np.full((1, 2), 1e-10), here, there, 0, 1.0)[0, 0] == LIMIT


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"image": np.ones(4)}, "image must have shape (h, w) or (h, w, c), got (4,)"),
        ({"image": np.full((3, 4), np.nan)}, "image must be finite"),
        ({"image": np.full((3, 4), 2e30)}, "image must stay within 1e+30"),
        ({"variance": -0.1}, "variance must not be negative anywhere, got -0.1"),
        ({"variance": np.full((3, 4), np.inf)}, "variance must be finite"),
        ({"variance": float("nan")}, "variance must be finite"),
        ({"variance": np.ones((4, 3))}, "variance must have the height and width of image"),
        ({"variance": np.ones((3, 4, 2))}, "variance must have shape (h, w) or that of what it belongs to"),
        ({"variance": None}, "variance must be a number or an array (h, w) or (h, w, c), got None"),
        ({"variance": "noisy"}, "variance must be a number or an array (h, w) or (h, w, c), got 'noisy'"),
        ({"guide": np.ones((4, 4))}, "guide must have the height and width of image"),
        ({"guide": np.full((3, 4), np.nan)}, "guide must be finite"),
        ({"guide": np.ones((3, 4)), "albedo": np.ones((3, 4))}, "nlm takes an albedo or a guide, not both"),
        ({"albedo": np.full((3, 4), 1.5)}, "albedo must lie in [0, 1], got 1.5 to 1.5"),
        ({"search_radius": -1}, "search_radius must be at least 0"),
        ({"search_radius": 1.5}, "search_radius must be a whole number"),
        ({"patch_radius": True}, "patch_radius must be a whole number"),
        ({"weight_radius": -1}, "weight_radius must be at least 0"),
        ({"k": 0}, "k must be greater than 0"),
        ({"cancellation": 1.5}, "cancellation must lie in [0, 1], got 1.5"),
        ({"engine": "fast"}, "engine must be one of 'numba', 'numpy', got 'fast'"),
    ],
)
def test_bad_input_is_refused(changes, message):
    good = {"image": np.ones((3, 4)), "variance": 0.1}
    with pytest.raises(ValueError, match=re.escape(message)):
        nlm(**(good | changes))
