"""No more network than needed to set the dials of a filter, and no more features: what does each of them gain?

    python -m mcdenoise.study.lbf_capacity --json capacity.json [--out capacity.png] [--scenes 40] [--folds 5]

Two sweeps on random scenes. The first is over architectures, trained as the model of the package is: with groups of features
left out at random. The second takes away one group of features at a time, from filter and network, with nothing else left
out; "without albedo" colours are not divided by it either, "without colour" takes away only what the network sees of it.
Folds are cut by scene, so every error is that of scenes which the model has not seen; of the scenes it may see, a quarter
says when to stop.

The error of an image is its relMSE after the filter over that before: 1 is no filter at all. A fold's error is the mean over
its scenes and their spp. All of it takes some 20 minutes on 2 cores; each candidate is written down when it is done, and a
second run with the same options goes on behind it.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np
from tqdm import tqdm

from mcdenoise.lbf import LBFModel
from mcdenoise.lbf.dataset import DataConfig, SceneData, drop_groups, load_data
from mcdenoise.lbf.layer import VARIANTS
from mcdenoise.lbf.primary import GROUPS
from mcdenoise.lbf.secondary import COLOUR
from mcdenoise.lbf.training import TrainConfig, train_lbf
from mcdenoise.metrics import relmse
from mcdenoise.samples.gate import check_count
from mcdenoise.samples.storage import write_beside
from mcdenoise.study.arguments import OneLineParser
from mcdenoise.study.capacity import Hidden, capacity_figure, k_folds, lines
from mcdenoise.study.charts import save_figure
from mcdenoise.study.lbf_capacity_results import (
    ALL,
    FORMAT,
    Study,
    difference_lines,
    differences_figure,
    load_study,
    read_json,
)

ARCHITECTURES: tuple[Hidden, ...] = ((), (2,), (4,), (10,), (20,), (40,), (10, 10))
USUAL: Hidden = (10,)  # of the sweep over groups
STREAM_FOLDS, STREAM_STOP, STREAM_JUDGED = 11, 12, 13
STOP_SHARE = 0.25  # of the scenes that a model may see: they say when to stop


@dataclass(frozen=True)
class StudyConfig:
    """How the study is done.

    Attributes
    ----------
    train : of every training; `hidden`, `groups` and `drop` are what the study varies
    scenes, size, reference_spp : of the random scenes, the first `scenes` seeds; as `mcdenoise train` renders them
    spp : which images of each scene are used, to learn from and to judge by
    folds : parts of the scenes
    judged_rows : image rows of each held-out image that count

    Examples
    --------
    >>> StudyConfig(scenes=4).data.seeds
    ((0, 1, 2), (3,))
    """

    train: TrainConfig = field(default_factory=lambda: TrainConfig(radius=13, epochs=60, rows=2, patience=4))
    scenes: int = 40
    size: int = DataConfig().size
    reference_spp: int = DataConfig().reference_spp
    spp: tuple[int, ...] = (4, 16, 64)
    folds: int = 5
    judged_rows: int = 16

    def __post_init__(self) -> None:
        check_count(self.scenes, "scenes", least=2)
        check_count(self.judged_rows, "judged_rows")
        object.__setattr__(self, "spp", tuple(self.spp))

    @property
    def data(self) -> DataConfig:
        """The scenes, as `load_data` is asked for them."""
        return DataConfig(self.scenes - 1, 1, self.size, reference_spp=self.reference_spp)


def study(config: StudyConfig, scenes: Sequence[SceneData], path: Path, *, progress: bool | None = None) -> Study:
    """Run both sweeps on `scenes`; every candidate goes into the JSON file `path` when it is done.

    Raises
    ------
    ValueError
        If `path` holds something else, or a study with other settings; for spp that the scenes lack.
    """
    todo = _todo(config.train)
    scenes = [_with_spp(scene, config.spp) for scene in scenes]
    done = _read(path, _settings(config, scenes))
    folds = k_folds(range(len(scenes)), config.folds, np.random.default_rng([config.train.seed, STREAM_FOLDS]))
    bar = tqdm(total=len(todo) * len(folds), desc="LBF capacity", unit="fit", disable=_hide(progress))
    with bar:
        for name, train in todo.items():
            if name not in done["candidates"]:
                done["candidates"][name] = _candidate(train, config, scenes, folds, bar)
                with write_beside(path) as temporary:
                    temporary.write_text(json.dumps(done, indent=1) + "\n", encoding="utf-8")
            else:
                bar.update(len(folds))
    return load_study(path)


def _with_spp(scene: SceneData, spp: Sequence[int]) -> SceneData:
    """Keep the images that are used."""
    there = {primary.spp: primary for primary in scene.primaries}
    if not spp or not set(spp) <= set(there):
        raise ValueError(f"spp must be some of {', '.join(map(str, there))}, got {', '.join(map(str, spp)) or 'none'}.")
    return replace(scene, primaries=tuple(there[one] for one in sorted(set(spp))))


def _todo(train: TrainConfig) -> dict[str, TrainConfig]:
    """Name -> how it is trained, of all candidates."""
    found = {f"hidden {_label(hidden)}": replace(train, hidden=hidden) for hidden in ARCHITECTURES}
    usual = replace(train, hidden=USUAL, drop=False)
    found[ALL] = usual
    without = {group: tuple(other for other in train.groups if other != group) for group in train.groups}
    found |= {f"without {group}": replace(usual, groups=left) for group, left in without.items()}
    return found | ({f"without {COLOUR}": replace(usual, sees_colour=False)} if train.sees_colour else {})


def _candidate(
    train: TrainConfig,
    config: StudyConfig,
    scenes: Sequence[SceneData],
    folds: Sequence[tuple[np.ndarray, np.ndarray]],
    bar: tqdm,
) -> dict[str, object]:
    """Train once a fold, judge on the scenes left out and on as many of those learnt from."""
    errors, fitted, seconds, epochs = [], [], [], []
    for seen, held_out in folds:
        start = time.process_time()
        learnt, stop = split(seen, train.seed)
        trained = train_lbf(train, ([scenes[k] for k in learnt], [scenes[k] for k in stop]), progress=False)
        seconds.append(time.process_time() - start)
        epochs.append(trained.model.card["best_epoch"])
        errors.append(error_of(trained.model, scenes, held_out, train, config.judged_rows))
        fitted.append(error_of(trained.model, scenes, learnt[: len(held_out)], train, config.judged_rows))
        bar.update()
    size = trained.model.network.size
    measured = {"errors": errors, "fitted": fitted, "epochs": epochs, "seconds": float(np.median(seconds))}
    return {"hidden": list(train.hidden), "parameters": size, **measured}


def split(seen: Sequence[int], seed: int) -> tuple[list[int], list[int]]:
    """Cut the scenes that a model may see into those it learns from and those that say when to stop.

    Examples
    --------
    >>> [len(part) for part in split(range(8), seed=0)]
    [6, 2]
    """
    mixed = np.random.default_rng([seed, STREAM_STOP]).permutation(np.asarray(seen)).tolist()
    count = max(1, round(STOP_SHARE * len(mixed)))
    if len(mixed) < 2:
        raise ValueError(f"A fold must leave two scenes or more to see, got {len(mixed)}. Take more scenes.")
    return sorted(mixed[count:]), sorted(mixed[:count])


def error_of(
    model: LBFModel, scenes: Sequence[SceneData], chosen: Sequence[int], train: TrainConfig, rows: int
) -> float:
    """Mean of relMSE after over relMSE before, over the images of the chosen scenes.

    Rows, and the groups left out if `train.drop`, depend on the scene alone: every candidate is judged by the same.
    """
    ratios = []
    for index in chosen:
        for primary in scenes[index].primaries:
            rng = np.random.default_rng([train.seed, STREAM_JUDGED, int(index), primary.spp])
            height = len(primary.colour)
            judged = np.sort(rng.choice(height, min(rows, height), replace=False))
            left = drop_groups(primary, GROUPS, rng) if train.drop else primary
            filtered, _ = model.layer(left, rows=judged).forward(model.theta(left)[judged])
            truth = scenes[index].reference[judged]
            ratios.append(relmse(filtered, truth) / relmse(left.colour[judged], truth))
    return float(np.mean(ratios))


def _settings(config: StudyConfig, scenes: Sequence[SceneData]) -> dict[str, object]:
    """What must be the same for a study to go on."""
    about = {
        **asdict(config),
        "train": {**asdict(config.train), "hidden": None},
        "names": [scene.name for scene in scenes],
    }
    return json.loads(json.dumps(about))


def _read(path: Path, settings: dict[str, object]) -> dict[str, object]:
    """The study so far, or an empty one."""
    if not path.exists():
        return {"format": FORMAT, "settings": settings, "candidates": {}}
    found = read_json(path)
    if found["settings"] != settings:
        other = [name for name in settings if found["settings"].get(name) != settings[name]]
        raise ValueError(
            f"{path} holds a study with another {', '.join(other)}. Use the same options, or another --json."
        )
    return found


def _label(hidden: Hidden) -> str:
    """Widths in words, as `Candidate.label`."""
    return "-".join(map(str, hidden)) or "linear"


def _hide(progress: bool | None) -> bool | None:
    """What tqdm calls `disable`."""
    return None if progress is None else not progress


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code (2, with one line on stderr, for what could not be done)."""
    try:
        options = _parser().parse_args(arguments)
        if options.json.suffix != ".json" or (options.out and options.out.suffix != ".png"):
            raise ValueError("The numbers need a name that ends in .json (--json), the charts one in .png (--out).")
        for path in (options.json, options.out):
            if path and not path.parent.is_dir():
                raise ValueError(f"The folder {path.parent} must exist before {path.name} is written. Create it first.")
        given = {name: getattr(options, name) for name in ("variant", "radius", "rows", "epochs", "seed")}
        train = replace(StudyConfig().train, **given, training_radius=options.radius)
        shared = {name: getattr(options, name) for name in ("scenes", "size", "reference_spp", "folds")}
        config = StudyConfig(train, spp=options.spp, **shared)
        learnt, stop = load_data(config.data, options.data)
        found = study(config, [*learnt, *stop], options.json)
        print("\n".join([*lines(found.architectures), "", *difference_lines(found)]))
        if options.out:
            save_figure(capacity_figure(found.architectures), options.out)
            save_figure(differences_figure(found), options.out.with_stem(f"{options.out.stem}_differences"))
    except SystemExit as leaving:
        return int(leaving.code or 0)
    except (ValueError, OSError) as error:
        print(f"lbf_capacity: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    usual = StudyConfig()
    parser = OneLineParser(prog="python -m mcdenoise.study.lbf_capacity", description=__doc__.splitlines()[0])
    parser.add_argument(
        "--json", type=Path, required=True, metavar="FILE.json", help="numbers; read first if it is there"
    )
    parser.add_argument(
        "--out", type=Path, metavar="CHART.png", help="write two charts: this name, and with _differences"
    )
    parser.add_argument("--data", type=Path, metavar="FOLDER", help="where rendered scenes are kept (default: cache)")
    parser.add_argument("--variant", choices=VARIANTS, default=usual.train.variant, help="of the filter")
    numbers = {
        "scenes": (usual.scenes, "random scenes, cut into folds"),
        "folds": (usual.folds, "parts of the scenes"),
        "size": (usual.size, "height and width, pixels"),
        "reference-spp": (usual.reference_spp, "of the references"),
        "radius": (usual.train.radius, "of the window; 27 takes more than twice as long as 13"),
        "rows": (usual.train.rows, "image rows of each image that training sees"),
        "epochs": (usual.train.epochs, "of training, at most"),
        "seed": (usual.train.seed, "of folds, rows and weights"),
    }
    for name, (default, words) in numbers.items():
        parser.add_argument(f"--{name}", type=int, default=default, metavar="N", help=f"{words} (default {default})")
    parser.add_argument(
        "--spp", type=int, nargs="+", default=usual.spp, metavar="N", help="images used (default 4 16 64)"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
