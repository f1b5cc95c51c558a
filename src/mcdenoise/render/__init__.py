"""Loading dock: the only room that imports Mitsuba, and only when it renders (chapter 01)."""

from mcdenoise.render.capture import capture
from mcdenoise.render.exr import read_exr, write_exr
from mcdenoise.render.reference import render_image, render_reference
from mcdenoise.render.scene import scene_names
from mcdenoise.render.toyscene import ToyScene
from mcdenoise.render.variants import choose_variant

__all__ = [
    "ToyScene",
    "capture",
    "choose_variant",
    "read_exr",
    "render_image",
    "render_reference",
    "scene_names",
    "write_exr",
]
