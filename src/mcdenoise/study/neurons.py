"""Pictures of networks over a plane: what each neuron gives, where it decides, and where the whole network decides."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from mcdenoise.nn.layers import Linear, Sigmoid, Step, Tanh
from mcdenoise.nn.network import MLP
from mcdenoise.nn.perceptron import Perceptron
from mcdenoise.samples.gate import check_float_array, check_nonfinite
from mcdenoise.study.show import Picture

CLASS_COLOURS = ("#4477AA", "#EE6677")  # of class 0 and class 1, told apart with any colour vision
REGION_COLOURS = ("#D3E0EE", "#FADADF")
CLASS_MARKERS = ("o", "s")
BOUNDARY = "#222222"
OUTPUTS = LinearSegmentedColormap.from_list("outputs", ("#6F9BC8", "#FFFFFF", "#F28C99"))  # low, middle, high
COLUMNS = 8  # maps side by side
MOST = 16  # maps a layer
FINE, COARSE = 241, 121  # points of the grid along each side: of a decision, of a neuron's map


class LayerOutput(NamedTuple):
    """What one layer of perceptrons makes of a batch: a `Linear` and the activation behind it."""

    activation: str
    before: np.ndarray
    after: np.ndarray


class Window(NamedTuple):
    """A rectangle of the plane, and the points of a grid on it, row by row."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """As matplotlib wants it."""
        return tuple(self)

    def sides(self, side: int) -> tuple[np.ndarray, np.ndarray]:
        """x of the columns and y of the rows of a grid of side x side points."""
        return np.linspace(self.left, self.right, side), np.linspace(self.bottom, self.top, side)

    def grid(self, side: int) -> np.ndarray:
        """The points, (side * side, 2)."""
        return np.stack([one.ravel() for one in np.meshgrid(*self.sides(side))], axis=1)


def show_neurons(network: MLP, x: object, labels: object, *, title: str = "") -> Figure:
    """Show what each neuron of a network gives: a row of maps for each layer, points and decision boundary on top.

    A neuron's boundary is where the number that goes into its activation is 0. Of a layer of more than 16 neurons the
    first 16 are shown. Blue is low and red is high: 0 to 1 behind a step or a sigmoid, -1 to 1 behind tanh; else the
    scale of each map reaches to its largest absolute value, and 0 is white.

    Parameters
    ----------
    network : takes two inputs.
    x : (n, 2), points; they also say which part of the plane is shown.
    labels : (n,), the class of each point, 0 (circles) or 1 (squares).
    title : a line above.

    Returns
    -------
    matplotlib Figure; as the last line of a notebook cell it is shown.

    Raises
    ------
    ValueError
        If the network does not take two inputs, or points and labels do not fit.

    Examples
    --------
    >>> import mcdenoise as mcd
    >>> corners, labels = [[0, 0], [0, 1], [1, 0], [1, 1]], [0, 1, 1, 0]
    >>> network = mcd.nn.MLP.random([2, 3, 1], output=mcd.nn.Sigmoid(), rng=np.random.default_rng(0))
    >>> figure = mcd.show_neurons(network, corners, labels)
    >>> [axes.get_title() for axes in figure.axes]
    ['neuron 1', 'neuron 2', 'neuron 3', 'output']
    """
    x, labels = check_points(x, labels)
    _check_network(network)
    window = window_of(x)
    layers = layer_outputs(network, window.grid(COARSE))
    rows = [min(layer.after.shape[1], MOST) for layer in layers]
    columns = min(max(*rows, 3), COLUMNS)
    bands = [-(-count // columns) for count in rows]
    figure = Picture(
        figsize=(max(1.22 * columns, 4.6), 1.4 * sum(bands) + (0.4 if title else 0.1)), layout="constrained"
    )
    if title:
        figure.suptitle(title, fontsize=11)
    grid = figure.add_gridspec(sum(bands), columns)
    for number, layer in enumerate(layers):
        start, last = sum(bands[:number]), number == len(layers) - 1
        for k in range(rows[number]):
            axes = figure.add_subplot(grid[start + k // columns, k % columns])
            draw_neuron(axes, layer, k, window)
            draw_points(axes, x, labels, size=4)
            alone = last and rows[number] == 1
            axes.set_title("output" if alone else f"neuron {k + 1}", fontsize=9, pad=3)
            if k == 0:
                axes.set_ylabel(_row_label(number, layer), fontsize=9)
    return figure


def show_decision(
    classify: MLP | Perceptron | Callable, x: object, labels: object, *, title: str = "", axes: Axes | None = None
) -> Figure:
    """Show how a classifier divides the plane: the region of each class, the decision boundary, and the points.

    Points on the wrong side have a black edge.

    Parameters
    ----------
    classify : an `MLP` of two inputs and one output, which answers 1 where what its last `Linear` gives is at least 0;
        a `Perceptron`; or a function (n, 2) -> (n,) of classes or probabilities, which answers 1 from 0.5 on.
    x : (n, 2), points; they also say which part of the plane is shown.
    labels : (n,), the class of each point, 0 (blue circles) or 1 (red squares).
    title : a line above.
    axes : where to draw; None: in a figure of its own.

    Returns
    -------
    matplotlib Figure; as the last line of a notebook cell it is shown.

    Raises
    ------
    ValueError
        If the classifier does not fit points of the plane or gives anything but a finite number for each, or points
        and labels do not fit.

    Examples
    --------
    >>> import mcdenoise as mcd
    >>> right = mcd.nn.Perceptron(weight=np.array([1.0, 0.0]), bias=-0.5)
    >>> figure = mcd.show_decision(right, [[0, 0], [1, 0]], [0, 1], title="right of a half")
    >>> figure.axes[0].get_title()
    'right of a half'
    """
    x, labels = check_points(x, labels)
    level = decision_of(classify)
    if axes is None:
        axes = Picture(figsize=(4.4, 4.2), layout="constrained").subplots()
    window = window_of(x)
    draw_regions(axes, level, window)
    draw_points(axes, x, labels, wrong=(level(x) >= 0) != labels)
    axes.set_title(title, fontsize=10)
    return axes.figure


def decision_of(classify: MLP | Perceptron | Callable) -> Callable[[np.ndarray], np.ndarray]:
    """The function (n, 2) -> (n,) that is at least 0 where a classifier answers 1.

    Examples
    --------
    >>> decision_of(lambda x: x[:, 0])(np.array([[0.75, 0.0]]))
    array([0.25])
    """
    if isinstance(classify, MLP):
        _check_network(classify)
        outputs = classify.layers[-1 - _behind(classify)].weight.shape[0]
        if outputs != 1:
            raise ValueError(f"show_decision needs a network of one output, got {outputs}.")
        return lambda x: layer_outputs(classify, x)[-1].before[:, 0]
    if isinstance(classify, Perceptron):
        if len(classify.weight) != 2:
            raise ValueError(f"show_decision needs a Perceptron of two weights, got {len(classify.weight)}.")
        return lambda x: x @ classify.weight + classify.bias
    if not callable(classify):
        raise ValueError(
            f"show_decision needs an MLP, a Perceptron or a function, got {type(classify).__name__}. "
            "Pass perceptron.classify or the like."
        )

    def level(x: np.ndarray) -> np.ndarray:
        values = check_float_array(classify(x), "what classify returns").astype(np.float64)
        if values.shape != (len(x),):
            raise ValueError(f"classify must return ({len(x)},) for ({len(x)}, 2) points, got {values.shape}.")
        return check_nonfinite(values, "what classify returns") - 0.5

    return level


def layer_outputs(network: MLP, x: np.ndarray) -> list[LayerOutput]:
    """What each `Linear` of a network makes of a batch, before and after the activation behind it.

    Examples
    --------
    >>> from mcdenoise.nn import half_planes
    >>> (layer,) = layer_outputs(MLP(half_planes([[1, 0, -2]])), np.array([[5.0, 0.0]]))
    >>> layer.activation, layer.before, layer.after
    ('step', array([[3.]]), array([[1.]]))
    """
    found, y = [], x.astype(network.dtype, copy=False)
    for layer in network.layers:
        y = layer.forward(y)[0]
        if isinstance(layer, Linear):
            found.append(LayerOutput("linear", y, y))
        elif found:
            found[-1] = LayerOutput(type(layer).__name__.lower(), found[-1].before, y)
    return found


def draw_neuron(axes: Axes, layer: LayerOutput, k: int, window: Window) -> None:
    """Draw the output of neuron k of a layer over a grid as a map, and its decision boundary."""
    side = round(np.sqrt(len(layer.after)))
    values = layer.after[:, k].reshape(side, side)
    low, high = scale_of(layer.activation, values)
    axes.imshow(
        values, cmap=OUTPUTS, vmin=low, vmax=high, origin="lower", extent=window.extent, interpolation="bilinear"
    )
    draw_boundary(axes, layer.before[:, k].reshape(side, side), window)
    axes.set(xticks=[], yticks=[])


def scale_of(activation: str, values: np.ndarray) -> tuple[float, float]:
    """The lowest and the highest value of the colours of a map.

    Examples
    --------
    >>> scale_of("sigmoid", np.array([0.2])), scale_of("relu", np.array([0.0, 3.0]))
    ((0.0, 1.0), (-3.0, 3.0))
    """
    if activation in (Step.__name__.lower(), Sigmoid.__name__.lower()):
        return 0.0, 1.0
    largest = 1.0 if activation == Tanh.__name__.lower() else float(np.abs(values).max()) or 1.0
    return -largest, largest


def draw_regions(axes: Axes, level: Callable[[np.ndarray], np.ndarray], window: Window) -> None:
    """Fill where `level` is below 0 and where it is at least 0 with the colours of the classes; draw the boundary."""
    values = _zero_is_one(level(window.grid(FINE)).reshape(FINE, FINE))
    far = 1 + np.abs(values).max()
    axes.contourf(*window.sides(FINE), values, levels=(-far, 0, far), colors=REGION_COLOURS)
    draw_boundary(axes, values, window)
    axes.set(aspect="equal", xlim=window[:2], ylim=window[2:], xlabel="$x_1$", ylabel="$x_2$")


def draw_boundary(axes: Axes, values: np.ndarray, window: Window) -> None:
    """Draw the line where values over a grid pass through 0; nothing if they never do."""
    if values.min() < 0 <= values.max():
        axes.contour(
            *window.sides(len(values)),
            _zero_is_one(values),
            levels=(0,),
            colors=BOUNDARY,
            linewidths=1.4,
            linestyles="solid",
        )


def _zero_is_one(values: np.ndarray) -> np.ndarray:
    """Move 0 a trifle up, to the side of the 1: a contour belongs to neither of its sides, an answer does."""
    return np.where(values == 0, np.finfo(np.float64).tiny, values)


def draw_points(
    axes: Axes, x: np.ndarray, labels: np.ndarray, *, size: float = 20, wrong: np.ndarray | None = None
) -> None:
    """Draw points in the colour and with the marker of their class; those that are `wrong` with a black edge."""
    wrong = np.zeros(len(x), bool) if wrong is None else wrong
    for k, (colour, marker) in enumerate(zip(CLASS_COLOURS, CLASS_MARKERS, strict=True)):
        for edge, width, chosen in (("white", 0.4, ~wrong), ("black", 1.3, wrong)):
            of = x[(labels == k) & chosen]
            if len(of):
                axes.scatter(*of.T, size, color=colour, marker=marker, edgecolors=edge, linewidths=width, zorder=3)


def window_of(x: np.ndarray) -> Window:
    """The square around points, with a margin.

    Examples
    --------
    >>> window_of(np.array([[0.0, 0.0], [1.0, 2.0]]))
    Window(left=-0.8, right=1.8, bottom=-0.3, top=2.3)
    """
    if not len(x):
        return Window(-1.5, 1.5, -1.5, 1.5)
    low, high = x.min(axis=0), x.max(axis=0)
    centre, half = (low + high) / 2, 0.65 * (float((high - low).max()) or 1.0)
    return Window(*(float(round(c + s * half, 9)) for c in centre for s in (-1, 1)))


def check_points(x: object, labels: object) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 2) as float64 and their classes (n,) as whole numbers.

    Examples
    --------
    >>> check_points([[0, 1]], [1])
    (array([[0., 1.]]), array([1]))
    """
    x = check_nonfinite(check_float_array(x, "x").astype(np.float64), "x")
    labels = check_float_array(labels, "labels")
    if x.ndim != 2 or x.shape[1] != 2 or labels.shape != x.shape[:1] or not np.isin(labels, (0, 1)).all():
        raise ValueError(f"x must be (n, 2) and labels (n,) of 0 and 1, got {x.shape} and {labels.shape}.")
    return x, labels.astype(int)


def _check_network(network: MLP) -> None:
    """Refuse what is no network over the plane."""
    if not isinstance(network, MLP) or network.inputs != 2:
        raise ValueError(
            f"A map needs an MLP of two inputs, got {network.inputs if isinstance(network, MLP) else type(network).__name__}."
        )


def _behind(network: MLP) -> int:
    """How many layers stand behind the last `Linear`."""
    return next(k for k, layer in enumerate(reversed(network.layers)) if isinstance(layer, Linear))


def _row_label(number: int, layer: LayerOutput) -> str:
    """What stands at the left of a row of maps."""
    count = layer.after.shape[1]
    return f"layer {number + 1}: {layer.activation}" + (f"\nfirst {MOST} of {count}" if count > MOST else "")
