"""What closes the gap? Models trained in the same way, each with one thing more than the one before.

    python -m mcdenoise.study.lbf_trials --json trials.json [--data FOLDER]

From the paper's network on all scenes by way of what ours adds to it, then ours on fewer scenes. Every model is judged on the
validation scenes and on the toy scenes, which no training sees. Trainings are short (one row of each image, 50 epochs): about a
minute each on an idle machine, once the scenes are rendered. What is there is not trained again.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tqdm import tqdm

from mcdenoise.lbf import LBFModel, Primary, primary_features
from mcdenoise.lbf.dataset import DataConfig, SceneData, load_data
from mcdenoise.lbf.training import TrainConfig, train_lbf
from mcdenoise.metrics import relmse
from mcdenoise.render import capture, render_reference
from mcdenoise.render.scenes import SCENES
from mcdenoise.samples.storage import write_beside
from mcdenoise.study.arguments import OneLineParser

SPP, SIZE, REFERENCE_SPP = (4, 8), 128, 1024
QUICK = TrainConfig(rows=1, validation_rows=2, epochs=50, patience=3)
PAPER = {"sees_colour": False, "colour_theta": 0.01, "divides_albedo": False}


@dataclass(frozen=True)
class Trial:
    """One training: what it has in words, what differs from the usual settings, and on which share of the scenes."""

    words: str
    changes: Mapping[str, object]
    share: float = 1.0


TRIALS = {
    "paper": Trial("the paper's network", PAPER),
    "colour": Trial("it also sees the colour, and sets its bandwidth", {"divides_albedo": False}),
    "ours": Trial("texture is divided out: ours", {}),
    "half": Trial("ours, half of the scenes", {}, 0.5),
    "quarter": Trial("ours, a quarter of the scenes", {}, 0.25),
}
Toy = tuple[str, Primary, np.ndarray]  # name, features, reference


def toys() -> list[Toy]:
    """Every toy scene at 4 and 8 spp."""
    found = []
    for name in SCENES:
        reference = render_reference(name, SIZE, SIZE, REFERENCE_SPP, progress=False)
        samples = capture(name, SIZE, SIZE, max(SPP), seed=0, progress=False)
        found += [(name, primary_features(samples.subset(0, spp)), reference) for spp in SPP]
    return found


def judge(model: LBFModel, scenes: Sequence[Toy]) -> dict[str, float]:
    """relMSE of a model on toy scenes: for each spp the geometric mean over the scenes.

    Examples
    --------
    >>> flat = np.ones((4, 4, 3), np.float32)
    >>> model = LBFModel.random([], hidden=[1], rng=np.random.default_rng(0))
    >>> round(judge(model, [("flat", Primary(flat, 0 * flat, {}, {}, {}, spp=4), 2 * flat)])["4"], 4)
    0.2494
    """
    errors: dict[str, list[float]] = {}
    for _, primary, reference in scenes:
        filtered, _ = model.layer(primary).forward(model.theta(primary))
        errors.setdefault(str(primary.spp), []).append(relmse(filtered.astype(np.float32), reference))
    return {spp: float(np.exp(np.mean(np.log(found)))) for spp, found in errors.items()}


def run_trials(
    scenes: tuple[Sequence[SceneData], Sequence[SceneData]],
    held_out: Sequence[Toy],
    path: Path,
    train: TrainConfig = QUICK,
) -> dict[str, dict]:
    """Train and judge what is not yet in the JSON file `path`; it is written after each."""
    found = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    for name, trial in tqdm(TRIALS.items(), desc="LBF trials", unit="model", disable=None, leave=False):
        if name in found:
            continue
        learnt = scenes[0][: max(1, round(trial.share * len(scenes[0])))]
        done = train_lbf(TrainConfig(**{**vars(train), **trial.changes}), (learnt, scenes[1]), progress=False)
        found[name] = {
            "words": trial.words,
            "parameters": done.model.network.size,
            "scenes": len(learnt),
            "validation": float(done.validation[:, 1].min() / done.unfiltered[1]),
            "toys": judge(done.model, held_out),
        }
        with write_beside(path) as temporary:
            temporary.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    return found


def lines(found: Mapping[str, Mapping]) -> list[str]:
    """A table of the trials.

    Examples
    --------
    >>> one = {"words": "ours", "parameters": 517, "scenes": 100, "validation": 0.31, "toys": {"4": 0.01, "8": 0.005}}
    >>> print("\\n".join(lines({"ours": one})))
    model                                             weights  scenes  validation  toys 4 spp  toys 8 spp
    ours                                                  517     100      0.310     0.01000     0.00500
    """
    table = [f"{'model':48s}  weights  scenes  validation  toys 4 spp  toys 8 spp"]
    for one in found.values():
        numbers = "".join(f"{one['toys'][str(spp)]:12.5f}" for spp in SPP)
        table.append(
            f"{one['words']:48s}  {one['parameters']:7d}  {one['scenes']:6d}  {one['validation']:9.3f}{numbers}"
        )
    return table


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code (2, with one line on stderr, for what could not be done)."""
    parser = OneLineParser(prog="python -m mcdenoise.study.lbf_trials", description=__doc__.splitlines()[0])
    parser.add_argument(
        "--json", type=Path, required=True, metavar="FILE.json", help="numbers; read first if it is there"
    )
    parser.add_argument("--data", type=Path, metavar="FOLDER", help="where rendered scenes are kept (default: cache)")
    try:
        options: argparse.Namespace = parser.parse_args(arguments)
        if options.json.suffix != ".json":
            raise ValueError(f"The numbers need a name that ends in .json, got {options.json.name!r}.")
        print("\n".join(lines(run_trials(load_data(DataConfig(), options.data), toys(), options.json))))
    except SystemExit as leaving:
        return int(leaving.code or 0)
    except (ValueError, OSError) as error:
        print(f"lbf_trials: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
