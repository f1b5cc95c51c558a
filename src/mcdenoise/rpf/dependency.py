"""Chapter 05: statistical dependency. What do the random parameters explain?

A feature that changes with the point on the lens is noise; one that changes with the place on the screen is an edge.
Both have a variance, and the variance does not tell them apart. Mutual information does: it measures how much one
number says about another, whatever the shape of the relation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdenoise.samples.buffer import SampleBuffer
from mcdenoise.samples.gate import (
    ENGINES,
    check_bandwidth,
    check_choice,
    check_count,
    check_float_array,
    check_nonfinite,
)

ROUNDING = 1e-12  # nats; less is what is left of sums that cancel
LARGEST_LEVELS = 255  # bins a variable; 9 to 11 are the rule
CONSTANT = 1e-6  # of the largest absolute value; rounding a coordinate to float32 leaves about 1e-7 of it


def mutual_information(x: object, y: object, *, levels: int | None = None, base: float = np.e) -> float:
    """How much the samples of one variable say about those of another: 0 if they are independent.

    mu(X; Y) = sum over x, y of p(x, y) log( p(x, y) / (p(x) p(y)) )

    with p the shares in a histogram of the standardised values, whose bins are one standard deviation wide
    (`quantise`). With N samples the histogram finds about (bins_x - 1) (bins_y - 1) / (2 N) nats even where there is
    nothing to find.

    Parameters
    ----------
    x, y : (n,), samples of two variables, in pairs.
    levels : at most so many bins, an odd number, with what lies beyond in the outermost; None: as many as needed.
    base : of the logarithm, above 1; e gives nats, 2 gives bits.

    Returns
    -------
    A number >= 0; 0 if either variable is constant (but for rounding, see `quantise`), and for a single sample.

    Raises
    ------
    ValueError
        For samples that are no finite (n,) arrays of one length above 0; for `levels` that is no odd whole number from 1
        to 255; for a base that is not above 1.

    References
    ----------
    Sen and Darabi, TOG 31(3), 2012, https://doi.org/10.1145/2167076.2167083 (the estimator); Miller, "Note on the bias
    of information estimates", 1955 (its bias).

    Examples
    --------
    >>> coin = np.array([0.0, 1.0, 0.0, 1.0])
    >>> round(mutual_information(coin, 5 - 3 * coin, base=2), 6)
    1.0
    >>> mutual_information(coin, [0.0, 0.0, 1.0, 1.0])
    0.0
    """
    x, y = _check_variables(x, 1, "x"), _check_variables(y, 1, "y")
    _check_pairs({"x": x, "y": y})
    base = check_bandwidth(base, "base")
    if base <= 1:
        raise ValueError(f"base must be above 1 (e for nats, 2 for bits), got {base:g}.")
    return information_of_levels(quantise(x, levels), quantise(y, levels)) / float(np.log(base))


def quantise(values: np.ndarray, levels: int | None = None) -> np.ndarray:
    """Whole numbers of standard deviations from the mean, along axis 0: round((value - mean) / deviation).

    Parameters
    ----------
    values : (n,) or (n, k), each column by itself. A constant column becomes 0. Constant is a column whose standard
        deviation is below 1e-6 of its largest absolute value: less is what rounding to float32 leaves of one coordinate
        of a flat wall.
    levels : an odd number: clamp to -(levels - 1) / 2 .. (levels - 1) / 2. None: to +-127.

    Raises
    ------
    ValueError
        For `levels` that is no odd whole number from 1 to 255.

    Examples
    --------
    >>> quantise(np.array([0.0, 0.0, 1.0, 5.0, -5.0]))
    array([ 0,  0,  0,  2, -2])
    >>> quantise(np.array([3.0, 3.0, 3.0000002]))
    array([0, 0, 0])
    """
    half = (LARGEST_LEVELS if levels is None else check_count(levels, "levels")) // 2
    if levels is not None and (levels % 2 == 0 or levels > LARGEST_LEVELS):
        raise ValueError(f"levels must be an odd number up to {LARGEST_LEVELS}, so that 0 is one, got {levels}.")
    rows = np.array(np.transpose(values), np.float64, order="C")  # a column is a row now, and lies together in memory
    largest = np.abs(rows).max(axis=-1, keepdims=True)
    rows /= np.where(largest > 0, largest, 1.0)  # so that no square overflows
    rows -= rows.mean(axis=-1, keepdims=True)
    deviation = np.sqrt(np.square(rows).mean(axis=-1, keepdims=True))
    rows /= np.where(deviation < CONSTANT, np.inf, deviation)
    return np.clip(np.rint(rows, out=rows), -half, half, out=rows).astype(np.int64).T


def information_of_levels(x: np.ndarray, y: np.ndarray) -> float:
    """Mutual information, in nats, of two variables that are whole numbers already: the formula as it reads.

    Parameters
    ----------
    x, y : (n,), whole numbers.

    Examples
    --------
    >>> float(round(information_of_levels(np.array([0, 0, 1, 1]), np.array([3, 3, 7, 7])) / np.log(2), 6))
    1.0
    """
    ### BEGIN SOLUTION
    x, y = (np.unique(one, return_inverse=True)[1] for one in (x, y))
    count = np.zeros((x.max() + 1, y.max() + 1))
    np.add.at(count, (x, y), 1)
    joint = count / len(x)
    p_x, p_y = (count.sum(axis=axis, keepdims=True) / len(x) for axis in (1, 0))
    there = joint > 0  # 0 log 0 = 0
    found = float(np.sum(joint[there] * np.log(joint[there] / (p_x * p_y)[there])))
    return found if found > ROUNDING else 0.0
    ### END SOLUTION


@dataclass(frozen=True, eq=False)
class Dependency:
    """Pairwise mutual information in one neighbourhood, in nats, and the shares that follow from it.

    Sums of pairs stand in for the information of all parameters together [SD12].

    Attributes
    ----------
    c_r : (3, n_r), D_{c,k}^{r,l}: channel k of radiance and random parameter l
    c_p : (3, 2), D_{c,k}^{p,l}: and screen position
    c_f : (3, n_f), D_{c,k}^{f,l}: and feature l
    f_r : (n_f, n_r), D_{f,k}^{r,l}: feature k and random parameter l
    f_p : (n_f, 2), D_{f,k}^{p,l}: and screen position

    Examples
    --------
    Red depends on the lens alone, green on the place alone, blue on nothing:

    >>> found = Dependency(
    ...     c_r=np.array([[0.6], [0.0], [0.0]]),
    ...     c_p=np.array([[0.0, 0.0], [0.3, 0.1], [0.0, 0.0]]),
    ...     c_f=np.zeros((3, 0)),
    ...     f_r=np.zeros((0, 1)),
    ...     f_p=np.zeros((0, 2)),
    ... )
    >>> found.share_c_r
    array([1., 0., 0.])
    """

    c_r: np.ndarray
    c_p: np.ndarray
    c_f: np.ndarray
    f_r: np.ndarray
    f_p: np.ndarray

    @property
    def share_c_r(self) -> np.ndarray:
        """W_{c,k}^r (3,): what the random parameters explain of what they and the position explain of radiance."""
        return share(self.c_r.sum(axis=1), self.c_r.sum(axis=1) + self.c_p.sum(axis=1))

    @property
    def share_c_r_each(self) -> np.ndarray:
        """W_{c,k}^{r,l} (3, n_r): the same for each random parameter; they add up to `share_c_r`."""
        return share(self.c_r, (self.c_r.sum(axis=1) + self.c_p.sum(axis=1))[:, np.newaxis])

    @property
    def share_f_r(self) -> np.ndarray:
        """W_{f,k}^r (n_f,): what the random parameters explain of what they and the position explain of a feature."""
        return share(self.f_r.sum(axis=1), self.f_r.sum(axis=1) + self.f_p.sum(axis=1))

    @property
    def share_c_f(self) -> np.ndarray:
        """W_c^{f,k} (n_f,): what feature k explains of all that is explained of radiance, over all channels."""
        whole = self.c_r.sum() + self.c_p.sum() + self.c_f.sum()
        return share(self.c_f.sum(axis=0), whole)


def share(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """part / whole, and 0 where nothing depends on anything (0 / 0).

    Examples
    --------
    >>> share(np.array([1.0, 0.0]), np.array([4.0, 0.0]))
    array([0.25, 0.  ])
    """
    return np.divide(part, whole, out=np.zeros(np.shape(part)), where=np.broadcast_to(whole > 0, np.shape(part)))


def dependency(
    position: object,
    random_params: object,
    features: object,
    radiance: object,
    *,
    levels: int | None = None,
    engine: str = "numba",
) -> Dependency:
    """Measure what depends on what among the samples of one neighbourhood.

    Parameters
    ----------
    position : (n, 2), p. random_params : (n, n_r), r. features : (n, n_f), f. radiance : (n, 3), c. n_r and n_f may be 0.
    levels : of the histograms, as for `mutual_information`.
    engine : ``"numba"``, or ``"numpy"``, pair by pair and as the formula reads.

    Returns
    -------
    Dependency

    Raises
    ------
    ValueError
        For arrays that are not finite, not (n, k), or of different n; for `levels` or an engine that there is not.

    References
    ----------
    Sen and Darabi, TOG 31(3), 2012, https://doi.org/10.1145/2167076.2167083; lecture, "Statistical dependency".

    Examples
    --------
    The feature is the lens, the radiance is the place on the screen:

    >>> rng = np.random.default_rng(0)
    >>> p, lens = rng.random((500, 2)), rng.random((500, 1))
    >>> found = dependency(p, lens, features=lens, radiance=p[:, [0, 0, 0]])
    >>> found.share_f_r.round(1), found.share_c_r.round(1)
    (array([1.]), array([0., 0., 0.]))
    """
    given = {"position": position, "random_params": random_params, "features": features, "radiance": radiance}
    arrays = {name: _check_variables(value, 2, name) for name, value in given.items()}
    for name, columns in (("position", 2), ("radiance", 3)):
        if arrays[name].shape[1] != columns:
            raise ValueError(f"{name} must have shape (n, {columns}), got {arrays[name].shape}.")
    _check_pairs(arrays)
    together = quantise(np.concatenate(list(arrays.values()), axis=1), levels)
    p, r, f, c = np.split(together, np.cumsum([array.shape[1] for array in arrays.values()])[:-1], axis=1)
    if check_choice(engine, ENGINES, "engine") == "numpy":
        pairs = information_of_pairs
    else:
        from mcdenoise.kernels.dependency import information_of_pairs as pairs
    return Dependency(c_r=pairs(c, r), c_p=pairs(c, p), c_f=pairs(c, f), f_r=pairs(f, r), f_p=pairs(f, p))


def dependency_of(samples: SampleBuffer, *, levels: int | None = None, engine: str = "numba") -> Dependency:
    """`dependency` among all samples of a buffer: crop it to the neighbourhood that is meant.

    Parameters
    ----------
    samples : such as ``samples.crop(y - 5, x - 5, 11, 11)``, the neighbourhood of pixel (y, x).
    levels, engine : as for `dependency`.

    Returns
    -------
    Dependency, random parameters and features in the order of the buffer's columns

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(4), np.arange(4)), axis=-1)[:, :, np.newaxis]
    >>> lens = rng.random((4, 4, 32))
    >>> radiance = np.repeat(lens[..., np.newaxis], 3, axis=-1)
    >>> samples = SampleBuffer.from_arrays(radiance, corner + rng.random((4, 4, 32, 2)), {"lens_u": lens})
    >>> dependency_of(samples).share_c_r.round(1)
    array([1., 1., 1.])
    """
    blocks = (samples.screen_position, samples.random_params, samples.features, samples.radiance)
    count = samples.height * samples.width * samples.spp
    return dependency(*(block.reshape(count, block.shape[-1]) for block in blocks), levels=levels, engine=engine)


def information_of_pairs(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Mutual information, in nats, of each column of x (n, a) with each of y (n, b), whole numbers: (a, b).

    Examples
    --------
    >>> x = np.array([[0, 0], [1, 0]])
    >>> information_of_pairs(x, x).round(2)
    array([[0.69, 0.  ],
           [0.  , 0.  ]])
    """
    found = [[information_of_levels(one, other) for other in y.T] for one in x.T]
    return np.array(found).reshape(x.shape[1], y.shape[1])


def _check_variables(value: object, dimensions: int, name: str) -> np.ndarray:
    """Return finite samples, one at least, in the given number of dimensions."""
    array = check_float_array(value, name)
    if array.ndim != dimensions or len(array) == 0:
        raise ValueError(
            f"{name} must have shape {'(n,)' if dimensions == 1 else '(n, columns)'} with n above 0, got {array.shape}. "
            f"Pass the samples of one neighbourhood."
        )
    return check_nonfinite(array, name)


def _check_pairs(arrays: dict[str, np.ndarray]) -> None:
    """Refuse variables of different numbers of samples."""
    if len({len(array) for array in arrays.values()}) > 1:
        words = ", ".join(f"{len(array)} of {name}" for name, array in arrays.items())
        raise ValueError(f"All variables must have the same samples, got {words}.")
