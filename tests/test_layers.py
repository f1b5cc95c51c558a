"""Layers and losses: closed forms, stated Jacobians, differences in float64, shapes, saturation, extremes, words."""

import autograd
import autograd.numpy as anp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import expit, log1p

from mcdenoise.nn import (
    CrossEntropy,
    Linear,
    RelativeError,
    ReLU,
    Sigmoid,
    Softplus,
    SquaredError,
    Step,
    Tanh,
    check_gradient,
)
from mcdenoise.nn.layers import linear_backward, sigmoid, softplus, softplus_backward
from mcdenoise.nn.losses import relative_error_gradient

pytestmark = pytest.mark.ch08
ACTIVATIONS = [Sigmoid(), Tanh(), ReLU(), Softplus()]
LOSSES = [SquaredError(), CrossEntropy(), RelativeError(), RelativeError(spp=8, epsilon=0.1)]


def name_of(value):
    return type(value).__name__


def away_from_zero(rng, *shape):
    """Numbers at least 0.1 from the kink of a ReLU."""
    x = rng.normal(size=shape)
    return x + 0.1 * np.sign(x)


def targets(rng, loss, *shape):
    return rng.random(shape) if isinstance(loss, CrossEntropy) else rng.gamma(1.0, 0.5, shape)


# --- Linear


def test_linear_is_the_equation(rng):
    x, weight, bias = rng.normal(size=(4, 3)), rng.normal(size=(2, 3)), rng.normal(size=2)
    y, _ = Linear(weight, bias).forward(x)
    expected = [[sum(weight[s, t] * x[i, t] for t in range(3)) + bias[s] for s in range(2)] for i in range(4)]
    np.testing.assert_allclose(y, expected, rtol=1e-13)


def test_linear_has_its_weight_as_jacobian(rng):
    layer = Linear(rng.normal(size=(2, 5)), rng.normal(size=2))
    np.testing.assert_array_equal(layer.jacobian(rng.normal(size=5)), layer.weight)


@given(n=st.integers(0, 5), d_in=st.integers(1, 6), d_out=st.integers(1, 6))
def test_linear_backward_for_any_shape(n, d_in, d_out):
    rng = np.random.default_rng([n, d_in, d_out])
    layer = Linear(rng.normal(size=(d_out, d_in)), rng.normal(size=d_out))
    x = rng.normal(size=(n, d_in))
    assert check_gradient(layer, {"x": x}) < 1e-6
    d_x, gradients = layer.backward(np.ones((n, d_out)), layer.forward(x)[1])
    assert d_x.shape == x.shape
    assert {name: one.shape for name, one in gradients.items()} == {"weight": (d_out, d_in), "bias": (d_out,)}
    if n == 0:
        assert not any(one.any() for one in gradients.values())


def test_whole_numbers_become_float64():
    layers = Linear(np.array([[1, 1]]), [0]), Linear([[1.0]], np.array([-0.5]))
    assert {array.dtype for one in layers for array in one.parameters.values()} == {np.dtype(np.float64)}


def test_a_batch_is_the_sum_of_its_rows(rng):
    d_y, x, weight = rng.normal(size=(6, 2)), rng.normal(size=(6, 3)), rng.normal(size=(2, 3))
    whole = linear_backward(d_y, x, weight)
    rows = [linear_backward(d_y[i : i + 1], x[i : i + 1], weight) for i in range(6)]
    np.testing.assert_allclose(whole[1], sum(row[1] for row in rows), rtol=1e-12)
    np.testing.assert_allclose(whole[2], sum(row[2] for row in rows), rtol=1e-12)
    np.testing.assert_allclose(whole[0], np.concatenate([row[0] for row in rows]), rtol=1e-12)


