"""The scalar graph: closed forms, differences, the order of the walk, depth, and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdenoise.nn.scalar import Scalar, backward, exp, log, relu, sigmoid, softplus, tanh, walk

pytestmark = pytest.mark.ch08

FUNCTIONS = {
    "exp": (exp, math.exp),
    "log": (log, math.log),
    "tanh": (tanh, math.tanh),
    "sigmoid": (sigmoid, lambda x: 1 / (1 + math.exp(-x))),
    "relu": (relu, lambda x: max(x, 0.0)),
    "softplus": (softplus, lambda x: math.log1p(math.exp(x))),
    "power": (lambda x: x**3, lambda x: x**3),
    "root": (lambda x: x**0.5, math.sqrt),
    "inverse": (lambda x: 2 / x, lambda x: 2 / x),
    "minus": (lambda x: 1 - x, lambda x: 1 - x),
    "negative": (lambda x: -x - 2, lambda x: -x - 2),
    "quotient": (lambda x: x / (x * x + 1), lambda x: x / (x * x + 1)),
}


def test_the_example_of_the_lecture():
    x, y, z = Scalar(-2, "x"), Scalar(5, "y"), Scalar(-4, "z")
    q = x + y
    f = q * z
    gradients = backward(f)
    assert (q.value, f.value) == (3, -12)
    assert [gradients[one] for one in (f, q, z, x, y)] == [1, -4, 3, -4, -4]


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("at", [0.3, 1.7])
def test_values_and_derivatives(name, at):
    graph, plain = FUNCTIONS[name]
    x = Scalar(at)
    y = graph(x)
    h = 1e-5
    assert y.value == pytest.approx(plain(at), rel=1e-12)
    assert backward(y)[x] == pytest.approx((plain(at + h) - plain(at - h)) / (2 * h), rel=1e-8)


@pytest.mark.parametrize("function", [tanh, sigmoid, relu, softplus, exp])
@pytest.mark.parametrize("at", [-1e4, -800.0, -0.5])
def test_far_below_zero_nothing_overflows(function, at):
    x = Scalar(at)
    y = function(x)
    assert math.isfinite(y.value)
    assert math.isfinite(backward(y)[x])


@pytest.mark.parametrize(
    ("function", "value", "slope"), [(tanh, 1, 0), (sigmoid, 1, 0), (relu, 1e4, 1), (softplus, 1e4, 1)]
)
def test_far_above_zero_they_are_flat_or_straight(function, value, slope):
    x = Scalar(1e4)
    y = function(x)
    assert (y.value, backward(y)[x]) == (value, slope)


def test_a_value_used_twice_gets_the_sum_of_its_gradients():
    x = Scalar(3.0)
    assert backward(x * x)[x] == 6
    assert backward(x + x + x)[x] == 3
    shared = x * 2
    assert backward(shared * shared + shared)[x] == 2 * (2 * 6) + 2


def test_calling_backward_twice_doubles_nothing():
    x = Scalar(0.7)
    f = tanh(x * x + 2 * x)
    assert backward(f) == backward(f)


def test_two_outputs_of_one_graph_do_not_disturb_each_other():
    x = Scalar(2.0)
    shared = x * 3
    one, other = shared * 5, shared + 1
    assert (backward(one)[x], backward(other)[x], backward(one)[x]) == (15, 3, 15)


def test_a_chain_of_a_hundred_thousand_operations():
    x = Scalar(1.0, "x")
    y = x
    for _ in range(100_000):
        y = y + 1e-5
    gradients = backward(y)
    assert gradients[x] == 1
    assert y.value == pytest.approx(2)
    assert repr(y) == "Scalar(2)"
    del y, gradients  # taking the chain apart is no recursion either


def test_the_walk_meets_each_scalar_once_and_before_its_parents():
    rng = np.random.default_rng(0)
    nodes = [Scalar(value) for value in rng.random(5)]
    for _ in range(60):
        a, b = rng.integers(0, len(nodes), 2)
        nodes.append(nodes[a] + nodes[b] if rng.random() < 0.5 else nodes[a] * nodes[b] * 0.1)
    order = walk(nodes[-1])
    place = {node: k for k, node in enumerate(order)}
    assert order[0] is nodes[-1]
    assert len(place) == len(order)
    assert all(place[node] < place[parent] for node in order for parent in node.parents)


@given(st.lists(st.floats(-2, 2), min_size=3, max_size=3))
def test_a_mixed_expression_agrees_with_differences(at):
    def graph(x, y, z):
        return tanh(x * y) * exp(z) + softplus(x - z) / (1 + sigmoid(y)) + (x * x + 1) ** 1.5

    inputs = [Scalar(value) for value in at]
    gradients = backward(graph(*inputs))
    for k, one in enumerate(inputs):
        ends = []
        for step in (1e-5, -1e-5):
            moved = [Scalar(value + step * (j == k)) for j, value in enumerate(at)]
            ends.append(graph(*moved).value)
        assert gradients[one] == pytest.approx((ends[0] - ends[1]) / 2e-5, rel=1e-6, abs=1e-8)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: log(Scalar(0)), "log needs a number above 0, got 0"),
        (lambda: exp(Scalar(1e4)), "exp.10000. needs a finite value"),
        (lambda: Scalar(-2) ** 0.5, r"-2 \*\* 0.5 is not defined"),
        (lambda: Scalar(0) ** 0.5, r"0 \*\* 0.5 is not defined, or its derivative is not"),
        (lambda: 1 / Scalar(0), r"0 \*\* -1 is not defined"),
        (lambda: Scalar(2) ** Scalar(3), "the power must be a plain number"),
        (lambda: Scalar(math.nan), "A scalar needs a finite value"),
        (lambda: Scalar(1e200) * Scalar(1e200), r"\*.1e\+200, 1e\+200. needs a finite value"),
    ],
)
def test_what_is_not_defined_is_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_a_gradient_beyond_float64_is_refused():
    x = Scalar(1e-200, "x")
    y = x * 1e200 * 1e200  # a value of 1e200, but a gradient of 1e400
    with pytest.raises(ValueError, match=r"1 gradients leave float64, the first at Scalar.1e-200, 'x'."):
        backward(y)


def test_to_the_power_of_zero_is_one_everywhere():
    x = Scalar(0)
    assert ((x**0).value, backward(x**0)[x]) == (1, 0)
