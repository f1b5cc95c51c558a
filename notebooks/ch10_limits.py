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
# # 10 Limits: speed, stability, and no more model than needed
#
# Nine chapters, ten filters. Which one should you take? Three questions decide. What does it cost beside what it gains, and
# what would plain Monte Carlo do with the same time? What does it do to an input that nobody had in mind? And what of it does
# this scene need at all? You answer each of them with numbers: a chart, a split of the error, a test against chance.
#
# Eleven exercises, 15.5 points, about 60 minutes. After each one, `check` tells you what holds and what does not. Hidden tests
# try other sizes and numbers, so read the contract in the docstring.

# %%
import time

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

import mcdenoise as mcd
from mcdenoise.classroom import check
from mcdenoise.study.charts import COLOURS, GREY, MARKERS
from mcdenoise.study.methods import METHODS
from mcdenoise.study.tune import choose_parameters

# %% [markdown]
# ## Speed against accuracy
#
# The stage behind the thin lens, 8 samples per pixel (spp). The rival of every filter is *more samples*: Monte Carlo at
# several spp, each timed.


# %%
def seconds_of(call, runs=3):
    """The median time of some calls, fewer if they are slow, and what the last one returned."""
    taken = []
    while len(taken) < runs and sum(taken) < 0.5:
        start = time.perf_counter()
        image = call()
        taken.append(time.perf_counter() - start)
    return float(np.median(taken)), image


samples = mcd.capture("dof", width=128, height=128, spp=8, seed=0)
reference = mcd.read_exr("data/dof.exr")
noisy = mcd.pixel_mean(samples.radiance)
spp = np.array([8, 32, 128])
mcd.render_image("dof", width=128, height=128, spp=8, seed=1)  # the first call also compiles
mc_seconds, mc_images = zip(
    *(seconds_of(lambda n=n: mcd.render_image("dof", width=128, height=128, spp=n, seed=1), 1) for n in spp.tolist()),
    strict=True,
)
mc_errors = np.array([mcd.relmse(image, reference) for image in mc_images])
seconds_per_spp, fixed_seconds = np.polyfit(spp, mc_seconds, 1)
fixed_seconds = max(fixed_seconds, 0.0)
for n, taken, error in zip(spp, mc_seconds, mc_errors, strict=True):
    print(f"Monte Carlo, {n:3} spp: {taken:.3f} s, relMSE {error:.4f}")

# %% [markdown]
# Seven of our methods on the same samples. Their bandwidths are chosen by halves of the samples, so none of them has seen the
# reference. The time of a filtered image is that of rendering 8 spp and of filtering.

# %%
CHOSEN = ("gaussian", "bilateral", "cross_bilateral_prefiltered", "nlm", "joint_nlm", "rpf", "lbf")
STYLE = dict(zip(METHODS, zip(COLOURS, MARKERS, strict=True), strict=True))
parameters, filter_seconds, images = {}, {}, {}
for name in CHOSEN:
    method = METHODS[name]
    parameters[name] = choose_parameters(method, samples)
    method.run(samples, **parameters[name])  # the first call may compile
    filter_seconds[name], images[name] = seconds_of(lambda m=method, p=parameters[name]: m.run(samples, **p))
errors = {name: mcd.relmse(image, reference) for name, image in images.items()}
rendering = fixed_seconds + 8 * seconds_per_spp
seconds = {name: rendering + filter_seconds[name] for name in CHOSEN}
shown = {f"{METHODS[name].label}: {errors[name]:.4f}": image for name, image in images.items()}
mcd.show_images({f"noisy: {mcd.relmse(noisy, reference):.4f}": noisy} | shown, columns=4)

# %% [markdown]
# ### Exercise 1 (write): the front
#
# A method is out of the question where another one is at least as fast *and* at least as accurate, and better in one of the
# two. Those that are left are the *Pareto front*: the choice between them is yours.

# %% exercise="pareto_front"
from mcdenoise.study.front import pareto_front

# %%
check("pareto_front")


