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
# # 08 Back propagation: which weight is to blame, and how much?
#
# Chapter 07 built networks by hand: we chose every weight. Now the weights are to find themselves. For that we must know what a
# small change of each weight does to the error, and we need it for all weights at once. Back propagation gives that in one walk
# through the network from behind. You do it by hand for one small graph, write it for layers, check it against the forward
# pass, and train with it.
#
# Ten exercises, 18 points, about 60 minutes. After each one, `check` tells you what holds and what does not. Hidden tests try
# other sizes and numbers, so read the contract in the docstring.

# %%
import matplotlib.pyplot as plt
import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import check

# %% [markdown]
# ## One graph by hand
#
# The lecture's example is $f(x, y, z) = (x + y)\, z$ at $x = -2$, $y = 5$, $z = -4$. With $q = x + y$ it is two operations, each
# with derivatives that one can see at a glance, its *local gradients*:
#
# | operation | value | local gradients |
# |---|---|---|
# | $q = x + y$ | 3 | $\partial q / \partial x = 1$, $\partial q / \partial y = 1$ |
# | $f = q z$ | -12 | $\partial f / \partial q = z = -4$, $\partial f / \partial z = q = 3$ |
#
# The *backward pass* starts at the end, where $\partial f / \partial f = 1$, and multiplies by one local gradient at each edge:
#
# $$ \frac{\partial f}{\partial x} = \frac{\partial f}{\partial q} \frac{\partial q}{\partial x} = -4 \cdot 1 = -4 $$
#
# A `Scalar` is a number that remembers how it was made. `backward` does the walk:

# %%
from mcdenoise.nn.scalar import backward

x, y, z = mcd.nn.Scalar(-2.0, "x"), mcd.nn.Scalar(5.0, "y"), mcd.nn.Scalar(-4.0, "z")
f = (x + y) * z
gradients = backward(f)
print(f"f = {f.value:g}; df/dx = {gradients[x]:g}, df/dy = {gradients[y]:g}, df/dz = {gradients[z]:g}")

# %% [markdown]
# Above each edge stands the value, below it the gradient. Move the slider to follow the walk edge by edge:

# %%
mcd.slider(lambda steps: mcd.draw_graph(f, steps=steps, title="f = (x + y) z"), steps=range(6), start=5)

# %% [markdown]
# ### A value that is used twice
#
# If a value goes two ways, a change of it changes the result by both ways. So what comes back by the two is *added*.
#
# ### Exercise 1 (predict): the gradients of g
#
# Take $g = (x + y) \cdot (x z)$ with the same three numbers. Find $\partial g / \partial x$, $\partial g / \partial y$ and
# $\partial g / \partial z$ by hand: write $q = x + y$ and $p = x z$ into a table as above.

# %% exercise="used_twice"
used_twice = None  # three numbers, such as (1, 2, 3)
### BEGIN SOLUTION
used_twice = (8 * 1 + 3 * -4, 8, 3 * -2)
### END SOLUTION

# %%
check("used_twice")

# %%
g = (x + y) * (x * z)
mcd.draw_graph(g, title="g = (x + y) (x z)")

# %% [markdown]
# ## From numbers to batches
#
# A network for images does the same sum for a million pixels. So we write it for a *batch*: `x` of shape (n, d_in), a row each.
# A fully connected layer makes d_out numbers of each row,
#
# $$ y_s = \sum_t w_{s,t}\, x_t + b_s, \qquad\text{for all rows together}\qquad y = x\, W^T + b $$
#
# Row $s$ of $W$ holds the weights of output $s$.
#
# ### Exercise 2 (write): a fully connected layer

# %% exercise="linear"
from mcdenoise.nn.layers import linear

# %%
check("linear")

# %% [markdown]
# ### The Jacobian matrix, and why nobody builds it
#
# For one row the layer turns a vector into a vector. All its derivatives $\partial y_s / \partial x_t$ together are a matrix with
# d_out rows and d_in columns, the *Jacobian*. That of a linear layer is $W$ itself. That of an activation is diagonal, because
# output $s$ depends on input $s$ alone:


# %%
def sigmoid(x):
    """The activation of this notebook, as its formula says."""
    return 1 / (1 + np.exp(-x))


