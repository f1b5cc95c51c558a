"""The exercises of chapter 07 tested themselves: the reference earns every point, each typical mistake is named."""

import itertools

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import Delaunay

import mcdenoise as mcd
from answers import ROOT, assert_earns_every_point, assert_mistake_is_named, failures, reference
from mcdenoise.classroom.checking.cells import parse_cells

pytestmark = pytest.mark.ch07


# --- perceptron


def answers(x, weight, bias, *, step=lambda total: total >= 0, kind=int):
    """Answers as a student would write them, with places for mistakes."""
    total = np.array([sum(row[k] * weight[k] for k in range(len(weight))) for row in x]) + bias
    return step(total).astype(kind)


def with_step(step, kind=float):
    return lambda *a: answers(*a, step=step, kind=kind)


def spoiling_perceptron(x, weight, bias):
    x *= weight
    return (x.sum(axis=1) + bias >= 0).astype(int)


# --- perceptron_step


def step(weight, bias, x, label, rate, *, answer=None, w=None, b=None):
    """One step of the rule, each part open to a mistake."""
    y = float(weight @ x + bias >= 0) if answer is None else answer(weight, bias, x)
    error = label - y
    new = weight + rate * error * x if w is None else w(weight, rate, error, x)
    return new, bias + rate * error if b is None else b(bias, rate, error)


def with_answer(answer):
    return lambda *a: step(*a, answer=answer)


def with_changes(w=None, b=None):
    return lambda *a: step(*a, w=w, b=b)


def flipped(weight, bias, x, label, rate):
    return step(weight, bias, x, label, -rate)


def signed(weight, bias, x, label, rate):
    """Answers and labels -1 and 1."""
    error = (2 * label - 1) - np.where(weight @ x + bias >= 0, 1, -1)
    return weight + rate * error * x, bias + rate * error


def label_alone(weight, bias, x, label, rate):
    return weight + rate * label * x, bias + rate * label


def spoiling_step(weight, bias, x, label, rate):
    weight += rate * (label - (weight @ x + bias >= 0)) * x
    return weight, bias


def always_moving(weight, bias, x, label, rate):
    return weight + rate * (2 * label - 1) * x, bias + rate * (2 * label - 1)


def corrections_alone(weight, bias, x, label, rate):
    new = step(weight, bias, x, label, rate)
    return new[0] - weight, new[1] - bias


# --- xor_layers


def gates(first, second, w_2=(1.0, -1.0), b_2=-0.5):
    """Two hidden neurons that compare the sum of the inputs with two numbers."""
    return lambda: (np.ones((2, 2)), np.array([-first, -second]), np.array([list(w_2)]), np.array([b_2]))


xor = gates(0.5, 1.5)


def by_subtraction():
    """One input without the other, or the other without the one."""
    return np.array([[1, -1], [-1, 1]]), np.array([-0.5, -0.5]), np.array([[1, 1]]), np.array([-0.5])


def transposed():
    weight = np.array([[1.0, -2.0], [1.0, -2.0]])
    return weight, np.array([-0.5, 3.0]), np.array([[1.0, 1.0]]), np.array([-1.5])


# --- polygon_layers


def polygon(corners, *, normal=lambda e: np.stack([-e[:, 1], e[:, 0]], axis=1), sign=-1, w_2=1.0, b_2=None):
    """A network for a polygon, with places for mistakes."""
    weight = normal(np.roll(corners, -1, axis=0) - corners)
    m = len(corners)
    bias = sign * np.einsum("ij,ij->i", weight, corners)
    return weight, bias, np.full((1, m), w_2), np.array([0.5 - m if b_2 is None else b_2])


def polygon_with(**changes):
    return lambda corners: polygon(corners, **changes)


def unit_normals(corners):
    """As right as the others."""
    weight, bias, *rest = polygon(corners)
    length = np.hypot(*weight.T)
    return weight / length[:, np.newaxis], bias / length, *rest


