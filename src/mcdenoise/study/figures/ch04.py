"""The figures of chapter 04, features and patches, in the order of the lecture."""

from mcdenoise.study.figures._ch04_dials import k_patch, search
from mcdenoise.study.figures._ch04_features import (
    features,
    five_errors,
    five_scenes,
    more_features,
    slider_share,
    window_weights,
)
from mcdenoise.study.figures._ch04_groups import demodulation, groups
from mcdenoise.study.figures._ch04_methods import left_over, methods
from mcdenoise.study.figures._ch04_noise import feature_noise_maps, focus, variance_limits
from mcdenoise.study.figures._ch04_patches import expected_difference, firefly, pixel_patch, variances_matter
from mcdenoise.study.figures._ch04_prefilter import gains, prefilter

FIGURES = {
    "features": features,
    "more_features": more_features,
    "window_weights": window_weights,
    "five_scenes": five_scenes,
    "five_errors": five_errors,
    "slider_share": slider_share,
    "feature_noise": feature_noise_maps,
    "focus": focus,
    "variance_limits": variance_limits,
    "prefilter": prefilter,
    "gains": gains,
    "groups": groups,
    "demodulation": demodulation,
    "pixel_patch": pixel_patch,
    "expected_difference": expected_difference,
    "variances_matter": variances_matter,
    "firefly": firefly,
    "k_patch": k_patch,
    "search": search,
    "methods": methods,
    "left_over": left_over,
}
