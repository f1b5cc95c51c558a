"""SampleBuffer: shapes, names, selection, crops, and every message of the gate."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conftest import make_samples
from mcdenoise.samples import SampleBuffer
from mcdenoise.samples.layout import FEATURES, RANDOM_PARAMS, Layout

pytestmark = pytest.mark.ch01


def test_arrays_are_float32_and_named(samples):
    assert samples.radiance.dtype == samples.features.dtype == np.float32
    assert (samples.height, samples.width, samples.spp) == (5, 7, 4)
    assert samples.random_param_names == ("lens_u", "lens_v")
    assert samples.feature_names == ("world_position", "visibility", "albedo")
    assert samples.features.shape == (5, 7, 4, 7)
    assert samples["albedo"].shape == (5, 7, 4, 3)
    assert samples["visibility"].shape == samples["lens_v"].shape == (5, 7, 4)


def test_a_name_is_a_view_of_its_columns(samples):
    np.testing.assert_array_equal(samples["albedo"], samples.features[..., 4:7])
    np.testing.assert_array_equal(samples["lens_v"], samples.random_params[..., 1])
    assert np.shares_memory(samples["albedo"], samples.features)
    assert samples["radiance"] is samples.radiance
    assert samples["hit"].all()


def test_buffer_keeps_what_it_was_given(rng):
    albedo = rng.random((2, 3, 4, 3)).astype(np.float32)
    samples = make_samples(rng, 2, 3, 4, features={"albedo": albedo})
    np.testing.assert_array_equal(samples["albedo"], albedo)


def test_buffer_is_frozen_and_does_not_share(rng):
    radiance = np.ones((2, 3, 4, 3), np.float32)
    samples = make_samples(rng, 2, 3, 4, radiance=radiance)
    radiance[:] = 7
    assert samples.radiance.max() == 1
    with pytest.raises(ValueError, match="read-only"):
        samples.radiance[0] = 0
    with pytest.raises(ValueError, match="read-only"):
        samples["albedo"][0] = 0
    with pytest.raises(dataclasses.FrozenInstanceError):
        samples.radiance = radiance
    with pytest.raises(TypeError):
        samples.provenance["seed"] = 2


def test_foreign_names_and_no_names_are_welcome(rng):
    samples = make_samples(rng, 2, 3, 4, random_params=None, features={"depth": rng.random((2, 3, 4))})
    assert samples.random_params.shape == (2, 3, 4, 0)
    assert samples["depth"].shape == (2, 3, 4)


def test_unknown_name_lists_what_there_is(samples):
    with pytest.raises(KeyError, match=r"no 'albdo'.*lens_u.*albedo"):
        samples["albdo"]


def test_repr_and_layout_read_well(samples):
    assert repr(samples) == (
        "SampleBuffer(5 x 7 pixels, 4 spp; random_params: lens_u, lens_v; features: world_position, visibility, albedo)"
    )
    assert "scene units" in str(samples.layout)
    assert str(samples.layout).count("\n") == 5


@pytest.mark.parametrize(
    ("random_params", "features", "names"),
    [
        (None, None, ("lens_u", "lens_v", "world_position", "visibility", "albedo")),
        ([], ["albedo"], ("albedo",)),
        (["lens_v"], ["albedo", "world_position"], ("lens_v", "albedo", "world_position")),
        (None, [], ("lens_u", "lens_v")),
    ],
)
def test_select_keeps_the_named(samples, random_params, features, names):
    chosen = samples.select(random_params=random_params, features=features)
    assert chosen.random_param_names + chosen.feature_names == names
    for name in names:
        np.testing.assert_array_equal(chosen[name], samples[name])
    assert chosen.radiance is samples.radiance


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["normal"], "has no 'normal'"),
        ("albedo", "must be a list of names"),
        (["albedo", "albedo"], "not name anything twice"),
    ],
)
def test_select_refuses(samples, names, message):
    with pytest.raises(ValueError, match=message):
        samples.select(features=names)


@given(
    y=st.integers(0, 4),
    x=st.integers(0, 6),
    height=st.integers(1, 5),
    width=st.integers(1, 7),
    seed=st.integers(0, 2**32 - 1),
)
def test_crop_moves_screen_positions_with_the_corner(y, x, height, width, seed):
    samples = make_samples(np.random.default_rng(seed))
    height, width = min(height, 5 - y), min(width, 7 - x)
    crop = samples.crop(y, x, height, width)
    assert crop.radiance.shape == (height, width, 4, 3)
    np.testing.assert_array_equal(crop["albedo"], samples["albedo"][y : y + height, x : x + width])
    np.testing.assert_array_equal(
        crop.screen_position + np.float32([x, y]), samples.screen_position[y : y + height, x : x + width]
    )
    assert crop.provenance["crop_origin"] == [y, x]
    rebuilt = SampleBuffer.from_arrays(crop.radiance, crop.screen_position)
    np.testing.assert_array_equal(rebuilt.screen_position, crop.screen_position)


def test_a_crop_of_a_crop_counts_from_the_first_image(samples):
    assert samples.crop(1, 2, 4, 5).crop(1, 1, 2, 2).provenance["crop_origin"] == [2, 3]


@pytest.mark.parametrize(
    ("window", "message"),
    [
        ((0, 0, 6, 1), "inside the image of 5 rows and 7 columns"),
        ((0, 6, 1, 2), "columns 6 to 8"),
        ((-1, 0, 1, 1), "y must be at least 0, got -1"),
        ((0, 0, 0, 1), "height must be at least 1"),
        ((0, 0, 1, 1.5), "width must be a whole number, got 1.5"),
    ],
)
def test_crop_refuses(samples, window, message):
    with pytest.raises(ValueError, match=message):
        samples.crop(*window)


def test_subsets_are_the_same_scene_at_fewer_spp(samples):
    first, last = samples.subset(0, 1), samples.subset(1, 4)
    assert (first.spp, last.spp) == (1, 3)
    assert last.layout == samples.layout
    np.testing.assert_array_equal(np.concatenate([first.radiance, last.radiance], axis=2), samples.radiance)
    np.testing.assert_array_equal(last["albedo"], samples["albedo"][:, :, 1:])
    assert last.provenance["subset"] == [1, 4]


@pytest.mark.parametrize(
    ("window", "message"),
    [
        ((2, 2), "stop must be at least 3, got 2"),
        ((0, 5), "at most the 4 spp of these samples, got 5"),
        ((-1, 2), "start must be at least 0"),
        ((0, 2.0), "stop must be a whole number"),
    ],
)
def test_subset_refuses(samples, window, message):
    with pytest.raises(ValueError, match=message):
        samples.subset(*window)


SIZE = (5, 7, 4)


def _with(array, index, value):
    array = np.array(array, float)
    array[index] = value
    return array


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radiance": np.ones((5, 7, 3))}, r"radiance must have shape \(h, w, spp, 3\).*got \(5, 7, 3\)"),
        ({"radiance": np.ones((5, 7, 0, 3))}, "none of them 0"),
        ({"radiance": [["a"]]}, "real-valued numeric array, got dtype <U1"),
        ({"radiance": [[1.0], [1.0, 2.0]]}, "rectangular numeric array"),
        ({"radiance": np.ones((*SIZE, 3), complex)}, "got dtype complex128"),
        ({"radiance": np.full((*SIZE, 3), 1e39)}, "radiance as float32 must be finite"),
        (
            {"screen_position": np.ones((*SIZE, 3))},
            r"screen_position must have shape \(h, w, spp, 2\) = \(5, 7, 4, 2\)",
        ),
        ({"random_params": {"lens_u": np.ones((5, 7, 3))}}, r"random_params 'lens_u' must have shape \(h, w, spp\)"),
        ({"random_params": {"lens_u": np.full(SIZE, -0.1)}}, r"lie in \[0, 1\], got -0.1"),
        ({"random_params": {"albedo": np.ones(SIZE)}}, "plain word that is not taken"),
        ({"features": {"albedo": np.ones((*SIZE, 2))}}, r"features 'albedo' must have shape \(h, w, spp, 3\)"),
        ({"features": {"albedo": np.ones(SIZE)}}, r"features 'albedo' must have shape \(h, w, spp, 3\)"),
        ({"features": {"my depth": np.ones(SIZE)}}, "must be a plain word"),
        ({"features": {"radiance": np.ones(SIZE)}}, "must be a plain word"),
        ({"features": {"depth": np.ones((*SIZE, 0))}}, "channels"),
        ({"features": {"depth": np.ones(SIZE)}, "random_params": {"depth": np.ones(SIZE)}}, "not both: depth"),
        ({"hit": np.ones((5, 7), bool)}, r"hit must be bool .* \(5, 7, 4\), got bool of \(5, 7\)"),
        ({"hit": np.full(SIZE, 2)}, "hit must be bool"),
        ({"provenance": {"scene": object()}}, "provenance must hold what JSON can"),
        ({"nonfinite": "ignore"}, "nonfinite must be one of 'raise', 'zero', got 'ignore'"),
    ],
)
def test_gate_says_what_is_needed_and_what_came(rng, changes, message):
    with pytest.raises(ValueError, match=message):
        make_samples(rng, **changes)


def test_exchanged_axes_are_noticed(rng):
    samples = make_samples(rng)
    with pytest.raises(ValueError, match=r"row 0, column 1.*Are x and y exchanged"):
        make_samples(rng, screen_position=samples.screen_position[..., ::-1])


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_nonfinite_is_refused_or_zeroed_as_asked(rng, bad):
    radiance = _with(np.ones((*SIZE, 3)), (1, 2, 3, 0), bad)
    with pytest.raises(ValueError, match=r"radiance must be finite: 1 of 420 .* \(1, 2, 3, 0\).*nonfinite='zero'"):
        make_samples(rng, radiance=radiance)
    samples = make_samples(rng, radiance=radiance, nonfinite="zero")
    assert samples.radiance[1, 2, 3].tolist() == [0, 1, 1]
    assert np.isnan(radiance[1, 2, 3, 0]) or np.isinf(radiance[1, 2, 3, 0])


def test_layout_knows_the_house_names():
    layout = Layout.of({name: channels for name, (channels, _) in RANDOM_PARAMS.items()}, {"albedo": 3})
    assert [field.start for field in layout.random_params] == list(range(7))
    assert layout.features[0].unit == FEATURES["albedo"][1]
