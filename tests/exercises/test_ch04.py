"""The exercises of chapter 04, features and patches: what holds for a right answer."""

import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import assert_matches, graded, picture

INFINITY = float("inf")


def _noise(*shape, seed=11):
    return np.random.default_rng(seed).random(shape)


def _letters(answer, number, example):
    """The letters of a prediction, in capitals."""
    letters = [str(one).strip().upper() for one in answer] if isinstance(answer, (tuple, list, str)) else []
    assert len(letters) == number, f"{number} letters are needed, as in {example}."
    return letters


# --- predictions


@graded("breaking_scenes", points=1)
def test_which_scenes_break_the_feature_filter(impl):
    "For each of the five scenes: what do its first-hit features know?"
    given = ("A", "A", "A", "A", "A")
    letters = _letters(impl, 5, given)
    scenes = (
        ("pinhole", "A", "every ray of a pixel starts at one point: what could make its features noisy?"),
        ("dof", "B", "the rays of a pixel start all over the lens: do they hit the same point of a ball out of focus?"),
        ("motion", "B", "each ray sees another instant: what does a pixel on the ball's path hit?"),
        ("glossy", "C", "the first hit is black metal with a smooth normal: where are the stripes that it shows?"),
        ("soft_shadow", "D", "the floor has one colour and one normal, in the shadow and outside of it."),
    )
    for letter, (scene, right, hint) in zip(letters, scenes, strict=True):
        assert letter == right, f"{scene} is not {letter}: {hint}"


@graded("expected_difference", points=1)
def test_two_views_of_one_truth_differ(impl):
    "The mean of the squared difference of two independent pixels with one mean, to two digits."
    value, expected = float(impl), 0.03 + 0.05
    for wrong, words in (
        (0.0, "the mean of u_p - u_q is 0, but squares are never negative: they do not cancel"),
        (0.02, "noise does not subtract: Var(u_p - u_q) has a plus between the two variances"),
        (0.04, "that is the mean of the two variances: both noises are in the difference, in full"),
        (0.0034, "that is the sum of their squares: a variance is a square already"),
        (0.0015, "that is their product: write out Var(u_p - u_q) for independent pixels"),
        (0.16, "twice too much: each of the two noises is in the difference once"),
        (np.sqrt(0.08), "that is the root, a standard deviation: the square of the difference is asked for"),
        (np.sqrt(0.03) + np.sqrt(0.05), "standard deviations do not add up, variances do"),
        ((np.sqrt(0.03) + np.sqrt(0.05)) ** 2, "standard deviations do not add up, their squares do"),
    ):
        assert abs(value - wrong) > 0.01 * wrong + 1e-4, f"{value:.3g}: {words}."
    assert abs(value - expected) <= 0.001, (
        f"{value:.3g} is not it: expand (u_p - u_q)^2 around the common mean; the mixed term vanishes on average."
    )


def _limits():
    """What the filters of the five questions give on noise, and the four answers to choose from."""
    image, feature = _noise(10, 12), {"f": _noise(10, 12, seed=3)}
    kind = {"engine": "numpy"}
    window = {"search_radius": 3, "patch_radius": 1} | kind
    tiny = 1e-9
    found = (
        mcd.nlm(image, 0.01, k=INFINITY, **window),
        mcd.nlm(image, tiny, k=0.6, **window),
        mcd.nlm(image, 1e6, k=0.6, **window),
        mcd.nlm(image, tiny, k=0.2 / np.sqrt(tiny), search_radius=3, patch_radius=0, **kind),
        mcd.joint_nlm(image, 0.01, feature, sigma_features={"f": 0.2}, k=INFINITY, **window),
    )
    flat = {"sigma_space": INFINITY, "radius": 3} | kind
    answers = {
        "A": image,
        "B": mcd.gaussian(image, **flat),
        "C": mcd.bilateral(image, sigma_radiance=0.2, **flat),
        "D": mcd.cross_bilateral(image, feature, sigma_radiance=INFINITY, sigma_features={"f": 0.2}, **flat),
    }
    return found, answers