# %%
def draw_chart(seconds, errors, more=None):
    """The chart: Monte Carlo as a line, each method a point; a ring around those on the front."""
    names = [*seconds, *(more or {})]
    points = [(seconds[name], errors[name]) for name in seconds] + list((more or {}).values())
    points += list(zip(mc_seconds, mc_errors, strict=True))
    on_front = pareto_front(*np.array(points).T)
    figure, axes = plt.subplots(figsize=(8, 4.6), layout="constrained")
    axes.plot(mc_seconds, mc_errors, "x--", color=GREY, label="Monte Carlo, 8, 32, 128 spp")
    for name, (x, y) in zip(names, points, strict=False):
        colour, marker = STYLE.get(name, ("black", "*"))
        label = METHODS[name].label if name in METHODS else name
        axes.plot(x, y, marker, color=colour, markersize=13 if marker == "*" else 8, label=label, linestyle="none")
    front = np.array(points)[on_front]
    axes.plot(*front.T, "o", fillstyle="none", color="black", markersize=16, label="on the front")
    axes.set(xscale="log", yscale="log", xlabel="rendering and filtering (s)", ylabel="relMSE", title="dof, 8 spp")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())
    axes.grid(color="0.92")
    figure.legend(loc="outside right upper", fontsize=8, markerscale=0.8, labelspacing=0.9)


draw_chart(seconds, errors)

# %% [markdown]
# Every time on this chart depends on the machine and on the renderer: on a scene whose samples cost a hundred times as much,
# all filters move together towards the left end of Monte Carlo's line. So it is better to say what a filter is worth *in
# samples*.
#
# ### Exercise 2 (write): equal error
#
# How many samples would plain Monte Carlo need for the same error? Its curve was measured at some spp. On logarithmic axes it
# is nearly straight, with slope -1, so draw a straight line there between two measured points.

# %% exercise="equal_error_spp"
from mcdenoise.study.front import equal_error_spp

# %%
check("equal_error_spp")

# %% [markdown]
# Beside it the other comparison, at equal time: what would Monte Carlo make of the seconds of the filter?

# %%
from mcdenoise.study.front import equal_time_error

print(f"{'8 spp and':28} relMSE   is that of Monte Carlo at   Monte Carlo in the same time")
for name in CHOSEN:
    as_many = equal_error_spp(errors[name], spp, mc_errors)
    rival = equal_time_error(seconds[name], fixed_seconds, seconds_per_spp, spp, mc_errors)
    print(f"{METHODS[name].label:28} {errors[name]:.4f} {as_many:18.0f} spp {rival:26.4f}")

# %% [markdown]
# ### Does it stay so?
#
# More samples take noise away, but no bias. Take a filter that leaves the squared bias 0.002 and the variance 0.04 / n, with n
# the spp. Monte Carlo has no bias, and the variance 0.2 / n.
#
# ### Exercise 3 (predict): where plain Monte Carlo catches up
#
# At how many spp are both equally wrong? Predict before you run the cell below the check.

# %% exercise="break_even_spp"
break_even_spp = None  # samples per pixel
### BEGIN SOLUTION
break_even_spp = 80
### END SOLUTION

# %%
check("break_even_spp")

# %% [markdown]
# On the stage: a Gaussian of 1 pixel is linear, so its bias is what it does to the reference. With that and the errors at 8 spp
# both lines can be drawn to the end. The points are measured, at spp that the lines have not seen.

# %%
blur = {n: mcd.gaussian(image, sigma_space=1.0) for n, image in zip(spp.tolist(), mc_images, strict=True)}
bias_squared = mcd.relmse(mcd.gaussian(reference, sigma_space=1.0), reference)
variances = {"Monte Carlo": 8 * mc_errors[0], "Gaussian": 8 * (mcd.relmse(blur[8], reference) - bias_squared)}
n = np.geomspace(4, 256, 50)
figure, axes = plt.subplots(figsize=(7, 3.8), layout="constrained")
axes.plot(n, variances["Monte Carlo"] / n, color=GREY, label="Monte Carlo: V / n")
axes.plot(n, bias_squared + variances["Gaussian"] / n, color=STYLE["gaussian"][0], label="Gaussian: b + v / n")
axes.axhline(bias_squared, color=STYLE["gaussian"][0], linestyle=":", label="b, its squared bias")
axes.plot(spp, mc_errors, "x", color=GREY)
axes.plot(spp, [mcd.relmse(image, reference) for image in blur.values()], "o", color=STYLE["gaussian"][0])
crossing = (variances["Monte Carlo"] - variances["Gaussian"]) / bias_squared
axes.axvline(crossing, color="black", linewidth=0.8)
axes.set(xscale="log", yscale="log", xlabel="n (spp)", ylabel="relMSE", title=f"equally wrong at {crossing:.0f} spp")
axes.legend(fontsize=8)
_ = axes.grid(which="both", color="0.92")

