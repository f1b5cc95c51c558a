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
# # 05 Dependency: what do the random parameters explain?
#
# A value that changes from sample to sample is an edge or noise. Its variance does not say which. But the renderer knows all
# random numbers of every sample. In this notebook you measure which of them a value depends on, turn that into shares, and see
# where the measure is blind.
#
# Eight exercises, 16.5 points, about 55 minutes. After each one, `check` tells you what holds and what does not. Hidden tests
# try other sizes and units, so read the contract in the docstring.

# %%
import matplotlib.pyplot as plt
import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import check

# %% [markdown]
# ## The same variance, another cause
#
# Four toy scenes with 8 samples per pixel (spp). Each sample is a vector $x_i = \{p, r, f, c\}$: the screen position, the
# random parameters, the features, the radiance.

# %%
scenes = ("dof", "motion", "soft_shadow", "glossy")
samples = {scene: mcd.capture(scene, width=128, height=128, spp=8, seed=0) for scene in scenes}
noisy = {scene: mcd.pixel_mean(samples[scene].radiance) for scene in scenes}
mcd.show_images(noisy)

# %% [markdown]
# We look at *neighbourhoods*: all samples of a box of 7 x 7 pixels, 392 of them. Two boxes of `dof` from the end of chapter 04.
# Each dot is a sample, and its colour is the albedo.


# %%
def box(scene, y, x):
    """All samples of the 7 x 7 pixels around (y, x), as columns by name; albedo and radiance are means over RGB."""
    around = samples[scene].crop(y - 3, x - 3, 7, 7)
    columns = dict(zip(("x", "y"), around.screen_position.reshape(-1, 2).T, strict=True))
    columns |= {block.name: around[block.name].ravel() for block in around.layout.random_params}
    columns["albedo"] = around["albedo"].mean(axis=-1).ravel()
    columns["radiance"] = around.radiance.mean(axis=-1).ravel()
    return columns


edge, blur = box("dof", 88, 66), box("dof", 100, 95)
figure, grid = plt.subplots(1, 4, figsize=(13, 3.4), layout="constrained")
for pair, (title, one) in zip((grid[:2], grid[2:]), {"(88, 66)": edge, "(100, 95)": blur}.items(), strict=True):
    for axes, (across, down) in zip(pair, (("x", "y"), ("lens_u", "lens_v")), strict=True):
        shown = axes.scatter(one[across], one[down], c=one["albedo"], cmap="viridis", s=12)
        axes.set(xlabel=across + " (pixels)" * (across == "x"), ylabel=down + " (pixels)" * (down == "y"))
        axes.set_title(f"{title}, std {one['albedo'].std():.2f}: {'screen' if across == 'x' else 'lens'}")
    pair[0].invert_yaxis()
_ = figure.colorbar(shown, ax=grid, label="albedo of the sample")

# %% [markdown]
# The standard deviations are alike. In the first box the albedo depends on the *screen position*: an edge. In the second it
# depends more on the *lens*: noise, most of it. How do we measure "depends"? The first thing that comes to mind is the
# correlation.

# %%
for title, one in (("edge (88, 66)", edge), ("blur (100, 95)", blur)):
    found = {name: np.corrcoef(one["albedo"], one[name])[0, 1] for name in ("x", "y", "lens_u", "lens_v")}
    print(
        f"{title:14}  correlation of albedo with " + ", ".join(f"{name} {value:.2f}" for name, value in found.items())
    )

# %% [markdown]
# For these two boxes that is enough. Now a box on the path of the ball in `motion`:

# %%
moving = box("motion", 86, 82)
print(f"correlation of radiance and time: {np.corrcoef(moving['time'], moving['radiance'])[0, 1]:.2f}")
figure, axes = plt.subplots(figsize=(5, 3.2), layout="constrained")
axes.scatter(moving["time"], moving["radiance"], s=8)
_ = axes.set(xlabel="time (share of the open shutter)", ylabel="radiance", title="motion, box around (86, 82)")

