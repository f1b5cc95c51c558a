"""Few samples of a light field, each carried along its own trajectory: the idea of Lehtinen et al. 2011 on one scanline."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mcdenoise.metrics import relmse
from mcdenoise.study.charts import COLOURS
from mcdenoise.study.display import tone_map
from mcdenoise.study.figures import _ch01_lens as lens
from mcdenoise.study.figures._ch01_lightfield import FINER, PIXELS, VIEWS, scanline

SPP = 4
SEEDS = 4  # sets of samples that the errors are averaged over
REACH = 0.75  # pixels: trajectories that pass a query at most so far away have a say
US = (np.arange(16) + 0.5) / 16  # where the light field is reconstructed
XS = (np.arange(PIXELS * FINER) + 0.5) / FINER


@dataclass(frozen=True)
class Sparse:
    """Samples of a light field: where on the lens and on the screen, what they saw, how they move along u."""

    u: np.ndarray
    x: np.ndarray
    radiance: np.ndarray
    depth: np.ndarray
    slope: np.ndarray

    def at(self, u: float) -> np.ndarray:
        """Return where on the screen, pixels, each sample's point is seen from lens place u."""
        return self.x + self.slope * (u - self.u)


def draw_samples(rng: np.random.Generator, spp: int = SPP) -> Sparse:
    """Look up `spp` cells of the light field, at random u and x, for each pixel of the scanline."""
    field = scanline()
    views = rng.integers(0, VIEWS, (PIXELS, spp)).ravel()
    columns = (np.arange(PIXELS)[:, np.newaxis] * FINER + rng.integers(0, FINER, (PIXELS, spp))).ravel()
    depth = field.depth[views, columns]
    return Sparse(
        u=(views + 0.5) / VIEWS,
        x=(columns + 0.5) / FINER,
        radiance=field.radiance[views, columns],
        depth=depth,
        slope=lens.light_field_slope(depth, PIXELS),
    )


def same_surface(samples: Sparse, one: int, others: np.ndarray) -> np.ndarray:
    """Return which of `others` can lie on one apparent surface with sample `one`: trajectories that do not cross.

    Two trajectories cross on the lens if their order on the screen at u = 0 is not that at u = 1 (Lehtinen et al. 2011,
    SameSurface).
    """
    start, end = samples.at(0.0), samples.at(1.0)
    return (start[others] - start[one]) * (end[others] - end[one]) >= 0


