"""The figures of chapter 08: what they claim holds, and what is stored is what the page shows."""

import numpy as np
import pytest

from mcdenoise.nn import MLP, RPROP, ReLU, SquaredError, train
from mcdenoise.nn.gradcheck import STEP
from mcdenoise.study.figures import _ch08_checks as checks
from mcdenoise.study.figures import _ch08_depth as deep
from mcdenoise.study.figures import _ch08_graphs as graphs
from mcdenoise.study.figures import _ch08_losses as losses
from mcdenoise.study.figures import _ch08_matrices as matrices
from mcdenoise.study.figures import _ch08_training as training
from mcdenoise.study.figures.__main__ import rounded
from mcdenoise.study.figures.ch08 import FIGURES
from stored_figures import (
    assert_quoted_numbers_exist,
    assert_same_numbers,
    assert_stored_shown_and_small,
    stored_numbers,
)

pytestmark = pytest.mark.ch08

STORED = stored_numbers("ch08")
CHEAP = (
    "patterns", "neuron", "twice", "jacobians", "never_built", "batch_shapes", "two_layer", "losses", "relative",
    "saturation", "kinks", "faults",
)  # fmt: skip


@pytest.mark.parametrize("name", CHEAP)
def test_stored_numbers_are_those_of_the_code(name):
    assert_same_numbers(rounded(FIGURES[name]()[1], name), STORED[name])


def test_every_figure_is_stored_shown_and_small():
    assert_stored_shown_and_small("ch08", FIGURES)


def test_the_page_quotes_numbers_that_exist():
    assert_quoted_numbers_exist("ch08", at_least=80)


def test_the_simple_example_is_the_lectures():
    x, y, z = -2, 5, -4
    assert STORED["slider_steps"]["value"]["f"] == (x + y) * z
    assert STORED["slider_steps"]["gradient"] == {"x": z, "y": z, "z": x + y, "q": z, "f": 1}
    f, named = graphs.simple_example()
    assert {name: one.value for name, one in named.items()} == STORED["slider_steps"]["value"]
    assert f is named["f"]


def test_patterns_and_the_neuron():
    of = STORED["patterns"]
    assert (of["x"], of["y"], of["z"], of["w"]) == (3 * -3, 3 * 2, 3, 0)
    of = STORED["neuron"]
    s = 1 / (1 + np.exp(-(2 * -1 + -3 * -2 - 3)))
    assert of["s"] == pytest.approx(s, rel=1e-3)
    assert of["d_a"] == of["short"] == of["d_b"] == pytest.approx(s * (1 - s), rel=1e-3)
    assert of["d_w2"] == pytest.approx(-2 * s * (1 - s), rel=1e-3)
    assert STORED["twice"]["shares"] == [2 * (1 - 2) * 1, 2 * (3 - 5) * 3]
    assert STORED["twice"]["sum"] == sum(STORED["twice"]["shares"])


def test_jacobians_are_what_the_page_says():
    of = STORED["jacobians"]
    assert of["linear_is_weight"]
    assert of["same"]
    assert of["off_diagonal"] == 0 < of["largest_slope"] <= 0.25
    network, x = matrices.example_layers()
    assert of["live"] == np.sum(network.layers[0].forward(x[np.newaxis])[0] > 0)


def test_numbers_in_jacobians_by_arithmetic():
    n, found = matrices.ROW, matrices.numbers_needed(matrices.ROW, matrices.WIDTHS)
    assert found["whole"] == [n**2 * 360, n**2 * 100, n**2 * 60]
    assert found["saved"] == [n * 36, n * 10, n * 10]
    assert STORED["never_built"]["whole_terabytes"] == pytest.approx(8 * n**2 * 520 / 1e12, rel=1e-3)
    assert STORED["never_built"]["multiplications_forward_backward"] == n * (2 * 420 + 60)
    assert STORED["two_layer"]["parameters"] == 36 * 10 + 10 + 10 * 6 + 6


def test_the_relative_error_listens_to_the_dark():
    of = STORED["relative"]
    assert of["dark"] == pytest.approx(0.01 / (1e-6 + 0.01), rel=1e-3)
    assert of["bright"] == pytest.approx(0.01 / (100 + 0.01), rel=1e-3)
    assert of["share_peak"] == pytest.approx(0.1 * 0.1 / (2 * 0.01), rel=1e-3)  # the maximum of c / (c^2 + epsilon)
    assert max(of["share_bright"], of["share_dark"]) < of["share_peak"]


def test_curves_of_losses_have_the_slopes_that_are_drawn():
    y = np.linspace(-1, 1, 201)
    for loss, target in ((losses.SquaredError(), 0.5), (losses.CrossEntropy(), 1.0), (losses.RelativeError(), 0.1)):
        values, slopes = losses.curve(loss, y, target)
        np.testing.assert_allclose(np.gradient(values, y)[1:-1], slopes[1:-1], atol=2e-3 * np.abs(slopes).max())


def test_cross_entropy_does_not_vanish_and_does_not_overflow():
    of = STORED["saturation"]
    p = 1 / (1 + np.exp(10))
    assert of["entropy"] == pytest.approx(1 - p, rel=1e-3)
    assert of["squared"] == pytest.approx((1 - p) ** 2 * p, rel=1e-3)
    assert of["naive_is_nan"]
    assert (of["sigmoid"], of["softplus"], of["loss_at_end"]) == ([1, 0], [1e4, 0], 1e4)
    assert of["lost_below"] == pytest.approx(-np.log(np.finfo(np.float32).max), abs=1)


