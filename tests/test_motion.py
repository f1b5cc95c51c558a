"""Motion: time is a random parameter like any other, and what stands still does not know it."""

import numpy as np
import pytest

from mcdenoise.render import ToyScene, capture, choose_variant, render_image
from mcdenoise.render.motion import TIME_SLICES, Poser, slice_time, spread_slices
from mcdenoise.render.scene import load_scene
from mcdenoise.render.variants import use_variant

pytestmark = pytest.mark.ch01
STEP, BOX_STEP = (0.3, 0.8, -0.2), (0.0, -0.6, 0.1)


@pytest.fixture(scope="module", params=("scalar_rgb", "llvm_ad_rgb"))
def variant(request):
    if request.param == "llvm_ad_rgb" and choose_variant() != request.param:
        pytest.skip("no LLVM library works with Dr.Jit on this machine")
    return request.param


def build():
    """A red ball and a green box over a grey floor, seen from above without perspective: the floor's z is 0."""
    import mitsuba as mi

    def put(x, z, scale):
        return mi.ScalarTransform4f().translate([x, 0, z]).scale(scale)

    def paint(*colour):
        return {"type": "diffuse", "reflectance": {"type": "rgb", "value": colour}}

    pose = mi.ScalarTransform4f().look_at(origin=[0, 0, 3], target=[0, 0, 0], up=[0, 1, 0])
    return {
        "type": "scene",
        "camera": {"type": "orthographic", "to_world": pose},
        "sky": {"type": "constant"},
        "floor": {"type": "rectangle", "to_world": put(0, 0, 3)},
        "ball": {"type": "sphere", "to_world": put(-0.4, 1, 0.25), "bsdf": paint(0.8, 0.1, 0.1)},
        "box": {"type": "cube", "to_world": put(0.4, 1, 0.2), "bsdf": paint(0.1, 0.8, 0.1)},
    }


def scene(**motion):
    return ToyScene(
        name="moving",
        idea="A ball and a box move.",
        build=build,
        random_params=("time",),
        features=("world_position", "albedo"),
        max_depth=2,
        motion=motion,
    )


MOVING = scene(ball=STEP, box=BOX_STEP)


@pytest.fixture(scope="module")
def samples(variant):
    return capture(MOVING, 24, 24, 16, seed=1, variant=variant)


def test_objects_move_by_their_displacement(samples):
    position, time = samples["world_position"].astype(np.float64), samples["time"].astype(np.float64)
    colours = {"ball": (0, STEP, (-0.4, 0, 1), 0.25), "box": (1, BOX_STEP, (0.4, 0, 1), 0.2)}
    for name, (channel, step, centre, radius) in colours.items():
        chosen = samples["albedo"][..., channel] > 0.7
        assert 0.02 < chosen.mean() < 0.3, name
        assert np.ptp(time[chosen]) > 0.9, name
        at_rest = (position - (time - 0.5)[..., np.newaxis] * step - centre)[chosen]
        norm = np.linalg.norm(at_rest, axis=-1, ord=2 if name == "ball" else np.inf)
        np.testing.assert_allclose(norm, radius, atol=1e-5, err_msg=name)


def test_floor_does_not_know_the_time(samples):
    floor = np.ptp(samples["albedo"], axis=-1) < 0.1
    position, time = samples["world_position"][floor].astype(np.float64), samples["time"][floor]
    screen = np.column_stack([samples.screen_position[floor], np.ones(floor.sum()), time])
    slope, *_ = np.linalg.lstsq(screen, position, rcond=None)
    np.testing.assert_allclose(screen @ slope, position, atol=1e-5)
    np.testing.assert_allclose(slope[3], 0, atol=1e-6)


def test_times_are_independent_and_uniform_over_the_slices(samples):
    time = samples["time"].astype(np.float64)
    index = time * TIME_SLICES - 0.5
    np.testing.assert_array_equal(index, np.round(index))
    counts = np.bincount(index.astype(int).ravel(), minlength=TIME_SLICES)
    expected = time.size / TIME_SLICES
    chi2 = ((counts - expected) ** 2 / expected).sum()
    assert abs(chi2 - (TIME_SLICES - 1)) < 4 * np.sqrt(2 * (TIME_SLICES - 1))
    first, second = time[..., ::2].ravel(), time[..., 1::2].ravel()
    assert abs(np.corrcoef(first, second)[0, 1]) < 4 / np.sqrt(first.size)


