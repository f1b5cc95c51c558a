"""The catalogue of failures: one entry a failure, the one source for the study, its tests, the tables and the lecture."""

from __future__ import annotations

from mcdenoise.study import stability_troubles as troubles
from mcdenoise.study.stability_measures import (
    added_error,
    against_unfiltered,
    largest_change,
    off_the_truth,
    outside,
    relative_change,
    relative_rms,
    rise,
    unequal_scale,
)
from mcdenoise.study.stability_run import Case
from mcdenoise.study.stability_special import BANDWIDTHS, ENGINES, THREADS, bandwidth_limits, engines, threads

NOT_WORSE = "relMSE at most that of the unfiltered image, at every seed (up to 0.1 %)."
RATIO = "relMSE / unfiltered"
NEAR_ONE = 1.001  # a filter that does nothing has 1, and rounding


def _spp(levels: tuple[int, ...]) -> tuple[str, ...]:
    """Labels of levels that are samples a pixel."""
    return tuple(f"{spp} spp" for spp in levels)


def _not_worse(title: str, varied: str, levels: tuple[str, ...], expected: str, make, **more) -> Case:
    """An entry whose guarantee is that filtering does no harm."""
    return Case(title, varied, levels, expected, NOT_WORSE, RATIO, NEAR_ONE, make, against_unfiltered, **more)


