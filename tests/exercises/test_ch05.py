"""The exercises of chapter 05, dependency: what holds for a right answer."""

from collections import Counter

import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import Finding, assert_matches, graded, name_mistake


def _pairs(count):
    """Samples x, y of two variables whose joint histogram is a table of counts, in an order without meaning."""
    count = np.asarray(count)
    x, y = (np.repeat(one.ravel(), count.ravel()) for one in np.indices(count.shape))
    order = np.random.default_rng(1).permutation(len(x))
    return x[order], y[order]


def _number(found):
    """The answer as a float, or NaN where it is none: `assert_matches` says so better."""
    return float(found) if np.shape(found) == () and np.asarray(found).dtype.kind in "if" else np.nan


# --- quantise(values)


def _assert_bins(found, expected, what):
    assert_matches(found, expected, what)
    kind = np.asarray(found).dtype
    assert kind.kind in "iu", f"{what}: whole numbers, but as {kind}: add .astype(int), so that they can be indices."


@graded("quantise", points=1)
def test_bins_are_one_standard_deviation_wide(impl):
    "The distance from the mean, in standard deviations, rounded to the nearest whole number."
    z = np.array([1.6, -1.6, 0.6, -0.6, np.sqrt(0.08), -np.sqrt(0.08)])  # mean 0, standard deviation 1
    values, expected = 10 + 0.3 * z, np.array([2, -2, 1, -1, 0, 0])
    found, what = impl(values), "bins of six values with mean 10 and standard deviation 0.3"
    mistakes = {
        "rounded down (floor), which makes the bin of 0 lie beside the mean: round to the nearest": np.floor(z),
        "rounded up (ceil): round to the nearest": np.ceil(z),
        "the decimals are cut off, which makes the bin of 0 two wide: round to the nearest": np.trunc(z),
        "not rounded: whole numbers are needed": z,
        "not divided by the standard deviation": np.rint(0.3 * z),
        "divided by the variance: the standard deviation is its root": np.rint(z / 0.3),
        "the mean is not taken off": np.rint(10 / 0.3 + z),
        "counted from the smallest value: the bins are centred on the mean": np.rint(z + 1.6),
        "counted from the smallest value, and rounded down: the bins are centred on the mean": np.floor(z + 1.6),
        "divided by N - 1 in the standard deviation; these values are to have a spread of 1, divide by N": np.rint(
            z * np.sqrt(5 / 6)
        ),
        "the sign is lost: bins lie on both sides of the mean": np.abs(expected),
    }
    name_mistake(found, expected, mistakes, what)
    _assert_bins(found, expected, what)


@graded("quantise", points=0.5)
def test_a_constant_has_one_bin(impl):
    "A variable that does not change has the bin 0 alone: no NaN, and no bins that rounding errors make."
    for value, n in ((3.0, 8), (0.1, 6), (1 / 3, 7), (1e-3, 11)):
        values = np.full(n, value)
        found = impl(values)
        bins = np.asarray(found)
        if bins.shape == (n,) and bins.dtype.kind in "iuf":
            bins = bins.astype(float)
            assert np.all(np.abs(bins) < 1e6), (
                f"{n} times {value:.3g}: 0/0 gives NaN, which is no whole number. A constant has the bin 0."
            )
            assert not bins.any(), (
                f"{n} times {value:.3g}: bin {bins[np.argmax(np.abs(bins))]:g}, expected 0. The mean is rounded, so the "
                f"standard deviation of a constant need not be exactly 0: ask whether the largest value is the smallest."
            )
        _assert_bins(found, np.zeros(n, int), f"bins of {n} times {value:.3g}")


