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
# # 04 Features: alike in what was hit
#
# The bilateral filter asks a noisy witness: the radiance. The renderer knows more about a pixel. In this notebook you let
# features choose the neighbours, see on five scenes where that breaks, and repair a part of it: with variances, and with
# patches.
#
# Seven exercises, 16.5 points, about 50 minutes. After each one, `check` tells you what holds and what does not. Hidden tests
# try other sizes and limits, so read the contract in the docstring.

# %%
import matplotlib.pyplot as plt
import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import check

# %% [markdown]
# ## What the renderer knows
#
# Five small scenes, 8 samples per pixel (spp). Each sample says what its ray hit first: where (`world_position`), which way
# the surface faces (`shading_normal`), and its colour under white light (`albedo`). The feature $f_p$ of a pixel is the mean
# over its samples.

# %%
scenes = ("pinhole", "dof", "motion", "glossy", "soft_shadow")
samples = {scene: mcd.capture(scene, width=128, height=128, spp=8, seed=0) for scene in scenes}
reference = {scene: mcd.read_exr(f"data/{scene}.exr") for scene in scenes}
noisy = {scene: mcd.pixel_mean(samples[scene].radiance) for scene in scenes}
first_hit = ("world_position", "shading_normal", "albedo")
features = {scene: {name: mcd.pixel_mean(samples[scene][name]) for name in first_hit} for scene in scenes}

# %%
mcd.show_images(
    {
        "pinhole, noisy": noisy["pinhole"],
        "albedo": features["pinhole"]["albedo"],
        "shading_normal / 2 + 1/2": features["pinhole"]["shading_normal"] / 2 + 0.5,
        "world_position / 4": features["pinhole"]["world_position"].clip(0, 4) / 4,
    }
)

# %% [markdown]
# The features show every edge, and hardly any noise. Now the same stage behind a thin lens. Each ray of a pixel starts at
# another point of the lens, and hits another point of a ball that is out of focus:

# %%
mcd.show_images(
    {
        "pinhole, albedo": features["pinhole"]["albedo"],
        "dof, albedo": features["dof"]["albedo"],
        "dof, its standard deviation, 4 x": 4 * np.sqrt(mcd.variance_of_mean(samples["dof"]["albedo"])),
        "dof, noisy": noisy["dof"],
    }
)

# %% [markdown]
# ## One more bell for each feature
#
# A neighbour counts if it is near, and alike in every feature. The *cross-bilateral* filter takes its weights from the
# features, and averages the radiance:
#
# $$ w_{pq} = G_{\sigma_s}(\|p - q\|)\; \prod_k G_{\sigma_k}(\|f_{k,p} - f_{k,q}\|) $$
#
# ### Exercise 1 (predict): which scene breaks it?
#
# One filter, the three first-hit features, five scenes: `pinhole`; `dof`, the same stage behind a lens; `motion`, two balls
# that move while the shutter is open; `glossy`, rough metal in which striped walls are mirrored; `soft_shadow`, a fence under
# a large light. For each, in this order, what do its features know?
#
# **A** they are free of noise and tell the surfaces apart; **B** they are as noisy as the colour; **C** they are smooth, and
# the detail lies in what the ray hits second; **D** the radiance changes within one surface, where its features do not.

# %% exercise="breaking_scenes"
breaking_scenes = None  # five letters, such as ("A", "A", "A", "A", "A")
### BEGIN SOLUTION
breaking_scenes = ("A", "B", "B", "C", "D")
### END SOLUTION

# %%
check("breaking_scenes")

# %% [markdown]
# Now run it, with the same bandwidths everywhere, beside the Gaussian of the same `sigma_space`.

# %%
dials = {
    "sigma_space": 1.0,
    "sigma_radiance": np.inf,
    "sigma_features": {"world_position": 1.0, "shading_normal": 0.2, "albedo": 0.1},
}
blurred = {scene: mcd.gaussian(noisy[scene], sigma_space=1.0) for scene in scenes}
crossed = {scene: mcd.cross_bilateral(noisy[scene], features[scene], **dials) for scene in scenes}
mcd.show_images(
    {f"{scene}, {name}": image[scene] for name, image in (("noisy", noisy), ("filtered", crossed)) for scene in scenes},
    columns=5,
)

# %% [markdown]
# Look at the part of each picture that its scene was made for: the whole of `pinhole`, what is out of focus or moves, the
# metal, the penumbra on the floor. What do the features gain *there*, over the Gaussian that knows nothing?


