"""The exercises of chapter 05 tested themselves: the reference earns every point, each typical mistake is named."""

import functools

import numpy as np
import pytest

import mcdenoise as mcd
from answers import assert_earns_every_point, assert_mistake_is_named, failures, reference
from mcdenoise.rpf.dependency import quantise as quantise_columns

pytestmark = pytest.mark.ch05


def quietly(function):
    def silent(*arguments):
        with np.errstate(all="ignore"):
            return function(*arguments)

    return silent


# --- quantise


def bins(values, *, centre=np.mean, spread=np.std, rounded=np.rint, kind=int):
    """Bins as a student would write them, with places for mistakes."""
    if np.ptp(values) == 0:
        return np.zeros(len(values), kind)
    return rounded((values - centre(values)) / spread(values)).astype(kind)


def spoiling_bins(values):
    values -= values.mean()
    return bins(values)


@quietly
def unguarded_bins(values):
    return np.rint((values - values.mean()) / values.std()).astype(int)


@quietly
def guarded_by_the_deviation(values):
    return np.zeros(len(values), int) if values.std() == 0 else unguarded_bins(values)


# --- information_of_levels


def tables(x, y):
    """p(x, y), p(x) and p(y), as tables of one shape."""
    x, y = (np.unique(one, return_inverse=True)[1] for one in (x, y))
    joint = np.zeros((x.max() + 1, y.max() + 1))
    np.add.at(joint, (x, y), 1 / len(x))
    p_x, p_y = joint.sum(axis=1, keepdims=True), joint.sum(axis=0, keepdims=True)
    return joint, np.broadcast_to(p_x, joint.shape), np.broadcast_to(p_y, joint.shape), len(x)


def in_each_cell(formula, gather=np.sum):
    """The sum over the cells that occur."""

    def information(x, y):
        joint, p_x, p_y, n = tables(x, y)
        there = joint > 0
        return float(gather(formula(joint[there], p_x[there], p_y[there], n)))

    return information


right = in_each_cell(lambda joint, p_x, p_y, n: joint * np.log(joint / (p_x * p_y)))


@quietly
def with_empty_cells(x, y):
    joint, p_x, p_y, _ = tables(x, y)
    return float(np.sum(joint * np.log(joint / (p_x * p_y))))


def with_epsilon(epsilon):
    def information(x, y):
        joint, p_x, p_y, _ = tables(x, y)
        return float(np.sum(joint * np.log((joint + epsilon) / (p_x * p_y + epsilon))))

    return information


def with_wrong_marginals(choose):
    """p(x) and p(y) taken from other axes of the square table."""

    def information(x, y):
        joint, p_x, p_y, _ = tables(x, y)
        if joint.shape[0] != joint.shape[1]:
            return right(x, y)
        p_x, p_y = choose(p_x, p_y)
        there = joint > 0
        return float(np.sum(joint[there] * np.log(joint[there] / (p_x * p_y)[there])))

    return information


def ten_bins(x, y):
    """np.histogram2d, left to its default."""
    joint = np.histogram2d(x, y)[0] / len(x)
    outer = joint.sum(axis=1, keepdims=True) * joint.sum(axis=0, keepdims=True)
    return float(np.sum(joint[joint > 0] * np.log(joint[joint > 0] / outer[joint > 0])))


def by_bincount(x, y):
    joint = np.bincount(x * (y.max() + 1) + y, minlength=(x.max() + 1) * (y.max() + 1))
    return right(np.repeat(np.arange(len(joint)), joint), np.repeat(np.arange(len(joint)), joint))


@quietly
def correlation(x, y):
    return float(np.nan_to_num(np.corrcoef(x, y)[0, 1]))


# --- dependency_shares


def share(part, whole):
    return np.where(whole > 0, part / np.where(whole > 0, whole, 1), 0.0)


def shares(c_r, c_p, c_f, f_r, f_p, *, ratio=share, c=None, f=None, by=None):
    """The three shares, each open to a mistake: a function of the tables it is made from."""
    of_radiance = c(c_r, c_p) if c else ratio(c_r.sum(axis=1), c_r.sum(axis=1) + c_p.sum(axis=1))
    of_feature = f(f_r, f_p) if f else ratio(f_r.sum(axis=1), f_r.sum(axis=1) + f_p.sum(axis=1))
    whole = c_r.sum() + c_p.sum() + c_f.sum()
    return of_radiance, of_feature, by(c_r, c_p, c_f) if by else ratio(c_f.sum(axis=0), whole)