@graded("nlm_limits", points=1)
def test_limits_of_the_patch_filters(impl):
    "What NL-means and its joint form turn into at the ends of their dials: tried on noise."
    given = ("D", "D", "D", "D", "D")
    letters = _letters(impl, 5, given)
    found, answers = _limits()
    hints = (
        "k stands below the line: what is left of d^2, and so of the weight, when k is infinite?",
        "with next to no noise every difference counts, and no two patches are equal: who keeps a weight?",
        "noise as large as that explains every difference: what does max(0, d^2) become, and the weight?",
        "the patch is one pixel, and what is taken off vanishes: write d^2 with 2 k^2 variance below the line.",
        "with k infinite the patches have no say: which factors of the weight are left?",
    )
    for place, (filtered, hint) in enumerate(zip(found, hints, strict=True)):
        right = min(answers, key=lambda letter: float(np.abs(answers[letter] - filtered).max()))
        assert letters[place] == right, f"question {place + 1} is not {letters[place]}: {hint}"


# --- feature_weights(features, variances, sigmas, y, x, sigma_space, radius)


def _bell_window(sigma_space, radius):
    """exp(-(dy^2 + dx^2) / (2 sigma_space^2)) of a whole window."""
    reach = np.arange(-radius, radius + 1)
    line = np.exp(-(reach**2) / (2 * sigma_space**2))
    return np.outer(line, line)


def _silent(features):
    """Variances of features that are free of noise."""
    return {name: np.zeros(feature.shape) for name, feature in features.items()}


def _name_exponent(weight, expected, mistakes, what):
    """Name the usual mistakes in one weight by their exponents."""
    for words, exponent in mistakes.items():
        assert not np.isclose(weight, np.exp(-exponent), rtol=1e-4), (
            f"{what}: yours is {float(weight):.4f}, expected {expected:.4f}: {words}."
        )


@graded("feature_weights", points=0.5)
def test_where_features_are_flat_only_nearness_counts(impl):
    "Where no feature changes the weights are the spatial bell, and the pixel's weight with itself is 1."
    features = {"albedo": np.full((9, 9, 3), 0.7), "normal": np.full((9, 9, 3), -0.4)}
    noise = {"albedo": np.full((9, 9, 3), 0.01), "normal": np.zeros((9, 9, 3))}
    weight = impl(features, noise, {"albedo": 0.1, "normal": 0.2}, 4, 4, 1.5, 3)
    assert not np.array_equal(weight, np.ones((7, 7))), "every weight is 1: the spatial kernel is missing."
    assert_matches(weight, _bell_window(1.5, 3), "weights where all features are flat (sigma_space 1.5, radius 3)")


@graded("feature_weights", points=1)
def test_likeness_of_features_free_of_noise(impl):
    "A feature free of noise counts by its Euclidean distance; of two features the bells are multiplied."
    features = {"albedo": np.full((5, 5, 3), 0.1), "depth": np.full((5, 5, 1), 2.0)}
    features["albedo"][2, 3] += (0.3, 0.6, 0.6)  # distance 0.9
    features["depth"][3, 2] = 2.5
    features["albedo"][3, 3], features["depth"][3, 3] = (0.4, 0.7, 0.7), 2.5
    weight = impl(features, _silent(features), {"albedo": 0.6, "depth": 0.4}, 2, 2, INFINITY, 1)
    one, two = np.exp(-(0.9**2) / (2 * 0.6**2)), np.exp(-(0.5**2) / (2 * 0.4**2))
    expected = np.array([[1, 1, 1], [1, 1, one], [1, two, one * two]])
    if np.shape(weight) == (3, 3):
        assert not (np.isclose(weight[2][1], one) and np.isclose(weight[1][2], two)), (
            "transposed: the weight of [1, 2] (y, x) stands at [2, 1]."
        )
        _explain_likeness(weight[1][2], weight[2][1])
        _explain_product(weight[2][2], one, two)
    assert_matches(weight, expected, "weights around a pixel with other features to its right and below")


