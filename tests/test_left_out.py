"""Samples left out judge the others: the estimate is unbiased, and the simplest that is as good is chosen."""

import re

import numpy as np
import pytest

from conftest import make_samples
from mcdenoise.samples import pixel_mean
from mcdenoise.study.choice import how_sure, simplest_like_best, tile_means
from mcdenoise.study.left_out import LeftOut

pytestmark = pytest.mark.ch10


def flat(rng, spp, side=48, noise=0.5):
    return make_samples(rng, side, side, spp, radiance=2 + noise * rng.normal(size=(side, side, spp, 3)))


@pytest.mark.parametrize(("spp", "parts"), [(2, 2), (3, 3), (8, 4), (10, 4)])
def test_the_truth_has_no_error_but_the_noise_of_the_parts(rng, spp, parts):
    left_out = LeftOut.of(flat(rng, spp))
    assert len(left_out.rests) == parts
    errors = left_out.error_map([np.full((48, 48, 3), 2.0)] * parts) - left_out.noise
    assert abs(errors.mean()) < 3 * errors.std() / np.sqrt(errors.size)


def test_a_biased_filter_shows_its_bias(rng):
    """Truth 2, answer 2.3: the relative error is 0.3^2 / (2^2 + 0.01)."""
    left_out = LeftOut.of(flat(rng, 8))
    errors = left_out.error_map([np.full((48, 48, 3), 2.3)] * 4) - left_out.noise
    assert errors.mean() == pytest.approx(0.09 / 4.01, abs=3 * errors.std() / 48)


def test_a_filter_is_run_on_each_rest(rng):
    samples = flat(rng, 8, side=16)
    left_out = LeftOut.of(samples)
    means = [pixel_mean(samples.without(first, first + 2).radiance) for first in (0, 2, 4, 6)]
    np.testing.assert_array_equal(left_out.error_of(lambda rest: pixel_mean(rest.radiance)), left_out.error_map(means))


def test_the_error_is_the_mean_over_the_parts(rng):
    left_out = LeftOut.of(flat(rng, 8, side=16))
    images = [np.full((16, 16, 3), value) for value in (1.8, 1.9, 2.0, 2.1)]
    parts = [left_out.part_error(part, image) for part, image in enumerate(images)]
    np.testing.assert_allclose(left_out.error_map(images), np.mean(parts, axis=0), rtol=1e-12)


def test_what_is_left_and_what_is_left_out_are_all_samples(samples):
    rest = samples.without(1, 3)
    for name in ("radiance", "random_params", "features", "screen_position", "hit"):
        np.testing.assert_array_equal(getattr(rest, name), getattr(samples, name)[:, :, [0, 3]])
        assert not getattr(rest, name).flags.writeable
    assert rest.provenance["left_out"] == [1, 3]


@pytest.mark.parametrize(
    ("span", "message"),
    [
        ((0, 4), "A sample must be left, got start 0 and stop 4 of 4 spp."),
        ((2, 5), "stop must be at most the 4 spp of these samples, got 5."),
        ((1, 1), "stop must be at least 2, got 1."),
    ],
)
def test_a_span_that_cannot_be_left_out_is_refused(samples, span, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        samples.without(*span)


def test_one_sample_cannot_be_cut(rng):
    with pytest.raises(ValueError, match=re.escape("At least 2 spp are needed")):
        LeftOut.of(flat(rng, 1, side=4))


@pytest.mark.parametrize(("side", "tiles"), [(16, 4), (32, 16), (63, 49), (64, 16), (128, 64), (7, 1)])
def test_tiles_cover_the_image(rng, side, tiles):
    errors = rng.random((side, side))
    means = tile_means(errors)
    assert len(means) == tiles
    if side % 8 == 0:
        assert means.mean() == pytest.approx(errors.mean())


def test_a_difference_that_all_tiles_share_counts_however_much_tiles_differ(rng):
    """0.01 better in every tile is better, though tiles differ a hundred times as much; unpaired it would drown."""
    hard = rng.uniform(0, 1, 40)
    assert simplest_like_best(np.array([hard + 0.01, hard])).chosen == 1


def test_a_difference_that_some_tiles_turn_round_does_not_count(rng):
    hard, noise = rng.uniform(0, 1, (2, 40))
    errors = np.array([hard, hard - 1e-3 + 0.1 * (noise - noise.mean())])
    found = simplest_like_best(errors)
    assert (found.best, found.chosen) == (1, 0)
    assert found.behind[0] == pytest.approx(1e-3)
    assert found.standard_error[0] == pytest.approx(0.1 * noise.std(ddof=1) / np.sqrt(40))


def test_what_is_slower_and_worse_is_not_chosen(rng):
    noise = 0.1 * rng.normal(size=40)
    errors = np.array([np.full(40, 0.5), 0.5 - 1e-3 + noise - noise.mean()])
    assert simplest_like_best(errors).chosen == 0
    assert simplest_like_best(errors, seconds=[1.0, 2.0]).chosen == 0
    assert simplest_like_best(errors, seconds=[2.0, 1.0]).chosen == 1


def test_the_closer_the_call_the_less_sure(rng):
    hard, noise = rng.uniform(0, 1, (2, 40))
    noise -= noise.mean()
    just_one = noise.std(ddof=1) / np.sqrt(40)  # standard error: the choice hangs by a hair
    clear, close = (np.array([hard + gap * just_one + noise, hard]) for gap in (5.0, 1.0001))
    assert how_sure(clear) > 0.99
    assert how_sure(close) == pytest.approx(0.5, abs=0.15)


@pytest.mark.parametrize(
    ("errors", "seconds"),
    [(np.zeros(3), None), (np.zeros((2, 1)), None), (np.zeros((0, 4)), None), (np.zeros((2, 4)), [1.0])],
)
def test_shapes_are_checked(errors, seconds):
    with pytest.raises(
        ValueError, match=re.escape("errors must be (models, tiles), a model and two tiles at least, got")
    ):
        simplest_like_best(errors, seconds)
