"""Training through the filter: it learns, stops early, resumes to the same bits, and finds a step that is too long."""

import json
import re

import numpy as np
import pytest

from mcdenoise.cli import main
from mcdenoise.lbf.checkpoint import load_checkpoint
from mcdenoise.lbf.dataset import KEEP, DataConfig, SceneData, drop_groups, flip_axes, load_data, subsets
from mcdenoise.lbf.layer import FilterLayer
from mcdenoise.lbf.model import LBFModel
from mcdenoise.lbf.oracle import oracle
from mcdenoise.lbf.pixel import (
    filter_pixel,
    filtered_by_theta,
    filtered_error_gradient,
    rprop_epoch,
    softplus_link,
)
from mcdenoise.lbf.primary import GROUPS, Primary
from mcdenoise.lbf.secondary import secondary_features, secondary_names
from mcdenoise.lbf.storage import load_model
from mcdenoise.lbf.training import TrainConfig, train_lbf
from mcdenoise.nn import RPROP, Diverged, RelativeError
from mcdenoise.nn.layers import softplus
from mcdenoise.samples.storage import write_npz

pytestmark = pytest.mark.ch09
QUICK = {"groups": ("albedo",), "hidden": (3,), "radius": 3, "rows": 8, "drop": False, "divides_albedo": False}


def made_up(seed, size=24, spp=(4, 16)):
    """Two flat halves under noise; albedo tells them apart, but has a pattern of its own that means nothing."""
    rng = np.random.default_rng(seed)
    reference = np.where(np.arange(size) < size // 2, 0.2, 0.8)[:, np.newaxis] * rng.uniform(0.5, 1, 3)
    reference = np.broadcast_to(reference, (size, size, 3)).astype(np.float32)
    albedo = {"albedo": (reference + 0.3 * rng.random((size, size, 1))).astype(np.float32)}
    uncertain = {"albedo": np.full_like(reference, 0.002)}
    primaries = []
    for n in spp:
        noise = 0.5 / np.sqrt(n) * rng.normal(size=(size, size, 3)) * reference
        variance = np.full_like(reference, (0.1 / n))
        primaries.append(Primary((reference + noise).astype(np.float32), variance, albedo, albedo, uncertain, n))
    return SceneData(f"made up {seed}", tuple(primaries), reference)


@pytest.fixture(scope="module")
def scenes():
    return [made_up(0), made_up(1)], [made_up(2)]


def same(one, other):
    return all(np.array_equal(one.parameters[name], other.parameters[name]) for name in one.parameters)


def test_it_learns_and_says_how(scenes):
    done = train_lbf(TrainConfig(epochs=40, **QUICK), scenes)
    assert done.losses[-1] < 0.6 * done.losses[0]
    assert done.validation[-1, 1] < 0.6 * done.validation[0, 1]
    assert done.losses[0] < done.unfiltered[0]
    card = json.loads(json.dumps(done.model.card))  # what JSON can hold
    assert card["training_scenes"] == ["made up 0", "made up 1"]
    assert card["validation_scenes"] == ["made up 2"]
    assert card["spp"] == [4, 16]
    assert card["epochs"] == 40
    assert card["validation_loss"]["best"] == done.validation[:, 1].min()
    assert card["training"]["seed"] == 0


def test_the_same_twice_another_seed_another_model(scenes):
    one, again = (train_lbf(TrainConfig(epochs=3, **QUICK), scenes).model.network for _ in range(2))
    assert same(one, again)
    assert not same(one, train_lbf(TrainConfig(epochs=3, seed=1, **QUICK), scenes).model.network)


def test_interrupted_and_resumed_it_ends_at_the_same_bits(scenes, tmp_path):
    whole = train_lbf(TrainConfig(epochs=14, check=3, **QUICK), scenes)
    path = tmp_path / "half.npz"
    train_lbf(TrainConfig(epochs=7, check=3, **QUICK), scenes, checkpoint=path)
    resumed = train_lbf(TrainConfig(epochs=14, check=3, **QUICK), scenes, checkpoint=path, resume=True)
    assert same(whole.model.network, resumed.model.network)
    np.testing.assert_array_equal(whole.losses, resumed.losses)
    np.testing.assert_array_equal(whole.validation, resumed.validation)


def test_an_interruption_in_the_middle_loses_only_what_came_after_the_last_look(scenes, tmp_path, monkeypatch):
    path, config = tmp_path / "stopped.npz", TrainConfig(epochs=9, check=3, **QUICK)
    step, done = RPROP.step, []

    def stop(self, *arguments):
        done.append(1)
        if len(done) == 5:
            raise KeyboardInterrupt
        return step(self, *arguments)

    monkeypatch.setattr(RPROP, "step", stop)
    with pytest.raises(KeyboardInterrupt):
        train_lbf(config, scenes, checkpoint=path)
    monkeypatch.undo()
    resumed = train_lbf(config, scenes, checkpoint=path, resume=True)
    whole = train_lbf(config, scenes)
    assert same(whole.model.network, resumed.model.network)
    np.testing.assert_array_equal(whole.losses, resumed.losses)


def test_early_stopping_keeps_the_best(scenes):
    """Validation scenes on which filtering can only harm: the first look is the best one."""
    still = made_up(3)
    hard = SceneData("hard", still.primaries, still.primaries[0].colour)
    done = train_lbf(TrainConfig(epochs=50, check=2, patience=2, **QUICK), (scenes[0], [hard]))
    assert len(done.losses) < 50
    best = done.validation[done.validation[:, 1].argmin(), 0]
    assert len(done.losses) == best + 4
    assert done.model.card["best_epoch"] == best


def test_a_step_that_is_too_long_is_found_and_the_best_is_kept(scenes, tmp_path):
    path = tmp_path / "far.npz"
    with pytest.raises(
        Diverged, match=r"Training diverged in epoch \d+: the loss is .* Take a smaller first step"
    ) as caught:
        train_lbf(TrainConfig(epochs=20, first_step=50.0, **QUICK), scenes, checkpoint=path)
    kept = caught.value.training.network
    assert all(np.isfinite(one).all() for one in kept.parameters.values())
    with np.load(path) as stored:
        assert np.array_equal(stored["best/weight_1"], kept.parameters["weight_1"])


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda path: path.unlink(), "there is no file"),
        (
            lambda path: path.write_bytes(path.read_bytes()[:200]),
            "is not a whole file of a checkpoint of mcdenoise train",
        ),
        (lambda path: write_npz(path, "A foreign file is", {"format": "other"}, {}), "its format is 'other'"),
    ],
)
def test_a_bad_checkpoint_is_refused(scenes, tmp_path, spoil, message):
    path = tmp_path / "checkpoint.npz"
    train_lbf(TrainConfig(epochs=1, **QUICK), scenes, checkpoint=path)
    spoil(path)
    with pytest.raises(ValueError, match=re.escape(message)):
        train_lbf(TrainConfig(epochs=1, **QUICK), scenes, checkpoint=path, resume=True)


