"""Random parameter filtering: its limits, its ladder, its ablations, and the same numbers from both engines."""

from dataclasses import replace

import numba
import numpy as np
import pytest

import mcdenoise as mcd
from mcdenoise import RPFConfig
from mcdenoise.rpf.blend import blend_sums, pair_weights, remove_spikes
from mcdenoise.rpf.config import PRESETS
from mcdenoise.rpf.draws import first_entries, offset_table, pixel_key, random_bits
from mcdenoise.rpf.neighbourhood import choose_samples, feature_limits, is_like, standardise
from rpf_scenes import blurred, buffer, edge

pytestmark = pytest.mark.ch06

SMALL = {"boxes": (9, 5)}
CONFIGS = {name: make(**({} if name == "adaptive" else SMALL)) for name, make in PRESETS.items()}
BOX = RPFConfig.lecture(boxes=(5,), deterministic=True)


def mixed(size=9, spp=4, seed=3, **more):
    """Radiance and features that depend on everything a little."""

    def radiance(x, y, params):
        return 0.5 + 0.3 * np.sin(x) + 0.4 * params["lens_u"] * (y > 4)

    features = {
        "world_position": lambda x, y, params: x + params["lens_v"],
        "albedo": lambda x, y, params: 0.2 + 0.5 * (y > 4),
    }
    return buffer(size, spp, radiance, features, seed=seed, **more)


# --- both engines


@pytest.mark.parametrize("name", CONFIGS)
def test_both_engines_agree(name):
    samples = mixed()
    fast, plain = (mcd.rpf(samples, CONFIGS[name], engine=engine, seed=5) for engine in ("numba", "numpy"))
    assert fast.shape == (9, 9, 3)
    assert fast.dtype == np.float32
    np.testing.assert_allclose(fast, plain, rtol=2e-5)


@pytest.mark.parametrize(
    "changes",
    [
        {"deterministic": True},
        {"clustering": False, "spikes": "joint"},
        {"alpha": 1.0, "beta": 0.0},
        {"alpha": 0.3},
        {"random_params": ("lens_v",)},
        {"random_params": ()},
        {"passes": (1,)},
        {"chance": 1.0, "levels": 5, "spikes": "clamp"},
        {"noise_gain": 3.0, "deterministic": True, "clustering": False},
    ],
    ids=str,
)
def test_both_engines_agree_with_every_switch(changes):
    samples = mixed()
    config = RPFConfig.technical_report(**{**SMALL, "spikes": "none", **changes})
    fast, plain = (mcd.rpf(samples, config, engine=engine) for engine in ("numba", "numpy"))
    np.testing.assert_allclose(fast, plain, rtol=2e-5)


def test_the_maps_of_the_kernel_are_those_of_the_formulas():
    samples, config = mixed(), RPFConfig.technical_report(**SMALL)
    maps = mcd.rpf_analysis(samples, config, pass_=1, seed=2)
    for pixel in ((0, 0), (4, 4), (8, 3)):
        found = mcd.rpf_neighbourhood(samples, pixel, config, pass_=1, seed=2)
        assert maps.accepted[pixel] == found.accepted.sum()
        for name in ("alpha", "beta", "share_c_r", "share_f_r"):
            np.testing.assert_allclose(getattr(maps, name)[pixel], getattr(found, name), atol=2e-6)
        np.testing.assert_allclose(maps.share_c_r_each[pixel], found.dependency.share_c_r_each, atol=2e-6)
        np.testing.assert_allclose(maps.share_c_f[pixel], found.dependency.share_c_f, atol=2e-6)
        np.testing.assert_allclose(maps.share_c_r_all[pixel], found.share_c_r.mean(), atol=2e-6)


def test_the_image_is_what_the_weights_of_one_pixel_give():
    samples, config = mixed(), RPFConfig.lecture(boxes=(5,))
    found = mcd.rpf_neighbourhood(samples, (4, 5), config, seed=1)
    blended = found.weights @ found.radiance / found.weights.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(mcd.rpf(samples, config, seed=1)[4, 5], blended.mean(axis=0), rtol=1e-5)
    np.testing.assert_array_equal(found.weights[:, ~found.accepted], 0)
    np.testing.assert_allclose(np.diag(found.weights[:, :4]), 1)


def test_same_bits_for_a_seed_at_any_number_of_threads():
    if numba.config.NUMBA_NUM_THREADS < 2:
        pytest.skip("numba was started with one thread only")
    samples, config = mixed(size=20), RPFConfig.technical_report(**SMALL)
    before = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        one = mcd.rpf(samples, config, seed=7)
        numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)
        np.testing.assert_array_equal(one, mcd.rpf(samples, config, seed=7))
    finally:
        numba.set_num_threads(before)
    assert (one != mcd.rpf(samples, config, seed=8)).any()


