"""Where the nodes of a computational graph stand when it is drawn: in layers from the inputs to the output, few crossings.

`Graph` is what is drawn, `lay_out` says where.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mcdenoise.nn.scalar import Scalar, backward, walk

LARGEST = 60  # nodes
SWEEPS = 12
SIGNS = {"*": "×", "^-1": "1/x", "^2": "x²", "^0.5": "√x"}
END = "end"  # the key of the place where the output's edge ends


class Edge(NamedTuple):
    """One use of a value: by the operation `target`, or as the output of the graph."""

    source: Scalar
    target: Scalar | str
    local: float


class Graph:
    """What is drawn: nodes, edges in the order of the backward pass, numbers within operations, gradients."""

    def __init__(self, output: Scalar) -> None:
        order = walk(output)
        uses = dict.fromkeys(order, 0)
        for parent in (parent for one in order for parent in one.parents):
            uses[parent] += 1
        numbers: set[Scalar] = set()
        for one in reversed(order):
            if not one.label and uses[one] == 1 and numbers.issuperset(one.parents):
                numbers.add(one)
        inner = {one: [parent for parent in one.parents if parent in numbers] for one in order}
        self.inside = {one: found[0] for one, found in inner.items() if len(found) == 1 and len(one.parents) == 2}
        hidden = {one for number in self.inside.values() for one in walk(number)}
        self.nodes = [one for one in reversed(order) if one not in hidden]  # each after its parents
        self.drawn = set(self.nodes)
        if len(self.nodes) > LARGEST:
            raise ValueError(
                f"draw_graph draws up to {LARGEST} nodes, this graph has {len(self.nodes)}. Draw a part of it."
            )
        self.edges = [Edge(output, END, 1.0)] + [
            Edge(parent, one, local)
            for one in order
            if one not in hidden
            for parent, local in zip(one.parents, one.local, strict=True)
            if parent not in hidden
        ]
        self.gradients = {**backward(output), END: 1.0}

    def text(self, node: Scalar) -> str:
        """What stands in a node."""
        if not node.parents:
            return node.label or number_text(node.value)
        sign = SIGNS.get(node.operation, node.operation)
        if node not in self.inside:
            return sign
        value = self.inside[node].value
        return f"− {number_text(-value)}" if sign == "+" and value < 0 else f"{sign} {number_text(value)}"


def number_text(value: float) -> str:
    """A number with up to three digits, and a true minus."""
    return f"{value:.3g}".replace("-", "−")


def layers(graph: Graph) -> dict:
    """The layer of each node: its longest way from an input; an input that is needed late starts later."""
    layer: dict = {}
    for node in graph.nodes:
        layer[node] = 1 + max((layer[parent] for parent in node.parents if parent in layer), default=-1)
    for node in graph.nodes:
        used = [layer[edge.target] for edge in graph.edges if edge.source is node and edge.target is not END]
        if not node.parents and used:
            layer[node] = max(min(used) - 2, 0)
    return {**layer, END: max(layer.values()) + 1}


def _chains(graph: Graph, layer: dict) -> list[list]:
    """For each edge its source, a stop in each layer on the way (which gets an entry in `layer`), its target."""
    chains = []
    for number, edge in enumerate(graph.edges):
        stops = [(number, k) for k in range(layer[edge.source] + 1, layer[edge.target])]
        layer |= {stop: stop[1] for stop in stops}
        chains.append([edge.source, *stops, edge.target])
    return chains


def lay_out(graph: Graph) -> tuple[dict, list[list]]:
    """The place (column, row upwards) of each node and stop, and the chain of places of each edge."""
    layer = layers(graph)
    chains = _chains(graph, layer)
    links = [link for chain in chains for link in pairwise(chain)]
    near: dict = {one: [] for one in layer}
    for left, right in links:
        near[left].append(right)
        near[right].append(left)
    rank = _ranks(graph, chains)
    columns = {k: sorted((one for one in layer if layer[one] == k), key=rank.get) for k in sorted(set(layer.values()))}
    best, fewest = columns, _crossings(columns, links)
    for _ in range(SWEEPS):  # forth and back: by the mean place of the neighbours that have been placed last
        for forth in (True, False):
            columns = _sweep(columns, near, layer, forth)
            crossings = _crossings(columns, links)
            if crossings < fewest:
                best, fewest = columns, crossings
    y = {one: float(row) for column in best.values() for row, one in enumerate(column)}
    for _ in range(4 * SWEEPS):
        for column in best.values():
            wanted = [float(np.mean([y[other] for other in near[one]])) for one in column]
            y |= dict(zip(column, _apart(wanted), strict=True))
    return {one: np.array([layer[one], -y[one]]) for one in layer}, chains


def _ranks(graph: Graph, chains: list[list]) -> dict:
    """An order to start from: branch by branch from the output, as a tree is drawn; stops go with their source."""
    rank: dict = {END: -1}
    waiting = [graph.edges[0].source]
    while waiting:
        node = waiting.pop()
        if node not in rank:
            rank[node] = len(rank)
            waiting += [parent for parent in reversed(node.parents) if parent in graph.drawn]
    return rank | {stop: rank[chain[0]] for chain in chains for stop in chain[1:-1]}


def _sweep(columns: dict, near: dict, layer: dict, forth: bool) -> dict:
    """Order each column by the mean row of the neighbours on the side that the sweep comes from."""
    done = {k: list(column) for k, column in columns.items()}
    row = {one: number - len(column) / 2 for column in columns.values() for number, one in enumerate(column)}
    for k in sorted(done, reverse=not forth):
        mean = {}
        for one in done[k]:
            sides = [row[other] for other in near[one] if (layer[other] < k) == forth]
            mean[one] = np.mean(sides) if sides else row[one]
        done[k].sort(key=mean.__getitem__)
        row |= {one: number - len(done[k]) / 2 for number, one in enumerate(done[k])}
    return done


def _crossings(columns: dict, links: list) -> int:
    """How many pairs of links between the same two columns cross."""
    row = {one: (k, number) for k, column in columns.items() for number, one in enumerate(column)}
    ends = [(*row[left], *row[right]) for left, right in links]
    return sum(
        a[0] == b[0] and a[2] == b[2] and (a[1] - b[1]) * (a[3] - b[3]) < 0
        for number, a in enumerate(ends)
        for b in ends[:number]
    )


def _apart(wanted: list[float]) -> np.ndarray:
    """The rows nearest to those wanted that stand in order, at least 1 apart (least squares: pool what is too near).

    Examples
    --------
    >>> _apart([0.0, 0.0, 5.0]).tolist()
    [-0.5, 0.5, 5.0]
    """
    pools: list[list[float]] = []
    for one in np.asarray(wanted, float) - np.arange(len(wanted)):
        pools.append([one, 1])
        while len(pools) > 1 and pools[-2][0] > pools[-1][0]:
            (mean, size), (other, more) = pools[-2:]
            pools[-2:] = [[(mean * size + other * more) / (size + more), size + more]]
    return np.concatenate([np.full(int(size), mean) for mean, size in pools]) + np.arange(len(wanted))