def test_a_checkpoint_of_another_training_is_refused(scenes, tmp_path):
    path = tmp_path / "checkpoint.npz"
    train_lbf(TrainConfig(epochs=1, **QUICK), scenes, checkpoint=path)
    with pytest.raises(ValueError, match="belongs to a training with another seed: 0 there, 1 here"):
        train_lbf(TrainConfig(epochs=2, seed=1, **QUICK), scenes, checkpoint=path, resume=True)
    with pytest.raises(ValueError, match="another data"):
        train_lbf(TrainConfig(epochs=2, **QUICK), (scenes[1], scenes[0]), checkpoint=path, resume=True)
    with pytest.raises(ValueError, match="To resume, say from which checkpoint"):
        train_lbf(TrainConfig(epochs=2, **QUICK), scenes, resume=True)
    assert load_checkpoint(path, {}).losses


def test_groups_that_no_scene_has_are_named(scenes):
    with pytest.raises(ValueError, match=r"No training scene has what mad visibility, .* Leave those groups out"):
        train_lbf(TrainConfig(**{**QUICK, "groups": ("albedo", "visibility")}), scenes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"variant": "mean"}, "variant must be one of"),
        ({"epochs": 0}, "epochs must be"),
        ({"rows": 0}, "rows must be"),
        ({"validation_rows": 0}, "validation_rows must be"),
        ({"training_radius": 0}, "training_radius must be"),
        ({"first_step": -1.0}, "first"),
    ],
)
def test_bad_settings_are_refused(scenes, changes, message):
    with pytest.raises(ValueError, match=message):
        train_lbf(TrainConfig(**{**QUICK, **changes}), scenes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"scenes": 0}, "scenes must be"),
        ({"size": 8}, "size must be"),
        ({"spp": (8, 4)}, re.escape("spp must be different numbers in ascending order, got (8, 4).")),
        ({"spp": ()}, "spp must be different numbers"),
    ],
)
def test_bad_data_settings_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        DataConfig(**changes)


def test_training_and_validation_never_share_a_scene():
    train, validation = DataConfig().seeds
    assert not set(train) & set(validation)
    assert len(train) >= 20
    assert len(validation) >= 5


