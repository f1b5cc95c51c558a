"""Chapter 07, the years of the subject on one line."""

from __future__ import annotations

from matplotlib.figure import Figure

from mcdenoise.study.figures._ch07_data import FOURTH, ONE, ZERO

EVENTS = (
    (1943, "McCulloch and Pitts", "neurons that fire or\nnot compute logic", ZERO),
    (1958, "Rosenblatt", "a perceptron learns\nits weights", ZERO),
    (1969, "Minsky and Papert", "what one layer\ncannot decide", FOURTH),
    (1975, "Werbos", "back propagation\n(thesis of 1974)", ONE),
    (1982, "Hopfield", "recurrent\nnetworks", ONE),
    (1986, "Rumelhart, Hinton,\nWilliams", "hidden layers learn\nfeatures", ONE),
    (1989, "Cybenko; Hornik et al.", "one hidden layer\ncomes near any curve", FOURTH),
    (2015, "Kalantari, Bako, Sen", "a network sets a\nfilter's bandwidths", ONE),
)
SHOWN_AT = (1943, 1953, 1963.5, 1974, 1983, 1992.5, 2003, 2014)  # so that texts do not overlap
HEIGHTS = (1, -1, 1, -1, 1, -1, 1, -1)


def timeline() -> tuple[Figure, dict]:
    """Eight years between the first neuron of logic and the network of chapter 09."""
    figure = Figure(figsize=(9.6, 3.1), layout="constrained")
    axes = figure.subplots()
    axes.plot((1940, 2020), (0, 0), color="#222222", linewidth=1.5)
    for year in range(1940, 2021, 10):
        axes.plot((year, year), (-0.05, 0.05), color="#222222", linewidth=1)
    for (year, who, what, colour), at, side in zip(EVENTS, SHOWN_AT, HEIGHTS, strict=True):
        axes.plot((year, year, at), (0, 0.2 * side, 0.36 * side), color=colour, linewidth=1)
        axes.plot(year, 0, "o", color=colour, markersize=8)
        up = side > 0
        axes.text(
            at,
            0.4 * side,
            f"{year}\n{who}\n{what}",
            color=colour,
            fontsize=9,
            ha="center",
            va="bottom" if up else "top",
        )
    axes.set(xlim=(1936, 2022), ylim=(-1.05, 0.95))
    axes.axis("off")
    axes.set_title("blue: one layer.  purple: what a layer can and cannot.  red: layers that are trained", fontsize=10)
    return figure, {"first": EVENTS[0][0], "last": EVENTS[-1][0], "events": len(EVENTS)}
