"""The exercises of chapter 07, the perceptron: what holds for a right answer."""

import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import Finding, assert_matches, graded, name_mistake


def _short(values):
    """A few numbers as text; of many only how many are 1."""
    values = np.asarray(values, float)
    return np.round(values, 3).tolist() if values.size <= 12 else f"{int(values.sum())} of {values.size} are 1"


def _numbers(impl, count, given):
    """The answer as so many numbers."""
    listed = list(impl) if isinstance(impl, (tuple, list)) or np.ndim(impl) == 1 else []
    fine = len(listed) == count and all(np.ndim(one) == 0 and np.asarray(one).dtype.kind in "biuf" for one in listed)
    assert fine, f"{count} numbers are needed, as in {given}."
    return tuple(float(one) for one in listed)


# --- four_points


@graded("four_points", points=1)
def test_four_points_by_hand(impl):
    "The answers of the perceptron w = (2, -1), b = -1 to the four points."
    answers, points = _numbers(impl, 4, (0, 0, 0, 0)), ((1, 0), (0, 0), (1, 1), (0, -2))
    for words, mistake in (
        ("the bias is forgotten: without it the line goes through the origin", (1, 1, 1, 1)),
        ("(1, 1) lies on the line, 2 - 1 - 1 = 0, and there the answer is 1: f(0) = 1", (1, 0, 0, 1)),
        ("the second weight is -1, and -1 times -2 is 2", (1, 0, 1, 0)),
        ("all answers are the wrong way round: 1 where the sum is at least 0", (0, 1, 0, 0)),
        ("the weights are exchanged: 2 belongs to the first coordinate", (0, 0, 1, 0)),
        ("these are the sums w . x + b: the answer is the step function of them", (1, -1, 0, 1)),
    ):
        assert answers != mistake, f"{answers}: {words}."
    for point, answer, right in zip(points, answers, (1, 0, 1, 1), strict=True):
        total = 2 * point[0] - point[1] - 1
        assert answer == right, (
            f"{point} has not the answer {answer:g}: add up 2 times {point[0]}, -1 times {point[1]} and -1. "
            f"Is {total} at least 0?"
        )


# --- perceptron(x, weight, bias)


def _assert_classes(found, expected, what):
    """Whole numbers 0 and 1, one a sample."""
    assert_matches(found, expected, what)
    kind = np.asarray(found).dtype
    assert kind.kind != "b", f"{what}: True and False came back: add .astype(int), so that they are 1 and 0."
    assert kind.kind in "iu", f"{what}: 0 and 1 are right, but as {kind}: add .astype(int), they are classes."


@graded("perceptron", points=1)
def test_each_sample_of_a_batch_gets_its_answer(impl):
    "1 where weight . x + bias is at least 0, else 0, for each row of the batch."
    weight, bias = np.array([2.0, -1.0, 0.5]), -1.5
    x = np.array([[1.0, 0, 0], [0.5, 0, 0], [1, 1, 3], [0, -2, 0], [-1, -1, 1], [1, 2, 1], [0, 0, 2], [0, -1, 0.5]])
    total = np.array([0.5, -0.5, 1, 0.5, -2, -1, -0.5, -0.25])
    found, expected = impl(x, weight, bias), np.array([1, 0, 1, 1, 0, 0, 0, 0])
    mistakes = {
        "the step function is missing: these are the sums w . x + b": total,
        "these are -1 and 1 (np.sign): the answers are 0 and 1": np.sign(total),
        "the answers are the wrong way round": 1 - expected,
        "the bias is forgotten": (total - bias >= 0) * 1,
        "the bias is taken off, it is added": (total - 2 * bias >= 0) * 1,
        "that is a sigmoid: the step function has only 0 and 1": 1 / (1 + np.exp(-total)),
        "only the first weight counts": (2 * x[:, 0] + bias >= 0) * 1,
    }
    name_mistake(found, expected, mistakes, "answers to 8 samples")
    assert np.shape(found) != (8, 3), (
        "answers to 8 samples: three numbers a sample came back, one is needed: the products with the weights are to be "
        "added up, x @ weight."
    )
    _assert_classes(found, expected, "answers to 8 samples")