@graded("quantise", points=0.5, hidden=True)
def test_bins_do_not_depend_on_the_unit(impl):
    "Skewed values, as radiance has them, in any unit, in float32 too: the same bins."
    values = np.random.default_rng(5).gamma(0.5, 1.0, 400)
    expected = np.rint((values - values.mean()) / np.sqrt(((values - values.mean()) ** 2).mean())).astype(int)
    _assert_bins(impl(values), expected, "bins of 400 skewed values")
    _assert_bins(impl(250 * values + 3), expected, "bins of the same values in another unit")
    _assert_bins(impl(1e-4 * values), expected, "bins of the same values, ten thousand times smaller")
    _assert_bins(impl(np.array([5.0, 1.0], np.float32)), np.array([1, -1]), "bins of two float32 values")
    _assert_bins(impl(np.array([0.7])), np.array([0]), "bins of one value")


# --- information_of_levels(x, y)


@graded("information_of_levels", points=1)
def test_information_of_a_small_table(impl):
    "Eight samples, two levels each, joint counts 3 1 / 1 3: (3/4) ln(3/2) + (1/4) ln(1/2) nats."
    x, y = _pairs([[3, 1], [1, 3]])
    found, expected = impl(x, y), 0.75 * np.log(1.5) + 0.25 * np.log(0.5)
    mistakes = {
        "the sign is flipped: p(x, y) stands above the line": -expected,
        "in bits: the natural logarithm is asked for, nats": expected / np.log(2),
        "the logarithm to base 10: the natural one is asked for": expected / np.log(10),
        "p(x, y) in front of the logarithm is missing": 2 * np.log(1.5) + 2 * np.log(0.5),
        "in front of the logarithm stands p(x) p(y): it is p(x, y)": (np.log(1.5) + np.log(0.5)) / 2,
        "in front of the logarithm stands p(y | x): it is p(x, y)": 2 * expected,
        "counts in place of shares: divide by the number of samples": 6 * np.log(3 / 16) + 2 * np.log(1 / 16),
        "in front of the logarithm stand counts: divide by the number of samples": 8 * expected,
        "in the logarithm stand counts: divide by the number of samples": expected - np.log(8),
        "the mean over the four cells: the sum is needed": expected / 4,
        "p(x) p(y) is missing below the line": 0.75 * np.log(3 / 8) + 0.25 * np.log(1 / 8),
        "that is the entropy of both together: p(x) p(y) is missing": -0.75 * np.log(3 / 8) - 0.25 * np.log(1 / 8),
        "that is the correlation": 0.5,
        "that is the squared correlation": 0.25,
    }
    name_mistake(found, expected, mistakes, "joint counts 3 1 / 1 3")
    assert_matches(found, expected, "information of eight samples with the joint counts 3 1 / 1 3")


@graded("information_of_levels", points=0.5)
def test_what_never_occurs_counts_nothing(impl):
    "0 log 0 is 0: pairs that do not occur add nothing, and p(x) belongs to x, p(y) to y."
    x, y = _pairs([[4, 2], [0, 2]])
    joint, p_x, p_y = np.array([4, 2, 2]) / 8, np.array([6, 6, 2]) / 8, np.array([4, 4, 4]) / 8
    expected = np.sum(joint * np.log(joint / (p_x * p_y)))
    found = impl(x, y)
    assert not (np.shape(found) == () and np.isnan(_number(found)) and np.asarray(found).dtype.kind == "f"), (
        "NaN: the joint counts are 4 2 / 0 2, and 0 log 0 is NaN for the computer. Leave out the pairs that never occur."
    )
    assert not np.isinf(_number(found)), "infinite: log 0. Leave out the pairs that never occur."
    mistakes = {
        words: np.sum(joint * np.log(joint / (one * other)))
        for words, one, other in (
            ("p(x) and p(y) are exchanged: p(x) is the sum over y", p_y, np.array([6, 2, 2]) / 8),
            ("p(x) stands twice", p_x, np.array([6, 2, 2]) / 8),
            ("p(y) stands twice", p_y, p_y),
        )
    }
    name_mistake(found, expected, mistakes, "joint counts 4 2 / 0 2")
    difference = abs(_number(found) - expected)
    assert not 1e-6 * expected < difference < 1e-2 * expected, (
        f"nearly right, {_number(found):.8f} for {expected:.8f}: is a small number added in the logarithm? Leave out the "
        f"pairs that never occur instead."
    )
    assert_matches(found, expected, "information of eight samples with the joint counts 4 2 / 0 2")