# %% [markdown]
# A better filter has a smaller bias, or narrows its bandwidths as the noise falls, and so it stays ahead for longer. But a
# filter whose bias stays is overtaken in the end, whatever its speed.
#
# ### Exercise 4 (write): a method of your own
#
# Now put a new point on the chart. Make a filter from anything that you have learnt; it gets the samples, and the albedo of
# each pixel. On the wall of the test, tiles under uneven light, the albedo is free of noise, and no plain Gaussian is good
# enough.


# %% exercise="new_method"
def new_method(radiance, albedo):
    """A filter of your own.

    radiance : (h, w, spp, 3), samples, spp >= 4. albedo : (h, w, 3), of each pixel, from 0 to 1; 0 is black paint.

    Returns an image (h, w, 3), finite, in radiance. On tiles under uneven light its relMSE is at most 0.3 times that of the
    noisy image, the mean of the samples.
    """
    ### BEGIN SOLUTION
    height, width, spp, _ = radiance.shape

    def blurred(image, sigma):
        bells = [np.exp(-np.square(np.subtract.outer(np.arange(n), np.arange(n)) / sigma) / 2) for n in (height, width)]
        down, across = (bell / bell.sum(axis=1, keepdims=True) for bell in bells)
        return np.einsum("yj,xk,jkc->yxc", down, across, image, optimize=True)

    paint = np.maximum(albedo, 0.1)
    light = radiance / paint[:, :, np.newaxis]
    mean, noise = light.mean(axis=2), light.var(axis=2).mean(axis=-1, keepdims=True) / spp
    smooth, noise = blurred(mean, 0.7), blurred(noise, 2.0)
    total, norm = np.zeros(mean.shape), np.zeros(noise.shape)
    for dy in range(-4, 5):
        for dx in range(-4, 5):
            p = np.s_[max(0, -dy) : height - max(0, dy), max(0, -dx) : width - max(0, dx)]
            q = np.s_[max(0, dy) : height + min(0, dy), max(0, dx) : width + min(0, dx)]
            unlike = np.mean((smooth[p] - smooth[q]) ** 2, axis=-1, keepdims=True) / (
                1.5 * (noise[p] + noise[q]) + 1e-10
            )
            unlike += np.sum((albedo[p] - albedo[q]) ** 2, axis=-1, keepdims=True) / 0.18
            weight = np.exp(-unlike - (dy**2 + dx**2) / 8)
            total[p] += weight * mean[q]
            norm[p] += weight
    return paint * total / norm
    ### END SOLUTION


# %%
check("new_method")

# %% [markdown]
# Yours on the chart. Here the albedo comes from behind a lens, with noise in it (chapter 04).

# %%
albedo = mcd.pixel_mean(samples["albedo"])
taken, mine = seconds_of(lambda: new_method(samples.radiance, albedo))
point = (rendering + taken, mcd.relmse(mine, reference))
print(
    f"yours: {taken:.3f} s, relMSE {point[1]:.4f}, that of Monte Carlo at {equal_error_spp(point[1], spp, mc_errors):.0f} spp"
)
draw_chart(seconds, errors, {"yours": point})

# %% [markdown]
# ## Stability
#
# One image and one seed say little: a filter may be right on average and different each time, or the same each time and
# wrong. For images $x_1 \dots x_n$ of $n$ seeds and the truth $t$, in each pixel:
#
# $$ s^2 = \frac{1}{n-1} \sum_k (x_k - \bar x)^2 \qquad b^2 \approx (\bar x - t)^2 - \frac{s^2}{n} $$
#
# ### Exercise 5 (write): bias and variance apart

