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
# # 09 A small network sets the filter's dials
#
# The filters of chapters 02 to 06 had dials: bandwidths that somebody chose, for the whole image or by a formula. Here a
# small network chooses them, for each pixel. It learns from images whose answer is known: error, back through the *filter*,
# back through the network. You write that chain for one pixel, check each term, train with it, and look for what the network
# cannot see. The method is that of Kalantari, Bako and Sen (2015), in short LBF.
#
# Ten exercises, 15.5 points, about 65 minutes. After each one, `check` tells you what holds and what does not. Hidden tests
# try other sizes and numbers, so read the contract in the docstring.

# %%
import matplotlib.pyplot as plt
import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import check

# %% [markdown]
# ## What the filter compares
#
# The stage of chapter 04 behind a thin lens, 4 samples per pixel (spp). For each pixel the filter compares its position, its
# colour, and groups of features: the *primary features*. Features are pixel means, and behind a lens they are noisy, so
# `primary_features` prefilters each group by NL-means. It keeps what is left of their variance, $\psi^2$.

# %%
samples = mcd.capture("dof", width=128, height=128, spp=4, seed=0)
reference = mcd.read_exr("data/dof.exr")
primary = mcd.primary_features(samples)
noisy = primary.colour
mcd.show_images(
    {
        f"noisy: relMSE {mcd.relmse(noisy, reference):.4f}": noisy,
        "albedo": primary.raw["albedo"],
        "albedo, prefiltered": primary.features["albedo"],
        "psi of albedo, 4 x": 4 * np.sqrt(primary.variances["albedo"]),
    }
)

# %% [markdown]
# ## The filter
#
# Chapter 04 again, with one change: every bandwidth belongs to the pixel $i$ in the middle. Let $E_{m,ij}$ be the squared
# distance of the pixels $i$ and $j$ in thing $m$, in units of its noise: position (in pixels), colour, and each group of
# features. Then
#
# $$ w_{ij} = \exp\Big(-\sum_m \theta_{m,i}\, E_{m,ij}\Big) \qquad
# \hat{\mathbf c}_i = \frac{\sum_j w_{ij}\, \mathbf c_j}{\sum_j w_{ij}} \qquad \theta = \frac{1}{2\sigma^2} $$
#
# The dial is $\theta$, the *inverse bandwidth*: 0 says "do not ask", a large one "only those that are equal". For one pixel:


# %%
def around(primary, y, x, radius):
    """Distances E_m of a pixel to all pixels of its window, (m, n), and the noisy colours there, (n, 3)."""
    rows, columns = np.indices(primary.colour.shape[:2])
    near = (abs(rows - y) <= radius) & (abs(columns - x) <= radius)
    c, variance = primary.colour.astype(float), primary.colour_variance.astype(float)
    E = [(rows[near] - y) ** 2 + (columns[near] - x) ** 2]
    E.append(((c[near] - c[y, x]) ** 2 / (variance[near] + variance[y, x] + 1e-10)).sum(axis=-1))
    for name in primary.groups:
        f, psi_squared = primary.features[name].astype(float), primary.variances[name][y, x]
        E.append(((f[near] - f[y, x]) ** 2 / np.maximum(psi_squared, 1e-4)).sum(axis=-1))
    return np.array(E, float), c[near]


NAMES = ("position", "colour", *primary.groups)
distances, colours = around(primary, 97, 78, radius=8)
print(f"{len(NAMES)} distances ({', '.join(NAMES)}) to {len(colours)} pixels")

# %% [markdown]
# ### Exercise 1 (write): the filter at one pixel

# %% exercise="filter_pixel"
from mcdenoise.lbf.pixel import filter_pixel

# %%
check("filter_pixel")

# %% [markdown]
# Your weights at three pixels, under three settings of the dials. Nearness alone mixes paints where they meet. With strict
# features the ball in focus keeps its paints apart, while a pixel of the ball out of focus is left almost alone with its
# noise: no two points of it look the same. Which setting is best differs from pixel to pixel.

# %%
PLACES = {"tile in focus": (97, 78), "ball in focus": (76, 66), "ball out of focus": (100, 118)}
SETTINGS = {
    "position alone, sigma 4": [1 / 32, 0, 0, 0, 0],
    "+ features, theta 0.05": [1 / 32, 0, 0.05, 0.05, 0.05],
    "+ features, theta 1": [1 / 32, 0, 1, 1, 1],
}
figure, grid = plt.subplots(4, 3, figsize=(8, 10), layout="constrained")
for column, (place, (y, x)) in enumerate(PLACES.items()):
    distances, colours = around(primary, y, x, radius=8)
    grid[0, column].imshow(np.clip(noisy[y - 8 : y + 9, x - 8 : x + 9], 0, 1) ** 0.45)
    grid[0, column].set_title(f"{place}: noisy", fontsize=10)
    for row, (name, theta) in enumerate(SETTINGS.items(), 1):
        filtered, weights = filter_pixel(np.array(theta), distances, colours)
        shown = grid[row, column].imshow(weights.reshape(17, 17), vmin=0, vmax=1)
        error = mcd.relmse(filtered.reshape(1, 1, 3), reference[y : y + 1, x : x + 1])
        grid[row, column].set_title(f"{name}\nS = {weights.sum():.1f}, relMSE {error:.4f}", fontsize=9)
