"""The figures of chapter 05, statistical dependency, in the order of the lecture."""

from mcdenoise.study.figures._ch05_bias import bias, pairs, spp, widths
from mcdenoise.study.figures._ch05_information import bins, correlation, joint, worked
from mcdenoise.study.figures._ch05_limits import amount, cost, fails, second_hits
from mcdenoise.study.figures._ch05_maps import (
    lens_and_light,
    shares_features,
    shares_of_features,
    shares_radiance,
    slider_box,
)
from mcdenoise.study.figures._ch05_neighbourhood import (
    matrix_blurred,
    matrix_focus,
    panels_blurred,
    panels_focus,
    slider_place,
    variance_twins,
)

FIGURES = {
    "lens_and_light": lens_and_light,
    "variance_twins": variance_twins,
    "panels_focus": panels_focus,
    "panels_blurred": panels_blurred,
    "bins": bins,
    "worked": worked,
    "correlation": correlation,
    "joint": joint,
    "slider_place": slider_place,
    "bias": bias,
    "widths": widths,
    "pairs": pairs,
    "matrix_focus": matrix_focus,
    "matrix_blurred": matrix_blurred,
    "shares_radiance": shares_radiance,
    "shares_features": shares_features,
    "shares_of_features": shares_of_features,
    "second_hits": second_hits,
    "slider_box": slider_box,
    "spp": spp,
    "amount": amount,
    "fails": fails,
    "cost": cost,
}