# %% [markdown]
# At first the rays of this box hit the floor, then the shadow of the ball, then the ball itself. The radiance depends on the
# time, and the correlation is about 0: it sees straight lines alone. We need a measure that sees any relation.
#
# ## Bins
#
# The measure will count, and to count we need bins. Take the mean off, divide by the standard deviation, and round:
#
# $$ \bar{x} = \mathrm{round}\left(\frac{x - \mathrm{mean}(x)}{\mathrm{std}(x)}\right), \qquad
# \mathrm{std}(x)^2 = \frac{1}{N} \sum_i (x_i - \mathrm{mean}(x))^2 $$
#
# So the bins are one standard deviation wide, and it makes no difference in which unit $x$ was measured.
#
# ### Exercise 1 (write): bins of one standard deviation


# %% exercise="quantise"
def quantise(values):
    """The bin of each sample of one variable: how many standard deviations from the mean, as the nearest whole number.

    values : (n,), finite. The standard deviation divides by n.

    Returns an array (n,) of integers. A constant variable has the bin 0 alone, whatever its value.
    """
    ### BEGIN SOLUTION
    if values.max() == values.min():  # std may be 1e-17: 0.1 is no number that the computer has
        return np.zeros(len(values), int)
    return np.rint((values - values.mean()) / values.std()).astype(int)
    ### END SOLUTION


# %%
check("quantise")

# %% [markdown]
# The box on the path of the ball, in your bins. The number in each cell is $p(x, y)$, the share of the samples that fall into
# it, in per cent. To its right, what it would be if radiance and time had nothing to do with each other: $p(x)\, p(y)$.

# %%
time, radiance = quantise(moving["time"]), quantise(moving["radiance"])
joint = np.zeros((np.ptp(radiance) + 1, np.ptp(time) + 1))
np.add.at(joint, (radiance - radiance.min(), time - time.min()), 1 / len(time))
figure, grid = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
product = joint.sum(axis=1, keepdims=True) * joint.sum(axis=0)
for axes, (title, share) in zip(grid, {"p(x, y)": joint, "p(x) p(y)": product}.items(), strict=True):
    axes.imshow(share, origin="lower", cmap="Blues", vmin=0, vmax=1.6 * joint.max(), aspect="auto")
    for (row, column), value in np.ndenumerate(share):
        axes.text(column, row, f"{100 * value:.1f}", ha="center", va="center")
    axes.set_xticks(range(joint.shape[1]), range(time.min(), time.max() + 1))
    axes.set_yticks(range(joint.shape[0]), range(radiance.min(), radiance.max() + 1))
    axes.set(xlabel="x: bin of time", ylabel="y: bin of radiance", title=f"{title}, per cent")

# %% [markdown]
# ## Mutual information
#
# If the two tables are equal, x says nothing about y. The mutual information measures how far they differ:
#
# $$ \mu(X; Y) = \sum_x \sum_y p(x, y)\, \log \frac{p(x, y)}{p(x)\, p(y)} $$
#
# The sum goes over the bins that occur. With the natural logarithm the unit is the *nat*. It is 0 for independent variables, and
# never negative. If y is x under another name, it is the entropy of x.
#
# ### Exercise 2 (write): mutual information of two binned variables
#
# `x` and `y` hold whole numbers, one pair a sample; negative ones too, and there may be gaps between them.

# %% exercise="information_of_levels"
from mcdenoise.rpf.dependency import information_of_levels

# %%
check("information_of_levels")


# %%
def mu(x, y):
    """Mutual information of two variables, by your two functions."""
    return information_of_levels(quantise(x), quantise(y))


print(f"mu(radiance; time) = {mu(moving['radiance'], moving['time']):.3f} nats, where the correlation was about 0")
figure, axes = plt.subplots(figsize=(8, 3.2), layout="constrained")
witnesses = ("x", "y", "lens_u", "lens_v", "light_u", "light_v")
for place, (title, one) in enumerate({"edge (88, 66)": edge, "blur (100, 95)": blur}.items()):
    found = [mu(one["albedo"], one[name]) for name in witnesses]
    bars = axes.bar(np.arange(6) + 0.4 * (place - 0.5), found, 0.38, label=title)
    axes.bar_label(bars, [f"{value:.3f}" for value in found], fontsize=8)
axes.set_xticks(range(6), witnesses)
axes.set(ylabel="mutual information (nats)", title="what does the albedo depend on?")
_ = axes.legend()

# %% [markdown]
# The edge depends on y, the blur on the lens: the two boxes are told apart. On the light the albedo cannot depend at all. Yet
# these bars are not 0. We come back to that.
#
# ### Exercise 3 (break): dependent, without correlation
#
# Make two variables of which one follows from the other, and whose correlation is 0.