for axes in grid.flat:
    axes.plot(8, 8, "r.")
    axes.set_xticks([])
    axes.set_yticks([])
_ = figure.colorbar(shown, ax=grid, label="weight", shrink=0.4)

# %% [markdown]
# ## What are the best dials?
#
# Turn one: the dial of all features, the same for all pixels, in the lower half of the image. (Position is at 2 pixels,
# colour at 0.01, the window has the radius 9.) `FilterLayer` is the filter of all pixels at once; it takes a $\theta$ for
# each.

# %%
lower = np.arange(64, 128)
layer = mcd.FilterLayer(primary, radius=9, rows=lower)


def with_one_dial(theta):
    """The lower half, all features at one dial."""
    return layer.forward(np.broadcast_to([1 / 8, 0.01, theta, theta, theta], layer.shape))[0]


tried = {theta: with_one_dial(theta) for theta in (0.001, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0)}
mcd.slider(
    lambda theta: mcd.show_images({f"relMSE {mcd.relmse(tried[theta], reference[lower]):.4f}": tried[theta]}),
    theta_of_features=tried,
    start=0.03,
)

# %% [markdown]
# At the left end the borders of paints are lost, at the right end all is nearly as noisy as before. Where is the best place?
# That depends on whom you ask:

# %%
PARTS = {
    "ball in focus": np.s_[:22, 50:85],
    "tiles in front": np.s_[50:, 20:90],
    "shadow on the left": np.s_[20:40, :50],
    "ball out of focus": np.s_[36:, 105:],
}
print("relMSE at theta = " + "".join(f"{theta:9g}" for theta in tried))
for name, part in PARTS.items():
    by_theta = [mcd.relmse(image[part], reference[lower][part]) for image in tried.values()]
    print(f"{name:18}" + "".join(f"{one:8.4f}{'*' if one == min(by_theta) else ' '}" for one in by_theta))

# %% [markdown]
# So each pixel should have dials of its own. With the reference at hand one can search: for each pixel the $\theta$ that
# brings $\hat{\mathbf c}$ nearest to it. We call that *the oracle*. Nobody can have it, for it knows the answer; it is the
# bound of what this filter can do. Beside it the best *single* setting for all pixels, found the same way:

# %%
from mcdenoise.lbf.oracle import oracle

found = oracle(layer, reference, colour_theta=0.01, steps=15)
candidates = {"noisy": noisy[lower], "best single setting": found.shared_image, "the oracle": found.image}
errors = {name: mcd.relmse(image, reference[lower]) for name, image in candidates.items()}
titled = {f"{name}: {errors[name]:.4f}": image for name, image in candidates.items()}
mcd.show_images(titled | {"reference": reference[lower]}, columns=2)

# %% [markdown]
# Its dials as maps, as bandwidths $\sigma = 1/\sqrt{2\theta}$: above as they were found, below their logarithms blurred. With
# that much freedom a part of the noise is fitted, and many dials give nearly the same colour. What is left after blurring is
# what a network can hope to learn.

# %%
figure, grid = plt.subplots(2, 2, figsize=(11, 5.6), layout="constrained")
for column, (name, unit) in zip(grid.T, (("position", "pixels"), ("albedo", "standard deviations")), strict=True):
    logs = -np.log10(2 * found.theta[..., NAMES.index(name)]) / 2
    for axes, one, what in zip(column, (logs, mcd.gaussian(logs, sigma_space=2.0)), ("", ", blurred"), strict=True):
        low, high, ticks = (-1, 2, [-1, 0, 1, 2]) if one is logs else (0, 1.2, [0, 0.5, 1])
        shown = axes.imshow(one, vmin=low, vmax=high, extent=(0, 128, 128, 64))
        axes.set_title(f"the oracle's bandwidth of {name}{what}", fontsize=10)
        bar = figure.colorbar(shown, ax=axes, label=unit, shrink=0.8)
        bar.set_ticks(ticks, labels=[f"{10**tick:.3g}" for tick in ticks])

# %% [markdown]
# ### How far is far?
#
# Between noisy and oracle lies the way that a better choice of dials can go. An error is worth as much as the factor by which
# it shrinks, so the way is measured in $\log$ relMSE: 0 at the noisy image, 1 at the oracle.
#
# ### Exercise 2 (write): the share of the way