CATALOGUE = {
    "firefly_count": Case(
        "Fireflies: how many",
        "pixels with one sample of 1e4: one in the image, 1000 and 20 000 per megapixel",
        ("one", "1000 / Mpx", "20000 / Mpx"),
        "A pixel without a firefly does not notice.",
        "Among the pixels without a firefly, relMSE is at most that of the unfiltered image.",
        RATIO,
        NEAR_ONE,
        troubles.many_fireflies,
        against_unfiltered,
    ),
    "firefly_value": Case(
        "Fireflies: how bright",
        "radiance of one sample in one pixel",
        tuple(f"{value:g}" for value in troubles.FIREFLY_VALUES),
        "The damage to other pixels is bounded, however bright the firefly.",
        "No other pixel changes by more than 2, twice white: at worst it gets back its own noise.",
        "largest change of another pixel",
        2.0,
        troubles.bright_firefly,
        largest_change,
        base=troubles.plain_samples,
    ),
    "nonfinite": Case(
        "NaN and infinite samples",
        "what stands in one sample of 1 % of the pixels",
        ("NaN and infinity",),
        'The gate refuses them in words; with nonfinite="zero" the image is finite and near the one without them.',
        "relMSE rises by at most 0.001: a pixel that lacks one sample of 8 errs by (1/8)^2, twice for exponential noise, "
        "in 1 % of the pixels.",
        "rise of relMSE",
        1e-3,
        troubles.nonfinite,
        rise,
        base=troubles.plain_samples,
    ),
    "few_spp": _not_worse(
        "Very few samples", "samples a pixel", _spp(troubles.SPP), "No statistics, but no harm.", troubles.few_spp
    ),
    "black": Case(
        "Black beside bright",
        "radiance of the dark half; the features know where it is",
        tuple(f"{value:g}" for value in troubles.BLACK),
        "No light leaks into the dark, where the relative error counts it most.",
        "In the dark half relMSE grows by at most 0.01: where it is black, a leak of 1 % of white.",
        "relMSE added",
        1e-2,
        troubles.black,
        added_error,
    ),
    "scale": Case(
        "The whole image darker or brighter",
        "factor of every sample",
        tuple(f"{value:g}" for value in troubles.SCALES),
        "F(s c) = s F(c): the unit of radiance is arbitrary.",
        "The largest deviation is at most 0.1 % of the brightest pixel.",
        "deviation from s F(c)",
        1e-3,
        troubles.scaled,
        unequal_scale,
        base=troubles.plain_samples,
    ),
    "high_range": _not_worse(
        "High dynamic range in one image",
        "decades from the darkest to the brightest of eight bands, unknown to features",
        tuple(f"{value} decades" for value in troubles.DECADES),
        "Bright bands do not drown the dark ones beside them.",
        troubles.high_range,
    ),
    "faint": Case(
        "At the end of float32",
        "factor of every sample",
        tuple(f"{value:g}" for value in troubles.FAINT),
        "Still a filter, and not slower: below 1e-38 numbers are denormal.",
        "An image, and its squared error at most that of the unfiltered one.",
        "MSE / unfiltered",
        NEAR_ONE,
        troubles.faint,
        relative_rms,
    ),
    "flat": Case(
        "One value everywhere",
        "the value, in every sample",
        tuple(f"{value:g}" for value in troubles.FLAT),
        "Constant in, constant out.",
        "No pixel is off by more than 1e-5 of it: rounding of float32 sums over a window.",
        "relative error",
        1e-5,
        troubles.flat,
        off_the_truth,
    ),
    "noise_free": Case(
        "Edges without noise",
        "samples a pixel",
        ("1 spp", "8 spp"),
        "What has no noise is left alone.",
        "relMSE at most 0.001, an error of 3 %.",
        "relMSE",
        1e-3,
        troubles.noise_free,
        added_error,
    ),
    "texture": _not_worse(
        "Texture at the scale of pixels",
        "side of the squares of a chequered albedo",
        tuple(f"{side} px" for side in troubles.SQUARES),
        "Features know the texture, so it stays.",
        troubles.texture,
    ),
    "noisy_features": _not_worse(
        "Noisy features: defocus",
        "samples a pixel (dof, the ball in front of the plane of focus)",
        _spp(troubles.TOY_SPP),
        "Features as noisy as the radiance do not mislead.",
        troubles.toy_scene("defocus"),
    ),
    "missing_features": _not_worse(
        "No features, or features that say nothing",
        "features of the room",
        ("none", "constant", "noise"),
        "Worse than with features, but no harm.",
        troubles.missing_features,
    ),
    "constant_feature": Case(
        "A constant feature",
        "features of one point against no features",
        ("constant",),
        "What does not vary says nothing, and changes nothing.",
        "No pixel changes by more than 1e-5 of the brightest.",
        "largest change",
        1e-5,
        troubles.constant_feature,
        relative_change,
        base=troubles.without_features,
    ),
    "misleading_features": _not_worse(
        "Misleading features",
        "stripes of 4 pixels, in the features alone or in the radiance alone",
        ("albedo edges", "radiance edges"),
        "Edges of features alone keep some noise; edges of radiance alone are not blurred beyond use.",
        troubles.misleading,
    ),
    "second_hit": _not_worse(
        "Noise in the second hit",
        "samples a pixel (glossy: metal balls)",
        _spp(troubles.TOY_SPP),
        "What is seen in a mirror is noisy while the first hit is not.",
        troubles.toy_scene("second_hit"),
    ),
    "penumbra": _not_worse(
        "Penumbrae",
        "samples a pixel (soft_shadow)",
        _spp(troubles.TOY_SPP),
        "A wide shadow edge that no surface feature knows is smoothed and not moved.",
        troubles.toy_scene("penumbra"),
    ),
    "bokeh": _not_worse(
        "Bokeh of tiny lamps",
        "samples a pixel (dof, lamps out of focus)",
        _spp(troubles.TOY_SPP),
        "Few bright samples make a disc: neither fireflies nor lost.",
        troubles.toy_scene("bokeh"),
    ),
    "correlated": _not_worse(
        "Samples that repeat",
        "different samples among the 8 of a pixel",
        tuple(f"{count} of 8" for count in troubles.DISTINCT),
        "The noise looks smaller than it is: less is filtered, but no harm is done.",
        troubles.correlated,
    ),
    "mutual_information": _not_worse(
        "Too few samples for mutual information",
        "samples a pixel; the random parameters explain nothing, the stripes are known to no feature",
        _spp(troubles.UNEXPLAINED_SPP),
        "Chance looks like dependency when samples are few: edges must not be taken for noise.",
        troubles.unexplained,
    ),
    "bandwidths": Case(
        "Bandwidths at their ends",
        "the bandwidth",
        BANDWIDTHS,
        "0 is refused in words; infinity switches the term off, and the filter before comes out.",
        "Refused, or for methods that set their own: the input comes back; at infinity equal to the limit within 1e-4 of the "
        "brightest pixel.",
        "deviation",
        1e-4,
        special=bandwidth_limits,
    ),
    "small_image": Case(
        "Images smaller than the window",
        "rows x columns",
        tuple(f"{h} x {w}" for h, w in troubles.SIZES),
        "Windows are clipped.",
        "Within the range of the unfiltered pixels, up to 1e-5 of the brightest.",
        "outside of the range",
        1e-5,
        troubles.small_image,
        outside,
    ),
    "engines": Case(
        "float32 against float64",
        "what is filtered",
        ENGINES,
        "The kernel (float32) and the formula as it reads (float64) agree.",
        "The largest difference is at most 1e-3 of the brightest pixel.",
        "difference",
        1e-3,
        special=engines,
    ),
    "threads": Case(
        "1 against 2 threads",
        "what is filtered",
        THREADS,
        "Identical bits.",
        "No bit differs.",
        "differing values",
        0.0,
        special=threads,
    ),
    "noise_level": _not_worse(
        "Noise until it breaks",
        "standard deviation of a sample, as a share of the truth",
        tuple(f"{value:g}" for value in troubles.NOISE_LEVELS),
        "Harm where there is next to no noise (bias), and where there is nothing but noise: between them a filter helps.",
        troubles.noise_level,
    ),
}
