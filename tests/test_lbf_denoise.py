"""mcd.lbf where statistics are undefined or inputs hostile: never NaN, never a crash, and what comes out.

Models are small and untrained, with the usual bandwidths everywhere: what holds for them does not hang on a training. Where a
model of the package is meant, the test says so.
"""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mcdenoise as mcd
from conftest import make_samples
from mcdenoise.lbf.despike import despike
from mcdenoise.lbf.layer import VARIANTS
from mcdenoise.lbf.primary import GROUPS, primary_features
from mcdenoise.lbf.storage import shipped_model
from mcdenoise.samples import pixel_mean

pytestmark = pytest.mark.ch09

BOTH = pytest.mark.parametrize("variant", VARIANTS)
ROUNDING = 1e-5  # of the largest value: float32
COLOUR_THETA = {"cross_bilateral": 0.01, "nlm": 0.8}


def model_of(variant="cross_bilateral", groups=GROUPS, **more):
    """A model before its training."""
    given = {"radius": 6, "patch_radius": 2, "colour_theta": COLOUR_THETA[variant], **more}
    return mcd.LBFModel.random(groups, hidden=[3], rng=np.random.default_rng(0), variant=variant, **given)


def scene(height=10, width=12, spp=4, groups=GROUPS, radiance=None, seed=0, still=False, **changes):
    """Noise; `still`: features that do not vary within a pixel."""
    rng = np.random.default_rng(seed)
    size = (height, width, spp)
    features = {}
    for name in groups:
        channels = () if name == "visibility" else (3,)
        one = rng.random((height, width, 1, *channels)) if still else rng.random((*size, *channels))
        features[name] = np.broadcast_to(one, (*size, *channels)).copy()
    light = rng.gamma(2.0, 0.3, (*size, 3)) if radiance is None else np.broadcast_to(radiance, (*size, 3)).copy()
    return make_samples(rng, *size, radiance=light, features=features, **changes)


def divided(samples, image, model):
    """What the filter averages: image and pixel means, over the albedo if the model divides by it."""
    mean = pixel_mean(samples.radiance)
    _, albedo = model.prepared(primary_features(samples))
    return (image, mean) if albedo is None else (image / albedo, mean / albedo)


def run(samples, model, variant="cross_bilateral", **more):
    """Filter, and see that a weighted mean came out: finite, between the least and the greatest pixel of each channel."""
    image = mcd.lbf(samples, model, variant=variant, **more)
    assert image.shape == (samples.height, samples.width, 3)
    assert image.dtype == np.float32
    assert np.isfinite(image).all()
    filtered, mean = divided(samples, image, model or shipped_model(variant))
    slack = ROUNDING * np.abs(mean).max((0, 1))
    assert (filtered >= mean.min((0, 1)) - slack).all()
    assert (filtered <= mean.max((0, 1)) + slack).all()
    return image


# --- what it does


@BOTH
def test_less_noise_and_both_engines_agree(variant):
    samples, model = scene(), model_of(variant)
    image = run(samples, model)
    np.testing.assert_allclose(image, run(samples, model, engine="numpy"), atol=3e-6)
    assert mcd.relmse(image, np.full(image.shape, 0.6)) < 0.2 * mcd.relmse(
        pixel_mean(samples.radiance), np.full(image.shape, 0.6)
    )


@BOTH
@settings(max_examples=8)
@given(st.integers(1, 9), st.integers(1, 9), st.integers(1, 5), st.sets(st.sampled_from(GROUPS)), st.integers(0, 99))
def test_engines_agree_whatever_there_is(variant, height, width, spp, groups, seed):
    samples = scene(height, width, spp, [*groups], seed=seed)
    model = model_of(variant)
    np.testing.assert_allclose(run(samples, model), run(samples, model, engine="numpy"), atol=1e-5)


def test_the_same_twice_and_nothing_is_changed():
    samples, model = scene(), model_of()
    before = samples.radiance.copy(), samples.features.copy()
    np.testing.assert_array_equal(run(samples, model), run(samples, model))
    np.testing.assert_array_equal(samples.radiance, before[0])
    np.testing.assert_array_equal(samples.features, before[1])