# %% exercise="bias_and_variance"
from mcdenoise.study.robust import bias_and_variance

# %%
check("bias_and_variance")

# %% [markdown]
# Five seeds, five ways. Both parts are divided by $t^2 + 0.01$, so that they add up to the relMSE of one image.

# %%
WAYS = ("noisy", "gaussian", "cross_bilateral_prefiltered", "nlm", "lbf")
stacks = {name: [] for name in WAYS}
for seed in range(5):
    one = mcd.capture("dof", width=128, height=128, spp=8, seed=100 + seed)
    stacks["noisy"].append(mcd.pixel_mean(one.radiance))
    for name in WAYS[1:]:
        stacks[name].append(METHODS[name].run(one, **parameters[name]))
parts = {
    name: [part / (reference**2 + 0.01) for part in bias_and_variance(np.array(stack), reference)]
    for name, stack in stacks.items()
}
labels = [METHODS[name].label if name in METHODS else name for name in WAYS]
bias_means, variance_means = np.array([[part.mean() for part in parts[name]] for name in WAYS]).T
figure, axes = plt.subplots(figsize=(8, 3.2), layout="constrained")
axes.barh(labels, bias_means, color="#4477AA", label="squared bias: wrong each time")
bars = axes.barh(labels, variance_means, left=bias_means, color="#CCBB44", label="variance: different each time")
worst = [max(mcd.relmse(image, reference) for image in stacks[name]) for name in WAYS]
axes.plot(worst, labels, "k|", markersize=14, label="relMSE of the worst seed")
axes.invert_yaxis()
axes.set(xlabel="relMSE", title="dof, 8 spp, 5 seeds")
_ = axes.legend(fontsize=8)

# %%
figure, grid = plt.subplots(2, len(WAYS), figsize=(12, 5.2), layout="constrained")
for column, name, label in zip(grid.T, WAYS, labels, strict=True):
    for axes, part, what in zip(column, parts[name], ("squared bias", "variance"), strict=True):
        shown = axes.imshow(
            np.sqrt(np.maximum(part.mean(axis=-1), 0)), vmin=0, vmax=0.3, cmap="magma", interpolation="nearest"
        )
        axes.set_title(f"{label.replace(', ', chr(10))}\n{what}", fontsize=9)
        axes.axis("off")
_ = figure.colorbar(shown, ax=grid, label="root, relative", shrink=0.6)

# %% [markdown]
# The filters take variance away and put bias in its place: at edges, in shadows, around the lamps, the same each time. More
# seeds, or a mean over frames of an animation, would take the rest of the variance, and leave the bias. The noisy image has none;
# the grain in its upper map is what five seeds leave over after the correction, and its mean is 0 up to chance.
#
# ### One pixel
#
# Filters are made for noise that is spread evenly. A *firefly* is a sample with far too much light. Add $a$ to one pixel, away
# from the border: the Gaussian makes a bell of it, and the sum of the bell's squares is $1 / (4 \pi \sigma^2)$. So the sum over
# all pixels of the squared damage is about
#
# $$ \sum_p \Delta_p^2 \approx \frac{a^2}{4 \pi \sigma^2} $$
#
# A wider filter spreads the damage, and makes it smaller, but it never goes away: it grows with $a^2$, and nothing bounds $a$.
#
# ### Exercise 6 (break): one pixel, and no more than needed


