"""Which networks the kernel can run, and how they are handed to it."""

from __future__ import annotations

import numpy as np

from mcdenoise.nn.layers import Linear, ReLU, Sigmoid, Softplus, Tanh
from mcdenoise.nn.losses import Loss
from mcdenoise.nn.network import MLP

CODES = {Sigmoid: 1, Tanh: 2, ReLU: 3, Softplus: 4}  # as in kernels/network.py; 0 is no activation


def plan_of(network: MLP) -> tuple[list[int], list[int]] | None:
    """Widths and activations of a float32 network for the kernel; None if it is not for it.

    The kernel runs `Linear` layers, each with at most one smooth activation or ReLU behind it, in float32.

    Examples
    --------
    >>> plan_of(MLP.random([36, 10, 6], output=Softplus(), rng=np.random.default_rng(0), dtype=np.float32))
    ([36, 10, 6], [1, 4])
    >>> plan_of(MLP.random([36, 10, 6], rng=np.random.default_rng(0), dtype=np.float64)) is None
    True
    """
    if network.dtype != np.float32:
        return None
    widths, activations = [network.inputs], []
    free = False  # the last layer was a Linear, so an activation may follow
    for layer in network.layers:
        if type(layer) is Linear:
            widths.append(len(layer.bias))
            activations.append(0)
        elif free and type(layer) in CODES:
            activations[-1] = CODES[type(layer)]
        else:
            return None
        free = type(layer) is Linear
    return widths, activations


def fast_loss_and_gradients(
    network: MLP, x: np.ndarray, target: np.ndarray, loss: Loss, plan: tuple[list[int], list[int]]
) -> tuple[float, dict[str, np.ndarray]]:
    """The twin of `loss_and_gradients` for a network that has a plan.

    Examples
    --------
    >>> from mcdenoise.nn.losses import SquaredError
    >>> mlp = MLP((Linear(np.ones((1, 1), np.float32), np.zeros(1, np.float32)),))
    >>> fast_loss_and_gradients(mlp, np.array([[3.0]]), np.array([[1.0]]), SquaredError(), plan_of(mlp))
    (2.0, {'weight_1': array([[6.]], dtype=float32), 'bias_1': array([2.], dtype=float32)})
    """
    from mcdenoise.kernels.network import network_backward, network_forward

    parameters = network.parameters
    flat = np.concatenate([array.ravel() for array in parameters.values()])
    x = np.ascontiguousarray(x, np.float32)
    value, saved = loss.forward(network_forward(x, flat, *plan), target)
    found = network_backward(loss.backward(saved), x, flat, *plan)
    ends = np.cumsum([array.size for array in parameters.values()])[:-1]
    pieces = zip(parameters.items(), np.split(found, ends), strict=True)
    return value, {name: piece.reshape(array.shape) for (name, array), piece in pieces}
