"""The benchmark of RPF, tiny: every part runs, says what it measured, and judges rightly. Times are never asserted."""

import re

import numpy as np
import pytest

from conftest import make_samples
from mcdenoise.rpf import RPFConfig
from mcdenoise.rpf.dependency import information_of_pairs
from mcdenoise.study import bench, bench_rpf, bench_rpf_accuracy, bench_rpf_parts
from mcdenoise.study.bench_accuracy import Row
from mcdenoise.study.bench_rpf import QUICK, WHOLE, Timed, growth_series, take_turns, time_lines, time_targets
from mcdenoise.study.bench_rpf_accuracy import (
    ADAPTIVE,
    GEOMETRIC,
    gain_verdicts,
    geometric_mean,
    knee_lines,
    preset_lines,
    preset_methods,
    spp_lines,
    with_mean,
)
from mcdenoise.study.bench_rpf_parts import information_work, pairs_by_bits, pairs_by_sklearn, rise_of

pytestmark = pytest.mark.ch10

NUMBER = r"[\d.]+"


@pytest.fixture
def tiny(monkeypatch, rng):
    """Captures of a made-up scene in place of the real one."""

    def capture(scene, width, height, spp, **_):
        features = {name: rng.random((height, width, spp, 3)) for name in bench_rpf.FEATURES}
        return make_samples(rng, height, width, spp, features=features)

    for module in (bench_rpf, bench_rpf_accuracy, bench_rpf_parts):
        monkeypatch.setattr(module, "capture", capture)
    reference = lambda scene, width, height, **_: np.full((height, width, 3), 0.6)  # noqa: E731 (of make_samples)
    monkeypatch.setattr(bench_rpf_accuracy, "render_reference", reference)
    monkeypatch.setattr("mcdenoise.study.bench_accuracy.capture", capture)
    monkeypatch.setattr("mcdenoise.study.bench_accuracy.render_reference", reference)


def timed(seconds, label=QUICK, boxes=(5, 3), side=4):
    """One run of `seconds` in the first pass, and nothing else."""
    samples = make_samples(np.random.default_rng(0), side, side, 2)
    run = [0.0, seconds, *[0.0] * (len(boxes) - 1)]
    return Timed(label, RPFConfig.technical_report(boxes=boxes), samples, wall=[run], cpu=[run])


def test_each_pass_of_each_preset_has_its_cost(tiny, monkeypatch):
    monkeypatch.setattr(bench_rpf, "SIDES", (6, 8))
    title, head, *lines = time_lines(repeats=2)
    assert "median of 2" in title
    assert head.split()[:2] == ["pixels", "seconds"]
    boxes = {"technical report": (55, 35, 17, 7), "adaptive": RPFConfig.adaptive().boxes}
    assert [re.search(r"(\d+x\d+)", line).group(1) for line in lines[:5]] == ["6x6", "6x6", "6x6", "8x8", "8x8"]
    for line in lines[:5]:
        passes = boxes["adaptive" if "adaptive" in line else "technical report"]
        assert re.search(rf"{NUMBER}, " + ", ".join(rf"{NUMBER} \({box}\)" for box in passes) + "$", line)
    assert len(lines) == 5 + 4
    assert all(line.startswith("  target: ") for line in lines[5:])


def test_parts_of_a_run_add_up(monkeypatch):
    one = timed(1.0)
    one.wall, one.cpu = [], []
    ticks = iter(np.arange(10.0))
    monkeypatch.setattr(bench_rpf, "_clocks", lambda: (0.0, 0.0) if (k := next(ticks)) == 0 else (k, k / 16))
    one.run()
    assert len(one.wall[0]) == len(one.cpu[0]) == 1 + len(one.config.boxes)
    assert one.seconds() == sum(one.wall[0])
    assert sum(one.cpu_milliseconds()) == pytest.approx(1e3 * sum(one.cpu[0]) / 16)


def test_slow_runs_are_not_repeated(monkeypatch):
    quick, slow = timed(1.0), timed(11.0)
    quick.wall, slow.wall = [], []
    monkeypatch.setattr(Timed, "run", lambda self: self.wall.append([11.0 if self is slow else 1.0]))
    take_turns([quick, slow], repeats=3)
    assert (len(quick.wall), len(slow.wall)) == (3, 1)


@pytest.mark.parametrize(("seconds", "words"), [(0.0095, "0.59 ms, reached"), (0.0097, "0.61 ms, missed")])
def test_targets_of_time(seconds, words, monkeypatch):
    monkeypatch.setattr(bench_rpf, "usable_cores", lambda: 2)
    lines = time_targets(timed(seconds), timed(10.5, WHOLE), timed(9.9))
    assert "4x4, under 2.5 s: 0.01 s, reached (" in lines[0]
    assert lines[2].endswith("(its CPU time, spread over all cores: 5.25 s)")
    assert "under 10 s: 9.90 s, reached" in lines[1]
    assert "under 10 s: 10.50 s, missed" in lines[2]
    assert lines[3].endswith(words)