@graded("information_of_levels", points=0.5)
def test_independent_variables_say_nothing(impl):
    "If every pair occurs as often as its levels make one expect, the information is 0."
    found = impl(*_pairs(np.outer([1, 2, 3], [4, 1])))
    assert_matches(found, 0.0, "information of two independent variables", atol=1e-9)


@graded("information_of_levels", points=1)
def test_names_of_levels_do_not_matter(impl):
    "Only which levels are equal matters, not their numbers: negative, far apart, or one-to-one."
    y = np.array([7, 8, 8, 9, 9, 9, 9, 9])
    expected = -(1 / 8 * np.log(1 / 8) + 2 / 8 * np.log(2 / 8) + 5 / 8 * np.log(5 / 8))
    merged = -(1 / 8 * np.log(1 / 8) + 7 / 8 * np.log(7 / 8))
    joined = -(2 / 8 * np.log(2 / 8) + 6 / 8 * np.log(6 / 8))
    for name, levels in (
        ("7, 8 and 9", (7, 8, 9)),
        ("-1, 0 and 1", (-1, 0, 1)),
        ("-1, 3 and 1", (-1, 3, 1)),
        ("-200, 1 and 2", (-200, 1, 2)),
        ("100, -1 and -2", (100, -1, -2)),
    ):
        x = np.array(levels)[y - 7]
        found = impl(x, y)
        what = f"x is a new name for y, its levels are {name}"
        mistakes = {
            "levels that lie close together share a bin (np.histogram2d takes 10 bins where it is not told). "
            "Count each whole number by itself": merged,
            "a level and its negative are counted as one": joined,
            "that is the correlation, or nearly": abs(float(np.corrcoef(x, y)[0, 1])),
        }
        name_mistake(found, expected, mistakes, what)
        assert_matches(found, expected, what)
    found = impl(np.full(8, 4), y)
    assert_matches(found, 0.0, "information of a constant and another variable", atol=1e-9)


@graded("information_of_levels", points=1, hidden=True)
def test_information_of_any_levels(impl):
    "Many levels, many samples, one sample: entropy of x, plus that of y, less that of the pairs; and symmetric."
    rng = np.random.default_rng(3)
    for n, a, b in ((1, 3, 4), (50, 9, 2), (392, 5, 11), (5000, 60, 200)):
        x = rng.integers(-a, a, n)
        y = (x + rng.integers(0, b, n)) % 7 - 2 * (x > 0)
        expected = (
            _entropy(x.tolist()) + _entropy(y.tolist()) - _entropy(list(zip(x.tolist(), y.tolist(), strict=True)))
        )
        assert_matches(impl(x, y), expected, f"information of {n} samples", atol=1e-9)
        assert_matches(impl(y, x), expected, f"information of {n} samples, x and y exchanged", atol=1e-9)


def _entropy(values):
    share = np.array(list(Counter(values).values())) / len(values)
    return float(-np.sum(share * np.log(share)))


# --- uncorrelated() and unseen() -> x, y


def _variables(impl, least, most):
    x, y = (np.asarray(one, float) for one in impl())
    assert x.shape == y.shape == (x.size,), (
        f"x and y must be two arrays (n,) of one length, got {x.shape} and {y.shape}."
    )
    assert least <= len(x) <= most, f"{least} to {most} samples are asked for, got {len(x)}."
    assert np.isfinite([x, y]).all(), "x and y must be finite: there is NaN or infinity."
    for name, values in (("x", x), ("y", y)):
        assert np.ptp(values) > 0, f"{name} is constant: a constant depends on nothing. Let it vary."
    return x, y


