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
# # 03 The bilateral filter: near, and alike in colour
#
# The Gaussian averages whatever is near, also across an edge. The bilateral filter asks one more question of every
# neighbour: *is your radiance like mine?* In this notebook you write it, measure what it gains, and find three ways to
# make it fail.
#
# Seven exercises, 16.5 points, about 50 minutes. After each one, `check` tells you what holds and what does not. Hidden tests
# try other sizes and limits, so read the contract in the docstring.

# %%
import matplotlib.pyplot as plt
import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import check

# %% [markdown]
# ## A noisy image with edges
#
# Render a small scene with 8 samples per pixel (spp), and load its reference of 4096 spp.

# %%
samples = mcd.capture("pinhole", width=128, height=128, spp=8, seed=0)
noisy = mcd.pixel_mean(samples.radiance)
reference = mcd.read_exr("data/pinhole.exr")
blurred = mcd.gaussian(noisy, sigma_space=1.0)
mcd.show_images(
    {
        f"noisy, relMSE {mcd.relmse(noisy, reference):.4f}": noisy,
        f"Gaussian, relMSE {mcd.relmse(blurred, reference):.4f}": blurred,
        "reference": reference,
    }
)

# %% [markdown]
# The blur costs more than the noise did: a Gaussian of only one pixel is already worse than no filter at all.
#
# ## Two kernels
#
# A neighbour $q$ counts for pixel $p$ if it is near *and* alike:
#
# $$ w_{pq} = G_{\sigma_s}(\|p - q\|)\; G_{\sigma_r}(\|I_p - I_q\|), \qquad
# G_\sigma(d) = \exp\left(-\frac{d^2}{2\sigma^2}\right) $$

# %% [markdown]
# ### Exercise 1 (predict): across an edge
#
# An edge is $2\sigma_r$ high. What does the range kernel $G_{\sigma_r}$ give a neighbour on its other side? Compute it by
# hand before you run anything.

# %% exercise="weight_across"
weight_across = None  # a number with two digits
### BEGIN SOLUTION
weight_across = np.exp(-2.0)
### END SOLUTION

# %%
check("weight_across")

# %% [markdown]
# The whole bell, with dots at one, two and three sigma:

# %%
distance = np.linspace(0, 4, 200)
weight = np.exp(-(distance**2) / (2 * 1.0**2))
figure, axes = plt.subplots(figsize=(6, 3))
axes.plot(distance, weight)
axes.plot([1, 2, 3], np.exp(-(np.array([1.0, 2.0, 3.0]) ** 2) / 2), "o")
axes.set(xlabel="d / sigma", ylabel="weight", title="one bell, used twice")
axes.grid()

# %% [markdown]
# ### Exercise 2 (write): the weights of one pixel
#
# Write down $w_{pq}$ for every $q$ of the window around one pixel. With colour images $\|I_p - I_q\|$ is the Euclidean
# distance of two colours: one number from three channels. (An infinite sigma is allowed, and NumPy gets it right:
# `d / np.inf` is 0.)


# %% exercise="bilateral_weights"
def bilateral_weights(image, y, x, sigma_space, sigma_radiance, radius):
    """Weights of the window around the pixel (y, x).

    image : (h, w, c). sigma_space, radius : pixels. sigma_radiance : unit of the image. Either sigma may be infinite.

    Returns an array (2 radius + 1, 2 radius + 1): entry [radius + dy, radius + dx] is the weight of the pixel
    (y + dy, x + dx), and 0 where that lies outside the image.
    """
    ### BEGIN SOLUTION
    height, width = image.shape[:2]
    weight = np.zeros((2 * radius + 1, 2 * radius + 1))
    for dy in range(-radius, radius + 1):
        for dx in range(-radius, radius + 1):
            if 0 <= y + dy < height and 0 <= x + dx < width:
                near = ((dy / sigma_space) ** 2 + (dx / sigma_space) ** 2) / 2
                alike = np.sum(((image[y + dy, x + dx] - image[y, x]) / sigma_radiance) ** 2) / 2
                weight[radius + dy, radius + dx] = np.exp(-near - alike)
    return weight
    ### END SOLUTION


# %%
check("bilateral_weights")

# %% [markdown]
# See your weights at a pixel on an edge: this is the lecture's picture, seen from above.

