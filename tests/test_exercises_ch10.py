"""The exercises of chapter 10 tested themselves: the reference earns every point, each typical mistake is named."""

import ast

import numpy as np
import pytest

from answers import (
    EXERCISES,
    ROOT,
    assert_earns_every_point,
    assert_mistake_is_named,
    failures,
    picture,
    reference,
)
from mcdenoise.filters import gaussian
from mcdenoise.study.capacity import smallest_model

pytestmark = pytest.mark.ch10
NOTEBOOK = ROOT / "notebooks" / "ch10_limits.py"
LENS, LIGHT = ("lens_u", "lens_v"), ("light_u", "light_v")


# --- the chart


def front(beats):
    """The front, from a rule by which (seconds, errors) of others beat that of one point."""

    def function(seconds, errors):
        return np.array([not np.any(beats(seconds, errors, s, e)) for s, e in zip(seconds, errors, strict=True)])

    return function


right_front = front(lambda s, e, a, b: (s <= a) & (e <= b) & ((s < a) | (e < b)))


def swept(rule, order=lambda s, e: np.lexsort((e, s))):
    """The front by one walk along the times: `rule` compares an error with the best so far."""

    def function(seconds, errors):
        on, best = np.zeros(len(seconds), bool), np.inf
        for k in order(seconds, errors):
            if rule(errors[k], best):
                on[k], best = True, errors[k]
        return on

    return function


def swept_with_equals(seconds, errors):
    """Another right idea: a walk that remembers the whole place of the last point of the front."""
    on, last = np.zeros(len(seconds), bool), (-1.0, np.inf)
    for k in np.lexsort((errors, seconds)):
        if errors[k] < last[1] or (seconds[k], errors[k]) == last:
            on[k], last = True, (seconds[k], errors[k])
    return on


def hull(seconds, errors):
    """The corners of the lower left convex hull alone."""
    on = right_front(seconds, errors)
    for k in np.flatnonzero(on):
        for i in np.flatnonzero(on):
            for j in np.flatnonzero(on):
                if seconds[i] < seconds[k] < seconds[j]:
                    share = (seconds[k] - seconds[i]) / (seconds[j] - seconds[i])
                    on[k] &= errors[k] <= errors[i] + share * (errors[j] - errors[i])
    return on


def curve(to=np.log, back=np.exp, to_error=np.log):
    """Monte Carlo's spp by interpolation on some axes, with the right ends."""

    def function(error, spp, mc_errors):
        if error < mc_errors[-1]:
            return spp[-1] * mc_errors[-1] / error
        if error > mc_errors[0]:
            return spp[0] * mc_errors[0] / error
        return back(np.interp(to_error(error), to_error(mc_errors[::-1]), to(spp[::-1])))

    return function


right_spp = curve()


def same(x):
    return x


def inside(change):
    """A right curve between the ends, and something else outside."""

    def function(error, spp, mc_errors):
        found = right_spp(error, spp, mc_errors)
        return found if mc_errors[-1] <= error <= mc_errors[0] else change(error, spp, mc_errors)

    return function


def line_goes_on(error, spp, mc_errors):
    at = slice(-2, None) if error < mc_errors[-1] else slice(0, 2)
    return np.exp(np.polyval(np.polyfit(np.log(mc_errors[at]), np.log(spp[at]), 1), np.log(error)))


def by_polyfit(error, spp, mc_errors):
    return np.exp(np.polyval(np.polyfit(np.log(mc_errors), np.log(spp), 1), np.log(error)))


# --- a method


def tiles(sigma, floor=0.1):
    """Blur the radiance over the albedo, and multiply afterwards; a right idea."""

    def function(radiance, albedo):
        paint = np.maximum(albedo, floor)
        return gaussian(radiance.mean(axis=2) / paint, sigma_space=sigma) * albedo

    return function


def least_squares(radiance, albedo):
    """Another right idea: the light that explains most of the radiance around."""
    above, below = (gaussian(one, sigma_space=1.2) for one in (radiance.mean(axis=2) * albedo, albedo**2))
    return albedo * above / np.maximum(below, 1e-9)


