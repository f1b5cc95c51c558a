"""Chapter 06: random parameter filtering. Samples in, image out, over several passes with smaller and smaller boxes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from tqdm import tqdm

from mcdenoise.filters import noise_variance
from mcdenoise.rpf.blend import blend_sums, pair_weights, remove_spikes
from mcdenoise.rpf.config import SPIKES, RPFConfig
from mcdenoise.rpf.dependency import Dependency, information_of_pairs, quantise
from mcdenoise.rpf.draws import first_entries, offset_table
from mcdenoise.rpf.neighbourhood import TOLERANCE, choose_samples, feature_limits, is_like, standardise
from mcdenoise.rpf.weights import Weights, scales_of, weights_of
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.samples.gate import ENGINES, check_choice, check_count


def rpf(
    samples: SampleBuffer,
    config: RPFConfig | None = None,
    *,
    engine: str = "numba",
    seed: int = 0,
    progress: bool | None = None,
) -> np.ndarray:
    """Random parameter filtering: blend each sample with samples like it, judged by what is not the fault of chance.

    For every pixel the samples of a box around it are drawn, and those of another kind left out. Mutual information among
    them says how much of radiance and features the random parameters explain (lens, time, light), and how much the screen
    position. What the random parameters explain is noise, and loses its say in the weights.

    Parameters
    ----------
    samples : SampleBuffer. Where it has no random parameter, all of radiance and features is trusted.
    config : every constant; default `RPFConfig.adaptive()`.
    engine : ``"numba"``, or ``"numpy"``, pixel by pixel and as the formulas read: for tiny images.
    seed : of the draws; the same seed gives the same image, at any number of threads.
    progress : show a bar; None: if it takes long and somebody is looking.

    Returns
    -------
    (h, w, 3) float32, scene-linear radiance

    Raises
    ------
    ValueError
        For samples that are no SampleBuffer, a configuration that is no RPFConfig or names random parameters or features
        that the samples lack, an engine that there is not, or a seed that is no whole number >= 0.

    Notes
    -----
    With 1 spp a pixel has no statistics of its own: every feature counts as constant in it, and only the tolerance of
    the clustering lets others in; noise within pixels is taken from neighbouring pixels.

    Each blended sample lies between the least and the greatest of its neighbourhood. Energy is not kept exactly: with the
    default the mean of the image stays within 3 % of that of the samples on the toy scenes; see `RPFConfig.spikes` for
    what else changes it.

    References
    ----------
    Sen and Darabi, "On filtering the noise from the random parameters in Monte Carlo rendering", TOG 31(3), 2012,
    https://doi.org/10.1145/2167076.2167083, and technical report EECE-TR-11-0004.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(6), np.arange(6)), axis=-1)[:, :, np.newaxis]
    >>> lens = rng.random((6, 6, 8))
    >>> radiance = np.repeat(1 + (lens > 0.5)[..., np.newaxis], 3, axis=-1).astype(np.float32)
    >>> samples = SampleBuffer.from_arrays(radiance, corner + rng.random((6, 6, 8, 2)), {"lens_u": lens})
    >>> image = rpf(samples)
    >>> noisy = pixel_mean(samples.radiance)
    >>> bool(image.std() < 0.5 * noisy.std())
    True
    """
    job = prepare(samples, config, seed)
    passes = _numba_pass if check_choice(engine, ENGINES, "engine") == "numba" else _numpy_pass
    radiance = job.radiance
    rows = len(job.config.turns) * samples.height
    with tqdm(total=rows, desc="RPF", unit="row", disable=quiet(progress), delay=2, leave=False) as bar:
        for turn in job.config.turns:
            bar.set_postfix_str(f"pass {turn + 1}, box {job.config.boxes[turn]}")
            radiance = passes(job, turn, radiance, bar.update)
    return pixel_mean(radiance)


@dataclass(frozen=True, eq=False)
class Job:
    """What all passes share.

    Attributes
    ----------
    samples : with the random parameters that are asked
    config, seed : as for `rpf`
    radiance : (h, w, spp, 3), capped
    noise : (h, w, n_f + 3), variance within pixels of features and channels
    limits : (n_f,), of the clustering. gains : (n_f,), factors of beta.
    """

    samples: SampleBuffer
    config: RPFConfig
    seed: int
    radiance: np.ndarray
    noise: np.ndarray
    limits: np.ndarray
    gains: np.ndarray

    @cached_property
    def records(self) -> np.ndarray:
        """All numbers of a sample side by side, as the kernel wants them: features, radiance, position, random parameters."""
        blocks = (self.samples.features, self.radiance, self.samples.screen_position, self.samples.random_params)
        return np.concatenate(blocks, axis=-1).reshape(-1)


def prepare(samples: SampleBuffer, config: RPFConfig | None, seed: int) -> Job:
    """Check what came, and compute what all passes share."""
    if not isinstance(samples, SampleBuffer):
        raise ValueError(
            f"samples must be a SampleBuffer, got {type(samples).__name__}. Use mcd.capture, mcd.load_samples, or "
            f"mcd.SampleBuffer.from_arrays."
        )
    config = RPFConfig.adaptive() if config is None else config
    if not isinstance(config, RPFConfig):
        raise ValueError(f"config must be an RPFConfig, such as RPFConfig.lecture(), got {type(config).__name__}.")
    seed = check_count(seed, "seed", least=0)
    if config.random_params is not None:
        samples = samples.select(random_params=config.random_params)
    gains = np.ones(samples.features.shape[-1])
    for name, gain in config.feature_gains:
        for field in samples.layout.features:
            if field.name == name:
                gains[field.columns] = gain
    radiance = np.minimum(samples.radiance, np.float32(config.radiance_cap))
    if config.noise_gain:
        noise = noise_variance(np.concatenate([samples.features, radiance], axis=-1)) * samples.spp
    else:
        noise = np.zeros((*samples.radiance.shape[:2], len(gains) + 3), np.float32)
    return Job(samples, config, seed, radiance, noise, feature_limits(samples), gains)


@dataclass(frozen=True, eq=False)
class Pixel:
    """What RPF finds at one pixel in one pass: the neighbourhood, and what follows from it.

    Attributes
    ----------
    chosen : (n, 3), y, x and number in its pixel of each sample. accepted : (n,) bool, of the kind of the pixel.
    found : Dependency. weights : Weights. factors : (n_f + 3,), of squared differences.
    standardised : (accepted, n_f + 3). space : (spp, accepted), or None.
    """

    chosen: np.ndarray
    accepted: np.ndarray
    found: Dependency
    weights: Weights
    factors: np.ndarray
    standardised: np.ndarray
    space: np.ndarray | None

    @property
    def places(self) -> tuple[np.ndarray, ...]:
        """Index of the accepted samples into arrays (h, w, spp, ...)."""
        return tuple(self.chosen[self.accepted].T)

    def pair_weights(self, spp: int) -> np.ndarray:
        """w_ij of each of the pixel's samples with each accepted sample, (spp, accepted)."""
        return pair_weights(self.standardised, self.factors, spp, self.space)


