"""Chapter 09: training the network through the filter, with validation, early stopping, checkpoints and resuming."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from tqdm import tqdm

from mcdenoise.lbf.checkpoint import Progress, load_checkpoint, save_checkpoint
from mcdenoise.lbf.dataset import DataConfig, SceneData, drop_groups, flip_axes, load_data
from mcdenoise.lbf.layer import PATCH_RADIUS, RADIUS, VARIANTS
from mcdenoise.lbf.loss import Example, FilterLoss
from mcdenoise.lbf.model import LBFModel, seen_names
from mcdenoise.lbf.primary import GROUPS, Primary
from mcdenoise.nn import MLP, RPROP, Diverged, RelativeError, Training, loss_and_gradients
from mcdenoise.samples.gate import check_choice, check_count

LEAST_NOISE = 1e-3  # loss of a noisy image below which it no longer counts for more
STREAM_WEIGHTS, STREAM_ROWS = 1, 2


@dataclass(frozen=True)
class TrainConfig:
    """How a model is trained.

    Attributes
    ----------
    variant : of the filter, ``"cross_bilateral"`` or ``"nlm"``
    groups : that the model may use
    hidden : widths of the hidden layers
    colour_theta : theta of the colour's distance, the same everywhere (0.01 in the paper); None: predicted
    radius, patch_radius : of the filter
    training_radius : of its window while it is trained: less than half the cost; the bells it learns are narrower
    sees_colour : show the network secondary features of the colour, too
    divides_albedo : filter colours that are divided by the albedo
    drop : leave out groups at random, so that the model serves scenes which lack them
    epochs : at most
    rows, validation_rows : image rows of each image that count, in training and in validation scenes
    check : epochs from one look at the validation scenes to the next
    patience : looks without a better validation loss until training stops
    first_step : of RPROP
    seed : of weights, rows and dropped groups
    """

    variant: str = "cross_bilateral"
    groups: tuple[str, ...] = GROUPS
    hidden: tuple[int, ...] = (10,)
    colour_theta: float | None = None
    radius: int = RADIUS
    training_radius: int = 13
    patch_radius: int = PATCH_RADIUS
    sees_colour: bool = True
    divides_albedo: bool = True
    drop: bool = True
    epochs: int = 80
    rows: int = 2
    validation_rows: int = 6
    check: int = 5
    patience: int = 6
    first_step: float = 0.02
    seed: int = 0

    def __post_init__(self) -> None:
        check_choice(self.variant, VARIANTS, "variant")
        for name in ("epochs", "rows", "validation_rows", "training_radius", "check", "patience"):
            check_count(getattr(self, name), name)
        object.__setattr__(self, "hidden", tuple(self.hidden))
        object.__setattr__(self, "groups", tuple(self.groups))

    def start(self) -> LBFModel:
        """The model before the first step; it does not yet know the statistics of its inputs."""
        settings = {
            name: getattr(self, name)
            for name in ("variant", "patch_radius", "colour_theta", "sees_colour", "divides_albedo")
        }
        settings["radius"] = min(self.radius, self.training_radius)
        rng = np.random.default_rng([self.seed, STREAM_WEIGHTS])
        return LBFModel.random(self.groups, hidden=self.hidden, rng=rng, **settings)


@dataclass(frozen=True, eq=False)
class LBFTraining:
    """What a training left.

    Attributes
    ----------
    model : with the smallest validation loss
    losses : (epochs,), of the training scenes, each before its step
    validation : (looks, 2), number of epochs and loss of the validation scenes
    unfiltered : loss of the noisy images, training and validation scenes
    """

    model: LBFModel
    losses: np.ndarray
    validation: np.ndarray
    unfiltered: tuple[float, float]


def train_lbf(
    config: TrainConfig,
    data: DataConfig | tuple[Sequence[SceneData], Sequence[SceneData]],
    *,
    folder: Path | None = None,
    checkpoint: Path | None = None,
    resume: bool = False,
    progress: bool | None = None,
) -> LBFTraining:
    """Train a model: RPROP on a fixed set of image rows, until the validation scenes no longer gain.

    Parameters
    ----------
    config : how
    data : on what; scenes that are given are taken as they are
    folder : where rendered scenes are kept; default: in the cache folder
    checkpoint : a `.npz` that is written at each look at the validation scenes
    resume : go on from `checkpoint`, to the same result as without the interruption
    progress : show a bar; default: on a terminal

    Raises
    ------
    Diverged
        (a ValueError) If a loss or parameter is not finite, or filtering has become worse than not to filter. Its
        `training.network` is the best one until then, which the checkpoint holds, too.
    ValueError
        For a checkpoint that is not whole, or belongs to another training.
    """
    scenes = load_data(data, folder) if isinstance(data, DataConfig) else data
    model, examples, watched = _prepare(config, *scenes)
    task, judge = _Task(FilterLoss(model, examples)), _Task(FilterLoss(model, watched))
    optimizer, identity, network = RPROP(config.first_step), _identity(config, scenes), model.network
    if resume:
        at = load_checkpoint(_needed(checkpoint), identity)
    else:
        at = Progress(network.parameters, optimizer.start(network.parameters), network.parameters)

    def look() -> None:
        """Judge by the validation scenes."""
        if not at.validation or at.validation[-1][0] < len(at.losses):
            value = judge.value(network.replace(at.parameters))
            if not at.validation or value < min(loss for _, loss in at.validation):
                at.best, at.best_epoch = at.parameters, len(at.losses)
            at.validation.append((len(at.losses), value))

    def keep() -> None:
        """Write down where the training stands."""
        if checkpoint:
            save_checkpoint(at, identity, checkpoint)

    bar = tqdm(total=config.epochs, initial=len(at.losses), desc="training", unit="epoch", disable=_hide(progress))
    with bar:
        while len(at.losses) < config.epochs:
            if len(at.losses) % config.check == 0:
                look()
                keep()
                if len(at.losses) - at.best_epoch >= config.patience * config.check:
                    break
            value, gradients = task.value_and_gradients(network.replace(at.parameters))
            _insist(value, at, task.unfiltered, replace(model, network=network.replace(at.best)), optimizer)
            at.parameters, at.state = optimizer.step(at.parameters, gradients, at.state)
            at.losses.append(value)
            bar.set_postfix(loss=f"{value:.4f}", validation=f"{at.validation[-1][1]:.4f}")
            bar.update()
        keep()  # before a look that a longer training would not take
        look()
    unfiltered = task.unfiltered, judge.unfiltered
    card = _card(config, data, scenes, at, unfiltered)
    best = replace(model, network=network.replace(at.best), radius=config.radius, card=card)
    return LBFTraining(best, np.array(at.losses), np.array(at.validation), unfiltered)


class _Task:
    """A loss with all its rows."""

    def __init__(self, loss: FilterLoss) -> None:
        self.loss = loss
        self.x, self.target = (
            np.concatenate([getattr(e, name) for e in loss.examples]) for name in ("inputs", "target")
        )
        self.unfiltered = loss.error_of([e.layer.noisy for e in loss.examples], self.target)

    def value(self, network: MLP) -> float:
        return self.loss.forward(network.forward(self.x)[0], self.target)[0]

    def value_and_gradients(self, network: MLP) -> tuple[float, dict[str, np.ndarray]]:
        return loss_and_gradients(network, self.x, self.target, self.loss)


def _prepare(
    config: TrainConfig, train_scenes: Sequence[SceneData], validation_scenes: Sequence[SceneData]
) -> tuple[LBFModel, list[Example], list[Example]]:
    """Draw rows and groups, measure the inputs, and make the examples."""
    start = config.start()
    drawn = [_draw(config, start, scenes, part) for part, scenes in enumerate((train_scenes, validation_scenes))]
    columns: dict[str, list[np.ndarray]] = {name: [] for name in start.input_names}
    for one in drawn[0]:
        for k, name in enumerate(seen_names(one.primary.groups, config.sees_colour)):
            columns[name].append(one.values[..., k].ravel())
    if missing := [name for name, found in columns.items() if not found]:
        raise ValueError(f"No training scene has what {', '.join(missing)} are made of. Leave those groups out.")
    joined = [np.concatenate(found).astype(np.float64) for found in columns.values()]
    statistics = {"mean": np.array([one.mean() for one in joined]), "scale": np.array([one.std() for one in joined])}
    model = replace(start, **statistics)
    made = [[_example(model, one) for one in part] for part in drawn]
    return model, made[0], made[1]


class _Drawn(NamedTuple):
    """What training takes from one image."""

    primary: Primary
    rows: np.ndarray
    values: np.ndarray  # secondary features of these rows
    reference: np.ndarray


def _draw(config: TrainConfig, model: LBFModel, scenes: Sequence[SceneData], part: int) -> list[_Drawn]:
    """For each image the features that it keeps, and the rows that count."""
    found, count = [], (config.rows, config.validation_rows)[part]
    for index, scene in enumerate(scenes):
        for primary in scene.primaries:
            rng = np.random.default_rng([config.seed, STREAM_ROWS, part, index, primary.spp])
            height = primary.colour.shape[0]
            rows = np.sort(rng.choice(height, min(count, height), replace=False))
            if config.drop:
                primary = drop_groups(primary, config.groups, rng)
            else:
                primary = primary.select([group for group in config.groups if group in primary.groups])
            primary = flip_axes(primary, rng)
            found.append(_Drawn(primary, rows, model.secondary(primary)[rows], scene.reference))
    return found


def _example(model: LBFModel, one: _Drawn) -> Example:
    """One image, ready for training."""
    inputs = model.normalise(one.values, one.primary.groups)
    noisy, _ = RelativeError(one.primary.spp).forward(one.primary.colour.reshape(-1, 3), one.reference.reshape(-1, 3))
    layer, target = model.layer(one.primary, rows=one.rows), one.reference[one.rows].reshape(-1, 3)
    return Example(layer, inputs.reshape(-1, inputs.shape[-1]), target, weight=1 / max(noisy, LEAST_NOISE))


def _insist(value: float, at: Progress, unfiltered: float, best: LBFModel, optimizer: RPROP) -> None:
    """Stop where filtering is worse than not to filter: the step is too long."""
    if np.isfinite(value) and (value < unfiltered or not at.losses):  # before the first step no step can be too long
        return
    left = Training(best.network, np.array(at.losses), np.array([loss for _, loss in at.validation]), at.best_epoch)
    raise Diverged(
        f"Training diverged in epoch {len(at.losses) + 1}: the loss is {value:.3g}, that of the noisy images is "
        f"{unfiltered:.3g}, with {optimizer}. Take a smaller first step (a tenth of it). The network with the smallest "
        f"validation loss until then is in the error's `training.network`, and in the checkpoint.",
        left,
    )


def _needed(checkpoint: Path | None) -> Path:
    """Return the checkpoint to go on from."""
    if checkpoint is None:
        raise ValueError("To resume, say from which checkpoint: checkpoint=PATH.")
    return checkpoint


def _identity(config: TrainConfig, scenes: tuple[Sequence[SceneData], Sequence[SceneData]]) -> dict[str, Any]:
    """What must be the same for a training to go on; `epochs` may be raised."""
    digest = hashlib.sha256()
    for scene in (*scenes[0], *scenes[1]):
        digest.update(scene.reference.tobytes())
        for primary in scene.primaries:
            digest.update(primary.colour.tobytes())
    return {**asdict(config), "epochs": 0, "data": digest.hexdigest()[:16]}


def _card(
    config: TrainConfig,
    data: object,
    scenes: tuple[Sequence[SceneData], Sequence[SceneData]],
    at: Progress,
    unfiltered: tuple[float, float],
) -> dict[str, Any]:
    """How a model came about."""
    losses = dict(at.validation)
    return {
        "training": asdict(config),
        "data": asdict(data) if isinstance(data, DataConfig) else {},
        "training_scenes": [scene.name for scene in scenes[0]],
        "validation_scenes": [scene.name for scene in scenes[1]],
        "spp": sorted({primary.spp for scene in scenes[0] for primary in scene.primaries}),
        "epochs": len(at.losses),
        "best_epoch": at.best_epoch,
        "loss": {"unfiltered": unfiltered[0], "first": at.losses[0], "last": at.losses[-1]},
        "validation_loss": {"unfiltered": unfiltered[1], "best": losses[at.best_epoch]},
        "curve": {
            "training": [round(loss / unfiltered[0], 4) for loss in at.losses],
            "validation": [[epochs, round(loss / unfiltered[1], 4)] for epochs, loss in at.validation],
        },
        "versions": {name: version(name) for name in ("mcdenoise", "mitsuba", "drjit", "numba", "numpy")},
    }


def _hide(progress: bool | None) -> bool | None:
    """What tqdm calls `disable`."""
    return None if progress is None else not progress