rng = np.random.default_rng(0)
row, weight, bias = np.array([0.5, -1.0, 2.0, 0.0]), rng.normal(size=(3, 4)).round(1), np.zeros(3)
hidden = linear(row[np.newaxis], weight, bias)[0]
matrices = {
    "linear layer, 4 to 3": mcd.nn.Linear(weight, bias).jacobian(row),
    "sigmoid of its 3 outputs": mcd.nn.Sigmoid().jacobian(hidden),
}
matrices["both, one after the other"] = matrices["sigmoid of its 3 outputs"] @ matrices["linear layer, 4 to 3"]
figure, grid = plt.subplots(1, 3, figsize=(11, 3.2), layout="constrained")
for axes, (title, matrix) in zip(grid, matrices.items(), strict=True):
    axes.imshow(matrix, cmap="PuOr", vmin=-1.5, vmax=1.5)
    for (s, t), value in np.ndenumerate(matrix):
        axes.text(t, s, f"{value:.2f}", ha="center", va="center", color="white" if abs(value) > 0.9 else "black")
    axes.set_xticks(range(matrix.shape[1]), range(1, matrix.shape[1] + 1))
    axes.set_yticks(range(matrix.shape[0]), range(1, matrix.shape[0] + 1))
    axes.set(title=title, xlabel="input t", ylabel="output s")

# %% [markdown]
# The chain rule multiplies these matrices. But we want the gradient of *one* number, the loss. So we start at its end with one
# row vector `d_y`, the gradient of the loss with respect to `y`, and multiply a row by a matrix at each layer. And for the
# sigmoid even that is too much: a product with a diagonal matrix is one multiplication a number. What would the matrices weigh?

# %%
print("numbers in the Jacobian, and in d_y, of an activation behind 100 neurons:")
for rows in (1, 100, 10_000):
    numbers = 100 * rows
    print(f"  batch of {rows:6} rows: {numbers**2:22,}  and {numbers:10,}   ({8 * numbers**2 / 1e9:,.4g} GB)")

# %% [markdown]
# ## Layers: a pair of functions each
#
# So a layer is a pair. `forward` returns y and what it wants *saved* for later. `backward` takes `d_y` and what was saved, and
# returns the gradient of each input. In one row the loss changes with $x_t$ by way of all outputs $s$:
#
# $$ \frac{\partial E}{\partial x_t} = \sum_s \frac{\partial E}{\partial y_s} \frac{\partial y_s}{\partial x_t} $$
#
# $W$ and $b$ are inputs too. But all rows of a batch use the same ones: these are values that are used n times.
#
# ### Exercise 3 (write): the backward pass of a linear layer
#
# Write down $\partial y_s / \partial x_t$, $\partial y_s / \partial w_{s,t}$ and $\partial y_s / \partial b_s$ first. Then sum
# over everything by which the loss depends on the input. Each gradient has the shape of what it is a gradient of.

# %% exercise="linear_backward"
from mcdenoise.nn.layers import linear_backward

# %%
check("linear_backward")

# %% [markdown]
# ### Exercise 4 (write): the backward pass of the sigmoid
#
# $s(x) = 1 / (1 + e^{-x})$ has the derivative $s\,(1 - s)$. So the output is all that needs to be saved.

# %% exercise="sigmoid_backward"
from mcdenoise.nn.layers import sigmoid_backward

# %%
check("sigmoid_backward")

# %% [markdown]
# ### Exercise 5 (write): the backward pass of softplus
#
# $\log(1 + e^x)$ is a smooth version of $\max(x, 0)$. In chapter 09 it keeps a bandwidth above 0. Differentiate it, and you meet
# an old friend. The catch: a network may be off by a lot, and then $x$ is 1000 or -1000. Your function must give the right
# number there too, and without a warning, for every finite $x$. (Try `sigmoid(np.array([-1000.0]))` of this notebook first.)

# %% exercise="softplus_backward"
from mcdenoise.nn.layers import softplus_backward

# %%
check("softplus_backward")

# %% [markdown]
# Three activations and their derivatives. Remember the scale of the right picture: the sigmoid is steepest at 0, and even there
# its derivative is only 1/4.

# %%
at = np.linspace(-6, 6, 241)[:, np.newaxis]
activations = {"sigmoid": mcd.nn.Sigmoid(), "tanh": mcd.nn.Tanh(), "relu": mcd.nn.ReLU(), "softplus": mcd.nn.Softplus()}
COLOURS = dict(zip(activations, ("#4477AA", "#EE6677", "#228833", "#AA3377"), strict=True))
figure, grid = plt.subplots(1, 2, figsize=(9, 3), layout="constrained")
for name, layer in activations.items():
    value, saved = layer.forward(at)
    grid[0].plot(at, value, label=name, color=COLOURS[name])
    grid[1].plot(at, layer.backward(np.ones_like(at), saved)[0], label=name, color=COLOURS[name])
