"""Chapter 08: back propagation on one screen. Numbers that remember how they were made.

A `Scalar` holds its value, the scalars that it was made from, and the derivative of its value with respect to each of
them (the local gradient), worked out on the spot. `backward` walks from the output to the inputs and applies the chain
rule once an edge. Nothing is stored in the graph, so it can be walked as often as one likes.
"""

from __future__ import annotations

import math
from itertools import count

_NUMBERS = count()  # a scalar is younger than its parents: descending numbers are an order for the backward pass


class Scalar:
    """A number in a computational graph; + - * / ** and the functions of this module make new ones from it.

    Attributes
    ----------
    value : float
    parents : the scalars it was made from
    local : d value / d parent, one a parent
    operation : its sign, such as ``"+"`` or ``"exp"``; empty for an input
    label : a name for pictures

    Raises
    ------
    ValueError
        If the value, or that of an operation, is not finite or not defined: the message names the operation.

    References
    ----------
    Lecture, "Back propagation: a simple example".

    Examples
    --------
    >>> x, y, z = Scalar(-2, "x"), Scalar(5, "y"), Scalar(-4, "z")
    >>> f = (x + y) * z
    >>> f.value, [backward(f)[one] for one in (x, y, z)]
    (-12.0, [-4.0, -4.0, 3.0])
    """

    __slots__ = ("label", "local", "number", "operation", "parents", "value")

    def __init__(self, value: float, label: str = "", operation: str = "", parents=(), local=()) -> None:
        values = (value, *local)
        if not all(math.isfinite(one) for one in values):
            made = f"{operation}({', '.join(f'{one.value:g}' for one in parents)})" if operation else "A scalar"
            raise ValueError(f"{made} needs a finite value and finite derivatives, got {value:g} and {list(local)}.")
        self.value, self.label, self.operation = float(value), label, operation
        self.parents, self.local, self.number = tuple(parents), tuple(local), next(_NUMBERS)

    def __repr__(self) -> str:
        return f"Scalar({self.value:g}{f', {self.label!r}' if self.label else ''})"

    def __add__(self, other):
        other = _scalar(other)
        return Scalar(self.value + other.value, "", "+", (self, other), (1.0, 1.0))

    def __mul__(self, other):
        other = _scalar(other)
        return Scalar(self.value * other.value, "", "*", (self, other), (other.value, self.value))

    def __pow__(self, power: float):
        at_zero = self.value == 0 and power != 0 and power < 1
        if isinstance(power, Scalar) or at_zero or (self.value < 0 and power != int(power)):
            raise ValueError(
                f"{self.value:g} ** {power} is not defined, or its derivative is not: the power must be a plain number, "
                f"whole if the base is negative, 0 or at least 1 if it is 0."
            )
        local = power * self.value ** (power - 1) if power else 0.0
        return Scalar(self.value**power, "", f"^{power:g}", (self,), (local,))

    def __neg__(self):
        return self * -1

    def __sub__(self, other):
        return self + -_scalar(other)

    def __truediv__(self, other):
        return self * _scalar(other) ** -1

    def __rsub__(self, other):
        return _scalar(other) - self

    def __rtruediv__(self, other):
        return _scalar(other) / self

    __radd__, __rmul__ = __add__, __mul__


def exp(x: Scalar) -> Scalar:
    """e^x; its derivative is itself. Above 709 it leaves float64, which is refused."""
    value = math.exp(x.value) if x.value < 709 else math.inf
    return Scalar(value, "", "exp", (x,), (value,))


def log(x: Scalar) -> Scalar:
    """Natural logarithm; its derivative is 1/x. x must be above 0."""
    if x.value <= 0:
        raise ValueError(f"log needs a number above 0, got {x.value:g}.")
    return Scalar(math.log(x.value), "", "log", (x,), (1 / x.value,))


def tanh(x: Scalar) -> Scalar:
    """Hyperbolic tangent t; its derivative is 1 - t^2."""
    value = math.tanh(x.value)
    return Scalar(value, "", "tanh", (x,), (1 - value**2,))


def sigmoid(x: Scalar) -> Scalar:
    """s = 1 / (1 + e^-x); its derivative is s (1 - s)."""
    small = math.exp(-abs(x.value))  # at most 1: no overflow at either end
    value = (1 if x.value >= 0 else small) / (1 + small)
    return Scalar(value, "", "sigmoid", (x,), (small / (1 + small) ** 2,))


def relu(x: Scalar) -> Scalar:
    """max(x, 0); its derivative is 1 where x > 0, else 0 (also at 0, where there is none)."""
    return Scalar(max(x.value, 0.0), "", "relu", (x,), (1.0 if x.value > 0 else 0.0,))


def softplus(x: Scalar) -> Scalar:
    """log(1 + e^x), a smooth relu; its derivative is the sigmoid."""
    small = math.exp(-abs(x.value))
    slope = (1 if x.value >= 0 else small) / (1 + small)
    return Scalar(max(x.value, 0.0) + math.log1p(small), "", "softplus", (x,), (slope,))


def backward(output: Scalar) -> dict[Scalar, float]:
    """Derivatives of `output` with respect to every scalar that it was made from, itself (1) included.

    The chain rule, from the output back: each scalar hands every parent its own gradient times the local one, and what
    arrives at a parent by several ways is added.

    Parameters
    ----------
    output : the end of the graph, of any depth; the walk is no recursion.

    Returns
    -------
    dict, scalar -> d output / d scalar, in the order of the walk

    Raises
    ------
    ValueError
        If a gradient leaves float64.

    Examples
    --------
    x comes in twice, so its gradients add up:

    >>> x = Scalar(3.0)
    >>> backward(x * x + x)[x]
    7.0
    """
    gradients = dict.fromkeys(walk(output), 0.0)
    gradients[output] = 1.0
    for scalar in gradients:
        for parent, local in zip(scalar.parents, scalar.local, strict=True):
            gradients[parent] += gradients[scalar] * local
    if bad := [scalar for scalar, gradient in gradients.items() if not math.isfinite(gradient)]:
        raise ValueError(f"{len(bad)} gradients leave float64, the first at {bad[0]!r}. Scale the numbers down.")
    return gradients


def walk(output: Scalar) -> list[Scalar]:
    """All scalars that `output` was made from, itself first, each before its parents.

    Examples
    --------
    >>> x = Scalar(1.0, "x")
    >>> walk(x + 2.0)
    [Scalar(3), Scalar(2), Scalar(1, 'x')]
    """
    found, waiting = {output}, [output]
    while waiting:
        for parent in waiting.pop().parents:
            if parent not in found:
                found.add(parent)
                waiting.append(parent)
    return sorted(found, key=lambda scalar: -scalar.number)


def _scalar(value: Scalar | float) -> Scalar:
    """Return a number as a scalar without parents."""
    return value if isinstance(value, Scalar) else Scalar(value)
