"""Filters: image in, image out. Each contains the one before it as a limit."""

from mcdenoise.filters.bilateral import bilateral
from mcdenoise.filters.cross_bilateral import cross_bilateral
from mcdenoise.filters.gaussian import gaussian

__all__ = ["bilateral", "cross_bilateral", "gaussian"]
