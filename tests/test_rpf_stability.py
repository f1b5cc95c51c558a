"""Random parameter filtering where statistics are undefined or inputs hostile: never NaN, never a crash, and what comes out."""

from dataclasses import replace

import numpy as np
import pytest

import mcdenoise as mcd
from mcdenoise import RPFConfig
from mcdenoise.rpf.config import PRESETS
from rpf_scenes import blurred, buffer, edge

pytestmark = pytest.mark.ch06

CONFIGS = {name: make() for name, make in PRESETS.items()}
ALL = pytest.mark.parametrize("name", CONFIGS)


def run(samples, name, **more):
    image = mcd.rpf(samples, CONFIGS[name], **more)
    assert image.shape == (samples.height, samples.width, 3)
    assert np.isfinite(image).all()
    assert image.min() >= samples.radiance.min() - 1e-6
    assert image.max() <= samples.radiance.max() * (1 + 1e-5)
    return image


@ALL
@pytest.mark.parametrize("spp", [1, 2, 3])
def test_few_samples(name, spp):
    """With 1 spp features are constant within a pixel, so edges of features stay; radiance may be averaged."""
    samples = buffer(10, spp, edge, {"albedo": edge})
    image = run(samples, name)
    np.testing.assert_allclose(image[:, [0, 1, 10, 11][:2]], 0.2, atol=0.15)
    np.testing.assert_allclose(image[:, 8:], 0.8, atol=0.15)


@ALL
def test_without_random_parameters_all_is_trusted(name):
    """A pinhole without lights: W = 0, alpha = 1, and an edge without noise stays."""
    samples = buffer(10, 4, edge, {"albedo": edge}, random_params=())
    np.testing.assert_allclose(run(samples, name)[:, :5], 0.2, atol=0.02)
    found = mcd.rpf_analysis(samples, CONFIGS[name])
    assert found.share_c_r_each.shape == (10, 10, 3, 0)
    assert (found.share_c_r == 0).all()
    assert (found.alpha == 1).all()


@ALL
def test_a_constant_feature_changes_nothing(name):
    """Its mutual information with anything is 0, and all its differences are 0."""
    without = buffer(8, 4, blurred)
    with_one = buffer(8, 4, blurred, {"albedo": 0.4})
    np.testing.assert_allclose(run(with_one, name), run(without, name), rtol=1e-6)


@ALL
@pytest.mark.parametrize("brightness", [1e-30, 1e-38, 1e-40])
def test_light_at_the_end_of_float32_gives_an_image(name, brightness):
    """One over a denormal deviation is no float32; what varies by so little counts as constant."""
    one = buffer(8, 4, blurred)
    faint = replace(one, radiance=one.radiance * np.float32(brightness))
    image = mcd.rpf(faint, CONFIGS[name], progress=False)
    least, greatest = (float(bound) for bound in (faint.radiance.min(), faint.radiance.max()))
    assert image.min() >= least * (1 - 1e-5)
    assert image.max() <= greatest * (1 + 1e-5)


@pytest.mark.parametrize("engine", ["numba", "numpy"])
def test_an_infinite_bandwidth_lets_all_in(engine):
    """sigma_8 infinite: every weight is that of the screen alone, so a constant shift of half the samples is averaged."""
    samples = buffer(6, 4, blurred)
    wide = mcd.RPFConfig.adaptive(sigma_8_squared=np.inf)
    image = mcd.rpf(samples, wide, engine=engine, progress=False)
    blind = mcd.rpf(samples, mcd.RPFConfig.adaptive(alpha=0.0, beta=0.0), engine=engine, progress=False)
    np.testing.assert_allclose(image, blind, rtol=1e-5)


@ALL
def test_without_features(name):
    run(buffer(8, 4, blurred), name)


def test_nan_and_infinity_are_stopped_at_the_gate_or_set_to_0():
    radiance = np.ones((4, 4, 4, 3))
    radiance[1, 2, 3, 0], radiance[3, 3, 0, 1] = np.nan, np.inf
    position = buffer(4, 4).screen_position
    with pytest.raises(ValueError, match="nonfinite='zero'"):
        mcd.SampleBuffer.from_arrays(radiance, position)
    samples = mcd.SampleBuffer.from_arrays(radiance, position, nonfinite="zero")
    for name in CONFIGS:
        run(samples, name)


