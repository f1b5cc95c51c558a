"""The model: what it predicts and what it looks at, its file, its card, and the models that come with the package."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mcdenoise as mcd
from mcdenoise.lbf import (
    LBFModel,
    Primary,
    lbf_analysis,
    primary_features,
    secondary_features,
    secondary_names,
    storage,
)
from mcdenoise.lbf.layer import LARGEST_THETA, RADIUS, VARIANTS
from mcdenoise.lbf.model import START
from mcdenoise.lbf.primary import GROUPS
from mcdenoise.lbf.storage import SETTINGS, card_text, load_model, save_model, shipped_model
from mcdenoise.lbf.untextured import untextured
from mcdenoise.nn import MLP, Linear, Sigmoid, Softplus
from mcdenoise.samples.storage import write_npz

pytestmark = pytest.mark.ch09

CHANNELS = {"world_position": 3, "shading_normal": 3, "albedo": 3, "albedo_2": 3, "visibility": 1}
TWO = ("albedo", "visibility")
AS_PUBLISHED = {"colour_theta": 0.01, "sees_colour": False, "divides_albedo": False}
WEIGHTS = Path(storage.__file__).parent / "weights"


def model_of(groups=TWO, hidden=(3,), seed=0, **others):
    """A model whose statistics are not 0 and 1; unless told otherwise it does with the colour what the paper's does."""
    rng = np.random.default_rng(seed)
    model = LBFModel.random(groups, hidden=hidden, rng=rng, **{**AS_PUBLISHED, **others})
    return replace(model, mean=rng.normal(size=model.mean.shape), scale=rng.uniform(0.5, 2, model.scale.shape))


def primary_of(groups=TWO, height=6, width=7, seed=1):
    """Random colours and features."""
    rng = np.random.default_rng(seed)
    features = {name: rng.random((height, width, CHANNELS[name]), np.float32) for name in groups}
    variances = {name: 0.1 * one for name, one in features.items()}
    colour = rng.random((height, width, 3), np.float32)
    return Primary(colour, 0.1 * colour, features, features, variances, spp=4)


def assert_same_network(one, other):
    assert list(one.parameters) == list(other.parameters)
    for name, array in one.parameters.items():
        assert array.dtype == other.parameters[name].dtype
        np.testing.assert_array_equal(array, other.parameters[name])


# --- outputs and inputs


def test_outputs_are_those_that_are_not_given():
    assert model_of().outputs == ("position", "albedo", "visibility")
    assert model_of(colour_theta=None).outputs == ("position", "colour", "albedo", "visibility")
    assert model_of(groups=(), colour_theta=None).outputs == ("position", "colour")
    assert (
        LBFModel.random(TWO, hidden=(3,), rng=np.random.default_rng(0)).outputs == model_of(colour_theta=None).outputs
    )
    turned = model_of(groups=("visibility", "albedo"))
    assert turned.groups == TWO
    assert turned.outputs == ("position", "albedo", "visibility")


@pytest.mark.parametrize("colour_theta", [0.01, None])
def test_before_training_bandwidths_are_the_usual_ones_everywhere(colour_theta):
    """Whatever the inputs, within a factor of 2.2: 5 pixels, 2 standard deviations."""
    model = LBFModel.random(GROUPS, hidden=[10], rng=np.random.default_rng(3), colour_theta=colour_theta)
    theta = model.network.forward(np.random.default_rng(4).normal(size=(500, 43)).astype(np.float32))[0]
    usual = np.array([START[name] for name in model.outputs])
    assert (theta < 2.2 * usual).all()
    assert (theta > usual / 2.2).all()


