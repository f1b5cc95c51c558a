"""Pictures of networks: each map shows what its neuron gives, each boundary lies where the answer changes."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

import mcdenoise as mcd
from mcdenoise.study import neurons
from mcdenoise.study.neurons import COARSE, FINE, MOST, Window, decision_of, layer_outputs, window_of

pytestmark = pytest.mark.ch07

CORNERS = np.array([[0, 0], [0, 1], [1, 0], [1, 1]], float)
LABELS = np.array([0, 1, 1, 0])


def _network(*widths, hidden=None, output=None, seed=0):
    return mcd.nn.MLP.random(widths, hidden=hidden, output=output, rng=np.random.default_rng(seed))


def _maps(figure):
    return [axes.images[0] for axes in figure.axes]


def _boundary(axes):
    """The corners of all contour lines of a picture."""
    lines = [one for one in axes.collections if getattr(one, "filled", None) is False]
    return np.concatenate([path.vertices for one in lines for path in one.get_paths()]) if lines else np.zeros((0, 2))


def test_each_map_is_the_output_of_its_neuron():
    network = _network(2, 3, 2, hidden=mcd.nn.Tanh(), output=mcd.nn.Sigmoid())
    maps = _maps(mcd.show_neurons(network, CORNERS, LABELS))
    points = window_of(CORNERS).grid(COARSE)
    hidden = np.tanh(points @ network.layers[0].weight.T + network.layers[0].bias)
    values = np.hstack([hidden, network.forward(points)[0]])
    assert len(maps) == 5
    for one, expected in zip(maps, values.T, strict=True):
        np.testing.assert_allclose(one.get_array().ravel(), expected)
        assert one.origin == "lower"


def test_maps_are_not_turned_or_mirrored():
    """A neuron that looks at x_2 alone is low at the bottom; the top right corner is the largest x_1 and x_2."""
    network = mcd.nn.MLP(mcd.nn.half_planes([[0, 1, -0.75], [1, 0, -0.25]]))
    figure = mcd.show_neurons(network, CORNERS, LABELS)
    below, right = (one.get_array() for one in _maps(figure))
    assert np.all(below[0] == 0)
    assert np.all(below[-1] == 1)
    assert np.all(right[:, 0] == 0)
    assert np.all(right[:, -1] == 1)
    window = window_of(CORNERS)
    assert _maps(figure)[0].get_extent() == list(window) == [-0.15, 1.15, -0.15, 1.15]


@pytest.mark.parametrize("activation", [mcd.nn.Step, mcd.nn.Sigmoid, mcd.nn.Tanh, mcd.nn.ReLU, mcd.nn.Softplus])
def test_the_boundary_of_a_neuron_is_its_line(activation):
    """Behind every activation: where the number that goes into it is 0."""
    weight, bias = np.array([[1.5, -0.7]]), np.array([-0.3])
    network = mcd.nn.MLP((mcd.nn.Linear(weight, bias), activation()))
    corners = _boundary(mcd.show_neurons(network, CORNERS, LABELS).axes[0])
    assert len(corners) > 10
    np.testing.assert_allclose(corners @ weight[0] + bias, 0, atol=1e-9)


@pytest.mark.parametrize(
    ("activation", "limits"), [("step", (0, 1)), ("sigmoid", (0, 1)), ("tanh", (-1, 1)), ("linear", (-3, 3)), ("relu", (-3, 3))]
)  # fmt: skip
def test_white_stands_for_the_middle(activation, limits):
    assert neurons.scale_of(activation, np.array([-3.0, 0.5])) == limits


def test_a_neuron_that_is_the_same_everywhere_has_no_boundary():
    network = mcd.nn.MLP(mcd.nn.half_planes([[0, 0, 1], [0, 0, -1]]))
    figure = mcd.show_neurons(network, CORNERS, LABELS)
    assert all(len(_boundary(axes)) == 0 for axes in figure.axes)
    FigureCanvasAgg(figure).draw()  # and no warning


def test_wide_layers_wrap_and_end():
    figure = mcd.show_neurons(_network(2, 40, 1), CORNERS, LABELS, title="forty")
    assert len(figure.axes) == MOST + 1
    assert figure.axes[0].get_ylabel() == f"layer 1: sigmoid\nfirst {MOST} of 40"
    assert figure.axes[-1].get_title() == "output"
    assert figure.axes[-1].get_ylabel() == "layer 2: linear"
    assert figure.get_suptitle() == "forty"


def test_layers_are_counted_by_their_weights():
    network = _network(2, 3, 1, output=mcd.nn.Sigmoid())
    first, last = layer_outputs(network, CORNERS)
    assert (first.activation, last.activation) == ("sigmoid", "sigmoid")
    np.testing.assert_allclose(last.after, network.forward(CORNERS)[0])
    np.testing.assert_allclose(last.after, 1 / (1 + np.exp(-last.before)))


def test_all_classifiers_are_asked_the_same_question():
    weight, bias = np.array([2.0, -1.0]), -0.5
    line = mcd.nn.Perceptron(weight, bias)
    one = mcd.nn.Linear(weight[np.newaxis], np.array([bias]))
    x = np.random.default_rng(0).uniform(-2, 2, (200, 2))
    for classify in (
        line, line.classify, mcd.nn.MLP((one,)), mcd.nn.MLP((one, mcd.nn.Step())), mcd.nn.MLP((one, mcd.nn.Sigmoid())),
        lambda x: 1 / (1 + np.exp(-(x @ weight + bias))),
    ):  # fmt: skip
        np.testing.assert_array_equal(decision_of(classify)(x) >= 0, line.classify(x) == 1)


def test_on_the_line_the_answer_is_one():
    line = mcd.nn.Perceptron(np.array([1.0, 0.0]), 0.0)
    assert decision_of(line)(np.zeros((1, 2))) >= 0
    assert decision_of(line.classify)(np.zeros((1, 2))) >= 0
    assert decision_of(mcd.nn.MLP(mcd.nn.half_planes([[1, 0, 0]])))(np.zeros((1, 2))) >= 0


def test_regions_have_the_colours_of_their_classes():
    figure = mcd.show_decision(lambda x: (x[:, 0] > 0.5).astype(float), CORNERS, CORNERS[:, 0], title="right")
    FigureCanvasAgg(figure).draw()
    picture = np.asarray(figure.canvas.buffer_rgba())[..., :3] / 255
    axes = figure.axes[0]
    for at, colour in (((0.25, 0.5), neurons.REGION_COLOURS[0]), ((0.75, 0.5), neurons.REGION_COLOURS[1])):
        column, row = np.rint(axes.transData.transform(at)).astype(int)
        np.testing.assert_allclose(picture[picture.shape[0] - row, column], to_rgb(colour), atol=0.01)
    step = 1.3 / (FINE - 1)
    assert np.all(np.abs(_boundary(axes)[:, 0] - 0.5) <= step)
    assert axes.get_title() == "right"


def test_where_everything_is_on_the_line_the_answer_is_one():
    """As before the first correction of the learning rule: w = 0 and b = 0."""
    figure = mcd.show_decision(mcd.nn.Perceptron(np.zeros(2), 0.0), CORNERS, LABELS)
    FigureCanvasAgg(figure).draw()
    column, row = np.rint(figure.axes[0].transData.transform((0.5, 0.5))).astype(int)
    picture = np.asarray(figure.canvas.buffer_rgba())[..., :3] / 255
    np.testing.assert_allclose(picture[picture.shape[0] - row, column], to_rgb(neurons.REGION_COLOURS[1]), atol=0.01)


def _scattered(axes):
    """Edge and face colours of points drawn, with how many there are of each."""
    found = {}
    for one in axes.collections:
        if len(one.get_offsets()) and getattr(one, "filled", None) is None:
            face, edge = (tuple(colours[0][:3]) for colours in (one.get_facecolor(), one.get_edgecolor()))
            found[face, edge] = np.asarray(one.get_offsets())
    return found


def test_wrong_points_have_a_black_edge():
    figure = mcd.show_decision(lambda x: np.ones(len(x)), CORNERS, LABELS)
    points = _scattered(figure.axes[0])
    wrong = [offsets for (_, edge), offsets in points.items() if edge == (0, 0, 0)]
    np.testing.assert_array_equal(np.concatenate(wrong), CORNERS[LABELS == 0])
    blue, red = map(to_rgb, neurons.CLASS_COLOURS)
    assert {face for face, _ in points} == {blue, red}


def test_it_draws_into_axes_that_are_given():
    figure = Figure()
    left, right = figure.subplots(1, 2)
    assert mcd.show_decision(lambda x: x[:, 0], CORNERS, LABELS, axes=right) is figure
    assert not left.collections
    assert right.collections


def test_notebooks_can_show_the_pictures():
    for figure in (
        mcd.show_decision(lambda x: x[:, 0], CORNERS, LABELS),
        mcd.show_neurons(_network(2, 2, 1), CORNERS, LABELS),
    ):
        assert figure._repr_png_().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("x", "expected"),
    [
        (np.zeros((0, 2)), Window(-1.5, 1.5, -1.5, 1.5)),
        (np.ones((1, 2)), Window(0.35, 1.65, 0.35, 1.65)),
        (np.array([[0.0, 0.0], [2.0, 1.0]]), Window(-0.3, 2.3, -0.8, 1.8)),
    ],
)
def test_the_window_is_a_square_around_the_points(x, expected):
    assert window_of(x) == expected


def test_no_points_and_one_point_can_be_shown():
    for count in (0, 1):
        mcd.show_neurons(_network(2, 2, 1), CORNERS[:count], LABELS[:count])
        mcd.show_decision(_network(2, 2, 1), CORNERS[:count], LABELS[:count])


def test_the_inputs_stay_as_they_were():
    x, labels, network = CORNERS.copy(), LABELS.copy(), _network(2, 2, 1)
    mcd.show_neurons(network, x, labels)
    mcd.show_decision(network, x, labels)
    np.testing.assert_array_equal(x, CORNERS)
    np.testing.assert_array_equal(labels, LABELS)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: mcd.show_neurons(_network(3, 1), CORNERS, LABELS), "two inputs, got 3"),
        (lambda: mcd.show_neurons("network", CORNERS, LABELS), "MLP of two inputs, got str"),
        (lambda: mcd.show_decision(_network(3, 1), CORNERS, LABELS), "two inputs, got 3"),
        (lambda: mcd.show_decision(_network(2, 3), CORNERS, LABELS), "one output, got 3"),
        (lambda: mcd.show_decision(mcd.nn.Perceptron(np.ones(3), 0.0), CORNERS, LABELS), "two weights, got 3"),
        (lambda: mcd.show_decision(3, CORNERS, LABELS), "or a function, got int"),
        (lambda: mcd.show_decision(lambda x: x, CORNERS, LABELS), r"must return \(4,\)|must return \(58081,\)"),
        (lambda: mcd.show_decision(lambda x: x[:, 0] * np.nan, CORNERS, LABELS), "what classify returns"),
        (lambda: mcd.show_decision(lambda x: x[:, 0], CORNERS, LABELS + 1), "of 0 and 1"),
        (lambda: mcd.show_decision(lambda x: x[:, 0], CORNERS, LABELS[:3]), r"got \(4, 2\) and \(3,\)"),
        (lambda: mcd.show_decision(lambda x: x[:, 0], CORNERS[:, :1], LABELS), r"got \(4, 1\)"),
        (lambda: mcd.show_decision(lambda x: x[:, 0], CORNERS * np.nan, LABELS), "x"),
    ],
)
def test_refusals_say_what_is_needed(call, words):
    with pytest.raises(ValueError, match=words):
        call()
