"""Chapter 08: losses, each a pair forward and backward: one number for a whole batch, and its gradient.

All are means over the rows of a batch, so that a rate of learning does not depend on how many there are. A batch of no
rows has the loss 0. Squares are added up in float64: in float32 too, loss and gradient are finite for magnitudes up to 1e30.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from mcdenoise.nn.layers import sigmoid, softplus
from mcdenoise.samples.gate import check_bandwidth, check_float_array, check_nonfinite


@dataclass(frozen=True, eq=False)
class Loss:
    """What all losses have in common."""

    def forward(self, y: np.ndarray, target: object) -> tuple[float, Any]:
        """Return the loss, a float, and what `backward` needs."""
        raise NotImplementedError

    def backward(self, saved: Any) -> np.ndarray:
        """Return d_y (n, d): the gradient of the loss with respect to y."""
        raise NotImplementedError

    def rows(self, part: slice | np.ndarray) -> Self:
        """The same loss for some of the rows; different only where a loss knows something of each row."""
        return self

    def _check(self, y: np.ndarray, target: object) -> np.ndarray:
        """Return the target in the dtype of y, of the same shape."""
        target = check_float_array(target, "target")
        if np.ndim(y) != 2 or target.shape != np.shape(y):
            raise ValueError(
                f"{type(self).__name__} needs y and target of one shape (n, d), got {np.shape(y)} and {target.shape}. One "
                f"number a row is a column: target[:, np.newaxis]."
            )
        return target.astype(y.dtype, copy=False)


@dataclass(frozen=True, eq=False)
class SquaredError(Loss):
    """E_i = 1/2 sum over q of (y_q - target_q)^2, its mean over the rows. Gradient: (y - target) / n.

    Examples
    --------
    >>> loss, saved = SquaredError().forward(np.array([[3.0, 1.0]]), [[1.0, 1.0]])
    >>> loss, SquaredError().backward(saved)
    (2.0, array([[2., 0.]]))
    """

    def forward(self, y: np.ndarray, target: object) -> tuple[float, np.ndarray]:
        """Return the loss, and y - target."""
        difference = y - self._check(y, target)
        squares = np.einsum("nq,nq->", difference, difference, dtype=np.float64)
        return float(squares) / 2 / max(len(y), 1), difference

    def backward(self, saved: np.ndarray) -> np.ndarray:
        """Return (y - target) / n."""
        return saved / max(len(saved), 1)


@dataclass(frozen=True, eq=False)
class CrossEntropy(Loss):
    """E_i = sum over q of -target log p - (1 - target) log(1 - p) with p = sigmoid(y), its mean over the rows.

    y is what goes INTO the sigmoid, not what comes out: then E = softplus(y) - target y, and no log 0 can happen.
    Gradient: (p - target) / n. It does not vanish where a saturated sigmoid is wrong.

    Examples
    --------
    >>> loss, saved = CrossEntropy().forward(np.array([[0.0], [1e4]]), [[1.0], [1.0]])
    >>> round(loss, 4), CrossEntropy().backward(saved).ravel()
    (0.3466, array([-0.25,  0.  ]))
    """

    def forward(self, y: np.ndarray, target: object) -> tuple[float, tuple[np.ndarray, np.ndarray]]:
        """Return the loss, and (y, target)."""
        target = self._check(y, target)
        if np.any((target < 0) | (target > 1)):
            raise ValueError(f"CrossEntropy needs targets in [0, 1], got {target.min():g} to {target.max():g}.")
        return _mean_of_rows(softplus(y) - target * y), (y, target)

    def backward(self, saved: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        """Return (sigmoid(y) - target) / n."""
        y, target = saved
        return (sigmoid(y) - target) / max(len(y), 1)


@dataclass(frozen=True, eq=False)
class RelativeError(Loss):
    """E_i = n/2 sum over q of (y_q - c_q)^2 / (c_q^2 + epsilon), its mean over the rows. c is the reference.

    Gradient: n (y_q - c_q) / (c_q^2 + epsilon), divided by the number of rows. epsilon keeps it finite where the
    reference is black: there both are as steep as anywhere, n/epsilon.

    Parameters
    ----------
    spp : n, samples per pixel; a number, or (n,), one a row. A factor alone: more samples, more say.
    epsilon : radiance squared, above 0.

    Raises
    ------
    ValueError
        For an epsilon or an spp that is not above 0, or shapes that do not fit.

    References
    ----------
    Lecture, "One hidden-layer model: relative mean square error" [KBS15].

    Examples
    --------
    >>> loss, saved = RelativeError(spp=4).forward(np.array([[0.5, 0.0, 0.1]]), [[0.4, 0.0, 0.0]])
    >>> round(loss, 4), RelativeError(spp=4).backward(saved).round(3)
    (2.1176, array([[ 2.353,  0.   , 40.   ]]))
    """

    spp: float | np.ndarray = 1.0
    epsilon: float = 0.01

    def __post_init__(self) -> None:
        check_bandwidth(self.epsilon, "epsilon")
        spp = check_nonfinite(check_float_array(self.spp, "spp"), "spp")
        if spp.ndim > 1 or np.any(spp <= 0):
            raise ValueError(
                f"spp must be a number above 0, or (n,) of them, got shape {spp.shape}, least {spp.min()}."
            )

    def rows(self, part: slice | np.ndarray) -> Self:
        """The same loss with the spp of these rows."""
        return type(self)(np.asarray(self.spp)[part], self.epsilon) if np.ndim(self.spp) else self

    def forward(self, y: np.ndarray, target: object) -> tuple[float, tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Return the loss, and (y, c, n)."""
        target, spp = self._check(y, target), np.asarray(self.spp, np.float64)
        if spp.ndim and len(spp) != len(y):
            raise ValueError(f"RelativeError has the spp of {len(spp)} rows, got {len(y)} rows.")
        spp = np.broadcast_to(spp.reshape(-1, 1), (len(y), 1))
        squared = np.square(y - target, dtype=np.float64) / (np.square(target, dtype=np.float64) + self.epsilon)
        return _mean_of_rows(spp * squared) / 2, (y, target, spp)

    def backward(self, saved: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
        """Return n (y - c) / (c^2 + epsilon) / rows."""
        y, reference, spp = saved
        gradient = relative_error_gradient(y, reference, spp, self.epsilon) / max(len(y), 1)
        return gradient.astype(y.dtype, copy=False)


def relative_error_gradient(
    filtered: np.ndarray, reference: np.ndarray, spp: float | np.ndarray, epsilon: float
) -> np.ndarray:
    """dE_i / dc_hat_{i,q} of the relative error E_i = n/2 sum over q of (c_hat_{i,q} - c_{i,q})^2 / (c_{i,q}^2 + epsilon).

    Parameters
    ----------
    filtered : (n, 3), c_hat, a row for each pixel i. reference : (n, 3), c.
    spp : n, the number of samples per pixel, or (n, 1). epsilon : radiance squared, above 0.

    Returns
    -------
    gradient : (n, 3), float64

    Examples
    --------
    >>> relative_error_gradient(np.array([[0.5, 0.0]]), np.array([[0.4, 0.0]]), spp=4, epsilon=0.01).round(3)
    array([[2.353, 0.   ]])
    """
    ### BEGIN SOLUTION
    reference = np.asarray(reference, np.float64)
    return spp * (filtered - reference) / (reference**2 + epsilon)
    ### END SOLUTION


def _mean_of_rows(values: np.ndarray) -> float:
    """Sum over the columns, mean over the rows, added up in float64."""
    return float(values.sum(dtype=np.float64)) / max(len(values), 1)
