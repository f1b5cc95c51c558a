"""Chapter 03, figures that need no scene: the two bells, weights on a step, staircase, halo, limits, an outlier."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.filters import bilateral, gaussian
from mcdenoise.filters.bilateral import bilateral_sums
from mcdenoise.filters.window import bell
from mcdenoise.study.figures._ch03_data import BILATERAL, GAUSSIAN, NOISY, REFERENCE

HALF, OUT = 12, 2  # half the side of the window on the step; the centre stands 2 pixels right of the edge
STEP = {"sigma_space": 4.0, "sigma_radiance": 0.15, "radius": HALF}


def kernels() -> tuple[Figure, dict]:
    """The bell over distance, the bell over the difference of radiance, and their product."""
    figure = Figure(figsize=(9, 3.2), layout="constrained")
    near, alike, both = figure.subplots(1, 3, width_ratios=(1, 1, 1.15))
    distance, difference = np.linspace(0, 8, 200), np.linspace(0, 1, 200)
    for sigma, style in ((1, ":"), (2, "-"), (4, "--")):
        near.plot(distance, bell(distance[:, None], sigma), style, color=GAUSSIAN, label=f"{sigma} px")
    near.plot(np.arange(9), bell(np.arange(9.0)[:, None], 2), "o", color=GAUSSIAN)
    for sigma, style in ((0.1, ":"), (0.2, "-"), (0.4, "--")):
        alike.plot(difference, bell(difference[:, None], sigma), style, color=BILATERAL, label=f"{sigma}")
    near.set(title="near: $G_{\\sigma_s}$", xlabel="distance $|p - q|$ (pixels)", ylabel="weight")
    alike.set(title="alike: $G_{\\sigma_r}$", xlabel="difference $|I_p - I_q|$ (radiance)", ylabel="weight")
    weight = bell(distance[:, None], 2) * bell(difference[:, None], 0.2)[:, None]
    shown = both.contourf(distance, difference, weight, levels=np.linspace(0, 1, 21), cmap="viridis")
    lines = both.contour(distance, difference, weight, levels=(0.01, 0.1, 0.5), colors="white", linewidths=1)
    both.clabel(lines, fontsize=8)
    both.set(title="near and alike (2 px, 0.2)", xlabel="distance (pixels)", ylabel="difference (radiance)")
    figure.colorbar(shown, ax=both, label="weight", ticks=np.linspace(0, 1, 6))
    for axes in (near, alike):
        axes.grid(color="#e5e5e5")
        axes.legend(frameon=False, fontsize=9, title=f"sigma_{'space' if axes is near else 'radiance'}")
    at = {f"at_{k}_sigma": bell(np.array([float(k)]), 1) for k in (1, 2, 3)}
    return figure, at


def noisy_step(seed: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """A step from 0.25 to 0.75 between two columns, with normal noise of 0.05 and without; the window of its centre."""
    clean = np.full((2 * HALF + 1, 2 * HALF + 1), 0.25)
    clean[:, HALF - OUT :] = 0.75
    return clean + 0.05 * np.random.default_rng(seed).normal(size=clean.shape), clean


def step_weights(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The two factors of the weights of the centre pixel with every pixel of `image`."""
    offset = np.stack(np.meshgrid(np.arange(-HALF, HALF + 1), np.arange(-HALF, HALF + 1), indexing="ij"), axis=-1)
    likeness = bell((image - image[HALF, HALF])[..., np.newaxis], STEP["sigma_radiance"])
    return bell(offset, STEP["sigma_space"]), likeness


def weights() -> tuple[Figure, dict]:
    """The lecture's picture: a noisy step, the weights at its central pixel, and what both filters make of it."""
    image, clean = noisy_step()
    near, alike = step_weights(image)
    smooth = gaussian(image, sigma_space=STEP["sigma_space"], radius=HALF)
    kept = bilateral(image, **STEP)
    figure = Figure(figsize=(7.6, 5.4))
    surfaces = {
        "noisy step": (image, "gray"),
        "near: spatial kernel": (near, "viridis"),
        "alike: range kernel": (alike, "viridis"),
        "Gaussian of the step": (smooth, "gray"),
        "bilateral of the step": (kept, "gray"),
        "weight = near x alike": (near * alike, "viridis"),
    }
    x, y = np.meshgrid(np.arange(-HALF, HALF + 1), np.arange(-HALF, HALF + 1))
    for place, (title, (surface, colours)) in enumerate(surfaces.items(), 1):
        axes = figure.add_subplot(2, 3, place, projection="3d")
        axes.plot_surface(x, y, surface, cmap=colours, vmin=0, vmax=1, rstride=1, cstride=1, antialiased=False)
        axes.view_init(elev=38, azim=-118)
        axes.set(zlim=(0, 1), xticks=(-10, 0, 10), yticks=(-10, 0, 10), zticks=(0, 0.5, 1))
        axes.tick_params(pad=-3, labelsize=7)
        axes.set_xlabel("x (pixels)", labelpad=-7, fontsize=7)
        axes.set_ylabel("y (pixels)", labelpad=-7, fontsize=7)
        axes.set_title(f"{title}\n({'weight' if colours == 'viridis' else 'radiance'})", fontsize=9, y=1.02)
    figure.subplots_adjust(left=0.01, right=0.98, bottom=0.04, top=0.92, wspace=0.05, hspace=0.22)
    norm = bilateral_sums(image[..., np.newaxis], **STEP)[1][HALF, HALF]
    across = clean == 0.25
    numbers = {
        "across_near": near[across].sum() / near.sum(),
        "across_product": (near * alike)[across].sum() / norm,
        "norm_near": near.sum(),
        "norm_product": norm,
        "truth": clean[HALF, HALF],
        "noisy": image[HALF, HALF],
        "gaussian": smooth[HALF, HALF],
        "bilateral": kept[HALF, HALF],
    }
    return figure, numbers