def with_ratio(ratio):
    return quietly(lambda *a: shares(*a, ratio=ratio))


def with_radiance(formula):
    return quietly(lambda *a: shares(*a, c=formula))


def with_feature(formula):
    return quietly(lambda *a: shares(*a, f=formula))


def by_feature(formula):
    return quietly(lambda *a: shares(*a, by=formula))


def each(c_r, c_p, c_f):
    """What is explained of each channel, as a column."""
    return (c_r.sum(axis=1) + c_p.sum(axis=1) + c_f.sum(axis=1))[:, np.newaxis]


def with_beta(*given):
    of_radiance, of_feature, of_each = shares(*given)
    return of_radiance, of_feature * of_each, of_each


def with_exchanged_tables(c_r, c_p, c_f, f_r, f_p):
    return shares(c_r, c_p, c_f, c_r, c_p)


# --- uncorrelated and unseen


def parabola(shift=0.0, n=1001):
    x = np.linspace(-1, 1, n)
    return x, (x + shift) ** 2


def at_random(n=2000, seed=0):
    rng = np.random.default_rng(seed)
    return rng.random(n), rng.random(n)


def tent():
    x = np.linspace(0, 1, 2000)
    return x, np.minimum(x, 1 - x)


def circle():
    angle = np.linspace(0, 2 * np.pi, 2000)
    return np.cos(angle), np.sin(angle)


def stripes(number=64, n=4096):
    x = np.arange(n) / n
    return x, np.floor(number * x) % 2


def waves():
    x = np.random.default_rng(0).random(8000)
    return x, np.sin(60 * x)


def firefly():
    x = np.linspace(0, 1, 1000)
    return x, np.where(x == 1, 1e6, x)


def coins():
    x = np.arange(4096) // 4 / 1024
    return x, np.arange(4096) % 2