def test_growth_varies_one_thing_at_a_time(tiny, monkeypatch):
    monkeypatch.setattr(bench_rpf, "GROWTH_SIDES", (4, 5, 6))
    asked = []
    monkeypatch.setattr(bench_rpf, "rpf", lambda samples, config, progress: asked.append((samples, config)))
    series = {one.symbol[0]: one for one in growth_series()}
    assert series["M"].values == (484, 2420, 12100)
    for one in series.values():
        for value in one.values:
            one.run(value)()
    sizes = [(len(s.feature_names) * 3, s.spp, s.height * s.width, round(c.fraction(0), 2)) for s, c in asked]
    assert sizes[:3] == [(9, spp, 16, 0.02) for spp in (4, 8, 16)]
    assert sizes[3:6] == [(9, 8, 16, share) for share in (0.02, 0.1, 0.5)]
    assert sizes[6:9] == [(columns, 8, 16, 0.02) for columns in (3, 6, 9)]
    assert sizes[9:] == [(9, 8, pixels, 0.02) for pixels in (16, 25, 36)]
    assert asked[3][1].boxes == (55,)


def test_growth_is_printed_as_laws(tiny, monkeypatch):
    for name, values in {"GROWTH_SIDES": (2, 3), "GROWTH_SPP": (8, 16), "GROWTH_FRACTIONS": (0.02, 0.03)}.items():
        monkeypatch.setattr(bench_rpf, name, values)
    text = "\n".join(bench_rpf.growth_lines(repeats=1))
    for quantity in ("spp", "M", "feature columns", "pixels"):
        assert re.search(rf": time ~ {quantity}\^-?{NUMBER} \(", text)


def test_memory_is_measured_in_a_process_of_its_own(tiny, monkeypatch):
    monkeypatch.setattr(bench_rpf_parts, "MEMORY_OF", {"adaptive": RPFConfig.adaptive()})
    lines = bench_rpf_parts.memory_lines("made up", 8, 4)
    if not bench_rpf_parts.RESET.exists():
        assert "not measured" in lines[1]
        return
    assert len(lines) == 2
    assert re.search(rf"{NUMBER} x the buffer; target under 10 x: (reached|missed)$", lines[1])


@pytest.mark.skipif(not bench_rpf_parts.RESET.exists(), reason="only Linux can say what the peak of a call is")
def test_a_peak_is_seen_whatever_came_before_and_is_left_after():
    np.ones(20_000_000)
    assert 36e6 < rise_of(lambda: np.ones(5_000_000).sum()) < 60e6  # 40 MB, and what was free already
    assert rise_of(lambda: None) < 5e6


def test_memory_is_not_guessed_where_it_cannot_be_measured(tiny, monkeypatch, tmp_path):
    monkeypatch.setattr(bench_rpf_parts, "RESET", tmp_path / "missing")
    assert "not measured" in bench_rpf_parts.memory_lines("made up", 4, 2)[-1]


def test_all_ways_to_mutual_information_agree(rng):
    pytest.importorskip("sklearn")
    x, y = rng.integers(-3, 4, (200, 3)), rng.integers(-2, 3, (200, 2))
    y[:, 0] = x[:, 0] // 2
    expected = information_of_pairs(x, y)
    np.testing.assert_allclose(pairs_by_bits(x, y), expected, atol=1e-9)
    np.testing.assert_allclose(pairs_by_sklearn(x, y), expected, atol=1e-9)
    assert expected[0, 0] > 10 * expected[1, 1]


@pytest.mark.filterwarnings("ignore")  # scikit-learn warns of labels that look continuous
def test_all_pairs_of_a_neighbourhood_are_counted(rng, monkeypatch):
    blocks = [rng.integers(0, 3, (50, columns)) for columns in (3, 4, 2, 9)]
    assert information_work(*blocks).title.startswith("mutual information, 99 pairs of 50 samples")
    monkeypatch.setattr(bench_rpf_parts, "find_sklearn", lambda: None)
    work = information_work(*blocks)
    assert work.contestants[-1].run is None
    for contestant in work.contestants[:2]:
        found = contestant.run()
        assert [one.shape for one in found] == [(12, 6), (3, 9)]


def test_information_is_timed_for_few_and_for_all_samples(tiny):
    lines = bench_rpf_parts.information_lines("made up", repeats=1)
    assert [re.search(r"(\d+) samples", line).group(1) for line in lines if "pairs of" in line] == ["512", "12100"]


