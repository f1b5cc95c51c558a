"""capture: the samples are Mitsuba's own, and every recorded number is the one that was used."""

import sys
from importlib.metadata import version

import numpy as np
import pytest

from mcdenoise.render import capture, choose_variant, scene_names
from mcdenoise.render.scene import load_scene
from mcdenoise.render.scenes import SCENES
from mcdenoise.render.variants import use_variant
from mcdenoise.samples.layout import FEATURES

pytestmark = pytest.mark.ch01
VARIANTS = ("scalar_rgb", "llvm_ad_rgb")


@pytest.fixture(params=VARIANTS)
def variant(request):
    return need(request.param)


def need(variant):
    if variant == "llvm_ad_rgb" and choose_variant() != variant:
        pytest.skip("no LLVM library works with Dr.Jit on this machine")
    return variant


def mi_render(scene, width, height, spp, seed, variant):
    with use_variant(variant):
        import mitsuba as mi

        ready = load_scene(scene, width, height)
        return np.array(mi.render(ready.scene, integrator=ready.integrator, spp=spp, seed=seed))


def mean_and_error(values):
    """Mean over all samples and its standard error; pixels are strata."""
    pixels, spp = values.shape[0] * values.shape[1], values.shape[2]
    error = np.sqrt((values.var(axis=2, ddof=1, dtype=np.float64) / spp).sum(axis=(0, 1))) / pixels
    return values.mean(axis=(0, 1, 2), dtype=np.float64), error


def fields(samples):
    names = ("radiance", "screen_position")
    yield from ((name, getattr(samples, name)) for name in names)
    for name in (*samples.random_param_names, *samples.feature_names):
        yield name, samples[name].reshape(*samples.hit.shape, -1)


def rectangle(z=0.0, scale=1.0, **more):
    import mitsuba as mi

    return {"type": "rectangle", "to_world": mi.ScalarTransform4f().translate([0, 0, z]).scale(scale), **more}


def looking_down(distance, **camera):
    """A camera at height `distance` above the origin, looking down; image right is +x or -x."""
    import mitsuba as mi

    pose = mi.ScalarTransform4f().look_at(origin=[0, 0, distance], target=[0, 0, 0], up=[0, 1, 0])
    return {"type": "perspective", "fov": 40, **camera, "to_world": pose}


@pytest.fixture
def scalar():
    """Dicts are built under a variant."""
    with use_variant("scalar_rgb"):
        yield


# Against Mitsuba


@pytest.mark.parametrize("name", [name for name in SCENES if not SCENES[name].motion])
def test_mean_is_mitsubas_image_bit_for_bit(name):
    variant = need("llvm_ad_rgb")
    samples = capture(name, 31, 23, 8, seed=3, variant=variant)
    mitsuba_version = tuple(int(number) for number in version("mitsuba").split(".")[:2])
    rounding = 0 if mitsuba_version >= (3, 9) else 3e-7  # before 3.9 the film's sum took another order
    np.testing.assert_allclose(samples.radiance.mean(axis=2), mi_render(name, 31, 23, 8, 3, variant), rtol=rounding)


@pytest.mark.parametrize("name", ["dof", "glossy"])
def test_mean_is_mitsubas_image_within_the_noise(name):
    samples = capture(name, 24, 16, 32, seed=3, variant="scalar_rgb")
    image = mi_render(name, 24, 16, 32, 4, "scalar_rgb")
    mean, error = mean_and_error(samples.radiance)
    assert (np.abs(mean - image.mean(axis=(0, 1))) < 4 * np.sqrt(2) * error).all()


@pytest.mark.parametrize(("name", "features"), [("dof", None), ("glossy", list(FEATURES))])
def test_both_variants_agree_in_every_field(name, features):
    need("llvm_ad_rgb")
    one, two = (capture(name, 24, 16, 32, seed=5, variant=v, features=features) for v in VARIANTS)
    assert one.layout == two.layout
    for (field, a), (_, b) in zip(fields(one), fields(two), strict=True):
        (mean_a, error_a), (mean_b, error_b) = mean_and_error(a), mean_and_error(b)
        assert (np.abs(mean_a - mean_b) <= 4 * np.hypot(error_a, error_b) + 1e-7).all(), field


def test_many_samples_are_traced_in_passes(monkeypatch):
    variant = need("llvm_ad_rgb")
    monkeypatch.setattr(sys.modules["mcdenoise.render.capture"], "WAVEFRONT", 24 * 8 * 5)
    samples = capture("dof", 24, 16, 8, seed=5, variant=variant)
    whole, error = mean_and_error(capture("dof", 24, 16, 8, seed=6, variant=variant).radiance)
    mean, _ = mean_and_error(samples.radiance)
    assert (np.abs(mean - whole) < 4 * np.sqrt(2) * error).all()
    rows = samples.screen_position[..., 0] % 1
    assert len(np.unique(rows)) > 0.99 * rows.size  # no pass repeats the numbers of another


