"""Chapter 09: secondary features, what the network sees: how noisy, how bright, how uneven each group is around a pixel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mcdenoise.filters import gaussian
from mcdenoise.filters.prefilter import prefilter_feature
from mcdenoise.filters.window import window_offsets
from mcdenoise.lbf.despike import sums_around, window_count
from mcdenoise.lbf.mad import by_plane, mad
from mcdenoise.lbf.primary import GROUPS, Primary
from mcdenoise.samples.gate import check_names

COLOUR = "colour"  # no group of the filter's distances; what the network may see besides
SEEN = (*GROUPS, COLOUR)
KINDS = ("mad", "mean", "std", "mean 7x7", "std 7x7", "deviation 3x3", "gradient")


def secondary_names(groups: Sequence[str]) -> list[str]:
    """Names of the secondary features in the order of the network's inputs.

    Parameters
    ----------
    groups : names out of `GROUPS`; whatever their order, the result has that of `GROUPS`.

    Returns
    -------
    7 len(groups) + 1 names: each kind for each group, and the sampling rate before the gradients.

    Raises
    ------
    ValueError
        For a name that is no group, or one named twice.

    Examples
    --------
    >>> secondary_names(["albedo"])  # doctest: +NORMALIZE_WHITESPACE
    ['mad albedo', 'mean albedo', 'std albedo', 'mean 7x7 albedo', 'std 7x7 albedo', 'deviation 3x3 albedo',
     'sampling rate', 'gradient albedo']
    """
    chosen = check_names(groups, SEEN, "groups")
    ordered = [group for group in SEEN if group in chosen]
    names = [f"{kind} {group}" for kind in KINDS for group in ordered]
    return [*names[: 6 * len(ordered)], "sampling rate", *names[6 * len(ordered) :]]


def secondary_features(primary: Primary, colour: bool = False) -> np.ndarray:
    """What the network sees of each pixel; each number is computed for every channel, then averaged over its group.

    | kind | of | definition |
    |---|---|---|
    | mad | raw | `mad`: noise from the median of Haar coefficients |
    | mean, std | prefiltered | the value; the square root of its variance |
    | mean 7x7, std 7x7 | prefiltered | of the window clipped at borders, divisor n - 1 |
    | deviation 3x3 | prefiltered | mean of abs(f_j - mean), window clipped |
    | sampling rate | | 1 / spp |
    | gradient | prefiltered | (gx^2 + gy^2) / 2 of 3 x 3 differences |

    Parameters
    ----------
    primary : from `primary_features`.

    Returns
    -------
    (h, w, 7 len(primary.groups) + 1) float32, columns as `secondary_names(primary.groups)`; not yet normalised.

    Raises
    ------
    ValueError
        For anything but a Primary.

    References
    ----------
    Kalantari, Bako and Sen 2015, https://doi.org/10.1145/2766977, and the authors' code. With five groups 36 numbers.

    Examples
    --------
    >>> flat = {"visibility": np.ones((2, 3, 1), np.float32)}
    >>> none = {"visibility": np.zeros((2, 3, 1), np.float32)}
    >>> grey = np.ones((2, 3, 3), np.float32)
    >>> secondary_features(Primary(grey, 0 * grey, raw=flat, features=flat, variances=none, spp=4))[0, 0]
    array([0.  , 1.  , 0.  , 1.  , 0.  , 0.  , 0.25, 0.  ], dtype=float32)
    """
    if not isinstance(primary, Primary):
        raise ValueError(
            f"primary must be a Primary, got {type(primary).__name__}. Pass primary_features(samples), not the samples."
        )
    groups, kinds = primary.groups, [primary.raw, primary.features, primary.variances]
    if colour:
        groups, kinds = (
            (*groups, COLOUR),
            [{**one, COLOUR: own} for one, own in zip(kinds, colour_group(primary), strict=True)],
        )
    rate = np.full((*primary.colour.shape[:2], 1), 1 / primary.spp, np.float32)
    if not groups:
        return rate
    widths = [kinds[0][group].shape[-1] for group in groups]
    raw, features, variances = (_side_by_side(one, groups) for one in kinds)
    around = (mean_7x7(features), std_7x7(features), deviation_3x3(features))
    kinds = [
        _group_mean(kind, widths) for kind in (mad(raw), features, np.sqrt(variances), *around, gradient(features))
    ]
    return np.concatenate([*kinds[:-1], rate, kinds[-1]], axis=-1)


def colour_group(primary: Primary) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Colour as one more group for the network to see: log(1 + c), raw and prefiltered, and the variance that is left.

    The paper's network knows nothing of the colour it is to filter: not how noisy it is, not where a shadow begins.
    The logarithm keeps a lamp from drowning the rest.

    Returns
    -------
    raw, filtered, variance : each (h, w, 3), float32

    Examples
    --------
    >>> grey = np.ones((1, 1, 3), np.float32)
    >>> colour_group(Primary(grey, 0 * grey, {}, {}, {}, spp=4))[0].round(3)
    array([[[0.693, 0.693, 0.693]]], dtype=float32)
    """
    bright = np.maximum(primary.colour, 0)
    raw = np.log1p(bright)
    return raw, *prefilter_feature(raw, primary.colour_variance / (1 + bright) ** 2)


