"""The exercises of chapter 03 tested themselves: the reference earns every point, each typical mistake is named."""

import numpy as np
import pytest

from answers import assert_earns_every_point, assert_mistake_is_named, failures, picture
from mcdenoise.filters.bilateral import bilateral_sums

pytestmark = pytest.mark.ch03


def l2(difference, sigma):
    return np.exp(-np.sum((np.asarray(difference) / sigma) ** 2, axis=-1) / 2)


def l1(difference, sigma):
    return np.exp(-((np.abs(difference).sum(axis=-1) / sigma) ** 2) / 2)


def without_two(difference, sigma):
    return l2(difference, sigma) ** 2


def not_squared(difference, sigma):
    return np.exp(-np.sqrt(np.sum(np.asarray(difference) ** 2, axis=-1)) / (2 * sigma**2))


def sigma_for_variance(difference, sigma):
    return np.exp(-np.sum(np.asarray(difference) ** 2, axis=-1) / (2 * sigma))


def no_brackets(difference, sigma):
    with np.errstate(invalid="ignore"):
        return np.exp(-np.sum(np.asarray(difference) ** 2, axis=-1) / 2 * sigma**2)


def hollow(difference, sigma):
    return l2(difference, sigma) * np.any(difference)


def constant(difference, sigma):
    return np.ones(np.shape(difference)[:-1])


def weights(image, y, x, sigma_space, sigma_radiance, radius, *, near=l2, alike=l2, shift=(0, 0), wrap=False):
    """The loop a student would write, with places for mistakes."""
    height, width = image.shape[:2]
    weight = np.zeros((2 * radius + 1, 2 * radius + 1))
    for dy in range(-radius, radius + 1):
        for dx in range(-radius, radius + 1):
            there = y + dy, x + dx
            if wrap:
                there = there[0] % height, there[1] % width
            if 0 <= there[0] < height and 0 <= there[1] < width:
                offset = np.array([dy + shift[0], dx + shift[1]], float)
                likeness = alike(image[there] - image[y, x], sigma_radiance)
                weight[radius + dy, radius + dx] = near(offset, sigma_space) * likeness
    return weight


def per_channel_weights(image, y, x, sigma_space, sigma_radiance, radius):
    one = [weights(image[..., k : k + 1], y, x, sigma_space, sigma_radiance, radius) for k in range(image.shape[-1])]
    return np.stack(one, axis=-1)


def spoiling_weights(image, y, x, *rest):
    image -= image[y, x]
    return weights(image, y, x, *rest)


def sums(
    image, sigma_space, sigma_radiance, radius, *, near=l2, alike=l2, shift=(0, 0), wrap=False, guide=(0, 0), last=0
):
    image = np.asarray(image, float)
    height, width, channels = image.shape
    total, norm = np.zeros((height, width, channels)), np.zeros((height, width))
    for dy in range(-radius, radius + 1 + last):
        for dx in range(-radius, radius + 1 + last):
            for y in range(height):
                for x in range(width):
                    j, i = y + dy, x + dx
                    if wrap:
                        j, i = j % height, i % width
                    if not (0 <= j < height and 0 <= i < width):
                        continue
                    seen = min(j + guide[0], height - 1), min(i + guide[1], width - 1)
                    weight = near(np.array([dy + shift[0], dx + shift[1]], float), sigma_space)
                    weight = weight * alike(image[seen] - image[y, x], sigma_radiance)
                    total[y, x] += weight * image[j, i]
                    norm[y, x] += weight
    return total, norm


def per_channel_sums(image, *rest):
    one = [sums(image[..., k : k + 1], *rest) for k in range(image.shape[-1])]
    return np.concatenate([total for total, _ in one], axis=-1), one[0][1]


def divided(image, *rest):
    total, norm = sums(image, *rest)
    return total / norm[..., np.newaxis], norm


def norm_over_channels(image, *rest):
    total, norm = sums(image, *rest)
    return total, norm * image.shape[-1]


def without_row_0(image, *rest):
    """As with `if 0 < j < height and 0 < i < width`."""
    total, norm = np.zeros(image.shape), np.zeros(image.shape[:2])
    total[1:, 1:], norm[1:, 1:] = sums(image[1:, 1:], *rest)
    return total, norm


def transposed(image, *rest):
    total, norm = sums(image, *rest)
    return total.swapaxes(0, 1), norm.T


def truncated(image, *rest):
    total, norm = sums(image, *rest)
    return total.astype(int), norm


def spoiling(image, *rest):
    result = sums(image, *rest)
    image *= 2
    return result


def with_nan(image, *rest):
    total, norm = sums(image, *rest)
    total[0, 0] = np.nan
    return total, norm


def padded(image, sigma_space, sigma_radiance, radius):
    image = np.asarray(image, float)
    border = np.pad(image, ((radius, radius), (radius, radius), (0, 0)))
    total, norm = sums(border, sigma_space, sigma_radiance, radius)
    inside = slice(radius, radius + image.shape[0]), slice(radius, radius + image.shape[1])
    return total[inside], norm[inside]


def rows_and_columns(response):
    y, x = np.indices(response.shape)
    return (response * y).sum() / response.sum(), (response * x).sum() / response.sum()


