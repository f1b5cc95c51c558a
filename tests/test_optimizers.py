"""Optimizers against transcriptions and closed forms; training: what it keeps, that it repeats, how it fails."""

import numpy as np
import pytest

from mcdenoise.nn import (
    MLP,
    RPROP,
    SGD,
    Adam,
    CrossEntropy,
    Diverged,
    Linear,
    RelativeError,
    ReLU,
    Sigmoid,
    SquaredError,
    Tanh,
    load_network,
    loss_and_gradients,
    save_network,
    train,
    two_moons,
)

pytestmark = pytest.mark.ch08
OPTIMIZERS = [SGD(0.1), SGD(0.1, momentum=0.9), Adam(0.05), RPROP(0.05)]


def bowl(w):
    """Gradient of a bowl that is thirty times as steep in one direction, and of a term that is no square."""
    return np.array([30.0, 1.0, 4.0]) * w + np.array([0.0, 0.5, 0.0]) * np.cos(w)


def path(optimizer, steps, dtype=np.float64):
    parameters = {"w": np.array([1.0, -2.0, 0.5], dtype)}
    state, found = optimizer.start(parameters), []
    for _ in range(steps):
        parameters, state = optimizer.step(parameters, {"w": bowl(parameters["w"]).astype(dtype)}, state)
        found.append(parameters["w"])
    return np.array(found)


def plain_rprop(steps, first=0.05, grow=1.2, shrink=0.5, smallest=1e-6, largest=50.0):
    """Number by number, with ifs, as in Igel and Hüsken's table of iRprop-."""
    w, step, before, found = [1.0, -2.0, 0.5], [first] * 3, [0.0] * 3, []
    for _ in range(steps):
        gradient = list(bowl(np.array(w)))
        for k in range(3):
            if before[k] * gradient[k] > 0:
                step[k] = min(step[k] * grow, largest)
            elif before[k] * gradient[k] < 0:
                step[k] = max(step[k] * shrink, smallest)
                gradient[k] = 0.0
            if gradient[k] > 0:
                w[k] -= step[k]
            elif gradient[k] < 0:
                w[k] += step[k]
            before[k] = gradient[k]
        found.append(list(w))
    return np.array(found)


def test_rprop_against_a_transcription():
    np.testing.assert_allclose(path(RPROP(0.05), 200), plain_rprop(200), rtol=1e-12, atol=1e-15)


def test_rprop_sees_only_signs():
    """Gradients a thousand times larger, in some numbers: the same path."""
    rprop = RPROP(0.05)
    parameters, scaled = {"w": np.array([1.0, -2.0])}, {"w": np.array([1.0, -2.0])}
    states = [rprop.start(parameters), rprop.start(scaled)]
    for _ in range(50):
        parameters, states[0] = rprop.step(parameters, {"w": parameters["w"]}, states[0])
        scaled, states[1] = rprop.step(scaled, {"w": scaled["w"] * [1000, 1e-3]}, states[1])
    assert np.array_equal(parameters["w"], scaled["w"])


def test_rprop_steps_stay_within_their_bounds():
    rprop, parameters = RPROP(first=1.0, largest=2.0, smallest=0.1), {"w": np.array([0.0, 0.0])}
    state = rprop.start(parameters)
    for turn in range(12):
        parameters, state = rprop.step(parameters, {"w": np.array([1.0, (-1.0) ** turn])}, state)
    assert state["step.w"][0] == 2.0
    assert state["step.w"][1] >= 0.1


@pytest.mark.parametrize("momentum", [0.0, 0.9])
def test_sgd_against_a_transcription(momentum):
    w, velocity, found = np.array([1.0, -2.0, 0.5]), np.zeros(3), []
    for _ in range(50):
        velocity = momentum * velocity - 0.01 * bowl(w)
        w = w + velocity
        found.append(w)
    np.testing.assert_allclose(path(SGD(0.01, momentum), 50), found, rtol=1e-13)


def test_adam_against_a_transcription():
    w, mean, square, found = np.array([1.0, -2.0, 0.5]), np.zeros(3), np.zeros(3), []
    for t in range(1, 51):
        gradient = bowl(w)
        mean, square = 0.9 * mean + 0.1 * gradient, 0.999 * square + 0.001 * gradient**2
        w = w - 0.05 * (mean / (1 - 0.9**t)) / (np.sqrt(square / (1 - 0.999**t)) + 1e-8)
        found.append(w)
    np.testing.assert_allclose(path(Adam(0.05), 50), found, rtol=1e-10)