def test_subsets_are_disjoint_where_they_fit():
    parts = subsets((4, 8, 16, 32, 64))
    assert parts == [(0, 4), (4, 12), (12, 28), (28, 60), (0, 64)]


def test_groups_are_dropped_as_often_as_said():
    image = np.ones((1, 1, 3), np.float32)
    every = dict.fromkeys(GROUPS, image)
    primary, rng = Primary(image, image, every, every, every, 4), np.random.default_rng(0)
    kept = [drop_groups(primary, GROUPS, rng).groups for _ in range(1000)]
    for name, share in KEEP.items():
        found = np.mean([name in one for one in kept])
        assert abs(found - share) <= 4 * np.sqrt(share * (1 - share) / 1000)


def test_turning_axes_round_changes_what_the_network_sees_and_not_what_the_filter_does():
    image = np.random.default_rng(5).random((6, 7, 3)).astype(np.float32)
    every = dict.fromkeys(GROUPS, image)
    primary = Primary(image, image, every, every, every, 4)
    turned = [flip_axes(primary, np.random.default_rng(seed)) for seed in range(8)]
    assert any((one.features["world_position"] < 0).any() for one in turned)
    theta = np.full((6, 7, 7), 0.1)
    expected = FilterLayer(primary, engine="numpy").forward(theta)[0]
    names, before = secondary_names(GROUPS), secondary_features(primary)
    for one in turned:
        np.testing.assert_array_equal(FilterLayer(one, engine="numpy").forward(theta)[0], expected)
        for k, name in enumerate(names):
            if name not in [
                f"{kind} {group}" for kind in ("mean", "mean 7x7") for group in ("world_position", "shading_normal")
            ]:
                np.testing.assert_allclose(secondary_features(one)[..., k], before[..., k], rtol=1e-5, atol=1e-6)
        assert set(np.unique(np.sign(one.raw["albedo"]))) == {1}


def test_the_command_trains_writes_and_resumes(tmp_path, capsys):
    """Two scenes of 64 x 64 pixels, rendered, learnt from and watched: model, card, chart; the second run renders nothing."""
    out, data = tmp_path / "small.npz", tmp_path / "data"
    options = ["train", "--out", str(out), "--data", str(data), "--scenes", "2", "--validation", "1", "--size", "64"]
    options += ["--spp", "4", "8", "--reference-spp", "16", "--hidden", "4"]
    assert main([*options, "--epochs", "5"]) == 0
    model = load_model(out)
    assert model.groups == GROUPS
    assert model.card["training_scenes"] == ["random_0", "random_1"]
    assert out.with_suffix(".md").read_text().startswith("# Model card: cross_bilateral, 43-4-7, 211 parameters")
    assert out.with_suffix(".png").stat().st_size > 10_000
    assert "211 parameters, 5 epochs" in capsys.readouterr().out
    stamps = {path: path.stat().st_mtime_ns for path in data.iterdir()}
    assert main([*options, "--epochs", "6", "--resume"]) == 0
    assert {path: path.stat().st_mtime_ns for path in data.iterdir()} == stamps
    assert load_model(out).card["epochs"] == 6
    # A file that was cut off is rendered again, to the same.
    path = data / "scene_2.npz"
    whole = load_data(DataConfig(scenes=2, validation=1, size=64, spp=(4, 8), reference_spp=16), data)[1][0]
    path.write_bytes(path.read_bytes()[:999])
    again = load_data(DataConfig(scenes=2, validation=1, size=64, spp=(4, 8), reference_spp=16), data)[1][0]
    np.testing.assert_array_equal(whole.primaries[0].colour, again.primaries[0].colour)
    # Scenes of another size are not taken for what was asked for, and not thrown away either.
    with pytest.raises(
        ValueError, match=r"was rendered with \{'size': 64, .*needed is \{'size': 32, .*Name another folder"
    ):
        load_data(DataConfig(scenes=2, validation=1, size=32, spp=(4, 8), reference_spp=16), data)
    assert path.is_file()


def test_the_command_refuses_in_one_line(tmp_path, capsys):
    assert main(["train", "--out", str(tmp_path / "model.txt")]) == 2
    assert "A model is stored as .npz, got the name 'model.txt'" in capsys.readouterr().err
    assert main(["train", "--scenes", "0", "--out", str(tmp_path / "m.npz")]) == 2
    assert capsys.readouterr().err.startswith("mcdenoise train: scenes must be")