# %% exercise="one_pixel"
def one_pixel(noisy, truth, sigma_space, factor):
    """Change one pixel so that the filtered image gets worse by a factor.

    noisy, truth : (h, w), grey, 24 pixels or more in each direction. The filter F is a Gaussian: the weight of pixel q for
        pixel p is exp(-d^2 / (2 sigma_space^2)), d their distance, q any pixel of the image, divided by the sum of weights.
    factor : from 10 to 1000

    Returns an image (h, w), equal to noisy in all pixels but one, there not negative, whose mean of (F(image) - truth)^2 is at
    least factor times and at most 1.2 factor times that of noisy.
    """
    ### BEGIN SOLUTION
    distances = [np.subtract.outer(np.arange(n), np.arange(n)) for n in noisy.shape]
    weights = [np.exp(-(d**2) / (2 * sigma_space**2)) for d in distances]
    down, across = (one / one.sum(axis=1, keepdims=True) for one in weights)
    before = down @ noisy @ across.T - truth
    y, x = noisy.shape[0] // 2, noisy.shape[1] // 2
    spot = np.outer(down[:, y], across[:, x])
    square, mixed, error = np.sum(spot**2), np.sum(spot * before), np.sum(before**2)
    broken = noisy.copy()
    broken[y, x] += (-mixed + np.sqrt(mixed**2 + square * error * (1.1 * factor - 1))) / square
    return broken
    ### END SOLUTION


# %%
check("one_pixel")

# %% [markdown]
# On the stage, in grey: the error of the Gaussian of 1 pixel times 10.

# %%
grey, grey_truth = noisy.mean(axis=-1).astype(float), reference.mean(axis=-1).astype(float)
broken = one_pixel(grey, grey_truth, 1.0, 10.0)
y, x = np.argwhere(broken != grey)[0]
a = broken[y, x] - grey[y, x]
before, after = (mcd.gaussian(image, sigma_space=1.0) for image in (grey, broken))
print(f"a = {a:.2f} in pixel ({y}, {x}), 1 of {grey.size}; {8 * a:.0f} more in one of its 8 samples does it")
print(f"sum of the squared damage: measured {np.sum((after - before) ** 2):.3f}, by formula {a**2 / (4 * np.pi):.3f}")
mcd.show_images(
    {
        "with the pixel": broken,
        f"Gaussian without it: {mcd.mse(before, grey_truth):.5f}": before,
        f"Gaussian with it: {mcd.mse(after, grey_truth):.5f}": after,
    },
    title="mean squared error",
)

# %% [markdown]
# And the others? The same light, in all channels of one sample of one pixel; here are 40 x 40 pixels around it.

# %%
from dataclasses import replace

top, left = (int(np.clip(place - 20, 0, 88)) for place in (y, x))
without = samples.crop(top, left, 40, 40)
radiance = without.radiance.copy()
radiance[y - top, x - left, 0] += 8 * a
with_it = replace(without, radiance=radiance)
crops = {"noisy": mcd.pixel_mean(radiance)}
print(f"{'':30} sum of the squared damage   pixels changed by 0.01 or more")
for name in CHOSEN:
    clean, crops[METHODS[name].label] = (METHODS[name].run(one, **parameters[name]) for one in (without, with_it))
    damage = crops[METHODS[name].label] - clean
    spread = np.sum(np.abs(damage).max(axis=-1) >= 0.01)
    print(f"{METHODS[name].label:30} {np.sum(damage.mean(axis=-1) ** 2):25.2f} {spread:32}")
mcd.show_images(crops, columns=4)

# %% [markdown]
# The Gaussian compares nothing. Who compares colours as they are finds nobody like the bright pixel: it keeps its light, and
# its neighbours keep theirs. Who divides a distance by the *noise* of the pixel can be fooled. The firefly makes the variance
# of its pixel so large that everybody seems to be like it: it is spread over what was right before. (The sum of squares is
# smaller then, for the same light stands in more pixels. Which of the two would you rather see?)
#
# ### Before the filter
#
# A bound needs another mean. Cut the samples of a pixel into groups, take the mean of each group, and of those means the
# *median*: bad samples that spoil less than half of the groups do not get through, however large they are.
#
# ### Exercise 7 (write): the median of means

# %% exercise="median_of_means"
from mcdenoise.study.robust import median_of_means

# %%
check("median_of_means")

