"""How noisy a pixel is, features with less noise, and the albedo that may be divided by."""

import re

import numpy as np
import pytest

from conftest import make_samples, noise
from mcdenoise.filters import gaussian, noise_variance, prefilter_features, safe_albedo
from mcdenoise.samples import pixel_mean, variance_of_mean

pytestmark = pytest.mark.ch04


def test_without_a_window_it_is_the_variance_of_the_mean(engine):
    samples = noise(5, 6, 4, 3)
    np.testing.assert_array_equal(noise_variance(samples, radius=0, engine=engine), variance_of_mean(samples))


def test_it_is_the_mean_over_the_window(engine):
    samples = noise(5, 6, 4, 3)
    expected = gaussian(variance_of_mean(samples), sigma_space=np.inf, radius=2, engine=engine)
    np.testing.assert_array_equal(noise_variance(samples, radius=2, engine=engine), expected)


@pytest.mark.parametrize("spp", [1, 2, 8])
def test_even_light_gives_the_variance_it_was_made_with(engine, spp):
    """Mean over many pixels within 5 standard errors, from the spread between pixels at 1 spp too."""
    samples = 3.0 + np.random.default_rng(7).normal(scale=0.4, size=(120, 120, spp, 1))
    estimate = noise_variance(samples, engine=engine).mean()
    expected = 0.16 / spp * (1 if spp > 1 else 8 / 9)  # between 9 pixels, about their own mean
    error = expected * np.sqrt(2 * 9 / (120 * 120 * max(spp - 1, 1)))
    assert abs(estimate - expected) < 5 * error + (0.01 * expected if spp == 1 else 0)  # 1 spp: borders


def test_one_sample_and_one_pixel_have_no_variance(engine):
    np.testing.assert_array_equal(noise_variance(np.full((1, 1, 1, 3), 5.0), engine=engine), np.zeros((1, 1, 3)))
    assert (noise_variance(np.full((4, 5, 1), 1e3, np.float32), engine=engine) == 0).all()


def test_prefiltering_removes_noise_and_keeps_edges(engine, rng):
    size, spp = (24, 24), 8
    truth = np.where(np.arange(24) < 12, 0.2, 0.8) * np.ones((24, 1))
    noisy = np.clip(truth[..., np.newaxis] + 0.15 * rng.normal(size=(*size, spp)), 0, 1)
    features = {"albedo": np.repeat(noisy[..., np.newaxis], 3, axis=-1), "depth": np.ones((*size, spp))}
    samples = make_samples(rng, *size, spp, features=features)
    filtered, variances = prefilter_features(samples, engine=engine)
    before = np.abs(pixel_mean(samples["albedo"])[..., 0] - truth)
    after = np.abs(filtered["albedo"][..., 0] - truth)
    assert after.mean() < 0.5 * before.mean()
    assert after[:, 11:13].max() < 0.15
    assert filtered["albedo"].shape == variances["albedo"].shape == (24, 24, 3)
    assert (variances["albedo"] > 0).all()
    np.testing.assert_array_equal(filtered["depth"], np.ones(size))
    np.testing.assert_array_equal(variances["depth"], np.zeros(size))


def test_only_the_named_features_and_their_shapes(samples):
    filtered, variances = prefilter_features(samples, ["visibility"])
    assert list(filtered) == list(variances) == ["visibility"]
    assert filtered["visibility"].shape == (5, 7)
    assert filtered["visibility"].dtype == np.float32
    assert list(prefilter_features(samples)[0]) == list(samples.feature_names)
    assert prefilter_features(samples, []) == ({}, {})


def test_one_sample_a_pixel_is_enough(rng):
    samples = make_samples(rng, spp=1)
    for arrays in prefilter_features(samples):
        assert all(np.isfinite(array).all() for array in arrays.values())


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["shading_normal"], "features has no 'shading_normal'"),
        ("albedo", "features must be a list of names"),
        (["albedo", "albedo"], "features must not name anything twice"),
    ],
)
def test_unknown_features_are_refused(samples, names, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        prefilter_features(samples, names)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"samples": np.ones((3, 4))}, "samples must have shape (h, w, spp) or (h, w, spp, c)"),
        ({"samples": np.full((3, 4, 2), np.nan)}, "samples must be finite"),
        ({"samples": np.ones((3, 4, 2)), "radius": -1}, "radius must be at least 0"),
        ({"samples": np.ones((3, 4, 2)), "engine": "fast"}, "engine must be one of"),
    ],
)
def test_bad_samples_are_refused(arguments, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        noise_variance(**arguments)


def test_dark_albedo_is_divided_by_a_tenth():
    image = np.ones((1, 3, 2))
    albedo = np.array([[[0.5, 0.009], [0.0, 1.0], [0.11, 0.1]]])
    np.testing.assert_array_equal(safe_albedo(albedo, image), [[[0.5, 0.1], [0.1, 1.0], [0.11, 0.1]]])
    assert safe_albedo(None, image) is None
    assert safe_albedo(np.full((1, 3), 0.5), image).shape == (1, 3, 2)


@pytest.mark.parametrize(
    ("albedo", "message"),
    [
        (np.ones((2, 3)), "albedo must have the height and width of image, (1, 3), got (2, 3)"),
        (np.ones((1, 3, 3)), "albedo must have shape (h, w) or that of image, (1, 3, 2), got (1, 3, 3)"),
        (np.full((1, 3), -0.5), "albedo must lie in [0, 1], got -0.5 to -0.5"),
        (np.full((1, 3), np.nan), "albedo must be finite"),
    ],
)
def test_what_is_no_albedo_is_refused(albedo, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        safe_albedo(albedo, np.ones((1, 3, 2)))