grid[0].set(title="activations", xlabel="x", ylabel="y", ylim=(-1.2, 4))
grid[1].set(title="their derivatives", xlabel="x", ylabel="dy / dx")
grid[1].axhline(0.25, color="grey", linestyle=":")
_ = grid[0].legend()

# %% [markdown]
# ## What can be a loss?
#
# One number for a whole batch, and it must have a derivative. Three of them, for one row; a batch has the mean over its rows.
#
# - **Squared error** $E = \frac12 \sum_q (y_q - t_q)^2$, with the target $t$. The gradient is $y - t$.
# - **Cross-entropy** for classes 0 and 1: $E = -t \log p - (1 - t) \log(1 - p)$ with $p = s(y)$. The gradient with respect to
#   $y$, the number that goes *into* the sigmoid, is $p - t$.
# - **Relative error**, below.
#
# Why not the squared error for classes? Let the label be 1 and look at the gradient that reaches $y$ by way of the sigmoid:

# %%
p = sigmoid(at)
entropy = mcd.nn.CrossEntropy()
per_row = [entropy.backward(entropy.forward(one[np.newaxis], [[1.0]])[1])[0, 0] for one in at]
figure, axes = plt.subplots(figsize=(5.5, 3), layout="constrained")
axes.plot(at, sigmoid_backward(p - 1, p), label="squared error of the sigmoid", color=COLOURS["sigmoid"])
axes.plot(at, per_row, label="cross-entropy", color=COLOURS["tanh"])
axes.set(xlabel="y, into the sigmoid", ylabel="gradient dE / dy", title="label 1: who pulls at a wrong answer?")
_ = axes.legend()

# %% [markdown]
# On the left the answer is as wrong as can be. The squared error hardly pulls there, for the sigmoid is flat. The cross-entropy
# does.
#
# ### Exercise 6 (write): the lecture's loss
#
# For images the lecture measures the error of pixel $i$ relative to how bright it should be. $\hat c$ is the filtered radiance,
# $c$ the reference, $n$ the samples per pixel (spp):
#
# $$ E_i = \frac{n}{2} \sum_{q \in \{r, g, b\}} \frac{(\hat c_{i,q} - c_{i,q})^2}{c_{i,q}^2 + \varepsilon} \qquad
# \frac{\partial E_i}{\partial \hat c_{i,q}} = \;??? $$

# %% exercise="relative_error_gradient"
from mcdenoise.nn.losses import relative_error_gradient

# %%
check("relative_error_gradient")

# %% [markdown]
# A pixel that is 0.1 too bright, over references from black to white. Dark pixels count the most, and $\varepsilon$ says how much
# at most:

# %%
c = np.geomspace(1e-3, 1, 100)[:, np.newaxis]
figure, axes = plt.subplots(figsize=(5.5, 3), layout="constrained")
for epsilon, style in ((0.1, ":"), (0.01, "-"), (0.001, "--")):
    axes.plot(c, relative_error_gradient(c + 0.1, c, 4, epsilon), style, color="#4477AA", label=f"epsilon {epsilon:g}")
axes.set(
    xscale="log", yscale="log", xlabel="reference c (radiance)", ylabel="dE / d c_hat", title="0.1 too bright, 4 spp"
)
_ = axes.legend()

# %% [markdown]
# ## Two layers, put together
#
# The network $y = s(x W_1^T + b_1)\, W_2^T + b_2$ with your functions. Backward is forward read from below.


# %%
def two_layers(x, weight_1, bias_1, weight_2, bias_2):
    """Forward: y, and what the backward pass needs."""
    s = sigmoid(linear(x, weight_1, bias_1))
    return linear(s, weight_2, bias_2), (x, s, weight_1, weight_2)


def two_layers_backward(d_y, saved):
    """The gradients of x and of all four parameters, by name."""
    x, s, weight_1, weight_2 = saved
    d_s, d_weight_2, d_bias_2 = linear_backward(d_y, s, weight_2)
    d_h = sigmoid_backward(d_s, s)
    d_x, d_weight_1, d_bias_1 = linear_backward(d_h, x, weight_1)
    return {"x": d_x, "weight_1": d_weight_1, "bias_1": d_bias_1, "weight_2": d_weight_2, "bias_2": d_bias_2}


