"""Speed against accuracy: closed forms on made-up results, the curves of the methods, and the quick study itself."""

import json
import re
import sys
from dataclasses import asdict, replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conftest import make_samples
from mcdenoise.lbf.denoise import lbf
from mcdenoise.metrics import relmse
from mcdenoise.samples import pixel_mean
from mcdenoise.study import speed_accuracy_measure as measure
from mcdenoise.study.methods import METHODS
from mcdenoise.study.peers import GUIDED, OIDN, user_methods
from mcdenoise.study.show import indexed_png
from mcdenoise.study.speed_accuracy import CHARTS, Settings, charts, entries, lines, pooled, study
from mcdenoise.study.speed_accuracy_curves import Curve, Setting, all_curves, our_curves
from mcdenoise.study.speed_accuracy_results import (
    UNFILTERED,
    best_for_a_time,
    equal_spp,
    equal_time,
    error_slopes,
    front,
    growth,
    missing,
    pooled_monte_carlo,
    scene_monte_carlo,
    scene_points,
)
from mcdenoise.study.speed_accuracy_style import spread, styles

pytestmark = pytest.mark.ch10
SPPS, MORE = (2, 8, 32), (128, 512)
SPREAD = (0.5, 2.0)  # error of each seed over their geometric mean


def row(label, setting, seconds, relmse, usual=True, peer=False):
    """One setting as the study stores it."""
    names = {"method": label, "label": label, "setting": setting, "usual": usual, "peer": peer, "parameters": {}}
    return {**names, "seconds": seconds, "repeats": 3, "relmse": [factor * relmse for factor in SPREAD]}


@pytest.fixture
def made_up():
    """Two scenes whose Monte Carlo error is a / spp exactly, and filters whose seconds and errors are round numbers."""
    settings = Settings(scenes=("a", "b"), spps=SPPS, seeds=2, monte_carlo_spps=MORE)
    found = {"settings": json.loads(json.dumps(asdict(settings))), "cores": 2, "entries": {}}
    for scene, noise, cost in (("a", 0.4, 0.01), ("b", 1.6, 0.04)):
        for spp in SPPS:
            rows = [
                row("Gaussian", "radius 1", 0.1 * cost, noise / spp / 2, usual=False),
                row("Gaussian", "radius 9", 8 * cost, noise / spp / 4),
                row("LBF", "radius 27", 24 * cost, noise / 16 / np.sqrt(spp)),
                row(OIDN, "", cost, noise / spp, peer=True),
            ]
            rows += [row("RPF", "box 3", cost, noise)] if scene == "a" else []
            entry = {"scene": scene, "spp": spp, "choose_seconds": 1.5, "missing": [GUIDED], "rows": rows}
            found["entries"][f"{scene}, {spp} spp"] = {**entry, "unfiltered": [f * noise / spp for f in SPREAD]}
        spp = [*SPPS, *MORE]
        errors = [[factor * noise / n for factor in SPREAD] for n in spp]
        times = {"fixed_seconds": 0.3, "seconds_per_spp": cost}
        found["entries"][f"{scene}, Monte Carlo"] = {"scene": scene, "spp": spp, "relmse": errors, **times}
    sizes = {"pixels": [64, 256, 1024], "spp": [2, 8, 32], "window": [1, 2, 4]}
    for quantity, values in sizes.items():
        sides = 2 * np.array(values) + 1.0 if quantity == "window" else np.array(values, float)
        grown = [
            {"label": label, "peer": False, "values": values, "seconds": (1e-4 * sides**power).tolist()}
            for label, power in (("Gaussian", 1.0), ("LBF", 2.0))
        ]
        found["entries"][f"growth with {quantity}"] = {"quantity": quantity, "rows": grown}
    return found


def test_pooling_takes_geometric_means_over_scenes(made_up):
    points = pooled(made_up, 8)
    assert list(points) == [UNFILTERED, "Gaussian, radius 1", "Gaussian, radius 9", "LBF, radius 27", OIDN]
    gaussian = points["Gaussian, radius 9"]
    assert gaussian.per_seed == pytest.approx([factor * 0.8 / 8 / 4 for factor in SPREAD])
    assert gaussian.relmse == pytest.approx(0.8 / 8 / 4)
    assert (gaussian.filter_seconds, gaussian.render_seconds) == pytest.approx((8 * 0.02, 8 * 0.02))
    assert gaussian.seconds == pytest.approx(16 * 0.02)
    assert points[UNFILTERED].seconds == pytest.approx(8 * 0.02)
    assert points[OIDN].peer
    assert not gaussian.peer


