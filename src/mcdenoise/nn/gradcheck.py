"""Chapter 08: is a backward pass right? Ask the forward pass: change one number a little, and see what comes out.

Central differences in float64, (f(x + h) - f(x - h)) / 2h, against what the backward pass says. A failure names the
function, the input, the place and both numbers, and guesses which of the usual mistakes it is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from mcdenoise.nn.gradguess import guess_numbers, guess_shape
from mcdenoise.nn.layers import Layer
from mcdenoise.nn.losses import Loss
from mcdenoise.nn.network import MLP
from mcdenoise.samples.gate import check_bandwidth, check_nonfinite

SMALL = 4096  # entries of the Jacobian: up to there all are compared
ENTRIES = 512  # numbers of an input: above, differences are taken along random directions
LARGE = 1_000_000  # entries of the Jacobian: above, likewise
DIRECTIONS = 3
STEP = 6e-6  # the cube root of float64's precision: rounding and curvature err about equally
ROUNDING = 8e-16
COARSE = 1e-2  # slopes over this distance say how large a slope is here, even at the bottom of a bowl
KINK = 1e-2  # of that slope; from one side to the other a smooth one changes by about 2 STEP / COARSE of it


class GradientError(AssertionError):
    """A backward pass is wrong; the message says where, by how much, and what it looks like."""


class Pair(NamedTuple):
    """A function and its backward pass.

    Attributes
    ----------
    forward : called with the inputs by name; returns (y, saved), y a number or an array
    backward : called with (d_y, saved); returns a dict, input -> gradient, or a tuple in the order of the inputs
    name : for messages
    """

    forward: Callable[..., tuple[Any, Any]]
    backward: Callable[[Any, Any], Any]
    name: str = ""


def check_gradient(
    function: Pair | tuple | Layer | MLP | Loss,
    inputs: Mapping[str, object],
    *,
    fixed: Mapping[str, object] | None = None,
    tolerance: float = 1e-6,
    seed: int = 0,
) -> float:
    """Compare a backward pass with central differences of its forward pass, in float64.

    Small functions have each entry of their Jacobian compared, one output at a time. Large ones are compared along
    random projections: of the outputs, <d_y, y>, and of an input with more than 512 numbers too.

    Parameters
    ----------
    function : a `Pair` or tuple (forward, backward); a layer, an `MLP`, whose parameters are checked as well; or a loss.
    inputs : name -> array, all of which have a gradient. Keep away from kinks, such as x = 0 of a ReLU.
    fixed : name -> array, further inputs, without one, such as the target of a loss.
    tolerance : for |received - expected| / max(|received|, |expected|), lengths of vectors.
    seed : of the random projections.

    Returns
    -------
    The worst relative error; what rounding can explain counts less.

    Raises
    ------
    GradientError
        (an AssertionError) If a gradient is wrong, has another shape, is missing or not finite; if either pass changes
        its inputs or what was saved.
    ValueError
        For an input that is not finite.

    Examples
    --------
    >>> def forward(x):
    ...     return x**2, x
    >>> check_gradient((forward, lambda d_y, x: {"x": d_y * 2 * x}), {"x": [1.0, 3.0]}) < 1e-8
    True
    >>> check_gradient((forward, lambda d_y, x: {"x": d_y * x}), {"x": [1.0, 3.0]})
    Traceback (most recent call last):
    ...
    mcdenoise.nn.gradcheck.GradientError: forward: gradient of x, shape (2,): relative error 0.5; worst at [1]: received \
