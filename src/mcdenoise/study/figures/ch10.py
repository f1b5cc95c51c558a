"""The figures of chapter 10, speed, stability, and no more model than a scene needs, in the order of the lecture.

Most are made from what `mcdenoise study all` left in lectures/studies.
"""

from mcdenoise.study.figures._ch10_evidence import left_out, paired, permutation
from mcdenoise.study.figures._ch10_failures import (
    catalogue,
    chart_bias,
    chart_times,
    noise_breakdown,
    slider_features,
    slider_light,
    slider_range,
    slider_samples,
)
from mcdenoise.study.figures._ch10_front import chart_budget, chart_pooled, chart_scenes, reading
from mcdenoise.study.figures._ch10_needs import (
    chart_boxes,
    chart_dropping,
    chart_information,
    chart_simplest,
)
from mcdenoise.study.figures._ch10_price import price
from mcdenoise.study.figures._ch10_robust import fireflies, median
from mcdenoise.study.figures._ch10_together import together
from mcdenoise.study.figures._ch10_worth import break_even, chart_growth, equal_error, slopes, slopes_scenes

FIGURES = {
    "reading": reading,
    "pooled": chart_pooled,
    "scenes": chart_scenes,
    "budget": chart_budget,
    "equal_error": equal_error,
    "price": price,
    "slopes": slopes,
    "slopes_scenes": slopes_scenes,
    "break_even": break_even,
    "growth": chart_growth,
    "catalogue": catalogue,
    "slider_samples": slider_samples,
    "fireflies": fireflies,
    "median": median,
    "breakdown": noise_breakdown,
    "slider_range": slider_range,
    "slider_features": slider_features,
    "slider_light": slider_light,
    "bias": chart_bias,
    "times": chart_times,
    "permutation": permutation,
    "information": chart_information,
    "left_out": left_out,
    "dropping": chart_dropping,
    "boxes": chart_boxes,
    "paired": paired,
    "simplest": chart_simplest,
    "together": together,
}
