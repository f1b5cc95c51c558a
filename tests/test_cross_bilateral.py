"""The cross-bilateral filter against its formula, its limits, its symmetries; and what it accepts as features."""

import re
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import assert_close, noise
from mcdenoise.filters import bilateral, cross_bilateral, gaussian
from mcdenoise.samples import SampleBuffer, pixel_mean

pytestmark = pytest.mark.ch04

ENGINES = ("numpy", "numba")
# Largest relative error allowed: rounding of a float64 sum, and of a float32 sum of up to a few hundred terms.
PRECISION = {"numpy": 1e-12, "numba": 4e-6}
close = partial(assert_close, PRECISION)


SCENE = {"albedo": noise(13, 18, 3, seed=5), "depth": noise(13, 18, seed=6), "shading_normal": noise(13, 18, 3, seed=7)}
SIGMAS = {"albedo": 0.4, "depth": 0.3, "shading_normal": 0.8}


def test_formula_term_by_term(engine):
    """One pixel, written out: every neighbour's weight as the product of the lecture's bell curves."""
    image, radius, (row, column) = noise(13, 18, 2), 4, (2, 16)
    total, norm = 0.0, 0.0
    for y in range(max(0, row - radius), min(13, row + radius + 1)):
        for x in range(max(0, column - radius), min(18, column + radius + 1)):
            weight = np.exp(-((y - row) ** 2 + (x - column) ** 2) / (2 * 2.5**2))
            weight *= np.exp(-np.sum((image[y, x] - image[row, column]) ** 2) / (2 * 0.7**2))
            for name, sigma in SIGMAS.items():
                weight *= np.exp(-np.sum((SCENE[name][y, x] - SCENE[name][row, column]) ** 2) / (2 * sigma**2))
            total, norm = total + weight * image[y, x], norm + weight
    filtered = cross_bilateral(
        image, SCENE, sigma_space=2.5, sigma_radiance=0.7, sigma_features=SIGMAS, radius=radius, engine=engine
    )
    close(engine, filtered[row, column], total / norm)


def test_step_in_a_feature_is_the_closed_form(engine):
    """Two half planes, told apart by the feature alone: out = (A left + g B right) / (A + g B)."""
    columns = np.arange(16)
    left = columns < 8
    image = np.where(left, 1.0, 3.0) * np.ones((5, 1))
    step, sigma = 0.9, 0.5
    features = {"albedo": np.where(left, 0.0, step) * np.ones((5, 1))}
    g = np.exp(-(step**2) / (2 * sigma**2))
    near = np.exp(-((columns[:, None] - columns) ** 2) / (2 * 2.0**2)) * (abs(columns[:, None] - columns) <= 6)
    same = near * np.where(left[:, None] == left, 1.0, g)
    expected = (same @ image[0]) / same.sum(axis=1) * np.ones((5, 1))
    filtered = cross_bilateral(
        image,
        features,
        sigma_space=2.0,
        sigma_radiance=np.inf,
        sigma_features={"albedo": sigma},
        radius=6,
        engine=engine,
    )
    close(engine, filtered, expected)


@pytest.mark.parametrize("sigma_radiance", [0.5, np.inf])
def test_infinite_feature_bandwidth_is_the_bilateral(engine, sigma_radiance):
    image = noise(13, 18, 3)
    expected = bilateral(image, sigma_space=2.0, sigma_radiance=sigma_radiance, engine=engine)
    common = {"sigma_space": 2.0, "sigma_radiance": sigma_radiance, "engine": engine}
    close(engine, cross_bilateral(image, {}, sigma_features={}, **common), expected)
    for wide in (np.inf, 1e9):
        sigmas = dict.fromkeys(SCENE, wide)
        close(engine, cross_bilateral(image, SCENE, sigma_features=sigmas, **common), expected)


