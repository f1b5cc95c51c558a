"""dof: a thin lens; what is out of focus has noisy features.

A row of textured balls recedes over a checker floor; the middle one is sharp. Behind them small lamps
blur to bright discs (bokeh). A first-hit feature of a defocused pixel is as noisy as its colour, so it cannot say
which neighbours are alike: the case that random parameter filtering was made for.
"""

from typing import Any

from mcdenoise.render.scenes import parts
from mcdenoise.render.toyscene import ToyScene

CAMERA = {"origin": (0.0, -5.4, 1.7), "target": (0.0, 0.4, 0.68), "fov": 34.0}
LENS = {"aperture_radius": 0.22, "focus_distance": 5.3}

CREAM = (0.75, 0.68, 0.55)
RED, BLUE, GREEN, YELLOW = (0.62, 0.07, 0.05), (0.05, 0.14, 0.5), (0.06, 0.34, 0.12), (0.75, 0.45, 0.05)


def build() -> dict[str, Any]:
    """Mitsuba dict of the scene with its thin lens, without film, sampler and integrator."""
    return {
        "type": "scene",
        "sensor": parts.thin_lens_camera(**CAMERA, **LENS),
        **stage(),
    }


def stage() -> dict[str, Any]:
    """Everything but the camera: balls, floor, wall, main light and lamps."""
    return {**_balls(), **_room(), **_lamps()}


def _balls() -> dict[str, Any]:
    return {
        "ball_near": parts.sphere((0.85, -2.3, 0.4), 0.4, parts.diffuse(parts.stripes(CREAM, RED, 12)), (25, 15, 0)),
        "ball_left": parts.sphere((-0.9, -0.8, 0.5), 0.5, parts.diffuse(parts.checker(CREAM, GREEN, 12, 6))),
        "ball_focus": parts.sphere((0.1, 0.1, 0.6), 0.6, parts.diffuse(parts.checker(CREAM, BLUE, 16, 8)), (20, 20, 0)),
        "ball_right": parts.sphere(
            (1.45, 1.7, 0.6), 0.6, parts.diffuse(parts.stripes(CREAM, RED, 8, "v")), (30, -30, 0)
        ),
        "ball_far": parts.sphere((-1.1, 3.4, 0.7), 0.7, parts.diffuse(parts.stripes(CREAM, YELLOW, 14)), (-30, 20, 0)),
    }


def _room() -> dict[str, Any]:
    tiles = parts.checker((0.55, 0.52, 0.48), (0.16, 0.17, 0.2), 40, 40)
    return {
        "floor": parts.floor((0, 4, 0), 12, 12, parts.diffuse(tiles)),
        "wall": parts.rectangle((0, 12, 0), (0, -1, 0), 16, 10, bsdf=parts.diffuse((0.13, 0.16, 0.27))),
        "light": parts.square_light((-3.2, -6.0, 7.6), (0, 1.0, 0), 1.7, (32.0, 30.3, 27.2)),
    }


def _lamps() -> dict[str, Any]:
    """Small bright balls, dim as lights: a low `sampling_weight` keeps light samples for the main light."""
    places = [(-2.7, 2.35), (-1.5, 1.7), (-0.2, 2.5), (1.0, 1.9), (2.2, 2.6), (3.1, 1.6)]
    tints = [(1.0, 0.75, 0.4), (1.0, 0.5, 0.3), (0.5, 0.7, 1.0)]
    return {f"lamp_{i}": _lamp((x, 7.5, z), tints[i % len(tints)]) for i, (x, z) in enumerate(places)}


def _lamp(center: parts.Vector, tint: parts.Vector) -> dict[str, Any]:
    radiance = parts.rgb(tuple(3.5 * channel for channel in tint))
    emitter = {"type": "area", "radiance": radiance, "sampling_weight": 0.003}
    return parts.sphere(center, 0.13, parts.diffuse((0, 0, 0))) | {"emitter": emitter}


SCENE = ToyScene(
    name="dof",
    idea="Out of focus the features are as noisy as the colour.",
    build=build,
    random_params=("lens_u", "lens_v", "light_u", "light_v"),
    features=("world_position", "shading_normal", "albedo"),
    max_depth=2,
)
