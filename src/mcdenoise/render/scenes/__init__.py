"""The toy scenes, each chosen to show one thing; importing them does not import Mitsuba."""

from mcdenoise.render.scenes import dof, glossy, motion, pinhole, soft_shadow
from mcdenoise.render.toyscene import ToyScene

SCENES: dict[str, ToyScene] = {
    module.SCENE.name: module.SCENE for module in (dof, pinhole, soft_shadow, glossy, motion)
}
"""Toy scenes by name, in the order of the lecture."""