# %%
def varies(one):
    """Where albedo or normal differ between the samples of a pixel."""
    spread = sum(mcd.noise_variance(one[name]).sum(axis=-1) for name in ("albedo", "shading_normal"))
    return spread > 0.01


shadow = mcd.gaussian(mcd.pixel_mean(samples["soft_shadow"]["visibility"]), sigma_space=1.0)
part = {
    "pinhole": np.full((128, 128), True),
    "dof": varies(samples["dof"]),
    "motion": varies(samples["motion"]),
    "glossy": features["glossy"]["albedo"].max(axis=-1) < 0.01,
    "soft_shadow": (shadow.reshape(128, 128) > 0.1)
    & (shadow.reshape(128, 128) < 0.9)
    & (features["soft_shadow"]["shading_normal"][..., 2] > 0.99),
}
figure, axes = plt.subplots(figsize=(8, 3.6))
for place, (name, image) in enumerate((("noisy", noisy), ("Gaussian", blurred), ("with features", crossed))):
    error = [mcd.relmse_map(image[scene], reference[scene])[part[scene]].mean() for scene in scenes]
    bars = axes.bar(np.arange(5) + 0.27 * (place - 1), error, 0.25, label=name)
    axes.bar_label(bars, [f"{one:.3f}" for one in error], fontsize=7)
axes.set_yscale("log")
axes.set_xticks(range(5), scenes)
axes.set(ylabel="relMSE in that part", title="one filter, five scenes (sigma_space = 1)")
axes.legend()
figure.tight_layout()

# %% [markdown]
# On `pinhole` the features are worth a lot: the Gaussian blurs the edges, the filter keeps them. Behind the lens and in motion
# the same filter is *worse than the Gaussian*: a pixel whose feature is noisy finds few that are like it, and those by chance.
# On the metal and in the penumbra it is hardly better, or not at all: there its features have nothing to say.
#
# So there are two diseases: features that are noisy, and features that do not know. First the noise.
#
# ## How much of a difference is noise?
#
# A noisy feature need not be thrown away. We can measure its noise: the samples of a pixel say how far its mean may be off
# (`variance_of_mean`). So ask first: how large a difference does noise alone make?
#
# ### Exercise 2 (predict): two views of one truth
#
# Two pixels $p$ and $q$ show the same surface. Their values $u_p$ and $u_q$ have the same mean, independent noise, and the
# variances 0.03 and 0.05. What is $(u_p - u_q)^2$ on average?

# %% exercise="expected_difference"
expected_difference = None  # a number with two digits
### BEGIN SOLUTION
expected_difference = 0.03 + 0.05
### END SOLUTION

# %%
check("expected_difference")

# %% [markdown]
# A difference of that size says nothing. So we measure each squared difference in units of what bandwidth and noise explain
# together. With one variance for each pixel, feature and channel $c$:
#
# $$ w_{pq} = G_{\sigma_s}(\|p - q\|)\; \prod_k \exp\left(-\frac{1}{2} \sum_c
# \frac{(f_{k,c,p} - f_{k,c,q})^2}{\sigma_k^2 + \mathrm{Var}_{k,c,p} + \mathrm{Var}_{k,c,q}}\right) $$
#
# With no variance this is the filter from above.
#
# ### Exercise 3 (write): the weights of one pixel
#
# Write down $w_{pq}$ for every $q$ of the window around one pixel.


# %% exercise="feature_weights"
def feature_weights(features, variances, sigmas, y, x, sigma_space, radius):
    """Weights of the window around the pixel (y, x), by nearness and by features.

    features, variances : two dicts with the same names, each name -> array (h, w, c); a variance is 0 where there is no
        noise. Every feature has the same h and w, but a c of its own. sigmas : dict, name -> bandwidth of that feature.
        sigma_space, radius : pixels. Any of the sigmas may be infinite.

    Returns an array (2 radius + 1, 2 radius + 1): entry [radius + dy, radius + dx] is the weight of the pixel
    (y + dy, x + dx), and 0 where that lies outside the image.
    """
    ### BEGIN SOLUTION
    height, width = next(iter(features.values())).shape[:2]
    weight = np.zeros((2 * radius + 1, 2 * radius + 1))
    for dy in range(-radius, radius + 1):
        for dx in range(-radius, radius + 1):
            q = y + dy, x + dx
            if not (0 <= q[0] < height and 0 <= q[1] < width):
                continue
            exponent = (dy / sigma_space) ** 2 + (dx / sigma_space) ** 2
            for name, feature in features.items():
                explained = sigmas[name] ** 2 + variances[name][y, x] + variances[name][q]
                exponent += np.sum((feature[y, x] - feature[q]) ** 2 / explained)
            weight[radius + dy, radius + dx] = np.exp(-exponent / 2)
    return weight
    ### END SOLUTION


