"""The toy scenes: each builds, renders, and shows the one thing it claims to show."""

import subprocess
import sys

import mitsuba as mi
import numpy as np
import pytest

from mcdenoise.render.scenes import SCENES, parts
from mcdenoise.render.toyscene import ToyScene

pytestmark = pytest.mark.ch01

RANDOM_PARAMS = ("lens_u", "lens_v", "time", "light_u", "light_v", "bsdf_u", "bsdf_v")
FEATURES = ("world_position", "shading_normal", "albedo")
FEATURES = (*FEATURES, *(f"{name}_2" for name in FEATURES), "visibility")


@pytest.fixture(autouse=True)
def _scalar_variant() -> None:
    mi.set_variant("scalar_rgb")


@pytest.fixture(params=list(SCENES))
def scene(request: pytest.FixtureRequest) -> ToyScene:
    return SCENES[request.param]


def load(scene: ToyScene, width: int = 16, height: int = 16):
    description = scene.build()
    description["sensor"]["film"] = {
        "type": "hdrfilm",
        "width": width,
        "height": height,
        "rfilter": {"type": "box"},
    }
    description["integrator"] = {"type": "path", "max_depth": scene.max_depth}
    return mi.load_dict(description)


def render(loaded, spp: int, seed: int) -> np.ndarray:
    return np.array(mi.render(loaded, spp=spp, seed=seed))


def pixel_variance(loaded, spp: int = 16, repeats: int = 8) -> np.ndarray:
    """Variance of the pixel mean at `spp`, from independent renders, averaged over channels."""
    return np.var([render(loaded, spp, seed) for seed in range(repeats)], axis=0, ddof=1).mean(axis=-1)


def camera_rays(width: int, height: int):
    """Film positions in [0, 1)^2 of the pixel centres, row by row."""
    return [((x + 0.5) / width, (y + 0.5) / height) for y in range(height) for x in range(width)]


def first_hit(loaded, film: tuple[float, float], aperture: tuple[float, float] = (0.5, 0.5)):
    ray, _ = loaded.sensors()[0].sample_ray(0.0, 0.5, list(film), list(aperture))
    return loaded.ray_intersect(mi.Ray3f(ray))


def test_scene_names_come_in_the_order_of_the_lecture():
    assert list(SCENES) == ["dof", "pinhole", "soft_shadow", "glossy", "motion"]
    assert all(name == scene.name for name, scene in SCENES.items())


def test_importing_the_scenes_does_not_import_mitsuba():
    code = "import sys, mcdenoise.render.scenes; sys.exit('mitsuba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_idea_is_one_sentence(scene):
    assert scene.idea.endswith(".")
    assert scene.idea.count(".") == 1


def test_random_params_and_features_are_known_and_in_order(scene):
    assert scene.random_params == tuple(name for name in RANDOM_PARAMS if name in scene.random_params)
    assert scene.features == tuple(name for name in FEATURES if name in scene.features)


def test_dict_leaves_film_sampler_and_integrator_to_capture(scene):
    description = scene.build()
    assert description["type"] == "scene"
    assert "integrator" not in description
    assert not {"film", "sampler"} & set(description["sensor"])


@pytest.mark.parametrize(("width", "height"), [(16, 16), (24, 10), (10, 24)])
def test_renders_finite_light_at_any_aspect_ratio(scene, width, height):
    image = render(load(scene, width, height), spp=16, seed=1)
    assert image.shape == (height, width, 3)
    assert np.isfinite(image).all()
    assert (image >= 0).all()
    assert 0.1 < image.mean() < 0.6


@pytest.mark.parametrize(("width", "height"), [(16, 16), (32, 16), (16, 32)])
def test_every_camera_ray_meets_a_surface(scene, width, height):
    loaded = load(scene, width, height)
    hits = [first_hit(loaded, film) for film in camera_rays(width, height)]
    assert all(hit.is_valid() for hit in hits)


def test_each_call_builds_afresh(scene):
    first = scene.build()
    first["sensor"]["fov"] = 1.0
    for value in first.values():
        if isinstance(value, dict) and "bsdf" in value:
            value["bsdf"].clear()
    second = scene.build()
    assert second["sensor"]["fov"] != 1.0
    assert all(value["bsdf"] for value in second.values() if isinstance(value, dict) and "bsdf" in value)
    mi.load_dict(second)


def test_lens_params_are_named_exactly_where_the_camera_has_a_lens(scene):
    needs_lens = load(scene).sensors()[0].needs_aperture_sample()
    assert needs_lens == ("lens_u" in scene.random_params) == ("lens_v" in scene.random_params)


def test_time_is_named_exactly_where_something_moves(scene):
    assert ("time" in scene.random_params) == bool(scene.motion)


def test_pinhole_is_dof_without_the_lens():
    dof, pinhole = SCENES["dof"].build(), SCENES["pinhole"].build()
    lens, perspective = dof.pop("sensor"), pinhole.pop("sensor")
    assert plain(dof) == plain(pinhole)
    assert (lens.pop("type"), perspective.pop("type")) == ("thinlens", "perspective")
    del lens["aperture_radius"], lens["focus_distance"]
    assert plain(lens) == plain(perspective)
    assert SCENES["dof"].features == SCENES["pinhole"].features
    assert SCENES["dof"].random_params == ("lens_u", "lens_v", *SCENES["pinhole"].random_params)


