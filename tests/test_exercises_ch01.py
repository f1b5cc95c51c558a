"""The tests of the exercises of chapter 01: the reference passes all; each typical slip fails a public one, in fitting words."""

import numpy as np
import pytest

import mcdenoise as mcd
from answers import failures, picture, reference

pytestmark = pytest.mark.ch01


@pytest.mark.parametrize(("name", "shape"), [("variance_of_mean", (32, 48)), ("refocus", (12, 40, 3))])
def test_picture_of_the_reference_is_the_target(name, shape):
    yours, target = picture(name)
    assert yours.shape == target.shape == shape
    np.testing.assert_allclose(yours, target, rtol=1e-9)


def test_references_agree_with_the_package(rng):
    samples = rng.random((3, 4, 5, 3))
    np.testing.assert_allclose(reference("variance_of_mean")(samples), mcd.variance_of_mean(samples))
    image, target = rng.random((2, 5, 6, 3))
    assert reference("relmse")(image, target, 0.01) == pytest.approx(mcd.relmse(image, target))


def changes_samples(samples):
    samples -= samples.mean(axis=2, keepdims=True)
    return (samples**2).sum(axis=2) / (samples.shape[2] - 1) / samples.shape[2]


def first_channel(samples):
    return (samples.var(axis=2, ddof=1) / samples.shape[2])[..., :1]


def repeated_channel(samples):
    return 0 * samples[:, :, 0] + first_channel(samples)


VARIANCE = {
    "of the samples": (lambda s: s.var(axis=2, ddof=1), "spp times less"),
    "of the samples, N": (lambda s: s.var(axis=2), "divided by spp where spp - 1 is needed"),
    "N for N - 1": (lambda s: s.var(axis=2) / s.shape[2], "spp - 1 is needed (ddof=1)"),
    "N - 1 twice": (lambda s: s.var(axis=2, ddof=1) / (s.shape[2] - 1), "spp - 1 twice"),
    "of the sum": (lambda s: s.var(axis=2, ddof=1) * s.shape[2], "of the sum of the samples"),
    "root": (lambda s: np.sqrt(s.var(axis=2, ddof=1) / s.shape[2]), "standard deviation of the mean"),
    "std of samples": (lambda s: s.std(axis=2, ddof=1), "standard deviation of the samples"),
    "squares summed": (lambda s: s.var(axis=2) * s.shape[2], "summed, not averaged"),
    "mean": (lambda s: s.mean(axis=2), "mean of the samples"),
    "over channels": (lambda s: s.var(axis=3) / s.shape[2], "(4, 5, 7)"),
    "over rows": (lambda s: s.var(axis=0) / s.shape[2], "(4, 5, 3)"),
    "over everything": (lambda s: s.var(ddof=1) / s.shape[2], "(4, 5, 3)"),
    "spp kept": (
        lambda s: s.var(axis=2, ddof=1, keepdims=True) / s.shape[2],
        "an axis of length 1 too many (keepdims?)",
    ),
    "rows for spp": (lambda s: s.var(axis=2, ddof=1) / len(s), "divided by the number of rows"),
    "one channel": (first_channel, "(4, 5, 3)"),
    "one channel for all": (repeated_channel, "worst entry"),
    "second moment": (lambda s: (s**2).mean(axis=2) / s.shape[2], "worst entry"),
    "changes its input": (changes_samples, "modified its input `samples`"),
    "nothing returned": (lambda s: None, "None"),
}
RELMSE = {
    "mse": (lambda i, r, e: np.mean((i - r) ** 2), "mean squared error"),
    "sum": (lambda i, r, e: np.sum((i - r) ** 2 / (r**2 + e)), "summed"),
    "root": (lambda i, r, e: np.sqrt(np.mean((i - r) ** 2 / (r**2 + e))), "square root"),
    "epsilon outside": (lambda i, r, e: np.mean((i - r) ** 2 / r**2 + e), "it belongs to reference², inside"),
    "no epsilon": (lambda i, r, e: np.mean((i - r) ** 2 / r**2), "epsilon is left out"),
    "epsilon squared": (lambda i, r, e: np.mean((i - r) ** 2 / (r**2 + e**2)), "epsilon is squared"),
    "ratio of means": (lambda i, r, e: np.mean((i - r) ** 2) / np.mean(r**2 + e), "pixel by pixel"),
    "image below": (lambda i, r, e: np.mean((i - r) ** 2 / (i**2 + e)), "the reference's is needed"),
    "no square below": (lambda i, r, e: np.mean((i - r) ** 2 / (r + e)), "without its square"),
    "no square above": (lambda i, r, e: np.mean(np.abs(i - r) / (r**2 + e)), "the difference is not squared"),
    "signed": (lambda i, r, e: np.mean((i - r) / (r**2 + e)), "off by"),
    "fixed epsilon": (lambda i, r, e: np.mean((i - r) ** 2 / (r**2 + 0.01)), "off by"),
    "sum over channels": (
        lambda i, r, e: np.mean(np.sum((i - r) ** 2 / (r**2 + e), axis=2)),
        "summed over channels",
    ),
    "a map": (lambda i, r, e: (i - r) ** 2 / (r**2 + e), "average over pixels and channels"),
    "nothing returned": (lambda i, r, e: None, "None"),
}
SLOPE = {
    "sign": (lambda d, f, a, k: 2 * a * k * (1 - f / d), "the sign"),
    "radius for diameter": (lambda d, f, a, k: a * k * (f / d - 1), "half of what is expected"),
    "scene units": (lambda d, f, a, k: 2 * a * (f / d - 1), "multiply by pixels_per_unit"),
    "scene units, radius": (lambda d, f, a, k: a * (f / d - 1), "and half"),
    "absolute": (lambda d, f, a, k: 2 * a * k * np.abs(f / d - 1), "an absolute value"),
    "not divided": (lambda d, f, a, k: 2 * a * k * (f - d), "not divided by depth"),
    "divided by focus": (lambda d, f, a, k: 2 * a * k * (f - d) / f, "divided by focus_distance"),
    "no - 1": (lambda d, f, a, k: 2 * a * k * f / d, "the slope of a point in focus"),
    "upside down": (lambda d, f, a, k: 2 * a * k * (d / f - 1), "the sign"),
    "one depth": (lambda d, f, a, k: 2 * a * k * (f / np.mean(d) - 1), "(6,)"),
    "nothing returned": (lambda d, f, a, k: None, "None"),
}


