"""The benchmark's command: it runs, says what it measured, and refuses bad arguments in one line."""

import re
import sys

import pytest

from mcdenoise.study import bench

pytestmark = pytest.mark.ch10


def test_prints_ours_and_every_peer(capsys):
    assert bench.main(["filters", "--size", "40", "--repeats", "1"]) == 0
    output = capsys.readouterr().out
    for name in ("mcdenoise.gaussian", "mcdenoise.bilateral", "mcdenoise.cross_bilateral"):
        assert re.search(rf"{re.escape(name)} +[\d.]+ ms", output)
    for name in (
        "scipy.ndimage.gaussian_filter",
        "skimage.filters.gaussian",
        "cv2.GaussianBlur",
        "skimage.restoration.denoise_bilateral",
        "cv2.bilateralFilter",
    ):
        assert re.search(rf"{re.escape(name)} +([\d.]+ ms +[\d.]+ x our time|not installed)", output)
    assert "40x40x3 float32; median of 1" in output
    assert "compiling or loading our kernels" in output
    assert re.search(r"cores: \d+; threads: numba \d+", output)
    assert len(re.findall(r"billion taps", output)) == 2


def test_a_peer_that_is_absent_is_said_to_be(capsys, monkeypatch):
    for name in ("cv2", "skimage", "scipy.ndimage"):
        monkeypatch.setitem(sys.modules, name, None)
    assert bench.main(["filters", "--size", "16", "--repeats", "2"]) == 0
    output = capsys.readouterr().out
    assert len(re.findall(r"^  \S+ +not installed$", output, flags=re.MULTILINE)) == 5
    assert "OpenCV not installed" in output


def test_contestants_take_turns_and_the_median_is_scaled():
    order = []

    def contestant(name, **changes):
        return bench.Contestant(name, lambda: order.append(name), **changes)

    ours, theirs, slow = contestant("ours"), contestant("theirs"), contestant("slow", once=True, scale=4.0)
    bench.measure([bench.Work("work", [ours, theirs, slow, bench.Contestant("absent", None)])], repeats=3)
    assert order == ["ours", "theirs", "slow", "ours", "theirs", "slow", "ours", "theirs", "ours", "theirs"]
    assert [len(one.seconds) for one in (ours, theirs, slow)] == [3, 3, 1]
    slow.seconds = [0.5, 1.0, 9.0]
    assert slow.median() == 4.0


@pytest.mark.parametrize("radius", [0, 2, 9])
def test_taps_are_pairs_inside_the_image(radius):
    pixels = [(y, x) for y in range(5) for x in range(5)]
    pairs = sum(abs(a - c) <= radius and abs(b - d) <= radius for a, b in pixels for c, d in pixels)
    assert bench._taps(5, radius) == pairs


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["filters", "--size", "3"], "argument --size: a whole number of at least 8 is needed, got '3'"),
        (["filters", "--repeats", "none"], "argument --repeats: a whole number of at least 1 is needed, got 'none'"),
        (["filters", "--fast"], "unrecognized arguments: --fast"),
        (["everything"], "invalid choice: 'everything'"),
        ([], "the following arguments are required: filters"),
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
