"""Chapter 06: what RPF finds, to be looked at: maps over the image, and the samples of one neighbourhood."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from mcdenoise.rpf.config import RPFConfig
from mcdenoise.rpf.dependency import Dependency
from mcdenoise.rpf.passes import Job, look, prepare, quiet, run_kernel
from mcdenoise.samples import SampleBuffer
from mcdenoise.samples.gate import check_count
from mcdenoise.samples.layout import Field, Layout


@dataclass(frozen=True, eq=False)
class RPFAnalysis:
    """Maps of what depends on what, and of the weights that follow, in one pass of RPF: float32 arrays.

    Attributes
    ----------
    share_c_r_each : (h, w, 3, n_r), W_{c,k}^{r,l}: random parameter l and channel k
    share_c_r : (h, w, 3), W_{c,k}^r. share_c_r_all : (h, w), W_c^r, as the configuration has it.
    share_f_r : (h, w, n_f), W_{f,k}^r. share_c_f : (h, w, n_f), W_c^{f,k}.
    alpha : (h, w, 3). beta : (h, w, n_f).
    accepted : (h, w), how many samples of the neighbourhood were used
    layout : which name stands in which columns

    Examples
    --------
    ``analysis["lens_u"]`` is W_{c,k}^{r,l} of one random parameter, (h, w, 3); ``analysis["albedo"]`` is W_{f,k}^r of one
    feature, (h, w, channels).

    >>> one = np.ones((1, 1, 3), np.float32)
    >>> maps = dict(share_c_r=one, share_f_r=one, share_c_f=one, alpha=one, beta=one, share_c_r_all=one[..., 0])
    >>> layout = Layout.of({"lens_u": 1}, {"albedo": 3})
    >>> RPFAnalysis(share_c_r_each=one[..., np.newaxis], accepted=one[..., 0], layout=layout, **maps)["lens_u"].shape
    (1, 1, 3)
    """

    share_c_r_each: np.ndarray
    share_c_r: np.ndarray
    share_c_r_all: np.ndarray
    share_f_r: np.ndarray
    share_c_f: np.ndarray
    alpha: np.ndarray
    beta: np.ndarray
    accepted: np.ndarray
    layout: Layout

    def __getitem__(self, name: str) -> np.ndarray:
        """W_{c,k}^{r,l} of a random parameter, W_{f,k}^r of a feature."""
        kind, field = _find(self.layout, name)
        if kind == "random_params":
            return self.share_c_r_each[..., field.columns].sum(axis=-1)
        return self.share_f_r[..., field.columns]


def rpf_analysis(
    samples: SampleBuffer,
    config: RPFConfig | None = None,
    pass_: int = 0,
    *,
    seed: int = 0,
    progress: bool | None = None,
) -> RPFAnalysis:
    """Measure what `mcd.rpf` measures in one pass, for every pixel.

    Parameters
    ----------
    samples, config, seed, progress : as for `mcd.rpf`.
    pass_ : which pass, from 0 on: another box, other draws.

    Returns
    -------
    RPFAnalysis

    Raises
    ------
    ValueError
        As `mcd.rpf`, or for a pass that the configuration lacks.

    Examples
    --------
    The radiance is the place on the lens, the albedo the place on the screen:

    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(8), np.arange(8)), axis=-1)[:, :, np.newaxis]
    >>> position, lens = corner + rng.random((8, 8, 8, 2)), rng.random((8, 8, 8))
    >>> lit = np.repeat(lens[..., np.newaxis], 3, axis=-1)
    >>> samples = SampleBuffer.from_arrays(lit, position, {"lens_u": lens}, {"albedo": position[..., [0, 0, 0]]})
    >>> found = rpf_analysis(samples)
    >>> bool(found["lens_u"].mean() > 0.9), bool(found["albedo"].mean() < 0.1), bool(found.alpha.mean() < 0.1)
    (True, True, True)
    """
    job = prepare(samples, config, seed)
    turn = _check_pass(pass_, job)
    with tqdm(
        total=samples.height, desc="RPF analysis", unit="row", disable=quiet(progress), delay=2, leave=False
    ) as bar:
        _, maps = run_kernel(job, turn, job.radiance, bar.update, maps=True)
    each = maps.pop("share_c_r_each")
    single = {name: maps.pop(name)[..., 0] for name in ("share_c_r_all", "accepted")}
    return RPFAnalysis(
        share_c_r_each=each.reshape(*each.shape[:2], 3, each.shape[2] // 3), layout=job.samples.layout, **single, **maps
    )


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """The samples of one neighbourhood, those of the pixel first, and what RPF makes of them.

    Attributes
    ----------
    pixel : y, x
    places : (n, 3), y, x and number in its pixel of each sample
    accepted : (n,) bool; False: of another kind, left out by the clustering
    position, random_params, features, radiance : (n, 2), (n, n_r), (n, n_f), (n, 3), as in the buffer
    weights : (spp, n), w_ij of each sample i of the pixel with each sample j, 0 where it was left out
    dependency : Dependency, among the accepted samples
    alpha, beta : (3,), (n_f,). share_c_r, share_f_r : (3,), (n_f,), W_{c,k}^r and W_{f,k}^r
    layout : which name stands in which columns

    ``neighbourhood["albedo"]`` or ``["lens_u"]`` is one field, (n, channels) or (n,).

    Examples
    --------
    >>> corner = np.stack(np.meshgrid(np.arange(3), np.arange(3)), axis=-1)[:, :, np.newaxis]
    >>> samples = SampleBuffer.from_arrays(np.ones((3, 3, 2, 3)), np.repeat(corner + 0.5, 2, axis=2))
    >>> found = rpf_neighbourhood(samples, (1, 1), RPFConfig.lecture(boxes=(3,), deterministic=True))
    >>> len(found.places), bool(found.accepted.all()), found.weights.shape
    (18, True, (2, 18))
    """

    pixel: tuple[int, int]
    places: np.ndarray
    accepted: np.ndarray
    position: np.ndarray
    random_params: np.ndarray
    features: np.ndarray
    radiance: np.ndarray
    weights: np.ndarray
    dependency: Dependency
    alpha: np.ndarray
    beta: np.ndarray
    share_c_r: np.ndarray
    share_f_r: np.ndarray
    layout: Layout

    def __getitem__(self, name: str) -> np.ndarray:
        """One field by its name."""
        kind, field = _find(self.layout, name)
        return getattr(self, kind)[:, field.start if field.channels == 1 else field.columns]


def rpf_neighbourhood(
    samples: SampleBuffer, pixel: Sequence[int], config: RPFConfig | None = None, pass_: int = 0, *, seed: int = 0
) -> Neighbourhood:
    """Return the samples that `mcd.rpf` looks at for one pixel in one pass, with their weights.

    Parameters
    ----------
    samples, config, seed : as for `mcd.rpf`.
    pixel : y, x.
    pass_ : which pass, from 0 on.

    Returns
    -------
    Neighbourhood

    Raises
    ------
    ValueError
        As `mcd.rpf`, or for a pixel outside the image, or a pass that the configuration lacks.

    Examples
    --------
    >>> corner = np.stack(np.meshgrid(np.arange(9), np.arange(9)), axis=-1)[:, :, np.newaxis]
    >>> samples = SampleBuffer.from_arrays(np.ones((9, 9, 2, 3)), np.repeat(corner + 0.5, 2, axis=2))
    >>> found = rpf_neighbourhood(samples, (4, 4), RPFConfig.lecture(boxes=(3,), sample_fraction=0.5))
    >>> found.position.shape, found.places[:2].tolist()
    ((9, 2), [[4, 4, 0], [4, 4, 1]])
    """
    job = prepare(samples, config, seed)
    turn, pixel = _check_pass(pass_, job), _check_pixel(pixel, samples)
    seen = look(job, pixel, turn)
    everywhere = tuple(seen.chosen.T)
    weights = np.zeros((samples.spp, len(seen.chosen)))
    weights[:, seen.accepted] = seen.pair_weights(samples.spp)
    blocks = (job.samples.screen_position, job.samples.random_params, job.samples.features, job.radiance)
    position, random_params, features, radiance = (block[everywhere] for block in blocks)
    return Neighbourhood(
        pixel=pixel,
        places=seen.chosen,
        accepted=seen.accepted,
        position=position,
        random_params=random_params,
        features=features,
        radiance=radiance,
        weights=weights,
        dependency=seen.found,
        alpha=seen.weights.alpha,
        beta=seen.weights.beta,
        share_c_r=seen.weights.share_c_r,
        share_f_r=seen.weights.share_f_r,
        layout=job.samples.layout,
    )


def _find(layout: Layout, name: str) -> tuple[str, Field]:
    """Return the kind and the field of a name, or say which there are."""
    if found := layout.find(name):
        return found
    known = [field.name for field in (*layout.random_params, *layout.features)]
    raise KeyError(f"There is no {name!r} here; there is: {', '.join(known) or 'nothing'}.")


def _check_pass(pass_: object, job: Job) -> int:
    """Return a pass that there is."""
    turn = check_count(pass_, "pass_", least=0)
    if turn >= len(job.config.boxes):
        raise ValueError(f"pass_ must be below {len(job.config.boxes)}, the number of boxes, got {turn}.")
    return turn


def _check_pixel(pixel: object, samples: SampleBuffer) -> tuple[int, int]:
    """Return a place in the image."""
    if isinstance(pixel, (str, bytes)) or not isinstance(pixel, Sequence) or len(pixel) != 2:
        raise ValueError(f"pixel must be two whole numbers, row and column, got {pixel!r}.")
    y, x = (check_count(one, "each of pixel", least=0) for one in pixel)
    if y >= samples.height or x >= samples.width:
        raise ValueError(
            f"pixel must lie in the image of {samples.height} rows and {samples.width} columns, got row {y}, column {x}."
        )
    return y, x
