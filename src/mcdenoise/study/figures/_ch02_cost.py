"""Chapter 02, what a Gaussian filter takes away from noise, and what it costs."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.filters.gaussian import gaussian, gaussian_sums
from mcdenoise.filters.window import bell
from mcdenoise.kernels.gaussian import space_weight, sum_rows
from mcdenoise.study.charts import COLOURS, GREY, MARKERS
from mcdenoise.study.figures._ch02_errors import plain_log

NOISE_SIGMAS = (0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0)
NOISE_SIZE = 1024
RADII = (1, 2, 4, 8, 16, 32)
ROUNDS = 3
FITTED = 8  # exponents are fitted from this radius on, where the calls themselves no longer count


def share_left(sigma_space: float, radius: int) -> float:
    """Return sum w^2 / (sum w)^2 over the window: the share of white noise's variance that the filter leaves, exactly.

    Examples
    --------
    >>> round(share_left(2.0, 12) * 4 * np.pi * 2.0**2, 6)
    1.0
    """
    line = bell(np.arange(-radius, radius + 1)[:, np.newaxis], sigma_space)
    return float((np.sum(line**2) / np.sum(line) ** 2) ** 2)


def measured_share(sigma_space: float, seed: int = 0) -> tuple[float, float]:
    """Return the variance that the filter leaves of white noise of variance 1, far from borders, and its standard error.

    The variance of n pixels of a Gaussian field with correlation rho has the relative standard error
    sqrt(2 sum rho^2 / n); here rho(d) = exp(-d^2 / (4 sigma^2)), so sum rho^2 = 2 pi sigma^2 (at least 1).
    """
    noise = np.random.default_rng(seed).standard_normal((NOISE_SIZE, NOISE_SIZE))
    margin = int(np.ceil(3 * sigma_space))
    inside = gaussian(noise, sigma_space=sigma_space)[margin:-margin, margin:-margin]
    share = float(np.mean(inside**2))
    return share, share * float(np.sqrt(2 * max(1.0, 2 * np.pi * sigma_space**2) / inside.size))


def make_noise_left() -> tuple[Figure, dict]:
    """Chart the variance that is left of white noise, and show the noise itself."""
    figure = Figure(figsize=(8.8, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.1, 1))
    fine = np.geomspace(0.3, 4.5, 60)
    measured = [measured_share(sigma) for sigma in NOISE_SIGMAS]
    left.plot(fine, 1 / (4 * np.pi * fine**2), "--", color=GREY, label="1 / (4 π sigma²)")
    left.plot(fine, [share_left(s, int(np.ceil(3 * s))) for s in fine], color=COLOURS[0], label="Σw² / (Σw)²")
    left.plot(NOISE_SIGMAS, [share for share, _ in measured], "o", color=COLOURS[1], label="measured")
    plain_log(left)
    left.set(
        title="variance that is left of white noise", xlabel="sigma_space (pixels)", ylabel="share of the variance"
    )
    left.legend(frameon=False)
    noise = 0.25 * np.random.default_rng(0).standard_normal((64, 64))
    tiles = [noise, *(gaussian(noise, sigma_space=sigma, engine="numpy") for sigma in (1.0, 2.0, 4.0))]
    right.imshow(np.block([tiles[:2], tiles[2:]]), cmap="gray", vmin=-0.75, vmax=0.75, interpolation="nearest")
    right.set(xticks=[], yticks=[], title="the same noise: as it is, sigma 1, 2, 4")
    right.axhline(63.5, color="white")
    right.axvline(63.5, color="white")
    numbers = {
        "measured_2": measured[NOISE_SIGMAS.index(2.0)][0],
        "formula_2": 1 / (16 * np.pi),
        "exact_2": share_left(2.0, 6),
        "exact_half": share_left(0.5, 2),
        "formula_half": 1 / np.pi,
        "largest_z": max(
            abs(share - share_left(s, int(np.ceil(3 * s)))) / error
            for s, (share, error) in zip(NOISE_SIGMAS, measured, strict=True)
        ),
    }
    return figure, numbers


def separable_sums(image: np.ndarray, sigma_space: float, radius: int) -> tuple[np.ndarray, np.ndarray]:
    """Return total and norm as `gaussian_sums` does, in NumPy, by one pass along the rows and one down the columns.

    Examples
    --------
    >>> image = np.arange(12.0).reshape(3, 4, 1)
    >>> bool(np.allclose(separable_sums(image, 1.0, 2)[0], gaussian_sums(image, 1.0, 2)[0]))
    True
    """
    total, norm = image.astype(np.float64), np.ones(image.shape[:2])
    for axis in (1, 0):
        total, norm = _line_sums(total, sigma_space, radius, axis), _line_sums(norm, sigma_space, radius, axis)
    return total, norm


def _line_sums(image: np.ndarray, sigma_space: float, radius: int, axis: int) -> np.ndarray:
    """Weighted sum along one axis of the values inside the image."""
    image = np.moveaxis(image, axis, 0)
    total = np.zeros_like(image)
    for d in range(min(radius, len(image) - 1) + 1):
        weight = bell(np.array([d]), sigma_space)
        total[: len(image) - d] += weight * image[d:]
        if d:
            total[d:] += weight * image[:-d]
    return np.moveaxis(total, 0, axis)


def compiled_sums(image: np.ndarray, sigma_space: float, radius: int) -> np.ndarray:
    """Return the total of the numba kernel, on one core, so that all versions are measured alike.

    Examples
    --------
    >>> image = np.arange(12, dtype=np.float32).reshape(3, 4, 1)
    >>> bool(np.allclose(compiled_sums(image, 1.0, 2), gaussian_sums(image, 1.0, 2)[0]))
    True
    """
    height, width, channels = image.shape
    weight_y, weight_x = (space_weight(sigma_space, min(radius, size - 1)) for size in (height, width))
    total = np.empty_like(image)
    sum_rows(total.ravel(), image.ravel(), weight_y, weight_x, height, channels, 0, height)
    return total


def shortest_times(sums: Callable, image: np.ndarray) -> np.ndarray:
    """Return the CPU time of `sums` for each of RADII, in seconds: the run that other work disturbed least."""
    sums(image, 1.0, 1)  # compiles
    shortest = np.full(len(RADII), np.inf)
    for _ in range(ROUNDS):
        for k, radius in enumerate(RADII):
            ends = time.process_time() + 0.05
            now = 0.0
            while now < ends:
                start = time.process_time()
                sums(image, radius / 3, radius)
                now = time.process_time()
                shortest[k] = min(shortest[k], now - start)
    return shortest


def make_cost() -> tuple[Figure, dict]:
    """Chart the time of the direct sum, of two passes and of the numba kernel over the side of the window."""
    image = np.random.default_rng(0).random((256, 256, 3), np.float32)
    versions = {"NumPy, whole window": gaussian_sums, "NumPy, two passes": separable_sums}
    versions["numba, two passes"] = compiled_sums
    sides = np.array([2 * radius + 1 for radius in RADII])
    large = np.array(RADII) >= FITTED
    figure = Figure(figsize=(7.5, 4.8), layout="constrained")
    axes, numbers = figure.subplots(), {}
    for (name, sums), short, colour, marker in zip(
        versions.items(), ("direct", "passes", "numba"), COLOURS, MARKERS, strict=False
    ):
        seconds = shortest_times(sums, image)
        exponent = float(np.polyfit(np.log(sides[large]), np.log(seconds[large]), 1)[0])
        axes.plot(sides, 1e3 * seconds, marker=marker, color=colour, label=f"{name}: slope {exponent:.2f}")
        numbers[short] = {"exponent": exponent, "milliseconds": list(1e3 * seconds)}
    plain_log(axes, subs=(1,))
    axes.set_xticks(sides, [f"{side}" for side in sides])
    axes.set(xlabel="side of the window, 2 radius + 1 (pixels)", ylabel="CPU milliseconds, 256 x 256 x 3")
    axes.set_title(f"What a Gaussian costs (one core of this machine; slopes fitted from radius {FITTED} on)")
    axes.legend(frameon=False)
    numbers["ratio_32"] = numbers["direct"]["milliseconds"][-1] / numbers["passes"]["milliseconds"][-1]
    numbers["taps_ratio_32"] = sides[-1] / 2
    return figure, numbers
