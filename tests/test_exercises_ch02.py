"""The tests of the exercises of chapter 02: the reference passes all; each typical slip fails a public one, in fitting words."""

import numpy as np
import pytest

from answers import failures, picture, reference

pytestmark = pytest.mark.ch02


@pytest.mark.parametrize("name", ["gaussian_sums", "gaussian_rows"])
def test_picture_of_the_reference_is_the_target(name):
    yours, target = picture(name)
    assert yours.shape == target.shape == (48, 64, 3)
    np.testing.assert_allclose(yours, target, rtol=1e-12)


# gaussian_weights: the window as the student might write it, with one slip each


def window(exponent, *, first=None, dtype=float, scale=lambda weight: weight):
    def gaussian_weights(sigma_space, radius):
        start = -radius if first is None else first(radius)
        d = np.arange(start, start + 2 * radius + 1)
        squared = (d[:, np.newaxis] ** 2 + d**2).astype(float)
        return scale(np.exp(exponent(squared, sigma_space))).astype(dtype)

    return gaussian_weights


def good(squared, sigma_space):
    return -squared / (2 * sigma_space**2)


def half_window(sigma_space, radius):
    d = np.arange(-radius, radius)
    return np.exp(-(d[:, np.newaxis] ** 2 + d**2) / (2 * sigma_space**2))


def one_line(sigma_space, radius):
    return np.exp(-(np.arange(-radius, radius + 1) ** 2) / (2 * sigma_space**2))


def zero_over_zero(sigma_space, radius):
    d = np.arange(-radius, radius + 1.0)
    distance = np.hypot(d[:, np.newaxis], d)
    with np.errstate(invalid="ignore"):
        return np.exp(-(distance**4) / (2 * sigma_space**2 * distance**2))


WEIGHTS = {
    "no 2": (window(lambda d2, s: -d2 / s**2), "the 2 of 2 sigma_space² is missing"),
    "sigma not squared": (window(lambda d2, s: -d2 / (2 * s)), "without its square"),
    "sigma not squared, no 2": (window(lambda d2, s: -d2 / s), "without its square and without its factor 2"),
    "sign": (window(lambda d2, s: d2 / (2 * s**2)), "grows with the distance"),
    "multiplies": (window(lambda d2, s: -d2 * s**2 / 2), "multiplies where it should divide"),
    "distance not squared": (
        window(lambda d2, s: -np.sqrt(d2) / (2 * s**2)),
        "the distance stands in the exponent without its square",
    ),
    "normalised": (window(good, scale=lambda w: w / w.sum()), "not normalised"),
    "lecture's constant": (lambda s, r: window(good)(s, r) / (2 * np.pi * s**2), "no constant in front"),
    "off centre": (window(good, first=lambda r: -r - 1), "off centre"),
    "from 0": (window(good, first=lambda r: 0), "off centre"),
    "integers": (window(good, dtype=int), "decimals are cut off"),
    "one pixel short": (half_window, "must have shape (5, 5), yours has (4, 4)"),
    "one dimension": (one_line, "must have shape (5, 5), yours has (5,)"),
    "0/0": (zero_over_zero, "NaN"),
    "nothing returned": (lambda s, r: None, "None"),
}


# gaussian_sums and gaussian_rows: loops over offsets, with one slip each


def sums(
    *,
    offsets=None,
    weight=lambda dy, dx, s: np.exp(-(dy**2 + dx**2) / (2 * s**2)),
    outside="nothing",
    rows_only=False,
    finish=lambda total, norm: (total, norm),
    dtype=float,
):
    def gaussian_sums(image, sigma_space, radius):
        height, width, channels = image.shape
        total, norm = np.zeros((height, width, channels), dtype), np.zeros((height, width))
        reach = range(-radius, radius + 1) if offsets is None else offsets(radius)
        for dy in (0,) if rows_only else reach:
            for dx in reach:
                w = weight(dy, dx, sigma_space)
                neighbour, inside = moved(image, dy, dx, outside)
                total += (w * inside[..., np.newaxis] * neighbour).astype(dtype)
                norm += w if outside == "black" else w * inside
        return finish(total, norm)

    return gaussian_sums


def moved(image, dy, dx, outside):
    """The image moved by (dy, dx), and 1 where it comes from inside."""
    y, x = np.mgrid[: image.shape[0], : image.shape[1]]
    y, x = y + dy, x + dx
    inside = ((y >= 0) & (y < image.shape[0]) & (x >= 0) & (x < image.shape[1])).astype(float)
    if outside in ("wrap", "edge"):
        inside[:] = 1.0
    if outside == "wrap":
        return image[y % image.shape[0], x % image.shape[1]], inside
    return image[np.clip(y, 0, image.shape[0] - 1), np.clip(x, 0, image.shape[1] - 1)], inside


