"""Chapter 08: layers, each a pair forward and backward for whole batches of rows.

`forward(x)` returns what the layer makes of a batch (n, d_in), and what its backward pass will need. `backward(d_y,
saved)` takes the gradient of a loss with respect to the output and returns the one with respect to the input, and those
of the layer's parameters by name. No Jacobian matrix is ever built for that: a backward pass multiplies by it.

A layer keeps nothing of what passes through it and changes none of its arrays.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from mcdenoise.samples.gate import check_float_array


@dataclass(frozen=True, eq=False)
class Layer:
    """What all layers have in common. A layer without parameters (an activation) acts on each number by itself."""

    @property
    def parameters(self) -> dict[str, np.ndarray]:
        """The arrays that training changes, by name; empty for an activation."""
        return dict(vars(self))

    def replace(self, parameters: dict[str, np.ndarray]) -> Self:
        """The same layer with other parameters."""
        return type(self)(**parameters)

    def forward(self, x: np.ndarray) -> tuple[np.ndarray, Any]:
        """Return y, and what `backward` needs."""
        raise NotImplementedError

    def backward(self, d_y: np.ndarray, saved: Any) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return d_x, and the gradients of the parameters by name."""
        raise NotImplementedError

    def jacobian(self, x: object) -> np.ndarray:
        """The matrix dy/dx (d_out, d_in) at one row x (d_in,): a backward pass for each output, all in one batch.

        Examples
        --------
        >>> Tanh().jacobian([0.0, 0.0])
        array([[1., 0.],
               [0., 1.]])
        """
        x = check_float_array(np.asarray(x, np.float64), f"x of {type(self).__name__}")
        if x.ndim != 1:
            raise ValueError(f"jacobian of {type(self).__name__} is that of one row, shape (d_in,), got {x.shape}.")
        outputs = self.forward(x[np.newaxis])[0].shape[1]
        _, saved = self.forward(np.repeat(x[np.newaxis], outputs, axis=0))
        return self.backward(np.eye(outputs), saved)[0]