def test_a_setting_that_one_scene_lacks_is_left_out_of_the_pool_alone(made_up):
    assert "RPF, box 3" in scene_points(made_up, "a", 8)
    assert "RPF, box 3" not in scene_points(made_up, "b", 8)
    assert "RPF, box 3" not in pooled(made_up, 8)


def test_equal_error_is_told_in_samples(made_up):
    found = equal_spp(made_up, 8)
    assert found["Gaussian, radius 9"] == pytest.approx({"a": 32, "b": 32})
    assert found[OIDN] == pytest.approx({"a": 8, "b": 8})
    assert found["LBF, radius 27"] == pytest.approx({"a": 16 * np.sqrt(8), "b": 16 * np.sqrt(8)})
    assert found["RPF, box 3"] == pytest.approx({"a": 1})


def test_equal_time_is_what_monte_carlo_makes_of_the_filter_seconds(made_up):
    found = equal_time(made_up, 8)
    assert found["Gaussian, radius 9"] == pytest.approx({"a": 0.4 / 16, "b": 1.6 / 16})
    assert found["LBF, radius 27"] == pytest.approx({"a": 0.4 / 32, "b": 1.6 / 32})


def test_slopes_are_exact_where_the_law_is(made_up):
    assert scene_monte_carlo(made_up, "a").slope(64) == pytest.approx(-1)
    assert pooled_monte_carlo(made_up).slope(64) == pytest.approx(-1)
    slopes = error_slopes(made_up)
    assert slopes["Gaussian"] == pytest.approx({"": -1, "a": -1, "b": -1})
    assert slopes["LBF"] == pytest.approx({"": -0.5, "a": -0.5, "b": -0.5})
    assert "RPF" not in slopes  # not on every scene


def test_monte_carlo_is_pooled_as_the_filters_are(made_up):
    rival = pooled_monte_carlo(made_up)
    np.testing.assert_allclose(rival.relmse, 0.8 / np.array([*SPPS, *MORE]))
    np.testing.assert_allclose(rival.seconds, 0.02 * np.array([*SPPS, *MORE]))
    assert rival.fixed_seconds == 0


def test_the_front_holds_who_is_not_beaten(made_up):
    """At 8 spp: radius 1 costs 8.1 samples and is worth 16; radius 9 costs 16, is worth 32; LBF costs 32 for 45; OIDN 9 for 8."""
    on_front = front(pooled(made_up, 8).values(), pooled_monte_carlo(made_up))
    names = [label for label, *_ in on_front]
    expected = ["Gaussian, radius 1", "Gaussian, radius 9", "LBF, radius 27"]
    assert names == ["Monte Carlo 2 spp", "Monte Carlo 8 spp", *expected, "Monte Carlo 128 spp", "Monte Carlo 512 spp"]
    seconds, errors = np.array([one[1:] for one in on_front]).T
    assert (np.diff(seconds) > 0).all()
    assert (np.diff(errors) < 0).all()


def test_the_best_for_a_time_is_sought_over_all_spp(made_up):
    best = [(point.curve, point.spp) for point in best_for_a_time(made_up)]
    # LBF at 2 spp (26 samples' time, worth 22.6) loses to the wide Gaussian at 8 spp (16 samples' time, worth 32).
    assert ("LBF", 2) not in best
    assert best[:2] == [(UNFILTERED, 2), ("Gaussian", 2)]
    assert best[-1] == (UNFILTERED, 512)


def test_growth_is_fitted_over_the_width_of_the_window(made_up):
    for quantity in ("pixels", "spp", "window"):
        rows = growth(made_up, quantity)
        assert [exponent for *_, exponent in rows] == pytest.approx([1, 2])
    assert rows[0][2].tolist() == [3, 5, 9]


