"""Advice on made-up scenes whose needs are known, on two toy scenes, and on the command line."""

import json
import re

import numpy as np
import pytest

from conftest import make_samples
from mcdenoise.cli import main
from mcdenoise.render import capture
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.advise import ASKS, advise
from mcdenoise.study.advise_lines import advice_lines
from mcdenoise.study.methods import METHODS

pytestmark = pytest.mark.ch10


@pytest.fixture(scope="module")
def wallpaper():
    """A texture of single pixels that albedo knows, light that varies with one number, another feature of nothing but noise."""
    rng = np.random.default_rng(5)
    size = (32, 32, 8)
    texture = np.broadcast_to(rng.uniform(0.1, 0.9, (32, 32, 1, 3)), (*size, 3))
    light, idle = rng.random((2, *size))
    radiance = texture * (0.2 + 1.6 * light[..., np.newaxis])
    features = {"albedo": texture, "shading_normal": rng.normal(size=(*size, 3))}
    params = {"light_u": light, "lens_u": idle}
    return advise(make_samples(rng, *size, radiance=radiance, random_params=params, features=features), progress=False)


def test_what_carries_information_is_kept(wallpaper):
    assert wallpaper.layout["random_params"] == ("light_u",)


def test_what_a_filter_needs_is_kept(wallpaper):
    assert wallpaper.layout["features"] == ("albedo",)
    albedo, normal = wallpaper.features
    assert albedo.behind > 5 * albedo.standard_error
    assert normal.behind < 0.2 * albedo.behind


def test_a_texture_that_features_know_needs_a_feature_filter(wallpaper):
    """Every filter of radiance alone must blur the texture or leave the noise."""
    assert "features" in ASKS[wallpaper.method]
    radiance_alone = [one.tiles.mean() for one in wallpaper.methods if ASKS[one.name].startswith("radiance")]
    assert min(radiance_alone) > 1.5 * wallpaper.methods[wallpaper.choice.chosen].tiles.mean() - wallpaper.noise


def test_boxes_have_the_error_of_rpf_but_for_their_difference(wallpaper):
    """Boxes are judged by two parts, methods by four: RPF with its usual boxes has one error in both tables."""
    boxes = {one.name: wallpaper.box_error(one) for one in wallpaper.boxes}
    (whole,) = (one for one in wallpaper.methods if one.name == "rpf")
    assert list(boxes) == ["3", "5", "5 3", "7 5 3"]
    assert boxes["5 3"] == pytest.approx(wallpaper.error(whole))
    assert len(whole.parts) == 4
    assert {len(one.parts) for one in wallpaper.boxes} == {2}


def test_the_words_say_what_the_numbers_say(wallpaper):
    text = "\n".join(advice_lines(wallpaper))
    assert "Random parameters: keep light_u; drop lens_u." in text
    assert "Features: keep albedo; drop shading_normal." in text
    assert f"Filter: {METHODS[wallpaper.method].label} (chapter 0" in text
    assert (
        f"How sure: {100 * wallpaper.sure:.0f} % of the resamplings of the image's 16 tiles choose that filter" in text
    )
    assert "RPF, if you use it: boxes " in text


def test_without_names_there_is_nothing_to_keep_and_fewer_methods(rng):
    samples = make_samples(
        rng, 16, 16, 3, radiance=1 + 0.3 * rng.normal(size=(16, 16, 3, 3)), random_params={}, features={}
    )
    found = advise(samples, progress=False)
    assert [one.name for one in found.methods] == ["gaussian", "bilateral", "nlm"]
    assert found.layout == {"random_params": (), "features": ()}
    assert found.numbers()["rpf_choice"] is None
    assert "Random parameters: keep none; drop nothing." in advice_lines(found)


@pytest.mark.parametrize(
    ("height", "width", "spp", "message"),
    [
        (16, 16, 1, "At least 2 spp are needed, to filter some and judge by the others, got 1."),
        (15, 40, 4, "Advice needs an image of 16 x 16 pixels or more, to compare its tiles, got 15 x 40."),
    ],
)
def test_what_cannot_be_advised_is_said(rng, height, width, spp, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        advise(make_samples(rng, height, width, spp), progress=False)


def test_the_command_keeps_the_light_of_a_soft_shadow_and_drops_a_lens_without_effect(tmp_path, capsys):
    """The renderer may hand over lens numbers that its pinhole camera never used."""
    samples = capture("soft_shadow", 32, 32, 8, seed=100, variant="scalar_rgb")
    rng = np.random.default_rng(0)
    params = {name: samples[name] for name in samples.random_param_names}
    params |= {name: rng.random(samples.hit.shape) for name in ("lens_u", "lens_v")}
    features = {name: samples[name] for name in samples.feature_names}
    path = tmp_path / "samples.npz"
    SampleBuffer.from_arrays(samples.radiance, samples.screen_position, params, features).save(path)
    assert main(["advise", str(path), "--json", str(tmp_path / "advice.json")]) == 0
    output = capsys.readouterr().out
    assert "Random parameters: keep light_u, light_v; drop lens_u, lens_v." in output
    numbers = json.loads((tmp_path / "advice.json").read_text())
    assert numbers["layout"]["random_params"] == ["light_u", "light_v"]
    assert numbers["method"] in numbers["on_front"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["none.npz"], "but there is no file"),
        (["none.npz", "--json", "a.txt"], "The numbers need a name that ends in .json, got 'a.txt'."),
        (["none.npz", "--json", "nowhere/a.json"], "The folder nowhere must exist before a.json is written."),
        (["none.npz", "--seed", "x"], "invalid int value"),
    ],
)
def test_bad_commands_take_one_line(capsys, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    try:
        code = main(["advise", *arguments])
    except SystemExit as leaving:
        code = leaving.code
    assert code == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
