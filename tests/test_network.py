"""Whole networks: gradients against differences and another library, shapes, storage, depth, words."""

import json

import autograd
import autograd.numpy as anp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdenoise.nn import (
    MLP,
    Linear,
    RelativeError,
    ReLU,
    Sigmoid,
    Softplus,
    SquaredError,
    Step,
    Tanh,
    check_gradient,
    load_network,
    loss_and_gradients,
    save_network,
)
from mcdenoise.nn.gradcheck import Pair

pytestmark = pytest.mark.ch08


def network(widths=(3, 4, 2), **settings):
    return MLP.random(widths, rng=np.random.default_rng(5), **settings)


# --- gradients


@given(
    n=st.integers(0, 4),
    widths=st.lists(st.integers(1, 5), min_size=2, max_size=5),
    hidden=st.sampled_from([Sigmoid(), Tanh(), Softplus()]),
    output=st.sampled_from([None, Sigmoid(), Softplus()]),
)
@settings(max_examples=30)
def test_whole_networks_against_differences(n, widths, hidden, output):
    mlp = network(widths, hidden=hidden, output=output)
    x = np.random.default_rng(n).normal(size=(n, widths[0]))
    assert check_gradient(mlp, {"x": x}) < 1e-6


@pytest.mark.parametrize("hidden", [Sigmoid(), Tanh(), ReLU(), Softplus()], ids=lambda one: type(one).__name__)
def test_network_and_loss_together(hidden, rng):
    """The whole chain from the weights to the lecture's relative error. Biases of 0 could put a ReLU on its kink."""
    mlp, loss = network((5, 7, 4, 3), hidden=hidden, output=Softplus()), RelativeError(spp=8)
    mlp = mlp.replace({name: array + 0.1 * name.startswith("bias") for name, array in mlp.parameters.items()})
    x, target = rng.normal(size=(6, 5)), rng.gamma(1.0, 0.5, (6, 3))

    def forward(**parameters):
        changed = mlp.replace(parameters)
        return loss_and_gradients(changed, x, target, loss)[0], changed

    def backward(d_y, changed):
        gradients = loss_and_gradients(changed, x, target, loss)[1]
        return {name: d_y * gradient for name, gradient in gradients.items()}

    assert check_gradient(Pair(forward, backward, "chain"), mlp.parameters) < 1e-6


@pytest.mark.parametrize("depth", [1, 3])
def test_whole_networks_against_autograd(depth, rng):
    widths = (4, *([6] * depth), 3)
    mlp = network(widths, hidden=Tanh(), output=Softplus())
    x, target = rng.normal(size=(9, 4)), rng.gamma(1.0, 0.5, (9, 3))

    def plain(parameters):
        y = x
        for k in range(1, depth + 2):
            y = anp.dot(y, parameters[f"weight_{k}"].T) + parameters[f"bias_{k}"]
            y = anp.tanh(y) if k <= depth else anp.logaddexp(0.0, y)
        return anp.sum((y - target) ** 2 / (target**2 + 0.01)) / 2 / 9

    value, gradients = loss_and_gradients(mlp, x, target, RelativeError())
    expected = autograd.grad(plain)(dict(mlp.parameters))
    assert value == pytest.approx(float(plain(mlp.parameters)), rel=1e-12)
    assert gradients.keys() == expected.keys()
    for name in expected:
        np.testing.assert_allclose(gradients[name], expected[name], rtol=1e-9, atol=1e-13)


@pytest.mark.parametrize("first", [(), (Tanh(),)], ids=["linear first", "activation first"])
def test_gradients_are_those_of_backward_without_d_x(first, rng):
    mlp = MLP((*first, *network().layers))
    _, saved = mlp.forward(rng.normal(size=(5, 3)))
    d_y = rng.normal(size=(5, 2))
    full, short = mlp.backward(d_y, saved)[1], mlp.gradients(d_y, saved)
    assert list(full) == list(short) == list(mlp.parameters)
    assert all(np.array_equal(full[name], short[name]) for name in full)


def test_float32_is_near_float64(rng):
    mlp, x = network((36, 10, 6), output=Softplus()), rng.normal(size=(1000, 36))
    small = MLP.random((36, 10, 6), output=Softplus(), rng=np.random.default_rng(5), dtype=np.float32)
    target = rng.gamma(1.0, 0.5, (1000, 6))
    exact, near = (loss_and_gradients(one, x, target, SquaredError()) for one in (mlp, small))
    assert near[0] == pytest.approx(exact[0], rel=1e-5)
    for name, gradient in near[1].items():
        assert gradient.dtype == np.float32
        assert np.linalg.norm(gradient - exact[1][name]) < 1e-5 * np.linalg.norm(exact[1][name])