def test_differences_err_by_curvature_and_by_rounding():
    of = STORED["step"]
    assert of["power"] == pytest.approx(2, abs=0.05)
    assert of["central_float64"]["best"] < 1e-9 < 1e-8 < of["forward_float64"]["best"]
    assert of["central_float32"]["best"] > 1e-5
    for step, dtype, central in ((1e-2, np.float64, True), (STEP, np.float64, True), (1e-6, np.float64, False)):
        error = checks.relative_error(*checks.numerical(step, dtype, central))
        assert error >= of["central_float64" if central else "forward_float64"]["best"]
        assert error < {1e-2: 1e-4, STEP: 1e-8, 1e-6: 1e-5}[step]


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("wrong sign", "sign"),
        ("mean in place of sum", "mean in place of"),
        ("transposed", "transpose"),
        ("local gradient forgotten", "relative error"),
        ("upstream gradient forgotten", "does not depend on d_y"),
    ],
)
def test_each_fault_is_found_and_named(fault, words):
    message = checks.message_of(checks.FAULTS[fault])
    assert "gradient of weight" in message
    assert words in message
    assert message == STORED["faults"][fault.replace(" ", "_")]


def test_a_kink_is_half():
    assert STORED["kinks"]["at_kink"] == 0.5
    assert "kink" in STORED["kinks"]["message"]
    assert STORED["kinks"]["share_near"] == pytest.approx(2 * STEP / np.sqrt(2 * np.pi), rel=0.3)


def test_optimizers_are_told_apart():
    of = STORED["optimizers"]
    assert of["rprop"]["reached"] < of["momentum"]["reached"] < of["sgd"]["reached"] < of["adam"]["reached"]
    assert 10 * of["rprop"]["last"] < of["adam"]["last"] < of["momentum"]["last"] < of["sgd"]["last"]
    assert of["sgd"]["worst_rise"] < 1 < 10 < of["momentum"]["worst_rise"]
    losses_of = train(*training.problem(), loss=SquaredError(), optimizer=RPROP(), epochs=of["rprop"]["reached"]).losses
    assert losses_of[-1] < 0.005 <= losses_of[:-1].min()


def test_the_loop_is_train():
    """slider_curve writes the training loop out: the same network, bit by bit."""
    (network,) = training.on_the_way((30,)).values()
    other = train(*training.problem(), loss=SquaredError(), optimizer=RPROP(), epochs=30).network
    for name, array in network.parameters.items():
        np.testing.assert_array_equal(array, other.parameters[name])
    assert STORED["slider_curve"]["losses"] == sorted(STORED["slider_curve"]["losses"], reverse=True)


def test_paths_on_the_bowl():
    steps = training.FRAMES
    for name, places in training.paths(steps[-1]).items():
        found = np.hypot(*places.T)[list(steps)]
        np.testing.assert_allclose(found, STORED["slider_bowl"]["distance"][training._key(name)], rtol=1e-3)
    plain = training.paths(40)["SGD, rate 1.8"]
    k = np.arange(41)[:, np.newaxis]
    np.testing.assert_allclose(plain, training.START * (1 - 1.8 * training.BOWL) ** k, atol=1e-12)


def test_a_rate_too_far_runs_away():
    of = STORED["rates"]
    assert of["best_rate"] < of["first_diverged"] < 4 * of["best_rate"]
    assert of["best"] < of["tenth"] < of["hundredth"] < of["start"] < of["last_kept"]
    assert of["finite"]
    assert of["message"].startswith("Training diverged in epoch 7")
    assert training.loss_at_rate(2 * of["first_diverged"], epochs=20)[1]
    assert not training.loss_at_rate(of["best_rate"], epochs=20)[1]


def test_gradients_over_depth():
    of = STORED["depth"]
    for gain in ("0.5", "1", "2"):
        assert of["sigmoid"][gain]["factor"] < float(gain) / 4 + 0.01  # slope at most 1/4
        assert of["tanh"][gain]["factor"] <= float(gain)
        assert of["ReLU"][gain]["factor"] == pytest.approx(float(gain) / np.sqrt(2), rel=0.03)
    assert of["ReLU"]["root"]["factor"] == pytest.approx(1, abs=0.03)
    assert of["tanh"]["2"]["norms"][-1] > 10 * of["tanh"]["2"]["norms"][0]
    assert deep.first_gradient(8, ReLU(), 1.0) == pytest.approx(of["ReLU"]["1"]["norms"][4], rel=1e-3)


def test_dead_units():
    of = STORED["dead"]
    assert of["by_bias"] == sorted(of["by_bias"], reverse=True)
    assert of["by_bias"][of["bias"].index(0)] == 0 == of["diverged"]
    assert max(of["shares"][:6]) == 0 < 0.9 < of["shares"][7]
    assert of["losses"][7] > 5 * of["losses"][5]
    share, loss, gone = deep.after_training(1.0, 0)
    assert (share > 0.9, loss > 0.05, gone) == (True, True, False)


def test_float32_is_enough_for_training():
    of = STORED["precision"]
    assert max(of["by_depth"]) < 10 * of["eps"]
    assert of["by_loss"][-1] > 50 * of["by_loss"][0]
    assert of["sizes"][-1] < 0.01 * of["sizes"][0]
    rng = np.random.default_rng(0)
    network = MLP.random([deep.ACROSS, 8, 1], rng=rng)
    found = deep.gradients_in(np.float32, network, rng.standard_normal((10, deep.ACROSS)), np.ones((10, 1)))
    assert found.dtype == np.float32