# %% [markdown]
# ### Exercise 8 (predict): what it bears, and what it costs
#
# A pixel has 16 samples. Bad samples are arbitrarily large, and fall where they do most harm. How many of them does the median
# of means bear, so that the result stays among the means of good samples? Say it for 1, 4, 5 and 16 groups.
#
# Another pixel has no bad samples. It sees a lamp in one of its 16 samples: that sample is 16, all others are 0, so that the
# mean is 1, and right. What does it show with 4 groups? Predict all five numbers before you run the cells below the check.

# %% exercise="median_limits"
median_limits = None  # five numbers, such as (3, 3, 3, 3, 1.0)
### BEGIN SOLUTION
median_limits = (0, 1, 2, 7, 0.0)
### END SOLUTION

# %%
check("median_limits")

# %% [markdown]
# Measured, with 16 spp of the stage: in each pixel some of the samples, chosen at random, are set to 100.

# %%
GROUPS = (1, 4, 5, 16)
rng = np.random.default_rng(0)
sixteen = mcd.capture("dof", width=128, height=128, spp=16, seed=3).radiance
order = rng.random(sixteen.shape[:3]).argsort(axis=2)
counts = (0, 1, 2, 3, 4, 6, 8)
curves = {groups: [] for groups in GROUPS}
for count in counts:
    spoiled = np.where((order < count)[..., np.newaxis], np.float32(100), sixteen)
    for groups in GROUPS:
        curves[groups].append(mcd.relmse(median_of_means(spoiled, groups), reference))
figure, axes = plt.subplots(figsize=(7, 3.8), layout="constrained")
for (groups, curve), colour, marker in zip(curves.items(), COLOURS, MARKERS, strict=False):
    words = {1: "the mean", 16: "16 groups: the median"}.get(groups, f"{groups} groups")
    axes.plot(counts, curve, marker=marker, color=colour, label=words)
axes.set(yscale="log", xlabel="bad samples of 16 in each pixel", ylabel="relMSE", title="where does it break down?")
axes.legend(fontsize=8)
_ = axes.grid(color="0.92")

# %% [markdown]
# Each curve holds out as long as you predicted, and then nothing holds it. (16 groups are spoiled by 8, half of them.) At the
# left end, without any bad sample, stands the price. The light of a pixel is *skewed*: many dark samples, few bright ones, and
# those few carry the mean. To the median they look like fireflies, so the image gets too dark:

# %%
glossy_reference = mcd.read_exr("data/glossy.exr")
glossy = mcd.capture("glossy", width=128, height=128, spp=16, seed=3).radiance
shown = {}
for name, light, truth in (("dof", sixteen, reference), ("glossy", glossy, glossy_reference)):
    for groups in GROUPS:
        image = median_of_means(light, groups)
        print(
            f"{name:7} {groups:2} groups: relMSE {mcd.relmse(image, truth):.4f}, light {image.mean() / truth.mean() - 1:+.1%}"
        )
        shown[f"{name}, {groups} groups"] = image
mcd.show_images(shown, columns=4)

# %% [markdown]
# Robust or unbiased: for skewed light nobody has both. Who bounds the damage of a pixel that is wrong must pay with light that
# was right, and should measure how much.
#
# ## No more model than the scene needs
#
# The capture of a scene hands over random parameters and features. Does the light depend on them at all? Mutual information
# (chapter 05) is never 0 on a finite number of samples, so compare it with chance: *shuffle* the parameter within each pixel,
# and measure again, many times.
#
# ### Exercise 9 (write): could it be chance?

# %% exercise="permutation_p_value"
from mcdenoise.study.evidence import permutation_p_value

# %%
check("permutation_p_value")

# %% [markdown]
# Three scenes. What depends on a random parameter is how a sample differs from the mean of its pixel. Beside the real parameters
# stands a coin that no ray has ever seen. For `dof` the same once more in tiles of 16 x 16 pixels, mean over the tiles.

# %%
SHUFFLES = 19


def information(r, away, tile):
    """Mutual information (nats) of a random parameter and of what radiance differs from its pixel: mean over tiles."""
    corners = [(y, x) for y in range(0, r.shape[0], tile) for x in range(0, r.shape[1], tile)]
    parts = [np.s_[y : y + tile, x : x + tile] for y, x in corners]
    return np.mean([mcd.mutual_information(r[part].ravel(), away[part].ravel()) for part in parts])