def shear(light_field, slope, *, centre=0.5, sign=1, scale=None, whole=False, wrap=False):
    n_u, n_x, channels = light_field.shape
    x, row = np.arange(n_x), np.zeros((n_x, channels))
    for k in range(n_u):
        place = x + sign * slope * ((k + 0.5) / n_u - centre)
        place = np.rint(place) if whole else place
        for c in range(channels):
            values = light_field[k, :, c]
            row[:, c] += np.interp(place, x, values, period=n_x if wrap else None)
    return row / (n_u if scale is None else scale)


REFOCUS = {
    "wrong way": ({"sign": -1}, "shifted the wrong way"),
    "off centre": ({"centre": 0.0}, "off centre"),
    "summed": ({"scale": 1}, "summed over u"),
    "whole columns": ({"whole": True}, "worst entry"),
    "wraps around": ({"wrap": True}, "worst entry"),
}
FUNCTIONS = [
    *(("variance_of_mean", slip, *case) for slip, case in VARIANCE.items()),
    *(("relmse", slip, *case) for slip, case in RELMSE.items()),
    *(("light_field_slope", slip, *case) for slip, case in SLOPE.items()),
    *(
        ("refocus", slip, lambda field, slope, changes=changes: shear(field, slope, **changes), words)
        for slip, (changes, words) in REFOCUS.items()
    ),
    ("refocus", "mean over u", lambda field, slope: field.mean(axis=0), "nothing is shifted"),
    ("refocus", "mean over x", lambda field, slope: field.mean(axis=1), "averaged over x"),
    ("refocus", "middle row", lambda field, slope: field[len(field) // 2], "only the middle row"),
    ("refocus", "grey", lambda field, slope: shear(field, slope).mean(axis=1), "(9, 3)"),
    ("refocus", "nothing returned", lambda field, slope: None, "return"),
    ("firefly", "constant", lambda u: np.ones_like(u), "do not vary at all"),
    ("firefly", "mild", lambda u: 2 * u, "in 0 % of the pixels"),
    ("firefly", "not rare enough", lambda u: np.where(u < 0.02, 50.0, 0.0), "90 % are asked for"),
    ("firefly", "mean not 1", lambda u: np.where(u < 0.001, 500.0, 0.0), "yours is 0.5"),
    ("firefly", "negative", lambda u: np.where(u < 0.001, 2000.0, -1.0), "never negative"),
    ("firefly", "one number", lambda u: 1000.0, "shape (200000,) is needed"),
    ("firefly", "by place", lambda u: np.where(np.arange(len(u)) % 1000 == 0, 1000.0, 0.0), "its own u alone"),
    (
        "firefly",
        "knows the test",
        lambda u: 2000.0 * (np.arange(u.size) < 100) * (u.size == 200_000),
        "its own u alone",
    ),
    ("firefly", "by its own mean", lambda u: (u < 0.001) / np.mean(u < 0.001), "that must be a fixed number"),
    ("firefly", "infinite", lambda u: np.where(u < 0.001, np.inf, 0.0), "NaN or infinite"),
    ("firefly", "nothing returned", lambda u: None, "return"),
]


@pytest.mark.parametrize(("name", "slip", "answer", "words"), FUNCTIONS, ids=lambda value: str(value)[:24])
def test_slips_fail_a_public_test_in_fitting_words(name, slip, answer, words):
    messages = failures(name, answer, hidden=False)
    assert any(words in message for message in messages), messages


def test_the_shear_above_is_right_without_a_slip():
    assert failures("refocus", shear, hidden=False) == failures("refocus", shear, hidden=True) == []


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("spp_needed", (32, 64), "exchanged"),
        ("spp_needed", (32, 32), "that halves the variance"),
        ("spp_needed", (256, 32), "quarters the RMS error"),
        ("spp_needed", (64, 64), "a squared error already"),
        ("spp_needed", (64, 256), "falls as 1 / N"),
        ("spp_needed", (8, 32), "more than the 16 spp at hand"),
        ("spp_needed", (48, 32), "is not at 48 spp"),
        ("spp_needed", 64, "two numbers"),
        ("spp_needed", "many", "does not fit the question"),
        ("spp_needed", None, "not answered yet"),
        ("crossing_samples", [[31.0, 0.9, 4.0], [33.0, 0.1, 4.0]], "parallel"),
        ("crossing_samples", [[31.0, 0.1, 8.0], [33.0, 0.1, 4.0]], "cross at u = -0.07"),
        ("crossing_samples", [[31.0, 0.5, 8.0], [33.0, 0.5, 8.1]], "not on the lens"),
        ("crossing_samples", [[31.0, 0.1, 4.0], [36.0, 0.9, 8.0]], "at most 3 are allowed"),
        ("crossing_samples", [[31.0, 1.4, 4.0], [32.0, 0.9, 8.0]], "u lies between 0 and 1"),
        ("crossing_samples", [[31.0, 0.4, -4.0], [32.0, 0.9, 8.0]], "depths are above 0"),
        ("crossing_samples", [31.0, 0.4, 4.0], "shape (2, 3) is needed"),
        ("crossing_samples", None, "not answered yet"),
    ],
)
def test_wrong_values_get_a_hint(name, value, words):
    messages = failures(name, value, hidden=False)
    assert any(words in message for message in messages), messages


