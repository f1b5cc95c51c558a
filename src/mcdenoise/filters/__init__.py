"""Filters: image in, image out. Each contains the one before it as a limit."""

from mcdenoise.filters.albedo import safe_albedo
from mcdenoise.filters.bilateral import bilateral
from mcdenoise.filters.cross_bilateral import cross_bilateral
from mcdenoise.filters.gaussian import gaussian
from mcdenoise.filters.joint_nlm import joint_nlm
from mcdenoise.filters.nlm import nlm
from mcdenoise.filters.prefilter import noise_variance, prefilter_features

__all__ = [
    "bilateral",
    "cross_bilateral",
    "gaussian",
    "joint_nlm",
    "nlm",
    "noise_variance",
    "prefilter_features",
    "safe_albedo",
]