def test_the_first_layer_may_leave_d_x_out(rng):
    layer, d_y = Linear(rng.normal(size=(2, 3)), np.zeros(2)), rng.normal(size=(5, 2))
    _, saved = layer.forward(rng.normal(size=(5, 3)))
    full, short = layer.backward(d_y, saved)[1], layer.gradients(d_y, saved)
    assert all(np.array_equal(full[name], short[name]) for name in full)


# --- activations


@pytest.mark.parametrize("layer", ACTIVATIONS, ids=name_of)
@pytest.mark.parametrize("shape", [(0, 3), (1, 1), (1, 4), (5, 3)])
def test_activations_against_differences(layer, shape, rng):
    assert check_gradient(layer, {"x": away_from_zero(rng, *shape)}) < 1e-6


@pytest.mark.parametrize(
    ("layer", "slope"),
    [
        (Sigmoid(), lambda x: expit(x) * expit(-x)),
        (Tanh(), lambda x: 1 / np.cosh(x) ** 2),
        (ReLU(), lambda x: (x > 0).astype(float)),
        (Softplus(), expit),
    ],
    ids=lambda value: name_of(value) if hasattr(value, "forward") else "",
)
def test_their_jacobians_are_diagonal_and_as_stated(layer, slope, rng):
    x = rng.normal(size=4)
    np.testing.assert_allclose(layer.jacobian(x), np.diag(slope(x)), rtol=1e-12, atol=1e-15)


def test_values_against_scipy():
    x = np.linspace(-40, 40, 1001)
    np.testing.assert_allclose(sigmoid(x), expit(x), rtol=1e-13)
    np.testing.assert_allclose(softplus(x), np.maximum(x, 0) + log1p(np.exp(-np.abs(x))), rtol=1e-13)
    np.testing.assert_allclose(softplus_backward(np.ones_like(x), x), -np.expm1(-softplus(x)), rtol=1e-9)


def test_softplus_keeps_its_digits_in_float32():
    """Far below 0 too, where 1 + e^x is 1: the result is e^x, not 0."""
    x = np.linspace(-60, 5, 100_001, dtype=np.float32)
    np.testing.assert_allclose(softplus(x), np.logaddexp(0, x.astype(np.float64)), rtol=4e-7)


def test_a_smooth_step_becomes_a_step():
    x = np.array([[-1.0, -0.1, 0.1, 1.0]])
    np.testing.assert_allclose(Sigmoid().forward(1e4 * x)[0], Step().forward(x)[0], atol=1e-12)
    np.testing.assert_allclose(Softplus().forward(1e4 * x)[0] / 1e4, ReLU().forward(x)[0], atol=1e-12)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("layer", ACTIVATIONS, ids=name_of)
@pytest.mark.parametrize("size", [1e2, 1e4, 1e30])
def test_saturation_is_finite_and_silent(layer, dtype, size):
    """Warnings are errors here, so this also says that nobody overflows aloud."""
    x = np.array([[-size, size]], dtype)
    y, saved = layer.forward(x)
    d_x, _ = layer.backward(np.ones_like(y), saved)
    assert y.dtype == d_x.dtype == dtype
    assert np.isfinite(y).all()
    assert np.isfinite(d_x).all()
    straight = isinstance(layer, ReLU | Softplus)
    low = -1.0 if isinstance(layer, Tanh) else 0.0
    np.testing.assert_allclose(y, [[low, size if straight else 1.0]], rtol=1e-6, atol=1e-30)
    np.testing.assert_allclose(d_x, [[0.0, 1.0 if straight else 0.0]], atol=1e-30)


@pytest.mark.parametrize(
    "layer", [Linear(np.ones((3, 2), np.float32), np.ones(3, np.float32)), *ACTIVATIONS], ids=name_of
)
def test_float32_stays_float32(layer, rng):
    x = rng.normal(size=(4, 2)).astype(np.float32)
    y, saved = layer.forward(x)
    d_x, gradients = layer.backward(np.ones_like(y), saved)
    assert {one.dtype for one in (y, d_x, *gradients.values())} == {np.dtype(np.float32)}