@BOTH
@pytest.mark.parametrize("factor", [2.0**-40, 0.25, 2.0**20, 2.0**45])
def test_twice_the_light_twice_the_image(variant, factor):
    """Where the network does not see the colour: its distance is in units of its noise, and only epsilon, 1e-10, has a unit."""
    samples, model = scene(), model_of(variant, sees_colour=False)
    brighter = scene(radiance=(factor * samples.radiance).astype(np.float32))
    expected = factor * run(samples, model)
    tolerance = 1e-5 if factor > 1e-3 else 0.05  # epsilon is no longer small there
    np.testing.assert_allclose(run(brighter, model), expected, rtol=tolerance)


@BOTH
def test_the_analysis_shows_what_was_done(variant):
    samples, model = scene(groups=("albedo", "visibility")), model_of(variant, groups=("shading_normal", "visibility"))
    found = mcd.lbf_analysis(samples, model)
    np.testing.assert_array_equal(found.image, mcd.lbf(samples, model))
    assert list(found.theta) == list(found.bandwidths) == ["position", "colour", "visibility"]
    assert found.primary.groups == ("visibility",)
    for name, theta in found.theta.items():
        assert theta.shape == (10, 12)
        assert (theta > 0).all()
        np.testing.assert_allclose(2 * theta * found.bandwidths[name] ** 2, 1, rtol=1e-5)
    np.testing.assert_array_equal(found.theta["colour"], np.float32(COLOUR_THETA[variant]))


def test_a_bandwidth_of_theta_0_is_infinite():
    """Softplus reaches 0 in float32; no warning, no NaN."""
    model = model_of(groups=("albedo",))
    last = {"bias_2": np.array([-200.0, -3.0], np.float32)}
    model = replace(model, network=model.network.replace({**model.network.parameters, **last}))
    found = mcd.lbf_analysis(scene(groups=("albedo",)), model)
    assert (found.theta["position"] == 0).all()
    assert np.isposinf(found.bandwidths["position"]).all()
    assert np.isfinite(found.bandwidths["albedo"]).all()
    assert np.isfinite(found.image).all()


# --- what samples may be


@BOTH
@pytest.mark.parametrize("height", [1e3, 1e6])
def test_a_firefly_stays_where_it_is(variant, height):
    """One sample of a million: nothing of it reaches other pixels, and the energy of the image does not grow."""
    radiance = scene().radiance.copy()
    radiance[4, 5, 1] = height
    samples, model = scene(radiance=radiance), model_of(variant)
    filtered, mean = divided(samples, run(samples, model), model)
    others = np.ones((10, 12), bool)
    others[4, 5] = False
    assert filtered[others].max() <= mean[others].max() * (1 + ROUNDING)
    assert filtered.sum() <= 1.01 * mean.sum()


@BOTH
def test_fireflies_everywhere(variant):
    """A tenth of the samples between a thousand and a million."""
    samples, rng = scene(), np.random.default_rng(5)
    radiance = samples.radiance.copy()
    radiance[rng.random(radiance.shape[:3]) < 0.1] *= 10.0 ** rng.uniform(3, 6)
    run(scene(radiance=radiance), model_of(variant))


@BOTH
@pytest.mark.parametrize(
    ("picture", "most"),
    [
        (lambda y, x, rng: rng.random((10, 12, 3)), 1e-6),
        (lambda y, x, rng: np.where(x < 6, 0.2, 0.8)[..., np.newaxis] * np.ones(3), 1e-6),
        (lambda y, x, rng: (0.5 + 1e-3 * (x + y))[..., np.newaxis] * np.ones(3), 1e-5),
        (lambda y, x, rng: (0.5 + 1e-4 * (x + y))[..., np.newaxis] * np.ones(3), 1e-4),
        (lambda y, x, rng: (0.5 + 1e-5 * (x + y))[..., np.newaxis] * np.ones(3), 1e-4),
    ],
)
def test_without_noise_the_image_hardly_changes(variant, picture, most):
    """By less than 1e-4 of a radiance of 1: only what differs by about sqrt(1e-10) is averaged at all."""
    y, x = np.indices((10, 12))
    image = picture(y, x, np.random.default_rng(7)).astype(np.float32)
    for groups in ((), GROUPS):
        samples = scene(radiance=image[:, :, np.newaxis], groups=groups, still=True)
        assert np.abs(run(samples, model_of(variant)) - image).max() < most


