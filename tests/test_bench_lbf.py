"""The benchmark of LBF, tiny: every part runs, says what it measured, and judges rightly. Times are never asserted."""

import json
import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from conftest import make_samples
from mcdenoise.lbf import LBFModel
from mcdenoise.lbf.primary import GROUPS
from mcdenoise.metrics import relmse
from mcdenoise.render import capture
from mcdenoise.render.scenes import SCENES
from mcdenoise.render.scenes.cornell import SCENE as CORNELL
from mcdenoise.samples import pixel_mean
from mcdenoise.study import bench, bench_lbf, bench_lbf_accuracy
from mcdenoise.study.bench_accuracy import UNFILTERED
from mcdenoise.study.bench_lbf import BACKWARD, FORWARD, GLOBAL, PARTS, WHOLE, ratio_lines
from mcdenoise.study.bench_lbf_accuracy import (
    LBF,
    OIDN,
    ORACLE,
    RPF,
    TUNED,
    accuracy_lines,
    find_oidn,
    measure_errors,
    share_of_way,
    verdict_lines,
    with_mean,
)
from mcdenoise.study.bench_rpf_accuracy import GEOMETRIC
from mcdenoise.study.methods import METHODS

pytestmark = pytest.mark.ch10

SHARES = {"world_position": 3, "shading_normal": 3, "albedo": 3, "albedo_2": 3, "visibility": 1}


def model_of(variant="cross_bilateral"):
    """As from the package, but small and untrained."""
    return LBFModel.random(GROUPS, hidden=[2], rng=np.random.default_rng(0), variant=variant, radius=2, patch_radius=1)


@pytest.fixture
def tiny(monkeypatch, rng):
    """Captures of a made-up scene with every group of features; models that nobody trained; no peer."""

    def capture(scene, width, height, spp, **_):
        size = (height, width, spp)
        features = {name: rng.random((*size, channels)) for name, channels in SHARES.items()}
        return make_samples(rng, *size, features={**features, "visibility": features["visibility"][..., 0]})

    for module in (bench_lbf, bench_lbf_accuracy, sys.modules["mcdenoise.lbf.denoise"]):
        monkeypatch.setattr(module, "shipped_model", model_of)
    for module in (bench_lbf, bench_lbf_accuracy):
        monkeypatch.setattr(module, "capture", capture)
    monkeypatch.setattr(bench_lbf_accuracy, "render_reference", lambda *_, **__: np.full((16, 16, 3), 0.6))
    monkeypatch.setattr(bench_lbf, "REST", 0.0)
    monkeypatch.setitem(sys.modules, "pyoidn", None)


def test_both_variants_and_all_their_parts_are_timed(tiny, capsys, tmp_path):
    path = tmp_path / "times.json"
    assert (
        bench.main(["lbf", "--size", "12", "--spp", "2", "--radius", "3", "--repeats", "1", "--json", str(path)]) == 0
    )
    output = capsys.readouterr().out
    for name in (*PARTS, BACKWARD, WHOLE, GLOBAL):
        assert len(re.findall(rf"^  {re.escape(name)} +[\d.]+ ms", output, re.MULTILINE)) == 2
    assert "LBF, nlm, dof, 12x12, 2 spp, window 7x7, 5 groups; median of 1" in output
    assert len(re.findall(r"Intel OIDN.*not installed", output)) == 2
    assert "target" not in output  # they are stated for another size
    assert re.search(r"kernels of LBF: [\d.]+ s", output)
    numbers = json.loads(path.read_text())
    assert (numbers["size"], numbers["spp"], numbers["radius"]) == (12, 2, 3)
    assert set(numbers["seconds"]) == {"cross_bilateral", "nlm"}
    assert numbers["ratios"]["nlm"]["backward / forward"] > 0


def test_targets_are_stated_at_their_size(tiny, monkeypatch):
    monkeypatch.setattr(bench_lbf, "SIZE", 8)
    monkeypatch.setattr(bench_lbf, "RADIUS", 2)
    works = bench_lbf.lbf_works(8, 8, 2)
    assert [target.contestant for work in works for target in work.targets] == [WHOLE, WHOLE]
    assert not any(work.targets for work in bench_lbf.lbf_works(8, 4, 2))


@pytest.mark.parametrize(("backward", "word"), [(0.39, "reached"), (0.41, "missed")])
def test_shares_and_ratios(backward, word):
    seconds = dict.fromkeys(PARTS, 0.1) | {FORWARD: 0.2, BACKWARD: backward, WHOLE: 1.0, GLOBAL: 0.1}
    shares, both, cost = ratio_lines(seconds, judged=True)
    assert shares.endswith("filter, forward 20 %, the rest 50 %")
    assert both.endswith(f"{1 + backward / 0.2:.2f} x forward; target under 3 x: {word}")
    assert "2.00 x the filter with global ones" in cost
    assert "target" not in ratio_lines(seconds, judged=False)[1]


def test_the_parts_make_up_the_whole(tiny, rng):
    """Features, network and filter, one after the other, are what mcd.lbf does."""
    samples = make_samples(rng, 10, 11)
    runs = {one.name: one.run() for one in bench_lbf.contestants(model_of(), samples)}
    np.testing.assert_array_equal(runs[FORWARD][0], runs[WHOLE])
    assert runs[BACKWARD].shape == (10, 11, 2 + 3)