@graded("perceptron", points=0.5)
def test_on_the_line_the_answer_is_one(impl):
    "Where weight . x + bias is exactly 0 the answer is 1."
    x = np.array([[1.0, 1.0], [0.0, -1.0], [1.0, 1.25], [1.0, 0.75]])  # sums of powers of two: no rounding
    found, expected = impl(x, np.array([2.0, -1.0]), -1.0), np.array([1, 1, 0, 1])
    mistakes = {
        "on the line the answer is 1, so >= and not >": np.array([0, 0, 0, 1]),
        "on the line came 1/2 (np.sign or np.heaviside): f(0) = 1": np.array([0.5, 0.5, 0, 1]),
    }
    name_mistake(found, expected, mistakes, "two samples on the line, one on each side")
    _assert_classes(found, expected, "two samples on the line, one on each side")


@graded("perceptron", points=0.5, hidden=True)
def test_answers_of_any_batch(impl):
    "One input or nine, one sample, none, float32."
    rng = np.random.default_rng(8)
    for n, d in ((1, 1), (40, 2), (25, 9), (3, 3), (0, 4)):
        x, weight, bias = rng.standard_normal((n, d)), rng.standard_normal(d), float(rng.standard_normal())
        expected = [int(sum(a * b for a, b in zip(row, weight, strict=True)) > -bias) for row in x]
        _assert_classes(impl(x, weight, bias), np.array(expected, int), f"answers to {n} samples of {d} inputs")
    found = impl(np.array([[0.5], [-0.5]], np.float32), np.array([-2.0], np.float32), 0.25)
    _assert_classes(found, np.array([0, 1]), "answers to two float32 samples")


# --- perceptron_step(weight, bias, x, label, rate)


def _step(impl, weight, bias, x, label, rate):
    """What one step returned: weights and bias, in one array."""
    found = impl(np.array(weight, float), bias, np.array(x, float), label, rate)
    if found is None:
        raise Finding("nothing came back (None): is the `return` missing?")
    if not isinstance(found, (tuple, list)) or len(found) != 2:
        raise Finding("two results are needed, the new weight and the new bias; something else came back.")
    if np.shape(found[1]) != ():
        raise Finding(f"the bias is one number; shape {np.shape(found[1])} came back.")
    assert_matches(np.shape(found[0]), np.shape(weight), "the shape of the new weight")
    return np.append(np.asarray(found[0], float), float(found[1]))


def _of_wrong(weight, bias, x, label, rate):
    """What the usual mistakes give where the answer was wrong: (weight, bias) in one array."""
    weight, x = np.array(weight, float), np.array(x, float)
    old, total = np.append(weight, bias), float(weight @ x) + bias
    error, one = (1 if label else -1), np.append(x, 1.0)
    return {
        "nothing has changed, but the answer was wrong": old,
        "it moves the wrong way: label - answer, not answer - label": old - rate * error * one,
        "the rate is missing": old + error * one,
        "the rate is missing for the bias": np.append(weight + rate * error * x, bias + error),
        "the bias does not change": np.append(weight + rate * error * x, bias),
        "the bias moves the wrong way": np.append(weight + rate * error * x, bias - rate * error),
        "the weight does not change": np.append(weight, bias + rate * error),
        "the sample is missing in the correction of the weight": old + rate * error,
        "a step twice as long: are the answers -1 and 1? They are 0 and 1": old + 2 * rate * error * one,
        "the sum w . x + b stands where its answer belongs, 0 or 1": old + rate * (label - total) * one,
        "these are the corrections alone: add them to what was given": rate * error * one,
    }