def look(job: Job, pixel: tuple[int, int], turn: int) -> Pixel:
    """Choose the neighbourhood of a pixel, measure what depends on what in it, and set the weights: as the formulas read."""
    samples, config = job.samples, job.config
    size, box = samples.radiance.shape[:3], config.boxes[turn]
    draws = None if config.deterministic else config.draws(turn, samples.spp)
    chosen = choose_samples(size, pixel, box, draws, job.seed, turn)
    features = samples.features[tuple(chosen.T)].astype(np.float64)
    accepted = np.ones(len(chosen), bool)
    if config.clustering:
        accepted[samples.spp :] = is_like(features[samples.spp :], features[: samples.spp], job.limits, TOLERANCE)
    places = tuple(chosen[accepted].T)
    blocks = (job.samples.screen_position, samples.random_params, features[accepted], job.radiance[places])
    p, r = (block[places].astype(np.float64) for block in blocks[:2])
    f, c = blocks[2], blocks[3].astype(np.float64)
    found = measure(p, r, f, c, config)
    weights = weights_of(found, config, turn, job.gains)
    standardised, scale = standardise(np.concatenate([f, c], axis=-1))
    factors = scales_of(weights, job.noise[pixel] * scale**2, config, turn, samples.spp)
    space = _space(p, samples.spp, box / 4) if config.deterministic else None
    return Pixel(chosen, accepted, found, weights, factors, standardised, space)


