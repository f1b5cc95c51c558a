"""The exercises of chapter 03, the bilateral filter: what holds for a right answer."""

import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import assert_matches, graded, picture

INFINITY = float("inf")


def _noise(*shape, seed=7):
    return np.random.default_rng(seed).random(shape)


def _bell_window(sigma_space, radius):
    """exp(-(dy^2 + dx^2) / (2 sigma_space^2)) of a whole window."""
    reach = np.arange(-radius, radius + 1)
    line = np.exp(-(reach**2) / (2 * sigma_space**2))
    return np.outer(line, line)


def _nearness(height, width, sigma_space, radius):
    """Sum of the spatial weights over the window's pixels inside the image, for every pixel."""
    sums = []
    for size in (height, width):
        distance = np.arange(size)[:, np.newaxis] - np.arange(size)
        near = np.exp(-(distance**2) / (2 * sigma_space**2))
        sums.append(np.where(np.abs(distance) <= radius, near, 0.0).sum(axis=1))
    return np.outer(*sums)


def _check_impulse(total, expected, y, x, radius):
    """Name what is wrong with the sum around one bright pixel at (y, x), if it is finite and has the right shape."""
    divided = np.allclose(total, expected / _nearness(*total.shape, 1.3, radius))
    assert not divided, "total is divided by norm already: return the two sums apart."
    rows, columns = np.nonzero(total)
    assert len(rows), "total of an image with one bright pixel is 0 everywhere."
    for name, along in (("y", rows), ("x", columns)):
        reached, side = along.max() - along.min() + 1, 2 * radius + 1
        assert reached == side, (
            f"total around one bright pixel: it spreads over {reached} pixels in {name}, for radius {radius} it must be "
            f"{side}: do the offsets d{name} run from {-radius} to {radius}, both included?"
        )
    window = total[y - radius : y + radius + 1, x - radius : x + radius + 1]
    assert np.ptp(window) > 0, "every pixel of the window weighs 1: the spatial kernel is missing."
    assert total[y, x] != 0, "total around one bright pixel: the pixel itself, offset (0, 0), is left out of the sum."
    top = tuple(int(place) for place in np.unravel_index(total.argmax(), total.shape))
    assert top == (y, x), (
        f"off centre: the impulse lies at y = {y}, x = {x}, the top of your bell at y = {top[0]}, x = {top[1]}."
    )


def _quotient(total, norm, image):
    """Total / norm of a student's two sums, once they have their shapes."""
    for name, values, shape in (("total", total, image.shape), ("norm", norm, image.shape[:2])):
        assert_matches(np.zeros(np.shape(values)), np.zeros(shape), name)  # the shape alone
    norm = np.asarray(norm, float)
    assert (norm != 0).all(), f"norm is 0 at {int((norm == 0).sum())} pixels: the weight of a pixel with itself is 1."
    return np.asarray(total, float) / norm[..., np.newaxis]


def _explain_likeness(weight):
    """Name the usual mistakes in the weight of a colour that differs by (0.3, 0.6, 0.6), with sigma_radiance = 0.6."""
    mistakes = {
        "the factor 2 is missing: the bell is exp(-d^2 / (2 sigma^2))": 0.9**2 / 0.6**2,
        "sigma is to be squared: the bell is exp(-d^2 / (2 sigma^2))": 0.9**2 / (2 * 0.6),
        "the distance d is to be squared: the bell is exp(-d^2 / (2 sigma^2))": 0.9 / (2 * 0.6**2),
        "neither d nor sigma is squared: the bell is exp(-d^2 / (2 sigma^2))": 0.9 / (2 * 0.6),
        "the distance is L2, the root of the sum of squares over the channels, not L1, the sum of |d|": 1.5**2 / 0.72,
        "the squares are summed over the channels, not averaged": 0.9**2 / 3 / 0.72,
        "all channels count, not only the first": 0.3**2 / 0.72,
        "the range kernel is missing: it counts as if it were the same colour": 0.0,
    }
    for words, exponent in mistakes.items():
        assert not np.isclose(weight, np.exp(-exponent), rtol=1e-4), (
            f"a colour at distance 0.9 with sigma_radiance 0.6 gets the weight {float(weight):.4f}, expected 0.3247: {words}."
        )


