"""The constants of random parameter filtering: the published ones, what they mean, and what is refused."""

import numpy as np
import pytest

from mcdenoise import Dependency, RPFConfig
from mcdenoise.rpf.config import PRESETS, preset_table
from mcdenoise.rpf.weights import falling, scales_of, weights_of

pytestmark = pytest.mark.ch06


def found(share_c=0.25, share_f=0.5, feature=1.0):
    """A neighbourhood with these shares: two random parameters, two features."""
    return Dependency(
        c_r=np.full((3, 2), share_c / 2),
        c_p=np.full((3, 2), (1 - share_c) / 2),
        c_f=np.full((3, 2), feature / 2),
        f_r=np.full((2, 2), share_f / 2),
        f_p=np.full((2, 2), (1 - share_f) / 2),
    )


@pytest.mark.parametrize(
    ("config", "turn", "alpha", "beta"),
    [
        (RPFConfig.lecture(), 0, 0.75, 0.5),
        (RPFConfig.technical_report(), 0, 0.5, 0.25 * 0.5),
        (RPFConfig.technical_report(), 3, 1 - 2.6 * 0.25, 0.25 * (1 - 1.3 * 0.5)),
        (RPFConfig.nvidia(), 2, 1 - 1.2 * 0.25, 0.25 * (1 - 1.2 * 0.5)),
        (RPFConfig.authors_release(), 1, 0.0, 0.25 * (1 - 1.35 * 0.5)),
    ],
)
def test_alpha_and_beta_are_the_published_ones(config, turn, alpha, beta):
    """W_{c,k}^r = 1/4, W_{f,k}^r = 1/2, and each of the two features explains a quarter of all: by hand."""
    weights = weights_of(found(), config, turn, np.ones(2))
    np.testing.assert_allclose(weights.alpha, alpha)
    np.testing.assert_allclose(weights.beta, beta)
    assert weights.share == pytest.approx(0.25)


def test_w_c_r_is_the_mean_of_the_shares_or_the_share_of_the_sums():
    uneven = Dependency(
        c_r=np.array([[1.0], [0.0], [0.0]]),
        c_p=np.array([[0.0], [3.0], [0.0]]),
        c_f=np.zeros((3, 0)),
        f_r=np.zeros((0, 1)),
        f_p=np.zeros((0, 1)),
    )
    assert weights_of(uneven, RPFConfig.lecture(), 0, np.ones(0)).share == pytest.approx(1 / 3)
    assert weights_of(uneven, RPFConfig.nvidia(), 0, np.ones(0)).share == pytest.approx(1 / 4)


def test_the_share_of_a_feature_is_taken_by_the_feature_not_by_the_channel():
    c_f = np.zeros((3, 2))
    c_f[:, 1] = 1  # the second feature explains all channels, the first none
    one = Dependency(c_r=np.zeros((3, 1)), c_p=np.zeros((3, 2)), c_f=c_f, f_r=np.zeros((2, 1)), f_p=np.ones((2, 2)))
    np.testing.assert_allclose(weights_of(one, RPFConfig.technical_report(), 0, np.ones(2)).beta, [0, 1])


def test_weights_are_never_negative():
    np.testing.assert_allclose(falling(np.array([0.0, 0.4, 0.6, 1.0]), 2.0), [1, 0.2, 0, 0])


def test_fixed_weights_ask_no_dependency_and_one_of_them_still_does():
    both = weights_of(found(), RPFConfig.lecture(alpha=1.0, beta=0.0), 0, np.ones(2))
    assert both.alpha.tolist() == [1, 1, 1]
    assert both.beta.tolist() == [0, 0]
    assert both.share == 0
    one = weights_of(found(), RPFConfig.lecture(alpha=1.0), 0, np.ones(2))
    assert one.alpha.tolist() == [1, 1, 1]
    assert one.beta.tolist() == [0.5, 0.5]
    assert one.share == pytest.approx(0.25)


@pytest.mark.parametrize("spp", [4, 8, 32])
def test_sigma_falls_with_spp_in_the_report_and_with_the_pass_in_the_release(spp):
    assert RPFConfig.technical_report().precision(2, spp) == pytest.approx(spp / (16 * 0.02))
    assert RPFConfig.technical_report(noisy=False).precision(2, spp) == pytest.approx(spp / (16 * 0.002))
    assert RPFConfig.authors_release().precision(2, spp) == pytest.approx(1.1 / 0.05)


