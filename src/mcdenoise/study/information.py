"""Which random parameters and features say anything about radiance? Mutual information beyond chance, by permutation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcdenoise.rpf.dependency import quantise
from mcdenoise.samples import SampleBuffer
from mcdenoise.samples.gate import check_count
from mcdenoise.study.evidence import permutation_p_value

BOX = 7  # pixels, side of a neighbourhood
NEIGHBOURHOODS = 64  # spread over the image
PERMUTATIONS = 199  # at least, and 40 a name: the smallest p-value, corrected for the names, must come below 0.05
SIGNIFICANT = 0.05  # for all names of a buffer together


@dataclass(frozen=True)
class Information:
    """What one random parameter or feature says about radiance.

    Attributes
    ----------
    name, kind : as in the buffer; ``"random_params"`` or ``"features"``
    nats : mutual information with the three channels of radiance, of all its channels, mean over neighbourhoods, less
        what chance gives
    p_value : of the permutation test, corrected for the number of names (Holm)
    """

    name: str
    kind: str
    nats: float
    p_value: float

    @property
    def informative(self) -> bool:
        """Beyond chance."""
        return self.p_value < SIGNIFICANT


def information(
    samples: SampleBuffer,
    *,
    neighbourhoods: int = NEIGHBOURHOODS,
    permutations: int | None = None,
    box: int = BOX,
    seed: int = 0,
) -> list[Information]:
    """Test each random parameter and each feature: does it say more about radiance than chance?

    In neighbourhoods spread over the image, radiance and the other fields become whole numbers (`rpf.dependency.quantise`), and
    their mutual information is added up. Then the samples of a field are shuffled within each neighbourhood, again and
    again: that breaks any dependency and leaves chance. The share of shuffles that say as much is the p-value. A feature
    that follows the place on the screen, as radiance does, is informative in this sense: whether a filter needs it is
    another question, which dropping it answers.

    Parameters
    ----------
    samples : of a scene, at any spp
    neighbourhoods, permutations : how many; more permutations reach smaller p-values, 1 / (permutations + 1) at least; None: as
        many as the number of names needs
    box : side of a neighbourhood, pixels; the image's, if that is smaller
    seed : of the shuffles

    Returns
    -------
    One `Information` a name, random parameters first.

    Raises
    ------
    ValueError
        If a number is no whole number above 0.

    References
    ----------
    Holm 1979, "A simple sequentially rejective multiple test procedure" (the correction).

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(16), np.arange(16)), axis=-1)[:, :, np.newaxis]
    >>> lens, time = rng.random((2, 16, 16, 8))
    >>> radiance = np.repeat(lens[..., np.newaxis], 3, axis=-1)
    >>> samples = SampleBuffer.from_arrays(radiance, corner + rng.random((16, 16, 8, 2)), {"lens_u": lens, "time": time})
    >>> [(one.name, one.informative) for one in information(samples, neighbourhoods=4)]
    [('lens_u', True), ('time', False)]
    """
    fields = [(field.name, kind) for kind in ("random_params", "features") for field in getattr(samples.layout, kind)]
    permutations = max(PERMUTATIONS, 40 * len(fields)) if permutations is None else permutations
    counts = {"neighbourhoods": neighbourhoods, "permutations": permutations, "box": box}
    neighbourhoods, permutations, box = (check_count(value, name) for name, value in counts.items())
    rng = np.random.default_rng(check_count(seed, "seed", least=0))
    found = np.zeros((permutations + 1, len(fields)))  # the first row is as it is, the others are shuffled
    corners = spread_corners(samples.height, samples.width, neighbourhoods, box)
    for y, x in corners:
        crop = samples.crop(y, x, min(box, samples.height), min(box, samples.width))
        found += _of_neighbourhood(crop, [name for name, _ in fields], permutations, rng)
    found /= len(corners)
    p_values = holm([permutation_p_value(column[0], column[1:]) for column in found.T])
    beyond = found[0] - found[1:].mean(axis=0)
    return [Information(*field, float(nats), p) for field, nats, p in zip(fields, beyond, p_values, strict=True)]


def _of_neighbourhood(
    crop: SampleBuffer, names: Sequence[str], permutations: int, rng: np.random.Generator
) -> np.ndarray:
    """(permutations + 1, names): nats of each name with radiance, first as it is, then shuffled."""
    from mcdenoise.kernels.dependency import information_of_pairs

    count = crop.height * crop.width * crop.spp
    radiance = quantise(crop.radiance.reshape(count, 3))
    columns = [crop[name].reshape(count, -1) for name in names]
    if not columns:
        return np.zeros((permutations + 1, 0))
    first = np.cumsum([0, *(column.shape[1] for column in columns[:-1])])
    others = quantise(np.concatenate(columns, axis=1))
    orders = [slice(None), *(rng.permutation(count) for _ in range(permutations))]
    sums = [information_of_pairs(radiance, others[order]).sum(axis=0) for order in orders]
    return np.add.reduceat(np.array(sums), first, axis=1)


def spread_corners(height: int, width: int, number: int, box: int) -> list[tuple[int, int]]:
    """Upper left corners of about `number` boxes, evenly over the image, no more than lie side by side.

    Examples
    --------
    >>> spread_corners(16, 16, 4, 4)
    [(2, 2), (2, 10), (10, 2), (10, 10)]
    >>> spread_corners(3, 5, 64, 7)
    [(0, 0)]
    """
    rows = max(1, min(round(np.sqrt(number * height / width)), height // box, number))
    columns = max(1, min(number // rows, width // box))
    starts = [
        np.maximum((np.arange(n) + 0.5) * side / n - box / 2, 0).astype(int)
        for n, side in ((rows, height), (columns, width))
    ]
    return [(int(y), int(x)) for y in starts[0] for x in starts[1]]


def holm(p_values: Sequence[float]) -> list[float]:
    """Correct p-values for their number: the smallest counts m times, the next m - 1 times, and none less than one before.

    Examples
    --------
    >>> [round(p, 2) for p in holm([0.01, 0.04, 0.03])]
    [0.03, 0.06, 0.06]
    """
    p = np.asarray(p_values, np.float64)
    order = np.argsort(p)
    scaled = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1)) if len(p) else p
    corrected = np.empty(len(p))
    corrected[order] = np.minimum(scaled, 1.0)
    return corrected.tolist()
