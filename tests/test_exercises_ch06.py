"""The exercises of chapter 06 tested themselves: the reference earns every point, each typical mistake is named."""

import numpy as np
import pytest

import mcdenoise as mcd
from answers import ROOT, assert_earns_every_point, assert_mistake_is_named, failures, reference
from mcdenoise.rpf.blend import remove_spikes
from mcdenoise.rpf.config import RPFConfig
from mcdenoise.rpf.dependency import Dependency
from mcdenoise.rpf.draws import offset_table
from mcdenoise.rpf.weights import scales_of, weights_of

pytestmark = pytest.mark.ch06


def quietly(function):
    def silent(*arguments):
        with np.errstate(all="ignore"):
            return function(*arguments)

    return silent


# --- is_like


def far_by_the_rule(d, s, limit, tolerance):
    return (d > limit * s) & ((d > tolerance) | (s > tolerance))


def like(features, own, limits, tolerance, *, spread=np.std, distance=np.abs, far=far_by_the_rule, join=np.any):
    """The rule as a student would write it, with places for mistakes."""
    d = distance(features - own.mean(axis=0))
    return ~join(far(d, spread(own, axis=0), limits, tolerance), axis=1)


def with_far(formula):
    return lambda *a: like(*a, far=formula)


def by_all_samples(features, own, limits, tolerance):
    return like(features, features, limits, tolerance)


def from_the_first(features, own, limits, tolerance):
    far = far_by_the_rule(np.abs(features - own[0]), own.std(axis=0), limits, tolerance)
    return ~far.any(axis=1)


def first_feature(features, own, limits, tolerance):
    return like(features[:, :1], own[:, :1], limits[:1], tolerance)


# --- alpha_beta


def says(c, f, by, turn, *, alpha=None, beta=None, is_report=lambda turn: turn is not None):
    """alpha and beta of the lecture and of the report, with places for mistakes in the report."""
    if not is_report(turn):
        return 1 - c, 1 - f
    gain = 1 + 0.1 * turn
    return (
        alpha(c, gain) if alpha else np.maximum(1 - 2 * gain * c, 0),
        beta(f, by, gain) if beta else by * np.maximum(1 - gain * f, 0),
    )


def with_alpha(formula):
    return lambda *a: says(*a, alpha=formula)


def with_beta(formula):
    return lambda *a: says(*a, beta=formula)


def in_the_lecture(change):
    """Another answer for turn None."""
    return lambda c, f, by, turn: change(c, f, by) if turn is None else says(c, f, by, turn)


# --- exponent_factors


def factors(alpha, beta, share, spp, sigma, *, narrow=lambda w: (1 - w) ** 2, below=None, both=None):
    """As asked for, with places for mistakes."""
    both = np.concatenate([beta, alpha]) if both is None else both(beta, alpha)
    return both * narrow(share) / (2 * 8 * sigma / spp if below is None else below(spp, sigma))


def with_narrow(formula):
    return lambda *a: factors(*a, narrow=formula)


def with_below(formula):
    return lambda *a: factors(*a, below=formula)


@quietly
def by_division(alpha, beta, share, spp, sigma):
    return np.concatenate([beta, alpha]) / (2 * 8 * sigma / spp / np.float64(1 - share) ** 2)


def by_plain_division(alpha, beta, share, spp, sigma):
    return np.concatenate([beta, alpha]) / (2 * 8 * sigma / spp / (1 - share) ** 2)


def by_nan(alpha, beta, share, spp, sigma):
    return factors(alpha, beta, share, spp, sigma) * (1 if share < 1 else np.nan)


# --- pair_weights


def pairs(x, factors, spp, space=None, *, exponent=lambda d, k: d**2 @ k, finish=lambda w: w):
    """Weights of own samples with all, with places for mistakes."""
    weights = finish(np.exp(-exponent(x[:spp, np.newaxis] - x[np.newaxis], factors)))
    return weights if space is None else weights * space