# %%
check("feature_weights")

# %% [markdown]
# Your weights at one place of the near ball, which is out of focus behind the lens. From left to right: no lens, and all is
# well; with the lens, the noise hides the neighbours; the variances bring some of them back.

# %%
y, x, radius = 99, 117, 8
window = np.s_[y - radius : y + radius + 1, x - radius : x + radius + 1]
silent = {name: np.zeros((128, 128, 3)) for name in first_hit}
noise = {name: mcd.variance_of_mean(samples["dof"][name]) for name in first_hit}
figure, grid = plt.subplots(1, 5, figsize=(13, 3), layout="constrained")
for axes, scene in zip(grid[[0, 2]], ("pinhole", "dof"), strict=True):
    axes.imshow(np.clip(features[scene]["albedo"][window], 0, 1) ** 0.45)
    axes.set_title(f"{scene}: albedo")
for axes, scene, variances in zip(grid[[1, 3, 4]], ("pinhole", "dof", "dof"), (silent, silent, noise), strict=True):
    weight = feature_weights(features[scene], variances, dials["sigma_features"], y, x, 4.0, radius)
    shown = axes.imshow(weight, vmin=0, vmax=1)
    axes.set_title(f"W_p = {weight.sum():.1f}" + (", with variances" if variances is noise else ""))
for axes in grid:
    axes.plot(radius, radius, "r.")
    axes.axis("off")
_ = figure.colorbar(shown, ax=grid, label="weight", shrink=0.8)

# %% [markdown]
# ### Features with less noise
#
# We can also denoise the features first, each by itself, before they guide anything. `prefilter_features` does that, and
# returns the variances that are left.

# %%
cleaned = {scene: mcd.prefilter_features(samples[scene], first_hit) for scene in scenes}
steps = {"raw features": crossed, "+ variances": {}, "+ prefiltered": {}, "+ every feature there is": {}}
sigmas = dials["sigma_features"] | {"visibility": 0.2}
for scene in scenes:
    noise = {name: mcd.variance_of_mean(samples[scene][name]) for name in first_hit}
    steps["+ variances"][scene] = mcd.cross_bilateral(noisy[scene], features[scene], variances=noise, **dials)
    clean, left = cleaned[scene]
    steps["+ prefiltered"][scene] = mcd.cross_bilateral(noisy[scene], clean, variances=left, **dials)
    clean, left = mcd.prefilter_features(samples[scene])
    every = {"sigma_features": {name: sigmas[name.removesuffix("_2")] for name in clean}}
    steps["+ every feature there is"][scene] = mcd.cross_bilateral(
        noisy[scene], clean, variances=left, **(dials | every)
    )
figure, axes = plt.subplots(figsize=(9, 3.8))
for place, (name, image) in enumerate(steps.items()):
    error = [mcd.relmse(image[scene], reference[scene]) for scene in scenes]
    bars = axes.bar(np.arange(5) + 0.21 * (place - 1.5), error, 0.2, label=name)
    axes.bar_label(bars, [f"{one:.4f}" for one in error], fontsize=6)
axes.set_yscale("log")
axes.set_xticks(range(5), scenes)
axes.set(ylabel="relMSE", title="what the features gain, step by step (sigma_space = 1)")
axes.legend(fontsize=8)
figure.tight_layout()

# %% [markdown]
# Noise was the disease of `dof` and `motion`: less than half of their error is left. `glossy` and `soft_shadow` gain next to
# nothing from cleaner features. What helps there is a feature that knows: `visibility` for the shadow, and on the metal, a
# little, the second hit (whose features are noisy themselves).
#
# ## Patches: the surroundings as a witness
#
# Where no feature knows, only the radiance is left. One noisy pixel is a poor witness; the *patch* around it is a better one,
# for it holds 49 pixels instead of one. NL-means compares patches, and measures their distance in units of noise:
#
# $$ \begin{aligned}
# w_{pq} &= e^{-\max(0,\, d^2(p, q))} \\
# d^2(p, q) &= \frac{1}{|P|} \sum_{o \in P} \frac{(u_{p+o} - u_{q+o})^2 - e_o}{k^2\, (\mathrm{Var}_{p+o} + \mathrm{Var}_{q+o})} \\
# e_o &= \mathrm{Var}_{p+o} + \min(\mathrm{Var}_{p+o}, \mathrm{Var}_{q+o})
# \end{aligned} $$
#
# $P$ are the offsets of the patch, $(\ldots)^2$ is the mean over the channels. Exercise 2 says what stands behind the minus:
# $e_o$ is the difference that noise alone explains. (The $\min$ is for fireflies: the firefly may take from its neighbours,
# which have little variance, but they do not take from it.)
#
# ### Exercise 4 (write): the distance of two patches