def to_the_right(edge):
    return np.stack([edge[:, 1], -edge[:, 0]], axis=1)


def complement(corners):
    weight, bias, w_2, b_2 = polygon(corners)
    return weight, bias, -w_2, -b_2


def not_closed(corners):
    weight, bias, w_2, b_2 = polygon(corners)
    w_2[0, -1] = 0
    return weight, bias, w_2, b_2 + 1


def missing_row(corners):
    return polygon(corners[:-1])


def shared_bias(corners):
    weight, bias, w_2, b_2 = polygon(corners)
    return weight, np.full_like(bias, bias.mean()), w_2, b_2


def spoiling_polygon(corners):
    layers = polygon(corners)
    corners -= corners.mean(axis=0)
    return layers


def changed(make, place, change):
    """Four arrays with one of them changed."""

    def layers(*arguments):
        found = list(make(*arguments))
        found[place] = change(found[place])
        return tuple(found)

    return layers


# --- slow_points


def pair(gap, far=1.0):
    return lambda: (np.array([[far, far], [far - gap, far - gap]]), np.array([1, 0]))


def squeezed():
    """Two points on each side of a slanted line, close to it and far from the origin."""
    return np.array([[0.9, 0.9], [1.0, 0.8], [0.9, 0.95], [1.0, 0.85]]), np.array([0, 0, 1, 1])


def one_below_the_other():
    return np.array([[0.5, 0.0], [0.5, 0.03]]), np.array([0, 1])


CORNERS = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
EITHER, HOLE = (1, 1, -0.5), (1, -1, -0.5)

