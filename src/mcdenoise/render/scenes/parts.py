"""Pieces the toy scenes share: cameras, a light, diffuse colours and two-colour patterns.

Units are scene units; x points right, y away from the camera, z up. Colours are scene-linear RGB.
Mitsuba is imported inside the functions, so that importing a scene stays free of it; each function
returns a fresh dict that Mitsuba's ``load_dict`` understands, and needs a variant to be set.
"""

from typing import Any

Vector = tuple[float, float, float]


def pinhole_camera(origin: Vector, target: Vector, fov: float) -> dict[str, Any]:
    """Perspective camera; `fov` in degrees spans the shorter image side, so any aspect ratio shows the scene."""
    import mitsuba as mi

    to_world = mi.ScalarTransform4f().look_at(origin=list(origin), target=list(target), up=[0, 0, 1])
    return {"type": "perspective", "fov": fov, "fov_axis": "smaller", "to_world": to_world}


def thin_lens_camera(
    origin: Vector, target: Vector, fov: float, aperture_radius: float, focus_distance: float
) -> dict[str, Any]:
    """Return `pinhole_camera` with a lens: points at `focus_distance` along the axis are sharp, others blur."""
    lens = {"type": "thinlens", "aperture_radius": aperture_radius, "focus_distance": focus_distance}
    return pinhole_camera(origin, target, fov) | lens


def diffuse(reflectance: Vector | dict[str, Any]) -> dict[str, Any]:
    """Lambertian surface of one colour or of a texture."""
    return {"type": "diffuse", "reflectance": reflectance if isinstance(reflectance, dict) else rgb(reflectance)}


def rgb(colour: Vector) -> dict[str, Any]:
    """One scene-linear colour."""
    return {"type": "rgb", "value": list(colour)}


def checker(colour_0: Vector, colour_1: Vector, cells_u: float, cells_v: float) -> dict[str, Any]:
    """Two-colour checkerboard, `cells_u` by `cells_v` cells over the unit square of surface coordinates."""
    import mitsuba as mi

    return {
        "type": "checkerboard",
        "color0": rgb(colour_0),
        "color1": rgb(colour_1),
        "to_uv": mi.ScalarTransform4f().scale([cells_u / 2, cells_v / 2, 1]),
    }


def stripes(colour_0: Vector, colour_1: Vector, count: float, axis: str = "u") -> dict[str, Any]:
    """`count` stripes, alternating in the surface coordinate `axis`: a checkerboard of less than one cell across."""
    across = 0.98
    return checker(colour_0, colour_1, *((count, across) if axis == "u" else (across, count)))


def sphere(center: Vector, radius: float, bsdf: dict[str, Any], turn: Vector = (0.0, 0.0, 0.0)) -> dict[str, Any]:
    """Sphere; `turn` (degrees about x, then y, then z) shows another side of its texture."""
    import mitsuba as mi

    to_world = mi.ScalarTransform4f().translate(list(center))
    for axis, angle in zip(([0, 0, 1], [0, 1, 0], [1, 0, 0]), reversed(turn), strict=True):
        to_world = to_world @ mi.ScalarTransform4f().rotate(axis, angle)
    return {"type": "sphere", "to_world": to_world @ mi.ScalarTransform4f().scale(radius), "bsdf": bsdf}


def rectangle(center: Vector, facing: Vector, half_width: float, half_height: float, **surface: Any) -> dict[str, Any]:
    """Rectangle about `center` with its normal along `facing`; `surface` is its ``bsdf`` or ``emitter``."""
    import mitsuba as mi

    target = [c + f for c, f in zip(center, facing, strict=True)]
    upright = abs(facing[2]) < 0.99 * sum(f * f for f in facing) ** 0.5
    to_world = mi.ScalarTransform4f().look_at(
        origin=list(center), target=target, up=[0, 0, 1] if upright else [0, 1, 0]
    ) @ mi.ScalarTransform4f().scale([half_width, half_height, 1])
    return {"type": "rectangle", "to_world": to_world, **surface}


def floor(center: Vector, half_width: float, half_height: float, bsdf: dict[str, Any]) -> dict[str, Any]:
    """Horizontal rectangle that faces up."""
    return rectangle(center, (0, 0, 1), half_width, half_height, bsdf=bsdf)


def square_light(center: Vector, target: Vector, half_size: float, radiance: Vector) -> dict[str, Any]:
    """One-sided square area light that looks at `target`; the unseen side and the surface itself are black."""
    facing = (target[0] - center[0], target[1] - center[1], target[2] - center[2])
    emitter = {"type": "area", "radiance": rgb(radiance)}
    return rectangle(center, facing, half_size, half_size, bsdf=diffuse((0, 0, 0)), emitter=emitter)
