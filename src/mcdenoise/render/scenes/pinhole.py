"""pinhole: dof with the lens removed, the control where a feature filter is right.

Same balls, floor and lights; every camera ray of a pixel now starts at one point, so first-hit features are all but
free of noise and say which neighbours are alike. What changes between the two pictures is the lens alone.
"""

from dataclasses import replace
from typing import Any

from mcdenoise.render.scenes import dof, parts


def build() -> dict[str, Any]:
    """Mitsuba dict of the scene with a perspective camera, without film, sampler and integrator."""
    return {"type": "scene", "sensor": parts.pinhole_camera(**dof.CAMERA), **dof.stage()}


SCENE = replace(
    dof.SCENE,
    name="pinhole",
    idea="Without the lens the features are free of noise, and a feature filter is right.",
    build=build,
    random_params=("light_u", "light_v"),
)