# exercise, what the student did, the answer, what the message must say
WRONG = (
    ("four_points", "bias forgotten", (1, 1, 1, 1), "the bias is forgotten"),
    ("four_points", "strict", (1, 0, 0, 1), "lies on the line"),
    ("four_points", "sign of a weight", (1, 0, 1, 0), "-1 times -2 is 2"),
    ("four_points", "reversed", (0, 1, 0, 0), "the wrong way round"),
    ("four_points", "exchanged", (0, 0, 1, 0), "the weights are exchanged"),
    ("four_points", "sums", (1, -1, 0, 1), "these are the sums"),
    ("four_points", "a guess", (0, 0, 1, 1), "(1, 0) has not the answer 0"),
    ("four_points", "a word", "1011", "4 numbers are needed"),
    ("four_points", "three", (1, 0, 1), "4 numbers are needed"),
    ("perceptron", "no step", with_step(np.positive), "the step function is missing"),
    ("perceptron", "np.sign", with_step(np.sign), "these are -1 and 1"),
    ("perceptron", "-1 and 1", with_step(lambda t: np.where(t >= 0, 1, -1)), "these are -1 and 1"),
    ("perceptron", "reversed", with_step(lambda t: t < 0, int), "the wrong way round"),
    ("perceptron", "bias forgotten", lambda x, w, b: answers(x, w, 0), "the bias is forgotten"),
    ("perceptron", "bias taken off", lambda x, w, b: answers(x, w, -b), "it is added"),
    ("perceptron", "sigmoid", with_step(lambda t: 1 / (1 + np.exp(-t))), "that is a sigmoid"),
    ("perceptron", "first weight", lambda x, w, b: answers(x[:, :1], w[:1], b), "only the first weight"),
    ("perceptron", "not added up", lambda x, w, b: (x * w + b >= 0).astype(int), "x @ weight"),
    ("perceptron", "strict", with_step(lambda t: t > 0, int), ">= and not >"),
    ("perceptron", "heaviside", with_step(lambda t: np.heaviside(t, 0.5)), "on the line came 1/2"),
    ("perceptron", "truth values", with_step(lambda t: t >= 0, bool), "add .astype(int)"),
    ("perceptron", "decimal points", with_step(lambda t: t >= 0), "they are classes"),
    ("perceptron", "a column", lambda *a: answers(*a)[:, np.newaxis], "one too many"),
    ("perceptron", "one sample", lambda x, w, b: int(x[0] @ w + b >= 0), "shape"),
    ("perceptron", "weight first", lambda x, w, b: (w @ x + b >= 0).astype(int), "stopped with ValueError"),
    ("perceptron", "spoils its input", spoiling_perceptron, "modified its input `x`"),
    ("perceptron", "returns nothing", lambda *a: None, "is the `return` missing"),
    ("perceptron_step", "the wrong way", flipped, "not answer - label"),
    ("perceptron_step", "rate", lambda w, b, x, y, r: step(w, b, x, y, 1.0), "the rate is missing"),
    ("perceptron_step", "rate of b", with_changes(b=lambda b, r, e: b + e), "missing for the bias"),
    ("perceptron_step", "no bias", with_changes(b=lambda b, r, e: b), "the bias does not change"),
    ("perceptron_step", "bias back", with_changes(b=lambda b, r, e: b - r * e), "the bias moves the wrong way"),
    ("perceptron_step", "no weight", with_changes(w=lambda w, r, e, x: w), "the weight does not change"),
    ("perceptron_step", "no sample", with_changes(w=lambda w, r, e, x: w + r * e), "the sample is missing"),
    ("perceptron_step", "-1 and 1", signed, "a step twice as long"),
    ("perceptron_step", "the sum", with_answer(lambda w, b, x: w @ x + b), "the sum w . x + b stands"),
    ("perceptron_step", "corrections", corrections_alone, "the corrections alone"),
    ("perceptron_step", "label alone", label_alone, "label - answer is -1"),
    ("perceptron_step", "always moving", always_moving, "the answer is right, so nothing may change"),
    ("perceptron_step", "never moving", lambda w, b, x, y, r: (w, b), "but the answer was wrong"),
    ("perceptron_step", "bias not asked", with_answer(lambda w, b, x: float(w @ x >= 0)), "without the bias it would"),
    (
        "perceptron_step",
        "strict",
        with_answer(lambda w, b, x: float(w @ x + b > 0)),
        "The sum is 0, so the answer is 1",
    ),
    ("perceptron_step", "in place", spoiling_step, "modified its input `weight`"),
    ("perceptron_step", "weight alone", lambda *a: step(*a)[0], "two results are needed"),
    ("perceptron_step", "bias array", lambda *a: (step(*a)[0], np.array([step(*a)[1]])), "the bias is one number"),
    ("perceptron_step", "joined", lambda *a: (np.append(*step(*a)), 0.0), "the shape of the new weight"),
    ("perceptron_step", "returns nothing", lambda *a: None, "is the `return` missing"),
    ("has_a_line", "A", "NNNYN", "beside the origin"),
    ("has_a_line", "B", "YYNYN", "put a ruler"),
    ("has_a_line", "C", ("Y", "N", "Y", "Y", "N"), "the inner ring"),
    ("has_a_line", "D", "ynnnn", "the squared radius"),
    ("has_a_line", "E", "YNNYY", "that takes two lines"),
    ("has_a_line", "four letters", "YNNY", "5 letters"),
    ("has_a_line", "a number", 3, "5 letters"),
    ("slow_points", "a wide gap", pair(1.0), "make the gap narrower"),
    ("slow_points", "narrow", pair(1 / 16), "far from the origin"),
    ("slow_points", "XOR", lambda: (CORNERS, np.array([0, 1, 1, 0])), "Either there is no line"),
    ("slow_points", "too narrow", pair(1e-7), "the gap is too narrow"),
    ("slow_points", "one point twice", lambda: (np.ones((2, 2)), np.array([0, 1])), "stands in both classes"),
    ("slow_points", "one class", lambda: (CORNERS, np.ones(4)), "nothing to separate"),
    ("slow_points", "too far", lambda: (9 * CORNERS, np.array([0, 1, 1, 1])), "from -1 to 1"),
    ("slow_points", "NaN", lambda: (np.full((2, 2), np.nan), np.array([0, 1])), "from -1 to 1"),
    ("slow_points", "too many", lambda: (np.ones((50, 2)), np.ones(50)), "2 to 20 points"),
    ("slow_points", "-1 and 1", lambda: (CORNERS, np.array([-1, 1, 1, 1])), "labels are 0 or 1"),
    ("slow_points", "columns", lambda: (CORNERS[:3].T, np.array([0, 1, 1])), "an array (n, 2)"),
    ("slow_points", "a column of labels", lambda: (CORNERS, np.ones((4, 1))), "one a point"),
    ("slow_points", "no labels", lambda: CORNERS[:1], "returned"),
    ("xor_layers", "or", gates(0.5, 9.0), "that is OR"),
    ("xor_layers", "and", gates(9.0, 1.5, w_2=(1, 1)), "that is AND"),
    ("xor_layers", "nand", gates(-9.0, 1.5), "that is NAND"),
    ("xor_layers", "reversed", gates(0.5, 1.5, w_2=(-1, 1), b_2=0.5), "the wrong way round"),
    ("xor_layers", "too low", gates(0.5, 1.5, b_2=-2.0), "always 0"),
    ("xor_layers", "a step is 1 at 0", gates(0.5, 1.5, b_2=0.0), "always 1"),
    ("xor_layers", "too high", gates(0.5, 1.5, b_2=1.0), "always 1"),
    ("xor_layers", "transposed", transposed, "With weight_1 transposed"),
    ("xor_layers", "on the corners", gates(1.0, 2.0), "A line must not pass through a corner"),
    ("xor_layers", "near the corners", gates(0.3, 1.5), "nor within 0.2"),
    ("xor_layers", "nor", gates(0.5, 1.5, w_2=(-1, 0), b_2=0.5), "what does the second layer make of it"),
    ("xor_layers", "second layer flat", changed(xor, 2, np.ravel), "weight_2 must have the shape (1, 2)"),
    ("xor_layers", "bias a number", changed(xor, 3, np.squeeze), "bias_2 must have the shape (1,)"),
    ("xor_layers", "not finite", changed(xor, 1, lambda b: b * np.inf), "finite numbers"),
    ("xor_layers", "three arrays", lambda: xor()[:3], "four arrays are needed"),
    ("xor_layers", "returns nothing", lambda: None, "is the `return` missing"),
    ("polygon_layers", "union", polygon_with(b_2=-0.5), "all of them are needed"),
    ("polygon_layers", "complement", complement, "1 outside and 0 inside"),
    ("polygon_layers", "one missed", lambda c: polygon(c, b_2=1.5 - len(c)), "one edge may be missed"),
    ("polygon_layers", "triangles only", polygon_with(b_2=-2.5), "it depends on m"),
    ("polygon_layers", "to the right", polygon_with(normal=to_the_right), "inside is on their left"),
    ("polygon_layers", "never", polygon_with(b_2=-99.0), "0 everywhere"),
    ("polygon_layers", "always", polygon_with(b_2=0.5), "is too high"),
    ("polygon_layers", "not closed", not_closed, "from the last corner to the first"),
    ("polygon_layers", "sign of the bias", polygon_with(sign=1), "have the wrong sign"),
    ("polygon_layers", "no bias", polygon_with(sign=0), "all lines go through the origin"),
    ("polygon_layers", "along", polygon_with(normal=np.positive), "turn them left by 90 degrees"),
    ("polygon_layers", "right, any", polygon_with(normal=to_the_right, b_2=-0.5), "1 on the right of the edges"),
    ("polygon_layers", "one bias for all", shared_bias, "points have the wrong answer"),
    ("polygon_layers", "a row missing", missing_row, "weight_1 must have the shape (3, 2)"),
    ("polygon_layers", "transposed", changed(polygon, 0, np.transpose), "Row s holds the weights of neuron s"),
    ("polygon_layers", "in place", spoiling_polygon, "modified its input `corners`"),
    ("polygon_layers", "two layers as two", lambda c: polygon(c)[:2], "four arrays are needed"),
    ("polygon_layers", "returns nothing", lambda c: None, "is the `return` missing"),
    ("third_layer", "either: zero", {"either": (1, 1, 0), "hole": HOLE}, "the bias must be below 0"),
    ("third_layer", "either: both", {"either": (1, 1, -1.5), "hole": HOLE}, "that asks for both"),
    ("third_layer", "either: never", {"either": (1, 1, -3), "hole": HOLE}, "it is never 1"),
    ("third_layer", "either: a", {"either": (1, 0, -0.5), "hole": HOLE}, "that is a alone"),
    ("third_layer", "either: b", {"either": (0, 1, -0.5), "hole": HOLE}, "that is b alone"),
    ("third_layer", "hole: zero", {"either": EITHER, "hole": (1, -1, 0)}, "the bias must be below 0"),
    ("third_layer", "hole: only b off", {"either": EITHER, "hole": (0, -1, 0)}, "1 outside of both"),
    ("third_layer", "hole: filled", {"either": EITHER, "hole": (2, -1, -0.5)}, "w_b must take off"),
    ("third_layer", "hole: union", {"either": EITHER, "hole": (1, 1, -0.5)}, "that is the union"),
    ("third_layer", "hole: itself", {"either": EITHER, "hole": (1, 1, -1.5)}, "the hole alone"),
    ("third_layer", "hole: exchanged", {"either": EITHER, "hole": (-1, 1, -0.5)}, "a and b are exchanged"),
    ("third_layer", "hole: never", {"either": EITHER, "hole": (1, -1, -2)}, "it is never 1"),
    ("third_layer", "hole: always", {"either": EITHER, "hole": (1, 1, 1)}, "it is 1 everywhere"),
    ("third_layer", "hole: not b", {"either": EITHER, "hole": (0, -1, -0.5)}, "it is never 1"),
    ("third_layer", "nand", {"either": (-1, -1, 1.5), "hole": HOLE}, "for a = 0 and b = 0"),
    ("third_layer", "one of them", {"either": EITHER}, "a dict is needed"),
    ("third_layer", "a tuple", (EITHER, HOLE), "a dict is needed"),
    ("third_layer", "two numbers", {"either": (1, 1), "hole": HOLE}, "3 numbers are needed"),
    ("fewest_lines", "clouds 2", (2, 2, 3, 3), "one line does it"),
    ("fewest_lines", "clouds 0", (0, 2, 3, 3), "one neuron must stand there"),
    ("fewest_lines", "XOR 1", (1, 1, 3, 3), "no line separates these corners"),
    ("fewest_lines", "XOR 3", (1, 3, 3, 3), "with fewer above"),
    ("fewest_lines", "XOR 4", (1, 4, 3, 3), "not one for each corner"),
    ("fewest_lines", "rings 2", (1, 2, 2, 3), "open at an end"),
    ("fewest_lines", "rings 4", (1, 2, 4, 3), "which closed region"),
    ("fewest_lines", "rings 8", (1, 2, 8, 3), "fewer are enough"),
    ("fewest_lines", "moons 1", (1, 2, 3, 1), "too few parts of the plane"),
    ("fewest_lines", "moons 2", (1, 2, 3, 2), "in the hollow of the other"),
    ("fewest_lines", "moons 4", (1, 2, 3, 4), "zigzag"),
    ("fewest_lines", "one number", 3, "4 numbers are needed"),
)
RIGHT = {
    "four_points": [1, 0, 1.0, 1],
    "perceptron": answers,
    "perceptron_step": step,
    "has_a_line": "ynnyn",
    "slow_points": pair(1 / 512),
    "xor_layers": xor,
    "polygon_layers": polygon,
    "third_layer": {"either": (2, 2, -1), "hole": (1, -2, -0.5)},
    "fewest_lines": (1, 2, 3, 3),
}