def test_the_first_step_of_adam_has_the_length_of_the_rate():
    np.testing.assert_allclose(np.abs(path(Adam(0.05), 1)[0] - [1.0, -2.0, 0.5]), 0.05, rtol=1e-6)


def test_plain_descent_on_a_parabola_is_geometric():
    """w shrinks by 1 - rate a step."""
    parameters, descent = {"w": np.array([1.0])}, SGD(0.25)
    state = descent.start(parameters)
    for _ in range(10):
        parameters, state = descent.step(parameters, {"w": parameters["w"]}, state)
    assert parameters["w"].item() == pytest.approx(0.75**10, rel=1e-14)


@pytest.mark.parametrize("optimizer", OPTIMIZERS, ids=repr)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_steps_change_nothing_that_was_given_and_keep_the_dtype(optimizer, dtype):
    parameters, gradients = {"w": np.ones(3, dtype)}, {"w": np.full(3, -2, dtype)}
    state = optimizer.start(parameters)
    before = {name: array.copy() for name, array in state.items()}
    new, after = optimizer.step(parameters, gradients, state)
    assert (parameters["w"] == 1).all()
    assert (gradients["w"] == -2).all()
    assert all(np.array_equal(state[name], before[name]) for name in before)
    assert new["w"].dtype == dtype
    assert (new["w"] > 1).all()
    assert {array.dtype for name, array in after.items() if name != "steps"} == {np.dtype(dtype)}
    assert after.keys() == state.keys()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: SGD(0), "rate must be greater than 0"),
        (lambda: SGD(0.1, momentum=1), "momentum must be below 1"),
        (lambda: SGD(0.1, momentum=-0.1), r"momentum must lie in \[0, 1\]"),
        (lambda: Adam(beta_1=1.0), "beta_1 must be below 1"),
        (lambda: Adam(epsilon=0), "epsilon must be greater than 0"),
        (lambda: RPROP(first=0), "first must be greater than 0"),
        (lambda: RPROP(grow=0.9), "shrink < 1 < grow"),
        (lambda: RPROP(first=100.0), "smallest <= first <= largest"),
    ],
)
def test_settings_that_cannot_work(make, words):
    with pytest.raises(ValueError, match=words):
        make()


# --- training


def moons(n=200, seed=0):
    x, labels = two_moons(n, rng=np.random.default_rng(seed))
    return x, labels[:, np.newaxis].astype(float)


def small(*, hidden=None, seed=1, dtype=np.float64):
    return MLP.random([2, 6, 1], hidden=hidden or Tanh(), rng=np.random.default_rng(seed), dtype=dtype)


@pytest.mark.parametrize(
    ("optimizer", "epochs", "batch"),
    [(SGD(0.5, momentum=0.9), 150, None), (Adam(0.05), 500, None), (RPROP(0.05), 100, None), (Adam(0.02), 80, 20)],
    ids=["momentum", "adam", "rprop", "adam in batches"],
)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_all_learn_two_moons(optimizer, epochs, batch, dtype):
    x, target = moons()
    done = train(
        small(dtype=dtype),
        x,
        target,
        loss=CrossEntropy(),
        optimizer=optimizer,
        epochs=epochs,
        batch=batch,
        rng=np.random.default_rng(2),
    )
    fresh, labels = moons(seed=3)
    right = (done.network.forward(fresh)[0] > 0) == labels
    assert done.network.dtype == dtype
    assert done.losses.shape == (epochs,)
    assert done.losses[-1] < 0.2 * done.losses[0]
    assert right.mean() > 0.96  # 200 points, of which noise alone puts about 1 % on the wrong side


def test_a_linear_network_finds_the_least_squares_solution(rng):
    x, target = rng.normal(size=(40, 3)), rng.normal(size=(40, 2))
    mlp = MLP.random([3, 2], rng=rng)
    done = train(mlp, x, target, loss=SquaredError(), optimizer=SGD(0.5), epochs=500)
    expected = np.linalg.lstsq(np.concatenate([x, np.ones((40, 1))], axis=1), target, rcond=None)[0]
    np.testing.assert_allclose(done.network.parameters["weight_1"], expected[:3].T, atol=1e-9)
    np.testing.assert_allclose(done.network.parameters["bias_1"], expected[3], atol=1e-9)