def test_the_default_needs_no_seed():
    samples = mixed()
    np.testing.assert_array_equal(mcd.rpf(samples, seed=0), mcd.rpf(samples, seed=1))


# --- the draws


def test_random_bits_are_those_of_splitmix64():
    """The first outputs for the state 1234567, known from the generator's public description."""
    first = [6457827717110365317, 3203168211198807973, 9817491932198370423]
    assert random_bits(1234567, np.arange(1, 4)).tolist() == first


@pytest.mark.parametrize("box", [7, 55])
def test_offsets_are_a_rounded_gaussian_inside_the_box(box):
    """Counts within 5 standard errors of box / 4; the same offsets in x and in y, apart from each other."""
    size, spp = 61, 3
    chosen = choose_samples((size, size, spp), (30, 30), box, 40_000, seed=1, turn=0)[spp:]
    assert len(chosen) == 40_000
    assert (np.abs(chosen[:, :2] - 30) <= box // 2).all()
    assert not ((chosen[:, :2] == 30).all(axis=1)).any()
    offsets = np.arange(-(box // 2), box // 2 + 1)
    from scipy.stats import norm

    one = np.diff(norm.cdf(np.arange(-(box // 2), box // 2 + 2) - 0.5, scale=box / 4))
    both = np.outer(one, one)
    both[box // 2, box // 2] = 0
    both /= both.sum()
    for axis, expected in ((0, both.sum(axis=1)), (1, both.sum(axis=0))):
        counts = np.array([(chosen[:, axis] - 30 == offset).sum() for offset in offsets])
        assert (np.abs(counts - 40_000 * expected) < 5 * np.sqrt(40_000 * expected) + 4).all()
    counts = np.bincount(chosen[:, 2], minlength=spp)
    assert (np.abs(counts - 40_000 / spp) < 5 * np.sqrt(40_000 / spp)).all()
    assert abs(np.corrcoef(chosen[:, 0], chosen[:, 1])[0, 1]) < 5 / np.sqrt(40_000)


def test_at_a_corner_the_gaussian_is_cut_not_folded():
    chosen = choose_samples((9, 9, 2), (0, 8), 7, 5000, seed=0, turn=0)[2:]
    assert (chosen[:, 0] >= 0).all()
    assert (chosen[:, 1] <= 8).all()
    assert (chosen[:, 0] <= 3).all()
    assert (chosen[:, 1] >= 5).all()
    rows = np.bincount(chosen[:, 0])
    assert (np.diff(rows[1:]) < 0).all()
    assert rows[0] > rows[2]


def test_the_samples_of_the_pixel_come_first_and_in_order():
    chosen = choose_samples((5, 5, 3), (2, 1), 5, 30, seed=0, turn=2)
    assert chosen[:3].tolist() == [[2, 1, 0], [2, 1, 1], [2, 1, 2]]
    assert len(choose_samples((1, 1, 3), (0, 0), 5, 30, seed=0, turn=0)) == 3


def test_every_pixel_and_pass_draws_for_itself():
    keys = {int(pixel_key(seed, turn, pixel)) for seed in range(4) for turn in range(4) for pixel in range(100)}
    assert len(keys) == 1600


def test_the_table_of_offsets_is_symmetric_and_its_entries_begin_where_it_says():
    for box in (3, 17, 55):
        table = offset_table(box, box / 4)
        first = first_entries(table, box)
        counts = np.diff(first)
        np.testing.assert_array_equal(counts, counts[::-1])
        assert counts.sum() == len(table)
        assert (counts > 0).all()


# --- the neighbourhood


def test_clustering_leaves_out_what_is_far_in_any_feature():
    own = np.array([[0.0, 5.0], [2.0, 5.0]])  # means 1 and 5, deviations 1 and 0
    limits = np.array([3.0, 3.0])
    candidates = np.array([[1.0, 5.0], [4.0, 5.0], [4.1, 5.0], [1.0, 5.09], [1.0, 5.11]])
    assert is_like(candidates, own, limits, tolerance=0.1).tolist() == [True, True, False, True, False]


def test_world_positions_may_be_ten_times_as_far():
    samples = buffer(2, 2, features={"world_position": 0.0, "albedo": 0.0, "world_position_2": 0.0})
    assert feature_limits(samples).tolist() == [30] * 3 + [3] * 3 + [30] * 3


def test_standardised_columns_have_mean_0_and_deviation_1():
    values = np.random.default_rng(0).normal(7, 3, (50, 3))
    values[:, 1] = 1e-6 * values[:, 1]
    values[:, 2] = np.float32(0.1)
    result, scale = standardise(values)
    np.testing.assert_allclose(result[:, :2].mean(axis=0), 0, atol=1e-8)
    np.testing.assert_allclose(result[:, :2].std(axis=0), 1, rtol=1e-9)
    assert (result[:, 2] == 0).all()
    assert scale[2] == 0


# --- the filter


def test_weights_are_symmetric_one_for_itself_and_fall_with_distance():
    x = np.random.default_rng(1).normal(size=(6, 4))
    weights = pair_weights(x, np.array([0.1, 0.2, 0.3, 0.4]), spp=6)
    np.testing.assert_allclose(weights, weights.T)
    np.testing.assert_allclose(np.diag(weights), 1)
    np.testing.assert_allclose(weights[0, 1], np.exp(-((x[0] - x[1]) ** 2 @ [0.1, 0.2, 0.3, 0.4])))
    total, norm = blend_sums(weights, np.ones((6, 3)))
    np.testing.assert_allclose(total, norm[:, np.newaxis].repeat(3, axis=1))


def test_alpha_and_beta_0_average_the_box():
    """Without clustering and with every sample, this is a Gaussian average over the samples of the box."""
    samples = buffer(9, 4, radiance=np.random.default_rng(0).random((9, 9, 4, 3)))
    config = RPFConfig.lecture(boxes=(5,), deterministic=True, clustering=False, alpha=0.0, beta=0.0)
    image = mcd.rpf(samples, config)
    p, c = samples.screen_position[2:7, 2:7].reshape(-1, 2), samples.radiance[2:7, 2:7].reshape(-1, 3)
    own = samples.screen_position[4, 4]
    weight = np.exp(-((own[:, np.newaxis] - p) ** 2).sum(axis=-1) / (2 * 1.25**2))
    np.testing.assert_allclose(image[4, 4], (weight @ c / weight.sum(axis=1, keepdims=True)).mean(axis=0), rtol=1e-5)


def test_alpha_and_beta_1_keep_noise_and_0_blurs():
    """The corners of the lecture, on an edge of radiance with noise of the lens."""
    samples = buffer(12, 8, lambda x, y, p: edge(x, y, p) + 0.2 * p["lens_u"], {"albedo": edge})
    noisy = mcd.pixel_mean(samples.radiance)
    corner = {
        (a, b): mcd.rpf(samples, RPFConfig.lecture(alpha=a, beta=b, boxes=(9, 5), clustering=False))
        for a in (0.0, 1.0)
        for b in (0.0, 1.0)
    }
    left = np.s_[:, :4]
    assert corner[1.0, 1.0][left].std() > 0.8 * noisy[left].std()
    assert corner[0.0, 1.0][left].std() < 0.3 * noisy[left].std()
    truth = 0.1 + edge(np.arange(12) + 0.5, 0, {})
    blur = {key: np.abs(image[2:-2, 4:8, 0].mean(axis=0) - truth[4:8]).max() for key, image in corner.items()}
    assert blur[0.0, 0.0] > 0.1
    assert blur[0.0, 1.0] < 0.03
    assert blur[1.0, 1.0] < 0.03


@pytest.mark.parametrize("name", CONFIGS)
def test_what_has_no_noise_is_unchanged(name):
    samples = buffer(8, 4, radiance=0.7, features={"albedo": 0.3, "world_position": lambda x, y, p: x})
    np.testing.assert_allclose(mcd.rpf(samples, CONFIGS[name]), 0.7, rtol=1e-6)


@pytest.mark.parametrize("name", ["lecture", "technical report", "NVIDIA", "adaptive"])
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scaling_all_radiance_scales_the_image(name, scale):
    """The authors' release cuts radiance off at 10, so it is not among them."""
    samples = mixed()
    config = CONFIGS[name]
    larger = mcd.SampleBuffer.from_arrays(
        samples.radiance * np.float32(scale),
        samples.screen_position,
        {name: samples[name] for name in samples.random_param_names},
        {name: samples[name] for name in samples.feature_names},
    )
    np.testing.assert_allclose(mcd.rpf(larger, config), scale * mcd.rpf(samples, config), rtol=2e-4)


def test_lens_noise_goes_and_an_edge_stays():
    """What only the lens explains is averaged; what only the place explains is kept. Truth is known for both."""
    noise, step = buffer(12, 8, blurred), buffer(12, 8, edge)
    for name in ("adaptive", "technical report"):
        config = RPFConfig.adaptive() if name == "adaptive" else RPFConfig.technical_report(spikes="none", **SMALL)
        before, after = (
            np.sqrt(((image - 0.5) ** 2).mean()) for image in (mcd.pixel_mean(noise.radiance), mcd.rpf(noise, config))
        )
        assert after < 0.5 * before
        np.testing.assert_allclose(mcd.rpf(step, config)[:, :5], 0.2, atol=0.02)
        np.testing.assert_allclose(mcd.rpf(step, config)[:, 7:], 0.8, atol=0.02)


# --- ablations


def test_without_the_lens_the_noise_of_the_lens_stays():
    """Mean square error against the truth 0.5. Chance alone gives the light W = 1/2, so not all of the noise comes back."""
    samples = buffer(14, 8, blurred, random_params=("lens_u", "lens_v", "light_u", "light_v"))
    report, lecture = (
        RPFConfig.technical_report(spikes="none", **SMALL),
        RPFConfig.lecture(sigma_8_squared=0.3, **SMALL),
    )
    for config, factor in ((report, 2), (lecture, 2), (RPFConfig.adaptive(), 1.25)):
        without = replace(config, random_params=("light_u", "light_v"))
        error, without_error = (((mcd.rpf(samples, one) - 0.5) ** 2).mean() for one in (config, without))
        assert without_error > factor * error


@pytest.mark.parametrize(
    ("fixed", "factor"), [({"alpha": 0.0, "beta": 0.0}, 10), ({}, 1.15)], ids=["fixed", "measured"]
)
def test_without_clustering_edges_get_worse(fixed, factor):
    """With alpha = beta = 0 nothing else keeps the two sides apart; with the measured ones it still helps."""

    def lit(x, y, params):
        return edge(x, y, params) * (0.2 + 1.6 * (params["light_u"] > 0.5))

    samples = buffer(14, 8, lit, {"albedo": edge}, ("light_u", "light_v"))
    truth = edge(np.arange(14) + 0.5, 0, {})[np.newaxis, :, np.newaxis]
    kept, dropped = (
        ((mcd.rpf(samples, RPFConfig.technical_report(clustering=on, **SMALL, **fixed)) - truth)[:, 4:8] ** 2).mean()
        for on in (True, False)
    )
    assert dropped > factor * kept


def test_passes_are_chained():
    """Two passes are the second run on what the first gave; the original radiance stays in the weights."""
    samples = mixed()
    config = RPFConfig.lecture(**SMALL, alpha=0.0, beta=0.0, clustering=False)
    both, second = mcd.rpf(samples, config), mcd.rpf(samples, replace(config, passes=(1,)))
    assert both.std() < 0.8 * second.std()


# --- spikes


def test_what_each_kind_of_spike_handling_does_to_the_mean():
    rng = np.random.default_rng(0)
    blended = rng.random((8, 3))
    blended[2] += 50
    mean = blended.mean(axis=0)
    np.testing.assert_array_equal(remove_spikes(blended, "none"), blended)
    np.testing.assert_allclose(remove_spikes(blended, "joint").mean(axis=0), mean)
    assert (remove_spikes(blended, "clamp", 0.5).mean(axis=0) < mean).all()
    set_to_mean = remove_spikes(blended, "mean")
    np.testing.assert_allclose(set_to_mean[2], mean)
    assert (set_to_mean.mean(axis=0) < mean).all()  # one bright sample: what is lost is lost
    dark = -blended
    np.testing.assert_allclose(remove_spikes(dark, "mean")[2], dark.mean(axis=0))  # both sides: the absolute value
    np.testing.assert_array_equal(remove_spikes(dark, "clamp", 0.5)[2], dark[2])  # the bright side alone


def test_judging_channel_by_channel_shifts_the_hue():
    blended = np.zeros((4, 3))
    blended[0] = 9, 0, 0
    blended[1:] = 0, 1, 1
    assert remove_spikes(blended, "mean")[0].tolist() == [2.25, 0.75, 0.75]
    np.testing.assert_allclose(remove_spikes(blended, "joint").mean(axis=0), blended.mean(axis=0))


# --- a real scene


def test_on_the_thin_lens_scene_rpf_halves_the_error_of_the_samples_and_keeps_energy():
    samples = mcd.capture("dof", 64, 64, 8, seed=0, variant="scalar_rgb", progress=False)
    many = mcd.pixel_mean(mcd.capture("dof", 64, 64, 256, seed=1, variant="scalar_rgb", progress=False).radiance)
    noisy, image = mcd.pixel_mean(samples.radiance), mcd.rpf(samples)
    assert mcd.relmse(image, many) < 0.5 * mcd.relmse(noisy, many)
    assert abs(image.mean() / noisy.mean() - 1) < 0.03
    no_lens = mcd.rpf(samples, RPFConfig.adaptive(random_params=("light_u", "light_v")))
    blurred_part = samples["world_position"].var(axis=2).sum(axis=-1) > 0.02
    errors = [mcd.relmse_map(one, many).mean(axis=-1)[blurred_part].mean() for one in (image, no_lens)]
    assert errors[1] > 1.5 * errors[0]
