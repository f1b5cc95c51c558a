"""What the study found, from its stored numbers: points of one scene and pooled ones, fronts, what equal error costs, slopes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdenoise.study.bench_rpf_accuracy import geometric_mean
from mcdenoise.study.bench_scaling import power_law
from mcdenoise.study.front import equal_error_spp, equal_time_error, pareto_front

UNFILTERED = "unfiltered"
QUANTITIES = ("pixels", "spp", "window")
NOISE_FREE = 16  # Monte Carlo's slope is fitted where the reference has at least so many times its spp


@dataclass(frozen=True)
class Point:
    """One setting of one method at one spp, on one scene or pooled over scenes.

    Attributes
    ----------
    curve, setting : labels of the method and of what its dial is set to
    usual : it stands for the method where there is room for one setting
    peer : it comes from somebody else
    spp : samples per pixel that it filters
    render_seconds : of those samples, without what a render costs before its first sample
    filter_seconds : samples in, image out; 0 for the unfiltered image
    per_seed : relMSE of each seed

    Examples
    --------
    >>> point = Point("Gaussian", "radius 9", True, False, 8, 0.02, 0.01, (0.01, 0.04))
    >>> point.label, round(point.seconds, 3), round(point.relmse, 3)
    ('Gaussian, radius 9', 0.03, 0.02)
    """

    curve: str
    setting: str
    usual: bool
    peer: bool
    spp: int
    render_seconds: float
    filter_seconds: float
    per_seed: tuple[float, ...]

    @property
    def label(self) -> str:
        """Method and setting."""
        return f"{self.curve}, {self.setting}" if self.setting else self.curve

    @property
    def seconds(self) -> float:
        """Rendering the samples and filtering them."""
        return self.render_seconds + self.filter_seconds

    @property
    def relmse(self) -> float:
        """Geometric mean over the seeds."""
        return geometric_mean(self.per_seed)


@dataclass(frozen=True, eq=False)
class MonteCarlo:
    """Plain Monte Carlo, on one scene or pooled over scenes.

    Attributes
    ----------
    spp : (n,), ascending
    per_seed : (n, seeds) relMSE
    fixed_seconds : what a render costs before its first sample; 0 where pooled
    seconds_per_spp : of every sample per pixel
    """

    spp: np.ndarray
    per_seed: np.ndarray
    fixed_seconds: float
    seconds_per_spp: float

    @property
    def relmse(self) -> np.ndarray:
        """(n,), geometric means over the seeds."""
        return np.exp(np.log(self.per_seed).mean(axis=1))

    @property
    def seconds(self) -> np.ndarray:
        """(n,), of the samples."""
        return self.spp * self.seconds_per_spp

    def slope(self, most_spp: float) -> float:
        """Return the exponent of relMSE over spp, fitted up to `most_spp`; -1 is the law."""
        kept = self.spp <= most_spp
        return power_law(self.spp[kept], self.relmse[kept])[1]


def scene_points(found: Mapping[str, Any], scene: str, spp: int) -> dict[str, Point]:
    """Return label -> point of one scene at one spp: the unfiltered image, then every setting in the order of its method.

    Raises
    ------
    ValueError
        If the study has no such entry.
    """
    entry, cost = _entry(found, f"{scene}, {spp} spp"), scene_monte_carlo(found, scene).seconds_per_spp * spp
    points = [Point(UNFILTERED, "", True, False, spp, cost, 0.0, tuple(entry["unfiltered"]))]
    for row in entry["rows"]:
        names = (row["label"], row["setting"], row["usual"], row["peer"])
        points.append(Point(*names, spp, cost, row["seconds"], tuple(row["relmse"])))
    return {point.label: point for point in points}


def scene_monte_carlo(found: Mapping[str, Any], scene: str) -> MonteCarlo:
    """Return what the study found about Monte Carlo on one scene."""
    entry = _entry(found, f"{scene}, Monte Carlo")
    spp, per_seed = np.array(entry["spp"], float), np.array(entry["relmse"], float)
    return MonteCarlo(spp, per_seed, entry["fixed_seconds"], entry["seconds_per_spp"])


def pooled(found: Mapping[str, Any], spp: int) -> dict[str, Point]:
    """Return label -> point at one spp: geometric means over the scenes, of seconds and of each seed's relMSE.

    Halving the error counts the same in every scene. A setting that one scene lacks is left out.
    """
    scenes = [scene_points(found, scene, spp) for scene in found["settings"]["scenes"]]
    everywhere = [label for label in scenes[0] if all(label in points for points in scenes)]
    return {label: _mean_point([points[label] for points in scenes]) for label in everywhere}


def pooled_monte_carlo(found: Mapping[str, Any]) -> MonteCarlo:
    """Return Monte Carlo over all scenes, geometric means."""
    scenes = [scene_monte_carlo(found, scene) for scene in found["settings"]["scenes"]]
    per_seed = np.exp(np.mean([np.log(one.per_seed) for one in scenes], axis=0))
    return MonteCarlo(scenes[0].spp, per_seed, 0.0, geometric_mean([one.seconds_per_spp for one in scenes]))


def front(points: Iterable[Point], rival: MonteCarlo) -> list[tuple[str, float, float]]:
    """Return label, seconds and relMSE of what is on the Pareto front of the points and of Monte Carlo, fastest first.

    Examples
    --------
    >>> rival = MonteCarlo(np.array([8, 16]), np.array([[0.04], [0.02]]), 0.0, 0.01)
    >>> blur = Point("blur", "", True, False, 8, 0.08, 0.05, (0.01,))
    >>> [label for label, *_ in front([blur], rival)]
    ['Monte Carlo 8 spp', 'blur']
    """
    everybody = [(one.label, one.seconds, one.relmse) for one in points if one.curve != UNFILTERED]
    renders = zip(rival.spp, rival.seconds, rival.relmse, strict=True)
    everybody += [(f"Monte Carlo {spp:.0f} spp", float(seconds), float(error)) for spp, seconds, error in renders]
    kept = pareto_front(np.array([one[1] for one in everybody]), np.array([one[2] for one in everybody]))
    return sorted((one for one, on in zip(everybody, kept, strict=True) if on), key=lambda one: one[1])


def best_for_a_time(found: Mapping[str, Any]) -> list[Point]:
    """Return the Pareto front over all settings and all spp, pooled, fastest first; Monte Carlo counts as unfiltered."""
    spps, rival = found["settings"]["spps"], pooled_monte_carlo(found)
    points = [point for spp in spps for point in pooled(found, spp).values() if point.curve != UNFILTERED]
    for spp, seconds, per_seed in zip(rival.spp, rival.seconds, rival.per_seed, strict=True):
        points.append(Point(UNFILTERED, "", True, False, int(spp), float(seconds), 0.0, tuple(per_seed.tolist())))
    kept = pareto_front(np.array([one.seconds for one in points]), np.array([one.relmse for one in points]))
    return sorted((one for one, on in zip(points, kept, strict=True) if on), key=lambda one: one.seconds)


def equal_spp(found: Mapping[str, Any], spp: int) -> dict[str, dict[str, float]]:
    """Return label -> scene -> how many Monte Carlo samples per pixel reach the relMSE of the filtered image.

    Both errors are measured against one reference, whose own noise is in both: it cancels.
    """

    def one(point: Point, rival: MonteCarlo) -> float:
        return equal_error_spp(point.relmse, rival.spp, rival.relmse)

    return _by_scene(found, spp, one)


def equal_time(found: Mapping[str, Any], spp: int) -> dict[str, dict[str, float]]:
    """Return label -> scene -> the relMSE of Monte Carlo that takes as long as rendering and filtering."""

    def one(point: Point, rival: MonteCarlo) -> float:
        fixed = rival.fixed_seconds
        return equal_time_error(fixed + point.seconds, fixed, rival.seconds_per_spp, rival.spp, rival.relmse)

    return _by_scene(found, spp, one)


def pays_from(filter_seconds: float, spp: int, equal: float) -> float:
    """Return the rendering seconds a spp from which filtering beats more samples; infinite if it never does.

    Monte Carlo needs `equal` - spp more samples for the error that the filter reaches in `filter_seconds`.

    Examples
    --------
    >>> pays_from(0.4, 8, 48.0), pays_from(0.4, 8, 7.0)
    (0.01, inf)
    """
    return filter_seconds / (equal - spp) if equal > spp else float("inf")


def error_slopes(found: Mapping[str, Any]) -> dict[str, dict[str, float]]:
    """Return method -> scene -> the exponent of relMSE over spp of its usual setting; the scene "" is all of them pooled."""
    spps = found["settings"]["spps"]
    slopes: dict[str, dict[str, float]] = {curve: {} for curve in usual_errors(found)}
    for scene in ("", *found["settings"]["scenes"]):
        errors = usual_errors(found, scene)
        for curve, of_scene in slopes.items():
            of_scene[scene] = power_law(spps, [geometric_mean(seeds) for seeds in errors[curve]])[1]
    return slopes


def usual_errors(found: Mapping[str, Any], scene: str = "") -> dict[str, list[tuple[float, ...]]]:
    """Return method -> relMSE of each seed at every spp, of its usual setting; on one scene, or "": pooled."""
    spps = found["settings"]["spps"]
    tables = [scene_points(found, scene, spp) if scene else pooled(found, spp) for spp in spps]
    usual = [{point.curve: point.per_seed for point in table.values() if point.usual} for table in tables]
    return {curve: [at[curve] for at in usual] for curve in usual[0] if all(curve in at for at in usual)}


def growth(found: Mapping[str, Any], quantity: str) -> list[tuple[str, bool, np.ndarray, np.ndarray, float]]:
    """Return label, whether a peer, values, seconds and the fitted exponent of every method, as one quantity grows."""
    rows = []
    for row in _entry(found, f"growth with {quantity}")["rows"]:
        values, seconds = np.array(row["values"], float), np.array(row["seconds"], float)
        sides = 2 * values + 1 if quantity == "window" else values
        rows.append((row["label"], row["peer"], sides, seconds, power_law(sides, seconds)[1]))
    return rows


def missing(found: Mapping[str, Any]) -> list[str]:
    """Return the labels of peers that were not installed in any of the entries."""
    return sorted({label for entry in found["entries"].values() for label in entry.get("missing", ())})


def _entry(found: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """One entry of the study."""
    if name not in found["entries"]:
        raise ValueError(
            f"The study speed-accuracy lacks its entry {name!r}. Run it to its end, with the same settings."
        )
    return found["entries"][name]


def _mean_point(points: Sequence[Point]) -> Point:
    """Geometric means over scenes; the filter's seconds are what is left of the total."""
    first = points[0]
    render = geometric_mean([one.render_seconds for one in points])
    filtering = geometric_mean([one.filter_seconds for one in points]) if first.filter_seconds else 0.0
    per_seed = np.exp(np.mean([np.log(one.per_seed) for one in points], axis=0)).tolist()
    return Point(first.curve, first.setting, first.usual, first.peer, first.spp, render, filtering, tuple(per_seed))


def _by_scene(
    found: Mapping[str, Any], spp: int, call: Callable[[Point, MonteCarlo], float]
) -> dict[str, dict[str, float]]:
    """Label -> scene -> what a function finds for the point and for Monte Carlo there."""
    result: dict[str, dict[str, float]] = {}
    for scene in found["settings"]["scenes"]:
        rival = scene_monte_carlo(found, scene)
        for label, point in scene_points(found, scene, spp).items():
            result.setdefault(label, {})[scene] = call(point, rival)
    return result