def test_errors_of_everybody_on_every_scene(tiny, rng):
    errors = measure_errors(["dof", CORNELL], 16, 4, 8, steps=2)
    assert list(errors) == [
        UNFILTERED,
        *(METHODS[name].label for name in TUNED),
        RPF,
        *LBF.values(),
        *ORACLE.values(),
        OIDN,
    ]
    assert errors.pop(OIDN) == {}
    for label, of in errors.items():
        assert set(of) == {"dof", "cornell"}, label
    for variant in LBF:
        assert errors[ORACLE[variant]]["dof"] < errors[LBF[variant]]["dof"]
        assert errors[ORACLE[variant]]["dof"] < errors[UNFILTERED]["dof"]


def test_oidn_gets_pixel_means_of_what_there_is(monkeypatch, rng):
    seen = []

    def denoise(colour, hdr, **guides):
        seen.append((colour, hdr, guides))
        return 2 * colour

    monkeypatch.setitem(sys.modules, "pyoidn", SimpleNamespace(denoise=denoise))
    samples = make_samples(rng, features={name: rng.random((5, 7, 4, 3)) for name in ("albedo", "shading_normal")})
    image = find_oidn()(samples)
    find_oidn()(make_samples(rng))
    np.testing.assert_array_equal(image, 2 * pixel_mean(samples.radiance))
    assert [(hdr, list(guides)) for _, hdr, guides in seen] == [(True, ["albedo", "normal"]), (True, ["albedo"])]
    np.testing.assert_array_equal(seen[0][2]["normal"], pixel_mean(samples["shading_normal"]))
    asked = bench_lbf_accuracy.ways(1)[OIDN]
    assert asked(samples, image) == pytest.approx(relmse(image, image), abs=1e-12)


def errors_of(lbf=0.02, cornell=0.01, oidn=0.005):
    """Two scenes and the one from outside."""

    def row(dof, glossy, outside):
        return {"dof": dof, "glossy": glossy, CORNELL.name: outside}

    tuned = [METHODS[name].label for name in TUNED]
    found = {UNFILTERED: row(0.16, 0.16, 0.02), tuned[0]: row(0.03, 0.04, 1.0), tuned[1]: row(0.05, 0.025, 1.0)}
    found |= {RPF: row(0.04, 0.009, 1.0), OIDN: row(oidn, oidn, 1.0) if oidn else {}}
    for variant in LBF:
        found |= {LBF[variant]: row(lbf, lbf, cornell), ORACLE[variant]: row(0.01, 0.01, 0.01)}
    return {4: found}


def test_the_way_is_told_in_logarithms():
    assert share_of_way(0.16, 0.16, 0.01) == 0
    assert share_of_way(0.16, 0.01, 0.01) == 1
    assert share_of_way(0.16, 0.32, 0.01) == pytest.approx(-0.25)
    lines = accuracy_lines(errors_of(), ["dof", "glossy"], 128, 1024)
    assert "128x128, 4 spp, reference 1024 spp" in lines[0]
    assert lines[1].split() == ["dof", "glossy", *GEOMETRIC.split(), "cornell"]
    (way,) = [line for line in lines if line.startswith("  way to the oracle of LBF, NL-means, %")]
    assert way.split()[-4:] == ["75", "75", "75", "100"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, ["on every scene: reached (dof 0.67, glossy 0.80 x", "on average: missed (geom. mean 1.05 x",
              "outside: reached (cornell 0.50 x", "60 % of the way to its oracle: 75 %, reached", "4.00 x the relMSE of"]),
        ({"lbf": 0.028}, ["on every scene: missed (dof 0.93, glossy 1.12 x", "63 %, reached"]),
        ({"lbf": 0.0185}, ["on average: reached"]),
        ({"lbf": 0.04}, ["its oracle: 50 %, missed"]),
        ({"cornell": 0.021}, ["outside: missed (cornell 1.05 x"]),
    ],
)  # fmt: skip
def test_verdicts(changes, words):
    lines = verdicts_of(**changes)
    assert len(lines) == 5
    for part in words:
        assert sum(part in line for line in lines) == 1, part
    assert all("LBF, NL-means, 4 spp" in line for line in lines)
    assert len(verdicts_of(oidn=None)) == 4


def verdicts_of(**changes):
    scenes = ["dof", "glossy"]
    return verdict_lines({4: with_mean(errors_of(**changes)[4], scenes)}, "nlm", scenes)


def test_the_command_measures_what_it_is_asked(tiny, capsys, monkeypatch, tmp_path):
    asked = []

    def accuracy(*given, **more):
        asked.append((*given, more))
        return errors_of()

    monkeypatch.setattr(bench, "accuracy_of_lbf", accuracy)
    path = tmp_path / "errors.json"
    options = ["--scenes", "dof", "glossy", "--size", "32", "--spp", "4", "--reference-spp", "64", "--steps", "3"]
    assert bench.main(["lbf_accuracy", *options, "--json", str(path)]) == 0
    assert asked == [(("dof", "glossy"), 32, 64, {"spps": [4], "steps": 3})]
    assert "far target: LBF, 4 spp" in capsys.readouterr().out
    assert json.loads(path.read_text())["relmse"]["4"][RPF]["glossy"] == 0.009


def test_the_scene_from_outside_is_mitsubas_with_a_lens():
    """It is not among the toy scenes; all that the network looks at is recorded."""
    assert CORNELL.name not in SCENES
    samples = capture(CORNELL, 12, 12, 4, variant="scalar_rgb")
    assert samples.feature_names == GROUPS
    assert samples.random_param_names[:2] == ("lens_u", "lens_v")
    green_and_red = pixel_mean(samples["albedo"])[6, [1, -2]]
    assert green_and_red[0, 0] > 2 * green_and_red[0, 1]
    assert green_and_red[1, 1] > 2 * green_and_red[1, 0]
    spread = samples["world_position"].std(axis=2).mean(axis=-1)
    assert spread.max() > 0.05  # out of focus
