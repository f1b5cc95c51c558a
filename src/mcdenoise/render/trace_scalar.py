"""Trace one sample after another with the scalar variant of Mitsuba: slower, but it needs no LLVM."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from mcdenoise.render.scene import ReadyScene
from mcdenoise.samples.layout import CHANNELS, FEATURES

_ALWAYS = ("radiance", "screen_position", "hit", "lens_u", "lens_v", "light_u", "light_v", "bsdf_u", "bsdf_v")
_NOTHING = (0.0, 0.0, 0.0)


def trace_scalar(
    ready: ReadyScene, names: Sequence[str], pixels: np.ndarray, width: int, seed: int
) -> dict[str, np.ndarray]:
    """Trace one sample for each entry of `pixels` and return what `names` lists.

    The same data as :func:`trace_wavefront` from a plain loop. Numbers go into one flat list, because a list takes a
    sample's numbers ten times faster than an array would.

    Parameters
    ----------
    ready : the scene, loaded under the scalar variant
    names : fields to return; "time" is skipped
    pixels : (n,) int, index of the pixel (y * width + x)
    width : of the image, pixels
    seed : of Mitsuba's sampler

    Returns
    -------
    dict of name -> (n, channels) float32
    """
    import mitsuba as mi

    scene, integrator, sensor = ready.scene, ready.integrator, ready.scene.sensors()[0]
    height = int(sensor.film().size()[1])
    has_lens = sensor.needs_aperture_sample()
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, 1)
    next_2d = sampler.next_2d
    if list(names) == ["radiance"]:
        return {"radiance": _radiance(ready, sampler, pixels, width)}
    smooth = int(mi.BSDFFlags.Smooth)
    centre = mi.Point2f(0.5)
    add_features = _feature_adder(scene, [name for name in FEATURES if name in names])
    numbers: list[float] = []
    for pixel in pixels.tolist():
        jitter = next_2d()
        x, y = pixel % width + jitter.x, pixel // width + jitter.y
        lens = next_2d() if has_lens else centre
        ray, ray_weight = sensor.sample_ray_differential(0.0, 0.0, mi.Point2f(x / width, y / height), lens)
        first = scene.ray_intersect(ray)
        ahead = sampler.clone()
        hit = first.is_valid()
        if not hit or first.bsdf(ray).flags() & smooth:
            light, lobe, scatter = ahead.next_2d(), ahead.next_1d(), ahead.next_2d()
        else:  # the scalar integrator draws no light sample on a perfect mirror
            lobe, scatter, light = ahead.next_1d(), ahead.next_2d(), ahead.next_2d()
        radiance = integrator.sample(scene, sampler, ray)[0] * ray_weight
        numbers += (*radiance, x, y, hit, *lens, *light, *scatter)
        add_features(numbers, hit, first, ray, light, lobe, scatter)
    return _columns(numbers, names, len(pixels))


def _radiance(ready: ReadyScene, sampler: Any, pixels: np.ndarray, width: int) -> np.ndarray:
    """Trace one sample for each entry of `pixels` and return nothing but its radiance, (n, 3) float32."""
    import mitsuba as mi

    scene, integrator, sensor = ready.scene, ready.integrator, ready.scene.sensors()[0]
    height = int(sensor.film().size()[1])
    has_lens, centre = sensor.needs_aperture_sample(), mi.Point2f(0.5)
    numbers: list[float] = []
    for pixel in pixels.tolist():
        jitter = sampler.next_2d()
        place = mi.Point2f((pixel % width + jitter.x) / width, (pixel // width + jitter.y) / height)
        lens = sampler.next_2d() if has_lens else centre
        ray, ray_weight = sensor.sample_ray_differential(0.0, 0.0, place, lens)
        numbers.extend(integrator.sample(scene, sampler, ray)[0] * ray_weight)
    return np.array(numbers, np.float32).reshape(-1, 3)


def _feature_adder(scene: Any, names: Sequence[str]) -> Callable[..., None]:
    """Return a function that appends the features `names` of one camera ray to a list, computing only those."""
    import mitsuba as mi

    kinds = ("world_position", "shading_normal", "albedo")
    at_first = [kind in names for kind in kinds]
    at_second = [f"{kind}_2" in names for kind in kinds]
    zeros = _NOTHING * sum(at_second)
    has_second, has_visibility = any(at_second), "visibility" in names
    diffuse, context, surface = int(mi.BSDFFlags.DiffuseReflection), mi.BSDFContext(), _surface

    def add(numbers: list[float], hit: bool, first: Any, ray: Any, light: Any, lobe: float, scatter: Any) -> None:
        if not hit:
            numbers += _NOTHING * sum(at_first) + zeros + (0.0,) * has_visibility
            return
        bsdf = first.bsdf(ray)
        surface(numbers, first, bsdf, at_first, diffuse)
        if has_second:
            sample, weight = bsdf.sample(context, first, lobe, scatter)
            onward = first.spawn_ray(first.to_world(sample.wo))
            second = scene.ray_intersect(onward) if max(weight) > 0 else None
            if second is not None and second.is_valid():
                surface(numbers, second, second.bsdf(), at_second, diffuse)
            else:
                numbers += zeros
        if has_visibility:
            numbers.append(max(scene.sample_emitter_direction(first, light, True)[1]) > 0)

    return add


def _surface(numbers: list[float], si: Any, bsdf: Any, wanted: Sequence[bool], diffuse: int) -> None:
    """Append position, normal and albedo of one hit, each if `wanted`."""
    if wanted[0]:
        numbers.extend(si.p)
    if wanted[1]:
        numbers.extend(si.sh_frame.n)
    if wanted[2]:
        if bsdf.flags() & diffuse:
            numbers.extend(bsdf.eval_diffuse_reflectance(si))
        else:
            numbers += _NOTHING


def _columns(numbers: list[float], names: Sequence[str], count: int) -> dict[str, np.ndarray]:
    """Cut the flat list into name -> (count, channels)."""
    table = np.array(numbers, np.float32).reshape(count, -1)
    widths = {name: CHANNELS[name] for name in (*_ALWAYS, *(name for name in FEATURES if name in names))}
    ends = dict(zip(widths, np.cumsum(list(widths.values())).tolist(), strict=True))
    columns = {name: table[:, ends[name] - widths[name] : ends[name]] for name in names if name != "time"}
    return {name: values.clip(0, 1) if name.startswith("albedo") else values for name, values in columns.items()}