# %% exercise="patch_distance"
def patch_distance(image, variance, p, q, patch_radius, k):
    """Squared distance of the patches around the pixels p and q, in units of noise.

    image : (h, w, c). variance : (h, w), above 0 everywhere: of a pixel, the mean over its channels. p, q : (y, x), inside
        the image. patch_radius : the patch has (2 patch_radius + 1)^2 places. k : a number above 0.

    Returns a number: max(0, d^2), where d^2 is the mean over the places of the patch that lie inside the image for p and
    for q. The other places are left out.
    """
    ### BEGIN SOLUTION
    height, width = variance.shape
    places = []
    for dy in range(-patch_radius, patch_radius + 1):
        for dx in range(-patch_radius, patch_radius + 1):
            a, b = (p[0] + dy, p[1] + dx), (q[0] + dy, q[1] + dx)
            if all(0 <= y < height and 0 <= x < width for y, x in (a, b)):
                square = np.mean((image[a] - image[b]) ** 2)
                by_noise = variance[a] + min(variance[a], variance[b])
                places.append((square - by_noise) / (k**2 * (variance[a] + variance[b])))
    return max(0.0, np.mean(places))
    ### END SOLUTION


# %%
check("patch_distance")

# %% [markdown]
# Your weights $e^{-d^2}$ for one pixel of `soft_shadow` in a search window of 17 x 17: by single pixels, by patches of 7 x 7
# that all have the same variance, and by patches that know their own.

# %%
y, x, radius = 64, 64, 8
window = np.s_[y - radius : y + radius + 1, x - radius : x + radius + 1]
image = noisy["soft_shadow"].astype(float)
variance = mcd.noise_variance(samples["soft_shadow"].radiance).mean(axis=-1).astype(float)
variance = np.maximum(variance, 1e-6)
same = np.full((128, 128), variance.mean())
figure, grid = plt.subplots(1, 5, figsize=(13, 3), layout="constrained")
grid[0].imshow(np.clip(image[window], 0, 1) ** 0.45)
grid[0].set_title("the window")
grid[1].imshow(np.clip(reference["soft_shadow"][window], 0, 1) ** 0.45)
grid[1].set_title("reference")
cases = (("single pixels", variance, 0), ("patches, one variance", same, 3), ("patches, own variance", variance, 3))
for axes, (title, known, patch_radius) in zip(grid[2:], cases, strict=True):
    weight = np.zeros(variance[window].shape)
    for dy, dx in np.ndindex(weight.shape):
        q = y + dy - radius, x + dx - radius
        weight[dy, dx] = np.exp(-patch_distance(image, known, (y, x), q, patch_radius, 0.6))
    shown = axes.imshow(weight, vmin=0, vmax=1)
    axes.set_title(title)
for axes in grid:
    axes.plot(radius, radius, "r.")
    axes.axis("off")
_ = figure.colorbar(shown, ax=grid, label="weight", shrink=0.8)

# %% [markdown]
# ### Why NL-means without variances disappoints
#
# In a photograph the noise is about the same everywhere, and one number will do. In a rendered image it is not: what is right
# for the wall leaves the blurred lamps alone, and what is right for the lamps blurs the wall away. Give NL-means the best
# single number, and then the variance of each pixel:

# %%
result = {}
for scene in ("dof", "soft_shadow"):
    variance = mcd.noise_variance(samples[scene].radiance)
    numbers = float(variance.mean()) * 2.0 ** np.arange(-8, 4)
    single = [mcd.nlm(noisy[scene], number, weight_radius=1) for number in numbers]
    best = min(single, key=lambda one: mcd.relmse(one, reference[scene]))
    own = mcd.nlm(noisy[scene], variance, weight_radius=1)
    for name, one in (("noisy, relMSE", noisy[scene]), ("best one variance", best), ("own variances", own)):
        result[f"{scene}, {name}: {mcd.relmse(one, reference[scene]):.4f}"] = one