# --- bilateral_weights(image, y, x, sigma_space, sigma_radiance, radius)


@graded("bilateral_weights", points=0.5)
def test_on_a_flat_image_only_nearness_counts(impl):
    "On a flat image the weights are the spatial bell, and the pixel's weight with itself is 1."
    weight = impl(np.full((9, 9, 3), 0.7), 4, 4, 1.5, 0.2, 3)
    assert not np.array_equal(weight, np.ones((7, 7))), "every weight is 1: the spatial kernel is missing."
    assert_matches(weight, _bell_window(1.5, 3), "weights on a flat image (sigma_space 1.5, radius 3)")


@graded("bilateral_weights", points=1)
def test_likeness_is_the_distance_of_two_colours(impl):
    "Likeness is measured by the Euclidean distance over all three channels together."
    image = np.full((5, 5, 3), 0.1)
    image[2, 3] += (0.3, 0.6, 0.6)  # distance 0.9
    weight = impl(image, 2, 2, INFINITY, 0.6, 1)
    expected = np.ones((3, 3))
    expected[1, 2] = np.exp(-(0.9**2) / (2 * 0.6**2))
    if np.shape(weight) == (3, 3):
        assert not np.isclose(weight[2][1], expected[1, 2]), "transposed: the weight of [1, 2] (y, x) stands at [2, 1]."
        _explain_likeness(weight[1][2])
    assert_matches(weight, expected, "weights around one pixel of another colour, at [1, 2] of the window")


@graded("bilateral_weights", points=0.5)
def test_outside_the_image_the_weight_is_zero(impl):
    "Where the window leaves the image the weight is 0, and the window keeps its size."
    image = np.full((4, 6, 1), 2.0)
    expected = np.zeros((5, 5))
    expected[2:, :3] = _bell_window(1.0, 2)[2:, :3]
    weight = impl(image, 0, 5, 1.0, 0.1, 2)
    if np.shape(weight) == (5, 5):
        inside = expected > 0
        right_inside = np.allclose(np.asarray(weight)[inside], expected[inside])
        assert not (right_inside and np.any(np.asarray(weight)[~inside] > 0)), (
            "pixels outside the image have a weight: a negative index takes pixels from the other side (wrap-around)."
        )
    assert_matches(weight, expected, "weights at the top right corner, y = 0 and x = 5")


@graded("bilateral_weights", points=0.5)
def test_an_edge_cuts_the_window(impl):
    "On a step the pixels on the other side get next to nothing; which side is which is kept."
    image = np.zeros((9, 9, 1))
    image[4:] = 1.0  # the upper four rows are dark
    weight = impl(image, 4, 4, 2.0, 0.1, 2)
    expected = _bell_window(2.0, 2)
    expected[:2] *= np.exp(-50.0)
    assert_matches(weight, expected, "weights next to an edge that lies above the pixel")


@graded("bilateral_weights", points=1, hidden=True)
def test_weights_of_noise_give_the_filter(impl):
    "With these weights the weighted mean is the bilateral filter, anywhere in a noisy image."
    image = _noise(7, 10, 3)
    filtered = mcd.bilateral(image, sigma_space=1.7, sigma_radiance=0.3, radius=2, engine="numpy")
    padded = np.pad(image, ((2, 2), (2, 2), (0, 0)))
    for y, x in ((0, 0), (3, 5), (6, 2), (2, 9)):
        weight = np.asarray(impl(image, y, x, 1.7, 0.3, 2), float)
        mean = (weight[..., np.newaxis] * padded[y : y + 5, x : x + 5]).sum(axis=(0, 1)) / weight.sum()
        assert_matches(mean, filtered[y, x], f"weighted mean at y = {y}, x = {x}")