# %%
y, x, radius = 58, 60, 8
crop = noisy[y - radius : y + radius + 1, x - radius : x + radius + 1]
near = bilateral_weights(noisy, y, x, 3.0, np.inf, radius)
alike = bilateral_weights(noisy, y, x, np.inf, 0.2, radius)
both = bilateral_weights(noisy, y, x, 3.0, 0.2, radius)
figure, grid = plt.subplots(1, 4, figsize=(11, 3), layout="constrained")
grid[0].imshow(np.clip(crop, 0, 1) ** 0.45)
grid[0].set_title("the window")
for axes, weight, title in zip(grid[1:], (near, alike, both), ("near", "alike", "near and alike"), strict=True):
    shown = axes.imshow(weight, vmin=0, vmax=1)
    axes.set_title(title)
for axes in grid:
    axes.plot(radius, radius, "r.")
    axes.axis("off")
_ = figure.colorbar(shown, ax=grid, label="weight", shrink=0.8)

# %% [markdown]
# ## From weights to a filter
#
# The output is the weighted mean, and $W_p$, the sum of the weights, makes it a mean:
#
# $$ BF[I]_p = \frac{1}{W_p} \sum_{q \in S} w_{pq}\, I_q, \qquad W_p = \sum_{q \in S} w_{pq} $$
#
# We keep the two sums apart: `total` is $\sum w I$ and `norm` is $W_p$.
#
# ### Exercise 3 (write): both sums for all pixels
#
# Two helpers are given. `window_offsets(height, width, radius)` yields `dy, dx, here, there` for every offset of the window:
# `image[there]` is `image[here]` moved by the offset, and both stay inside the image. `bell(difference, sigma)` is $G_\sigma$
# of a vector that lies on the last axis. You may also do without them.

# %%
from mcdenoise.filters.window import bell, window_offsets

print(bell(np.array([3.0, 4.0]), sigma=5.0))  # distance 5 = one sigma
for dy, dx, here, there in window_offsets(1, 3, radius=1):
    print(dy, dx, np.array([[1, 2, 3]])[here], np.array([[1, 2, 3]])[there])

# %% exercise="bilateral_sums"
from mcdenoise.filters.bilateral import bilateral_sums

# %%
check("bilateral_sums")

# %% [markdown]
# Your filter at work, and its $W_p$: how many neighbours have a say?

# %%
total, norm = bilateral_sums(noisy, 1.0, 0.15, 3)
filtered = total / norm[..., np.newaxis]
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4))
left.imshow(np.clip(filtered, 0, 1) ** 0.45)
left.axis("off")
right.axis("off")
left.set_title(f"bilateral, relMSE {mcd.relmse(filtered, reference):.4f}")
shown = right.imshow(norm, vmin=1)
right.set_title("W_p: dark where a pixel is alone")
figure.colorbar(shown)
figure.tight_layout()

# %% [markdown]
# ## Against the Gaussian
#
# Cut through an edge, with the same `sigma_space` for both filters.

# %%
kept = mcd.bilateral(noisy, sigma_space=1.0, sigma_radiance=0.15)
figure, axes = plt.subplots(figsize=(9, 3.2))
for name, image in {"noisy": noisy, "Gaussian": blurred, "bilateral": kept, "reference": reference}.items():
    axes.plot(image[76, :70].mean(axis=-1), label=name)
axes.set(xlabel="x (pixels)", ylabel="radiance", title="row 76")
axes.legend()
axes.grid()

# %% [markdown]
# ## The dial sigma_radiance
#
# Slide from left to right: from the noisy image itself to the Gaussian.


# %%
def frame(sigma_radiance):
    image = mcd.bilateral(noisy, sigma_space=1.0, sigma_radiance=sigma_radiance)
    return mcd.show_images({f"relMSE {mcd.relmse(image, reference):.4f}": image})


mcd.slider(frame, sigma_radiance=[0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2, np.inf], start=0.2)

# %% [markdown]
# ### Exercise 4 (predict): four limits
#
# What does the bilateral filter turn into? Give one letter each:
# **A** the image itself, **B** the Gaussian, **C** the plain mean of the window, **D** the mean of the whole image.
#
# 1. `sigma_radiance` goes to 0 (and no two pixels are equal);
# 2. `sigma_radiance` goes to infinity;
# 3. both sigmas go to infinity, at a fixed radius;
# 4. `sigma_space` goes to 0.

# %% exercise="limits"
limits = None  # four letters, such as ("D", "D", "D", "D")
### BEGIN SOLUTION
limits = ("A", "B", "C", "A")
### END SOLUTION

# %%
check("limits")

# %% [markdown]
# Between the limits lies a minimum. Where, depends on both dials: the error map
# $E(\sigma_s, \sigma_r) = \mathrm{relMSE}(BF[I], \text{reference})$.