def _assert_same_again(impl, least, most):
    made, again = _variables(impl, least, most), _variables(impl, least, most)
    assert all(map(np.array_equal, made, again)), (
        "two calls gave different samples: use a fixed seed, np.random.default_rng(0)."
    )
    return made


def _assert_uncorrelated(x, y, what):
    correlation, found = float(np.corrcoef(x, y)[0, 1]), mcd.mutual_information(x, y)
    assert abs(correlation) <= 0.02, (
        f"{what}: the correlation is {correlation:.3f}, at most 0.02 from 0 is asked for: for each x where y rises there must "
        f"be one where it falls as much."
    )
    assert found >= 0.3, (
        f"{what}: the correlation is {correlation:.3f}, but the mutual information is only {found:.3f} nats, 0.3 are asked "
        f"for: y must still follow from x."
    )


@graded("uncorrelated", points=1)
def test_dependent_without_correlation(impl):
    "The correlation is 0 up to 0.02, yet the mutual information is at least 0.3 nats."
    _assert_uncorrelated(*_variables(impl, 500, 5000), "x and y")


@graded("uncorrelated", points=0.5, hidden=True)
def test_it_stays_so_in_other_units(impl):
    "It holds in other units, with x and y exchanged, for samples in another order, and is the same at every call."
    x, y = _assert_same_again(impl, 500, 5000)
    order = np.random.default_rng(2).permutation(len(x))
    _assert_uncorrelated(5 - 100 * x, 0.01 * y + 2, "in other units")
    _assert_uncorrelated(y[order], x[order], "exchanged, in another order")


WITNESS_X, WITNESS_Y = 64, 8  # bins of equal count


def _by_rank(values, bins):
    """Bins by rank, each of about as many different values; equal values share a bin."""
    different, rank = np.unique(values, return_inverse=True)
    return rank * min(bins, len(different)) // len(different)


def _seen_by_rank(x, y):
    """What bins by rank find, 64 of x and 8 of y, less what chance alone gives."""
    x, y = _by_rank(x, WITNESS_X), _by_rank(y, WITNESS_Y)
    pairs = list(zip(x.tolist(), y.tolist(), strict=True))
    chance = x.max() * y.max() / (2 * len(x))
    return _entropy(x.tolist()) + _entropy(y.tolist()) - _entropy(pairs) - chance


def _assert_unseen(x, y, what):
    different, first, back = np.unique(x, return_index=True, return_inverse=True)
    assert np.array_equal(y[first][back], y), (
        f"{what}: y is no function of x: samples with the same x have another y ({len(different)} values of x among {len(x)})."
    )
    ours, theirs = mcd.mutual_information(x, y), _seen_by_rank(x, y)
    assert ours <= 0.05, (
        f"{what}: our bins still see {ours:.3f} nats, at most 0.05 are asked for. What happens within one bin goes unseen: "
        f"let y change faster than that, or let nearly all of y fall into one bin."
    )
    assert theirs >= 0.5, (
        f"{what}: our bins see {ours:.3f} nats, but bins by rank ({WITNESS_X} of x, {WITNESS_Y} of y) see only {theirs:.3f} as "
        f"well, 0.5 are asked for: is it noise, or does y change faster than {WITNESS_X} bins can follow?"
    )


@graded("unseen", points=1)
def test_a_function_that_our_bins_do_not_see(impl):
    "y is a function of x; our bins see at most 0.05 nats of it, bins by rank see at least 0.5."
    _assert_unseen(*_variables(impl, 1000, 20_000), "x and y")


@graded("unseen", points=1, hidden=True)
def test_it_stays_unseen_in_other_units(impl):
    "It stays so in other units and for samples in another order, and is the same at every call."
    x, y = _assert_same_again(impl, 1000, 20_000)
    order = np.random.default_rng(2).permutation(len(x))
    _assert_unseen(3 + 16 * x[order], 4 * y[order], "in other units and another order")


# --- dependency_shares(c_r, c_p, c_f, f_r, f_p)

NAMES = ("W_{c,k}^r", "W_{f,k}^r", "W_c^{f,k}")


