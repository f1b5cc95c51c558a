"""cornell: Mitsuba's own box with a lens put in front; nobody here tuned anything to it (chapter 09).

It is no toy scene of the lecture, and not among `SCENES`: the benchmark uses it to see how a trained filter does on a scene
that somebody else made. Light bounces up to seven times, walls have no texture, and the lens is sharp at the small box.
"""

from typing import Any

from mcdenoise.render.toyscene import ToyScene

LENS = {"type": "thinlens", "aperture_radius": 0.15, "focus_distance": 3.3}


def build() -> dict[str, Any]:
    """Mitsuba dict of the scene with its thin lens, without film, sampler and integrator."""
    import mitsuba as mi

    box = mi.cornell_box()
    camera = {key: value for key, value in box["sensor"].items() if key not in ("film", "sampler")}
    return {**box, "sensor": camera | LENS}


SCENE = ToyScene(
    name="cornell",
    idea="A scene from outside: a trained filter must do no harm where it was not trained.",
    build=build,
    random_params=("lens_u", "lens_v", "light_u", "light_v", "bsdf_u", "bsdf_v"),
    features=("world_position", "shading_normal", "albedo", "albedo_2", "visibility"),
    max_depth=8,
)