def test_the_tables_say_everything(made_up):
    text = "\n".join(lines(made_up))
    assert missing(made_up) == [GUIDED]
    assert f"not installed: {GUIDED}" in text
    assert "8 spp, geometric means over 2 scenes" in text
    assert "Choosing took 9 s, which nobody is charged for" in text
    gaussian = next(line for line in lines(made_up) if "Gaussian, radius 9" in line and "25.00" in line)
    # relMSE (seeds), filter and total seconds, equal-error spp, equal-time relMSE, 0.16 s for 24 samples: 6.67 ms, front
    numbers = ["25.00", "12.50", "50.00", "0.1600", "0.3200", "32.0", "50.00", "6.67"]
    assert re.findall(r"\d+\.\d+", gaussian) == numbers
    assert gaussian.endswith("*")
    oidn = next(line for line in lines(made_up) if OIDN in line)
    assert oidn.rstrip().endswith("never")
    assert re.search(r"front: Monte Carlo 2 spp; .*Gaussian, radius 9", text)
    assert re.search(r"LBF +-0.50 +-0.50 +-0.50", text)
    assert re.search(r"Gaussian +1.00 +1.00 +1.00", text)
    assert re.search(r"a +0.300 +10.00 +-1.00 +0.39\n", text)  # 12.5 at 32 spp, over 1024 / 32


def test_a_peer_that_was_installed_half_way_is_shown_where_it_was_there(made_up):
    for spp in (2, 8):
        entry = made_up["entries"][f"a, {spp} spp"]
        entry["rows"] = [one for one in entry["rows"] if one["label"] != OIDN]
    assert OIDN not in pooled(made_up, 8)
    assert OIDN in pooled(made_up, 32)
    assert OIDN not in error_slopes(made_up)
    assert set(equal_spp(made_up, 8)[OIDN]) == {"b"}
    assert sum(OIDN in line for line in lines(made_up)) == 1  # its row at 32 spp
    for name in ("speed_accuracy_scenes", "equal_error_spp"):
        assert CHARTS[name](made_up).get_suptitle()


def test_a_study_that_stopped_half_way_is_refused_with_its_gap(made_up):
    del made_up["entries"]["b, Monte Carlo"]
    with pytest.raises(ValueError, match=r"lacks its entry 'b, Monte Carlo'\. Run it to its end"):
        pooled(made_up, 8)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"chart_spp": 6}, r"chart_spp must be one of spps = \(2, 4, 8, 16, 32\), got 6"),
        ({"spps": (1, 8)}, r"at least two different spp from 2 on, ascending, got \(1, 8\)"),
        ({"spps": (8,)}, r"got \(8,\)"),
        ({"spps": (8, 2)}, r"got \(8, 2\)"),
        ({"monte_carlo_spps": (16, 64)}, r"between spps and reference_spp, got \(16, 64\) between 32 and 1024"),
        ({"monte_carlo_spps": (64,)}, r"must be at least two spp"),
        ({"reference_spp": 256}, r"between 32 and 256"),
    ],
)
def test_settings_that_cannot_be_measured_are_refused(changes, words):
    with pytest.raises(ValueError, match=words):
        Settings(**changes)


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12))
def test_labels_move_apart_and_keep_their_order(heights):
    heights = np.array(heights)
    moved = spread(heights, 0.05)
    order = np.argsort(heights, kind="stable")
    assert (np.diff(moved[order]) > 0.05 - 1e-9).all()
    assert moved.mean() == pytest.approx(heights.mean(), abs=1e-9)


def test_every_method_has_a_curve_and_its_usual_setting_is_what_the_method_does(rng):
    samples = make_samples(rng, 12, 12, 4)
    curves = {curve.name: curve for curve in our_curves()}
    assert list(curves) == list(METHODS)
    for curve in curves.values():
        assert len(curve.settings) > 1
        assert not curve.peer
    for name in ("rpf", "lbf", "lbf_nlm"):
        usual = curves[name].settings[curves[name].usual]
        image = curves[name].method.run(samples, **usual.dial)
        np.testing.assert_array_equal(image, METHODS[name].run(samples))
    narrow = curves["lbf"].method.run(samples, radius=0)
    np.testing.assert_allclose(narrow, pixel_mean(samples.radiance), rtol=1e-5)
    assert not np.allclose(narrow, lbf(samples))