# %% [markdown]
# ### Is it right? Ask the forward pass
#
# Add a small $h$ to one number, take it away, and see what comes out: $\frac{f(x + h) - f(x - h)}{2h}$. That is slow, two
# forward passes for each number. But it needs no derivative, so it can judge those that we wrote. `check_gradient` does it for
# all numbers. It raises a `GradientError` where the two disagree, and returns the largest relative error:

# %%
rng = np.random.default_rng(1)
inputs = {"x": rng.normal(size=(6, 2)), "weight_1": rng.normal(size=(4, 2)), "bias_1": rng.normal(size=4)}
inputs |= {"weight_2": rng.normal(size=(1, 4)), "bias_2": rng.normal(size=1)}
pair = mcd.nn.Pair(two_layers, two_layers_backward, "two layers")
print(f"largest relative error: {mcd.nn.check_gradient(pair, inputs):.1e}")

# %% [markdown]
# ### Exercise 7 (predict): five faults
#
# Five backward passes, each with one fault. Run `complain` on each, read what the check says, and find the fault in the code. One
# letter a function, in the order of `PAIRS`:
#
# - **A** a matrix is transposed
# - **B** the sum over the batch is missing
# - **C** a mean over the batch stands where a sum should be
# - **D** a factor of 2 is missing
# - **E** the sign is wrong
# - **F** an array that is needed again is overwritten
# - **G** it does not multiply by `d_y`

# %%
ROWS = np.array([[1.0, 2.0, -1.0], [0.5, 0.0, 3.0], [-2.0, 1.0, 1.0], [0.0, 1.5, 0.5]])


def decay(x):
    y = np.exp(-x)
    return y, y


def decay_backward(d_y, y):
    return {"x": d_y * y}


def cube(x):
    return x**3, x


def cube_backward(d_y, x):
    x *= x
    return {"x": 3 * d_y * x}


def product(weight):
    return ROWS @ weight.T, None


def product_backward(d_y, saved):
    return {"weight": ROWS.T @ d_y}


def energy(x):
    return np.sum(x**2), x


def energy_backward(d_y, x):
    return {"x": d_y * x}


def shifted(x, bias):
    return x + bias, None


def shifted_backward(d_y, saved):
    return {"x": d_y, "bias": d_y}


PAIRS = {
    "decay": (decay, decay_backward),
    "cube": (cube, cube_backward),
    "product": (product, product_backward),
    "energy": (energy, energy_backward),
    "shifted": (shifted, shifted_backward),
}
INPUTS = {"x": ROWS, "weight": np.arange(9.0).reshape(3, 3) / 4, "bias": np.array([0.1, 0.2, 0.3])}


def complain(name):
    """What the gradient check says about one of the five."""
    forward, its_backward = PAIRS[name]
    needed = {one: INPUTS[one] for one in forward.__code__.co_varnames[: forward.__code__.co_argcount]}
    try:
        print(f"{name} is right: {mcd.nn.check_gradient((forward, its_backward), needed):.1e}")
    except mcd.nn.GradientError as error:
        print(error)


complain("decay")  # and the other four?

# %% exercise="five_faults"
five_faults = None  # five letters, such as ("A", "A", "A", "A", "A")
### BEGIN SOLUTION
five_faults = ("E", "F", "A", "D", "B")
### END SOLUTION

# %%
check("five_faults")

# %%
for name in PAIRS:
    complain(name)
    print()

# %% [markdown]
# ### When the judge is wrong
#
# Finite differences look a little to the left and a little to the right. Where a function has a *kink* between the two, they
# measure a slope that it has on neither side. Then a backward pass that is right looks wrong.
#
# ### Exercise 8 (break): make the check complain
#
# A network $y = \mathrm{relu}(x W^T + b)\, W_2^T + b_2$ with a backward pass that is right, and first weights that you are told.
# Find an input row at which the check complains. Think of what chapter 07 calls the decision boundary of a neuron.


# %% exercise="at_a_kink"
def at_a_kink(weight, bias):
    """An input at which a correct backward pass looks wrong to finite differences.

    weight : (d, d_in), no row of which is 0. bias : (d,). Those of the first layer, followed by relu.

    Returns a row x (d_in,), finite.
    """
    ### BEGIN SOLUTION
    normal = weight[0]
    return -bias[0] * normal / (normal @ normal)
    ### END SOLUTION


# %%
check("at_a_kink")

