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
# # 01 Noise: a pixel is an integral
#
# A renderer does not compute a pixel, it **estimates** it: it averages a few random light paths. What is left of the randomness
# is the noise that this whole course is about. Here you measure it, predict it, fool it, and look inside one scanline, where
# the noise turns out to have a shape.
#
# Seven exercises, 17 points, about 50 minutes. After each one, `check` tells you what holds and what does not. Hidden tests
# try other sizes and limits, so read the contract in the docstring.

# %%
import matplotlib.pyplot as plt
import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import check

# %% [markdown]
# ## 1. A pixel is an integral
#
# A pixel is the mean of the radiance $f$ over everything a camera ray may do: where in the pixel it starts $(x, y)$, where it
# crosses the lens $(u, v)$, which point of the light it asks for $(l_u, l_v)$ (`light_u` and `light_v` in the code):
#
# $$I = \int\!\!\int\!\!\int\!\!\int\!\!\int\!\!\int f(x, y; u, v; l_u, l_v)\; dx\, dy\, du\, dv\, dl_u\, dl_v
# \;\approx\; \frac{1}{N} \sum_{i=1}^{N} f(x_i, y_i; u_i, v_i; l_{u,i}, l_{v,i})$$
#
# (This scene has no motion, so no time $t$.) `mcd.capture` renders a scene and keeps every sample with its random numbers.

# %%
samples = mcd.capture("dof", width=128, height=128, spp=32, seed=0)
print(samples.layout)
samples

# %% [markdown]
# One pixel, 32 samples, one mean: the blurred edge of the ball in front. The samples come from two surfaces, and hardly one has
# the radiance of the pixel.

# %%
y, x = 94, 101
f = samples.radiance[y, x].mean(axis=1)
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
left.imshow(np.clip(mcd.pixel_mean(samples.radiance), 0, 1) ** (1 / 2.2))
left.plot(x, y, "s", color="white", markerfacecolor="none")
left.set(title="32 spp; the pixel", xticks=[], yticks=[])
right.hist(f, bins=20)
right.axvline(f.mean(), color="black", label=f"their mean: {f.mean():.3f}")
right.set(xlabel="radiance of a sample", ylabel="samples", title="32 samples of one pixel")
_ = right.legend(frameon=False)

# %% [markdown]
# ## 2. How far off is a mean?
#
# The samples are independent, so their variances add, and dividing by $N$ divides the variance by $N^2$:
#
# $$\operatorname{Var}\Big[\frac1N \sum_i f_i\Big] = \frac{1}{N^2} \sum_i \operatorname{Var}[f_i] = \frac{\sigma^2}{N},
# \qquad \sigma^2 \approx s^2 = \frac{1}{N - 1} \sum_i (f_i - \bar f)^2$$
#
# ($N - 1$, because the mean $\bar f$ was made from the same samples and lies closer to them than the truth does.)
#
# ### Exercise `variance_of_mean` (write, 3 points)


# %% exercise="variance_of_mean"
def variance_of_mean(samples):
    """Estimate, from the samples of each pixel, the variance of their mean.

    Parameters
    ----------
    samples : (h, w, spp, c), radiance; at least 2 spp.

    Returns
    -------
    variance : (h, w, c), radiance squared: the expected squared distance of the pixel's mean from the truth, in each
        channel by itself. For `dof` at 32 spp about 0.001 in the mean; 0 where all samples are equal.
    """
    ### BEGIN SOLUTION
    mean = samples.mean(axis=2, keepdims=True)
    return ((samples - mean) ** 2).sum(axis=2) / (samples.shape[2] - 1) / samples.shape[2]
    ### END SOLUTION


# %%
check("variance_of_mean")

# %% [markdown]
# Does it know the true error? Left what the samples say of themselves, right how far the image really is from the reference of
# 4096 spp. The right one is a single throw of dice in each pixel; on average both say the same.

