"""The kernel of networks against the NumPy reference: parity, threads, saturation, and for whom it is."""

import numba
import numpy as np
import pytest

from mcdenoise.kernels import network as kernel
from mcdenoise.nn import (
    MLP,
    RPROP,
    Linear,
    RelativeError,
    ReLU,
    Sigmoid,
    Softplus,
    SquaredError,
    Step,
    Tanh,
    loss_and_gradients,
    train,
)
from mcdenoise.nn.fast import CODES, fast_loss_and_gradients, plan_of

pytestmark = pytest.mark.ch08
BLOCK = kernel.BLOCK


def network(widths, hidden=None, output=None, dtype=np.float32):
    return MLP.random(widths, hidden=hidden, output=output, rng=np.random.default_rng(3), dtype=dtype)


def assert_same(mlp, x, target, loss):
    """As the NumPy engine in float64, up to what float32 can do."""
    exact = mlp.replace({name: array.astype(np.float64) for name, array in mlp.parameters.items()})
    expected = loss_and_gradients(exact, x, target, loss, engine="numpy")
    received = loss_and_gradients(mlp, x, target, loss)
    assert received[0] == pytest.approx(expected[0], rel=1e-5, abs=1e-12)
    assert list(received[1]) == list(expected[1])
    for name, gradient in received[1].items():
        assert gradient.dtype == np.float32
        assert gradient.shape == expected[1][name].shape
        size = np.linalg.norm(expected[1][name])
        assert np.linalg.norm(gradient - expected[1][name]) <= 2e-5 * size, name


@pytest.mark.parametrize("rows", [1, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK + 7])
@pytest.mark.parametrize("widths", [(36, 10, 6), (1, 1), (3, 5, 4, 7, 2)])
def test_any_number_of_rows_and_any_widths(rows, widths, rng):
    mlp = network(widths, Sigmoid(), Softplus())
    assert_same(mlp, rng.normal(size=(rows, widths[0])), rng.random((rows, widths[-1])), SquaredError())


@pytest.mark.parametrize("hidden", [Sigmoid(), Tanh(), ReLU(), Softplus()], ids=lambda one: type(one).__name__)
@pytest.mark.parametrize("output", [None, Sigmoid(), Tanh(), ReLU(), Softplus()], ids=lambda one: type(one).__name__)
def test_every_activation_within_and_at_the_end(hidden, output, rng):
    x, target = rng.normal(size=(300, 4)), rng.gamma(1.0, 0.5, (300, 3))
    assert_same(network((4, 6, 5, 3), hidden, output), x, target, RelativeError(spp=8))


def test_two_linear_layers_in_a_row(rng):
    mlp = MLP((*network((4, 3)).layers, *network((3, 2)).layers, Tanh()))
    assert plan_of(mlp) == ([4, 3, 2], [0, 2])
    assert_same(mlp, rng.normal(size=(50, 4)), rng.normal(size=(50, 2)), SquaredError())


def test_no_rows_have_no_gradient():
    value, gradients = loss_and_gradients(network((3, 4, 2)), np.zeros((0, 3)), np.zeros((0, 2)), SquaredError())
    assert value == 0
    assert not any(gradient.any() for gradient in gradients.values())


def test_rows_are_added_up_whatever_their_order(rng):
    x, target = rng.normal(size=(1000, 4)), rng.normal(size=(1000, 2))
    mlp, order = network((4, 6, 2), Tanh()), rng.permutation(1000)
    one, other = (loss_and_gradients(mlp, x[rows], target[rows], SquaredError())[1] for rows in (slice(None), order))
    for name in one:
        np.testing.assert_allclose(one[name], other[name], rtol=1e-4, atol=1e-6)


def test_same_bits_at_any_number_of_threads(rng):
    if numba.config.NUMBA_NUM_THREADS < 2:
        pytest.skip("numba was started with one thread only")
    x, target = rng.normal(size=(5000, 4)), rng.normal(size=(5000, 2))
    mlp, before, found = network((4, 6, 2), Tanh()), numba.get_num_threads(), []
    try:
        for threads in (1, numba.config.NUMBA_NUM_THREADS):
            numba.set_num_threads(threads)
            found.append(loss_and_gradients(mlp, x, target, SquaredError()))
    finally:
        numba.set_num_threads(before)
    assert found[0][0] == found[1][0]
    assert all(np.array_equal(found[0][1][name], found[1][1][name]) for name in found[0][1])