@pytest.mark.parametrize("layer", [Linear(np.ones((2, 2)), np.ones(2)), *ACTIVATIONS, Step()], ids=name_of)
def test_nobody_changes_what_came_in(layer, rng):
    x, d_y = rng.normal(size=(3, 2)), rng.normal(size=(3, 2))
    before = x.copy(), d_y.copy()
    y, saved = layer.forward(x)
    kept = y.copy()
    if not isinstance(layer, Step):
        layer.backward(d_y, saved)
        layer.backward(d_y, saved)
    assert np.array_equal(x, before[0])
    assert np.array_equal(d_y, before[1])
    assert np.array_equal(y, kept)


def test_the_step_has_no_backward_pass():
    y, saved = Step().forward(np.array([[-1e-9, 0.0]]))
    assert y.tolist() == [[0, 1]]
    with pytest.raises(ValueError, match=r"Step has no backward pass.*Use Sigmoid"):
        Step().backward(np.ones((1, 2)), saved)


# --- losses


@pytest.mark.parametrize("loss", LOSSES, ids=name_of)
@pytest.mark.parametrize("shape", [(1, 1), (1, 3), (6, 3)])
def test_losses_against_differences(loss, shape, rng):
    y, target = rng.normal(size=shape), targets(rng, loss, *shape)
    assert check_gradient(loss, {"y": y}, fixed={"target": target}) < 1e-6


@pytest.mark.parametrize("loss", LOSSES, ids=name_of)
def test_no_rows_have_no_loss(loss):
    value, saved = loss.forward(np.zeros((0, 3)), np.zeros((0, 3)))
    assert value == 0
    assert loss.backward(saved).shape == (0, 3)


def test_losses_have_the_closed_form():
    y, target = np.array([[2.0, 0.5], [1.0, 1.0]]), np.array([[1.0, 0.5], [1.0, 0.0]])
    assert SquaredError().forward(y, target)[0] == pytest.approx((1 + 1) / 2 / 2)
    relative = 4 / 2 * (1 / 1.01 + 1 / 0.01) / 2
    assert RelativeError(spp=4).forward(y, target)[0] == pytest.approx(relative)
    p = expit(y)
    entropy = -(target * np.log(p) + (1 - target) * np.log(1 - p)).sum() / 2
    assert CrossEntropy().forward(y, target)[0] == pytest.approx(entropy)


def test_the_answer_to_the_question_of_the_lecture():
    """dE_i / dc_hat = n (c_hat - c) / (c^2 + eps), a number at a time."""
    filtered, reference = np.array([[0.5, 2.0, 0.1]]), np.array([[0.4, 3.0, 0.0]])
    expected = [8 * 0.1 / (0.16 + 0.01), 8 * -1.0 / (9 + 0.01), 8 * 0.1 / 0.01]
    np.testing.assert_allclose(relative_error_gradient(filtered, reference, 8, 0.01), [expected], rtol=1e-12)


def test_spp_a_row_weighs_the_rows(rng):
    y, target = rng.random((3, 3)), rng.random((3, 3))
    loss = RelativeError(spp=np.array([4.0, 8.0, 64.0]))
    alone = [RelativeError(spp=n).forward(y[i : i + 1], target[i : i + 1])[0] for i, n in enumerate((4, 8, 64))]
    assert loss.forward(y, target)[0] == pytest.approx(np.mean(alone))
    assert check_gradient(loss, {"y": y}, fixed={"target": target}) < 1e-6


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_black_reference_is_as_steep_as_epsilon_says(dtype):
    loss = RelativeError()
    value, saved = loss.forward(np.array([[0.0, 1.0]], dtype), np.zeros((1, 2), dtype))
    assert value == pytest.approx(50)
    np.testing.assert_allclose(loss.backward(saved), [[0, 100]], rtol=1e-6)