@pytest.mark.parametrize("value", [(64, 32), [64, 32], np.array([64.0, 32.0])])
def test_right_predictions_pass_in_any_form(value):
    assert failures("spp_needed", value, hidden=False) == []


@pytest.mark.parametrize("value", [[[31, 0.5, 8], [31.5, 0.5, 4]], ((50, 0.0, 9.0), (51, 0.0, 4.5))])
def test_crossing_samples_of_other_places(value):
    messages = failures("crossing_samples", value, hidden=False)
    slopes = [2 * 0.22 * 39.5 * (5.3 / depth - 1) for _, _, depth in value]
    starts = [x - slope * u for (x, u, _), slope in zip(value, slopes, strict=True)]
    crosses = 0 < (starts[0] - starts[1]) / (slopes[1] - slopes[0]) < 1
    assert (messages == []) is crosses


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        (
            "variance_of_mean",
            lambda s: s.var(axis=2, ddof=1) / s.shape[2] if s.shape[0] < 5 else s.var(axis=2) / s.shape[2],
        ),
        ("relmse", lambda i, r, e: np.mean((i - r) ** 2 / (r**2 + max(e, 0.01)))),
        ("light_field_slope", lambda d, f, a, k: 2 * a * k * (np.minimum(f / d, 2.65) - 1) if f != 6.1 else 0 * d),
        ("refocus", lambda field, slope: shear(field, slope) if field.shape[2] == 3 else shear(field, -slope)),
        ("firefly", lambda u: reference("firefly")(u) if len(u) > 1 else u[0]),
        ("firefly", lambda u: 2000.0 * ((u < 5e-4) & (np.abs(200_000 * u % 1 - 0.5) < 1e-6))),
    ],
)
def test_answers_made_for_the_public_tests_fail_a_hidden_one(name, answer):
    assert failures(name, answer, hidden=False) == []
    assert failures(name, answer, hidden=True) != []


def test_an_absolute_slope_is_named_by_the_hidden_test_too():
    messages = failures("light_field_slope", lambda d, f, a, k: 2 * a * k * np.abs(f / d - 1), hidden=True)
    assert len(messages) == 1
    assert "an absolute value" in messages[0]
