"""Chapter 09: the loss of the whole chain. Network outputs in, relative error of the filtered images out, and back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcdenoise.lbf.layer import FilterLayer, Saved
from mcdenoise.lbf.model import LBFModel
from mcdenoise.nn import RelativeError


@dataclass(frozen=True, eq=False)
class Example:
    """Rows of one noisy image, ready for training.

    Attributes
    ----------
    layer : the filter, with the rows that count
    inputs : (n, inputs), of the network, n pixels
    target : (n, 3), the reference
    weight : of the image's errors in the loss
    """

    layer: FilterLayer
    inputs: np.ndarray
    target: np.ndarray
    weight: float = 1.0


@dataclass(frozen=True, eq=False)
class FilterLoss:
    """The relative error of filtered images as a loss on what the network puts out.

    E = mean over pixels of n/2 sum_q (c_hat_q - c_q)^2 / (c_q^2 + 0.01), n the spp of the pixel's image

    It goes where any loss of `nn` goes: the gradient of the last filter weight is one chain rule,
    dE/dw = sum_m [sum_q dE/dc_hat_q dc_hat_q/dtheta_m] dtheta_m/dw.

    Attributes
    ----------
    model : which outputs are which bandwidths
    examples : in the order of the rows of y
    """

    model: LBFModel
    examples: Sequence[Example]

    def forward(self, y: np.ndarray, target: np.ndarray) -> tuple[float, tuple]:
        """Return the loss, and what `backward` needs."""
        filtered, saved = [], []
        for part, example in self._parts(y):
            theta = self.model.arrange(part, example.layer.primary.groups).reshape(example.layer.shape)
            one, kept = example.layer.forward(theta)
            filtered.append(one.reshape(-1, 3))
            saved.append(kept)
        value, of_error = self._error.forward(np.concatenate(filtered), target)
        return value, (of_error, saved, y.dtype)

    def backward(self, saved: tuple) -> np.ndarray:
        """Return dE/dy, (n, outputs)."""
        of_error, of_layers, dtype = saved
        d_filtered, found = self._error.backward(of_error), []
        for (part, example), kept in zip(self._parts(d_filtered), of_layers, strict=True):
            found.append(self._back(example, part, kept))
        return np.concatenate(found).astype(dtype, copy=False)

    def rows(self, part: slice) -> FilterLoss:
        """Only whole images can be filtered, so this loss is never cut into parts."""
        if part == slice(None):
            return self
        raise ValueError("A filter needs whole images: train it in full batches.")

    def error_of(self, images: Sequence[np.ndarray], target: np.ndarray) -> float:
        """The loss of images, (rows, w, 3) for each example, whatever made them."""
        return self._error.forward(np.concatenate([image.reshape(-1, 3) for image in images]), target)[0]

    @property
    def _error(self) -> RelativeError:
        """The relative error, with spp and weight of every row."""
        each = [np.full(len(e.inputs), e.weight * e.layer.primary.spp) for e in self.examples]
        return RelativeError(np.concatenate(each))

    def _back(self, example: Example, d_filtered: np.ndarray, saved: Saved) -> np.ndarray:
        """From the gradient of one image's filtered colours to that of the network's outputs."""
        layer = example.layer
        d_theta = layer.backward(d_filtered.reshape(*layer.shape[:2], 3), saved)
        return self.model.arrange_back(d_theta.reshape(len(d_filtered), -1), layer.primary.groups)

    def _parts(self, values: np.ndarray) -> list[tuple[np.ndarray, Example]]:
        """The rows of each example."""
        ends = np.cumsum([len(example.inputs) for example in self.examples])
        return list(zip(np.split(values, ends[:-1]), self.examples, strict=True))
