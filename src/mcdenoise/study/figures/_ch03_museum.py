"""Chapter 03, a museum case: what one impulse shows about three bilateral filters."""

from __future__ import annotations

from importlib.metadata import version

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.filters import bilateral
from mcdenoise.filters.window import bell

MIDDLE, SIGMA, WIDE = 20, 2.0, 1e3  # of a 41 x 41 image; sigma_space in pixels; a sigma_radiance that hides no one


def impulse() -> np.ndarray:
    """One bright pixel in the middle of black."""
    image = np.zeros((2 * MIDDLE + 1, 2 * MIDDLE + 1))
    image[MIDDLE, MIDDLE] = 1.0
    return image


def centre_and_spread(response: np.ndarray) -> dict[str, float]:
    """Centroid from the middle and standard deviations of a response, in pixels."""
    y, x = np.indices(response.shape) - MIDDLE
    share = response / response.sum()
    off_y, off_x = (share * y).sum(), (share * x).sum()
    spread = np.sqrt((share * (y - off_y) ** 2).sum()), np.sqrt((share * (x - off_x) ** 2).sum())
    return {"y": off_y, "x": off_x, "std_y": spread[0], "std_x": spread[1]}


def library_response() -> np.ndarray:
    """The impulse response of scikit-image's bilateral filter as installed."""
    from skimage.restoration import denoise_bilateral

    return denoise_bilateral(impulse(), sigma_color=WIDE, sigma_spatial=SIGMA)


def misread_response(window: int = 13) -> np.ndarray:
    """What a table of (window + 1)^2 weights gives when it is read as if its rows had `window` entries.

    ``arange(-window // 2, window // 2 + 1)`` has one entry too many for an odd window: -13 // 2 is -7, not -6.
    """
    reach = np.arange(-window // 2, window // 2 + 1)
    table = bell(reach[:, np.newaxis], SIGMA)[:, np.newaxis] * bell(reach[:, np.newaxis], SIGMA)
    weight = table.ravel()[: window**2].reshape(window, window)
    response = np.zeros_like(impulse())
    side = slice(MIDDLE - window // 2, MIDDLE + window // 2 + 1)
    response[side, side] = weight[::-1, ::-1] / weight.sum()
    return response


def museum() -> tuple[Figure, dict]:
    """Our impulse response, scikit-image's, and the explanation of the difference, drawn alike."""
    installed = version("scikit-image")
    responses = {
        "ours": bilateral(impulse(), sigma_space=SIGMA, sigma_radiance=WIDE, radius=6),
        f"scikit-image {installed}": library_response(),
        "14 x 14 table, read in rows of 13": misread_response(),
    }
    figure = Figure(figsize=(8.8, 3.7), layout="constrained")
    figure.suptitle("Response to one impulse at (0, 0), sigma_space = 2 px, range kernel switched off", fontsize=11)
    measured = []
    for axes, (name, response) in zip(figure.subplots(1, 3, sharey=True), responses.items(), strict=True):
        at = centre_and_spread(response)
        measured.append(at)
        reach = (-MIDDLE - 0.5, MIDDLE + 0.5)
        shown = axes.imshow(response, cmap="magma", vmin=0, vmax=0.041, extent=(*reach, *reach[::-1]))
        axes.axhline(0, color="#88ccff", linewidth=0.6)
        axes.axvline(0, color="#88ccff", linewidth=0.6)
        axes.plot(at["x"], at["y"], "+", color="#00E5FF", markersize=14, markeredgewidth=2)
        axes.set(
            xlim=(-11, 11), ylim=(11, -11), xlabel="x (pixels)", xticks=range(-10, 11, 5), yticks=range(-10, 11, 5)
        )
        y, x = (round(at[axis], 2) + 0.0 for axis in "yx")
        spread = f"std {at['std_y']:.1f}, {at['std_x']:.1f}"
        axes.set_title(f"{name}\ncentroid y {y:+.2f}, x {x:+.2f}; {spread}", fontsize=8)
    figure.axes[0].set_ylabel("y (pixels)")
    figure.colorbar(shown, ax=figure.axes, label="response", shrink=0.9)
    ours, library, misread = responses.values()
    numbers = {
        "version": installed,
        "ours": measured[0],
        "library": measured[1],
        "library_is_centred": bool(np.hypot(measured[1]["y"], measured[1]["x"]) < 0.01),
        "library_from_ours": np.abs(library - ours).max(),
        "library_from_misread_table": np.abs(library - misread).max(),
        "peak": ours.max(),
    }
    return figure, numbers