def test_every_preset_is_in_both_tables(tiny, monkeypatch):
    monkeypatch.setattr(bench_rpf_accuracy, "RIVALS", ("gaussian", "bilateral"))
    lines = preset_lines(["dof", "motion"], 8, 16)
    for label in [method.label for method in preset_methods()]:
        rows = [line for line in lines if re.match(rf"  {re.escape(label)} +\d", line)]
        assert [len(re.findall(rf" {NUMBER}(?= |$)", row[len(label) + 2 :])) for row in rows] == [3, 3]
    assert len([line for line in lines if line.startswith("  target: ")]) == 3
    assert lines[1].split() == ["dof", "motion", "geom.", "mean"]


def test_presets_differ(tiny, rng):
    samples = make_samples(rng, 8, 8, 4)
    images = [method.run(samples) for method in preset_methods()]
    for k, image in enumerate(images):
        assert np.isfinite(image).all()
        assert all(np.abs(image - other).max() > 1e-4 for other in images[:k])


@pytest.mark.parametrize(("error", "word"), [(0.0074, "reached"), (0.0076, "missed")])
def test_the_gain_is_judged_where_it_is_asked_and_told_everywhere(error, word):
    rows = [
        Row("Gaussian", None, {"dof": 0.01, "glossy": 0.01}),
        Row("bilateral", None, {"dof": 0.02, "glossy": 0.02}),
        Row(ADAPTIVE, None, {"dof": error, "glossy": 0.02}),
    ]
    gaussian, bilateral = gain_verdicts(rows, ["dof", "glossy"])
    assert f"soft_shadow: {word} (dof " in gaussian
    assert "glossy -100 %" in gaussian
    assert ": reached (dof 6" in bilateral
    assert "not judged" in gain_verdicts(rows, ["glossy"])[0]


@pytest.mark.parametrize(("adaptive", "word"), [(0.009, "reached"), (0.011, "missed")])
def test_the_default_must_beat_the_best_preset_at_every_spp(adaptive, word):
    errors = {4: {"unfiltered": 9.0, ADAPTIVE: 0.01, "RPF, a": 0.02, "RPF, b": 0.04, "Gaussian": 0.001},
              8: {"unfiltered": 9.0, ADAPTIVE: adaptive, "RPF, a": 0.02, "RPF, b": 0.01}}  # fmt: skip
    *table, verdict = spp_lines(errors, 128)
    assert f": {word} (4 spp: 0.50 x that of RPF, a; 8 spp: {adaptive / 0.01:.2f} x that of RPF, b)" in verdict
    assert not any("Gaussian" in line for line in table)


def test_means_over_scenes_are_geometric():
    (row,) = with_mean([Row("a", None, {"dof": 0.001, "motion": 0.1})], ["dof", "motion"])
    assert row.errors[GEOMETRIC] == pytest.approx(0.01)
    assert geometric_mean([2.0, 2.0, 2.0]) == pytest.approx(2.0)


def test_the_knee_compares_the_default_with_the_published_number(tiny, monkeypatch):
    monkeypatch.setattr(bench_rpf_accuracy, "KNEE_MULTIPLES", (0.25, 1.0))
    monkeypatch.setattr(bench_rpf_accuracy, "_error_and_cpu", lambda samples, config, _: (config.fraction(0), 0.064))
    lines = knee_lines(["dof", "motion"], 8, 16)
    assert [re.search(r"(\d+) % of M", line).group(1) for line in lines[2:-1]] == ["2", "9", "100"]
    assert all(line.endswith(" 1.00") for line in lines[2:-1])
    quick = RPFConfig.technical_report().fraction(0) / 0.5
    assert f"{100 * (quick - 1):+.1f} %, reached" in lines[-1]


def test_the_command_prints_all_parts(monkeypatch, capsys):
    asked = []
    for name in ("time_lines", "growth_lines", "memory_lines", "information_lines", "preset_lines", "knee_lines"):
        monkeypatch.setattr(bench, name, lambda *values, name=name: asked.append((name, values)) or [f"part {name}"])
    assert bench.main(["rpf", "--repeats", "2", "--scenes", "dof", "--size", "32"]) == 0
    output = capsys.readouterr().out
    assert re.search(r"kernels of RPF: [\d.]+ s", output)
    assert output.index("part time_lines") < output.index("part growth_lines") < output.index("part knee_lines")
    assert dict(asked)["preset_lines"] == (("dof",), 32, 1024)
    asked.clear()
    assert bench.main(["rpf", "--no-accuracy"]) == 0
    assert [name for name, _ in asked] == ["time_lines", "growth_lines", "memory_lines", "information_lines"]
    assert asked[0][1] == (5,)
