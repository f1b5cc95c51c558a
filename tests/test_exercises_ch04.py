"""The exercises of chapter 04 tested themselves: the reference earns every point, each typical mistake is named."""

import numpy as np
import pytest

from answers import assert_earns_every_point, assert_mistake_is_named, failures, picture, reference

pytestmark = pytest.mark.ch04


def joined(square, var_p, var_q, sigma):
    """The exponent of one feature, as asked for."""
    return np.sum(square / (sigma**2 + var_p + var_q)) / 2


def product(bells):
    return np.prod(bells)


def weights(
    features,
    variances,
    sigmas,
    y,
    x,
    sigma_space,
    radius,
    *,
    exponent=joined,
    difference=np.square,
    join=product,
    near=1.0,
    shift=(0, 0),
    wrap=False,
):
    """The loop a student would write, with places for mistakes."""
    height, width = next(iter(features.values())).shape[:2]
    weight = np.zeros((2 * radius + 1, 2 * radius + 1))
    for dy in range(-radius, radius + 1):
        for dx in range(-radius, radius + 1):
            there = y + dy, x + dx
            if wrap:
                there = there[0] % height, there[1] % width
            if 0 <= there[0] < height and 0 <= there[1] < width:
                bells = [
                    np.exp(
                        -exponent(
                            difference(features[name][there] - features[name][y, x]),
                            variances[name][y, x],
                            variances[name][there],
                            sigmas[name],
                        )
                    )
                    for name in features
                ]
                space = ((dy + shift[0]) / sigma_space) ** 2 + ((dx + shift[1]) / sigma_space) ** 2
                weight[radius + dy, radius + dx] = np.exp(-near * space / 2) * join(bells)
    return weight


def with_exponent(formula):
    return lambda *a: weights(*a, exponent=formula)


def spoiling_weights(features, *rest):
    for feature in features.values():
        feature *= 2
    return weights(features, *rest)


def excess(square, own, other, k):
    """One place of the patch, as asked for."""
    return (square - own - min(own, other)) / (k**2 * (own + other))


def distance(
    image,
    variance,
    p,
    q,
    patch_radius,
    k,
    *,
    place=excess,
    channels=np.mean,
    patch=np.mean,
    last=0,
    clip=(True, True),
    least=0.0,
    fill=None,
):
    """The loop a student would write, with places for mistakes."""
    height, width = variance.shape
    places = []
    for dy in range(-patch_radius, patch_radius + 1 + last):
        for dx in range(-patch_radius, patch_radius + 1 + last):
            a, b = (p[0] + dy, p[1] + dx), (q[0] + dy, q[1] + dx)
            outside = [not (0 <= one[0] < height and 0 <= one[1] < width) for one in (a, b)]
            if any(out and clipped for out, clipped in zip(outside, clip, strict=True)):
                if fill is not None:
                    places.append(fill)
                continue
            a, b = (a[0] % height, a[1] % width), (b[0] % height, b[1] % width)
            places.append(place(channels((image[a] - image[b]) ** 2), variance[a], variance[b], k))
    return max(least, patch(places))


def at_each_place(formula):
    return lambda *a: distance(*a, place=formula)


def middle_only(image, variance, p, q, patch_radius, k):
    return distance(image, variance, p, q, 0, k)


def divided_by_nine(image, variance, p, q, patch_radius, k):
    return distance(image, variance, p, q, patch_radius, k, patch=np.sum) / (2 * patch_radius + 1) ** 2


def subtracted_once(image, variance, p, q, patch_radius, k):
    square = distance(image, variance, p, q, patch_radius, k, place=lambda s, *_: s, patch=np.sum)
    own, other = variance[p], variance[q]
    return max(0.0, (square - own - min(own, other)) / (k**2 * (own + other)))


def demodulated(image, albedo):
    factor = np.maximum(albedo, 0.1)
    return image / factor, factor


def with_factor(make):
    return lambda image, albedo: (image / make(albedo), make(albedo))


def quietly(function):
    def silent(*arguments):
        with np.errstate(all="ignore"):
            return function(*arguments)

    return silent