@graded("perceptron_step", points=1)
def test_a_wrong_answer_moves_the_line(impl):
    "After a wrong answer w changes by rate (label - answer) x, and b by rate (label - answer)."
    for case, what in (
        (((0.5, -1.0), 0.25, (2.0, 1.0), 0, 0.25), "label 0, answered with 1"),
        (((1.0, -1.0), -0.5, (0.25, 0.5), 1, 0.25), "label 1, answered with 0"),
    ):
        found = _step(impl, *case)
        weight, bias, x, label, rate = case
        sign = 1 if label == 1 else -1
        expected = np.array([*(w + sign * rate * t for w, t in zip(weight, x, strict=True)), bias + sign * rate])
        mistakes = _of_wrong(*case)
        if label == 0:
            mistakes["nothing has changed, but the answer was wrong: label alone is 0, label - answer is -1"] = (
                mistakes.pop("nothing has changed, but the answer was wrong")
            )
        name_mistake(found, expected, mistakes, f"{what}: weight and bias")
        assert_matches(found, expected, f"{what}: weight and bias")


@graded("perceptron_step", points=0.5)
def test_a_right_answer_changes_nothing(impl):
    "After a right answer weight and bias are what they were."
    for weight, bias, x, label, what in (
        ((1.0, 0.5), -0.5, (1.0, 1.0), 1, "label 1, answered with 1"),
        ((1.0, 0.5), -2.0, (1.0, 1.0), 0, "label 0, answered with 0 (without the bias it would be 1)"),
    ):
        found = _step(impl, weight, bias, x, label, 0.5)
        assert np.allclose(found, [*weight, bias]), (
            f"{what}: the answer is right, so nothing may change; yours went from {[*weight, bias]} to {_short(found)}."
        )


@graded("perceptron_step", points=0.5)
def test_on_the_line_the_step_takes_the_answer_for_one(impl):
    "On the line the answer is 1: right for the label 1, wrong for the label 0. So the first step from 0 moves."
    found = _step(impl, (0.0, 0.0), 0.0, (2.0, 1.0), 0, 1.0)
    assert not np.allclose(found, 0), (
        "from weight 0 and bias 0, label 0: nothing has changed. The sum is 0, so the answer is 1 (>= 0), and wrong."
    )
    assert_matches(found, np.array([-2.0, -1.0, -1.0]), "from weight 0 and bias 0, label 0: weight and bias")
    found = _step(impl, (0.0, 0.0), 0.0, (2.0, 1.0), 1, 1.0)
    assert np.allclose(found, 0), (
        f"from weight 0 and bias 0, label 1: yours changed to {_short(found)}. The sum is 0, so the answer is 1, and right."
    )


@graded("perceptron_step", points=1, hidden=True)
def test_many_steps_in_any_dimension(impl):
    "Fifty steps one after the other, with one input or five, and other rates."
    rng = np.random.default_rng(4)
    for d, rate in ((1, 1.0), (5, 0.125), (3, 3.0)):
        weight, bias = rng.standard_normal(d), 0.5
        for number in range(50):
            x, label = rng.standard_normal(d), int(rng.integers(2))
            found = _step(impl, weight, bias, x, label, rate)
            answer = sum(a * b for a, b in zip(weight, x, strict=True)) > -bias
            if answer != label:
                sign = -1 if answer else 1
                weight, bias = (
                    np.array([a + sign * rate * b for a, b in zip(weight, x, strict=True)]),
                    bias + sign * rate,
                )
            assert_matches(found, np.append(weight, bias), f"step {number + 1} with {d} inputs: weight and bias")


# --- has_a_line


@graded("has_a_line", points=1)
def test_which_sets_have_a_line(impl):
    "For each of the five sets: is there a line that separates its classes?"
    letters = [str(one).strip().upper() for one in impl] if isinstance(impl, (tuple, list, str)) else []
    assert len(letters) == 5, "5 letters are needed, as in 'YYYYY'."
    hints = (
        ("Y", "the gap is narrow and slanted, but a line fits into it. The bias lets it pass beside the origin."),
        ("N", "put a ruler between the moons: the end of each lies in the hollow of the other."),
        ("N", "any line that has the inner ring on one side has a part of the outer one on that side too."),
        ("Y", "x_1^2 + x_2^2 is the squared radius: small inside, large outside, and a weighted sum of these inputs."),
        ("N", "class 0 lies on both sides of the strip: that takes two lines."),
    )
    for name, letter, (right, hint) in zip("ABCDE", letters, hints, strict=True):
        assert letter == right, f"{name} is not {letter}: {hint}"