# %% exercise="share_of_the_way"
def share_of_the_way(unfiltered, filtered, oracle):
    """Which share of the way from unfiltered to the oracle a filter has gone, in log relMSE.

    unfiltered, filtered, oracle : relMSE of three images, numbers above 0; oracle is below unfiltered.

    Returns a number: 0 if filtered is unfiltered, 1 if it is the oracle, below 0 if the filter does harm.
    """
    ### BEGIN SOLUTION
    return np.log(unfiltered / filtered) / np.log(unfiltered / oracle)
    ### END SOLUTION


# %%
check("share_of_the_way")

# %%
share = share_of_the_way(errors["noisy"], errors["best single setting"], errors["the oracle"])
print(
    f"The best single setting goes {100 * share:.0f} % of the way. The rest is for dials that change from pixel to pixel."
)

# %% [markdown]
# ## What the network sees
#
# The network has no reference. For each pixel it sees the *secondary features*: numbers that say how noisy, how bright and
# how uneven each group is around it. Seven kinds for each group, and the sampling rate 1 / spp. With five groups these are
# the paper's 36 numbers; our model sees the colour as one more group, as $\log(1 + c)$. Some of them as maps:

# %%
secondary = mcd.secondary_features(primary, colour=True)
columns = mcd.secondary_names([*primary.groups, "colour"])
print(f"{len(columns)} secondary features: {len(primary.groups)} groups and the colour x 7 kinds + the sampling rate")
four = ("mad albedo", "std albedo", "std 7x7 albedo", "std colour")
maps = {name: secondary[..., columns.index(name)] for name in four}
mcd.show_images({f"{name}, scaled": one / np.percentile(one, 98) for name, one in maps.items()})

# %% [markdown]
# They have all kinds of units. So each is normalised, $(v - \mathrm{mean}) / \mathrm{std}$; a trained model has learnt mean
# and std from its training scenes, here they are those of this image. The three pixels from above:

# %%
x_all = (secondary - secondary.mean(axis=(0, 1))) / (secondary.std(axis=(0, 1)) + 1e-6)
figure, axes = plt.subplots(figsize=(8, 5.6), layout="constrained")
for shift, (place, (y, x)) in enumerate(PLACES.items()):
    colour, marker = ("#4477AA", "#EE6677", "#228833")[shift], "os^"[shift]
    axes.plot(x_all[y, x], np.arange(len(columns)), marker, color=colour, label=place)
axes.axvline(0, color="0.7", zorder=0)
axes.set_yticks(range(len(columns)), columns, fontsize=8)
axes.invert_yaxis()
axes.set(xlabel="standard deviations from the mean of the image", title="what the network sees of three pixels")
axes.grid(axis="y", color="0.92")
_ = axes.legend()

# %% [markdown]
# From there on it is chapters 07 and 08: a linear layer, a hidden one with sigmoids, and at the end *softplus*,
# $\theta = \log(1 + e^z)$, because an inverse bandwidth is never negative.
#
# ## The chain, term by term
#
# Which weight $w$ of the network is to blame for the error $E_i$ of a pixel, and how much? By way of all $M$ dials, and of
# three channels:
#
# $$ \frac{\partial E_i}{\partial w} = \sum_{m=1}^{M} \left[ \sum_{q \in \{r, g, b\}}
# \frac{\partial E_i}{\partial \hat c_{i,q}}\, \frac{\partial \hat c_{i,q}}{\partial \theta_{m,i}} \right]
# \frac{\partial \theta_{m,i}}{\partial z_{m,i}}\, \frac{\partial z_{m,i}}{\partial w} $$
#
# Read it from left to right. **The first term** belongs to the error
# $E_i = \frac n2 \sum_q (\hat c_{i,q} - c_{i,q})^2 / (c_{i,q}^2 + \varepsilon)$, with $n$ the spp.
#
# ### Exercise 3 (write): from the error to the filtered colour

# %% exercise="filtered_error_gradient"
from mcdenoise.lbf.pixel import filtered_error_gradient

# %%
check("filtered_error_gradient")

# %% [markdown]
# **The second term** is what is new in this chapter: how does a filtered pixel change with a dial? Begin with $w_j$: what is
# $\partial w_j / \partial \theta_m$? Then $\hat c = T / S$ with $T = \sum_j w_j c_j$ and $S = \sum_j w_j$; both change.
#
# ### Exercise 4 (write): from the filtered colour to the dials

# %% exercise="filtered_by_theta"
from mcdenoise.lbf.pixel import filtered_by_theta

# %%
check("filtered_by_theta")

# %% [markdown]
# In words: a larger $\theta_m$ takes weight from pixels that are far in thing $m$. If those are brighter than $\hat c$, it
# gets darker; if distance and colour have nothing to do with each other, nothing changes. That is a *covariance*, and it has
# a minus.
#
# The judge of chapter 08 says whether it is right. Each pair is one term of the chain, at a pixel of the ball out of focus:

# %%
y, x = PLACES["ball out of focus"]
distances, colours = around(primary, y, x, radius=8)
c, theta = reference[y, x].astype(float), np.array([0.02, 0.01, 0.05, 0.05, 0.05])