def test_the_dial_of_time_is_not_chosen(samples):
    curves = {curve.name: curve for curve in our_curves()}
    assert {one["search_radius"] for one in curves["nlm"].method.candidates(samples)} == {7}
    assert {one["patch_radius"] for one in curves["nlm"].method.candidates(samples)} == {1, 3}
    assert list(curves["rpf_report"].method.candidates(samples)) == [{}]
    for name, curve in curves.items():
        dial = curve.settings[0].dial
        for candidate in curve.method.candidates(samples):
            assert {**candidate, **dial}.items() >= dial.items()
        assert all(setting.dial.keys() == dial.keys() for setting in curve.settings), name


def test_few_settings_are_the_fastest_and_the_usual_one():
    curves, _ = all_curves(few=True)
    ours = {curve.name: [setting.label for setting in curve.settings] for curve in curves if not curve.peer}
    assert ours["lbf"] == ["radius 3", "radius 27"]
    assert ours["rpf"] == ["box 3", "boxes 5, 3"]
    assert all(curve.usual == len(curve.settings) - 1 for curve in curves)


def test_peers_that_are_not_installed_are_listed(monkeypatch):
    for name in ("cv2", "skimage", "pyoidn"):
        monkeypatch.setitem(sys.modules, name, None)
    curves, absent = all_curves()
    assert [curve.name for curve in curves] == list(METHODS)
    assert absent == list(user_methods())
    assert len(absent) == 6


def test_the_denoiser_of_intel_joins_where_it_is_installed(monkeypatch, samples):
    fake = SimpleNamespace(denoise=lambda colour, hdr, **guides: 2 * colour)
    monkeypatch.setitem(sys.modules, "pyoidn", fake)
    curves, absent = all_curves()
    oidn = next(curve for curve in curves if curve.label == OIDN)
    assert oidn.peer
    assert OIDN not in absent
    np.testing.assert_array_equal(oidn.method.run(samples), 2 * pixel_mean(samples.radiance))


@pytest.mark.parametrize("label", [label for label, method in user_methods().items() if method and label != OIDN])
def test_lists_of_peers_are_short_and_hold_what_helps_on_a_flat_image(label, rng):
    shape = (16, 16, 4)
    features = {name: rng.random((*shape, 3)) for name in ("albedo", "shading_normal")}
    samples = make_samples(rng, *shape, radiance=rng.gamma(2.0, 0.5, (*shape, 3)), features=features)
    method, truth = user_methods()[label], np.ones((16, 16, 3))
    candidates = method.candidates(samples)
    assert 1 < len(candidates) <= 60
    errors = [relmse(method.run(samples, **parameters), truth) for parameters in candidates]
    assert min(errors) < 0.6 * relmse(pixel_mean(samples.radiance), truth)


def test_the_guided_filter_is_never_negative_and_follows_its_guide(rng):
    method = user_methods()[GUIDED]
    if method is None:
        pytest.skip("OpenCV is not installed")
    edge = np.broadcast_to((np.arange(16) >= 8)[:, np.newaxis, np.newaxis], (16, 16, 4, 3)).astype(float)
    samples = make_samples(rng, 16, 16, 4, radiance=5 * edge, features={"albedo": edge})
    image = method.run(samples, guide="grey", radius=2, epsilon=0.003)
    assert image.min() >= 0
    np.testing.assert_allclose(image, 5 * edge[:, :, 0], atol=0.2)
    blind = method.run(samples, guide="mixed", radius=2, epsilon=100.0)
    assert blind[:, 7].min() > 0.5  # a straight line of no slope: the mean of the window


