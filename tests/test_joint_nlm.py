"""The joint filter: patches of radiance times the likeness of features. Its two limits are its two parents."""

import re
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import assert_close, noise
from mcdenoise.filters import cross_bilateral, gaussian, joint_nlm, nlm
from mcdenoise.samples import SampleBuffer, pixel_mean

pytestmark = pytest.mark.ch04

ENGINES = ("numpy", "numba")
PRECISION = {"numpy": 1e-12, "numba": 6e-6}
close = partial(assert_close, PRECISION)
SCENE = {"albedo": noise(13, 18, 3, seed=5), "depth": noise(13, 18, seed=6)}
SIGMAS = {"albedo": 0.4, "depth": 0.3}
VARIANCES = {"albedo": 0.1 * noise(13, 18, 3, seed=8)}


@pytest.mark.parametrize("variances", [None, VARIANCES])
@pytest.mark.parametrize("sigma_space", [2.0, np.inf])
def test_infinite_k_is_the_cross_bilateral(engine, variances, sigma_space):
    image = noise(13, 18, 3)
    common = {"sigma_features": SIGMAS, "variances": variances, "sigma_space": sigma_space, "engine": engine}
    expected = cross_bilateral(image, SCENE, sigma_radiance=np.inf, radius=4, **common)
    for k in (np.inf, 1e9):
        close(engine, joint_nlm(image, 0.1, SCENE, k=k, search_radius=4, **common), expected)


@pytest.mark.parametrize("weight_radius", [0, 2])
def test_infinite_feature_bandwidth_is_nl_means(engine, weight_radius):
    image = noise(13, 18, 3)
    dials = {"search_radius": 4, "patch_radius": 2, "weight_radius": weight_radius, "engine": engine}
    expected = nlm(image, 0.05, **dials)
    close(engine, joint_nlm(image, 0.05, {}, sigma_features={}, **dials), expected)
    for wide in (np.inf, 1e9):
        close(engine, joint_nlm(image, 0.05, SCENE, sigma_features=dict.fromkeys(SCENE, wide), **dials), expected)


def test_infinite_everything_is_the_mean_of_the_window(engine):
    image, wide = noise(13, 18, 3), dict.fromkeys(SCENE, np.inf)
    expected = gaussian(image, sigma_space=np.inf, radius=4, engine=engine)
    close(engine, joint_nlm(image, 0.1, SCENE, sigma_features=wide, k=np.inf, search_radius=4, engine=engine), expected)


def test_weights_are_products(engine):
    """Two pixels: exp(-d^2) times the bell over space times the likeness of the feature, in closed form."""
    image, depth = np.array([[0.0, 3.0]]), np.array([[0.0, 1.0]])
    filtered = joint_nlm(
        image,
        1.0,
        {"depth": depth},
        sigma_features={"depth": 0.5},
        variances={"depth": np.array([[0.5, 0.25]])},
        sigma_space=1.5,
        patch_radius=0,
        k=2.0,
        engine=engine,
    )
    weight = np.exp(-(9 - 2) / (4 * 2) - 1 / (2 * 1.5**2) - 1 / (2 * (0.25 + 0.75)))
    close(engine, filtered, np.array([[3 * weight, 3]]) / (1 + weight))


def test_features_hold_where_radiance_is_lost(engine):
    """Noise ten times the step: NL-means mixes the two halves, the joint filter does not."""
    rng = np.random.default_rng(1)
    left = np.arange(24) < 12
    truth = np.where(left, 1.0, 1.3) * np.ones((24, 1))
    image = truth + 3 * rng.normal(size=truth.shape)
    albedo = {"albedo": np.where(left, 0.2, 0.8) * np.ones((24, 1))}
    joint = joint_nlm(
        image, 9.0, albedo, sigma_features={"albedo": 0.05}, search_radius=24, patch_radius=1, engine=engine
    )
    plain = nlm(image, 9.0, search_radius=24, patch_radius=1, engine=engine)
    step = image[:, ~left].mean() - image[:, left].mean()  # what the samples themselves hold
    assert joint[:, ~left].mean() - joint[:, left].mean() == pytest.approx(step, rel=0.2)
    assert abs(plain[:, ~left].mean() - plain[:, left].mean()) < 0.5 * abs(step)


@settings(max_examples=25)
@given(
    height=st.integers(1, 16),
    width=st.integers(1, 40),
    channels=st.sampled_from([None, 1, 3]),
    feature_channels=st.lists(st.sampled_from([None, 1, 3, 5]), max_size=3),
    noisy=st.booleans(),
    radii=st.tuples(st.integers(0, 6), st.integers(0, 4), st.integers(0, 2)),
    seed=st.integers(0, 99),
)
def test_engines_agree(height, width, channels, feature_channels, noisy, radii, seed):
    rng = np.random.default_rng(seed)

    def draw(k):
        return rng.normal(size=(height, width) if k is None else (height, width, k)).astype(np.float32)

    image = draw(channels)
    features = {f"feature_{i}": draw(k) for i, k in enumerate(feature_channels)}
    variances = {name: feature**2 for name, feature in features.items()} if noisy else None
    dials = dict(zip(("search_radius", "patch_radius", "weight_radius"), radii, strict=True))
    fast, plain = (
        joint_nlm(
            image,
            image**2,
            features,
            sigma_features=dict.fromkeys(features, 0.8),
            variances=variances,
            sigma_space=3.0,
            engine=engine,
            **dials,
        )
        for engine in ENGINES
    )
    np.testing.assert_allclose(fast, plain, rtol=0, atol=4e-5 * np.abs(image).max())


def test_takes_a_sample_buffer(engine, samples: SampleBuffer):
    image = pixel_mean(samples.radiance)
    common = {"sigma_features": {"albedo": 0.3}, "search_radius": 3, "engine": engine}
    means = {"albedo": pixel_mean(samples["albedo"])}
    np.testing.assert_array_equal(joint_nlm(image, 0.1, samples, **common), joint_nlm(image, 0.1, means, **common))


def test_albedo_leaves_before_and_comes_back_after(engine):
    """Texture under even light comes back exactly, whatever the weights."""
    albedo = 0.1 + 0.9 * noise(9, 11, 3)
    filtered = joint_nlm(2.0 * albedo, 1.0, {}, sigma_features={}, albedo=albedo, engine=engine)
    close(engine, filtered, 2.0 * albedo)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"variance": -1.0}, "variance must not be negative anywhere"),
        ({"sigma_features": {}}, "sigma_features must give a bandwidth for every feature, got none for 'albedo'"),
        ({"variances": {"depth": np.ones((3, 4))}}, "variances has no 'depth'; there is: albedo"),
        ({"variances": {"radiance": np.ones((3, 4))}}, "variances has no 'radiance'; there is: albedo"),
        ({"sigma_space": 0}, "sigma_space must be greater than 0"),
        ({"k": -1}, "k must be greater than 0"),
        ({"albedo": np.ones((4, 4))}, "albedo must have the height and width of image"),
        ({"engine": "fast"}, "engine must be one of 'numba', 'numpy', got 'fast'"),
    ],
)
def test_bad_input_is_refused(changes, message):
    good = {
        "image": np.ones((3, 4)),
        "variance": 0.1,
        "features": {"albedo": np.ones((3, 4))},
        "sigma_features": {"albedo": 0.1},
    }
    with pytest.raises(ValueError, match=re.escape(message)):
        joint_nlm(**(good | changes))
