"""Chapter 09: what are the optimal parameters? A search with the reference: the bound of this family of filters."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from tqdm import trange

from mcdenoise.lbf.layer import FilterLayer
from mcdenoise.nn import RPROP
from mcdenoise.samples.gate import check_count, check_float_array, check_nonfinite

EPSILON = 0.01  # radiance squared, as in relMSE
SPACE = (1.0, 2.0, 4.0, 8.0, 30.0)  # sigma of position, pixels
FEATURES = (0.01, 0.1, 1.0)  # theta of every group of features
LOWEST, HIGHEST = np.log(1e-6), np.log(400.0)
FIRST_STEP, LARGEST_STEP = 0.3, 2.0


@dataclass(frozen=True, eq=False)
class Oracle:
    """The best that one filter can do.

    Attributes
    ----------
    image : (rows, w, 3), filtered with the best theta of every pixel
    theta : (rows, w, names), that theta
    shared_image, shared_theta : with the best theta of all pixels together, (names,)
    errors : relMSE of the best image after each step
    """

    image: np.ndarray
    theta: np.ndarray
    shared_image: np.ndarray
    shared_theta: np.ndarray
    errors: tuple[float, ...]


def oracle(
    layer: FilterLayer,
    reference: object,
    *,
    colour_theta: float | None = None,
    steps: int = 40,
    progress: bool = False,
) -> Oracle:
    """Search theta of every pixel for the smallest relative error against the reference.

    Each pixel is a problem of its own: from the best of 15 usual settings gradient descent goes on, by RPROP on
    log theta, with the gradient of the layer's backward pass; the best theta that was met is kept. It is a bound that
    nobody reaches: no filter knows the reference, and with that much freedom part of the noise is fitted.

    Parameters
    ----------
    layer : whose filter it is
    reference : (h, w, 3)
    colour_theta : theta of the colour's distance, the same everywhere; None: searched too
    steps : of the descent

    Raises
    ------
    ValueError
        For a reference of another shape, or not finite.

    Examples
    --------
    >>> from mcdenoise.lbf.primary import Primary
    >>> image = np.random.default_rng(0).random((8, 8, 3)).astype(np.float32)
    >>> found = oracle(FilterLayer(Primary(image, image, {}, {}, {}, spp=4), engine="numpy"), np.full((8, 8, 3), 0.5), steps=5)
    >>> found.errors[-1] < found.errors[0]
    True
    """
    reference = check_nonfinite(check_float_array(reference, "reference"), "reference")
    if reference.shape != layer.primary.colour.shape:
        raise ValueError(
            f"reference must have the shape of the image, {layer.primary.colour.shape}, got {reference.shape}."
        )
    truth, check_steps = reference[layer.rows], check_count(steps, "steps", least=0)
    scale = truth**2 + EPSILON
    best = _Best(layer, truth)
    shared = min((_start(layer, colour_theta, *setting) for setting in product(SPACE, FEATURES)), key=best.try_theta)
    shared_image, shared_error = layer.forward(shared)[0], best.error.mean()
    optimizer, errors = RPROP(first=FIRST_STEP, largest=LARGEST_STEP), [float(shared_error)]
    logs = {"theta": np.log(best.theta)}
    state = optimizer.start(logs)
    for _ in trange(check_steps, desc="oracle", unit="step", disable=not progress, leave=False):
        theta = np.exp(logs["theta"])
        filtered, saved = best.keep(theta)
        slope = layer.backward((filtered - truth) / scale, saved) * theta
        if colour_theta is not None:
            slope[..., 1] = 0
        logs, state = optimizer.step(logs, {"theta": slope}, state)
        logs = {"theta": np.clip(logs["theta"], LOWEST, HIGHEST)}
        errors.append(float(best.error.mean()))
    image, shared_theta = layer.forward(best.theta)[0], shared[0, 0]
    return Oracle(image, best.theta, shared_image, shared_theta, tuple(errors))


class _Best:
    """The best theta of every pixel that was met, and its error."""

    def __init__(self, layer: FilterLayer, truth: np.ndarray) -> None:
        self.layer, self.truth = layer, truth
        self.error = np.full(layer.shape[:2], np.inf)
        self.theta = np.zeros(layer.shape)

    def keep(self, theta: np.ndarray) -> tuple[np.ndarray, tuple]:
        """Filter, and keep theta where the error is smaller than any before."""
        filtered, saved = self.layer.forward(theta)
        error = np.mean((filtered - self.truth) ** 2 / (self.truth**2 + EPSILON), axis=-1)
        better = error < self.error
        self.error[better], self.theta[better] = error[better], theta[better]
        self.last = float(error.mean())
        return filtered, saved

    def try_theta(self, theta: np.ndarray) -> float:
        """Keep, and return the error of the whole image."""
        self.keep(theta)
        return self.last


def _start(layer: FilterLayer, colour_theta: float | None, sigma_space: float, feature_theta: float) -> np.ndarray:
    """One setting for all pixels."""
    theta = np.full(layer.shape, feature_theta)
    theta[..., 0] = 1 / (2 * sigma_space**2)
    theta[..., 1] = 0.01 if colour_theta is None else colour_theta
    return theta
