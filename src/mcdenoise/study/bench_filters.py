"""The pieces of work of the benchmark: each of our filters beside what scipy, scikit-image and OpenCV offer."""

from __future__ import annotations

import importlib
import time
from types import ModuleType

import numpy as np

from mcdenoise.filters import bilateral, gaussian, joint_nlm, nlm
from mcdenoise.study.bench_guided import (
    CROSS_RADIUS,
    CROSS_TARGETS,
    FEATURES,
    NOISE,
    PATCH_RADIUS,
    PREFILTER_SPP,
    SEARCH_RADIUS,
    cross,
    crosses,
    joints,
    prefilters,
)
from mcdenoise.study.bench_measure import Contestant, Target, Work

SIGMA_SPACE, GAUSSIAN_RADIUS = 3.0, 9
BILATERAL_SIGMA_SPACE, SIGMA_RADIANCE, BILATERAL_RADIUS = 5.0, 0.3, 10

NLM, NLM_NUMBER = "mcdenoise.nlm, a variance a pixel", "mcdenoise.nlm, one number as variance"
SKIMAGE_NLM, CV2_NLM = "skimage.restoration.denoise_nl_means", "cv2.fastNlMeansDenoising"
TARGET_SIZE = 512  # the targets are stated for it
NLM_TARGETS = tuple(
    Target(ours, rival=rival, times=times)
    for ours in (NLM, NLM_NUMBER)
    for rival, times in ((SKIMAGE_NLM, 6.0), (CV2_NLM, 2.0))
)
Peers = dict[str, ModuleType | None]


def find_peers() -> Peers:
    """Return the libraries we measure beside, None for one that is not installed.

    Examples
    --------
    >>> list(find_peers())
    ['scipy.ndimage', 'skimage', 'cv2']
    """
    return {name: _import(name) for name in ("scipy.ndimage", "skimage", "cv2")}