@pytest.mark.parametrize("code", CODES.values())
@pytest.mark.parametrize("size", [1e2, 1e4, 1e30])
def test_saturation_is_finite(code, size):
    """The layer hands its input through; its activation and slope at both ends are those of the reference."""
    x = np.array([[-size], [size]], np.float32)
    layer = next(kind for kind, one in CODES.items() if one == code)()
    y = kernel.network_forward(x, np.array([1, 0], np.float32), (1, 1), (code,))
    expected, saved = layer.forward(x)
    np.testing.assert_allclose(y, expected, rtol=1e-6, atol=1e-30)
    slope = kernel.network_backward(np.ones_like(x), x, np.array([1, 0], np.float32), (1, 1), (code,))
    assert np.isfinite(slope).all()
    np.testing.assert_allclose(slope[1], layer.backward(np.ones_like(x), saved)[0].sum(), atol=1e-30)


def test_activations_are_accurate_between():
    x = np.linspace(-30, 30, 100_001, dtype=np.float32)[:, np.newaxis]
    one = np.array([1, 0], np.float32)
    for kind, code in CODES.items():
        y = kernel.network_forward(x, one, (1, 1), (code,))
        expected = kind().forward(x.astype(np.float64))[0]
        # An exponent of 43 is rounded by 43 * 2^-24, and so is e^-30 relatively. Tanh subtracts near 0: 1 - e.
        tolerance = {"rtol": 0, "atol": 3e-7} if kind is Tanh else {"rtol": 1e-6 + 43 * 2**-24, "atol": 0}
        np.testing.assert_allclose(y, expected, **tolerance)


# --- for whom


def test_only_float32_networks_of_known_layers_are_for_it():
    assert plan_of(network((3, 4, 2), ReLU(), Softplus())) == ([3, 4, 2], [3, 4])
    linear, step = network((3, 3)).layers[0], Step()
    others = [
        network((3, 2), dtype=np.float64),
        MLP((Tanh(), linear)),
        MLP((linear, step, linear)),
        MLP((linear, Tanh(), Tanh(), linear)),
        MLP((type("Own", (Linear,), {})(np.ones((1, 3), np.float32), np.ones(1, np.float32)),)),
    ]
    assert [plan_of(one) for one in others] == [None] * len(others)


def test_the_others_pass_through_numpy(rng):
    linear = network((3, 3)).layers[0]
    mlp, x = MLP((linear, Tanh(), Tanh(), linear)), rng.normal(size=(9, 3)).astype(np.float32)
    both = [loss_and_gradients(mlp, x, x, SquaredError(), engine=engine) for engine in ("numba", "numpy")]
    assert both[0][0] == both[1][0]
    assert all(np.array_equal(both[0][1][name], both[1][1][name]) for name in both[0][1])


def test_training_takes_the_same_way_by_both_engines(rng):
    x = rng.uniform(-1, 1, (400, 1))
    done = [
        train(
            network((1, 8, 1), Tanh()),
            x,
            np.sin(3 * x),
            loss=SquaredError(),
            optimizer=RPROP(0.01),
            epochs=60,
            engine=engine,
        )
        for engine in ("numba", "numpy")
    ]
    np.testing.assert_allclose(done[0].losses, done[1].losses, rtol=1e-2)
    assert done[0].losses[-1] < 0.05 * done[0].losses[0]


def test_the_kernel_is_what_runs(monkeypatch, rng):
    ran = []
    monkeypatch.setattr(
        "mcdenoise.nn.training.fast_loss_and_gradients",
        lambda *given: ran.append(given[0]) or fast_loss_and_gradients(*given),
    )
    mlp, x = network((2, 2)), rng.normal(size=(5, 2))
    loss_and_gradients(mlp, x, x, SquaredError(), engine="numpy")
    assert ran == []
    loss_and_gradients(mlp, x, x, SquaredError())
    assert ran == [mlp]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"x": np.ones((4, 2))}, r"Linear 3 -> 4 needs x of shape \(n, 3\).*got \(4, 2\)"),
        ({"x": np.ones(3)}, r"got \(3,\). A single row"),
        ({"target": np.ones((4, 3))}, r"SquaredError needs y and target of one shape"),
        ({"engine": "torch"}, "engine must be"),
    ],
)
def test_what_does_not_fit_is_said_in_the_same_words(changes, words):
    given = {"x": np.ones((4, 3)), "target": np.ones((4, 2)), "loss": SquaredError(), "engine": "numba"} | changes
    with pytest.raises(ValueError, match=words):
        loss_and_gradients(network((3, 4, 2)), **given)
