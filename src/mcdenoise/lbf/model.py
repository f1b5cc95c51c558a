"""Chapter 09: the model. From secondary features to the inverse bandwidths of a pixel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from mcdenoise.lbf.layer import LARGEST_THETA, PATCH_RADIUS, RADIUS, VARIANTS, FilterLayer
from mcdenoise.lbf.primary import GROUPS, Primary
from mcdenoise.lbf.secondary import COLOUR, secondary_features, secondary_names
from mcdenoise.lbf.untextured import untextured
from mcdenoise.nn import MLP, Softplus
from mcdenoise.samples.gate import check_bandwidth, check_choice, check_count, check_names

# theta = 1 / (2 sigma^2) at the start of a training: a bell of 5 pixels, and features that differ by 2 deviations.
START = {"position": 0.02, "colour": 0.01} | dict.fromkeys(GROUPS, 0.12)
TINY = 1e-6


@dataclass(frozen=True, eq=False)
class LBFModel:
    """A network that predicts the bandwidths of one filter, with everything that is needed to run it.

    A model knows some groups of features. Where a scene lacks one of them, the filter lacks its distance, and the
    network's inputs of that group are 0, the mean of the training scenes: in training, groups were left out at random in
    the same way. A group that the model does not know is not used.

    Attributes
    ----------
    network : (n, inputs) -> (n, outputs), with `Softplus` at its end
    mean, scale : (inputs,), of the training scenes; the network sees (v - mean) / (scale + 1e-6)
    groups : of features, in the order of `GROUPS`
    variant, radius, patch_radius : of the filter, see `FilterLayer`
    colour_theta : theta of the colour's distance, the same everywhere; None: the network predicts it
    sees_colour : the network sees secondary features of the colour, too; the paper's does not
    divides_albedo : colours are divided by the albedo before the filter, and multiplied after; the paper's are not
    card : how the model came about, as JSON can hold it

    Examples
    --------
    >>> model = LBFModel.random(["albedo"], hidden=[2], rng=np.random.default_rng(0))
    >>> model.outputs, model.network.size
    (('position', 'colour', 'albedo'), 41)
    """

    network: MLP
    mean: np.ndarray
    scale: np.ndarray
    groups: tuple[str, ...]
    variant: str = "cross_bilateral"
    radius: int = RADIUS
    patch_radius: int = PATCH_RADIUS
    colour_theta: float | None = None
    sees_colour: bool = True
    divides_albedo: bool = True
    card: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        groups = check_names(self.groups, GROUPS, "groups")
        object.__setattr__(self, "groups", tuple(group for group in GROUPS if group in groups))
        inputs, outputs = len(self.input_names), len(self.outputs)
        weights = [one for name, one in self.network.parameters.items() if name.startswith("weight")]
        if (weights[0].shape[1], weights[-1].shape[0]) != (inputs, outputs):
            raise ValueError(
                f"A model of {len(self.groups)} groups needs a network with {inputs} inputs and {outputs} outputs, got "
                f"{weights[0].shape[1]} and {weights[-1].shape[0]}."
            )
        if not isinstance(self.network.layers[-1], Softplus):
            raise ValueError("The network must end in Softplus: an inverse bandwidth is never negative.")
        check_choice(self.variant, VARIANTS, "variant")
        for name in ("radius", "patch_radius"):
            check_count(getattr(self, name), name, least=0)
        if np.min(self.scale) < 0:
            raise ValueError(f"scale must not be negative anywhere, got {np.min(self.scale):g}.")
        for name in ("mean", "scale"):
            if np.shape(getattr(self, name)) != (inputs,):
                raise ValueError(f"{name} must have shape {(inputs,)}, got {np.shape(getattr(self, name))}.")
        if self.colour_theta is not None:
            object.__setattr__(self, "colour_theta", check_bandwidth(self.colour_theta, "colour_theta"))

    @classmethod
    def random(
        cls,
        groups: tuple[str, ...] | list[str],
        *,
        hidden: tuple[int, ...] | list[int],
        rng: np.random.Generator,
        dtype: type = np.float32,
        **settings: Any,
    ) -> LBFModel:
        """A model before its training: small random weights, biases that give usual bandwidths everywhere.

        Parameters
        ----------
        groups : names out of `GROUPS`. hidden : widths of the hidden layers (sigmoid). rng : where the weights come from.
        dtype : of the network. settings : the other attributes of `LBFModel`.
        """
        inputs = len(seen_names(groups, settings.get("sees_colour", True)))
        probe = _predicted(groups, settings.get("colour_theta"))
        network = MLP.random([inputs, *hidden, len(probe)], output=Softplus(), rng=rng, gain=0.5, dtype=dtype)
        last = f"bias_{len(hidden) + 1}"
        start = np.array([START[name] for name in probe])
        parameters = {**network.parameters, last: np.log(np.expm1(start)).astype(dtype)}
        return cls(network.replace(parameters), np.zeros(inputs), np.ones(inputs), tuple(groups), **settings)

    @property
    def input_names(self) -> list[str]:
        """What the network sees."""
        return seen_names(self.groups, self.sees_colour)

    @property
    def outputs(self) -> tuple[str, ...]:
        """What the network's outputs are theta of."""
        return tuple(_predicted(self.groups, self.colour_theta))

    def layer(self, primary: Primary, **settings: Any) -> FilterLayer:
        """The filter of this model for a scene; `settings` as for `FilterLayer` (rows, engine)."""
        shared = {name: getattr(self, name) for name in ("variant", "radius", "patch_radius")}
        compared, albedo = self.prepared(primary)
        return FilterLayer(compared, albedo=albedo, **shared, **settings)

    def prepared(self, primary: Primary) -> tuple[Primary, np.ndarray | None]:
        """What this model compares: `known`, and where it divides by albedo `untextured`, with that albedo."""
        known = self.known(primary)
        return untextured(known) if self.divides_albedo else (known, None)

    def known(self, primary: Primary) -> Primary:
        """The scene's features without the groups that this model does not know."""
        return primary.select([group for group in primary.groups if group in self.groups])

    def inputs(self, primary: Primary) -> np.ndarray:
        """What the network sees, (h, w, inputs) float32: normalised, 0 where the scene lacks a group."""
        return self.normalise(self.secondary(primary), self.known(primary).groups)

    def secondary(self, primary: Primary) -> np.ndarray:
        """Secondary features of what this model compares, (h, w, own inputs), not yet normalised."""
        return secondary_features(self.prepared(primary)[0], self.sees_colour)

    def normalise(self, values: np.ndarray, groups: tuple[str, ...]) -> np.ndarray:
        """Secondary features (..., own inputs) of a scene with these groups as what the network sees, (..., inputs)."""
        own = {name: k for k, name in enumerate(seen_names(groups, self.sees_colour))}
        found = np.zeros((*values.shape[:-1], len(self.input_names)), np.float32)
        for k, name in enumerate(self.input_names):
            if name in own:
                found[..., k] = (values[..., own[name]] - self.mean[k]) / (self.scale[k] + TINY)
        return found

    def theta(self, primary: Primary) -> np.ndarray:
        """Inverse bandwidths for `layer(primary)`: (h, w, 2 + groups of the scene that the model knows)."""
        inputs = self.inputs(primary)
        y, _ = self.network.forward(inputs.reshape(-1, inputs.shape[-1]))
        return self.arrange(y, self.known(primary).groups).reshape(*inputs.shape[:2], -1)

    def arrange(self, y: np.ndarray, groups: tuple[str, ...]) -> np.ndarray:
        """Columns of theta for a filter with these groups, from the network's outputs (n, outputs)."""
        theta = np.empty((len(y), 2 + len(groups)), y.dtype)
        for column, name in enumerate(("position", "colour", *groups)):
            theta[:, column] = y[:, self.outputs.index(name)] if name in self.outputs else self.colour_theta
        return np.minimum(theta, LARGEST_THETA, out=theta)

    def arrange_back(self, d_theta: np.ndarray, groups: tuple[str, ...]) -> np.ndarray:
        """The gradient of `arrange`: from that of theta to that of the network's outputs, 0 for outputs not used."""
        d_y = np.zeros((len(d_theta), len(self.outputs)), d_theta.dtype)
        for column, name in enumerate(("position", "colour", *groups)):
            if name in self.outputs:
                d_y[:, self.outputs.index(name)] = d_theta[:, column]
        return d_y


def _predicted(groups: tuple[str, ...] | list[str], colour_theta: float | None) -> list[str]:
    """Names of what is predicted."""
    return ["position", *(["colour"] if colour_theta is None else []), *(g for g in GROUPS if g in groups)]


def seen_names(groups: tuple[str, ...] | list[str], colour: bool) -> list[str]:
    """Names of what the network sees."""
    return secondary_names([*groups, *[COLOUR] * colour])
