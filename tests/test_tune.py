"""Bandwidths by search: never worse than the best candidate, inside their range, with and without the reference."""

import re

import numpy as np
import pytest

from conftest import make_samples
from mcdenoise.metrics import relmse
from mcdenoise.study import tune as tune_module
from mcdenoise.study.methods import METHODS
from mcdenoise.study.tune import choose_parameters, halves_error, main, reference_error, tune

pytestmark = pytest.mark.ch04


def scene(rng, noise=0.3, spp=8, side=24):
    """Two halves of different brightness with noise, and what is behind it."""
    truth = np.where(np.arange(side) < side // 2, 0.5, 1.5)[np.newaxis, :, np.newaxis] * np.ones((side, 1, 3))
    size = (side, side, spp)
    radiance = truth[:, :, np.newaxis] + noise * rng.normal(size=(*size, 3))
    albedo = np.broadcast_to(truth[:, :, np.newaxis] / 2, (*size, 3))
    return make_samples(rng, *size, radiance=radiance, features={"albedo": albedo}), truth


@pytest.mark.parametrize("name", METHODS)
def test_never_worse_than_the_best_candidate(rng, name):
    samples, truth = scene(rng, side=16)
    method = METHODS[name]
    error = reference_error(method, samples, truth)
    found = tune(method, samples, truth)
    assert (
        found.error
        == pytest.approx(error(found.parameters))
        == pytest.approx(relmse(method.run(samples, **found.parameters), truth))
    )
    assert found.error <= min(error(one) for one in method.candidates(samples))
    assert found.tried >= len(method.candidates(samples))


def test_refined_between_the_candidates_and_never_beyond(rng):
    """The best Gaussian of pure noise on a plane is as wide as may be; that of a step lies between two candidates."""
    samples, truth = scene(rng)
    flat = make_samples(rng, 24, 24, 8, radiance=1 + 0.3 * rng.normal(size=(24, 24, 8, 3)))
    assert tune(METHODS["gaussian"], flat, np.ones((24, 24, 3))).parameters == {"sigma_space": 2.8}
    sigma = tune(METHODS["gaussian"], samples, truth).parameters["sigma_space"]
    assert 0.35 <= sigma <= 2.8
    error = reference_error(METHODS["gaussian"], samples, truth)
    for other in (sigma * np.sqrt(2), sigma / np.sqrt(2)):
        if 0.35 <= other <= 2.8:
            assert error({"sigma_space": sigma}) <= error({"sigma_space": other})


def test_numbers_in_dicts_are_refined_and_whole_numbers_are_not(rng):
    samples, truth = scene(rng)
    candidates = METHODS["joint_nlm"].candidates(samples)
    found = tune(METHODS["joint_nlm"], samples, truth).parameters
    assert found["search_radius"] == candidates[0]["search_radius"]
    assert isinstance(found["weight_radius"], int)
    spans = [one["sigma_features"]["albedo"] for one in candidates]
    assert min(spans) <= found["sigma_features"]["albedo"] <= max(spans)


def test_without_reference_it_comes_close(rng):
    samples, truth = scene(rng)
    method = METHODS["bilateral"]
    error = reference_error(method, samples, truth)
    blind, knowing = tune(method, samples).parameters, tune(method, samples, truth).parameters
    unfiltered = relmse(samples.radiance.mean(axis=2), truth)
    assert error(blind) - error(knowing) < 0.2 * (unfiltered - error(knowing))


def test_the_choice_is_the_candidate_that_halves_find_best(rng):
    samples, _ = scene(rng, side=16)
    method = METHODS["bilateral"]
    error, chosen = halves_error(method, samples), choose_parameters(method, samples)
    assert chosen in method.candidates(samples)
    assert error(chosen) == min(error(one) for one in method.candidates(samples))


def test_halves_expect_the_error_that_the_whole_has(rng):
    """A linear filter, even light: the criterion is twice the relMSE of all samples, but for a constant."""
    truth = np.ones((64, 64, 3))
    samples = make_samples(rng, 64, 64, 8, radiance=1 + 0.2 * rng.normal(size=(64, 64, 8, 3)))
    one, other = ({"sigma_space": sigma} for sigma in (0.5, 2.0))
    error, true = halves_error(METHODS["gaussian"], samples), reference_error(METHODS["gaussian"], samples, truth)
    assert (error(other) - error(one)) / 2 == pytest.approx(true(other) - true(one), rel=0.05)


@pytest.mark.parametrize("name", ["rpf", "rpf_report"])
def test_a_method_without_dials_is_run_once(rng, name):
    samples, truth = scene(rng, side=8)
    found = tune(METHODS[name], samples, truth)
    assert found.tried == 1
    assert found.parameters == METHODS[name].candidates(samples)[0]


def test_one_sample_needs_a_reference(rng):
    samples, truth = scene(rng, spp=1)
    with pytest.raises(ValueError, match=re.escape("Tuning without a reference needs at least 2 spp")):
        tune(METHODS["gaussian"], samples)
    assert tune(METHODS["nlm"], samples, truth).error < relmse(samples.radiance[:, :, 0], truth)


def test_the_command_prints_both_ways(capsys, monkeypatch, rng):
    samples, truth = scene(rng, side=16)
    monkeypatch.setattr(tune_module, "capture", lambda *_, **__: samples)
    monkeypatch.setattr(tune_module, "render_reference", lambda *_, **__: truth)
    assert main(["dof", "--methods", "gaussian", "cross_bilateral", "rpf"]) == 0
    output = capsys.readouterr().out
    assert "dof, 128 x 128, 8 spp: relMSE" in output
    for name in ("gaussian", "cross_bilateral"):
        for way in ("by halves", "by reference"):
            assert re.search(rf"{name} +[\d.]+  {way}, \d+ tried: sigma_space", output)
    assert "sigma_features {albedo" in output
    assert re.search(r"rpf +[\d.]+  by reference, 1 tried: nothing to choose", output)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["dof", "--methods", "median"], "methods has no 'median'"),
        (["nowhere"], "nowhere"),
        ([], "the following arguments are required: SCENE"),
        (["dof", "--spp", "many"], "argument --spp: invalid int value"),
    ],
)
def test_bad_arguments_give_one_line_and_code_2(arguments, message, capsys):
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.err.count("\n") == 1