def random_layer(seed=0, engine="numpy", groups=("albedo",), height=5, width=6):
    rng = np.random.default_rng(seed)
    image, feature = rng.random((height, width, 3)), rng.random((height, width, 3))
    features = dict.fromkeys(groups, feature)
    variances = dict.fromkeys(groups, 0.1 * feature)
    return FilterLayer(Primary(image, 0.05 * image + 0.01, features, features, variances, 4), radius=2, engine=engine)


def test_one_pixel_agrees_with_the_layer():
    """The three terms of the chain rule at a pixel in a corner, against forward and backward of the whole image."""
    from mcdenoise.filters.window import window_offsets
    from mcdenoise.lbf.distances import offset_distances

    layer = random_layer()
    theta = np.random.default_rng(1).random(layer.shape)
    filtered, saved = layer.forward(theta)
    distances, colours = [], []
    for dy, dx, here, there in window_offsets(5, 6, 2):
        if here[0].start == 0 and here[1].start == 0:
            distances.append(offset_distances(layer, dy, dx, here, there)[0, 0])
            colours.append(layer.primary.colour[there][0, 0])
    distances, colours = np.array(distances).T, np.array(colours)
    one, weights = filter_pixel(theta[0, 0], distances, colours)
    np.testing.assert_allclose(one, filtered[0, 0], rtol=1e-12)
    assert weights.sum() == pytest.approx(saved[2][0, 0], rel=1e-12)
    d_filtered = np.zeros_like(filtered)
    d_filtered[0, 0] = [0.3, -1.0, 2.0]
    expected = layer.backward(d_filtered, saved)[0, 0]
    np.testing.assert_allclose(
        filtered_by_theta(theta[0, 0], distances, colours) @ d_filtered[0, 0], expected, rtol=1e-10
    )


def test_the_first_and_the_last_term_are_those_of_nn():
    rng = np.random.default_rng(2)
    filtered, reference = rng.random((2, 3))
    error, saved = RelativeError(spp=4).forward(filtered[np.newaxis], reference[np.newaxis])
    del error
    expected = RelativeError(spp=4).backward(saved)[0]
    np.testing.assert_allclose(filtered_error_gradient(filtered, reference, 4, 0.01), expected, rtol=1e-12)
    z = np.linspace(-30, 30, 13)
    np.testing.assert_allclose(softplus_link(np.ones(13), softplus(z)), 1 / (1 + np.exp(-z)), rtol=1e-7)


def test_an_epoch_is_that_of_the_training():
    """Against `FilterLoss`, for a model that predicts everything."""
    from mcdenoise.lbf.loss import Example, FilterLoss
    from mcdenoise.nn import loss_and_gradients

    layer, rng = random_layer(), np.random.default_rng(3)
    model = LBFModel.random(["albedo"], hidden=[2], rng=rng, colour_theta=None, dtype=np.float64)
    inputs, reference = rng.normal(size=(30, model.network.inputs)), rng.random((5, 6, 3))
    optimizer = RPROP(0.1)
    state = optimizer.start(model.network.parameters)
    network, _, error = rprop_epoch(model.network, inputs, layer, reference, optimizer, state)
    loss = FilterLoss(model, [Example(layer, inputs, reference.reshape(-1, 3))])
    value, gradients = loss_and_gradients(model.network, inputs, reference.reshape(-1, 3), loss)
    assert error == pytest.approx(value, rel=1e-12)
    expected, _ = optimizer.step(model.network.parameters, gradients, state)
    for name, array in network.parameters.items():
        np.testing.assert_allclose(array, expected[name], rtol=1e-12)


def test_the_oracle_beats_every_shared_setting_and_gains_with_each_step():
    scene = made_up(4)
    layer = FilterLayer(scene.primaries[0], radius=3, engine="numpy")
    found = oracle(layer, scene.reference, colour_theta=0.01, steps=8)
    assert (np.diff(found.errors) <= 0).all()
    relative = (found.image - scene.reference) ** 2 / (scene.reference**2 + 0.01)
    assert relative.mean() == pytest.approx(found.errors[-1], rel=1e-6)
    assert found.errors[-1] < ((found.shared_image - scene.reference) ** 2 / (scene.reference**2 + 0.01)).mean()
    np.testing.assert_allclose(found.theta[..., 1], 0.01)
    free = oracle(layer, scene.reference, steps=8)
    assert len(np.unique(free.theta[..., 1])) > 10


@pytest.mark.parametrize("reference", [np.ones((3, 3, 3)), np.full((24, 24, 3), np.nan)])
def test_the_oracle_refuses_a_reference_that_does_not_fit(reference):
    with pytest.raises(ValueError, match="reference"):
        oracle(FilterLayer(made_up(4).primaries[0]), reference)
