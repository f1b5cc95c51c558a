"""Bandwidths chosen without the reference, against the choice that knows the truth."""

import numpy as np
import pytest

from conftest import make_samples
from mcdenoise.metrics import relmse
from mcdenoise.rpf import RPFConfig, rpf
from mcdenoise.study.methods import METHODS, feature_spreads, report_config, report_multiples, share_of_draws
from mcdenoise.study.tune import choose_parameters

pytestmark = pytest.mark.ch10


def _noisy(rng, truth, noise, spp=8, **changes):
    """Samples of `truth` (h, w, 3) with Gaussian noise of standard deviation `noise`."""
    size = (*truth.shape[:2], spp)
    radiance = truth[:, :, np.newaxis] + noise * rng.normal(size=(*size, 3))
    return make_samples(rng, *size, radiance=radiance, **changes)


def _ramp(height, width):
    """A slow ramp: little detail to lose."""
    return np.repeat(np.linspace(0.5, 1.5, width)[np.newaxis, :, np.newaxis], 3, axis=2).repeat(height, axis=0)


def test_more_noise_asks_for_a_wider_gaussian(rng):
    truth = _ramp(24, 24) + 0.3 * (np.indices((24, 24)).sum(0) // 4 % 2)[..., np.newaxis]
    chosen = [choose_parameters(METHODS["gaussian"], _noisy(rng, truth, n))["sigma_space"] for n in (0.01, 0.3, 1.5)]
    assert chosen == sorted(chosen)
    assert chosen[0] < chosen[-1]


@pytest.mark.parametrize("name", ["gaussian", "bilateral"])
def test_choice_by_halves_is_close_to_the_choice_that_knows_the_truth(rng, name):
    method = METHODS[name]
    truth = _ramp(32, 32) * (1 + 0.5 * (np.indices((32, 32))[1] > 16))[..., np.newaxis]
    samples = _noisy(rng, truth, 0.4)
    errors = [relmse(method.run(samples, **p), truth) for p in method.candidates(samples)]
    chosen = relmse(method.run(samples, **choose_parameters(method, samples)), truth)
    unfiltered = relmse(samples.radiance.mean(axis=2), truth)
    assert chosen < 0.5 * unfiltered
    assert chosen - min(errors) < 0.1 * (unfiltered - min(errors))


def test_one_sample_has_no_halves_and_takes_the_middle(rng):
    samples = _noisy(rng, _ramp(8, 8), 0.1, spp=1)
    assert choose_parameters(METHODS["gaussian"], samples) == {"sigma_space": 1.0}


def test_spreads_follow_the_units_and_leave_out_what_does_not_vary(rng):
    size = (6, 6, 2)
    depth = rng.random(size)
    features = {"depth": depth, "albedo": np.full((*size, 3), 0.5), "albedo_2": rng.random((*size, 3))}
    near = feature_spreads(make_samples(rng, *size, features=features))
    far = feature_spreads(make_samples(rng, *size, features={**features, "depth": 100 * depth}))
    assert set(near) == {"depth", "albedo_2"}
    assert far["depth"] == pytest.approx(100 * near["depth"], rel=1e-5)


def test_every_method_runs_on_every_candidate(rng):
    samples = _noisy(rng, _ramp(8, 9), 0.2)
    for method in METHODS.values():
        for parameters in method.candidates(samples):
            assert method.run(samples, **parameters).shape == (8, 9, 3)


def test_methods_are_in_the_order_of_the_course():
    chapters = [method.chapter for method in METHODS.values()]
    assert chapters == sorted(chapters)
    assert list(METHODS)[-4:] == ["rpf", "rpf_report", "lbf", "lbf_nlm"]
    assert all(name == method.name for name, method in METHODS.items())


def test_rpf_has_nothing_to_choose_and_runs_nothing_to_choose_it(rng, monkeypatch):
    monkeypatch.setattr("mcdenoise.study.methods.rpf", None)
    samples = _noisy(rng, _ramp(8, 8), 0.2)
    assert choose_parameters(METHODS["rpf"], samples) == {}
    assert choose_parameters(METHODS["rpf_report"], samples) == {"draws": 1.0}


def test_rpf_is_the_default_and_the_report_its_preset(rng):
    samples = _noisy(rng, _ramp(8, 9), 0.2)
    np.testing.assert_array_equal(METHODS["rpf"].run(samples), rpf(samples))
    report = METHODS["rpf_report"]
    np.testing.assert_array_equal(report.run(samples, draws=1.0), rpf(samples, RPFConfig.technical_report()))
    whole = rpf(samples, RPFConfig.technical_report(sample_fraction=0.5))
    np.testing.assert_array_equal(report.run(samples, **report.variants[-1].parameters), whole)


def test_variants_are_draws_from_a_quarter_of_the_default_to_all():
    variants = METHODS["rpf_report"].variants
    assert [variant.parameters["draws"] for variant in variants[:3]] == [0.25, 1.0, 4.0]
    assert len({variant.name for variant in variants}) == len(variants)
    assert variants[-1].label == "100 % of M"
    for variant in variants:
        config = report_config(variant.parameters["draws"])
        share = sum(config.draws(turn, 1024) + 1024 for turn in config.turns) / sum(
            0.5 * box**2 * 1024 for box in config.boxes
        )
        assert variant.label == f"{100 * share:.0f} % of M"


def test_no_multiple_draws_more_than_what_was_published():
    multiples = report_multiples([3.0, 1e6])
    assert list(multiples)[:2] == [3.0, 1e6]
    assert multiples[1e6] == pytest.approx(1.0) == pytest.approx(list(multiples.values())[-1])
    assert max(report_config(1e6).sample_fraction) == 0.5
    assert share_of_draws(report_config(3.0)) < 1
