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
# # 02 The Gaussian filter: near
#
# Chapter 01 left us with a noisy image: every pixel is the mean of a few random samples. Rendering more samples is slow, so we
# look for help next door. **Two pixels that lie close together probably show the same thing: average them.** That is the whole
# chapter; what it costs, how much noise it removes and what it destroys, you will measure yourself.
#
# Seven exercises, 14 points, about 50 minutes. After each one, `check` tells you what holds and what does not. Hidden tests
# try other sizes and limits, so read the contract in the docstring.

# %%
import time

import matplotlib.pyplot as plt
import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import check

# %% [markdown]
# The scene of this notebook: a row of balls seen through a thin lens, 8 samples a pixel, and its reference of 4096 samples a
# pixel.

# %%
reference = mcd.read_exr("data/dof.exr")
noisy = mcd.pixel_mean(mcd.capture("dof", width=128, height=128, spp=8, seed=0)["radiance"])
mcd.show_images({f"8 spp: relMSE {mcd.relmse(noisy, reference):.4f}": noisy, "reference, 4096 spp": reference})

# %% [markdown]
# ## 1. Near, as a number
#
# Closeness becomes a weight by a bell curve over the distance of two pixels p and q:
#
# $$G_\sigma(d) = \exp\left(-\frac{d^2}{2\sigma^2}\right), \qquad d = \|p - q\|$$
#
# The lecture writes $\frac{1}{2\pi\sigma^2}$ in front. We leave it out: we shall divide by the sum of the weights anyway, and
# a constant cancels. The weight of a pixel with itself is then 1.

# %%
d = np.linspace(0, 8, 200)
figure, axes = plt.subplots(figsize=(5, 2.8), layout="constrained")
for sigma_space in (1.0, 2.0, 4.0):
    axes.plot(d, np.exp(-(d**2) / (2 * sigma_space**2)), label=f"sigma_space {sigma_space:g}")
axes.set(xlabel="distance d (pixels)", ylabel="weight", title="near counts, far does not")
_ = axes.legend(frameon=False)

# %% [markdown]
# ### Exercise `gaussian_weights` (write, 2 points)
#
# The weights of a whole window: (2 radius + 1) x (2 radius + 1) pixels around the middle one. Hint: `np.arange(-radius,
# radius + 1)` holds the distances along one axis; add a `np.newaxis` to get the other.


# %% exercise="gaussian_weights"
def gaussian_weights(sigma_space, radius):
    """The weights of the window around one pixel.

    Parameters
    ----------
    sigma_space : standard deviation of the bell in pixels, > 0.
    radius : whole number >= 0; the window has (2 radius + 1)^2 pixels.

    Returns
    -------
    weights : (2 radius + 1, 2 radius + 1), exp(-d^2 / (2 sigma_space^2)) with d the
        distance from the middle pixel, whose own weight is 1: no constant in front.
    """
    ### BEGIN SOLUTION
    d = np.arange(-radius, radius + 1)
    return np.exp(-(d[:, np.newaxis] ** 2 + d**2) / (2 * sigma_space**2))
    ### END SOLUTION


# %%
check("gaussian_weights")

# %% [markdown]
# ## 2. The filter
#
# Each pixel becomes the weighted mean of its neighbourhood:
#
# $$\text{out}_p = \frac{\sum_q w_{pq}\, c_q}{\sum_q w_{pq}} = \frac{\text{total}_p}{\text{norm}_p}$$
#
# over the pixels q of the window **that lie inside the image**. We keep the two sums apart: an average hides a neighbour that
# was counted twice, the two sums do not.
#
# Looping over pixels is slow in Python; loop over the offsets of the window instead, and move the whole image at once. The
# function `window_offsets` hands you each offset (dy, dx) with the two parts of the image that it brings together:
# `image[there]` is `image[here]` moved by (dy, dx). And `bell(vector, sigma)` is $G_\sigma$ of the length of a vector whose
# components lie on the last axis.

# %%
from mcdenoise.filters.window import bell, window_offsets

row = np.array([[10, 20, 30]])
for dy, dx, here, there in window_offsets(1, 3, radius=1):
    weight = bell(np.array([dy, dx]), 1.5)
    print(f"dx {dx:2d}, weight {weight:.3f}: pixels {row[here]}, neighbours {row[there]}")

# %% [markdown]
# ### Exercise `gaussian_sums` (write, 3 points)
#
# The docstring is the contract of the real function in `mcdenoise.filters.gaussian`; its tests are yours.

# %% exercise="gaussian_sums"
from mcdenoise.filters.gaussian import gaussian_sums

# %%
check("gaussian_sums")

