"""The main job: one scene, every method, and the honest rival, more samples, all timed and measured in one run."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any, TypeVar

import numpy as np
from tqdm import tqdm

from mcdenoise.metrics import mse, psnr, relmse, relmse_map, ssim
from mcdenoise.render import capture, render_image, render_reference
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.samples.gate import check_count, check_names
from mcdenoise.study.machine import usable_cores
from mcdenoise.study.methods import METHODS, Method, Variant
from mcdenoise.study.tune import choose_parameters

T = TypeVar("T")
REPEATS = 5
ENOUGH_SECONDS = 2.0  # of timing one filter: a slow one is run fewer times
SMALLEST = 16  # pixels a side: below that there is nothing to look at, and SSIM has no room


@dataclass(frozen=True, eq=False)
class Result:
    """One image of the comparison with what it cost and how far it is from the reference.

    Attributes
    ----------
    name, label : for files, and for people
    kind : "filter" or "monte_carlo"
    spp : samples per pixel behind the image
    render_seconds : rendering that many samples, radiance alone
    relmse, mse, psnr, ssim : against the reference
    image : (h, w, 3) float32
    parameters : of the filter, {} for Monte Carlo
    filter_seconds : median over repeats, samples in, image out; 0 for Monte Carlo
    repeats : how many runs that median is of; 0 for Monte Carlo
    curve, point : labels of the method and of the variant, if this is one of several; else ""
    compile_seconds : what the first call took beyond the second
    choose_seconds : what choosing the parameters by halves of the samples took
    equal_time_with : labels of the filters whose total time this Monte Carlo image takes
    """

    name: str
    label: str
    kind: str
    spp: int
    render_seconds: float
    relmse: float
    mse: float
    psnr: float
    ssim: float
    image: np.ndarray
    parameters: Mapping[str, Any] = field(default_factory=dict)
    filter_seconds: float = 0.0
    repeats: int = 0
    curve: str = ""
    point: str = ""
    compile_seconds: float = 0.0
    choose_seconds: float = 0.0
    equal_time_with: tuple[str, ...] = ()

    @property
    def seconds(self) -> float:
        """Rendering and filtering together."""
        return self.render_seconds + self.filter_seconds

    def numbers(self) -> dict[str, Any]:
        """Everything but the image, as JSON can hold it."""
        return {name: value for name, value in vars(self).items() if name != "image"} | {"seconds": self.seconds}


@dataclass(frozen=True, eq=False)
class Comparison:
    """All results of one run: unfiltered Monte Carlo first, then the filters, then Monte Carlo at higher spp."""

    scene: str
    size: int
    spp: int
    seed: int
    reference_spp: int
    capture_seconds: float
    render_fixed_seconds: float
    render_seconds_per_spp: float
    provenance: Mapping[str, Any]
    results: tuple[Result, ...]
    reference: np.ndarray

    @property
    def unfiltered(self) -> Result:
        """Monte Carlo at the spp that the filters get."""
        return self.results[0]

    @property
    def filters(self) -> tuple[Result, ...]:
        """The filtered images."""
        return tuple(result for result in self.results if result.kind == "filter")

    @property
    def rivals(self) -> tuple[Result, ...]:
        """Monte Carlo at higher spp, ascending."""
        return tuple(result for result in self.results[1:] if result.kind == "monte_carlo")

    @property
    def reference_relmse(self) -> float:
        """What relMSE the reference's own noise may add: the input's, over the ratio of the spp (a 1/N estimate)."""
        return self.unfiltered.relmse * self.spp / self.reference_spp

    def error_map(self, result: Result) -> np.ndarray:
        """Return the relative squared error of a result, (h, w): `relmse_map`, mean over the channels."""
        return relmse_map(result.image, self.reference).mean(axis=-1)

    def front(self) -> tuple[Result, ...]:
        """Return the Pareto front, by time: the results that no other beats in both seconds and relMSE."""
        best, front = np.inf, []
        for result in sorted(self.results, key=lambda r: (r.seconds, r.relmse)):
            if result.relmse < best:
                best = result.relmse
                front.append(result)
        return tuple(front)


def compare(
    scene: object = "dof",
    *,
    spp: int = 8,
    size: int = 128,
    methods: Sequence[str] | None = None,
    seed: int = 0,
    reference_spp: int = 1024,
    variant: str = "auto",
) -> Comparison:
    """Capture a scene, run every method, and measure each against the reference and against more samples.

    Parameters
    ----------
    scene : name, Mitsuba dict or path, as for `mcd.capture`.
    spp : samples per pixel that the filters get.
    size : height and width in pixels, at least 16.
    methods : names from `METHODS`; all of them by default.
    seed : of the captured samples.
    reference_spp : of the reference, which is cached on disk.
    variant : Mitsuba back end, as for `mcd.capture`.

    Returns
    -------
    Comparison

    Raises
    ------
    ValueError
        For an unknown scene or method, or numbers out of range.

    Notes
    -----
    Rendering is charged with the time of `mcd.render_image` (radiance alone), for filters and for Monte Carlo alike: capturing
    the features in Python is slow for reasons that no renderer shares, so it is reported apart (`capture_seconds`).
    """
    spp, size = check_count(spp, "spp"), check_count(size, "size", least=SMALLEST)
    seed = check_count(seed, "seed", least=0)
    if check_count(reference_spp, "reference_spp") <= spp:
        raise ValueError(
            f"reference_spp must be greater than spp = {spp}, got {reference_spp}. Pass a larger reference_spp."
        )
    chosen = [METHODS[name] for name in check_names(METHODS if methods is None else methods, list(METHODS), "methods")]
    view = {"width": size, "height": size, "variant": variant}

    samples, capture_seconds = timed(lambda: capture(scene, spp=spp, seed=seed, **view))
    reference = render_reference(scene, spp=reference_spp, seed=seed, **view)
    render = RenderClock(lambda n: render_image(scene, spp=n, seed=seed + 1, **view), spp, reference_spp)

    unfiltered = _monte_carlo(pixel_mean(samples.radiance), reference, spp, render)
    filtered = []
    for method in tqdm(chosen, "filters", disable=None, leave=False):
        filtered += _filter(method, samples, reference, render)
    rivals = _rivals(filtered, reference, render)
    return Comparison(
        scene=Path(samples.provenance["scene"]).name,
        size=size,
        spp=spp,
        seed=seed,
        reference_spp=reference_spp,
        capture_seconds=capture_seconds,
        render_fixed_seconds=render.fixed_seconds,
        render_seconds_per_spp=render.seconds_per_spp,
        provenance={**samples.provenance, "cores": usable_cores()},
        results=(unfiltered, *filtered, *rivals),
        reference=reference,
    )


class RenderClock:
    """What rendering N spp costs: fixed_seconds + N seconds_per_spp, from medians at spp and 4 spp in this run.

    The first, discarded call takes what is done once (loading, compiling).
    """

    def __init__(self, render: Callable[[int], np.ndarray], spp: int, most_spp: int) -> None:
        self.render, self.spp, self.most_spp = render, spp, most_spp
        render(spp)
        turns = tqdm((spp, 4 * spp) * REPEATS, "timing Monte Carlo", disable=None, leave=False)
        taken = [timed(lambda n=n: render(n))[1] for n in turns]
        few, many = statistics.median(taken[::2]), statistics.median(taken[1::2])
        self.seconds_per_spp = max(many - few, 1e-9) / (3 * spp)
        self.fixed_seconds = max(few - spp * self.seconds_per_spp, 0.0)

    def seconds(self, spp: int) -> float:
        """Return the seconds that rendering `spp` samples per pixel takes."""
        return self.fixed_seconds + spp * self.seconds_per_spp

    def spp_within(self, seconds: float) -> int:
        """Return the spp that `seconds` more than those for `self.spp` pay for, rounded up in favour of Monte Carlo."""
        return min(self.spp + int(np.ceil(seconds / self.seconds_per_spp)), self.most_spp)


def timed(call: Callable[[], T]) -> tuple[T, float]:
    """Return what a call returns, and its seconds.

    Examples
    --------
    >>> result, seconds = timed(lambda: 1 + 1)
    >>> result, seconds >= 0
    (2, True)
    """
    start = perf_counter()
    result = call()
    return result, perf_counter() - start


def _measure(image: np.ndarray, reference: np.ndarray, spp: int, render: RenderClock, **about: Any) -> Result:
    """Put an image and its cost beside its errors."""
    errors = {metric.__name__: metric(image, reference) for metric in (relmse, mse, psnr, ssim)}
    return Result(image=image, spp=spp, render_seconds=render.seconds(spp), **errors, **about)


def _monte_carlo(image: np.ndarray, reference: np.ndarray, spp: int, render: RenderClock, **about: Any) -> Result:
    """Measure an image of `spp` samples per pixel, unfiltered."""
    names = {"name": f"mc_{spp}spp", "label": f"MC {spp} spp", "kind": "monte_carlo"}
    return _measure(image, reference, spp, render, **names, **about)


def _filter(method: Method, samples: SampleBuffer, reference: np.ndarray, render: RenderClock) -> list[Result]:
    """Run one method: a call that may compile, the choice of its bandwidths, then the timed calls, for each variant."""
    corner = samples.crop(0, 0, SMALLEST, SMALLEST)
    first_choice = method.candidates(corner)[0]
    first, second = (timed(lambda: method.run(corner, **first_choice))[1] for _ in range(2))
    compiling = max(first - second, 0.0)
    if not method.variants:
        parameters, choosing = timed(lambda: choose_parameters(method, samples))
        about = {"name": method.name, "label": method.label, "choose_seconds": choosing}
        runs = [(parameters, about)]
    else:
        runs = [(variant.parameters, _about_variant(method, variant)) for variant in method.variants]
    results = []
    for parameters, about in runs:
        image, seconds = timed_often(lambda p=parameters: method.run(samples, **p))
        cost = {"filter_seconds": statistics.median(seconds), "repeats": len(seconds), "compile_seconds": compiling}
        about |= {"kind": "filter", "parameters": parameters, **cost}
        results.append(_measure(image, reference, samples.spp, render, **about))
        compiling = 0.0
    return results


def _about_variant(method: Method, variant: Variant) -> dict[str, Any]:
    """Names of one point of a method's curve."""
    name, label = f"{method.name}_{variant.name}", f"{method.label}, {variant.label}"
    return {"name": name, "label": label, "curve": method.label, "point": variant.label}


def timed_often(call: Callable[[], T], repeats: int = REPEATS, enough: float = ENOUGH_SECONDS) -> tuple[T, list[float]]:
    """Return what a call returns, and the seconds of several calls: fewer than usual once they have taken long enough.

    Examples
    --------
    >>> result, seconds = timed_often(lambda: 1 + 1, repeats=3)
    >>> result, len(seconds)
    (2, 3)
    """
    seconds: list[float] = []
    while len(seconds) < repeats and sum(seconds) < enough:
        result, taken = timed(call)
        seconds.append(taken)
    return result, seconds


def _rivals(filtered: Sequence[Result], reference: np.ndarray, render: RenderClock) -> list[Result]:
    """Render Monte Carlo at the total time of each filter, and at 4 and 16 times the spp to show the 1/N slope."""
    equal: dict[int, list[str]] = {n * render.spp: [] for n in (4, 16) if n * render.spp <= render.most_spp}
    for result in filtered:
        equal.setdefault(render.spp_within(result.filter_seconds), []).append(result.label)
    return [
        _monte_carlo(render.render(spp), reference, spp, render, equal_time_with=tuple(labels))
        for spp, labels in tqdm(sorted(equal.items()), "Monte Carlo at equal time", disable=None, leave=False)
    ]
