"""Random parameter filtering: samples in, image out (chapters 05 and 06)."""

from mcdenoise.rpf.config import RPFConfig, preset_table
from mcdenoise.rpf.dependency import Dependency, dependency, dependency_of, mutual_information
from mcdenoise.rpf.passes import rpf

__all__ = ["Dependency", "RPFConfig", "dependency", "dependency_of", "mutual_information", "preset_table", "rpf"]
