"""The figures of chapter 07: what they claim holds, and what is stored is what the page shows."""

from itertools import product

import numpy as np
import pytest

from mcdenoise.nn import MLP, half_planes, train_perceptron
from mcdenoise.study.figures import _ch07_curves as curves
from mcdenoise.study.figures import _ch07_data as data
from mcdenoise.study.figures import _ch07_features as features
from mcdenoise.study.figures import _ch07_layers as layers
from mcdenoise.study.figures import _ch07_rule as rule
from mcdenoise.study.figures import _ch07_trained as trained
from mcdenoise.study.figures.__main__ import rounded
from mcdenoise.study.figures.ch07 import FIGURES
from mcdenoise.study.neurons import layer_outputs
from stored_figures import (
    assert_quoted_numbers_exist,
    assert_same_numbers,
    assert_stored_shown_and_small,
    stored_numbers,
)

pytestmark = pytest.mark.ch07

STORED = stored_numbers("ch07")
CHEAP = (
    "timeline", "one_dimension", "geometry", "bound", "gates", "polynomial", "perceptron_features", "xor_network", "regions",
    "polygons", "checker_by_hand", "step_gradient",
)  # fmt: skip


@pytest.mark.parametrize("name", CHEAP)
def test_stored_numbers_are_those_of_the_code(name):
    assert_same_numbers(rounded(FIGURES[name]()[1], name), STORED[name])


def test_every_figure_is_stored_shown_and_small():
    assert_stored_shown_and_small("ch07", FIGURES)


def test_the_page_quotes_numbers_that_exist():
    assert_quoted_numbers_exist("ch07", at_least=70)


def test_a_line_answers_the_question_of_the_pixels_but_saves_little():
    of, errors = STORED["answers"], STORED["answers"]["relmse"]
    assert of["right"] > of["wide"] + 0.2
    assert errors["labels"] < errors["line"] < errors["narrow"] < errors["noisy"] < errors["wide"]
    assert of["share_saved"] < 1 / 3
    assert of["cost"] > 2 * of["saved"] > 0
    assert of["weight"][0] > 0 > of["weight"][1]  # noise asks for the wide filter, a slope for the narrow one


def test_distances_of_the_geometry():
    of = STORED["geometry"]
    weight, bias, at = np.array(of["weight"]), of["bias"], np.array(of["at"])
    foot = of["distance"] * weight / of["length"]
    assert foot @ weight + bias == pytest.approx(0, abs=1e-9)
    assert (at - of["point"] * weight / of["length"]) @ weight + bias == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("gap", [0.3, 0.01])
def test_points_with_a_gap_have_the_gap(gap):
    x, labels, line = rule.separable(200, gap, np.random.default_rng(1))
    away = (2 * labels - 1) * (x @ line[:2] + line[2])
    assert gap - 1e-12 <= away.min() < gap + 0.05
    assert np.hypot(*line[:2]) == pytest.approx(1)


def test_no_set_needs_more_corrections_than_its_bound():
    of = STORED["bound"]
    assert 0 < of["loosest"] < of["closest"] < 1
    for k in range(4):  # half the gap: four times the bound, about twice the corrections
        assert 3 < of["bound"][k + 1] / of["bound"][k] < 4.5
        assert 1.5 < of["median"][k + 1] / of["median"][k] < 3
    for seed in range(20):
        x, labels, line = rule.separable(30, 0.1, np.random.default_rng(seed))
        for rng in (None, np.random.default_rng(seed)):
            done = train_perceptron(x, labels, epochs=1000, rng=rng)
            assert len(done.history) - 1 <= rule.novikoff(x, labels, line)


def test_both_halves_of_the_proof():
    """w . u grows by gamma a correction at least, |w|^2 by R^2 at most."""
    x, labels, line = rule.separable(40, 0.2, np.random.default_rng(0), reach=1.0)
    history, rows = train_perceptron(x, labels).history, np.column_stack([x, np.ones(len(x))])
    unit, corrections = line / np.linalg.norm(line), np.arange(len(train_perceptron(x, labels).history))
    gamma, longest = np.min((2 * labels - 1) * (rows @ unit)), np.square(rows).sum(axis=1).max()
    assert np.all(history @ unit >= corrections * gamma - 1e-9)
    assert np.all(np.square(history).sum(axis=1) <= corrections * longest + 1e-9)