def unrelated(amplitude=0.1, bias=0.0, side=32, shade=1.0):
    """A feature of noise alone, of which every pixel has another value."""
    rng = np.random.default_rng(0)
    truth = np.full((side, side), 0.5)
    coin = rng.permutation(truth.size).reshape(truth.shape) % 2
    return truth + amplitude * (2 * coin - 1) + bias, shade * rng.random(truth.shape), truth


def unknown_edge():
    """An edge of the radiance that the feature does not have."""
    truth = np.full((40, 40), 0.2)
    truth[:, 20:] = 1.0
    return truth + np.random.default_rng(0).normal(0, 0.05, truth.shape), np.full((40, 40), 0.5), truth


def same_noise():
    """The noise of the feature is that of the radiance, as behind a lens."""
    noise = np.random.default_rng(0).normal(0, 0.1, (40, 40)).clip(-0.4, 0.4)
    return 0.5 + noise, 0.5 + noise, np.full((40, 40), 0.5)


def honest():
    """The feature knows the edge: it leads well."""
    noisy, _, truth = unknown_edge()
    return noisy, truth, truth


def checkered():
    """A feature of two values: half of the neighbours still count."""
    noisy, _, truth = unrelated()
    return noisy, np.indices(truth.shape).sum(axis=0) % 2, truth