def transposed(function):
    def turned(image, sigma_space, radius):
        total, norm = function(np.swapaxes(image, 0, 1), sigma_space, radius)
        return np.swapaxes(total, 0, 1), norm.T

    return turned


def changes_its_input(image, sigma_space, radius):
    image *= 1.5
    return sums()(image, sigma_space, radius)


def shifted(total, norm):
    return np.roll(total, 1, axis=1), norm


def nan_division(total, norm):
    with np.errstate(invalid="ignore", divide="ignore"):
        return total * np.float64(0) / (norm[..., np.newaxis] * 0), norm


def constant_in_front(image, sigma_space, radius):
    total, norm = sums()(image, sigma_space, radius)
    return total / (2 * np.pi * sigma_space**2), norm / (2 * np.pi * sigma_space**2)


SUMS = {
    "no 2": ({"weight": lambda y, x, s: np.exp(-(y**2 + x**2) / s**2)}, "the 2 of 2 sigma_space² is missing"),
    "sigma not squared": ({"weight": lambda y, x, s: np.exp(-(y**2 + x**2) / (2 * s))}, "without its square"),
    "sign": ({"weight": lambda y, x, s: np.exp((y**2 + x**2) / (2 * s**2))}, "the sign of the exponent is wrong"),
    "off centre": ({"finish": shifted}, "off centre"),
    "divided already": ({"finish": lambda t, n: (t / n[..., np.newaxis], n)}, "divided by norm already"),
    "swapped": ({"finish": lambda t, n: (n, t)}, "total comes first"),
    "total alone": ({"finish": lambda t, n: t}, "2 results are needed"),
    "norm with channels": ({"finish": lambda t, n: (t, n[..., np.newaxis] + 0 * t)}, "is needed"),
    "norm transposed": ({"finish": lambda t, n: (t, n.T)}, "transposed"),
    "black outside": ({"outside": "black"}, "norm of a flat image"),
    "edge repeated": ({"outside": "edge"}, "norm of a flat image"),
    "wraps around": ({"outside": "wrap"}, "norm of a flat image"),
    "one offset short": ({"offsets": lambda r: range(-r, r)}, "do the offsets dy run from -4 to 4"),
    "middle left out": ({"weight": lambda y, x, s: np.exp(-(y**2 + x**2) / (2 * s**2)) * bool(y or x)}, "is left out"),
    "integers": ({"dtype": int}, "decimals are cut off"),
    "0/0": ({"finish": nan_division}, "NaN"),
    "nothing returned": ({"finish": lambda t, n: None}, "return"),
}
ROWS = {
    **{
        name: SUMS[name]
        for name in ("no 2", "sigma not squared", "sign", "off centre", "total alone", "0/0", "integers")
    },
    "wraps around": ({"outside": "wrap"}, "only pixels inside the row may count"),
    "black outside": ({"outside": "black"}, "only pixels inside the row may count"),
    "one offset short": ({"offsets": lambda r: range(-r, r)}, "do the offsets dx run from -4 to 4"),
    "whole window": ({"rows_only": False}, "along the row alone"),
}
FUNCTIONS = [
    *(("gaussian_weights", slip, *case) for slip, case in WEIGHTS.items()),
    *(("gaussian_sums", slip, sums(**changes), words) for slip, (changes, words) in SUMS.items()),
    ("gaussian_sums", "changes its input", changes_its_input, "modified its input `image`"),
    ("gaussian_sums", "lecture's constant", constant_in_front, "a constant factor"),
    ("gaussian_sums", "rows alone", sums(rows_only=True), "1 pixels in y, for radius 4 it must be 9"),
    *(
        ("gaussian_rows", slip, sums(**{"rows_only": True, **changes}), words)
        for slip, (changes, words) in ROWS.items()
    ),
    ("gaussian_rows", "down the columns", transposed(sums(rows_only=True)), "must run along the rows"),
]


@pytest.mark.parametrize(("name", "slip", "answer", "words"), FUNCTIONS, ids=lambda value: str(value)[:24])
def test_slips_fail_a_public_test_in_fitting_words(name, slip, answer, words):
    messages = failures(name, answer, hidden=False)
    assert any(words in message for message in messages), messages