def test_a_flat_feature_changes_nothing(engine):
    image = noise(13, 18, 3)
    flat = {"world_position": np.full((13, 18, 3), 1e4)}
    filtered = cross_bilateral(
        image, flat, sigma_space=2.0, sigma_radiance=0.5, sigma_features={"world_position": 1e-3}, engine=engine
    )
    close(engine, filtered, bilateral(image, sigma_space=2.0, sigma_radiance=0.5, engine=engine))


@pytest.mark.parametrize("largest", [1.0, 1e6, 1e30])
@pytest.mark.parametrize("sigma", [1e-6, 1e-30])
def test_a_feature_unlike_everywhere_returns_the_image(engine, largest, sigma):
    image = noise(13, 18, 3).astype(np.float32)
    features = {"albedo": noise(13, 18).astype(np.float32)}
    features["albedo"][3, 4] = largest
    filtered = cross_bilateral(
        image, features, sigma_space=2.0, sigma_radiance=1.0, sigma_features={"albedo": sigma}, engine=engine
    )
    np.testing.assert_array_equal(filtered, image)


@pytest.mark.parametrize("turn", [np.flipud, np.fliplr, np.rot90, lambda image: image[::-1, ::-1]])
def test_commutes_with_mirror_and_turn(engine, turn):
    image = noise(13, 18, 3)
    turned = {name: turn(feature) for name, feature in SCENE.items()}
    common = {"sigma_space": 2.0, "sigma_radiance": 0.8, "sigma_features": SIGMAS, "engine": engine}
    close(engine, cross_bilateral(turn(image), turned, **common), turn(cross_bilateral(image, SCENE, **common)))


@settings(max_examples=40)
@given(
    height=st.integers(1, 20),
    width=st.integers(1, 40),
    channels=st.sampled_from([None, 1, 3, 4]),
    feature_channels=st.lists(st.sampled_from([None, 1, 2, 3, 5]), max_size=4),
    scale=st.floats(1e-3, 1e6),
    sigma=st.floats(0.1, 10.0),
    radius=st.integers(0, 9),
    seed=st.integers(0, 99),
)
def test_engines_agree_and_stay_in_range(height, width, channels, feature_channels, scale, sigma, radius, seed):
    rng = np.random.default_rng(seed)

    def draw(k):
        return (scale * rng.normal(size=(height, width) if k is None else (height, width, k))).astype(np.float32)

    image = draw(channels)
    features = {f"feature_{k}": draw(k_channels) for k, k_channels in enumerate(feature_channels)}
    before = {name: feature.copy() for name, feature in features.items()} | {"image": image.copy()}
    fast, plain = (
        cross_bilateral(
            image,
            features,
            sigma_space=3.0,
            sigma_radiance=scale * 2,
            sigma_features=dict.fromkeys(features, sigma * scale),
            radius=radius,
            engine=engine,
        )
        for engine in ENGINES
    )
    for name, array in (features | {"image": image}).items():
        np.testing.assert_array_equal(array, before[name])
    # Guides of up to 4 / sigma are rounded to float32: 2^-24 * 40 in a difference of up to 5 that counts.
    largest = np.abs(image).max()
    np.testing.assert_allclose(fast, plain, rtol=0, atol=4e-5 * largest)
    assert fast.dtype == plain.dtype == np.float32
    assert fast.shape == plain.shape == image.shape
    assert (fast >= image.min() - 1e-6 * largest).all()
    assert (fast <= image.max() + 1e-6 * largest).all()


def test_order_of_features_does_not_matter(engine):
    image = noise(13, 18, 3)
    common = {"sigma_space": 2.0, "sigma_radiance": 0.8, "engine": engine}
    one = cross_bilateral(image, SCENE, sigma_features=SIGMAS, **common)
    other = cross_bilateral(image, SCENE, sigma_features=dict(reversed(SIGMAS.items())), **common)
    close(engine, other, one)


