"""Random scenes: a seed is a scene, kinds come in fixed shares, layouts make sense, and pictures are well exposed."""

import math
import pickle
import subprocess
import sys

import mitsuba as mi
import numpy as np
import pytest

from mcdenoise.render import capture
from mcdenoise.render.scene import load_scene
from mcdenoise.render.scenes.random_exposure import camera_rays, irradiance, mean_radiance, panel_distance
from mcdenoise.render.scenes.random_layout import angle_between, between, in_view, reach
from mcdenoise.render.scenes.random_parts import Ball, Box, Camera, Lamp, Light, Paint, Panel, Plan
from mcdenoise.render.scenes.random_scene import FEATURES, random_kind, random_scene
from mcdenoise.samples.layout import RANDOM_PARAMS

MANY = range(140)
SCENES = {seed: random_scene(seed) for seed in MANY}
PLAIN, LENS, METAL, MOTION, ALL = 0, 5, 2, 38, 17  # seeds of each kind
GREY = Paint("plain", ((0.5, 0.5, 0.5), (0.0, 0.0, 0.0)))


@pytest.fixture(autouse=True)
def _scalar_variant() -> None:
    mi.set_variant("scalar_rgb")


def shapes(seed, *types):
    return {key: shape for key, shape in SCENES[seed].build.shapes if isinstance(shape, types)}


