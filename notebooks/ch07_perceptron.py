# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # 07 The perceptron: lines, and what lines can make
#
# Random parameter filtering sets its dials by rules that somebody thought out. In chapter 09 a network will set them. It is
# built from one part, the perceptron: a line that divides its inputs in two. In this notebook you teach one line, see where no
# line helps, and put lines together until any region can be drawn.
#
# Nine exercises, 16 points, about 50 minutes. After each one, `check` tells you what holds and what does not. Hidden tests try
# other numbers, so read the contract in the docstring.

# %%
import matplotlib.pyplot as plt
import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import check

# %% [markdown]
# ## A classifier is a line
#
# A perceptron weighs its inputs, adds a bias, and asks whether the sum has reached 0:
#
# $$ y = f(w \cdot x + b), \qquad f(s) = 1 \text{ where } s \ge 0, \text{ else } 0 $$
#
# $f$ is the *step function*. With two inputs, $w_1 x_1 + w_2 x_2 + b = 0$ is a line, the *decision boundary*. On one side of it
# the answer is 1, on the other 0. On the line itself it is 1.
#
# ### Exercise 1 (predict): four points
#
# $w = (2, -1)$ and $b = -1$. Take a pencil. What are the answers for the points $(1, 0)$, $(0, 0)$, $(1, 1)$ and $(0, -2)$?

# %% exercise="four_points"
four_points = None  # four numbers, such as (0, 0, 0, 0)
### BEGIN SOLUTION
four_points = (1, 0, 1, 1)
### END SOLUTION

# %%
check("four_points")

# %% [markdown]
# In a picture. The weights are an arrow at right angles to the line, and it points to the side of the 1. The bias moves the
# line: its distance from the origin is $|b| / |w|$, here $1 / \sqrt 5$.

# %%
corners = np.array([[1.0, 0.0], [0.0, 0.0], [1.0, 1.0], [0.0, -2.0]])
line = mcd.nn.Perceptron(weight=np.array([2.0, -1.0]), bias=-1.0)
figure, axes = plt.subplots(figsize=(4.6, 4.4), layout="constrained")
mcd.show_decision(line, corners, line.classify(corners), title="w = (2, -1), b = -1", axes=axes)
foot = -line.bias * line.weight / (line.weight @ line.weight)  # the point of the line next to the origin
axes.annotate("", foot + 0.4 * line.weight, foot, arrowprops={"arrowstyle": "->", "linewidth": 2})
axes.text(*(foot + 0.4 * line.weight + [0.05, -0.1]), "w")
for point, answer in zip(corners, line.classify(corners), strict=True):
    place, side = ((8, -4), "left") if answer else ((-8, -4), "right")
    axes.annotate(f"({point[0]:g}, {point[1]:g}): {answer}", point, place, textcoords="offset points", ha=side)

# %% [markdown]
# ### Exercise 2 (write): the perceptron, for a batch
#
# A *batch* is an array of samples, a row each. We write everything for batches from now on.


# %% exercise="perceptron"
def perceptron(x, weight, bias):
    """The answer of a perceptron to each sample of a batch.

    x : (n, d), a row each; n may be 0. weight : (d,). bias : a number.

    Returns an array (n,) of whole numbers: 1 where weight . x + bias is at least 0, else 0.
    """
    ### BEGIN SOLUTION
    return (x @ weight + bias >= 0).astype(int)
    ### END SOLUTION


# %%
check("perceptron")

# %% [markdown]
# ## A line that learns
#
# Now the other way round: the points and their classes are given, `labels` 0 or 1, and a line is wanted. Rosenblatt's rule
# (1958) looks at one sample after the other. If the answer is right, it does nothing. If it is wrong, it moves the line:
#
# $$ w \leftarrow w + \mathrm{rate}\,(\mathrm{label} - \mathrm{answer})\, x, \qquad
# b \leftarrow b + \mathrm{rate}\,(\mathrm{label} - \mathrm{answer}) $$
#
# The difference is 1 if the answer should have been 1, and -1 if it should have been 0. Either way $w \cdot x + b$ comes nearer
# to the right side for this sample: it changes by $\pm\,\mathrm{rate}\,(|x|^2 + 1)$.
#
# ### Exercise 3 (write): one step of the rule