@graded("bilateral_weights", points=0.5, hidden=True)
def test_extreme_bandwidths_stay_finite(impl):
    "An infinite sigma switches its bell off; a tiny one leaves the pixel alone with itself."
    image = _noise(5, 5, 3)
    assert_matches(impl(image, 2, 2, INFINITY, INFINITY, 2), np.ones((5, 5)), "weights with both sigmas infinite")
    alone = np.zeros((5, 5))
    alone[2, 2] = 1.0
    assert_matches(impl(image, 2, 2, INFINITY, 1e-6, 2), alone, "weights with sigma_radiance 1e-6")


# --- bilateral_sums(image, sigma_space, sigma_radiance, radius)


@graded("bilateral_sums", points=0.5)
def test_wide_range_kernel_gives_the_bell(impl):
    "With sigma_radiance infinite an impulse turns into the spatial bell, centred on it."
    image = np.zeros((11, 13, 1))
    image[5, 4] = 1.0
    total, norm = impl(image, 1.3, INFINITY, 3)
    expected = np.zeros((11, 13))
    expected[2:9, 1:8] = _bell_window(1.3, 3)
    if np.shape(total) == (11, 13, 1):
        assert not np.isnan(total).all(), (
            "total is NaN everywhere: with an infinite sigma, d^2 / 2 * sigma^2 is 0 times infinity. Are the brackets of "
            "d^2 / (2 sigma^2) missing?"
        )
        if np.isfinite(total).all() and np.asarray(total).dtype.kind == "f":
            _check_impulse(np.asarray(total)[..., 0], expected, 5, 4, 3)
    assert_matches(total, expected[..., np.newaxis], "total of an impulse at y = 5, x = 4")
    assert_matches(norm[5][6], _bell_window(1.3, 3).sum(), "norm (W_p) of a pixel in the middle")


@graded("bilateral_sums", points=0.5)
def test_borders_count_only_what_is_there(impl):
    "On a flat image norm is the sum of the bell over the pixels inside the image, and total is norm times the colour."
    total, norm = impl(np.full((6, 7, 2), 3.0), 2.0, 0.5, 4)
    expected = _nearness(6, 7, 2.0, 4)
    if np.shape(norm) == (6, 7):
        assert np.any(norm), "norm is 0 everywhere: the weight of a pixel with itself is 1 already."
        assert np.ptp(norm) > 0, (
            f"norm is {norm[0][0]:.4g} in the corner as in the middle: pixels outside the image were counted (padding or "
            f"wrap-around)."
        )
        assert not np.allclose(total, 3.0), "total is divided by norm already: return the two sums apart."
    assert_matches(norm, expected, "norm on a flat image (clipped at the borders)")
    assert_matches(total, 3 * np.dstack([expected, expected]), "total on a flat image of radiance 3")


@graded("bilateral_sums", points=1)
def test_two_colours_weigh_each_other(impl):
    "Two pixels at colour distance d give each other the weight exp(-d^2 / (2 sigma_radiance^2)), in both sums."
    image = np.array([[[0.1, 0.2, 0.3], [0.4, 0.8, 0.9]]])  # distance 0.9
    total, norm = impl(image, INFINITY, 0.6, 1)
    weight = np.exp(-(0.9**2) / (2 * 0.6**2))
    if np.shape(norm) == (1, 2):
        assert not np.allclose(norm, 3 * (1 + weight)), (
            "norm is 3 times what it should be: the weight is added once per channel; norm counts each pixel once."
        )
        assert norm[0][0] != 0, (
            "norm is 0: even the pixel itself is left out. Row 0 and column 0 belong to the image: is it 0 <= y, 0 <= x?"
        )
        assert not norm[0][0] < 0.99, (
            f"norm is {norm[0][0]:.4g}, but the weight of a pixel with itself is 1 already: is the difference taken between "
            f"the very pixels that are averaged?"
        )
        assert not norm[0][0] > 2.01, (
            f"norm of an image of two pixels is {norm[0][0]:.4g}: pixels outside were counted (padding or wrap-around)."
        )
        _explain_likeness(norm[0][0] - 1)
    assert_matches(norm, np.full((1, 2), 1 + weight), "norm of two pixels of different colour")
    assert_matches(total, image + weight * image[:, ::-1], "total of two pixels of different colour")