@pytest.mark.parametrize("sees_colour", [False, True])
@pytest.mark.parametrize("divides_albedo", [False, True])
def test_inputs_are_normalised_secondary_features(sees_colour, divides_albedo):
    """Of the colours that the filter compares."""
    model, primary = model_of(sees_colour=sees_colour, divides_albedo=divides_albedo), primary_of()
    compared = untextured(primary)[0] if divides_albedo else primary
    names, values = secondary_names([*TWO, *["colour"] * sees_colour]), secondary_features(compared, sees_colour)
    assert model.input_names == names
    found = model.inputs(primary)
    assert found.dtype == np.float32
    assert found.shape == (6, 7, len(names)) == (6, 7, 22 if sees_colour else 15)
    np.testing.assert_allclose(found, (values - model.mean) / (model.scale + 1e-6), rtol=1e-5, atol=1e-6)


@settings(max_examples=30)
@given(st.sets(st.sampled_from(GROUPS)), st.sets(st.sampled_from(GROUPS)), st.booleans())
def test_absent_groups_are_0_and_unknown_groups_are_not_used(known, present, sees_colour):
    """Whatever the model knows and the scene has: each input has its own name's number, or 0."""
    model, primary = model_of([*known], sees_colour=sees_colour), primary_of([*present])
    shared, colour = known & present, ["colour"] * sees_colour
    assert set(model.known(primary).groups) == shared
    assert set(model.layer(primary).names) == {"position", "colour", *shared}
    found = dict(zip(secondary_names([*known, *colour]), np.moveaxis(model.inputs(primary), -1, 0), strict=True))
    values = secondary_features(primary.select([*shared]), sees_colour)
    alone = dict(zip(secondary_names([*shared, *colour]), np.moveaxis(values, -1, 0), strict=True))
    for k, (name, column) in enumerate(found.items()):
        if name in alone:
            expected = (alone[name] - model.mean[k]) / (model.scale[k] + 1e-6)
            np.testing.assert_allclose(column, expected, rtol=1e-5, atol=1e-5)
        else:
            assert name.split()[-1] in known - present
            np.testing.assert_array_equal(column, 0)
    theta = model.theta(primary)
    assert theta.shape == (6, 7, 2 + len(shared))
    np.testing.assert_array_equal(theta, model.theta(primary.select([*shared])))


def test_theta_is_what_the_network_puts_out():
    model, primary = model_of(groups=GROUPS, colour_theta=0.25), primary_of(("visibility", "world_position"))
    y = model.network.forward(model.inputs(primary).reshape(42, 36))[0].reshape(6, 7, 6)
    theta = model.theta(primary)
    assert model.layer(primary).names == ("position", "colour", "world_position", "visibility")
    np.testing.assert_array_equal(theta[..., 0], y[..., 0])
    np.testing.assert_array_equal(theta[..., 1], np.float32(0.25))
    np.testing.assert_array_equal(theta[..., 2], y[..., 1])
    np.testing.assert_array_equal(theta[..., 3], y[..., 5])


@given(
    st.sets(st.sampled_from(GROUPS)), st.sets(st.sampled_from(GROUPS)), st.sampled_from((None, 0.3)), st.integers(0, 99)
)
def test_arranging_forward_and_back_are_adjoint(known, present, colour_theta, seed):
    """<arrange(y) - arrange(0), d> = <y, arrange_back(d)>: the gradient goes where the value came from."""
    model = model_of([*known], colour_theta=colour_theta)
    groups, rng = tuple(group for group in GROUPS if group in known & present), np.random.default_rng(seed)
    y, d_theta = rng.random((5, len(model.outputs))), rng.normal(size=(5, 2 + len(groups)))
    forward = model.arrange(y, groups) - model.arrange(0 * y, groups)
    back = model.arrange_back(d_theta, groups)
    assert back.shape == y.shape
    assert np.sum(forward * d_theta) == pytest.approx(np.sum(y * back), rel=1e-12, abs=1e-12)


def test_theta_never_leaves_what_the_filter_takes():
    model = model_of()
    theta = model.arrange(np.full((2, 3), 1e30, np.float32), TWO)
    assert theta.max() == LARGEST_THETA
    weights = {name: 1e20 * one for name, one in model.network.parameters.items()}
    wild = replace(model, network=model.network.replace(weights))
    wild.layer(primary_of(), engine="numpy").forward(wild.theta(primary_of()))


