"""The figures of chapter 09, learning-based filtering, in the order of the lecture."""

from mcdenoise.study.figures._ch09_features import prefilter, secondary
from mcdenoise.study.figures._ch09_filter import chain, first_look, slider_gamma, weights_of_one_pixel
from mcdenoise.study.figures._ch09_gradient import gradient_check
from mcdenoise.study.figures._ch09_limits import despike, limits
from mcdenoise.study.figures._ch09_oracle import oracle
from mcdenoise.study.figures._ch09_pixel import covariance, terms
from mcdenoise.study.figures._ch09_results import methods, results, slider_spp, theta_maps
from mcdenoise.study.figures._ch09_training import (
    capacity,
    capacity_sizes,
    slider_learning,
    training,
    training_scenes,
    trials,
)

FIGURES = {
    "first_look": first_look,
    "chain": chain,
    "weights_of_one_pixel": weights_of_one_pixel,
    "slider_gamma": slider_gamma,
    "oracle": oracle,
    "prefilter": prefilter,
    "secondary": secondary,
    "covariance": covariance,
    "terms": terms,
    "gradient_check": gradient_check,
    "training_scenes": training_scenes,
    "training": training,
    "slider_learning": slider_learning,
    "capacity_sizes": capacity_sizes,
    "capacity": capacity,
    "results": results,
    "theta_maps": theta_maps,
    "methods": methods,
    "slider_spp": slider_spp,
    "despike": despike,
    "limits": limits,
    "trials": trials,
}
