"""soft_shadow: a fence under one square light; all noise is in the penumbra.

Direct light only, diffuse surfaces, a pinhole: a light sample is either blocked or not, and only where that
depends on the point of the light is there any noise to remove. The penumbra widens with the distance from the slat
that casts it, so no single filter width fits; colour and normal of the floor say nothing about it.
"""

from typing import Any

from mcdenoise.render.scenes import parts
from mcdenoise.render.toyscene import ToyScene

LIGHT_CENTER = (-6.4, -3.6, 6.4)
LIGHT_HALF_SIZE = 0.9
SLAT_COLOURS = ((0.7, 0.3, 0.16), (0.72, 0.5, 0.2), (0.3, 0.45, 0.28), (0.2, 0.4, 0.5), (0.3, 0.28, 0.5))


def build() -> dict[str, Any]:
    """Mitsuba dict of the scene, without film, sampler and integrator."""
    return {
        "type": "scene",
        "sensor": parts.pinhole_camera((2.2, -6.0, 5.0), (0.2, 0.3, 0.35), 31.0),
        "light": parts.square_light(LIGHT_CENTER, (0, 0, 0), LIGHT_HALF_SIZE, (115.0, 108.0, 98.0)),
        "floor": parts.floor((0, 0, 0), 40, 40, parts.diffuse((0.6, 0.58, 0.54))),
        **{f"slat_{i}": _slat(i, colour) for i, colour in enumerate(SLAT_COLOURS)},
    }


def _slat(index: int, colour: parts.Vector) -> dict[str, Any]:
    """Upright board; the row runs away from the camera, so that the shadows fall side by side."""
    import mitsuba as mi

    half_height = 0.5 + 0.07 * index
    to_world = mi.ScalarTransform4f().translate([-0.7, -1.5 + 0.75 * index, half_height])
    to_world = to_world @ mi.ScalarTransform4f().scale([0.07, 0.2, half_height])
    return {"type": "cube", "to_world": to_world, "bsdf": parts.diffuse(colour)}


SCENE = ToyScene(
    name="soft_shadow",
    idea="All noise is in the penumbra, and the penumbra widens with distance.",
    build=build,
    random_params=("light_u", "light_v"),
    features=("world_position", "shading_normal", "albedo", "visibility"),
    max_depth=2,
)