def test_the_slider_shows_every_correction_of_the_rule():
    x, labels, _ = rule.separable(40, 0.2, np.random.default_rng(0), reach=1.0)
    done, of = train_perceptron(x, labels), STORED["slider_rule"]
    counts = [int(np.sum(rule._of(done, k).classify(x) != labels)) for k in range(len(done.history))]
    assert counts == of["wrong"]
    assert counts[-1] == 0 < min(counts[:-1])
    assert counts[3] > counts[2]  # a correction spoils others: the page says so
    assert of["corrections"] == sum(of["mistakes"]) < of["bound"]
    changes = np.diff(done.history, axis=0)
    for change in changes:  # the sample ringed is one of the set
        assert np.any(np.all(np.isclose(x, change[:2] / change[2]), axis=1))


def test_xor_has_no_line_and_two_of_sixteen_have_none():
    of = STORED["gates"]
    assert of["and"]["separated"]
    assert of["or"]["separated"]
    assert not of["xor"]["separated"]
    assert (of["of_2"], of["of_3"], of["best_xor"]) == (14, 104, 3)
    for name, labels in features.GATES.items():
        answers = features.CORNERS @ of[name.lower()]["weight"] + of[name.lower()]["bias"] >= 0
        assert np.array_equal(answers, labels) == of[name.lower()]["separated"]


def test_a_square_makes_an_interval_and_a_circle():
    of = STORED["polynomial"]
    assert of["separated"]
    assert of["threshold"] < 0.85
    low, high = of["interval"]
    assert -0.5 < low < -0.3 < 0.7 < high < 0.9  # the points are of class 1 from -0.4 to 0.8
    assert 0.45 < of["radius"] < 1
    assert of["rings_wrong"] == 0


def test_three_perceptrons_make_two_intervals():
    x = np.array([-1.5, -0.5, 0.5, 1.5])[:, np.newaxis]
    network = features.sum_of_steps()
    hidden, output = layer_outputs(network, x)
    np.testing.assert_array_equal(hidden.after, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1]])
    np.testing.assert_array_equal(output.after.ravel(), [0, 1, 0, 1])
    assert STORED["perceptron_features"]["changes"] == [-1, 0, 1]


def test_the_network_for_xor():
    assert STORED["xor_network"]["answers"] == [0, 1, 1, 0]
    np.testing.assert_array_equal(features.xor_by_hand().forward(features.CORNERS)[0].ravel(), features.GATES["XOR"])


