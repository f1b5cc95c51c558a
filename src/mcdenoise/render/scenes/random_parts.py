"""Pieces of a random scene as plain numbers: they are drawn first, and become a Mitsuba dict when the scene is built.

All of them are frozen and compare by value, so two plans with the same numbers are the same scene. Units are those of
`parts`: scene units, x right, y away from the camera, z up; colours are scene-linear RGB; angles are in degrees.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdenoise.render.scenes import parts
from mcdenoise.render.scenes.parts import Vector


@dataclass(frozen=True)
class Paint:
    """What a surface is made of.

    Attributes
    ----------
    pattern : ``"plain"``, ``"checker"``, ``"stripes_u"``, ``"stripes_v"`` or ``"metal"``
    colours : two RGB reflectances; a plain surface has the first
    cells : cells of the pattern along u and v, each over the whole surface
    material, roughness : name of the metal, and alpha of its GGX lobe

    Examples
    --------
    >>> Paint("checker", ((0.0, 0.0, 0.0), (1.0, 0.5, 0.0)), (8.0, 4.0)).mean_colour.tolist()
    [0.5, 0.25, 0.0]
    """

    pattern: str
    colours: tuple[Vector, Vector] = ((0.5, 0.5, 0.5), (0.5, 0.5, 0.5))
    cells: tuple[float, float] = (1.0, 1.0)
    material: str = "none"
    roughness: float = 0.0

    @property
    def mean_colour(self) -> np.ndarray:
        """RGB reflectance averaged over the pattern, (3,); a metal counts as the grey of `colours`."""
        return np.mean(self.colours[: 1 if self.pattern == "plain" else 2], axis=0)

    def build(self) -> dict[str, Any]:
        """Mitsuba dict of the BSDF."""
        if self.pattern == "metal":
            lobe = {"distribution": "ggx", "alpha": self.roughness}
            return {"type": "roughconductor", "material": self.material, **lobe}
        if self.pattern == "plain":
            return parts.diffuse(self.colours[0])
        if self.pattern == "checker":
            return parts.diffuse(parts.checker(*self.colours, *self.cells))
        axis = self.pattern[-1]
        return parts.diffuse(parts.stripes(*self.colours, self.cells["uv".index(axis)], axis))


@dataclass(frozen=True)
class Ball:
    """A sphere; `turn` shows another side of its pattern."""

    center: Vector
    radius: float
    turn: Vector
    paint: Paint

    def build(self) -> dict[str, Any]:
        """Mitsuba dict of the shape."""
        return parts.sphere(self.center, self.radius, self.paint.build(), self.turn)


@dataclass(frozen=True)
class Box:
    """A box of three half sizes that stands upright, turned about z by `angle`."""

    center: Vector
    half_sizes: Vector
    angle: float
    paint: Paint

    def build(self) -> dict[str, Any]:
        """Mitsuba dict of the shape."""
        import mitsuba as mi

        to_world = mi.ScalarTransform4f().translate(list(self.center))
        to_world = to_world @ mi.ScalarTransform4f().rotate([0, 0, 1], self.angle)
        to_world = to_world @ mi.ScalarTransform4f().scale(list(self.half_sizes))
        return {"type": "cube", "to_world": to_world, "bsdf": self.paint.build()}


@dataclass(frozen=True)
class Panel:
    """A rectangle about `center` that looks along `facing` (an axis): floor, wall, ceiling."""

    center: Vector
    facing: Vector
    half_sizes: tuple[float, float]
    paint: Paint

    def build(self) -> dict[str, Any]:
        """Mitsuba dict of the shape."""
        return parts.rectangle(self.center, self.facing, *self.half_sizes, bsdf=self.paint.build())


@dataclass(frozen=True)
class Light:
    """A square that shines towards `target`; its side is twice `half_size`."""

    center: Vector
    target: Vector
    half_size: float
    radiance: Vector

    def build(self) -> dict[str, Any]:
        """Mitsuba dict of the shape with its emitter."""
        return parts.square_light(self.center, self.target, self.half_size, self.radiance)


@dataclass(frozen=True)
class Lamp:
    """A small bright ball; it takes few light samples, which are for the square lights."""

    center: Vector
    radius: float
    radiance: Vector

    def build(self) -> dict[str, Any]:
        """Mitsuba dict of the shape with its emitter."""
        emitter = {"type": "area", "radiance": parts.rgb(self.radiance), "sampling_weight": 0.01}
        return parts.sphere(self.center, self.radius, parts.diffuse((0, 0, 0))) | {"emitter": emitter}


@dataclass(frozen=True)
class Camera:
    """A pinhole, or a thin lens where `aperture_radius` is above 0."""

    origin: Vector
    target: Vector
    fov: float
    aperture_radius: float = 0.0
    focus_distance: float = 1.0

    def build(self) -> dict[str, Any]:
        """Mitsuba dict of the sensor, without film and sampler."""
        if not self.aperture_radius:
            return parts.pinhole_camera(self.origin, self.target, self.fov)
        return parts.thin_lens_camera(self.origin, self.target, self.fov, self.aperture_radius, self.focus_distance)


@dataclass(frozen=True)
class Plan:
    """All numbers of one scene; calling it gives the Mitsuba dict, so it serves as the `build` of a ToyScene.

    Attributes
    ----------
    camera : Camera
    shapes : tuple of (key of the dict, shape)

    Examples
    --------
    >>> floor = Panel((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (9.0, 9.0), Paint("plain"))
    >>> plan = Plan(Camera((0.0, -5.0, 1.0), (0.0, 0.0, 1.0), 40.0), (("floor", floor),))
    >>> plan == Plan(plan.camera, plan.shapes)
    True
    """

    camera: Camera
    shapes: tuple[tuple[str, Ball | Box | Panel | Light | Lamp], ...]

    def __call__(self) -> dict[str, Any]:
        """Mitsuba dict of the scene, without film, sampler and integrator."""
        shapes = {key: shape.build() for key, shape in self.shapes}
        return {"type": "scene", "sensor": self.camera.build(), **shapes}
