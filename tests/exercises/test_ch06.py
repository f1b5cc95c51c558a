"""The exercises of chapter 06, random parameter filtering: what holds for a right answer."""

import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import Finding, assert_matches, graded, name_mistake


def _number(answer):
    """The answer as a float, or a message."""
    assert isinstance(answer, (int, float, np.number)), f"one number is needed, got {answer!r}."
    return float(answer)


# --- twice_near


@graded("twice_near", points=1)
def test_near_counted_twice(impl):
    "The bandwidth that is left if the nearness is drawn and weighted too, in a box of 17 pixels, to two digits."
    value = _number(impl)
    for wrong, words in (
        (17 / 4, "that is sigma_p, of one of the two bells: their product is narrower"),
        (17 / 8, "each of the two halves the variance, not the bandwidth: add up the exponents"),
        (17 / 4 * np.sqrt(2), "that is wider than one bell alone: a product of two bells is narrower"),
        (17 / 2, "that is wider than one bell alone: a product of two bells is narrower"),
        ((17 / 4) ** 2 / 2, "that is the variance: sigma is its root"),
        (17 / np.sqrt(2), "that is of the box: sigma_p is a quarter of it"),
    ):
        assert abs(value - wrong) > 0.01 * wrong, f"{value:.3g}: {words}."
    assert abs(value - 17 / 4 / np.sqrt(2)) <= 0.02, (
        f"{value:.3g} is not it: both bells are exp(-d^2 / (2 sigma_p^2)), with sigma_p = box / 4. Which sigma has their "
        f"product?"
    )


# --- is_like(features, own, limits, tolerance)


def _assert_kinds(found, expected, what):
    """Truth values, one a sample."""
    kind = np.asarray(found).dtype.kind
    if np.shape(found) == np.shape(expected) and kind in "iuf":
        raise Finding(
            f"{what}: numbers came back, truth values are needed, so that they can choose: samples[is_like(...)]."
        )
    if np.ndim(found) == 2:
        raise Finding(
            f"{what}: one truth value a sample is needed, not one a feature; shape {np.shape(found)} came back."
        )
    assert_matches(found, expected, what)


@graded("is_like", points=1)
def test_how_far_is_far(impl):
    "Far is what lies more than limit standard deviations from the mean of the pixel's own samples, on either side."
    own, distance = np.array([[0.0], [1.0]]), np.array([0.0, 0.5, 0.6, 0.8, 1.4, 1.7, 2.4, 3.2, -1.4, -1.7])
    expected, what = np.abs(distance) <= 1.5, "own samples 0 and 1, limit 3"
    mistakes = {
        "True and False are exchanged: True is what stays": ~expected,
        "the variance is used: the standard deviation is its root": np.abs(distance) <= 0.75,
        "divided by N - 1 in the standard deviation: divide by N": np.abs(distance) <= 3 * np.sqrt(0.5),
        "only samples above the mean are left out: take the absolute value": distance <= 1.5,
        "the limit is a number of standard deviations: multiply by s_k": np.abs(distance) <= 3,
        "one standard deviation is the limit: limits is not used": np.abs(distance) <= 0.5,
        "only what is nearer than the tolerance stays: a sample within the limit stays too": np.abs(distance) <= 0.1,
        "nothing is left out. Are mean and deviation those of all samples? Take those of the pixel, `own`": np.ones(
            10, bool
        ),
        "the distance is taken from the pixel's first sample: take it from the mean": np.abs(distance + 0.5) <= 1.5,
    }
    found = impl(0.5 + distance[:, np.newaxis], own, np.array([3.0]), 0.1)
    name_mistake(found, expected, mistakes, what)
    _assert_kinds(found, expected, what)