def test_the_network_that_was_given_stays_as_it_is():
    mlp, (x, target) = small(), moons()
    before = {name: array.copy() for name, array in mlp.parameters.items()}
    done = train(mlp, x, target, loss=CrossEntropy(), optimizer=Adam(0.05), epochs=3)
    assert all(np.array_equal(mlp.parameters[name], before[name]) for name in before)
    assert not np.array_equal(done.network.parameters["weight_1"], before["weight_1"])


def test_the_same_seed_the_same_training():
    x, target = moons()
    settings = {"loss": CrossEntropy(), "optimizer": Adam(0.05), "epochs": 3, "batch": 32}
    one, other, third = (train(small(), x, target, rng=np.random.default_rng(seed), **settings) for seed in (7, 7, 8))
    assert np.array_equal(one.losses, other.losses)
    assert np.array_equal(one.network.parameters["weight_1"], other.network.parameters["weight_1"])
    assert not np.array_equal(one.losses, third.losses)


def test_one_step_is_one_step():
    """An epoch of one batch is forward, backward, step; nothing else."""
    mlp, (x, target), descent = small(), moons(), SGD(0.3)
    value, gradients = loss_and_gradients(mlp, x, target, CrossEntropy())
    done = train(mlp, x, target, loss=CrossEntropy(), optimizer=descent, epochs=1)
    assert done.losses.tolist() == [value]
    for name, array in mlp.parameters.items():
        np.testing.assert_array_equal(done.network.parameters[name], array - 0.3 * gradients[name])


@pytest.mark.parametrize("rows", [4096, 4097, 10_000])
def test_a_large_batch_in_parts_is_the_whole(rows, rng):
    """Parts of different length, and an spp a row: the same loss and gradients as in one go."""
    x, target = rng.normal(size=(rows, 2)), rng.gamma(1.0, 0.5, (rows, 1))
    mlp, loss = small(), RelativeError(spp=rng.integers(1, 64, rows).astype(float))
    y, saved = mlp.forward(x)
    value, saved_by_loss = loss.forward(y, target)
    expected = mlp.gradients(loss.backward(saved_by_loss), saved)
    received = loss_and_gradients(mlp, x, target, loss)
    assert received[0] == pytest.approx(value, rel=1e-12)
    for name, gradient in received[1].items():
        np.testing.assert_allclose(gradient, expected[name], rtol=1e-9, atol=1e-12 * np.abs(expected[name]).max())


def test_batches_take_the_spp_of_their_rows_along(rng):
    x, target = rng.normal(size=(30, 2)), rng.gamma(1.0, 0.5, (30, 1))
    loss = RelativeError(spp=rng.integers(1, 64, 30).astype(float))
    done = train(small(), x, target, loss=loss, optimizer=Adam(0.01), epochs=2, batch=7, rng=rng)
    assert np.isfinite(done.losses).all()


def test_the_best_on_validation_is_kept(rng):
    """Few noisy points and many weights: validation gets worse again, and the network from before that comes back."""
    x, y = rng.uniform(-1, 1, (16, 1)), rng.normal(size=(16, 1))
    held = rng.uniform(-1, 1, (100, 1)), np.zeros((100, 1))
    mlp = MLP.random([1, 30, 1], hidden=Tanh(), gain=3, rng=rng)
    done = train(mlp, x, y, loss=SquaredError(), optimizer=RPROP(0.01), epochs=60, validation=held)
    assert done.validation.shape == (60,)
    assert done.best == np.argmin(done.validation) < 59
    assert SquaredError().forward(done.network.forward(held[0])[0], held[1])[0] == done.validation.min()


def test_state_can_be_stored_and_training_goes_on_to_the_same_result(tmp_path):
    """Parameters and state through files after 5 of 10 steps: the same bits as 10 steps in one go."""
    x, target = moons()
    for optimizer in OPTIMIZERS:

        def run(mlp, state, steps, optimizer=optimizer):
            for _ in range(steps):
                gradients = loss_and_gradients(mlp, x, target, CrossEntropy())[1]
                parameters, state = optimizer.step(mlp.parameters, gradients, state)
                mlp = mlp.replace(parameters)
            return mlp, state

        start = optimizer.start(small().parameters)
        whole, _ = run(small(), start, 10)
        half, state = run(small(), start, 5)
        save_network(half, tmp_path / "half.npz")
        np.savez(tmp_path / "state.npz", **state)
        with np.load(tmp_path / "state.npz") as stored:
            resumed, _ = run(load_network(tmp_path / "half.npz"), dict(stored), 5)
        assert np.array_equal(whole.parameters["weight_1"], resumed.parameters["weight_1"])


