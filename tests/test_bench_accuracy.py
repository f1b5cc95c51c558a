"""The accuracy table: everybody in it, peers that run, and the verdict on NL-means."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from conftest import make_samples
from mcdenoise.metrics import relmse
from mcdenoise.samples import pixel_mean
from mcdenoise.study import bench_accuracy
from mcdenoise.study.bench_accuracy import Row, accuracy_lines, all_rows, nlm_verdicts
from mcdenoise.study.bench_filters import find_peers
from mcdenoise.study.bench_peers import GUIDES, JOINT_BILATERAL, NLM_CONSTANT, constant_nlm, peer_methods
from mcdenoise.study.methods import METHODS
from mcdenoise.study.tune import tune

pytestmark = pytest.mark.ch10


@pytest.fixture
def noisy(rng):
    """Samples of a flat image, and the truth."""
    size = (16, 16, 4)
    features = {name: rng.random((*size, 3)) for name in ("albedo", "shading_normal")}
    return make_samples(rng, *size, radiance=rng.gamma(2.0, 0.5, (*size, 3)), features=features), np.ones((16, 16, 3))


@pytest.mark.parametrize("label", [label for label, method in peer_methods(find_peers()) if method])
def test_every_peer_denoises_a_flat_image(label, noisy):
    samples, truth = noisy
    method = dict(peer_methods(find_peers()))[label]
    candidates = method.candidates(samples)
    images = [method.run(samples, **parameters) for parameters in (candidates[0], candidates[-1])]
    assert all(image.shape == truth.shape and np.isfinite(image).all() for image in images)
    assert relmse(images[-1], truth) < 0.7 * relmse(pixel_mean(samples.radiance), truth)


def test_the_joint_bilateral_filter_sees_at_most_three_channels(noisy):
    samples, truth = noisy
    seen = []

    def joint_bilateral(guide, image, width, sigma_radiance, sigma_space):
        assert guide.dtype == image.dtype == np.float32
        assert guide.shape == image.shape == truth.shape
        seen.append((width, sigma_radiance, sigma_space))
        return image

    cv2 = SimpleNamespace(ximgproc=SimpleNamespace(jointBilateralFilter=joint_bilateral))
    method = dict(peer_methods({"skimage": None, "cv2": cv2}))[JOINT_BILATERAL]
    for tone in GUIDES:
        method.run(samples, tone=tone, sigma_space=1.4, sigma_radiance=0.2)
    assert seen == [(11, 0.2, 1.4)] * 5  # "albedo, then normal" runs it twice
    assert {parameters["tone"] for parameters in method.candidates(samples)} == set(GUIDES)


def test_a_constant_variance_is_searched_like_any_dial(noisy):
    samples, truth = noisy
    found = tune(constant_nlm(), samples, truth)
    assert found.error < 0.5 * relmse(pixel_mean(samples.radiance), truth)
    assert isinstance(found.parameters["variance"], float)


def test_everybody_has_a_line_and_who_is_missing_is_said_to_be(monkeypatch, noisy):
    for name in ("cv2", "skimage"):
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setattr(bench_accuracy, "capture", lambda *_, **__: noisy[0])
    monkeypatch.setattr(bench_accuracy, "render_reference", lambda *_, **__: noisy[1])
    monkeypatch.setattr(bench_accuracy, "tune", lambda method, *_: SimpleNamespace(error=0.25))
    lines = accuracy_lines(["dof", "motion"], 16, 4, 64)
    assert "16x16, 4 spp, reference 64 spp; all parameters tuned with the reference" in lines[0]
    assert lines[1].split() == ["dof", "motion"]
    for method in METHODS.values():
        assert f"  {method.label:36s}{250:13.2f}{250:13.2f}" in lines
    missing = [line for line in lines if line.endswith(" not installed")]
    assert len(missing) == 4
    assert any(JOINT_BILATERAL in line for line in missing)


@pytest.mark.parametrize(("worst", "word"), [(0.019, "reached"), (0.021, "missed")])
def test_nlm_must_beat_the_gaussian_on_every_scene(worst, word):
    rows = [
        Row("Gaussian", None, {"dof": 0.01, "motion": 0.02}),
        Row("NL-means", None, {"dof": 0.005, "motion": worst}),
        Row(NLM_CONSTANT, None, {"dof": 0.02, "motion": 0.01}),
    ]
    title, noisy, constant = nlm_verdicts(rows, ["dof", "motion"])
    assert title.endswith(f"on every scene: {word}")
    assert f"relMSE over that of the best Gaussian: dof 0.50, motion {worst / 0.02:.2f}" in noisy
    assert "one best constant variance: 1 of 2 scenes" in constant
    assert "dof 2.00, motion 0.50" in constant


def test_the_labels_the_verdict_needs_are_in_the_table():
    labels = [row.label for row in all_rows()]
    assert len(set(labels)) == len(labels)
    assert {"Gaussian", "NL-means", NLM_CONSTANT} <= set(labels)