@graded("is_like", points=0.5)
def test_one_far_feature_is_enough(impl):
    "A sample is left out if any of its features is far, each by the limit of its own column."
    own = np.array([[0.0, 10.0, 1.0], [2.0, 14.0, 3.0]])  # mean 1, 12, 2; deviation 1, 2, 1
    features = np.array(
        [[1.0, 12.0, 2.0], [5.0, 12.0, 2.0], [1.0, 20.0, 2.0], [1.0, 12.0, 12.0], [5.0, 20.0, 40.0], [1.0, 92.0, 2.0]]
    )
    expected, what = np.array([True, False, False, True, False, False]), "three features, limits 3, 3 and 30"
    mistakes = {
        "only samples that are far in all features are left out: one is enough (any, not all)": [1, 1, 1, 1, 0, 1],
        "every column has the limit 3: limits has one for each": [1, 0, 0, 0, 0, 0],
        "only the first feature is asked": [1, 0, 1, 1, 0, 1],
        "the limit 30 is used for all columns": [1, 1, 1, 1, 0, 0],
    }
    found = impl(features, own, np.array([3.0, 3.0, 30.0]), 0.1)
    name_mistake(found, expected, mistakes, what)
    _assert_kinds(found, expected, what)


@graded("is_like", points=0.5)
def test_a_small_difference_is_never_far(impl):
    "Where the pixel's own samples are all alike a sample stays within the tolerance; and only there."
    own, features = np.full((4, 1), 0.5), np.array([[0.5], [0.55], [0.41], [0.65], [0.3]])
    expected, what = np.array([True, True, True, False, False]), "own samples all 0.5, tolerance 0.1"
    mistakes = {
        "everything that differs is far: the tolerance is not used": [1, 0, 0, 0, 0],
        "nothing is far: distance and deviation are joined by `or`, one above the tolerance is enough": [1, 1, 1, 1, 1],
    }
    found = impl(features, own, np.array([3.0]), 0.1)
    name_mistake(found, expected, mistakes, what)
    _assert_kinds(found, expected, what)
    own = np.array([[0.0], [0.4]])  # deviation 0.2, above the tolerance
    found, what = (
        impl(np.array([[0.21], [0.28]]), own, np.array([0.25]), 0.1),
        "deviation 0.2, limit 0.25, tolerance 0.1",
    )
    mistakes = {"the tolerance counts only where s_k is below it too: `or s_k > tolerance`": [1, 1]}
    name_mistake(found, np.array([True, False]), mistakes, what)
    _assert_kinds(found, np.array([True, False]), what)


@graded("is_like", points=0.5, hidden=True)
def test_any_features(impl):
    "Any number of samples and features, any limits and tolerance; also one own sample."
    rng = np.random.default_rng(4)
    for n, spp, n_f, tolerance in ((50, 8, 9, 0.1), (30, 1, 4, 0.3), (20, 32, 1, 0.01)):
        own, features = rng.normal(size=(spp, n_f)), 2 * rng.normal(size=(n, n_f))
        own[:, 0] = features[::3, 0] = 0.25
        limits = rng.choice([2.0, 3.0, 30.0], n_f)
        expected = []
        for sample in features:
            far = False
            for k in range(n_f):
                m, s = own[:, k].mean(), np.sqrt(((own[:, k] - own[:, k].mean()) ** 2).mean())
                d = abs(sample[k] - m)
                far = far or (d > limits[k] * s and (d > tolerance or s > tolerance))
            expected.append(not far)
        what = f"{n} samples of {n_f} features, {spp} own"
        _assert_kinds(impl(features, own, limits, tolerance), np.array(expected), what)


# --- alpha_beta(share_c_r, share_f_r, share_c_f, turn)

SHARES = np.array([0.1, 0.3, 0.6]), np.array([0.2, 0.95, 0.5, 0.0]), np.array([0.1, 0.2, 0.3, 0.4])


def _two(impl, *arguments):
    found = impl(*arguments)
    if found is None:
        raise Finding("nothing came back (None): is the `return` missing?")
    if not isinstance(found, (tuple, list)) or len(found) != 2:
        raise Finding("two arrays are needed, alpha (3,) and beta (n_f,), in this order; something else came back.")
    return found


