"""How good are our filters beside those of others? relMSE on the toy scenes, all tuned with the reference alike.

Tuned with the reference: a choice that nobody has in earnest, but the same for all. It measures what a filter can do,
not what it does; `study.tune` shows what halves of the samples choose.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from tqdm import tqdm

from mcdenoise.metrics import relmse
from mcdenoise.render import capture, render_reference
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.study.bench_filters import find_peers
from mcdenoise.study.bench_measure import reached
from mcdenoise.study.bench_peers import NLM_CONSTANT, constant_nlm, peer_methods
from mcdenoise.study.methods import METHODS, Method
from mcdenoise.study.tune import tune

SCENES = ("dof", "pinhole", "soft_shadow", "glossy", "motion")
UNFILTERED = "unfiltered"


@dataclass
class Row:
    """One method on all scenes.

    Attributes
    ----------
    label : what the table calls it
    method : None for the unfiltered image, and for a peer that is not installed
    errors : scene -> relMSE
    """

    label: str
    method: Method | None
    errors: dict[str, float] = field(default_factory=dict)


def accuracy_lines(scenes: Sequence[str], size: int, spp: int, reference_spp: int) -> list[str]:
    """Measure everybody on every scene; return the table and the verdicts on NL-means."""
    rows = all_rows()
    fill(rows, scenes, size, spp, reference_spp)
    title = (
        f"relMSE x 1000, {size}x{size}, {spp} spp, reference {reference_spp} spp; "
        f"all parameters tuned with the reference, ours and theirs alike"
    )
    return [title, *error_table(rows, scenes), *nlm_verdicts(rows, scenes)]


def all_rows() -> list[Row]:
    """Return unfiltered, all our methods, NL-means with one constant variance, and the peers.

    Examples
    --------
    >>> [row.label for row in all_rows()][:2]
    ['unfiltered', 'Gaussian']
    """
    ours = [*METHODS.values(), constant_nlm()]
    peers = [Row(label, method) for label, method in peer_methods(find_peers())]
    return [Row(UNFILTERED, None), *(Row(method.label, method) for method in ours), *peers]


def fill(rows: Sequence[Row], scenes: Sequence[str], size: int, spp: int, reference_spp: int) -> None:
    """Put the errors of all scenes into the rows."""
    todo = [(scene, row) for scene in scenes for row in rows]
    samples: SampleBuffer | None = None
    bar = tqdm(todo, desc="accuracy", unit="method", disable=None, leave=False)
    for scene, row in bar:
        bar.set_postfix_str(f"{scene}, {row.label}")
        if row is rows[0]:
            samples = capture(scene, size, size, spp, seed=0)
            reference = render_reference(scene, size, size, spp=reference_spp, seed=0)
            row.errors[scene] = relmse(pixel_mean(samples.radiance), reference)
        elif row.method:
            row.errors[scene] = tune(row.method, samples, reference).error


def error_table(rows: Sequence[Row], scenes: Sequence[str]) -> list[str]:
    """Return a line a method, a column a scene.

    Examples
    --------
    >>> print(*error_table([Row("unfiltered", None, {"dof": 0.07}), Row("peer", None)], ["dof"]), sep="\\n")
                                                    dof
      unfiltered                                  70.00
      peer                                 not installed
    """
    lines = ["  " + " " * 36 + "".join(f"{scene:>13s}" for scene in scenes)]
    for row in rows:
        numbers = "".join(f"{1e3 * row.errors[scene]:13.2f}" for scene in scenes) if row.errors else " not installed"
        lines.append(f"  {row.label:36s}{numbers}")
    return lines


def nlm_verdicts(rows: Sequence[Row], scenes: Sequence[str]) -> list[str]:
    """Return whether NL-means beats the best Gaussian everywhere: with variances (a target), and with one constant."""
    errors = {row.label: row.errors for row in rows}
    gaussian, noisy = errors[METHODS["gaussian"].label], errors[METHODS["nlm"].label]
    ratios = {
        label: {scene: other[scene] / gaussian[scene] for scene in scenes}
        for label, other in (("per-pixel variances", noisy), ("one best constant variance", errors[NLM_CONSTANT]))
    }
    lines = [
        f"target: NL-means with per-pixel variances beats the best Gaussian on every scene: "
        f"{reached(max(ratios['per-pixel variances'].values()) < 1)}"
    ]
    return [*lines, *(f"  {label}: {_of_gaussian(ratio)}" for label, ratio in ratios.items())]


def _of_gaussian(ratios: Mapping[str, float]) -> str:
    """Ratios to the Gaussian's relMSE in words."""
    beaten = int(np.sum([ratio < 1 for ratio in ratios.values()]))
    parts = ", ".join(f"{scene} {ratio:.2f}" for scene, ratio in ratios.items())
    return f"{beaten} of {len(ratios)} scenes; relMSE over that of the best Gaussian: {parts}"