def _explain_likeness(of_albedo, of_depth):
    """Name the usual mistakes for a distance of (0.3, 0.6, 0.6) with sigma = 0.6; 0.3247 is right."""
    assert not (np.isclose(of_albedo, 1) and np.isclose(of_depth, 1)), (
        "another albedo, or another depth, gets the weight 1: the features have no say."
    )
    assert not np.isclose(of_albedo, 1), "another albedo gets the weight 1: only the last feature has a say."
    assert not np.isclose(of_depth, 1), "another depth gets the weight 1: only the first feature has a say."
    what = "an albedo at distance 0.9 with sigma 0.6 and no noise"
    mistakes = {
        "the factor 1/2 in the exponent is missing": 0.9**2 / 0.6**2,
        "sigma is to be squared in sigma^2 + var_p + var_q": 0.9**2 / (2 * 0.6),
        "the difference is to be squared": 1.5 / (2 * 0.6**2),
        "the distance d is to be squared": 0.9 / (2 * 0.6**2),
        "the squares are summed over the channels, not the differences": 1.5**2 / 0.72,
        "the squares are summed over the channels, not averaged": 0.9**2 / 3 / 0.72,
        "all channels count, not only the first": 0.3**2 / 0.72,
    }
    _name_exponent(of_albedo, 0.3247, mistakes, what)


def _explain_product(weight, one, two):
    """Name other ways to join two bells."""
    for words, joined in (
        ("the bells are multiplied, not added", one + two),
        ("the bells are multiplied, not averaged", (one + two) / 2),
        ("the bells are multiplied; yours is the smaller of the two", min(one, two)),
        ("the bells are multiplied; yours is the larger of the two", max(one, two)),
    ):
        assert not np.isclose(weight, joined, rtol=1e-4), f"two features differ, weight {float(weight):.4f}: {words}."


@graded("feature_weights", points=1)
def test_noise_widens_the_bell_channel_by_channel(impl):
    "Each squared difference is divided by sigma^2 + var_p + var_q of its own channel: noise excuses a difference."
    features = {"albedo": np.zeros((3, 3, 2))}
    features["albedo"][1, 2] = 0.6, 0.8
    noise = {"albedo": np.full((3, 3, 2), 0.1)}
    noise["albedo"][1, 1], noise["albedo"][1, 2] = (0.04, 0.36), (0.2, 0.0)
    weight = impl(features, noise, {"albedo": 0.5}, 1, 1, INFINITY, 1)
    right = (0.36 / (0.25 + 0.24) + 0.64 / (0.25 + 0.36)) / 2
    expected = np.ones((3, 3))
    expected[1, 2] = np.exp(-right)
    if np.shape(weight) == (3, 3):
        mistakes = {
            "the variances have no say: noise is to excuse a difference": (0.36 + 0.64) / 0.25 / 2,
            "only var_p, that of the middle pixel, counts: q is noisy too": (0.36 / 0.29 + 0.64 / 0.61) / 2,
            "only var_q, that of the neighbour, counts: p is noisy too": (0.36 / 0.45 + 0.64 / 0.25) / 2,
            "the mean of the two variances is too little, the sum is needed": (0.36 / 0.37 + 0.64 / 0.43) / 2,
            "a variance is a square already: do not square it": (
                0.36 / (0.25 + 0.04**2 + 0.2**2) + 0.64 / (0.25 + 0.36**2)
            )
            / 2,
            "variances are added to sigma^2, not standard deviations": (
                0.36 / (0.25 + 0.2 + np.sqrt(0.2)) + 0.64 / (0.25 + 0.6)
            )
            / 2,
            "sigma is to be squared in sigma^2 + var_p + var_q": (0.36 / 0.74 + 0.64 / 0.86) / 2,
            "each channel's square is divided by its own variances; yours are averaged first": 1 / (0.25 + 0.3) / 2,
            "each channel's square is divided by its own variances; yours are summed first": 1 / (0.25 + 0.6) / 2,
            "the factor 1/2 in the exponent is missing": 2 * right,
            "with noise too the quotients are summed over the channels, not averaged": right / 2,
        }
        _name_exponent(weight[1][2], np.exp(-right), mistakes, "a neighbour whose albedo is noisy")
    assert_matches(weight, expected, "weights around a pixel with noisy features")


@graded("feature_weights", points=0.5)
def test_outside_the_image_there_is_no_weight(impl):
    "Where the window leaves the image the weight is 0, and the window keeps its size."
    features = {"depth": np.full((4, 6, 1), 2.0)}
    expected = np.zeros((5, 5))
    expected[2:, :3] = _bell_window(1.0, 2)[2:, :3]
    weight = impl(features, _silent(features), {"depth": 0.1}, 0, 5, 1.0, 2)
    if np.shape(weight) == (5, 5):
        inside = expected > 0
        right_inside = np.allclose(np.asarray(weight)[inside], expected[inside])
        assert not (right_inside and np.any(np.asarray(weight)[~inside] > 0)), (
            "pixels outside the image have a weight: a negative index takes pixels from the other side (wrap-around)."
        )
    assert_matches(weight, expected, "weights at the top right corner, y = 0 and x = 5")