# Closed forms


def furnace(shape, **emitter):
    """Albedo 0.5, emission 0.5, seen from inside: radiance 1, less 2**-24 as paths have at most 24 edges."""
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 24, "rr_depth": 100},
        "camera": {"type": "perspective", "fov": 60},
        "walls": {
            "type": shape,
            "flip_normals": True,
            "bsdf": {"type": "diffuse", "reflectance": 0.5},
            "light": {"type": "area", "radiance": 0.5, **emitter},
        },
    }


def test_furnace_sphere(variant, scalar):
    """Light samples are left to a lamp outside: Mitsuba is off by 1% where a sphere's own surface is lit by its samples."""
    scene = furnace("sphere", sampling_weight=0.0) | {"lamp": {"type": "point", "position": [0, 0, 5]}}
    samples = capture(scene, 8, 8, 8, seed=1, variant=variant)
    np.testing.assert_allclose(samples.radiance, 1 - 2.0**-24, rtol=1e-5)
    assert samples.hit.all()
    assert "albedo" not in samples.feature_names  # it does not vary
    np.testing.assert_allclose(np.linalg.norm(samples["world_position"], axis=-1), 1, atol=1e-5)
    np.testing.assert_allclose(samples["shading_normal"], -samples["world_position"], atol=1e-5)


def test_furnace_cube(variant, scalar):
    samples = capture(furnace("cube"), 12, 12, 64, seed=1, variant=variant)
    mean, error = mean_and_error(samples.radiance)
    assert (error < 0.003).all()
    assert (np.abs(mean - 1) < 4 * error + 2.0**-24).all()


@pytest.mark.parametrize("depth", [4.0, 6.0])
def test_world_position_depends_on_the_lens_only_out_of_focus(variant, scalar, depth):
    """On a plane at `depth` the lens point a moves the hit by a (1 - depth / focus); in focus by nothing."""
    focus, aperture = 4.0, 0.3
    camera = looking_down(depth, type="thinlens", aperture_radius=aperture, focus_distance=focus)
    scene = {"type": "scene", "camera": camera, "floor": rectangle(scale=20), "light": {"type": "constant"}}
    samples = capture(scene, 16, 12, 16, seed=2, variant=variant)
    assert {"lens_u", "lens_v"} <= set(samples.random_param_names)
    import mitsuba as mi

    lens = np.stack([samples["lens_u"], samples["lens_v"]], axis=-1).reshape(-1, 2)
    disk = np.array([mi.warp.square_to_uniform_disk_concentric(mi.Point2f(u)) for u in lens.tolist()])
    screen = samples.screen_position.reshape(-1, 2)
    known = np.column_stack([screen, np.ones(len(screen)), disk * aperture])
    hit = samples["world_position"].reshape(-1, 3)[:, :2].astype(np.float64)
    slope, *_ = np.linalg.lstsq(known, hit, rcond=None)
    np.testing.assert_allclose(known @ slope, hit, atol=1e-4)
    np.testing.assert_allclose(np.abs(slope[3:]), abs(1 - depth / focus) * np.eye(2), atol=1e-4)


def test_recorded_light_numbers_are_those_used(variant, scalar):
    """A blocked light point darkens its own sample; what is left is the chance that the BSDF sample finds the light."""
    light = rectangle(2.0, 0.1, light={"type": "area", "radiance": 100.0}, flip_normals=True)
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "camera": looking_down(1.5),
        "light": light,
        "floor": rectangle(scale=3),
        "fence": rectangle(1.9, 0.07),
    }
    samples = capture(scene, 16, 16, 16, seed=2, variant=variant)
    on_floor = samples.hit & (np.abs(samples["world_position"][..., 2]) < 1e-4)
    visible = samples["visibility"][on_floor] == 1
    dark = samples.radiance[on_floor].sum(axis=-1) < 1e-6
    assert 0.2 < visible.mean() < 0.8
    assert not dark[visible].any()
    assert dark[~visible].mean() > 0.98