def with_exponent(formula):
    return lambda *a: pairs(*a, exponent=formula)


def finished(change):
    return lambda *a: pairs(*a, finish=change)


def all_with_all(x, factors, spp, space=None):
    return pairs(x, factors, len(x))


def with_space(join):
    return lambda x, k, spp, space=None: pairs(x, k, spp) if space is None else join(pairs(x, k, spp), space)


def without_self(weights):
    return weights * (1 - np.eye(*weights.shape))


# --- spikes_spread


def spread(blended, limit, *, deviation=np.std, distance=np.abs, join=np.all, instead=None, give=None):
    """The treatment as a student would write it, with places for mistakes."""
    mean = blended.mean(axis=0)
    spike = join(distance(blended - mean) > limit * deviation(blended, axis=0), axis=1, keepdims=True)
    kept = np.where(spike, mean if instead is None else instead(blended, limit), blended)
    return kept + (mean - kept.mean(axis=0)) if give is None else give(kept, blended, mean, spike)


def channel_by_channel(blended, limit, *, back=True):
    mean = blended.mean(axis=0)
    kept = np.where(np.abs(blended - mean) > limit * blended.std(axis=0), mean, blended)
    return kept + (mean - kept.mean(axis=0)) * back


def given(formula):
    return lambda *a: spread(*a, give=formula)


# --- hard_scene


def lens_checkerboard(x, y, u, v):
    return np.where((u < 0.5) == (v < 0.5), 1.0, 0.2)


def screen_checkerboard(x, y, u, v):
    return np.where((np.floor(x) + np.floor(y)) % 2, 1.0, 0.5) + 0.3 * u


def stripes_on_the_lens(x, y, u, v):
    return 0.6 + 0.4 * np.where(np.floor(64 * u) % 2, 1.0, -1.0)


def rare_lamps(x, y, u, v):
    return 0.2 + 100 * (u > 0.99)


def lens_noise(x, y, u, v):
    return 1 + 0.7 * np.sin(2 * np.pi * u)


def edge_and_lens(x, y, u, v):
    return np.where(x < 8, 0.2, 1.0) * (0.5 + u)


