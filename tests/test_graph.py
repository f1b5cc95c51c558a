"""draw_graph: the lecture's picture of a graph holds its numbers, in its places, as far as the backward pass has come."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.patches import Ellipse

import mcdenoise as mcd
from mcdenoise.nn.scalar import Scalar, backward, exp, sigmoid, walk
from mcdenoise.study.graph import GRADIENT, VALUE
from mcdenoise.study.graph_layout import END, LARGEST, Graph, _apart, _crossings, _ranks, lay_out

pytestmark = pytest.mark.ch08


def example():
    x, y, z = Scalar(-2, "x"), Scalar(5, "y"), Scalar(-4, "z")
    return (x + y) * z


def network(width=3):
    x = [Scalar(0.5, "x1"), Scalar(-1, "x2")]
    hidden = [
        sigmoid(sum((Scalar(0.1 * (k + i), f"w{k}{i}") * one for i, one in enumerate(x)), Scalar(0.1, f"b{k}")))
        for k in range(width)
    ]
    return (sum((Scalar(k - 1.5, f"v{k}") * one for k, one in enumerate(hidden)), Scalar(0.2, "c")) - 1) ** 2


def texts(figure, colour=None):
    return [one.get_text() for one in figure.axes[0].texts if one.get_text() and colour in (None, one.get_color())]


def test_the_lectures_example():
    """Values -2, 5, -4, 3, -12 above; gradients -4, -4, 3, -4, 1 below."""
    figure = mcd.draw_graph(example(), title="f = (x + y) z")
    assert sorted(texts(figure, VALUE)) == sorted(["−2", "5", "−4", "3", "−12"])
    assert sorted(texts(figure, GRADIENT)) == sorted(["−4", "−4", "3", "−4", "1"])
    assert {"x", "y", "z", "+", "×"} <= set(texts(figure))
    assert figure.get_suptitle() == "f = (x + y) z"
    assert sum(isinstance(one, Ellipse) for one in figure.axes[0].patches) == 2


def test_values_stand_above_and_gradients_below_their_edge():
    figure = mcd.draw_graph(example(), steps=1)
    (one,) = [text for text in figure.axes[0].texts if text.get_text() == "−12"]
    (other,) = [text for text in figure.axes[0].texts if text.get_text() == "1"]
    line = figure.axes[0].lines[0].get_ydata()
    assert one.get_position()[1] > line.max() >= line.min() > other.get_position()[1]


def test_steps_add_one_gradient_each():
    words = [texts(mcd.draw_graph(example(), steps=k))[-1] for k in range(6)]
    assert words[0] == "step 0: the forward pass is done, 5 steps back are to come"
    assert words[1:] == [
        "step 1: the gradient of the output itself is 1",
        "step 2: upstream 1 × local −4 = −4",
        "step 3: upstream 1 × local 3 = 3",
        "step 4: upstream −4 × local 1 = −4",
        "step 5: upstream −4 × local 1 = −4",
    ]
    for k in range(6):
        figure = mcd.draw_graph(example(), steps=k)
        widths = [line.get_linewidth() for line in figure.axes[0].lines]
        assert len(texts(figure, GRADIENT)) == max(k - 1, 0)  # the last one is emphasised
        assert sum(width > 2 for width in widths) == (k > 0)


@pytest.mark.parametrize("make", [example, network, lambda: exp(-(Scalar(1, "x") * 2)) + 1])
def test_shares_of_all_edges_add_up_to_the_gradients(make):
    output = make()
    graph, gradients = Graph(output), backward(output)
    shares = dict.fromkeys(graph.nodes, 0.0)
    for edge in graph.edges:
        shares[edge.source] += edge.local * graph.gradients[edge.target]
    for node in graph.nodes:
        assert shares[node] == pytest.approx(gradients[node])


def test_a_share_is_drawn_when_all_that_it_depends_on_has_been():
    """The walk: before an edge's turn all edges that leave its target have had theirs."""
    graph = Graph(network())
    turn = {id(edge): number for number, edge in enumerate(graph.edges)}
    for edge in graph.edges[1:]:
        assert all(turn[id(one)] < turn[id(edge)] for one in graph.edges if one.source is edge.target)


