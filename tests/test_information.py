"""The permutation test: it finds what is there, and takes chance for information no more often than it says."""

import re
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conftest import make_samples
from mcdenoise.study.information import holm, information, spread_corners

pytestmark = pytest.mark.ch10


def found(samples, **changes):
    return {one.name: one for one in information(samples, **changes)}


def test_what_radiance_depends_on_is_found_and_nothing_else(rng):
    """Not through a mean: the square of a number that is symmetric about 0 has no correlation with it."""
    size = (16, 16, 8)
    lens, time, light = rng.random((3, *size))
    radiance = np.repeat((lens - 0.5)[..., np.newaxis] ** 2, 3, axis=-1) + 0.01 * rng.random((*size, 3))
    params = {"lens_u": lens, "time": time, "light_u": light}
    told = found(make_samples(rng, *size, radiance=radiance, random_params=params, features={}), neighbourhoods=4)
    assert [name for name, one in told.items() if one.informative] == ["lens_u"]
    assert told["lens_u"].nats > 10 * max(abs(told["time"].nats), abs(told["light_u"].nats))


def test_chance_passes_for_information_no_more_often_than_one_in_twenty(rng):
    """60 buffers of noise, three names each: false alarms are binomial, three standard errors above 3 of 60 at most."""
    alarms = 0
    for _ in range(60):
        params = {name: rng.random((7, 7, 2)) for name in ("lens_u", "lens_v", "time")}
        samples = make_samples(rng, 7, 7, 2, random_params=params, features={})
        alarms += any(one.informative for one in information(samples, permutations=79))
    assert alarms <= 3 + 3 * np.sqrt(60 * 0.05 * 0.95)


def test_all_channels_of_a_feature_count_as_one(rng):
    albedo = rng.random((7, 7, 4, 3))
    told = found(make_samples(rng, 7, 7, 4, radiance=albedo, random_params={}, features={"albedo": albedo}))
    assert list(told) == ["albedo"]
    assert told["albedo"].kind == "features"
    assert told["albedo"].nats > 3 * 0.5  # three channels of their own, well over half a nat each


def test_many_names_need_more_shuffles(rng):
    """Twelve names: with 199 shuffles the corrected p-value of anything would be 12 / 200."""
    size = (14, 14, 4)
    params = {f"number_{k}": rng.random(size) for k in range(12)}
    radiance = np.repeat(params["number_3"][..., np.newaxis], 3, axis=-1)
    told = found(make_samples(rng, *size, radiance=radiance, random_params=params, features={}))
    assert [name for name, one in told.items() if one.informative] == ["number_3"]


def test_the_same_seed_gives_the_same(samples):
    assert information(samples, permutations=9) == information(samples, permutations=9)


def test_a_buffer_of_radiance_alone_has_nothing_to_test(rng):
    assert information(make_samples(rng, random_params={}, features={})) == []


@pytest.mark.parametrize("name", ["neighbourhoods", "permutations", "box"])
def test_numbers_are_checked(samples, name):
    with pytest.raises(ValueError, match=re.escape(f"{name} must be at least 1, got 0.")):
        information(samples, **{name: 0})


@given(st.integers(1, 60), st.integers(1, 60), st.integers(1, 80), st.integers(1, 12))
def test_boxes_lie_in_the_image_and_not_on_each_other(height, width, number, box):
    corners = spread_corners(height, width, number, box)
    rows, columns = sorted({y for y, _ in corners}), sorted({x for _, x in corners})
    assert len(set(corners)) == len(corners) == len(rows) * len(columns) <= max(number, 1)
    for starts, side in ((rows, height), (columns, width)):
        assert starts[0] >= 0
        assert starts[-1] + min(box, side) <= side
        assert all(b - a >= box for a, b in pairwise(starts))


@given(st.lists(st.floats(0.001, 1), max_size=8))
def test_holm_keeps_the_order_and_never_says_more(p_values):
    corrected = holm(p_values)
    assert all(p <= q <= min(1.0, len(p_values) * p) + 1e-12 for p, q in zip(p_values, corrected, strict=True))
    order = np.argsort(p_values, kind="stable")
    assert np.all(np.diff(np.array(corrected)[order]) >= 0)
