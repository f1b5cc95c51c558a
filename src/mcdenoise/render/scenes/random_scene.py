"""random_scene: as many different small scenes as wanted, to train a filter on (chapter 09).

A seed is a scene. All numbers are drawn here, with NumPy alone; Mitsuba comes in when the scene is built. What kind of scene
it is does not depend on luck: of any 70 seeds in a row 35 have a thin lens, 28 rough metal, 10 motion (its 256 poses take
time), and all 8 combinations occur; of any 20, 10 have a lens, 8 metal, 2 or 3 motion. The rest is drawn.
"""

import math
from dataclasses import replace

import numpy as np

from mcdenoise.render.scenes.parts import Vector
from mcdenoise.render.scenes.random_exposure import exposed
from mcdenoise.render.scenes.random_layout import between, lamps_drawn, lights_drawn, objects_drawn, room_drawn
from mcdenoise.render.scenes.random_parts import Ball, Box, Camera, Plan
from mcdenoise.render.toyscene import ToyScene
from mcdenoise.samples.gate import check_count

STREAMS = ("camera", "objects", "lights", "lamps", "room", "lens", "exposure", "motion")
FEATURES = ("world_position", "shading_normal", "albedo", "albedo_2", "visibility")


def random_kind(seed: int) -> frozenset[str]:
    """Return what is special about the scene of `seed`: any of ``"lens"``, ``"metal"``, ``"motion"``.

    Examples
    --------
    >>> sorted(random_kind(17)), sorted(random_kind(0))
    (['lens', 'metal', 'motion'], [])
    """
    has = {"lens": seed % 2 == 1, "metal": seed % 5 in (1, 2), "motion": seed % 7 == 3}
    return frozenset(name for name, is_so in has.items() if is_so)


def random_scene(seed: int) -> ToyScene:
    """Draw a scene of floor, walls, 3 to 9 balls and boxes, and one or two square lights.

    Parameters
    ----------
    seed : int, at least 0. The same seed is the same scene; its kind is that of :func:`random_kind`.

    Returns
    -------
    ToyScene
        Named ``random_<seed>``. It records the five features that LBF's network uses, and the random parameters that the
        scene has: light always, lens, time and BSDF by kind. Paths have 2 segments, with metal 3 or 4. The picture's
        mean radiance is about 0.2 to 0.5.

    Raises
    ------
    ValueError
        If `seed` is no whole number or below 0.

    Examples
    --------
    >>> scene = random_scene(17)
    >>> scene.name, scene.random_params
    ('random_17', ('lens_u', 'lens_v', 'time', 'light_u', 'light_v', 'bsdf_u', 'bsdf_v'))
    >>> random_scene(17) == scene
    True
    """
    seed = check_count(seed, "seed", least=0)
    kind = random_kind(seed)
    camera = _camera(_rng(seed, "camera"))
    objects = objects_drawn(_rng(seed, "objects"), camera, kind)
    lights = lights_drawn(_rng(seed, "lights"), camera, kind)
    inside = {**objects, **lights, **lamps_drawn(_rng(seed, "lamps"), kind)}
    shapes = {**room_drawn(_rng(seed, "room"), camera, list(inside.values()), kind), **inside}
    if "lens" in kind:
        camera = _with_lens(_rng(seed, "lens"), camera, objects)
    goal = _rng(seed, "exposure").uniform(0.26, 0.5) * (0.85 if "metal" in kind else 1.0)  # longer paths bring more
    used = ["lens_u", "lens_v"] * ("lens" in kind) + ["time"] * ("motion" in kind) + ["light_u", "light_v"]
    return ToyScene(
        name=f"random_{seed}",
        idea=f"Drawn at random for training, with {', '.join(sorted(kind)) or 'diffuse surfaces alone'}.",
        build=exposed(Plan(camera, tuple(shapes.items())), goal),
        random_params=(*used, *["bsdf_u", "bsdf_v"] * ("metal" in kind)),
        features=FEATURES,
        max_depth=3 + seed // 5 % 2 if "metal" in kind else 2,
        motion=_motion(_rng(seed, "motion"), objects) if "motion" in kind else {},
    )


def _rng(seed: int, stream: str) -> np.random.Generator:
    """The random numbers of one part of the scene."""
    return np.random.default_rng([seed, STREAMS.index(stream)])


def _camera(rng: np.random.Generator) -> Camera:
    """Look at the middle of the scene from 4.5 to 8 units away, 9 to 50 degrees above the floor."""
    distance, height = rng.uniform(4.5, 8.0), math.radians(9 + 41 * rng.random() ** 1.5)
    side = math.radians(rng.uniform(-35, 35))
    target = (rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.4), rng.uniform(0.3, 0.6))
    step = (math.cos(height) * math.sin(side), -math.cos(height) * math.cos(side), math.sin(height))
    origin = (target[0] + distance * step[0], target[1] + distance * step[1], target[2] + distance * step[2])
    return Camera(origin, target, rng.uniform(27, 46))


def _with_lens(rng: np.random.Generator, camera: Camera, objects: dict[str, Ball | Box]) -> Camera:
    """Put a lens on, from slight to strong, that is sharp at one of the objects."""
    chosen = list(objects.values())[int(rng.integers(len(objects)))]
    aperture = between(rng, 0.04, 0.06 * math.dist(camera.origin, camera.target))
    return replace(camera, aperture_radius=aperture, focus_distance=math.dist(camera.origin, chosen.center))


def _motion(rng: np.random.Generator, objects: dict[str, Ball | Box]) -> dict[str, Vector]:
    """Let the first ball move, and each other with even odds: slow or fast, level, by a diameter at most."""
    motion = {}
    for key, shape in objects.items():
        if isinstance(shape, Ball) and (not motion or rng.random() < 0.5):
            way, angle = shape.radius * between(rng, 0.15, 2.0), rng.uniform(0, 2 * math.pi)
            motion[key] = (way * math.cos(angle), way * math.sin(angle), 0.0)
    return motion
