"""How much network, and which features, the dials of a filter need: on made-up scenes where the answer is known."""

import json
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mcdenoise.lbf.dataset import SceneData
from mcdenoise.lbf.model import LBFModel
from mcdenoise.lbf.primary import Primary
from mcdenoise.lbf.training import TrainConfig
from mcdenoise.study import lbf_capacity
from mcdenoise.study.capacity import Candidate, Capacity
from mcdenoise.study.lbf_capacity import StudyConfig, error_of, split, study
from mcdenoise.study.lbf_capacity_results import (
    ALL,
    Study,
    difference,
    difference_lines,
    differences_figure,
    load_study,
)

pytestmark = pytest.mark.ch09

GROUPS = ("albedo", "visibility")
TRAIN = TrainConfig(groups=GROUPS, radius=3, rows=8, epochs=12, drop=False, first_step=0.1)


def made_up(seed, size=16, spp=(4, 16)):
    """Two flat halves under much noise; albedo tells them apart without noise, visibility is nothing but noise."""
    rng = np.random.default_rng(seed)
    reference = np.where(np.arange(size) < size // 2, 0.35, 0.7)[:, np.newaxis] * np.ones(3)
    reference = np.broadcast_to(reference, (size, size, 3)).astype(np.float32)
    features = {"albedo": reference, "visibility": rng.random((size, size, 1)).astype(np.float32)}
    uncertain = {"albedo": np.full_like(reference, 0.01), "visibility": np.full((size, size, 1), 0.05, np.float32)}
    primaries = []
    for n in spp:
        noise = 2 / np.sqrt(n) * rng.normal(size=(size, size, 3)) * reference
        variance = (4 / n * reference**2).astype(np.float32)
        primaries.append(Primary((reference + noise).astype(np.float32), variance, features, features, uncertain, n))
    return SceneData(f"made up {seed}", tuple(primaries), reference)


@pytest.fixture(scope="module")
def scenes():
    return [made_up(seed) for seed in range(6)]


@pytest.fixture(scope="module")
def config():
    return StudyConfig(TRAIN, scenes=6, spp=(4,), folds=3, judged_rows=10)


@pytest.fixture
def quick(monkeypatch):
    """Two architectures, and models as they are before the first step; it lists what was asked for."""
    monkeypatch.setattr(lbf_capacity, "ARCHITECTURES", ((), (2,)))
    monkeypatch.setattr(lbf_capacity, "USUAL", (2,))
    asked = []

    def untrained(settings, data, progress):
        asked.append([{scene.name for scene in part} for part in data])
        return SimpleNamespace(model=replace(settings.start(), card={"best_epoch": 0}))

    monkeypatch.setattr(lbf_capacity, "train_lbf", untrained)
    return asked


@pytest.fixture(scope="module")
def found(scenes, config, tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lbf_capacity, "ARCHITECTURES", ((), (2,)))
        patch.setattr(lbf_capacity, "USUAL", (2,))
        return study(config, scenes, tmp_path_factory.mktemp("study") / "capacity.json", progress=False)


def test_every_candidate_is_measured_in_every_fold(found):
    assert [one.hidden for one in found.architectures.candidates] == [(), (2,)]
    assert list(found.groups) == [ALL, "without albedo", "without visibility", "without colour"]
    for one in (*found.architectures.candidates, *found.groups.values()):
        assert one.errors.shape == one.fitted.shape == (3,)
        assert (one.errors > 0).all()
        assert one.errors.mean() < 0.8  # filtering helps
        assert one.seconds > 0
    for one in found.architectures.candidates:
        assert one.parameters == replace(TRAIN, hidden=one.hidden).start().network.size
    inputs = 7 * 2 + 1  # kinds for both groups, and the sampling rate
    assert found.groups["without colour"].parameters == (inputs + 1) * 2 + (2 + 1) * 4
    assert found.architectures.chosen in (0, 1)


def test_the_group_that_means_something_is_missed_and_the_other_is_not(found):
    harm, spread = found.harm("without albedo")
    assert harm > 3 * spread
    noise, _ = found.harm("without visibility")
    assert abs(noise) < 0.2 * harm
    assert found.harm(ALL) == (0.0, 0.0)


def candidate(parameters, errors, hidden=(2,)):
    return Candidate(hidden, parameters, np.array(errors), np.array(errors), 1.0)


def test_the_standard_error_is_that_of_the_difference():
    """Folds of very different difficulty, one tenth more in each: the difference is known well."""
    here, there = candidate(9, [0.2, 0.6, 1.0]), candidate(9, [0.1, 0.5, 0.9])
    mean, spread = difference(here, there)
    assert mean == pytest.approx(0.1)
    assert spread < 1e-12
    assert here.standard_error > 0.2


def test_enough_is_judged_fold_by_fold():
    """The smallest is within one standard error of the best, but worse in every fold; the middle one is not."""
    small = candidate(10, [0.15, 0.55, 0.95], ())
    middle = candidate(20, [0.09, 0.51, 0.90], (2,))
    best = candidate(40, [0.1, 0.5, 0.89], (4,))
    found = Study({}, Capacity("", "", (small, middle, best)), {})
    assert found.architectures.best == 2
    assert found.architectures.chosen == 0
    assert found.enough == 1
    assert found.excess[2] == (0.0, 0.0)


def test_tables_and_chart_show_it(found):
    lines = difference_lines(found)
    best = found.architectures.candidates[found.architectures.best].label
    other = {"2": "linear", "linear": "2"}[best]
    assert f"more than the best, {best}; enough, as far as one can tell: " in lines[0]
    assert re.fullmatch(rf"  {other} +\+0\.\d{{4}} \+- 0\.\d{{4}}", lines[1])
    assert lines[3].endswith(f"more than with all groups, {found.groups[ALL].mean:.4f}")
    harm, spread = found.harm("without albedo")
    assert lines[4] == f"  {'without albedo':24s}  +{harm:.4f} +- {spread:.4f}"
    assert lines[5].startswith("  without visibility ")
    left, right = differences_figure(found).axes
    assert [text.get_text() for text in left.get_yticklabels()] == ["linear", "2"]
    assert [text.get_text() for text in right.get_yticklabels()] == [
        "without albedo",
        "without visibility",
        "without colour",
    ]
    drawn = [(line.get_xdata()[0], line.get_ydata()[0]) for line in right.lines if len(line.get_xdata()) == 1]
    assert (harm, 2) in drawn


def test_it_goes_on_behind_the_last_candidate(scenes, config, quick, tmp_path, monkeypatch):
    """Interrupted in the third candidate, it trains only what is missing, to the same numbers."""
    path, untrained, config = tmp_path / "capacity.json", lbf_capacity.train_lbf, replace(config, folds=2)

    def stops(*given, **more):
        if len(quick) == 5:
            raise KeyboardInterrupt
        return untrained(*given, **more)

    monkeypatch.setattr(lbf_capacity, "train_lbf", stops)
    with pytest.raises(KeyboardInterrupt):
        study(config, scenes, path, progress=False)
    assert len(json.loads(path.read_text())["candidates"]) == 2
    monkeypatch.setattr(lbf_capacity, "train_lbf", untrained)
    resumed = study(config, scenes, path, progress=False)
    assert len(quick) == 5 + 8
    whole = study(config, scenes, tmp_path / "whole.json", progress=False)
    assert list(whole.groups) == list(resumed.groups)
    for name, one in whole.groups.items():
        np.testing.assert_array_equal(one.errors, resumed.groups[name].errors)


def test_a_study_with_other_settings_is_not_gone_on_with(scenes, config, quick, tmp_path):
    path = tmp_path / "capacity.json"
    study(config, scenes, path, progress=False)
    other = StudyConfig(replace(TRAIN, epochs=3), scenes=6, spp=(4,), folds=3, judged_rows=10)
    with pytest.raises(ValueError, match=re.escape("capacity.json holds a study with another train. Use the same")):
        study(other, scenes, path, progress=False)
    with pytest.raises(ValueError, match="another spp"):
        study(replace(config, spp=(4, 16)), scenes, path, progress=False)
    with pytest.raises(ValueError, match=re.escape("spp must be some of 4, 16, got 4, 8.")):
        study(replace(config, spp=(4, 8)), scenes, path, progress=False)
    with pytest.raises(ValueError, match="another names"):
        study(config, scenes[::-1], path, progress=False)


def test_held_out_scenes_are_never_learnt_from(scenes, config, quick, tmp_path, monkeypatch):
    error = lbf_capacity.error_of

    def judged(model, scenes, chosen, *rest):
        quick[-1].append({scenes[k].name for k in chosen})
        return error(model, scenes, chosen, *rest)

    monkeypatch.setattr(lbf_capacity, "error_of", judged)
    study(config, scenes, tmp_path / "capacity.json", progress=False)
    assert len(quick) == 6 * 3
    for learnt, stop, held_out, fitted in quick:
        assert not learnt & stop
        assert not (learnt | stop) & held_out
        assert fitted <= learnt
        assert len(fitted) == len(held_out)
        assert len(learnt | stop | held_out) == 6
    assert set.union(*(held_out for *_, held_out, _ in quick[:3])) == {scene.name for scene in scenes}


def test_a_filter_that_does_nothing_has_error_1(scenes):
    model = LBFModel.random(GROUPS, hidden=[2], rng=np.random.default_rng(0), radius=0)
    assert error_of(model, scenes, [0, 3], TRAIN, 5) == pytest.approx(1.0, rel=1e-6)


def test_everybody_is_judged_by_the_same_rows_and_groups(scenes, monkeypatch):
    """Whatever the model and whoever else is judged: rows and dropped groups belong to the scene."""
    seen = []
    monkeypatch.setattr(
        LBFModel,
        "theta",
        lambda self, primary: seen.append((id(primary.colour), primary.groups)) or theta(self, primary),
    )
    layer = LBFModel.layer
    monkeypatch.setattr(
        LBFModel, "layer", lambda self, primary, rows: seen.append(tuple(rows)) or layer(self, primary, rows=rows)
    )
    drop = replace(TRAIN, drop=True)
    for hidden, chosen in (((2,), [1, 4]), ((), [4, 1])):
        seen.append("next")
        model = LBFModel.random(GROUPS, hidden=hidden, rng=np.random.default_rng(1), radius=1)
        error_of(model, scenes, chosen, drop, 5)
    one, other = (seen[1 : len(seen) // 2], seen[len(seen) // 2 + 1 :])
    assert sorted(map(str, one)) == sorted(map(str, other))
    assert len(set(map(str, one))) > 2


def theta(model, primary):
    """`LBFModel.theta`, which a test replaces."""
    inputs = model.inputs(primary)
    y, _ = model.network.forward(inputs.reshape(-1, inputs.shape[-1]))
    return model.arrange(y, model.known(primary).groups).reshape(*inputs.shape[:2], -1)


def test_two_scenes_are_needed_to_learn_and_to_stop():
    with pytest.raises(ValueError, match="two scenes or more to see, got 1"):
        split([3], seed=0)
    learnt, stop = split(range(16), seed=5)
    assert len(learnt) == 12
    assert sorted(learnt + stop) == list(range(16))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "there is no file"),
        ("{", "is not the whole file of a study"),
        ('{"format": "other"}', "is no study of LBF's capacity"),
        ("[1]", "is no study of LBF's capacity"),
    ],
)
def test_a_foreign_file_is_refused(content, words, tmp_path):
    path = tmp_path / "capacity.json"
    if content:
        path.write_text(content)
    with pytest.raises(ValueError, match=words):
        load_study(path)