# --- failure


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_rate_that_diverges_is_reported_and_the_best_network_kept(dtype, rng):
    x = 10 * rng.normal(size=(50, 2))
    target = x @ np.array([[1.0], [2.0]])
    mlp = MLP((Linear(np.zeros((1, 2), dtype), np.zeros(1, dtype)),))
    with pytest.raises(Diverged, match=r"diverged in epoch .*SGD.rate=1.0.*smaller step") as caught:
        train(mlp, x, target, loss=SquaredError(), optimizer=SGD(np.float64(1.0)), epochs=10_000)
    left = caught.value.training
    assert isinstance(caught.value, ValueError)
    assert 0 < len(left.losses) < 10
    assert np.isfinite(left.losses).all()
    y, _ = left.network.forward(x)
    assert SquaredError().forward(y, target)[0] == pytest.approx(left.losses.min(), rel=1e-6)
    assert all(np.isfinite(array).all() for array in left.network.parameters.values())
    assert train(mlp, x, target, loss=SquaredError(), optimizer=SGD(0.001), epochs=100).losses[-1] < 1


def test_a_step_to_infinity_is_found_at_once(rng):
    """One step so long that float32 overflows: no warning, no NaN, the start is what is left."""
    mlp = MLP.random([2, 4, 1], hidden=ReLU(), rng=rng, dtype=np.float32)
    x, target = rng.normal(size=(20, 2)), 1e20 * rng.normal(size=(20, 1))
    with pytest.raises(Diverged) as caught:
        train(mlp, x, target, loss=SquaredError(), optimizer=SGD(1e30), epochs=5)
    assert np.array_equal(caught.value.training.network.parameters["weight_1"], mlp.parameters["weight_1"])


def test_with_validation_the_best_is_what_is_left(rng):
    x = 10 * rng.normal(size=(50, 2))
    target = x @ np.array([[1.0], [2.0]])
    mlp = MLP.random([2, 1], rng=rng)
    with pytest.raises(Diverged) as caught:
        train(mlp, x, target, loss=SquaredError(), optimizer=SGD(1.0), epochs=100, validation=(x, target))
    left = caught.value.training
    assert len(left.validation) == len(left.losses)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"x": np.full((4, 2), np.nan)}, "x must be finite"),
        ({"target": np.full((4, 1), np.inf)}, "target must be finite"),
        ({"target": np.ones(4)}, r"x and target must be \(n, d_in\) and \(n, d_out\).*\(4, 2\) and \(4,\)"),
        ({"target": np.ones((3, 1))}, r"got \(4, 2\) and \(3, 1\)"),
        ({"x": np.ones((0, 2)), "target": np.ones((0, 1))}, "n above 0"),
        ({"x": np.ones((4, 3))}, r"Linear 2 -> 6 needs x of shape \(n, 2\)"),
        ({"batch": 2}, "pass rng as well"),
        ({"batch": 2, "optimizer": RPROP(), "rng": np.random.default_rng(0)}, "RPROP needs all rows at once"),
        ({"batch": 0}, "batch must be at least 1"),
        ({"epochs": 0}, "epochs must be at least 1"),
        ({"validation": (np.ones((4, 2)), np.full((4, 1), np.nan))}, "validation target must be finite"),
    ],
)
def test_what_training_refuses(changes, words):
    given = {
        "x": np.ones((4, 2)),
        "target": np.ones((4, 1)),
        "loss": SquaredError(),
        "optimizer": SGD(0.1),
        "epochs": 1,
    }
    with pytest.raises(ValueError, match=words):
        train(small(), **(given | changes))


def test_a_sigmoid_that_starts_saturated_learns_slowly():
    """The squared error of a saturated sigmoid is wrong and hardly has a gradient; cross-entropy has one."""
    x, target = np.ones((10, 1)), np.ones((10, 1))
    start = MLP((Linear(np.array([[-10.0]]), np.zeros(1)), Sigmoid()))
    slow = train(start, x, target, loss=SquaredError(), optimizer=SGD(0.5), epochs=20)
    fast = train(MLP(start.layers[:1]), x, target, loss=CrossEntropy(), optimizer=SGD(0.5), epochs=20)
    assert slow.losses[-1] > 0.99 * slow.losses[0]
    assert fast.losses[-1] < 0.2 * fast.losses[0]