def test_recorded_bsdf_numbers_are_those_used(variant, scalar):
    """Lamps that only BSDF samples find, red for x < 0, green for x > 0: the second hit tells the colour of its sample."""
    import mitsuba as mi

    def lamp(x, colour):
        pose = mi.ScalarTransform4f().translate([x, 0, 1]).rotate([0, 1, 0], 180).scale([5, 10, 1])
        emitter = {"type": "area", "radiance": {"type": "rgb", "value": colour}, "sampling_weight": 0.0}
        return {"type": "rectangle", "to_world": pose, "light": emitter}

    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "camera": looking_down(0.5),
        "floor": rectangle(scale=3, bsdf={"type": "diffuse", "reflectance": 0.5}),
        "red": lamp(-5, [1, 0, 0]),
        "green": lamp(5, [0, 1, 0]),
        "other": {"type": "point", "position": [0, 0, -1]},  # below the floor: lights nothing, takes all light samples
    }
    names = ["world_position", "world_position_2", "shading_normal_2"]
    samples = capture(scene, 8, 8, 16, seed=2, variant=variant, features=names)
    second = samples["world_position_2"].astype(np.float64)
    found = np.abs(samples["shading_normal_2"]).sum(axis=-1) > 0
    assert found.mean() > 0.9
    expected = 0.5 * np.stack([second[..., 0] < 0, second[..., 0] > 0, 0 * second[..., 0]], axis=-1)
    np.testing.assert_allclose(samples.radiance[found], expected[found], atol=1e-5)


# What is recorded


def test_toy_scene_carries_what_it_names_and_says_where_it_comes_from(variant):
    samples = capture("dof", 6, 4, 2, seed=7, variant=variant)
    assert samples.random_param_names == SCENES["dof"].random_params
    assert samples.feature_names == SCENES["dof"].features
    expected = {"scene": "dof", "width": 6, "height": 4, "spp": 2, "seed": 7, "variant": variant}
    assert expected.items() <= samples.provenance.items()
    assert {"mitsuba", "drjit", "mcdenoise"} <= samples.provenance.keys()


def test_same_seed_same_samples(variant):
    one, two, other = (capture("glossy", 6, 4, 2, seed=s, variant=variant) for s in (1, 1, 2))
    np.testing.assert_array_equal(one.radiance, two.radiance)
    np.testing.assert_array_equal(one.random_params, two.random_params)
    assert not np.array_equal(one.random_params, other.random_params)


def test_only_what_is_asked_for(variant):
    samples = capture("glossy", 6, 4, 2, variant=variant, random_params=["bsdf_v"], features=["albedo_2", "visibility"])
    assert samples.random_param_names == ("bsdf_v",)
    assert samples.feature_names == ("albedo_2", "visibility")
    full = capture("glossy", 6, 4, 2, variant=variant)
    np.testing.assert_array_equal(samples["albedo_2"], full["albedo_2"])
    np.testing.assert_array_equal(samples.radiance, full.radiance)


def test_foreign_scene_tells_what_it_uses(variant, scalar):
    """No lens; one point light: no random number chooses a point on it; no bounce: the scattered ray is not seen."""
    bare = {
        "type": "scene",
        "camera": looking_down(3),
        "floor": rectangle(),
        "lamp": {"type": "point", "position": [0, 0, 2]},
    }
    path = {"type": "path", "max_depth": 2}
    samples = capture({**bare, "integrator": path}, 8, 8, 2, variant=variant)
    assert samples.random_param_names == ()
    assert samples.feature_names == ("world_position", "shading_normal", "albedo", "visibility")
    assert not samples.hit.all()
    missed = ~samples.hit
    for name in samples.feature_names:
        assert not samples[name][missed].any()
    deeper = capture({**bare, "sky": {"type": "constant"}}, 8, 8, 2, variant=variant)
    assert deeper.random_param_names == ("light_u", "light_v", "bsdf_u", "bsdf_v")


def test_albedo_is_diffuse_reflectance(variant, scalar):
    import mitsuba as mi

    colour = {"type": "rgb", "value": [0.2, 0.4, 0.8]}
    bsdfs = [
        ({"type": "diffuse", "reflectance": colour}, [0.2, 0.4, 0.8]),
        ({"type": "roughconductor", "material": "Cu"}, [0, 0, 0]),
        ({"type": "conductor", "material": "Cu"}, [0, 0, 0]),
        ({"type": "dielectric"}, [0, 0, 0]),
        ({"type": "twosided", "one": {"type": "diffuse", "reflectance": colour}}, [0.2, 0.4, 0.8]),
    ]
    scene = {"type": "scene", "camera": looking_down(1), "light": {"type": "constant"}}
    for k, (bsdf, _) in enumerate(bsdfs):
        pose = mi.ScalarTransform4f().translate([0.2 * (k - 2), 0, 0]).scale([0.1, 1, 1])
        scene[f"tile{k}"] = {"type": "rectangle", "to_world": pose, "bsdf": bsdf}
    samples = capture(scene, 16, 16, 2, variant=variant, features=["world_position", "albedo"])
    tile = np.round(samples["world_position"][..., 0] / 0.2 + 2).astype(int)
    expected = np.array([albedo for _, albedo in bsdfs])[tile]
    assert set(tile.ravel()) == set(range(5))
    np.testing.assert_allclose(samples["albedo"], expected, atol=1e-6)
    assert mi.variant() == "scalar_rgb"