def test_the_command_prints_tables_and_writes_charts(scenes, quick, tmp_path, capsys, monkeypatch):
    asked = []
    monkeypatch.setattr(lbf_capacity, "load_data", lambda *given: asked.append(given) or (scenes[:5], scenes[5:]))
    monkeypatch.setattr(lbf_capacity, "StudyConfig", lambda train=TRAIN, **given: StudyConfig(train, **given))
    numbers, chart = tmp_path / "capacity.json", tmp_path / "capacity.png"
    options = ["--json", str(numbers), "--out", str(chart), "--data", str(tmp_path), "--scenes", "6", "--folds", "2"]
    options += ["--spp", "4"]
    assert lbf_capacity.main([*options, "--epochs", "2", "--radius", "2", "--rows", "4", "--size", "20"]) == 0
    output = capsys.readouterr().out
    assert re.search(r"^  linear +92 +0\.\d+", output, re.MULTILINE)
    assert "chosen" in output
    assert "without visibility" in output
    config, folder = asked[0]
    assert (config.scenes, config.validation, config.size, folder) == (5, 1, 20, tmp_path)
    assert load_study(numbers).settings["train"]["training_radius"] == 2
    for path in (chart, tmp_path / "capacity_differences.png"):
        assert path.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "the following arguments are required: --json"),
        (["--json", "numbers.txt"], "a name that ends in .json"),
        (["--json", "a.json", "--out", "chart.pdf"], "the charts one in .png"),
        (["--json", "nowhere/a.json"], "The folder nowhere must exist"),
        (["--json", "a.json", "--scenes", "1"], "scenes must be at least 2"),
        (["--json", "a.json", "--variant", "median"], "invalid choice: 'median'"),
    ],
)
def test_bad_arguments_take_one_line_and_exit_code_2(arguments, words, capsys):
    assert lbf_capacity.main(arguments) == 2
    said = capsys.readouterr()
    assert words in said.err
    assert said.err.count("\n") == 1