-0.3963, expected -0.7926. Half of what is expected: is a factor of 2 missing?
    """
    pair, given = _as_pair(function, inputs)
    arrays = {name: check_nonfinite(np.array(value, np.float64), name) for name, value in given.items()}
    constants = {name: np.asarray(value) for name, value in (fixed or {}).items()}
    check_bandwidth(tolerance, "tolerance")
    name = pair.name or getattr(pair.forward, "__name__", "function")
    check = _Check(name, pair, arrays, constants, tolerance, np.random.default_rng(seed))
    return check.run()


class _Check:
    """One run of `check_gradient`."""

    def __init__(self, name, pair, inputs, fixed, tolerance, rng) -> None:
        self.name, self.pair, self.inputs, self.fixed = name, pair, inputs, fixed
        self.tolerance, self.rng, self.worst = tolerance, rng, 0.0
        self.y, self.saved = self.forward(inputs, watch=True)

    def run(self) -> float:
        """Compare with a random d_y first, then, if there are few, with each output by itself."""
        differences = {name: self.differences(name) for name in self.inputs}
        for number, d_y in enumerate(self.projections()):
            received = self.backward(d_y, watch=number == 0)
            for name, (along, change) in differences.items():
                expected = np.tensordot(change, d_y, d_y.ndim)
                self.compare(name, received, along, expected, d_y)
        return self.worst

    def projections(self):
        """The d_y to try."""
        yield np.asarray(self.rng.standard_normal(self.y.shape))
        if self.y.size > 1 and self.y.size * sum(array.size for array in self.inputs.values()) <= SMALL:
            for place in np.ndindex(self.y.shape):
                d_y = np.zeros(self.y.shape)
                d_y[place] = 1.0
                yield d_y

    def differences(self, name: str) -> tuple[np.ndarray | None, np.ndarray]:
        """Return the directions (None: each number by itself) and dy along each, (directions, *y.shape)."""
        x = self.inputs[name]
        if x.size <= ENTRIES and x.size * self.y.size <= LARGE:
            return None, self.jacobian(name, list(np.ndindex(x.shape)))
        along = self.rng.standard_normal((DIRECTIONS, *x.shape)) / np.sqrt(x.size)
        return along, np.array([self.central(name, slice(None), STEP * one, STEP) for one in along])

    def jacobian(self, name: str, places: list[tuple[int, ...]]) -> np.ndarray:
        """dy / d number at some places of an input, (places, *y.shape)."""
        x = self.inputs[name]
        steps = STEP * np.maximum(1.0, np.abs(x))
        change = [self.central(name, place, steps[place]) for place in places]
        return np.array(change).reshape(len(places), *self.y.shape)

    def central(self, name: str, place, step, length: float | None = None) -> np.ndarray:
        """(f(x + step) - f(x - step)) / 2 length."""
        ends = []
        for sign in (1, -1):
            moved = self.inputs[name].copy()
            moved[place] += sign * step
            ends.append(self.forward({**self.inputs, name: moved})[0])
        return (ends[0] - ends[1]) / (2 * (step if length is None else length))

    def forward(self, inputs: dict[str, np.ndarray], watch: bool = False) -> tuple[np.ndarray, Any]:
        """Run forward on copies."""
        copies = {name: array.copy() for name, array in (inputs | self.fixed).items()}
        result = self.call("forward", lambda: self.pair.forward(**copies))
        if not (isinstance(result, tuple) and len(result) == 2):
            raise GradientError(f"{self.name}: forward must return (y, saved), got {type(result).__name__}.")
        if watch:
            self.copies = copies
            self.unchanged("forward")
        y = np.asarray(result[0], np.float64)
        if not np.isfinite(y).all():
            raise GradientError(f"{self.name}: forward gives NaN or infinity here; choose other inputs.")
        return y.copy(), result[1]

    def backward(self, d_y: np.ndarray, watch: bool = False) -> dict[str, np.ndarray]:
        """Run backward; the first time also twice, and look for what it overwrites."""
        received = self.gradients(d_y)
        if watch:
            self.unchanged("backward")
            again = self.gradients(d_y)
            for name in received:
                if not np.array_equal(received[name], again[name], equal_nan=True):
                    raise GradientError(
                        f"{self.name}: gradient of {name}: a second call of backward gives another one. It overwrites what "
                        f"forward saved, or adds to what it gave before."
                    )
        return received

    def gradients(self, d_y: np.ndarray) -> dict[str, np.ndarray]:
        """What backward returns, as a dict of float64 arrays, copied."""
        upstream = d_y.copy() if d_y.ndim else float(d_y)
        found = self.call("backward", lambda: self.pair.backward(upstream, self.saved))
        if not isinstance(found, Mapping):
            found = found if isinstance(found, tuple) else (found,)
            if len(found) != len(self.inputs):
                raise GradientError(f"{self.name}: {len(self.inputs)} gradients are needed, {len(found)} came back.")
            found = dict(zip(self.inputs, found, strict=True))
        missing = [name for name in self.inputs if found.get(name) is None]
        if missing:
            raise GradientError(f"{self.name}: there is no gradient of {', '.join(missing)}.")
        return {name: np.array(found[name], np.float64) for name in self.inputs}

    def call(self, which: str, run: Callable[[], Any]) -> Any:
        """Run a pass; what goes wrong inside is said with the shapes that came in."""
        try:
            return run()
        except (ValueError, TypeError, IndexError, KeyError) as error:
            shapes = {name: array.shape for name, array in self.inputs.items()}
            if which == "backward":
                shapes["d_y"] = self.y.shape
            words = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
            raise GradientError(f"{self.name}: {which} failed with {words}: {error}") from error

    def unchanged(self, which: str) -> None:
        """Refuse a pass that changed an input."""
        for name, array in self.copies.items():
            if not np.array_equal(array, (self.inputs | self.fixed)[name]):
                raise GradientError(
                    f"{self.name}: {which} overwrites its input {name}. What was saved for backward is wrong then; work on "
                    f"a copy."
                )

    def compare(self, name, received, along, expected, d_y) -> None:
        """Raise unless one gradient is right; keep the worst error."""
        x, gradient = self.inputs[name], received[name]
        where = f"{self.name}: gradient of {name}, shape {x.shape}"
        if gradient.shape != x.shape:
            raise GradientError(f"{where}: received shape {gradient.shape}. {guess_shape(gradient, x.shape)}".strip())
        if not np.isfinite(gradient).all():
            place = tuple(int(k) for k in np.argwhere(~np.isfinite(gradient))[0])
            raise GradientError(f"{where}: NaN or infinity, first at {list(place)}.")
        measured = gradient if along is None else np.tensordot(along, gradient, x.ndim)
        expected = expected.reshape(measured.shape)
        error = float(np.linalg.norm(measured - expected))
        size = max(float(np.linalg.norm(measured)), float(np.linalg.norm(expected)))
        noise = ROUNDING / STEP * float(np.sum(np.abs(d_y * self.y))) * max(expected.size, 1) ** 0.5
        floor = size + noise / self.tolerance  # so that error > tolerance * size + noise is what fails
        relative = error / floor if floor else 0.0
        self.worst = max(self.worst, relative)
        if relative > self.tolerance:
            raise GradientError(f"{where}: relative error {error / size:.2g}; {self.explain(name, gradient, d_y)}")

    def explain(self, name: str, received: np.ndarray, d_y: np.ndarray) -> str:
        """Say where it is worst, and guess why; of a large input only the first numbers are looked at."""
        places = list(islice(np.ndindex(received.shape), ENTRIES if self.y.size * ENTRIES <= LARGE else 1))
        change = self.jacobian(name, places)
        expected = np.tensordot(change, d_y, d_y.ndim)
        found = np.array([received[place] for place in places])
        worst = int(np.argmax(np.abs(found - expected)))
        text = (
            f"worst at {list(places[worst])}: received {found[worst] + 0.0:.4g}, expected {expected[worst] + 0.0:.4g}."
        )
        if np.count_nonzero(d_y) == 1 and d_y.size > 1:
            text = f"for output {[int(k) for k in np.argwhere(d_y)[0]]} alone, {text}"
        guess = (
            self.kink(name, places[worst], d_y)
            or guess_numbers(found, expected, change, d_y, received)
            or self.ignores(name, d_y)
        )
        return f"{text} {guess}".strip()

    def kink(self, name: str, place: tuple[int, ...], d_y: np.ndarray) -> str:
        """Notice that the slopes before and behind a place differ, by more than a curve's would: no gradient is right there."""
        before, behind = self.slope(name, place, d_y, -STEP), self.slope(name, place, d_y, STEP)
        largest = max(abs(self.slope(name, place, d_y, step)) for step in (-COARSE, COARSE))
        if abs(behind - before) <= KINK * largest:
            return ""
        return f"The function has a kink there: its slope is {before:.4g} before and {behind:.4g} behind. Check at other inputs."

    def slope(self, name: str, place: tuple[int, ...], d_y: np.ndarray, step: float) -> float:
        """(<d_y, f(x + step)> - <d_y, f(x)>) / step, one-sided."""
        moved = self.inputs[name].copy()
        moved[place] += step
        return float(np.sum((self.forward({**self.inputs, name: moved})[0] - self.y) * d_y)) / step + 0.0

    def ignores(self, name: str, d_y: np.ndarray) -> str:
        """Notice a backward pass that does not multiply by d_y."""
        same = np.allclose(self.gradients(2 * d_y)[name], self.gradients(d_y)[name], rtol=1e-9)
        return "It does not depend on d_y: the chain rule multiplies by it." if same else ""


def _as_pair(function: object, inputs: Mapping[str, object]) -> tuple[Pair, dict[str, object]]:
    """Return the pair of functions, and all inputs that have a gradient."""
    if isinstance(function, Layer | MLP):
        pair = Pair(
            lambda x, **parameters: _forward_of(function.replace(parameters), x),
            lambda d_y, saved: _flat(*saved[0].backward(d_y, saved[1])),
            type(function).__name__,
        )
        return pair, {**inputs, **function.parameters}
    if isinstance(function, Loss):
        pair = Pair(
            lambda y, target: function.forward(y, target),
            lambda d_y, saved: {"y": d_y * function.backward(saved)},
            type(function).__name__,
        )
        return pair, dict(inputs)
    return Pair(*function), dict(inputs)


def _forward_of(layer: Layer | MLP, x: np.ndarray) -> tuple[np.ndarray, tuple]:
    """Run a layer, and save it with what it saved."""
    y, saved = layer.forward(x)
    return y, (layer, saved)


def _flat(d_x: np.ndarray, gradients: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """All gradients in one dict."""
    return {"x": d_x, **gradients}
