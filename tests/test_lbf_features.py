"""What the filter compares (primary features) and what the network sees (secondary features)."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage, stats

from conftest import make_samples, noise
from mcdenoise.filters import nlm, noise_variance, prefilter_features
from mcdenoise.filters.prefilter import prefilter_feature
from mcdenoise.lbf.mad import NORMAL_MEDIAN, _median_4x4, mad
from mcdenoise.lbf.primary import GROUPS, Primary, primary_features, scene_frame, two_buffer_variance
from mcdenoise.lbf.secondary import (
    KINDS,
    colour_group,
    deviation_3x3,
    gradient,
    mean_7x7,
    secondary_features,
    secondary_names,
    std_7x7,
)
from mcdenoise.samples import pixel_mean, variance_of_mean

pytestmark = pytest.mark.ch09

SIZES = given(st.integers(1, 12), st.integers(1, 12))


def five_groups(rng, height=9, width=10, spp=4, **changes):
    """Samples with every group; world positions on a grid of 1/256, so that moving the world rounds nothing."""
    size = (height, width, spp)
    features = {
        "visibility": rng.integers(0, 2, size),
        "albedo": rng.random((*size, 3)),
        "shading_normal": rng.normal(size=(*size, 3)),
        "world_position": rng.integers(-512, 512, (*size, 3)) / 256,
        "albedo_2": rng.random((*size, 3)),
    }
    return make_samples(rng, *size, features={**features, **changes})


def windows(plane, radius):
    """Each pixel's window, clipped at the borders."""
    for y, x in np.ndindex(plane.shape):
        yield y, x, plane[max(y - radius, 0) : y + radius + 1, max(x - radius, 0) : x + radius + 1].astype(np.float64)


def slow_around(plane, radius, function):
    result = np.empty(plane.shape)
    for y, x, window in windows(plane, radius):
        result[y, x] = function(window)
    return result


def slow_gradient(plane):
    padded, result = np.pad(plane, 1, mode="edge"), np.empty(plane.shape)
    for y, x in np.ndindex(plane.shape):
        window = padded[y : y + 3, x : x + 3]
        gx = (window[:, 2].sum() - window[:, 0].sum()) / 9
        gy = (window[2].sum() - window[0].sum()) / 9
        result[y, x] = (gx**2 + gy**2) / 2
    return result


def mirrored(place, size):
    """The place inside that a place outside shows: 1 for -1, 2 for -2, ..."""
    place = abs(place) % max(2 * (size - 1), 1)
    return min(place, 2 * (size - 1) - place)