def test_slow_settings_run_at_the_spp_of_the_charts_alone(monkeypatch, rng):
    samples = make_samples(rng, 16, 16, 8)
    curve = Curve(
        METHODS["gaussian"], (Setting("radius 1", {"radius": 1}), Setting("radius 2", {"radius": 2}, slow=True))
    )
    asked = []

    def captured(scene, size, spp, seed):
        asked.append((scene, size, spp, seed))
        return samples

    monkeypatch.setattr(measure, "captured", captured)
    monkeypatch.setattr(measure, "warmed_curves", lambda few: ([curve], [GUIDED]))
    monkeypatch.setattr(measure, "render_reference", lambda *_, **__: np.ones((16, 16, 3)))
    settings = replace(Settings.quick(), repeats=2)
    few, all_of_them = (measure.measure_scene(settings, "dof", spp) for spp in (2, 8))
    assert [one["setting"] for one in few["rows"]] == ["radius 1"]
    assert [one["setting"] for one in all_of_them["rows"]] == ["radius 1", "radius 2"]
    assert [one["usual"] for one in all_of_them["rows"]] == [True, False]
    assert all_of_them["missing"] == [GUIDED]
    assert all_of_them["rows"][0]["repeats"] == 2 * settings.seeds
    # Everything is a part of one capture; bandwidths are chosen on a seed that is not judged.
    assert set(asked) == {("dof", 32, 8, seed) for seed in (0, 1, 2)}


@pytest.fixture(scope="session")
def quick(tmp_path_factory):
    """The quick study, run once."""
    path = tmp_path_factory.mktemp("speed_accuracy") / "study.json"
    return study(Settings.quick(), path, progress=False), path


def test_the_quick_study_leaves_every_entry_as_json(quick):
    found, path = quick
    assert list(found["entries"]) == list(entries(Settings.quick()))
    assert json.loads(path.read_text()) == found
    for name in found["entries"]:
        entry = found["entries"][name]
        if "choose_seconds" in entry:
            assert {one["method"] for one in entry["rows"] if not one["peer"]} == set(METHODS)
            assert all(len(one["relmse"]) == 2 and min(one["relmse"]) > 0 for one in entry["rows"])
            assert all(one["seconds"] > 0 for one in entry["rows"])


def test_a_second_run_goes_on_where_the_first_ended(quick, monkeypatch):
    found, path = quick
    half = json.loads(path.read_text())
    half["entries"] = {name: half["entries"][name] for name in list(half["entries"])[:-1]}
    again = path.with_name("again.json")
    again.write_text(json.dumps(half))
    calls = []
    monkeypatch.setattr(measure, "choose_parameters", lambda *_: pytest.fail("it measured a scene again"))
    monkeypatch.setattr(
        "mcdenoise.study.speed_accuracy.measure_growth", lambda *asked: calls.append(asked) or {"rows": []}
    )
    resumed = study(Settings.quick(), again, progress=False)
    assert calls == [(Settings.quick(), "window")]
    assert list(resumed["entries"]) == list(found["entries"])


def test_up_to_the_filters_spp_monte_carlo_is_their_unfiltered_input(quick):
    found, _ = quick
    for scene in ("dof", "soft_shadow"):
        rival = found["entries"][f"{scene}, Monte Carlo"]
        inputs = [found["entries"][f"{scene}, {spp} spp"]["unfiltered"] for spp in (2, 8)]
        assert rival["relmse"][:2] == inputs
        assert rival["spp"] == [2, 8, 16, 64]
        assert scene_monte_carlo(found, scene).slope(64) == pytest.approx(-1, abs=0.25)


def test_filters_of_the_quick_study_are_worth_more_than_their_samples(quick):
    worth = equal_spp(quick[0], 8)
    for label in ("Gaussian, radius 9", "joint NL-means, search radius 7", "LBF, radius 27"):
        assert min(worth[label].values()) > 8, label


def test_charts_come_from_the_stored_numbers(quick):
    found = json.loads(quick[1].read_text())
    drawn = charts(found)
    assert list(drawn) == list(CHARTS)
    for name, figure in drawn.items():
        assert re.fullmatch("[a-z_]+", name)
        assert figure.get_suptitle()
        assert all(axes.get_xlabel() for axes in figure.axes if axes.axison), name
    assert len(indexed_png(drawn["error_spp_pooled"], 150)) < 200_000
    assert len(lines(found)) > 50


def test_our_methods_look_as_in_all_figures_and_peers_are_grey(made_up):
    look = styles(made_up)
    assert [look[label].colour for label in ("Gaussian", "LBF")] == ["#4477AA", "#CC3311"]
    assert look[OIDN].peer
    red, green, blue = (look[OIDN].colour[k : k + 2] for k in (1, 3, 5))
    assert red == green == blue