mcd.show_images(result, columns=3)

# %% [markdown]
# The dial $k$ says how many standard deviations still pass. Slide from the noisy image to the plain mean:


# %%
def frame(k):
    image = mcd.nlm(noisy["dof"], mcd.noise_variance(samples["dof"].radiance), k=k, weight_radius=1)
    return mcd.show_images({f"relMSE {mcd.relmse(image, reference['dof']):.4f}": image})


mcd.slider(frame, k=[0.1, 0.2, 0.4, 0.6, 0.8, 1.2, 2.0, 4.0, np.inf], start=0.6)

# %% [markdown]
# ### Exercise 5 (predict): five limits
#
# `joint_nlm` multiplies both ideas: patches of the radiance, and features. (Nearness is switched off, `sigma_space` infinite.)
# What do the filters turn into? Give one letter each: **A** the image itself, **B** the plain mean of the search window,
# **C** the bilateral filter with `sigma_space` infinite, **D** the cross-bilateral filter, led by its features alone.
#
# 1. `nlm`, k goes to infinity;
# 2. `nlm`, the variance of all pixels goes to 0, k stays (and no two patches are equal);
# 3. `nlm`, the variance of all pixels goes to infinity, k stays;
# 4. `nlm`, patches of one pixel, the variance $v$ of all pixels goes to 0, but $k^2 v$ stays;
# 5. `joint_nlm`, k goes to infinity.

# %% exercise="nlm_limits"
nlm_limits = None  # five letters, such as ("D", "D", "D", "D", "D")
### BEGIN SOLUTION
nlm_limits = ("B", "A", "B", "C", "D")
### END SOLUTION

# %%
check("nlm_limits")

# %% [markdown]
# ## Texture is no noise
#
# The radiance of a matt surface is its albedo times the light that arrives, and light is smoother than texture. So divide the
# texture out, filter what is left, and multiply it back: *albedo demodulation*. What to do where the albedo is black?
#
# ### Exercise 6 (write): divide the albedo out


# %% exercise="demodulate"
def demodulate(image, albedo):
    """Split an image (h, w, 3) into irradiance and factor, by its albedo (h, w, 3), so that irradiance * factor is the image.

    In each channel the factor is the albedo, but at least 0.1: black must not be divided by, and what is nearly black (the
    rim of metal, where radiance is no matter of albedo) must not be blown up. Nothing may be NaN or infinite.

    Returns irradiance, factor : two arrays (h, w, 3).
    """
    ### BEGIN SOLUTION
    factor = np.maximum(albedo, 0.1)
    return image / factor, factor
    ### END SOLUTION


# %%
check("demodulate")

# %% [markdown]
# What is left on the checker floor is light and shadow:

# %%
irradiance, factor = demodulate(noisy["pinhole"], cleaned["pinhole"][0]["albedo"])
mcd.show_images({"pinhole, noisy": noisy["pinhole"], "factor": factor, "irradiance": irradiance / 2}, columns=3)

# %% [markdown]
# ## All together
#
# Everything that this chapter has, beside the Gaussian with the best `sigma_space` for each scene. Below the Gaussian all dials
# are the same for all scenes. (`joint` has patches, prefiltered first-hit features, and nearness of `sigma_space = 2`.)

# %%
methods = {"Gaussian": {}, "cross-bilateral": {}, "NL-means": {}, "joint": {}, "joint, albedo divided out": {}}
for scene in scenes:
    image, variance, (clean, left) = noisy[scene], mcd.noise_variance(samples[scene].radiance), cleaned[scene]
    joint = {
        "sigma_features": dials["sigma_features"],
        "variances": left,
        "sigma_space": 2.0,
        "k": 0.8,
        "weight_radius": 1,
    }
    gauss = [mcd.gaussian(image, sigma_space=sigma) for sigma in (0.35, 0.5, 0.7, 1.0, 1.4)]
    methods["Gaussian"][scene] = min(gauss, key=lambda one: mcd.relmse(one, reference[scene]))
    methods["cross-bilateral"][scene] = steps["+ prefiltered"][scene]
    methods["NL-means"][scene] = mcd.nlm(image, variance, weight_radius=1)
    methods["joint"][scene] = mcd.joint_nlm(image, variance, clean, **joint)
    methods["joint, albedo divided out"][scene] = mcd.joint_nlm(image, variance, clean, albedo=clean["albedo"], **joint)