def plain(value):
    """The same dict with transforms as nested lists, so that it can be compared."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    return np.array(value.matrix).tolist() if hasattr(value, "matrix") else value


def spread_over_lens(loaded, shape_id: str, rng: np.random.Generator) -> float:
    """Median over the pixels that show `shape_id` of the standard deviation of the hit's x over the lens."""
    spreads = []
    for film in camera_rays(24, 24):
        if (hit := first_hit(loaded, film)).shape.id() == shape_id:
            hits = [first_hit(loaded, film, aperture) for aperture in rng.random((16, 2)).tolist()]
            spreads.append(np.std([h.p[0] for h in hits if h.shape is not None and h.shape.id() == hit.shape.id()]))
    return float(np.median(spreads))


def test_dof_positions_depend_on_the_lens_only_out_of_focus():
    loaded, rng = load(SCENES["dof"]), np.random.default_rng(5)
    sharp = spread_over_lens(loaded, "ball_focus", rng)
    assert spread_over_lens(loaded, "ball_near", rng) > 3 * sharp
    assert spread_over_lens(loaded, "ball_far", rng) > 3 * sharp


def test_lamps_of_dof_take_few_light_samples():
    description = SCENES["dof"].build()
    lamps = [value["emitter"]["sampling_weight"] for key, value in description.items() if key.startswith("lamp")]
    assert len(lamps) >= 3
    assert sum(lamps) < 0.05


def lit_fraction(loaded, hit, grid: int = 5) -> float:
    """Share of the light that the point sees: 0 in the umbra, 1 in full light."""
    points = (np.arange(grid) + 0.5) / grid
    visible = []
    for u in points.tolist():
        for v in points.tolist():
            sample, _ = loaded.sample_emitter_direction(hit, [u, v], test_visibility=False)
            facing = sample.pdf > 0 and hit.n @ np.array(sample.d) > 0
            visible.append(facing and not loaded.ray_test(hit.spawn_ray_to(sample.p)))
    return float(np.mean(visible))


def flat_regions(loaded, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Pixels whose four corners show one shape, all in the umbra or all in full light."""
    nodes = [(x / size, y / size) for y in range(size + 1) for x in range(size + 1)]
    hits = [first_hit(loaded, film) for film in nodes]
    lit = np.array([lit_fraction(loaded, hit) for hit in hits])
    shape = np.unique([hit.shape.id() for hit in hits], return_inverse=True)[1]
    lit, shape = (corners(values.reshape(size + 1, size + 1)) for values in (lit, shape))
    one_shape = (shape == shape[0]).all(axis=0)
    return one_shape & (lit == 0).all(axis=0), one_shape & (lit == 1).all(axis=0)


def corners(nodes: np.ndarray) -> np.ndarray:
    """The values at the four corners of each pixel, (4, h, w)."""
    return np.stack([nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, :-1], nodes[1:, 1:]])


def test_soft_shadow_noise_is_in_the_penumbra():
    loaded = load(SCENES["soft_shadow"], 40, 40)
    umbra, full = flat_regions(loaded, 40)
    variance = pixel_variance(loaded)
    assert umbra.sum() > 20
    assert 800 < full.sum() < 1400
    assert (variance[umbra] < 1e-4 * variance.mean()).mean() > 0.9
    assert variance[~umbra & ~full].sum() > 0.85 * variance.sum()
    assert np.median(variance[~umbra & ~full]) > 10 * np.median(variance[full])


def test_glossy_metal_is_black_at_the_first_hit_and_varied_at_the_second():
    loaded, rng = load(SCENES["glossy"]), np.random.default_rng(2)
    context, seconds, flat = mi.BSDFContext(), [], []
    for film in camera_rays(24, 24):
        hit = first_hit(loaded, film)
        if not hit.shape.id().startswith("ball"):
            continue
        bsdf = hit.bsdf()
        flat.append(not mi.has_flag(bsdf.flags(), mi.BSDFFlags.DiffuseReflection))
        sample, _ = bsdf.sample(context, hit, float(rng.random()), rng.random(2).tolist())
        second = loaded.ray_intersect(hit.spawn_ray(hit.to_world(sample.wo)))
        if second.is_valid() and mi.has_flag(second.bsdf().flags(), mi.BSDFFlags.DiffuseReflection):
            seconds.append(np.array(second.bsdf().eval_diffuse_reflectance(second)))
    assert all(flat)
    assert len(flat) > 60
    assert (np.std(seconds, axis=0) > 0.1).all()


def test_motion_keys_are_shapes_that_can_be_posed_again():
    scene = SCENES["motion"]
    loaded = load(scene)
    params = mi.traverse(loaded)
    for key, displacement in scene.motion.items():
        before = next(shape for shape in loaded.shapes() if shape.id() == key).bbox().center()
        params[f"{key}.to_world"] = mi.ScalarTransform4f().translate(list(displacement)) @ params[f"{key}.to_world"]
        params.update()
        after = next(shape for shape in loaded.shapes() if shape.id() == key).bbox().center()
        assert np.array(after) - np.array(before) == pytest.approx(displacement, abs=1e-6)
    assert np.isfinite(render(loaded, 4, 0)).all()


def test_motion_has_a_fast_and_a_slow_object():
    slow, fast = sorted(np.linalg.norm(displacement) for displacement in SCENES["motion"].motion.values())
    assert fast > 5 * slow > 0


def test_stripes_vary_along_one_coordinate_only():
    pattern = parts.stripes((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), 4, axis="v")
    bsdf = mi.load_dict(parts.diffuse(pattern))
    hit = mi.SurfaceInteraction3f()

    def value(u: float, v: float) -> float:
        hit.uv = [u, v]
        return bsdf.eval_diffuse_reflectance(hit)[0]

    centres = [0.125, 0.375, 0.625, 0.875]
    along = [value(0.5, v) for v in centres]
    assert all([value(u, v) for v in centres] == along for u in (0.01, 0.3, 0.7, 0.99))
    assert along in ([0.0, 1.0, 0.0, 1.0], [1.0, 0.0, 1.0, 0.0])