def test_a_network_of_identities_hands_everything_through(rng):
    identity = Linear(np.eye(3), np.zeros(3))
    mlp, x, d_y = MLP((identity, identity)), rng.normal(size=(4, 3)), rng.normal(size=(4, 3))
    y, saved = mlp.forward(x)
    assert np.array_equal(y, x)
    assert np.array_equal(mlp.backward(d_y, saved)[0], d_y)


def test_calling_backward_twice_gives_the_same(rng):
    mlp = network()
    _, saved = mlp.forward(rng.normal(size=(5, 3)))
    once, twice = (mlp.backward(np.ones((5, 2)), saved)[1] for _ in range(2))
    assert all(np.array_equal(once[name], twice[name]) for name in once)


# --- depth


def gradient_of_first_layer(depth, hidden, gain, width=32, n=64):
    mlp = MLP.random([width] * (depth + 1), hidden=hidden, gain=gain, rng=np.random.default_rng(0))
    rng = np.random.default_rng(1)
    x, target = rng.normal(size=(2, n, width))
    gradients = loss_and_gradients(mlp, x, target, SquaredError())[1]
    return float(np.linalg.norm(gradients["weight_1"]))


def test_gradients_vanish_with_depth_behind_sigmoids():
    """Each sigmoid passes at most a quarter."""
    norms = [gradient_of_first_layer(depth, Sigmoid(), 1.0) for depth in (2, 4, 8)]
    assert norms[1] < norms[0] / 4**2 * 2
    assert norms[2] < norms[1] / 4**4 * 4


def test_gradients_explode_with_depth_where_weights_are_large():
    norms = [gradient_of_first_layer(depth, ReLU(), 3.0) for depth in (2, 4, 8)]
    assert norms[1] > 3 * norms[0]
    assert norms[2] > 9 * norms[1]


def test_the_right_gain_keeps_them():
    """Of ReLU half is lost a layer; a gain of sqrt(2) makes up for it."""
    shallow, deep = (gradient_of_first_layer(depth, ReLU(), np.sqrt(2)) for depth in (2, 16))
    assert 0.1 < deep / shallow < 10


def test_a_dead_unit_learns_nothing(rng):
    """A ReLU whose input is below 0 for all rows has no gradient, and so never comes back."""
    mlp = network((3, 4, 2), hidden=ReLU())
    dead = mlp.replace({**mlp.parameters, "bias_1": np.array([-100.0, 0.0, 0.0, 0.0])})
    gradients = loss_and_gradients(dead, rng.normal(size=(50, 3)), rng.normal(size=(50, 2)), SquaredError())[1]
    assert not gradients["weight_1"][0].any()
    assert gradients["bias_1"][0] == 0
    assert gradients["weight_1"][1:].any(axis=1).all()


# --- shape and words


def test_sizes_and_names():
    mlp = MLP.random([36, 10, 6], rng=np.random.default_rng(0), output=Softplus(), dtype=np.float32)
    assert (mlp.size, mlp.inputs, mlp.dtype) == (436, 36, np.float32)
    assert list(mlp.parameters) == ["weight_1", "bias_1", "weight_2", "bias_2"]
    assert [type(layer).__name__ for layer in mlp.layers] == ["Linear", "Sigmoid", "Linear", "Softplus"]


def test_the_same_generator_gives_the_same_network():
    one, other, third = (
        MLP.random([3, 3], rng=np.random.default_rng(seed)).parameters["weight_1"] for seed in (1, 1, 2)
    )
    assert np.array_equal(one, other)
    assert not np.array_equal(one, third)