def test_takes_the_pixel_means_of_a_sample_buffer(engine, samples: SampleBuffer):
    image = pixel_mean(samples.radiance)
    sigmas = {"albedo": 0.3, "visibility": 0.5}
    common = {"sigma_space": 2.0, "sigma_radiance": 0.8, "sigma_features": sigmas, "engine": engine}
    means = {name: pixel_mean(samples[name]) for name in sigmas}
    np.testing.assert_array_equal(cross_bilateral(image, samples, **common), cross_bilateral(image, means, **common))


def test_keeps_dtype_and_takes_any_memory_layout(engine):
    wide = noise(26, 36, 3).astype(np.float32)
    image, feature = wide[::2, ::-2], wide[1::2, 1::2].transpose(1, 0, 2).copy().transpose(1, 0, 2)
    common = {"sigma_space": 2.0, "sigma_radiance": 0.8, "sigma_features": {"albedo": 0.4}, "engine": engine}
    expected = cross_bilateral(image.copy(), {"albedo": feature.copy()}, **common)
    np.testing.assert_array_equal(cross_bilateral(image, {"albedo": feature}, **common), expected)
    assert expected.dtype == np.float32
    assert cross_bilateral(image.astype(np.float64), {"albedo": feature}, **common).dtype == np.float64


VARIANCES = {"albedo": 0.2 * noise(13, 18, 3, seed=8), "depth": 0.1 * noise(13, 18, seed=9)}


def test_noise_widens_the_bandwidth_term_by_term(engine):
    """One pixel, written out: each squared difference over sigma^2 + both variances, that of the radiance too."""
    image, noise_of_image, radius, (row, column) = noise(13, 18, 2), 0.1 * noise(13, 18, 2, seed=4), 4, (2, 16)
    total, norm = 0.0, 0.0
    for y in range(max(0, row - radius), min(13, row + radius + 1)):
        for x in range(max(0, column - radius), min(18, column + radius + 1)):
            exponent = ((y - row) ** 2 + (x - column) ** 2) / 2.5**2
            both = noise_of_image[y, x] + noise_of_image[row, column]
            exponent += np.sum((image[y, x] - image[row, column]) ** 2 / (0.7**2 + both))
            for name, sigma in SIGMAS.items():
                variance = VARIANCES.get(name, np.zeros((13, 18)))
                both = variance[y, x] + variance[row, column]
                exponent += np.sum((SCENE[name][y, x] - SCENE[name][row, column]) ** 2 / (sigma**2 + both))
            weight = np.exp(-exponent / 2)
            total, norm = total + weight * image[y, x], norm + weight
    filtered = cross_bilateral(
        image,
        SCENE,
        sigma_space=2.5,
        sigma_radiance=0.7,
        sigma_features=SIGMAS,
        variances={**VARIANCES, "radiance": noise_of_image},
        radius=radius,
        engine=engine,
    )
    close(engine, filtered[row, column], total / norm)


def test_no_variance_is_the_plain_filter(engine):
    image = noise(13, 18, 3)
    common = {"sigma_space": 2.0, "sigma_radiance": 0.8, "sigma_features": SIGMAS, "engine": engine}
    expected = cross_bilateral(image, SCENE, **common)
    zero = {"radiance": 0.0, **{name: np.zeros((13, 18)) for name in SIGMAS}}
    for variances in ({}, zero, dict.fromkeys(zero, 1e-30)):
        close(engine, cross_bilateral(image, SCENE, variances=variances, **common), expected)


def test_a_feature_of_pure_noise_has_no_say(engine):
    image = noise(13, 18, 3)
    common = {"sigma_space": 2.0, "sigma_radiance": 0.8, "engine": engine}
    drowned = cross_bilateral(image, SCENE, sigma_features=SIGMAS, variances=dict.fromkeys(SIGMAS, 1e15), **common)
    close(engine, drowned, bilateral(image, sigma_space=2.0, sigma_radiance=0.8, engine=engine))