# %%
reference = mcd.read_exr("data/dof.exr")
noisy = mcd.pixel_mean(samples.radiance)
estimated = np.sqrt(variance_of_mean(samples.radiance).mean(axis=2))
real = np.sqrt(mcd.squared_error_map(noisy, reference).mean(axis=2))
print(f"mean square: estimated {np.mean(estimated**2):.5f}, real {np.mean(real**2):.5f}")
mcd.show_images({"estimated standard deviation x 10": 10 * estimated, "real error x 10": 10 * real})

# %% [markdown]
# ## 3. One number for an image
#
# An error of 0.1 is much in a shadow and nothing in a lamp. So each squared error is divided by the squared reference, and a
# small $\varepsilon$ keeps black pixels from counting without bound:
#
# $$\text{relMSE} = \operatorname{mean}\; \frac{(\text{image} - \text{ref})^2}{\text{ref}^2 + \varepsilon}$$
#
# ### Exercise `relmse` (write, 3 points)


# %% exercise="relmse"
def relmse(image, reference, epsilon):
    """Relative mean squared error of an image.

    Parameters
    ----------
    image, reference : (h, w, c), radiance >= 0; the reference may be 0 in places.
    epsilon : radiance squared, > 0; the house uses 0.01.

    Returns
    -------
    A number without unit, the mean over pixels and channels: 0 for the reference itself. Some 0.5 at 1 spp, 0.01 at
        64 spp for `dof`.
    """
    ### BEGIN SOLUTION
    return np.mean((image - reference) ** 2 / (reference**2 + epsilon))
    ### END SOLUTION


# %%
check("relmse")

# %% [markdown]
# ### Exercise `spp_needed` (predict, 2 points)
#
# An image has 16 spp. How many spp bring its **RMS error** (the square root of the mean squared error) down to a half? How many
# its **relMSE**? Write both numbers before you go on; the curve comes after.

# %% exercise="spp_needed"
spp_needed = None  # your prediction: (spp for half the RMS error, spp for half the relMSE)
### BEGIN SOLUTION
spp_needed = (64, 32)
### END SOLUTION

# %%
check("spp_needed")

# %% [markdown]
# Deal the 32 samples of each pixel out to $32 / N$ images of $N$ spp, and average their errors. A power law is a straight line in
# a double logarithmic chart; the slope is the power.