# %% exercise="uncorrelated"
def uncorrelated():
    """Make two variables that depend on each other, but are not correlated.

    Returns
    -------
    x, y : two arrays (n,), 500 to 5000 samples, the same at every call (a fixed seed). Their correlation is at most 0.02
        from 0, their mutual information (`mcd.mutual_information`) at least 0.3 nats.
    """
    ### BEGIN SOLUTION
    x = np.linspace(-1, 1, 1001)
    return x, x**2
    ### END SOLUTION


# %%
check("uncorrelated")

# %%
x, y = uncorrelated()
figure, axes = plt.subplots(figsize=(4, 3), layout="constrained")
axes.scatter(x, y, s=4)
_ = axes.set(xlabel="x", ylabel="y", title=f"correlation {np.corrcoef(x, y)[0, 1]:.2f}, mu {mu(x, y):.2f} nats")

# %% [markdown]
# ## What chance alone gives
#
# The albedo does not depend on the light, and the bars say otherwise. Few samples never fall into the bins quite as evenly as
# they should, and every unevenness counts as information. For independent variables and N samples this gives, on average,
# about
#
# $$ \frac{(\mathrm{bins}_x - 1)\,(\mathrm{bins}_y - 1)}{2 N} \quad \text{nats.} $$
#
# ### Exercise 4 (predict): a box by chance
#
# In a box of 7 x 7 pixels with 8 spp the albedo falls into 3 bins, `lens_u` into 5. How many nats does chance alone give?

# %% exercise="chance_alone"
chance_alone = None  # nats, two digits
### BEGIN SOLUTION
chance_alone = (3 - 1) * (5 - 1) / (2 * 392)
### END SOLUTION

# %%
check("chance_alone")

# %% [markdown]
# Measured: shuffle one of the two among the samples, and nothing depends on anything.

# %%
rng = np.random.default_rng(0)
shuffled = [mu(rng.permutation(edge["albedo"]), edge["lens_u"]) for _ in range(200)]
print(
    f"edge (88, 66): {len(np.unique(quantise(edge['albedo'])))} bins of albedo, shuffled {np.mean(shuffled):.4f} nats"
)
counts = np.array([50, 100, 200, 400, 800, 1600, 3200])
chance = [np.mean([mu(rng.random(n), rng.random(n)) for _ in range(100)]) for n in counts]
figure, axes = plt.subplots(figsize=(5, 3.2), layout="constrained")
axes.loglog(counts, 4 * 4 / (2 * counts), label="4 * 4 / (2 N)")
axes.loglog(counts, chance, "o", label="measured, 5 and 5 bins")
axes.axvline(392, color="grey", linestyle=":", label="7 x 7 pixels, 8 spp")
axes.set(xlabel="samples N", ylabel="mutual information (nats)", title="two independent variables")
_ = axes.legend()

# %% [markdown]
# ## From pairs to shares
#
# A pixel's radiance depends on several numbers at once. To measure that jointly we would need bins in all their dimensions, and
# there are too few samples to fill them. So sums of pairs stand in. With the three channels $c_k$, the features $f_k$, the random
# parameters $r_l$ and the positions $p_l$ of one neighbourhood:
#
# $$ D_{c,k}^r = \sum_l \mu(c_k; r_l) \qquad D_{c,k}^p = \sum_l \mu(c_k; p_l) \qquad D_{c,k}^f = \sum_l \mu(c_k; f_l) $$
#
# and in the same way $D_{f,k}^r$, $D_{f,k}^p$. What we need are shares. How much of a channel, or of a feature, do the random
# parameters explain, beside the position? And how much of the radiance does feature $k$ explain?
#
# $$ W_{c,k}^r = \frac{D_{c,k}^r}{D_{c,k}^r + D_{c,k}^p} \qquad
# W_{f,k}^r = \frac{D_{f,k}^r}{D_{f,k}^r + D_{f,k}^p} \qquad
# W_c^{f,k} = \frac{\sum_l \mu(c_l; f_k)}{D_c^r + D_c^p + D_c^f} $$
#
# where $D_c^r = \sum_k D_{c,k}^r$ sums over the channels, and so do the others. Note the index of the last one: $k$ is a
# feature there, and the sum goes over the channels.
#
# ### Exercise 5 (write): the shares