# %%
network = mcd.nn.MLP.random([2, 3, 1], hidden=mcd.nn.ReLU(), rng=np.random.default_rng(2))
network = network.replace(network.parameters | {"bias_1": np.array([0.5, -0.3, 0.2])})
kink = at_a_kink(network.parameters["weight_1"], network.parameters["bias_1"])
for name, row in (("at the kink", kink), ("0.01 beside it", kink + 0.01)):
    try:
        print(f"{name}: right, {mcd.nn.check_gradient(network, {'x': row[np.newaxis]}):.1e}")
    except mcd.nn.GradientError as error:
        print(f"{name}: {error}")

# %% [markdown]
# ## Training
#
# Forward, loss, backward, a step against the gradient; again. Two hundred points of two moons, eight hidden neurons, your
# functions, and the cross-entropy:

# %%
rng = np.random.default_rng(0)
points, labels = mcd.nn.two_moons(200, rng=rng, noise=0.15)
target = labels[:, np.newaxis].astype(float)
start = {"weight_1": rng.normal(size=(8, 2)), "bias_1": np.zeros(8)}
start |= {"weight_2": rng.normal(size=(1, 8)) / np.sqrt(8), "bias_2": np.zeros(1)}
loss, losses, parameters, snapshots = mcd.nn.CrossEntropy(), [], start, {}
for epoch in range(1001):
    y, saved = two_layers(points, **parameters)
    value, saved_by_loss = loss.forward(y, target)
    gradients = two_layers_backward(loss.backward(saved_by_loss), saved)
    if epoch in (0, 100, 1000):
        snapshots[epoch] = parameters
    losses.append(value)
    parameters = {name: one - 2.0 * gradients[name] for name, one in parameters.items()}
figure, grid = plt.subplots(1, 4, figsize=(14, 3.4), layout="constrained", width_ratios=(1, 1, 1, 1.1))
for axes, (epoch, one) in zip(grid, snapshots.items(), strict=False):
    right = np.mean((two_layers(points, **one)[0][:, 0] > 0) == labels)
    mcd.show_decision(
        lambda x, one=one: (two_layers(x, **one)[0][:, 0] > 0).astype(float),
        points,
        labels,
        title=f"epoch {epoch}: {100 * right:.0f} % right",
        axes=axes,
    )
grid[3].semilogy(losses, color="#4477AA")
_ = grid[3].set(xlabel="epoch", ylabel="cross-entropy", title="learning rate 2, all rows at once")

# %% [markdown]
# At first the loss falls fast: the network finds the best straight line. Then it rests a while, and falls again as the line
# begins to bend. What did the hidden neurons become? As in chapter 07, each is a map over the plane:

# %%
first, second = (mcd.nn.Linear(snapshots[1000][f"weight_{k}"], snapshots[1000][f"bias_{k}"]) for k in (1, 2))
trained = mcd.nn.MLP((first, mcd.nn.Sigmoid(), second, mcd.nn.Sigmoid()))
mcd.show_neurons(trained, points, labels, title="after 1000 epochs")

# %% [markdown]
# Six of the eight draw nearly the same line, three of them with the colours exchanged. So this network has more neurons than it
# uses. We come back to that.
#
# The library's `mcd.nn.train` does the same loop for any list of layers. Regression, too: one input, one output, a curve.

# %%
curve_x = np.linspace(-3, 3, 60)[:, np.newaxis]
curve_y = np.sin(1.5 * curve_x) * np.exp(-(curve_x**2) / 8)
small = mcd.nn.MLP.random([1, 8, 1], hidden=mcd.nn.Tanh(), rng=np.random.default_rng(0), gain=2.0)


def fit(optimizer, epochs=300, network=small):
    """Train on the curve with the squared error, all rows at once."""
    return mcd.nn.train(network, curve_x, curve_y, loss=mcd.nn.SquaredError(), optimizer=optimizer, epochs=epochs)


figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
axes.plot(curve_x, curve_y, ".", color="grey", label="target")
axes.plot(curve_x, small.forward(curve_x)[0], ":", color="#4477AA", label="before")
for epochs, colour in ((10, "#66CCEE"), (300, "#EE6677")):
    done = fit(mcd.nn.SGD(0.1), epochs)
    axes.plot(curve_x, done.network.forward(curve_x)[0], color=colour, label=f"after {epochs} epochs")
axes.set(xlabel="x", ylabel="y", ylim=(-1.1, 1.7), title="eight tanh neurons, learning rate 0.1")
_ = axes.legend(ncols=2)

# %% [markdown]
# ### How long a step?
#
# The gradient says which way is down, but not how far. Five learning rates, the same start:

# %%
figure, axes = plt.subplots(figsize=(6, 3.4), layout="constrained")
for rate, colour in zip(
    (0.001, 0.01, 0.1, 0.3, 1.0), ("#AA3377", "#66CCEE", "#4477AA", "#228833", "#EE6677"), strict=True
):
    try:
        done = fit(mcd.nn.SGD(rate))
    except mcd.nn.Diverged as error:
        print(error)
        done = error.training
    axes.semilogy(done.losses, color=colour, label=f"{rate:g}")
axes.set(xlabel="epoch", ylabel="squared error", title="five learning rates", ylim=(1e-3, 1e2))
_ = axes.legend(title="learning rate", ncols=2)

# %% [markdown]
# A thousandth is too small: three hundred epochs, and hardly a start. 0.3 is fastest, and close to the edge: look at its last
# epochs. With 1 each step jumps over the valley and lands higher on the other side. The library stops such a training with
# `Diverged`, and keeps the best network until then.
#
# ### Momentum, and steps that find their own length
#
# *Momentum* keeps a share of the last step. Where gradients agree, steps add up; where they alternate, they cancel.
#
# RPROP does not use the length of the gradient at all. Each weight has a step of its own, and only the *sign* counts:
#
# - sign as in the step before: we are on our way, so the step grows (times 1.2);
# - sign flipped: we have jumped over a minimum. The step shrinks (times 0.5), the weight stays where it is this time, and 0 is
#   remembered as its sign;
# - one of the two signs 0: the step stays.
#
# Then the step is kept within its bounds, and the weight goes one step against the sign that is remembered.
#
# ### Exercise 9 (write): one step of RPROP

# %% exercise="rprop_step"
from mcdenoise.nn.optimizers import rprop_step

# %%
check("rprop_step")

# %% [markdown]
# Your step in the hollow $E = \frac12 (x^2 + 400\, y^2)$: steep across, nearly flat along. Gradient descent must take steps
# that are short enough for the steep direction, and crawls along the flat one.

# %%
steep = np.array([1.0, 400.0])
paths = {name: [np.array([-3.0, 0.2])] for name in ("gradient descent", "momentum", "RPROP")}
velocity, sign, step = np.zeros(2), np.zeros(2), np.full(2, 0.01)
for _ in range(60):
    plain, pushed, by_sign = (path[-1] for path in paths.values())
    paths["gradient descent"].append(plain - 0.0045 * steep * plain)
    velocity = 0.8 * velocity - 0.0045 * steep * pushed
    paths["momentum"].append(pushed + velocity)
    moved, sign, step = rprop_step(by_sign, steep * by_sign, sign, step, 1.2, 0.5, 1e-6, 50.0)
    paths["RPROP"].append(moved)
figure, grid = plt.subplots(1, 2, figsize=(11, 3.4), layout="constrained")
across, down = np.meshgrid(np.linspace(-3.2, 0.8, 120), np.linspace(-0.25, 0.25, 120))
grid[0].contour(across, down, (across**2 + 400 * down**2) / 2, 12, colors="0.8")
for (name, path), colour in zip(paths.items(), ("#4477AA", "#228833", "#EE6677"), strict=True):
    path = np.array(path)
    grid[0].plot(*path.T, ".-", color=colour, label=name, linewidth=1)
    grid[1].semilogy((path**2 @ steep) / 2, color=colour, label=name)
grid[0].set(xlabel="x", ylabel="y", title="60 steps from the left")
grid[1].set(xlabel="step", ylabel="E", title="how far down?")
_ = grid[1].legend()

# %% [markdown]
# And on the curve:

# %%
figure, axes = plt.subplots(figsize=(6, 3.2), layout="constrained")
ways = {
    "SGD, rate 0.1": mcd.nn.SGD(0.1),
    "with momentum 0.9": mcd.nn.SGD(0.1, momentum=0.9),
    "RPROP": mcd.nn.RPROP(),
}
for (name, optimizer), colour in zip(ways.items(), ("#4477AA", "#228833", "#EE6677"), strict=True):
    done = fit(optimizer, 600)
    axes.semilogy(done.losses, color=colour, label=f"{name}: {done.losses[-1]:.1e}")
axes.set(xlabel="epoch", ylabel="squared error", title="eight tanh neurons on the curve")
_ = axes.legend()

# %% [markdown]
# ## Gradients that vanish
#
# On its way to the first layer a gradient is multiplied by one local gradient at each activation. Those of the sigmoid are 1/4
# or less. What is left after many layers? Networks of 16 neurons a layer, ten starts each; how large is the gradient of the
# *first* weights (root of the mean square), before any training?