def unsafe(radiance, albedo):
    with np.errstate(all="ignore"):
        return gaussian(np.nan_to_num(radiance.mean(axis=2) / albedo), sigma_space=1.2) * albedo / (albedo > 0)


# --- bias, variance, one pixel


def parts(bias=lambda m, v, n: m - v / n, variance=lambda images, truth: images.var(axis=0, ddof=1)):
    """bias_squared from (squared error of the mean, variance, n), and variance from the images."""

    def function(images, truth):
        right = images.var(axis=0, ddof=1)
        return bias((images.mean(axis=0) - truth) ** 2, right, len(images)), variance(images, truth)

    return function


right_parts = parts()


def by_pairs(images, truth):
    """Another right idea: the mean of the products of different images' errors is the squared bias, without correction."""
    away, n = images - truth, len(images)
    products = away.sum(axis=0) ** 2 - (away**2).sum(axis=0)
    bias_squared = products / (n * (n - 1))
    return bias_squared, (away**2).mean(axis=0) - bias_squared


def bells(size, sigma):
    away = np.arange(size)[:, np.newaxis] - np.arange(size)
    bell = np.exp(-(away**2) / (2 * sigma**2))
    return bell / bell.sum(axis=1, keepdims=True)


def error_of(image, truth, sigma):
    return np.mean((bells(len(image), sigma) @ image @ bells(image.shape[1], sigma).T - truth) ** 2)


