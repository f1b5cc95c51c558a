"""Chapter 08, graphs of numbers: the simple example, patterns, a neuron, a weight that is used twice."""

from __future__ import annotations

from matplotlib.figure import Figure

from mcdenoise.nn.scalar import Scalar, backward, exp, sigmoid
from mcdenoise.study.graph import draw_graph
from mcdenoise.study.slider import Slider, slider

ROWS = ((1.0, 2.0), (3.0, 5.0))  # x and target of the two rows that share a weight


def simple_example() -> tuple[Scalar, dict[str, Scalar]]:
    """f = (x + y) z of the lecture: the output, and all values by name."""
    x, y, z = Scalar(-2, "x"), Scalar(5, "y"), Scalar(-4, "z")
    q = x + y
    q.label = "q"
    f = q * z
    return f, {"x": x, "y": y, "z": z, "q": q, "f": f}


def slider_steps() -> tuple[Slider, dict]:
    """The simple example, a step of the backward pass at a time."""
    f, named = simple_example()
    gradients = backward(f)
    picture = slider(
        lambda step: draw_graph(f, steps=step), title="f = (x + y) z, backwards", start=5, step=[0, 1, 2, 3, 4, 5]
    )
    return picture, {
        "value": {name: one.value for name, one in named.items()},
        "gradient": {name: gradients[one] for name, one in named.items()},
    }


def largest(x: Scalar, y: Scalar) -> Scalar:
    """The larger of two scalars. Its local gradients are 1 for the larger, 0 for the other.

    Examples
    --------
    >>> largest(Scalar(4), Scalar(1)).local
    (1.0, 0.0)
    """
    first = x.value > y.value
    return Scalar(max(x.value, y.value), "", "max", (x, y), (1.0, 0.0) if first else (0.0, 1.0))


def patterns() -> tuple[Figure, dict]:
    """Three ways in which a gradient goes on: shared out by +, exchanged by ×, sent one way by max."""
    x, y, z, w = Scalar(2, "x"), Scalar(-3, "y"), Scalar(4, "z"), Scalar(1, "w")
    f = (x * y + largest(z, w)) * 3
    gradients = backward(f)
    return draw_graph(f), {"f": f.value} | {one.label: gradients[one] for one in (x, y, z, w)}


def neuron() -> tuple[Figure, dict]:
    """A sigmoid neuron with two inputs, taken apart."""
    w1, x1, w2, x2, b = Scalar(2, "w1"), Scalar(-1, "x1"), Scalar(-3, "w2"), Scalar(-2, "x2"), Scalar(-3, "b")
    a = w1 * x1 + w2 * x2 + b
    a.label = "a"
    s = (exp(-a) + 1) ** -1
    gradients = backward(s)
    short = sigmoid(a)
    return draw_graph(s), {
        "s": s.value,
        "d_a": gradients[a],
        "short": short.local[0],
        **{f"d_{one.label}": gradients[one] for one in (w1, x1, w2, x2, b)},
    }


def twice() -> tuple[Figure, dict]:
    """Two rows of a batch use one weight: its gradient is the sum of two shares."""
    w = Scalar(1.0, "w")
    halves, shares = [], []
    for number, (x, target) in enumerate(ROWS, 1):
        halves.append((w * Scalar(x, f"x{number}") - target) ** 2)
        shares.append(backward(halves[-1])[w])
    loss = halves[0] + halves[1]
    return draw_graph(loss), {"shares": shares, "sum": backward(loss)[w], "loss": loss.value}