# %%
spaces, radiances = (0.35, 0.5, 0.7, 1.0, 1.4, 2.0), (0.05, 0.1, 0.2, 0.4, 0.8, 1.6)
errors = np.array(
    [[mcd.relmse(mcd.bilateral(noisy, sigma_space=s, sigma_radiance=r), reference) for r in radiances] for s in spaces]
)
figure, axes = plt.subplots(figsize=(5.5, 4.2))
shown = axes.imshow(np.log10(errors), origin="lower", cmap="viridis_r")
axes.set_xticks(range(6), radiances)
axes.set_yticks(range(6), spaces)
axes.set(xlabel="sigma_radiance (radiance)", ylabel="sigma_space (pixels)", title=f"smallest relMSE {errors.min():.4f}")
axes.plot(*np.unravel_index(errors.argmin(), errors.shape)[::-1], "rs", markersize=24, fillstyle="none")
figure.colorbar(shown, label="log10 relMSE")
figure.tight_layout()

# %% [markdown]
# ## Three ways to fail
#
# ### The guide is noisy
#
# Every weight is computed from $I_p$ and $I_q$, and both are noisy. How much does that cost? Let an *oracle* compute the
# weights from the reference $R$ (no real filter may do that) and average the same noisy pixels:
#
# $$ w_{pq} = G_{\sigma_s}(\|p - q\|)\; G_{\sigma_r}(\|R_p - R_q\|) $$
#
# Its guide is free of noise, so it can afford a window of `sigma_space` 4; the other two choose theirs from 0.5 to 1.4.

# %%
truth = mcd.read_exr("data/soft_shadow.exr")
spps = (1, 2, 4, 8, 32)
curves = {"Gaussian": [], "own guide": [], "oracle": []}
for spp in spps:
    image = mcd.render_image("soft_shadow", width=128, height=128, spp=spp, seed=1)
    gauss = [mcd.gaussian(image, sigma_space=s) for s in (0.5, 0.7, 1.0, 1.4)]
    own = [
        mcd.bilateral(image, sigma_space=s, sigma_radiance=r)
        for s in (0.5, 0.7, 1.0, 1.4)
        for r in (0.1, 0.2, 0.4, 0.8, np.inf)
    ]
    oracle = [
        mcd.cross_bilateral(
            image, {"R": truth}, sigma_space=4.0, sigma_radiance=np.inf, sigma_features={"R": sigma_reference}
        )
        for sigma_reference in (0.025, 0.05, 0.1)
    ]
    for name, candidates in zip(curves, (gauss, own, oracle), strict=True):
        curves[name].append(min(mcd.relmse(one, truth) for one in candidates))

figure, axes = plt.subplots(figsize=(6, 4))
for name, curve in curves.items():
    axes.loglog(spps, curve, "o-", label=f"{name}, best parameters")
axes.set_xticks(spps, spps)
axes.minorticks_off()
axes.set(xlabel="samples per pixel (spp)", ylabel="relMSE", title="soft_shadow")
axes.legend()
axes.grid()

# %% [markdown]
# The filter is not the problem, its guide is. At 1 spp the bilateral hardly beats the Gaussian; the oracle, with the very
# same noisy pixels, is several times better. Chapter 04 looks for guides with less noise.
#
# ### Exercise 5 (predict): a firefly
#
# All pixels are 0.5, one has the radiance 50. What is its radiance after the bilateral filter with `sigma_space = 2` and
# `sigma_radiance = 0.3`?

# %% exercise="firefly_left"
firefly_left = None  # radiance, two digits
### BEGIN SOLUTION
firefly_left = 50.0
### END SOLUTION

# %%
check("firefly_left")

# %% [markdown]
# Answered? Then read on. A firefly has no neighbour that is like it, so it keeps itself: $W_p \approx 1$. Now look for it in a
# rendered image.

# %%
glossy = mcd.render_image("glossy", width=128, height=128, spp=8, seed=1)
mcd.show_images(
    {
        "glossy, 8 spp": glossy[30:94, 64:],
        "Gaussian": mcd.gaussian(glossy, sigma_space=1.4)[30:94, 64:],
        "bilateral": mcd.bilateral(glossy, sigma_space=1.4, sigma_radiance=0.3)[30:94, 64:],
        "reference": mcd.read_exr("data/glossy.exr")[30:94, 64:],
    }
)

# %% [markdown]
# ### Exercise 6 (break): worse than the Gaussian
#
# Make a grey image with an edge of at least 0.4 along a whole row or column (16 to 64 pixels a side), and noise with mean
# zero, such that the bilateral (`sigma_space = 2`, `sigma_radiance = 0.2`) has **at least five times** the mean squared
# error of the Gaussian (`sigma_space = 2`), although the Gaussian blurs the edge.


