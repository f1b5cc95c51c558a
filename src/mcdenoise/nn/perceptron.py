"""Chapter 07: the perceptron. A line cuts the plane in two; lines make regions, and regions make everything else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mcdenoise.nn.layers import Linear, Step
from mcdenoise.samples.gate import check_bandwidth, check_count, check_float_array, check_nonfinite


@dataclass(frozen=True, eq=False)
class Perceptron:
    """A classifier: 1 where w . x + b >= 0, else 0. Its decision boundary is the line w . x + b = 0.

    Attributes
    ----------
    weight : (d,), at right angles to the line, pointing to the side of the 1
    bias : float; the line is -bias / |weight| away from the origin, along the weight

    References
    ----------
    Lecture, "Perceptron classifier"; Rosenblatt, Psychological Review 65, 1958, https://doi.org/10.1037/h0042519

    Examples
    --------
    >>> right_of_one = Perceptron(weight=np.array([1.0, 0.0]), bias=-1.0)
    >>> right_of_one.classify([[0.0, 5.0], [2.0, 5.0]])
    array([0, 1])
    """

    weight: np.ndarray
    bias: float

    def classify(self, x: ArrayLike) -> np.ndarray:
        """Return the class, 0 or 1, of each row of x (n, d)."""
        x = check_float_array(x, "x")
        if x.ndim != 2 or x.shape[1] != len(self.weight):
            raise ValueError(f"Perceptron needs x of shape (n, {len(self.weight)}), got {x.shape}.")
        return (x @ self.weight + self.bias >= 0).astype(int)


@dataclass(frozen=True, eq=False)
class PerceptronTraining:
    """What the learning rule did.

    Attributes
    ----------
    perceptron : after the last epoch
    history : (corrections + 1, d + 1), weights and, last, bias: at the start and after each correction
    mistakes : (epochs,), corrections in each epoch
    separated : an epoch went by without a mistake, so the data lies on both sides of the line

    Examples
    --------
    >>> train_perceptron([[0.0], [1.0]], [0, 1]).separated
    True
    """

    perceptron: Perceptron
    history: np.ndarray
    mistakes: np.ndarray
    separated: bool


def train_perceptron(
    x: ArrayLike, labels: ArrayLike, *, rate: float = 1.0, epochs: int = 100, rng: np.random.Generator | None = None
) -> PerceptronTraining:
    """Rosenblatt's rule: go through the samples; where the answer is wrong, move the line towards the sample.

    w += rate (label - answer) x,   b += rate (label - answer)

    If a line separates the classes, one is found after at most (R / gamma)^2 corrections from 0 (R: longest (x, 1),
    gamma: half the width of the widest gap, as seen from there). If there is none, the rule never stops.

    Parameters
    ----------
    x : (n, d). labels : (n,), 0 or 1.
    rate : length of a correction; starting from 0 it scales the weights and changes no answer.
    epochs : at most so many; training ends after the first without a mistake.
    rng : shuffles the samples in each epoch; None: they keep their order.

    Raises
    ------
    ValueError
        For x that is not finite or not (n, d), n above 0; for labels other than n of 0 and 1.

    References
    ----------
    Rosenblatt 1958; Novikoff, "On convergence proofs for perceptrons", 1962 (the bound).

    Examples
    --------
    Of AND and XOR only the first has a line:

    >>> corners = [[0, 0], [0, 1], [1, 0], [1, 1]]
    >>> train_perceptron(corners, [0, 0, 0, 1]).separated, train_perceptron(corners, [0, 1, 1, 0]).separated
    (True, False)
    """
    x, labels = _check_classes(x, labels)
    rate, epochs = check_bandwidth(rate, "rate"), check_count(epochs, "epochs")
    weight, bias = np.zeros(x.shape[1]), 0.0
    history, mistakes = [(*weight, bias)], []
    while len(mistakes) < epochs and (not mistakes or mistakes[-1]):
        for i in range(len(x)) if rng is None else rng.permutation(len(x)):
            if (x[i] @ weight + bias >= 0) != labels[i]:
                weight, bias = perceptron_step(weight, bias, x[i], labels[i], rate)
                history.append((*weight, bias))
        mistakes.append(len(history) - 1 - sum(mistakes))
    return PerceptronTraining(Perceptron(weight, bias), np.array(history), np.array(mistakes), mistakes[-1] == 0)


def perceptron_step(
    weight: np.ndarray, bias: float, x: np.ndarray, label: int, rate: float
) -> tuple[np.ndarray, float]:
    """Rosenblatt's rule for one sample: w += rate (label - answer) x and b += rate (label - answer).

    Parameters
    ----------
    weight : (d,). bias : a number. The answer is 1 where weight . x + bias >= 0, else 0.
    x : (d,), the sample. label : its class, 0 or 1. rate : > 0.

    Returns
    -------
    The new weight and bias; those that were given if the answer was right.

    Examples
    --------
    >>> perceptron_step(np.array([0.0, 0.0]), 0.0, x=np.array([2.0, 1.0]), label=0, rate=1.0)
    (array([-2., -1.]), -1.0)
    """
    ### BEGIN SOLUTION
    answer = 1 if weight @ x + bias >= 0 else 0
    return weight + rate * (label - answer) * x, bias + rate * (label - answer)
    ### END SOLUTION


def half_planes(lines: ArrayLike) -> tuple[Linear, Step]:
    """A layer of perceptrons with given lines: output k is 1 where a_k x + b_k y + c_k >= 0.

    Parameters
    ----------
    lines : (m, d + 1), rows such as (a, b, c)

    Examples
    --------
    >>> linear, step = half_planes([[1, 0, 0], [0, 1, -1]])
    >>> step.forward(linear.forward(np.array([[0.5, 0.5]]))[0])[0]
    array([[1., 0.]])
    """
    lines = check_nonfinite(check_float_array(lines, "lines").astype(np.float64), "lines")
    if lines.ndim != 2 or lines.shape[1] < 2:
        raise ValueError(f"lines must be (m, d + 1), the bias last, got shape {lines.shape}.")
    return Linear(lines[:, :-1], lines[:, -1]), Step()


def all_of(groups: Sequence[Sequence[int]], inputs: int) -> tuple[Linear, Step]:
    """A layer of intersections: output g is 1 where all inputs of group g are 1. ``~k`` asks for input k to be 0.

    Parameters
    ----------
    groups : indices of inputs, at least one a group
    inputs : how many there are, each 0 or 1

    Examples
    --------
    Input 0 without input 1:

    >>> linear, step = all_of([[0, ~1]], inputs=2)
    >>> step.forward(linear.forward(np.array([[1.0, 0.0], [1.0, 1.0]]))[0])[0].ravel()
    array([1., 0.])
    """
    return _gate(groups, inputs, lambda count: count - 0.5)


def any_of(groups: Sequence[Sequence[int]], inputs: int) -> tuple[Linear, Step]:
    """A layer of unions: output g is 1 where at least one input of group g is 1 (or, for ``~k``, 0).

    Examples
    --------
    >>> linear, step = any_of([[0, 1]], inputs=2)
    >>> step.forward(linear.forward(np.array([[1.0, 0.0], [0.0, 0.0]]))[0])[0].ravel()
    array([1., 0.])
    """
    return _gate(groups, inputs, lambda count: 0.5)


def _gate(groups: Sequence[Sequence[int]], inputs: int, threshold) -> tuple[Linear, Step]:
    """Count, with weights 1 and -1, what of a group is as wished, and compare with a threshold."""
    weight = np.zeros((len(groups), check_count(inputs, "inputs")))
    bias = np.zeros(len(groups))
    for g, group in enumerate(groups):
        places = [k if k >= 0 else ~k for k in group]
        if not places or max(places) >= inputs or len(set(places)) < len(places):
            raise ValueError(
                f"A group names inputs 0 to {inputs - 1} (or ~k), each once, at least one; got {list(group)}."
            )
        weight[g, places] = [1.0 if k >= 0 else -1.0 for k in group]
        bias[g] = sum(k < 0 for k in group) - threshold(len(group))
    return Linear(weight, bias), Step()


def _check_classes(x: ArrayLike, labels: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Return samples (n, d) and their classes (n,)."""
    x, labels = check_nonfinite(check_float_array(x, "x").astype(np.float64), "x"), np.asarray(labels)
    if x.ndim != 2 or len(x) == 0 or labels.shape != x.shape[:1] or not np.isin(labels, (0, 1)).all():
        raise ValueError(
            f"x must be (n, d) with n above 0 and labels (n,) of 0 and 1, got {x.shape} and {labels.shape}."
        )
    return x, labels.astype(int)