# %% exercise="dependency_shares"
def dependency_shares(c_r, c_p, c_f, f_r, f_p):
    """The shares that follow from the mutual information of all pairs in one neighbourhood.

    c_r : (3, n_r), entry [k, l] is the information of channel k and random parameter l. c_p : (3, 2), of channel and
        position. c_f : (3, n_f), of channel and feature. f_r : (n_f, n_r), of feature and random parameter.
        f_p : (n_f, 2), of feature and position. n_r and n_f may be 0.

    Returns three arrays: W_{c,k}^r (3,), W_{f,k}^r (n_f,) and W_c^{f,k} (n_f,). A share of nothing (0 / 0) is 0.
    """

    ### BEGIN SOLUTION
    def share(part, whole):
        return np.where(whole > 0, part / np.where(whole > 0, whole, 1.0), 0.0)

    of_radiance = share(c_r.sum(axis=1), c_r.sum(axis=1) + c_p.sum(axis=1))
    of_feature = share(f_r.sum(axis=1), f_r.sum(axis=1) + f_p.sum(axis=1))
    by_feature = share(c_f.sum(axis=0), c_r.sum() + c_p.sum() + c_f.sum())
    return of_radiance, of_feature, by_feature
    ### END SOLUTION


# %%
check("dependency_shares")

# %% [markdown]
# The two boxes again, with all their pairs. `mcd.dependency_of` measures them as you do, faster, and holds the five tables.
# What float rounding alone makes vary it takes for constant.

# %%
figure, grid = plt.subplots(1, 2, figsize=(11, 3.4), layout="constrained")
names = [
    f"{name} {one}" for name, ones in (("world position", "xyz"), ("normal", "xyz"), ("albedo", "RGB")) for one in ones
]
for place, (title, (y, x)) in enumerate({"edge (88, 66)": (88, 66), "blur (100, 95)": (100, 95)}.items()):
    found = mcd.dependency_of(samples["dof"].crop(y - 3, x - 3, 7, 7))
    w_c_r, w_f_r, w_c_f = dependency_shares(found.c_r, found.c_p, found.c_f, found.f_r, found.f_p)
    where = 0.4 * (place - 0.5)
    grid[0].bar(np.arange(12) + where, np.append(w_c_r, w_f_r), 0.38, label=title)
    grid[1].bar(np.arange(9) + where, w_c_f, 0.38, label=title)
grid[0].set_xticks(range(12), ["red", "green", "blue", *names], rotation=60, ha="right")
grid[1].set_xticks(range(9), names, rotation=60, ha="right")
grid[0].set(ylim=(0, 1), ylabel="share", title="W: what the random parameters explain")
grid[1].set(ylabel="share", title="W: what each feature explains of the radiance")
_ = grid[0].legend()

# %% [markdown]
# ### Exercise 6 (predict): the share that chance gives
#
# Shuffle the radiance among the samples of a box: now it depends on nothing. `dof` has four random parameters (`lens_u`,
# `lens_v`, `light_u`, `light_v`); these and both positions fall into 5 bins each. What is $W_{c,k}^r$ on average?

# %% exercise="chance_share"
chance_share = None  # a number with two digits
### BEGIN SOLUTION
chance_share = 4 / (4 + 2)
### END SOLUTION

# %%
check("chance_share")

# %%
around = samples["dof"].crop(88 - 3, 66 - 3, 7, 7)
blocks = [around.screen_position, around.random_params, around.features, around.radiance]
p, r, f, c = (block.reshape(392, -1) for block in blocks)
by_chance = np.array([mcd.dependency(p, r, f, rng.permutation(c)).share_c_r.mean() for _ in range(200)])
figure, axes = plt.subplots(figsize=(5, 3), layout="constrained")
axes.hist(by_chance, 20)
axes.axvline(found_here := mcd.dependency(p, r, f, c).share_c_r.mean(), color="C1", label=f"the edge: {found_here:.2f}")
axes.axvline(by_chance.mean(), color="black", linestyle=":", label=f"mean by chance: {by_chance.mean():.2f}")
axes.set(xlabel="W, mean over the channels", ylabel="shuffles of 200", title="radiance shuffled among 392 samples")
_ = axes.legend()