found = {}
for place, tile in (("pinhole", 64), ("soft_shadow", 64), ("dof", 64), ("dof, in tiles", 16)):
    some = mcd.capture(place.split(",")[0], width=64, height=64, spp=8, seed=1)
    away = (some.radiance - some.radiance.mean(axis=2, keepdims=True)).mean(axis=-1)
    for name in (*some.random_param_names, "a coin"):
        r = rng.random(away.shape) if name == "a coin" else some[name].reshape(away.shape)
        shuffled = [information(rng.permuted(r, axis=2), away, tile) for _ in range(SHUFFLES)]
        found[f"{place}: {name}"] = information(r, away, tile), np.array(shuffled)
figure, axes = plt.subplots(figsize=(8, 5.6), layout="constrained")
for place, (observed, shuffled) in enumerate(found.values()):
    axes.plot(
        shuffled, np.full(SHUFFLES, place), "|", color=GREY, label="" if place else f"{SHUFFLES} shuffles: chance"
    )
    axes.plot(observed, place, "o", color="#EE6677", label="" if place else "observed")
    p = permutation_p_value(observed, shuffled)
    axes.annotate(f"p = {p:.3f}", (1.01, place), xycoords=("axes fraction", "data"), va="center", fontsize=9)
axes.set_yticks(range(len(found)), list(found))
axes.set(
    xscale="log", xlabel="mutual information with the radiance (nats)", title="dependency, and what chance makes of it"
)
axes.grid(axis="x", color="0.92")
axes.invert_yaxis()
_ = axes.legend(fontsize=8)

# %% [markdown]
# With 19 shuffles p cannot be smaller than 1/20. Look at `lens_u` of `dof`. On one side of a stripe of paint more u means
# brighter, on the other side darker: over the whole image the two mix, and what is left lies at the edge of what chance makes.
# In tiles it comes out. So a large p is no proof that nothing is there: where did you look? And a small p says that there *is*
# a dependency, not that it is worth anything: with enough samples the weakest one is found. What counts is the error.
#
# ### An error without a reference
#
# Filter half of the samples, and compare with the mean of the other half, $o$, which is noisy but unbiased and knows nothing
# of the first. With $f$ the filtered image, $t$ the truth and $\sigma^2_o$ the variance of $o$:
#
# $$ E\,(f - o)^2 = E\,(f - t)^2 + \sigma^2_o $$
#
# ### Exercise 10 (write): the error against the other half

# %% exercise="error_against_other"
from mcdenoise.study.evidence import error_against_other

# %%
check("error_against_other")

# %% [markdown]
# The Gaussian on half of the samples of `dof`, estimated and true. Nobody needs a reference to find the best bandwidth.

# %%
half_a, half_b = samples.subset(0, 4), samples.subset(4, 8)
image_a, image_b = (mcd.pixel_mean(half.radiance) for half in (half_a, half_b))
variance_b = mcd.variance_of_mean(half_b.radiance)
sigmas = np.array([0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1.0, 1.2, 1.5, 2.0])
blurs = [mcd.gaussian(image_a, sigma_space=float(sigma)) for sigma in sigmas]
estimated = [error_against_other(image, image_b, variance_b) for image in blurs]
figure, axes = plt.subplots(figsize=(7, 3.4), layout="constrained")
axes.plot(sigmas, estimated, "o-", color="#4477AA", label="against the other half")
axes.plot(sigmas, [mcd.mse(image, reference) for image in blurs], "s--", color="#EE6677", label="against the reference")
axes.set(xlabel="sigma_space (pixels)", ylabel="mean squared error", ylim=(0, None))
axes.legend(fontsize=8)
_ = axes.grid(color="0.92")

# %% [markdown]
# ### As small as possible
#
# Two models whose errors differ by less than chance are equally good, so take the smaller one. The *one-standard-error rule* of
# chapter 08: the smallest model whose mean error is within one standard error of the best. Here the models are the lists of
# features that the cross-bilateral filter of chapter 04 may ask, on `pinhole`, judged on five seeds without the reference.