# exercise, what the student did, the answer, what the message must say
WRONG = (
    ("quantise", "floor", lambda v: bins(v, rounded=np.floor), "rounded down (floor)"),
    ("quantise", "ceil", lambda v: bins(v, rounded=np.ceil), "rounded up (ceil)"),
    ("quantise", "astype(int) alone", lambda v: bins(v, rounded=np.trunc), "the decimals are cut off"),
    ("quantise", "not rounded", lambda v: bins(v, rounded=np.positive, kind=float), "not rounded"),
    ("quantise", "not divided", lambda v: bins(v, spread=lambda _: 1), "not divided by the standard deviation"),
    ("quantise", "variance", lambda v: bins(v, spread=np.var), "its root"),
    ("quantise", "ddof 1", lambda v: bins(v, spread=lambda v: np.std(v, ddof=1)), "divided by N - 1"),
    ("quantise", "mean forgotten", lambda v: bins(v, centre=lambda _: 0), "the mean is not taken off"),
    ("quantise", "from the minimum", lambda v: bins(v, centre=np.min), "centred on the mean"),
    ("quantise", "a histogram", lambda v: bins(v, centre=np.min, rounded=np.floor), "and rounded down"),
    ("quantise", "the sign lost", lambda v: np.abs(bins(v)), "the sign is lost"),
    ("quantise", "decimal points", lambda v: bins(v, kind=float), "add .astype(int)"),
    ("quantise", "0 / 0", unguarded_bins, "0/0 gives NaN"),
    ("quantise", "0 / 0, left as NaN", quietly(lambda v: np.rint((v - v.mean()) / v.std())), "0/0 gives NaN"),
    ("quantise", "std == 0", guarded_by_the_deviation, "need not be exactly 0"),
    ("quantise", "spoils its input", spoiling_bins, "modified its input `values`"),
    ("quantise", "returns nothing", lambda v: None, "is the `return` missing"),
    ("information_of_levels", "sign", lambda *a: -right(*a), "the sign is flipped"),
    ("information_of_levels", "log2", lambda *a: right(*a) / np.log(2), "in bits"),
    ("information_of_levels", "log10", lambda *a: right(*a) / np.log(10), "base 10"),
    (
        "information_of_levels",
        "p in front missing",
        in_each_cell(lambda j, x, y, n: np.log(j / (x * y))),
        "in front of the logarithm is missing",
    ),
    (
        "information_of_levels",
        "p(x) p(y) in front",
        in_each_cell(lambda j, x, y, n: x * y * np.log(j / (x * y))),
        "stands p(x) p(y)",
    ),
    (
        "information_of_levels",
        "p(y | x) in front",
        in_each_cell(lambda j, x, y, n: j / x * np.log(j / (x * y))),
        "stands p(y | x)",
    ),
    (
        "information_of_levels",
        "counts",
        in_each_cell(lambda j, x, y, n: n * j * np.log(j * n / (x * n * y * n))),
        "counts in place of shares",
    ),
    (
        "information_of_levels",
        "counts in front",
        in_each_cell(lambda j, x, y, n: n * j * np.log(j / (x * y))),
        "in front of the logarithm stand counts",
    ),
    (
        "information_of_levels",
        "counts in the log",
        in_each_cell(lambda j, x, y, n: j * np.log(j * n / (x * n * y * n))),
        "in the logarithm stand counts",
    ),
    (
        "information_of_levels",
        "mean over the cells",
        in_each_cell(lambda j, x, y, n: j * np.log(j / (x * y)), np.mean),
        "the mean over the four cells",
    ),
    (
        "information_of_levels",
        "marginals missing",
        in_each_cell(lambda j, x, y, n: j * np.log(j)),
        "missing below the line",
    ),
    (
        "information_of_levels",
        "joint entropy",
        in_each_cell(lambda j, x, y, n: -j * np.log(j)),
        "the entropy of both",
    ),
    ("information_of_levels", "correlation", correlation, "that is the correlation"),
    ("information_of_levels", "its square", lambda *a: correlation(*a) ** 2, "the squared correlation"),
    ("information_of_levels", "0 log 0", with_empty_cells, "0 log 0 is NaN"),
    ("information_of_levels", "0 log 0 after log", quietly(lambda x, y: with_empty_cells(x, y) - 0), "Leave out"),
    ("information_of_levels", "epsilon", with_epsilon(1e-4), "is a small number added"),
    ("information_of_levels", "marginals exchanged", with_wrong_marginals(lambda x, y: (x.T, y.T)), "are exchanged"),
    ("information_of_levels", "p(x) twice", with_wrong_marginals(lambda x, y: (x, x.T)), "p(x) stands twice"),
    ("information_of_levels", "p(y) twice", with_wrong_marginals(lambda x, y: (y.T, y)), "p(y) stands twice"),
    ("information_of_levels", "ten bins", ten_bins, "np.histogram2d takes 10 bins"),
    ("information_of_levels", "absolute values", lambda x, y: right(np.abs(x), y), "counted as one"),
    ("information_of_levels", "bincount", by_bincount, "stopped with ValueError"),
    ("information_of_levels", "NaN for constants", quietly(lambda x, y: right(x, y) / (np.ptp(x) > 0)), "constant"),
    ("information_of_levels", "an array", lambda x, y: np.array([right(x, y)]), "one number"),
    ("information_of_levels", "returns nothing", lambda x, y: None, "is the `return` missing"),
    ("uncorrelated", "a line", lambda: (np.linspace(0, 1, 900),) * 2, "correlation is 1.000"),
    ("uncorrelated", "off centre", lambda: parabola(0.5), "one where it falls as much"),
    ("uncorrelated", "independent", lambda: at_random(seed=7), "mutual information is only"),
    ("uncorrelated", "circle", circle, "mutual information is only"),
    ("uncorrelated", "too few", lambda: parabola(n=101), "500 to 5000"),
    ("uncorrelated", "constant", lambda: (np.linspace(0, 1, 900), np.ones(900)), "y is constant"),
    ("uncorrelated", "NaN", lambda: (np.linspace(0, 1, 900), np.full(900, np.nan)), "finite"),
    ("uncorrelated", "unequal", lambda: (np.arange(900), np.arange(901)), "one length"),
    ("uncorrelated", "tables", lambda: (np.ones((30, 30)), np.ones((30, 30))), "two arrays (n,)"),
    ("uncorrelated", "one array", lambda: np.arange(900), "returned"),
    ("chance_alone", "zero", 0, "never exactly fair"),
    ("chance_alone", "one not taken off", 0.0191, "one is taken off"),
    ("chance_alone", "2 forgotten", 0.0204, "2 N stands below"),
    ("chance_alone", "one pixel", 0.5, "not those of one pixel"),
    ("chance_alone", "pixels", 0.0816, "not its pixels"),
    ("chance_alone", "one row", 0.0714, "7 x 7 pixels, not 7"),
    ("chance_alone", "bits", 0.0147, "in bits"),
    ("chance_alone", "a guess", 0.03, "into the formula"),
    ("chance_share", "zero", 0, "finds a little by chance"),
    ("chance_share", "half", 0.5, "only two positions"),
    ("chance_share", "one", 1, "the two positions find"),
    ("chance_share", "ratio", 2, "between 0 and 1"),
    ("chance_share", "positions", 0.3333, "1 - W"),
    ("chance_share", "one of four", 0.25, "one of four"),
    ("chance_share", "features too", 0.2667, "the features do not stand"),
    ("chance_share", "a guess", 0.8, "How many d"),
    ("dependency_shares", "1 - W", with_ratio(lambda a, b: 1 - share(a, b)), "1 - W"),
    ("dependency_shares", "r / p", with_radiance(lambda r, p: r.sum(1) / p.sum(1)), "missing a part"),
    (
        "dependency_shares",
        "mean of ratios",
        with_radiance(lambda r, p: np.mean(r / (r + p.sum(1, keepdims=True)), axis=1)),
        "sum first, divide then",
    ),
    (
        "dependency_shares",
        "means",
        with_radiance(lambda r, p: share(r.mean(1), r.mean(1) + p.mean(1))),
        "the mean over the random parameters",
    ),
    (
        "dependency_shares",
        "largest",
        with_radiance(lambda r, p: share(r.max(1), r.max(1) + p.sum(1))),
        "only the largest",
    ),
    (
        "dependency_shares",
        "wrong axis",
        with_radiance(lambda r, p: share(r.sum(0), r.sum(0) + p.sum())),
        "summed over the channels",
    ),
    (
        "dependency_shares",
        "all channels as one",
        with_radiance(lambda r, p: np.full(3, share(r.sum(), r.sum() + p.sum()))),
        "one ratio for all channels",
    ),
    (
        "dependency_shares",
        "features in the whole",
        lambda *a: (share(a[0].sum(1), a[0].sum(1) + a[1].sum(1) + a[2].sum(1)), *shares(*a)[1:]),
        "the features do not belong",
    ),
    (
        "dependency_shares",
        "feature: 1 - W",
        with_feature(lambda r, p: 1 - share(r.sum(1), r.sum(1) + p.sum(1))),
        "1 - W",
    ),
    ("dependency_shares", "feature: r / p", with_feature(lambda r, p: r.sum(1) / p.sum(1)), "missing a part"),
    ("dependency_shares", "feature: wrong axis", with_feature(lambda r, p: r.sum(0)), "one number for each feature"),
    ("dependency_shares", "tables exchanged", with_exchanged_tables, "take the tables of the features"),
    ("dependency_shares", "beta of the paper", with_beta, "multiplied by W_c^{f,k}"),
    ("dependency_shares", "order", lambda *a: [shares(*a)[k] for k in (0, 2, 1)], "exchanged?"),
    (
        "dependency_shares",
        "indexed by channel",
        by_feature(lambda r, p, f: f.sum(1) / (r.sum() + p.sum() + f.sum())),
        "indexed by the channel",
    ),
    (
        "dependency_shares",
        "whole without f",
        by_feature(lambda r, p, f: f.sum(0) / (r.sum() + p.sum())),
        "D_c^f is missing",
    ),
    (
        "dependency_shares",
        "whole without r",
        by_feature(lambda r, p, f: f.sum(0) / (p.sum() + f.sum())),
        "D_c^r is missing",
    ),
    (
        "dependency_shares",
        "whole without p",
        by_feature(lambda r, p, f: f.sum(0) / (r.sum() + f.sum())),
        "D_c^p is missing",
    ),
    ("dependency_shares", "whole of f", by_feature(lambda r, p, f: f.sum(0) / f.sum()), "D_c^r and D_c^p are missing"),
    (
        "dependency_shares",
        "one feature beside r and p",
        by_feature(lambda r, p, f: f.sum(0) / (r.sum() + p.sum() + f.sum(0))),
        "all features stand below",
    ),
    (
        "dependency_shares",
        "mean of the channels' ratios",
        by_feature(lambda r, p, f: np.mean(f / each(r, p, f), axis=0)),
        "and then the mean",
    ),
    (
        "dependency_shares",
        "sum of the channels' ratios",
        by_feature(lambda r, p, f: np.sum(f / each(r, p, f), axis=0)),
        "the sum of three ratios",
    ),
    ("dependency_shares", "0 / 0", with_ratio(lambda a, b: a / b), "NaN (0/0)"),
    ("dependency_shares", "0 / 0 is 1", with_ratio(lambda a, b: np.where(b > 0, a / b, 1.0)), "is 1 where nothing"),
    ("dependency_shares", "0 / 0 is a half", with_ratio(lambda a, b: np.where(b > 0, a / b, 0.5)), "is 0.5 where"),
    ("dependency_shares", "epsilon", with_ratio(lambda a, b: a / (b + 1e-5)), "Is a small number"),
    ("dependency_shares", "two results", lambda *a: shares(*a)[:2], "three arrays are needed"),
    ("dependency_shares", "a table", lambda *a: np.concatenate(shares(*a)), "three arrays are needed"),
    ("dependency_shares", "returns nothing", lambda *a: None, "is the `return` missing"),
    ("what_explains", "first wrong", "BDBCDE", "place 1 is not B"),
    ("what_explains", "second wrong", "AABCDE", "hidden by the fence"),
    ("what_explains", "third wrong", "ADDCDE", "Light changes no albedo"),
    ("what_explains", "fourth wrong", ("A", "D", "B", "A", "D", "E"), "part of the exposure"),
    ("what_explains", "fifth wrong", ("A", "D", "B", "C", "A", "E"), "no shadow, no edge"),
    ("what_explains", "sixth wrong", "adbcdd", "rough metal mirrors"),
    ("what_explains", "five letters", "ADBCD", "6 letters"),
    ("what_explains", "a number", 5, "6 letters"),
    ("unseen", "seen", lambda: parabola(n=2000), "our bins still see"),
    ("unseen", "noise", at_random, "is it noise"),
    ("unseen", "no function", coins, "y is no function of x"),
    ("unseen", "too fine", lambda: (np.arange(4096), np.arange(4096) % 2), "faster than 64 bins"),
    ("unseen", "wide stripes", lambda: stripes(6), "faster than that"),
    ("unseen", "constant", lambda: (np.arange(2000), np.ones(2000)), "y is constant"),
    ("unseen", "too few", lambda: stripes(n=640), "1000 to 20000"),
    ("unseen", "two results", lambda: np.arange(2000), "returned"),
)
RIGHT = {
    "quantise": bins,
    "information_of_levels": right,
    "uncorrelated": parabola,
    "chance_alone": 0.0102,
    "chance_share": 0.67,
    "dependency_shares": shares,
    "what_explains": "adbcde",
    "unseen": stripes,
}