def error_forward(filtered):
    return 4 / 2 * np.sum((filtered - c) ** 2 / (c**2 + 0.01)), filtered


def error_backward(d_error, filtered):
    return {"filtered": d_error * filtered_error_gradient(filtered, c, 4, 0.01)}


def filter_forward(theta):
    return filter_pixel(theta, distances, colours)[0], theta


def filter_backward(d_filtered, theta):
    return {"theta": filtered_by_theta(theta, distances, colours) @ d_filtered}


filtered, _ = filter_pixel(theta, distances, colours)
for pair, inputs in (
    (mcd.nn.Pair(error_forward, error_backward, "the error"), {"filtered": filtered}),
    (mcd.nn.Pair(filter_forward, filter_backward, "the filter"), {"theta": theta}),
):
    print(f"{pair.name}: largest relative error {mcd.nn.check_gradient(pair, inputs):.1e}")

# %% [markdown]
# ### Which way should a dial go?
#
# Five pixels, each the middle one of a row of seven. Points show the noisy colours, squares the albedo, the line is the
# reference of the middle. Two dials are set, position at 0.1 and albedo at 0.5 ($\psi^2 = 0.1$).
#
# - **A** a flat wall; the middle has caught too much light. Dial: position.
# - **B** the border between two paints. Dial: albedo.
# - **C** the border of a shadow, on one paint. Dial: albedo.
# - **D** the same shadow. Dial: position.
# - **E** a flat wall out of focus: what each pixel saw of the paint is chance, and its colour goes with it. Dial: albedo.

# %%
STEP = np.array([0.2, 0.2, 0.2, 0.2, 0.8, 0.8, 0.8])
CHANCE = np.array([0.3, 0.8, 0.35, 0.85, 0.4, 0.25, 0.8])
PIXELS = {  # name: colours, albedo, reference of the middle, dial
    "A": (np.array([0.45, 0.55, 0.5, 0.9, 0.5, 0.45, 0.55]), np.full(7, 0.5), 0.5, "position"),
    "B": (STEP, STEP, 0.2, "albedo"),
    "C": (STEP, np.full(7, 0.5), 0.2, "albedo"),
    "D": (STEP, np.full(7, 0.5), 0.2, "position"),
    "E": (CHANCE, CHANCE, 0.5, "albedo"),
}
figure, grid = plt.subplots(1, 5, figsize=(13, 2.6), layout="constrained", sharey=True)
for axes, (name, (row, albedo, right, dial)) in zip(grid, PIXELS.items(), strict=True):
    axes.plot(row, "o", color="#4477AA", label="colour")
    axes.plot(albedo, "s", color="#EE6677", fillstyle="none", markersize=9, label="albedo")
    axes.axhline(right, color="black", linewidth=1, label="reference")
    axes.axvline(3, color="0.85", linewidth=8, zorder=0)
    axes.set(title=f"{name}: {dial}", xlabel="x (pixels)", ylim=(0, 1))
_ = grid[0].legend(fontsize=8)

# %% [markdown]
# ### Exercise 5 (predict): the sign of the gradient
#
# What is the sign of $\partial E / \partial \theta$ for the dial that is named: **+** a larger $\theta$ makes the error
# larger (so training will make it smaller), **-** the reverse, or **0**? Predict before you run the cell below the check.

# %% exercise="which_way"
which_way = None  # five signs, such as ("+", "+", "+", "+", "+")
### BEGIN SOLUTION
which_way = ("+", "-", "0", "-", "+")
### END SOLUTION

# %%
check("which_way")

# %%
for name, (row, albedo, right, dial) in PIXELS.items():
    distances_7 = np.array([(np.arange(7) - 3.0) ** 2, (albedo - albedo[3]) ** 2 / 0.1])
    theta_7, colours_7 = np.array([0.1, 0.5]), np.repeat(row[:, np.newaxis], 3, axis=1)
    filtered, _ = filter_pixel(theta_7, distances_7, colours_7)
    d_filtered = filtered_error_gradient(filtered, np.full(3, right), 4, 0.01)
    slopes = filtered_by_theta(theta_7, distances_7, colours_7) @ d_filtered
    d_theta = slopes[("position", "albedo").index(dial)]
    print(f"{name}: c_hat {filtered[0]:.2f}, reference {right}; dE/dtheta of {dial}: {d_theta:+.3f}")

# %% [markdown]
# In E the dial learns to distrust the albedo, without anybody saying so: that is what training will do in the blurred parts.
# In C no setting of albedo helps, and the gradient knows it.
#
# **The third term** is the slope of softplus. Chapter 08 wrote it with $z$. But the filter only gets $\theta$, and the slope
# can be said with $\theta$ alone: solve $\theta = \log(1 + e^z)$ for $e^z$, and put it into $1 / (1 + e^{-z})$.
#
# ### Exercise 6 (write): through softplus

# %% exercise="softplus_link"
from mcdenoise.lbf.pixel import softplus_link

