"""Denoisers that others offer, as methods that `tune` can search: samples in, image out.

They know nothing of high dynamic range. So each may choose, with the reference, whether it sees the radiance itself or
log(1 + c), and gets candidates so wide apart that the best lies inside; `tune` refines them as it refines ours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from types import ModuleType
from typing import Any

import numpy as np

from mcdenoise.filters import nlm, noise_variance
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.study.bench_filters import Peers
from mcdenoise.study.methods import METHODS, Method, Parameters

SEARCH_RADIUS = 10
TONES = {"as it is": (np.asarray, np.asarray), "log(1 + c)": (np.log1p, np.expm1)}
GUIDES = {  # jointBilateralFilter takes one guide of at most 3 channels
    "albedo": ("albedo",),
    "normal": ("shading_normal",),
    "albedo, then normal": ("albedo", "shading_normal"),
    "mixed": ("mixed",),
}
JOINT_BILATERAL = "OpenCV joint bilateral"
NLM_CONSTANT = "NL-means, one best constant variance"


def constant_nlm() -> Method:
    """Return our NL-means with one number as the variance of all pixels, to be searched like any other dial."""

    def candidates(samples: SampleBuffer) -> list[Parameters]:
        mean = float(noise_variance(samples.radiance).mean())
        grid = product((1, 3), (0.15, 0.3, 0.6, 1.2), (1 / 1024, 1 / 256, 1 / 64, 1 / 16, 1 / 4, 1.0))
        return [
            {"patch_radius": r, "k": k, "weight_radius": 1, "variance": max(share * mean, 1e-12)}
            for r, k, share in grid
        ]

    return Method("nlm_constant", NLM_CONSTANT, 4, candidates, METHODS["gaussian"].prepare, nlm)


def peer_methods(peers: Peers) -> list[tuple[str, Method | None]]:
    """Return label and method of every peer; None where its library is not installed.

    Examples
    --------
    >>> peer_methods({"scipy.ndimage": None, "skimage": None, "cv2": None})[0]
    ('scikit-image NL-means, fast mode', None)
    """
    skimage, cv2 = peers["skimage"], peers["cv2"]
    contrib = getattr(cv2, "ximgproc", None)
    return [
        _skimage_nlm("scikit-image NL-means, fast mode", skimage),
        _opencv_nlm("OpenCV NL-means, 8 bits", cv2),
        _opencv_bilateral("OpenCV bilateral (L1)", cv2),
        _opencv_joint_bilateral(JOINT_BILATERAL, contrib),
    ]


def _image(samples: SampleBuffer) -> dict[str, Any]:
    """The pixel means, never negative."""
    return {"image": np.maximum(pixel_mean(samples.radiance), 0)}


def peer(
    label: str, library: ModuleType | None, candidates: list[Parameters], prepare: Any, run: Any
) -> tuple[str, Method | None]:
    """Pair the label of a peer with its method, None without its library.

    Examples
    --------
    >>> peer("blur of others", None, [], None, None)
    ('blur of others', None)
    """
    return label, library and Method(label, label, 4, lambda _: candidates, prepare, run)


def _skimage_nlm(label: str, skimage: ModuleType | None) -> tuple[str, Method | None]:
    """scikit-image: h is how different patches may be, sigma the noise that is taken off."""

    def run(image: np.ndarray, tone: str, patch_size: int, h: float, noise: float) -> np.ndarray:
        there, back = TONES[tone]
        denoise, windows = skimage.restoration.denoise_nl_means, {"patch_distance": SEARCH_RADIUS, "channel_axis": -1}
        return back(denoise(there(image), patch_size=patch_size, h=h, sigma=noise * h, fast_mode=True, **windows))

    grid = product(TONES, (3, 7), (0.01, 0.03, 0.1, 0.3, 1.0), (0.0, 0.5, 2.0))
    candidates = [{"tone": tone, "patch_size": size, "h": h, "noise": noise} for tone, size, h, noise in grid]
    return peer(label, skimage, candidates, _image, run)


def _opencv_nlm(label: str, cv2: ModuleType | None) -> tuple[str, Method | None]:
    """OpenCV: log(1 + c) of the whole range, or the range up to a percentile, in 8 bits; h in grey levels."""

    def run(image: np.ndarray, white: int, patch_size: int, h: float) -> np.ndarray:
        tone = np.log1p(image)
        scale = 255 / max(float(np.percentile(tone, white)), 1e-6)
        grey = np.clip(np.round(scale * tone), 0, 255).astype(np.uint8)
        windows = {"templateWindowSize": patch_size, "searchWindowSize": 2 * SEARCH_RADIUS + 1}
        return np.expm1(cv2.fastNlMeansDenoising(grey, None, h=h, **windows).astype(np.float32) / scale)

    grid = product((99, 100), (3, 7), (1.0, 4.0, 8.0, 16.0, 32.0, 128.0))
    candidates = [{"white": white, "patch_size": size, "h": h} for white, size, h in grid]
    return peer(label, cv2, candidates, _image, run)


def _opencv_bilateral(label: str, cv2: ModuleType | None) -> tuple[str, Method | None]:
    """OpenCV: the window reaches as far as ours, 3 sigma."""

    def run(image: np.ndarray, tone: str, sigma_space: float, sigma_radiance: float) -> np.ndarray:
        there, back = TONES[tone]
        return back(cv2.bilateralFilter(there(image), _diameter(sigma_space), sigma_radiance, sigma_space))

    return peer(label, cv2, _bandwidths(TONES), _image, run)


def _opencv_joint_bilateral(label: str, contrib: ModuleType | None) -> tuple[str, Method | None]:
    """OpenCV contrib: guided by albedo, normal, both one after the other, or three channels mixed of both."""

    def run(image: np.ndarray, guides: dict[str, np.ndarray], tone: str, sigma_space: float, sigma_radiance: float):
        for name in GUIDES[tone]:
            guide = guides[name]
            image = contrib.jointBilateralFilter(guide, image, _diameter(sigma_space), sigma_radiance, sigma_space)
        return image

    return peer(label, contrib, _bandwidths(GUIDES), image_and_guides, run)


def _bandwidths(tones: Sequence[str]) -> list[Parameters]:
    """Candidates for a bilateral filter of OpenCV."""
    grid = product(tones, (0.35, 0.7, 1.4, 2.8, 5.6), (0.025, 0.1, 0.2, 0.4, 0.8, 3.2))
    return [{"tone": tone, "sigma_space": space, "sigma_radiance": radiance} for tone, space, radiance in grid]


def _diameter(sigma_space: float) -> int:
    """Width of the window: 3 sigma to both sides, as ours."""
    return 2 * math.ceil(3 * sigma_space) + 1


def image_and_guides(samples: SampleBuffer) -> dict[str, Any]:
    """Return the image with guides of at most three channels; a feature that the scene lacks counts as constant."""
    image = _image(samples)["image"]
    found = {
        name: pixel_mean(samples[name]) if name in samples.feature_names else np.zeros_like(image)
        for name in ("albedo", "shading_normal")
    }
    spread = found["shading_normal"].std(axis=(0, 1))
    normal = found["shading_normal"][..., np.sort(np.argsort(spread)[-2:])]  # the two components that vary most
    mixed = np.concatenate([found["albedo"].mean(axis=-1, keepdims=True), normal], axis=-1)
    return {"image": image, "guides": {**found, "mixed": np.ascontiguousarray(mixed)}}