# %%
N = np.array([1, 2, 4, 8, 16, 32])
errors = []
for n in N:
    images = [mcd.pixel_mean(part) for part in np.split(samples.radiance, 32 // n, axis=2)]
    errors.append(np.mean([relmse(image, reference, 0.01) for image in images]))
slope = np.polyfit(np.log(N), np.log(errors), 1)[0]
figure, axes = plt.subplots(figsize=(5, 3), layout="constrained")
axes.loglog(N, errors, "o", label=f"relMSE: slope {slope:.2f}")
axes.loglog(N, errors[0] / N, "--", color="gray", label="1 / N")
axes.loglog(N, np.sqrt(errors), "s", label=f"its root: slope {slope / 2:.2f}")
axes.loglog(N, np.sqrt(errors[0] / N), ":", color="gray", label="1 / sqrt(N)")
axes.set(xlabel="samples per pixel N", ylabel="error", title="dof")
axes.yaxis.set_minor_formatter(plt.NullFormatter())
_ = axes.legend(frameon=False)

# %% [markdown]
# Move the slider: two steps cost four times the time and take half the noise. That is why nobody renders noise away.

# %%
mcd.slider(lambda spp: mcd.pixel_mean(samples.radiance[:, :, :spp]), title="dof", spp=[1, 2, 4, 8, 16, 32])

# %% [markdown]
# ## 4. Break the estimate
#
# The variance is estimated from the same few samples as the mean. If something bright and rare was not hit, **both** are wrong,
# and nothing warns you. Such samples are called fireflies.
#
# ### Exercise `firefly` (break, 2 points)
#
# Invent a pixel (a radiance for each random number) with mean 1 whose samples nearly always look quiet.


# %% exercise="firefly"
def firefly(u):
    """Radiance of the samples of a pixel that fools the variance estimate.

    Parameters
    ----------
    u : (n,), random numbers in [0, 1), one for each sample; n may be large.

    Returns
    -------
    values : (n,), >= 0, each a function of its own u. Their mean over all u in [0, 1) is 1 (within 2 %; the test looks at
        200 000 evenly spaced u). In at least 9 of 10 pixels of 16 samples the estimated variance of the mean is below a
        tenth of the true one.
    """
    ### BEGIN SOLUTION
    return np.where(u < 0.001, 1000.0, 0.0)
    ### END SOLUTION


# %%
check("firefly")

# %%
u = np.random.default_rng(0).random((20_000, 16))
means = firefly(u.ravel()).reshape(u.shape).mean(axis=1)
print(
    f"20 000 pixels, all with the true value 1: the middle one shows {np.median(means):.3f}, their mean {means.mean():.2f}"
)
figure, axes = plt.subplots(figsize=(5, 2.6), layout="constrained")
axes.hist(means, bins=40, log=True)
_ = axes.set(xlabel="pixel at 16 spp", ylabel="pixels", title="true value: 1")

# %% [markdown]
# ## 5. The thin lens
#
# A lens of radius $A$ is focused at the distance $d_f$: all rays that belong to one point of the screen meet again on the plane
# of focus, wherever they cross the lens. Take a point at depth $d$ and walk from the lens place $X$ through it to the plane of
# focus: by similar triangles the ray arrives $X\,(1 - d_f / d)$ beside the ray that comes from the middle of the lens.
#
# The lens is $2A$ wide, so the point smears over the **circle of confusion** of diameter $c = 2A\,|d - d_f| / d$.
#
# In our samples the number `lens_u` runs over the lens from right to left, $X = A\,(1 - 2u)$ (for $v = \frac12$), and one scene
# unit on the plane of focus is $k$ pixels (`pixels_per_unit`). So on the screen the point moves along a straight line,
#
# $$x(u) = x_0 + \text{slope} \cdot \left(u - \tfrac12\right)$$
#
# ### Exercise `light_field_slope` (write, 2 points)
#
# Put the pieces together. Check the sign: a point far behind the plane of focus moves to smaller x as u grows.


# %% exercise="light_field_slope"
def light_field_slope(depth, focus_distance, lens_radius, pixels_per_unit):
    """How far a point moves on the screen while the ray's place on the lens goes from u = 0 to u = 1.

    Parameters
    ----------
    depth : a number or an array of any shape, > 0, scene units, measured along the axis of the camera.
    focus_distance, lens_radius : scene units, > 0.
    pixels_per_unit : pixels on the screen for one scene unit on the plane of focus.

    Returns
    -------
    slope : pixels, shape of `depth`. 0 in focus, positive in front, negative behind; its magnitude is the diameter of the
        circle of confusion. For `dof` 128 pixels wide between -17 and 15.
    """
    ### BEGIN SOLUTION
    return 2 * lens_radius * pixels_per_unit * (focus_distance / depth - 1)
    ### END SOLUTION


# %%
check("light_field_slope")

# %% [markdown]
# Against the samples: each knows the world position that it hit, so its depth $d$, and where the middle of the lens would have
# seen that point, $x_0$. Divide what it moved by $u - \frac12$, and there is the slope. (We take samples near the horizontal
# diameter of the lens, $|v - \frac12| < 0.02$.)

# %%
focus_distance, lens_radius, pixels_per_unit = 5.3, 0.22, 128 / (2 * 5.3 * np.tan(np.radians(17)))
camera, target = np.array([0.0, -5.4, 1.7]), np.array([0.0, 0.4, 0.68])
forward = (target - camera) / np.linalg.norm(target - camera)
right = np.array([1.0, 0.0, 0.0])

diameter = samples.hit & (np.abs(samples["lens_v"] - 0.5) < 0.02) & (np.abs(samples["lens_u"] - 0.5) > 0.25)
position, u = samples["world_position"][diameter] - camera, samples["lens_u"][diameter]
depth = position @ forward
x_0 = 64 + pixels_per_unit * focus_distance * (position @ right) / depth
measured = (samples.screen_position[diameter][:, 0] - x_0) / (u - 0.5)
predicted = light_field_slope(depth, focus_distance, lens_radius, pixels_per_unit)
print(f"{len(u)} samples; largest difference {np.abs(measured - predicted).max():.2f} pixels")
d = np.linspace(2.8, 14, 200)
figure, axes = plt.subplots(figsize=(5, 3), layout="constrained")
axes.plot(depth, measured, ".", markersize=4, label="samples")
axes.plot(d, light_field_slope(d, focus_distance, lens_radius, pixels_per_unit), "k", linewidth=0.8, label="yours")
axes.axhline(0, color="gray", linewidth=0.6)
axes.set(xlabel="depth (scene units)", ylabel="slope (pixels)", xlim=(2.6, 14), title="in focus at 5.3 scene units")
_ = axes.legend(frameon=False)

# %% [markdown]
# ## 6. One scanline as a light field
#
# Take row 60 of the image, and draw each sample not at its pixel alone but at (x, u). The noise of defocus turns into order:
# every point of a surface draws a straight line, and **its slope is its depth**. (The file holds the row at 64 places on the
# lens and two columns to a pixel; it was written by `store_scanline` in `mcdenoise.study.figures._ch01_lightfield`.)

# %%
light_field = mcd.read_exr("data/dof_scanline.exr")
print("rows u, columns x, channels:", light_field.shape)
here = np.abs(samples["lens_v"][60] - 0.5) < 0.02
figure, axes = plt.subplots(figsize=(8, 3.4), layout="constrained")
axes.imshow(np.clip(light_field, 0, 1) ** (1 / 2.2), aspect="auto", origin="lower", extent=(0, 128, 0, 1))
for name, x_0, depth in (("near", 23.0, 4.55), ("in focus", 73.0, 5.06), ("far", 40.0, 8.29)):
    slope = light_field_slope(depth, focus_distance, lens_radius, pixels_per_unit)
    axes.plot(x_0 + slope * np.array([-0.5, 0.5]), [0, 1], linewidth=2.5, label=f"{name}: slope {slope:+.1f}")
x, u = samples.screen_position[60][here][:, 0], samples["lens_u"][60][here]
colours = np.clip(samples.radiance[60][here], 0, 1) ** (1 / 2.2)
axes.scatter(x, u, s=16, c=colours, edgecolors="black", label="samples of row 60")
axes.set(xlabel="screen x (pixels)", ylabel="lens u", title="row 60 of dof as a light field")
_ = axes.legend(loc="upper right", fontsize=8)

# %% [markdown]
# A pixel of the image is the mean of one column of this picture. Its noise comes from drawing a few points of that column at
# random.
#
# Two points of one surface that are seen all over the lens keep their order on the screen: **their lines never cross**. Where two
# lines do cross, one ray meets both points; then the nearer hides the farther, and the two lie on different surfaces. So from two
# samples alone you can tell that they must not be averaged.
#
# ### Exercise `crossing_samples` (break, 2 points)
#
# Give two samples of `dof` that look like good neighbours (at most 3 pixels apart on the screen), but whose trajectories cross
# for some u between 0 and 1. Here x is where the sample itself lies on the screen, at its own u (not $x_0$).

# %% exercise="crossing_samples"
crossing_samples = None  # two rows, one for each sample: [[x, u, depth], [x, u, depth]] (pixels, 0 to 1, scene units)
### BEGIN SOLUTION
crossing_samples = [[31.5, 0.9, 4.55], [34.0, 0.1, 8.29]]
### END SOLUTION

# %%
check("crossing_samples")

# %% [markdown]
# ## 7. Refocus after the fact
#
# Shift every row so that lines of one slope stand upright, then average over u: what has that slope becomes sharp, as if the lens
# had been focused there.
#
# $$\text{row}(x) = \operatorname{mean}_u\; L\!\left(x + \text{slope} \cdot (u - \tfrac12),\; u\right)$$
#
# ### Exercise `refocus` (write, 3 points)


# %% exercise="refocus"
def refocus(light_field, slope):
    """Average a light field over u along lines of one slope.

    Parameters
    ----------
    light_field : (n_u, n_x, c), radiance; row k stands for u = (k + 1/2) / n_u, columns for whole numbers x.
    slope : columns that a line moves while u goes from 0 to 1; any sign, not always whole.

    Returns
    -------
    row : (n_x, c), the mean over u of the radiance at x + slope (u - 1/2), interpolated linearly between columns;
        beyond the border the last column is repeated (np.interp does both, one channel at a time). In radiance.
    """
    ### BEGIN SOLUTION
    n_u, n_x, channels = light_field.shape
    x = np.arange(n_x)
    row = np.zeros((n_x, channels))
    for k in range(n_u):
        place = x + slope * ((k + 0.5) / n_u - 0.5)
        for c in range(channels):
            row[:, c] += np.interp(place, x, light_field[k, :, c])
    return row / n_u
    ### END SOLUTION


# %%
check("refocus")

# %% [markdown]
# The scanline for eight distances of focus, one below the other. Which ball is sharp where? (The file has two columns to a pixel,
# hence the factor 2.)

# %%
distances = np.array([3.9, 4.55, 5.06, 5.3, 6.0, 6.7, 8.3, 10.0])
slopes = 2 * light_field_slope(distances, focus_distance, lens_radius, pixels_per_unit)
rows = np.stack([refocus(light_field, slope) for slope in slopes])
figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
axes.imshow(np.clip(rows, 0, 1) ** (1 / 2.2), aspect="auto", extent=(0, 128, len(rows), 0), interpolation="nearest")
axes.set_yticks(np.arange(len(rows)) + 0.5, [f"{d:g}" for d in distances])
_ = axes.set(xlabel="screen x (pixels)", ylabel="focused at (scene units)", title="one scanline, refocused")

# %% [markdown]
# ## 8. The sample vector
#
# Everything that is known of a sample is one vector, and chapters 05 and 06 work with nothing else:
#
# $$\mathbf{x}_i = \{\; \underbrace{\mathbf p_i}_{\text{screen}};\; \underbrace{\mathbf r_i}_{\text{random}};\;
# \underbrace{\mathbf f_i}_{\text{features}};\; \underbrace{\mathbf c_i}_{\text{colour}} \;\}$$
#
# Six views of the samples of 7 x 7 pixels on the blurred edge of the ball in front, coloured by the surface that was hit. In
# which panels do the two surfaces fall apart, and in which are they mixed?

# %%
near = samples.crop(90, 98, 7, 7).subset(0, 8)
ball = ((near["world_position"] - camera) @ forward < 3.9).ravel()
panels = {
    "(a) screen position": (near.screen_position, "x (pixels)", "y (pixels)"),
    "(b) place on the lens": (near.random_params[..., :2], "lens u", "lens v"),
    "(c) world position": (near["world_position"], "x (scene units)", "y (scene units)"),
    "(d) shading normal": (near["shading_normal"], "x", "y"),
    "(e) albedo": (near["albedo"], "red", "green"),
    "(f) radiance": (near.radiance, "red (radiance)", "green (radiance)"),
}
figure, grid = plt.subplots(2, 3, figsize=(8, 5), layout="constrained")
for axes, (title, (values, across, up)) in zip(grid.flat, panels.items(), strict=True):
    first, second = values.reshape(len(ball), -1)[:, :2].T
    axes.plot(first[ball], second[ball], "o", markersize=3, label="ball")
    axes.plot(first[~ball], second[~ball], "^", markersize=3, label="floor")
    axes.set(title=title, xlabel=across, ylabel=up)
grid[0, 0].invert_yaxis()  # as on the screen: y runs down
_ = grid[0, 2].legend(frameon=False)

# %% [markdown]
# The world position tells the surfaces apart, but a *pixel's mean* of it lies on neither: it is as noisy as the colour. The lens
# numbers (b) say better than the screen (a) which surface a sample hits. Hold on to that: it is the idea behind chapter 05.
#
# ## What you should be able to do now
#
# - say which integral a pixel is, and why its estimate is noisy;
# - estimate the noise of a pixel from its samples, and say when that estimate fails;
# - predict how error falls with spp, as RMS error and as relMSE;
# - compute the circle of confusion, and read depth off a slope in the light field;
# - say from two samples that they lie on different surfaces;
# - name the parts of the sample vector.
#
# Chapter 02 starts to remove the noise with the simplest idea there is: *near*.
