"""Chapter 09: primary features, what the filter compares: pixel means of colour and features, and how noisy they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mcdenoise.filters import gaussian, noise_variance
from mcdenoise.filters.prefilter import prefilter_feature
from mcdenoise.filters.window import with_channels
from mcdenoise.lbf.despike import despike
from mcdenoise.samples import SampleBuffer, half_means, pixel_mean, variance_of_mean
from mcdenoise.samples.gate import check_float_array, check_names

GROUPS = ("world_position", "shading_normal", "albedo", "albedo_2", "visibility")
KEPT_BY_GROUP = ("raw", "features", "variances")


@dataclass(frozen=True, eq=False)
class Primary:
    """What the filter compares; build it with `primary_features`. All arrays float32.

    Attributes
    ----------
    colour : (h, w, 3), pixel mean of radiance
    colour_variance : (h, w, 3), of that mean, without spikes
    raw : group -> (h, w, channels), pixel means
    features : group -> (h, w, channels), prefiltered
    variances : group -> (h, w, channels), what is left of their variance: psi^2 in the paper
    spp : samples per pixel

    Examples
    --------
    >>> grey, spot = np.ones((1, 1, 3), np.float32), {"visibility": np.ones((1, 1, 1), np.float32)}
    >>> Primary(grey, 0 * grey, raw=spot, features=spot, variances=spot, spp=4).groups
    ('visibility',)
    """

    colour: np.ndarray
    colour_variance: np.ndarray
    raw: Mapping[str, np.ndarray]
    features: Mapping[str, np.ndarray]
    variances: Mapping[str, np.ndarray]
    spp: int

    @property
    def groups(self) -> tuple[str, ...]:
        """Names of the groups, in the order of `GROUPS`."""
        return tuple(group for group in GROUPS if group in self.raw)

    def select(self, groups: Sequence[str]) -> Primary:
        """Keep only the named groups.

        Raises
        ------
        ValueError
            For a group that is not there.

        Examples
        --------
        >>> grey, spot = np.ones((1, 1, 3), np.float32), {"albedo": np.ones((1, 1, 3), np.float32)}
        >>> Primary(grey, 0 * grey, raw=spot, features=spot, variances=spot, spp=4).select([]).groups
        ()
        """
        chosen = check_names(groups, self.groups, "groups")
        kept = {name: {group: getattr(self, name)[group] for group in chosen} for name in KEPT_BY_GROUP}
        return replace(self, **kept)


def primary_features(samples: SampleBuffer, groups: Sequence[str] | None = None) -> Primary:
    """Pixel means of colour and features; features prefiltered by NL-means; variances of all.

    World positions have no natural unit, but the filter compares every variance with the same floor (1e-4). So they are
    counted from the middle of the scene, and in units of its size: see `scene_frame`.

    Parameters
    ----------
    samples : SampleBuffer.
    groups : names out of `GROUPS`; default: those that the samples have. None at all is allowed.

    Returns
    -------
    Primary

    Raises
    ------
    ValueError
        For samples that are no SampleBuffer; for a group that the samples lack, that is none of `GROUPS`, or that is
        named twice.

    References
    ----------
    Kalantari, Bako and Sen, "A machine learning approach for filtering Monte Carlo noise", TOG 34(4), 2015,
    https://doi.org/10.1145/2766977, and the authors' code; the unit of world positions is ours.

    Examples
    --------
    >>> corner = np.stack(np.meshgrid(np.arange(3), np.arange(2)), axis=-1)[:, :, np.newaxis]
    >>> albedo = np.full((2, 3, 1, 3), 0.5)
    >>> samples = SampleBuffer.from_arrays(np.ones((2, 3, 1, 3)), corner + 0.5, features={"albedo": albedo})
    >>> primary = primary_features(samples)
    >>> primary.groups, primary.features["albedo"].shape, float(primary.colour_variance.max())
    (('albedo',), (2, 3, 3), 0.0)
    """
    if not isinstance(samples, SampleBuffer):
        raise ValueError(
            f"samples must be a SampleBuffer, got {type(samples).__name__}. Build one with SampleBuffer.from_arrays or "
            f"mcd.capture."
        )
    available = [group for group in GROUPS if group in samples.feature_names]
    chosen = available if groups is None else check_names(groups, available, "groups")
    raw, features, variances = {}, {}, {}
    for group in [group for group in GROUPS if group in chosen]:
        values = np.ascontiguousarray(samples[group])  # a view of every feature's samples would be slow to sum
        if group == "world_position":
            centre, size = scene_frame(values, samples.hit)
            values = (values - centre) / size
        mean, variance = with_channels(pixel_mean(values)), with_channels(two_buffer_variance(values))
        raw[group] = mean
        features[group], variances[group] = prefilter_feature(mean, variance)
    noise = despike(two_buffer_variance(samples.radiance), radius=27, deviations=10, together=True)
    return Primary(pixel_mean(samples.radiance), noise, raw, features, variances, samples.spp)


def two_buffer_variance(samples: np.ndarray) -> np.ndarray:
    """Variance of the pixel means, from the spread of samples and corrected by the difference of two halves.

    variance = sample_var * box(buffer_var) / (box(sample_var) + 1e-10),   buffer_var = (half_b - half_a)^2 / 4

    with sample_var the `variance_of_mean`, half_a and half_b the `half_means`, and box the mean over 21 x 21 pixels,
    clipped at borders. The spread of samples tells pixels apart but takes samples to be independent; halves see what they
    have in common (strata make buffer_var smaller), but from a single difference. With an odd spp the halves lack the
    last sample: buffer_var is scaled by (spp - 1) / spp, to the variance of the mean of all. With 1 spp there is neither:
    then `noise_variance` with radius 1, the spread between neighbours.

    Parameters
    ----------
    samples : (h, w, spp) or (h, w, spp, c), such as ``buffer.radiance``.

    Returns
    -------
    (h, w) or (h, w, c), >= 0, same dtype, in the unit of the samples squared; 0 for constant samples.

    Raises
    ------
    ValueError
        As `pixel_mean`, and for variances above 1e30.

    Examples
    --------
    >>> two_buffer_variance(np.array([[[1.0, 3.0]]])).round(4)
    array([[1.]])
    """
    samples = check_float_array(samples, "samples")
    if samples.ndim in (3, 4) and samples.shape[2] == 1:
        return noise_variance(samples, radius=1)
    sample_var = variance_of_mean(samples)
    half_a, half_b = half_means(samples)
    spp = samples.shape[2]
    buffer_var = (half_b - half_a) ** 2 * (0.25 * (spp - spp % 2) / spp)
    both = np.concatenate([with_channels(buffer_var), with_channels(sample_var)], axis=-1)
    buffer_box, sample_box = np.split(gaussian(both, sigma_space=np.inf, radius=10), 2, axis=-1)
    return sample_var * (buffer_box / (sample_box + 1e-10)).reshape(sample_var.shape)


def scene_frame(world_position: np.ndarray, hit: np.ndarray) -> tuple[np.ndarray, np.float32]:
    """Middle and size of the scene as the camera sees it, neither moved by a few distant points.

    centre = median of the pixel means, each component for itself; size = median of their distances to it

    over the pixels all of whose samples hit a surface (over all pixels where there is none such: a miss has no position).

    Parameters
    ----------
    world_position : (h, w, spp, 3), scene units. hit : (h, w, spp) bool.

    Returns
    -------
    centre, size : (3,) and one number, float32, scene units; size is 1 where it would be 0.

    Examples
    --------
    >>> position = np.zeros((1, 3, 1, 3), np.float32)
    >>> position[0, :, 0, 0] = [1, 3, 7]
    >>> scene_frame(position, np.ones((1, 3, 1), bool))
    (array([3., 0., 0.], dtype=float32), np.float32(2.0))
    """
    points, seen = pixel_mean(world_position), hit.all(axis=2)
    points = points[seen] if seen.any() else points.reshape(-1, 3)
    centre = np.median(points, axis=0)
    size = np.median(np.linalg.norm(points - centre, axis=-1))
    return centre, size if size > 0 else np.float32(1)
