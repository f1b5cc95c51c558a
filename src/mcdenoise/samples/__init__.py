"""Ground floor: the samples of a render, their layout, statistics, checks and storage (chapter 01)."""

from mcdenoise.samples.buffer import SampleBuffer
from mcdenoise.samples.layout import Field, Layout
from mcdenoise.samples.statistics import half_means, pixel_mean, sample_variance, variance_of_mean
from mcdenoise.samples.storage import load_samples

__all__ = [
    "Field",
    "Layout",
    "SampleBuffer",
    "half_means",
    "load_samples",
    "pixel_mean",
    "sample_variance",
    "variance_of_mean",
]
