"""motion: one fast and one slow ball; time is a random parameter.

While the shutter is open the red ball crosses a quarter of the picture and the blue ball moves by a sixth of its
radius. Along the path every sample of a pixel sees another instant: its features are as noisy as its colour,
and so is the moving shadow, where the features do not move at all. The still floor beside them is clean.
"""

from typing import Any

from mcdenoise.render.scenes import parts
from mcdenoise.render.toyscene import ToyScene

CREAM, RED, BLUE = (0.75, 0.68, 0.55), (0.66, 0.09, 0.05), (0.06, 0.16, 0.52)


def build() -> dict[str, Any]:
    """Mitsuba dict of the scene at mid-exposure, without film, sampler and integrator."""
    tiles = parts.checker((0.58, 0.56, 0.52), (0.2, 0.21, 0.24), 44, 44)
    return {
        "type": "scene",
        "sensor": parts.pinhole_camera((0.0, -5.4, 3.2), (0.0, 0.1, 0.45), 34.0),
        "light": parts.square_light((-2.6, -3.0, 9.0), (0, 0, 0), 1.3, (46.0, 43.5, 40.0)),
        "floor": parts.floor((0, 0, 0), 14, 14, parts.diffuse(tiles)),
        "wall": parts.rectangle((0, 13, 0), (0, -1, 0), 16, 12, bsdf=parts.diffuse((0.2, 0.21, 0.24))),
        "ball_fast": parts.sphere(
            (0.15, -0.75, 0.45), 0.45, parts.diffuse(parts.checker(CREAM, RED, 12, 6)), (20, 15, 0)
        ),
        "ball_slow": parts.sphere(
            (0.1, 1.25, 0.7), 0.7, parts.diffuse(parts.checker(CREAM, BLUE, 14, 7)), (20, -15, 0)
        ),
    }


SCENE = ToyScene(
    name="motion",
    idea="Time blurs colour and features alike: one ball moves fast, one slowly.",
    build=build,
    random_params=("time", "light_u", "light_v"),
    features=("world_position", "shading_normal", "albedo", "visibility"),
    max_depth=2,
    motion={"ball_fast": (0.9, 0.0, 0.0), "ball_slow": (0.12, 0.0, 0.0)},
)