@graded("bilateral_sums", points=1)
def test_the_quotient_is_the_bilateral_filter(impl):
    "On noise total / norm is the bilateral filter, and the image is left as it was."
    image = _noise(9, 12, 3)
    total, norm = impl(image, 1.5, 0.3, 3)
    filtered = mcd.bilateral(image, sigma_space=1.5, sigma_radiance=0.3, radius=3, engine="numpy")
    assert_matches(_quotient(total, norm, image), filtered, "total / norm on noise")


@graded("bilateral_sums", points=1, hidden=True)
def test_steep_steps_survive(impl):
    "A step of ten sigma_radiance survives; a window larger than the image does no harm."
    image = np.zeros((5, 8, 1))
    image[:, 3:] = 10.0
    total, norm = impl(image, 3.0, 1.0, 9)
    assert_matches(_quotient(total, norm, image), image, "total / norm of a step of ten sigma_radiance", atol=1e-6)


@graded("bilateral_sums", points=1, hidden=True)
def test_whole_numbers_and_small_floats_are_not_cut_off(impl):
    "An image of whole numbers, or of float32, gives the same sums as one of float64."
    whole = np.random.default_rng(2).integers(0, 5, (6, 5, 3))
    expected = mcd.bilateral(whole.astype(float), sigma_space=1.0, sigma_radiance=2.0, radius=2, engine="numpy")
    for kind in (np.int64, np.float32, np.float64):
        total, norm = impl(whole.astype(kind), 1.0, 2.0, 2)
        assert_matches(
            _quotient(total, norm, whole),
            expected,
            f"total / norm of an image of dtype {np.dtype(kind).name}",
            rtol=1e-5,
        )


