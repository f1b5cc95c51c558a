"""No more model than needed: which is the smallest network that is as good as the best, as far as one can tell?

    python -m mcdenoise.study.capacity two_moons [--points 300] [--folds 5] [--out chart.png]
    python -m mcdenoise.study.capacity denoise
    python -m mcdenoise.study.lbf_capacity --json capacity.json    the same rule for the network of chapter 09

Each architecture is trained on all parts of the data but one and judged on that one, in turns (k-fold validation). The
spread between the folds says how well its error is known. The smallest model whose mean error is within one standard
error of the best one is chosen: what larger models gain cannot be told from chance.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter
from tqdm import tqdm

from mcdenoise.samples.gate import check_count, check_float_array, check_nonfinite

LOOKS = (
    (0, "#228833", "D", "linear"),
    (1, "#4477AA", "o", "one hidden layer"),
    (2, "#EE6677", "s", "two hidden layers"),
)  # depth, colour, marker, words
Model = TypeVar("Model")
Hidden = tuple[int, ...]  # widths of the hidden layers; () is a linear model


@dataclass(frozen=True, eq=False)
class Candidate:
    """One architecture and how it did.

    Attributes
    ----------
    hidden : widths of its hidden layers
    parameters : how many weights and biases
    errors : (folds,), validation error of each fold
    fitted : (folds,), error on the rows that each was trained on
    seconds : CPU time of training, median over the folds

    Examples
    --------
    >>> one = Candidate((8,), 33, errors=np.array([0.1, 0.2, 0.3]), fitted=np.zeros(3), seconds=0.5)
    >>> one.label, round(one.mean, 3), round(one.standard_error, 3)
    ('8', 0.2, 0.058)
    """

    hidden: Hidden
    parameters: int
    errors: np.ndarray
    fitted: np.ndarray
    seconds: float

    @property
    def label(self) -> str:
        """Widths in words: ``8``, ``8-8``, or ``linear``."""
        return "-".join(map(str, self.hidden)) or "linear"

    @property
    def mean(self) -> float:
        """Mean validation error."""
        return float(self.errors.mean())

    @property
    def standard_error(self) -> float:
        """Standard error of that mean, from the spread of the folds."""
        return float(self.errors.std(ddof=1) / np.sqrt(len(self.errors)))


@dataclass(frozen=True, eq=False)
class Capacity:
    """A sweep over architectures.

    Attributes
    ----------
    title, unit : what was learnt, and of the error
    candidates : in the order given
    best, chosen : indices of the one with the smallest mean error, and of the smallest that is as good
    """

    title: str
    unit: str
    candidates: tuple[Candidate, ...]

    @property
    def best(self) -> int:
        """Index of the candidate with the smallest mean error."""
        return int(np.argmin([one.mean for one in self.candidates]))

    @property
    def chosen(self) -> int:
        """Index of the smallest candidate within one standard error of the best."""
        return smallest_model(
            [one.parameters for one in self.candidates], np.array([one.errors for one in self.candidates])
        )


def smallest_model(parameters: Sequence[int], errors: np.ndarray) -> int:
    """Index of the model with the fewest parameters among those within one standard error of the best.

    Parameters
    ----------
    parameters : (m,), of each model
    errors : (m, folds), validation errors, two folds or more

    Returns
    -------
    The index; of models with equally many parameters, that with the smaller mean error.

    Raises
    ------
    ValueError
        If the shapes do not fit or an error is not finite.

    References
    ----------
    The rule of one standard error: Breiman, Friedman, Olshen and Stone, "Classification and Regression Trees", 1984.

    Examples
    --------
    >>> errors = np.array([[0.5, 0.4], [0.21, 0.19], [0.16, 0.22], [0.18, 0.22]])
    >>> smallest_model([3, 9, 17, 33], errors)
    1
    """
    errors = check_nonfinite(check_float_array(errors, "errors"), "errors")
    if errors.ndim != 2 or errors.shape[1] < 2 or errors.shape[0] != len(parameters):
        raise ValueError(
            f"errors must be (m, folds) with two folds or more, for the {len(parameters)} models, got {errors.shape}."
        )
    means = errors.mean(axis=1)
    best = int(np.argmin(means))
    limit = means[best] + errors[best].std(ddof=1) / np.sqrt(errors.shape[1])
    return min(np.flatnonzero(means <= limit).tolist(), key=lambda k: (parameters[k], means[k]))


def k_folds(groups: Sequence[int], folds: int, rng: np.random.Generator) -> list[tuple[np.ndarray, np.ndarray]]:
    """Cut rows into folds; rows of one group stay together.

    Parameters
    ----------
    groups : (n,), a number a row; ``range(n)`` if every row is by itself. Neighbouring pixels look alike: put tiles in.
    folds : at least 2, at most as many as there are groups

    Returns
    -------
    For each fold the rows to train on, and those to judge by.

    Examples
    --------
    >>> parts = k_folds([0, 0, 1, 1, 2, 2], folds=3, rng=np.random.default_rng(0))
    >>> [judged.tolist() for _, judged in parts]
    [[4, 5], [0, 1], [2, 3]]
    """
    groups = np.asarray(groups)
    names = rng.permutation(np.unique(groups))
    if not 2 <= check_count(folds, "folds") <= len(names):
        raise ValueError(f"folds must be from 2 to {len(names)}, the number of groups, got {folds}.")
    cut = np.zeros(len(groups), int)
    for fold, part in enumerate(np.array_split(names, folds)):
        cut[np.isin(groups, part)] = fold
    return [(np.flatnonzero(cut != fold), np.flatnonzero(cut == fold)) for fold in range(folds)]


def sweep(
    title: str,
    unit: str,
    architectures: Sequence[Hidden],
    folds: Sequence[tuple[np.ndarray, np.ndarray]],
    fit: Callable[[Hidden, np.ndarray], tuple[Model, int]],
    error: Callable[[Model, np.ndarray], float],
) -> Capacity:
    """Train every architecture once a fold.

    Parameters
    ----------
    title, unit : for the chart
    architectures : widths of hidden layers
    folds : from `k_folds`
    fit : (hidden, rows) -> a model trained on these rows, and how many parameters it has
    error : (model, rows) -> its error on these rows

    Examples
    --------
    A mean instead of a network:

    >>> y = np.array([1.0, 2.0, 3.0, 4.0])
    >>> folds = k_folds(range(4), 2, np.random.default_rng(0))
    >>> found = sweep("a mean", "1", [()], folds, lambda _, rows: (y[rows].mean(), 1), lambda m, rows: np.ptp(y[rows] - m))
    >>> found.candidates[0].parameters, len(found.candidates[0].errors)
    (1, 2)
    """
    if not architectures or len(folds) < 2:
        raise ValueError(
            f"At least one architecture and two folds are needed, got {len(architectures)} and {len(folds)}."
        )
    candidates = []
    for hidden in tqdm(architectures, desc=title, unit="model", delay=2, leave=False, disable=None):
        errors, fitted, seconds = [], [], []
        for train_rows, judged_rows in folds:
            start = time.process_time()
            model, parameters = fit(tuple(hidden), train_rows)
            seconds.append(time.process_time() - start)
            errors.append(error(model, judged_rows))
            fitted.append(error(model, train_rows))
        measured = np.array(errors), np.array(fitted), float(np.median(seconds))
        candidates.append(Candidate(tuple(hidden), parameters, *measured))
    return Capacity(title, unit, tuple(candidates))


def lines(capacity: Capacity) -> list[str]:
    """A table of the sweep, with the best and the chosen marked.

    Examples
    --------
    >>> one = Candidate((8,), 33, np.array([0.1, 0.3]), np.array([0.1, 0.1]), 0.5)
    >>> print(*lines(Capacity("two moons", "1", (one,))), sep="\\n")
    two moons; error on held-out folds (1), mean and standard error
      hidden        parameters       error              fitted    CPU s
      8                     33      0.2000 +- 0.1000    0.1000     0.50  best, chosen
    """
    found = [
        f"{capacity.title}; error on held-out folds ({capacity.unit}), mean and standard error",
        f"  {'hidden':12s}  {'parameters':>10s}  {'error':>10s}              {'fitted':>6s}  {'CPU s':>7s}",
    ]
    for index, one in enumerate(capacity.candidates):
        marks = [name for name, place in (("best", capacity.best), ("chosen", capacity.chosen)) if place == index]
        found.append(
            f"  {one.label:12s}  {one.parameters:10d}  {one.mean:10.4f} +- {one.standard_error:.4f}  "
            f"{one.fitted.mean():8.4f}  {one.seconds:7.2f}  {', '.join(marks)}".rstrip()
        )
    return found


def capacity_figure(capacity: Capacity) -> Figure:
    """Chart validation error and training time against the number of parameters, with the choice and its limit."""
    figure = Figure(figsize=(10, 4.2), layout="constrained")
    figure.suptitle(capacity.title)
    left, right = figure.subplots(1, 2, width_ratios=(1.7, 1))
    best, chosen = capacity.candidates[capacity.best], capacity.candidates[capacity.chosen]
    for depth, colour, marker, words in LOOKS:
        some = [one for one in capacity.candidates if len(one.hidden) == depth]
        some.sort(key=lambda one: one.parameters)
        if not some:
            continue
        sizes = [one.parameters for one in some]
        bars = [one.standard_error for one in some]
        left.errorbar(sizes, [one.mean for one in some], bars, fmt=marker, ls="-", color=colour, capsize=3, label=words)
        left.plot(sizes, [one.fitted.mean() for one in some], "_:" if depth == 0 else ":", color=colour)
        right.plot(sizes, [one.seconds for one in some], marker, ls="-", color=colour)
        for one in some if depth else ():
            end, away, side = one.standard_error, 3, "bottom"
            if depth > 1:
                end, away, side = -end, -3, "top"
            at = (one.parameters, one.mean + end)
            left.annotate(one.label, at, (0, away), textcoords="offset points", fontsize=8, ha="center", va=side)
    limit = best.mean + best.standard_error
    left.axhline(limit, color="#777777", ls="--", lw=1, label="best + one standard error")
    left.plot(chosen.parameters, chosen.mean, "*", ms=17, color="#CCBB44", mec="black", label=f"chosen: {chosen.label}")
    left.plot([], [], ":", color="#777777", label="on the rows trained on")
    left.set(xscale="log", xlabel="weights and biases", ylabel=f"validation error ({capacity.unit})", ylim=(0, None))
    left.legend(frameon=False, fontsize=8)
    right.set(xscale="log", xlabel="weights and biases", ylabel="CPU time of training, a fold (s)", ylim=(0, None))
    for axes in (left, right):
        axes.grid(color="#e5e5e5")
        axes.xaxis.set_major_formatter(ScalarFormatter())
    return figure


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code (2, with one line on stderr, for what could not be done)."""
    from mcdenoise.study.capacity_tasks import TASKS, run_task
    from mcdenoise.study.charts import save_figure

    parser = _parser(sorted(TASKS))
    try:
        options = parser.parse_args(arguments)
        if options.out and options.out.suffix != ".png":
            raise ValueError(f"The chart is a PNG: --out needs a name that ends in .png, got {options.out.name!r}.")
        if options.out and not options.out.parent.is_dir():
            raise ValueError(
                f"The folder {options.out.parent} must exist before the chart is written there. Create it first."
            )
        found = run_task(options.task, points=options.points, folds=options.folds, seed=options.seed)
        print("\n".join(lines(found)))
        if options.out:
            save_figure(capacity_figure(found), options.out)
    except SystemExit as leaving:
        return int(leaving.code or 0)
    except (ValueError, OSError) as error:
        print(f"capacity: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    return 0


def _parser(tasks: Sequence[str]) -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    from mcdenoise.study.arguments import OneLineParser

    parser = OneLineParser(prog="python -m mcdenoise.study.capacity", description=__doc__.splitlines()[0])
    parser.add_argument("task", choices=tasks, help="what is learnt")
    parser.add_argument("--points", type=int, help="rows of data (default: 300 in the plane, 4096 pixels)")
    parser.add_argument("--folds", type=int, default=5, help="parts of the data (default 5)")
    parser.add_argument("--seed", type=int, default=0, help="of data, folds and weights (default 0)")
    parser.add_argument("--out", type=Path, help="write the chart to this PNG")
    return parser


if __name__ == "__main__":
    sys.exit(main())