@graded("alpha_beta", points=1)
def test_what_is_trusted_in_the_lecture(impl):
    "The lecture: alpha_k = 1 - W_{c,k}^r, beta_k = 1 - W_{f,k}^r."
    c, f, by = SHARES
    alpha, beta = _two(impl, c, f, by, None)
    if np.shape(alpha) == f.shape and np.shape(beta) == c.shape:
        raise Finding("lecture (turn None): alpha and beta are exchanged: alpha, of the 3 channels, comes first.")
    mistakes = {
        "alpha is W itself: what the random parameters explain is to lose its say": c,
        "one number for all channels: each channel has its own": np.full(3, 1 - c.mean()),
        "that is the report's: for turn None the lecture's is asked for": np.maximum(1 - 2 * c, 0),
    }
    name_mistake(alpha, 1 - c, mistakes, "lecture (turn None), alpha")
    assert_matches(alpha, 1 - c, "lecture (turn None), alpha")
    mistakes = {
        "beta is W itself: what the random parameters explain is to lose its say": f,
        "multiplied by W_c^{f,k}: that is the report's, the lecture has beta_k = 1 - W_{f,k}^r": by * (1 - f),
        "made of W_c^{f,k}: beta comes from the share of the random parameters in the feature": 1 - by,
    }
    name_mistake(beta, 1 - f, mistakes, "lecture (turn None), beta")
    assert_matches(beta, 1 - f, "lecture (turn None), beta")


@graded("alpha_beta", points=1)
def test_what_is_trusted_in_the_report(impl):
    "The report: alpha_k = max(1 - 2 (1 + 0.1 t) W, 0), beta_k = W_c^{f,k} max(1 - (1 + 0.1 t) W, 0)."
    c, f, by = SHARES
    for turn in (3, 0):
        gain, what = 1 + 0.1 * turn, f"report, turn {turn}"
        alpha, beta = _two(impl, c, f, by, turn)
        right = np.maximum(1 - 2 * gain * c, 0)
        mistakes = {
            "that is the lecture's: turn 0 is the first pass of the report (is it `if turn:`?)": 1 - c,
            "the 2 is missing": np.maximum(1 - gain * c, 0),
            "below 0: a weight that grows with the distance; max(..., 0) is missing": 1 - 2 * gain * c,
            "the absolute value in place of max(..., 0)": np.abs(1 - 2 * gain * c),
            "the passes are counted from 1: the first one has turn 0": np.maximum(1 - 2 * (gain + 0.1) * c, 0),
            "turn is not used": np.maximum(1 - 2 * c, 0),
            "the 2 multiplies the whole, (1 + 0.1 t)": np.maximum(1 - (2 + 0.1 * turn) * c, 0),
            "one number for all channels: each channel has its own": np.full(3, max(1 - 2 * gain * c.mean(), 0)),
        }
        mistakes = {words: value for words, value in mistakes.items() if not np.allclose(value, right)}
        name_mistake(alpha, right, mistakes, what + ", alpha")
        assert_matches(alpha, right, what + ", alpha")
        right = by * np.maximum(1 - gain * f, 0)
        mistakes = {
            "that is the lecture's: turn 0 is the first pass of the report (is it `if turn:`?)": 1 - f,
            "W_c^{f,k} is missing: a feature that says nothing about the radiance has no say": right / by,
            "below 0: max(..., 0) is missing": by * (1 - gain * f),
            "the 2 belongs to alpha alone": by * np.maximum(1 - 2 * gain * f, 0),
            "turn is not used": by * np.maximum(1 - f, 0),
            "W_c^{f,k} stands inside the max": np.maximum(1 - gain * f * by, 0),
        }
        mistakes = {words: value for words, value in mistakes.items() if not np.allclose(value, right)}
        name_mistake(beta, right, mistakes, what + ", beta")
        assert_matches(beta, right, what + ", beta")


@graded("alpha_beta", points=0.5, hidden=True)
def test_any_shares(impl):
    "All passes, any number of features, none too; alpha and beta are never below 0."
    rng = np.random.default_rng(6)
    for n_f in (0, 1, 18):
        c, f, by = rng.random(3), rng.random(n_f), rng.random(n_f)
        for turn in (None, 0, 1, 2, 3):
            alpha, beta = _two(impl, c, f, by, turn)
            report, gain = turn is not None, 1 + 0.1 * (turn or 0)
            right = [max(1 - (2 if report else 1) * gain * w, 0) for w in c]
            assert_matches(alpha, np.array(right), f"turn {turn}, alpha")
            right = [(v if report else 1) * max(1 - gain * w, 0) for w, v in zip(f, by, strict=True)]
            assert_matches(beta, np.array(right), f"turn {turn}, beta of {n_f} features")


