"""Mutual information against closed forms, laws, its bias and another library; dependencies and shares."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.metrics import mutual_info_score

from mcdenoise.rpf import dependency, mutual_information
from mcdenoise.rpf.dependency import information_of_levels, quantise

pytestmark = pytest.mark.ch05
PARTS = ("c_r", "c_p", "c_f", "f_r", "f_p")
SHARES = ("share_c_r", "share_c_r_each", "share_f_r", "share_c_f")


def entropy(values):
    share = np.unique(values, return_counts=True)[1] / len(values)
    return -np.sum(share * np.log(share))


def neighbourhood(n=400, n_r=3, n_f=4, seed=0):
    """Samples with something to find: feature 0 is the lens, feature 1 the position, radiance a mixture."""
    rng = np.random.default_rng(seed)
    position, random_params = rng.random((n, 2)), rng.random((n, n_r))
    features = rng.random((n, n_f))
    features[:, 0] = random_params[:, 0] ** 2
    features[:, 1] = position[:, 1]
    radiance = np.stack([random_params[:, 0], position[:, 0], random_params[:, 1] + features[:, 2]], axis=1)
    return position, random_params, features, radiance


def test_a_copy_has_all_the_information_that_there_is():
    x = np.random.default_rng(0).normal(size=500)
    assert mutual_information(x, x) == pytest.approx(entropy(quantise(x)), rel=1e-12)


@pytest.mark.parametrize("k", [2, 3, 8])
def test_one_to_one_is_the_logarithm_of_the_number_of_values(k):
    """k equally likely values, spread so that each has a bin of its own."""
    x = np.repeat(np.arange(k, dtype=float), 10)
    levels = quantise(x)
    assert information_of_levels(np.arange(k).repeat(10), -3 * np.arange(k).repeat(10)) == pytest.approx(np.log(k))
    assert mutual_information(x, x) == pytest.approx(entropy(levels))


def test_every_combination_once_is_independent():
    x, y = (grid.ravel().astype(float) for grid in np.meshgrid(np.arange(5), np.arange(7)))
    assert mutual_information(x, y) == pytest.approx(0, abs=1e-12)


def test_a_noisy_coin_has_the_closed_form():
    """Y = X in three cases of four: log 2 - H(1/4)."""
    x = np.array([0, 0, 0, 0, 1, 1, 1, 1.0])
    y = np.array([0, 0, 0, 1, 1, 1, 1, 0.0])
    expected = 1 + 0.75 * np.log2(0.75) + 0.25 * np.log2(0.25)
    assert mutual_information(x, y, base=2) == pytest.approx(expected)
    assert mutual_information(x, y) == pytest.approx(expected * np.log(2))


@given(n=st.integers(1, 300), bins=st.tuples(st.integers(1, 9), st.integers(1, 9)), seed=st.integers(0, 999))
def test_agrees_with_scikit_learn(n, bins, seed):
    rng = np.random.default_rng(seed)
    x, y = (rng.integers(-k, k + 1, n) for k in bins)
    assert information_of_levels(x, y) == pytest.approx(mutual_info_score(x, y), abs=1e-12)


@given(
    n=st.integers(1, 200),
    levels=st.sampled_from([None, 1, 5, 9]),
    slope=st.sampled_from([-3.0, 1e-8, 1e8]),
    seed=st.integers(0, 999),
)
def test_laws(n, levels, slope, seed):
    """Symmetric, never negative, at most either entropy, blind to order, shift, scale and sign."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=n)
    y = x + rng.normal(size=n)
    found = mutual_information(x, y, levels=levels)
    order = rng.permutation(n)
    assert found == pytest.approx(mutual_information(y, x, levels=levels), abs=1e-12)
    assert 0 <= found <= min(entropy(quantise(x, levels)), entropy(quantise(y, levels))) + 1e-12
    assert found == pytest.approx(mutual_information(x[order], y[order], levels=levels), abs=1e-12)
    assert found == pytest.approx(mutual_information(slope * x, y, levels=levels), abs=1e-12)


@pytest.mark.parametrize("n", [128, 512, 2048])
def test_bias_where_there_is_nothing_to_find(n):
    """(bins_x - 1) (bins_y - 1) / (2 n) nats for independent variables, and the next term of the series: 400 trials."""
    rng = np.random.default_rng(5)
    found = [information_of_levels(rng.integers(0, 5, n), rng.integers(0, 5, n)) for _ in range(400)]
    first = 4 * 4 / (2 * n)
    second = ((625 - 1) - 2 * (25 - 1)) / (12 * n**2)  # sums of 1 / p over 25 and twice 5 bins
    error = np.std(found) / np.sqrt(len(found))
    assert abs(np.mean(found) - first - second) < 4 * error + 0.2 * second
    assert np.mean(found) > 0.9 * first


