"""Learning-based filtering: a small network sets the dials of a filter, pixel by pixel (chapter 09)."""

from mcdenoise.lbf.denoise import LBFAnalysis, lbf, lbf_analysis
from mcdenoise.lbf.layer import FilterLayer
from mcdenoise.lbf.model import LBFModel
from mcdenoise.lbf.primary import Primary, primary_features
from mcdenoise.lbf.secondary import secondary_features, secondary_names
from mcdenoise.lbf.storage import load_model, save_model, shipped_model

__all__ = [
    "FilterLayer",
    "LBFAnalysis",
    "LBFModel",
    "Primary",
    "lbf",
    "lbf_analysis",
    "load_model",
    "primary_features",
    "save_model",
    "secondary_features",
    "secondary_names",
    "shipped_model",
]
