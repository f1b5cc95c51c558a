"""What likeness is judged by: features with their bandwidths and, where they are noisy, their variances."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from mcdenoise.filters.window import check_range, with_channels
from mcdenoise.samples.buffer import SampleBuffer
from mcdenoise.samples.gate import check_bandwidth, check_names, check_same_size
from mcdenoise.samples.statistics import pixel_mean

RADIANCE = "radiance"  # the name under which `variances` may hold the variance of the image itself


class Guide(NamedTuple):
    """One quantity that likeness is judged by.

    Examples
    --------
    >>> Guide(np.zeros((2, 3, 1)), sigma=0.1).variance is None
    True
    """

    values: np.ndarray  # (h, w, c)
    sigma: float  # bandwidth, unit of the values
    variance: np.ndarray | None = None  # (h, w, c), unit of the values squared; None: free of noise


def check_guides(
    features: object, sigma_features: object, variances: object, image: np.ndarray, own: tuple[str, ...] = ()
) -> list[Guide]:
    """Bring features, bandwidths and variances together, one Guide a feature.

    Parameters
    ----------
    features : name -> array (h, w) or (h, w, c); or a SampleBuffer, of which pixel means are taken.
    sigma_features : name -> bandwidth; for a mapping of features it must name each of them.
    variances : name -> variance of a feature, (h, w) or as the feature; None, or a name left out: no noise.
    image : what is filtered; all must have its height and width.
    own : names that `variances` may hold beside those of features.

    Raises
    ------
    ValueError
        For anything that does not fit together; the message says what is missing.

    Examples
    --------
    >>> (guide,) = check_guides({"depth": np.ones((2, 3))}, {"depth": 0.5}, None, np.ones((2, 3)))
    >>> guide.values.shape, guide.sigma
    ((2, 3, 1), 0.5)
    """
    if not isinstance(sigma_features, Mapping):
        raise ValueError(
            f"sigma_features must be a mapping from name to bandwidth, got {sigma_features!r}. "
            f"Write sigma_features={{'albedo': 0.1}}."
        )
    if isinstance(features, SampleBuffer):
        names = check_names(sigma_features, features.feature_names, "sigma_features")
        features = {name: pixel_mean(features[name]) for name in names}
    elif isinstance(features, Mapping):
        names = check_names(sigma_features, tuple(features), "sigma_features")
        if missing := [name for name in features if name not in names]:
            raise ValueError(
                f"sigma_features must give a bandwidth for every feature, got none for "
                f"{', '.join(map(repr, missing))}. Give one (infinity ignores the feature) or leave the feature out."
            )
    else:
        raise ValueError(
            f"features must be a mapping from name to array or a SampleBuffer, got {type(features).__name__}. "
            f"Write features={{'albedo': array}}."
        )
    variances = check_variances(variances, (*names, *own))
    guides = []
    for name in names:
        feature = check_same_size(check_range(features[name], f"features[{name!r}]"), f"features[{name!r}]", image)
        sigma = check_bandwidth(sigma_features[name], f"sigma_features[{name!r}]")
        variance = None
        if name in variances:
            variance = check_variance(variances[name], f"variances[{name!r}]", feature)
        guides.append(Guide(with_channels(feature), sigma, variance))
    return guides


def check_variances(variances: object, known: tuple[str, ...]) -> Mapping[str, object]:
    """Return `variances` as a mapping whose names are all in `known`; None gives an empty one.

    Raises
    ------
    ValueError
        For something else than a mapping, or a name that is not known.

    Examples
    --------
    >>> check_variances(None, ())
    {}
    """
    if variances is None:
        return {}
    if not isinstance(variances, Mapping):
        raise ValueError(
            f"variances must be a mapping from name to variance, got {type(variances).__name__}. "
            f"Write variances={{'albedo': array}}."
        )
    check_names(variances, known, "variances")
    return variances


def check_variance(variance: object, name: str, image: np.ndarray) -> np.ndarray:
    """Return a variance as an array (h, w, c) that fits `image` (h, w) or (h, w, c): finite, nowhere negative.

    Parameters
    ----------
    variance : one number for the whole image, (h, w) for all channels alike, or an array of the shape of `image`.
    name : what to call it in a message.

    Raises
    ------
    ValueError
        For another shape, NaN, infinity, magnitudes above 1e30, or values below 0.

    Examples
    --------
    >>> check_variance(0.5, "variance", np.ones((2, 3, 3))).shape
    (2, 3, 3)
    """
    shape = with_channels(image).shape
    if np.ndim(variance) == 0:
        variance = np.full(image.shape[:2], _number(variance, name))
    variance = with_channels(check_same_size(check_range(variance, name), name, image))
    if variance.shape[2] not in (1, shape[2]):
        raise ValueError(
            f"{name} must have shape (h, w) or that of what it belongs to, {image.shape}, got {variance.shape}."
        )
    if (least := float(variance.min())) < 0:
        raise ValueError(f"{name} must not be negative anywhere, got {least:g}. Is it a standard deviation or a mean?")
    return np.broadcast_to(variance, shape)


def _number(variance: object, name: str) -> float:
    """Return one number as a float; text, None and the like are refused."""
    if isinstance(variance, (bool, np.bool_)) or not isinstance(variance, (int, float, np.integer, np.floating)):
        raise ValueError(
            f"{name} must be a number or an array (h, w) or (h, w, c), got {variance!r}. "
            f"Take mcd.noise_variance(samples.radiance)."
        )
    return float(variance)