print(f"{'relMSE':26}" + "".join(f"{scene:>13}" for scene in scenes))
for name, image in ({"noisy": noisy} | methods).items():
    print(f"{name:26}" + "".join(f"{mcd.relmse(image[scene], reference[scene]):13.4f}" for scene in scenes))

# %% [markdown]
# Patches and features together are ahead of either alone on nearly every scene, and to divide the albedo out helps once more.
# It is the *prefiltered* albedo: a raw one would be divided out with its noise, and behind the lens it does harm. (Try it.)
#
# ### Exercise 7 (break): a feature that misleads
#
# A good feature helps. Make one that harms: a grey image with noise of mean zero, and a feature in [0, 1], such that the
# filter that the feature leads (`sigma_space = 3`, `sigma_radiance` infinite, `sigma_features = 0.02`, no variances) has **at
# least five times** the mean squared error of the better of two filters that do not know it: the Gaussian, and the bilateral
# with `sigma_radiance = 0.2` (both `sigma_space = 3`). There are several ways.


# %% exercise="misleading"
def misleading():
    """Make an image and a feature that leads the filter astray.

    Returns
    -------
    noisy, feature, truth : three arrays (h, w), 16 to 64 pixels a side, the same at every call (a fixed seed). noisy -
        truth is the noise: standard deviation at least 0.02, mean within a tenth of that of 0. The feature lies in
        [0, 1]. The mean squared error with the feature is at least five times the smaller one without. Hidden tests also
        try sigma_space 2.5 and 4 with sigma_features 0.03 and 0.01, where three times is enough.
    """
    ### BEGIN SOLUTION
    rng = np.random.default_rng(0)
    truth = np.full((40, 40), 0.5)
    noise = rng.normal(0, 0.1, truth.shape).clip(-0.4, 0.4)
    return truth + noise, 0.5 + noise, truth  # the feature has the noise of the radiance, as behind a lens
    ### END SOLUTION


# %%
check("misleading")

# %%
made, feature, made_from = misleading()
mcd.show_images(
    {
        "yours": made,
        "feature": feature,
        "Gaussian": mcd.gaussian(made, sigma_space=3),
        "led by the feature": mcd.cross_bilateral(
            made, {"f": feature}, sigma_space=3, sigma_radiance=np.inf, sigma_features={"f": 0.02}
        ),
    }
)

# %% [markdown]
# ## What a variance cannot say
#
# Two places of `dof`, each of 3 x 3 pixels with 8 samples. The albedo spreads by the same amount in both, so the variances tell
# the filter to mistrust both alike. Draw each sample in the colour of its albedo, once over the screen, once over the lens:

# %%
figure, grid = plt.subplots(1, 4, figsize=(13, 3.4), layout="constrained")
one = samples["dof"]
for pair, (y, x) in zip((grid[:2], grid[2:]), ((88, 66), (100, 95)), strict=True):
    around = np.s_[y - 1 : y + 2, x - 1 : x + 2]
    albedo = one["albedo"][around].mean(axis=-1).ravel()
    screen = one.screen_position[around].reshape(-1, 2)
    lens = [one[name][around].ravel() for name in ("lens_u", "lens_v")]
    for axes, (across, down), title in zip(pair, (screen.T, lens), ("screen", "lens"), strict=True):
        shown = axes.scatter(across, down, c=albedo, cmap="viridis", vmin=0, vmax=0.7)
        axes.set_title(f"({y}, {x}), std {albedo.std():.2f}: {title}")
        axes.set_xlabel("x (pixels)" if title == "screen" else "lens_u")
        axes.set_ylabel("y (pixels)" if title == "screen" else "lens_v")
    pair[0].invert_yaxis()
_ = figure.colorbar(shown, ax=grid, label="albedo of the sample")

# %% [markdown]
# On the left the albedo depends on where the sample lies on the *screen*: this is an edge of the picture, sharp and worth
# keeping. On the right it depends on where the ray went through the *lens*: this is noise, to be averaged away. A variance says
# how much a feature varies, not what makes it vary. But the random numbers of every sample are known. Which of them a feature
# depends on can be measured: that is the question of chapter 05.
#
# ## What you should be able to do now
#
# - add features to the bilateral filter, and say for a scene whether they will help;
# - tell features that are noisy from features that do not know;
# - divide a difference by what noise explains, for features and for patches;
# - name the limits of NL-means, and say why it needs a variance for each pixel;
# - say what a variance cannot: where the noise comes from.