@graded("feature_weights", points=1, hidden=True)
def test_feature_weights_of_noise_give_the_filter(impl):
    "With these weights the weighted mean is the cross-bilateral filter, anywhere in a noisy image."
    image = _noise(7, 10, 3)
    features = {"a": _noise(7, 10, 3, seed=1), "b": _noise(7, 10, 1, seed=2), "c": _noise(7, 10, 2, seed=3)}
    noise = {name: 0.1 * _noise(*feature.shape, seed=5) for name, feature in features.items()}
    sigmas = {"c": INFINITY, "b": 0.2, "a": 0.4}
    filtered = mcd.cross_bilateral(
        image,
        features,
        sigma_space=1.7,
        sigma_radiance=INFINITY,
        sigma_features=sigmas,
        variances=noise,
        radius=2,
        engine="numpy",
    )
    padded = np.pad(image, ((2, 2), (2, 2), (0, 0)))
    for y, x in ((0, 0), (3, 5), (6, 2), (2, 9)):
        weight = np.asarray(impl(features, noise, sigmas, y, x, 1.7, 2), float)
        mean = (weight[..., np.newaxis] * padded[y : y + 5, x : x + 5]).sum(axis=(0, 1)) / weight.sum()
        assert_matches(mean, filtered[y, x], f"weighted mean at y = {y}, x = {x}")


@graded("feature_weights", points=0.5, hidden=True)
def test_a_silenced_feature_has_no_say(impl):
    "An infinite sigma switches a feature off, a huge variance nearly does; without features there is the bell alone."
    features = {"albedo": _noise(5, 5, 3)}
    bell = _bell_window(2.0, 2)
    assert_matches(
        impl(features, _silent(features), {"albedo": INFINITY}, 2, 2, 2.0, 2), bell, "weights, sigma infinite"
    )
    noise = {"albedo": np.full((5, 5, 3), 1e12)}
    assert_matches(impl(features, noise, {"albedo": 0.01}, 2, 2, 2.0, 2), bell, "weights, variance 1e12")
    features["albedo"] = features["albedo"].astype(np.float32)
    expected = np.zeros((5, 5))
    expected[2, 2] = 1.0
    assert_matches(impl(features, _silent(features), {"albedo": 1e-6}, 2, 2, 2.0, 2), expected, "weights, sigma 1e-6")


# --- patch_distance(image, variance, p, q, patch_radius, k)


def _name_distance(found, expected, mistakes, what):
    """Name the usual mistakes in a patch distance."""
    if np.shape(found) != () or np.asarray(found).dtype.kind not in "if":
        return
    assert not float(found) < 0, f"{what}: yours is {float(found):.4g}, below 0: is max(0, ...) missing?"
    for words, value in mistakes.items():
        assert not np.isclose(float(found), value, rtol=1e-4) or np.isclose(value, expected, rtol=1e-4), (
            f"{what}: yours is {float(found):.4g}, expected {expected:.4g}: {words}."
        )