# --- exponent_factors(alpha, beta, share, spp, sigma_8_squared)


@graded("exponent_factors", points=1)
def test_the_bandwidth_widens_with_the_share(impl):
    "Features first, then channels: beta_k and alpha_k times (1 - W)^2 / (2 sigma^2), with sigma^2 = 8 sigma_8^2 / spp."
    alpha, beta, share, spp, sigma = np.array([0.2, 0.4, 0.6]), np.array([0.5, 1.0]), 0.25, 2, 0.02
    both, squared, what = np.array([0.5, 1.0, 0.2, 0.4, 0.6]), 8 * sigma / spp, "W = 0.25, 2 spp, sigma_8^2 = 0.02"
    expected = both * (1 - share) ** 2 / (2 * squared)
    mistakes = {
        "alpha stands first: features first, then channels": np.roll(expected, 3),
        "1 - W stands there once: it is squared": both * (1 - share) / (2 * squared),
        "the 2 of 2 sigma^2 is missing": 2 * expected,
        "(1 - W)^2 is missing": both / (2 * squared),
        "W^2 in place of (1 - W)^2": both * share**2 / (2 * squared),
        "1 - W^2 in place of (1 - W)^2": both * (1 - share**2) / (2 * squared),
        "divided by (1 - W)^2: the bandwidth is to grow with W": both / (1 - share) ** 2 / (2 * squared),
        "spp is not used": both * (1 - share) ** 2 / (2 * sigma),
        "spp stands on the wrong side: with more samples the bandwidth shrinks, sigma^2 = 8 sigma_8^2 / spp": (
            both * (1 - share) ** 2 / (2 * sigma * spp / 8)
        ),
        "the 8 is missing": 8 * expected,
        "sigma_8^2 is squared once more: the argument is the square already": both
        * (1 - share) ** 2
        / (2 * (8 / spp) * sigma**2),
        "its root is taken: 2 sigma^2 stands below the line": both * (1 - share) ** 2 / (2 * np.sqrt(squared)),
        "the sign belongs to the exponent: the factors are above 0": -expected,
    }
    found = impl(alpha, beta, share, spp, sigma)
    if isinstance(found, (tuple, list)) and len(found) == 2:
        raise Finding(f"{what}: two arrays came back, one is needed: features first, then channels (np.concatenate).")
    name_mistake(found, expected, mistakes, what)
    assert_matches(found, expected, what)


@graded("exponent_factors", points=0.5)
def test_all_noise_is_no_division_by_zero(impl):
    "At W = 1 the bandwidth is infinite, and all factors are 0: no NaN, no division by zero."
    found = impl(np.array([0.0, 0.0, 0.3]), np.array([1.0, 0.5, 0.0]), 1.0, 8, 0.002)
    if np.shape(found) == (6,):
        assert not np.isnan(np.asarray(found, float)).any(), (
            "W = 1: NaN (0 / 0). Do not divide by (1 - W)^2: multiply by it in the exponent."
        )
        assert not np.isinf(np.asarray(found, float)).any(), (
            "W = 1: infinite (division by 0). An infinite bandwidth makes the factor 0."
        )
    assert_matches(found, np.zeros(6), "W = 1", atol=1e-9)


@graded("exponent_factors", points=0.5, hidden=True)
def test_any_factors(impl):
    "Any numbers of features and samples, from no noise to nothing but noise; no features too."
    rng = np.random.default_rng(8)
    for n_f, spp, share, sigma in ((0, 1, 0.0, 0.3), (9, 8, 0.4, 0.002), (18, 64, 0.99, 0.02)):
        alpha, beta = rng.random(3), rng.random(n_f)
        expected = [w * (1 - share) * (1 - share) * spp / (16 * sigma) for w in (*beta, *alpha)]
        assert_matches(
            impl(alpha, beta, share, spp, sigma), np.array(expected), f"{n_f} features, {spp} spp, W = {share}"
        )


