"""mcdenoise: a course and reference implementation of Monte Carlo render denoising.

The front door: ``import mcdenoise as mcd``. Mitsuba, numba, matplotlib and scikit-image are loaded when first needed.

>>> import mcdenoise as mcd
>>> noisy = [[0.0, 1.0, 0.0, 1.0]]
>>> mcd.gaussian(noisy, sigma_space=10.0, engine="numpy").round(1)
array([[0.5, 0.5, 0.5, 0.5]])
"""

from importlib import import_module

from mcdenoise import nn
from mcdenoise.filters import (
    bilateral,
    cross_bilateral,
    gaussian,
    joint_nlm,
    nlm,
    noise_variance,
    prefilter_features,
    safe_albedo,
)
from mcdenoise.lbf import (
    FilterLayer,
    LBFAnalysis,
    LBFModel,
    Primary,
    lbf,
    lbf_analysis,
    load_model,
    primary_features,
    secondary_features,
    secondary_names,
)
from mcdenoise.metrics import mse, psnr, relmse, relmse_map, squared_error_map, ssim
from mcdenoise.render import capture, read_exr, render_image, render_reference, scene_names, write_exr
from mcdenoise.rpf import (
    Dependency,
    Neighbourhood,
    RPFAnalysis,
    RPFConfig,
    dependency,
    dependency_of,
    mutual_information,
    rpf,
    rpf_analysis,
    rpf_neighbourhood,
)
from mcdenoise.samples import (
    SampleBuffer,
    half_means,
    load_samples,
    pixel_mean,
    sample_variance,
    variance_of_mean,
)

__all__ = [
    "Dependency",
    "FilterLayer",
    "LBFAnalysis",
    "LBFModel",
    "Neighbourhood",
    "Primary",
    "RPFAnalysis",
    "RPFConfig",
    "SampleBuffer",
    "bilateral",
    "capture",
    "check",
    "cross_bilateral",
    "dependency",
    "dependency_of",
    "draw_graph",
    "gaussian",
    "half_means",
    "joint_nlm",
    "lbf",
    "lbf_analysis",
    "load_model",
    "load_samples",
    "mse",
    "mutual_information",
    "nlm",
    "nn",
    "noise_variance",
    "pixel_mean",
    "prefilter_features",
    "primary_features",
    "psnr",
    "read_exr",
    "relmse",
    "relmse_map",
    "render_image",
    "render_reference",
    "rpf",
    "rpf_analysis",
    "rpf_neighbourhood",
    "safe_albedo",
    "sample_variance",
    "scene_names",
    "secondary_features",
    "secondary_names",
    "show_decision",
    "show_difference",
    "show_images",
    "show_neurons",
    "slider",
    "squared_error_map",
    "ssim",
    "variance_of_mean",
    "write_exr",
]

# What draws or checks is loaded when first asked for: matplotlib takes a second.
_LOADED_LATER = {
    "check": "mcdenoise.classroom.checking.check",
    "draw_graph": "mcdenoise.study.graph",
    "show_decision": "mcdenoise.study.neurons",
    "show_difference": "mcdenoise.study.show",
    "show_images": "mcdenoise.study.show",
    "show_neurons": "mcdenoise.study.neurons",
    "slider": "mcdenoise.study.slider",
}


def __getattr__(name: str) -> object:
    """Load one of the names that need heavy libraries."""
    if name in _LOADED_LATER:
        return getattr(import_module(_LOADED_LATER[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