# %% [markdown]
# A share has no zero level: the value of ignorance is not 0, but $n_r / (n_r + 2)$. Where nothing depends on anything, W is near
# that. The reverse does not hold: the blur above has about the same W, but its nats are many times those of chance. Who reads a
# W should know the D below it.
#
# ## What explains what
#
# ### Exercise 7 (predict): six places
#
# Each time, a box of 7 x 7 pixels. What explains the most: **A** the position on the screen, **B** the lens, **C** the time,
# **D** the light, **E** the direction of scattering?
#
# 1. `dof` (94, 66): where the ball in focus stands on the floor, with its shadow; the radiance;
# 2. `soft_shadow` (75, 75): the penumbra of the fence on the floor; the radiance;
# 3. `dof` (112, 112): the striped ball near the lens, out of focus; the *albedo*;
# 4. `motion` (90, 86): on the path of the moving ball; the radiance;
# 5. `soft_shadow` (114, 110): bare floor far from the fence; the radiance;
# 6. `glossy` (50, 22): the lamp mirrored in the ball of rough metal on the left; the radiance.

# %% exercise="what_explains"
what_explains = None  # six letters, such as ("A", "A", "A", "A", "A", "A")
### BEGIN SOLUTION
what_explains = ("A", "D", "B", "C", "D", "E")
### END SOLUTION

# %%
check("what_explains")

# %%
places = (
    ("dof", 94, 66, "radiance"),
    ("soft_shadow", 75, 75, "radiance"),
    ("dof", 112, 112, "albedo"),
    ("motion", 90, 86, "radiance"),
    ("soft_shadow", 114, 110, "radiance"),
    ("glossy", 50, 22, "radiance"),
)
groups = {
    "position": ("x", "y"),
    "lens": ("lens_u", "lens_v"),
    "time": ("time",),
    "light": ("light_u", "light_v"),
    "scattering": ("bsdf_u", "bsdf_v"),
}
figure, axes = plt.subplots(figsize=(9, 3.6), layout="constrained")
for number, (scene, y, x, what) in enumerate(places):
    one, left = box(scene, y, x), 0.0
    found = {group: sum(mu(one[what], one[n]) for n in members if n in one) for group, members in groups.items()}
    for colour, (group, value) in enumerate(found.items()):
        part = value / sum(found.values())
        axes.barh(number, part, left=left, color=f"C{colour}", label=group if number == 0 else None)
        left += part
axes.set_yticks(range(6), [f"{s} ({y}, {x}), {what}, std {box(s, y, x)[what].std():.2f}" for s, y, x, what in places])
axes.invert_yaxis()
axes.set(xlim=(0, 1), xlabel="share of the mutual information", title="what explains most?")
_ = figure.legend(loc="outside lower center", ncols=5)

# %% [markdown]
# Place 5 is a warning. The radiance of the bare floor hardly varies (compare the standard deviations), but the little that there
# is comes from the light. W says *what* makes a value vary, not how much it varies.
#
# ## W as an image
#
# One box around every fourth pixel of `dof`. In the background the albedo is constant: there W is 0 / 0, and we set it to 0.


