"""The perceptron and its rule, networks of half planes built by hand, and the points to classify."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdenoise.nn import (
    MLP,
    Perceptron,
    all_of,
    any_of,
    checker,
    half_planes,
    rings,
    train_perceptron,
    two_moons,
    xor,
)

pytestmark = pytest.mark.ch07
CORNERS = np.array([[0, 0], [0, 1], [1, 0], [1, 1]], float)
DATA = {"moons": two_moons, "rings": rings, "xor": xor, "checker": checker}


def separable(seed, n=60, gap=0.2):
    """Points of the square on both sides of a random line, none nearer to it than `gap`."""
    rng = np.random.default_rng(seed)
    weight, bias = rng.normal(size=2), 0.3 * rng.normal()
    weight /= np.linalg.norm(weight)
    x = rng.uniform(-1, 1, (20 * n, 2))
    x = x[np.abs(x @ weight + bias) > gap][:n]
    return x, (x @ weight + bias >= 0).astype(int), np.append(weight, bias)


def run(layers, x):
    return MLP(tuple(layers)).forward(np.asarray(x, float))[0]


def test_the_answer_is_one_on_the_side_of_the_weight_and_on_the_line():
    perceptron = Perceptron(np.array([3.0, 4.0]), -5.0)  # the line is 1 from the origin
    assert perceptron.classify([[0.6, 0.8], [0.59, 0.8], [3, 4], [-3, -4]]).tolist() == [1, 0, 1, 0]


@given(seed=st.integers(0, 10_000))
def test_the_rule_separates_what_a_line_can_within_novikoffs_bound(seed):
    x, labels, line = separable(seed)
    done = train_perceptron(x, labels, epochs=10_000)
    assert done.separated
    assert np.array_equal(done.perceptron.classify(x), labels)
    assert done.mistakes[-1] == 0
    assert done.mistakes.sum() == len(done.history) - 1
    with_one = np.concatenate([x, np.ones((len(x), 1))], axis=1)
    gap = np.abs(with_one @ line).min() / np.linalg.norm(line)  # that of one line: the widest is no smaller
    assert done.mistakes.sum() <= (with_one**2).sum(axis=1).max() / gap**2


def test_each_correction_is_the_rule():
    x, labels, _ = separable(3)
    done = train_perceptron(x, labels, rate=0.5)
    assert not done.history[0].any()
    for before, after in pairwise(done.history):
        wrong = [one for one in zip(x, labels, strict=True) if (one[0] @ before[:-1] + before[-1] >= 0) != one[1]]
        steps = [0.5 * (2 * label - 1) * np.append(one, 1) for one, label in wrong]
        assert any(np.allclose(after - before, step, atol=1e-14) for step in steps)
    assert np.array_equal(done.history[-1], [*done.perceptron.weight, done.perceptron.bias])


def test_the_rate_scales_the_weights_and_changes_no_answer():
    x, labels, _ = separable(5)
    one, other = (train_perceptron(x, labels, rate=rate) for rate in (1.0, 0.25))
    assert np.array_equal(one.mistakes, other.mistakes)
    np.testing.assert_allclose(other.history, 0.25 * one.history, rtol=1e-12)


@pytest.mark.parametrize(
    ("table", "line"), [((0, 0, 0, 1), True), ((0, 1, 1, 1), True), ((1, 0, 0, 0), True), ((0, 1, 1, 0), False)]
)
def test_and_or_nor_have_a_line_and_xor_has_none(table, line):
    done = train_perceptron(CORNERS, table, epochs=200)
    assert done.separated == line
    assert len(done.mistakes) < 200 if line else len(done.mistakes) == 200
    if not line:
        assert (done.mistakes > 0).all()
        assert np.abs(done.history).max() < 10  # it does not run away, it goes round


def test_shuffling_needs_a_generator_and_repeats():
    x, labels, _ = separable(1, gap=0.02)
    one, other = (train_perceptron(x, labels, rng=np.random.default_rng(0), epochs=1000) for _ in range(2))
    assert np.array_equal(one.history, other.history)
    assert one.separated


# --- networks by hand


def test_half_planes_are_lines(rng):
    lines, x = rng.normal(size=(4, 3)), rng.normal(size=(50, 2))
    expected = (x @ lines[:, :2].T + lines[:, 2] >= 0).astype(float)
    assert np.array_equal(run(half_planes(lines), x), expected)


@given(st.data())
def test_gates_are_and_and_or(data):
    """Every input of 0 and 1, every group, against Python's own all and any."""
    inputs = data.draw(st.integers(1, 5))
    places = data.draw(st.lists(st.integers(0, inputs - 1), min_size=1, max_size=inputs, unique=True))
    group = [k if data.draw(st.booleans()) else ~k for k in places]
    x = np.array(np.meshgrid(*[[0.0, 1.0]] * inputs)).reshape(inputs, -1).T
    wished = np.array([[row[k] == 1 if k >= 0 else row[~k] == 0 for k in group] for row in x])
    assert np.array_equal(run(all_of([group], inputs), x)[:, 0], wished.all(axis=1))
    assert np.array_equal(run(any_of([group], inputs), x)[:, 0], wished.any(axis=1))


