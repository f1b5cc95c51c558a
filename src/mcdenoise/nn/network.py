"""Chapter 08: a multi-layer perceptron is a list of layers, and its backward pass the same list from behind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np

from mcdenoise.nn.layers import Layer, Linear, Sigmoid
from mcdenoise.samples.gate import check_bandwidth, check_count, check_float_array

DTYPES = (np.float32, np.float64)


@dataclass(frozen=True, eq=False)
class MLP:
    """A multi-layer perceptron: features are outputs of perceptrons, and the input of the next ones.

    Parameters
    ----------
    layers : in the order of the forward pass, at least one `Linear` among them, all of one dtype

    Raises
    ------
    ValueError
        If there is no `Linear`, if the widths of neighbours do not fit, or dtypes differ.

    References
    ----------
    Lecture, "Multi-layer perceptron"; Rumelhart, Hinton and Williams, Nature 323, 1986,
    https://doi.org/10.1038/323533a0

    Examples
    --------
    >>> mlp = MLP.random([2, 3, 1], rng=np.random.default_rng(0))
    >>> y, saved = mlp.forward(np.zeros((4, 2)))
    >>> d_x, gradients = mlp.backward(np.ones((4, 1)), saved)
    >>> y.shape, d_x.shape, {name: gradient.shape for name, gradient in gradients.items()}
    ((4, 1), (4, 2), {'weight_1': (3, 2), 'bias_1': (3,), 'weight_2': (1, 3), 'bias_2': (1,)})
    """

    layers: tuple[Layer, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "layers", tuple(self.layers))
        linear = [layer for layer in self.layers if isinstance(layer, Linear)]
        if not linear:
            raise ValueError("An MLP needs at least one Linear layer, got none.")
        for number, (one, other) in enumerate(pairwise(linear), 1):
            if one.weight.shape[0] != other.weight.shape[1]:
                raise ValueError(
                    f"Linear layer {number + 1} must take the {one.weight.shape[0]} outputs of layer {number} (its weight "
                    f"is {one.weight.shape}), got the weight {other.weight.shape}."
                )
        kinds = sorted({array.dtype.name for array in self.parameters.values()})
        if len(kinds) > 1:
            raise ValueError(f"All parameters of an MLP must have one dtype, got {' and '.join(kinds)}.")

    @classmethod
    def random(
        cls,
        widths: Sequence[int],
        *,
        hidden: Layer | None = None,
        output: Layer | None = None,
        rng: np.random.Generator,
        gain: float = 1.0,
        dtype: type = np.float64,
    ) -> MLP:
        """A network with random weights, normal with the standard deviation gain / sqrt(d_in), and biases of 0.

        Parameters
        ----------
        widths : of the input, the hidden layers and the output: ``[36, 10, 6]`` has one hidden layer of 10.
        hidden : activation behind every hidden layer; None: `Sigmoid`.
        output : activation behind the last layer; None: none.
        rng : where the weights come from. The same state, the same network.
        gain : sqrt(2) suits ReLU, which lets half of its input through; 1 suits the others.
        dtype : float32 or float64.

        Examples
        --------
        >>> MLP.random([36, 10, 6], rng=np.random.default_rng(0)).size
        436
        """
        widths = [check_count(width, "a width") for width in widths]
        if len(widths) < 2:
            raise ValueError(f"widths must name at least those of input and output, got {widths}.")
        if np.dtype(dtype) not in DTYPES:
            raise ValueError(f"dtype must be float32 or float64, got {np.dtype(dtype)}.")
        gain, layers = check_bandwidth(gain, "gain"), []
        for d_in, d_out in pairwise(widths):
            weight = rng.standard_normal((d_out, d_in)) * (gain / np.sqrt(d_in))
            layers += [Linear(weight.astype(dtype), np.zeros(d_out, dtype)), hidden or Sigmoid()]
        return cls((*layers[:-1], output) if output else tuple(layers[:-1]))

    @cached_property
    def parameters(self) -> Mapping[str, np.ndarray]:
        """All weights and biases: ``weight_1``, ``bias_1`` of the first `Linear`, ``weight_2``, ...; read-only."""
        found = {f"{name}_{k}": array for k, layer in self._numbered for name, array in layer.parameters.items()}
        return MappingProxyType(found)

    @property
    def size(self) -> int:
        """How many weights and biases there are."""
        return sum(array.size for array in self.parameters.values())

    @property
    def dtype(self) -> np.dtype:
        """float32 or float64: that of the parameters, and of all that is computed."""
        return self.parameters["weight_1"].dtype

    @property
    def inputs(self) -> int:
        """d_in of the first `Linear`."""
        return self.parameters["weight_1"].shape[1]

    def replace(self, parameters: Mapping[str, np.ndarray]) -> MLP:
        """The same network with other parameters, of the same names and shapes.

        Examples
        --------
        >>> mlp = MLP((Linear(np.ones((1, 2)), np.zeros(1)),))
        >>> mlp.replace({**mlp.parameters, "bias_1": np.ones(1)}).forward(np.zeros((1, 2)))[0]
        array([[1.]])
        """
        known = self.parameters
        if parameters.keys() != known.keys():
            raise ValueError(f"The parameters of this MLP are {', '.join(known)}; got {', '.join(parameters)}.")
        for name, array in parameters.items():
            if np.shape(array) != known[name].shape:
                raise ValueError(f"{name} has shape {known[name].shape} in this MLP, got {np.shape(array)}.")
        return MLP(
            tuple(
                layer.replace({name: parameters[f"{name}_{k}"] for name in layer.parameters})
                for k, layer in self._numbered
            )
        )

    def forward(self, x: object) -> tuple[np.ndarray, list[Any]]:
        """Run a batch through all layers.

        Parameters
        ----------
        x : (n, d_in); n may be 0. Taken in the dtype of the network.

        Returns
        -------
        y : (n, d_out)
        saved : what each layer saved, for `backward`
        """
        y, saved = check_float_array(x, "x").astype(self.dtype, copy=False), []
        for layer in self.layers:
            y, one = layer.forward(y)
            saved.append(one)
        return y, saved

    def backward(self, d_y: np.ndarray, saved: list[Any]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Run a gradient back through all layers: the chain rule, a layer at a time.

        Parameters
        ----------
        d_y : (n, d_out), gradient of a loss with respect to y
        saved : what `forward` returned with y

        Returns
        -------
        d_x : (n, d_in)
        gradients : of each parameter, by name
        """
        return self._back(d_y, saved, 0)

    def gradients(self, d_y: np.ndarray, saved: list[Any]) -> dict[str, np.ndarray]:
        """The gradients of `backward` without d_x, which training does not need: that of x costs one large product."""
        if not isinstance(self.layers[0], Linear):
            return self.backward(d_y, saved)[1]
        d_y, gradients = self._back(d_y, saved, 1)
        return {f"{name}_1": one for name, one in self.layers[0].gradients(d_y, saved[0]).items()} | gradients

    def _back(self, d_y: np.ndarray, saved: list[Any], first: int) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """From the last layer to the one of index `first`."""
        gradients: dict[str, np.ndarray] = {}
        for (k, layer), one in zip(reversed(self._numbered[first:]), reversed(saved[first:]), strict=True):
            d_y, found = layer.backward(d_y, one)
            gradients = {f"{name}_{k}": gradient for name, gradient in found.items()} | gradients
        return d_y, gradients

    @cached_property
    def _numbered(self) -> list[tuple[int, Layer]]:
        """The layers, each with the number of `Linear` layers up to it."""
        numbers = np.cumsum([isinstance(layer, Linear) for layer in self.layers]).tolist()
        return list(zip(numbers, self.layers, strict=True))