# %% exercise="hard_case"
def hard_case():
    """Make an image on which the bilateral filter does much worse than the Gaussian.

    Returns
    -------
    noisy, truth : two arrays (h, w), 16 to 64 pixels a side, the same at every call (a fixed seed). truth has an edge of
        at least 0.4 along a whole row or column. noisy - truth is the noise: standard deviation at least 0.02, mean
        within a tenth of that of 0. The bilateral's mean squared error is at least five times the Gaussian's. Hidden
        tests also try sigma_space 1.4 and 3, where four times is enough.
    """
    ### BEGIN SOLUTION
    rng = np.random.default_rng(0)
    truth = np.full((48, 48), 0.5)
    truth[:, 24:] = 1.0
    coin = rng.permutation(truth.size).reshape(truth.shape) % 2
    return truth + coin - 0.5, truth
    ### END SOLUTION


# %%
check("hard_case")

# %%
made, made_from = hard_case()
mcd.show_images(
    {
        "yours": made,
        "Gaussian": mcd.gaussian(made, sigma_space=2),
        "bilateral": mcd.bilateral(made, sigma_space=2, sigma_radiance=0.2),
        "truth": made_from,
    }
)

# %% [markdown]
# ## A museum case: one impulse
#
# How would you know that somebody's bilateral filter is right? Switch one kernel off and look at the other alone: with a
# very wide range kernel, the answer to one bright pixel must be the spatial bell, centred on it.
#
# ### Exercise 7 (write): where is the middle?
#
# The centroid of a response $r$ is $\sum_q r_q\, q \,/ \sum_q r_q$, here counted from the middle of the array.


# %% exercise="centroid"
def centroid(response):
    """Centroid (y, x) of an image (h, w), both odd, in pixels from its middle pixel (h // 2, w // 2)."""
    ### BEGIN SOLUTION
    height, width = response.shape
    rows, columns = np.indices((height, width))
    share = response / response.sum()
    return (share * (rows - height // 2)).sum(), (share * (columns - width // 2)).sum()
    ### END SOLUTION


# %%
check("centroid")

# %% [markdown]
# Three bilateral filters, one impulse: ours in two engines, and the one of scikit-image, a library that much of science
# rests on.

# %%
from importlib.metadata import version

from skimage.restoration import denoise_bilateral

impulse = np.zeros((41, 41))
impulse[20, 20] = 1.0
responses = {
    "ours, numpy": mcd.bilateral(impulse, sigma_space=2, sigma_radiance=1e3, engine="numpy"),
    "ours, numba": mcd.bilateral(impulse, sigma_space=2, sigma_radiance=1e3),
    f"scikit-image {version('scikit-image')}": denoise_bilateral(impulse, sigma_spatial=2, sigma_color=1e3),
}
figure, grid = plt.subplots(1, 3, figsize=(10, 3.8), sharey=True)
for axes, (name, response) in zip(grid, responses.items(), strict=True):
    down, right = centroid(response)
    axes.imshow(response[8:33, 8:33], extent=(-12.5, 12.5, 12.5, -12.5), cmap="magma")
    axes.plot(right, down, "c+", markersize=14)
    axes.set(xlabel="x (pixels)", ylabel="y (pixels)")
    axes.set_title(f"{name}\ncentroid ({round(down, 2) + 0.0:.2f}, {round(right, 2) + 0.0:.2f})")
figure.tight_layout()
if np.hypot(down, right) < 0.01:
    print(f"scikit-image {version('scikit-image')} is centred. In version 0.26.0 the centroid was (-1.64, 1.16).")
else:
    print(f"scikit-image {version('scikit-image')} is off centre by {np.hypot(down, right):.2f} pixels.")

# %% [markdown]
# In version 0.26.0 a window of 13 x 13 gets its spatial weights from `np.arange(-13 // 2, 13 // 2 + 1)`. In Python
# `-13 // 2` is -7, not -6: the table has 14 rows of 14 weights, and is then read in rows of 13. Row k starts k entries too
# early, and the bell is sheared apart. On a photograph the result looks like a blur, and a test that asks "is there less
# noise than before?" passes. An impulse shows it at first sight.
#
# It can happen to anyone who writes a filter. So give every filter an impulse, also your own.
#
# ## What you should be able to do now
#
# - write the bilateral filter from its formula, and say what each sigma and $W_p$ do;
# - name its two limits, and find the minimum between them;
# - explain why its own noise misleads it at low spp, and why fireflies survive;
# - test any filter with one impulse.
