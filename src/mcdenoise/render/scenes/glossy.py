"""glossy: rough metal before striped walls; the detail is in the second hit.

On metal the first hit tells nothing but shape: its albedo is black and its normal smooth, while the colour
shows stripes of walls, some of them behind the camera. Only features of the second hit know those
stripes. Light that reaches a diffuse wall by way of the metal arrives rarely and strongly: fireflies.
"""

from typing import Any

from mcdenoise.render.scenes import parts
from mcdenoise.render.toyscene import ToyScene

WHITE, RED, BLUE = (0.75, 0.72, 0.66), (0.6, 0.1, 0.07), (0.08, 0.2, 0.5)
GREEN, YELLOW = (0.1, 0.38, 0.18), (0.75, 0.48, 0.08)


def build() -> dict[str, Any]:
    """Mitsuba dict of the scene, without film, sampler and integrator."""
    return {
        "type": "scene",
        "sensor": parts.pinhole_camera((0.0, -4.6, 1.8), (0.0, 0.3, 0.75), 34.5),
        "light": parts.square_light((0.0, -0.8, 3.95), (0, -0.8, 0), 2.2, (3.0, 2.85, 2.65)),
        **_walls(),
        **_metal(),
    }


def _walls() -> dict[str, Any]:
    def wall(
        center: parts.Vector, facing: parts.Vector, colour: parts.Vector, axis: str = "u", count: int = 16
    ) -> dict[str, Any]:
        return parts.rectangle(center, facing, 4, 4, bsdf=parts.diffuse(parts.stripes(WHITE, colour, count, axis)))

    return {
        "wall_back": wall((0, 2.6, 0), (0, -1, 0), BLUE),
        "wall_left": wall((-2.8, 0, 0), (1, 0, 0), RED, "v"),
        "wall_right": wall((2.8, 0, 0), (-1, 0, 0), GREEN, "v"),
        "wall_front": wall((0, -6.5, 0), (0, 1, 0), YELLOW, count=8),
        "floor": parts.floor(
            (0, -1, 0), 6, 6, parts.diffuse(parts.stripes((0.45, 0.44, 0.42), (0.2, 0.2, 0.23), 24, "v"))
        ),
        "ceiling": parts.rectangle((0, -1, 4), (0, 0, -1), 6, 6, bsdf=parts.diffuse(WHITE)),
    }


def _metal() -> dict[str, Any]:
    def rough(material: str, alpha: float) -> dict[str, Any]:
        return {"type": "roughconductor", "material": material, "distribution": "ggx", "alpha": alpha}

    return {
        "ball_left": parts.sphere((-1.05, 0.6, 0.65), 0.65, rough("Cu", 0.12)),
        "ball_middle": parts.sphere((0.0, -0.7, 0.5), 0.5, rough("Ag", 0.05)),
        "ball_right": parts.sphere((1.05, 0.5, 0.65), 0.65, rough("Au", 0.08)),
    }


SCENE = ToyScene(
    name="glossy",
    idea="On rough metal the detail is in the second hit; first-hit features are flat.",
    build=build,
    random_params=("light_u", "light_v", "bsdf_u", "bsdf_v"),
    features=(
        "world_position",
        "shading_normal",
        "albedo",
        "world_position_2",
        "shading_normal_2",
        "albedo_2",
    ),
    max_depth=4,
)