def slow_mad(plane):
    height, width = plane.shape
    noise_of = np.empty(plane.shape)
    for y, x in np.ndindex(plane.shape):
        rows = [mirrored(y + dy, height) for dy in range(-4, 4)]
        columns = [mirrored(x + dx, width) for dx in range(-4, 4)]
        block = plane[np.ix_(rows, columns)]
        coefficient = np.abs(block[::2, 1::2] + block[1::2, ::2] - block[::2, ::2] - block[1::2, 1::2]) / 2
        noise_of[y, x] = np.median(coefficient) / 0.6745
    cells = np.empty(plane.shape)
    for y, x in np.ndindex(plane.shape):
        cells[y, x] = noise_of[y // 2 * 2 : y // 2 * 2 + 2, x // 2 * 2 : x // 2 * 2 + 2].mean()
    return slow_around(cells, 1, np.max)


SLOW = {
    mad: slow_mad,
    mean_7x7: lambda plane: slow_around(plane, 3, np.mean),
    std_7x7: lambda plane: slow_around(plane, 3, lambda window: window.std(ddof=1) if window.size > 1 else 0.0),
    deviation_3x3: lambda plane: slow_around(plane, 1, lambda window: np.abs(window - window.mean()).mean()),
    gradient: slow_gradient,
}


@SIZES
def test_each_kind_is_its_definition_at_every_size(height, width):
    image = noise(height, width, 2, seed=height).astype(np.float32)
    for kind, slow in SLOW.items():
        result = kind(image)
        assert result.dtype == np.float32
        assert result.shape == image.shape
        for channel in range(2):
            expected = slow(image[..., channel].astype(np.float64))
            np.testing.assert_allclose(result[..., channel], expected, rtol=2e-6, atol=2e-7, err_msg=kind.__name__)


def test_scipy_agrees():
    """Whole windows for the means (SciPy pads, we clip), everywhere for those that repeat edges."""
    plane = noise(20, 23)
    inside = np.s_[3:-3, 3:-3]
    mean, square = (ndimage.uniform_filter(p, 7) for p in (plane, plane**2))
    np.testing.assert_allclose(mean_7x7(plane[..., None])[inside][..., 0], mean[inside], rtol=1e-6)
    spread = np.sqrt((square - mean**2) * 49 / 48)
    np.testing.assert_allclose(std_7x7(plane[..., None])[inside][..., 0], spread[inside], rtol=1e-6)
    squares = (ndimage.prewitt(plane, axis, mode="nearest") ** 2 for axis in (0, 1))
    np.testing.assert_allclose(gradient(plane[..., None])[..., 0], sum(squares) / 162, rtol=1e-6)
    deviations = ndimage.generic_filter(plane, lambda window: np.abs(window - window.mean()).mean(), 3)
    np.testing.assert_allclose(deviation_3x3(plane[..., None])[1:-1, 1:-1, 0], deviations[1:-1, 1:-1], rtol=1e-6)


@pytest.mark.parametrize("level", [0.0, 0.1, 1e6])
def test_flat_ground_is_quiet(level):
    image = np.full((11, 9, 3), level, np.float32)
    for kind in (mad, std_7x7, deviation_3x3, gradient):
        np.testing.assert_array_equal(kind(image), np.zeros(image.shape), err_msg=kind.__name__)
    np.testing.assert_allclose(mean_7x7(image), image, rtol=1e-6)


def test_a_ramp():
    """f = 3 x + 4 y: gx = 2 * 3 / 3 and gy = 2 * 4 / 3; no diagonal difference; deviation and spread of a plane."""
    y, x = np.mgrid[:12, :14]
    image = (3.0 * x + 4.0 * y)[..., None]
    np.testing.assert_allclose(gradient(image)[1:-1, 1:-1], (2**2 + (8 / 3) ** 2) / 2, rtol=1e-6)
    np.testing.assert_array_equal(mad(image)[4:-4, 4:-4], 0)
    np.testing.assert_allclose(std_7x7(image)[3:-3, 3:-3], np.sqrt((9 + 16) * 4 * 49 / 48), rtol=1e-6)
    np.testing.assert_allclose(mean_7x7(image)[3:-3, 3:-3], image[3:-3, 3:-3], rtol=1e-6)
    along_x = (3.0 * x)[..., None]
    np.testing.assert_allclose(deviation_3x3(along_x)[1:-1, 1:-1], 3 * 2 / 3, rtol=1e-6)


def test_a_checkerboard_is_all_diagonal():
    """Each coefficient is abs(2 * 0.5 + 0.5 - ...) = 1, also where the board is mirrored."""
    board = (np.indices((9, 12)).sum(axis=0) % 2)[..., None]
    np.testing.assert_allclose(mad(board), 1 / NORMAL_MEDIAN, rtol=1e-6)
    np.testing.assert_allclose(gradient(board)[1:-1, 1:-1], 0, atol=1e-12)


def test_the_median_of_white_noise_is_its_deviation():
    """Within 5 standard errors, before cells and neighbours; blocks of 8 x 8 pixels are independent.

    The 8th and 9th of 16 are a little more than the median: the quantile of a beta variable, 1.9 % more.
    """
    ranks = (stats.beta(k, 17 - k).expect(stats.halfnorm(scale=0.3).ppf) for k in (8, 9))
    expected = sum(ranks) / 2
    coefficient = np.abs(np.random.default_rng(5).normal(scale=0.3, size=(406, 406)))
    medians = _median_4x4(coefficient)[::8, ::8]
    error = medians.std() / np.sqrt(medians.size)
    assert abs(medians.mean() - expected) < 5 * error
    assert error < 0.01 * expected
    estimate = mad(np.random.default_rng(6).normal(scale=0.3, size=(200, 200, 1)))
    assert abs(estimate.mean() / 0.3 - 1.11) < 0.02


def test_a_straight_edge_is_no_noise():
    image = np.where(np.arange(20) < 9, 0.2, 0.8)[:, None, None] * np.ones((20, 16, 1))
    np.testing.assert_allclose(mad(image), 0, atol=1e-7)
    assert std_7x7(image).max() > 0.2


def test_small_spread_on_a_large_value():
    """A difference of squares in float32 would have no digit left."""
    grid = np.random.default_rng(2).integers(0, 8, (20, 20, 1)) / 1024
    np.testing.assert_allclose(std_7x7((grid + 4096).astype(np.float32)), std_7x7(grid), rtol=1e-6)


def test_names_are_in_the_order_of_the_network():
    names = secondary_names(GROUPS)
    assert len(names) == 36
    assert names[30] == "sampling rate"
    assert [names[k] for k in (0, 5, 10, 15, 20, 25, 31)] == [
        f"{kind} world_position" for kind in ("mad", "mean", "std", "mean 7x7", "std 7x7", "deviation 3x3", "gradient")
    ]
    assert names[4] == "mad visibility"
    assert names[35] == "gradient visibility"
    assert secondary_names(["visibility", "albedo"]) == secondary_names(["albedo", "visibility"])
    assert secondary_names([]) == ["sampling rate"]


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        (["depth"], "groups has no 'depth'; there is: world_position, shading_normal, albedo, albedo_2, visibility"),
        ("albedo", "groups must be a list of names"),
        (["albedo", "albedo"], "groups must not name anything twice"),
    ],
)
def test_what_is_no_group_has_no_name(groups, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        secondary_names(groups)


def test_each_column_is_what_its_name_says(rng):
    primary = primary_features(five_groups(rng))
    inputs = secondary_features(primary)
    assert inputs.shape == (9, 10, 36)
    assert inputs.dtype == np.float32
    columns = dict(zip(secondary_names(primary.groups), np.moveaxis(inputs, -1, 0), strict=True))
    np.testing.assert_array_equal(columns.pop("sampling rate"), 0.25)
    for group in GROUPS:
        raw, feature, variance = (a[group] for a in (primary.raw, primary.features, primary.variances))
        expected = {"mad": mad(raw), "mean": feature, "std": np.sqrt(variance), "gradient": gradient(feature)}
        around = {"mean 7x7": mean_7x7, "std 7x7": std_7x7, "deviation 3x3": deviation_3x3}
        expected |= {kind: function(feature) for kind, function in around.items()}
        for kind, image in expected.items():
            mean = image.astype(np.float64).mean(axis=-1)
            np.testing.assert_allclose(columns.pop(f"{kind} {group}"), mean, rtol=1e-6, atol=1e-7)
    assert not columns


def test_only_the_groups_that_the_samples_have(rng):
    samples = make_samples(rng)  # visibility before albedo, no normals, no second hit
    primary = primary_features(samples)
    assert primary.groups == ("world_position", "albedo", "visibility")
    assert list(primary.raw) == list(primary.features) == list(primary.variances) == list(primary.groups)
    assert secondary_features(primary).shape == (5, 7, 22)
    assert primary_features(samples, ["visibility", "albedo"]).groups == ("albedo", "visibility")
    none = primary_features(samples, [])
    assert none.groups == ()
    np.testing.assert_array_equal(secondary_features(none), np.full((5, 7, 1), 0.25))
    own = make_samples(rng, features={"depth": np.ones((5, 7, 4))})
    assert primary_features(own).groups == ()


@pytest.mark.parametrize("spp", [1, 2, 3])
@pytest.mark.parametrize("size", [(1, 1), (1, 5), (6, 2)])
def test_few_samples_and_small_images(rng, spp, size):
    primary = primary_features(five_groups(rng, *size, spp))
    for arrays in (primary.raw, primary.features, primary.variances):
        assert {name: a.shape for name, a in arrays.items()} == {
            group: (*size, 1 if group == "visibility" else 3) for group in GROUPS
        }
        assert all(a.dtype == np.float32 and np.isfinite(a).all() for a in arrays.values())
    assert all((a >= 0).all() for a in primary.variances.values())
    assert primary.colour.dtype == primary.colour_variance.dtype == np.float32
    inputs = secondary_features(primary)
    assert inputs.shape == (*size, 36)
    assert np.isfinite(inputs).all()


def test_colour_is_not_filtered_and_features_are(rng):
    samples = five_groups(rng)
    primary = primary_features(samples)
    np.testing.assert_array_equal(primary.colour, pixel_mean(samples.radiance))
    np.testing.assert_array_equal(primary.raw["albedo"], pixel_mean(samples["albedo"]))
    np.testing.assert_array_equal(primary.raw["visibility"][..., 0], pixel_mean(samples["visibility"]))
    feature, variance = prefilter_feature(pixel_mean(samples["albedo"]), two_buffer_variance(samples["albedo"]))
    np.testing.assert_array_equal(primary.features["albedo"], feature)
    np.testing.assert_array_equal(primary.variances["albedo"], variance)


def test_one_prefilter_serves_both(rng, engine):
    samples = make_samples(rng)
    features, variances = prefilter_features(samples, engine=engine)
    for name in samples.feature_names:
        mean, variance = pixel_mean(samples[name]), noise_variance(samples[name], radius=0)
        feature, left = prefilter_feature(mean, variance, engine)
        np.testing.assert_array_equal(features[name], feature)
        np.testing.assert_array_equal(variances[name], left)
        dials = {"search_radius": 5, "patch_radius": 3, "k": 1.0, "weight_radius": 2, "cancellation": 0.0}
        np.testing.assert_allclose(feature, nlm(mean, variance, **dials, engine=engine), rtol=1e-6)


def test_a_spike_in_the_variance_of_colour_goes(rng):
    samples = make_samples(rng, 20, 20)
    radiance = samples.radiance.copy()
    radiance[7, 8, 2, 0] = 1e4  # in one channel: all three channels of the variance are replaced
    spiky = make_samples(rng, 20, 20, radiance=radiance)
    before, after = two_buffer_variance(radiance), primary_features(spiky, []).colour_variance
    np.testing.assert_array_equal(np.argwhere((before != after).any(axis=-1)), [[7, 8]])
    np.testing.assert_array_equal(after[7, 8], np.median(before[6:9, 7:10].reshape(9, 3), axis=0))


@pytest.mark.parametrize("change", [lambda p: 1024 * p, lambda p: p / 1024, lambda p: np.add(p, [64, -128, 32])])
def test_unit_and_origin_of_the_world_change_nothing(rng, change):
    samples = five_groups(rng)
    moved = five_groups(rng, world_position=change(samples["world_position"]))
    here, there = (primary_features(s, ["world_position"]) for s in (samples, moved))
    for name in ("raw", "features", "variances"):
        np.testing.assert_array_equal(getattr(here, name)["world_position"], getattr(there, name)["world_position"])
    np.testing.assert_array_equal(secondary_features(here), secondary_features(there))
    distance = np.linalg.norm(here.raw["world_position"], axis=-1)
    assert np.median(distance) == pytest.approx(1, rel=1e-6)


def test_a_far_away_point_and_misses_do_not_set_the_unit():
    position = np.zeros((1, 6, 2, 3), np.float32)
    position[0, :, :, 1] = np.array([1, 2, 3, 4, 5, 1e6])[:, None]
    hit = np.ones((1, 6, 2), bool)
    centre, size = scene_frame(position, hit)
    np.testing.assert_array_equal(centre, [0, 3.5, 0])
    assert size == 1.5
    hit[0, 5, 1] = False
    assert scene_frame(position, hit)[1] == 1
    np.testing.assert_array_equal(scene_frame(position, ~hit)[0], [0, 3.5, 0])  # no pixel hit throughout: all of them
    assert scene_frame(0 * position, hit)[1] == 1


@pytest.mark.parametrize("spp", [2, 3, 4, 7])
def test_two_buffers_by_the_formula(spp):
    samples = noise(12, 25, spp, 2)
    half = spp // 2
    a, b = samples[:, :, :half].mean(axis=2), samples[:, :, half : 2 * half].mean(axis=2)
    buffer_var, sample_var = (b - a) ** 2 / 4 * (2 * half / spp), samples.var(axis=2, ddof=1) / spp
    for channel in range(2):
        boxes = [slow_around(v[..., channel], 10, np.mean) for v in (buffer_var, sample_var)]
        expected = sample_var[..., channel] * boxes[0] / (boxes[1] + 1e-10)
        np.testing.assert_allclose(two_buffer_variance(samples)[..., channel], expected, rtol=1e-5)
    np.testing.assert_array_equal(two_buffer_variance(samples[..., 0]), two_buffer_variance(samples)[..., 0])


@pytest.mark.parametrize("spp", [2, 3, 8, 9])
def test_two_buffers_find_the_variance_of_independent_samples(spp):
    """Within 5 standard errors: each half-difference squared is a variance with one degree of freedom."""
    samples = 2 + np.random.default_rng(spp).normal(scale=0.5, size=(100, 100, spp))
    estimate = two_buffer_variance(samples).mean()
    expected = 0.25 / spp
    assert abs(estimate / expected - 1) < 5 * np.sqrt(2 / 100**2)


def test_halves_that_agree_have_no_variance():
    samples = noise(6, 7, 4)
    np.testing.assert_array_equal(two_buffer_variance(np.concatenate([samples, samples], axis=2)), np.zeros((6, 7)))
    two = noise(6, 7, 2)  # two samples: both estimates are the same number
    np.testing.assert_allclose(two_buffer_variance(two), variance_of_mean(two), rtol=1e-6)


@pytest.mark.parametrize("spp", [1, 2, 3, 8])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_constant_samples_have_no_variance(spp, dtype):
    variance = two_buffer_variance(np.full((5, 6, spp, 3), 0.1, dtype))
    assert variance.dtype == dtype
    np.testing.assert_array_equal(variance, np.zeros((5, 6, 3)))


def test_one_sample_takes_its_neighbours():
    samples = noise(6, 7, 1, 3)
    np.testing.assert_array_equal(two_buffer_variance(samples), noise_variance(samples, radius=1))


@pytest.mark.parametrize(
    ("function", "value", "message"),
    [
        (two_buffer_variance, np.ones((3, 4)), "samples must have shape (h, w, spp) or (h, w, spp, c)"),
        (two_buffer_variance, np.full((3, 4, 2), np.inf), "samples must be finite"),
        (two_buffer_variance, noise(3, 4, 2) * 1e20, "image must stay within 1e+30 in magnitude"),
        (primary_features, np.ones((3, 4, 2, 3)), "samples must be a SampleBuffer, got ndarray"),
        (secondary_features, np.ones((3, 4, 3)), "primary must be a Primary, got ndarray"),
    ],
)
def test_what_is_neither_samples_nor_primary_is_refused(function, value, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        function(value)


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        (["shading_normal"], "groups has no 'shading_normal'; there is: world_position, albedo, visibility"),
        (["radiance"], "groups has no 'radiance'"),
        ("albedo", "groups must be a list of names"),
        (["albedo", "albedo"], "groups must not name anything twice"),
    ],
)
def test_groups_that_the_samples_lack_are_refused(samples, groups, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        primary_features(samples, groups)


def test_select_keeps_the_named_groups(samples):
    primary = primary_features(samples)
    chosen = primary.select(["visibility", "albedo"])
    assert chosen.groups == ("albedo", "visibility")
    np.testing.assert_array_equal(chosen.features["albedo"], primary.features["albedo"])
    np.testing.assert_array_equal(
        secondary_features(chosen), secondary_features(primary_features(samples, chosen.groups))
    )
    with pytest.raises(ValueError, match=re.escape("groups has no 'albedo_2'; there is: world_position, albedo")):
        primary.select(["albedo_2"])


def test_a_primary_is_frozen(samples):
    primary = primary_features(samples)
    assert isinstance(primary, Primary)
    with pytest.raises(AttributeError):
        primary.spp = 5


def test_colour_is_one_more_group_for_the_network_alone(rng):
    primary = primary_features(five_groups(rng))
    names, values = secondary_names([*primary.groups, "colour"]), secondary_features(primary, colour=True)
    assert len(names) == 43
    assert values.shape == (9, 10, 43)
    own = [k for k, name in enumerate(names) if "colour" in name]
    assert [names[k] for k in own] == [f"{kind} colour" for kind in KINDS]
    np.testing.assert_array_equal(np.delete(values, own, axis=-1), secondary_features(primary))
    raw, filtered, variance = colour_group(primary)
    np.testing.assert_allclose(raw, np.log1p(primary.colour), rtol=1e-6)
    expected = prefilter_feature(raw, primary.colour_variance / (1 + primary.colour) ** 2)
    np.testing.assert_array_equal(filtered, expected[0])
    np.testing.assert_array_equal(variance, expected[1])
    np.testing.assert_allclose(values[..., own[1]], filtered.mean(axis=-1), rtol=1e-5)


def test_colour_below_zero_counts_as_black():
    black = Primary(np.full((2, 2, 3), -5.0, np.float32), np.zeros((2, 2, 3), np.float32), {}, {}, {}, spp=4)
    np.testing.assert_array_equal(colour_group(black)[0], 0)
    assert secondary_features(black, colour=True).shape == (2, 2, 8)