def test_samples_and_image_have_the_same_expectation(variant):
    samples = capture(MOVING, 12, 12, 256, seed=1, variant=variant)
    image = render_image(MOVING, 12, 12, 512, seed=1, variant=variant)
    error = samples.radiance.std(axis=2, ddof=1) / np.sqrt(samples.spp)
    error = np.hypot(error, error / np.sqrt(2))
    excess = np.abs(samples.radiance.mean(axis=2) - image) / (error + 1e-4)
    assert excess.max() < 5  # 432 comparisons: the largest of so many normal deviates
    assert np.sqrt((excess**2).mean()) < 1.2


def test_image_is_as_noisy_as_samples_with_independent_times():
    """The rival of every filter may not have better times than the samples that the filters get."""
    truth = render_image(MOVING, 24, 24, 512, seed=99, variant="scalar_rgb").astype(np.float64)

    def error(image):
        return float(((image - truth) ** 2).mean())

    of_image = np.array([error(render_image(MOVING, 24, 24, 4, seed, variant="scalar_rgb")) for seed in range(12)])
    of_samples = np.array(
        [error(capture(MOVING, 24, 24, 4, seed, variant="scalar_rgb").radiance.mean(axis=2)) for seed in range(12)]
    )
    deviation = np.sqrt(of_image.var(ddof=1) / 12 + of_samples.var(ddof=1) / 12)
    assert abs(of_image.mean() - of_samples.mean()) < 4 * deviation
    assert deviation < 0.1 * of_samples.mean()


def test_poses_do_not_add_up(variant):
    """Posing for one time after another ends where posing for the last alone does."""
    with use_variant(variant):
        import mitsuba as mi

        images = []
        for times in ([0.9], [0.1, 0.5, 0.3, 0.9]):
            ready = load_scene(MOVING, 8, 8)
            for time in times:
                ready.poser.at(time)
            images.append(np.array(mi.render(ready.scene, integrator=ready.integrator, spp=4, seed=1)))
    np.testing.assert_allclose(*images, atol=1e-6)


def test_no_motion_no_time():
    still = scene()
    with pytest.raises(ValueError, match="random_params has no 'time'"):
        capture(still, 4, 4, 1, variant="scalar_rgb")
    samples = capture(still, 4, 4, 1, variant="scalar_rgb", random_params=[])
    assert samples.random_param_names == ()


def test_open_shutter_of_a_foreign_scene_is_no_motion(variant):
    with use_variant(variant):
        description = build()
    description["camera"] |= {"shutter_open": 0.0, "shutter_close": 1.0}
    assert "time" not in capture(description, 4, 4, 1, variant=variant).random_param_names


def test_motion_of_nothing():
    with pytest.raises(ValueError, match=r"motion names 'bat', which can not be moved; what can: .*ball, box"):
        capture(scene(bat=STEP), 4, 4, 1, variant="scalar_rgb")


def test_object_without_a_place_can_not_move():
    with use_variant("scalar_rgb"):
        ready = load_scene(scene(), 4, 4)
        with pytest.raises(ValueError, match="motion names 'sky'"):
            Poser(ready.scene, {"sky": STEP})


@pytest.mark.parametrize("spp", [1, 8, 100, 256, 1000])
def test_image_spreads_its_samples_over_the_open_shutter(spp):
    counts = np.array([spread_slices(np.random.default_rng(seed), spp) for seed in range(200)])
    assert counts.shape == (200, TIME_SLICES)
    assert (counts.sum(axis=1) == spp).all()
    times = (counts * [slice_time(k) for k in range(TIME_SLICES)]).sum(axis=1) / spp
    error = max(times.std(ddof=1), 1e-9) / np.sqrt(len(times))
    assert abs(times.mean() - 0.5) < 4 * error
    assert (np.abs(counts.mean(axis=0) - spp / TIME_SLICES) < 5 * np.sqrt(spp / TIME_SLICES / 200)).all()
