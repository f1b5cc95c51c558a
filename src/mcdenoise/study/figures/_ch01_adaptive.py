"""Where to put samples: in noisy pixels, or at the discontinuities of the light field (Hachisuka et al. 2008)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from mcdenoise.metrics import relmse
from mcdenoise.study.charts import COLOURS
from mcdenoise.study.display import tone_map
from mcdenoise.study.figures._ch01_lightfield import FINER, PIXELS, VIEWS, scanline
from mcdenoise.study.figures._ch01_reconstruct import pixel_row

BUDGETS = (8, 16)  # samples to a pixel, on average
FIRST = 4  # samples in each pixel before cells are told apart
LEAF, LEAST = 4, 2  # a cell with LEAF samples is cut in two, if each half gets LEAST: one sample has no contrast
TALL = 4.0  # pixels that the whole lens is worth when a cell's longer side is chosen
SEEDS = 8
SHOWN = (14, 50)  # pixels of the scanline in the figure
EPSILON = 0.01  # that of relMSE: both ways are after the relative error


def look_up(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return the radiance (n, 3) of the light field at x (pixels) and u."""
    rows, columns = (np.asarray(u) * VIEWS).astype(int), (np.asarray(x) * FINER).astype(int)
    return scanline().radiance[rows, columns]


def image_space(
    rng: np.random.Generator, spp: int, *, adaptive: bool = True
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Share the samples among pixels by the spread of pilot samples, u at random; returns x, u and the scanline
    (PIXELS, 3).

    Half of the budget are pilot samples, the same for all pixels. A pixel's share of the rest is proportional to their
    standard deviation over their mean, which makes the summed relative variance of all pixels smallest (Neyman's
    allocation). Without `adaptive` all pixels get the same.
    """
    pilot = spp // 2
    pilot_x = np.arange(PIXELS)[:, np.newaxis] + rng.random((PIXELS, pilot))
    pilot_u = rng.random((PIXELS, pilot))
    values = look_up(pilot_x, pilot_u)
    spread = (values.std(axis=1) / np.sqrt(values.mean(axis=1) ** 2 + EPSILON)).mean(axis=1)
    rest = spp * PIXELS - pilot_x.size
    share = spread / spread.sum() if adaptive else np.full(PIXELS, 1 / PIXELS)
    # whole numbers that add up to the rest
    counts = np.diff(np.rint(np.concatenate([[0], share.cumsum()]) * rest)).astype(int)
    pixel = np.repeat(np.arange(PIXELS), counts)
    x = np.concatenate([pilot_x.ravel(), pixel + rng.random(rest)])
    u = np.concatenate([pilot_u.ravel(), rng.random(rest)])
    total = np.zeros((PIXELS, 3))
    np.add.at(total, x.astype(int), look_up(x, u))
    return x, u, total / (pilot + counts)[:, np.newaxis]


@dataclass
class Cell:
    """A box of the (x, u) plane with the samples in it; `low` and `high` are its corners, x in pixels and u."""

    low: np.ndarray
    high: np.ndarray
    places: list = field(default_factory=list)
    radiance: list = field(default_factory=list)

    def priority(self) -> float:
        """Return what the cell may add to the error: its area times the contrast of its samples."""
        values = np.array(self.radiance)
        contrast = np.abs(values - values.mean(axis=0)).mean() / np.sqrt(values.mean() ** 2 + EPSILON)
        return float(np.prod(self.high - self.low) * (contrast + 0.01))

    def add(self, rng: np.random.Generator) -> None:
        """Take one sample, at random inside the cell."""
        place = self.low + rng.random(2) * (self.high - self.low)
        self.places.append(place)
        self.radiance.append(look_up(*place))

    def halves(self) -> tuple[Cell, Cell]:
        """Cut the cell across its longer side; each half keeps its samples."""
        axis = int(np.argmax((self.high - self.low) * (1, TALL)))
        middle = (self.low[axis] + self.high[axis]) / 2
        cut_high, cut_low = self.high.copy(), self.low.copy()
        cut_high[axis] = cut_low[axis] = middle
        halves = Cell(self.low, cut_high), Cell(cut_low, self.high)
        for place, radiance in zip(self.places, self.radiance, strict=True):
            half = halves[int(place[axis] >= middle)]
            half.places.append(place)
            half.radiance.append(radiance)
        return halves


def grow_cells(rng: np.random.Generator, spp: int) -> list[Cell]:
    """Put each next sample into the cell of (x, u) that errs most, and cut cells that are full; they start as pixels."""
    cells = [Cell(np.array([float(x), 0.0]), np.array([x + 1.0, 1.0])) for x in range(PIXELS)]
    for cell in cells:
        for _ in range(FIRST):
            cell.add(rng)
    priorities = [cell.priority() for cell in cells]
    for _ in range((spp - FIRST) * PIXELS):
        worst = int(np.argmax(priorities))
        cell = cells[worst]
        cell.add(rng)
        halves = cell.halves()
        if len(cell.places) >= LEAF and all(len(half.places) >= LEAST for half in halves):
            cells[worst] = halves[0]
            cells.append(halves[1])
            priorities.append(halves[1].priority())
        priorities[worst] = cells[worst].priority()
    return cells


def integrate(cells: list[Cell]) -> np.ndarray:
    """Return the scanline (PIXELS, 3): the integral over u of a light field that is constant on each cell."""
    row = np.zeros((PIXELS, 3))
    for cell in cells:
        row[int(cell.low[0])] += np.prod(cell.high - cell.low) * np.mean(cell.radiance, axis=0)
    return row


def make_adaptive() -> tuple[Figure, dict[str, float]]:
    """Show where the same number of samples goes: by pixel, and by cell of the light field; and what it brings."""
    truth = pixel_row(scanline().radiance)
    ways = {
        "uniform": lambda rng, spp: image_space(rng, spp, adaptive=False)[2],
        "image_space": lambda rng, spp: image_space(rng, spp)[2],
        "multidimensional": lambda rng, spp: integrate(grow_cells(rng, spp)),
    }
    numbers: dict[str, float] = {"seeds": SEEDS}
    for spp in BUDGETS:
        for name, way in ways.items():
            rows = [way(np.random.default_rng([seed, spp]), spp) for seed in range(SEEDS)]
            errors = [relmse(row[np.newaxis], truth[np.newaxis]) for row in rows]
            numbers[f"{name}_{spp}"] = float(np.mean(errors))
            numbers[f"{name}_{spp}_se"] = float(np.std(errors, ddof=1) / np.sqrt(SEEDS))
    spp = BUDGETS[-1]
    figure = Figure(figsize=(7.6, 6), layout="constrained")
    above, middle, below = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 1.6))
    x, u, _ = image_space(np.random.default_rng([0, spp]), spp)
    cells = grow_cells(np.random.default_rng([0, spp]), spp)
    where = np.concatenate([cell.places for cell in cells])
    middle.add_collection(
        PatchCollection(
            [Rectangle(cell.low, *(cell.high - cell.low)) for cell in cells],
            facecolor="none",
            edgecolor=COLOURS[1],
            linewidth=0.5,
        )
    )
    for axes, places, name, title, colour in (
        (above, (x, u), "image_space", "image space: by the spread inside each pixel", COLOURS[0]),
        (middle, where.T, "multidimensional", "multidimensional: by the contrast inside each cell", COLOURS[1]),
    ):
        pale = 0.5 + 0.5 * tone_map(scanline().radiance)
        axes.imshow(pale, aspect="auto", origin="lower", extent=(0, PIXELS, 0, 1), interpolation="nearest")
        axes.plot(*places, ".", color="black", markersize=2.5)
        axes.set(ylabel="lens u", ylim=(0, 1), title=f"{title}; relMSE {numbers[f'{name}_{spp}']:.4f}")
        counts = np.bincount(places[0].astype(int), minlength=PIXELS)
        below.step(np.arange(PIXELS) + 0.5, counts, where="mid", color=colour, label=name.replace("_", " "))
    below.axhline(
        spp, color="black", linewidth=1, linestyle=":", label=f"uniform: relMSE {numbers[f'uniform_{spp}']:.4f}"
    )
    below.set(xlabel="screen x (pixels)", ylabel="spp", xlim=SHOWN, title="samples in each pixel")
    below.legend(frameon=False, fontsize=9, ncols=3, loc="upper center")
    below.set_ylim(0, 1.45 * below.get_ylim()[1])
    return figure, numbers