@pytest.mark.parametrize("loss", LOSSES, ids=name_of)
@pytest.mark.parametrize("size", [1e-30, 1e10, 1e30])
def test_losses_at_the_ends_of_float32_are_finite(loss, size):
    """Radiance may reach 1e30: its square leaves float32, not float64."""
    y = np.array([[size, -size, 0.0]], np.float32)
    target = np.array([[0.0, 1.0, 1.0]], np.float32)
    if not isinstance(loss, CrossEntropy):
        target = target * np.float32(size)
    value, saved = loss.forward(y, target)
    assert np.isfinite(value)
    assert np.isfinite(loss.backward(saved)).all()
    assert loss.backward(saved).dtype == np.float32


def test_cross_entropy_does_not_vanish_where_the_sigmoid_is_wrong():
    """The gradient of the squared error of a saturated sigmoid is 0, though it is wrong; that of cross-entropy is 1."""
    far, target = np.array([[-50.0]]), np.array([[1.0]])
    assert CrossEntropy().backward(CrossEntropy().forward(far, target)[1]) == pytest.approx(-1)
    s, saved = Sigmoid().forward(far)
    d_s = SquaredError().backward(SquaredError().forward(s, target)[1])
    assert abs(Sigmoid().backward(d_s, saved)[0].item()) < 1e-20


# --- another library


@pytest.mark.parametrize("loss", LOSSES[:3], ids=name_of)
def test_losses_against_autograd(loss, rng):
    y, target = rng.normal(size=(5, 3)), targets(rng, loss, 5, 3)
    formulas = {
        "SquaredError": lambda y: anp.sum((y - target) ** 2) / 2 / 5,
        "CrossEntropy": lambda y: anp.sum(anp.logaddexp(0, y) - target * y) / 5,
        "RelativeError": lambda y: anp.sum((y - target) ** 2 / (target**2 + 0.01)) / 2 / 5,
    }
    formula = formulas[name_of(loss)]
    value, saved = loss.forward(y, target)
    assert value == pytest.approx(float(formula(y)), rel=1e-12)
    np.testing.assert_allclose(loss.backward(saved), autograd.grad(formula)(y), rtol=1e-10, atol=1e-14)


# --- words


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: Linear(np.ones((2, 3)), np.ones(3)),
            r"weight \(d_out, d_in\) and a bias \(d_out,\), got \(2, 3\) and \(3,\)",
        ),
        (lambda: Linear(np.ones(3), np.ones(3)), r"got \(3,\) and \(3,\)"),
        (
            lambda: Linear(np.ones((2, 3)), np.ones(2)).forward(np.ones((4, 2))),
            r"Linear 3 -> 2 needs x .* \(n, 3\).*\(4, 2\)",
        ),
        (
            lambda: Linear(np.ones((2, 3)), np.ones(2)).forward(np.ones(3)),
            r"got \(3,\). A single row is x\[np.newaxis\]",
        ),
        (lambda: Tanh().jacobian([[1.0]]), r"jacobian of Tanh is that of one row, shape \(d_in,\), got \(1, 1\)"),
        (
            lambda: SquaredError().forward(np.ones((4, 1)), np.ones(4)),
            r"SquaredError .* got \(4, 1\) and \(4,\).*column",
        ),
        (
            lambda: CrossEntropy().forward(np.ones((1, 1)), [[2.0]]),
            r"CrossEntropy needs targets in \[0, 1\], got 2 to 2",
        ),
        (lambda: RelativeError(epsilon=0), "epsilon must be greater than 0"),
        (lambda: RelativeError(spp=0), "spp must be a number above 0"),
        (lambda: RelativeError(spp=[4, 8]).forward(np.ones((3, 3)), np.ones((3, 3))), "the spp of 2 rows, got 3 rows"),
    ],
)
def test_what_does_not_fit_is_said_with_both_shapes(call, words):
    with pytest.raises(ValueError, match=words):
        call()