def test_at_w_1_everything_is_alike_and_nothing_is_divided_by_0():
    weights = weights_of(found(share_c=1.0), RPFConfig.lecture(), 0, np.ones(2))
    assert scales_of(weights, np.zeros(5), RPFConfig.lecture(), 0, 8).tolist() == [0] * 5


def test_noise_within_pixels_widens_by_its_share():
    """sigma_k^2 = sigma^2 + gain W_k v_k, and the factor is weight (1 - W)^2 / (2 sigma_k^2)."""
    config = RPFConfig.adaptive(noise_gain=10.0)
    weights = weights_of(found(), config, 0, np.ones(2))
    factors = scales_of(weights, np.array([0.0, 0.5, 0.0, 0.0, 0.3]), config, 0, 8)
    variances = np.array([0.002, 0.002 + 10 * 0.5 * 0.5, 0.002, 0.002, 0.002 + 10 * 0.25 * 0.3])
    np.testing.assert_allclose(factors, np.array([0.5, 0.5, 0.75, 0.75, 0.75]) * 0.75**2 / (2 * variances))


def test_m_is_half_the_box_as_published_but_64_a_sample_at_most():
    config = RPFConfig.lecture()
    assert [config.draws(turn, 8) for turn in range(4)] == [512 - 8, 512 - 8, 512 - 8, 196 - 8]
    assert [RPFConfig.lecture(sample_fraction=0.5).draws(turn, 8) for turn in (0, 3)] == [12100 - 8, 196 - 8]
    assert RPFConfig.lecture(sample_fraction=(0.1, 0.2, 0.3, 0.4)).draws(2, 8) == round(0.3 * 289 * 8) - 8
    assert RPFConfig.lecture(boxes=(1,)).draws(0, 4) == 0


def test_presets_differ_as_the_table_says():
    table = preset_table()
    for words in ("technical report", "authors' release", "sigma_8_squared", "feature_gains", "spikes"):
        assert words in table
    row = next(line.split() for line in table.splitlines() if line.startswith("spikes"))
    assert row == ["spikes", "none", "mean", "joint", "clamp", "none"]
    assert "levels" not in preset_table({"a": RPFConfig.lecture(), "b": RPFConfig.lecture(alpha=1.0)})


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_takes_changes(name):
    assert PRESETS[name](alpha=0.5).alpha == 0.5
    with pytest.raises(TypeError):
        PRESETS[name](aplha=0.5)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"boxes": (8,)}, "Take 7 or 9 for 8"),
        ({"boxes": ()}, "boxes must be the sides"),
        ({"boxes": 7}, "boxes must be the sides"),
        ({"boxes": (7.0,)}, "must be a whole number"),
        ({"sample_fraction": 0.0}, "sample_fraction must be greater than 0"),
        ({"sample_fraction": np.inf}, "pass deterministic=True"),
        ({"sample_fraction": (0.5, 0.5)}, "one for each of the 4 boxes"),
        ({"passes": (4,)}, "from 0 to 3"),
        ({"passes": (1, 0)}, "ascending order"),
        ({"passes": ()}, "passes must be a list"),
        ({"sigma_8_squared": 0}, "sigma_8_squared must be greater than 0"),
        ({"alpha": 1.5}, r"alpha must lie in \[0, 1\]"),
        ({"beta": -0.1}, r"beta must lie in \[0, 1\]"),
        ({"beta_step": -1}, "beta_step must be 0 or greater"),
        ({"noise_gain": np.nan}, "noise_gain must be 0 or greater"),
        ({"chance": "much"}, "chance must be a number"),
        ({"spikes": "median"}, "spikes must be one of"),
        ({"levels": 6}, "levels must be an odd number"),
        ({"levels": 33}, "up to 31"),
    ],
    ids=str,
)
def test_what_cannot_be_is_refused_in_words(changes, words):
    with pytest.raises(ValueError, match=words):
        RPFConfig.lecture(**changes)