def front_layer(samples: Sparse, near: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """Return those of the samples `near` a query that lie on the nearest surface that covers it.

    A surface covers the query if it has samples to its left and to its right (`offset` in pixels, of all samples).
    """
    rest = near[np.argsort(samples.depth[near])]
    while rest.size:
        layer = rest[same_surface(samples, rest[0], rest)]
        if offset[layer].min() <= 0 <= offset[layer].max():
            return layer
        rest = rest[~np.isin(rest, layer)]
    return near[[np.abs(offset[near]).argmin()]]


def reconstruct(samples: Sparse, *, along_slopes: bool = True, by_surface: bool = True) -> np.ndarray:
    """Reconstruct the light field at `US` and `XS` from few samples; returns (32, PIXELS, 3).

    Each query takes a mean of the samples that pass near it, weighted by a tent over the distance: as they stand, or
    carried `along_slopes`; all of them, or `by_surface` only those of the nearest surface that covers it.
    """
    result = np.empty((len(US), len(XS), 3))
    for row, u in enumerate(US):
        place = samples.at(u) if along_slopes else samples.x
        for column, x in enumerate(XS):
            offset = place - x
            near = np.flatnonzero(np.abs(offset) < REACH)
            if not near.size:
                near = np.array([np.abs(offset).argmin()])
            chosen = front_layer(samples, near, offset) if by_surface else near
            weight = np.maximum(REACH - np.abs(offset[chosen]), 1e-6)
            result[row, column] = weight @ samples.radiance[chosen] / weight.sum()
    return result


def pixel_row(radiance: np.ndarray) -> np.ndarray:
    """Return the scanline (PIXELS, 3) of a light field: its mean over u, and over the columns of each pixel."""
    return radiance.mean(axis=0).reshape(PIXELS, FINER, 3).mean(axis=1)


def compare(seed: int) -> tuple[Sparse, np.ndarray, dict[str, np.ndarray]]:
    """Return a set of samples, the light field reconstructed along slopes, and the scanlines of all four ways."""
    samples = draw_samples(np.random.default_rng(seed))
    along = reconstruct(samples)
    return (
        samples,
        along,
        {
            "input": samples.radiance.reshape(PIXELS, SPP, 3).mean(axis=1),
            "without_slopes": pixel_row(reconstruct(samples, along_slopes=False, by_surface=False)),
            "without_surfaces": pixel_row(reconstruct(samples, by_surface=False)),
            "along_slopes": pixel_row(along),
        },
    )


def make_same_surface() -> tuple[Figure, dict[str, float]]:
    """Show few samples, the light field reconstructed along their slopes, and the scanline before and after."""
    truth = pixel_row(scanline().radiance)
    sets = [compare(seed) for seed in range(SEEDS)]
    samples, along, estimates = sets[0]
    errors = {
        name: float(np.mean([relmse(one[2][name][np.newaxis], truth[np.newaxis]) for one in sets]))
        for name in estimates
    }
    figure = Figure(figsize=(9.2, 5.4), layout="constrained")
    (a, b), (c, d) = figure.subplots(2, 2)
    a.scatter(samples.x, samples.u, c=tone_map(samples.radiance[np.newaxis])[0], s=9, edgecolors="none")
    a.set(facecolor="#dddddd", xlim=(0, PIXELS), ylim=(0, 1), title=f"the samples: {SPP} to a pixel", ylabel="lens u")
    extent = (0, PIXELS, 0, 1)
    b.imshow(tone_map(along), aspect="auto", origin="lower", extent=extent, interpolation="nearest")
    b.set(title="reconstructed along their slopes", ylabel="lens u")
    crossing = _draw_crossing(c)
    for name, label, colour in (
        ("input", f"mean of {SPP} samples", COLOURS[4]),
        ("along_slopes", "reconstructed", COLOURS[1]),
    ):
        d.plot(np.arange(PIXELS) + 0.5, estimates[name].mean(axis=1), color=colour, label=label)
    d.plot(np.arange(PIXELS) + 0.5, truth.mean(axis=1), color="black", linewidth=1, label="truth")
    d.set(title="mean over u: the scanline", xlabel="screen x (pixels)", ylabel="radiance", xlim=(0, PIXELS))
    d.set_ylim(0, 1.5 * truth.mean(axis=1).max())
    d.legend(frameon=False, fontsize=9)
    numbers = {
        "spp": SPP,
        "seeds": SEEDS,
        **{f"relmse_{name}": error for name, error in errors.items()},
        "gain": errors["input"] / errors["along_slopes"],
        **crossing,
    }
    return figure, numbers


def _draw_crossing(axes: Axes) -> dict[str, float]:
    """Zoom in on the edge of the green ball: a trajectory on it and one on the yellow ball behind cross."""
    field = scanline()
    shown = slice(int(26 * FINER), int(42 * FINER))
    axes.imshow(
        tone_map(field.radiance[:, shown]),
        aspect="auto",
        origin="lower",
        extent=(26, 42, 0, 1),
        interpolation="nearest",
    )
    # a point near the edge of the green ball seen at u = 0.9, and one of the yellow ball seen right of the edge at u = 0.1
    places = []
    for u, x, colour in ((0.9, 31.5, "white"), (0.1, 34.5, COLOURS[1])):
        depth = field.depth[int(u * VIEWS), int(x * FINER)]
        slope = float(lens.light_field_slope(depth, PIXELS))
        us = np.array([0.0, 1.0])
        axes.plot(x + slope * (us - u), us, color="black", linewidth=3.2)
        axes.plot(x + slope * (us - u), us, color=colour, linewidth=1.8)
        places.append((u, x, slope))
    (u_1, x_1, slope_1), (u_2, x_2, slope_2) = places
    u = (x_2 - slope_2 * u_2 - x_1 + slope_1 * u_1) / (slope_1 - slope_2)
    axes.plot(x_1 + slope_1 * (u - u_1), u, "o", color="black", markerfacecolor="white", markersize=8)
    axes.set(title="trajectories cross: the nearer hides the farther", xlabel="screen x (pixels)", ylabel="lens u")
    return {"crossing_u": u, "crossing_x": x_1 + slope_1 * (u - u_1), "slope_near": slope_1, "slope_far": slope_2}
