"""Chapter 03, figures about the two dials: the limits of sigma_radiance, the error map, the sliders."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from mcdenoise.filters import bilateral, gaussian
from mcdenoise.metrics import relmse
from mcdenoise.study.figures._ch03_data import (
    GAUSSIAN,
    NOISY,
    RADIANCES,
    SPACES,
    best_gaussian,
    noisy,
    picture,
)
from mcdenoise.study.figures._references import reference
from mcdenoise.study.slider import Slider, slider


def distances_to_limits(
    image: np.ndarray, sigma_radiance: np.ndarray, sigma_space: float = 1.4
) -> tuple[np.ndarray, np.ndarray]:
    """RMS difference of the bilateral from the image itself, and from the Gaussian, for each sigma_radiance."""
    smooth = gaussian(image, sigma_space=sigma_space, engine="numpy")
    rows = []
    for sigma in sigma_radiance:
        kept = bilateral(image, sigma_space=sigma_space, sigma_radiance=sigma, engine="numpy")
        rows.append([np.sqrt(((kept - other) ** 2).mean()) for other in (image, smooth)])
    return np.array(rows)[:, 0], np.array(rows)[:, 1]


def limits() -> tuple[Figure, dict]:
    """sigma_radiance to 0 gives the image back, to infinity the Gaussian: both distances, measured."""
    image = noisy("pinhole")[60:108, 30:78].astype(np.float64)
    sigma_radiance = np.geomspace(1e-3, 1e2, 21)
    to_image, to_gaussian = distances_to_limits(image, sigma_radiance)
    figure = Figure(figsize=(9.4, 3.6), layout="constrained")
    axes, *shown = figure.subplots(1, 4, width_ratios=(1.7, 1, 1, 1))
    axes.loglog(sigma_radiance, to_image, "s-", color=NOISY, label="distance from the image")
    axes.loglog(sigma_radiance, to_gaussian, "o-", color=GAUSSIAN, label="distance from the Gaussian")
    tail = sigma_radiance >= 3
    axes.loglog(
        sigma_radiance[tail], to_gaussian[tail][-1] * (1e2 / sigma_radiance[tail]) ** 2 * 2, "k:", label="slope -2"
    )
    axes.set(xlabel="sigma_radiance", ylabel="RMS difference (radiance)", ylim=(3e-9, 1))
    axes.set_title("pinhole, 8 spp, sigma_space = 1.4 px")
    axes.grid(color="#e5e5e5")
    axes.legend(frameon=False, loc="lower left")
    for one, sigma in zip(shown, (0.01, 0.2, 100.0), strict=True):
        title = f"sigma_radiance\n= {sigma:g}"
        picture(one, bilateral(image, sigma_space=1.4, sigma_radiance=sigma, engine="numpy"), title)
    slope = np.polyfit(np.log(sigma_radiance[-5:]), np.log(to_gaussian[-5:]), 1)[0]
    numbers = {
        "slope": slope,
        "image_at_0_001": to_image[0],
        "gaussian_at_100": to_gaussian[-1],
        "equal_at": float(np.interp(0, np.log(to_image / to_gaussian), np.log10(sigma_radiance))),
        "image_to_gaussian": to_image[-1],
    }
    numbers["equal_at"] = 10 ** numbers["equal_at"]
    return figure, numbers


def error_map() -> tuple[Figure, dict]:
    """RelMSE over both bandwidths, on a scene of sharp edges and on one with a lens."""
    figure = Figure(figsize=(9.4, 4.3), layout="constrained")
    radiances, numbers = RADIANCES[:-1], {}
    for axes, scene in zip(figure.subplots(1, 2), ("pinhole", "dof"), strict=True):
        image = noisy(scene)
        errors = np.array(
            [
                [relmse(bilateral(image, sigma_space=s, sigma_radiance=r), reference(scene)) for r in radiances]
                for s in SPACES
            ]
        )
        shown = axes.imshow(errors, cmap="viridis_r", norm=LogNorm(errors.min(), errors.max()), origin="lower")
        for (i, j), error in np.ndenumerate(errors):
            light = error > np.sqrt(errors.min() * errors.max())
            axes.text(
                j, i, f"{error:.4f}"[1:], ha="center", va="center", fontsize=7, color="white" if light else "black"
            )
        i, j = np.unravel_index(errors.argmin(), errors.shape)
        axes.plot(j, i, "s", markersize=22, markerfacecolor="none", markeredgecolor="#EE3333", markeredgewidth=2)
        axes.set_xticks(range(len(radiances)), [f"{r:g}" for r in radiances])
        axes.set_yticks(range(len(SPACES)), [f"{s:g}" for s in SPACES])
        axes.set(xlabel="sigma_radiance", ylabel="sigma_space (pixels)")
        axes.set_title(f"{scene}, 8 spp: unfiltered {relmse(image, reference(scene)):.4f}", fontsize=11)
        figure.colorbar(shown, ax=axes, label="relMSE", format="%.3g")
        numbers[scene] = {
            "sigma_space": SPACES[i],
            "sigma_radiance": radiances[j],
            "relmse": errors[i, j],
            "gaussian": best_gaussian(scene, image)[0],
        }
    return figure, numbers


def _slide(title: str, space: float, radiance: float) -> Figure:
    """One frame: the filtered image and its error in the title."""
    image = noisy("pinhole")
    filtered = bilateral(image, sigma_space=space, sigma_radiance=radiance)
    figure = Figure(figsize=(3.6, 3.9), layout="constrained")
    picture(figure.subplots(), filtered, f"{title}: relMSE {relmse(filtered, reference('pinhole')):.4f}")
    return figure


def slider_radiance() -> tuple[Slider, dict]:
    """sigma_radiance from 0.02 to infinity on the pinhole scene."""
    values = [0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2, np.inf]
    frames = slider(
        lambda value: _slide("sigma_space = 1.4 px", 1.4, value),
        title="From the image itself to the Gaussian",
        sigma_radiance=values,
        start=0.2,
    )
    return frames, {"frames": len(values)}


def slider_space() -> tuple[Slider, dict]:
    """sigma_space from 0.35 to 8 pixels on the pinhole scene."""
    values = [0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 8.0]
    frames = slider(
        lambda value: _slide("sigma_radiance = 0.2", value, 0.2),
        title="How far is near?",
        unit="px",
        sigma_space=values,
        start=1.4,
    )
    return frames, {"frames": len(values)}