def test_small_sigma_counts_in_standard_deviations(engine):
    """sigma -> 0: a difference of s standard deviations of the difference has the weight exp(-s^2 / 2)."""
    depth, variance = {"depth": np.array([[0.0, 3.0]])}, {"depth": np.array([[1.0, 3.0]])}
    common = {"sigma_space": np.inf, "sigma_radiance": np.inf, "radius": 1, "engine": engine}
    filtered = cross_bilateral(
        np.array([[0.0, 1.0]]), depth, sigma_features={"depth": 1e-9}, variances=variance, **common
    )
    weight = np.exp(-((3.0 / 2.0) ** 2) / 2)
    close(engine, filtered, np.array([[weight, 1.0]]) / (1 + weight))


def test_zero_variance_beside_a_large_one(engine):
    """Where nothing is noisy the bandwidth alone counts, whatever the noise elsewhere."""
    image, depth = noise(6, 18, 3), {"depth": noise(6, 18, seed=6)}
    variance = np.where(np.arange(18) < 9, 0.0, 1e12) * np.ones((6, 1))
    common = {"sigma_space": 2.0, "sigma_radiance": np.inf, "sigma_features": {"depth": 0.2}, "radius": 3}
    plain = cross_bilateral(image, depth, engine=engine, **common)
    filtered = cross_bilateral(image, depth, variances={"depth": variance}, engine=engine, **common)
    np.testing.assert_allclose(filtered[:, :6], plain[:, :6], rtol=1e-5)
    box = gaussian(image, sigma_space=2.0, radius=3, engine=engine)
    np.testing.assert_allclose(filtered[:, 12:], box[:, 12:], rtol=1e-5)


@settings(max_examples=30)
@given(
    height=st.integers(1, 20),
    width=st.integers(1, 40),
    feature_channels=st.lists(st.sampled_from([None, 1, 3, 4]), min_size=1, max_size=4),
    scale=st.floats(1e-3, 1e6),
    share=st.floats(0, 100),
    radius=st.integers(0, 9),
    seed=st.integers(0, 99),
)
def test_engines_agree_with_variances(height, width, feature_channels, scale, share, radius, seed):
    rng = np.random.default_rng(seed)

    def draw(k):
        return (scale * rng.normal(size=(height, width) if k is None else (height, width, k))).astype(np.float32)

    image = draw(3)
    features = {f"feature_{i}": draw(k) for i, k in enumerate(feature_channels)}
    noisy = list(features)[::2]
    fast, plain = (
        cross_bilateral(
            image,
            features,
            sigma_space=3.0,
            sigma_radiance=scale * 2,
            sigma_features=dict.fromkeys(features, scale),
            variances={"radiance": share * image**2} | {name: share * features[name] ** 2 for name in noisy},
            radius=radius,
            engine=engine,
        )
        for engine in ENGINES
    )
    np.testing.assert_allclose(fast, plain, rtol=0, atol=4e-5 * np.abs(image).max())


def test_texture_under_even_light_survives_demodulation(engine):
    """And what is black stays black: 0 / 0.1 is averaged with its neighbours, and multiplied by 0.1 again."""
    albedo = 0.1 + 0.9 * noise(13, 18, 3)
    albedo[3, 4] = 0.0
    image, radius = 2.0 * albedo, 2
    common = {"sigma_space": 3.0, "sigma_radiance": np.inf, "sigma_features": {}, "radius": radius, "engine": engine}
    filtered = cross_bilateral(image, {}, albedo=albedo, **common)
    close(engine, filtered[3 + radius + 1 :], image[3 + radius + 1 :])
    assert (filtered[3, 4] <= 0.1 * 2.0).all()