@pytest.mark.parametrize("exercise", RIGHT)
def test_a_right_answer_earns_every_point(exercise):
    assert_earns_every_point(exercise, RIGHT[exercise])
    assert_earns_every_point(exercise, reference(exercise))


@pytest.mark.parametrize(
    ("exercise", "idea"),
    [
        ("xor_layers", by_subtraction),
        ("polygon_layers", unit_normals),
        ("polygon_layers", lambda corners: [one.tolist() for one in polygon(corners)]),
        ("slow_points", squeezed),
        ("slow_points", one_below_the_other),
        ("perceptron_step", lambda *a: [np.asarray(step(*a)[0]), np.float64(step(*a)[1])]),
    ],
)
def test_every_right_idea_earns_every_point(exercise, idea):
    assert_earns_every_point(exercise, idea)


@pytest.mark.parametrize(("exercise", "mistake", "answer", "words"), WRONG, ids=[f"{e}: {m}" for e, m, *_ in WRONG])
def test_a_public_test_names_the_mistake(exercise, mistake, answer, words):
    assert_mistake_is_named(exercise, mistake, answer, words)


def test_the_hidden_tests_find_points_that_change():
    calls = itertools.count()

    def never_the_same():
        x, labels = pair(1 / 512)()
        return x * (-1) ** next(calls), labels

    assert failures("slow_points", never_the_same, hidden=False) == []
    assert "fixed seed" in failures("slow_points", never_the_same, hidden=True)[-1]