# --- pair_weights(standardised, factors, spp, space)


@graded("pair_weights", points=1)
def test_weights_of_two_own_samples(impl):
    "exp(-sum over k of factor_k (x_ik - x_jk)^2): one row for each of the pixel's samples, one column for each sample."
    x, factors = np.array([[0.0, 0.0], [0.5, 0.0], [0.0, 2.0], [1.5, 1.0]]), np.array([1.2, 0.4])
    square = (x[:2, np.newaxis] - x[np.newaxis]) ** 2
    exponent, what = square @ factors, "two own samples of four, two columns"
    found = impl(x, factors, 2)
    if np.shape(found) == (4, 4):
        raise Finding(
            f"{what}: weights of all samples with all came back, (4, 4); rows only for the pixel's own are needed, (2, 4)."
        )
    if np.shape(found) == (4, 2):
        raise Finding(f"{what}: transposed: a row for each own sample i, a column for each sample j, (2, 4).")
    if np.shape(found) == (4,):
        raise Finding(f"{what}: one row came back: every own sample has weights of its own, (2, 4).")
    right = np.exp(-exponent)
    without = right * (1 - np.eye(2, 4))
    with np.errstate(all="ignore"):
        mistakes = {
            "the sign of the exponent is wrong: the weight must fall with the distance": np.exp(exponent),
            "the distance is not squared": np.exp(-np.abs(x[:2, np.newaxis] - x) @ factors),
            "halved once more: the factors hold the 1 / 2 already": np.exp(-exponent / 2),
            "divided by the factors: multiply": np.exp(-square @ (1 / factors)),
            "the factors are not used": np.exp(-square.sum(axis=-1)),
            "the factors are squared": np.exp(-square @ factors**2),
            "the mean over the columns: the sum is needed": np.exp(-exponent / 2),
            "the columns' weights are added: the sum stands in the exponent": np.exp(-square * factors).sum(axis=-1),
            "that is the exponent: the weight is exp(-...)": exponent,
            "sample i itself is left out: w_ii = 1": without,
            "rows are divided by their sum: the weights themselves are asked for": right / right.sum(1, keepdims=True),
            "every row has the weights from the first sample": np.exp(-exponent[[0, 0]]),
            "the distance is that from the mean of the own samples": np.exp(
                -np.repeat(((x - x[:2].mean(axis=0)) ** 2 @ factors)[np.newaxis], 2, axis=0)
            ),
            "the root of the sum is in the exponent: the square is needed": np.exp(-np.sqrt(exponent)),
            "the factors stand inside the square": np.exp(-((square * factors**2).sum(axis=-1))),
            "differences are summed before they are squared": np.exp(-(((x[:2, np.newaxis] - x) @ factors) ** 2)),
        }
        name_mistake(found, right, mistakes, what)
    assert_matches(found, right, what)


@graded("pair_weights", points=0.5)
def test_without_factors_all_count_the_same(impl):
    "alpha = beta = 0: every weight is 1, that is a box average; large factors leave only equal samples."
    rng = np.random.default_rng(2)
    x = np.round(rng.normal(size=(12, 5)), 1)
    assert_matches(impl(x, np.zeros(5), 3), np.ones((3, 12)), "factors all 0")
    x[7] = x[1]
    expected = np.zeros((3, 12))
    expected[[0, 1, 2, 1], [0, 1, 2, 7]] = 1.0
    assert_matches(impl(x, np.full(5, 1e6), 3), expected, "huge factors", atol=1e-12)