@ALL
def test_a_firefly_of_a_million(name):
    """It stays where it is or is spread, never beyond its own energy; pixels that it cannot reach do not change."""
    samples = buffer(24, 8, blurred)
    radiance = samples.radiance.copy()
    radiance[3, 3, 2] = 1e6
    params = {one: samples[one] for one in samples.random_param_names}
    bright = mcd.SampleBuffer.from_arrays(radiance, samples.screen_position, params)
    image = run(bright, name)
    assert image.sum() <= 1.05 * mcd.pixel_mean(radiance).sum() + 1
    if name == "adaptive":  # boxes 5 and 3: it reaches three pixels
        np.testing.assert_array_equal(image[8:, 8:], run(samples, name)[8:, 8:])


@ALL
@pytest.mark.parametrize("size", [(1, 1), (1, 5), (2, 2), (3, 7)])
def test_images_smaller_than_the_box(name, size):
    samples = buffer(size[0], 4, blurred, {"albedo": edge}, width=size[1])
    image = run(samples, name)
    if size == (1, 1) and CONFIGS[name].spikes in ("none", "joint"):
        assert abs(image.mean() - samples.radiance.mean()) < 0.2


@ALL
def test_all_black_stays_black(name):
    samples = buffer(6, 4, 0.0, {"albedo": 0.0})
    np.testing.assert_array_equal(run(samples, name), 0)


@ALL
def test_identical_samples_stay_as_they_are(name):
    """Every pixel has its value eight times: the lens explains nothing, whatever its numbers are."""
    values = np.random.default_rng(0).random((6, 6, 1, 3)).repeat(8, axis=2)
    samples = buffer(6, 8, values, {"albedo": values})
    image = run(samples, name)
    if name == "adaptive":
        np.testing.assert_allclose(image, values[:, :, 0], atol=0.02)


@ALL
def test_a_feature_that_is_a_random_parameter(name):
    """It says nothing about the scene, and W_{f,k}^r knows: near 1 in any box."""
    samples = buffer(10, 8, blurred, {"albedo": lambda x, y, p: p["lens_u"]})
    run(samples, name)
    assert mcd.rpf_analysis(samples, CONFIGS[name])["albedo"].mean() > 0.85


@ALL
def test_radiance_with_large_negative_lobes(name):
    """Some renderers filter with negative lobes: still finite, still between the least and the greatest sample."""
    values = np.random.default_rng(2).normal(0, 1, (8, 8, 4, 3))
    image = mcd.rpf(buffer(8, 4, values), CONFIGS[name])
    assert np.isfinite(image).all()
    assert image.min() >= values.min()
    assert image.max() <= values.max()


def test_wrong_input_is_refused_in_words():
    samples = buffer(4, 2)
    for call, words in (
        (lambda: mcd.rpf(samples.radiance), "samples must be a SampleBuffer, got ndarray"),
        (lambda: mcd.rpf(samples, "lecture"), "config must be an RPFConfig"),
        (lambda: mcd.rpf(samples, engine="fast"), "engine must be one of"),
        (lambda: mcd.rpf(samples, seed=-1), "seed must be at least 0"),
        (lambda: mcd.rpf(samples, RPFConfig.lecture(random_params=("time",))), "random_params has no 'time'"),
        (lambda: mcd.rpf_analysis(samples, pass_=2), "pass_ must be below 2"),
        (lambda: mcd.rpf_neighbourhood(samples, (4, 0)), "pixel must lie in the image of 4 rows"),
        (lambda: mcd.rpf_neighbourhood(samples, 3), "pixel must be two whole numbers"),
    ):
        with pytest.raises(ValueError, match=words):
            call()
    with pytest.raises(KeyError, match="There is no 'depth'"):
        mcd.rpf_analysis(samples)["depth"]
    with pytest.raises(KeyError, match="There is no 'depth'"):
        mcd.rpf_neighbourhood(samples, (0, 0))["depth"]
