"""Chapter 08: what to do with a gradient. Each optimizer is a pure step: parameters, gradients and state in, new ones out.

The state is a dict of named arrays, so a training can be stored and go on later to the same result.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mcdenoise.samples.gate import check_bandwidth, check_share

Arrays = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class SGD:
    """Gradient descent with momentum: velocity = momentum velocity - rate gradient, parameter += velocity.

    Parameters
    ----------
    rate : step along the gradient, > 0
    momentum : share of the last velocity that is kept, [0, 1); 0 is plain gradient descent

    Examples
    --------
    >>> descent = SGD(rate=0.5)
    >>> parameters = {"w": np.array([1.0])}
    >>> descent.step(parameters, {"w": np.array([2.0])}, descent.start(parameters))[0]
    {'w': array([0.])}
    """

    rate: float
    momentum: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "rate", check_bandwidth(self.rate, "rate"))
        _check_below_one(self.momentum, "momentum")

    def start(self, parameters: Arrays) -> dict[str, np.ndarray]:
        """The state before the first step: no velocity."""
        return {f"velocity.{name}": np.zeros_like(array) for name, array in parameters.items()}

    def step(self, parameters: Arrays, gradients: Arrays, state: Arrays) -> tuple[dict, dict]:
        """Return new parameters and the new state."""
        new, velocities = {}, {}
        for name, array in parameters.items():
            velocity = self.momentum * state[f"velocity.{name}"] - self.rate * gradients[name]
            new[name], velocities[f"velocity.{name}"] = array + velocity, velocity
        return new, velocities


@dataclass(frozen=True)
class Adam:
    """Steps of about `rate` in each parameter: the running mean of gradients over the root of that of their squares.

    Both means start at 0 and are divided by 1 - beta^t, which makes up for that.

    Parameters
    ----------
    rate : > 0. beta_1, beta_2 : what the means keep at each step, [0, 1). epsilon : > 0, against division by zero.

    References
    ----------
    Kingma and Ba, ICLR 2015, https://arxiv.org/abs/1412.6980

    Examples
    --------
    >>> adam = Adam(rate=0.1)
    >>> parameters = {"w": np.array([1.0, 1.0])}
    >>> new, state = adam.step(parameters, {"w": np.array([2.0, -300.0])}, adam.start(parameters))
    >>> new["w"].round(6)
    array([0.9, 1.1])
    """

    rate: float = 1e-3
    beta_1: float = 0.9
    beta_2: float = 0.999
    epsilon: float = 1e-8

    def __post_init__(self) -> None:
        object.__setattr__(self, "rate", check_bandwidth(self.rate, "rate"))
        check_bandwidth(self.epsilon, "epsilon")
        _check_below_one(self.beta_1, "beta_1")
        _check_below_one(self.beta_2, "beta_2")

    def start(self, parameters: Arrays) -> dict[str, np.ndarray]:
        """The state before the first step: both means 0, no step done."""
        zeros = {
            f"{kind}.{name}": np.zeros_like(one) for name, one in parameters.items() for kind in ("mean", "square")
        }
        return {"steps": np.array(0), **zeros}

    def step(self, parameters: Arrays, gradients: Arrays, state: Arrays) -> tuple[dict, dict]:
        """Return new parameters and the new state."""
        t = int(state["steps"]) + 1
        new, after = {}, {"steps": np.array(t)}
        for name, array in parameters.items():
            gradient = gradients[name]
            mean = self.beta_1 * state[f"mean.{name}"] + (1 - self.beta_1) * gradient
            square = self.beta_2 * state[f"square.{name}"] + (1 - self.beta_2) * gradient * gradient
            root = np.sqrt(square / (1 - self.beta_2**t))
            new[name] = array - self.rate / (1 - self.beta_1**t) * mean / (root + self.epsilon)
            after |= {f"mean.{name}": mean, f"square.{name}": square}
        return new, after


@dataclass(frozen=True)
class RPROP:
    """Resilient propagation: each parameter has a step of its own, and only the sign of its gradient counts.

    Where the sign is that of the step before, the step grows by `grow`; where it has changed, the minimum was jumped
    over: the step shrinks by `shrink`, and the parameter stays where it is this time (iRprop-). For full batches: with
    small ones signs change by chance.

    Parameters
    ----------
    first : step at the start, > 0
    grow, shrink : > 1, and in (0, 1)
    smallest, largest : bounds of a step, > 0

    References
    ----------
    Riedmiller and Braun, ICNN 1993, https://doi.org/10.1109/ICNN.1993.298623; Igel and Hüsken, NC 2000 (iRprop-).

    Examples
    --------
    >>> rprop = RPROP(first=0.1)
    >>> parameters, state = {"w": np.array([1.0, 1.0])}, rprop.start({"w": np.array([1.0, 1.0])})
    >>> for gradient in ([9.0, 9.0], [5.0, -1.0]):
    ...     parameters, state = rprop.step(parameters, {"w": np.array(gradient)}, state)
    >>> parameters["w"], state["step.w"]
    (array([0.78, 0.9 ]), array([0.12, 0.05]))
    """

    first: float = 0.01
    grow: float = 1.2
    shrink: float = 0.5
    smallest: float = 1e-6
    largest: float = 50.0

    def __post_init__(self) -> None:
        for name in ("first", "smallest", "largest"):
            check_bandwidth(getattr(self, name), name)
        if not (0 < self.shrink < 1 < self.grow < np.inf and self.smallest <= self.first <= self.largest):
            raise ValueError(
                f"RPROP needs 0 < shrink < 1 < grow and smallest <= first <= largest, got shrink {self.shrink:g}, grow "
                f"{self.grow:g}, steps {self.smallest:g}, {self.first:g}, {self.largest:g}."
            )

    def start(self, parameters: Arrays) -> dict[str, np.ndarray]:
        """The state before the first step: no sign yet, all steps `first`."""
        state = {}
        for name, array in parameters.items():
            state |= {f"sign.{name}": np.zeros_like(array), f"step.{name}": np.full_like(array, self.first)}
        return state

    def step(self, parameters: Arrays, gradients: Arrays, state: Arrays) -> tuple[dict, dict]:
        """Return new parameters and the new state."""
        new, after = {}, {}
        for name, array in parameters.items():
            sign, step = state[f"sign.{name}"], state[f"step.{name}"]
            bounds = self.grow, self.shrink, self.smallest, self.largest
            new[name], sign, step = rprop_step(array, gradients[name], sign, step, *bounds)
            after |= {f"sign.{name}": sign, f"step.{name}": step}
        return new, after


def rprop_step(
    parameter: np.ndarray,
    gradient: np.ndarray,
    sign: np.ndarray,
    step: np.ndarray,
    grow: float,
    shrink: float,
    smallest: float,
    largest: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One step of RPROP, each number of a parameter by itself (all arrays have one shape).

    The sign of the gradient is compared with that of the step before. Equal: the step is multiplied by `grow`. Opposite:
    by `shrink`; the parameter stays where it is, and 0 is remembered as its sign, so that the next step goes on without a
    comparison. One of them 0: the step stays. Then the step is held between `smallest` and `largest`, and the parameter
    goes one step against the sign.

    Parameters
    ----------
    parameter, gradient : the numbers, and dE / d number
    sign : of the gradient in the step before, as it was remembered: -1, 0 or 1
    step : length of the step before, > 0
    grow, shrink, smallest, largest : > 1, in (0, 1), bounds of a step

    Returns
    -------
    The new parameter, the sign to remember, the new step.

    Examples
    --------
    >>> before = np.array([1.0, 1.0]), np.array([5.0, -0.1])
    >>> rprop_step(*before, sign=np.array([1.0, 1.0]), step=np.array([0.1, 0.1]), grow=1.2, shrink=0.5, smallest=0, largest=50)
    (array([0.88, 1.  ]), array([1., 0.]), array([0.12, 0.05]))
    """
    ### BEGIN SOLUTION
    now = np.sign(gradient)
    agree = now * sign
    factor = np.where(agree > 0, grow, np.where(agree < 0, shrink, 1.0)).astype(parameter.dtype)
    step = np.clip(step * factor, smallest, largest)
    sign = np.where(agree < 0, 0, now)
    return parameter - sign * step, sign, step
    ### END SOLUTION


def _check_below_one(value: object, name: str) -> None:
    """Refuse what is not in [0, 1)."""
    if check_share(value, name) == 1:
        raise ValueError(f"{name} must be below 1, got 1: nothing new would ever count.")