def test_where_a_model_divides_by_albedo_filter_and_network_see_the_quotient():
    model, primary = model_of(divides_albedo=True, sees_colour=True), primary_of(("albedo", "albedo_2"))
    compared, albedo = model.prepared(primary)
    assert compared.groups == ("albedo",)
    np.testing.assert_allclose(compared.colour * albedo, primary.colour, rtol=1e-6)
    layer = model.layer(primary, engine="numpy")
    np.testing.assert_array_equal(layer.primary.colour, compared.colour)
    np.testing.assert_array_equal(layer.albedo, albedo)
    plain = replace(model, divides_albedo=False)
    assert plain.prepared(primary)[1] is None
    assert not np.array_equal(plain.inputs(primary), model.inputs(primary))
    assert model.layer(primary_of(("visibility",))).albedo is None  # nothing to divide by


def test_settings_reach_the_filter():
    model, primary = model_of(variant="nlm", radius=4, patch_radius=2), primary_of()
    layer = model.layer(primary, rows=[1, 5], engine="numpy")
    assert (layer.variant, layer.radius, layer.patch_radius, layer.engine) == ("nlm", 4, 2, "numpy")
    assert layer.rows.tolist() == [1, 5]


# --- what does not fit


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"groups": ("albedo",)}, "A model of 1 groups needs a network with 8 inputs and 2 outputs, got 15 and 3."),
        ({"colour_theta": None}, "needs a network with 15 inputs and 4 outputs, got 15 and 3."),
        ({"sees_colour": True}, "needs a network with 22 inputs and 3 outputs, got 15 and 3."),
        ({"groups": ("albedo", "depth")}, "groups has no 'depth'; there is: world_position, shading_normal, albedo"),
        ({"groups": ("albedo", "albedo")}, "groups must not name anything twice"),
        ({"groups": "albedo"}, "groups must be a list of names"),
        ({"mean": np.zeros(14)}, "mean must have shape (15,), got (14,)."),
        ({"scale": np.ones((15, 1))}, "scale must have shape (15,), got (15, 1)."),
        ({"scale": -np.ones(15)}, "scale must not be negative anywhere, got -1."),
        ({"variant": "median"}, "variant must be one of"),
        ({"radius": -1}, "radius must be"),
        ({"patch_radius": 0.5}, "patch_radius must be"),
        ({"colour_theta": 0.0}, "colour_theta must be greater than 0"),
        ({"colour_theta": "dark"}, "colour_theta must be"),
    ],
)
def test_a_model_must_fit_together(changes, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        replace(model_of(), **changes)


def test_the_network_must_end_in_softplus():
    model = model_of()
    with pytest.raises(ValueError, match="must end in Softplus: an inverse bandwidth is never negative"):
        replace(model, network=MLP((*model.network.layers[:-1], Sigmoid())))


# --- the file


@pytest.mark.parametrize(
    "chosen",
    [
        {},
        {"hidden": ()},
        {"hidden": (4, 2), "variant": "nlm", "radius": 9, "patch_radius": 1, "colour_theta": None},
        {"groups": GROUPS, "dtype": np.float64, "colour_theta": 0.1 + 0.2, "sees_colour": True},
        {"divides_albedo": True},
        {"groups": (), "colour_theta": None},
    ],
)
def test_saved_and_loaded_to_the_bit(chosen, tmp_path):
    model = replace(model_of(**chosen), card={"training": {"seed": 3, "hidden": [4]}, "spp": [4, 8], "note": "ä"})
    path = tmp_path / "model.npz"
    save_model(model, path)
    found = load_model(path)
    assert_same_network(found.network, model.network)
    for name in ("mean", "scale"):
        np.testing.assert_array_equal(getattr(found, name), getattr(model, name))
    assert {name: getattr(found, name) for name in SETTINGS} == {name: getattr(model, name) for name in SETTINGS}
    assert dict(found.card) == model.card
    primary = primary_of(GROUPS)
    np.testing.assert_array_equal(found.theta(primary), model.theta(primary))
    with pytest.raises(TypeError):
        found.card["note"] = "another"


@pytest.fixture
def stored(tmp_path):
    """What is in a file of a model with 8 inputs, 2 hidden neurons and 2 outputs: (about, arrays)."""
    path = tmp_path / "whole.npz"
    save_model(model_of(("albedo",), hidden=(2,)), path)
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    return json.loads(str(arrays.pop("about"))), arrays


NAN = np.full((2, 8), np.nan, np.float32)


@pytest.mark.parametrize(
    ("about", "arrays", "words"),
    [
        ({"format": "mcdenoise-lbf-0"}, {}, "must have the format mcdenoise-lbf-1, got 'mcdenoise-lbf-0'."),
        ({"groups": ["albedo", "depth"]}, {}, "groups has no 'depth'"),
        ({"groups": ["albedo", "visibility"]}, {}, "A model of 2 groups needs a network with 15 inputs and 3 outputs"),
        ({"groups": None}, {}, "holds no model that fits together"),
        ({"colour_theta": None}, {}, "needs a network with 8 inputs and 3 outputs, got 8 and 2."),
        ({"colour_theta": -1}, {}, "colour_theta must be greater than 0"),
        ({}, {"weight_1": NAN}, "weight_1 must be finite: 16 of 16"),
        ({}, {"scale": np.full(8, np.inf)}, "scale must be finite"),
        ({}, {"scale": None}, "'scale'"),
        ({}, {"mean": np.zeros(3)}, "mean must have shape (8,), got (3,)."),
        ({}, {"weight_2": None}, "there are arrays that belong to no layer: bias_2."),
        ({}, {"more": np.zeros(2)}, "there are arrays that belong to no layer: more."),
        ({}, {"weight_2": np.ones((2, 3), np.float32)}, "Linear layer 2 must take the 2 outputs of layer 1"),
        ({}, {"bias_1": np.ones(3, np.float32)}, "Linear needs a weight (d_out, d_in) and a bias (d_out,)"),
        ({}, {"weight_1": np.array(["a"])}, "holds no model that fits together"),
        ({}, dict.fromkeys(("weight_1", "bias_1", "weight_2", "bias_2")), "An MLP needs at least one Linear layer"),
    ],
)
def test_a_file_that_does_not_fit_is_refused(stored, tmp_path, about, arrays, words):
    whole_about, whole = stored
    path = tmp_path / "changed.npz"
    write_npz(path, "A model is", whole_about | about, {n: a for n, a in {**whole, **arrays}.items() if a is not None})
    with pytest.raises(ValueError, match=re.escape(words)) as caught:
        load_model(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda path: path.unlink(), "An .npz file of a model of mcdenoise train is needed, but there is no file"),
        (lambda path: path.write_bytes(b""), "is not a whole file of a model of mcdenoise train"),
        (lambda path: path.write_bytes(path.read_bytes()[:-40]), "is not a whole file of a model"),
        (lambda path: path.write_bytes(path.read_bytes()[:300]), "is not a whole file of a model"),
        (lambda path: path.write_bytes(path.read_bytes()[:200] + b"!" + path.read_bytes()[201:]), "Bad CRC-32"),
        (lambda path: np.savez(path, radiance=np.ones(3)), "('about'). Train or save it again."),
        (lambda path: np.savez(path, about=np.array("no JSON")), "is not a whole file of a model"),
        (lambda path: np.savez(path, about=np.array("[1, 2]")), "is not a whole file of a model"),
        (lambda path: np.savez(path, about=np.array([{}], object)), "Object arrays cannot be loaded"),
    ],
)
def test_a_file_that_is_none_of_ours_is_refused(tmp_path, spoil, words):
    path = tmp_path / "model.npz"
    save_model(model_of(), path)
    spoil(path)
    with pytest.raises(ValueError, match=re.escape(words)):
        mcd.load_model(path)