@graded("patch_distance", points=1)
def test_the_distance_of_two_pixels(impl):
    "With a patch of one pixel: what noise explains is taken off, the rest is counted in units of k^2 times the noise."
    image, variance = np.array([[[0.2], [1.2]]]), np.array([[0.12, 0.34]])
    for p, q, own, other in (((0, 1), (0, 0), 0.34, 0.12), ((0, 0), (0, 1), 0.12, 0.34)):
        below = 0.5**2 * 0.46
        least = min(own, other)
        expected = (1.0 - (own + least)) / below
        mistakes = {
            "the noise is not taken off: subtract var_p + min(var_p, var_q)": 1.0 / below,
            "taken off is var_p + var_q; it must be var_p + min(var_p, var_q)": (1 - 0.46) / below,
            "taken off is var_p alone; min(var_p, var_q) is missing": (1 - own) / below,
            "taken off is min(var_p, var_q) alone; var_p is missing": (1 - least) / below,
            "taken off is var_q + min(var_p, var_q): are p and q exchanged?": (1 - other - least) / below,
            "taken off is var_p + max(var_p, var_q), or 2 var_p: the smaller one is meant": (1 - own - max(own, other))
            / below,
            "k is to be squared": (1 - own - least) / (0.5 * 0.46),
            "k is missing below the line": (1 - own - least) / 0.46,
            "k^2 belongs below the line": (1 - own - least) * 0.5**2 / 0.46,
            "the line ends too late: a / (k**2 * b) needs its brackets": (1 - own - least) / 0.5**2 * 0.46,
            "nothing is divided by the noise: var_p + var_q is missing below the line": (1 - own - least) / 0.5**2,
            "below the line stands var_p alone; both pixels are noisy": (1 - own - least) / (0.5**2 * own),
            "below the line stands var_q alone; both pixels are noisy": (1 - own - least) / (0.5**2 * other),
            "the noise is subtracted after the division": 1 / below - (own + least),
            "that is the weight: the distance itself is asked for": np.exp(-expected),
            "that is its root: d^2 is asked for": np.sqrt(expected),
        }
        what = f"distance of two pixels that differ by 1, var_p = {own}, var_q = {other}, k = 0.5"
        found = impl(image, variance, p, q, 0, 0.5)
        _name_distance(found, expected, mistakes, what)
        assert_matches(found, expected, what)


@graded("patch_distance", points=1)
def test_means_over_patch_and_channels(impl):
    "The squared difference is the mean over the channels; d^2 is the mean over the pixels of the patch."
    image, variance = np.zeros((5, 9, 3)), np.full((5, 9), 0.25)
    image[1, 5] = 3.0, 6.0, 6.0  # the patch of q = (2, 6) holds it at its top left
    expected = ((9 + 36 + 36) / 3 - 0.5 + 8 * (-0.5)) / 9 / 0.5
    mistakes = {
        "the squares are averaged over the channels, not summed": (81 - 9 * 0.5) / 9 / 0.5,
        "sum over the patch: the mean of its pixels is needed": 9 * expected,
        "max(0, ...) is taken pixel by pixel: take it once, of the mean over the patch": (27 - 0.5) / 9 / 0.5,
        "all channels count, not only the first": (9 - 9 * 0.5) / 9 / 0.5,
        "the noise is taken off once for each channel; the mean over the channels comes first": (
            (81 - 3 * 9 * 0.5) / 9 / 0.5
        ),
        "the patch is one column or row too small": (27 - 4 * 0.5) / 4 / 0.5,
        "the patch is one column or row too large": (27 - 16 * 0.5) / 16 / 0.5,
        "squares are summed over the patch, but the noise is taken off once": (27 - 0.5) / 0.5,
        "the noise is not taken off": 27 / 9 / 0.5,
    }
    found = impl(image, variance, (2, 2), (2, 6), 1, 1.0)
    assert not (np.ndim(found) == 0 and found == 0), (
        "distance of two patches that differ in one corner: yours is 0, expected 5. Is only the pixel in the middle of "
        "each patch compared?"
    )
    _name_distance(found, expected, mistakes, "distance of two patches that differ in one pixel")
    assert_matches(found, expected, "distance of two patches that differ in one pixel")


@graded("patch_distance", points=0.5)
def test_what_noise_explains_is_no_distance(impl):
    "Patches that differ by no more than their noise have the distance 0, and so have equal ones."
    image, variance = np.zeros((3, 7, 1)), np.full((3, 7), 0.2)
    image[:, 4:] = 0.5  # squared 0.25, the noise explains 0.4
    for q in ((1, 5), (1, 1)):
        found = impl(image, variance, (1, 1), q, 1, 0.6)
        _name_distance(
            found, 0.0, {"the noise is not taken off: subtract var_p + min(var_p, var_q)": 0.25 / 0.144}, "d^2"
        )
        assert_matches(found, 0.0, "distance of two patches that differ by less than their noise", atol=1e-12)


