"""What a user would pick instead of our filters: the peers of the benchmark, guided filter and Intel's denoiser, as methods.

Their dials are chosen by halves of the samples, as ours are (`study.tune.choose_parameters`): lists short enough for that,
around what the long lists of `bench_peers` found on the toy scenes. The extra ``mcdenoise[peers]`` installs the libraries.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from types import ModuleType

import numpy as np

from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.study.bench_filters import find_peers
from mcdenoise.study.bench_peers import TONES, image_and_guides, peer, peer_methods
from mcdenoise.study.methods import Method, Parameters

OIDN, GUIDED = "Intel OIDN", "OpenCV guided filter"
# Of each dial of a peer, the values that are tried; a dial that is not named keeps all of its own.
SHORT = {
    "tone": ("log(1 + c)", "albedo", "albedo, then normal", "mixed"),
    "sigma_space": (0.7, 1.4, 2.8),
    "sigma_radiance": (0.1, 0.2, 0.4, 0.8, 3.2),
    "h": (0.03, 0.1, 0.3, 4.0, 8.0, 16.0, 32.0),
    "noise": (0.5, 2.0),
    "white": (99,),
}


def find_oidn() -> Callable[[SampleBuffer], np.ndarray] | None:
    """Intel's Open Image Denoise, samples in, image out; None if its Python package `pyoidn` is not installed."""
    try:
        import pyoidn
    except ImportError:
        return None

    def run(samples: SampleBuffer) -> np.ndarray:
        names = {"albedo": "albedo", "normal": "shading_normal"}
        guides = {ours: pixel_mean(samples[name]) for ours, name in names.items() if name in samples.feature_names}
        return np.asarray(pyoidn.denoise(pixel_mean(samples.radiance), hdr=True, **guides))

    return run


def user_methods() -> dict[str, Method | None]:
    """Return label -> method of everything that a user could pick instead; None where it is not installed.

    Examples
    --------
    >>> list(user_methods())[-2:]
    ['OpenCV guided filter', 'Intel OIDN']
    """
    libraries = find_peers()
    found = {label: method and _shortened(method) for label, method in peer_methods(libraries)}
    oidn = find_oidn()
    network = oidn and Method(OIDN, OIDN, 9, lambda _: [{}], lambda samples: {"samples": samples}, oidn)
    return found | dict([opencv_guided(libraries["cv2"])]) | {OIDN: network}


def _shortened(method: Method) -> Method:
    """The method with those of its candidates whose dials are all in `SHORT`."""

    def kept(samples: SampleBuffer) -> Sequence[Parameters]:
        return [
            one
            for one in method.candidates(samples)
            if all(value in SHORT.get(name, (value,)) for name, value in one.items())
        ]

    return replace(method, candidates=kept)


def opencv_guided(cv2: ModuleType | None) -> tuple[str, Method | None]:
    """Return label and method of OpenCV's guided filter: in each window log(1 + c) is fitted by a straight line in the guide.

    The guide is log(1 + c) itself, the grey of the albedo, the albedo, or three channels mixed of albedo and normal. (With a
    guide of three channels that are all alike and an epsilon below about 0.01, OpenCV takes the mean of the window instead.)
    What the line makes negative is 0.

    Examples
    --------
    >>> opencv_guided(None)
    ('OpenCV guided filter', None)
    """
    contrib = getattr(cv2, "ximgproc", None)
    there, back = TONES["log(1 + c)"]

    def run(image: np.ndarray, guides: dict[str, np.ndarray], guide: str, radius: int, epsilon: float) -> np.ndarray:
        tone = there(image)
        every = {**guides, "itself": tone, "grey": np.ascontiguousarray(guides["mixed"][..., 0])}
        return back(np.maximum(contrib.guidedFilter(every[guide], tone, radius, epsilon), 0))

    grid = product(("itself", "grey", "albedo", "mixed"), (1, 2), (0.003, 0.01, 0.03, 0.1))
    candidates = [{"guide": guide, "radius": radius, "epsilon": epsilon} for guide, radius, epsilon in grid]
    return peer(GUIDED, contrib, candidates, image_and_guides, run)