# %% exercise="perceptron_step"
from mcdenoise.nn.perceptron import perceptron_step

# %%
check("perceptron_step")

# %% [markdown]
# Two clouds, and your step. We go through the samples again and again, until nothing is wrong any more.


# %%
def two_clouds(n=40, seed=4):
    """Two clouds with a narrow gap between them."""
    rng = np.random.default_rng(seed)
    labels = np.arange(n) % 2
    return np.where(labels[:, np.newaxis] == 0, [0.3, 0.2], [1.0, 0.7]) + 0.2 * rng.standard_normal((n, 2)), labels


def corrections_of(x, labels, epochs=20):
    """All weights and biases that your step goes through, from 0 on, one after each correction."""
    weight, bias = np.zeros(2), 0.0
    lines = [(weight, bias)]
    for _ in range(epochs):
        for one, label in zip(x, labels, strict=True):
            weight, bias = perceptron_step(weight, bias, one, label, 1.0)
            if not np.array_equal(weight, lines[-1][0]) or bias != lines[-1][1]:
                lines.append((weight, bias))
    return lines


x, labels = two_clouds()
lines = corrections_of(x, labels)
shown = (1, 2, len(lines) // 2, len(lines) - 1)
figure, grid = plt.subplots(1, 4, figsize=(13, 3.4), layout="constrained")
for axes, k in zip(grid, shown, strict=True):
    wrong = int(np.sum(perceptron(x, *lines[k]) != labels))
    mcd.show_decision(mcd.nn.Perceptron(*lines[k]), x, labels, axes=axes)
    axes.set_title(f"correction {k}: {wrong} of {len(x)} wrong", fontsize=10)

# %% [markdown]
# ### How many corrections?
#
# If there is a line with a gap, the rule finds one. Novikoff (1962) gave the proof in a few lines, and a bound: from 0 it takes
# at most
#
# $$ \left(\frac{R}{\gamma}\right)^2 \text{ corrections}, \qquad R = \max_i |(x_i, 1)|, \qquad
# \gamma = \min_i \frac{|w^* \cdot x_i + b^*|}{|(w^*, b^*)|} $$
#
# with any line $(w^*, b^*)$ that separates the classes. Neither the number of samples nor that of the inputs stands in it: only
# the gap, beside the size of the data. Nor does the rate. From 0 it scales all weights, and no answer depends on their length.

# %%
slanted, offset = np.array([0.8, 0.6]), -0.2
gaps, counted, bounds = np.array([0.8, 0.4, 0.2, 0.1, 0.05, 0.025]), [], []
points = np.random.default_rng(0).uniform(-1, 1, (200, 2))
for gap in gaps:
    side = points @ slanted + offset
    x = points + np.where(np.abs(side) < gap / 2, np.sign(side) * gap / 2 - side, 0)[:, np.newaxis] * slanted
    side = x @ slanted + offset
    done = mcd.nn.train_perceptron(x, (side > 0).astype(int), epochs=2000)
    gamma = np.abs(side).min() / np.hypot(1.0, offset)
    counted.append(done.mistakes.sum())
    bounds.append((np.sum(x**2, axis=1).max() + 1) / gamma**2)
figure, axes = plt.subplots(figsize=(5, 3.4), layout="constrained")
axes.loglog(gaps, bounds, ":", color="black", label="at most $(R / \\gamma)^2$")
axes.loglog(gaps, counted, "o-", label="counted, 200 samples")
axes.set_xticks(gaps, [f"{gap:g}" for gap in gaps])
axes.minorticks_off()
axes.set(xlabel="width of the gap", ylabel="corrections", title="the narrower the gap, the longer it takes")
_ = axes.legend()

# %% [markdown]
# ### Exercise 4 (predict): is there a line?
#
# Five sets of points. D holds the same points as C, but the perceptron gets other inputs: the squares of the coordinates.


# %%
def five_sets():
    """Points and classes of A to E."""
    rng = np.random.default_rng(1)
    rings, of_rings = mcd.nn.rings(120, rng=rng, noise=0.05)
    strip = rng.uniform(-1, 1, (200, 2))
    across = np.abs(strip.sum(axis=1))
    strip, across = strip[np.abs(across - 0.5) > 0.1], across[np.abs(across - 0.5) > 0.1]
    return {
        "A: two clouds": two_clouds(),
        "B: two moons": mcd.nn.two_moons(120, rng=rng, noise=0.04),
        "C: rings": (rings, of_rings),
        "D: squares of C": (rings**2, of_rings),
        "E: a strip": (strip, (across < 0.5).astype(int)),
    }


figure, grid = plt.subplots(1, 5, figsize=(13, 3), layout="constrained")
for axes, (title, (x, labels)) in zip(grid, five_sets().items(), strict=True):
    for k, marker in enumerate("os"):
        axes.scatter(*x[labels == k].T, 14, marker=marker, color=("#4477AA", "#EE6677")[k], label=f"class {k}")
    axes.set(title=title, xlabel="$x_1^2$" if "D" in title else "$x_1$", ylabel="$x_2^2$" if "D" in title else "$x_2$")
    axes.set_aspect("equal", adjustable="datalim")
_ = grid[0].legend(fontsize=8)

# %% [markdown]
# Which of them can a perceptron separate? **Y** if there is a line, **N** if there is none.

# %% exercise="has_a_line"
has_a_line = None  # five letters, such as "YYYYY"
### BEGIN SOLUTION
has_a_line = "YNNYN"
### END SOLUTION

# %%
check("has_a_line")

# %%
figure, axes = plt.subplots(figsize=(6.5, 3.2), layout="constrained")
for title, (x, labels) in five_sets().items():
    done = mcd.nn.train_perceptron(x, labels, epochs=60)
    axes.plot(np.arange(1, len(done.mistakes) + 1), done.mistakes, ".-", label=title)
    if not done.separated:
        right = [np.mean(perceptron(x, line[:2], line[2]) == labels) for line in done.history[-200:]]
        print(f"{title:14} its last 200 lines have {100 * min(right):.0f} to {100 * max(right):.0f} % right")
axes.set_yscale("symlog", linthresh=1)
axes.set_yticks([0, 1, 10, 100], ["0", "1", "10", "100"])
axes.set(
    xlabel="epoch (once through all samples)", ylabel="corrections", title="0 corrections: separated, training ends"
)
_ = axes.legend(fontsize=8, loc=(0.6, 0.16))

# %% [markdown]
# Where there is no line, the rule never comes to rest. It does not even settle on the best of the lines that are wrong: each
# correction may spoil what was good. And D says what helps: not another rule, but other *features*.
#
# ### Exercise 5 (break): a rule that takes for ever
#
# The rule finds the line, if there is one. Find points for which it takes long.


# %% exercise="slow_points"
def slow_points():
    """Points that a line separates, and that Rosenblatt's rule needs more than 1000 corrections for.

    Returns
    -------
    x, labels : arrays (n, 2) and (n,), 2 to 20 points, coordinates from -1 to 1, labels 0 or 1, the same at every call.
        `mcd.nn.train_perceptron(x, labels)` makes at least 1000 corrections, whether it takes the samples in your order or
        in the reverse order, and is done before it has looked at a sample for the 20 000th time.
    """
    ### BEGIN SOLUTION
    return np.array([[1.0, 1.0], [1 - 1 / 512, 1 - 1 / 512]]), np.array([1, 0])
    ### END SOLUTION


# %%
check("slow_points")

# %%
x, labels = slow_points()
done = mcd.nn.train_perceptron(x, labels, epochs=20_000 // len(x))
figure, grid = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
mcd.show_decision(done.perceptron, x, labels, title=f"{done.mistakes.sum()} corrections", axes=grid[0])
window = np.ones(50) / 50
for column, name, style in zip(done.history.T, ("$w_1$", "$w_2$", "$b$"), ("-", "--", ":"), strict=True):
    grid[1].plot(np.convolve(column, window, "valid"), style, label=name, linewidth=2)
grid[1].set(xlabel="correction", ylabel="weights and bias", title="means over 50 corrections")
_ = grid[1].legend()

# %% [markdown]
# One correction to and one fro: what is left of the two is the difference of the samples, and that is tiny.
#
# ## XOR has no line
#
# Four corners are enough to stop a perceptron. The *exclusive or* is 1 where exactly one of the two inputs is 1. A line would
# need
#
# $$ b < 0, \qquad w_1 + b \ge 0, \qquad w_2 + b \ge 0, \qquad w_1 + w_2 + b < 0. $$
#
# Add the two in the middle: $w_1 + w_2 + 2b \ge 0$, so $w_1 + w_2 + b \ge -b > 0$. That contradicts the last one.
#
# But two lines do it: one that tells (0, 0) from the rest, one that tells (1, 1) from the rest. Their answers are the *features*
# for a second perceptron. That is a network of two layers. The perceptrons of the first one are called *hidden*:
#
# $$ h = f(W_1 x + b_1), \qquad y = f(W_2 h + b_2) $$
#
# Row $s$ of a weight matrix holds the weights of perceptron $s$, $w_{s,t}$ for input $t$.
#
# ### Exercise 6 (write): a network for XOR


# %% exercise="xor_layers"
def xor_layers():
    """Weights and biases of a network of two layers of step functions for XOR, with two hidden neurons.

    Returns
    -------
    weight_1 (2, 2), bias_1 (2,), weight_2 (1, 2), bias_2 (1,) : y = 1 where exactly one of the inputs is 1. The inputs need
        not be exact: from -0.2 to 0.2 one counts as 0, from 0.8 to 1.2 as 1.
    """
    ### BEGIN SOLUTION
    weight_1, bias_1 = np.array([[1.0, 1.0], [1.0, 1.0]]), np.array([-0.5, -1.5])  # at least one, both
    return weight_1, bias_1, np.array([[1.0, -1.0]]), np.array([-0.5])  # at least one, but not both
    ### END SOLUTION


# %%
check("xor_layers")


# %%
def network_of(weight_1, bias_1, weight_2, bias_2):
    """Your weights as a network of the library: the same numbers, in layers."""
    weights = (np.asarray(one, float) for one in (weight_1, bias_1, weight_2, bias_2))
    first, second = mcd.nn.Linear(next(weights), next(weights)), mcd.nn.Linear(next(weights), next(weights))
    return mcd.nn.MLP((first, mcd.nn.Step(), second, mcd.nn.Step()))


xor = network_of(*xor_layers())
corners, exclusive = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]]), np.array([0, 1, 1, 0])
hidden = mcd.nn.MLP(xor.layers[:2]).forward(corners)[0]
figure, grid = plt.subplots(1, 2, figsize=(8, 3.9), layout="constrained")
mcd.show_decision(xor, corners, exclusive, title="the plane: two lines", axes=grid[0])
mcd.show_decision(
    mcd.nn.MLP(xor.layers[2:]), hidden, exclusive, title="the same points, as the hidden layer sees them", axes=grid[1]
)
grid[1].set(xlabel="$h_1$", ylabel="$h_2$")
for point in {tuple(h) for h in hidden}:
    same = [f"({a:g}, {b:g})" for (a, b), h in zip(corners, hidden, strict=True) if tuple(h) == point]
    side = "right" if point[0] > 0.5 else "left"
    grid[1].annotate("\n".join(same), point, (0, 7), textcoords="offset points", ha=side)