def test_the_hidden_test_finds_a_network_for_one_size_of_polygon():
    def with_a_margin(corners):
        weight, bias, *rest = unit_normals(corners)
        return weight, bias + 0.005, *rest

    assert failures("polygon_layers", with_a_margin, hidden=False) == []
    assert "a small hexagon" in failures("polygon_layers", with_a_margin, hidden=True)[-1]


def test_the_references_are_those_of_the_library(rng):
    x, weight = rng.standard_normal((50, 3)), rng.standard_normal(3)
    expected = mcd.nn.Perceptron(weight, 0.25).classify(x)
    np.testing.assert_array_equal(reference("perceptron")(x, weight, 0.25), expected)
    corners = np.array([[0.0, 0.0], [2.0, 0.5], [1.0, 3.0]])
    lines = np.column_stack(reference("polygon_layers")(corners)[:2])
    network = mcd.nn.MLP((*mcd.nn.half_planes(lines), *mcd.nn.all_of([[0, 1, 2]], inputs=3)))
    ours = _network(reference("polygon_layers")(corners))
    points = rng.uniform(-1, 4, (200, 2))
    np.testing.assert_array_equal(ours.forward(points)[0], network.forward(points)[0])


# --- the predictions are what is measured


def _network(layers):
    weight_1, bias_1, weight_2, bias_2 = (np.asarray(one, float) for one in layers)
    nn = mcd.nn
    return nn.MLP((nn.Linear(weight_1, bias_1), nn.Step(), nn.Linear(weight_2, bias_2), nn.Step()))