# %%
def shares_over_the_image(scene, step=4):
    """W of the lens in the radiance, W of all random parameters in the radiance, and in the albedo: a grid of boxes."""
    grid = np.zeros((128 // step, 128 // step, 3))
    for row, column in np.ndindex(grid.shape[:2]):
        y, x = (int(np.clip(step * k + step // 2 - 3, 0, 121)) for k in (row, column))
        found = mcd.dependency_of(samples[scene].crop(y, x, 7, 7))
        lens = found.share_c_r_each[:, :2].sum(axis=1).mean()
        grid[row, column] = lens, found.share_c_r.mean(), found.share_f_r[6:9].mean()
    return grid


maps = shares_over_the_image("dof")
figure, grid = plt.subplots(1, 4, figsize=(13, 3.3), layout="constrained")
grid[0].imshow(np.clip(noisy["dof"], 0, 1) ** (1 / 2.2))
grid[0].set_title("dof, noisy")
titles = ("W of radiance: lens", "W of radiance: lens and light", "W of albedo: lens and light")
for axes, title, share in zip(grid[1:], titles, np.moveaxis(maps, -1, 0), strict=True):
    shown = axes.imshow(share, vmin=0, vmax=1, extent=(0, 128, 128, 0))
    axes.set_title(title)
for axes in grid:
    axes.axis("off")
_ = figure.colorbar(shown, ax=grid, label="W")

# %% [markdown]
# The lens shows where the stage is out of focus, and the map of the albedo shows it best, for there the light has no say. What
# does chapter 06 make of such maps? In the bilateral weights of two samples each channel of radiance gets a factor $\alpha_k$,
# each feature a factor $\beta_k$:
#
# $$ \alpha_k = 1 - W_{c,k}^r \qquad \beta_k = 1 - W_{f,k}^r $$
#
# A feature that the random parameters explain loses its say, where it is noise and only there.

# %%
figure, grid = plt.subplots(1, 3, figsize=(11, 3.5), layout="constrained")
grid[0].imshow(np.clip(mcd.pixel_mean(samples["dof"]["albedo"]), 0, 1) ** (1 / 2.2))
grid[0].set_title("dof, albedo (mean of 8 samples)")
for axes, title, share in zip(grid[1:], ("alpha = 1 - W of radiance", "beta = 1 - W of albedo"), (1, 2), strict=True):
    shown = axes.imshow(1 - maps[..., share], vmin=0, vmax=1, extent=(0, 128, 128, 0), cmap="gray")
    axes.set_title(title)
for axes in grid:
    axes.axis("off")
_ = figure.colorbar(shown, ax=grid, label="factor")

# %% [markdown]
# ## Where it fails
#
# Pairs do not see what only two numbers together decide. Here y is white or black by both lens coordinates, like a checkerboard
# on the lens:

# %%
lens_u, lens_v = rng.random(392), rng.random(392)
y = np.where((lens_u < 0.5) == (lens_v < 0.5), 1.0, 0.0)
both = 10 * quantise(lens_u) + quantise(lens_v)
print(f"mu(y; lens_u) = {mu(y, lens_u):.3f}, mu(y; lens_v) = {mu(y, lens_v):.3f} nats")
print(f"mu(y; both)   = {information_of_levels(quantise(y), both):.3f} nats")

# %% [markdown]
# ### Exercise 8 (break): blind bins
#
# One number can hide from our bins as well. Find a y that is a function of x, and that our bins do not see. There are at least
# two ways: what happens within one bin, and what a single sample does to the standard deviation.


# %% exercise="unseen"
def unseen():
    """Make two variables of which the second is a function of the first, and which our bins take for independent.

    Returns
    -------
    x, y : two arrays (n,), 1000 to 20000 samples, the same at every call (a fixed seed). Where x is equal, y is equal. Our
        bins (`mcd.mutual_information`) find at most 0.05 nats. Bins by rank, 64 of x and 8 of y, each of about as many
        different values, find at least 0.5 nats above chance: so it is no noise.
    """
    ### BEGIN SOLUTION
    x = np.arange(4096) / 4096
    return x, np.floor(64 * x) % 2  # stripes, about eighteen of them in each bin
    ### END SOLUTION


# %%
check("unseen")

# %%
x, y = unseen()
figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
axes.plot(x, y, ".", markersize=3)
for border in x.mean() + x.std() * (np.arange(-2, 2) + 0.5):
    axes.axvline(border, color="grey", linewidth=0.5)
_ = axes.set(xlabel="x (grey: borders of the bins)", ylabel="y", title=f"our bins see {mu(x, y):.4f} nats")

# %% [markdown]
# Both happen in images. Stripes narrower than two pixels in a box of seven are the first case. A firefly is the second: it makes
# the standard deviation so large that all other samples share one bin. Take the box on the path of the ball, and make one of its
# 392 samples a thousand times brighter:

# %%
firefly = moving["radiance"].copy()
firefly[0] *= 1000
print(f"mu(radiance; time) = {mu(moving['radiance'], moving['time']):.3f} nats")
print(f"with one firefly   = {mu(firefly, moving['time']):.3f} nats")

# %% [markdown]
# ## What you should be able to do now
#
# - say why neither a variance nor a correlation tells an edge from noise;
# - bin two variables and write down their mutual information;
# - say what chance gives, in nats and as a share, and when a share means nothing;
# - compute the shares of a neighbourhood, and predict for a place which random parameter explains it;
# - name three things that the measure does not see.