def test_a_value_that_is_used_twice_has_its_sum():
    x = Scalar(3.0, "x")
    figure = mcd.draw_graph(x * x + x)
    assert "sum 7" in texts(figure)
    assert sorted(texts(figure, GRADIENT)) == sorted(["1", "1", "3", "3", "1", "sum 7"])
    assert not any("sum" in one for one in texts(mcd.draw_graph(x * x + x, steps=4)))
    first, second = (line.get_xydata() for line in figure.axes[0].lines if len(line.get_xydata()) == 4)
    assert first[1, 1] > second[1, 1]  # the two edges of x * x are told apart


def test_numbers_stand_within_their_operation():
    x = Scalar(2.0, "x")
    shown = set(texts(mcd.draw_graph((3 * x + 1) ** 2 - 5)))
    assert {"× 3", "+ 1", "x²", "− 5"} <= shown
    assert len(Graph((3 * x + 1) ** 2 - 5).nodes) == 5
    assert set(texts(mcd.draw_graph(Scalar(2) * Scalar(3)), VALUE)) == {"2", "3", "6"}  # nothing else to stand beside


def test_layers_go_right_and_neighbours_keep_apart():
    graph = Graph(network())
    places, chains = lay_out(graph)
    for chain in chains:
        across = np.diff([places[one][0] for one in chain])
        assert np.all(across == 1)
    assert places[END][0] == max(place[0] for place in places.values())
    by_column = {}
    for x, y in places.values():
        by_column.setdefault(x, []).append(y)
    for column in by_column.values():
        assert np.all(np.diff(np.sort(column)) > 1 - 1e-9)


def test_a_tree_has_no_crossings():
    w = [Scalar(k, f"w{k}") for k in range(8)]
    s = [w[2 * k] * w[2 * k + 1] for k in range(4)]
    graph = Graph((s[0] + s[3]) * exp(s[1] + s[2]))
    places, chains = lay_out(graph)
    rows = {}
    for one, (x, y) in places.items():
        rows.setdefault(x, []).append((-y, one))
    columns = {x: [one for _, one in sorted(column, key=lambda pair: pair[0])] for x, column in rows.items()}
    assert _crossings(columns, [link for chain in chains for link in pairwise(chain)]) == 0
    assert set(_ranks(graph, chains)) == set(places)


def test_apart_is_the_nearest_in_order():
    rng = np.random.default_rng(0)
    for _ in range(20):
        wanted = rng.uniform(0, 5, 6)
        found = _apart(wanted.tolist())
        assert np.all(np.diff(found) > 1 - 1e-12)
        assert found.sum() == pytest.approx(wanted.sum())  # pools keep their mean
        for _ in range(20):
            other = np.maximum.accumulate(found - np.arange(6) + 0.05 * rng.standard_normal(6)) + np.arange(6)
            assert np.sum((other - wanted) ** 2) >= np.sum((found - wanted) ** 2) - 1e-12


def test_labels_stay_on_the_paper():
    for make in (example, network):
        figure = mcd.draw_graph(make(), steps=3, title="t")
        assert figure._repr_png_().startswith(b"\x89PNG")
        box = figure.bbox
        for text in figure.axes[0].texts:
            extent = text.get_window_extent()
            assert box.x0 - 1 <= extent.x0
            assert extent.x1 <= box.x1 + 1
            assert box.y0 - 1 <= extent.y0


def test_a_deep_graph_is_refused_in_words():
    x = Scalar(1.0, "x")
    for _ in range(LARGEST):
        x = exp(-x)
    with pytest.raises(ValueError, match=rf"up to {LARGEST} nodes, this graph has 121"):
        mcd.draw_graph(x)


@pytest.mark.parametrize(
    ("output", "steps", "words"),
    [
        (2.0, None, "needs a Scalar, the output of a graph, got float"),
        (None, 6, "from 0 to 5, the steps of this graph, got 6"),
        (None, -1, "from 0 to 5"),
        (None, 1.5, "whole number"),
        (None, True, "got True"),
    ],
)
def test_bad_input_is_refused_in_words(output, steps, words):
    with pytest.raises(ValueError, match=words):
        mcd.draw_graph(example() if output is None else output, steps=steps)


def test_an_input_alone_is_a_graph():
    figure = mcd.draw_graph(Scalar(2.5, "x"))
    assert texts(figure, VALUE) == ["2.5"]
    assert len(walk(Scalar(2.5))) == 1
