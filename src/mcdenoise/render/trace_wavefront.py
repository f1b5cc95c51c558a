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
    path integrator is about to draw at the first hit: light (2), lobe (1), BSDF (2). Everything fuses into one kernel;
    the size of the image is opaque to it, so that one compilation serves all sizes.

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
    sensor = ready.scene.sensors()[0]
    index, columns = mi.UInt32(np.ascontiguousarray(pixels, np.uint32)), dr.opaque(mi.UInt32, width)
    scale = [dr.opaque(mi.Float, float(np.float32(1) / np.float32(side))) for side in sensor.film().size()]
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, n)
    film = mi.Point2f(index % columns, index // columns) + sampler.next_2d()
    lens = sampler.next_2d() if sensor.needs_aperture_sample() else mi.Point2f(0.5)
    ray, ray_weight = sensor.sample_ray_differential(0.0, 0.0, film * mi.Point2f(scale), lens)
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
    return {name: _as_table(value, n) for name, value in wanted.items()}


def _as_table(value: Any, n: int) -> np.ndarray:
    """Return an evaluated Dr.Jit number or vector as (n, channels); literals are as wide as the others."""
    import drjit as dr

    channels = list(value) if dr.depth_v(value) > 1 else [value]  # one by one: they are in memory, no kernel is needed
    return np.stack([np.broadcast_to(np.array(channel), n) for channel in channels], axis=1)


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