def test_demodulation_divides_filters_multiplies(engine):
    image, albedo = noise(13, 18, 3), 0.1 + 0.9 * noise(13, 18, 3, seed=5)
    common = {"sigma_space": 2.0, "sigma_radiance": 0.8, "sigma_features": SIGMAS, "engine": engine}
    variance = 0.1 * noise(13, 18, 3, seed=4)
    inner = cross_bilateral(image / albedo, SCENE, variances={"radiance": variance / albedo**2}, **common)
    outer = cross_bilateral(image, SCENE, variances={"radiance": variance}, albedo=albedo, **common)
    np.testing.assert_allclose(outer, albedo * inner, rtol=1e-5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"image": np.ones(4)}, "image must have shape (h, w) or (h, w, c), got (4,)"),
        ({"sigma_space": 0.0}, "sigma_space must be greater than 0"),
        ({"sigma_space": np.inf}, "radius must be given when sigma_space is infinite"),
        ({"sigma_radiance": 0.0}, "sigma_radiance must be greater than 0"),
        ({"sigma_features": 0.1}, "sigma_features must be a mapping from name to bandwidth, got 0.1"),
        ({"sigma_features": {}}, "sigma_features must give a bandwidth for every feature, got none for 'albedo'"),
        ({"sigma_features": {"albedo": 0.1, "depth": 1.0}}, "sigma_features has no 'depth'; there is: albedo"),
        ({"sigma_features": {"albedo": 0}}, "sigma_features['albedo'] must be greater than 0"),
        ({"features": [np.ones((3, 4))]}, "features must be a mapping from name to array or a SampleBuffer, got list"),
        ({"features": {"albedo": np.ones((4, 3))}}, "features['albedo'] must have the height and width of image"),
        ({"features": {"albedo": np.full((3, 4), np.nan)}}, "features['albedo'] must be finite"),
        ({"features": {"albedo": np.full((3, 4), 2e30)}}, "features['albedo'] must stay within 1e+30"),
        ({"features": {"albedo": np.ones(3)}}, "features['albedo'] must have shape (h, w) or (h, w, c)"),
        ({"variances": [1.0]}, "variances must be a mapping from name to variance, got list"),
        ({"variances": {"depth": 1.0}}, "variances has no 'depth'; there is: albedo, radiance"),
        ({"variances": {"albedo": np.ones((4, 3))}}, "variances['albedo'] must have the height and width of image"),
        ({"variances": {"albedo": np.ones((3, 4, 2))}}, "variances['albedo'] must have shape (h, w) or that of"),
        ({"variances": {"albedo": -np.ones((3, 4))}}, "variances['albedo'] must not be negative anywhere, got -1"),
        ({"variances": {"albedo": None}}, "variances['albedo'] must be a number or an array (h, w) or (h, w, c)"),
        ({"variances": {"radiance": np.full((3, 4), np.nan)}}, "variances['radiance'] must be finite"),
        ({"albedo": np.full((3, 4), 2.0)}, "albedo must lie in [0, 1], got 2 to 2"),
        ({"radius": -1}, "radius must be at least 0"),
        ({"engine": "fast"}, "engine must be one of 'numba', 'numpy', got 'fast'"),
    ],
)
def test_bad_input_is_refused(changes, message):
    good = {
        "image": np.ones((3, 4)),
        "features": {"albedo": np.ones((3, 4))},
        "sigma_space": 1.0,
        "sigma_radiance": 1.0,
        "sigma_features": {"albedo": 0.1},
    }
    with pytest.raises(ValueError, match=re.escape(message)):
        cross_bilateral(**(good | changes))


def test_a_buffer_without_the_named_feature_is_refused(samples: SampleBuffer):
    with pytest.raises(ValueError, match=re.escape("sigma_features has no 'shading_normal'")):
        cross_bilateral(
            pixel_mean(samples.radiance),
            samples,
            sigma_space=1.0,
            sigma_radiance=1.0,
            sigma_features={"shading_normal": 0.1},
        )


def test_a_buffer_of_another_size_is_refused(samples: SampleBuffer):
    with pytest.raises(ValueError, match=re.escape("features['albedo'] must have the height and width of")):
        cross_bilateral(
            np.ones((3, 3, 3)), samples, sigma_space=1.0, sigma_radiance=1.0, sigma_features={"albedo": 0.1}
        )