@dataclass(frozen=True, eq=False)
class Linear(Layer):
    """A fully connected layer: y = x W^T + b, for one row y_s = sum over t of w_{s,t} x_t + b_s.

    Jacobian: dy_s/dx_t = w_{s,t}, so d_x = d_y W. In a batch every row uses the same W and b, so their gradients are
    sums over the rows: d_W = d_y^T x, d_b = sum of d_y.

    Parameters
    ----------
    weight : (d_out, d_in), w_{s,t}: row s holds the weights of output s; float32 stays, whole numbers become float64
    bias : (d_out,), in the lecture w_{s,0}; likewise

    Raises
    ------
    ValueError
        If the shapes do not fit, or in `forward` if x is not (n, d_in).

    References
    ----------
    Lecture, "Multi-layer perceptron" (matrix of weights), "Fully connected layers".

    Examples
    --------
    >>> layer = Linear(weight=np.array([[1.0, 2.0], [0.0, -1.0]]), bias=np.array([0.0, 5.0]))
    >>> y, saved = layer.forward(np.array([[1.0, 1.0]]))
    >>> y
    array([[3., 4.]])
    >>> d_x, d_parameters = layer.backward(np.array([[1.0, 0.0]]), saved)
    >>> d_x, d_parameters["bias"]
    (array([[1., 2.]]), array([1., 0.]))
    """

    weight: np.ndarray
    bias: np.ndarray

    def __post_init__(self) -> None:
        weight, bias = (_check_numbers(one, f"{name} of Linear") for name, one in self.parameters.items())
        if weight.ndim != 2 or bias.shape != weight.shape[:1]:
            raise ValueError(
                f"Linear needs a weight (d_out, d_in) and a bias (d_out,), got {weight.shape} and {bias.shape}."
            )
        object.__setattr__(self, "weight", weight)
        object.__setattr__(self, "bias", bias)

    def forward(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return y (n, d_out), and x."""
        if np.ndim(x) != 2 or np.shape(x)[1] != self.weight.shape[1]:
            raise ValueError(
                f"Linear {self.weight.shape[1]} -> {self.weight.shape[0]} needs x of shape (n, {self.weight.shape[1]}) for "
                f"its weight {self.weight.shape}, got {np.shape(x)}. A single row is x[np.newaxis]."
            )
        return linear(x, self.weight, self.bias), x

    def backward(self, d_y: np.ndarray, saved: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return d_x (n, d_in) and the gradients of `weight` and `bias`: see `linear_backward`."""
        d_x, d_weight, d_bias = linear_backward(d_y, saved, self.weight)
        return d_x, {"weight": d_weight, "bias": d_bias}

    def gradients(self, d_y: np.ndarray, saved: np.ndarray) -> dict[str, np.ndarray]:
        """Only those of `weight` and `bias`: d_x of the first layer is a large product that nobody needs."""
        return {"weight": d_y.T @ saved, "bias": np.ones(len(d_y), d_y.dtype) @ d_y}


def _check_numbers(value: object, name: str) -> np.ndarray:
    """Return numbers as they are if they are float32 or float64, else (whole numbers, lists) as float64."""
    array = check_float_array(value, name)
    return array if np.asarray(value).dtype in (np.float32, np.float64) else np.asarray(value, np.float64)


@dataclass(frozen=True, eq=False)
class Step(Layer):
    """1 where x >= 0, else 0: the perceptron's activation. Its derivative is 0 wherever it has one.

    Examples
    --------
    >>> Step().forward(np.array([[-1.0, 0.0, 2.0]]))[0]
    array([[0., 1., 1.]])
    """

    def forward(self, x: np.ndarray) -> tuple[np.ndarray, None]:
        """Return y, and nothing."""
        return np.where(x >= 0, x.dtype.type(1), x.dtype.type(0)), None

    def backward(self, d_y: np.ndarray, saved: None) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Refuse: no gradient would ever reach the weights below."""
        raise ValueError(
            "Step has no backward pass: its derivative is 0 wherever there is one, so nothing before it would learn. "
            "Use Sigmoid, a smooth step, instead."
        )


@dataclass(frozen=True, eq=False)
class Sigmoid(Layer):
    """s = 1 / (1 + e^-x), a smooth step. Jacobian: diagonal, s (1 - s).

    Never NaN: far below 0 e^-x overflows to infinity and s is 0, far above it is 1; there the gradient is 0 (saturation).

    Examples
    --------
    >>> Sigmoid().forward(np.array([[0.0, 1e4, -1e4]]))[0]
    array([[0.5, 1. , 0. ]])
    """

    def forward(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return s, and s."""
        s = sigmoid(x)
        return s, s

    def backward(self, d_y: np.ndarray, saved: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return d_x = d_y s (1 - s)."""
        return sigmoid_backward(d_y, saved), {}


@dataclass(frozen=True, eq=False)
class Tanh(Layer):
    """t = tanh(x). Jacobian: diagonal, 1 - t^2.

    Examples
    --------
    >>> Tanh().forward(np.array([[0.0, 1e4]]))[0]
    array([[0., 1.]])
    """

    def forward(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return t, and t."""
        t = np.tanh(x)
        return t, t

    def backward(self, d_y: np.ndarray, saved: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return d_x = d_y (1 - t^2)."""
        return d_y * (1 - saved * saved), {}


@dataclass(frozen=True, eq=False)
class ReLU(Layer):
    """max(x, 0). Jacobian: diagonal, 1 where x > 0, else 0 (also at 0, where there is none).

    Examples
    --------
    >>> ReLU().forward(np.array([[-1.0, 2.0]]))[0]
    array([[0., 2.]])
    """

    def forward(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return y, and y: it is above 0 where x is."""
        y = np.maximum(x, 0)
        return y, y

    def backward(self, d_y: np.ndarray, saved: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return d_x = d_y where x > 0, else 0."""
        return d_y * (saved > 0), {}


@dataclass(frozen=True, eq=False)
class Softplus(Layer):
    """log(1 + e^x), a smooth ReLU whose output is never negative. Jacobian: diagonal, the sigmoid, = 1 - e^-y.

    Computed as max(x, 0) + log(1 + e^-|x|): no overflow at either end. Below -104 it is 0 in float32 (-745 in float64),
    and so is its gradient.

    References
    ----------
    The links of the filter's parameters in chapter 09 [KBS15].

    Examples
    --------
    >>> Softplus().forward(np.array([[0.0, 50.0, -1e4]]))[0].round(3)
    array([[ 0.693, 50.   ,  0.   ]])
    """

    def forward(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return y, and x."""
        return softplus(x), x

    def backward(self, d_y: np.ndarray, saved: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return d_x = d_y sigmoid(x)."""
        return softplus_backward(d_y, saved), {}


def linear(x: np.ndarray, weight: np.ndarray, bias: np.ndarray) -> np.ndarray:
    """A fully connected layer for a batch: y_{i,s} = sum over t of w_{s,t} x_{i,t} + b_s.

    Parameters
    ----------
    x : (n, d_in), a row each. weight : (d_out, d_in), a row for each output. bias : (d_out,).

    Returns
    -------
    y : (n, d_out)

    Examples
    --------
    >>> linear(np.array([[1.0, 1.0]]), weight=np.array([[1.0, 2.0], [0.0, -1.0]]), bias=np.array([0.0, 5.0]))
    array([[3., 4.]])
    """
    ### BEGIN SOLUTION
    y = x @ weight.T
    y += bias
    return y
    ### END SOLUTION


def linear_backward(d_y: np.ndarray, x: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The backward pass of y = x W^T + b for a batch.

    Parameters
    ----------
    d_y : (n, d_out), gradient of a loss with respect to y. x : (n, d_in). weight : (d_out, d_in).

    Returns
    -------
    d_x : (n, d_in)
    d_weight : (d_out, d_in), from all rows of the batch together, since all use the same weights
    d_bias : (d_out,), likewise

    Examples
    --------
    >>> d_x, d_weight, d_bias = linear_backward(np.array([[1.0], [2.0]]), np.array([[3.0], [4.0]]), np.array([[10.0]]))
    >>> d_x.tolist(), d_weight.tolist(), d_bias.tolist()
    ([[10.0], [20.0]], [[11.0]], [3.0])
    """
    ### BEGIN SOLUTION
    ones = np.ones(len(d_y), d_y.dtype)  # a product with them is the sum over the rows, several times faster
    return d_y @ weight, d_y.T @ x, ones @ d_y
    ### END SOLUTION


def sigmoid(x: np.ndarray) -> np.ndarray:
    """1 / (1 + e^-x) of an array, in its dtype; no warning at any x.

    Examples
    --------
    >>> sigmoid(np.array([0.0, -1000.0]))
    array([0.5, 0. ])
    """
    with np.errstate(over="ignore"):  # e^-x = infinity is meant: 1 / infinity is the 0 that is right
        s = np.exp(-x)
    s += 1
    return np.reciprocal(s, out=s)


def sigmoid_backward(d_y: np.ndarray, s: np.ndarray) -> np.ndarray:
    """The backward pass of s = sigmoid(x), from its output alone.

    Parameters
    ----------
    d_y : (n, d), gradient of a loss with respect to the output. s : (n, d), that output.

    Returns
    -------
    d_x : (n, d)

    Examples
    --------
    >>> sigmoid_backward(np.array([[8.0]]), np.array([[0.5]]))
    array([[2.]])
    """
    ### BEGIN SOLUTION
    d_x = 1 - s
    d_x *= s
    d_x *= d_y
    return d_x
    ### END SOLUTION


def softplus(x: np.ndarray) -> np.ndarray:
    """log(1 + e^x) of an array, in its dtype, without overflow: max(x, 0) + log(1 + a) with a = e^-|x|.

    1 + a is rounded to u, and what rounding has added, u - 1 - a, is taken off again: that matters where a is small, and
    there the slope of the logarithm is 1. This is `np.log1p`, but in operations for which NumPy has vector instructions.

    Examples
    --------
    >>> softplus(np.array([0.0, -30.0, 50.0])).round(3)
    array([ 0.693,  0.   , 50.   ])
    """
    a = np.negative(np.abs(x))
    np.exp(a, out=a)
    u = 1 + a
    added = u - 1
    added -= a
    y = np.log(u, out=u)
    y -= added
    y += np.maximum(x, 0)
    return y


def softplus_backward(d_y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The backward pass of y = log(1 + e^x), for every finite x, without a warning.

    Parameters
    ----------
    d_y : (n, d), gradient of a loss with respect to the output. x : (n, d), the input.

    Returns
    -------
    d_x : (n, d)

    Examples
    --------
    >>> softplus_backward(np.array([[2.0, 2.0, 2.0]]), np.array([[0.0, 1000.0, -1000.0]]))
    array([[1., 2., 0.]])
    """
    ### BEGIN SOLUTION
    with np.errstate(over="ignore"):  # e^-x may be infinite: then the result is the 0 that is right
        return d_y / (1 + np.exp(-x))
    ### END SOLUTION