def mean_7x7(image: np.ndarray) -> np.ndarray:
    """Mean of the 7 x 7 window, clipped at borders; (h, w, c) in, the same shape out, float32.

    Examples
    --------
    >>> mean_7x7(np.array([[[1.0], [3.0]]]))[..., 0]
    array([[2., 2.]], dtype=float32)
    """
    return gaussian(image.astype(np.float32), sigma_space=np.inf, radius=3)


def std_7x7(image: np.ndarray) -> np.ndarray:
    """Standard deviation of the 7 x 7 window, clipped at borders, divisor n - 1; 0 where the window is one pixel.

    (h, w, c) in, the same shape out, float32.

    Examples
    --------
    >>> std_7x7(np.array([[[1.0], [3.0]]])).round(4)[..., 0]
    array([[1.4142, 1.4142]], dtype=float32)
    """
    return by_plane(_std_plane, image)


def deviation_3x3(image: np.ndarray) -> np.ndarray:
    """Mean distance of the pixels of the 3 x 3 window from their mean, clipped at borders: mean of abs(f_j - mean).

    (h, w, c) in, the same shape out, float32.

    Examples
    --------
    >>> deviation_3x3(np.array([[[1.0], [3.0]]]))[..., 0]
    array([[1., 1.]], dtype=float32)
    """
    return by_plane(_deviation_plane, image)


def gradient(image: np.ndarray) -> np.ndarray:
    """Steepness: (gx^2 + gy^2) / 2, with gx the right minus the left column of 3 x 3 pixels, over 9; gy likewise.

    A ramp of slope s a pixel along x gives (2 s / 3)^2 / 2. Edges are repeated. (h, w, c) in, same shape out, float32.

    Examples
    --------
    >>> gradient(np.array([[[0.0], [3.0], [6.0]]]))[..., 0]
    array([[0.5, 2. , 0.5]], dtype=float32)
    """
    return by_plane(_gradient_plane, image)


def _std_plane(plane: np.ndarray) -> np.ndarray:
    """Sums of values and squares about the plane's mean: a difference of squares loses fewer digits near 0."""
    centred = plane - plane.mean()
    count = window_count(*plane.shape, radius=3)
    total, squares = sums_around(centred, 3) + centred, sums_around(centred**2, 3) + centred**2
    return np.sqrt(np.maximum(squares - total**2 / count, 0) / np.maximum(count - 1, 1))


def _deviation_plane(plane: np.ndarray) -> np.ndarray:
    """The mean first, then the distances from it."""
    count = window_count(*plane.shape, radius=1)
    mean = (sums_around(plane, 1) + plane) / count
    total = np.zeros(plane.shape)
    for _, _, here, there in window_offsets(*plane.shape, radius=1):
        total[here] += np.abs(plane[there] - mean[here])
    return total / count


def _gradient_plane(plane: np.ndarray) -> np.ndarray:
    """Sums of three along one axis, differences of them along the other."""
    padded = np.pad(plane, 1, mode="edge")
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    columns = padded[:, :-2] + padded[:, 1:-1] + padded[:, 2:]
    gx, gy = (rows[:, 2:] - rows[:, :-2]) / 9, (columns[2:] - columns[:-2]) / 9
    return (gx**2 + gy**2) / 2


def _side_by_side(arrays: Mapping[str, np.ndarray], groups: Sequence[str]) -> np.ndarray:
    """The arrays of all groups, one after another along the last axis."""
    return np.concatenate([arrays[group] for group in groups], axis=-1)


def _group_mean(image: np.ndarray, widths: Sequence[int]) -> np.ndarray:
    """Mean over the channels of each group: (h, w, sum of widths) in, (h, w, len(widths)) out."""
    mean, start = np.empty((*image.shape[:2], len(widths)), np.float32), 0
    for group, width in enumerate(widths):
        mean[..., group] = sum(image[..., start + channel] for channel in range(width)) / width
        start += width
    return mean