# %%
check("softplus_link")

# %% [markdown]
# **The last term** is that of a linear layer, $z_m = \sum_t w_{m,t}\, x_t + b_m$: chapter 08. Now put the four together, for
# a network of one layer and a few pixels:
#
# $$ E = \frac1N \sum_{i=1}^{N} E_i $$
#
# ### Exercise 7 (write): the whole chain
#
# Use the four functions that you have written.


# %% exercise="chain_rule"
def chain_rule(weight, bias, x, distances, colours, reference, spp, epsilon):
    """The error of some pixels, and its gradients with respect to a network of one layer, theta = softplus(x W^T + b).

    weight : (m, d), a row for each theta. bias : (m,). x : (pixels, d), what the network sees of each pixel.
    distances : (pixels, m, n), E_mj of each pixel to its n neighbours. colours : (pixels, n, 3). reference : (pixels, 3).
    spp, epsilon : numbers, as in E_i.

    Returns error (a number, the mean of E_i over the pixels), d_weight (m, d) and d_bias (m,).
    """
    ### BEGIN SOLUTION
    theta = np.logaddexp(0, x @ weight.T + bias)
    error, d_z = 0.0, np.zeros(theta.shape)
    for i in range(len(x)):
        filtered, _ = filter_pixel(theta[i], distances[i], colours[i])
        error += spp / 2 * np.sum((filtered - reference[i]) ** 2 / (reference[i] ** 2 + epsilon))
        d_filtered = filtered_error_gradient(filtered, reference[i], spp, epsilon)
        d_theta = filtered_by_theta(theta[i], distances[i], colours[i]) @ d_filtered
        d_z[i] = softplus_link(d_theta, theta[i])
    return error / len(x), d_z.T @ x / len(x), d_z.mean(axis=0)
    ### END SOLUTION


# %%
check("chain_rule")

# %% [markdown]
# A hundred pixels of the lower half to learn from, and another hundred to see whether it learns anything but those. (Pixels
# at the border are left out, so that all windows have one size.) The judge on the first six, and then the library: its layer
# does the filter's part for all pixels at once, and keeps no weights for it; it computes them twice.

# %%
rng = np.random.default_rng(0)
inner = [(y, x) for y in range(64, 124) for x in range(4, 124)]
chosen = [inner[k] for k in rng.choice(len(inner), 200, replace=False)]


def pack(pixels):
    """What `chain_rule` needs of some pixels, by name."""
    windows = [around(primary, y, x, radius=4) for y, x in pixels]
    return {
        "x": np.array([x_all[place] for place in pixels], float),
        "distances": np.array([one for one, _ in windows]),
        "colours": np.array([one for _, one in windows]),
        "reference": np.array([reference[place] for place in pixels], float),
        "spp": 4,
        "epsilon": 0.01,
    }


data, others = pack(chosen[:100]), pack(chosen[100:])
usual = np.array([0.02, 0.01, 0.12, 0.12, 0.12])  # a bell of 5 pixels, and features that differ by 2 deviations
parameters = {"weight": np.zeros((5, len(columns))), "bias": np.log(np.expm1(usual))}


def chain_forward(weight, bias):
    error, d_weight, d_bias = chain_rule(weight, bias, **six)
    return error, (d_weight, d_bias)


def chain_backward(d_error, saved):
    return {"weight": d_error * saved[0], "bias": d_error * saved[1]}


six = {name: value[:6] if np.ndim(value) else value for name, value in data.items()}
whole = mcd.nn.Pair(chain_forward, chain_backward, "the whole chain")
print(f"largest relative error: {mcd.nn.check_gradient(whole, parameters):.1e}")
layer = mcd.FilterLayer(primary, radius=4, rows=[chosen[0][0]])
image, saved = layer.forward(np.broadcast_to(usual, layer.shape))
d_image = np.zeros(image.shape)
d_image[0, chosen[0][1]] = 1.0
theirs = layer.backward(d_image, saved)[0, chosen[0][1]]
yours = filtered_by_theta(usual, data["distances"][0], data["colours"][0]).sum(axis=1)
print(f"your term and the library's differ by {np.abs(theirs - yours).max() / np.abs(yours).max():.0e} of the largest")

# %% [markdown]
# ## Training
#
# An *epoch*: forward, error, back, one step. The step is RPROP of chapter 08, where each parameter has a step of its own, and
# only the sign of its gradient counts:
#
# | sign of the gradient, and the one remembered | step | parameter | remember |
# |---|---|---|---|
# | equal | times 1.2 | one (new) step against the sign | the sign |
# | opposite | times 0.5 | waits | 0 |
# | one of them is 0 | stays | one step against the sign | the sign |
#
# Steps stay between 1e-6 and 50. You may copy your `rprop_step` of chapter 08 into the cell.
#
# ### Exercise 8 (write): one epoch