@pytest.mark.parametrize("n", [1, 2, 50])
def test_a_constant_says_nothing(n):
    x = np.random.default_rng(0).random(n)
    for constant in (0.0, 1e30, -1e-30, 0.1):
        assert mutual_information(x, np.full(n, constant)) == 0
    assert mutual_information([3.0], [4.0]) == 0


def test_levels_are_steps_of_one_deviation():
    x = np.array([-3.5, -1.0, 0.0, 1.0, 3.5])  # deviation 2.3
    np.testing.assert_array_equal(quantise(x), [-2, 0, 0, 0, 2])
    np.testing.assert_array_equal(quantise(x, levels=3), [-1, 0, 0, 0, 1])
    np.testing.assert_array_equal(quantise(np.full((4, 2), 7.0)), np.zeros((4, 2)))
    columns = np.stack([x, 1e30 * x, 1e-30 * x], axis=1)
    np.testing.assert_array_equal(quantise(columns), np.stack([quantise(x)] * 3, axis=1))


def test_each_column_is_cut_as_if_it_were_alone():
    """Rows, columns, strides and float32 make no difference, and the input stays as it was."""
    values = np.random.default_rng(1).gamma(0.5, 1.0, (300, 8)).astype(np.float32)
    before = values.copy()
    for view in (values, np.asfortranarray(values), values[::2, ::3], values[::-1]):
        alone = [quantise(column) for column in view.T]
        np.testing.assert_array_equal(quantise(view), np.stack(alone, axis=1))
        spread = view.std(axis=0, dtype=np.float64)
        expected = np.rint((view - view.mean(axis=0, dtype=np.float64)) / spread)
        np.testing.assert_array_equal(quantise(view), expected)
    np.testing.assert_array_equal(values, before)
    assert quantise(values[:, :0]).shape == (300, 0)


@pytest.mark.parametrize("distance", [0.3, 1.0, -7.0, 1000.0])
def test_rounding_of_a_flat_wall_is_no_variable(engine, distance):
    """World positions in float32 on the wall y = distance: y varies by its last bit alone."""
    rng = np.random.default_rng(3)
    position, random_params, radiance = rng.random((968, 2)), rng.random((968, 2)), rng.random((968, 3))
    wall = np.stack([position[:, 0], np.full(968, distance), position[:, 1]], axis=1).astype(np.float32)
    wall[:, 1] += np.spacing(wall[:, 1]) * rng.integers(-1, 2, 968).astype(np.float32)
    assert len(np.unique(wall[:, 1])) == 3
    found = dependency(position, random_params, wall, radiance, engine=engine)
    assert not quantise(wall)[:, 1].any()
    assert not np.hstack([found.f_r, found.f_p])[1].any()
    assert found.share_f_r[1] == found.share_c_f[1] == 0
    assert found.f_p[[0, 2], [0, 1]].min() > 1
    centred = wall - wall.mean(axis=0, dtype=np.float64)  # nothing to compare the last bits with
    assert dependency(position, random_params, centred, radiance, engine=engine).share_f_r[1] > 0.2


@pytest.mark.parametrize(("unit", "offset"), [(1e-6, 0.0), (1e-30, 0.0), (1e-6, 0.01), (1e-2, -1000.0)])
def test_a_tiny_variation_that_is_no_rounding_counts(unit, offset):
    noise = np.random.default_rng(4).normal(size=500)
    np.testing.assert_array_equal(quantise(offset + unit * noise), quantise(noise))


@pytest.mark.parametrize("value", [1.0, -250.0, 1e-20])
def test_what_is_constant_is_decided_at_a_millionth(value):
    sign = np.tile([1.0, -1.0], 50)
    assert not quantise(value * (1 + 0.99e-6 * sign)).any()
    np.testing.assert_array_equal(quantise(value * (1 + 1.01e-6 * sign)), sign * np.sign(value))


@pytest.mark.parametrize("sizes", [(1, 3, 4), (2, 0, 0), (50, 0, 4), (50, 3, 0), (400, 5, 18)])
@pytest.mark.parametrize("levels", [None, 5])
def test_engines_agree(sizes, levels):
    arrays = neighbourhood(sizes[0], max(sizes[1], 2), max(sizes[2], 3))
    arrays = (arrays[0], arrays[1][:, : sizes[1]], arrays[2][:, : sizes[2]], arrays[3])
    fast, plain = (dependency(*arrays, levels=levels, engine=engine) for engine in ("numba", "numpy"))
    for part in (*PARTS, *SHARES):
        np.testing.assert_allclose(getattr(fast, part), getattr(plain, part), rtol=1e-9, atol=1e-12)
        assert getattr(plain, part).shape == getattr(fast, part).shape