# exercise, what the student did, the answer, what the message must say
WRONG = (
    ("breaking_scenes", "pinhole", "BBBCD", "pinhole is not B"),
    ("breaking_scenes", "dof", ("A", "A", "B", "C", "D"), "start all over the lens"),
    ("breaking_scenes", "motion", ("A", "B", "A", "C", "D"), "another instant"),
    ("breaking_scenes", "glossy", ("A", "B", "B", "D", "D"), "black metal"),
    ("breaking_scenes", "soft_shadow", ("A", "B", "B", "C", "C"), "one colour and one normal"),
    ("breaking_scenes", "four letters", "ABBC", "5 letters"),
    ("breaking_scenes", "a number", 3, "5 letters"),
    ("expected_difference", "zero", 0, "do not cancel"),
    ("expected_difference", "minus", 0.02, "has a plus"),
    ("expected_difference", "mean", 0.04, "mean of the two"),
    ("expected_difference", "squares", 0.0034, "sum of their squares"),
    ("expected_difference", "product", 0.0015, "their product"),
    ("expected_difference", "twice", 0.16, "twice too much"),
    ("expected_difference", "root", 0.283, "that is the root"),
    ("expected_difference", "sum of deviations", 0.397, "do not add up"),
    ("expected_difference", "its square", 0.157, "their squares do"),
    ("expected_difference", "a guess", 0.1, "expand"),
    ("nlm_limits", "first wrong", ("A", "A", "B", "C", "D"), "question 1"),
    ("nlm_limits", "second wrong", ("B", "B", "B", "C", "D"), "question 2"),
    ("nlm_limits", "third wrong", ("B", "A", "A", "C", "D"), "question 3"),
    ("nlm_limits", "fourth wrong", ("B", "A", "B", "A", "D"), "question 4"),
    ("nlm_limits", "fifth wrong", "babcb", "question 5"),
    ("nlm_limits", "two letters", ("A", "B"), "5 letters"),
    ("feature_weights", "space forgotten", lambda *a: weights(*a, near=0.0), "spatial kernel is missing"),
    ("feature_weights", "2 missing, space", lambda *a: weights(*a, near=2.0), "is the 2 of 2 sigma^2 missing"),
    ("feature_weights", "off centre", lambda *a: weights(*a, shift=(0, -1)), "off centre"),
    ("feature_weights", "normalised", lambda *a: weights(*a) / weights(*a).sum(), "divided by the sum"),
    ("feature_weights", "transposed", lambda *a: weights(*a).T, "transposed"),
    ("feature_weights", "wrap-around", lambda *a: weights(*a, wrap=True), "wrap-around"),
    ("feature_weights", "features forgotten", lambda *a: weights(*a, join=lambda _: 1.0), "features have no say"),
    ("feature_weights", "last feature", lambda *a: weights(*a, join=lambda b: b[-1]), "only the last feature"),
    ("feature_weights", "first feature", lambda *a: weights(*a, join=lambda b: b[0]), "only the first feature"),
    ("feature_weights", "bells added", lambda *a: weights(*a, join=sum), "factor of 2"),
    ("feature_weights", "bells averaged", lambda *a: weights(*a, join=np.mean), "multiplied"),
    ("feature_weights", "smallest bell", lambda *a: weights(*a, join=min), "the smaller of the two"),
    (
        "feature_weights",
        "L1",
        lambda *a: weights(*a, difference=lambda d: np.abs(d).sum() ** 2 / d.size),
        "not the diff",
    ),
    (
        "feature_weights",
        "2 missing",
        with_exponent(lambda s, a, b, sigma: np.sum(s / (sigma**2 + a + b))),
        "the factor 1/2 in the exponent",
    ),
    (
        "feature_weights",
        "sigma not squared",
        with_exponent(lambda s, a, b, sigma: np.sum(s / (sigma + a + b)) / 2),
        "sigma is to be squared",
    ),
    (
        "feature_weights",
        "not squared",
        with_exponent(lambda s, a, b, sigma: np.sum(np.sqrt(s) / (sigma**2 + a + b)) / 2),
        "the difference is to be squared",
    ),
    (
        "feature_weights",
        "mean over channels",
        with_exponent(lambda s, a, b, sigma: np.mean(s / (sigma**2 + a + b)) / 2),
        "summed over the channels, not averaged",
    ),
    (
        "feature_weights",
        "first channel",
        with_exponent(lambda s, a, b, sigma: s[0] / (sigma**2 + a + b)[0] / 2),
        "all channels count",
    ),
    (
        "feature_weights",
        "no noise",
        with_exponent(lambda s, a, b, sigma: np.sum(s) / sigma**2 / 2),
        "the variances have no say",
    ),
    (
        "feature_weights",
        "noise of p",
        with_exponent(lambda s, a, b, sigma: np.sum(s / (sigma**2 + a)) / 2),
        "q is noisy too",
    ),
    (
        "feature_weights",
        "noise of q",
        with_exponent(lambda s, a, b, sigma: np.sum(s / (sigma**2 + b)) / 2),
        "p is noisy too",
    ),
    (
        "feature_weights",
        "mean of the variances",
        with_exponent(lambda s, a, b, sigma: np.sum(s / (sigma**2 + (a + b) / 2)) / 2),
        "the sum is needed",
    ),
    (
        "feature_weights",
        "deviations",
        with_exponent(lambda s, a, b, sigma: np.sum(s / (sigma**2 + np.sqrt(a) + np.sqrt(b))) / 2),
        "not standard deviations",
    ),
    (
        "feature_weights",
        "variances squared",
        with_exponent(lambda s, a, b, sigma: np.sum(s / (sigma**2 + a**2 + b**2)) / 2),
        "a square already",
    ),
    (
        "feature_weights",
        "channels together",
        with_exponent(lambda s, a, b, sigma: np.sum(s) / (sigma**2 + np.mean(a + b)) / 2),
        "yours are averaged first",
    ),
    (
        "feature_weights",
        "channels together, summed",
        with_exponent(lambda s, a, b, sigma: np.sum(s) / (sigma**2 + np.sum(a + b)) / 2),
        "yours are summed first",
    ),
    (
        "feature_weights",
        "cut to size",
        lambda f, v, s, y, x, *a: weights(f, v, s, y, x, *a)[max(0, a[1] - y) :],
        "shape (3, 5) came back, (5, 5) is needed",
    ),
    ("feature_weights", "spoils its input", spoiling_weights, "modified its input `features`"),
    ("feature_weights", "whole numbers", lambda *a: weights(*a).astype(int), "whole numbers"),
    ("feature_weights", "returns nothing", lambda *a: None, "is the `return` missing"),
    (
        "patch_distance",
        "noise left in",
        at_each_place(lambda s, a, b, k: s / (k**2 * (a + b))),
        "the noise is not taken off",
    ),
    (
        "patch_distance",
        "min forgotten",
        at_each_place(lambda s, a, b, k: (s - a - b) / (k**2 * (a + b))),
        "taken off is var_p + var_q",
    ),
    (
        "patch_distance",
        "own only",
        at_each_place(lambda s, a, b, k: (s - a) / (k**2 * (a + b))),
        "min(var_p, var_q) is missing",
    ),
    (
        "patch_distance",
        "least only",
        at_each_place(lambda s, a, b, k: (s - min(a, b)) / (k**2 * (a + b))),
        "var_p is missing",
    ),
    (
        "patch_distance",
        "p and q exchanged",
        at_each_place(lambda s, a, b, k: excess(s, b, a, k)),
        "are p and q exchanged",
    ),
    (
        "patch_distance",
        "max for min",
        at_each_place(lambda s, a, b, k: (s - a - max(a, b)) / (k**2 * (a + b))),
        "the smaller one is meant",
    ),
    ("patch_distance", "k not squared", at_each_place(lambda s, a, b, k: excess(s, a, b, k) * k), "k is to be squared"),
    ("patch_distance", "no k", at_each_place(lambda s, a, b, k: excess(s, a, b, 1)), "k is missing"),
    ("patch_distance", "k above", at_each_place(lambda s, a, b, k: excess(s, a, b, 1 / k)), "k^2 belongs below"),
    (
        "patch_distance",
        "no brackets",
        at_each_place(lambda s, a, b, k: (s - a - min(a, b)) / k**2 * (a + b)),
        "needs its brackets",
    ),
    (
        "patch_distance",
        "no brackets above",
        at_each_place(lambda s, a, b, k: s / (k**2 * (a + b)) - a - min(a, b)),
        "after the division",
    ),
    (
        "patch_distance",
        "not in units of noise",
        at_each_place(lambda s, a, b, k: (s - a - min(a, b)) / k**2),
        "nothing is divided by the noise",
    ),
    (
        "patch_distance",
        "divided by own",
        at_each_place(lambda s, a, b, k: (s - a - min(a, b)) / (k**2 * a)),
        "stands var_p alone",
    ),
    (
        "patch_distance",
        "divided by other",
        at_each_place(lambda s, a, b, k: (s - a - min(a, b)) / (k**2 * b)),
        "stands var_q alone",
    ),
    ("patch_distance", "the weight", lambda *a: np.exp(-distance(*a)), "that is the weight"),
    ("patch_distance", "the root", lambda *a: np.sqrt(distance(*a)), "d^2 is asked for"),
    ("patch_distance", "sum over patch", lambda *a: distance(*a, patch=np.sum), "sum over the patch"),
    ("patch_distance", "sum over channels", lambda *a: distance(*a, channels=np.sum), "averaged over the channels"),
    ("patch_distance", "first channel", lambda *a: distance(*a, channels=lambda s: s[0]), "not only the first"),
    (
        "patch_distance",
        "max at each place",
        at_each_place(lambda *a: max(0.0, excess(*a))),
        "taken pixel by pixel",
    ),
    ("patch_distance", "max forgotten", lambda *a: distance(*a, least=-np.inf), "is max(0, ...) missing"),
    ("patch_distance", "one short", lambda *a: distance(*a, last=-1) if a[4] else distance(*a), "too small"),
    ("patch_distance", "one long", lambda *a: distance(*a, last=1) if a[4] else distance(*a), "too large"),
    ("patch_distance", "noise off once", subtracted_once, "the noise is taken off once"),
    ("patch_distance", "the middle alone", middle_only, "Is only the pixel in the middle"),
    ("patch_distance", "wrap-around", lambda *a: distance(*a, clip=(False, False)), "wrap-around"),
    ("patch_distance", "wrap-around of q", lambda *a: distance(*a, clip=(True, False)), "look at q too"),
    ("patch_distance", "divided by nine", divided_by_nine, "only 4 places"),
    (
        "patch_distance",
        "outside is equal",
        lambda i, v, *a: distance(i, v, *a, fill=excess(0, 1, 1, a[-1])),
        "as if they were equal",
    ),
    (
        "patch_distance",
        "one a channel",
        lambda *a: distance(*a, channels=lambda s: s, patch=lambda x: x[0])[()],
        "stopped",
    ),
    ("patch_distance", "NaN", lambda *a: np.nan, "NaN"),
    ("patch_distance", "returns nothing", lambda *a: None, "is the `return` missing"),
    ("demodulate", "0 / 0", quietly(with_factor(lambda a: a)), "NaN (0/0)"),
    ("demodulate", "divided by 0", quietly(lambda i, a: ((i + 1e-9) / a, a)), "infinite (division by 0)"),
    ("demodulate", "floor of 0.01", with_factor(lambda a: np.maximum(a, 0.01)), "blown up a hundred times"),
    ("demodulate", "something added", with_factor(lambda a: a + 0.001), "plus 0.001"),
    ("demodulate", "factor 0", lambda i, a: (demodulated(i, a)[0], a), "is lost"),
    ("demodulate", "a step to 1", with_factor(lambda a: np.where(a < 0.1, 1, a)), "jumps from 0.1 to 1"),
    (
        "demodulate",
        "all three channels",
        with_factor(
            lambda a: np.where(a.min(axis=-1, keepdims=True) < 0.1, a.max(axis=-1, keepdims=True).clip(0.1), a)
        ),
        "channel by channel",
    ),
    (
        "demodulate",
        "mean over channels",
        lambda i, a: (i / a.mean(axis=-1, keepdims=True).clip(0.01), a),
        "each channel has its own albedo",
    ),
    ("demodulate", "multiplied", lambda i, a: (i * a, demodulated(i, a)[1]), "divide, so that"),
    ("demodulate", "left alone", lambda i, a: (i, demodulated(i, a)[1]), "texture is still"),
    ("demodulate", "exchanged", lambda i, a: demodulated(i, a)[::-1], "are exchanged"),
    ("demodulate", "one result", lambda i, a: demodulated(i, a)[0], "2 results are needed"),
    ("misleading", "honest", honest, "at least five times"),
    ("misleading", "checkered", checkered, "leaves a pixel alone"),
    ("misleading", "no noise", lambda: unrelated(amplitude=0.0), "standard deviation"),
    ("misleading", "biased", lambda: unrelated(bias=0.2), "the mean"),
    ("misleading", "above 1", lambda: unrelated(shade=5.0), "lie in [0, 1]"),
    ("misleading", "too small", lambda: unrelated(side=8), "16 to 64"),
    ("misleading", "NaN", lambda: (np.full((20, 20), np.nan), *unrelated(side=20)[1:]), "finite"),
    ("misleading", "unequal", lambda: (*unrelated()[:2], np.zeros((20, 20))), "one size"),
    ("misleading", "colour", lambda: [np.dstack([one] * 3) for one in unrelated()], "images (h, w)"),
    ("misleading", "two images", lambda: unrelated()[:2], "returned"),
)
RIGHT = {
    "breaking_scenes": ("a", "b", "b", "c", "d"),
    "expected_difference": 0.08,
    "nlm_limits": "BABCD",
    "feature_weights": weights,
    "patch_distance": distance,
    "demodulate": demodulated,
    "misleading": unrelated,
}