@graded("pair_weights", points=0.5)
def test_the_spatial_factor_multiplies(impl):
    "Where every sample of a box is taken, `space` is multiplied to the weights; None is 1."
    x, factors = np.array([[0.0], [1.0], [2.0]]), np.array([0.3])
    space, what = np.array([[1.0, 0.5, 0.25], [0.5, 1.0, 0.75]]), "with a spatial factor"
    plain = np.exp(-0.3 * np.array([[0.0, 1.0, 4.0], [1.0, 0.0, 1.0]]))
    assert_matches(impl(x, factors, 2, None), plain, "space None")
    mistakes = {
        "the spatial factor is not used": plain,
        "the spatial factor is added": plain + space,
        "the spatial factor stands in the exponent: it is a weight already": plain * np.exp(-space),
        "divided by the spatial factor": plain / space,
    }
    found = impl(x, factors, 2, space)
    name_mistake(found, plain * space, mistakes, what)
    assert_matches(found, plain * space, what)


@graded("pair_weights", points=1, hidden=True)
def test_any_weights(impl):
    "Any number of samples and columns, weights symmetric, and the blend of one pixel follows."
    rng = np.random.default_rng(5)
    for n, columns, spp in ((40, 12, 8), (5, 3, 5), (9, 1, 1)):
        x, factors, space = rng.normal(size=(n, columns)), rng.random(columns) / columns, rng.random((spp, n))
        expected = np.ones((spp, n))
        for i in range(spp):
            for j in range(n):
                expected[i, j] = np.exp(-sum(factors[k] * (x[i, k] - x[j, k]) ** 2 for k in range(columns)))
        weights = np.asarray(impl(x, factors, spp))
        assert_matches(weights, expected, f"{n} samples of {columns} columns")
        assert_matches(weights[:, :spp], weights[:, :spp].T, f"symmetric: w_ij = w_ji, {spp} own samples")
        assert_matches(impl(x, factors, spp, space), expected * space, f"{n} samples, with a spatial factor")
        colours = rng.random((n, 3))
        blended = weights @ colours / weights.sum(axis=1, keepdims=True)
        right = [sum(w * c for w, c in zip(row, colours, strict=True)) / sum(row) for row in expected]
        assert_matches(blended, np.array(right), f"blended colours of {spp} samples")


# --- predictions


def _words(answer, given):
    """The words of a prediction, in capitals."""
    words = [str(one).strip().upper() for one in answer] if isinstance(answer, (tuple, list)) else []
    assert [len(word) for word in words] == [len(word) for word in given], (
        f"{len(given)} words of {len(given[0])} letters are needed, as in {given}."
    )
    return words


@graded("corners", points=1.5)
def test_what_each_corner_does(impl):
    "For each corner and each toy: G, the noise goes and the edge stays; E, the edge is lost; N, the noise stays."
    given = ("GGG", "GGG", "GGG", "GGG")
    words = _words(impl, given)
    hints = {
        "A": ("GEE", "every weight is 1: what is left of noise, and of any edge, in a box average?"),
        "B": ("NNN", "the radiance itself is what is noisy: which samples are like a sample that is too bright?"),
        "C": ("NGE", "the paint alone chooses: where is it noise, where does it show the edge, where is it the same?"),
        "D": ("NNN", "a sample must be alike in paint and in radiance: that leaves fewer than either of them alone."),
    }
    for word, (corner, (right, hint)) in zip(words, hints.items(), strict=True):
        for place, (letter, expected) in enumerate(zip(word, right, strict=True)):
            assert letter == expected, f"corner {corner}, toy {place + 1} is not {letter}: {hint}"


@graded("without_a_cause", points=1)
def test_what_stays_noisy(impl):
    "For the lens and for the light left out, at each of three places: S, as smooth as with all; N, noisy again."
    given = ("SSS", "SSS")
    words = _words(impl, given)
    places = ("tile in focus", "end of a shadow", "ball near the lens")
    hints = {
        "lens": (
            "SSN",
            "what makes the noise there: lens or light? Where the lens does, and is not asked, W is small.",
        ),
        "light": (
            "NNS",
            "what makes the noise there: lens or light? Where the light does, and is not asked, W is small.",
        ),
    }
    for word, (cause, (right, hint)) in zip(words, hints.items(), strict=True):
        for letter, expected, place in zip(word, right, places, strict=True):
            assert letter == expected, f"without the {cause}, the {place} is not {letter}: {hint}"


# --- spikes_spread(blended, limit)


def _grey(*values):
    return np.repeat(np.array(values, float)[:, np.newaxis], 3, axis=1)