def adding(amount):
    """Add light to the middle; `amount` of (error of the filtered image, pixels, sigma, factor)."""

    def function(noisy, truth, sigma_space, factor):
        broken, (height, width) = noisy.copy(), noisy.shape
        broken[height // 2, width // 2] += amount(error_of(noisy, truth, sigma_space), noisy.size, sigma_space, factor)
        return broken

    return function


by_formula = adding(lambda error, pixels, sigma, factor: np.sqrt(1.1 * factor * error * pixels * 4 * np.pi * sigma**2))


def by_bisection(noisy, truth, sigma_space, factor):
    """Another right idea: try."""
    low, high, wanted = 0.0, 1e6, 1.1 * factor * error_of(noisy, truth, sigma_space)
    for _ in range(60):
        broken = noisy.copy()
        broken[3, 4] += (low + high) / 2
        if error_of(broken, truth, sigma_space) < wanted:
            low = (low + high) / 2
        else:
            high = (low + high) / 2
    return broken


def everywhere(noisy, truth, sigma_space, factor):
    return noisy + np.sqrt(1.1 * factor * error_of(noisy, truth, sigma_space))


def spoiling(noisy, truth, sigma_space, factor):
    noisy[5, 5] += 10
    return noisy


# --- groups


def groups_of(cut, inner=np.mean, outer=np.median):
    """The outer statistic of the inner ones of each part of the samples."""

    def function(radiance, groups):
        return outer([inner(radiance[:, :, part], axis=2) for part in cut(radiance.shape[2], groups)], axis=0)

    return function


def in_order(spp, groups):
    return np.array_split(np.arange(spp), groups)


def larger_last(spp, groups):
    return [np.arange(spp * k // groups, spp * (k + 1) // groups) for k in range(groups)]


def left_over(spp, groups):
    return np.arange(spp // groups * groups).reshape(groups, -1)


def of_size(spp, groups):
    return [np.arange(k, min(k + groups, spp)) for k in range(0, spp, groups)]


def middle(side):
    """The lower (0) or the upper (1) one of the middle two."""
    return lambda means, axis: np.sort(means, axis=axis)[(len(means) - 1 + side) // 2]


right_median = groups_of(in_order)


def grey(radiance, groups):
    return np.repeat(right_median(radiance, groups).mean(axis=-1, keepdims=True), 3, axis=-1)


# --- evidence


def p_value(formula):
    """An answer from (how many are at least as good, how many are better, n)."""
    return lambda observed, permuted: formula(
        int(np.sum(permuted >= observed)), int(np.sum(permuted > observed)), len(permuted)
    )


def against(formula, reduce=np.mean):
    """An answer from (squared difference, variance)."""
    return lambda filtered, other, variance: reduce(formula((filtered - other) ** 2, variance))


# exercise, what the student did, the answer, what the message must say
WRONG = (
    ("pareto_front", "the others", lambda *g: ~right_front(*g), "everybody but the front"),
    ("pareto_front", "beaten by itself", front(lambda s, e, a, b: (s <= a) & (e <= b)), "dominate itself"),
    ("pareto_front", "strictly", front(lambda s, e, a, b: (s < a) & (e < b)), "better in one of the two is enough"),
    (
        "pareto_front",
        "sorted",
        lambda s, e: right_front(s, e)[np.argsort(s, kind="stable")],
        "that is the order by time",
    ),
    ("pareto_front", "hull", hull, "convex hull"),
    ("pareto_front", "ends", lambda s, e: right_front(s, e) & ((s == s.min()) | (e == e.min())), "only the fastest"),
    ("pareto_front", "the best", lambda s, e: e * s == (e * s).min(), "only one point"),
    ("pareto_front", "or", front(lambda s, e, a, b: (s < a) | (e < b)), "is on the front"),
    ("pareto_front", "largest", lambda s, e: right_front(-s, -e), "the slowest and most wrong"),
    ("pareto_front", "indices", lambda s, e: np.flatnonzero(right_front(s, e)), "numbers of points came back"),
    ("pareto_front", "first of equals", swept(lambda e, best: e < best), "only the first of two equals"),
    (
        "pareto_front",
        "last of equals",
        swept(lambda e, best: e < best, lambda s, e: np.lexsort((-np.arange(len(s)), e, s))),
        "only the last of two equals",
    ),
    ("pareto_front", "no equals", front(lambda s, e, a, b: ((s <= a) & (e <= b)).sum() > 1), "equals are left out"),
    ("pareto_front", "spoils its input", lambda s, e: (s.sort(), right_front(s, e))[1], "modified its input `s`"),
    ("pareto_front", "returns nothing", lambda s, e: None, "is the `return` missing"),
    ("equal_error_spp", "no logarithms", curve(same, same, same), "a straight line without logarithms"),
    ("equal_error_spp", "log of spp", curve(to_error=same), "that of the error is missing"),
    ("equal_error_spp", "log of error", curve(same, same), "that of spp is missing"),
    ("equal_error_spp", "no exp", curve(back=same), "exp is missing"),
    ("equal_error_spp", "log2", curve(np.log2, same, np.log2), "2 to that power"),
    ("equal_error_spp", "log10", curve(np.log10, same, np.log10), "10 to that power"),
    ("equal_error_spp", "next", lambda e, n, mc: n[np.argmax(mc <= e)], "the next measured spp"),
    ("equal_error_spp", "before", lambda e, n, mc: n[max(np.argmax(mc <= e) - 1, 0)], "the measured spp before"),
    (
        "equal_error_spp",
        "not turned",
        lambda e, n, mc: np.exp(np.interp(np.log(e), np.log(mc), np.log(n))),
        "turn both around",
    ),
    ("equal_error_spp", "one line", by_polyfit, "one line through all points"),
    ("equal_error_spp", "a factor", lambda e, n, mc: right_spp(e, n, mc) / n[0], "how many times as many"),
    ("equal_error_spp", "slope -1", lambda e, n, mc: n[0] * mc[0] / e, "a slope of -1 is taken"),
    ("equal_error_spp", "slope -1 from the end", lambda e, n, mc: n[-1] * mc[-1] / e, "yours 16, expected 8"),
    ("equal_error_spp", "stops", inside(lambda e, n, mc: np.clip(mc[0] * n[0] / e, n[0], n[-1])), "it stops at the"),
    ("equal_error_spp", "line goes on", inside(line_goes_on), "the last line goes on"),
    ("equal_error_spp", "wrong end", inside(lambda e, n, mc: n[0] * mc[0] / e), "the last one is nearer"),
    ("equal_error_spp", "infinite", inside(lambda e, n, mc: np.inf), "infinite: outside"),
    ("equal_error_spp", "NaN", inside(lambda e, n, mc: np.nan), "NaN: outside"),
    ("equal_error_spp", "rounded up", lambda *g: np.ceil(right_spp(*g) - 1e-9), "rounded up"),
    ("equal_error_spp", "rounded", lambda *g: np.round(right_spp(*g)), "rounded: a part"),
    ("equal_error_spp", "spoils its input", lambda e, n, mc: (mc.sort(), 8.0)[1], "modified its input `mc`"),
    ("equal_error_spp", "returns nothing", lambda *g: None, "is the `return` missing"),
    ("break_even_spp", "no noise", 100, "the filter has some noise too"),
    ("break_even_spp", "added", 120, "on which side does each of them stand"),
    ("break_even_spp", "noise is bias", 20, "the filter's own variance is down"),
    ("break_even_spp", "ratio", 5, "how many times less noise"),
    ("break_even_spp", "root", 3.58, "the bias is squared already"),
    ("break_even_spp", "square", 40000, "the bias is squared already"),
    ("break_even_spp", "upside down", 0.0125, "that is 1 / n"),
    ("break_even_spp", "early", 64, "there the filter is better"),
    ("break_even_spp", "late", 90, "there the plain Monte Carlo is better"),
    ("break_even_spp", "words", "80", "one number is needed"),
    ("break_even_spp", "a pair", (80, 100), "one number is needed"),
    ("break_even_spp", "nothing", None, "not answered yet"),
    ("new_method", "nothing", lambda r, a: r.mean(axis=2), "That is the noisy image itself"),
    ("new_method", "Gaussian", lambda r, a: gaussian(r.mean(axis=2), sigma_space=1.2), "where two paints meet"),
    ("new_method", "too narrow", tiles(0.4), "more neighbours make less noise"),
    ("new_method", "sum", lambda r, a: tiles(1.2)(r, a) * r.shape[2], "the mean over the samples missing"),
    ("new_method", "black", unsafe, "where the albedo is 0"),
    ("new_method", "the light alone", lambda r, a: tiles(1.2)(r, np.ones_like(a)), "where two paints meet"),
    ("new_method", "samples", lambda r, a: r, "shape (40, 48, 8, 3) came back"),
    ("new_method", "infinite", lambda r, a: np.where(np.arange(48)[:, None] == 3, np.inf, r.mean(axis=2)), "infinite"),
    ("new_method", "spoils its input", lambda r, a: (r.sort(axis=2), r[:, :, 4])[1], "modified its input `r`"),
    ("new_method", "returns nothing", lambda r, a: None, "is the `return` missing"),
    ("bias_and_variance", "n", parts(variance=lambda i, t: i.var(axis=0)), "so n - 1"),
    ("bias_and_variance", "sum", parts(variance=lambda i, t: 2 * i.var(axis=0, ddof=1)), "not divided by n - 1"),
    (
        "bias_and_variance",
        "of the mean",
        parts(variance=lambda i, t: i.var(axis=0, ddof=1) / 3),
        "variance of the mean",
    ),
    ("bias_and_variance", "deviation", parts(variance=lambda i, t: i.std(axis=0, ddof=1)), "the standard deviation"),
    (
        "bias_and_variance",
        "from the truth",
        parts(variance=lambda i, t: np.mean((i - t) ** 2, axis=0)),
        "from the truth",
    ),
    (
        "bias_and_variance",
        "n - 1",
        parts(variance=lambda i, t: np.sum((i - t) ** 2, axis=0) / 2),
        "and divided by n - 1",
    ),
    ("bias_and_variance", "pixels", parts(variance=lambda i, t: i.var(axis=(1, 2), ddof=1)), "over the pixels of each"),
    ("bias_and_variance", "all", parts(variance=lambda i, t: i.var(ddof=1)), "one number for all images"),
    ("bias_and_variance", "mean", parts(variance=lambda i, t: i.var(axis=0, ddof=1).mean()), "each pixel has its own"),
    ("bias_and_variance", "order", lambda *g: right_parts(*g)[::-1], "the order is bias_squared, variance"),
    ("bias_and_variance", "not corrected", parts(lambda m, v, n: m), "nothing is taken off"),
    ("bias_and_variance", "all of it", parts(lambda m, v, n: m - v), "the whole variance is taken off"),
    ("bias_and_variance", "added", parts(lambda m, v, n: m + v / n), "is added: take it off"),
    ("bias_and_variance", "n - 1 again", parts(lambda m, v, n: m - v / (n - 1)), "divided by n - 1 once more"),
    (
        "bias_and_variance",
        "v by n",
        parts(lambda m, v, n: m - v * (n - 1) / n**2),
        "the variance that was divided by n",
    ),
    ("bias_and_variance", "clipped", parts(lambda m, v, n: np.maximum(m - v / n, 0)), "set to 0 where it is negative"),
    ("bias_and_variance", "size", parts(lambda m, v, n: np.abs(m - v / n)), "its size without the sign"),
    (
        "bias_and_variance",
        "not squared",
        lambda i, t: (i.mean(axis=0) - t, right_parts(i, t)[1]),
        "that is the bias, not",
    ),
    (
        "bias_and_variance",
        "whole error",
        lambda i, t: (np.mean((i - t) ** 2, axis=0), right_parts(i, t)[1]),
        "the whole mean squared error",
    ),
    ("bias_and_variance", "over pixels", parts(lambda m, v, n: np.mean(m - v / n)), "each pixel has its own"),
    ("bias_and_variance", "one result", lambda *g: right_parts(*g)[0], "2 things are needed"),
    ("bias_and_variance", "returns nothing", lambda *g: None, "is the `return` missing"),
    ("one_pixel", "nothing", adding(lambda *g: 0.0), "nothing is changed"),
    ("one_pixel", "everywhere", everywhere, "only one may"),
    ("one_pixel", "linear", adding(lambda e, n, s, f: f * np.sqrt(e)), "at least 50 is needed"),
    ("one_pixel", "huge", adding(lambda *g: 1e6), "find out how much is needed"),
    ("one_pixel", "one pixel's error", adding(lambda e, n, s, f: np.sqrt(1.1 * f * e)), "at least 50 is needed"),
    ("one_pixel", "no bell", adding(lambda e, n, s, f: np.sqrt(1.1 * f * e * n)), "at least 50 is needed"),
    (
        "one_pixel",
        "the bell's height",
        adding(lambda e, n, s, f: np.sqrt(1.1 * f * e * n) * 2 * np.pi * s**2),
        "at most 60 is allowed",
    ),
    (
        "one_pixel",
        "the wrong root",
        adding(lambda e, n, s, f: -np.sqrt(1.1 * f * e * n * 4 * np.pi * s**2)),
        "radiance is not negative",
    ),
    ("one_pixel", "infinite", adding(lambda *g: np.inf), "must be finite"),
    ("one_pixel", "spoils its input", spoiling, "modified its input `noisy`"),
    ("one_pixel", "a number", lambda *g: 3.0, "the image"),
    ("one_pixel", "returns nothing", lambda *g: None, "is the `return` missing"),
    ("median_of_means", "mean", lambda r, g: r.mean(axis=2), "the mean of all samples"),
    ("median_of_means", "median", lambda r, g: np.median(r, axis=2), "the median of all samples"),
    ("median_of_means", "turned", groups_of(in_order, np.median, np.mean), "it is the other way round"),
    ("median_of_means", "mean of means", groups_of(in_order, outer=np.mean), "their median is asked for"),
    ("median_of_means", "sums", groups_of(in_order, np.sum), "the groups' sums"),
    (
        "median_of_means",
        "every third",
        groups_of(lambda spp, groups: [np.arange(k, spp, groups) for k in range(groups)]),
        "in the order of the samples",
    ),
    ("median_of_means", "larger last", groups_of(larger_last), "it comes first"),
    ("median_of_means", "left over", groups_of(left_over), "is left out"),
    ("median_of_means", "size", groups_of(of_size), "there must be three groups"),
    ("median_of_means", "smallest", groups_of(in_order, outer=np.min), "the smallest of the means"),
    ("median_of_means", "largest", groups_of(in_order, outer=np.max), "the largest of the means"),
    ("median_of_means", "grey", grey, "each has a median of its own"),
    ("median_of_means", "lower", groups_of(in_order, outer=middle(0)), "the lower one of the middle two"),
    ("median_of_means", "upper", groups_of(in_order, outer=middle(1)), "the upper one of the middle two"),
    ("median_of_means", "spoils its input", lambda r, g: (r.sort(axis=2), r.mean(axis=2))[1], "modified its input `r`"),
    ("median_of_means", "returns nothing", lambda r, g: None, "is the `return` missing"),
    ("median_limits", "one for the mean", (1, 1, 2, 7, 0), "a single bad sample is enough"),
    ("median_limits", "half of four", (0, 2, 2, 7, 0), "the mean of the middle two: is a bad one among them"),
    ("median_limits", "half of five", (0, 1, 3, 7, 0), "the middle one: is a bad one among them"),
    ("median_limits", "whole groups", (0, 4, 6, 7, 0), "put that many bad samples into as many groups"),
    ("median_limits", "careful", (0, 1, 1, 7, 0), "how many may be spoiled"),
    ("median_limits", "half of sixteen", (0, 1, 2, 8, 0), "16 groups: not 8"),
    ("median_limits", "the mean", (0, 1, 2, 7, 1), "that is the mean, the true value"),
    ("median_limits", "the sample", (0, 1, 2, 7, 16), "that is the sample with the lamp"),
    ("median_limits", "its group", (0, 1, 2, 7, 4), "one of the four means"),
    ("median_limits", "half of it", (0, 1, 2, 7, 2), "write down the four means"),
    ("median_limits", "four numbers", (0, 1, 2, 7), "5 numbers are needed"),
    ("median_limits", "one number", 7, "5 numbers are needed"),
    ("median_limits", "nothing", None, "not answered yet"),
    ("permutation_p_value", "not counted", p_value(lambda k, b, n: k / n), "the observed order is not counted"),
    ("permutation_p_value", "above", p_value(lambda k, b, n: (1 + k) / n), "but not below"),
    ("permutation_p_value", "below", p_value(lambda k, b, n: k / (1 + n)), "but not above"),
    ("permutation_p_value", "better", p_value(lambda k, b, n: (1 + b) / (1 + n)), "those that do exactly as well"),
    ("permutation_p_value", "better of n", p_value(lambda k, b, n: b / n), "the observed order is one of ten"),
    ("permutation_p_value", "worse", p_value(lambda k, b, n: 1 - k / n), "that is the share of those that do worse"),
    ("permutation_p_value", "1 - p", p_value(lambda k, b, n: 1 - (1 + k) / (1 + n)), "that is 1 - p"),
    ("permutation_p_value", "smaller", p_value(lambda k, b, n: (1 + n - b) / (1 + n)), "do worse or as well"),
    ("permutation_p_value", "twice", p_value(lambda k, b, n: 2 * (1 + k) / (1 + n)), "on one side only"),
    ("permutation_p_value", "count", p_value(lambda k, b, n: 1 + k), "a number of orders"),
    ("permutation_p_value", "count of shuffles", p_value(lambda k, b, n: k), "a number of shuffles"),
    ("permutation_p_value", "never", lambda o, x: 0.4 if o == 0.5 else 0.0, "chance can never do it"),
    ("permutation_p_value", "returns nothing", lambda *g: None, "is the `return` missing"),
    ("error_against_other", "no variance", against(lambda d, v: d), "nothing is taken off"),
    ("error_against_other", "added", against(lambda d, v: d + v), "the variance is added"),
    ("error_against_other", "half", against(lambda d, v: d - v / 2), "half of the variance"),
    ("error_against_other", "twice", against(lambda d, v: d - 2 * v), "twice the variance"),
    ("error_against_other", "deviation", against(lambda d, v: d - np.sqrt(v)), "its standard deviation"),
    ("error_against_other", "squared variance", against(lambda d, v: d - v**2), "its square is taken off"),
    ("error_against_other", "root", lambda *g: np.sqrt(abs(against(lambda d, v: d - v)(*g))), "that is the root of it"),
    ("error_against_other", "sum", against(lambda d, v: d - v, np.sum), "the sum over pixels and channels"),
    (
        "error_against_other",
        "channels",
        against(lambda d, v: (d - v).sum(axis=-1)),
        "the sum over the channels",
    ),
    (
        "error_against_other",
        "square of the mean",
        lambda f, o, v: np.mean(f - o) ** 2 - v.mean(),
        "square first, then take the mean",
    ),
    ("error_against_other", "size", lambda f, o, v: np.mean(np.abs(f - o) - v), "its square"),
    ("error_against_other", "divided", against(lambda d, v: d / v), "divided by the variance"),
    ("error_against_other", "a map", against(lambda d, v: d - v, lambda one: one), "a map: one number"),
    ("error_against_other", "clipped", lambda *g: max(0.0, against(lambda d, v: d - v)(*g)), "Do not cut it off"),
    ("error_against_other", "each pixel", against(lambda d, v: np.maximum(d - v, 0)), "each pixel is cut off at 0"),
    ("error_against_other", "its size", lambda *g: abs(against(lambda d, v: d - v)(*g)), "Do not cut it off"),
    ("error_against_other", "spoils its input", lambda f, o, v: (f.__isub__(o), 1.0)[1], "modified its input `f`"),
    ("error_against_other", "returns nothing", lambda *g: None, "is the `return` missing"),
    ("smallest_layout", "the best", (("albedo", *LIGHT, "shading_normal"), 0.0), "a layout with fewer names"),
    ("smallest_layout", "the lens", (("albedo", *LENS, *LIGHT), 3.4), "a layout with fewer names"),
    ("smallest_layout", "by the deviation", (("albedo",), 7.0), "the root of their number"),
    ("smallest_layout", "nothing kept", ((), 299.0), "clearly worse"),
    ("smallest_layout", "unknown", (("albedo", "lens_u"), 3.0), "no such layout"),
    ("smallest_layout", "names alone", ("albedo", "light_u", "light_v"), "a pair is needed"),
    ("smallest_layout", "one text", "albedo", "a pair is needed"),
    ("smallest_layout", "an index", (2, 3.0), "a pair is needed"),
    ("smallest_layout", "no number", (("albedo", *LIGHT), "3 %"), "must be a number"),
    ("smallest_layout", "of itself", (("albedo", *LIGHT), 2.91), "divide by the mean of the best"),
    ("smallest_layout", "whole", (("albedo", *LIGHT), 103.0), "that is the whole error"),
    ("smallest_layout", "factor", (("albedo", *LIGHT), 1.03), "that is a factor"),
    ("smallest_layout", "share", (("albedo", *LIGHT), 0.03), "that is a share"),
    ("smallest_layout", "difference", (("albedo", *LIGHT), 0.3), "that is a difference"),
    ("smallest_layout", "the error of the best", (("albedo", *LIGHT), 3.56), "that is one standard error"),
    ("smallest_layout", "none", (("albedo", *LIGHT), 0), "its mean is smaller"),
    ("smallest_layout", "something", (("albedo", *LIGHT), 12.0), "divide the two means"),
    ("smallest_layout", "nothing", None, "not answered yet"),
)
RIGHT = {
    "pareto_front": right_front,
    "equal_error_spp": right_spp,
    "break_even_spp": 80.0,
    "new_method": tiles(1.0),
    "bias_and_variance": right_parts,
    "one_pixel": by_formula,
    "median_of_means": right_median,
    "median_limits": (0, 1, 2, 7, 0),
    "permutation_p_value": p_value(lambda k, b, n: (1 + k) / (1 + n)),
    "error_against_other": against(lambda d, v: d - v),
    "smallest_layout": (("albedo", *LIGHT), 3.0),
}
OTHER_IDEAS = (
    ("pareto_front", "a walk", swept_with_equals),
    ("pareto_front", "a list", lambda s, e: right_front(s, e).tolist()),
    ("pareto_front", "0 and 1", lambda s, e: right_front(s, e).astype(int)),
    ("equal_error_spp", "another base", curve(np.log10, lambda x: 10**x, np.log10)),
    ("break_even_spp", "a NumPy number", np.float32(80)),
    ("new_method", "least squares", least_squares),
    ("bias_and_variance", "pairs", by_pairs),
    (
        "bias_and_variance",
        "whole error less variance",
        lambda i, t: (np.mean((i - t) ** 2, axis=0) - i.var(axis=0, ddof=1), i.var(axis=0, ddof=1)),
    ),
    ("one_pixel", "by bisection", by_bisection),
    ("median_of_means", "a loop over groups", groups_of(in_order, lambda r, axis: r.sum(axis=axis) / r.shape[axis])),
    ("median_limits", "a list", [0, 1, 2, 7, 0.0]),
    ("error_against_other", "two means", lambda f, o, v: np.mean((o - f) ** 2) - np.mean(v)),
    ("smallest_layout", "in another order", [["light_v", "light_u", "albedo"], 2.97]),
)


@pytest.mark.parametrize("exercise", RIGHT)
def test_a_right_answer_earns_every_point(exercise):
    assert_earns_every_point(exercise, RIGHT[exercise])


@pytest.mark.parametrize(("exercise", "idea", "answer"), OTHER_IDEAS, ids=[f"{e}: {i}" for e, i, _ in OTHER_IDEAS])
def test_every_right_idea_earns_every_point(exercise, idea, answer):
    assert_earns_every_point(exercise, answer)


@pytest.mark.parametrize(("exercise", "mistake", "answer", "words"), WRONG, ids=[f"{e}: {m}" for e, m, *_ in WRONG])
def test_a_public_test_names_the_mistake(exercise, mistake, answer, words):
    assert_mistake_is_named(exercise, mistake, answer, words)


def test_every_exercise_has_a_right_answer_and_wrong_ones():
    names = {name for name, one in EXERCISES.items() if one.chapter == "ch10"}
    assert set(RIGHT) == {exercise for exercise, *_ in WRONG} == names


def test_no_constant_passes_the_hidden_tests():
    """Who returns what the public tests want, and nothing else, fails a hidden one."""
    table = {0.5: 0.4, 0.9: 0.1}
    assert failures("permutation_p_value", lambda observed, permuted: table.get(observed, 0.4), hidden=False) == []
    assert failures("permutation_p_value", lambda observed, permuted: table.get(observed, 0.4), hidden=True)


def test_the_picture_shows_the_wall():
    yours, target = picture("new_method")
    assert yours.shape == target.shape == (40, 48, 3)
    assert np.mean((yours - target) ** 2) < np.mean(target**2) / 20


# --- what the notebook says is what the tests and the library say


def tables(path):
    """The value of LAYOUTS as a file has it."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    (value,) = [
        node.value for node in tree.body if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "LAYOUTS"
    ]
    return ast.literal_eval(value)


def test_the_table_of_layouts_is_that_of_the_tests_and_the_rule_that_of_the_library():
    layouts = tables(NOTEBOOK)
    assert layouts == tables(ROOT / "tests" / "exercises" / "test_ch10.py")
    errors = np.array(list(layouts.values()))
    chosen = smallest_model([len(names) for names in layouts], errors)
    names, percent = reference("smallest_layout")
    assert list(layouts)[chosen] == names
    means = errors.mean(axis=1)
    assert percent == pytest.approx(100 * (means[chosen] / means.min() - 1))


def test_the_break_even_is_where_both_errors_meet():
    n = reference("break_even_spp")
    assert 0.002 + 0.04 / n == pytest.approx(0.2 / n)


def test_the_median_bears_what_is_predicted(rng):
    """The worst places of bad samples, one more in each group: it bears so many and not one more."""
    radiance = rng.random((1, 1, 16, 3))
    for groups, borne in zip((1, 4, 5, 16), reference("median_limits"), strict=False):
        firsts = [part[0] for part in in_order(16, groups)]
        for bad in (borne, borne + 1):
            spoiled = radiance.copy()
            spoiled[:, :, firsts[:bad]] = 1e9
            assert (reference("median_of_means")(spoiled, groups).max() < 1) == (bad == borne)
    lamp = np.zeros((1, 1, 16, 3))
    lamp[:, :, 3] = 16
    assert reference("median_of_means")(lamp, 4).max() == reference("median_limits")[4]


def test_the_damage_of_one_pixel_is_that_of_the_formula():
    """Away from the border, and for bandwidths from a pixel on."""
    for sigma in (1.0, 1.7, 3.0):
        spot = np.zeros((61, 61))
        spot[30, 30] = 7.0
        damage = np.sum(gaussian(spot, sigma_space=sigma, radius=30) ** 2)
        assert damage == pytest.approx(49 / (4 * np.pi * sigma**2), rel=0.002)