def _shares(impl, *tables):
    found = impl(*tables)
    if found is None:
        raise Finding("nothing came back (None): is the `return` missing?")
    if not isinstance(found, (tuple, list)) or len(found) != 3:
        raise Finding(f"three arrays are needed, {', '.join(NAMES)}, in this order; something else came back.")
    return found


def _assert_one_each(found, expected, of, what):
    """One number for each channel, or for each feature."""
    if np.shape(found) != expected.shape and np.asarray(found).dtype.kind in "iuf":
        raise Finding(
            f"{what}: one number for each {of} is needed, {len(expected)} of them; shape {np.shape(found)} came back."
        )
    assert_matches(found, expected, what)


def _tables(n_r, n_f, seed=0):
    """Five tables of pairs, as mutual information may be."""
    rng = np.random.default_rng(seed)
    sizes = ((3, n_r), (3, 2), (3, n_f), (n_f, n_r), (n_f, 2))
    return [np.round(rng.gamma(1.0, 0.3, size), 2) + 0.01 for size in sizes]


@graded("dependency_shares", points=1)
def test_share_of_the_random_parameters_in_radiance(impl):
    "W_{c,k}^r, one number for each channel: the sum over the random parameters, of that sum and the one over positions."
    c_r, c_p, c_f, f_r, f_p = _tables(4, 5)
    found, what = _shares(impl, c_r, c_p, c_f, f_r, f_p)[0], f"{NAMES[0]} of four random parameters"
    r, p = c_r.sum(axis=1), c_p.sum(axis=1)
    expected = r / (r + p)
    mistakes = {
        "that is 1 - W, what the position explains": 1 - expected,
        "the whole is missing a part, D^r + D^p stands below the line": r / p,
        "the mean over the random parameters for their sum": (r / 4) / (r / 4 + p / 2),
        "each random parameter has a ratio of its own, and then the mean: sum first, divide then": (
            c_r / (c_r + p[:, np.newaxis])
        ).mean(axis=1),
        "only the largest of the random parameters counts: sum them": c_r.max(axis=1) / (c_r.max(axis=1) + p),
        "summed over the channels: each channel keeps its own": c_r.sum(axis=0)
        / (c_r.sum(axis=0) + c_p.sum(axis=0).sum()),
        "the features do not belong into this whole": r / (r + p + c_f.sum(axis=1)),
        "one ratio for all channels: each channel has its own": np.full(3, r.sum() / (r + p).sum()),
    }
    name_mistake(found, expected, mistakes, what)
    _assert_one_each(found, expected, "channel", what)


@graded("dependency_shares", points=0.5)
def test_share_of_the_random_parameters_in_a_feature(impl):
    "W_{f,k}^r, one number for each feature, from the tables of the features."
    tables = _tables(3, 5, seed=1)
    found, what = _shares(impl, *tables)[1], f"{NAMES[1]} of five features"
    c_r, c_p, c_f, f_r, f_p = tables
    r, p = f_r.sum(axis=1), f_p.sum(axis=1)
    expected = r / (r + p)
    of_radiance = c_f.sum(axis=0) / (c_r.sum() + c_p.sum() + c_f.sum())
    mistakes = {
        "that is 1 - W, what the position explains": 1 - expected,
        "the whole is missing a part, D^r + D^p stands below the line": r / p,
        "that is W_{c,k}^r, of the radiance: take the tables of the features": c_r.sum(1) / (c_r.sum(1) + c_p.sum(1)),
        "that is W_c^{f,k}: exchanged?": of_radiance,
        "multiplied by W_c^{f,k}": expected * of_radiance,
    }
    name_mistake(found, expected, mistakes, what)
    _assert_one_each(found, expected, "feature", what)