# %%
def first_gradient(activation, depth, gain, starts=10):
    """Median over some starts of the size of the gradient of weight_1."""
    found = []
    for seed in range(starts):
        start = np.random.default_rng(seed)
        widths = [2, *[16] * depth, 1]
        network = mcd.nn.MLP.random(widths, hidden=activations[activation], rng=start, gain=gain)
        _, gradients = mcd.nn.loss_and_gradients(network, points, target, loss)
        found.append(np.sqrt(np.mean(gradients["weight_1"] ** 2)))
    return np.median(found)


depths = (1, 2, 3, 4, 6, 8, 10)
figure, axes = plt.subplots(figsize=(6, 3.4), layout="constrained")
for name, gain in (("sigmoid", 1.0), ("tanh", 1.0), ("relu", np.sqrt(2))):
    sizes = [first_gradient(name, depth, gain) for depth in depths]
    axes.semilogy(depths, sizes, "o-", color=COLOURS[name], label=f"{name}: {sizes[0] / sizes[-1]:,.0f} times less")
axes.set(xlabel="hidden layers", ylabel="gradient of weight_1", title="what arrives at the first layer?")
_ = axes.legend(title="from 1 to 10 layers")

# %% [markdown]
# With ten sigmoids in a row the first layer does not learn at all, at any learning rate that the last one survives. tanh has the
# slope 1 at 0, relu has it everywhere on one side. With weights of the right size their gradients arrive.
#
# ## No more model than needed
#
# How many hidden neurons does a curve need? The training error cannot say: it falls with every neuron. So we ask points that
# the training has not seen. With few points, each must do both jobs: *k-fold validation* splits them into k parts, trains on all
# but one, measures on that one, and does so k times. Now each width has k errors.

# %%
WIDTHS, FOLDS = (1, 2, 3, 4, 6, 10, 24), 5
rng = np.random.default_rng(0)
some_x = rng.uniform(-3, 3, (60, 1))
some_y = np.sin(1.5 * some_x) * np.exp(-(some_x**2) / 8) + 0.2 * rng.standard_normal((60, 1))
fold = np.arange(60) % FOLDS
errors, training, fits = np.zeros((len(WIDTHS), FOLDS)), np.zeros((len(WIDTHS), FOLDS)), {}
squared = mcd.nn.SquaredError()
for (place, k), _ in np.ndenumerate(errors):
    network = mcd.nn.MLP.random([1, WIDTHS[place], 1], hidden=mcd.nn.Tanh(), rng=np.random.default_rng(k), gain=2.0)
    done = mcd.nn.train(
        network, some_x[fold != k], some_y[fold != k], loss=squared, optimizer=mcd.nn.RPROP(), epochs=150
    )
    errors[place, k] = squared.forward(done.network.forward(some_x[fold == k])[0], some_y[fold == k])[0]
    training[place, k], fits[WIDTHS[place], k] = done.losses[-1], done.network
parameters = np.array([network.size for (_, k), network in fits.items() if k == 0])

# %% [markdown]
# The mean over the folds has an error of its own, and two models whose means differ by less than that are equally good for all we
# know. Then we take the smaller one: it is faster, and it has less room for nonsense. The rule: the model with the fewest
# parameters whose mean error is at most
#
# $$ \mathrm{mean}_{\mathrm{best}} + \mathrm{std}_{\mathrm{best}} / \sqrt{k} $$
#
# where *best* is the model with the smallest mean, and its standard deviation over the folds divides by $k - 1$.
#
# ### Exercise 10 (write): the smallest model that will do


# %% exercise="smallest_model"
def smallest_model(parameters, errors):
    """The model with the fewest parameters that is within one standard error of the best.

    parameters : (m,), how many parameters each model has, in any order, no two alike. errors : (m, folds), the validation
        error of each model in each fold, at least two folds.

    Returns the index of the model, a whole number from 0 to m - 1.
    """
    ### BEGIN SOLUTION
    mean = errors.mean(axis=1)
    best = np.argmin(mean)
    bound = mean[best] + errors[best].std(ddof=1) / np.sqrt(errors.shape[1])
    return int(np.argmin(np.where(mean <= bound, parameters, np.inf)))
    ### END SOLUTION


# %%
check("smallest_model")

