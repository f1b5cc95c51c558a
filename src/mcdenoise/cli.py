"""The command line: `mcdenoise compare SCENE`, `study`, `advise`, `train`, `classroom ...`, `doctor`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from mcdenoise.classroom.command import add_commands
from mcdenoise.classroom.command import run as run_classroom
from mcdenoise.lbf.dataset import DataConfig
from mcdenoise.lbf.layer import VARIANTS
from mcdenoise.lbf.primary import GROUPS
from mcdenoise.lbf.training import TrainConfig
from mcdenoise.study.arguments import OneLineParser

STUDIES = ("speed-accuracy", "stability", "parsimony", "all")


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command line.

    Examples
    --------
    >>> build_parser().parse_args(["compare", "dof", "--spp", "4"]).spp
    4
    """
    parser = OneLineParser(
        prog="mcdenoise", description="Monte Carlo render denoising: course and reference implementation."
    )
    parser.add_argument("--version", action="version", version=f"mcdenoise {version('mcdenoise')}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_compare(commands)
    _add_study(commands)
    _add_advise(commands)
    _add_train(commands)
    add_commands(commands)
    commands.add_parser(
        "doctor",
        help="say what works on this machine, and what to install for more",
        description="Look at Python, Mitsuba and its back ends, numba, extras and tools. Exit code 0 if the essentials "
        "work, else 1.",
    )
    return parser


def _add_compare(commands: argparse._SubParsersAction) -> None:
    """Add `mcdenoise compare`."""
    compare = commands.add_parser(
        "compare",
        help="denoise a scene with every method; chart speed against accuracy",
        description="Capture a scene, denoise it with every method, and measure each against a reference and against "
        "Monte Carlo with more samples. Writes a table, results.json, two figures, EXR images and report.html.",
    )
    compare.add_argument("scene", metavar="SCENE", help="name of a toy scene, or path of a Mitsuba XML file")
    compare.add_argument("--spp", type=int, default=8, help="samples per pixel to denoise (default 8)")
    compare.add_argument("--size", type=int, default=128, help="height and width in pixels (default 128)")
    compare.add_argument("--methods", nargs="+", metavar="NAME", help="methods to run (default: all)")
    compare.add_argument("--seed", type=int, default=0, help="seed of the samples (default 0)")
    compare.add_argument(
        "--reference-spp", type=int, default=1024, help="samples per pixel of the reference (default 1024)"
    )
    compare.add_argument(
        "--variant", default="auto", help="Mitsuba back end: auto, scalar_rgb, llvm_ad_rgb (default auto)"
    )
    compare.add_argument("--out", type=Path, metavar="DIR", help="folder for the results (default out/SCENE)")


def _add_study(commands: argparse._SubParsersAction) -> None:
    """Add `mcdenoise study`."""
    study = commands.add_parser(
        "study",
        help="the studies of chapter 10: speed against accuracy, stability, parsimony",
        description="Measure every method over all toy scenes. Numbers go into a JSON file entry by entry, so a run that was "
        "stopped goes on; charts and report.html are made from them. All together: half an hour on 2 cores.",
    )
    study.add_argument("study", choices=STUDIES, metavar="STUDY", help=", ".join(STUDIES))
    study.add_argument("--quick", action="store_true", help="small images, few seeds: a minute or two")
    study.add_argument("--size", type=int, help="height and width in pixels (default 128; 32 or so if quick)")
    study.add_argument(
        "--out", type=Path, metavar="DIR", help="folder for the results (default out/study, quick: out/study-quick)"
    )


def _add_advise(commands: argparse._SubParsersAction) -> None:
    """Add `mcdenoise advise`."""
    advise = commands.add_parser(
        "advise",
        help="say what samples need: random parameters, features, filter; no reference needed",
        description="Read samples (SampleBuffer.save), test what carries information, try every filter by leaving samples out, "
        "and print the least that is as good as the best, and how sure that is.",
    )
    advise.add_argument("samples", type=Path, metavar="SAMPLES.npz", help="of any renderer, 2 spp or more")
    advise.add_argument("--seed", type=int, default=0, help="of shuffles and resamplings (default 0)")
    advise.add_argument("--json", type=Path, metavar="FILE.json", help="write all numbers there too")


def _add_train(commands: argparse._SubParsersAction) -> None:
    """Add `mcdenoise train`; the defaults are those of the models that come with the package."""
    usual, data = TrainConfig(), DataConfig()
    train = commands.add_parser(
        "train",
        help="train the network that sets the dials of a filter (chapter 09)",
        description="Render random scenes, train a model through the filter, and write it with its card and its loss curve. "
        "Without options the result is the model that comes with the package.",
    )
    train.add_argument("--variant", choices=VARIANTS, default=usual.variant, help=f"filter (default {usual.variant})")
    train.add_argument(
        "--out", type=Path, metavar="MODEL.npz", help="default out/VARIANT.npz; card and chart stand beside it"
    )
    train.add_argument(
        "--groups", nargs="*", default=usual.groups, metavar="GROUP", help=f"of features, out of {', '.join(GROUPS)}"
    )
    train.add_argument("--hidden", type=int, nargs="*", default=usual.hidden, metavar="WIDTH", help="of hidden layers")
    train.add_argument("--scenes", type=int, default=data.scenes, help=f"to learn from (default {data.scenes})")
    train.add_argument(
        "--validation", type=int, default=data.validation, help=f"to stop by (default {data.validation})"
    )
    train.add_argument(
        "--size", type=int, default=data.size, help=f"height and width of the images (default {data.size})"
    )
    train.add_argument("--spp", type=int, nargs="+", default=data.spp, help="samples per pixel (default 4 8 16 32 64)")
    train.add_argument(
        "--reference-spp",
        type=int,
        default=data.reference_spp,
        help=f"of the references (default {data.reference_spp})",
    )
    train.add_argument("--epochs", type=int, default=usual.epochs, help=f"at most (default {usual.epochs})")
    train.add_argument("--seed", type=int, default=usual.seed, help="of weights, rows and dropped groups (default 0)")
    train.add_argument(
        "--data", type=Path, metavar="DIR", help="where rendered scenes are kept (default: the cache folder)"
    )
    train.add_argument("--resume", action="store_true", help="go on from the checkpoint beside the model")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code: that of the command, or 2 with one line on standard error for what could
    not be done.
    """
    parser = build_parser()
    options = parser.parse_args(arguments)
    try:
        return _RUN[options.command](options)
    except (ValueError, OSError) as error:
        print(f"mcdenoise {options.command}: {' '.join(str(error).split())}", file=sys.stderr)
        return 2


def run_compare(options: argparse.Namespace) -> int:
    """Run `mcdenoise compare`: print the table and write the folder."""
    from mcdenoise.study.compare import compare
    from mcdenoise.study.report import make_folder, table, write_all

    folder = options.out or Path("out") / Path(options.scene).stem
    make_folder(folder)
    comparison = compare(
        options.scene,
        spp=options.spp,
        size=options.size,
        methods=options.methods,
        seed=options.seed,
        reference_spp=options.reference_spp,
        variant=options.variant,
    )
    print(table(comparison))
    written = write_all(comparison, folder)
    print(f"\nWrote {len(written)} files into {folder}. Open {written[0]} in a browser: keys flip between the images.")
    return 0


def run_study(options: argparse.Namespace) -> int:
    """Run `mcdenoise study`."""
    from mcdenoise.study.studies import run_study

    return run_study(options)


def run_advise(options: argparse.Namespace) -> int:
    """Run `mcdenoise advise`."""
    from mcdenoise.study.advise_lines import run_advise

    return run_advise(options)


def run_train(options: argparse.Namespace) -> int:
    """Run `mcdenoise train`."""
    from mcdenoise.study.training import run_train

    return run_train(options)


def run_doctor(options: argparse.Namespace) -> int:
    """Run `mcdenoise doctor`."""
    from mcdenoise.classroom.doctor import run_doctor

    return run_doctor()


_RUN = {
    "compare": run_compare,
    "study": run_study,
    "advise": run_advise,
    "train": run_train,
    "classroom": run_classroom,
    "doctor": run_doctor,
}


if __name__ == "__main__":
    sys.exit(main())
