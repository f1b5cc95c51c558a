"""The pieces of work that need features: cross-bilateral filter, joint NL-means, and the prefilter of features."""

from __future__ import annotations

from types import ModuleType

import numpy as np

from mcdenoise.filters import cross_bilateral, joint_nlm, prefilter_features
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.bench_measure import Contestant, Target

CROSS_SIGMA_SPACE, SIGMA_FEATURE, CROSS_RADIUS = 9.0, 0.5, 27
SEARCH_RADIUS, PATCH_RADIUS, NOISE = 10, 3, 0.1
FEATURES = ("world_position", "shading_normal", "albedo")
PREFILTER_SPP = 8

CROSS, CROSS_NOISY = "mcdenoise.cross_bilateral", "mcdenoise.cross_bilateral, variances"
CROSS_TARGETS = (Target(CROSS, seconds=0.35), Target(CROSS_NOISY, seconds=0.35))


def crosses(rng: np.random.Generator, image: np.ndarray, cv2: ModuleType | None) -> list[Contestant]:
    """Return cross-bilateral filters: ours without and with variances, and OpenCV's, which is not in all its packages."""
    features = {name: rng.random(image.shape, dtype=np.float32) for name in FEATURES}
    variances = {name: 0.01 * rng.random(image.shape, dtype=np.float32) for name in FEATURES}
    contrib, width = getattr(cv2, "ximgproc", None), 2 * CROSS_RADIUS + 1
    albedo = features["albedo"]
    return [
        Contestant(CROSS, lambda: cross(image, features, CROSS_RADIUS), "exact formula"),
        Contestant(CROSS_NOISY, lambda: cross(image, features, CROSS_RADIUS, variances), "one a feature channel"),
        Contestant(
            "cv2.ximgproc.jointBilateralFilter",
            contrib and (lambda: contrib.jointBilateralFilter(albedo, image, width, SIGMA_FEATURE, CROSS_SIGMA_SPACE)),
            "3 guide channels of the 12, round window (0.7 of the taps), L1 distance, weights from a table",
        ),
    ]


def joints(rng: np.random.Generator, image: np.ndarray) -> list[Contestant]:
    """Return joint NL-means with and without variances of the features."""
    features = {name: rng.random(image.shape, dtype=np.float32) for name in FEATURES}
    variances = {name: 0.01 * rng.random(image.shape, dtype=np.float32) for name in FEATURES}
    noise = (NOISE**2 * rng.uniform(0.5, 1.5, image.shape)).astype(np.float32)
    dials = {"search_radius": SEARCH_RADIUS, "patch_radius": PATCH_RADIUS}
    sigmas = dict.fromkeys(features, SIGMA_FEATURE)

    def run(noise_of_features: dict[str, np.ndarray] | None) -> np.ndarray:
        return joint_nlm(image, noise, features, sigma_features=sigmas, variances=noise_of_features, **dials)

    return [
        Contestant("mcdenoise.joint_nlm, variances", lambda: run(variances), "one a feature channel"),
        Contestant("mcdenoise.joint_nlm", lambda: run(None), "features free of noise"),
    ]


def prefilters(rng: np.random.Generator, size: int) -> list[Contestant]:
    """Return the prefilter of features."""
    samples = random_samples(rng, size, PREFILTER_SPP)
    return [
        Contestant("mcdenoise.prefilter_features", lambda: prefilter_features(samples), "means, variances, NL-means")
    ]


def cross(
    image: np.ndarray,
    features: dict[str, np.ndarray],
    radius: int,
    variances: dict[str, np.ndarray] | None = None,
) -> np.ndarray:
    """Run the cross-bilateral filter of the benchmark.

    Examples
    --------
    >>> image = np.ones((4, 4, 3), np.float32)
    >>> cross(image, {"albedo": image}, radius=1).shape
    (4, 4, 3)
    """
    return cross_bilateral(
        image,
        features,
        sigma_space=CROSS_SIGMA_SPACE,
        sigma_radiance=SIGMA_FEATURE,
        sigma_features=dict.fromkeys(features, SIGMA_FEATURE),
        variances=variances,
        radius=radius,
    )


def random_samples(rng: np.random.Generator, size: int, spp: int) -> SampleBuffer:
    """Return samples of noise with the features of the benchmark.

    Examples
    --------
    >>> random_samples(np.random.default_rng(0), 4, 2).feature_names
    ('world_position', 'shading_normal', 'albedo')
    """
    shape = (size, size, spp)
    corner = np.stack(np.meshgrid(np.arange(size), np.arange(size)), axis=-1)[:, :, np.newaxis]
    return SampleBuffer.from_arrays(
        rng.random((*shape, 3), dtype=np.float32),
        corner + rng.random((*shape, 2), dtype=np.float32),
        features={name: rng.random((*shape, 3), dtype=np.float32) for name in FEATURES},
    )