@graded("patch_distance", points=0.5)
def test_patches_are_clipped_at_the_borders(impl):
    "A place of the patch that lies outside the image, for p or for q, is left out of the mean."
    image, variance = np.zeros((4, 6, 1)), np.full((4, 6), 0.5)
    image[:, 4:] = 3.0
    places = 4  # of nine: at p = (0, 0) only those below and right; at q = (0, 4) their partners
    image[1, 5] = 6.0
    expected = ((3 * 9 + 36) / places - 1) / (0.6**2 * 1.0)
    found = impl(image, variance, (0, 0), (0, 4), 1, 0.6)
    mistakes = {
        "the sum is divided by 9, but only 4 places of the patch lie inside the image": (63 - 4) / 9 / 0.36,
        "places outside the image count as if they were equal": (63 - 9) / 9 / 0.36,
        "a negative index takes pixels from the other side (wrap-around)": (135 - 9) / 9 / 0.36,
    }
    _name_distance(found, expected, mistakes, "distance at the border, p = (0, 0) and q = (0, 4)")
    assert_matches(found, expected, "distance at the border, p = (0, 0) and q = (0, 4)")
    image, expected = image[:, ::-1].copy(), (9 - 1) / 0.36  # now q stands in the corner: one pixel of 6 is left out
    image[1, 0] = 3.0
    image[:, 5] = 7.0  # what a negative index would find
    found = impl(image, variance, (1, 3), (1, 0), 1, 0.6)
    mistakes = {
        "a negative index takes pixels from the other side (wrap-around): look at q too": (6 * 9 + 3 * 49 - 9)
        / 9
        / 0.36,
        "the sum is divided by 9, but only 6 places of the patch lie inside the image": 6 * 8 / 9 / 0.36,
    }
    _name_distance(found, expected, mistakes, "distance at the border, p = (1, 3) and q = (1, 0)")
    assert_matches(found, expected, "distance at the border, p = (1, 3) and q = (1, 0)")


def _slow_distance(image, variance, p, q, patch_radius, k):
    """d^2 of two pixels by whole arrays: every pixel beside its partner, then the places of the patch."""
    height, width = variance.shape
    rows, columns = np.indices(variance.shape)
    there = rows + q[0] - p[0], columns + q[1] - p[1]
    inside = (there[0] >= 0) & (there[0] < height) & (there[1] >= 0) & (there[1] < width)
    inside &= (abs(rows - p[0]) <= patch_radius) & (abs(columns - p[1]) <= patch_radius)
    mine, other = np.nonzero(inside), (there[0][inside], there[1][inside])
    square = ((image[mine].astype(float) - image[other]) ** 2).mean(axis=-1)
    own, its = variance[mine], variance[other]
    return max(0.0, ((square - own - np.minimum(own, its)) / (k**2 * (own + its))).mean())


@graded("patch_distance", points=1, hidden=True)
def test_any_patch_anywhere(impl):
    "Any two pixels of a noisy image, any patch, any k; also a patch larger than the image."
    image, variance = _noise(8, 9, 3), 0.01 + 0.05 * _noise(8, 9, seed=4)
    for p, q, radius, k in (
        ((3, 4), (5, 2), 1, 0.6),
        ((0, 8), (7, 0), 2, 0.45),
        ((7, 3), (6, 8), 3, 1.0),
        ((2, 2), (4, 7), 20, 0.3),
    ):
        expected = _slow_distance(image, variance, p, q, radius, k)
        assert_matches(impl(image, variance, p, q, radius, k), expected, f"distance of {p} and {q}, radius {radius}")


@graded("patch_distance", points=0.5, hidden=True)
def test_distances_give_nl_means(impl):
    "exp(-d^2) as weights, and the weighted mean is NL-means."
    image, variance = _noise(5, 6, 3), 0.02 + 0.05 * _noise(5, 6, seed=9)
    filtered = mcd.nlm(image, variance, search_radius=1, patch_radius=1, k=0.7, engine="numpy")
    for y, x in ((2, 3), (0, 0), (4, 5)):
        total, norm = np.zeros(3), 0.0
        for j in range(max(0, y - 1), min(5, y + 2)):
            for i in range(max(0, x - 1), min(6, x + 2)):
                weight = np.exp(-float(impl(image, variance, (y, x), (j, i), 1, 0.7)))
                total, norm = total + weight * image[j, i], norm + weight
        assert_matches(total / norm, filtered[y, x], f"weighted mean at y = {y}, x = {x}")


# --- demodulate(image, albedo) -> irradiance, factor