def test_regions_are_as_many_as_the_formula_says():
    of = STORED["regions"]
    assert of["counted"] == of["formula"] == [1 + m + m * (m - 1) // 2 for m in of["m"]]


@pytest.mark.parametrize("m", [3, 6])
def test_no_region_is_missed_by_looking_at_crossings(m):
    """A fine grid over a large part of the plane finds no pattern that the crossings do not."""
    lines = layers.random_lines(m, seed=1)
    x = np.random.default_rng(0).normal(0, 3, (40_000, 2))
    found = len(np.unique(MLP(half_planes(lines)).forward(x)[0], axis=0))
    assert found <= layers.count_regions(lines) == 1 + m + m * (m - 1) // 2


@pytest.mark.parametrize("sides", layers.SIDES)
def test_polygons_contain_their_inner_circle_and_no_more_than_the_outer(sides):
    angle = np.linspace(0, 2 * np.pi, 360)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    answer = lambda radius: layers.polygon(sides).forward(radius * circle)[0]  # noqa: E731
    assert answer(0.999 * layers.RADIUS).all()
    assert not answer(1.001 * layers.RADIUS / np.cos(np.pi / sides)).any()
    assert 0 < answer(1.05 * layers.RADIUS).mean() < 1
    assert STORED["polygons"]["wrong"] == sorted(STORED["polygons"]["wrong"], reverse=True)


def test_the_checkerboard_is_right_in_every_cell():
    centres = np.array(list(product((-0.75, -0.25, 0.25, 0.75), repeat=2)))
    expected = np.floor(2 * (centres + 1)).sum(axis=1) % 2
    np.testing.assert_array_equal(layers.board().forward(centres)[0].ravel(), expected)
    hidden = layer_outputs(layers.board(), centres)
    assert [one.after.shape[1] for one in hidden] == STORED["checker_by_hand"]["neurons"] == [6, 8, 1]
    np.testing.assert_array_equal(hidden[1].after.sum(axis=0), np.ones(8))  # each second neuron is one cell
    assert STORED["checker_by_hand"]["wrong"] == 0


def test_stored_errors_are_those_of_the_trained_networks():
    network = data.trained("moons", (4,)).network
    assert data.wrong(network, *data.points("moons", 240)) == STORED["neurons_moons"]["wrong"] == 0
    unseen = data.wrong(network, *data.points("moons", trained.MANY, seed=9))
    assert unseen == pytest.approx(STORED["four_sets"]["moons"]["unseen"], abs=2e-3)  # rounding may move a point or two
    for name, of in STORED["four_sets"].items():
        assert of["train"] <= 0.02 < 0.1, name
        assert of["train"] <= of["unseen"] < 0.1, name
    assert STORED["neurons_checker"]["wrong"] == STORED["four_sets"]["checker"]["train"]


def test_behind_the_hidden_layer_a_plane_is_enough():
    for name in ("clouds", "rings"):
        assert STORED["coordinates"][name] == {"wrong": 0, "same": True}
    x, labels = data.points("clouds", 240)
    assert not train_perceptron(x, labels, epochs=50).separated
    hidden = layer_outputs(data.trained("clouds", (2,), epochs=1500, seed=1).network, x)[0].after
    assert train_perceptron(hidden, labels, epochs=200).separated


def test_three_lines_close_a_shape():
    of = STORED["slider_hidden"]
    one, two, three = of["unseen"][:3]
    assert of["neurons"][:3] == [1, 2, 3]
    assert one > two > 0.15 > 0.03 > three
    assert of["train"][2:] == [0] * 6
    assert of["unseen"][3] > three  # the page says that four happen to be worse
    assert of["unseen"][-1] >= of["unseen"][of["neurons"].index(6)]


def test_twice_the_steps_half_the_difference():
    of = STORED["slider_steps"]
    for k, count in enumerate(of["counts"]):
        for smooth, name in ((False, "steps"), (True, "sigmoids")):
            assert curves.distance(curves.steps_for(count, smooth)) == pytest.approx(of[name][k], rel=1e-3)
    ratios = np.array(of["steps"][2:-1]) / of["steps"][3:]
    np.testing.assert_allclose(ratios, 2, rtol=0.02)
    assert all(soft < hard for soft, hard in zip(of["sigmoids"], of["steps"], strict=True))


def test_a_step_is_flat_and_a_sigmoid_is_not():
    of = STORED["step_gradient"]
    assert of["flat"] > 0.98
    assert of["smooth_flat"] == 0
    assert of["turns"] == 1
    assert of["least_wrong"] < of["wrong_at_best"]


def test_the_rule_never_stops_without_a_line():
    of = STORED["never_stops"]
    assert of["clean_separated"]
    assert of["clean_epochs"] < of["epochs"]
    assert 0 < of["least"] <= of["last"] <= 1.2 * of["least"]
    assert of["right"]["worst"] < of["line"] - 0.2
    assert of["right"]["best"] <= of["line"] + 0.01


def test_more_neurons_fit_the_points_and_miss_the_others():
    of = STORED["overfit"]
    for train, unseen in ((of["train"], of["unseen"]), (of["mean_train"], of["mean_unseen"])):
        assert train == sorted(train, reverse=True)
        assert unseen == sorted(unseen)
    assert of["train"][2] == 0
    assert of["mean_unseen"][2] > of["mean_unseen"][0] + 0.04


def test_no_line_separates_the_pixels_of_the_rule():
    """A linear program finds none; it finds one for the points that have one."""
    optimize = pytest.importorskip("scipy.optimize")

    def has_line(x, labels):
        rows = -(2 * labels - 1)[:, np.newaxis] * np.column_stack([x, np.ones(len(x))])
        return optimize.linprog(np.zeros(3), rows, -np.ones(len(x)), bounds=(None, None)).status == 0

    assert has_line(*rule.separable(rule.SOME, 0.002, np.random.default_rng(3))[:2])
    x, labels, _ = data.pixels()
    some = np.random.default_rng(1).choice(len(x), rule.SOME, replace=False)
    assert not has_line(x[some], labels[some])
    assert labels.mean() == pytest.approx(STORED["answers"]["wide"], rel=1e-3)