def test_samples_are_no_model(samples, tmp_path):
    samples.save(tmp_path / "samples.npz")
    with pytest.raises(ValueError, match=re.escape("must have the format mcdenoise-lbf-1, got 'mcdenoise-samples-1'")):
        load_model(tmp_path / "samples.npz")


def test_what_cannot_be_written_is_said_and_leaves_nothing(tmp_path):
    with pytest.raises(ValueError, match=re.escape("A model is stored as .npz, got the name 'model.txt'.")):
        save_model(model_of(), tmp_path / "model.txt")
    with pytest.raises(ValueError, match=r"must exist before .* can be written there"):
        save_model(model_of(), tmp_path / "missing" / "model.npz")
    assert list(tmp_path.iterdir()) == []


# --- the card


def test_the_card_says_everything():
    """Settings first, then what stands by itself, then the sections; a long list by its ends and its length."""
    scenes = [f"random_{k}" for k in range(12)]
    card = {"training": {"rows": 4, "hidden": [3], "rate": 0.123456}, "spp": [4, 8], "scenes": scenes}
    lines = card_text(replace(model_of(radius=9), card=card)).splitlines()
    assert lines[0] == "# Model card: cross_bilateral, 15-3-3, 60 parameters"
    assert "It predicts theta = 1 / (2 sigma^2) of position, albedo, visibility for every pixel." in lines
    settings = ["groups: albedo, visibility", "variant: cross_bilateral", "radius: 9", "patch_radius: 3"]
    settings += ["colour_theta: 0.01", "sees_colour: False", "divides_albedo: False"]
    result, training = ["spp: 4, 8", "scenes: random_0 to random_11 (12)"], ["rows: 4", "hidden: 3", "rate: 0.1235"]
    assert [line[2:] for line in lines if line.startswith("- ")] == [*settings, *result, *training]
    assert [line for line in lines if line.startswith("##")] == ["## filter", "## result", "## training"]
    assert card_text(model_of(hidden=())).startswith("# Model card: cross_bilateral, 15-3, 48 parameters")