# exercise, what the student did, the answer, what the message must say
WRONG = (
    ("twice_near", "one bell", 4.25, "one of the two bells"),
    ("twice_near", "half", 2.125, "halves the variance"),
    ("twice_near", "wider", 6.01, "wider than one bell"),
    ("twice_near", "sum", 8.5, "wider than one bell"),
    ("twice_near", "variance", 9.03, "sigma is its root"),
    ("twice_near", "of the box", 12.02, "a quarter"),
    ("twice_near", "a guess", 3.5, "Which sigma"),
    ("twice_near", "text", "three", "one number"),
    ("is_like", "inverted", lambda *a: ~like(*a), "exchanged"),
    ("is_like", "variance", lambda *a: like(*a, spread=np.var), "variance is used"),
    ("is_like", "ddof 1", lambda *a: like(*a, spread=lambda v, axis: np.std(v, axis, ddof=1)), "N - 1"),
    ("is_like", "no abs", lambda *a: like(*a, distance=np.positive), "absolute value"),
    ("is_like", "limit alone", with_far(lambda d, s, k, t: (d > k) & ((d > t) | (s > t))), "multiply by s_k"),
    ("is_like", "no limit", with_far(lambda d, s, k, t: (d > s) & (d > t)), "limits is not used"),
    ("is_like", "tolerance alone", with_far(lambda d, s, k, t: d > t), "within the limit stays"),
    ("is_like", "or for and", with_far(lambda d, s, k, t: (d > k * s) | (d > t) | (s > t)), "own samples 0 and 1"),
    ("is_like", "and for or", with_far(lambda d, s, k, t: (d > k * s) & (d > t) & (s > t)), "joined by `or`"),
    ("is_like", "no tolerance", with_far(lambda d, s, k, t: d > k * s), "tolerance is not used"),
    ("is_like", "s forgotten", with_far(lambda d, s, k, t: (d > k * s) & (d > t)), "or s_k > tolerance"),
    ("is_like", "all for any", lambda *a: like(*a, join=np.all), "any, not all"),
    ("is_like", "one limit", lambda f, o, k, t: like(f, o, k[0], t), "one for each"),
    ("is_like", "largest limit", lambda f, o, k, t: like(f, o, k.max(), t), "limit 30"),
    ("is_like", "first feature", first_feature, "only the first feature"),
    ("is_like", "of all samples", by_all_samples, "those of the pixel"),
    ("is_like", "first sample", from_the_first, "take it from the mean"),
    ("is_like", "numbers", lambda *a: like(*a).astype(int), "truth values are needed"),
    ("is_like", "a table", lambda f, o, k, t: np.abs(f - o.mean(0)) <= k * o.std(0), "one truth value a sample"),
    ("is_like", "returns nothing", lambda *a: None, "is the `return` missing"),
    ("alpha_beta", "W", in_the_lecture(lambda c, f, by: (c, f)), "alpha is W itself"),
    ("alpha_beta", "beta W", in_the_lecture(lambda c, f, by: (1 - c, f)), "beta is W itself"),
    ("alpha_beta", "exchanged", in_the_lecture(lambda c, f, by: (1 - f, 1 - c)), "are exchanged"),
    ("alpha_beta", "paper", in_the_lecture(lambda c, f, by: (1 - c, by * (1 - f))), "that is the report's"),
    ("alpha_beta", "wrong share", in_the_lecture(lambda c, f, by: (1 - c, 1 - by)), "made of W_c^{f,k}"),
    (
        "alpha_beta",
        "one for all",
        in_the_lecture(lambda c, f, by: (np.full(3, 1 - c.mean()), 1 - f)),
        "each channel has its own",
    ),
    ("alpha_beta", "if turn", lambda *a: says(*a, is_report=bool), "is it `if turn:`"),
    ("alpha_beta", "always the report", lambda c, f, by, t: says(c, f, by, t or 0), "the lecture's is asked for"),
    ("alpha_beta", "2 missing", with_alpha(lambda c, g: np.maximum(1 - g * c, 0)), "the 2 is missing"),
    ("alpha_beta", "no max", with_alpha(lambda c, g: 1 - 2 * g * c), "below 0"),
    ("alpha_beta", "abs", with_alpha(lambda c, g: np.abs(1 - 2 * g * c)), "the absolute value"),
    ("alpha_beta", "turn from 1", with_alpha(lambda c, g: np.maximum(1 - 2 * (g + 0.1) * c, 0)), "counted from 1"),
    ("alpha_beta", "no turn", with_alpha(lambda c, g: np.maximum(1 - 2 * c, 0)), "turn is not used"),
    ("alpha_beta", "2 + 0.1 t", with_alpha(lambda c, g: np.maximum(1 - (1 + g) * c, 0)), "multiplies the whole"),
    ("alpha_beta", "beta alone", with_beta(lambda f, by, g: np.maximum(1 - g * f, 0)), "W_c^{f,k} is missing"),
    ("alpha_beta", "beta no max", with_beta(lambda f, by, g: by * (1 - g * f)), "below 0"),
    ("alpha_beta", "beta with 2", with_beta(lambda f, by, g: by * np.maximum(1 - 2 * g * f, 0)), "alpha alone"),
    ("alpha_beta", "beta no turn", with_beta(lambda f, by, g: by * np.maximum(1 - f, 0)), "turn is not used"),
    ("alpha_beta", "inside", with_beta(lambda f, by, g: np.maximum(1 - g * f * by, 0)), "inside the max"),
    ("alpha_beta", "one result", lambda *a: says(*a)[0], "two arrays are needed"),
    ("alpha_beta", "returns nothing", lambda *a: None, "is the `return` missing"),
    ("exponent_factors", "order", lambda *a: factors(*a, both=lambda b, a: np.append(a, b)), "features first"),
    ("exponent_factors", "two arrays", lambda a, b, *rest: (b, a), "two arrays came back"),
    ("exponent_factors", "1 - W", with_narrow(lambda w: 1 - w), "it is squared"),
    ("exponent_factors", "forgotten", with_narrow(lambda w: 1), "(1 - W)^2 is missing"),
    ("exponent_factors", "W^2", with_narrow(lambda w: w**2), "W^2 in place"),
    ("exponent_factors", "1 - W^2", with_narrow(lambda w: 1 - w**2), "1 - W^2 in place"),
    ("exponent_factors", "divided", quietly(with_narrow(lambda w: np.float64(1 - w) ** -2)), "to grow with W"),
    ("exponent_factors", "2 missing", with_below(lambda spp, s: 8 * s / spp), "the 2 of 2 sigma^2"),
    ("exponent_factors", "spp missing", with_below(lambda spp, s: 2 * s), "spp is not used"),
    ("exponent_factors", "spp above", with_below(lambda spp, s: 2 * s * spp / 8), "the wrong side"),
    ("exponent_factors", "8 missing", with_below(lambda spp, s: 2 * s / spp), "the 8 is missing"),
    ("exponent_factors", "squared again", with_below(lambda spp, s: 2 * 8 / spp * s**2), "the square already"),
    ("exponent_factors", "root", with_below(lambda spp, s: 2 * np.sqrt(8 * s / spp)), "its root is taken"),
    ("exponent_factors", "sign", lambda *a: -factors(*a), "the sign belongs"),
    ("exponent_factors", "infinite", with_narrow(lambda w: (1 - w) ** 2 if w < 1 else np.inf), "W = 1"),
    ("exponent_factors", "NaN", by_nan, "NaN (0 / 0)"),
    ("exponent_factors", "ZeroDivisionError", by_plain_division, "ZeroDivisionError"),
    ("exponent_factors", "returns nothing", lambda *a: None, "is the `return` missing"),
    ("pair_weights", "sign", with_exponent(lambda d, k: -(d**2) @ k), "the sign of the exponent"),
    ("pair_weights", "not squared", with_exponent(lambda d, k: np.abs(d) @ k), "not squared"),
    ("pair_weights", "halved", with_exponent(lambda d, k: d**2 @ k / 2), "halved once more"),
    ("pair_weights", "divided", quietly(with_exponent(lambda d, k: d**2 @ (1 / k))), "divided by the factors"),
    ("pair_weights", "no factors", with_exponent(lambda d, k: (d**2).sum(-1)), "the factors are not used"),
    ("pair_weights", "factors squared", with_exponent(lambda d, k: d**2 @ k**2), "the factors are squared"),
    ("pair_weights", "inside the square", with_exponent(lambda d, k: ((d * k) ** 2).sum(-1)), "factors are squared"),
    ("pair_weights", "summed first", with_exponent(lambda d, k: (d @ k) ** 2), "before they are squared"),
    ("pair_weights", "root", with_exponent(lambda d, k: np.sqrt(d**2 @ k)), "the root of the sum"),
    ("pair_weights", "exponent", lambda *a: -np.log(pairs(*a)), "that is the exponent"),
    ("pair_weights", "self left out", finished(without_self), "w_ii = 1"),
    ("pair_weights", "normalised", finished(lambda w: w / w.sum(1, keepdims=True)), "divided by their sum"),
    ("pair_weights", "one row", finished(lambda w: w[0]), "one row came back"),
    ("pair_weights", "first row", finished(lambda w: np.repeat(w[:1], len(w), axis=0)), "from the first sample"),
    ("pair_weights", "transposed", finished(np.transpose), "transposed"),
    ("pair_weights", "all with all", all_with_all, "rows only for the pixel's own"),
    (
        "pair_weights",
        "from the mean",
        lambda x, k, spp, space=None: np.exp(-np.repeat((x - x[:spp].mean(0))[np.newaxis] ** 2 @ k, spp, axis=0)),
        "from the mean of the own",
    ),
    ("pair_weights", "space ignored", with_space(lambda w, s: w), "the spatial factor is not used"),
    ("pair_weights", "space added", with_space(np.add), "the spatial factor is added"),
    ("pair_weights", "space twice exp", with_space(lambda w, s: w * np.exp(-s)), "it is a weight already"),
    ("pair_weights", "space divides", with_space(np.divide), "divided by the spatial factor"),
    ("pair_weights", "returns nothing", lambda *a: None, "is the `return` missing"),
    ("corners", "A keeps edges", ("GGE", "NNN", "NGE", "NNN"), "corner A, toy 2"),
    ("corners", "B is good", ("GEE", "NNG", "NGE", "NNN"), "too bright"),
    ("corners", "C cannot", ("GEE", "NNN", "GGE", "NNN"), "the paint alone chooses"),
    ("corners", "D is best", ["gee", "nnn", "nge", "ggg"], "fewer than either"),
    ("corners", "three words", ("GEE", "NNN", "NGE"), "4 words"),
    ("corners", "long words", "GEENNNNGENNN", "4 words"),
    ("without_a_cause", "exchanged", ("NNS", "SSN"), "without the lens, the tile"),
    ("without_a_cause", "lens does all", ("SSN", "SNS"), "without the light, the tile"),
    ("without_a_cause", "ball by light", ("SSN", "NNN"), "the ball near the lens is not N"),
    ("without_a_cause", "one word", "SSNNNS", "2 words"),
    ("spikes_spread", "energy lost", given(lambda kept, *_: kept), "is lost"),
    ("spikes_spread", "no abs", lambda *a: spread(*a, distance=np.positive), "a dark sample is a spike too"),
    ("spikes_spread", "variance", lambda *a: spread(*a, deviation=np.var), "not with the variance"),
    (
        "spikes_spread",
        "ddof 1",
        lambda *a: spread(*a, deviation=lambda v, axis: np.std(v, axis, ddof=1)),
        "divided by N - 1",
    ),
    (
        "spikes_spread",
        "to the others",
        given(lambda kept, b, mean, spike: kept + ~spike * (b - kept).sum(0) / (~spike).sum()),
        "the others get it all",
    ),
    ("spikes_spread", "in full", given(lambda kept, b, mean, _: kept + (b - kept).sum(axis=0)), "it is shared"),
    (
        "spikes_spread",
        "multiplied",
        given(lambda kept, b, mean, _: kept * mean / kept.mean(axis=0)),
        "multiplied by a factor",
    ),
    ("spikes_spread", "all the mean", lambda b, k: np.repeat(b.mean(0)[np.newaxis], len(b), 0), "all samples became"),
    ("spikes_spread", "no limit", lambda b, k: spread(b, 1.0), "the limit is not used"),
    ("spikes_spread", "clamped", lambda b, k: np.minimum(b, b.mean(0) + k * b.std(0)), "a spike becomes the mean"),
    ("spikes_spread", "per channel", channel_by_channel, "one by one"),
    ("spikes_spread", "any for all", lambda *a: spread(*a, join=np.any), "all, not any"),
    ("spikes_spread", "returns nothing", lambda *a: None, "is the `return` missing"),
    ("hard_scene", "lens noise", lens_noise, "which pattern do they miss"),
    ("hard_scene", "edge", edge_and_lens, "which pattern do they miss"),
    ("hard_scene", "no noise", lambda x, y, u, v: np.floor(x) % 2, "hardly any noise"),
    ("hard_scene", "NaN", lambda x, y, u, v: np.full(len(x), np.nan), "finite"),
    ("hard_scene", "negative", lambda x, y, u, v: u - 1, "never negative"),
    ("hard_scene", "black", lambda x, y, u, v: 0 * u, "let there be light"),
    ("hard_scene", "one number", lambda x, y, u, v: 1.0, "one number a sample"),
    ("hard_scene", "colour", lambda x, y, u, v: np.stack([u, u, u], axis=-1), "one number a sample"),
)
RIGHT = {
    "twice_near": 3.0,
    "is_like": like,
    "alpha_beta": says,
    "exponent_factors": factors,
    "pair_weights": pairs,
    "corners": ["gee", "nnn", "nge", "nnn"],
    "without_a_cause": ("ssn", "nns"),
    "spikes_spread": spread,
    "hard_scene": lens_checkerboard,
}


