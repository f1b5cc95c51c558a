"""Chapter 06, first step: the samples around one pixel. Draw them, leave out those of another kind, standardise the rest."""

from __future__ import annotations

import numpy as np

from mcdenoise.rpf.dependency import CONSTANT
from mcdenoise.rpf.draws import first_entries, offset_table, pixel_key, random_bits
from mcdenoise.samples import SampleBuffer

TOLERANCE = 0.1  # a feature this near the mean of the pixel is never far
FAR, FAR_POSITION = 3.0, 30.0  # standard deviations, for features and for world positions


def choose_samples(
    size: tuple[int, int, int], pixel: tuple[int, int], box: int, draws: int | None, seed: int, turn: int
) -> np.ndarray:
    """Choose the samples of a neighbourhood: all of the pixel itself first, then `draws` of other pixels of the box.

    An offset is drawn from a Gaussian of sigma_p = box / 4, rounded to whole pixels, inside box and image, not the pixel
    itself; then one of the samples there. The same sample may come twice. Because near pixels are drawn more often, the
    spatial factor of the weight is not needed again.

    Parameters
    ----------
    size : (h, w, spp). pixel : y, x.
    draws : None: every sample of the box once, row by row.
    seed, turn : which random numbers; turn is the number of the pass.

    Returns
    -------
    (n, 3), whole numbers: y, x and number in its pixel of each sample

    Examples
    --------
    >>> choose_samples((1, 2, 2), (0, 1), box=3, draws=None, seed=0, turn=0).tolist()
    [[0, 1, 0], [0, 1, 1], [0, 0, 0], [0, 0, 1]]
    """
    (height, width, spp), (y, x), half = size, pixel, box // 2
    own = [(y, x, s) for s in range(spp)]
    if draws is None:
        rows, columns = (range(max(a - half, 0), min(a + half + 1, n)) for a, n in ((y, height), (x, width)))
        others = [(b, a, s) for b in rows for a in columns for s in range(spp) if (b, a) != (y, x)]
        return np.array(own + others).reshape(-1, 3)
    if height * width == 1 or draws == 0:
        return np.array(own)
    table = offset_table(box, box / 4)
    first, key = first_entries(table, box), pixel_key(seed, turn, y * width + x)
    found, number = np.empty((0, 3), np.int64), 0
    while len(found) < draws:
        bits = random_bits(key, np.arange(number, number + draws))
        number += draws
        dx, dy = (
            table[
                _scaled(
                    bits >> np.uint64(shift), 24, first[half - min(a, half)], first[half + min(n - 1 - a, half) + 1]
                )
            ]
            for shift, a, n in ((0, x, width), (24, y, height))
        )
        s = _scaled(bits >> np.uint64(48), 16, 0, spp)
        drawn = np.stack([y + dy, x + dx, s], axis=-1)
        found = np.concatenate([found, drawn[(dx != 0) | (dy != 0)]])
    return np.concatenate([np.array(own), found[:draws]])


def _scaled(bits: np.ndarray, count: int, low: int, high: int) -> np.ndarray:
    """The lowest `count` bits as whole numbers from low to high - 1."""
    part = bits & np.uint64((1 << count) - 1)
    return low + ((part * np.uint64(high - low)) >> np.uint64(count)).astype(np.int64)


def feature_limits(samples: SampleBuffer) -> np.ndarray:
    """How many standard deviations each column of features may be away: 30 for world positions, 3 for others, (n_f,)."""
    limits = np.full(samples.features.shape[-1], FAR)
    for field in samples.layout.features:
        if field.name.startswith("world_position"):
            limits[field.columns] = FAR_POSITION
    return limits


def is_like(features: np.ndarray, own: np.ndarray, limits: np.ndarray, tolerance: float) -> np.ndarray:
    """Whether each sample is of the kind of the pixel: the clustering of [SD12].

    A sample is left out if for any feature k, with mean m_k and standard deviation s_k over the pixel's own samples,
    |f_k - m_k| > limit_k s_k and (|f_k - m_k| > tolerance or s_k > tolerance).

    Parameters
    ----------
    features : (n, n_f) of the samples to be judged. own : (spp, n_f) of the pixel. limits : (n_f,), standard deviations.
    tolerance : in the unit of the feature; published: 0.1.

    Returns
    -------
    (n,) bool

    Examples
    --------
    >>> own = np.array([[0.0], [1.0]])
    >>> is_like(np.array([[0.5], [1.9], [2.1]]), own, limits=np.array([3.0]), tolerance=0.1)
    array([ True,  True, False])
    """
    ### BEGIN SOLUTION
    mean, deviation = own.mean(axis=0), own.std(axis=0)
    distance = np.abs(features - mean)
    far = (distance > limits * deviation) & ((distance > tolerance) | (deviation > tolerance))
    return ~far.any(axis=1)
    ### END SOLUTION


def standardise(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Subtract the mean of each column, and divide by its standard deviation; a constant column becomes 0.

    Parameters
    ----------
    values : (n, k). A standard deviation below 1e-6 of the column's largest value is rounding: the column is constant.

    Returns
    -------
    standardised : (n, k). scale : (k,), one over the standard deviation, 0 for a constant column.

    Examples
    --------
    >>> standardised, scale = standardise(np.array([[1.0, 5.0], [3.0, 5.0]]))
    >>> standardised, scale
    (array([[-1.,  0.],
           [ 1.,  0.]]), array([1., 0.]))
    """
    values = np.asarray(values, np.float64)
    centred = values - values.mean(axis=0)
    deviation = centred.std(axis=0)
    varies = deviation > CONSTANT * np.abs(values).max(axis=0)
    scale = np.divide(1, deviation, out=np.zeros_like(deviation), where=varies)
    return centred * scale, scale
