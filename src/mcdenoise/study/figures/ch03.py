"""The figures of chapter 03, the bilateral filter, in the order of the lecture."""

from mcdenoise.study.figures._ch03_guide import differences, firefly, guide
from mcdenoise.study.figures._ch03_limits import error_map, limits, slider_radiance, slider_space
from mcdenoise.study.figures._ch03_museum import museum
from mcdenoise.study.figures._ch03_scenes import against_gaussian, cut, scenes, window_weights
from mcdenoise.study.figures._ch03_toys import halo, kernels, outlier, staircase, weights

FIGURES = {
    "kernels": kernels,
    "weights": weights,
    "window_weights": window_weights,
    "against_gaussian": against_gaussian,
    "cut": cut,
    "scenes": scenes,
    "slider_radiance": slider_radiance,
    "slider_space": slider_space,
    "limits": limits,
    "error_map": error_map,
    "staircase": staircase,
    "halo": halo,
    "differences": differences,
    "guide": guide,
    "outlier": outlier,
    "firefly": firefly,
    "museum": museum,
}