@pytest.mark.parametrize("exercise", RIGHT)
def test_a_right_answer_earns_every_point(exercise):
    assert_earns_every_point(exercise, RIGHT[exercise])


@pytest.mark.parametrize("idea", [screen_checkerboard, stripes_on_the_lens, rare_lamps])
def test_every_right_idea_earns_every_point(idea):
    assert_earns_every_point("hard_scene", idea)


def test_a_guarded_division_is_no_mistake():
    def guarded(alpha, beta, share, spp, sigma):
        if share == 1:
            return np.zeros(len(beta) + 3)
        return by_division(alpha, beta, share, spp, sigma)

    assert_earns_every_point("exponent_factors", guarded)
    assert_earns_every_point("exponent_factors", by_division)  # 1 / infinity is 0


@pytest.mark.parametrize(("exercise", "mistake", "answer", "words"), WRONG, ids=[f"{e}: {m}" for e, m, *_ in WRONG])
def test_a_public_test_names_the_mistake(exercise, mistake, answer, words):
    assert_mistake_is_named(exercise, mistake, answer, words)


def test_the_hidden_tests_find_what_the_public_ones_let_through():
    def by_place_in_the_array(x, y, u, v):
        return lens_checkerboard(x, y, u, v) + 1e-3 * np.linspace(0, 1, len(x))

    assert failures("hard_scene", by_place_in_the_array, hidden=False) == []
    assert "its own x, y, u, v alone" in failures("hard_scene", by_place_in_the_array, hidden=True)[-1]