# %% [markdown]
# From here on we take the library's fast twin of your function, `mcd.gaussian`, so that the cells run also before yours is right.
#
# **One bright pixel tells everything.** The filter is linear, so its answer to a single bright pixel (its *impulse response*) is
# all there is to know about it. The answer must be the bell itself: centred, round, with the peak $1 / (2\pi\sigma^2)$.

# %%
impulse = np.zeros((21, 21))
impulse[10, 10] = 1.0
response = mcd.gaussian(impulse, sigma_space=2.0, radius=10)
x = np.arange(-10, 11)
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
left.imshow(response, extent=(-10.5, 10.5, 10.5, -10.5))
left.set(title="response to one bright pixel", xlabel="x (pixels)", ylabel="y (pixels)")
right.plot(x, np.exp(-(x**2) / (2 * 2.0**2)) / (2 * np.pi * 2.0**2), label="closed form")
right.plot(x, response[10], "o", label="filter")
right.set(title=f"cut: peak {response.max():.4f}, 1 / (8 pi) = {1 / (8 * np.pi):.4f}")
right.set(xlabel="x (pixels)", ylabel="response")
_ = right.legend(frameon=False)

# %% [markdown]
# Now the render. Move the slider: where does the noise go, and what goes with it?


# %%
def blurred(sigma_space):
    filtered = mcd.gaussian(noisy, sigma_space=sigma_space)
    title = f"sigma_space {sigma_space:g}: relMSE {mcd.relmse(filtered, reference):.4f}"
    return mcd.show_images({title: filtered, "reference": reference})


mcd.slider(blurred, sigma_space=[0.3, 0.4, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0])

# %% [markdown]
# ## 3. How much noise goes
#
# Let every pixel have an independent error of variance $s^2$. The errors of a weighted mean add up as squares:
#
# $$\text{variance left} = s^2\, \frac{\sum_q w_q^2}{\left(\sum_q w_q\right)^2}$$
#
# Both sums are close to integrals of bells, and a squared bell is a narrower bell: $G_\sigma^2 = G_{\sigma/\sqrt 2}$, and the
# integral of $G_\sigma$ over the plane is $2 \pi \sigma^2$.
#
# ### Exercise `predicted_noise` (predict, 1 point)
#
# White noise of standard deviation 1 goes through a Gaussian of sigma_space 2. Which **standard deviation** is left? Write the
# number, or the expression, before you run the cell after the check.

# %% exercise="predicted_noise"
predicted_noise = None  # your prediction: a number
### BEGIN SOLUTION
predicted_noise = 1 / np.sqrt(4 * np.pi * 2.0**2)
### END SOLUTION

# %%
check("predicted_noise")


# %%
def variance_left(sigma_space):
    radius = np.ceil(3 * sigma_space)
    line = np.exp(-(np.arange(-radius, radius + 1) ** 2) / (2 * sigma_space**2))
    weights = line[:, np.newaxis] * line
    return (weights**2).sum() / weights.sum() ** 2


white = np.random.default_rng(0).standard_normal((256, 256))
sigmas = [0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0]
left_over = [mcd.gaussian(white, sigma_space=s)[16:-16, 16:-16].var() for s in sigmas]
figure, axes = plt.subplots(figsize=(5, 3), layout="constrained")
axes.loglog(sigmas, [variance_left(s) for s in sigmas], "--", label="predicted by the weights")
axes.loglog(sigmas, left_over, "o", label="measured")
axes.set(xlabel="sigma_space (pixels)", ylabel="variance left", xticks=[0.5, 1, 2, 4])
axes.set(title="white noise of variance 1", xticklabels=[0.5, 1, 2, 4])
axes.minorticks_off()
_ = axes.legend(frameon=False)

# %% [markdown]
# The dashed line takes the sums as they are. If you took integrals for the sums, you have a formula that needs no window. It is
# as good for a wide bell; below about 0.7 pixels a bell falls between the pixels, and less noise goes than that formula says.
#
# ## 4. Two passes instead of one window
#
# The bell of a vector is a product of two bells, one along x and one along y:
#
# $$\exp\left(-\frac{d_x^2 + d_y^2}{2\sigma^2}\right)
# = \exp\left(-\frac{d_x^2}{2\sigma^2}\right) \exp\left(-\frac{d_y^2}{2\sigma^2}\right)$$
#
# So first sum along the rows, then sum the result down the columns: 2 (2 radius + 1) neighbours for each pixel instead of
# (2 radius + 1)².
#
# ### Exercise `gaussian_rows` (write, 3 points)
#
# The first pass. The second is the same function on the image turned over its diagonal; the norms of the two passes multiply.