@graded("dependency_shares", points=1)
def test_share_of_a_feature_in_the_radiance(impl):
    "W_c^{f,k}, one number for each feature k: its sum over the channels, of all that is explained of the radiance."
    for n_f in (5, 3):
        tables = _tables(2, n_f, seed=2)
        found, what = _shares(impl, *tables)[2], f"{NAMES[2]} of {n_f} features"
        c_r, c_p, c_f, _, _ = tables
        part, whole = c_f.sum(axis=0), c_r.sum() + c_p.sum() + c_f.sum()
        each = (c_r.sum(axis=1) + c_p.sum(axis=1) + c_f.sum(axis=1))[:, np.newaxis]
        mistakes = {
            "indexed by the channel: k is the feature, sum over the channels": c_f.sum(axis=1) / whole,
            "indexed by the channel, and divided channel by channel: k is the feature": c_f.sum(axis=1) / each[:, 0],
            "D_c^f is missing below the line": part / (c_r.sum() + c_p.sum()),
            "D_c^r is missing below the line": part / (c_p.sum() + c_f.sum()),
            "D_c^p is missing below the line": part / (c_r.sum() + c_f.sum()),
            "D_c^r and D_c^p are missing below the line": part / c_f.sum(),
            "a feature beside r and p alone: all features stand below the line": part / (c_r.sum() + c_p.sum() + part),
            "each channel has a ratio of its own, and then the mean: sum first, divide then": (c_f / each).mean(axis=0),
            "the sum of three ratios, one a channel: sum first, divide then": (c_f / each).sum(axis=0),
        }
        name_mistake(found, part / whole, mistakes, what)
        _assert_one_each(found, part / whole, "feature", what)


@graded("dependency_shares", points=0.5)
def test_where_nothing_depends_the_share_is_zero(impl):
    "0 / 0 is 0: a constant channel or feature depends on nothing. And the unit of the information cancels."
    _assert_the_unit_cancels(impl)
    c_r, c_p, c_f, f_r, f_p = _tables(2, 4, seed=3)
    for table, row in ((c_r, 1), (c_p, 1), (c_f, 1), (f_r, 2), (f_p, 2)):
        table[row] = 0
    c_f[:, 2] = 0
    for tables, case in (
        ((c_r, c_p, c_f, f_r, f_p), "green and feature 2 are constant"),
        ([np.zeros_like(one) for one in (c_r, c_p, c_f, f_r, f_p)], "everything is constant"),
    ):
        for found, expected, name in zip(_shares(impl, *tables), _loops(*tables), NAMES, strict=True):
            values = np.asarray(found, float)
            assert not np.isnan(values).any(), f"{case}: {name} has NaN (0/0). There the share is 0."
            if values.shape == expected.shape:
                for wrong in (1.0, 0.5):
                    assert not np.any((values == wrong) & (expected == 0)), (
                        f"{case}: {name} is {wrong:g} where nothing depends on anything. There the share is 0."
                    )
            assert_matches(found, expected, f"{case}: {name}")


def _assert_the_unit_cancels(impl):
    """The same shares for less information: no constant stands below the line."""
    small = [1e-3 * one for one in _tables(2, 4, seed=4)]
    for found, expected, name in zip(_shares(impl, *small), _loops(*small), NAMES, strict=True):
        off = np.abs(np.asarray(found, float) - expected).max() if np.shape(found) == expected.shape else 0.0
        assert not 1e-6 < off < 0.2, (
            f"information a thousand times smaller: {name} is off by {off:.2g}, though the unit should cancel. Is a small "
            f"number added below the line? Ask where the whole is above 0 instead."
        )


def _loops(c_r, c_p, c_f, f_r, f_p):
    """The three shares, number by number."""

    def ratio(part, whole):
        return part / whole if whole > 0 else 0.0

    whole = sum(float(x) for table in (c_r, c_p, c_f) for x in table.flat)
    of_radiance = [ratio(sum(c_r[k]), sum(c_r[k]) + sum(c_p[k])) for k in range(3)]
    of_feature = [ratio(sum(f_r[k]), sum(f_r[k]) + sum(f_p[k])) for k in range(len(f_r))]
    by_feature = [ratio(sum(c_f[:, k]), whole) for k in range(c_f.shape[1])]
    return np.array(of_radiance), np.array(of_feature), np.array(by_feature)


