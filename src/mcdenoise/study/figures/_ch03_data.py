"""What the figures of chapter 03 start from: the shipped references, renders at a fixed seed, and small drawing helpers."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from itertools import product

import numpy as np
from matplotlib.axes import Axes

from mcdenoise.filters import bilateral, gaussian
from mcdenoise.metrics import relmse
from mcdenoise.render import render_image
from mcdenoise.study.display import tone_map
from mcdenoise.study.figures._references import reference

SIZE = 128
SPACES = (0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0)  # sigma_space that are tried, in pixels
RADIANCES = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2, np.inf)  # sigma_radiance that are tried
GAUSSIAN, BILATERAL, ORACLE, NOISY, REFERENCE = "#4477AA", "#EE6677", "#228833", "#BBBBBB", "#222222"


@cache
def noisy(scene: str, spp: int = 8, seed: int = 1) -> np.ndarray:
    """A scene at a few spp; the scalar variant, which gives the same numbers on every machine."""
    return render_image(scene, SIZE, SIZE, spp, seed, variant="scalar_rgb", progress=False)


def best(filter_with: Callable[..., np.ndarray], scene: str, *choices: Iterable[float]) -> tuple[float, ...]:
    """The smallest relMSE over all combinations of parameters, and the parameters. (It looks at the reference.)"""
    return min((relmse(filter_with(*chosen), reference(scene)), *chosen) for chosen in product(*choices))


def best_gaussian(scene: str, image: np.ndarray) -> tuple[float, ...]:
    """RelMSE and sigma_space of the best Gaussian."""
    return best(lambda space: gaussian(image, sigma_space=space), scene, SPACES)


def best_bilateral(scene: str, image: np.ndarray) -> tuple[float, ...]:
    """RelMSE, sigma_space and sigma_radiance of the best bilateral."""
    return best(
        lambda space, radiance: bilateral(image, sigma_space=space, sigma_radiance=radiance), scene, SPACES, RADIANCES
    )


def picture(axes: Axes, image: np.ndarray, title: str = "") -> None:
    """Show radiance under the one tone map, without ticks."""
    axes.imshow(tone_map(image), cmap="gray", vmin=0, vmax=1, interpolation="nearest")
    axes.set(xticks=[], yticks=[])
    axes.set_title(title, fontsize=10)