@pytest.mark.parametrize("name", ["gaussian_sums", "gaussian_rows"])
def test_the_loops_above_are_right_without_a_slip(name):
    answer = sums(rows_only=name == "gaussian_rows")
    assert failures(name, answer, hidden=False) == failures(name, answer, hidden=True) == []


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("predicted_noise", 1 / (16 * np.pi), "this is the variance"),
        ("predicted_noise", 1 / (8 * np.pi), "the peak of the bell"),
        ("predicted_noise", 0.25, "two dimensions"),
        ("predicted_noise", 0.5, "too large by more than 5 %"),
        ("predicted_noise", 0.05, "too small by more than 5 %"),
        ("predicted_noise", 2.0, "between all (1) and nothing (0)"),
        ("predicted_noise", "little", "does not fit the question"),
        ("predicted_noise", None, "not answered yet"),
        ("predicted_order", ["dof", "soft_shadow", "pinhole"], "the reverse order"),
        ("predicted_order", ["dof", "pinhole", "soft_shadow"], "dof does not want the smallest"),
        ("predicted_order", ["soft_shadow", "dof", "pinhole"], "soft_shadow does not want the smallest"),
        ("predicted_order", ["pinhole", "dof", "soft_shadow"], "compare the noise of the other two"),
        ("predicted_order", ["pinhole", "dof"], "each once"),
        ("predicted_order", "pinhole", "each once"),
        ("predicted_order", 3, "does not fit the question"),
    ],
)
def test_wrong_predictions_get_a_hint(name, value, words):
    (message,) = failures(name, value, hidden=False)
    assert words in message


def checks(height, width):
    y, x = np.mgrid[:height, :width]
    return (x + y) % 2.0


def white(height, width, seed=0):
    noise = np.random.default_rng(seed).standard_normal((height, width))
    return (noise - noise.mean()) / noise.std()


@pytest.mark.parametrize(
    ("name", "answer", "words"),
    [
        ("hard_image", lambda h, w: np.full((h, w), 0.5), "the Gaussian still helps"),
        ("hard_image", lambda h, w: 0.45 + 0.1 * checks(h, w), "the Gaussian still helps"),
        ("hard_image", lambda h, w: 3 * checks(h, w), "radiance between 0 and 1"),
        ("hard_image", lambda h, w: checks(w, h), "shape (48, 64) is needed"),
        ("hard_image", lambda h, w: checks(h, w) * np.nan, "NaN"),
        ("hard_image", lambda h, w: None, "is the `return` missing?"),
        ("stubborn_noise", white, "let neighbours err alike"),
        ("stubborn_noise", lambda h, w, seed: white(h, w, 0), "use the seed"),
        ("stubborn_noise", lambda h, w, seed: white(h, w, None), "the same seed must give the same noise"),
        ("stubborn_noise", lambda h, w, seed: np.ones((h, w)), "the mean must be 0"),
        ("stubborn_noise", lambda h, w, seed: 3 * white(h, w), "the standard deviation must be 1"),
        ("stubborn_noise", lambda h, w, seed: white(w, h), "shape (64, 80) is needed"),
    ],
)
def test_images_that_break_nothing_get_a_hint(name, answer, words):
    messages = failures(name, answer, hidden=False)
    assert any(words in message for message in messages), messages


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        ("gaussian_weights", lambda s, r: reference("gaussian_weights")(s, r) if r else np.zeros((1, 1))),
        ("hard_image", lambda h, w: checks(h, w) if (h, w) == (48, 64) else np.zeros((h, w))),
        ("stubborn_noise", lambda h, w, seed: reference("stubborn_noise")(64, 80, seed)),
    ],
)
def test_answers_made_for_the_public_tests_fail_a_hidden_one(name, answer):
    assert failures(name, answer, hidden=False) == []
    assert failures(name, answer, hidden=True) != []


def test_a_row_shorter_than_the_window_has_no_middle_that_is_right():
    def twice(image, sigma_space, radius):
        total, norm = sums(rows_only=True)(image, sigma_space, radius)
        return total, norm * (2 if image.shape[1] <= 2 * radius else 1)

    (message,) = failures("gaussian_rows", twice, hidden=True)
    assert "a constant factor of 2" in message
    assert "middle of a row" not in message


def test_a_window_larger_than_the_image_is_tested_hidden():
    def no_clip(image, sigma_space, radius):
        if radius >= min(image.shape[:2]):
            raise IndexError("window larger than the image")
        return sums()(image, sigma_space, radius)

    assert failures("gaussian_sums", no_clip, hidden=False) == []
    (message,) = failures("gaussian_sums", no_clip, hidden=True)
    assert "IndexError" in message