# %% exercise="one_epoch"
def one_epoch(parameters, state, data):
    """One epoch of training: the chain, then one step of RPROP for all parameters.

    parameters : {"weight": (m, d), "bias": (m,)}. data : the other arguments of `chain_rule`, by name.
    state : {"weight": (sign, step), "bias": (sign, step)}, what RPROP remembers: for each parameter two arrays of its shape.

    Returns the new parameters, the new state (dicts with the same names), and the error before the step. What comes in is
    not changed.
    """
    ### BEGIN SOLUTION
    error, d_weight, d_bias = chain_rule(**parameters, **data)
    new, after = {}, {}
    for name, gradient in (("weight", d_weight), ("bias", d_bias)):
        sign, step = state[name]
        now = np.sign(gradient)
        agree = now * sign
        step = np.clip(step * np.where(agree > 0, 1.2, np.where(agree < 0, 0.5, 1.0)), 1e-6, 50.0)
        now = np.where(agree < 0, 0.0, now)
        new[name], after[name] = parameters[name] - now * step, (now, step)
    return new, after, error
    ### END SOLUTION


# %%
check("one_epoch")

# %%
state = {name: (np.zeros(one.shape), np.full(one.shape, 0.02)) for name, one in parameters.items()}
trained, learnt, unseen = parameters, [], []
for _ in range(60):
    unseen.append(chain_rule(**trained, **others)[0])
    trained, state, error = one_epoch(trained, state, data)
    learnt.append(error)
figure, axes = plt.subplots(figsize=(6.5, 3.4), layout="constrained")
axes.plot(learnt, color="#4477AA", label="100 pixels that it learns from")
axes.plot(unseen, color="#EE6677", label="100 pixels that it never sees")
axes.set(xlabel="epoch of RPROP", ylabel="E", ylim=(0, None), title=f"a layer of {5 * len(columns) + 5} parameters")
_ = axes.legend()
print(f"pixels it learns from: E from {learnt[0]:.3f} to {min(learnt):.3f}")
print(f"pixels it never sees:  E from {unseen[0]:.3f} to {min(unseen):.3f}, and {unseen[-1]:.3f} at the end")

# %% [markdown]
# The pixels that it learns from get better and better. The others do so for a while, then they get worse: it learns its
# hundred pixels by heart. So it needs more of them, and from more than one *scene*. The library draws scenes at random, of
# balls, boxes, lights and lenses, and keeps the network that was best on scenes from which it did *not* learn. Three small
# scenes, one to watch, and a hidden layer of four:

# %%
from mcdenoise.lbf.dataset import DataConfig, load_data
from mcdenoise.lbf.training import TrainConfig, train_lbf

scenes = load_data(DataConfig(scenes=3, validation=1, size=64, spp=(4, 8), reference_spp=128, first=1012))
mcd.show_images({f"{one.name}, 4 spp": one.primaries[0].colour for part in scenes for one in part})

# %%
config = TrainConfig(
    groups=primary.groups,
    hidden=(4,),
    divides_albedo=False,
    radius=9,
    rows=12,
    validation_rows=12,
    epochs=40,
    drop=False,
)
done = train_lbf(config, scenes, progress=False)
figure, axes = plt.subplots(figsize=(6.5, 3.4), layout="constrained")
axes.plot(done.losses / done.unfiltered[0], color="#4477AA", label="three scenes that it learns from")
axes.plot(
    done.validation[:, 0], done.validation[:, 1] / done.unfiltered[1], "o-", color="#EE6677", label="one to watch"
)
axes.set(
    xlabel="epoch of RPROP",
    ylabel="E / E of the noisy images",
    ylim=(0, None),
    title=f"{len(columns)}-4-{len(done.model.outputs)}, {done.model.network.size} parameters",
)
_ = axes.legend()

# %% [markdown]
# Compare the two curves. Where the scene to watch stops gaining while the others go on, the network learns what only its
# three scenes have. What is kept is the network with the smallest error on the scene to watch.
#
# ## The model that comes with the package
#
# It was trained in the same way by `mcdenoise train`, on more and larger scenes and at 4 to 64 spp, never on `dof`. One thing
# is different: as in chapter 04 the colours are divided by the albedo before the filter, and multiplied after, so the filter
# need not tell paints apart. `mcd.lbf` runs the model; `mcd.lbf_analysis` shows the dials, too. Its twin (`variant="nlm"`)
# compares the colours of patches, and is a model of its own. The oracle is that of the model's filter, on every third row,
# and with a window of radius 13.

# %%
from dataclasses import replace

from mcdenoise.lbf.storage import shipped_model