# %%
from mcdenoise.study.capacity import smallest_model
from mcdenoise.study.methods import bandwidths, feature_spreads

LISTS = [
    (),
    ("albedo",),
    ("shading_normal",),
    ("albedo", "shading_normal"),
    ("albedo", "shading_normal", "world_position"),
]
truth = mcd.read_exr("data/pinhole.exr")
judged, true = np.zeros((len(LISTS), 5)), np.zeros(len(LISTS))
for seed in range(5):
    one = mcd.capture("pinhole", width=128, height=128, spp=8, seed=20 + seed)
    half_a, half_b = one.subset(0, 4), one.subset(4, 8)
    features, feature_variances = mcd.prefilter_features(half_a, list(LISTS[-1]))
    sigma_features = bandwidths(feature_spreads(half_a), 0.2, np.inf)
    for row, names in enumerate(LISTS):
        image = mcd.cross_bilateral(
            mcd.pixel_mean(half_a.radiance),
            sigma_space=1.4,
            sigma_radiance=1.6,
            features={name: features[name] for name in names},
            sigma_features={name: sigma_features[name] for name in names},
            variances={name: feature_variances[name] for name in names},
        )
        other = mcd.pixel_mean(half_b.radiance), mcd.variance_of_mean(half_b.radiance)
        judged[row, seed] = error_against_other(image, *other)
        true[row] += mcd.mse(image, truth) / 5
chosen = smallest_model([len(names) for names in LISTS], judged)
print(f"{'asked':42} estimated, and standard error        true")
for row, names in enumerate(LISTS):
    spread = judged[row].std(ddof=1) / np.sqrt(5)
    mark = "  <- the smallest" if row == chosen else ""
    print(f"{', '.join(names) or 'nothing':42} {judged[row].mean():10.5f} +- {spread:.5f} {true[row]:19.5f}{mark}")

# %% [markdown]
# `mcdenoise advise SAMPLES.npz` asks the questions of this part for any samples: what says more than chance, what each name is
# worth to a filter, and which filter is the simplest that cannot be told from the best. It has no reference either.
#
# ### Exercise 11 (predict): the smallest layout
#
# A made-up scene: behind a lens stands a painted wall in the shade of a tree. Six layouts, each with the relMSE of five seeds,
# in thousandths. Which layout do you keep, and what does that cost?

# %%
LAYOUTS = {
    (): (40.1, 38.2, 41.5, 39.0, 40.7),
    ("albedo",): (10.3, 11.5, 9.9, 10.7, 11.1),
    ("albedo", "light_u", "light_v"): (10.3, 9.8, 11.1, 9.7, 10.6),
    ("albedo", "light_u", "light_v", "shading_normal"): (9.2, 10.9, 9.7, 10.8, 9.4),
    ("albedo", "lens_u", "lens_v", "light_u", "light_v"): (10.4, 9.9, 11.1, 9.8, 10.5),
    ("albedo", "lens_u", "lens_v", "light_u", "light_v", "shading_normal"): (9.3, 10.9, 9.8, 10.9, 9.4),
}
for names, row in LAYOUTS.items():
    print(f"{', '.join(names) or 'nothing':68} " + "".join(f"{one:6.1f}" for one in row))

# %% exercise="smallest_layout"
# The names of the layout, and by how many per cent its mean error is above that of the best layout (one digit).
smallest_layout = None  # such as (("lens_u", "lens_v"), 12.5)
### BEGIN SOLUTION
smallest_layout = (("albedo", "light_u", "light_v"), 3.0)
### END SOLUTION

# %%
check("smallest_layout")

# %% [markdown]
# ## What you should be able to do now
#
# - put a method on the chart of speed against accuracy, and say whether anybody needs it;
# - say what a filter is worth in samples, and at how many spp plain Monte Carlo overtakes it;
# - split an error into bias and variance, and say which of the two more samples cure;
# - break a filter with one pixel, and compute the damage before you do it;
# - bound the damage, and say what the bound costs;
# - ask whether a dependency is more than chance, and whether it is worth its price, without a reference;
# - choose the smallest model, and defend it with numbers.
