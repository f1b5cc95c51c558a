"""The gradient check: what it finds, what it calls it, and what it lets pass."""

import re

import numpy as np
import pytest

from mcdenoise.nn import GradientError, Linear, Pair, ReLU, Softplus, Step, check_gradient
from mcdenoise.nn.gradcheck import ENTRIES

pytestmark = pytest.mark.ch08


def inputs(rng, n=4, d_in=3, d_out=3):
    return {"x": rng.normal(size=(n, d_in)), "weight": rng.normal(size=(d_out, d_in)), "bias": rng.normal(size=d_out)}


def linear(x, weight, bias):
    return x @ weight.T + bias, (x, weight)


def backward_with(**wrong):
    """The backward pass of `linear`, right but for the gradients that are given as functions of (d_y, x, weight)."""
    right = {
        "x": lambda d_y, x, weight: d_y @ weight,
        "weight": lambda d_y, x, weight: d_y.T @ x,
        "bias": lambda d_y, x, weight: d_y.sum(axis=0),
    }
    return lambda d_y, saved: {name: one(d_y, *saved) for name, one in (right | wrong).items()}


MISTAKES = {
    "transposed weight": ({"x": lambda d_y, x, w: d_y @ w.T}, "gradient of x.*multiplied by the transposed matrix"),
    "transposed gradient": (
        {"weight": lambda d_y, x, w: x.T @ d_y},
        "gradient of weight.*rows and columns are exchanged",
    ),
    "no sum over the batch": (
        {"bias": lambda d_y, x, w: d_y},
        r"received shape \(4, 3\). The sum over",
    ),
    "mean over the batch": (
        {"bias": lambda d_y, x, w: d_y.mean(axis=0)},
        "1/4 of what.*a mean in place of their sum",
    ),
    "batch size too often": ({"weight": lambda d_y, x, w: len(x) * d_y.T @ x}, "4 times what is expected"),
    "one row alone": ({"bias": lambda d_y, x, w: d_y[2]}, "Only row 2 of the batch counts"),
    "factor of 2": ({"weight": lambda d_y, x, w: 2 * d_y.T @ x}, "Twice what is expected"),
    "half": ({"x": lambda d_y, x, w: d_y @ w / 2}, "Half of what is expected"),
    "another factor": ({"x": lambda d_y, x, w: 3.5 * d_y @ w}, "A constant factor of 3.5"),
    "sign": ({"bias": lambda d_y, x, w: -d_y.sum(axis=0)}, "gradient of bias.*The sign is flipped"),
    "nothing": ({"weight": lambda d_y, x, w: np.zeros_like(w)}, "All zero: does d_y arrive"),
    "no matrix": ({"x": lambda d_y, x, w: d_y}, "It is d_y itself: the local gradient is missing"),
    "no d_y": ({"bias": lambda d_y, x, w: np.full(3, 4.0)}, "It does not depend on d_y"),
    "NaN": ({"bias": lambda d_y, x, w: np.array([0, np.nan, 0])}, r"NaN or infinity, first at \[1\]"),
    "missing": ({"bias": lambda d_y, x, w: None}, "there is no gradient of bias"),
    "summed too often": ({"weight": lambda d_y, x, w: (d_y.T @ x).sum(axis=0)}, "summed too often"),
    "another shape": (
        {"x": lambda d_y, x, w: (d_y @ w)[:2]},
        r"received shape \(2, 3\). A gradient has the shape of its input",
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_usual_mistakes_have_a_name(name, rng):
    wrong, words = MISTAKES[name]
    with pytest.raises(GradientError, match=words):
        check_gradient(Pair(linear, backward_with(**wrong), "my linear"), inputs(rng))


def test_the_message_names_function_input_place_and_numbers(rng):
    pair = Pair(linear, backward_with(x=lambda d_y, x, w: -d_y @ w), "my linear")
    with pytest.raises(GradientError) as caught:
        check_gradient(pair, inputs(rng))
    text = str(caught.value)
    assert text.startswith("my linear: gradient of x, shape (4, 3): relative error 2; worst at [")
    received, expected = re.search(r"received (\S+), expected (\S+)\. ", text).groups()
    assert float(received) == -float(expected) != 0


def test_a_transposed_matrix_that_does_not_fit_is_said_with_shapes(rng):
    pair = Pair(linear, backward_with(x=lambda d_y, x, w: d_y @ w.T), "my linear")
    with pytest.raises(
        GradientError, match=r"backward failed with x \(4, 3\), weight \(2, 3\), bias \(2,\), d_y \(4, 2\): .*matmul"
    ):
        check_gradient(pair, inputs(rng, d_out=2))


def test_what_is_right_passes(rng):
    assert check_gradient((linear, backward_with()), inputs(rng)) < 1e-8
    assert check_gradient((linear, lambda d_y, saved: tuple(backward_with()(d_y, saved).values())), inputs(rng)) < 1e-8


def test_one_wrong_entry_is_enough(rng):
    def wrong(d_y, x, w):
        d_x = d_y @ w
        d_x[3, 1] *= 1.001
        return d_x

    with pytest.raises(GradientError, match=r"worst at \[3, 1\]"):
        check_gradient((linear, backward_with(x=wrong)), inputs(rng))


def test_a_gradient_that_is_not_linear_in_d_y_is_found(rng):
    """Right for d_y of about this size alone: the units of the full Jacobian find it."""
    scale = []

    def wrong(d_y, x, w):
        scale.append(np.linalg.norm(d_y))
        return d_y @ w * (np.linalg.norm(d_y) / scale[0])

    with pytest.raises(GradientError, match=r"gradient of x.*for output \[0, 0\] alone"):
        check_gradient((linear, backward_with(x=wrong)), inputs(rng))


@pytest.mark.parametrize("wrong", [False, True])
def test_large_inputs_are_checked_along_projections(wrong, rng):
    given = inputs(rng, n=200, d_in=30, d_out=20)
    assert given["weight"].size > ENTRIES
    backward = backward_with(**({"weight": lambda d_y, x, w: 2 * d_y.T @ x} if wrong else {}))
    if wrong:
        with pytest.raises(GradientError, match=r"gradient of weight, shape \(20, 30\): .*Twice what is expected"):
            check_gradient((linear, backward), given)
    else:
        assert check_gradient((linear, backward), given) < 1e-6


def test_overwriting_is_found(rng):
    def forward(x):
        y = np.tanh(x)
        return y, y

    def in_place(d_y, y):
        y *= y
        return {"x": d_y * (1 - y)}

    with pytest.raises(
        GradientError, match=r"a second call of backward gives another one. It overwrites what forward saved"
    ):
        check_gradient((forward, in_place), {"x": rng.normal(size=5)})

    def forward_in_place(x):
        x *= 2
        return x.copy(), None

    with pytest.raises(GradientError, match="forward overwrites its input x"):
        check_gradient((forward_in_place, lambda d_y, saved: {"x": 2 * d_y}), {"x": rng.normal(size=5)})

    def backward_in_place(d_y, x):
        x *= 2
        return {"x": d_y * x}

    with pytest.raises(GradientError, match="backward overwrites its input x"):
        check_gradient((lambda x: (x**2, x), backward_in_place), {"x": rng.normal(size=5)})


def test_a_kink_is_called_a_kink():
    with pytest.raises(GradientError, match=r"kink there: its slope is 0 before and .* behind. Check at other inputs"):
        check_gradient(ReLU(), {"x": np.array([[0.0, 1.0]])})
    assert check_gradient(ReLU(), {"x": np.array([[0.1, 1.0]])}) < 1e-6


def test_the_bottom_of_a_bowl_is_no_kink():
    """There the slope changes its sign, but smoothly: a wrong gradient must not be excused."""
    pair = Pair(lambda x: (np.sum(x**2), x), lambda d_y, x: {"x": d_y * 2 * x + np.array([1.0, 0.0])})
    with pytest.raises(GradientError, match=r"worst at \[0\]: received 1, expected 0") as caught:
        check_gradient(pair, {"x": [0.0, 3.0]})
    assert "kink" not in str(caught.value)


def test_numbers_as_outputs_and_inputs():
    assert (
        check_gradient((lambda a, b: (a * b, (a, b)), lambda d, s: (d * s[1], d * s[0])), {"a": 2.0, "b": -3.0}) < 1e-8
    )


def test_fixed_inputs_have_no_gradient(rng):
    def forward(x, scale):
        return scale * x, scale

    assert (
        check_gradient(
            (forward, lambda d_y, scale: {"x": scale * d_y}), {"x": rng.normal(size=3)}, fixed={"scale": 2.0}
        )
        < 1e-8
    )


def test_parameters_of_layers_are_checked_too(rng):
    class Wrong(Linear):
        def backward(self, d_y, saved):
            d_x, gradients = super().backward(d_y, saved)
            return d_x, {**gradients, "bias": 2 * gradients["bias"]}

    with pytest.raises(GradientError, match=r"Wrong: gradient of bias.*Twice"):
        check_gradient(Wrong(rng.normal(size=(2, 3)), np.zeros(2)), {"x": rng.normal(size=(5, 3))})


def test_saturation_is_no_fault():
    """Both are 0 there; rounding must not look like an error."""
    assert check_gradient(Softplus(), {"x": np.array([[-800.0, 800.0, -40.0]])}) < 1e-6


def test_steepness_does_not_make_it_fail(rng):
    """A loss of a million with gradients of a million: rounding grows with both."""
    pair = Pair(lambda x: (1e6 * np.sum(np.sin(x)), x), lambda d_y, x: {"x": 1e6 * d_y * np.cos(x)})
    assert check_gradient(pair, {"x": rng.normal(size=9)}) < 1e-6


@pytest.mark.parametrize(
    ("function", "words"),
    [
        ((lambda x: x, None), "forward must return"),
        ((lambda x: (x / 0.0 if False else np.full(2, np.nan), x), None), "forward gives NaN or infinity here"),
        ((lambda x: (x, x), lambda d_y, x: (d_y, d_y)), "1 gradients are needed, 2 came back"),
        ((lambda x, y: (x, x), None), "forward failed with x .*missing 1 required positional argument"),
        (Step(), "backward failed with .*Step has no backward pass"),
    ],
)
def test_functions_of_the_wrong_form(function, words):
    with pytest.raises(GradientError, match=words):
        check_gradient(function, {"x": np.ones((1, 2))})


def test_inputs_must_be_finite():
    with pytest.raises(ValueError, match="x must be finite"):
        check_gradient(ReLU(), {"x": [[np.nan]]})