# %% [markdown]
# This is the idea of the whole chapter: *features are outputs of perceptrons*. On the right, the hidden layer is a new pair of
# coordinates. It has moved the points, two of them to the same place, and now one line is enough.
#
# ## Any convex region
#
# Each hidden perceptron is a half plane. The second layer counts in how many of them a point lies. If it asks for all of them,
# the region is their intersection: a polygon without dents.
#
# ### Exercise 7 (write): a network for a polygon


# %% exercise="polygon_layers"
def polygon_layers(corners):
    """Weights and biases of a network of two layers of step functions: 1 inside a convex polygon, 0 outside.

    corners : (m, 2), m at least 3, in counter-clockwise order (x_1 to the right, x_2 up). Edges go from each corner to the
        next, and from the last one to the first.

    Returns weight_1 (m, 2), bias_1 (m,), weight_2 (1, m), bias_2 (1,): one hidden neuron for each edge, in any order. For a
    point on an edge either answer will do.
    """
    ### BEGIN SOLUTION
    edge = np.roll(corners, -1, axis=0) - corners
    weight_1 = np.stack([-edge[:, 1], edge[:, 0]], axis=1)  # the edge turned left by 90 degrees points inside
    bias_1 = -np.sum(weight_1 * corners, axis=1)
    m = len(corners)
    return weight_1, bias_1, np.ones((1, m)), np.array([0.5 - m])
    ### END SOLUTION


