"""Chapter 09: a model on disk, with its card; and the models that come with the package."""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from mcdenoise.lbf.layer import VARIANTS
from mcdenoise.lbf.model import LBFModel
from mcdenoise.nn import MLP, Linear, Sigmoid, Softplus
from mcdenoise.samples.gate import check_choice, check_nonfinite
from mcdenoise.samples.storage import open_npz, write_npz

FORMAT = "mcdenoise-lbf-1"
LONG = 7  # entries of a card that are all written out
SETTINGS = ("groups", "variant", "radius", "patch_radius", "colour_theta", "sees_colour", "divides_albedo")


def save_model(model: LBFModel, path: str | os.PathLike) -> None:
    """Write a model to `path`, a `.npz` file of plain arrays; its settings and its card are JSON in it.

    Raises
    ------
    ValueError
        If `path` does not end in `.npz` or its folder does not exist.

    See Also
    --------
    load_model : reads the file back, checked.
    """
    about = {"format": FORMAT, "card": dict(model.card), **{name: getattr(model, name) for name in SETTINGS}}
    statistics = {"mean": model.mean, "scale": model.scale}
    write_npz(path, "A model is", about, {**model.network.parameters, **statistics})


def load_model(path: str | os.PathLike) -> LBFModel:
    """Read a model that `save_model` wrote; everything is checked.

    Raises
    ------
    ValueError
        If there is no such file, it is no whole `.npz`, holds another format, or its arrays do not fit each other.

    Examples
    --------
    >>> import tempfile
    >>> model = LBFModel.random(["albedo"], hidden=[2], rng=np.random.default_rng(0))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_model(model, Path(folder) / "small.npz")
    ...     load_model(Path(folder) / "small.npz").groups
    ('albedo',)
    """
    with open_npz(path, "a model of mcdenoise train", "Train or save it again.") as stored:
        arrays = {name: stored[name] for name in stored.files}
        about = json.loads(str(arrays.pop("about")))
        found = about["format"]
        settings = {name: about[name] for name in SETTINGS} if found == FORMAT else {}
        card = about.get("card", {})
    if found != FORMAT:
        raise ValueError(f"{path} must have the format {FORMAT}, got {found!r}. Save it with this version.")
    try:
        for name, array in arrays.items():
            check_nonfinite(array, name)
        mean, scale = arrays.pop("mean"), arrays.pop("scale")
        settings["groups"] = tuple(settings["groups"])
        return LBFModel(_network(arrays), mean, scale, **settings, card=MappingProxyType(card))
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{path} holds no model that fits together: {error}") from error


def _network(arrays: dict[str, np.ndarray]) -> MLP:
    """Linear layers with sigmoids between them and a softplus at the end."""
    layers = []
    for k in range(1, len(arrays) // 2 + 1):
        layers += [Linear(arrays.pop(f"weight_{k}"), arrays.pop(f"bias_{k}")), Sigmoid()]
    if arrays:
        raise ValueError(f"there are arrays that belong to no layer: {', '.join(arrays)}.")
    return MLP((*layers[:-1], Softplus()))


@functools.cache
def shipped_model(variant: str = "cross_bilateral") -> LBFModel:
    """Return the model that comes with the package, for ``"cross_bilateral"`` or ``"nlm"``; its card says how it was made.

    Raises
    ------
    ValueError
        For another variant.

    Examples
    --------
    >>> shipped_model().variant
    'cross_bilateral'
    """
    return load_model(Path(__file__).parent / "weights" / f"{check_choice(variant, VARIANTS, 'variant')}.npz")


def card_text(model: LBFModel) -> str:
    """The card of a model, as Markdown.

    Examples
    --------
    >>> model = LBFModel.random(["albedo"], hidden=[2], rng=np.random.default_rng(0))
    >>> print(card_text(model).splitlines()[0])
    # Model card: cross_bilateral, 15-2-3, 41 parameters
    """
    weights = [one for name, one in model.network.parameters.items() if name.startswith("weight")]
    widths = "-".join(str(n) for n in (weights[0].shape[1], *(one.shape[0] for one in weights)))
    lines = [f"# Model card: {model.variant}, {widths}, {model.network.size} parameters", ""]
    settings = {name: getattr(model, name) for name in SETTINGS}
    lines += ["It predicts theta = 1 / (2 sigma^2) of " + ", ".join(model.outputs) + " for every pixel.", ""]
    sections = {name: one for name, one in model.card.items() if isinstance(one, Mapping)}
    rest = {name: one for name, one in model.card.items() if name not in sections}
    for title, entries in {"filter": settings, "result": rest, **sections}.items():
        lines += [f"## {title}", "", *(f"- {name}: {_plain(one)}" for name, one in entries.items()), ""]
    return "\n".join(lines)


def _plain(value: object) -> str:
    """A value of a card as one reads it."""
    if isinstance(value, (list, tuple)) and len(value) > LONG:
        return f"{_plain(value[0])} to {_plain(value[-1])} ({len(value)})"
    if isinstance(value, (list, tuple)):
        return ", ".join(_plain(one) for one in value)
    return f"{value:.4g}" if isinstance(value, float) else str(value)