# %% exercise="gaussian_rows"
def gaussian_rows(image, sigma_space, radius):
    """Sum of w c and sum of w along the rows alone (over x, axis 1).

    Parameters
    ----------
    image : (h, w, c). sigma_space : pixels.
    radius : pixels; the neighbours are those from -radius to radius inside the row.

    Returns
    -------
    total, norm : (h, w, c) and (h, w), floats.
    """
    ### BEGIN SOLUTION
    height, width, _ = image.shape
    total, norm = np.zeros(image.shape), np.zeros((height, width))
    for dx in range(-min(radius, width - 1), min(radius, width - 1) + 1):
        here = slice(max(0, -dx), width - max(0, dx))
        there = slice(max(0, dx), width + min(0, dx))
        weight = np.exp(-(dx**2) / (2 * sigma_space**2))
        total[:, here] += weight * image[:, there]
        norm[:, here] += weight
    return total, norm
    ### END SOLUTION


# %%
check("gaussian_rows")

# %% [markdown]
# What does it buy? On logarithmic axes a cost that grows like $n^k$ is a line of slope $k$: 2 for the window, 1 for two passes.
# The compiled filter, which takes two passes, is faster still.


# %%
def milliseconds(engine, radius):
    start = time.perf_counter()
    mcd.gaussian(noisy, sigma_space=radius / 3, radius=radius, engine=engine)
    return 1e3 * (time.perf_counter() - start)


radii = np.array([2, 4, 8, 16])
n = 2 * radii + 1
window = [min(milliseconds("numpy", radius) for _ in range(3)) for radius in radii]
figure, axes = plt.subplots(figsize=(5, 3), layout="constrained")
axes.loglog(n, window, "o", label="whole window, measured")
axes.loglog(n, window[-1] * n**2 / n[-1] ** 2, "--", label="as n² neighbours cost")
axes.loglog(n, window[-1] * 2 * n / n[-1] ** 2, "--", label="as 2 n neighbours cost")
axes.set(xlabel="n = 2 radius + 1", ylabel="milliseconds", xticks=n, xticklabels=n)
axes.set(title="time for 128 x 128 pixels")
axes.minorticks_off()
_ = axes.legend(frameon=False)
fastest = min(milliseconds("numba", 16) for _ in range(10))
print(f"radius 16: whole window {window[-1]:.0f} ms, compiled two passes {fastest:.2f} ms")

# %% [markdown]
# ## 5. Blur against noise
#
# The filter K is linear, so what it makes of a noisy image splits into two errors:
#
# $$K\,\text{noisy} - \text{ref} = \underbrace{(K\,\text{ref} - \text{ref})}_{\text{blur (bias)}}
# + \underbrace{K\,(\text{noisy} - \text{ref})}_{\text{noise that is left}}$$
#
# The first grows with sigma, the second falls. Somewhere between lies the best sigma.


# %%
def error_curve(noisy, reference, sigmas):
    scale = reference.astype(float) ** 2 + 0.01
    total, blur, noise = [], [], []
    for s in sigmas:
        k_noisy = mcd.gaussian(noisy, sigma_space=s)
        k_reference = mcd.gaussian(reference, sigma_space=s)
        total.append(mcd.relmse(k_noisy, reference))
        blur.append(mcd.relmse(k_reference, reference))
        noise.append(np.mean((k_noisy - k_reference) ** 2 / scale))
    return total, blur, noise


sigmas = np.geomspace(0.3, 4, 25)
total, blur, noise = error_curve(noisy, reference, sigmas)
figure, axes = plt.subplots(figsize=(5.5, 3.2), layout="constrained")
axes.loglog(sigmas, blur, label="blur (bias²)")
axes.loglog(sigmas, noise, label="noise that is left (variance)")
axes.loglog(sigmas, total, linewidth=2.5, label="relMSE")
best = sigmas[np.argmin(total)]
axes.loglog(best, min(total), "o", color="C2", markersize=9)
axes.axhline(mcd.relmse(noisy, reference), linestyle="--", color="gray", label="unfiltered")
axes.set(title=f"dof: best sigma_space {best:.2f}", xlabel="sigma_space (pixels)", ylabel="relMSE")
axes.set(ylim=(1e-3, 0.5), xticks=[0.5, 1, 2, 4], xticklabels=[0.5, 1, 2, 4])
axes.minorticks_off()
_ = axes.legend(frameon=False, fontsize=8)

# %% [markdown]
# ### Exercise `predicted_order` (predict, 1 point)
#
# Three scenes at 8 spp: look at them, then say which wants the smallest sigma_space and which the largest.

# %%
names = ["dof", "pinhole", "soft_shadow"]
renders = {}
for name in names:
    samples = mcd.capture(name, width=128, height=128, spp=8, seed=0)
    renders[name] = mcd.pixel_mean(samples["radiance"])
mcd.show_images(renders, columns=3)

# %% exercise="predicted_order"
predicted_order = None  # your prediction: a list of the three names, smallest sigma_space first
### BEGIN SOLUTION
predicted_order = ["pinhole", "soft_shadow", "dof"]
### END SOLUTION

