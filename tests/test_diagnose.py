"""assert_matches: the right result passes, a typically wrong one gets the words meant for it, and no other ones."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdenoise.classroom import Finding, assert_matches, name_mistake
from mcdenoise.study.display import tone_map
from toy_exercise import _blurred as blurred

RNG = np.random.default_rng(8)
IMPULSE = np.zeros((15, 17))
IMPULSE[7, 8] = 1.0
BELL = blurred(IMPULSE[..., np.newaxis], 1.5, 4)[..., 0]
IMAGE = RNG.gamma(2.0, 0.4, (16, 19, 3))  # radiance, also above 1
SQUARE = RNG.normal(size=(12, 12))
MASK = IMAGE[..., 0] > 0.5


def bell(sigma_space, dy=0.0, dx=0.0):
    y, x = np.indices(BELL.shape)
    weight = np.exp(-((y - 7 - dy) ** 2 + (x - 8 - dx) ** 2) / (2 * sigma_space**2))
    return weight / weight.sum()


def one_by(values, entry, value):
    values = values.copy()
    values[entry] = value
    return values


def in_frame(values, margin, frame):
    """`values` inside, `frame` within `margin` pixels of the border."""
    result = frame.copy()
    result[margin:-margin, margin:-margin] = values[margin:-margin, margin:-margin]
    return result


def finding(received, expected, **tolerance):
    with pytest.raises(Finding) as raised:
        assert_matches(received, expected, "the result", **tolerance)
    words = str(raised.value)
    assert words.startswith("the result: ")
    return words.removeprefix("the result: ")


WRONG = {
    "nothing returned": (None, BELL, "nothing came back (None): is the `return` missing?"),
    "text": ("bell", BELL, "the text 'bell' came back; an array of shape (15, 17) is needed"),
    "function": (np.exp, BELL, "the function `exp` came back"),
    "total and norm": (
        (IMAGE, BELL),
        IMAGE,
        "a tuple of 2 (an array of shape (16, 19, 3), an array of shape (15, 17))",
    ),
    "list for number": ([1.0], 1.0, "shape (1,) came back, () is needed: one number, not an array with one entry"),
    "ragged": ([[1.0, 2.0], [3.0]], np.ones((2, 2)), "rows of different lengths"),
    "complex": (BELL + 0.25j, BELL, "complex numbers came back (imaginary parts up to 0.25)"),
    "objects": (np.array([None, 1.0]), np.ones(2), "an array or list holding None came back"),
    "transposed shape": (BELL.T, BELL, "transposed: shape (17, 15) came back, (15, 17) is needed"),
    "transposed image": (IMAGE.swapaxes(0, 1), IMAGE, "transposed: shape (19, 16, 3) came back"),
    "channel missing": (IMAGE.mean(-1), IMAGE, "the last axis (channels) is missing"),
    "channel too many": (BELL[..., np.newaxis], BELL, "the last axis (channels) is one too many"),
    "batch missing": (IMAGE, IMAGE[np.newaxis], "the first axis is missing"),
    "batch too many": (IMAGE[np.newaxis], IMAGE, "the first axis is one too many"),
    "keepdims": (IMAGE[:, :, np.newaxis], IMAGE, "an axis of length 1 too many (keepdims?)"),
    "keepdims twice": (BELL[:, np.newaxis, :, np.newaxis], BELL, "2 axes of length 1 too many (keepdims?)"),
    "flat": (BELL.ravel(), BELL, "as many entries in another shape"),
    "valid part": (IMAGE[2:-2, 2:-2], IMAGE, "2 pixels missing at each border"),
    "padding kept": (np.pad(BELL, 1), BELL, "1 pixel too many at each border"),
    "off by one row and column": (BELL[1:, 1:], BELL, "1 pixel missing along each axis"),
    "a sum": (BELL.sum(), BELL, "shape () came back, (15, 17) is needed: 0 axes instead of 2"),
    "another size": (np.ones((3, 4)), BELL, "shape (3, 4) came back, (15, 17) is needed."),
    "decimals cut off": (
        (10 * IMAGE).astype(int),
        10 * IMAGE,
        "whole numbers came back (int64), the decimals are cut off",
    ),
    "rounded": (np.rint(10 * IMAGE).astype(int), 10 * IMAGE, "the decimals are rounded away"),
    "one NaN": (
        one_by(IMAGE, (3, 4, 1), np.nan),
        IMAGE,
        "1 entry of 912 is NaN (0/0?), first at (3, 4, 1), all others are right",
    ),
    "NaN all over": (np.full(BELL.shape, np.nan), BELL, "255 entries of 255 are NaN (0/0?), first at (0, 0);"),
    "infinite": (
        one_by(2 * BELL, (0, 5), np.inf),
        BELL,
        "1 entry of 255 is infinite (division by 0?), first at (0, 5);",
    ),
    "NaN for a number": (np.nan, 1.5, "the result is NaN"),
    "sign": (-IMAGE, IMAGE, "the sign is flipped"),
    "sign of a number": (-1.5, 1.5, "the sign is flipped; yours -1.5, expected 1.5"),
    "factor 2": (2 * BELL, BELL, "a constant factor of 2; worst entry (7, 8): yours 0.1"),
    "half": (IMAGE / 2, IMAGE, "a constant factor of 1/2"),
    "minus half": (-IMAGE / 2, IMAGE, "a constant factor of -1/2"),
    "pi": (np.pi * IMAGE, IMAGE, "a constant factor of pi"),
    "root 2": (np.sqrt(2) * 0.3, 0.3, "a constant factor of sqrt 2"),
    "8 bit": (255 * IMAGE, IMAGE, "a constant factor of 255"),
    "not normalised": (2 * np.pi * 1.5**2 * BELL, BELL, "not normalised: a constant factor of 14.14"),
    "bell that peaks at 1": (BELL / BELL.max(), BELL, "not normalised: a constant factor of 14.07"),
    "divided by the largest": (IMAGE / IMAGE.max(), IMAGE, "divided by the largest entry: a constant factor of 0."),
    "divided by the sum": (IMAGE / IMAGE.sum(), IMAGE, "divided by the sum of all entries"),
    "N for N - 1": (IMAGE * 7 / 8, IMAGE, "a constant factor of 7/8: divided by N where N - 1 is needed (N = 8)?"),
    "N - 1 for N": (IMAGE * 8 / 7, IMAGE, "a constant factor of 8/7: divided by N - 1 where N is needed (N = 8)?"),
    "shifted right": (np.roll(BELL, 1, axis=1), BELL, "off centre by (dy, dx) = (0, +1) pixels"),
    "shifted up": (np.roll(BELL, -2, axis=0), BELL, "off centre by (dy, dx) = (-2, 0) pixels"),
    "shifted image": (np.pad(IMAGE, ((1, 0), (0, 0), (0, 0)))[:-1], IMAGE, "off centre by (dy, dx) = (+1, 0) pixels"),
    "shifted curve": (np.roll(BELL[7], -1), BELL[7], "shifted by -1 along the axis"),
    "half a pixel": (bell(1.5, 0, 0.5), bell(1.5), "the centre of mass moved by (dy, dx) = (+0.00, +0.50) pixels"),
    "transposed": (SQUARE.T, SQUARE, "transposed: x and y are exchanged"),
    "left-right": (IMAGE[:, ::-1], IMAGE, "flipped left-right"),
    "up-down": (IMAGE[::-1], IMAGE, "flipped up-down"),
    "half turn": (IMAGE[::-1, ::-1], IMAGE, "turned by 180 degrees"),
    "reversed": (IMAGE[0, ::-1, 0], IMAGE[0, :, 0], "in reverse order"),
    "BGR": (IMAGE[..., ::-1], IMAGE, "channels exchanged: BGR came back, RGB is needed"),
    "grey": (IMAGE.mean(-1, keepdims=True).repeat(3, -1), IMAGE, "all channels hold their mean"),
    "border": (in_frame(IMAGE, 3, 0.5 * IMAGE), IMAGE, "right inside, wrong within 3 px of the border"),
    "border of a flat image": (in_frame(np.ones((9, 9)), 1, np.zeros((9, 9))), np.ones((9, 9)), "wrong within 1 px"),
    "not divided by norm": (
        in_frame(25 * IMAGE, 2, 15 * IMAGE),
        IMAGE,
        "not divided by norm (the sum of the weights)?",
    ),
    "one offset short": (
        BELL * ((np.arange(15) > 3)[:, np.newaxis] & (np.arange(17) > 4)),
        BELL,
        "relative error 0.02487, 93 % of the entries are right",
    ),
    "variance for deviation": (IMAGE**2, IMAGE, "the square of what is expected"),
    "deviation for variance": (0.7, 0.49, "the square root of what is expected"),
    "inverse": (1 / IMAGE, IMAGE, "the reciprocal of what is expected"),
    "display values": (tone_map(IMAGE).astype(float), IMAGE, "tone-mapped (sRGB): radiance stays linear"),
    "clipped": (IMAGE.clip(0, 1), IMAGE, "clipped to [0, 1]"),
    "absolute": (np.abs(SQUARE), SQUARE, "the sign is lost"),
    "cut at 0": (SQUARE.clip(0), SQUARE, "values below 0 are cut off"),
    "still zeros": (np.zeros_like(IMAGE), IMAGE, "all entries are 0"),
    "offset": (IMAGE + 0.5, IMAGE, "a constant is added: +0.5 everywhere"),
    "wider, at the border too": (
        blurred(IMPULSE[..., np.newaxis], 2.0, 5)[..., 0],
        BELL,
        "is wider than expected: a standard",
    ),
    "no 2 in 2 sigma^2": (bell(1.5 / np.sqrt(2)), bell(1.5), "the bell is 0.7071 times as wide as it should be"),
    "sigma^2 for sigma": (bell(1.8), bell(1.2), "the bell is 1.5 times as wide"),
    "display gamma": (IMAGE ** (1 / 2.2), IMAGE, "every entry is the expected one to the power 0.4545"),
    "sorted": (np.sort(IMAGE[0, :, 0]), IMAGE[0, :, 0], "the right values in the wrong places"),
    "single precision": (IMAGE.astype(np.float32), IMAGE, "computed in float32, float64 is needed"),
    "inverted mask": (~MASK, MASK, "True and False are exchanged"),
    "one of a mask": (one_by(MASK, (2, 3), ~MASK[2, 3]), MASK, "1 entry of 304 differs; worst entry (2, 3): yours"),
    "flipped mask": (MASK[:, ::-1], MASK, "flipped left-right"),
    "another text": ("lens_v", "lens_u", "yours is the text 'lens_v', expected is the text 'lens_u'"),
    "a number for a text": (3, "lens_u", "yours is the number 3"),
    "another number": (0.25, 0.2, "off by 0.05; yours 0.25, expected 0.2"),
    "something": (IMAGE0 := RNG.normal(size=IMAGE.shape), IMAGE, "relative error 1."),
    "one entry": (
        one_by(IMAGE, (8, 9, 0), 99.0),
        IMAGE,
        "100 % of the entries are right; worst entry (8, 9, 0): yours 99",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_result_gets_the_words_meant_for_it(case):
    received, expected, words = WRONG[case]
    precision = 1e-9 if case == "single precision" else 1e-6
    assert words in finding(received, expected, rtol=precision)


@pytest.mark.parametrize("case", WRONG)
def test_the_expected_result_itself_passes(case):
    expected = WRONG[case][1]
    assert_matches(expected, expected, "the result")
    if isinstance(expected, np.ndarray):
        assert_matches(expected.tolist(), expected, "the result")


def test_the_size_of_an_error_stands_with_the_share_of_right_entries():
    words = finding(one_by(BELL, (7, slice(None)), 0.3), BELL)
    error = np.linalg.norm(0.3 - BELL[7]) / np.linalg.norm(BELL)
    assert (
        f"relative error {error:.4g}, 93 % of the entries are right; worst entry (7, 0): yours 0.3, expected 0" in words
    )


def test_nearly_right_says_how_near():
    words = finding(IMAGE + 1e-7 * RNG.normal(size=IMAGE.shape), IMAGE, rtol=1e-9)
    assert re.search(r"nearly right, up to [0-9.]+e-0[78] of the largest value; worst entry .* yours [0-9.]{9,}", words)


def test_norm_is_not_blamed_where_nothing_is_expected_at_the_border():
    nothing = in_frame(SQUARE, 3, np.zeros_like(SQUARE))
    assert "norm" not in finding(in_frame(2 * SQUARE, 3, 0.01 * np.ones_like(SQUARE)), nothing)
    assert "not divided by norm" in finding(in_frame(2 * SQUARE, 3, SQUARE), SQUARE)


def test_numbers_that_print_alike_are_given_in_full():
    assert "yours 1.000001, expected 1" in finding(1.000001, 1.0, rtol=1e-9)


def test_the_tolerance_is_relative_to_the_largest_value_unless_given():
    assert_matches([1.0, 5e-7], [1.0, 0.0], "values")
    with pytest.raises(Finding):
        assert_matches([1.0, 5e-7], [1.0, 0.0], "values", atol=0.0)
    assert_matches([1.3, 0.2], [1.0, 0.0], "values", atol=0.3 + 1e-9)


def test_nan_where_nan_is_expected_passes_and_elsewhere_does_not():
    expected = np.array([np.nan, 1.0, np.inf])
    assert_matches([np.nan, 1.0, np.inf], expected, "values")
    assert "1 entry of 3 is NaN" in finding([np.nan, np.nan, np.inf], expected)
    assert "worst entry 0: yours 0, expected nan" in finding([0.0, 1.0, np.inf], expected)


def test_an_impulse_in_a_square_of_even_size_is_shifted_not_flipped():
    image = np.zeros((8, 8))
    image[4, 4] = 1.0
    assert "off centre by (dy, dx) = (-1, 0)" in finding(image[::-1], image)


def test_an_impulse_at_the_border_is_shifted_not_wrong_at_the_border():
    image = np.zeros((9, 9))
    image[1, 4] = 1.0
    assert "off centre by (dy, dx) = (+1, 0)" in finding(np.roll(image, 1, axis=0), image)


def test_zero_where_everything_is_zero():
    assert "error 2 where all is 0, 75 % of the entries are right" in finding([0.0, 0.0, 2.0, 0.0], np.zeros(4))


def test_one_number_is_not_called_a_multiple_of_another():
    assert "factor" not in finding(0.37, 0.3)


def test_large_images_are_explained_too():
    image = np.random.default_rng(1).random((200, 150, 3))
    assert "off centre by (dy, dx) = (+3, -2)" in finding(np.roll(image, (3, -2), axis=(0, 1)), image)
    assert "right inside, wrong within 5 px" in finding(in_frame(image, 5, 0 * image), image)
    assert "a constant factor of 1/3" in finding(image / 3, image)


@given(st.integers(-3, 3), st.integers(-3, 3), st.integers(0, 2**32 - 1))
def test_any_shift_of_a_noisy_image_is_named_exactly(dy, dx, seed):
    image = np.random.default_rng(seed).random((11, 13))
    shifted = np.roll(image, (dy, dx), axis=(0, 1))
    if (dy, dx) == (0, 0):
        assert_matches(shifted, image, "the result")
    else:
        signed = ", ".join(f"{d:+d}" if d else "0" for d in (dy, dx))
        assert f"off centre by (dy, dx) = ({signed}) pixels" in finding(shifted, image)


@given(st.floats(-300, 300).filter(lambda factor: abs(factor) > 1e-3 and abs(abs(factor) - 1) > 1e-3))
def test_any_constant_factor_is_called_one(factor):
    assert "a constant factor of " in finding(factor * SQUARE, SQUARE)


@given(st.integers(0, 2**32 - 1))
def test_two_unlike_images_get_numbers_and_no_explanation(seed):
    rng = np.random.default_rng(seed)
    words = finding(rng.random((9, 11, 3)), rng.random((9, 11, 3)))
    assert re.match(r"relative error [0-9.]+, 0 % of the entries are right; worst entry \(\d, \d+, \d\)", words)


MISTAKES = {"squared": np.array([1.0, 4.0]), "the sign is flipped": np.array([-1.0, -2.0]), "one number": 2.0}


@pytest.mark.parametrize(
    ("received", "words"),
    [
        ([1.0, 4.0], r"roots: squared; yours \[1.0, 4.0\], expected \[1.0, 2.0\]."),
        ((-1, -2), r"roots: the sign is flipped; yours \[-1.0, -2.0\]"),
        (np.float64(2), r"roots: one number; yours 2, expected"),
    ],
)
def test_a_usual_mistake_is_named_by_its_numbers(received, words):
    with pytest.raises(Finding, match=words):
        name_mistake(received, np.array([1.0, 2.0]), MISTAKES, "roots")


@pytest.mark.parametrize("received", [[1.0, 2.0], [3.0, 3.0], [1.0], None, "1, 4", [[1], [1, 2]], [None, 1], 1j])
def test_what_is_no_usual_mistake_passes(received):
    """What is right, wrong in another way, or no numbers: the next test says so."""
    name_mistake(received, np.array([1.0, 2.0]), MISTAKES, "roots")


def test_a_mistake_that_happens_to_be_right_is_none():
    name_mistake([0.0, 1.0], np.array([0.0, 1.0]), {"squared": np.array([0.0, 1.0])}, "roots")


def test_nan_can_be_a_mistake_and_many_numbers_are_cut_short():
    with pytest.raises(Finding, match=r"0/0; yours \[nan, nan, nan, \.\.\., nan, nan, nan\], expected"):
        name_mistake(np.full(40, np.nan), np.zeros(40), {"0/0": np.full(40, np.nan)}, "sums")