@BOTH
def test_black_stays_black(variant):
    """A black image; then black pixels, whose variance is 0, on a surface of their own."""
    model = model_of(variant)
    np.testing.assert_array_equal(run(scene(radiance=0.0), model), 0)
    radiance, albedo = scene().radiance.copy(), np.full((10, 12, 4, 3), 0.8)
    radiance[3:7, 4:9] = albedo[3:7, 4:9] = 0
    samples = make_samples(np.random.default_rng(0), 10, 12, radiance=radiance, features={"albedo": albedo})
    assert run(samples, model)[3:7, 4:9].max() < 1e-6


@BOTH
@pytest.mark.parametrize("spp", [1, 2, 3])
def test_few_samples(variant, spp):
    """With 1 spp neighbours stand in for the variance; with 2 each pixel has two numbers."""
    samples = scene(spp=spp)
    image = run(samples, model_of(variant))
    assert image.std() < 0.5 * pixel_mean(samples.radiance).std()


@BOTH
@pytest.mark.parametrize("size", [(1, 1), (3, 2), (1, 7)])
@pytest.mark.parametrize("spp", [1, 4])
def test_images_smaller_than_window_and_patch(variant, size, spp):
    samples = scene(*size, spp)
    image = run(samples, model_of(variant, radius=27, patch_radius=3))
    if size == (1, 1):
        np.testing.assert_allclose(image, pixel_mean(samples.radiance), rtol=1e-6)


@BOTH
def test_features_without_variance_keep_their_edges(variant):
    """Two halves that albedo tells apart without any noise: nothing crosses from one to the other."""
    x = np.arange(12)
    albedo = np.broadcast_to(np.where(x < 6, 0.1, 0.9)[:, np.newaxis, np.newaxis], (10, 12, 4, 3)).copy()
    base = scene()
    radiance = base.radiance * np.where(x < 6, 1.0, 20.0)[:, np.newaxis, np.newaxis]
    samples = make_samples(np.random.default_rng(0), 10, 12, radiance=radiance, features={"albedo": albedo})
    image, mean = run(samples, model_of(variant)), pixel_mean(samples.radiance)
    assert image[:, :6].max() <= mean[:, :6].max() * (1 + ROUNDING)
    assert image[:, 6:].min() >= mean[:, 6:].min() * (1 - ROUNDING)


@BOTH
def test_without_features(variant):
    """Position and colour are left."""
    samples, model = scene(groups=()), model_of(variant)
    run(samples, model)
    assert list(mcd.lbf_analysis(samples, model).theta) == ["position", "colour"]
    run(samples, model_of(variant, groups=()))


@BOTH
def test_features_that_the_model_does_not_know_are_not_used(variant, rng):
    model, albedo = model_of(variant, groups=("albedo",)), rng.random((10, 12, 4, 3))
    features = {"albedo": albedo, "depth": rng.random((10, 12, 4)), "world_position": rng.random((10, 12, 4, 3))}
    radiance = scene().radiance
    alone, more = (
        make_samples(np.random.default_rng(0), 10, 12, radiance=radiance, features=one)
        for one in ({"albedo": albedo}, features)
    )
    np.testing.assert_array_equal(run(alone, model), run(more, model))


@BOTH
def test_constant_features_change_nothing_but_the_network(variant):
    """Their distance is 0 everywhere; with a model that looks at nothing else, so is their effect."""
    model = model_of(variant)
    blind = {name: 0 * one if name.startswith("weight") else one for name, one in model.network.parameters.items()}
    model = replace(model, network=model.network.replace(blind))
    radiance = scene().radiance
    constant = make_samples(
        np.random.default_rng(0), 10, 12, radiance=radiance, features={"albedo": np.full((10, 12, 4, 3), 0.3)}
    )
    without = make_samples(np.random.default_rng(0), 10, 12, radiance=radiance, features={})
    np.testing.assert_allclose(run(constant, model), run(without, model), rtol=1e-6)


@BOTH
@pytest.mark.parametrize("factor", [1e-38, 1e-20, 1e10, 1e15])
def test_the_range_of_float32(variant, factor):
    run(scene(radiance=(factor * scene().radiance).astype(np.float32)), model_of(variant))


