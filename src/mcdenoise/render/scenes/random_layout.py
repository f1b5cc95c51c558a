"""What stands in a random scene: objects, lights, lamps, floor and walls, drawn with NumPy alone."""

import colorsys
import math

import numpy as np

from mcdenoise.render.scenes.parts import Vector
from mcdenoise.render.scenes.random_parts import Ball, Box, Camera, Lamp, Light, Paint, Panel

METALS = ("Ag", "Al", "Au", "Cr", "Cu", "W")


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw a size from `low` to `high`, every octave equally likely."""
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def reach(shape: Ball | Box | Light | Lamp) -> float:
    """Return how far from its centre a shape can be met, seen from above; a ball may move by its radius both ways.

    Examples
    --------
    >>> reach(Lamp((0.0, 0.0, 1.0), 0.1, (1.0, 1.0, 1.0)))
    0.1
    """
    if isinstance(shape, Ball):
        return 2 * shape.radius
    if isinstance(shape, Box):
        return math.hypot(*shape.half_sizes[:2])
    return math.sqrt(2) * shape.half_size if isinstance(shape, Light) else shape.radius


def in_view(camera: Camera, center: Vector, radius: float) -> bool:
    """Return whether any of a sphere is inside the cone around what a square film shows.

    Examples
    --------
    >>> camera = Camera((0.0, -5.0, 1.0), (0.0, 0.0, 1.0), 40.0)
    >>> in_view(camera, (0.0, 3.0, 1.0), 0.5), in_view(camera, (0.0, -8.0, 1.0), 0.5)
    (True, False)
    """
    distance = math.dist(camera.origin, center)
    if distance <= radius:
        return True
    cone = math.atan(math.sqrt(2) * math.tan(math.radians(camera.fov / 2)))
    return angle_between(camera.origin, camera.target, center) < cone + math.asin(radius / distance)


def angle_between(origin: Vector, first: Vector, second: Vector) -> float:
    """Return the angle, in radians, under which two points are seen from `origin`.

    Examples
    --------
    >>> round(math.degrees(angle_between((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (3.0, 3.0, 0.0))), 6)
    45.0
    """
    a, b = ([q - p for p, q in zip(origin, point, strict=True)] for point in (first, second))
    cosine = sum(x * y for x, y in zip(a, b, strict=True)) / (math.hypot(*a) * math.hypot(*b))
    return math.acos(min(1.0, max(-1.0, cosine)))


def _colour(rng: np.random.Generator) -> Vector:
    """Draw a reflectance, from nearly black to bright, from grey to deep."""
    return colorsys.hsv_to_rgb(rng.random(), rng.uniform(0, 0.85) ** 1.5, rng.uniform(0.08, 0.9))


def _paint(rng: np.random.Generator, size: Vector | tuple[float, float], finest: float) -> Paint:
    """Draw a pattern whose cells have a side of `finest` scene units (about a pixel) up to half of `size`."""
    pattern = ("plain", "plain", "checker", "checker", "stripes_u", "stripes_v")[int(rng.integers(6))]
    cell = between(rng, finest, max(min(size) / 2, 2 * finest) if min(size) < 4 else 1.5)
    return Paint(pattern, (_colour(rng), _colour(rng)), (size[0] / cell, size[1] / cell))


def _metal(rng: np.random.Generator) -> Paint:
    """Draw a metal, from nearly a mirror to nearly matt."""
    material = METALS[int(rng.integers(len(METALS)))]
    return Paint("metal", material=material, roughness=between(rng, 0.05, 0.4))


def objects_drawn(rng: np.random.Generator, camera: Camera, kind: frozenset[str]) -> dict[str, Ball | Box]:
    """Stand 3 to 9 objects on the floor in view of the camera, apart from each other where there is room."""
    objects: dict[str, Ball | Box] = {}
    discs: list[tuple[float, float, float]] = []
    scale = math.dist(camera.origin, camera.target) * math.tan(math.radians(camera.fov / 2))
    for index in range(int(rng.integers(3, 10))):
        size = scale * between(rng, 0.11 if index else 0.18, 0.34)  # the first is what may be metal or move
        is_ball = index == 0 or rng.random() < 0.6
        x, y = _place(rng, camera, size, discs)
        discs.append((x, y, size))
        is_metal = "metal" in kind and (index == 0 or rng.random() < 0.55)
        turn = tuple(rng.uniform(-90, 90, 3).tolist())
        extent = (2 * math.pi * size, math.pi * size) if is_ball else (1.2 * size, 1.2 * size)
        paint = _metal(rng) if is_metal else _paint(rng, extent, 0.02 * scale)
        if is_ball:
            objects[f"ball_{index}"] = Ball((x, y, size), size, turn, paint)
        else:
            half = (size * rng.uniform(0.3, 0.7), size * rng.uniform(0.3, 0.7), size * rng.uniform(0.3, 1.4))
            objects[f"box_{index}"] = Box((x, y, half[2]), half, turn[2], paint)
    return objects


def _place(
    rng: np.random.Generator, camera: Camera, size: float, discs: list[tuple[float, float, float]]
) -> tuple[float, float]:
    """Draw a place on the floor in view where a disc of radius `size` meets no other; after 40 tries any will do."""
    (x0, y0, _), (x1, y1, _) = camera.origin, camera.target
    ahead = (x1 - x0, y1 - y0)
    half_width = math.tan(math.radians(camera.fov / 2)) * math.dist(camera.origin, camera.target)
    for _ in range(40):
        depth, side = rng.uniform(0.68, 1.45), rng.uniform(-0.85, 0.85) * half_width / math.hypot(*ahead)
        x, y = (x0 + depth * (ahead[0] + side * ahead[1]), y0 + depth * (ahead[1] - side * ahead[0]))
        if all(math.dist((x, y), disc[:2]) > size + disc[2] for disc in discs):
            break
    return x, y


def lights_drawn(rng: np.random.Generator, camera: Camera, kind: frozenset[str]) -> dict[str, Light]:
    """Hang one or two square lights: small ones with hard shadows, large ones with wide penumbrae.

    They are out of view, and 35 degrees apart as seen from the middle, since a light casts shadows too. With metal none is
    tiny: its reflection would be a firefly that even a reference does not get rid of.
    """
    lights = {}
    for index in range(1 + (rng.random() < 0.4)):
        for _ in range(100):
            angle, aside = math.radians(rng.uniform(150, 390)), rng.uniform(0.5, 5.0)
            center = (aside * math.cos(angle), min(aside * math.sin(angle), 1.0), rng.uniform(4.2, 9.0))
            half_size = rng.uniform(0.4 if "metal" in kind else 0.1, 2.2)
            others = (light.center for light in lights.values())
            is_apart = all(angle_between((0.0, 0.0, 0.0), center, other) > math.radians(35) for other in others)
            if is_apart and not in_view(camera, center, math.sqrt(2) * half_size):
                break
        target = (rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 1.0), 0.0)
        strength = rng.uniform(0.15, 0.8) ** index * math.dist(center, target) ** 2 / half_size**2
        tint = colorsys.hsv_to_rgb(rng.random(), rng.uniform(0, 0.15 + 0.4 * index), strength)
        lights[f"light_{index}"] = Light(center, target, half_size, tint)
    return lights


def lamps_drawn(rng: np.random.Generator, kind: frozenset[str]) -> dict[str, Lamp]:
    """Hang a few small lamps into the picture, behind its middle: mostly if a lens can turn them into discs, else sometimes."""
    if rng.random() > (0.7 if "lens" in kind else 0.25):
        return {}
    lamps = {}
    for index in range(int(rng.integers(1, 6))):
        center = (rng.uniform(-2.5, 2.5), between(rng, 1.0, 5.0), rng.uniform(0.9, 2.4))
        tint = colorsys.hsv_to_rgb(rng.random(), rng.uniform(0, 0.7), rng.uniform(1.5, 5.0))
        lamps[f"lamp_{index}"] = Lamp(center, rng.uniform(0.04, 0.12), tint)
    return lamps


def room_drawn(
    rng: np.random.Generator, camera: Camera, inside: list[Ball | Box | Light | Lamp], kind: frozenset[str]
) -> dict[str, Panel]:
    """Lay the floor and put up walls around all that is `inside`: mostly one at the back, with metal more; else open sky."""
    finest = 0.025 * math.dist(camera.origin, camera.target) * math.tan(math.radians(camera.fov / 2))
    widths = [(camera.origin, 1.0), *((shape.center, 0.3 + reach(shape)) for shape in inside)]
    right, left = max(p[0] + w for p, w in widths), min(p[0] - w for p, w in widths)
    back, front = max(p[1] + w for p, w in widths) + 2.5 * rng.random(), min(p[1] - w for p, w in widths)
    height, more = rng.uniform(1.2, 4.5), 0.8 if "metal" in kind else 0.25
    wanted = {
        "wall_back": ((0.0, back, height), (0.0, -1.0, 0.0), 0.85),
        "wall_left": ((left, 0.0, height), (1.0, 0.0, 0.0), more),
        "wall_right": ((right, 0.0, height), (-1.0, 0.0, 0.0), more),
        "wall_front": ((0.0, front, height), (0.0, 1.0, 0.0), more),
    }
    panels = {"floor": Panel((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (20.0, 20.0), _paint(rng, (40.0, 40.0), finest))}
    for key, (center, facing, chance) in wanted.items():
        paint = _paint(rng, (40.0, 2 * height), 1.5 * finest)
        if rng.random() < chance:
            panels[key] = Panel(center, facing, (20.0, height), paint)
    return panels
