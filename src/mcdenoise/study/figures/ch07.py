"""The figures of chapter 07, the perceptron, in the order of the lecture."""

from mcdenoise.study.figures._ch07_classifiers import answers, geometry, one_dimension
from mcdenoise.study.figures._ch07_curves import slider_steps, step_gradient
from mcdenoise.study.figures._ch07_features import gates, perceptron_features, polynomial, xor_network
from mcdenoise.study.figures._ch07_history import timeline
from mcdenoise.study.figures._ch07_layers import checker_by_hand, polygons, regions
from mcdenoise.study.figures._ch07_rule import bound, never_stops, slider_rule
from mcdenoise.study.figures._ch07_trained import (
    coordinates,
    four_sets,
    neurons_checker,
    neurons_moons,
    overfit,
    slider_hidden,
)

FIGURES = {
    "timeline": timeline,
    "answers": answers,
    "one_dimension": one_dimension,
    "geometry": geometry,
    "slider_rule": slider_rule,
    "bound": bound,
    "gates": gates,
    "polynomial": polynomial,
    "perceptron_features": perceptron_features,
    "xor_network": xor_network,
    "regions": regions,
    "polygons": polygons,
    "checker_by_hand": checker_by_hand,
    "neurons_moons": neurons_moons,
    "neurons_checker": neurons_checker,
    "four_sets": four_sets,
    "coordinates": coordinates,
    "slider_hidden": slider_hidden,
    "slider_steps": slider_steps,
    "step_gradient": step_gradient,
    "never_stops": never_stops,
    "overfit": overfit,
}
