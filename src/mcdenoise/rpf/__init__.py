"""Random parameter filtering: samples in, image out. So far: what depends on what (chapter 05)."""

from mcdenoise.rpf.dependency import Dependency, dependency, dependency_of, mutual_information

__all__ = ["Dependency", "dependency", "dependency_of", "mutual_information"]