@pytest.mark.parametrize("exercise", RIGHT)
def test_a_right_answer_earns_every_point(exercise):
    assert_earns_every_point(exercise, RIGHT[exercise])


@pytest.mark.parametrize(("exercise", "idea"), [("uncorrelated", tent), ("unseen", waves), ("unseen", firefly)])
def test_every_right_idea_earns_every_point(exercise, idea):
    assert_earns_every_point(exercise, idea)


@pytest.mark.parametrize("epsilon", [1e-12, 1e-10])
def test_a_tiny_number_below_the_line_is_no_mistake(epsilon):
    assert_earns_every_point(
        "dependency_shares", lambda *a: shares(*a, ratio=lambda part, whole: part / (whole + epsilon))
    )
    assert_earns_every_point("information_of_levels", with_epsilon(epsilon))


@pytest.mark.parametrize(("exercise", "mistake", "answer", "words"), WRONG, ids=[f"{e}: {m}" for e, m, *_ in WRONG])
def test_a_public_test_names_the_mistake(exercise, mistake, answer, words):
    assert_mistake_is_named(exercise, mistake, answer, words)


@pytest.mark.parametrize(("exercise", "idea"), [("uncorrelated", parabola), ("unseen", stripes)])
def test_the_hidden_tests_find_what_the_public_ones_let_through(exercise, idea):
    def never_twice():
        x, y = idea()
        order = np.random.default_rng().permutation(len(x))
        return x[order], y[order]

    assert failures(exercise, never_twice, hidden=False) == []
    assert "fixed seed" in failures(exercise, never_twice, hidden=True)[-1]