# --- the references are those of the library


def found_somewhere(rng, n_f):
    sizes = {"c_r": (3, 2), "c_p": (3, 2), "c_f": (3, n_f), "f_r": (n_f, 2), "f_p": (n_f, 2)}
    return Dependency(**{name: rng.random(size) for name, size in sizes.items()})


@pytest.mark.parametrize("turn", [None, 0, 3])
def test_alpha_beta_and_factors_are_those_of_the_presets(rng, turn):
    found = found_somewhere(rng, 5)
    config = RPFConfig.lecture() if turn is None else RPFConfig.technical_report(noisy=False)
    ours = reference("alpha_beta")(found.share_c_r, found.share_f_r, found.share_c_f, turn)
    theirs = weights_of(found, config, turn or 0, np.ones(5))
    np.testing.assert_allclose(ours[0], theirs.alpha, rtol=1e-12)
    np.testing.assert_allclose(ours[1], theirs.beta, rtol=1e-12)
    factor = reference("exponent_factors")(*ours, found.share_c_r.mean(), 4, config.sigma_8_squared)
    np.testing.assert_allclose(factor, scales_of(theirs, np.zeros(8), config, turn or 0, 4), rtol=1e-12)


def test_spikes_are_those_of_the_library(rng):
    blended = rng.gamma(0.5, 1.0, (8, 1)) * (0.8 + 0.4 * rng.random((8, 3)))
    assert not np.allclose(remove_spikes(blended, "joint"), blended)
    for limit in (0.5, 1.0):
        np.testing.assert_allclose(reference("spikes_spread")(blended, limit), remove_spikes(blended, "joint", limit))


