"""What does a scene need? Advice from its samples alone: which random parameters, which features, which filter.

    mcdenoise advise SAMPLES.npz [--json advice.json]

There is no reference: a quarter of the samples judges what a filter makes of the other three (`left_out.LeftOut`), and whatever
the image cannot tell apart counts as equal (`choice.simplest_like_best`).
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from tqdm import tqdm

from mcdenoise.rpf import RPFConfig, rpf
from mcdenoise.samples import SampleBuffer
from mcdenoise.samples.gate import check_count
from mcdenoise.study.choice import Choice, how_sure, mean_and_error, simplest_like_best, tile_means
from mcdenoise.study.information import Information, information
from mcdenoise.study.left_out import LeftOut
from mcdenoise.study.methods import METHODS, Method, Parameters
from mcdenoise.study.tune import choose_parameters

SMALLEST = 16  # pixels a side: four tiles
# The methods in order of what they ask for, the least first.
ASKS = {
    "gaussian": "radiance",
    "bilateral": "radiance",
    "nlm": "radiance and its variance",
    "cross_bilateral": "features",
    "cross_bilateral_prefiltered": "features and their variances",
    "joint_nlm": "features, their variances, that of radiance",
    "rpf": "random parameters and features, sample by sample",
    "lbf": "features, variances, a trained network",
    "lbf_nlm": "features, variances, a trained network",
}
FEATURE_FILTERS = ("cross_bilateral", "cross_bilateral_prefiltered", "joint_nlm")
BOXES = ((3,), (5,), (5, 3), (7, 5, 3))  # of RPF, the cheapest first
RPF_PARTS = 2  # parts that judge its boxes and random parameters: it is slow


@dataclass(frozen=True, eq=False)
class Trial:
    """One way of filtering, on trial.

    Attributes
    ----------
    name : of the method, of what was left out, or the boxes
    parts : (parts, tiles), relative squared error in each tile, judged by each part, with the noise of that part
    seconds : of one run, median over the parts; each run has the samples of all parts but one
    parameters : of the method
    """

    name: str
    parts: np.ndarray
    seconds: float
    parameters: Parameters

    @property
    def tiles(self) -> np.ndarray:
        """Mean over the parts, (tiles,)."""
        return self.parts.mean(axis=0)


@dataclass(frozen=True)
class Drop:
    """What leaving one name out costs and saves.

    Attributes
    ----------
    name : of a random parameter or a feature
    behind, standard_error : by how much relMSE grows without it, and how well that is known, from differences between tiles
    seconds : what a run takes less without it
    keep : whether it belongs into the layout
    """

    name: str
    behind: float
    standard_error: float
    seconds: float
    keep: bool


@dataclass(frozen=True, eq=False)
class Advice:
    """What a buffer needs, and how sure that is.

    Attributes
    ----------
    height, width, spp : of the buffer
    noise : mean noise of the samples that judge: estimated relMSE is the mean of a trial's tiles less this
    informations : of each random parameter and feature (`information`)
    random_params : what dropping each costs RPF; kept is what carries information beyond chance
    features : what dropping each costs `feature_filter`; kept is what its error shows
    feature_filter : name of the filter that features are judged with; "" without features
    methods : a trial a method, the simplest first
    choice : among them, on the Pareto front
    sure : share of resamplings of the tiles that choose the same
    boxes, box_choice : trials of RPF's boxes, the cheapest first, and the choice among them; (), None without random parameters
    """

    height: int
    width: int
    spp: int
    noise: float
    informations: tuple[Information, ...]
    random_params: tuple[Drop, ...]
    features: tuple[Drop, ...]
    feature_filter: str
    methods: tuple[Trial, ...]
    choice: Choice
    sure: float
    boxes: tuple[Trial, ...]
    box_choice: Choice | None

    @property
    def method(self) -> str:
        """Name of the method to take."""
        return self.methods[self.choice.chosen].name

    @property
    def layout(self) -> dict[str, tuple[str, ...]]:
        """Which random parameters and features to keep, by name: arguments of `SampleBuffer.select`."""
        groups = {"random_params": self.random_params, "features": self.features}
        return {kind: tuple(one.name for one in drops if one.keep) for kind, drops in groups.items()}

    def error(self, trial: Trial) -> float:
        """Estimated relMSE of a trial; below 0 where noise hides it."""
        return float(trial.tiles.mean()) - self.noise

    def box_error(self, trial: Trial) -> float:
        """Estimated relMSE with other boxes: that of RPF, and the difference that the parts show which judged both."""
        usual = " ".join(map(str, RPFConfig.adaptive().boxes))
        whole = next(one for one in self.methods if one.name == "rpf")
        same = next(one for one in self.boxes if one.name == usual)
        return self.error(whole) + float(trial.tiles.mean() - same.tiles.mean())

    def numbers(self) -> dict[str, Any]:
        """Everything as JSON can hold it, without the tiles."""
        methods = [
            {
                "name": one.name,
                "error": self.error(one),
                "seconds": one.seconds,
                "behind": behind,
                "standard_error": spread,
            }
            for one, behind, spread in zip(self.methods, self.choice.behind, self.choice.standard_error, strict=True)
        ]
        boxes = [{"boxes": one.name, "error": self.box_error(one), "seconds": one.seconds} for one in self.boxes]
        return {
            **{
                name: getattr(self, name)
                for name in ("height", "width", "spp", "noise", "feature_filter", "method", "sure")
            },
            "layout": self.layout,
            "best": self.methods[self.choice.best].name,
            "on_front": [one.name for one, front in zip(self.methods, self.choice.on_front, strict=True) if front],
            **{
                name: [vars(one) for one in getattr(self, name)]
                for name in ("informations", "random_params", "features")
            },
            "methods": methods,
            "rpf_boxes": boxes,
            "rpf_choice": self.boxes[self.box_choice.chosen].name if self.box_choice else None,
        }


def advise(samples: SampleBuffer, *, seed: int = 0, progress: bool | None = None) -> Advice:
    """Say what a buffer needs: random parameters, features, filter, and how large RPF's boxes must be.

    Bandwidths are chosen by halves of all samples, as `mcdenoise compare` does. A random parameter is kept if its mutual
    information with radiance is beyond chance. A feature is kept if a filter errs more without it, by more than one standard
    error of the difference; the least useful goes first. The method is the simplest on the Pareto front of seconds and error
    that is less than one standard error behind the best.

    Parameters
    ----------
    samples : 2 spp or more, 16 x 16 pixels or more
    seed : of shuffles and resamplings
    progress : a bar on stderr; None: if that is a terminal

    Returns
    -------
    Advice

    Raises
    ------
    ValueError
        For 1 spp, a smaller image, or a seed that is no whole number from 0 on.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(16), np.arange(16)), axis=-1)[:, :, np.newaxis]
    >>> light = rng.random((16, 16, 4))
    >>> radiance = 0.5 + 0.5 * np.repeat(light[..., np.newaxis], 3, axis=-1)  # the light lies on a wall without texture
    >>> params = {"light_u": light, "lens_u": rng.random(light.shape)}
    >>> found = advise(SampleBuffer.from_arrays(radiance, corner + rng.random((16, 16, 4, 2)), params), progress=False)
    >>> found.layout, found.method
    ({'random_params': ('light_u',), 'features': ()}, 'gaussian')
    """
    seed = check_count(seed, "seed", least=0)
    if min(samples.height, samples.width) < SMALLEST:
        raise ValueError(
            f"Advice needs an image of {SMALLEST} x {SMALLEST} pixels or more, to compare its tiles, got {samples.height} x "
            f"{samples.width}."
        )
    left_out = LeftOut.of(samples)
    names = [name for name in ASKS if _can_run(name, samples)]
    with tqdm(
        total=len(names) + 4, desc="advice", disable=None if progress is None else not progress, leave=False
    ) as bar:
        informations = information(samples, seed=seed)
        bar.update()
        methods = []
        for name in names:
            bar.set_postfix_str(METHODS[name].label)
            methods.append(_try_method(METHODS[name], samples, left_out))
            bar.update()
        errors, seconds = np.array([one.tiles for one in methods]), [one.seconds for one in methods]
        choice = simplest_like_best(errors, seconds)
        feature_filter = _feature_filter(methods, choice.chosen)
        features = drop_features(feature_filter, left_out) if feature_filter else ()
        bar.update()
        whole = next((one for one in methods if one.name == "rpf"), None)
        random_params = _drop_random_params(informations, whole, left_out) if whole else ()
        bar.update()
        boxes = tuple(_try_boxes(boxes, whole, left_out) for boxes in BOXES) if whole else ()
        bar.update()
    return Advice(
        height=samples.height,
        width=samples.width,
        spp=samples.spp,
        noise=float(tile_means(left_out.noise).mean()),
        informations=tuple(informations),
        random_params=random_params,
        features=features,
        feature_filter=feature_filter.name if feature_filter else "",
        methods=tuple(methods),
        choice=choice,
        sure=how_sure(errors, seconds, seed),
        boxes=boxes,
        box_choice=simplest_like_best(np.array([one.tiles for one in boxes])) if boxes else None,
    )


def _can_run(name: str, samples: SampleBuffer) -> bool:
    """Whether the buffer has what a method is about."""
    if name == "rpf":
        return bool(samples.random_param_names)
    return bool(samples.feature_names) or name not in (*FEATURE_FILTERS, "lbf", "lbf_nlm")


def _try(
    name: str,
    run: Callable[[SampleBuffer], np.ndarray],
    left_out: LeftOut,
    parameters: Parameters,
    most: int | None = None,
) -> Trial:
    """Run on each rest, or on so many of them; error and time."""
    parts, seconds = [], []
    for part, rest in enumerate(left_out.rests[:most]):
        start = perf_counter()
        filtered = run(rest)
        seconds.append(perf_counter() - start)
        parts.append(tile_means(left_out.part_error(part, filtered)))
    return Trial(name, np.array(parts), statistics.median(seconds), parameters)


def _try_method(method: Method, samples: SampleBuffer, left_out: LeftOut) -> Trial:
    """Choose the bandwidths by halves of all samples, then run on each rest; a first call on a corner compiles."""
    parameters = choose_parameters(method, samples)
    method.run(samples.crop(0, 0, SMALLEST, SMALLEST), **parameters)
    return _try(method.name, lambda rest: method.run(rest, **parameters), left_out, parameters)


def _try_boxes(boxes: tuple[int, ...], whole: Trial, left_out: LeftOut) -> Trial:
    """RPF with other boxes; its default is known already."""
    name, config = " ".join(map(str, boxes)), RPFConfig.adaptive(boxes=boxes)
    if config == RPFConfig.adaptive():
        return Trial(name, whole.parts[:RPF_PARTS], whole.seconds, {})
    return _try(name, lambda rest: rpf(rest, config, progress=False), left_out, {}, RPF_PARTS)


def _drop_random_params(informations: Sequence[Information], whole: Trial, left_out: LeftOut) -> tuple[Drop, ...]:
    """RPF without each random parameter; what is kept is decided by information."""
    drops = []
    about = [one for one in informations if one.kind == "random_params"]
    for one in about:
        others = [other.name for other in about if other is not one]
        run = lambda rest, others=others: rpf(rest.select(random_params=others), progress=False)  # noqa: E731
        drops.append(_drop(whole, _try(one.name, run, left_out, {}, RPF_PARTS), one.informative))
    return tuple(drops)


def _drop(whole: Trial, without: Trial, keep: bool | None = None) -> Drop:
    """Compare with and without; kept, unless said otherwise, is what costs more than one standard error."""
    difference = (without.parts - whole.parts[: len(without.parts)]).mean(axis=0)
    behind, spread = mean_and_error(difference)
    keep = behind > spread if keep is None else keep
    return Drop(without.name, behind, spread, whole.seconds - without.seconds, keep)


def _feature_filter(methods: Sequence[Trial], chosen: int) -> Trial | None:
    """The filter that features are judged with: the one that is advised, or else the best that reads any."""
    able = [one for one in methods if one.name in FEATURE_FILTERS]
    return methods[chosen] if methods[chosen] in able else min(able, key=lambda one: one.tiles.mean(), default=None)


def drop_features(whole: Trial, left_out: LeftOut) -> tuple[Drop, ...]:
    """Take features away from a filter, the least useful first, until each that is left costs more than one standard error.

    Parameters
    ----------
    whole : trial of the filter with all features
    left_out : the samples

    Returns
    -------
    One `Drop` a feature: what it cost when it went, or would cost now.
    """
    method, names = METHODS[whole.name], list(left_out.rests[0].feature_names)
    gone: list[Drop] = []
    while True:
        left = [name for name in names if name not in [one.name for one in gone]]
        found = []
        for name in left:
            others = [other for other in left if other != name]
            found.append(_drop(whole, _try(name, _with_features(method, whole.parameters, others), left_out, {})))
        loose = [one for one in found if not one.keep]
        if not loose:
            return tuple(sorted([*gone, *found], key=lambda one: names.index(one.name)))
        gone.append(min(loose, key=lambda one: one.behind))
        left.remove(gone[-1].name)
        whole = _try(whole.name, _with_features(method, whole.parameters, left), left_out, whole.parameters)


def _with_features(
    method: Method, parameters: Parameters, names: Sequence[str]
) -> Callable[[SampleBuffer], np.ndarray]:
    """The filter with some features only, all else the same."""
    return lambda rest: method.run(rest.select(features=names), **parameters)