# %%
check("polygon_layers")

# %%
triangle = np.array([[-0.9, -0.7], [0.9, -0.5], [-0.1, 0.9]])
inside = network_of(*polygon_layers(triangle))
x = np.random.default_rng(2).uniform(-1.2, 1.2, (150, 2))
mcd.show_neurons(inside, x, inside.forward(x)[0][:, 0], title="a triangle: three half planes, and their intersection")

# %% [markdown]
# How many regions do lines make? Of the $2^m$ patterns of 0 and 1 that $m$ hidden neurons could give, few occur: at most
# $1 + m + m(m - 1)/2$ in the plane, as each new line crosses each old one at most once. Measured, on a fine grid:

# %%
rng = np.random.default_rng(5)
plane = np.stack(np.meshgrid(*2 * [np.linspace(-30, 30, 601)]), axis=-1).reshape(-1, 2)
for m in (1, 2, 3, 4, 5):
    angle, bias = np.pi * (np.arange(m) + 0.5 * rng.random(m)) / m, rng.uniform(-8, 8, m)
    pattern = (plane @ np.stack([np.cos(angle), np.sin(angle)]) + bias >= 0) @ 2 ** np.arange(m)
    print(f"{m} lines: {len(np.unique(pattern)):2} regions, at most {1 + m + m * (m - 1) // 2:2}; patterns {2**m:2}")