# --- the predictions are what is measured


def test_near_counted_twice_is_measured():
    sigma = 100.0  # whole pixels hardly matter, and the box ends after five sigma
    table = offset_table(1001, sigma).astype(float)
    weight = np.exp(-(table**2) / (2 * sigma**2))
    found = np.sqrt(np.average(table**2, weights=weight)) / sigma * 17 / 4
    assert found == pytest.approx(reference("twice_near"), abs=0.05)


CORNERS = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0))


def toy(number, seed, spp):
    """The toys of the notebook: stripes of the lens; two paints under noisy light; an edge of radiance on such stripes."""
    rng = np.random.default_rng(seed)
    corner = np.stack(np.meshgrid(np.arange(16), np.arange(16)), axis=-1)[:, :, np.newaxis]
    u, v, position = rng.random((16, 16, spp)), rng.random((16, 16, spp)), corner + rng.random((16, 16, spp, 2)) * 0.999
    right, stripes = position[..., 0] >= 8, np.where(np.floor(8 * u) % 2, 0.8, 0.3)
    paint = np.where(right, 0.6, 0.3) if number == 2 else stripes
    light = {1: stripes * (0.5 + v), 2: paint * 2 * v, 3: np.where(right, 0.5, 0.05) * (0.7 + 0.6 * v)}[number]
    grey = np.repeat(light[..., np.newaxis], 3, axis=-1)
    return mcd.SampleBuffer.from_arrays(grey, position, {"lens_u": u, "light_v": v}, {"paint": paint})