def staircase(passes: tuple[int, ...] = (1, 5, 20)) -> tuple[Figure, dict]:
    """A soft edge, filtered again and again, turns into steps; so does a noisy one, in a single pass."""
    x = np.arange(128.0)
    clean = np.tile(1 / (1 + np.exp(-(x - 63.5) / 6)), (48, 1))
    noise = clean + 0.05 * np.random.default_rng(2).normal(size=clean.shape)
    figure = Figure(figsize=(8.6, 3.4), layout="constrained")
    numbers = {"passes": list(passes)}
    for axes, (name, image) in zip(
        figure.subplots(1, 2, sharey=True), {"clean": clean, "noisy": noise}.items(), strict=True
    ):
        axes.plot(x, image[24], color=NOISY, linewidth=4 if name == "clean" else 1, label="before")
        numbers[name] = []
        for shift, count in enumerate(range(1, max(passes) + 1)):
            image = bilateral(image, sigma_space=6.0, sigma_radiance=0.1)
            if count in passes:
                numbers[name].append(np.diff(image[24]).max() / np.diff(clean[24]).max())
                style = {"color": (GAUSSIAN, "#CCBB44", BILATERAL)[passes.index(count)], "linewidth": 1.5}
                axes.plot(x, image[24], label=f"{count} pass{'es' if shift else ''}", **style)
        axes.set(title=f"{name} soft edge (6 px, 0.1)", xlabel="x (pixels)")
        axes.grid(color="#e5e5e5")
        axes.legend(frameon=False)
    figure.axes[0].set_ylabel("radiance")
    return figure, numbers


def halo(gain: float = 3.0, sigma_space: float = 12.0, sigma_radiance: float = 0.2) -> tuple[Figure, dict]:
    """Base + gain x detail on a soft edge: the Gaussian's base makes halos, the bilateral's turns the gradient round."""
    x = np.arange(128.0)
    image = np.tile(0.5 + 0.4 * np.tanh((x - 63.5) / 5), (33, 1))
    bases = {
        "Gaussian": gaussian(image, sigma_space=sigma_space)[16],
        "bilateral": bilateral(image, sigma_space=sigma_space, sigma_radiance=sigma_radiance)[16],
    }
    row, numbers = image[16], {"gain": gain}
    figure = Figure(figsize=(8.6, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    for axes in (left, right):
        axes.plot(x, row, color=REFERENCE, linewidth=2, label="image")
    for colour, (name, base) in zip((GAUSSIAN, BILATERAL), bases.items(), strict=True):
        boosted = base + gain * (row - base)
        left.plot(x, base, color=colour, label=f"{name}")
        right.plot(x, boosted, color=colour, label=f"{name}")
        numbers[name.lower()] = {
            "overshoot": boosted.max() - row.max(),
            "slope_in_the_middle": boosted[64] - boosted[63],
            "base_slope": np.diff(base).max() / np.diff(row).max(),
        }
    left.set(title="the base: what a filter keeps", xlabel="x (pixels)", ylabel="radiance")
    right.set(title="detail (image - base) times three", xlabel="x (pixels)")
    for axes in (left, right):
        axes.grid(color="#e5e5e5")
        axes.legend(frameon=False, loc="lower right")
    return figure, numbers | {"image_slope": row[64] - row[63]}


def outlier_after(height: np.ndarray, sigma_space: float, sigma_radiance: float, radius: int) -> np.ndarray:
    """What is left of one outlier over a flat neighbourhood of 0, in closed form: h / (1 + S G_sigma_radiance(h)).

    S is the sum of the spatial weights of all neighbours without the centre.
    """
    reach = np.arange(-radius, radius + 1.0)
    neighbours = bell(reach[:, np.newaxis], sigma_space).sum() ** 2 - 1
    return height / (1 + neighbours * bell(np.asarray(height)[..., np.newaxis], sigma_radiance))


def outlier() -> tuple[Figure, dict]:
    """How much of an outlier survives, against its height: the closed form, and the filter itself."""
    figure = Figure(figsize=(6.6, 3.4), layout="constrained")
    axes = figure.subplots()
    height, setting = np.linspace(0.01, 8, 400), {"sigma_space": 1.5, "radius": 5}
    left = outlier_after(height, sigma_radiance=1.0, **setting) / height
    axes.plot(height, left, color=BILATERAL, label="bilateral, closed form")
    tried = np.array([0.5, 1.0, 2.0, 3.0, 3.5, 4.0, 5.0, 6.0, 7.5])
    measured = []
    for h in tried:
        image = np.zeros((11, 11))
        image[5, 5] = h
        measured.append(bilateral(image, sigma_radiance=1.0, engine="numpy", **setting)[5, 5] / h)
    axes.plot(tried, measured, "o", color=BILATERAL, label="bilateral, filtered")
    all_alike = outlier_after(np.array([1.0]), sigma_radiance=np.inf, **setting)[0]
    axes.axhline(all_alike, color=GAUSSIAN, linestyle="--", label="Gaussian")
    axes.set(xlabel="height of the outlier / sigma_radiance", ylabel="share of it that is left", ylim=(0, 1.05))
    axes.set_title("One outlier in a flat image, sigma_space = 1.5 px")
    axes.grid(color="#e5e5e5")
    axes.legend(frameon=False, loc="upper left")
    half = float(np.interp(0.5, left[height > 1], height[height > 1]))
    numbers = {"gaussian": all_alike, "half_left_at": half, "left": dict(zip(tried, measured, strict=True))}
    return figure, numbers