XML = """<scene version="3.0.0">
  <sensor type="perspective"><float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0,0,3" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="1000"/><rfilter type="gaussian"/></film></sensor>
  <sensor type="orthographic"/>
  <integrator type="path"><integer name="max_depth" value="2"/></integrator>
  <emitter type="constant"/>
  <shape type="rectangle"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
    <string name="filename" value="grey.exr"/><boolean name="raw" value="true"/></texture></bsdf></shape>
</scene>"""


def test_xml_file_is_the_scene_of_the_same_dict(variant, scalar, tmp_path):
    from mcdenoise.render import write_exr

    write_exr(tmp_path / "grey.exr", np.full((2, 2, 3), 0.25))
    (tmp_path / "scene.xml").write_text(XML)
    samples = capture(tmp_path / "scene.xml", 8, 6, 4, seed=3, variant=variant)
    floor = rectangle(bsdf={"type": "diffuse", "reflectance": 0.25})
    path = {"type": "path", "max_depth": 2}
    twin = {"type": "scene", "integrator": path, "camera": looking_down(3), "sky": {"type": "constant"}, "floor": floor}
    expected = capture(twin, 8, 6, 4, seed=3, variant=variant)
    np.testing.assert_allclose(samples.radiance, expected.radiance, atol=1e-5)
    assert samples.layout == expected.layout


# Bad input


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scene": "doff"}, r"scene has no 'doff'; there is: dof, .*; or pass a dict or an \.xml file"),
        ({"scene": "nowhere.xml"}, "scene names the file nowhere.xml, but there is none"),
        ({"scene": 3}, "scene must be a name .*, a Mitsuba dict or the path of a Mitsuba XML file, got a int"),
        ({"scene": {"type": "scene"}}, "a camera given as a dict of type perspective or thinlens .* got the keys type"),
        ({"scene": {"type": "scene", "c": {"type": "perspective"}, "x": {"type": "cub"}}}, "Mitsuba refuses .*cub"),
        ({"width": 0}, "width must be at least 1, got 0"),
        ({"height": 2.5}, r"height must be a whole number, got 2\.5"),
        ({"spp": "8"}, "spp must be a whole number, got '8'"),
        ({"seed": -1}, "seed must be at least 0, got -1"),
        ({"seed": 2**32}, r"seed must be below 2\*\*32"),
        ({"variant": "fast"}, "variant must be one of"),
        ({"nonfinite": "drop"}, "nonfinite must be one of"),
        ({"random_params": ["time"]}, "random_params has no 'time'; there is: lens_u"),
        ({"features": "albedo"}, "features must be a list of names"),
        ({"features": ["depth"]}, "features has no 'depth'; there is: world_position"),
    ],
)
def test_bad_arguments(arguments, message):
    with pytest.raises(ValueError, match=message):
        capture(**{"scene": "dof", "width": 4, "height": 4, "spp": 1, "variant": "scalar_rgb"} | arguments)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<scene", r"Mitsuba refuses the scene file .*\.xml: .*line 1"),
        ('<scene version="3.0.0"/>', "it has no <sensor> at its top level"),
        ('<scene version="3.0.0"><sensor type="perspective"/><shape type="cub"/></scene>', "refuses .*cub"),
    ],
)
def test_bad_files(tmp_path, text, message):
    (tmp_path / "bad.xml").write_text(text)
    with pytest.raises(ValueError, match=message):
        capture(str(tmp_path / "bad.xml"), 4, 4, 1, variant="scalar_rgb")


def test_nonfinite_samples(variant, scalar):
    scene = {"type": "scene", "camera": looking_down(3), "sky": {"type": "constant", "radiance": float("inf")}}
    with pytest.raises(ValueError, match="radiance must be finite: 96 of 96 values are NaN or infinite"):
        capture(scene, 4, 4, 2, variant=variant)
    assert not capture(scene, 4, 4, 2, variant=variant, nonfinite="zero").radiance.any()


def test_scene_names_are_the_toy_scenes():
    assert scene_names() == tuple(SCENES)
