"""mcdenoise: a course and reference implementation of Monte Carlo render denoising.

The front door: ``import mcdenoise as mcd``. Mitsuba, numba, matplotlib and scikit-image are loaded when first needed.

>>> import mcdenoise as mcd
>>> noisy = [[0.0, 1.0, 0.0, 1.0]]
>>> mcd.gaussian(noisy, sigma_space=10.0, engine="numpy").round(1)
array([[0.5, 0.5, 0.5, 0.5]])
"""

from mcdenoise.filters import bilateral, cross_bilateral, gaussian
from mcdenoise.metrics import mse, psnr, relmse, relmse_map, squared_error_map, ssim
from mcdenoise.render import capture, read_exr, render_image, render_reference, scene_names, write_exr
from mcdenoise.samples import (
    SampleBuffer,
    half_means,
    load_samples,
    pixel_mean,
    sample_variance,
    variance_of_mean,
)

__all__ = [
    "SampleBuffer",
    "bilateral",
    "capture",
    "cross_bilateral",
    "gaussian",
    "half_means",
    "load_samples",
    "mse",
    "pixel_mean",
    "psnr",
    "read_exr",
    "relmse",
    "relmse_map",
    "render_image",
    "render_reference",
    "sample_variance",
    "scene_names",
    "squared_error_map",
    "ssim",
    "variance_of_mean",
    "write_exr",
]