@pytest.mark.parametrize("number", [1, 2, 3])
def test_what_each_corner_does_is_measured(number):
    few, truth = toy(number, 0, 8), mcd.pixel_mean(toy(number, 1, 1024).radiance)[..., 0]
    noisy, far = mcd.pixel_mean(few.radiance)[..., 0], np.r_[0:3, 13:16]
    settings = {"boxes": (7,), "deterministic": True, "clustering": False, "sigma_8_squared": 0.1}
    step = np.abs(truth[:, 8] - truth[:, 7]).mean()
    for (alpha, beta), word in zip(CORNERS, reference("corners"), strict=True):
        image = mcd.rpf(few, mcd.RPFConfig.lecture(alpha=alpha, beta=beta, **settings), progress=False)[..., 0]
        left = (image - truth)[:, far].std() / (noisy - truth)[:, far].std()  # noise, away from the edge
        lost = step > 0.1 and np.abs((image - truth)[:, 7:9].mean(axis=0)).max() > 0.2 * step
        measured = "E" if lost else "G" if left < 0.35 else "N" if left > 0.8 else "?"
        assert measured == word[number - 1], (alpha, beta, left, lost)


def test_what_stays_noisy_is_measured():
    samples = mcd.capture("dof", width=128, height=128, spp=8, seed=0, variant="scalar_rgb", progress=False)
    samples = samples.crop(64, 40, 64, 88)
    truth = mcd.read_exr(ROOT / "notebooks" / "data" / "dof.exr")[64:, 40:]

    def errors(image):
        error = mcd.relmse_map(image, truth)
        return [error[y - 68 : y - 59, x - 44 : x - 35].mean() for y, x in ((118, 76), (83, 86), (120, 122))]

    def filtered(random_params):
        config = mcd.RPFConfig.lecture(boxes=(17, 7), sigma_8_squared=0.3, random_params=random_params)
        return errors(mcd.rpf(samples, config, progress=False))

    noisy, smooth = errors(mcd.pixel_mean(samples.radiance)), filtered(None)
    for asked, word in zip((("light_u", "light_v"), ("lens_u", "lens_v")), reference("without_a_cause"), strict=True):
        for letter, all_noise, least, left in zip(word, noisy, smooth, filtered(asked), strict=True):
            back = (left - least) / (all_noise - least)  # of the noise that RPF takes away
            assert back > 0.25 if letter == "N" else back < 0.1, (asked, letter, back)