def test_two_layers_make_xor():
    first = half_planes([[1, 0, -0.5], [0, 1, -0.5]])
    layers = (*first, *all_of([[0, ~1], [~0, 1]], 2), *any_of([[0, 1]], 2))
    assert run(layers, CORNERS).ravel().tolist() == [0, 1, 1, 0]


def test_a_square_with_a_hole_needs_three_layers():
    def sides(r):
        return [[1, 0, r], [-1, 0, r], [0, 1, r], [0, -1, r]]

    layers = (*half_planes(sides(1) + sides(0.5)), *all_of([[0, 1, 2, 3], [4, 5, 6, 7]], 8), *all_of([[0, ~1]], 2))
    assert run(layers, [[0, 0], [0.75, 0], [0, -0.75], [1.5, 0], [0.75, 0.75]]).ravel().tolist() == [0, 1, 1, 0, 1]


def test_lines_in_general_position_make_so_many_regions(rng):
    """1 + m + m (m - 1) / 2 patterns of a layer of m half planes: what the next layer can tell apart."""
    for m in (1, 2, 3, 4):
        angles = np.pi * (np.arange(m) + 0.3) / m
        lines = np.stack([np.cos(angles), np.sin(angles), 0.1 * np.array([1, -1, 2, 1.5])[:m]], axis=1)
        x = 20 * rng.normal(size=(100_000, 2)) * rng.random((100_000, 1)) ** 4
        assert len(np.unique(run(half_planes(lines), x), axis=0)) == 1 + m + m * (m - 1) // 2


# --- points


@pytest.mark.parametrize("name", DATA)
def test_points_and_classes(name):
    x, labels = DATA[name](301, rng=np.random.default_rng(0))
    again, _ = DATA[name](301, rng=np.random.default_rng(0))
    assert x.shape == (301, 2)
    assert labels.shape == (301,)
    assert set(labels) == {0, 1}
    assert np.array_equal(x, again)
    assert np.abs(x).max() < 2
    assert np.abs(x.mean(axis=0)).max() < 0.25
    assert 0.35 < labels.mean() < 0.65


@pytest.mark.parametrize("name", DATA)
def test_no_line_separates_them(name):
    x, labels = DATA[name](200, rng=np.random.default_rng(1))
    assert not train_perceptron(x, labels, epochs=30).separated


def test_without_noise_the_shapes_are_exact():
    x, labels = two_moons(200, rng=np.random.default_rng(0), noise=0.0)
    upper, lower = x[labels == 0] + [0.5, 0.25], x[labels == 1] + [0.5, 0.25]
    np.testing.assert_allclose(np.hypot(*upper.T), 1, rtol=1e-12)
    np.testing.assert_allclose(np.hypot(lower[:, 0] - 1, lower[:, 1] - 0.5), 1, rtol=1e-12)
    assert (upper[:, 1] >= 0).all()
    assert (lower[:, 1] <= 0.5).all()
    x, labels = checker(500, rng=np.random.default_rng(0), cells=3)
    cell = np.floor((x + 1) * 1.5).astype(int)
    assert np.array_equal(cell.sum(axis=1) % 2, labels)


# --- words


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Perceptron(np.ones(2), 0.0).classify([1.0, 2.0]), r"needs x of shape \(n, 2\), got \(2,\)"),
        (lambda: train_perceptron([[1.0]], [2]), r"labels \(n,\) of 0 and 1"),
        (lambda: train_perceptron([[1.0]], [0, 1]), r"got \(1, 1\) and \(2,\)"),
        (lambda: train_perceptron(np.zeros((0, 2)), []), "n above 0"),
        (lambda: train_perceptron([[np.inf]], [1]), "x must be finite"),
        (lambda: train_perceptron([[1.0]], [1], rate=0), "rate must be greater than 0"),
        (lambda: train_perceptron([[1.0]], [1], epochs=0), "epochs must be at least 1"),
        (lambda: half_planes([1.0, 2.0]), r"lines must be \(m, d \+ 1\), the bias last, got shape \(2,\)"),
        (lambda: all_of([[0, 2]], 2), r"A group names inputs 0 to 1 \(or ~k\), each once, at least one; got \[0, 2\]"),
        (lambda: any_of([[]], 2), r"got \[\]"),
        (lambda: any_of([[0, ~0]], 2), r"got \[0, -1\]"),
        (lambda: two_moons(0, rng=np.random.default_rng(0)), "n must be at least 1"),
        (lambda: rings(5, rng=np.random.default_rng(0), noise=-1), "noise must be at least 0, got -1"),
        (lambda: checker(5, rng=np.random.default_rng(0), cells=0), "cells must be at least 1"),
    ],
)
def test_what_is_refused(call, words):
    with pytest.raises(ValueError, match=words):
        call()