@graded("spikes_spread", points=1)
def test_a_spike_is_spread(impl):
    "A sample that is far in all channels becomes the mean, and what the pixel lost is given to all its samples."
    for values, expected, limit in (
        ((0, 1, 2, 9), (1.5, 2.5, 3.5, 4.5), 1.0),
        ((9, 8, 7, 0), (7.5, 6.5, 5.5, 4.5), 1.0),
        ((0, 1, 2, 9), (0, 1, 2, 9), 2.0),
        ((0, 1, 2, 9), (1.5, 2.5, 3.5, 4.5), 1.6),
    ):
        values, right, what = _grey(*values), _grey(*expected), f"samples {values}, limit {limit:g}"
        mean, found = values.mean(axis=0), impl(values, limit)
        bright = values[3, 0] == 9
        kept = np.where(np.arange(4)[:, np.newaxis] == 3, mean, values)
        mistakes = {
            "what was taken off is lost: the mean of the pixel is another now": kept,
            "a dark sample is a spike too: take the absolute value of the distance": values if not bright else np.inf,
            "nothing is changed: compare with the standard deviation, not with the variance": values,
            "the others get it all: every sample gets the same part, the former spike too": np.where(
                np.arange(4)[:, np.newaxis] == 3, mean, values + (values[3] - mean) / 3
            ),
            "the loss is given to every sample in full: it is shared, the mean moves by (mean before - mean after)": kept
            + (values[3] - mean),
            "all samples became the mean": np.repeat(mean[np.newaxis], 4, axis=0),
            "the limit is not used": _grey(1.5, 2.5, 3.5, 4.5) if limit == 2 else np.inf,
            "cut off at the limit: a spike becomes the mean": np.minimum(values, mean + limit * values.std(axis=0)),
            "multiplied by a factor to restore the mean: add the same to all samples": (
                kept * mean[0] / kept.mean() if limit != 2 else np.inf
            ),
        }
        if limit == 1.6:
            mistakes = {"divided by N - 1 in the standard deviation: divide by N": values}
        what = f"grey samples {values[:, 0].astype(int).tolist()}, limit {limit:g}"
        mistakes = {w: v for w, v in mistakes.items() if np.ndim(v) and not np.allclose(v, right)}
        name_mistake(found, right, mistakes, what)
        assert_matches(found, right, what)


@graded("spikes_spread", points=0.5)
def test_far_in_all_channels(impl):
    "A sample that is far in one channel alone is no spike: it may just have another colour."
    blended = np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 3.2], [1.0, 2.0, 2.8], [9.0, 2.0, 3.0]])
    found, what = impl(blended, 1.0), "one sample is redder than the others"
    far = np.abs(blended - blended.mean(axis=0)) > blended.std(axis=0)
    mean = blended.mean(axis=0)
    one, any_ = np.where(far, mean, blended), np.where(far.any(axis=1, keepdims=True), mean, blended)
    mistakes = {
        "channels are judged one by one, which changes the hue: far in all of them": one,
        "channels are judged one by one, which changes the hue: far in all of them (all, not any)": one
        + (mean - one.mean(axis=0)),
        "one channel was enough: far in all of them (all, not any)": any_ + (mean - any_.mean(axis=0)),
        "one channel was enough, and the loss was not given back": any_,
    }
    name_mistake(found, blended, mistakes, what)
    assert_matches(found, blended, what)


@graded("spikes_spread", points=0.5, hidden=True)
def test_the_mean_stays(impl):
    "Any number of samples, one too: the mean of the pixel stays, in each channel."
    rng = np.random.default_rng(7)
    for spp, limit in ((8, 1.0), (32, 0.5), (1, 1.0), (6, 1.5)):
        blended = rng.gamma(0.3, 1.0, (spp, 1)) * (0.5 + rng.random((spp, 3)))
        mean = blended.mean(axis=0)
        spread = np.sqrt(((blended - mean) ** 2).mean(axis=0))
        expected = blended.copy()
        for i in range(spp):
            if all(abs(blended[i, k] - mean[k]) > limit * spread[k] for k in range(3)):
                expected[i] = mean
        expected += mean - expected.mean(axis=0)
        found = impl(blended, limit)
        assert_matches(found, expected, f"{spp} samples, limit {limit}")
        assert_matches(np.mean(found, axis=0), mean, f"mean of {spp} samples, limit {limit}")