def filter_works(size: int, peers: Peers) -> list[Work]:
    """Return all pieces of work, with every contestant that is installed; targets only at the size they are meant for."""
    rng = np.random.default_rng(0)
    image = rng.random((size, size, 3), dtype=np.float32)
    half, window = max(4, size // 2), 2 * CROSS_RADIUS + 1
    patches = f"patch {2 * PATCH_RADIUS + 1}, window {2 * SEARCH_RADIUS + 1}"
    judged = size == TARGET_SIZE
    small = np.ascontiguousarray(image[:half, :half])
    return [
        Work(
            f"Gaussian, sigma {SIGMA_SPACE:g}, radius {GAUSSIAN_RADIUS}, {size}x{size}x3 float32",
            _gaussians(image, peers),
        ),
        Work(
            f"bilateral, radius {BILATERAL_RADIUS}, {size}x{size}x3 float32",
            _bilaterals(image, peers),
            taps=count_taps(size, BILATERAL_RADIUS),
        ),
        Work(
            f"cross-bilateral, window {window}x{window}, 9 feature channels + colour, {half}x{half}",
            crosses(rng, small, peers["cv2"]),
            taps=count_taps(half, CROSS_RADIUS),
            targets=CROSS_TARGETS if judged else (),
        ),
        Work(
            f"NL-means, {patches}, {size}x{size}x3 float32",
            _nlms(rng, noisy_picture(rng, size), peers),
            taps=count_taps(size, SEARCH_RADIUS),
            targets=NLM_TARGETS if judged else (),
        ),
        Work(
            f"joint NL-means, {patches}, 9 feature channels + colour, {half}x{half}",
            joints(rng, small),
            taps=count_taps(half, SEARCH_RADIUS),
        ),
        Work(f"prefiltering 9 feature channels, {half}x{half}, {PREFILTER_SPP} spp", prefilters(rng, half)),
    ]


def _gaussians(image: np.ndarray, peers: Peers) -> list[Contestant]:
    """Return Gaussian filters: all with the same sigma and radius, differing at the border only."""
    ndimage, skimage, cv2 = peers.values()
    truncate, width = GAUSSIAN_RADIUS / SIGMA_SPACE, 2 * GAUSSIAN_RADIUS + 1
    sigmas = (SIGMA_SPACE, SIGMA_SPACE, 0)
    return [
        Contestant("mcdenoise.gaussian", lambda: gaussian(image, sigma_space=SIGMA_SPACE, radius=GAUSSIAN_RADIUS)),
        Contestant(
            "scipy.ndimage.gaussian_filter",
            ndimage and (lambda: ndimage.gaussian_filter(image, sigmas, truncate=truncate)),
        ),
        Contestant(
            "skimage.filters.gaussian",
            skimage and (lambda: skimage.filters.gaussian(image, SIGMA_SPACE, truncate=truncate, channel_axis=-1)),
        ),
        Contestant("cv2.GaussianBlur", cv2 and (lambda: cv2.GaussianBlur(image, (width, width), SIGMA_SPACE))),
    ]


def _bilaterals(image: np.ndarray, peers: Peers) -> list[Contestant]:
    """Return bilateral filters. Theirs are approximations, of which each note says what is left out."""
    _, skimage, cv2 = peers.values()
    sigmas = {"sigma_space": BILATERAL_SIGMA_SPACE, "sigma_radiance": SIGMA_RADIANCE}
    width, crop = 2 * BILATERAL_RADIUS + 1, image[: max(8, len(image) // 4), : max(8, len(image) // 4)]
    return [
        Contestant("mcdenoise.bilateral", lambda: bilateral(image, radius=BILATERAL_RADIUS, **sigmas), "exact formula"),
        Contestant(
            "skimage.restoration.denoise_bilateral",
            skimage
            and (
                lambda: skimage.restoration.denoise_bilateral(
                    crop, width, SIGMA_RADIANCE, BILATERAL_SIGMA_SPACE, channel_axis=-1
                )
            ),
            f"weights from tables; one run on {len(crop)}x{len(crop)}, scaled by pixels",
            scale=image.size / crop.size,
            once=True,
        ),
        Contestant(
            "cv2.bilateralFilter",
            cv2 and (lambda: cv2.bilateralFilter(image, width, SIGMA_RADIANCE, BILATERAL_SIGMA_SPACE)),
            "round window (0.7 of the taps), L1 distance, weights from a table",
        ),
    ]


def _nlms(rng: np.random.Generator, image: np.ndarray, peers: Peers) -> list[Contestant]:
    """Return NL-means filters. Theirs know one noise level for the whole image."""
    _, skimage, cv2 = peers.values()
    variance = (NOISE**2 * rng.uniform(0.5, 1.5, image.shape)).astype(np.float32)
    windows = {"search_radius": SEARCH_RADIUS, "patch_radius": PATCH_RADIUS}
    bytes_image = np.round(255 * image.clip(0, 1)).astype(np.uint8)
    sizes = {"templateWindowSize": 2 * PATCH_RADIUS + 1, "searchWindowSize": 2 * SEARCH_RADIUS + 1}
    theirs = {"patch_size": 2 * PATCH_RADIUS + 1, "patch_distance": SEARCH_RADIUS, "channel_axis": -1}
    dials = {"h": 0.6 * NOISE, "sigma": NOISE}  # as its documentation advises, and our k
    return [
        Contestant(NLM, lambda: nlm(image, variance, **windows), "exact formula, asymmetric weights"),
        Contestant(NLM_NUMBER, lambda: nlm(image, NOISE**2, **windows), "what the peers can do"),
        Contestant(
            SKIMAGE_NLM,
            skimage and (lambda: skimage.restoration.denoise_nl_means(image, fast_mode=True, **dials, **theirs)),
            "fast mode; one noise level, weights from a rough exponential, none below exp(-5)",
        ),
        Contestant(
            CV2_NLM,
            cv2 and (lambda: cv2.fastNlMeansDenoising(bytes_image, None, h=255 * 0.6 * NOISE, **sizes)),
            "8 bits a channel in and out; one noise level, weights from a table",
        ),
    ]


def noisy_picture(rng: np.random.Generator, size: int) -> np.ndarray:
    """Return waves and a chequered floor under noise of standard deviation NOISE.

    NL-means is not timed on pure noise: there no two patches are alike, and scikit-image's, which skips patches that
    differ, would get away with half of the work.

    Examples
    --------
    >>> noisy_picture(np.random.default_rng(0), 8).shape
    (8, 8, 3)
    """
    y, x = np.indices((size, size))[..., np.newaxis] / size
    waves = 0.25 * np.sin(7 * x + 5 * y + np.arange(3))
    floor = 0.2 * ((np.floor(8 * x) + np.floor(8 * y)) % 2)
    return (0.4 + waves + floor + NOISE * rng.normal(size=waves.shape)).astype(np.float32)


def compile_kernels() -> float:
    """Run every kernel once on a tiny image; return the seconds that took.

    Examples
    --------
    >>> compile_kernels() > 0
    True
    """
    tiny = np.ones((4, 4, 3), np.float32)
    features = dict.fromkeys(FEATURES, tiny)
    start = time.perf_counter()
    gaussian(tiny, sigma_space=1.0)
    bilateral(tiny, sigma_space=1.0, sigma_radiance=1.0)
    cross(tiny, features, 1)
    cross(tiny, features, 1, variances=features)
    nlm(tiny, 1.0, search_radius=1, patch_radius=1)
    joint_nlm(tiny, 1.0, features, sigma_features=dict.fromkeys(features, 1.0), variances=features, search_radius=1)
    return time.perf_counter() - start


def count_taps(size: int, radius: int) -> int:
    """Count pairs (pixel, neighbour in its window and inside the image).

    Examples
    --------
    >>> count_taps(2, 1)  # 4 pixels, each sees all 4
    16
    """
    return sum(size - abs(d) for d in range(-radius, radius + 1) if abs(d) < size) ** 2


def _import(name: str) -> ModuleType | None:
    """Return a peer's module, or None if it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None
