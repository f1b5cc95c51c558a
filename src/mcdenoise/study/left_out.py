"""An error without a reference: filter most of the samples, judge by those left out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from mcdenoise.samples import SampleBuffer, pixel_mean, sample_variance
from mcdenoise.samples.gate import check_count
from mcdenoise.study.tune import error_scale

PARTS = 4


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Samples cut into parts; each part judges what a filter makes of the others.

    For the filtered rest F and the mean B of a part, E |F - B|^2 = E |F - truth|^2 + variance of B, because their samples are
    independent; the last term is the same for all filters. Parts instead of halves, because a filter of half the samples is
    not yet the filter of all of them: of four parts, it sees three quarters.

    Attributes
    ----------
    rests : for each part, a buffer of all other samples
    means : for each part, its pixel mean, (h, w, 3)
    scales : denominators of relative errors, from a blurred mean of the rest: it must not know the part
    noise : (h, w), what of `error_map` is noise of the parts, on average

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(32), np.arange(32)), axis=-1)[:, :, np.newaxis]
    >>> position = corner + rng.random((32, 32, 8, 2))
    >>> samples = SampleBuffer.from_arrays(1 + 0.4 * rng.standard_normal((32, 32, 8, 3)), position)
    >>> left_out = LeftOut.of(samples)
    >>> means = [pixel_mean(rest.radiance) for rest in left_out.rests]
    >>> round(float((left_out.error_map(means) - left_out.noise).mean()), 2), round(0.4**2 / 6, 2)  # 6 spp filtered
    (0.03, 0.03)
    """

    rests: tuple[SampleBuffer, ...]
    means: tuple[np.ndarray, ...]
    scales: tuple[np.ndarray, ...]
    noise: np.ndarray

    @classmethod
    def of(cls, samples: SampleBuffer, parts: int = PARTS) -> LeftOut:
        """Cut samples into parts, as many as there are samples a pixel if that is less.

        Raises
        ------
        ValueError
            For 1 spp, which cannot be cut, and for less than 2 parts.
        """
        if samples.spp < 2:
            raise ValueError(f"At least 2 spp are needed, to filter some and judge by the others, got {samples.spp}.")
        number = min(check_count(parts, "parts", least=2), samples.spp)
        cuts = np.linspace(0, samples.spp, number + 1).round().astype(int).tolist()
        spans = list(pairwise(cuts))
        rests = tuple(samples.without(*span) for span in spans)
        means = tuple(pixel_mean(samples.radiance[:, :, first:last]) for first, last in spans)
        scales = tuple(error_scale(pixel_mean(rest.radiance)) for rest in rests)
        variance = sample_variance(samples.radiance)
        noise = [variance / (last - first) / scale for (first, last), scale in zip(spans, scales, strict=True)]
        return cls(rests, means, scales, _mean(noise))

    def part_error(self, part: int, filtered: np.ndarray) -> np.ndarray:
        """Relative squared error of one filtered rest against the part left out, noise included: (h, w), float64."""
        return _mean([(filtered - self.means[part]) ** 2 / self.scales[part]])

    def error_map(self, filtered: Sequence[np.ndarray]) -> np.ndarray:
        """Mean of `part_error` over all parts, (h, w)."""
        return np.mean([self.part_error(part, image) for part, image in enumerate(filtered)], axis=0)

    def error_of(self, run: Callable[[SampleBuffer], np.ndarray]) -> np.ndarray:
        """`error_map` of what `run` makes of each rest."""
        return self.error_map([run(rest) for rest in self.rests])


def _mean(maps: Sequence[np.ndarray]) -> np.ndarray:
    """Mean over maps and channels, (h, w)."""
    return np.mean([one.mean(axis=-1, dtype=np.float64) for one in maps], axis=0)
