"""The figures of chapter 06, random parameter filtering, in the order of the lecture."""

from mcdenoise.study.figures._ch06_adaptive import errors, gain, methods
from mcdenoise.study.figures._ch06_draws import fraction, seeds
from mcdenoise.study.figures._ch06_limits import columns, lamps
from mcdenoise.study.figures._ch06_maps import alpha_beta, idea, shares
from mcdenoise.study.figures._ch06_neighbourhood import (
    choose,
    panels_blurred,
    panels_focus,
    screen_weights,
    slider_beta,
)
from mcdenoise.study.figures._ch06_results import ablation, corners, first_look, other_scenes, passes
from mcdenoise.study.figures._ch06_switches import presets, slider_sigma, spikes, switches

FIGURES = {
    "first_look": first_look,
    "choose": choose,
    "panels_focus": panels_focus,
    "panels_blurred": panels_blurred,
    "shares": shares,
    "alpha_beta": alpha_beta,
    "slider_beta": slider_beta,
    "screen_weights": screen_weights,
    "spikes": spikes,
    "passes": passes,
    "corners": corners,
    "ablation": ablation,
    "presets": presets,
    "switches": switches,
    "slider_sigma": slider_sigma,
    "lamps": lamps,
    "columns": columns,
    "fraction": fraction,
    "seeds": seeds,
    "idea": idea,
    "gain": gain,
    "other_scenes": other_scenes,
    "methods": methods,
    "errors": errors,
}