@graded("demodulate", points=0.5)
def test_texture_leaves(impl):
    "A surface of many colours under even light has one irradiance."
    albedo = 0.1 + 0.8 * _noise(6, 7, 3)
    irradiance, factor = impl(2.5 * albedo, albedo)
    if np.shape(irradiance) == np.shape(factor) == albedo.shape:
        assert not np.allclose(irradiance, 2.5 * albedo**2), (
            "multiplied by the albedo: divide, so that the texture goes."
        )
        assert not np.allclose(irradiance, 2.5 * albedo), (
            "the texture is still in the irradiance: divide by the albedo."
        )
        assert not (np.allclose(factor, 2.5) and np.allclose(irradiance, albedo)), (
            "irradiance and factor are exchanged."
        )
        means = albedo.mean(axis=-1, keepdims=True)
        assert not np.allclose(irradiance * means, 2.5 * albedo), (
            "divided by the mean over the channels: each channel has its own albedo."
        )
    assert_matches(irradiance, np.full(albedo.shape, 2.5), "irradiance of a texture under even light")
    assert_matches(factor, albedo, "factor where the albedo is large")


@graded("demodulate", points=1)
def test_black_is_divided_by_a_tenth(impl):
    "Where the albedo of a channel is below 0.1 the factor is 0.1: no NaN, nothing blown up more than ten times."
    image = np.array([[[0.8, 0.6, 0.4], [5.0, 5.0, 5.0], [0.3, 0.0, 0.02], [0.02, 0.5, 0.5]]])
    albedo = np.array([[[0.4, 0.2, 0.5], [0.0, 0.0, 0.0], [0.6, 0.0, 0.005], [0.1, 0.5, 1.0]]])
    expected = np.array([[[2.0, 3.0, 0.8], [50.0, 50.0, 50.0], [0.5, 0.0, 0.2], [0.2, 1.0, 0.5]]])
    irradiance, factor = impl(image, albedo)
    for name, values in (("irradiance", irradiance), ("factor", factor)):
        if np.shape(values) == image.shape:
            values = np.asarray(values, float)
            bad = ~np.isfinite(values)
            assert not bad.any(), (
                f"{name} is {'NaN (0/0)' if np.isnan(values).any() else 'infinite (division by 0)'} where the albedo is 0: "
                f"there the factor is 0.1."
            )
    if np.shape(factor) == np.shape(irradiance) == image.shape:
        factor = np.asarray(factor, float)
        assert not np.allclose(factor, np.maximum(albedo, 0.01)), (
            "factor is 0.01 where the albedo is black: the radiance there is blown up a hundred times. It must be 0.1."
        )
        assert not np.allclose(factor, np.where(albedo < 0.1, 1, albedo)), (
            "factor jumps from 0.1 to 1 where the albedo becomes dark: neighbours on both sides are in other units. It must be "
            "0.1 there."
        )
        shift = factor - albedo
        assert not (np.ptp(shift) < 1e-9 and shift.max() > 1e-9), (
            f"factor is the albedo plus {shift.max():.3g} everywhere: the texture stays in part."
        )
        assert not np.allclose(factor, albedo), (
            "factor is 0 where the albedo is black: image = irradiance * factor is lost."
        )
        dark = np.where(
            albedo.min(axis=-1, keepdims=True) < 0.1, np.maximum(albedo.max(axis=-1, keepdims=True), 0.1), albedo
        )
        assert not np.allclose(factor, dark), "one dark channel changes all three: decide channel by channel."
    assert_matches(irradiance, expected, "irradiance of an image with black parts")
    assert_matches(factor, np.maximum(albedo, 0.1), "factor with black parts")


@graded("demodulate", points=1, hidden=True)
def test_the_image_comes_back(impl):
    "irradiance * factor is the image everywhere, for images of any size, float32 or float64."
    for kind in (np.float64, np.float32):
        image, albedo = (10 * _noise(9, 5, 3)).astype(kind), _noise(9, 5, 3, seed=8).astype(kind)
        albedo[albedo < 0.3] = 0
        irradiance, factor = impl(image, albedo)
        for name, values in (("irradiance", irradiance), ("factor", factor)):
            assert_matches(np.isfinite(np.asarray(values, float)), np.ones(image.shape, bool), f"{name}: is it finite")
        assert_matches(np.multiply(irradiance, factor), image, "irradiance * factor", rtol=1e-5)
        assert_matches(factor, np.maximum(albedo, 0.1), "factor of noise", rtol=1e-5)


