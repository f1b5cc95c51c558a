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


def look_up(radiance: np.ndarray, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Return the radiance (n, 3) of a light field (VIEWS, PIXELS * FINER, 3) at x (pixels) and u."""
    return radiance[(np.asarray(u) * VIEWS).astype(int), (np.asarray(x) * FINER).astype(int)]


def image_space(
    radiance: np.ndarray, spp: int, rng: np.random.Generator, *, adaptive: bool = True
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
    values = look_up(radiance, pilot_x, pilot_u)
    spread = (values.std(axis=1) / np.sqrt(values.mean(axis=1) ** 2 + EPSILON)).mean(axis=1)
    rest = spp * PIXELS - pilot_x.size
    share = spread / spread.sum() if adaptive else np.full(PIXELS, 1 / PIXELS)
    # whole numbers that add up to the rest
    counts = np.diff(np.rint(np.concatenate([[0], share.cumsum()]) * rest)).astype(int)
    pixel = np.repeat(np.arange(PIXELS), counts)
    x = np.concatenate([pilot_x.ravel(), pixel + rng.random(rest)])
    u = np.concatenate([pilot_u.ravel(), rng.random(rest)])
    total = np.zeros((PIXELS, 3))
    np.add.at(total, x.astype(int), look_up(radiance, x, u))
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

    def add(self, radiance: np.ndarray, rng: np.random.Generator) -> None:
        """Take one sample of a light field, at random inside the cell."""
        place = self.low + rng.random(2) * (self.high - self.low)
        self.places.append(place)
        self.radiance.append(look_up(radiance, *place))

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


def grow_cells(radiance: np.ndarray, spp: int, rng: np.random.Generator) -> list[Cell]:
    """Put each next sample into the cell of (x, u) that errs most, and cut cells that are full; they start as pixels."""
    cells = [Cell(np.array([float(x), 0.0]), np.array([x + 1.0, 1.0])) for x in range(PIXELS)]
    for cell in cells:
        for _ in range(FIRST):
            cell.add(radiance, rng)
    priorities = [cell.priority() for cell in cells]
    for _ in range((spp - FIRST) * PIXELS):
        worst = int(np.argmax(priorities))
        cell = cells[worst]
        cell.add(radiance, rng)
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


def mean_errors(radiance: np.ndarray, spp: int) -> dict[str, tuple[float, float]]:
    """Return the relMSE of the scanline that each way gives, and its standard error, over `SEEDS` runs."""
    truth = pixel_row(radiance)[np.newaxis]
    ways = {
        "uniform": lambda rng: image_space(radiance, spp, rng, adaptive=False)[2],
        "image_space": lambda rng: image_space(radiance, spp, rng)[2],
        "multidimensional": lambda rng: integrate(grow_cells(radiance, spp, rng)),
    }
    found = {}
    for name, way in ways.items():
        errors = [relmse(way(np.random.default_rng([seed, spp]))[np.newaxis], truth) for seed in range(SEEDS)]
        found[name] = float(np.mean(errors)), float(np.std(errors, ddof=1) / np.sqrt(SEEDS))
    return found


def make_adaptive() -> tuple[Figure, dict[str, float]]:
    """Show where the same number of samples goes: by pixel, and by cell of the light field; and what it brings."""
    radiance = scanline().radiance
    numbers: dict[str, float] = {"seeds": SEEDS}
    for spp in BUDGETS:
        for name, (error, standard_error) in mean_errors(radiance, spp).items():
            numbers |= {f"{name}_{spp}": error, f"{name}_{spp}_se": standard_error}
    # one sample of the light in each cell of the field: its noise is left in
    numbers |= {f"{name}_{spp}_noisy": error for name, (error, _) in mean_errors(scanline(spp=1).radiance, spp).items()}
    return _draw(radiance, spp, numbers), numbers


def _draw(radiance: np.ndarray, spp: int, numbers: dict[str, float]) -> Figure:
    """One run of both adaptive ways over the pale light field, and how many samples each pixel got."""
    figure = Figure(figsize=(7.6, 6), layout="constrained")
    above, middle, below = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 1.6))
    x, u, _ = image_space(radiance, spp, np.random.default_rng([0, spp]))
    cells = grow_cells(radiance, spp, np.random.default_rng([0, spp]))
    where = np.concatenate([cell.places for cell in cells])
    boxes = [Rectangle(cell.low, *(cell.high - cell.low)) for cell in cells]
    middle.add_collection(PatchCollection(boxes, facecolor="none", edgecolor=COLOURS[1], linewidth=0.5))
    pale = 0.5 + 0.5 * tone_map(radiance)
    for axes, places, name, title, colour in (
        (above, (x, u), "image_space", "image space: by the spread inside each pixel", COLOURS[0]),
        (middle, where.T, "multidimensional", "multidimensional: by the contrast inside each cell", COLOURS[1]),
    ):
        axes.imshow(pale, aspect="auto", origin="lower", extent=(0, PIXELS, 0, 1), interpolation="nearest")
        axes.plot(*places, ".", color="black", markersize=2.5)
        axes.set(ylabel="lens u", ylim=(0, 1), title=f"{title}; relMSE {numbers[f'{name}_{spp}']:.4f}")
        counts = np.bincount(places[0].astype(int), minlength=PIXELS)
        below.step(np.arange(PIXELS) + 0.5, counts, where="mid", color=colour, label=name.replace("_", " "))
    label = f"uniform: relMSE {numbers[f'uniform_{spp}']:.4f}"
    below.axhline(spp, color="black", linewidth=1, linestyle=":", label=label)
    below.set(xlabel="screen x (pixels)", ylabel="spp", xlim=SHOWN, title="samples in each pixel")
    below.legend(frameon=False, fontsize=9, ncols=3, loc="upper center")
    below.set_ylim(0, 1.45 * below.get_ylim()[1])
    return figure