# --- the models of the package


def test_only_two_models_come_with_the_package():
    with pytest.raises(ValueError, match=re.escape("variant must be one of 'cross_bilateral', 'nlm'")):
        shipped_model("median")


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_model_of_the_package(variant, rng):
    """It is small, knows every group, was made for this variant, and its card says how."""
    model = shipped_model(variant)
    assert shipped_model(variant) is model
    assert (model.variant, model.groups, model.radius) == (variant, GROUPS, RADIUS)
    assert model.network.size < 1000
    assert isinstance(model.network.layers[0], Linear)
    assert isinstance(model.network.layers[-1], Softplus)
    assert (WEIGHTS / f"{variant}.npz").stat().st_size < 50_000
    card = dict(model.card)
    assert card["training"]["variant"] == variant
    assert len(set(card["training_scenes"])) >= 20
    assert len(set(card["validation_scenes"])) >= 5
    assert not set(card["training_scenes"]) & set(card["validation_scenes"])
    assert not set(card["training_scenes"] + card["validation_scenes"]) & set(mcd.scene_names())
    assert card["validation_loss"]["best"] < card["validation_loss"]["unfiltered"]
    assert card_text(model).startswith(f"# Model card: {variant}, {model.network.inputs}-")
    assert (WEIGHTS / f"{variant}.md").read_text(encoding="utf-8").strip() == card_text(model).strip()


@pytest.mark.parametrize("variant", VARIANTS)
def test_bandwidths_of_the_package_depend_on_the_pixel(variant, samples):
    """Made-up samples: the map of every bandwidth varies, and nothing is out of range."""
    found = lbf_analysis(samples, variant=variant, engine="numpy")
    assert found.primary.groups == primary_features(samples).groups
    for name, theta in found.theta.items():
        assert (theta >= 0).all()
        assert (theta <= LARGEST_THETA).all()
        if name in shipped_model(variant).outputs:
            assert np.ptp(theta) > 0