@pytest.fixture(scope="module")
def sets():
    """The five sets of exercise 4, made by the notebook's own cells."""
    cells = parse_cells((ROOT / "notebooks" / "ch07_perceptron.py").read_bytes(), ".py")
    names = {"np": np, "mcd": mcd}
    for cell in cells:
        for name in ("two_clouds", "five_sets"):
            if (start := cell.source.find(f"def {name}(")) >= 0:
                lines = cell.source[start:].splitlines()
                end = next((k for k, one in enumerate(lines[1:], 1) if one and not one.startswith(" ")), len(lines))
                exec("\n".join(lines[:end]), names)
    return names["five_sets"]()


def has_a_line(x, labels):
    """Whether some line separates the classes: a linear program."""
    sign = np.where(labels == 1, -1.0, 1.0)[:, np.newaxis]
    rows = sign * np.column_stack([x, np.ones(len(x))])
    return linprog(np.zeros(3), A_ub=rows, b_ub=-np.ones(len(x)), bounds=(None, None)).status == 0


def test_which_sets_have_a_line_is_measured(sets):
    assert [title[0] for title in sets] == list("ABCDE")
    assert "".join("NY"[has_a_line(*one)] for one in sets.values()) == reference("has_a_line")
    for one in sets.values():
        assert mcd.nn.train_perceptron(*one, epochs=60).separated == has_a_line(*one)