def plain(value):
    """The same dict with transforms as nested lists, so that it can be compared."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    return np.array(value.matrix).tolist() if hasattr(value, "matrix") else value


# ---- a seed is a scene


@pytest.mark.parametrize(
    ("seed", "message"),
    [
        ("3", r"seed must be a whole number, got '3' \(str\)"),
        (2.0, r"seed must be a whole number, got 2.0 \(float\)"),
        (True, r"seed must be a whole number, got True \(bool\)"),
        (-1, "seed must be at least 0, got -1"),
    ],
)
def test_a_seed_that_is_none_is_refused(seed, message):
    with pytest.raises(ValueError, match=message):
        random_scene(seed)


def test_the_same_seed_is_the_same_scene_and_another_seed_another():
    assert random_scene(np.int64(ALL)) == SCENES[ALL]
    assert plain(random_scene(ALL).build()) == plain(SCENES[ALL].build())
    assert len({scene.build for scene in SCENES.values()}) == len(MANY)
    assert SCENES[ALL].name == "random_17"
    assert pickle.loads(pickle.dumps(SCENES[ALL])) == SCENES[ALL]


def test_each_call_builds_afresh():
    first = SCENES[ALL].build()
    first["sensor"]["fov"] = 1.0
    first["ball_0"].clear()
    assert SCENES[ALL].build()["ball_0"]
    assert SCENES[ALL].build()["sensor"]["fov"] == SCENES[ALL].build.camera.fov


def test_drawing_does_not_import_mitsuba():
    code = "import sys; from mcdenoise.render.scenes.random_scene import random_scene; random_scene(3); "
    code += "sys.exit('mitsuba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_numbers_are_plain_so_that_mitsuba_and_the_fingerprint_take_them():
    def numbers(value):
        if isinstance(value, (tuple, list)):
            for item in value:
                yield from numbers(item)
        elif hasattr(value, "__dataclass_fields__"):
            for name in value.__dataclass_fields__:
                yield from numbers(getattr(value, name))
        else:
            yield value

    for scene in SCENES.values():
        assert {type(number) for number in numbers(scene.build)} <= {float, str}
        assert {type(number) for way in scene.motion.values() for number in way} <= {float}


# ---- kinds come in fixed shares


def test_any_20_seeds_in_a_row_hold_10_lenses_8_metals_and_2_or_3_motions():
    for first in range(70):
        kinds = [random_kind(seed) for seed in range(first, first + 20)]
        count = {name: sum(name in kind for kind in kinds) for name in ("lens", "metal", "motion")}
        assert (count["lens"], count["metal"]) == (10, 8)
        assert count["motion"] in (2, 3)


def test_any_70_seeds_in_a_row_hold_all_8_combinations():
    kinds = [random_kind(seed) for seed in range(70)]
    assert len(set(kinds)) == 8
    assert sum("motion" in kind for kind in kinds) == 10
    assert [random_kind(seed) for seed in range(70, 140)] == kinds


def test_seeds_of_this_file_are_of_the_kind_they_are_named_after():
    kinds = [set(random_kind(seed)) for seed in (PLAIN, LENS, METAL, MOTION, ALL)]
    assert kinds == [set(), {"lens"}, {"metal"}, {"motion"}, {"lens", "metal", "motion"}]


def test_scenes_are_what_their_kind_says():
    for seed, scene in SCENES.items():
        kind, used = random_kind(seed), set(scene.random_params)
        metals = [s for s in shapes(seed, Ball, Box, Panel).values() if s.paint.pattern == "metal"]
        assert ("lens" in kind) == (scene.build.camera.aperture_radius > 0) == ({"lens_u", "lens_v"} <= used)
        assert ("metal" in kind) == bool(metals) == ({"bsdf_u", "bsdf_v"} <= used)
        assert ("motion" in kind) == bool(scene.motion) == ("time" in used)
        assert scene.max_depth in ((3, 4) if "metal" in kind else (2,))
        assert scene.random_params == tuple(name for name in RANDOM_PARAMS if name in used)
        assert {"light_u", "light_v"} <= used
        assert scene.features == FEATURES
        assert scene.idea.endswith(".")
    assert {scene.max_depth for scene in SCENES.values()} == {2, 3, 4}


def test_all_that_may_be_drawn_is_drawn():
    every = [shape for seed in MANY for shape in shapes(seed, Ball, Box, Panel).values()]
    patterns = [shape.paint.pattern for shape in every]
    assert set(patterns) == {"plain", "checker", "stripes_u", "stripes_v", "metal"}
    assert {len(shapes(seed, Ball, Box)) for seed in MANY} == set(range(3, 10))
    assert {len(shapes(seed, Light)) for seed in MANY} == {1, 2}
    for lens, share in ((True, 0.7), (False, 0.25)):
        lamps = [bool(shapes(seed, Lamp)) for seed in MANY if ("lens" in random_kind(seed)) == lens]
        assert abs(np.mean(lamps) - share) < 4 * np.sqrt(share * (1 - share) / len(lamps))
    assert 0.75 < np.mean(["wall_back" in shapes(seed, Panel) for seed in MANY]) < 0.95
    sizes = [light.half_size for seed in MANY for light in shapes(seed, Light).values()]
    assert min(sizes) < 0.2
    assert max(sizes) > 1.8


# ---- layouts make sense


def test_objects_stand_on_the_floor_and_all_is_inside_the_walls():
    for seed in MANY:
        objects, panels = shapes(seed, Ball, Box), shapes(seed, Panel)
        for shape in objects.values():
            assert shape.center[2] == (shape.radius if isinstance(shape, Ball) else shape.half_sizes[2]), seed
        for shape in shapes(seed, Ball, Box, Light, Lamp).values():
            for key, wall in panels.items():
                inwards = np.dot(np.subtract(shape.center, wall.center), wall.facing)
                assert inwards > (0 if key == "floor" else reach(shape)), seed
        for wall in panels.values():
            assert np.dot(np.subtract(SCENES[seed].build.camera.origin, wall.center), wall.facing) > 0.9, seed


def test_the_camera_is_outside_of_objects_and_sees_no_square_light():
    for seed in MANY:
        camera = SCENES[seed].build.camera
        for shape in shapes(seed, Ball, Box).values():
            assert math.dist(camera.origin[:2], shape.center[:2]) > reach(shape) + camera.aperture_radius, seed
            assert camera.aperture_radius < 0.1 * camera.focus_distance, seed
        for light in shapes(seed, Light).values():
            assert not in_view(camera, light.center, math.sqrt(2) * light.half_size), seed


def test_no_light_stands_before_another():
    pairs = [[light.center for light in shapes(seed, Light).values()] for seed in MANY]
    angles = [math.degrees(angle_between((0.0, 0.0, 0.0), *pair)) for pair in pairs if len(pair) == 2]
    assert min(angles) > 35


def test_few_objects_overlap():
    overlaps = []
    for seed in MANY:
        discs = [
            (s.center[:2], s.radius if isinstance(s, Ball) else reach(s)) for s in shapes(seed, Ball, Box).values()
        ]
        for i, (place, radius) in enumerate(discs):
            overlaps += [math.dist(place, other) < radius + size for other, size in discs[:i]]
    assert np.mean(overlaps) < 0.03


def test_balls_alone_move_level_and_by_a_diameter_at_most():
    ways = []
    for seed, scene in SCENES.items():
        for key, way in scene.motion.items():
            ball = shapes(seed, Ball)[key]
            assert way[2] == 0
            ways.append(math.hypot(*way) / ball.radius)
    assert 0.15 <= min(ways) < 0.4
    assert 1.5 < max(ways) <= 2.0


def test_reach_is_the_radius_about_the_centre_seen_from_above():
    center, white = (1.0, 2.0, 3.0), (1.0, 1.0, 1.0)
    assert reach(Ball(center, 0.5, (0.0, 0.0, 0.0), GREY)) == 1.0  # its radius, and the same for its motion
    assert reach(Box(center, (3.0, 4.0, 9.0), 45.0, GREY)) == 5.0
    assert reach(Light(center, (0.0, 0.0, 0.0), 1.0, white)) == math.sqrt(2)
    assert reach(Lamp(center, 0.25, white)) == 0.25


def test_in_view_has_its_border_where_the_sphere_touches_the_cone():
    camera = Camera((0.0, 0.0, 0.0), (0.0, 2.0, 0.0), 2 * math.degrees(math.atan(math.sqrt(0.5))))  # cone: 45 degrees
    radius = math.sqrt(0.5)  # of a sphere at (x, 1): distance to the line x = y is (x - 1) / sqrt(2)
    assert in_view(camera, (1.99, 1.0, 0.0), radius)
    assert not in_view(camera, (2.01, 1.0, 0.0), radius)
    assert in_view(camera, (0.0, -0.5, 0.0), radius)  # the camera is inside the sphere


def test_angle_between_has_its_limits():
    origin, ahead = (1.0, 1.0, 1.0), (1.1, 1.2, 1.3)
    assert angle_between(origin, ahead, ahead) == pytest.approx(0, abs=1e-7)
    assert angle_between(origin, ahead, (0.9, 0.8, 0.7)) == pytest.approx(math.pi)
    assert angle_between(origin, (2.0, 1.0, 1.0), (1.0, 1.0, 9.0)) == pytest.approx(math.pi / 2)


def test_between_draws_every_octave_alike():
    drawn = np.log2([between(np.random.default_rng(seed), 0.5, 8.0) for seed in range(400)])
    assert drawn.min() >= -1
    assert drawn.max() <= 3
    octaves = np.histogram(drawn, bins=4, range=(-1, 3))[0]
    assert abs(octaves - 100).max() < 4 * math.sqrt(400 * 0.25 * 0.75)  # 4 standard errors


# ---- light


def test_irradiance_falls_with_the_fourth_power_of_the_cosine():
    light = Light((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), 0.5, (1.0, 2.0, 4.0))
    points = np.array([[0.0, 0.0, 0.0], [math.tan(math.pi / 3), 0.0, 0.0], [0.0, 0.0, 2.0]])
    up = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    expected = np.outer([1.0, 1 / 16, 0.0], [1.0, 2.0, 4.0])  # the third is behind the light
    np.testing.assert_allclose(irradiance(light, points, up), expected, rtol=1e-12)
    assert not irradiance(light, points[:1], -up[:1]).any()


@pytest.mark.parametrize("facing", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)])
def test_panels_are_met_where_mitsuba_meets_them(facing):
    panel = Panel((0.3, -0.2, 0.5), facing, (0.7, 0.4), GREY)
    shape = mi.load_dict({"type": "scene", "panel": panel.build()})
    origin = np.array(panel.center) + 2 * np.array(facing) + 0.1
    rays = np.random.default_rng(2).normal(size=(300, 3)) * 0.4 - np.array(facing)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    expected = [shape.ray_intersect(mi.Ray3f(origin.tolist(), ray.tolist())).t for ray in rays]
    assert 50 < np.isfinite(expected).sum() < 250
    np.testing.assert_allclose(panel_distance(panel, origin, rays), expected, rtol=1e-5)
    assert np.isinf(panel_distance(panel, origin - 4 * np.array(facing), rays)).all()  # from behind
    assert np.isinf(panel_distance(panel, origin, np.roll(facing, 1)[np.newaxis])).all()  # along it


def test_rays_are_those_of_mitsubas_camera():
    camera = SCENES[PLAIN].build.camera
    film = {"film": {"type": "hdrfilm", "width": 3, "height": 3}}
    sensor = mi.load_dict(camera.build() | film)
    places = [((x + 0.5) / 3, (y + 0.5) / 3) for y in range(3) for x in range(3)]
    expected = [sensor.sample_ray(0.0, 0.5, list(place), [0.5, 0.5])[0].d for place in places]
    np.testing.assert_allclose(camera_rays(camera, 3), np.array(expected), atol=1e-6)


def test_mean_radiance_of_a_floor_under_a_far_light_is_albedo_times_irradiance_over_pi():
    floor = Panel((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (1e4, 1e4), GREY)
    light = Light((0.0, 0.0, 1e6), (0.0, 0.0, 0.0), 0.5, (math.pi * 1e12,) * 3)  # irradiance pi
    down = Camera((0.0, -1.0, 5.0), (0.0, 0.0, 0.0), 30.0)
    level = Camera((0.0, -1.0, 1.0), (0.0, 0.0, 1.0), 30.0)  # half of its rays go to the sky
    both = (("floor", floor), ("light", light))
    assert mean_radiance(Plan(down, both)) == pytest.approx(0.5, rel=1e-6)
    assert mean_radiance(Plan(level, both)) == pytest.approx(0.25, rel=1e-5)
    wall = Panel((0.0, 2.0, 0.0), (0.0, -1.0, 0.0), (1e4, 1e4), GREY)  # it hides floor and sky and gets no light
    assert mean_radiance(Plan(level, (*both, ("wall", wall)))) < 0.2


def test_lights_are_set_for_a_guessed_mean_radiance():
    for seed in MANY:
        low, high = (0.26 * 0.85, 0.5 * 0.85) if "metal" in random_kind(seed) else (0.26, 0.5)
        assert low * (1 - 1e-9) <= mean_radiance(SCENES[seed].build) <= high * (1 + 1e-9), seed


# ---- pictures


def test_pictures_are_finite_not_black_and_well_exposed():
    means = []
    for seed in MANY:
        ready = load_scene(SCENES[seed], 12, 12)
        image = np.array(mi.render(ready.scene, integrator=ready.integrator, spp=8, seed=seed))
        assert np.isfinite(image).all()
        assert (image >= 0).all()
        assert (image > 0).mean() > 0.5
        means.append(image.mean())
    assert min(means) > 0.1
    assert max(means) < 0.8
    assert np.mean([0.2 <= mean <= 0.5 for mean in means]) > 0.8
    assert np.std(means) > 0.05


@pytest.mark.parametrize("seed", [PLAIN, LENS, METAL, ALL])
def test_captured_samples_are_finite_and_carry_what_the_scene_names(seed):
    samples = capture(SCENES[seed], 12, 12, 2, seed=1, variant="scalar_rgb")
    assert samples.random_param_names == SCENES[seed].random_params
    assert samples.feature_names == FEATURES
    assert samples.hit.mean() > 0.5
    assert samples["albedo_2"].any()
    assert samples["visibility"].any()
    assert ("metal" in random_kind(seed)) == bool((samples["albedo"].max(axis=-1) == 0)[samples.hit].any())


def test_metal_can_be_moved_and_boxes_load():
    ready = load_scene(SCENES[ALL], 4, 4)
    assert set(SCENES[ALL].random_params) <= set(ready.random_params)
    ready.poser.at(0.9)
    assert np.isfinite(np.array(mi.render(ready.scene, integrator=ready.integrator, spp=1))).all()
