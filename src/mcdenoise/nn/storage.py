"""A network on disk: one small `.npz` of plain arrays, never a pickle, never half a file."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np

from mcdenoise.nn.layers import Linear, ReLU, Sigmoid, Softplus, Step, Tanh
from mcdenoise.nn.network import DTYPES, MLP
from mcdenoise.samples.gate import check_nonfinite
from mcdenoise.samples.storage import open_npz, write_npz

FORMAT = "mcdenoise-network-1"
KINDS = {kind.__name__: kind for kind in (Linear, Step, Sigmoid, Tanh, ReLU, Softplus)}


def save_network(network: MLP, path: str | os.PathLike) -> None:
    """Write a network to `path`, a `.npz` file: its parameters by name, and the kinds of its layers as JSON.

    Raises
    ------
    ValueError
        If `path` does not end in `.npz` or its folder does not exist; if a parameter is not finite, or a layer is none of
        this room's.

    See Also
    --------
    load_network : reads the file back, checked.
    """
    kinds = [type(layer).__name__ for layer in network.layers]
    if unknown := sorted(set(kinds) - set(KINDS)):
        raise ValueError(f"Layers of the kinds {', '.join(KINDS)} can be stored, got {', '.join(unknown)}.")
    for name, array in network.parameters.items():
        check_nonfinite(array, name)
    write_npz(path, "A network is", {"format": FORMAT, "layers": kinds}, network.parameters)


def load_network(path: str | os.PathLike) -> MLP:
    """Read a network that `save_network` wrote; everything is checked.

    Raises
    ------
    ValueError
        If there is no such file, it is no whole `.npz`, holds pickled objects or another format, or if its arrays are
        missing, not finite, or do not fit each other.

    Examples
    --------
    >>> import tempfile
    >>> mlp = MLP.random([2, 3, 1], rng=np.random.default_rng(0))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_network(mlp, Path(folder) / "small.npz")
    ...     np.array_equal(load_network(Path(folder) / "small.npz").parameters["weight_1"], mlp.parameters["weight_1"])
    True
    """
    with open_npz(path, "a network written by save_network", "Train or save it again.") as stored:
        arrays = {name: stored[name] for name in stored.files}
        about = json.loads(str(arrays.pop("about")))
        kinds = [KINDS[kind] for kind in about["layers"]] if about["format"] == FORMAT else None
    if kinds is None:
        raise ValueError(f"{path} must have the format {FORMAT}, got {about['format']!r}. Save it with this version.")
    return _build(kinds, arrays, Path(path))


def _build(kinds: list[type], arrays: dict[str, np.ndarray], path: Path) -> MLP:
    """Put the layers together, and the file's name in front of what is wrong with them."""
    layers, number = [], 0
    try:
        for name, array in arrays.items():
            if array.dtype not in DTYPES:
                raise ValueError(f"{name} must be float32 or float64, got {array.dtype}.")
            check_nonfinite(array, name)
        for kind in kinds:
            number += kind is Linear
            taken = [arrays.pop(f"{name}_{number}") for name in ("weight", "bias")] if kind is Linear else []
            layers.append(kind(*taken))
        if arrays:
            raise ValueError(f"there are arrays that belong to no layer: {', '.join(arrays)}.")
        return MLP(tuple(layers))
    except (ValueError, KeyError) as error:
        raise ValueError(f"{path} holds no network that fits together: {error}") from error