def measure(p: np.ndarray, r: np.ndarray, f: np.ndarray, c: np.ndarray, config: RPFConfig) -> Dependency:
    """Dependency of the accepted samples, less what chance alone gives: (bins_x - 1) (bins_y - 1) / (2 n) nats, a pair."""
    p, r, f, c = (quantise(block, config.levels) for block in (p, r, f, c))

    def pairs(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        bins_x, bins_y = (np.array([len(np.unique(column)) - 1 for column in one.T]) for one in (x, y))
        chance = config.chance * np.outer(bins_x, bins_y) / (2 * len(x))
        return np.maximum(information_of_pairs(x, y) - chance.reshape(x.shape[1], y.shape[1]), 0)

    return Dependency(c_r=pairs(c, r), c_p=pairs(c, p), c_f=pairs(c, f), f_r=pairs(f, r), f_p=pairs(f, p))


def _space(p: np.ndarray, spp: int, sigma: float) -> np.ndarray:
    """Gaussian of the screen distance of the pixel's samples from all samples."""
    square = ((p[:spp, np.newaxis] - p[np.newaxis]) ** 2).sum(axis=-1)
    return np.exp(-square / (2 * sigma**2))


def _numpy_pass(job: Job, turn: int, radiance: np.ndarray, done: Callable[[int], object]) -> np.ndarray:
    """One pass, pixel by pixel: `radiance` (h, w, spp, 3) in, blended out."""
    blended, spp = np.empty_like(radiance), job.samples.spp
    for y in range(job.samples.height):
        for x in range(job.samples.width):
            pixel = look(job, (y, x), turn)
            total, norm = blend_sums(pixel.pair_weights(spp), radiance[pixel.places])
            blended[y, x] = remove_spikes(total / norm[:, np.newaxis], job.config.spikes, job.config.spike_limit)
        done(1)
    return blended


def _numba_pass(job: Job, turn: int, radiance: np.ndarray, done: Callable[[int], object]) -> np.ndarray:
    """One pass by the kernel."""
    return run_kernel(job, turn, radiance, done)[0]


def run_kernel(
    job: Job, turn: int, radiance: np.ndarray, done: Callable[[int], object] = id, maps: bool = False
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Let the kernel do one pass: blended radiance (h, w, spp, 3), and on request the maps of `kernels.rpf.map_columns`."""
    from mcdenoise.kernels.rpf import Dials, Sizes, filter_image

    config, samples, box = job.config, job.samples, job.config.boxes[turn]
    height, width, spp = samples.radiance.shape[:3]
    sizes = Sizes(
        height=height,
        width=width,
        spp=spp,
        n_f=samples.features.shape[-1],
        n_r=samples.random_params.shape[-1],
        draws=-1 if config.deterministic else config.draws(turn, spp) * (height * width > 1),
        half=box // 2,
        levels=config.levels,
        spikes=SPIKES.index(config.spikes),
        seed=job.seed,
        turn=turn,
    )
    dials = Dials(
        sigma_space=box / 4,
        precision=config.precision(turn, spp),
        alpha_gain=config.alpha_start + config.alpha_step * turn,
        beta_gain=config.beta_start + config.beta_step * turn,
        alpha=-1.0 if config.alpha is None else config.alpha,
        beta=-1.0 if config.beta is None else config.beta,
        one_share=config.one_share,
        ratio_of_sums=config.ratio_of_sums,
        by_feature_share=config.by_feature_share,
        spike_limit=config.spike_limit,
        noise_gain=config.noise_gain,
        chance=config.chance,
        tolerance=TOLERANCE if config.clustering else np.inf,
    )
    table = offset_table(box, box / 4)
    arrays = job.records, radiance, job.noise, job.limits, job.gains, table, first_entries(table, box)
    return filter_image(*arrays, sizes, dials, done, maps)


def quiet(progress: bool | None) -> bool | None:
    """What tqdm calls `disable`: None is a terminal's choice."""
    return None if progress is None else not progress