# --- slow_points() -> x, labels

LOOKS, LEAST = 20_000, 1000


def _points(impl):
    x, labels = (np.atleast_1d(np.asarray(one, float)) for one in impl())
    assert x.shape == (len(x), 2), f"x must be an array (n, 2), a row each; its shape is {x.shape}."
    assert 2 <= len(x) <= 20, f"2 to 20 points are asked for, got {len(x)}."
    assert labels.shape == (len(x),), f"labels must have the shape ({len(x)},), one a point; it is {labels.shape}."
    assert np.all(np.abs(x) <= 1), "the coordinates must lie from -1 to 1."
    assert np.isin(labels, (0, 1)).all(), f"labels are 0 or 1, got {np.unique(labels).tolist()}."
    assert len(np.unique(labels)) == 2, "all points have one class: there is nothing to separate."
    for k in range(len(x)):
        same = np.all(x == x[k], axis=1)
        assert np.ptp(labels[same]) == 0, f"the point {x[k].tolist()} stands in both classes: no line separates them."
    return x, labels


def _assert_slow(x, labels, what):
    done = mcd.nn.train_perceptron(x, labels, epochs=LOOKS // len(x))
    counted = int(done.mistakes.sum())
    assert done.separated, (
        f"{what}: after {LOOKS} looks at a sample ({counted} corrections) it is not done. Either there is no line, or the gap "
        f"is too narrow."
    )
    assert counted >= LEAST, (
        f"{what}: separated after {counted} corrections, {LEAST} are asked for. The bound is (R / gamma)^2: make the gap "
        f"narrower, with the points far from the origin."
    )


@graded("slow_points", points=1)
def test_the_rule_needs_many_corrections(impl):
    "A line separates the points, but Rosenblatt's rule makes at least 1000 corrections before it finds one."
    x, labels = _points(impl)
    _assert_slow(x, labels, "in your order")


@graded("slow_points", points=0.5, hidden=True)
def test_it_is_slow_in_the_reverse_order_too(impl):
    "It takes as long in the reverse order, and the points are the same at every call."
    x, labels = _points(impl)
    again = _points(impl)
    assert all(map(np.array_equal, (x, labels), again)), (
        "two calls gave different points: use a fixed seed, np.random.default_rng(0)."
    )
    _assert_slow(x[::-1], labels[::-1], "in the reverse order")


# --- xor_layers() and polygon_layers(corners) -> weight_1, bias_1, weight_2, bias_2

NAMES = ("weight_1", "bias_1", "weight_2", "bias_2")


def _layers(impl, m, *arguments):
    """Four arrays of the shapes that a network of m hidden neurons has."""
    found = impl(*arguments)
    if found is None:
        raise Finding("nothing came back (None): is the `return` missing?")
    if not isinstance(found, (tuple, list)) or len(found) != 4:
        raise Finding(f"four arrays are needed, {', '.join(NAMES)}, in this order; something else came back.")
    for name, one, shape in zip(NAMES, found, ((m, 2), (m,), (1, m), (1,)), strict=True):
        hint = " Row s holds the weights of neuron s." if np.shape(one) == shape[::-1] and len(shape) == 2 else ""
        if np.shape(one) != shape:
            raise Finding(f"{name} must have the shape {shape}, a row for each neuron; yours is {np.shape(one)}.{hint}")
        if np.asarray(one).dtype.kind not in "iuf" or not np.isfinite(np.asarray(one, float)).all():
            raise Finding(f"{name} must hold finite numbers.")
    return [np.asarray(one, float) for one in found]


def _step_of(total):
    return np.where(total >= 0, 1.0, 0.0)


def _outputs(layers, x):
    """The network's answers: two layers of step functions."""
    weight_1, bias_1, weight_2, bias_2 = layers
    return _step_of(_step_of(np.einsum("it,st->is", x, weight_1) + bias_1) @ weight_2[0] + bias_2[0])


SQUARE = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
EXCLUSIVE = np.array([0.0, 1.0, 1.0, 0.0])


@graded("xor_layers", points=1)
def test_xor_of_the_four_corners(impl):
    "The answers to (0, 0), (0, 1), (1, 0) and (1, 1) are 0, 1, 1 and 0."
    layers = _layers(impl, 2)
    found, what = _outputs(layers, SQUARE), "answers to (0, 0), (0, 1), (1, 0), (1, 1)"
    mistakes = {
        "that is OR: take off the points where both inputs are 1": [0, 1, 1, 1],
        "that is AND: only where both inputs are 1": [0, 0, 0, 1],
        "that is NAND: what tells (0, 0) from the others is missing": [1, 1, 1, 0],
        "that is XOR the wrong way round": [1, 0, 0, 1],
        "that is the first input": [0, 0, 1, 1],
        "that is the second input": [0, 1, 0, 1],
        "always 0: is the bias of the last layer too low?": [0, 0, 0, 0],
        "always 1: is the bias of the last layer too high? A step is 1 at 0": [1, 1, 1, 1],
    }
    turned = _outputs((layers[0].T, *layers[1:]), SQUARE)
    if np.array_equal(turned, EXCLUSIVE):
        assert np.array_equal(found, EXCLUSIVE), (
            f"{what}: yours {found.astype(int).tolist()}. With weight_1 transposed it would be right: row s holds the weights "
            f"of neuron s."
        )
    name_mistake(found, EXCLUSIVE, {words: np.array(value, float) for words, value in mistakes.items()}, what)
    wrong = int(np.argmax(found != EXCLUSIVE))
    assert np.array_equal(found, EXCLUSIVE), (
        f"{what}: yours {found.astype(int).tolist()}. For {SQUARE[wrong].astype(int).tolist()} the hidden layer gives "
        f"{_step_of(layers[0] @ SQUARE[wrong] + layers[1]).astype(int).tolist()}: what does the second layer make of it?"
    )


def _assert_xor_near(layers, x, labels):
    for point, label, answer in zip(x, labels, _outputs(layers, x), strict=True):
        assert answer == label, (
            f"for the inputs {np.round(point, 2).tolist()} it answers {answer:g}, expected {label:g}. A line must not pass "
            f"through a corner, nor within 0.2 of one: move the biases of the hidden neurons to the middle of the gaps."
        )


@graded("xor_layers", points=0.5)
def test_xor_of_inputs_that_are_not_exact(impl):
    "Inputs up to 0.2 from 0 and from 1 have the same answers."
    offsets = 0.2 * (2 * SQUARE - 1)
    x = (SQUARE[:, np.newaxis] + offsets).reshape(-1, 2)
    _assert_xor_near(_layers(impl, 2), x, np.repeat(EXCLUSIVE, 4))


@graded("xor_layers", points=0.5, hidden=True)
def test_xor_of_many_inputs(impl):
    "It holds for any inputs near the corners."
    which = np.random.default_rng(6).integers(0, 4, 300)
    x = SQUARE[which] + np.random.default_rng(7).uniform(-0.2, 0.2, (300, 2))
    _assert_xor_near(_layers(impl, 2), x, EXCLUSIVE[which])


def _sides(corners, x):
    """For each point and each edge: above 0 to the left of it, (n, m)."""
    ends = [*corners[1:], corners[0]]
    return np.array(
        [
            [(b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) for a, b in zip(corners, ends, strict=True)]
            for p in x
        ]
    )


def _probes(corners):
    """Points in and around a polygon, none of them on the line of an edge; and their sides."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, reach = (low + high) / 2, 1.1 * (high - low).max()
    x = np.stack(np.meshgrid(*2 * [np.linspace(-1, 1, 13)]), axis=-1).reshape(-1, 2) * reach + middle
    sides = _sides(corners, x)
    clear = np.abs(sides).min(axis=1) > 1e-3 * reach**2
    return x[clear], sides[clear]


def _wrong_half_planes(corners, x, sides):
    """What the usual mistakes make of the hidden neurons, (n, m)."""
    along = np.array([*corners[1:], corners[0]]) - corners
    offset = np.einsum("ij,ij->i", np.stack([-along[:, 1], along[:, 0]], axis=1), corners)  # normal . corner
    return {
        "the hidden neurons are 1 on the right of the edges; counter-clockwise, inside is on their left": sides < 0,
        "the biases of the hidden neurons have the wrong sign: normal . corner + bias is 0": sides + 2 * offset >= 0,
        "the hidden neurons have no biases: all lines go through the origin": sides + offset >= 0,
        "the weights point along the edges: turn them left by 90 degrees": (
            np.einsum("ij,kj->ik", x, along) >= np.einsum("ij,ij->i", along, corners)
        ),
    }


def _wrong_counts(left):
    """What the usual mistakes make of right half planes."""
    count, m = left.sum(axis=1), left.shape[1]
    return {
        "1 outside and 0 inside": count < m,
        "1 everywhere: every point lies in some of the half planes, but all of them are needed. The bias of the second layer "
        "is too high, it depends on m": count > 0,
        "one edge may be missed: the bias of the second layer is too high, count to m": count >= m - 1,
        "the edge from the last corner to the first is missing": left[:, :-1].all(axis=1),
        "0 everywhere: the bias of the second layer is too low": np.zeros(len(left), bool),
    }


def _columns(values):
    return sorted(map(tuple, np.asarray(values, float).T.tolist()))


def _assert_polygon(impl, corners, what):
    x, sides = _probes(corners)
    layers, inside = _layers(impl, len(corners), corners), np.all(sides > 0, axis=1)
    found, hidden = _outputs(layers, x), _step_of(np.einsum("it,st->is", x, layers[0]) + layers[1])
    wrong = np.flatnonzero(found != inside)
    if not len(wrong):
        return
    for words, value in _wrong_half_planes(corners, x, sides).items():
        assert _columns(hidden) != _columns(value), f"{what}: {words}."
    for words, value in _wrong_counts(sides > 0).items():
        assert not np.array_equal(found, value), f"{what}: {words}."
    first = wrong[0]
    raise Finding(
        f"{what}: {len(wrong)} of {len(x)} points have the wrong answer, the first is {np.round(x[first], 3).tolist()}: it "
        f"lies {'inside' if inside[first] else 'outside'}, on the left of {int((sides[first] > 0).sum())} edges, and "
        f"{int(hidden[first].sum())} hidden neurons are 1."
    )


def _polygon(m, radius, centre, turn=0.3):
    angle = 2 * np.pi * np.arange(m) / m + turn
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1) + centre


@graded("polygon_layers", points=1.5)
def test_a_triangle(impl):
    "1 inside the triangle (1, 1), (4, 2), (2, 5), 0 outside."
    _assert_polygon(impl, np.array([[1.0, 1.0], [4.0, 2.0], [2.0, 5.0]]), "triangle (1, 1), (4, 2), (2, 5)")


@graded("polygon_layers", points=0.5)
def test_more_corners(impl):
    "A pentagon and a square elsewhere: one hidden neuron for each edge."
    _assert_polygon(impl, _polygon(5, 1.0, [0.5, -0.5]), "a pentagon")
    _assert_polygon(impl, np.array([[-2.0, 0.0], [-1.0, 0.0], [-1.0, 1.0], [-2.0, 1.0]]), "a square")


@graded("polygon_layers", points=1, hidden=True)
def test_any_convex_polygon(impl):
    "Small and large, far away, thin, with many corners, beginning at any of them."
    for corners, what in (
        (_polygon(6, 0.01, [0.02, 0.01]), "a small hexagon"),
        (_polygon(3, 200.0, [-500.0, 300.0], turn=2.0), "a large triangle, far away"),
        (_polygon(12, 1.0, [0.0, 0.0], turn=1.0), "a polygon of twelve corners"),
        (_polygon(7, 1.0, [0.0, 0.0]) * [3.0, 0.5] + 1, "a flat polygon of seven corners"),
        (np.roll(_polygon(4, 1.0, [0.0, 3.0]), 2, axis=0), "a square that begins elsewhere"),
    ):
        _assert_polygon(impl, corners, what)


# --- third_layer

PAIRS = ((0, 0), (0, 1), (1, 0), (1, 1))


def _third(impl, name):
    """The answers of one perceptron of the third layer to the four pairs (a, b)."""
    if not isinstance(impl, dict) or name not in impl:
        raise Finding('a dict is needed: {"either": (w_a, w_b, bias), "hole": (w_a, w_b, bias)}.')
    w_a, w_b, bias = _numbers(impl[name], 3, (0, 0, 0))
    return tuple(int(w_a * a + w_b * b + bias >= 0) for a, b in PAIRS)


def _name_third(found, right, mistakes, what):
    for words, mistake in mistakes.items():
        assert found != mistake, f"{what}: {words}."
    for (a, b), answer, expected in zip(PAIRS, found, right, strict=True):
        assert answer == expected, f"{what}: for a = {a} and b = {b} it answers {answer}, expected {expected}."


@graded("third_layer", points=0.5)
def test_either_of_two_polygons(impl):
    '"either" is 1 where at least one of a and b is 1.'
    mistakes = {
        "it is 1 even where both are 0: at 0 the step is 1, so the bias must be below 0": (1, 1, 1, 1),
        "that asks for both: the bias is too low": (0, 0, 0, 1),
        "it is never 1: the bias is too low": (0, 0, 0, 0),
        "that is a alone": (0, 0, 1, 1),
        "that is b alone": (0, 1, 0, 1),
    }
    _name_third(_third(impl, "either"), (0, 1, 1, 1), mistakes, '"either"')


@graded("third_layer", points=1)
def test_a_polygon_with_a_hole(impl):
    '"hole" is 1 where a is 1 and b is 0.'
    mistakes = {
        "it is 1 even where both are 0: at 0 the step is 1, so the bias must be below 0": (1, 0, 1, 1),
        "it is 1 outside of both: at 0 the step is 1, so the bias must be below 0": (1, 0, 1, 0),
        "it is 1 in the hole as well: w_b must take off what w_a gives": (0, 0, 1, 1),
        "it is 1 in the hole as well: that is the union": (0, 1, 1, 1),
        "that is the hole alone: both are 1 there": (0, 0, 0, 1),
        "a and b are exchanged: A is the outer one": (0, 1, 0, 0),
        "it is never 1: the bias is too low": (0, 0, 0, 0),
        "it is 1 everywhere: the bias is too high": (1, 1, 1, 1),
    }
    _name_third(_third(impl, "hole"), (0, 0, 1, 0), mistakes, '"hole"')


# --- fewest_lines


@graded("fewest_lines", points=1)
def test_how_few_lines(impl):
    "The least number of hidden step functions for the clouds, the corners of XOR, the rings and the moons."
    answers = _numbers(impl, 4, (1, 1, 1, 1))
    names = ("two clouds", "the corners of XOR", "rings", "two moons")
    known = {
        ("two clouds", 2): "one line does it, and a hidden layer of one neuron can hold it",
        ("two clouds", 0): "the output sees only what the hidden layer gives: one neuron must stand there",
        (
            "the corners of XOR",
            1,
        ): "with one hidden neuron the plane has two parts, and no line separates these corners",
        ("the corners of XOR", 4): "not one for each corner: a strip between two parallel lines is enough",
        ("the corners of XOR", 3): "you wrote a network with fewer above",
        ("rings", 2): "two lines make a strip or a wedge, open at an end, where the outer ring gets in",
        ("rings", 4): "a square does it, but which closed region has the fewest sides?",
        (
            "two moons",
            2,
        ): "with two lines one of the classes lies in a half plane, a strip or a wedge, all without a dent. "
        "But the end of each moon lies in the hollow of the other",
        ("two moons", 4): "there is a zigzag with fewer pieces",
        ("two moons", 5): "there is a zigzag with fewer pieces",
    }
    for name, answer, right in zip(names, answers, (1, 2, 3, 3), strict=True):
        hint = known.get((name, answer), "too few parts of the plane" if answer < right else "fewer are enough")
        assert answer == right, f"{name}: not {answer:g}: {hint}."
