"""Trace all samples of a pass at once with a vectorised (JIT) variant of Mitsuba."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mcdenoise.render.scene import ReadyScene


def trace_wavefront(
    ready: ReadyScene, names: Sequence[str], pixels: np.ndarray, width: int, seed: int
) -> dict[str, np.ndarray]:
    """Trace one sample for each entry of `pixels` and return what `names` lists.

    The draws are Mitsuba's own, in its order: film position, aperture; then a copy of the sampler draws ahead what the
    path integrator is about to draw at the first hit: light (2), lobe (1), BSDF (2). Everything fuses into one kernel.

    Parameters
    ----------
    ready : the scene, loaded under a JIT variant
    names : fields to return; "time" is skipped
    pixels : (n,) int, index of the pixel (y * width + x)
    width : of the image, pixels
    seed : of Mitsuba's sampler

    Returns
    -------
    dict of name -> (n, channels) float32
    """
    import drjit as dr
    import mitsuba as mi

    n = len(pixels)
    index = mi.UInt32(np.ascontiguousarray(pixels, np.uint32))
    height = int(ready.scene.sensors()[0].film().size()[1])
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, n)
    sensor = ready.scene.sensors()[0]
    film = mi.Point2f(index % width, index // width) + sampler.next_2d()
    lens = sampler.next_2d() if sensor.needs_aperture_sample() else mi.Point2f(0.5)
    ray, ray_weight = sensor.sample_ray_differential(0.0, 0.0, film / mi.Point2f(width, height), lens)
    ahead = sampler.clone()
    light, lobe, scatter = ahead.next_2d(), ahead.next_1d(), ahead.next_2d()
    radiance, _, _ = ready.integrator.sample(ready.scene, sampler, ray)
    first = ready.scene.ray_intersect(ray)
    values: dict[str, Any] = {
        "radiance": radiance * ray_weight,
        "screen_position": film,
        "hit": dr.select(first.is_valid(), mi.Float(1), mi.Float(0)),
    }
    values |= dict(zip(("lens_u", "lens_v", "light_u", "light_v"), (*lens, *light), strict=True))
    values |= dict(zip(("bsdf_u", "bsdf_v"), scatter, strict=True))
    values |= _surface(first, ray, names, "")
    if "visibility" in names:
        _, arriving = ready.scene.sample_emitter_direction(first, light, True, first.is_valid())
        values["visibility"] = dr.select(dr.max(arriving) > 0, mi.Float(1), mi.Float(0))
    if any(name.endswith("_2") for name in names):
        bsdf = first.bsdf(ray)
        sample, weight = bsdf.sample(mi.BSDFContext(), first, lobe, scatter, first.is_valid())
        onward = first.spawn_ray(first.to_world(sample.wo))
        second = ready.scene.ray_intersect(onward, first.is_valid() & (dr.max(weight) > 0))
        values |= _surface(second, mi.RayDifferential3f(onward), names, "_2")
    wanted = {name: values[name] for name in names if name != "time"}
    dr.eval(wanted)
    return {name: np.broadcast_to(np.atleast_2d(np.array(v)).T, (n, _channels(v))) for name, v in wanted.items()}


def _surface(si: Any, ray: Any, names: Sequence[str], suffix: str) -> dict[str, Any]:
    """Return the features of one hit that `names` asks for, zero where there is none."""
    import drjit as dr
    import mitsuba as mi

    values = {}
    if f"world_position{suffix}" in names:
        values[f"world_position{suffix}"] = si.p & si.is_valid()
    if f"shading_normal{suffix}" in names:
        values[f"shading_normal{suffix}"] = si.sh_frame.n & si.is_valid()
    if f"albedo{suffix}" in names:
        bsdf = si.bsdf(ray)
        is_diffuse = si.is_valid() & mi.has_flag(bsdf.flags(), mi.BSDFFlags.DiffuseReflection)
        values[f"albedo{suffix}"] = dr.clip(bsdf.eval_diffuse_reflectance(si, is_diffuse), 0, 1) & is_diffuse
    return values


def _channels(value: Any) -> int:
    """Return how many numbers a sample has in a Dr.Jit value: 1 for a plain array."""
    import drjit as dr

    return len(value) if dr.depth_v(value) > 1 else 1