# %% [markdown]
# ## A third layer: any region
#
# A second layer of several neurons draws several polygons. A third one puts them together. It takes two features: $a$ is 1 in
# polygon A, $b$ is 1 in polygon B.
#
# ### Exercise 8 (write): either of two, and a hole
#
# Give two perceptrons $f(w_a\, a + w_b\, b + \mathrm{bias})$ by their numbers $(w_a, w_b, \mathrm{bias})$: `"either"` is 1 where
# the point lies in A or in B or in both; `"hole"` is 1 where it lies in A but not in B.

# %% exercise="third_layer"
third_layer = None  # such as {"either": (0, 0, 0), "hole": (0, 0, 0)}
### BEGIN SOLUTION
third_layer = {"either": (1, 1, -0.5), "hole": (1, -1, -0.5)}
### END SOLUTION

# %%
check("third_layer")


# %%
def with_third_layer(corners_a, corners_b, numbers):
    """Two polygons side by side in the first two layers, and a third one that puts them together."""
    a, b = ([np.asarray(one, float) for one in polygon_layers(corners)] for corners in (corners_a, corners_b))
    m, n = len(corners_a), len(corners_b)
    first = mcd.nn.Linear(np.concatenate([a[0], b[0]]), np.concatenate([a[1], b[1]]))
    both = np.block([[a[2], np.zeros((1, n))], [np.zeros((1, m)), b[2]]])  # each polygon counts its own edges alone
    second = mcd.nn.Linear(both, np.concatenate([a[3], b[3]]))
    third = mcd.nn.Linear(np.array([numbers[:2]], float), np.array([numbers[2]], float))
    return mcd.nn.MLP((first, mcd.nn.Step(), second, mcd.nn.Step(), third, mcd.nn.Step()))


def regular(m, radius, centre):
    """The corners of a regular polygon."""
    angle = 2 * np.pi * (np.arange(m) + 0.5) / m
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1) + centre


x = np.random.default_rng(3).uniform(-1.2, 1.2, (200, 2))
two = with_third_layer(regular(3, 0.7, [-0.6, -0.3]), regular(4, 0.6, [0.6, 0.4]), third_layer["either"])
ring = with_third_layer(regular(6, 1.0, [0, 0]), regular(4, 0.5, [0, 0]), third_layer["hole"])
figure, grid = plt.subplots(1, 2, figsize=(8, 3.9), layout="constrained")
for axes, network, title in zip(grid, (two, ring), ("either of two: 7-2-1", "a hole: 10-2-1"), strict=True):
    mcd.show_decision(network, x, network.forward(x)[0][:, 0], title=title, axes=axes)

# %% [markdown]
# With enough polygons any region can be drawn, as finely as one likes: the first layer cuts, the second one intersects, the
# third one unites. The library builds such networks from lists: `half_planes`, `all_of`, `any_of` (and `~k` for "not input k").
# Here XOR again, but for the whole square, where the two lines cross:

# %%
square, crossed = mcd.nn.xor(200, rng=np.random.default_rng(4))
lines = mcd.nn.half_planes([[1, 0, 0], [0, 1, 0]])  # right of the middle, above the middle
quadrants = mcd.nn.all_of([[0, ~1], [~0, 1]], inputs=2)
crossing = mcd.nn.MLP((*lines, *quadrants, *mcd.nn.any_of([[0, 1]], inputs=2)))
print(f"wrong: {np.sum(crossing.forward(square)[0][:, 0] != crossed)} of {len(square)}")
mcd.show_neurons(crossing, square, crossed, title="XOR on a square: 2-2-1")

# %% [markdown]
# ## Why nobody sets them by hand
#
# You knew the polygon. For real data nobody does, so the weights must be learned, in all layers. But Rosenblatt's rule needs
# the right answer of each perceptron, and for a hidden one nobody knows it. What about going downhill? Below, one number is
# moved, the bias of a line between the two clouds. Left, how many answers are wrong. Right, the same for a smooth step, the
# *sigmoid* $1 / (1 + e^{-s})$, and a smooth measure of error (chapter 08 has its formula).

# %%
x, labels = two_clouds()
across, biases = x @ np.array([4.0, 2.0]), np.linspace(-7, -1, 301)
wrong = [np.mean(perceptron(x, np.array([4.0, 2.0]), bias) != labels) for bias in biases]
smooth = [mcd.nn.CrossEntropy().forward((across + bias)[:, np.newaxis], labels[:, np.newaxis])[0] for bias in biases]
figure, grid = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
grid[0].plot(biases, wrong)
grid[0].set(xlabel="bias", ylabel="share of wrong answers", title="step: flat, with jumps")
grid[1].plot(biases, smooth)
_ = grid[1].set(xlabel="bias", ylabel="cross-entropy", title="sigmoid: a slope everywhere")

# %% [markdown]
# The staircase is flat wherever one stands: its derivative is 0 and says nothing about where to go. Therefore `Step` refuses.

# %%
try:
    mcd.nn.Step().backward(np.ones((1, 1)), None)
except ValueError as error:
    print(error)

# %% [markdown]
# ## What a trained network finds
#
# Chapter 08 writes that gradient down. Here we only use it, `mcd.nn.train`, on two moons: three hidden sigmoids, random at the
# start, and nobody says what they should do. The black line in each map is where the neuron gives 1/2.

# %%
moons, of_moons = mcd.nn.two_moons(200, rng=np.random.default_rng(1))


def trained(x, labels, neurons, seed, epochs=300):
    """A network of one hidden layer of sigmoids, trained from random weights."""
    start = mcd.nn.MLP.random([2, neurons, 1], gain=2.0, rng=np.random.default_rng(seed))
    target = labels[:, np.newaxis].astype(float)
    return mcd.nn.train(start, x, target, loss=mcd.nn.CrossEntropy(), optimizer=mcd.nn.Adam(0.2), epochs=epochs).network


def share_right(network, x, labels):
    """Share of the points on the right side of the decision boundary."""
    return np.mean((network.forward(x)[0][:, 0] >= 0) == labels)


small = trained(moons, of_moons, 3, seed=0)
print(f"right: {100 * share_right(small, moons, of_moons):.1f} %")
mcd.show_neurons(small, moons, of_moons, title="two moons, three hidden sigmoids")

# %%
hidden = mcd.nn.MLP(small.layers[:2]).forward(moons)[0]
figure = plt.figure(figsize=(9, 4), layout="constrained")
mcd.show_decision(small, moons, of_moons, title="the plane", axes=figure.add_subplot(1, 2, 1))
axes = figure.add_subplot(1, 2, 2, projection="3d")
for k, marker in enumerate("os"):
    axes.scatter(*hidden[of_moons == k].T, s=14, marker=marker, color=("#4477AA", "#EE6677")[k], depthshade=False)
_ = axes.set(xlabel="$h_1$", ylabel="$h_2$", zlabel="$h_3$", title="as the hidden layer sees it: a plane is enough")

