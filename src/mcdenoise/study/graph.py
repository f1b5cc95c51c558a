"""Chapter 08: a computational graph as the lecture draws it, values above the edges and gradients below.

`graph_layout` makes a graph of nodes and edges and gives them places; here they are put on paper.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from matplotlib.patheffects import withStroke

from mcdenoise.nn.scalar import Scalar
from mcdenoise.study.graph_layout import END, Edge, Graph, lay_out, number_text
from mcdenoise.study.show import Picture

VALUE, GRADIENT, LINE, EMPHASIS = "#228833", "#AA3377", "#777777", "#EE7733"
WIDTH = 9.4  # inches, of the widest picture
GAP, ROW = 1.8, 0.92  # inches between layers (at most), and between neighbours in a layer
EDGE = 0.2  # inches of margin
HEIGHT, BOW = 0.42, 0.28  # inches: of a node, and by which the edges of x * x bow


def draw_graph(output: Scalar, *, steps: int | None = None, title: str = "") -> Figure:
    """Draw the graph that a scalar was made by: values above the edges, gradients below.

    Ellipses are operations, names on the left are inputs. A number without a label that is used once, beside something
    else, stands within its operation, as in "+ 1". Each edge has its own share of the gradient: that of the operation it
    goes to, times the local gradient. Where a value is used more than once, the sum of its shares stands below it.

    Parameters
    ----------
    output : the end of the graph, of up to 60 nodes; readable up to about 25.
    steps : how far the backward pass has come. 0: values alone; 1: the output's own gradient, 1; k: k edges in the order
        of the backward pass, the last one emphasised and its product written out; None: all edges.
    title : a line above.

    Returns
    -------
    matplotlib Figure; as the last line of a notebook cell it is shown.

    Raises
    ------
    ValueError
        If `output` is no `Scalar`, if the graph is too large, or if it has fewer than `steps` steps.

    References
    ----------
    Lecture, "Back propagation: a simple example".

    Examples
    --------
    >>> x, y, z = Scalar(-2, "x"), Scalar(5, "y"), Scalar(-4, "z")
    >>> figure = draw_graph((x + y) * z, steps=2)
    >>> figure.axes[0].texts[-1].get_text()
    'step 2: upstream 1 × local −4 = −4'
    """
    if not isinstance(output, Scalar):
        raise ValueError(f"draw_graph needs a Scalar, the output of a graph, got {type(output).__name__}.")
    graph = Graph(output)
    last = len(graph.edges)
    whole = isinstance(steps, int | np.integer) and not isinstance(steps, bool)
    if steps is not None and not (whole and 0 <= steps <= last):
        raise ValueError(
            f"steps must be None or a whole number from 0 to {last}, the steps of this graph, got {steps!r}."
        )
    return _Drawing(graph, last if steps is None else int(steps), steps is not None, title).figure


class _Drawing:
    """A graph on paper, its backward pass done up to a step. All lengths are inches."""

    def __init__(self, graph: Graph, steps: int, emphasised: bool, title: str) -> None:
        self.graph, self.steps = graph, steps
        places, chains = lay_out(graph)
        columns = max(place[0] for place in places.values())
        gap = min(GAP, (WIDTH - 0.9) / columns)
        self.font = 10.5 if gap > 1.2 else 8.5 if gap > 0.85 else 7.0
        self.places = {one: place * (gap, ROW) for one, place in places.items()}
        self._paper(title, emphasised)
        for number, chain in enumerate(chains, 1):
            self._edge(number, np.array([self.places[one] for one in chain]), emphasised and number == steps)
        for node in graph.nodes:
            self._node(node, self.places[node])
        if emphasised:
            self._words()

    def _paper(self, title: str, emphasised: bool) -> None:
        """A figure of the graph's size, with room for a title above and words below."""
        corners = np.array(list(self.places.values()))
        names = [self.graph.text(one) for one in self.graph.nodes if not one.parents]
        sums = [f"sum {number_text(self.graph.gradients[one])}" for one in self.graph.nodes if self._uses(one) > 1]
        left = max(self._size(text)[0] for text in (*names, *sums)) + EDGE
        low, high = corners.min(axis=0) - np.array([left, 0.5]), corners.max(axis=0) + np.array([EDGE, 0.45])
        size = np.maximum(high - low, (3.6, 1.2))
        above, below = 0.3 * bool(title), 0.3 * emphasised
        height = size[1] + above + below
        self.figure = Picture(figsize=(size[0], height))
        self.axes = self.figure.add_axes((0, below / height, 1, size[1] / height))
        self.axes.set(xlim=(low[0], low[0] + size[0]), ylim=(high[1] - size[1], high[1]))
        self.axes.axis("off")
        if title:
            self.figure.suptitle(title, fontsize=11, y=1 - 0.08 / height, va="top")

    def _edge(self, number: int, way: np.ndarray, strong: bool) -> None:
        """A line with the value above it and, if the backward pass has come so far, the gradient below."""
        edge = self.graph.edges[number - 1]
        twins = [k for k, one in enumerate(self.graph.edges, 1) if one[:2] == edge[:2]]
        if len(twins) > 1:  # a value times itself: the edges bow away from each other
            bow = BOW * (1 - 2 * twins.index(number) / (len(twins) - 1))
            way = np.array([way[0], way[0] + np.array([0.25, bow]), way[-1] + np.array([-0.25, bow]), way[-1]])
        colour, width = (EMPHASIS, 2.6) if strong else (LINE, 1.1)
        self.axes.plot(*way.T, color=colour, linewidth=width, zorder=1, solid_joinstyle="round")
        gradient = self.graph.gradients[edge.target] * edge.local
        texts = [(1, number_text(edge.source.value), VALUE)]
        if number <= self.steps:
            texts.append((-1, number_text(gradient), EMPHASIS if strong else GRADIENT))
        place, (right, up) = self._spot(edge, way, len(twins) > 1)
        for side, text, shade in texts:
            across, high = self._size(text)
            away = side * (across / 2 * abs(up) + high / 2 * right + 0.02)
            self._write(place + away * np.array([-up, right]), text, shade, strong and side < 0)

    def _spot(self, edge: Edge, way: np.ndarray, bowed: bool) -> tuple[np.ndarray, np.ndarray]:
        """Where on an edge its numbers stand, and the direction there.

        A value that is used once has its first stretch to itself; else the numbers go nearer to the target.
        """
        if bowed:
            return (way[1] + way[2]) / 2, np.array([1.0, 0.0])
        once = self._uses(edge.source) == 1
        start, end = (way[0], way[1]) if once else (way[-2], way[-1])
        along = (end - start) / np.hypot(*(end - start))
        rims = (
            self._rim(edge.source) if once or len(way) == 2 else 0.0,
            self._rim(edge.target) if len(way) == 2 else 0.0,
        )
        share = 0.5 if edge.target is END else 0.34 if once else 0.62
        return start + along * (rims[0] + share * (np.hypot(*(end - start)) - sum(rims))), along

    def _uses(self, node: Scalar) -> int:
        """How many edges leave a node."""
        return sum(edge.source is node for edge in self.graph.edges)

    def _rim(self, node: Scalar | str) -> float:
        """From the middle of a node to its side."""
        if node is END or not node.parents:
            return 0.0
        return max(HEIGHT, self._size(self.graph.text(node))[0] + 0.12) / 2

    def _size(self, text: str) -> tuple[float, float]:
        """About the width and height of a text."""
        return 0.62 * self.font / 72 * len(text), 1.25 * self.font / 72

    def _node(self, node: Scalar, place: np.ndarray) -> None:
        """An ellipse with its operation, or the name of an input; below it the sum of its shares."""
        text, line = self.graph.text(node), self._size("")[1]
        if node.parents:
            ellipse = Ellipse(place, 2 * self._rim(node), HEIGHT, facecolor="white", edgecolor="#222222", linewidth=1.2)
            self.axes.add_patch(ellipse).set_zorder(3)
            self._write(place, text, "#222222")
            self._write(place + np.array([0, HEIGHT / 2 + line / 2]), node.label, "#222222")
        else:
            self._write(place - np.array([0.06, 0]), text, "#222222", where="right")
        shares = [number for number, edge in enumerate(self.graph.edges, 1) if edge.source is node]
        if len(shares) > 1 and max(shares) <= self.steps:
            total = f"sum {number_text(self.graph.gradients[node])}"
            below = place - np.array([0, HEIGHT / 2 + line / 2] if node.parents else [0.06, line])
            self._write(below, total, GRADIENT, True, "center" if node.parents else "right")

    def _write(self, place: np.ndarray, text: str, colour: str, bold: bool = False, where: str = "center") -> None:
        """Text with a white rim."""
        self.axes.text(
            *place, text, ha=where, va="center", fontsize=self.font, color=colour, zorder=5,
            fontweight="bold" if bold else "normal", path_effects=[withStroke(linewidth=2.5, foreground="white")],
        )  # fmt: skip

    def _words(self) -> None:
        """The product of the last step, below the graph."""
        words = f"step 0: the forward pass is done, {len(self.graph.edges)} steps back are to come"
        if self.steps == 1:
            words = "step 1: the gradient of the output itself is 1"
        if self.steps > 1:
            edge = self.graph.edges[self.steps - 1]
            upstream = self.graph.gradients[edge.target]
            factors = f"upstream {number_text(upstream)} × local {number_text(edge.local)}"
            words = f"step {self.steps}: {factors} = {number_text(upstream * edge.local)}"
        colour = EMPHASIS if self.steps else "#222222"
        self.axes.text(0.5, 0, words, transform=self.axes.transAxes, ha="center", va="top", fontsize=10.5, color=colour)