def test_the_references_are_those_of_the_library(rng):
    values = rng.gamma(0.5, 1.0, (300, 2))
    x, y = (reference("quantise")(column) for column in values.T)
    np.testing.assert_array_equal(np.stack([x, y], axis=-1), quantise_columns(values))
    found = reference("information_of_levels")(x, y)
    np.testing.assert_allclose(found, mcd.mutual_information(*values.T), rtol=1e-12)


def test_the_reference_of_the_shares_is_that_of_the_library(rng):
    c, f, r, p = (rng.random((200, columns)) for columns in (3, 4, 3, 2))
    c[:, 1], f[:, 2] = 0.5, 0.25
    one = mcd.dependency(p, r, f, c)
    found = reference("dependency_shares")(one.c_r, one.c_p, one.c_f, one.f_r, one.f_p)
    for ours, theirs in zip(found, (one.share_c_r, one.share_f_r, one.share_c_f), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-12)


# --- the predictions are what is measured


@functools.cache
def captured(scene):
    return mcd.capture(scene, width=128, height=128, spp=8, seed=0, variant="scalar_rgb", progress=False)


GROUPS = {"lens": "B", "time": "C", "light": "D", "bsdf": "E"}
PLACES = (
    ("dof", 94, 66, "radiance"),
    ("soft_shadow", 75, 75, "radiance"),
    ("dof", 112, 112, "albedo"),
    ("motion", 90, 86, "radiance"),
    ("soft_shadow", 114, 110, "radiance"),
    ("glossy", 50, 22, "radiance"),
)