def test_it_finds_what_was_put_in(engine):
    found = dependency(*neighbourhood(4000), engine=engine)
    assert (found.share_f_r[[0, 1]] > [0.95, 0.0]).all()
    assert found.share_f_r[1] < 0.05
    assert found.share_c_r[0] > 0.95
    assert found.share_c_r[1] < 0.05
    assert found.share_c_r_each[0].argmax() == 0
    assert found.share_c_r_each[2].argmax() == 1
    assert found.share_c_f.argmax() in (0, 1, 2)
    assert found.share_c_f[3] < 0.01


def test_each_entry_is_the_information_of_its_pair(engine):
    position, random_params, features, radiance = neighbourhood(60)
    found = dependency(position, random_params, features, radiance, engine=engine)
    for part, x, y in (
        (found.c_r, radiance, random_params),
        (found.c_p, radiance, position),
        (found.c_f, radiance, features),
        (found.f_r, features, random_params),
        (found.f_p, features, position),
    ):
        for k in range(x.shape[1]):
            for m in range(y.shape[1]):
                assert part[k, m] == pytest.approx(mutual_information(x[:, k], y[:, m]), abs=1e-12)


def test_shares_are_the_quotients_of_the_lecture():
    found = dependency(*neighbourhood())
    d_r, d_p, d_f = found.c_r.sum(axis=1), found.c_p.sum(axis=1), found.c_f.sum(axis=1)
    np.testing.assert_allclose(found.share_c_r, d_r / (d_r + d_p))
    np.testing.assert_allclose(found.share_c_r_each.sum(axis=1), found.share_c_r)
    f_r, f_p = found.f_r.sum(axis=1), found.f_p.sum(axis=1)
    np.testing.assert_allclose(found.share_f_r, f_r / (f_r + f_p))
    whole = d_r.sum() + d_p.sum() + d_f.sum()
    np.testing.assert_allclose(found.share_c_f, found.c_f.sum(axis=0) / whole)


def test_nothing_depends_on_anything(engine):
    """0 / 0: constant radiance and features, no random parameters, one sample. Every share is 0."""
    rng = np.random.default_rng(0)
    flat = dependency(rng.random((30, 2)), rng.random((30, 2)), np.ones((30, 3)), np.ones((30, 3)), engine=engine)
    bare = dependency(rng.random((30, 2)), np.ones((30, 0)), np.ones((30, 0)), np.ones((30, 3)), engine=engine)
    single = dependency(*(array[:1] for array in neighbourhood()), engine=engine)
    for found in (flat, bare, single):
        for name in SHARES:
            values = getattr(found, name)
            np.testing.assert_array_equal(values, np.zeros_like(values))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"x": []}, "x must have shape (n,) with n above 0, got (0,)"),
        ({"x": np.ones((3, 2))}, "x must have shape (n,) with n above 0, got (3, 2)"),
        ({"x": [1.0, np.nan, 2.0]}, "x must be finite"),
        ({"y": [1.0]}, "All variables must have the same samples, got 3 of x, 1 of y"),
        ({"levels": 4}, "levels must be an odd number up to 255"),
        ({"levels": 257}, "levels must be an odd number up to 255"),
        ({"levels": 0}, "levels must be at least 1"),
        ({"base": 1.0}, "base must be above 1"),
        ({"base": -2}, "base must be greater than 0"),
    ],
)
def test_bad_input_is_refused(changes, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        mutual_information(**({"x": [1.0, 2.0, 3.0], "y": [1.0, 2.0, 3.0]} | changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"position": np.ones((5, 3))}, "position must have shape (n, 2), got (5, 3)"),
        ({"radiance": np.ones((5, 1))}, "radiance must have shape (n, 3), got (5, 1)"),
        ({"features": np.ones(5)}, "features must have shape (n, columns) with n above 0, got (5,)"),
        ({"random_params": np.ones((4, 2))}, "All variables must have the same samples, got 5 of position, 4 of"),
        ({"radiance": np.full((5, 3), np.inf)}, "radiance must be finite"),
        ({"engine": "fast"}, "engine must be one of 'numba', 'numpy', got 'fast'"),
    ],
)
def test_a_bad_neighbourhood_is_refused(changes, message):
    good = {
        name: np.ones((5, k)) for name, k in (("position", 2), ("random_params", 2), ("features", 3), ("radiance", 3))
    }
    with pytest.raises(ValueError, match=re.escape(message)):
        dependency(**(good | changes))
