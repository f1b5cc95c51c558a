"""The tables of the study, for the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from mcdenoise.study.bench_rpf_accuracy import geometric_mean
from mcdenoise.study.speed_accuracy_results import (
    NOISE_FREE,
    QUANTITIES,
    UNFILTERED,
    Point,
    best_for_a_time,
    equal_spp,
    equal_time,
    error_slopes,
    front,
    growth,
    missing,
    pays_from,
    pooled,
    pooled_monte_carlo,
    scene_monte_carlo,
)

WIDTH = 44
ERROR = 1e3  # relMSE in thousandths


def error_lines(found: Mapping[str, Any], spp: int) -> list[str]:
    """Return the table of one spp: every setting pooled over the scenes, the front marked and named."""
    points, rival = pooled(found, spp), pooled_monte_carlo(found)
    on_front = [label for label, *_ in front(points.values(), rival)]
    equal, rivals = (_means(of(found, spp)) for of in (equal_spp, equal_time))
    lines = [
        f"{spp} spp, geometric means over {len(found['settings']['scenes'])} scenes",
        f"  {'':{WIDTH}} {'relMSE x 1000 (seeds)':>24} {'filter s':>9} {'total s':>8} {'equal-error':>11} "
        f"{'equal-time':>13} {'pays from':>10}",
        f"  {'':{WIDTH}} {'':>24} {'':>9} {'':>8} {'spp':>11} {'relMSE x 1000':>13} {'ms a spp':>10}",
    ]
    for label, point in points.items():
        mark = " *" if label in on_front else ""
        lines.append(f"  {label:{WIDTH}} {_row(point, equal[label], rivals[label])}{mark}")
    return [*lines, f"  front: {'; '.join(on_front)}"]


def _row(point: Point, equal: float, rival: float) -> str:
    """The numbers of one setting."""
    low, high = ERROR * min(point.per_seed), ERROR * max(point.per_seed)
    words = f"{ERROR * point.relmse:8.2f} ({low:6.2f} ..{high:6.2f})"
    if point.curve == UNFILTERED:
        return f"{words} {'':9} {point.seconds:8.4f} {equal:11.1f}"
    price = 1e3 * pays_from(point.filter_seconds, point.spp, equal)
    pays = f"{price:10.2f}" if price < float("inf") else f"{'never':>10}"
    return f"{words} {point.filter_seconds:9.4f} {point.seconds:8.4f} {equal:11.1f} {ERROR * rival:13.2f} {pays}"


def _means(by_scene: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
    """Geometric means over the scenes."""
    return {label: geometric_mean(list(scenes.values())) for label, scenes in by_scene.items()}


def monte_carlo_lines(found: Mapping[str, Any]) -> list[str]:
    """Return what rendering costs and how its error falls, scene by scene."""
    settings = found["settings"]
    spp, most = max(settings["spps"]), settings["reference_spp"] / NOISE_FREE
    lines = [
        f"Monte Carlo; slope: exponent of relMSE over spp, up to {most:g} spp; reference noise: what the reference of "
        f"{settings['reference_spp']} spp adds to every relMSE",
        f"  {'':{WIDTH}} {'before the first sample s':>26} {'ms a spp':>9} {'slope':>7} {'reference noise x 1000':>23}",
    ]
    for scene in settings["scenes"]:
        rival = scene_monte_carlo(found, scene)
        own = rival.relmse[list(rival.spp).index(spp)] * spp / settings["reference_spp"]
        lines.append(
            f"  {scene:{WIDTH}} {rival.fixed_seconds:26.3f} {1e3 * rival.seconds_per_spp:9.2f} "
            f"{rival.slope(most):7.2f} {ERROR * own:23.2f}"
        )
    rival = pooled_monte_carlo(found)
    return [*lines, f"  {'pooled':{WIDTH}} {'':26} {1e3 * rival.seconds_per_spp:9.2f} {rival.slope(most):7.2f}"]


def budget_lines(found: Mapping[str, Any]) -> list[str]:
    """Return the Pareto front over all settings and all spp: the best that a time can buy."""
    lines = [
        "the best for a time, over all settings and spp, pooled",
        f"  {'':{WIDTH}} {'spp':>5} {'total s':>9} {'relMSE x 1000':>14}",
    ]
    for point in best_for_a_time(found):
        name = "Monte Carlo" if point.curve == UNFILTERED else point.label
        lines.append(f"  {name:{WIDTH}} {point.spp:5d} {point.seconds:9.4f} {ERROR * point.relmse:14.2f}")
    return lines


def slope_lines(found: Mapping[str, Any]) -> list[str]:
    """Return the exponents of relMSE over spp of every method, pooled and scene by scene."""
    scenes, spps = found["settings"]["scenes"], found["settings"]["spps"]
    lines = [
        f"exponent of relMSE over spp, {spps[0]} to {spps[-1]} spp, of the usual setting (plain Monte Carlo: -1)",
        f"  {'':{WIDTH}} {'pooled':>12}" + "".join(f"{scene:>13}" for scene in scenes),
    ]
    for curve, slopes in error_slopes(found).items():
        numbers = "".join(f"{slopes[scene]:13.2f}" for scene in scenes)
        lines.append(f"  {curve:{WIDTH}} {slopes['']:12.2f}{numbers}")
    return lines


def growth_lines(found: Mapping[str, Any]) -> list[str]:
    """Return the exponents of time over pixels, spp and the width of the window."""
    tables = {quantity: growth(found, quantity) for quantity in QUANTITIES}
    exponents: dict[str, dict[str, float]] = {}
    for quantity, rows in tables.items():
        for label, _, _, _, exponent in rows:
            exponents.setdefault(label, {})[quantity] = exponent
    spans = {quantity: _span(rows[0][2]) for quantity, rows in tables.items()}
    lines = [
        f"exponent of filter seconds over pixels ({spans['pixels']}), spp ({spans['spp']}), and the width of the window "
        f"({spans['window']} pixels, RPF its one box)",
        f"  {'':{WIDTH}}" + "".join(f"{quantity:>13}" for quantity in QUANTITIES),
    ]
    for label, found_exponents in exponents.items():
        cells = (found_exponents.get(quantity) for quantity in QUANTITIES)
        lines.append(f"  {label:{WIDTH}}" + "".join(f"{'-' if one is None else f'{one:.2f}':>13}" for one in cells))
    return lines


def _span(values: Sequence[float]) -> str:
    """From the first to the last.

    Examples
    --------
    >>> _span([4096.0, 65536.0])
    '4096 .. 65536'
    """
    return f"{values[0]:.0f} .. {values[-1]:.0f}"


def all_lines(found: Mapping[str, Any]) -> list[str]:
    """Return every table of the study."""
    settings = found["settings"]
    choosing = sum(entry.get("choose_seconds", 0.0) for entry in found["entries"].values())
    lines = [
        f"Speed against accuracy, {settings['size']}x{settings['size']}, {settings['seeds']} seeds, {found['cores']} cores, "
        f"reference {settings['reference_spp']} spp",
        "Total seconds: rendering the samples and filtering them, without what a render costs before its first sample.",
        "Equal-error spp: Monte Carlo samples that reach the same relMSE. Equal-time relMSE: of Monte Carlo in the same total.",
        "Pays from: the rendering milliseconds a spp from which the filter beats more samples. *: on the Pareto front.",
        f"Bandwidths are chosen by halves of the samples, on a seed that is not judged; the label names the dial of time. "
        f"Choosing took {choosing:.0f} s, which nobody is charged for.",
        "",
    ]
    for spp in settings["spps"]:
        lines += [*error_lines(found, spp), ""]
    lines += [*budget_lines(found), "", *monte_carlo_lines(found), "", *slope_lines(found), "", *growth_lines(found)]
    absent = missing(found)
    return [*lines, "", *(f"not installed: {label}" for label in absent)] if absent else lines