@pytest.mark.parametrize("exercise", RIGHT)
def test_a_right_answer_earns_every_point(exercise):
    assert_earns_every_point(exercise, RIGHT[exercise])


@pytest.mark.parametrize("idea", [unrelated, unknown_edge, same_noise])
def test_every_right_idea_misleads(idea):
    assert_earns_every_point("misleading", idea)


@pytest.mark.parametrize(("exercise", "mistake", "answer", "words"), WRONG, ids=[f"{e}: {m}" for e, m, *_ in WRONG])
def test_a_public_test_names_the_mistake(exercise, mistake, answer, words):
    assert_mistake_is_named(exercise, mistake, answer, words)


def test_the_hidden_tests_find_what_the_public_ones_let_through():
    def never_twice():
        noisy, _, truth = unrelated()
        return noisy, np.random.default_rng().random(truth.shape), truth

    assert failures("misleading", never_twice, hidden=False) == []
    assert "fixed seed" in failures("misleading", never_twice, hidden=True)[-1]


def test_the_picture_of_the_demodulated_reference_is_its_target():
    yours, target = picture("demodulate")
    np.testing.assert_allclose(yours, target, rtol=1e-12)


def test_the_reference_of_the_patches_is_the_distance_of_nl_means():
    rng = np.random.default_rng(3)
    image, variance = rng.random((6, 7, 3)), 0.01 + 0.1 * rng.random((6, 7))
    for p, q in (((0, 0), (5, 6)), ((3, 3), (2, 5))):
        expected = distance(image, variance, p, q, 2, 0.5)
        np.testing.assert_allclose(reference("patch_distance")(image, variance, p, q, 2, 0.5), expected, rtol=1e-12)