def middle(response):
    y, x = rows_and_columns(response)
    return y - response.shape[0] // 2, x - response.shape[1] // 2


def fair_coin(change=0.0, side=32, amplitude=0.5, step=0.5):
    truth = np.full((side, side), 0.5)
    truth[:, side // 2 :] += step
    coin = np.random.default_rng(0).permutation(truth.size).reshape(truth.shape) % 2
    return truth + amplitude * (2 * coin - 1) + change, truth


# exercise, what the student did, the answer, what the message must say
WRONG = (
    ("bilateral_weights", "L1 over channels", lambda *a: weights(*a, alike=l1), "not L1"),
    ("bilateral_weights", "difference per channel", per_channel_weights, "the last axis (channels) is one too many"),
    ("bilateral_weights", "not squared", lambda *a: weights(*a, alike=not_squared), "the distance d is to be squared"),
    (
        "bilateral_weights",
        "sigma for variance",
        lambda *a: weights(*a, alike=sigma_for_variance),
        "sigma is to be squared",
    ),
    ("bilateral_weights", "2 missing, range", lambda *a: weights(*a, alike=without_two), "factor 2 is missing"),
    (
        "bilateral_weights",
        "2 missing, space",
        lambda *a: weights(*a, near=without_two),
        "is the 2 of 2 sigma^2 missing",
    ),
    ("bilateral_weights", "space forgotten", lambda *a: weights(*a, near=constant), "spatial kernel is missing"),
    ("bilateral_weights", "range forgotten", lambda *a: weights(*a, alike=constant), "range kernel is missing"),
    ("bilateral_weights", "normalised", lambda *a: weights(*a) / weights(*a).sum(), "divided by the sum"),
    ("bilateral_weights", "off centre", lambda *a: weights(*a, shift=(0, -1)), "off centre"),
    ("bilateral_weights", "transposed", lambda *a: weights(*a).T, "transposed"),
    ("bilateral_weights", "wrap-around", lambda *a: weights(*a, wrap=True), "wrap-around"),
    (
        "bilateral_weights",
        "cut to size",
        lambda i, y, x, *a: weights(i, y, x, *a)[max(0, a[2] - y) :],
        "shape (3, 5) came back, (5, 5) is needed",
    ),
    ("bilateral_weights", "factor two", lambda *a: 2 * weights(*a), "factor of 2"),
    ("bilateral_weights", "spoils its input", spoiling_weights, "modified its input `image`"),
    ("bilateral_weights", "whole numbers", lambda *a: weights(*a).astype(int), "whole numbers"),
    ("bilateral_weights", "returns nothing", lambda *a: None, "is the `return` missing"),
    ("bilateral_sums", "L1 over channels", lambda *a: sums(*a, alike=l1), "not L1"),
    ("bilateral_sums", "difference per channel", per_channel_sums, "all channels count"),
    ("bilateral_sums", "not squared", lambda *a: sums(*a, alike=not_squared), "the distance d is to be squared"),
    ("bilateral_sums", "sigma for variance", lambda *a: sums(*a, alike=sigma_for_variance), "sigma is to be squared"),
    ("bilateral_sums", "2 missing, range", lambda *a: sums(*a, alike=without_two), "factor 2 is missing"),
    ("bilateral_sums", "2 missing, space", lambda *a: sums(*a, near=without_two), "is the 2 of 2 sigma^2 missing"),
    ("bilateral_sums", "space forgotten", lambda *a: sums(*a, near=constant), "spatial kernel is missing"),
    ("bilateral_sums", "range forgotten", lambda *a: sums(*a, alike=constant), "range kernel is missing"),
    ("bilateral_sums", "divided already", divided, "divided by norm already"),
    ("bilateral_sums", "guide moved by one", lambda *a: sums(*a, guide=(0, 1)), "the very pixels"),
    ("bilateral_sums", "off centre", lambda *a: sums(*a, shift=(0, 1)), "top of your bell"),
    ("bilateral_sums", "transposed", transposed, "transposed"),
    ("bilateral_sums", "wrap-around", lambda *a: sums(*a, wrap=True), "wrap-around"),
    ("bilateral_sums", "padded with black", padded, "pixels outside were counted"),
    ("bilateral_sums", "factor two", lambda *a: (2 * sums(*a)[0], sums(*a)[1]), "factor of 2"),
    ("bilateral_sums", "NaN", with_nan, "NaN"),
    (
        "bilateral_sums",
        "norm with channels",
        lambda *a: (sums(*a)[0], sums(*a)[0]),
        "the last axis (channels) is one too many",
    ),
    ("bilateral_sums", "norm with channels, quotient", lambda *a: (sums(*a)[0], sums(*a)[0]), "norm: shape (9, 12, 3)"),
    ("bilateral_sums", "norm over channels", norm_over_channels, "once per channel"),
    ("bilateral_sums", "row 0 left out", without_row_0, "even the pixel itself is left out"),
    ("bilateral_sums", "no brackets", lambda *a: sums(*a, alike=no_brackets), "Are the brackets of d^2 / (2 sigma^2)"),
    ("bilateral_sums", "window one short", lambda *a: sums(*a, last=-1), "do the offsets dy run from -3 to 3"),
    ("bilateral_sums", "middle left out", lambda *a: sums(*a, near=hollow), "offset (0, 0), is left out"),
    ("bilateral_sums", "norm zero", lambda *a: (sums(*a)[0], 0 * sums(*a)[1]), "norm is 0 everywhere"),
    ("bilateral_sums", "zeros", lambda i, *a: (np.zeros(i.shape), np.zeros(i.shape[:2])), "is 0 everywhere"),
    ("bilateral_sums", "one result", lambda *a: sums(*a)[0], "2 results are needed"),
    ("bilateral_sums", "whole numbers", truncated, "whole numbers"),
    ("bilateral_sums", "spoils its input", spoiling, "modified its input `image`"),
    ("weight_across", "2 missing", np.exp(-4), "2 sigma^2"),
    ("weight_across", "not squared", np.exp(-1), "squared"),
    ("weight_across", "zero", 0.0, "never zero"),
    ("weight_across", "at one sigma", 0.61, "at one sigma"),
    ("weight_across", "a guess", 0.4, "quotient"),
    ("weight_across", "a word", "small", "does not fit"),
    ("limits", "first wrong", ("B", "B", "C", "A"), "question 1"),
    ("limits", "second wrong", ("A", "C", "C", "A"), "question 2"),
    ("limits", "third wrong", ("A", "B", "D", "A"), "question 3"),
    ("limits", "fourth wrong", "ABCB", "question 4"),
    ("limits", "three letters", ("A", "B", "C"), "four letters"),
    ("firefly_left", "the Gaussian", 2.5, "Gaussian leaves"),
    ("firefly_left", "gone", 0.5, "outvote"),
    ("firefly_left", "halved", 25.0, "165 sigma_radiance"),
    ("hard_case", "little noise", lambda: fair_coin(amplitude=0.05), "at least five times"),
    ("hard_case", "no edge", lambda: fair_coin(step=0.0), "needs an edge"),
    ("hard_case", "biased", lambda: fair_coin(change=0.3), "mean"),
    ("hard_case", "no noise", lambda: fair_coin(amplitude=0.0), "standard deviation"),
    ("hard_case", "too small", lambda: fair_coin(side=8), "16 to 64"),
    ("hard_case", "NaN", lambda: (np.full((20, 20), np.nan), np.zeros((20, 20))), "finite"),
    ("hard_case", "one image", lambda: fair_coin()[0], "returned"),
    ("hard_case", "unequal", lambda: (np.zeros((20, 20)), np.zeros((21, 20))), "one size"),
    ("centroid", "x first", lambda r: middle(r)[::-1], "comes first"),
    ("centroid", "from the corner", rows_and_columns, "subtract the middle"),
    ("centroid", "not divided", lambda r: np.multiply(middle(r), r.sum()), "divided by the sum"),
    (
        "centroid",
        "the peak",
        lambda r: np.subtract(np.unravel_index(r.argmax(), r.shape), np.array(r.shape) // 2),
        "this is the peak, not the centroid",
    ),
    (
        "centroid",
        "half a pixel",
        lambda r: np.subtract(rows_and_columns(r), np.array(r.shape) / 2),
        "half a pixel off",
    ),
    ("centroid", "sign", lambda r: np.negative(middle(r)), "sign"),
)
RIGHT = {
    "bilateral_weights": weights,
    "bilateral_sums": bilateral_sums,
    "weight_across": 0.135,
    "limits": ["a", "b", "c", "a"],
    "firefly_left": 50,
    "hard_case": fair_coin,
    "centroid": middle,
}


@pytest.mark.parametrize("exercise", RIGHT)
def test_a_right_answer_earns_every_point(exercise):
    assert_earns_every_point(exercise, RIGHT[exercise])


def test_slow_loops_of_a_student_are_right_too():
    assert_earns_every_point("bilateral_sums", sums)


@pytest.mark.parametrize(("exercise", "mistake", "answer", "words"), WRONG, ids=[f"{e}: {m}" for e, m, *_ in WRONG])
def test_a_public_test_names_the_mistake(exercise, mistake, answer, words):
    assert_mistake_is_named(exercise, mistake, answer, words)


def test_the_hidden_tests_find_what_the_public_ones_let_through():
    def never_twice():
        _, truth = fair_coin()
        return truth + np.random.default_rng().permutation(np.repeat([-0.5, 0.5], 512)).reshape(32, 32), truth

    assert failures("hard_case", never_twice, hidden=False) == []
    assert "fixed seed" in failures("hard_case", never_twice, hidden=True)[-1]


def test_the_picture_of_the_reference_is_its_target():
    yours, target = picture("bilateral_sums")
    np.testing.assert_allclose(yours, target, rtol=1e-12)


@pytest.mark.parametrize(
    ("answer", "words"), [(divided, "divided by norm already"), (truncated, "whole numbers came back")]
)
def test_the_first_test_of_the_sums_names_it_too(answer, words):
    assert words in failures("bilateral_sums", answer, hidden=False)[0]