@graded("dependency_shares", points=1, hidden=True)
def test_shares_of_any_scene(impl):
    "One random parameter or seven, eighteen features or none; also a scene without random parameters."
    for n_r, n_f in ((1, 1), (7, 18), (2, 0), (0, 4)):
        tables = _tables(n_r, n_f, seed=n_r)
        for found, expected, name in zip(_shares(impl, *tables), _loops(*tables), NAMES, strict=True):
            assert_matches(found, expected, f"{name} with {n_r} random parameters and {n_f} features")


# --- predictions


@graded("chance_alone", points=1)
def test_what_chance_alone_gives(impl):
    "What chance alone gives in a box of 7 x 7 pixels with 8 spp, for 3 and 5 bins, to two digits."
    value, expected = float(impl), 2 * 4 / (2 * 7 * 7 * 8)
    for wrong, words in (
        (0.0, "chance is never exactly fair: some pairs of bins get a sample more than they should"),
        (15 / 784, "one is taken off each number of bins, (bins_x - 1)(bins_y - 1)"),
        (8 / 392, "twice too much: 2 N stands below the line"),
        (8 / 16, "N counts all samples of the box, not those of one pixel"),
        (8 / 98, "N counts the samples of the box, not its pixels: 8 in each"),
        (8 / 112, "the box is 7 x 7 pixels, not 7"),
        (8 / 784 / np.log(2), "that is in bits: nats are asked for"),
    ):
        assert abs(value - wrong) > 0.01 * wrong + 1e-5, f"{value:.3g}: {words}."
    assert abs(value - expected) <= 3e-4, (
        f"{value:.3g} is not it: put 3 and 5 bins and the number of all samples in the box into the formula."
    )


@graded("chance_share", points=1)
def test_share_by_chance(impl):
    "The share W_{c,k}^r of four random parameters if nothing depends on anything, to two digits."
    value = float(impl)
    for wrong, words in (
        (0.0, "each of the pairs finds a little by chance: W is the share of the random parameters in it"),
        (0.5, "there are four random parameters, but only two positions"),
        (1.0, "the two positions find something by chance too"),
        (2.0, "a share lies between 0 and 1: what stands below the line?"),
        (1 / 3, "that is the share of the positions, 1 - W"),
        (0.25, "that is one of four: W sums over the random parameters"),
        (4 / 15, "the features do not stand in W_{c,k}^r"),
    ):
        assert abs(value - wrong) > 1e-3, f"{value:.3g}: {words}."
    assert abs(value - 4 / 6) <= 0.01, (
        f"{value:.3g} is not it: every pair gives the same d by chance. How many d are in D^r, how many in D^p?"
    )


@graded("what_explains", points=1)
def test_what_explains_each_place(impl):
    "For each of the six places: which of position, lens, time, light and scattering explains most?"
    given = ("A", "A", "A", "A", "A", "A")
    letters = [str(one).strip().upper() for one in impl] if isinstance(impl, (tuple, list, str)) else []
    assert len(letters) == 6, f"6 letters are needed, as in {given}."
    hints = (
        ("A", "the ball is in focus: every ray of a pixel hits the same point, wherever it crossed the lens."),
        ("D", "whether a sample is dark depends on the point of the light that it asked: is it hidden by the fence?"),
        ("B", "the near ball is out of focus: what decides which of its stripes a ray hits? Light changes no albedo."),
        ("C", "the ball is at this place for a part of the exposure only."),
        ("D", "no shadow, no edge, one albedo: only the light's point is left to change the radiance, however little."),
        ("E", "rough metal mirrors: which way was the ray scattered?"),
    )
    for place, (letter, (right, hint)) in enumerate(zip(letters, hints, strict=True)):
        assert letter == right, f"place {place + 1} is not {letter}: {hint}"
