"""Motion as the random parameter `time`: the open shutter is cut into slices, and the scene is posed once for each.

Mitsuba 3 has no motion blur. Here a time is one of `TIME_SLICES` equally likely instants (k + 0.5) / TIME_SLICES; the
recorded time of a sample is exactly the instant at which it was rendered. The reference uses the same instants, so samples
and reference have the same expectation. A ball that crosses 40 pixels moves by 0.16 pixels from slice to slice.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

TIME_SLICES = 256


def slice_time(index: int) -> float:
    """Return the instant of a slice, in (0, 1).

    Examples
    --------
    >>> slice_time(0) * TIME_SLICES
    0.5
    """
    return (index + 0.5) / TIME_SLICES


def draw_slices(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return the slice of each of `count` samples, (count,) int: independent and uniform.

    Examples
    --------
    >>> draw_slices(np.random.default_rng(0), 3).shape
    (3,)
    """
    return rng.integers(0, TIME_SLICES, count)


def spread_slices(rng: np.random.Generator, spp: int) -> np.ndarray:
    """Return how many of `spp` samples fall into each slice, (TIME_SLICES,) int: one at random in each of `spp` strata.

    Every sample is uniform over the slices of its stratum, all strata together are uniform over all slices, so an image
    with these counts has the expectation of one with independent times, and less noise.

    Examples
    --------
    >>> int(spread_slices(np.random.default_rng(0), 512).min())
    2
    """
    instants = (np.arange(spp) + rng.random(spp)) / spp
    slices = np.minimum((instants * TIME_SLICES).astype(int), TIME_SLICES - 1)  # rounding may reach 1.0
    return np.bincount(slices, minlength=TIME_SLICES)


class Poser:
    """Puts the moving objects of a loaded scene where they are at a time.

    Parameters
    ----------
    scene : Mitsuba scene. It is changed in place: after `at(t)` whatever is rendered shows time t.
    motion : object key -> displacement (scene units) while time goes from 0 to 1; centred at time 0.5.

    Raises
    ------
    ValueError
        If the scene has no such object, or it can not be moved (no transform, no vertices).
    """

    def __init__(self, scene: Any, motion: Mapping[str, tuple[float, float, float]]) -> None:
        import mitsuba as mi

        self._params = mi.traverse(scene)
        self._rest = []
        for key, displacement in motion.items():
            name = next((n for n in (f"{key}.to_world", f"{key}.vertex_positions") if n in self._params), None)
            if name is None:
                ends = (".to_world", ".vertex_positions")
                movable = sorted({n.split(".")[0] for n in self._params.keys() if n.endswith(ends)})  # noqa: SIM118
                raise ValueError(f"motion names {key!r}, which can not be moved; what can: {', '.join(movable)}.")
            value = self._params[name]
            # A copy: what traverse gives is the live value, which changes with every pose.
            value = np.array(value).reshape(-1, 3) if name.endswith("positions") else type(value)(value)
            self._rest.append((name, value, [float(d) for d in displacement]))

    def at(self, time: float) -> None:
        """Pose the scene at `time` in [0, 1]."""
        import drjit as dr
        import mitsuba as mi

        for name, rest, displacement in self._rest:
            step = [(time - 0.5) * d for d in displacement]
            if isinstance(rest, np.ndarray):
                self._params[name] = type(self._params[name])((rest + np.float32(step)).ravel())
            else:
                opaque = [dr.opaque(mi.Float, s) for s in step]  # a literal would compile a kernel for every pose
                self._params[name] = type(rest)().translate(mi.Vector3f(opaque)) @ rest
        self._params.update()
