"""Random parameter filtering: samples in, image out (chapters 05 and 06)."""

from mcdenoise.rpf.analysis import Neighbourhood, RPFAnalysis, rpf_analysis, rpf_neighbourhood
from mcdenoise.rpf.config import RPFConfig, preset_table
from mcdenoise.rpf.dependency import Dependency, dependency, dependency_of, mutual_information
from mcdenoise.rpf.passes import rpf

__all__ = [
    "Dependency",
    "Neighbourhood",
    "RPFAnalysis",
    "RPFConfig",
    "dependency",
    "dependency_of",
    "mutual_information",
    "preset_table",
    "rpf",
    "rpf_analysis",
    "rpf_neighbourhood",
]