# %%
check("predicted_order")

# %%
figure, axes = plt.subplots(figsize=(5.5, 3.2), layout="constrained")
for name in names:
    truth = mcd.read_exr(f"data/{name}.exr")
    total, _, _ = error_curve(renders[name], truth, sigmas)
    (line,) = axes.loglog(sigmas, total, label=f"{name}: best {sigmas[np.argmin(total)]:.2f}")
    axes.loglog(sigmas[np.argmin(total)], min(total), "o", color=line.get_color())
    axes.axhline(mcd.relmse(renders[name], truth), linestyle="--", linewidth=0.8, color=line.get_color())
axes.set(xlabel="sigma_space (pixels)", ylabel="relMSE", title="solid: filtered; dashed: unfiltered")
axes.set(xticks=[0.5, 1, 2, 4], xticklabels=[0.5, 1, 2, 4])
axes.minorticks_off()
_ = axes.legend(frameon=False)

# %% [markdown]
# On `pinhole` the Gaussian is worse than doing nothing from about sigma_space 0.42 on: there is little noise and much detail.
#
# ## 6. Borders
#
# What lies outside the image? We say: nothing. The window is clipped, and norm makes up for it. If black is put outside instead,
# a flat grey image gets a dark frame. With $B = \sum_d G_\sigma(d)$ along one axis, the norm is $B^2$ inside and, in a corner,
# where only half of each axis is left,
#
# $$\text{norm}_\text{corner} = \left(\frac{B + 1}{2}\right)^2$$

# %%
flat = np.full((48, 48), 0.5)
ours = mcd.gaussian(flat, sigma_space=2.0, radius=6)
black = mcd.gaussian(np.pad(flat, 6), sigma_space=2.0, radius=6)[6:-6, 6:-6]
B = np.exp(-(np.arange(-6, 7) ** 2) / (2 * 2.0**2)).sum()
print(f"grey left in the corner: {black[0, 0] / 0.5:.4f}")
print(f"closed form (B + 1)² / (4 B²): {(B + 1) ** 2 / (4 * B**2):.4f}")
mcd.show_images({"ours: divided by norm": ours, "black outside: divided by B²": black})

# %% [markdown]
# ## 7. Break it
#
# ### Exercise `hard_image` (break, 2 points)
#
# Invent an image that **no** Gaussian from sigma_space 0.5 to 4 improves, although noise of standard deviation 0.1 is added to
# it. (At a sigma_space small enough, here below about 0.3, nobody can win: a neighbour's weight that is tiny, say
# $\varepsilon$, removes noise in proportion to $\varepsilon$, but adds blur only in proportion to $\varepsilon^2$.)


# %% exercise="hard_image"
def hard_image(height, width):
    """An image that every Gaussian from sigma_space 0.5 to 4 makes worse.

    Parameters
    ----------
    height, width : whole numbers >= 20, pixels.

    Returns
    -------
    image : (height, width), radiance in [0, 1]. The tests add the noise.
    """
    ### BEGIN SOLUTION
    y, x = np.mgrid[:height, :width]
    return (x + y) % 2.0
    ### END SOLUTION


# %%
check("hard_image")

# %% [markdown]
# ### Exercise `stubborn_noise` (break, 2 points)
#
# The formula of section 3 trusted that pixels err independently. Invent noise that does not keep to that: mean 0, variance 1, and
# a Gaussian of sigma_space 2 leaves more than half of its variance, where white noise leaves 2 %.


# %% exercise="stubborn_noise"
def stubborn_noise(height, width, seed):
    """Noise that a Gaussian of sigma_space 2 hardly reduces.

    Parameters
    ----------
    height, width : whole numbers >= 20, pixels. seed : whole number; another seed gives other noise.

    Returns
    -------
    noise : (height, width), with mean 0 and standard deviation 1 over its pixels.
    """
    ### BEGIN SOLUTION
    coarse = np.random.default_rng(seed).standard_normal((height // 10 + 1, width // 10 + 1))
    noise = np.kron(coarse, np.ones((10, 10)))[:height, :width]
    return (noise - noise.mean()) / noise.std()
    ### END SOLUTION


# %%
check("stubborn_noise")

# %% [markdown]
# This is why a second Gaussian after a first one helps so little: the noise that the first one leaves is of just this kind.
#
# ## What you should be able to do now
#
# - write a windowed filter as two sums, and say why they are kept apart;
# - say from one bright pixel whether a filter is right;
# - predict how much of independent noise a Gaussian leaves, and when that formula fails;
# - turn a window into two passes, and say what that saves;
# - split an error into blur and noise, and say which scene wants a larger sigma.
#
# Chapter 03 keeps "near" and adds a second idea, so that edges survive: *alike in colour*.