# --- hard_scene(x, y, u, v) -> radiance

SIDE, SPP, TRUE_SPP = 16, 8, 1024


def _draw(seed, spp):
    """Random numbers of a tiny image: screen position and lens."""
    rng = np.random.default_rng(seed)
    corner = np.stack(np.meshgrid(np.arange(SIDE), np.arange(SIDE)), axis=-1)[:, :, np.newaxis]
    return corner + 0.999 * rng.random((SIDE, SIDE, spp, 2)), 0.999 * rng.random((SIDE, SIDE, spp, 2))


def _render(impl, position, lens):
    """The student's scene at these samples, checked."""
    arguments = [
        np.ascontiguousarray(one.ravel()) for one in (*np.moveaxis(position, -1, 0), *np.moveaxis(lens, -1, 0))
    ]
    found = impl(*arguments)
    assert_matches(np.shape(found), np.array([arguments[0].size]), "shape of the radiance: one number a sample")
    radiance = np.asarray(found, float)
    assert np.isfinite(radiance).all(), "the radiance must be finite: there is NaN or infinity."
    assert radiance.min() >= 0, f"radiance is never negative, yours goes down to {radiance.min():.3g}."
    assert radiance.max() > 0, "all is black: let there be light."
    return radiance.reshape(position.shape[:3])


def _contest(impl, seed, **changes):
    """relMSE against the truth: of the noisy image, of a Gaussian, of RPF."""
    truth = _render(impl, *_draw(99, TRUE_SPP)).mean(axis=-1)
    position, lens = _draw(seed, SPP)
    radiance = np.repeat(_render(impl, position, lens)[..., np.newaxis], 3, axis=-1)
    samples = mcd.SampleBuffer.from_arrays(radiance, position, {"lens_u": lens[..., 0], "lens_v": lens[..., 1]})
    noisy = mcd.pixel_mean(samples.radiance)
    dials = {"boxes": (7,), "deterministic": True, "sigma_8_squared": 0.3} | changes
    images = (
        noisy,
        mcd.gaussian(noisy, sigma_space=1.0, engine="numpy"),
        mcd.rpf(samples, mcd.RPFConfig.lecture(**dials), progress=False),
    )
    truth = np.repeat(truth[..., np.newaxis], 3, axis=-1)
    return [float(mcd.relmse(image, truth)) for image in images]


def _assert_hard(errors, times):
    noisy, gaussian, ours = errors
    assert noisy >= 1e-3, (
        f"the noisy image has a relMSE of {noisy:.2g}: there is hardly any noise, at least 0.001 is asked for. Let the "
        f"radiance depend on the lens."
    )
    assert ours >= times * min(noisy, gaussian), (
        f"relMSE of RPF {ours:.3g}, of the noisy image {noisy:.3g}, of a Gaussian {gaussian:.3g}: RPF is to have {times} times "
        f"the smaller of the two. It is led by pairs and by standard deviations: which pattern do they miss?"
    )


@graded("hard_scene", points=1)
def test_rpf_fails(impl):
    "RPF has at least three times the relMSE of the better of the noisy image and a Gaussian."
    _assert_hard(_contest(impl, seed=0), 3)


@graded("hard_scene", points=1, hidden=True)
def test_rpf_fails_again(impl):
    "It stays so, twice at least, with other random numbers and a narrower bandwidth; and a sample is what its numbers say."
    position, lens = _draw(5, 2)
    one, again = _render(impl, position, lens), _render(impl, position[::-1], lens[::-1])[::-1]
    assert np.array_equal(one, again), (
        "the same sample at another place of the arrays has another radiance: it may depend on its own x, y, u, v alone."
    )
    _assert_hard(_contest(impl, seed=1), 2)
    _assert_hard(_contest(impl, seed=2, sigma_8_squared=0.2), 2)
