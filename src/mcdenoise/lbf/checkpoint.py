"""Chapter 09: a training on disk, so that an interrupted one goes on to the same result."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from mcdenoise.samples.storage import open_npz, write_npz

FORMAT = "mcdenoise-lbf-checkpoint-1"
KINDS = ("parameters", "state", "best")


@dataclass
class Progress:
    """Where a training stands: everything that the next epoch depends on.

    Attributes
    ----------
    parameters, state : of the network and of the optimizer, after `len(losses)` epochs
    best, best_epoch : the parameters with the smallest validation loss, and after how many epochs they were there
    losses : of each epoch, before its step
    validation : pairs of number of epochs and loss
    """

    parameters: Mapping[str, np.ndarray]
    state: Mapping[str, np.ndarray]
    best: Mapping[str, np.ndarray]
    best_epoch: int = 0
    losses: list[float] = field(default_factory=list)
    validation: list[tuple[int, float]] = field(default_factory=list)


def save_checkpoint(progress: Progress, identity: Mapping[str, Any], path: Path) -> None:
    """Write a training; `identity` says which one it is, and a later `load_checkpoint` insists on it."""
    arrays = {f"{kind}/{name}": one for kind in KINDS for name, one in getattr(progress, kind).items()}
    about = {"format": FORMAT, "identity": identity, "best_epoch": progress.best_epoch}
    arrays |= {"losses": np.array(progress.losses), "validation": np.array(progress.validation).reshape(-1, 2)}
    write_npz(path, "A checkpoint is", about, arrays)


def load_checkpoint(path: Path, identity: Mapping[str, Any]) -> Progress:
    """Read a training that `save_checkpoint` wrote.

    Raises
    ------
    ValueError
        If there is no such file, it is no whole checkpoint, or it belongs to another training.
    """
    with open_npz(path, "a checkpoint of mcdenoise train", "Start the training anew, without --resume.") as stored:
        about = json.loads(str(stored["about"]))
        if about["format"] != FORMAT:
            raise ValueError(f"its format is {about['format']!r}, needed is {FORMAT}")
        kinds = {kind: _named(stored, kind) for kind in KINDS}
        losses, validation = stored["losses"].tolist(), [(int(n), loss) for n, loss in stored["validation"].tolist()]
        found, best_epoch = about["identity"], int(about["best_epoch"])
    asked = json.loads(json.dumps(identity))
    if different := [name for name in asked if found.get(name) != asked[name]]:
        raise ValueError(
            f"{path} belongs to a training with another {', '.join(different)}: {found.get(different[0])!r} there, "
            f"{asked[different[0]]!r} here. Use the same options, or start anew without --resume."
        )
    return Progress(**kinds, best_epoch=best_epoch, losses=losses, validation=validation)


def _named(stored: Any, kind: str) -> dict[str, np.ndarray]:
    """The arrays of one kind by name."""
    return {name.removeprefix(f"{kind}/"): stored[name] for name in stored.files if name.startswith(f"{kind}/")}
