"""References: rendered once, kept, never wrong because of what lies in the cache."""

import numpy as np
import pytest

from mcdenoise.render import capture, choose_variant, reference, render_image, render_reference
from mcdenoise.render.scene import load_scene
from mcdenoise.render.variants import use_variant

pytestmark = pytest.mark.ch01
SMALL = {"width": 12, "height": 8, "spp": 8, "variant": "scalar_rgb"}


@pytest.fixture(autouse=True)
def cache(monkeypatch, tmp_path):
    monkeypatch.setenv("MCDENOISE_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache" / "references"


@pytest.fixture
def renders(monkeypatch):
    """The label of each scene that was really rendered."""
    done, real = [], reference._rendered

    def counted(ready, *rest):
        done.append(ready.label)
        return real(ready, *rest)

    monkeypatch.setattr(reference, "_rendered", counted)
    return done


@pytest.fixture(params=("scalar_rgb", "llvm_ad_rgb"))
def variant(request):
    if request.param == "llvm_ad_rgb" and choose_variant() != request.param:
        pytest.skip("no LLVM library works with Dr.Jit on this machine")
    return request.param


def test_image_has_the_expectation_of_the_samples(variant):
    samples = capture("dof", 16, 12, 256, seed=1, variant=variant)
    image = render_image("dof", 16, 12, 512, seed=1, variant=variant)
    assert image.shape == (12, 16, 3)
    assert image.dtype == np.float32
    mean = samples.radiance.mean(axis=(0, 1, 2), dtype=np.float64)
    spread = (samples.radiance.var(axis=2, ddof=1, dtype=np.float64) / samples.spp).sum(axis=(0, 1))
    error = np.sqrt(spread * 1.5) / (16 * 12)
    assert (np.abs(image.mean(axis=(0, 1)) - mean) < 4 * error).all()


def test_chunks_are_averaged_with_their_weights(variant, monkeypatch):
    seeds = {}
    monkeypatch.setattr(reference, "CHUNK", 12 * 8 * 3)
    image = render_image("dof", 12, 8, 8, seed=4, variant=variant)
    with use_variant(variant):
        import mitsuba as mi

        ready = load_scene("dof", 12, 8)
        for index, count in enumerate((3, 3, 2)):
            seed = reference.derived_seed(4, reference.STREAM_IMAGE, index + 1)
            seeds[seed] = count * np.array(mi.render(ready.scene, integrator=ready.integrator, spp=count, seed=seed))
    assert len(seeds) == 3
    np.testing.assert_allclose(image, sum(seeds.values()) / 8, rtol=1e-5, atol=1e-7)


def test_errors_of_reference_image_and_samples_are_independent(variant):
    """At one seed the three share no random numbers, so their errors do not go together."""
    size = {"width": 24, "height": 24, "seed": 3, "variant": variant}
    truth = render_image("soft_shadow", 24, 24, 512, seed=9, variant=variant)
    errors = [
        (capture("soft_shadow", spp=4, **size).radiance.mean(axis=2) - truth).mean(axis=2).ravel(),
        (render_image("soft_shadow", spp=4, **size) - truth).mean(axis=2).ravel(),
        (render_reference("soft_shadow", spp=4, **size) - truth).mean(axis=2).ravel(),
    ]
    noise = np.median(np.abs(errors), axis=1)[:, np.newaxis]
    correlation = np.corrcoef(np.clip(errors, -6 * noise, 6 * noise))
    assert (np.abs(correlation[~np.eye(3, dtype=bool)]) < 4 / 24).all()


def test_second_call_loads(cache, renders):
    first = render_reference("dof", **SMALL)
    second = render_reference("dof", **SMALL)
    np.testing.assert_array_equal(first, second)
    assert first.shape == (8, 12, 3)
    assert first.dtype == second.dtype == np.float32
    assert renders == ["dof"]
    assert len(list(cache.iterdir())) == 1


def test_everything_that_matters_is_in_the_key(cache, renders, tmp_path, monkeypatch):
    import mitsuba as mi

    with use_variant("scalar_rgb"):
        grey = mi.Bitmap(np.full((2, 2, 3), 0.25, np.float32))
        camera = {"type": "perspective", "to_world": mi.ScalarTransform4f().translate([0, 0, -3])}
    scene = {"type": "scene", "camera": camera, "sky": {"type": "constant"}, "ball": {"type": "sphere"}}
    texture = {"type": "bitmap", "bitmap": grey, "raw": True}
    for change in ({}, {"seed": 1}, {"spp": 4}, {"width": 8}, {"height": 12}):
        render_reference(scene, **SMALL | change)
    render_reference(scene | {"integrator": {"type": "path", "max_depth": 2}}, **SMALL)
    render_reference(scene | {"ball": {"type": "sphere", "radius": 0.5}}, **SMALL)
    render_reference(scene | {"ball": {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": texture}}}, **SMALL)
    monkeypatch.setattr(reference, "version", lambda package: "0")
    render_reference(scene, **SMALL)
    assert len(renders) == len(list(cache.iterdir())) == 9


def test_xml_file_that_changes(renders, tmp_path):
    file = tmp_path / "scene.xml"
    text = '<scene version="3.0.0"><sensor type="perspective"/><emitter type="constant"/></scene>'
    file.write_text(text)
    render_reference(file, **SMALL)
    render_reference(str(file), **SMALL)
    file.write_text(text.replace("constant", "point"))
    assert not render_reference(file, **SMALL).any()
    assert len(renders) == 2


def test_scene_that_hides_its_content_is_rendered_every_time(cache, renders):
    with use_variant("scalar_rgb"):
        import mitsuba as mi

        ball = mi.load_dict({"type": "sphere"})
        for _ in range(2):
            render_reference({"type": "scene", "c": {"type": "perspective"}, "ball": ball}, **SMALL)
    assert len(renders) == 2
    assert not cache.exists()


@pytest.mark.parametrize("damage", ["empty", "cut", "text", "shape", "nan", "pickle"])
def test_damaged_file_is_rendered_again(cache, renders, damage):
    image = render_reference("dof", **SMALL)
    (file,) = cache.iterdir()
    if damage in ("empty", "cut"):
        file.write_bytes(file.read_bytes()[: 0 if damage == "empty" else 200])
    elif damage == "text":
        file.write_text("no array")
    else:
        bad = {"shape": image[:4], "nan": image * np.float32(np.nan), "pickle": np.array([{}])}[damage]
        np.save(file, bad, allow_pickle=True)
    np.testing.assert_array_equal(render_reference("dof", **SMALL), image)
    np.testing.assert_array_equal(render_reference("dof", **SMALL), image)
    assert len(renders) == 2


def test_cache_that_can_not_be_written(monkeypatch, tmp_path, capsys):
    (tmp_path / "file").touch()
    monkeypatch.setenv("MCDENOISE_CACHE", str(tmp_path / "file"))
    assert render_reference("dof", **SMALL).any()
    assert "The reference could not be kept in" in capsys.readouterr().err


def test_pixels_that_are_never_finite():
    scene = {"type": "scene", "c": {"type": "perspective"}, "sky": {"type": "constant", "radiance": float("inf")}}
    with pytest.raises(ValueError, match="96 pixels of dict are never finite"):
        render_image(scene, **SMALL)


@pytest.mark.parametrize("render", [render_image, render_reference])
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scene": "doff"}, "scene has no 'doff'; there is: dof"),
        ({"width": 0}, "width must be at least 1, got 0"),
        ({"spp": 1.5}, r"spp must be a whole number, got 1\.5"),
        ({"seed": -1}, "seed must be at least 0, got -1"),
        ({"variant": "gpu"}, "variant must be one of"),
    ],
)
def test_bad_arguments(render, arguments, message):
    with pytest.raises(ValueError, match=message):
        render(**{"scene": "dof", **SMALL} | arguments)