@picture("demodulate")
def picture_demodulated(impl):
    """Checks under light that falls off, one check black: the light alone, by your function and as it was made."""
    y, x = np.indices((32, 32))
    checks = ((y // 8 + x // 8) % 2)[..., np.newaxis]
    albedo = np.where(checks, (0.7, 0.3, 0.2), (0.2, 0.3, 0.6))
    albedo[8:16, 8:16] = 0
    light = np.repeat(np.exp(-((y - 10) ** 2 + (x - 12) ** 2) / 300.0)[..., np.newaxis], 3, axis=-1)
    irradiance, _ = impl(albedo * light, albedo)
    return np.asarray(irradiance, float), np.where(albedo == 0, 0, light)


# --- misleading() -> noisy, feature, truth


def _misleading(impl):
    noisy, feature, truth = (np.asarray(one, float) for one in impl())
    assert noisy.ndim == 2, f"noisy, feature and truth must be images (h, w), got {noisy.shape} for noisy."
    assert noisy.shape == feature.shape == truth.shape, (
        f"noisy, feature and truth must have one size, got {noisy.shape}, {feature.shape} and {truth.shape}."
    )
    assert all(16 <= side <= 64 for side in noisy.shape), f"16 to 64 pixels a side are asked for, got {noisy.shape}."
    assert np.isfinite(noisy + feature + truth).all(), (
        "noisy, feature and truth must be finite: there is NaN or infinity."
    )
    return noisy, feature, truth


def _blind_and_led(noisy, feature, truth, sigma_space, sigma_feature):
    """Mean squared errors: the better of the two filters without the feature, and the filter that it leads."""
    blind = (
        mcd.gaussian(noisy, sigma_space=sigma_space, engine="numpy"),
        mcd.bilateral(noisy, sigma_space=sigma_space, sigma_radiance=0.2, engine="numpy"),
    )
    led = mcd.cross_bilateral(
        noisy,
        {"feature": feature},
        sigma_space=sigma_space,
        sigma_radiance=INFINITY,
        sigma_features={"feature": sigma_feature},
        engine="numpy",
    )
    return min(float(((one - truth) ** 2).mean()) for one in blind), float(((led - truth) ** 2).mean())


@graded("misleading", points=0.5)
def test_the_feature_is_fair(impl):
    "The noise is like Monte Carlo noise, its mean is zero, and the feature lies in [0, 1] like an albedo."
    noisy, feature, truth = _misleading(impl)
    noise = noisy - truth
    assert noise.std() > 0.02, f"the noise has a standard deviation of {noise.std():.3g}; at least 0.02 is asked for."
    assert abs(noise.mean()) <= 0.1 * noise.std(), (
        f"the noise has the mean {noise.mean():.3g}, more than a tenth of its standard deviation {noise.std():.3g}: the "
        f"truth is to be the mean of the noisy pixels."
    )
    assert ((feature >= 0) & (feature <= 1)).all(), (
        f"the feature must lie in [0, 1], yours goes from {feature.min():.3g} to {feature.max():.3g}."
    )


@graded("misleading", points=1)
def test_the_feature_misleads(impl):
    "Led by the feature the filter has at least five times the mean squared error of the better one without it."
    blind, led = _blind_and_led(*_misleading(impl), 3.0, 0.02)
    assert led >= 5 * blind, (
        f"mean squared error: led by the feature {led:.3g}, the better of Gaussian and bilateral {blind:.3g}; the first is "
        f"to be at least five times the second. Which feature leaves a pixel alone, or joins what does not belong together?"
    )


@graded("misleading", points=0.5, hidden=True)
def test_the_feature_misleads_at_other_dials(impl):
    "It stays so, at least three times, with sigma_space 2.5 and 4, sigma_feature 0.01 and 0.03; the same at every call."
    made, again = _misleading(impl), _misleading(impl)
    assert all(map(np.array_equal, made, again)), (
        "two calls gave different images: use a fixed seed, np.random.default_rng(0)."
    )
    for sigma_space, sigma_feature in ((2.5, 0.03), (4.0, 0.01)):
        blind, led = _blind_and_led(*made, sigma_space, sigma_feature)
        assert led >= 3 * blind, (
            f"with sigma_space = {sigma_space}, sigma_feature = {sigma_feature}: led {led:.3g}, without it {blind:.3g}."
        )
