"""The smallest model that is as good as the best: the rule, the folds, the sweep, the tasks, the command."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdenoise.study import capacity, capacity_tasks
from mcdenoise.study.capacity import Candidate, Capacity, capacity_figure, k_folds, smallest_model, sweep

pytestmark = pytest.mark.ch08


def test_the_rule_by_hand():
    """Mean 0.19 and standard error 0.03 of the third: the second, with 0.20, is as good; the first, with 0.45, is not."""
    errors = np.array([[0.5, 0.4], [0.21, 0.19], [0.16, 0.22], [0.18, 0.22]])
    assert smallest_model([3, 9, 17, 33], errors) == 1
    assert smallest_model([3, 40, 17, 33], errors) == 2


def test_without_spread_the_best_is_chosen():
    errors = np.repeat([[0.3], [0.2], [0.1]], 4, axis=1)
    assert smallest_model([1, 2, 3], errors) == 2


def test_of_equally_many_parameters_the_better_one():
    errors = np.array([[0.15, 0.25], [0.14, 0.24], [0.1, 0.3]])
    assert smallest_model([5, 5, 9], errors) == 1


@given(st.integers(1, 6), st.integers(2, 6), st.integers(0, 1000))
def test_the_choice_is_within_one_standard_error_and_none_smaller_is(m, folds, seed):
    rng = np.random.default_rng(seed)
    errors, parameters = rng.random((m, folds)), rng.integers(1, 50, m).tolist()
    chosen, means = smallest_model(parameters, errors), errors.mean(axis=1)
    best = int(np.argmin(means))
    limit = means[best] + errors[best].std(ddof=1) / np.sqrt(folds)
    assert means[chosen] <= limit
    assert all(parameters[k] >= parameters[chosen] for k in range(m) if means[k] <= limit)


@pytest.mark.parametrize(
    ("parameters", "errors", "words"),
    [
        ([1], [[0.1]], r"two folds or more, for the 1 models, got \(1, 1\)"),
        ([1, 2], [[0.1, 0.2]], r"for the 2 models, got \(1, 2\)"),
        ([1], [[0.1, np.nan]], "errors must be finite"),
    ],
)
def test_the_rule_refuses(parameters, errors, words):
    with pytest.raises(ValueError, match=words):
        smallest_model(parameters, np.array(errors))


@given(st.lists(st.integers(0, 8), min_size=4, max_size=60), st.integers(2, 4), st.integers(0, 99))
def test_each_row_is_judged_once_and_groups_stay_together(groups, folds, seed):
    if len(set(groups)) < folds:
        with pytest.raises(ValueError, match="folds must be from 2 to"):
            k_folds(groups, folds, np.random.default_rng(seed))
        return
    parts = k_folds(groups, folds, np.random.default_rng(seed))
    assert np.array_equal(np.sort(np.concatenate([judged for _, judged in parts])), np.arange(len(groups)))
    for trained, judged in parts:
        assert not set(np.array(groups)[trained]) & set(np.array(groups)[judged])
        assert len(trained) + len(judged) == len(groups)


def test_the_sweep_trains_on_one_part_and_judges_on_the_other():
    seen = []
    folds = k_folds(range(9), 3, np.random.default_rng(0))
    found = sweep(
        "sizes",
        "1",
        [(), (4,), (4, 2)],
        folds,
        lambda hidden, rows: (seen.append((hidden, len(rows))) or (hidden, set(rows)), 1 + sum(hidden)),
        lambda model, rows: float(len(model[1] & set(rows))) + 1 / (1 + len(model[0])),
    )
    assert seen == [(hidden, 6) for hidden in ((), (4,), (4, 2)) for _ in range(3)]
    assert [one.errors.tolist() for one in found.candidates] == [[1.0] * 3, [0.5] * 3, pytest.approx([1 / 3] * 3)]
    assert found.candidates[0].fitted.tolist() == [7.0] * 3
    assert [one.label for one in found.candidates] == ["linear", "4", "4-2"]
    assert found.best == found.chosen == 2
    with pytest.raises(ValueError, match="At least one architecture and two folds are needed, got 0 and 3"):
        sweep("", "", [], folds, None, None)


def made_up():
    errors = {(): [0.5, 0.6], (2,): [0.21, 0.2], (8,): [0.1, 0.3], (2, 2): [0.3, 0.3]}
    sizes = {(): 3, (2,): 9, (8,): 33, (2, 2): 15}
    return Capacity(
        "made up",
        "1",
        tuple(Candidate(h, sizes[h], np.array(e), np.array(e) / 2, 0.1 * sizes[h]) for h, e in errors.items()),
    )


def test_the_chart_shows_every_model_the_limit_and_the_choice():
    figure = capacity_figure(made_up())
    left, right = figure.axes
    words = [text.get_text() for text in left.get_legend().get_texts()]
    assert {"linear", "one hidden layer", "two hidden layers", "chosen: 2", "best + one standard error"} <= set(words)
    assert sorted(text.get_text() for text in left.texts) == ["2", "2-2", "8"]
    assert sum(len(line.get_xdata()) for line in right.lines) == 4
    assert figure._suptitle.get_text() == "made up"


def test_the_table_marks_best_and_chosen():
    best, chosen = (
        next(line for line in capacity.lines(made_up()) if line.endswith(word)) for word in ("best", "chosen")
    )
    assert best.split()[:2] == ["8", "33"]
    assert chosen.split()[:2] == ["2", "9"]


# --- tasks


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(capacity_tasks, "PLANE", ((), (4,)))
    monkeypatch.setattr(capacity_tasks, "DENOISE", ((), (2,)))
    monkeypatch.setattr(capacity_tasks, "EPOCHS", 100)


@pytest.mark.parametrize("task", ["two_moons", "rings", "xor", "checker"])
def test_points_have_two_columns_and_two_classes(task):
    data = capacity_tasks.TASKS[task](50, 0)
    again = capacity_tasks.TASKS[task](50, 0)
    assert data.x.shape == (50, 2)
    assert set(data.target.ravel()) == {0.0, 1.0}
    assert np.array_equal(data.x, again.x)
    assert data.error(data.target - 0.5, np.arange(50)) == 0
    assert data.error(0.5 - data.target, np.arange(50)) == 1


def test_rings_need_a_hidden_layer(quick):
    """A line is right half of the time; four hidden neurons nearly always."""
    found = capacity_tasks.run_task("rings", 150, folds=3)
    assert found.candidates[0].mean > 0.3
    assert found.candidates[1].mean < 0.15
    assert found.chosen == 1
    assert [one.parameters for one in found.candidates] == [3, 17]


def test_what_the_network_sees_of_an_image(rng):
    image = rng.random((6, 7, 3))
    seen = capacity_tasks.windows(image, 3)
    assert seen.shape == (6, 7, 27)
    np.testing.assert_array_equal(seen[2, 3].reshape(3, 3, 3), image[1:4, 2:5])
    np.testing.assert_array_equal(seen[0, 0].reshape(3, 3, 3), image[[0, 0, 1]][:, [0, 0, 1]])


def test_denoising_data_keeps_tiles_together_and_is_judged_in_relmse(rng, samples):
    reference = rng.gamma(1.0, 0.5, (samples.height, samples.width, 3))
    data = capacity_tasks.denoise_data(samples, reference, points=20, seed=0)
    assert data.x.shape == (20, 75 + 3 + 1 + 3)
    assert np.isfinite(data.x).all()
    assert data.error(data.target, np.arange(20)) < 1e-20
    off = np.log1p(2 * np.expm1(data.target))
    kept = np.expm1(data.target)
    assert data.error(off, np.arange(20)) == pytest.approx(np.mean(kept**2 / (kept**2 + 0.01)))
    assert set(data.groups) == {0}


# --- the command


def test_the_command_prints_a_table_and_writes_a_chart(quick, capsys, tmp_path):
    chart = tmp_path / "chart.png"
    assert capacity.main(["two_moons", "--points", "60", "--folds", "2", "--out", str(chart)]) == 0
    output = capsys.readouterr().out
    assert re.search(r"^  linear +3 +0\.\d+ \+- 0\.\d+", output, re.MULTILINE)
    assert "chosen" in output
    assert chart.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["sevens"], "invalid choice: 'sevens'"),
        (["xor", "--folds", "1"], "folds must be at least 2|folds must be from 2"),
        (["xor", "--points", "-3"], "n must be at least 1, got -3"),
        (["xor", "--out", "chart.pdf"], "needs a name that ends in .png, got 'chart.pdf'"),
        (["xor", "--points", "12", "--folds", "2", "--out", "nowhere/chart.png"], "The folder nowhere must exist"),
    ],
)
def test_bad_arguments_take_one_line_and_exit_code_2(arguments, words, capsys, quick):
    assert capacity.main(arguments) == 2
    said = capsys.readouterr()
    assert re.search(words, said.err)
    assert said.err.count("\n") == 1