def test_random_weights_keep_the_scale_of_their_input():
    weight = MLP.random([400, 300], gain=2.0, rng=np.random.default_rng(0)).parameters["weight_1"]
    assert weight.std() == pytest.approx(2 / np.sqrt(400), rel=4 / np.sqrt(2 * weight.size))  # 4 standard errors


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: MLP(()), "at least one Linear"),
        (
            lambda: MLP((*network((3, 4)).layers, *network((5, 2)).layers)),
            r"layer 2 must take the 4 outputs.*\(2, 5\)",
        ),
        (
            lambda: MLP((*network((3, 4)).layers, *network((4, 2), dtype=np.float32).layers)),
            "one dtype, got float32 and float64",
        ),
        (lambda: MLP.random([3], rng=None), "at least those of input and output"),
        (lambda: MLP.random([3, 0], rng=None), "a width must be at least 1"),
        (lambda: MLP.random([3, 1], rng=None, dtype=np.int32), "float32 or float64, got int32"),
        (lambda: network().forward(np.ones((4, 2))), r"Linear 3 -> 4 needs x of shape \(n, 3\).*got \(4, 2\)"),
        (
            lambda: network().replace({"weight_1": np.ones((4, 3))}),
            r"of this MLP are weight_1, bias_1.*; got weight_1",
        ),
        (lambda: network().replace({**network().parameters, "bias_1": np.ones(3)}), r"bias_1 has shape \(4,\).*\(3,\)"),
    ],
)
def test_what_does_not_fit(call, words):
    with pytest.raises(ValueError, match=words):
        call()


# --- storage


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_stored_and_read_back(dtype, tmp_path, rng):
    mlp = MLP.random([3, 4, 4, 2], hidden=Tanh(), output=Softplus(), rng=rng, dtype=dtype)
    save_network(mlp, tmp_path / "net.npz")
    back = load_network(tmp_path / "net.npz")
    x = rng.normal(size=(5, 3))
    assert [type(one) for one in back.layers] == [type(one) for one in mlp.layers]
    assert back.dtype == dtype
    assert np.array_equal(back.forward(x)[0], mlp.forward(x)[0])
    assert list(tmp_path.iterdir()) == [tmp_path / "net.npz"]


def test_a_step_network_can_be_stored(tmp_path):
    save_network(network(hidden=Step()), tmp_path / "net.npz")
    assert isinstance(load_network(tmp_path / "net.npz").layers[1], Step)


def stored(tmp_path, described=None, **changes):
    """A file that is right but for the changes (None: left out)."""
    mlp = network((2, 1))
    about = {"format": "mcdenoise-network-1", "layers": ["Linear"]} | (described or {})
    arrays = {"about": np.array(json.dumps(about)), **mlp.parameters} | changes
    path = tmp_path / "net.npz"
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    return path


@pytest.mark.parametrize(
    ("about", "changes", "words"),
    [
        ({"format": "else-1"}, {}, "must have the format mcdenoise-network-1, got 'else-1'"),
        ({"layers": ["Conv"]}, {}, "is not a whole file of a network"),
        ({"layers": 3}, {}, "is not a whole file of a network"),
        ({"layers": ["Linear", "Linear"]}, {}, "holds no network that fits together: 'weight_2'"),
        ({"layers": ["Sigmoid"]}, {}, "arrays that belong to no layer: weight_1, bias_1"),
        (None, {"about": None}, "is not a whole file of a network"),
        (None, {"bias_1": None}, "holds no network that fits together"),
        (None, {"bias_1": np.zeros(3)}, r"got \(1, 2\) and \(3,\)"),
        (None, {"bias_1": np.array([np.nan])}, "bias_1 must be finite"),
        (None, {"bias_1": np.array([1])}, "bias_1 must be float32 or float64, got int64"),
        (None, {"bias_1": np.array([object()])}, "is not a whole file of a network"),
        (None, {"bias_2": np.zeros(1)}, "arrays that belong to no layer: bias_2"),
    ],
)
def test_foreign_files_are_refused_in_words(about, changes, words, tmp_path):
    with pytest.raises(ValueError, match=words):
        load_network(stored(tmp_path, about, **changes))


def test_truncated_files_are_refused(tmp_path):
    path = stored(tmp_path)
    whole = path.read_bytes()
    for length in (0, 10, len(whole) // 2, len(whole) - 30):
        path.write_bytes(whole[:length])
        with pytest.raises(ValueError, match="is not a whole file of a network"):
            load_network(path)
    with pytest.raises(ValueError, match="there is no file"):
        load_network(tmp_path / "none.npz")


def test_what_cannot_be_stored(tmp_path):
    with pytest.raises(ValueError, match=r"stored as .npz, got the name 'net.pt'. Call it net.npz"):
        save_network(network(), tmp_path / "net.pt")
    bad = network()
    bad = bad.replace({**bad.parameters, "bias_1": np.full(4, np.inf)})
    with pytest.raises(ValueError, match="bias_1 must be finite"):
        save_network(bad, tmp_path / "net.npz")

    class Own(Tanh):
        pass

    with pytest.raises(ValueError, match="can be stored, got Own"):
        save_network(network(hidden=Own()), tmp_path / "net.npz")
    assert not list(tmp_path.iterdir())
