"""What `compare` can run: one entry a method, samples in, image out. A later chapter joins by adding its entry here."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from mcdenoise.filters import (
    bilateral,
    cross_bilateral,
    gaussian,
    joint_nlm,
    nlm,
    noise_variance,
    prefilter_features,
)
from mcdenoise.lbf import lbf
from mcdenoise.rpf import RPFConfig, rpf
from mcdenoise.rpf.config import PUBLISHED
from mcdenoise.samples import SampleBuffer, pixel_mean

Parameters = Mapping[str, Any]


@dataclass(frozen=True)
class Variant:
    """One setting of a method that trades time for accuracy: a point of its curve.

    Attributes
    ----------
    name : of its files, after that of the method
    label : beside its point in the chart, after that of the method elsewhere
    parameters : of `filter`
    """

    name: str
    label: str
    parameters: Parameters


@dataclass(frozen=True)
class Method:
    """One way from samples to an image.

    Attributes
    ----------
    name : what the command line calls it
    label : what charts and tables call it
    chapter : where the course explains it
    candidates : samples -> parameters worth trying; the middle one serves where nothing can be tried
    prepare : samples -> whatever does not depend on parameters, a dict of arguments of `filter`
    filter : (**prepared, **parameters) -> (h, w, 3) float32
    variants : settings that `compare` runs one and all, fastest first, and joins to a curve; (): one, chosen by halves
    """

    name: str
    label: str
    chapter: int
    candidates: Callable[[SampleBuffer], Sequence[Parameters]]
    prepare: Callable[[SampleBuffer], dict[str, Any]]
    filter: Callable[..., np.ndarray]
    variants: Sequence[Variant] = ()

    def apply(self, prepared: dict[str, Any], **parameters: Any) -> np.ndarray:
        """Filter what `prepare` made: (h, w, 3) float32. Bandwidths of features that do not vary there are left out."""
        if sigmas := parameters.get("sigma_features"):
            varying = {name: sigma for name, sigma in sigmas.items() if name in prepared["features"]}
            parameters = {**parameters, "sigma_features": varying}
        return self.filter(**prepared, **parameters)

    def run(self, samples: SampleBuffer, **parameters: Any) -> np.ndarray:
        """Samples in, image out: prepare and apply."""
        return self.apply(self.prepare(samples), **parameters)


def feature_spreads(samples: SampleBuffer) -> dict[str, float]:
    """Return how far the pixel means of each feature spread over the image: the scale of its bandwidth.

    The spread is the root mean square distance from the mean, over all channels, in the feature's own unit. Features that
    do not vary over the image are left out.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(8), np.arange(8)), axis=-1)[:, :, np.newaxis]
    >>> noise = rng.random((8, 8, 1, 3))
    >>> samples = SampleBuffer.from_arrays(noise, corner + 0.5, features={"albedo": noise, "depth": 0 * noise})
    >>> {name: round(spread, 1) for name, spread in feature_spreads(samples).items()}
    {'albedo': 0.5}
    """
    spreads = {}
    for name in samples.feature_names:
        mean = pixel_mean(samples[name]).reshape(samples.height * samples.width, -1)
        spreads[name] = float(np.sqrt(mean.var(axis=0, dtype=np.float64).sum()))
    return {name: spread for name, spread in spreads.items() if spread > 0}


def bandwidths(spreads: Mapping[str, float], share: float, second_share: float) -> dict[str, float]:
    """Return sigma_features: a share of each feature's spread, with a share of its own for second hits.

    Examples
    --------
    >>> bandwidths({"albedo": 0.5, "albedo_2": 0.5}, 0.2, np.inf)
    {'albedo': 0.1, 'albedo_2': inf}
    """
    return {name: (second_share if name.endswith("_2") else share) * spread for name, spread in spreads.items()}


def _shares(samples: SampleBuffer, first: Sequence[float], second: Sequence[float]) -> list[dict[str, float]]:
    """Every combination of shares of the first and of the second hit; of the first alone if there is no second."""
    spreads = feature_spreads(samples)
    second = second if any(name.endswith("_2") for name in spreads) else (np.inf,)
    return [bandwidths(spreads, *shares) for shares in product(first, second)]


def _gaussian_candidates(_: SampleBuffer) -> list[Parameters]:
    return [{"sigma_space": sigma} for sigma in (0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8)]


def _bilateral_candidates(_: SampleBuffer) -> list[Parameters]:
    grid = product((0.7, 1.4, 2.8), (0.1, 0.2, 0.4, 0.8, 1.6))
    return [{"sigma_space": space, "sigma_radiance": radiance} for space, radiance in grid]


def _cross_bilateral_candidates(samples: SampleBuffer) -> list[Parameters]:
    shares = _shares(samples, (0.1, 0.3, 1.0, 10.0), (np.inf, 1.0))
    return [
        {"sigma_space": space, "sigma_radiance": radiance, "sigma_features": sigmas}
        for space, radiance, sigmas in product((0.7, 1.4, 2.8), (0.1, 0.4, 1.6), shares)
    ]


def _prefiltered_candidates(samples: SampleBuffer) -> list[Parameters]:
    shares = _shares(samples, (0.1, 0.2, 0.4), (0.2, 0.4, np.inf))
    return [
        {"sigma_space": space, "sigma_radiance": radiance, "sigma_features": sigmas}
        for space, radiance, sigmas in product((0.7, 1.4, 2.8), (0.4, 1.6), shares)
    ]


def _nlm_candidates(_: SampleBuffer) -> list[Parameters]:
    grid = product((3, 7), (1, 3), (0.3, 0.45, 0.6, 0.8))
    return [{"search_radius": search, "patch_radius": patch, "k": k, "weight_radius": 1} for search, patch, k in grid]


def _joint_nlm_candidates(samples: SampleBuffer) -> list[Parameters]:
    shares = _shares(samples, (0.3, 1.0), (0.4, np.inf))
    return [
        {"search_radius": 5, "sigma_space": space, "k": k, "weight_radius": 1, "sigma_features": sigmas}
        for space, k, sigmas in product((2.0, np.inf), (0.6, 0.8, 1.2), shares)
    ]


def report_config(draws: float) -> RPFConfig:
    """Return the technical report's preset of RPF with `draws` times the samples of its default, the published M at most.

    Examples
    --------
    >>> [round(share, 2) for share in report_config(4.0).sample_fraction]
    [0.08, 0.21, 0.5, 0.5]
    """
    quick = RPFConfig.technical_report()
    shares = (min(draws * quick.fraction(turn), PUBLISHED) for turn in range(len(quick.boxes)))
    return RPFConfig.technical_report(sample_fraction=tuple(shares))


def share_of_draws(config: RPFConfig) -> float:
    """Return the samples drawn in all passes of RPF as a share of those with the published M.

    Examples
    --------
    >>> round(share_of_draws(report_config(1.0)), 2)
    0.09
    """
    drawn = sum(config.fraction(turn) * config.boxes[turn] ** 2 for turn in config.turns)
    return drawn / sum(PUBLISHED * config.boxes[turn] ** 2 for turn in config.turns)


def report_multiples(multiples: Sequence[float]) -> dict[float, float]:
    """Return multiples of the default draws of `report_config`, the published M last, each with its share of M.

    Examples
    --------
    >>> [(round(draws, 1), round(share, 2)) for draws, share in report_multiples([1.0]).items()]
    [(1.0, 0.09), (23.6, 1.0)]
    """
    quick = RPFConfig.technical_report()
    whole = PUBLISHED / min(quick.fraction(turn) for turn in quick.turns)
    return {draws: share_of_draws(report_config(draws)) for draws in (*multiples, whole)}


def _report_variants() -> list[Variant]:
    """A quarter of the default draws, the default, four times that, and the published M."""
    shares = {draws: f"{100 * share:.0f}" for draws, share in report_multiples((0.25, 1.0, 4.0)).items()}
    return [Variant(f"{share}_percent", f"{share} % of M", {"draws": draws}) for draws, share in shares.items()]


def _rpf_report(samples: SampleBuffer, draws: float) -> np.ndarray:
    return rpf(samples, report_config(draws), progress=False)


def _rpf_adaptive(samples: SampleBuffer) -> np.ndarray:
    return rpf(samples, progress=False)


def _lbf(samples: SampleBuffer) -> np.ndarray:
    return lbf(samples)


def _lbf_nlm(samples: SampleBuffer) -> np.ndarray:
    return lbf(samples, variant="nlm")


def _nothing_to_choose(_: SampleBuffer) -> list[Parameters]:
    return [{}]


def _default_draws(_: SampleBuffer) -> list[Parameters]:
    return [{"draws": 1.0}]


def _samples(samples: SampleBuffer) -> dict[str, Any]:
    return {"samples": samples}


def _image(samples: SampleBuffer) -> dict[str, Any]:
    return {"image": pixel_mean(samples.radiance)}


def _image_and_features(samples: SampleBuffer) -> dict[str, Any]:
    return {**_image(samples), "features": {name: pixel_mean(samples[name]) for name in feature_spreads(samples)}}


def _image_and_prefiltered(samples: SampleBuffer) -> dict[str, Any]:
    features, variances = prefilter_features(samples, list(feature_spreads(samples)))
    return {**_image(samples), "features": features, "variances": variances}


def _image_and_variance(samples: SampleBuffer) -> dict[str, Any]:
    return {**_image(samples), "variance": noise_variance(samples.radiance)}


def _everything(samples: SampleBuffer) -> dict[str, Any]:
    found = _image_and_prefiltered(samples)
    return found | {"variance": noise_variance(samples.radiance), "albedo": found["features"].get("albedo")}


METHODS = {
    method.name: method
    for method in (
        Method("gaussian", "Gaussian", 2, _gaussian_candidates, _image, gaussian),
        Method("bilateral", "bilateral", 3, _bilateral_candidates, _image, bilateral),
        Method(
            "cross_bilateral", "cross-bilateral", 4, _cross_bilateral_candidates, _image_and_features, cross_bilateral
        ),
        Method(
            "cross_bilateral_prefiltered",
            "cross-bilateral, prefiltered",
            4,
            _prefiltered_candidates,
            _image_and_prefiltered,
            cross_bilateral,
        ),
        Method("nlm", "NL-means", 4, _nlm_candidates, _image_and_variance, nlm),
        Method("joint_nlm", "joint NL-means", 4, _joint_nlm_candidates, _everything, joint_nlm),
        Method("rpf", "RPF", 6, _nothing_to_choose, _samples, _rpf_adaptive),
        Method("rpf_report", "RPF, technical report", 6, _default_draws, _samples, _rpf_report, _report_variants()),
        Method("lbf", "LBF", 9, _nothing_to_choose, _samples, _lbf),
        Method("lbf_nlm", "LBF, NL-means", 9, _nothing_to_choose, _samples, _lbf_nlm),
    )
}