@pytest.mark.parametrize("number", range(6))
def test_what_explains_each_place_is_measured(number):
    scene, y, x, what = PLACES[number]
    around = captured(scene).crop(y - 3, x - 3, 7, 7)
    found = mcd.dependency_of(around)
    albedo = around.layout.chosen("features", ["albedo"])[0].columns
    random, position = (found.c_r, found.c_p) if what == "radiance" else (found.f_r[albedo], found.f_p[albedo])
    explained = {"A": position.sum()}
    for field, value in zip(around.layout.random_params, random.sum(axis=0), strict=True):
        letter = GROUPS[field.name.partition("_")[0]]
        explained[letter] = explained.get(letter, 0.0) + value
    letter = max(explained, key=explained.get)
    assert letter == reference("what_explains")[number]
    assert explained[letter] > 1.5 * sum(value for other, value in explained.items() if other != letter)


def test_chance_gives_what_is_predicted(rng):
    n, shuffles = 392, 400
    lens, albedo = rng.random(n), rng.permutation(np.repeat([0.0, 1.0, 2.0], [50, 292, 50]))
    found = [mcd.mutual_information(rng.permutation(albedo), lens) for _ in range(shuffles)]
    error = np.std(found) / np.sqrt(shuffles)
    assert abs(np.mean(found) - reference("chance_alone")) < 4 * error + 0.1 * reference("chance_alone")


def test_chance_gives_the_share_that_is_predicted(rng):
    found = [
        mcd.dependency(rng.random((392, 2)), rng.random((392, 4)), np.zeros((392, 0)), rng.random((392, 3))).share_c_r
        for _ in range(100)
    ]
    assert np.mean(found) == pytest.approx(reference("chance_share"), abs=0.01)