model = shipped_model()
analysis = mcd.lbf_analysis(samples)
images = {"noisy": noisy, "three scenes": mcd.lbf(samples, done.model)}
images |= {"the model": analysis.image, "its twin with patches": mcd.lbf(samples, variant="nlm")}
some = np.arange(0, 128, 3)
smaller = replace(model, radius=13).layer(primary, rows=some)
bound = oracle(smaller, reference, colour_theta=model.colour_theta, steps=12)
errors = {name: mcd.relmse(image[some], reference[some]) for name, image in images.items()}
errors["best single setting"] = mcd.relmse(bound.shared_image, reference[some])
errors["the oracle"] = mcd.relmse(bound.image, reference[some])
print(f"{model.network.size} parameters; relMSE of every third row, and the share of the way to the oracle:")
for name, error in errors.items():
    share = share_of_the_way(errors["noisy"], error, errors["the oracle"])
    print(f"  {name:22} {error:.4f}  {100 * share:4.0f} %")
titled = {f"{name}: {mcd.relmse(image, reference):.4f}": image for name, image in images.items()}
mcd.show_images(titled | {"reference": reference}, columns=3)

# %% [markdown]
# The dials that it chose, as bandwidths. Position in pixels: where the map is bright, neighbours far away still count.
# Features in standard deviations: where it is dark, a neighbour must be equal.