@BOTH
@pytest.mark.parametrize("factor", [1e-30, 1e5, 1e14])
def test_features_of_any_size(variant, factor):
    """No feature has to be in [0, 1]; world positions have any unit."""
    rng = np.random.default_rng(3)
    features = {name: factor * rng.random((10, 12, 4, 3)) for name in ("world_position", "albedo")}
    run(make_samples(rng, 10, 12, features=features), model_of(variant))


@BOTH
def test_negative_radiance(variant):
    """Some reconstruction filters have negative lobes: a mean of negative numbers is negative."""
    samples = scene(radiance=-scene().radiance)
    run(samples, model_of(variant))
    blind = model_of(variant, sees_colour=False)
    np.testing.assert_allclose(run(samples, blind), -run(scene(), blind), rtol=1e-6)


def test_beyond_float32_there_is_a_sentence():
    with pytest.raises(ValueError, match=re.escape("must stay within 1e+30 in magnitude")):
        mcd.lbf(scene(radiance=(1e16 * scene().radiance).astype(np.float32)), model_of())


# --- switches


def test_despiked_takes_spikes_out_of_the_result():
    radiance = scene().radiance.copy()
    radiance[4, 5] = 1e6
    samples, model = scene(radiance=radiance), model_of()
    plain, cleaned = run(samples, model), run(samples, model, despiked=True)
    assert plain[4, 5].max() > 1e5
    assert cleaned[4, 5].max() < 10
    np.testing.assert_array_equal(cleaned, despike(plain, radius=1, deviations=2.0, together=True))
    untouched = (cleaned == plain).all(axis=-1)
    assert untouched.mean() > 0.7


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda s, m: mcd.lbf(s.radiance, m), "samples must be a SampleBuffer, got ndarray"),
        (lambda s, m: mcd.lbf(s, "nlm"), "model must be an LBFModel, got str. Read one with mcd.load_model, or leave it out."),
        (lambda s, m: mcd.lbf(s, m.network), "model must be an LBFModel, got MLP."),
        (lambda s, m: mcd.lbf(s, variant="median"), "variant must be one of 'cross_bilateral', 'nlm'"),
        (lambda s, m: mcd.lbf(s, m, engine="fast"), "engine must be one of 'numba', 'numpy'"),
        (lambda s, m: mcd.lbf_analysis(s, m, engine="fast"), "engine must be one of"),
    ],
)  # fmt: skip
def test_wrong_input_is_refused_in_words(call, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        call(scene(4, 4), model_of())


# --- the models of the package


@BOTH
def test_the_package_takes_noise_away_and_hardly_touches_a_clean_image(variant):
    """Flat ground in noise loses three quarters of its error or more; a noise-free picture keeps what it shows."""
    truth = np.full((24, 24, 3), 0.6, np.float32)
    noisy = scene(24, 24, groups=("world_position", "shading_normal", "albedo"), still=False)
    flat = make_samples(
        np.random.default_rng(1), 24, 24, radiance=noisy.radiance,
        features={name: np.full((24, 24, 4, 3), 0.5) for name in ("world_position", "shading_normal", "albedo")},
    )  # fmt: skip
    for samples in (noisy, flat):
        before = mcd.relmse(pixel_mean(samples.radiance), truth)
        assert mcd.relmse(run(samples, None, variant=variant), truth) < 0.5 * before
    picture = np.random.default_rng(2).random((24, 24, 1, 3))
    assert (
        np.abs(run(scene(24, 24, radiance=picture, still=True), None, variant=variant) - picture[:, :, 0]).max() < 1e-4
    )


@BOTH
@pytest.mark.parametrize("spp", [1, 2])
def test_the_package_survives_the_worst(variant, spp):
    """Fireflies, black pixels, still features, few samples, all at once."""
    radiance = scene(spp=spp).radiance.copy()
    radiance[2, 3], radiance[6:8] = 1e6, 0
    for groups in ((), ("albedo", "visibility"), GROUPS):
        run(scene(spp=spp, radiance=radiance, groups=groups, still=True), None, variant=variant)
        run(scene(spp=spp, radiance=radiance, groups=groups), None, variant=variant, despiked=True)
