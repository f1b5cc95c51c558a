"""How fast and how good are our filters beside those of scipy, scikit-image and OpenCV? One command, one run:

    python -m mcdenoise.study.bench filters [--size 512] [--repeats 5] [--no-accuracy]
    python -m mcdenoise.study.bench accuracy [--size 128] [--spp 8] [--scenes dof glossy]
    python -m mcdenoise.study.bench rpf [--repeats 5] [--no-accuracy] [--size 128] [--scenes dof glossy]
    python -m mcdenoise.study.bench nn [--repeats 5]
    python -m mcdenoise.study.bench lbf [--size 256] [--spp 8] [--radius 27] [--repeats 5] [--json times.json]
    python -m mcdenoise.study.bench lbf_accuracy [--size 128] [--spp 4 8] [--scenes dof glossy] [--json errors.json]

`filters` prints times, how they grow, their share of what the machine's arithmetic allows, and then what `accuracy`
prints: relMSE on the toy scenes. `rpf` prints what random parameter filtering costs, how that grows, its memory, and
relMSE of all its presets beside the filters before it. `nn` prints what a forward and a backward pass of our network
cost, `lbf` the same of learning-based filtering and its parts, `lbf_accuracy` its relMSE beside global bandwidths and an
oracle. Within a run the contestants take turns, so that whatever else the machine does hits all of them; each time is a
median. What numba compiles is compiled before, and that time is printed apart. Absolute times say little about another
machine: read ratios.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from mcdenoise.lbf.layer import RADIUS
from mcdenoise.render import scene_names
from mcdenoise.samples.gate import check_names
from mcdenoise.samples.storage import write_beside
from mcdenoise.study.arguments import OneLineParser
from mcdenoise.study.bench_accuracy import SCENES, accuracy_lines
from mcdenoise.study.bench_filters import TARGET_SIZE, Peers, compile_kernels, filter_works, find_peers
from mcdenoise.study.bench_lbf import SIZE as LBF_SIZE
from mcdenoise.study.bench_lbf import SPP as LBF_SPP
from mcdenoise.study.bench_lbf import compile_lbf, lbf_lines, lbf_numbers, lbf_works, measure_lbf
from mcdenoise.study.bench_lbf_accuracy import STEPS, accuracy_of_lbf
from mcdenoise.study.bench_lbf_accuracy import accuracy_lines as lbf_accuracy_lines
from mcdenoise.study.bench_limit import limit_lines, peak_rates
from mcdenoise.study.bench_measure import measure, table
from mcdenoise.study.bench_nn import nn_lines
from mcdenoise.study.bench_rpf import SCENE, SPP, compile_rpf, growth_lines, time_lines
from mcdenoise.study.bench_rpf_accuracy import knee_lines, preset_lines
from mcdenoise.study.bench_rpf_parts import information_lines, memory_lines
from mcdenoise.study.bench_scaling import scaling_lines
from mcdenoise.study.machine import usable_cores

REFERENCE_SPP = 1024
MEMORY_SIDE = 256


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code (2, with one line on stderr, for what could not be done)."""
    try:
        options = _parser().parse_args(arguments)
        if options.command == "filters":
            bench_filters(options.size, options.repeats, accuracy=options.accuracy)
        elif options.command == "rpf":
            bench_rpf(options.repeats, options.scenes if options.accuracy else [], options.size)
        elif options.command == "nn":
            bench_nn(options.repeats)
        elif options.command == "lbf":
            bench_lbf(options.size, options.spp, options.radius, options.repeats, options.json)
        elif options.command == "lbf_accuracy":
            counts = {name: getattr(options, name) for name in ("size", "spp", "reference_spp", "steps")}
            bench_lbf_accuracy(options.scenes, **counts, path=options.json)
        else:
            bench_accuracy(options.scenes, options.size, options.spp, options.reference_spp)
    except SystemExit as leaving:
        return int(leaving.code or 0)
    except (ValueError, OSError) as error:
        print(f"bench: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    return 0


def _parser() -> OneLineParser:
    """Return the parser of the command line."""
    parser = OneLineParser(prog="python -m mcdenoise.study.bench", description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(
        dest="command", required=True, metavar="{filters,accuracy,rpf,nn,lbf,lbf_accuracy}"
    )
    filters = commands.add_parser("filters", help="times of all filters beside their peers, then accuracy")
    filters.add_argument("--size", type=_count(8), default=TARGET_SIZE, help="height and width, pixels (default 512)")
    filters.add_argument("--repeats", type=_count(1), default=5, help="runs to take the median of (default 5)")
    filters.add_argument("--no-accuracy", dest="accuracy", action="store_false", help="times only")
    accuracy = commands.add_parser("accuracy", help="relMSE on the toy scenes, everybody tuned with the reference")
    accuracy.add_argument("--size", type=_count(16), default=128, help="height and width in pixels (default 128)")
    accuracy.add_argument("--spp", type=_count(2), default=8, help="samples per pixel (default 8)")
    accuracy.add_argument(
        "--reference-spp", type=_count(2), default=REFERENCE_SPP, help="of the reference (default 1024)"
    )
    rpf = commands.add_parser("rpf", help="random parameter filtering: time, growth, memory, accuracy of the presets")
    rpf.add_argument("--repeats", type=_count(1), default=5, help="runs to take the median of (default 5)")
    rpf.add_argument("--no-accuracy", dest="accuracy", action="store_false", help="times and memory only")
    rpf.add_argument("--size", type=_count(16), default=128, help="of the accuracy tables, pixels (default 128)")
    network = commands.add_parser("nn", help="our network: time of a forward and a backward pass")
    network.add_argument("--repeats", type=_count(1), default=5, help="runs to take the median of (default 5)")
    lbf_accuracy = _add_lbf(commands)
    for parser_of in (accuracy, rpf, lbf_accuracy):
        parser_of.add_argument(
            "--scenes", nargs="+", metavar="SCENE", default=list(SCENES), help="default: all toy scenes"
        )
    return parser


def _add_lbf(commands: argparse._SubParsersAction) -> argparse.ArgumentParser:
    """Add `lbf` and `lbf_accuracy`; return the parser of the latter."""
    times = commands.add_parser("lbf", help="learning-based filtering: time of its parts, ratios")
    times.add_argument("--size", type=_count(8), default=LBF_SIZE, help=f"height and width (default {LBF_SIZE})")
    times.add_argument("--spp", type=_count(1), default=LBF_SPP, help=f"samples per pixel (default {LBF_SPP})")
    times.add_argument("--radius", type=_count(0), default=RADIUS, help=f"of the window (default {RADIUS})")
    times.add_argument("--repeats", type=_count(1), default=5, help="runs to take the median of (default 5)")
    errors = commands.add_parser("lbf_accuracy", help="its relMSE beside global bandwidths, RPF, and an oracle")
    errors.add_argument("--size", type=_count(16), default=128, help="height and width in pixels (default 128)")
    errors.add_argument("--spp", type=_count(2), nargs="+", default=[4, 8], help="samples per pixel (default 4 8)")
    errors.add_argument(
        "--reference-spp", type=_count(2), default=REFERENCE_SPP, help="of the reference (default 1024)"
    )
    errors.add_argument("--steps", type=_count(1), default=STEPS, help=f"of the oracle's descent (default {STEPS})")
    for parser in (times, errors):
        parser.add_argument("--json", type=_json_path, metavar="FILE.json", help="write the numbers there, too")
    return errors


def bench_filters(size: int, repeats: int, *, accuracy: bool = True) -> None:
    """Time all contestants on `size` x `size` x 3 float32 (those with features on half of that) and print everything."""
    peers = find_peers()
    for line in machine_facts(peers):
        print(line)
    print(f"compiling or loading our kernels: {compile_kernels():.1f} s (not counted below)\n", flush=True)
    works = filter_works(size, peers)
    measure(works, repeats)
    for work in works:
        print("\n".join(table(work, repeats)), end="\n\n")
    if size != TARGET_SIZE:
        print(f"targets are stated for --size {TARGET_SIZE} and judged only there\n")
    print("\n".join(limit_lines(works, size, peak_rates())), end="\n\n", flush=True)
    print("\n".join(scaling_lines(size, repeats)), flush=True)
    if accuracy:
        print()
        bench_accuracy(SCENES, size=128, spp=8, reference_spp=REFERENCE_SPP)


def bench_accuracy(scenes: Sequence[str], size: int, spp: int, reference_spp: int) -> None:
    """Print relMSE of every method and peer on the scenes; references not yet in the cache are rendered first."""
    scenes = check_names(scenes, scene_names(), "scenes")
    print("\n".join(accuracy_lines(scenes, size, spp, reference_spp)), flush=True)


def bench_rpf(repeats: int, scenes: Sequence[str], size: int) -> None:
    """Time RPF, its growth, its memory; then its accuracy on the scenes, if there are any."""
    scenes = check_names(scenes, scene_names(), "scenes") if scenes else []
    for line in machine_facts(find_peers()):
        print(line)
    print(f"compiling or loading the kernels of RPF: {compile_rpf():.1f} s (not counted below)\n", flush=True)
    parts = [
        lambda: time_lines(repeats),
        lambda: growth_lines(repeats),
        lambda: memory_lines(SCENE, MEMORY_SIDE, SPP),
        lambda: information_lines(SCENE, repeats),
    ]
    if scenes:
        parts += [lambda: preset_lines(scenes, size, REFERENCE_SPP), lambda: knee_lines(scenes, size, REFERENCE_SPP)]
    for part in parts:
        print("\n".join(part()), end="\n\n", flush=True)


def bench_nn(repeats: int) -> None:
    """Time our network beside its peers."""
    for line in [*machine_facts(find_peers()), "", *nn_lines(repeats)]:
        print(line, flush=True)


def bench_lbf(size: int, spp: int, radius: int, repeats: int, path: Path | None = None) -> None:
    """Time both variants of learning-based filtering and their parts."""
    facts = machine_facts(find_peers())
    print("\n".join(facts))
    print(f"compiling or loading the kernels of LBF: {compile_lbf():.1f} s (not counted below)\n", flush=True)
    works = lbf_works(size, spp, radius)
    measure_lbf(works, repeats)
    print("\n".join(lbf_lines(works, repeats, judged=(size, spp, radius) == (LBF_SIZE, LBF_SPP, RADIUS))), flush=True)
    _keep(path, lbf_numbers(works, machine=facts, size=size, spp=spp, radius=radius, repeats=repeats))


def bench_lbf_accuracy(
    scenes: Sequence[str], *, size: int, spp: Sequence[int], reference_spp: int, steps: int, path: Path | None = None
) -> None:
    """Print relMSE of learning-based filtering and of everybody it is measured by."""
    scenes = check_names(scenes, scene_names(), "scenes")
    found = accuracy_of_lbf(scenes, size, reference_spp, spps=spp, steps=steps)
    print("\n".join(lbf_accuracy_lines(found, scenes, size, reference_spp)), flush=True)
    _keep(path, {"size": size, "reference_spp": reference_spp, "steps": steps, "relmse": found})


def _keep(path: Path | None, numbers: Mapping[str, object]) -> None:
    """Write numbers as JSON, if that is wanted."""
    if path:
        with write_beside(path) as temporary:
            temporary.write_text(json.dumps(numbers, indent=2) + "\n", encoding="utf-8")


def machine_facts(peers: Peers) -> list[str]:
    """Return what a reader must know about the machine: cores, threads, instruction sets, versions."""
    from mcdenoise.kernels.jit import compiler_facts

    facts = compiler_facts()
    cores = usable_cores()
    cv2 = peers["cv2"]
    versions = {"Python": sys.version.split()[0], "numpy": np.__version__, "numba": facts["numba"]}
    for label, name in (("scipy", "scipy.ndimage"), ("scikit-image", "skimage"), ("OpenCV", "cv2")):
        module = importlib.import_module(name.partition(".")[0]) if peers[name] else None
        versions[label] = module.__version__ if module else "not installed"
    threads = f"numba {facts['threads']}" + (f", OpenCV {cv2.getNumThreads()}" if cv2 else "")
    load = f"; load of others before: {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return [
        f"cores: {cores}; threads: {threads}, scipy and scikit-image 1; CPU: {facts['cpu']}; SIMD: {facts['simd']}{load}",
        "versions: " + ", ".join(f"{name} {version}" for name, version in versions.items()),
    ]


def _json_path(text: str) -> Path:
    """Return the path of a JSON file, for argparse: asked for before the work, not after it."""
    path = Path(text)
    if path.suffix != ".json" or not path.parent.is_dir():
        raise argparse.ArgumentTypeError(f"a name that ends in .json, in a folder that exists, is needed, got {text!r}")
    return path


def _count(least: int) -> Callable[[str], int]:
    """Return a reader of whole numbers of at least `least`, for argparse."""

    def read(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"a whole number of at least {least} is needed, got {text!r}")
        return int(text)

    return read


if __name__ == "__main__":
    sys.exit(main())