def test_the_four_points_are_measured():
    line = mcd.nn.Perceptron(np.array([2.0, -1.0]), -1.0)
    assert tuple(line.classify([[1, 0], [0, 0], [1, 1], [0, -2]])) == reference("four_points")


def test_three_lines_are_enough_for_rings_and_two_are_not(rng):
    x, labels = mcd.nn.rings(300, rng=rng, noise=0.0)
    angle = 2 * np.pi * np.arange(3) / 3
    triangle = polygon(0.99 * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    np.testing.assert_array_equal(_network(triangle).forward(x)[0][:, 0], labels)
    turns = np.linspace(0, 2 * np.pi, 720)
    across = x @ np.stack([np.cos(turns), np.sin(turns)])
    cut = np.mean(across[labels == 0] > across[labels == 1].max(axis=0), axis=0)  # by a line that keeps the inner ring
    assert cut.max() < 0.5  # of the outer ring: two such lines leave some of it
    assert _holds_one_of(x[labels == 0], x[labels == 1])  # nor is the outer ring alone in any convex region


def test_three_lines_are_enough_for_moons_and_two_are_not(rng):
    x, labels = mcd.nn.two_moons(300, rng=rng, noise=0.0)
    below = mcd.nn.half_planes(
        [[1.2, -1, 1.15], [-1.2, -1, 0], [1.2, -1, -1.15]]
    )  # left, middle and right of the zigzag
    zigzag = mcd.nn.Linear(np.array([[2.0, 1.0, 1.0]]), np.array([-2.5]))  # the left one, and one of the others
    network = mcd.nn.MLP((*below, zigzag, mcd.nn.Step()))
    np.testing.assert_array_equal(network.forward(x)[0][:, 0], labels)
    moons = x[labels == 0], x[labels == 1]  # with two lines one of them would lie in a convex region without the other
    assert _holds_one_of(*moons)
    assert _holds_one_of(*moons[::-1])


def _holds_one_of(points, others):
    """Whether one of the others lies in the convex hull of the points."""
    return bool(np.any(Delaunay(points).find_simplex(others) >= 0))


# --- what the notebook says of trained networks


def share_right(x, labels, neurons, seed, optimizer, epochs):
    """Train one hidden layer of sigmoids; the share of points that it gets right."""
    start = mcd.nn.MLP.random([2, neurons, 1], gain=2.0, rng=np.random.default_rng(seed))
    target = labels[:, np.newaxis].astype(float)
    done = mcd.nn.train(start, x, target, loss=mcd.nn.CrossEntropy(), optimizer=optimizer, epochs=epochs)
    return np.mean((done.network.forward(x)[0][:, 0] >= 0) == labels)


@pytest.mark.parametrize("points", [mcd.nn.two_moons, mcd.nn.rings])
def test_training_from_three_starts_needs_three_neurons(points):
    x, labels = points(200, rng=np.random.default_rng(1))
    two, three = (
        max(share_right(x, labels, neurons, seed, mcd.nn.Adam(0.2), 150) for seed in range(3)) for neurons in (2, 3)
    )
    assert two < 0.9 < 0.99 < three


def test_two_sigmoids_can_be_enough_for_moons_but_most_starts_do_not_find_it():
    x, labels = mcd.nn.two_moons(200, rng=np.random.default_rng(1))
    found = np.array([share_right(x, labels, 2, seed, mcd.nn.RPROP(), 200) for seed in range(8)])
    assert found.max() == 1
    assert np.sum(found < 0.9) > 4