@picture("bilateral_sums")
def picture_bilateral(impl):
    """Noisy checks of two colours, filtered."""
    y, x = np.indices((40, 40))
    checks = np.where(((y // 10 + x // 10) % 2)[..., np.newaxis], (0.7, 0.25, 0.2), (0.2, 0.3, 0.6))
    image = checks + 0.12 * (_noise(40, 40, 3) - 0.5)
    total, norm = impl(image, 2.0, 0.2, 4)
    yours = np.asarray(total, float) / np.asarray(norm, float)[..., np.newaxis]
    return yours, mcd.bilateral(image, sigma_space=2.0, sigma_radiance=0.2, radius=4, engine="numpy")


# --- predictions


@graded("weight_across", points=1)
def test_weight_across_an_edge(impl):
    "The range kernel's weight across an edge of height 2 sigma_radiance, to two digits."
    value, expected = float(impl), np.exp(-2.0)
    for wrong, words in (
        (np.exp(-4.0), "that is exp(-d^2 / sigma^2): the bell has 2 sigma^2 below the line"),
        (np.exp(-1.0), "that is exp(-d / 2): the difference is squared first"),
        (0.0, "a bell is small out there, never zero"),
        (0.6065, "that is the weight at one sigma, not at two"),
    ):
        assert abs(value - wrong) > 0.01 or abs(value - expected) <= 0.01, f"{value:.3g}: {words}."
    assert abs(value - expected) <= 0.01, f"{value:.3g} is not exp(-(2 sigma)^2 / (2 sigma^2)): write the quotient out."


def _what_it_is(filtered, image):
    """Which of the four answers a filtered image is: found by filtering."""
    candidates = {
        "A": image,
        "B": mcd.gaussian(image, sigma_space=1.5, radius=3, engine="numpy"),
        "C": mcd.gaussian(image, sigma_space=INFINITY, radius=3, engine="numpy"),
        "D": np.full_like(image, image.mean()),
    }
    return min(candidates, key=lambda letter: float(np.abs(candidates[letter] - filtered).max()))


@graded("limits", points=1)
def test_limits_of_the_bandwidths(impl):
    "What the bilateral filter turns into when a bandwidth goes to 0 or to infinity: tried on noise."
    letters = [str(one).strip().upper() for one in impl] if isinstance(impl, (tuple, list, str)) else []
    assert len(letters) == 4, "four letters are needed, as in ('A', 'B', 'C', 'D')."
    image, tiny = _noise(12, 12), 1e-6
    questions = (
        (1.5, tiny, "only pixels of the same colour keep a weight: what is the mean of equal colours?"),
        (1.5, INFINITY, "a bell of infinite width is 1 everywhere: which weights are left?"),
        (INFINITY, INFINITY, "both bells are 1 everywhere: what is a mean with equal weights, and over which pixels?"),
        (tiny, 0.2, "no neighbour is near enough to count: who is left in the mean?"),
    )
    for place, (space, radiance, hint) in enumerate(questions):
        filtered = mcd.bilateral(image, sigma_space=space, sigma_radiance=radiance, radius=3, engine="numpy")
        assert letters[place] == _what_it_is(filtered, image), f"question {place + 1} is not {letters[place]}: {hint}"


@graded("firefly_left", points=1)
def test_a_firefly_stays(impl):
    "The radiance of a firefly after the bilateral filter, to two digits."
    value = float(impl)
    image = np.full((15, 15), 0.5)
    image[7, 7] = 50.0
    blurred = float(mcd.gaussian(image, sigma_space=2.0, radius=6, engine="numpy")[7, 7])
    kept = float(mcd.bilateral(image, sigma_space=2.0, sigma_radiance=0.3, radius=6, engine="numpy")[7, 7])
    assert abs(value - blurred) > 0.5, (
        f"{value:.3g} is what the Gaussian leaves: here the neighbours must also be alike."
    )
    assert abs(value - 0.5) > 0.1, (
        f"{value:.3g} would mean that the neighbours outvote the firefly: what are their weights?"
    )
    assert abs(value - kept) <= 0.5, f"{value:.3g} is not it: which weight has a neighbour 165 sigma_radiance away?"


# --- hard_case() -> noisy, truth


def _errors(noisy, truth, sigma_space):
    filtered = (
        mcd.gaussian(noisy, sigma_space=sigma_space, engine="numpy"),
        mcd.bilateral(noisy, sigma_space=sigma_space, sigma_radiance=0.2, engine="numpy"),
    )
    return [float(((one - truth) ** 2).mean()) for one in filtered]


def _hard_case(impl):
    noisy, truth = (np.asarray(one, float) for one in impl())
    assert (noisy.ndim, noisy.shape) == (2, truth.shape), (
        f"noisy and truth must be images (h, w) of one size, got {noisy.shape} and {truth.shape}."
    )
    assert all(16 <= side <= 64 for side in noisy.shape), f"16 to 64 pixels a side are asked for, got {noisy.shape}."
    assert np.isfinite(noisy + truth).all(), "noisy and truth must be finite: there is NaN or infinity."
    return noisy, truth


@graded("hard_case", points=0.5)
def test_the_case_is_fair(impl):
    "The truth has an edge, and the noise is like Monte Carlo noise: its mean is zero."
    noisy, truth = _hard_case(impl)
    steps = [np.abs(np.diff(truth, axis=axis)).min(axis=1 - axis).max() for axis in (0, 1)]
    assert max(steps) >= 0.4, (
        f"truth needs an edge of 0.4 or more along a whole row or column; the best of yours is {max(steps):.3g}."
    )
    noise = noisy - truth
    assert noise.std() > 0.02, f"the noise has a standard deviation of {noise.std():.3g}; at least 0.02 is asked for."
    assert abs(noise.mean()) <= 0.1 * noise.std(), (
        f"the noise has the mean {noise.mean():.3g}, more than a tenth of its standard deviation {noise.std():.3g}: the "
        f"truth is to be the mean of the noisy pixels."
    )


@graded("hard_case", points=1)
def test_the_bilateral_is_worse(impl):
    "With sigma_radiance = 0.2 the bilateral has at least five times the Gaussian's mean squared error (sigma_space = 2)."
    noisy, truth = _hard_case(impl)
    of_gaussian, of_bilateral = _errors(noisy, truth, 2.0)
    assert of_bilateral >= 5 * of_gaussian, (
        f"mean squared error: Gaussian {of_gaussian:.3g}, bilateral {of_bilateral:.3g}; the second is to be at least five "
        f"times the first. Which noise does the range kernel take for an edge?"
    )


@graded("hard_case", points=0.5, hidden=True)
def test_it_is_no_accident(impl):
    "It stays so with sigma_space = 1.4 and 3, and the same images come back each time."
    noisy, truth = _hard_case(impl)
    again, _ = _hard_case(impl)
    assert np.array_equal(noisy, again), "two calls gave two images: use a fixed seed, np.random.default_rng(0)."
    for sigma_space in (1.4, 3.0):
        of_gaussian, of_bilateral = _errors(noisy, truth, sigma_space)
        assert of_bilateral >= 4 * of_gaussian, (
            f"with sigma_space = {sigma_space}: Gaussian {of_gaussian:.3g}, bilateral {of_bilateral:.3g}."
        )


# --- centroid(response) -> (y, x)


def _compare_centroid(found, expected, what, *, peak=None, atol=1e-9):
    """Name a middle that is half a pixel off, and a peak in place of the mean."""
    found, expected = np.asarray(found, float), np.asarray(expected, float)
    if found.shape == (2,):
        assert not np.allclose(found, expected - 0.5), (
            f"{what}: half a pixel off. The middle is the pixel (height // 2, width // 2), a whole number."
        )
        assert peak is None or not np.allclose(found, peak), (
            f"{what}: this is the peak, not the centroid: average the places, weighted by the response."
        )
    assert_matches(found, expected, what, atol=atol)


@graded("centroid", points=0.5)
def test_centred_responses_have_centroid_zero(impl):
    "A bell in the middle has its centroid at (0, 0), whatever its sum."
    _compare_centroid(impl(_bell_window(2.0, 6)), (0, 0), "centroid of a centred bell")
    _compare_centroid(impl(7 * _bell_window(1.0, 3)), (0, 0), "centroid of a bell seven times as high")


@graded("centroid", points=1)
def test_a_shift_is_found(impl):
    "One bright pixel 2 rows below and 3 columns left of the middle: (2, -3). It need not sum to 1."
    response = np.zeros((9, 13))
    response[6, 3] = 0.25
    found = np.asarray(impl(response), float)
    assert found.shape != (2,) or not np.allclose(found, (-3, 2)), "(-3, 2): that is (x, y); y, the row, comes first."
    assert found.shape != (2,) or not np.allclose(found, (6, 3)), (
        "(6, 3) is counted from the corner of the array: subtract the middle, (height // 2, width // 2)."
    )
    assert found.shape != (2,) or not np.allclose(found, (0.5, -0.75)), (
        "(0.5, -0.75): the moments are not divided by the sum of the response."
    )
    _compare_centroid(found, (2, -3), "centroid of a pixel 2 below and 3 left of the middle", atol=3e-6)


@graded("centroid", points=0.5)
def test_it_is_the_mean_and_not_the_peak(impl):
    "Of two bright pixels the centroid lies between them, nearer to the brighter one."
    response = np.zeros((11, 11))
    response[5, 1], response[5, 9] = 3.0, 1.0
    _compare_centroid(impl(response), (0, -2), "centroid of 3 at x = -4 and 1 at x = +4", peak=(0, -4), atol=2e-6)


@graded("centroid", points=0.5, hidden=True)
def test_any_size(impl):
    "Any odd height and width, and values of any kind."
    response = np.zeros((5, 21), np.float32)
    response[1, 20], response[4, 0] = 1.0, 1.0
    _compare_centroid(impl(response), (0.5, 0), "centroid in an image of 5 x 21", atol=1e-6)