# %%
maps = {name: np.clip(one, 1e-3, 1e3) for name, one in analysis.bandwidths.items() if one.min() < one.max()}
figure, grid = plt.subplots(2, (len(maps) + 1) // 2, figsize=(4.2 * ((len(maps) + 1) // 2), 7), layout="constrained")
for axes, (name, sigma) in zip(grid.flat, maps.items(), strict=False):
    logs = np.log10(sigma)
    low, high = np.percentile(logs, [1, 99])
    shown = axes.imshow(logs, vmin=low, vmax=high)
    axes.set_title(f"bandwidth of {name}", fontsize=10)
    bar = figure.colorbar(shown, ax=axes, shrink=0.75, ticks=np.linspace(low, high, 4))
    bar.ax.set_yticklabels([f"{10**tick:.3g}" for tick in np.linspace(low, high, 4)])
    bar.set_label("pixels" if name == "position" else "standard deviations")
    axes.axis("off")
for axes in grid.flat[len(maps) :]:
    axes.remove()

# %% [markdown]
# ## Who matters?
#
# If a group of features is left out, how much is lost? *Ablation* asks one at a time. Here for the filter with one setting
# for all pixels; $\theta_m = 0$ leaves a group out.
#
# ### Exercise 9 (write): leave one out


# %% exercise="group_ablation"
def group_ablation(theta, distances, colours, reference):
    """The error without each of the groups, and the group that matters most.

    theta : (m,), shared by all pixels. distances : (pixels, m, n). colours : (pixels, n, 3). reference : (pixels, 3).

    Returns errors (m,), relMSE if theta_m alone is 0: the mean over pixels and channels of
    (c_hat - c)^2 / (c^2 + 0.01); and most, the index of the group without which the error is largest.
    """
    ### BEGIN SOLUTION
    errors = np.zeros(len(theta))
    for m in range(len(theta)):
        without = theta.copy()
        without[m] = 0
        filtered = np.array([filter_pixel(without, e, c)[0] for e, c in zip(distances, colours, strict=True)])
        errors[m] = np.mean((filtered - reference) ** 2 / (reference**2 + 0.01))
    return errors, int(np.argmax(errors))
    ### END SOLUTION


# %%
check("group_ablation")

# %% [markdown]
# Two hundred pixels of the lower half, windows of radius 9, and a setting that did well above:

# %%
inner = [(y, x) for y in range(64, 119) for x in range(9, 119)]
asked = [inner[k] for k in rng.choice(len(inner), 200, replace=False)]
windows = [around(primary, y, x, radius=9) for y, x in asked]
given = np.array([e for e, _ in windows]), np.array([c for _, c in windows]), np.array([reference[p] for p in asked])
shared = np.array([1 / 8, 0.01, 0.03, 0.03, 0.03])
without, most = group_ablation(shared, *given)
with_all = mcd.relmse(np.array([filter_pixel(shared, e, c)[0] for e, c in windows])[np.newaxis], given[2][np.newaxis])
figure, axes = plt.subplots(figsize=(7, 2.9), layout="constrained")
bars = axes.barh(range(5), without, color=["#EE6677" if m == most else "#4477AA" for m in range(5)])
axes.bar_label(bars, [f" {one:.4f}" for one in without])
axes.axvline(with_all, color="black", linestyle=":")
axes.set_yticks(range(5), [f"without {name}, theta {one:.3g}" for name, one in zip(NAMES, shared, strict=True)])
axes.set(xlabel="relMSE", xlim=(0, 1.2 * without.max()), title=f"leave one out (dotted: with all, {with_all:.4f})")
axes.invert_yaxis()

# %% [markdown]
# A group may be missed little because another one says the same. So this is not what a group is worth alone, and not what it
# is worth to the network, which can turn to the others. To know that, one
# has to train without the group.
#
# ## Where it fails, and where it does not
#
# Three inputs unlike the training scenes: a firefly in 20 pixels; colours without any noise (the features keep theirs); and
# 1 spp, where there is no variance within pixels, and differences between neighbours stand in for it.

# %%
bright = samples.radiance.copy()
bright[rng.integers(0, 128, 20), rng.integers(0, 128, 20), 0] = 1000.0
fireflies = replace(samples, radiance=bright)
clean = replace(samples, radiance=np.repeat(reference[:, :, np.newaxis], 4, axis=2))
one = samples.subset(0, 1)
cases = {
    "fireflies, noisy": mcd.pixel_mean(bright),
    "fireflies, filtered": mcd.lbf(fireflies),
    "fireflies, despiked": mcd.lbf(fireflies, despiked=True),
    "no noise, filtered": mcd.lbf(clean),
    "1 spp, noisy": mcd.pixel_mean(one.radiance),
    "1 spp, filtered": mcd.lbf(one),
}
titled = {f"{name}: {mcd.relmse(image, reference):.3g}": image for name, image in cases.items()}
mcd.show_images(titled, columns=3)

# %% [markdown]
# A firefly finds nobody that is like it in colour, so it stays, and its neighbours hardly take from it. Despiking removes it
# afterwards, and with it some light that was true: the switch is off by default. On the clean image the distance of colour
# protects: it is divided by a variance of nearly 0. From 1 spp the filter still makes an image, but a blurred one: it does
# not know what is noise.
#
# ### What the network does not see
#
# Go back to the list of secondary features, without those of the colour: the paper's network sees features alone. Which of
# them know about the *light*?
#
# ### Exercise 10 (break): the blind spot
#
# A white wall, flat, its features constant and free of noise. A lamp throws light on it, and you choose the light: two
# patterns, of which each gets the same noise. The paper's network sees the same numbers for both, so it must say the same
# dials. Choose the two lights so that *no* dial serves both. For simplicity only the dial of position counts here:
# $w = e^{-\|p_i - p_j\|^2 / 2\sigma^2}$ with one $\sigma$ for the image, from 0 (no filter) to huge (the mean of all).


# %% exercise="blind_spot"
def blind_spot(noise):
    """Two lights for which no bandwidth serves both.

    noise : (h, w), 20 pixels or more in each direction; what is added to each light makes the noisy image.

    Returns two arrays (h, w) of light, >= 0. Whatever sigma the filter has, at least one of the two images must end with more
    than 4 times the mean squared error that it would have with its own best sigma.
    """
    ### BEGIN SOLUTION
    rows, columns = np.indices(noise.shape)
    return np.full(noise.shape, 5.0), 10.0 * ((rows + columns) % 2)
    ### END SOLUTION


# %%
check("blind_spot")

# %% [markdown]
# Two walls under your two lights, with noise from 4 samples. What does the paper's network see, and what does ours?

# %%
noise = rng.normal(size=(32, 32, 4, 1))
corner = np.stack(np.meshgrid(np.arange(32), np.arange(32)), axis=-1)[:, :, np.newaxis]
paint = {"albedo": np.full((32, 32, 4, 3), 0.8)}
shown, seen, dials = {}, {True: [], False: []}, []
for name, light in zip(("first", "second"), blind_spot(noise.mean(axis=(2, 3))), strict=True):
    radiance = np.repeat(light[:, :, np.newaxis, np.newaxis] + noise, 3, axis=3)
    wall = mcd.SampleBuffer.from_arrays(radiance, np.repeat(corner + 0.5, 4, axis=2), features=paint)
    one, truth = mcd.lbf_analysis(wall), np.repeat(light[..., np.newaxis], 3, axis=-1)
    for colour, found_there in seen.items():
        found_there.append(mcd.secondary_features(one.primary, colour))
    dials.append(np.median(one.bandwidths["position"]))
    for kind, image in (("noisy", mcd.pixel_mean(wall.radiance)), ("filtered", one.image)):
        shown[f"{name} light, {kind}:\nMSE {mcd.mse(image, truth):.3f}"] = np.clip(image / (np.max(light) or 1), 0, 1)
for colour, words in ((False, "the paper's network sees"), (True, "our network sees")):
    print(f"{words} the same in both: {np.array_equal(*seen[colour])}")
print(f"our bandwidth of position, median: {dials[0]:.2f} pixels and {dials[1]:.2f} pixels")
mcd.show_images(shown)

# %% [markdown]
# To the paper's network the two walls are one. Only the filter's own look at the colours of two pixels can tell them apart,
# at whatever dial. That is why ours sees the colour. Does it help on your lights? Compare the errors before and after.
# Nothing like them stood in the training scenes, and learned dials are as good as the scenes that they were learned from.
#
# ## What you should be able to do now
#
# - write the filter as a function of its dials, and say what $\theta = 0$ and a huge $\theta$ do;
# - say what the oracle is, and measure how far a filter is on the way to it;
# - name the four terms between error and weight, derive each, and check each;
# - predict which way a dial goes, from what is mixed into a pixel;
# - train a network through a filter, and tell learning from learning by heart;
# - say what the network sees, and construct what it cannot see.
