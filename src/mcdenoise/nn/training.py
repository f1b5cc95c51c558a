"""Chapter 08: training. Forward, loss, backward, step; again; and a stop where it runs away."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from tqdm import trange

from mcdenoise.nn.fast import fast_loss_and_gradients, plan_of
from mcdenoise.nn.losses import Loss
from mcdenoise.nn.network import MLP
from mcdenoise.nn.optimizers import RPROP, SGD, Adam
from mcdenoise.samples.gate import ENGINES, check_choice, check_count, check_float_array, check_nonfinite

PART = 4096  # rows that pass at once
RUNAWAY = 1e6  # times the loss at the start: the step is too long, and gets longer


@dataclass(frozen=True, eq=False)
class Training:
    """What a training left.

    Attributes
    ----------
    network : with validation data the one with the smallest validation loss, else the last one
    losses : (epochs,), mean over the steps of each epoch, each before its step
    validation : (epochs,), loss of the validation data after each epoch; empty without
    best : epoch after which `network` was taken, from 0 on

    Examples
    --------
    >>> Training(MLP.random([1, 1], rng=np.random.default_rng(0)), np.array([2.0, 1.0]), np.array([]), 1).losses[-1]
    np.float64(1.0)
    """

    network: MLP
    losses: np.ndarray
    validation: np.ndarray
    best: int


class Diverged(ValueError):
    """The loss ran away, or became NaN. `training` holds the losses until then, and the network with the smallest one."""

    def __init__(self, message: str, training: Training) -> None:
        super().__init__(message)
        self.training = training


def train(
    network: MLP,
    x: object,
    target: object,
    *,
    loss: Loss,
    optimizer: SGD | Adam | RPROP,
    epochs: int,
    batch: int | None = None,
    rng: np.random.Generator | None = None,
    validation: tuple[object, object] | None = None,
    engine: str = "numba",
    progress: bool = False,
) -> Training:
    """Train a network; the one that is given stays as it is.

    Parameters
    ----------
    x : (n, d_in). target : (n, d_out). n at least 1, both finite.
    loss : such as `SquaredError()`
    optimizer : RPROP needs full batches
    epochs : how often all rows are gone through
    batch : rows a step; None: all. The rows are shuffled each epoch, the last step may have fewer.
    rng : for shuffling, needed with `batch`
    validation : x and target that training does not see
    engine : as for `loss_and_gradients`
    progress : show a bar

    Returns
    -------
    Training

    Raises
    ------
    Diverged
        (a ValueError) If the loss or a parameter is not finite, or the loss is a million times what it was at first or
        what the answer 0 has. Its `training` holds the network with the smallest loss until then.
    ValueError
        For data that is not finite or does not fit, for a `batch` without `rng`, for RPROP in batches.

    Examples
    --------
    >>> x = np.linspace(-1, 1, 20)[:, np.newaxis]
    >>> from mcdenoise.nn.losses import SquaredError
    >>> start = MLP.random([1, 1], rng=np.random.default_rng(0))
    >>> done = train(start, x, 3 * x + 1, loss=SquaredError(), optimizer=SGD(0.5), epochs=100)
    >>> done.network.parameters["weight_1"].round(3), done.network.parameters["bias_1"].round(3)
    (array([[3.]]), array([1.]))
    """
    x, target = _check_data(x, target, network, "")
    rows = len(x) if batch is None else check_count(batch, "batch")
    if rows < len(x) and (rng is None or isinstance(optimizer, RPROP)):
        raise ValueError("Batches are shuffled: pass rng as well. RPROP needs all rows at once: leave batch out.")
    if validation is not None:
        validation = _check_data(*validation, network, "validation ")
    state, losses, seen = optimizer.start(network.parameters), [], []
    best, kept, safest = -1, network, network
    limit = RUNAWAY * max(loss.forward(y, target)[0] for y in (network.forward(x)[0], np.zeros_like(target)))
    for epoch in trange(
        check_count(epochs, "epochs"), desc="training", unit="epoch", disable=not progress, leave=False
    ):
        parts = [slice(None)] if rows >= len(x) else np.split(rng.permutation(len(x)), range(rows, len(x), rows))
        before, found = network, []
        for part in parts:
            network, state, value = _step(network, state, x[part], target[part], loss.rows(part), optimizer, engine)
            found.append(value)
            if not value <= limit or not all(np.isfinite(array).all() for array in network.parameters.values()):
                left = Training(kept if validation else safest, np.array(losses), np.array(seen), best)
                raise Diverged(_words(epoch, losses, value, optimizer), left)
        losses.append(float(np.mean(found)))
        if losses[-1] <= min(losses):
            safest = before
        if validation is not None:
            seen.append(loss.forward(network.forward(validation[0])[0], validation[1])[0])
        if validation is None or seen[-1] <= min(seen):
            kept, best = network, epoch
    return Training(kept, np.array(losses), np.array(seen), best)


def _step(
    network: MLP, state: dict, x: np.ndarray, target: np.ndarray, loss: Loss, optimizer: SGD | Adam | RPROP, engine: str
) -> tuple[MLP, dict, float]:
    """One step: the network and the state after it, and the loss before it."""
    with np.errstate(over="ignore", invalid="ignore"):  # found by the caller, and said in words
        value, gradients = loss_and_gradients(network, x, target, loss, engine=engine)
        parameters, state = optimizer.step(network.parameters, gradients, state)
    return network.replace(parameters), state, value


def loss_and_gradients(
    network: MLP, x: np.ndarray, target: np.ndarray, loss: Loss, *, engine: str = "numba"
) -> tuple[float, dict[str, np.ndarray]]:
    """Forward and backward: the loss of a batch, and its gradients by the name of the parameter.

    Parameters
    ----------
    x : (n, d_in). target : (n, d_out), as `loss` needs it.
    engine : ``"numba"`` runs float32 networks by a kernel and all others in NumPy; ``"numpy"`` runs all in NumPy.

    In NumPy a large batch passes in parts of 4096 rows, whose arrays stay in the cache. The loss is a mean over the rows, so
    what is returned is the mean over the parts, weighted by their rows.

    Examples
    --------
    >>> from mcdenoise.nn.layers import Linear
    >>> from mcdenoise.nn.losses import SquaredError
    >>> mlp = MLP((Linear(np.ones((1, 1)), np.zeros(1)),))
    >>> loss_and_gradients(mlp, np.array([[3.0]]), np.array([[1.0]]), SquaredError())
    (2.0, {'weight_1': array([[6.]]), 'bias_1': array([2.])})
    """
    plan = plan_of(network) if check_choice(engine, ENGINES, "engine") == "numba" else None
    if plan and np.ndim(x) == 2 and np.shape(x)[1] == network.inputs:  # else `forward` refuses in words
        return fast_loss_and_gradients(network, x, target, loss, plan)
    if len(x) <= PART:
        y, saved = network.forward(x)
        value, saved_by_loss = loss.forward(y, target)
        return value, network.gradients(loss.backward(saved_by_loss), saved)
    total, sums = 0.0, {name: np.zeros_like(array) for name, array in network.parameters.items()}
    for start in range(0, len(x), PART):
        part = slice(start, start + PART)
        value, gradients = loss_and_gradients(network, x[part], target[part], loss.rows(part), engine="numpy")
        share = len(x[part]) / len(x)
        total += share * value
        for name, gradient in gradients.items():
            sums[name] += share * gradient
    return total, sums


def _check_data(x: object, target: object, network: MLP, what: str) -> tuple[np.ndarray, np.ndarray]:
    """Return finite rows in the dtype of the network, at least one."""
    arrays = [
        check_nonfinite(check_float_array(one, what + name), what + name)
        for name, one in (("x", x), ("target", target))
    ]
    shapes = " and ".join(str(array.shape) for array in arrays)
    if any(array.ndim != 2 for array in arrays) or len(arrays[0]) != len(arrays[1]) or len(arrays[0]) == 0:
        raise ValueError(f"{what}x and target must be (n, d_in) and (n, d_out) with one n above 0, got {shapes}.")
    return arrays[0].astype(network.dtype, copy=False), arrays[1].astype(network.dtype, copy=False)


def _words(epoch: int, losses: list[float], value: float, optimizer: object) -> str:
    """Say what happened, and what helps."""
    first = (
        f"the loss was {losses[0]:.3g} in the first epoch and is {value:.3g} now"
        if losses
        else f"its loss is {value:.3g}"
    )
    return (
        f"Training diverged in epoch {epoch + 1}: {first}, with {optimizer}. Take a smaller step (a tenth of it). The network "
        f"with the smallest loss until then is in the error's `training.network`."
    )