# %%
chosen, mean = smallest_model(parameters, errors), errors.mean(axis=1)
best = int(np.argmin(mean))
error_of_mean = errors.std(axis=1, ddof=1) / np.sqrt(FOLDS)
figure, grid = plt.subplots(1, 2, figsize=(11, 3.6), layout="constrained")
grid[0].errorbar(WIDTHS, mean, error_of_mean, fmt="o-", color="#4477AA", capsize=3, label="validation, 5 folds")
grid[0].plot(WIDTHS, training.mean(axis=1), "s:", color="#EE6677", label="training")
grid[0].axhline(mean[best] + error_of_mean[best], color="grey", linestyle="--", label="best + its standard error")
grid[0].axvline(WIDTHS[chosen], color="#228833", label=f"chosen: {WIDTHS[chosen]} (best mean: {WIDTHS[best]})")
grid[0].set(xscale="log", yscale="log", xlabel="hidden neurons", ylabel="squared error", title="60 noisy points")
grid[0].set_xticks(WIDTHS, WIDTHS)
grid[0].minorticks_off()
grid[0].set_yticks((0.02, 0.03, 0.05, 0.1), ("0.02", "0.03", "0.05", "0.1"))
wide_x = np.linspace(-3, 3, 300)[:, np.newaxis]
grid[1].plot(some_x, some_y, ".", color="0.6")
grid[1].plot(wide_x, np.sin(1.5 * wide_x) * np.exp(-(wide_x**2) / 8), color="black", label="the truth")
for width, colour in ((1, "#AA3377"), (WIDTHS[chosen], "#228833"), (24, "#EE6677")):
    grid[1].plot(wide_x, fits[width, 0].forward(wide_x)[0], color=colour, label=f"{width} hidden")
grid[1].set(xlabel="x", ylabel="y", title="trained without the first fold")
grid[0].legend(fontsize=8)
_ = grid[1].legend(fontsize=8)

# %% [markdown]
# ## Where it fails
#
# The gradient leads down, but it does not know where down ends. Two hidden neurons are enough for exclusive or on four points:
# chapter 07 sets them by hand. Does training find them?

# %%
corners = np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]])
exclusive = np.array([[0.0], [1.0], [1.0], [0.0]])
for width in (2, 3, 6):
    ends = []
    for seed in range(20):
        network = mcd.nn.MLP.random([2, width, 1], hidden=mcd.nn.Tanh(), rng=np.random.default_rng(seed))
        done = mcd.nn.train(network, corners, exclusive, loss=loss, optimizer=mcd.nn.RPROP(), epochs=60)
        ends.append(done.losses[-1])
    print(
        f"{width} hidden neurons: {np.sum(np.array(ends) > 0.1):2} of 20 starts get stuck, the worst at {max(ends):.3f}"
    )

# %% [markdown]
# 0.347 is half of log 2: two of the four points are right, of the other two the network says "one half", and there it stays.
# With more neurons training gets stuck less often: a good reason to start with more than the solution needs.
#
# And a network knows nothing of places where it saw no data. The three that you compared, beyond the points:

# %%
far_x = np.linspace(-8, 8, 400)[:, np.newaxis]
figure, axes = plt.subplots(figsize=(6.5, 3.2), layout="constrained")
axes.axvspan(-3, 3, color="0.92", label="data")
axes.plot(far_x, np.sin(1.5 * far_x) * np.exp(-(far_x**2) / 8), color="black", label="the truth")
for width, colour in ((1, "#AA3377"), (WIDTHS[chosen], "#228833"), (24, "#EE6677")):
    axes.plot(far_x, fits[width, 0].forward(far_x)[0], color=colour, label=f"{width} hidden")
axes.set(xlabel="x", ylabel="y", ylim=(-2.5, 2.5), title="outside of the data")
_ = axes.legend(fontsize=8, ncols=2)

# %% [markdown]
# So a network that paints pixels by itself may paint anything where the scene is new. Chapter 09 gives it less to say: the
# filter of chapter 04 paints, and the network only sets its dials. For that the filter must become a layer, a pair forward and
# backward like the others.
#
# ## What you should be able to do now
#
# - draw the graph of a formula, and walk it backward by hand, also where a value is used twice;
# - say what a Jacobian matrix is, and why no backward pass builds one;
# - write layers and losses as pairs forward and backward for whole batches;
# - check a gradient, read the complaint, and say when the check itself is wrong;
# - tell from the losses whether a learning rate is too small or too large, and say what momentum and RPROP do about it;
# - say why gradients vanish, and choose a model no larger than it need be.