# %% [markdown]
# ## No more neurons than needed
#
# ### Exercise 9 (predict): how few lines?
#
# Step functions, one hidden layer, one output. How many hidden neurons are needed at least so that every point gets its class?
#
# 1. two clouds, as A of exercise 4 (at least one neuron must stand there);
# 2. the four corners of XOR;
# 3. rings without noise: one of radius 0.45 inside one of radius 1;
# 4. two moons without noise: each has its end in the hollow of the other.

# %% exercise="fewest_lines"
fewest_lines = None  # four numbers, such as (1, 1, 1, 1)
### BEGIN SOLUTION
fewest_lines = (1, 2, 3, 3)
### END SOLUTION

# %%
check("fewest_lines")

# %% [markdown]
# And what does training need, with sigmoids? Three sets, one hidden layer of 1 to 8 neurons, three random starts each.

# %%
rng = np.random.default_rng(1)
sets = {
    "two moons": (moons, of_moons),
    "rings": mcd.nn.rings(200, rng=rng),
    "checker 2 x 2": mcd.nn.checker(200, cells=2, rng=rng),
}
widths = (1, 2, 3, 4, 8)
figure, grid = plt.subplots(1, 3, figsize=(11, 3.2), sharey=True, layout="constrained")
for axes, (title, (x, labels)) in zip(grid, sets.items(), strict=True):
    found = np.array([[share_right(trained(x, labels, m, seed, 150), x, labels) for seed in range(3)] for m in widths])
    axes.plot(widths, 100 * found.max(axis=1), "-", color="#777777", label="the best of three")
    axes.plot(widths, 100 * found, "o", color="#4477AA", alpha=0.6, label=["one start", None, None])
    axes.set(xlabel="hidden neurons", title=title, xticks=range(1, 9))
grid[0].set_ylabel("right, per cent")
_ = grid[0].legend(loc="lower right")

# %% [markdown]
# For moons and rings training needs the three neurons that you predicted for lines, though these sets have noise. The
# checkerboard is hard for one hidden layer. The jump that a line adds is the same along its whole length, but where lines cross,
# the classes on its two sides change places. Eight neurons bend around that. The three layers above, of two, two and one
# neurons, are exact. Beyond the knee the curves are flat: more neurons buy nothing but weights to train, and safer starts. That
# is a rule for the rest of the course: no more network than the data needs.
#
# ## Where it fails
#
# *The fewest are hard to find.* Two moons again, with **two** hidden sigmoids, eight random starts, another optimizer:

# %%
found = []
for seed in range(8):
    start = mcd.nn.MLP.random([2, 2, 1], gain=2.0, rng=np.random.default_rng(seed))
    target = of_moons[:, np.newaxis].astype(float)
    done = mcd.nn.train(start, moons, target, loss=mcd.nn.CrossEntropy(), optimizer=mcd.nn.RPROP(), epochs=200)
    found.append((share_right(done.network, moons, of_moons), done.network))
print("right, per cent: " + ", ".join(f"{100 * share:.1f}" for share, _ in found))
best = max(found, key=lambda one: one[0])[1]
mcd.show_neurons(best, moons, of_moons, title="the best of the eight")

# %% [markdown]
# So two can be enough: a sigmoid that is not yet saturated is a slope, not a step, and a slope and a step make an S. Most starts
# never find it. Training goes downhill from where it begins, and more neurons than needed make a good beginning likelier.
#
# *It is sure where it has seen nothing.* The network of three neurons, far from all points:

# %%
for far in ([0.0, 20.0], [20.0, 0.0], [20.0, 20.0], [-20.0, -20.0]):
    probability = mcd.nn.Sigmoid().forward(small.forward(np.array([far]))[0])[0].item()
    print(f"at ({far[0]:3g}, {far[1]:3g}): class 1 with probability {probability:.4f}")

# %% [markdown]
# Lines go on for ever, and so do their answers. In chapter 09 the points are pixels, and what lies far away is a scene unlike
# those it was trained on.
#
# ## What you should be able to do now
#
# - draw the line of a perceptron from its weights and bias, and read its answers off;
# - teach a perceptron, and say what bounds the number of corrections;
# - say for a set of points whether there is a line, and prove that XOR has none;
# - write down the weights of networks for XOR, for a polygon, for a hole;
# - explain what "features are outputs of perceptrons" means, with a picture;
# - say why a step cannot be trained through, and what the smooth step changes;
# - count how few neurons a set of points needs, and say why training may want more.
