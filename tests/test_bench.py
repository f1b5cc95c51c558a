"""The benchmark's command: it runs, says what it measured, and refuses bad arguments in one line."""

import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from mcdenoise.study import bench
from mcdenoise.study.bench_filters import count_taps, filter_works, find_peers
from mcdenoise.study.bench_guided import CROSS, crosses
from mcdenoise.study.bench_limit import Operations

pytestmark = pytest.mark.ch10

OURS = ("gaussian", "bilateral", "cross_bilateral", "cross_bilateral, variances", "nlm, a variance a pixel",
        "nlm, one number as variance", "joint_nlm, variances", "prefilter_features")  # fmt: skip
THEIRS = (
    "scipy.ndimage.gaussian_filter",
    "skimage.filters.gaussian",
    "cv2.GaussianBlur",
    "skimage.restoration.denoise_bilateral",
    "cv2.bilateralFilter",
    "cv2.ximgproc.jointBilateralFilter",
    "skimage.restoration.denoise_nl_means",
    "cv2.fastNlMeansDenoising",
)


@pytest.fixture(autouse=True)
def _slow_parts_left_out(monkeypatch):
    """The parts that have tests of their own."""
    monkeypatch.setattr(bench, "scaling_lines", lambda size, repeats: [f"growth at {size}"])
    monkeypatch.setattr(bench, "peak_rates", lambda: Operations(40e9, 2e9))
    monkeypatch.setattr(bench, "accuracy_lines", lambda *asked: [f"accuracy of {asked}"])


def test_prints_ours_and_every_peer(capsys):
    assert bench.main(["filters", "--size", "40", "--repeats", "1"]) == 0
    output = capsys.readouterr().out
    for name in OURS:
        assert re.search(rf"mcdenoise\.{name} +[\d.]+ ms", output)
    for name in THEIRS:
        assert re.search(rf"{re.escape(name)} +([\d.]+ ms +[\d.]+ x our time|not installed)", output)
    assert "40x40x3 float32; median of 1" in output
    assert "compiling or loading our kernels" in output
    assert re.search(r"cores: \d+; threads: numba \d+", output)
    assert len(re.findall(r"billion taps", output)) == 4
    assert "targets are stated for --size 512" in output
    assert "peaks of this machine in this run" in output
    assert output.index("growth at 40") < output.index("accuracy of (('dof', 'pinhole', ")


def test_a_peer_that_is_absent_is_said_to_be(capsys, monkeypatch):
    for name in ("cv2", "skimage", "scipy.ndimage"):
        monkeypatch.setitem(sys.modules, name, None)
    assert bench.main(["filters", "--size", "16", "--repeats", "2", "--no-accuracy"]) == 0
    output = capsys.readouterr().out
    assert len(re.findall(r"^  \S+ +not installed$", output, flags=re.MULTILINE)) == len(THEIRS)
    assert "OpenCV not installed" in output
    assert "accuracy" not in output


def test_targets_are_judged_only_at_the_size_they_are_stated_for():
    count = {size: sum(len(work.targets) for work in filter_works(size, find_peers())) for size in (32, 512)}
    assert count == {32: 0, 512: 6}


@pytest.mark.parametrize("contrib", [None, "there"])
def test_opencv_without_its_contributed_modules_has_no_joint_bilateral_filter(contrib, rng):
    seen = []
    module = SimpleNamespace(jointBilateralFilter=lambda *asked: seen.append(asked)) if contrib else None
    ours, _, theirs = crosses(rng, np.ones((8, 8, 3), np.float32), SimpleNamespace(ximgproc=module))
    assert ours.name == CROSS
    if not contrib:
        assert theirs.run is None
        return
    theirs.run()
    ((guide, image, width, *_),) = seen
    assert guide.shape == image.shape == (8, 8, 3)
    assert width == 55


@pytest.mark.parametrize("radius", [0, 2, 9])
def test_taps_are_pairs_inside_the_image(radius):
    pixels = [(y, x) for y in range(5) for x in range(5)]
    pairs = sum(abs(a - c) <= radius and abs(b - d) <= radius for a, b in pixels for c, d in pixels)
    assert count_taps(5, radius) == pairs


def test_accuracy_takes_its_dials_from_the_command_line(capsys):
    assert bench.main(["accuracy", "--size", "16", "--spp", "4", "--scenes", "dof", "--reference-spp", "8"]) == 0
    assert capsys.readouterr().out == "accuracy of (('dof',), 16, 4, 8)\n"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["filters", "--size", "3"], "argument --size: a whole number of at least 8 is needed, got '3'"),
        (["filters", "--repeats", "none"], "argument --repeats: a whole number of at least 1 is needed, got 'none'"),
        (["filters", "--fast"], "unrecognized arguments: --fast"),
        (["accuracy", "--spp", "1"], "argument --spp: a whole number of at least 2 is needed, got '1'"),
        (["accuracy", "--scenes", "moon"], "moon"),
        (["rpf", "--scenes", "moon"], "moon"),
        (["rpf", "--size", "8"], "argument --size: a whole number of at least 16 is needed, got '8'"),
        (["rpf", "--repeats", "0"], "argument --repeats: a whole number of at least 1 is needed, got '0'"),
        (["nn", "--repeats", "0"], "argument --repeats: a whole number of at least 1 is needed, got '0'"),
        (["lbf", "--size", "7"], "argument --size: a whole number of at least 8 is needed, got '7'"),
        (["lbf", "--radius", "-1"], "argument --radius: a whole number of at least 0 is needed, got '-1'"),
        (
            ["lbf", "--json", "times.txt"],
            "argument --json: a name that ends in .json, in a folder that exists, is needed",
        ),
        (
            ["lbf_accuracy", "--json", "nowhere/errors.json"],
            "in a folder that exists, is needed, got 'nowhere/errors.json'",
        ),
        (["lbf_accuracy", "--spp", "1"], "argument --spp: a whole number of at least 2 is needed, got '1'"),
        (["lbf_accuracy", "--scenes", "moon"], "moon"),
        (["everything"], "invalid choice: 'everything'"),
        ([], "the following arguments are required: {filters,accuracy,rpf,nn,lbf,lbf_accuracy}"),
    ],
)
def test_bad_arguments_give_one_line_and_code_2(arguments, message, capsys):
    assert bench.main(arguments) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""


def test_help_is_no_error(capsys):
    assert bench.main(["filters", "--help"]) == 0
    assert "--repeats" in capsys.readouterr().out
