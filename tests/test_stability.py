"""The catalogue of failures: one test an entry, level and method states the guarantee; what is not given is a strict xfail."""

import copy
from dataclasses import asdict, replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from mcdenoise import SampleBuffer
from mcdenoise.study import stability_run
from mcdenoise.study.entries import read_study
from mcdenoise.study.methods import METHODS
from mcdenoise.study.stability import CATALOGUE, LIMITS, PICTURED, Settings, broken_in, charts, lines, pictures, study
from mcdenoise.study.stability_run import run_case
from mcdenoise.study.stability_scenes import build, noise_factors, plain, room
from mcdenoise.study.stability_tables import breakdown, firefly_damage
from mcdenoise.study.stability_troubles import broken_radiance

pytestmark = pytest.mark.ch10

ROOT = Path(__file__).parents[1]
DIVIDES_BY_ALBEDO = ("joint_nlm", "lbf", "lbf_nlm")
LEAST_ALBEDO = 0.1  # what is divided by is never below


@pytest.fixture(scope="session")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("stability") / "stability.json"


@pytest.fixture(scope="session")
def found(path):
    """The quick study, once."""
    return study(Settings.quick(), path, progress=False)


@pytest.fixture(scope="session")
def full():
    """The full study, as the lecture shows it."""
    return read_study(ROOT / "lectures" / "studies" / "stability.json", "stability")


def numbers_of(found, name, method, level):
    levels = {one["level"]: one for one in found["entries"][name]["levels"]}
    return levels[level]["methods"][method]


def every_guarantee(study):
    """One parameter an entry, level and method; where the guarantee is not given, the reason and the number seen."""
    for name, case in CATALOGUE.items():
        for level in case.levels:
            for method in METHODS:
                limit = broken_in(study, name, method, level)
                marks = []
                if limit:
                    reason = f"{limit.reason} ({case.unit} up to {limit.seen:g}; bound {case.bound:g})"
                    marks = [pytest.mark.xfail(strict=True, raises=AssertionError, reason=reason)]
                yield pytest.param(name, level, method, marks=marks, id=f"{name}-{level}-{method}".replace(" ", ""))


@pytest.mark.parametrize(("name", "level", "method"), list(every_guarantee("quick")))
def test_guarantee(found, name, level, method):
    """The worst number over the seeds stays within the bound of its entry."""
    assert_held(numbers_of(found, name, method, level), CATALOGUE[name])


@pytest.mark.parametrize(("name", "level", "method"), list(every_guarantee("full")))
def test_guarantee_in_the_full_study(full, name, level, method):
    """The same in the stored results, with more seeds and larger images: some limits show only there."""
    assert_held(numbers_of(full, name, method, level), CATALOGUE[name])


def assert_held(numbers, case):
    assert numbers.get("failure") is None, numbers["failure"]
    assert numbers["value"] <= case.bound, f"{case.guarantee} {case.unit}: {numbers['value']:.4g}, bound {case.bound:g}"


def test_the_stored_study_is_of_this_catalogue(full):
    assert full["settings"] == asdict(Settings())
    assert list(full["entries"]) == list(CATALOGUE)
    for name, case in CATALOGUE.items():
        assert [one["level"] for one in full["entries"][name]["levels"]] == list(case.levels)


@pytest.mark.parametrize("name", CATALOGUE)
def test_an_average_of_pixels_stays_within_their_range(found, name):
    """Those that divide by an albedo of at least 0.1 may leave it, by less than a factor of ten; RPF averages samples."""
    for level in found["entries"][name]["levels"]:
        for method, numbers in level["methods"].items():
            if numbers.get("outside") is not None and not method.startswith("rpf"):
                most = 1 / LEAST_ALBEDO - 1 if method in DIVIDES_BY_ALBEDO else 1e-5
                assert numbers["outside"] <= most, (level["level"], method)


@pytest.mark.parametrize("name", CATALOGUE)
def test_squared_bias_and_variance_add_up_to_the_error(found, name):
    for level in found["entries"][name]["levels"]:
        for numbers in [*level["methods"].values(), level.get("unfiltered", {})]:
            if numbers.get("relmse"):
                both = numbers["bias_squared"] + numbers["variance"]
                assert both == pytest.approx(numbers["relmse"]["mean"], rel=1e-9, abs=1e-30)
                assert numbers["relmse"]["mean"] <= numbers["relmse"]["worst"]


@pytest.mark.parametrize("name", LIMITS)
def test_the_numbers_in_the_reasons_are_those_seen(found, name):
    """Within a factor of 1.3, so that a limit which moves is written down again; and every limit names what there is."""
    for limit in (one for one in LIMITS[name] if one.quick):
        levels = limit.levels or CATALOGUE[name].levels
        assert set(levels) <= set(CATALOGUE[name].levels)
        assert set(limit.methods) <= set(METHODS)
        values = [numbers_of(found, name, method, level)["value"] for method in limit.methods for level in levels]
        worst = max(np.inf if value is None else value for value in values)
        assert worst == limit.seen or limit.seen / 1.3 < worst < limit.seen * 1.3, (limit.methods, worst)


def test_every_entry_says_what_it_is():
    assert len(CATALOGUE) >= 25
    for case in CATALOGUE.values():
        assert all((case.title, case.varied, case.levels, case.expected, case.guarantee, case.unit))
        assert (case.make is None) != (case.special is None)


def test_nan_and_infinity_are_refused_in_words():
    good, radiance = broken_radiance(Settings.quick(), seed=0)
    assert np.isnan(radiance).any()
    assert np.isinf(radiance).any()
    with pytest.raises(ValueError, match=r"radiance must be finite: .* pass nonfinite='zero'"):
        SampleBuffer.from_arrays(radiance, good.samples.screen_position)


def refuses_fireflies(image, **_):
    """An image, or a message in place of one."""
    if image.max() > 5:
        raise ValueError("too bright")
    return image


BROKEN = {  # a filter that is wrong, and the entry that finds it
    "brightens by a hundredth": ("flat", lambda image, **_: 1.01 * image),
    "one value is NaN": (
        "few_spp",
        lambda image, **_: np.where(np.arange(image.size).reshape(image.shape) == 7, np.nan, image),
    ),
    "refuses fireflies": ("firefly_value", refuses_fireflies),
    "moves the image by a pixel": ("noise_free", lambda image, **_: np.roll(image, 1, axis=1)),
    "takes the mean of the image": ("firefly_value", lambda image, **_: 0 * image + image.mean()),
    "clamps to white": ("scale", lambda image, **_: np.minimum(image, 1)),
    "overshoots": ("small_image", lambda image, **_: 2 * image - image.mean()),
}


@pytest.mark.parametrize("fault", BROKEN)
def test_a_broken_filter_is_found(fault, monkeypatch):
    """The guarantees can fail: each of these filters breaks that of its entry."""
    name, wrong = BROKEN[fault]
    monkeypatch.setattr(stability_run, "METHODS", {"gaussian": replace(METHODS["gaussian"], filter=wrong)})
    for cached in (stability_run._base_images, stability_run.normal_seconds, stability_run.compiled):
        cached.cache_clear()
    try:
        levels = run_case(CATALOGUE[name], replace(Settings.quick(), size=12))["levels"]
    finally:
        for cached in (stability_run._base_images, stability_run.normal_seconds, stability_run.compiled):
            cached.cache_clear()
    held = [level["methods"]["gaussian"]["held"] for level in levels]
    assert not all(held)
    if fault in ("one value is NaN", "refuses fireflies"):
        assert all(level["methods"]["gaussian"]["failure"] for level in levels)


@pytest.mark.parametrize("spread", [0.1, 1.0, 3.0])
def test_noise_has_mean_1_and_the_spread_asked_for(spread):
    factors = noise_factors(np.random.default_rng(0).random(400_000), spread)
    assert factors.mean() == pytest.approx(1, abs=5 * spread / np.sqrt(factors.size))
    assert factors.std() == pytest.approx(spread, rel=0.1)
    assert factors.min() >= 0


def test_the_truth_is_the_expected_image():
    """The mean of many samples is within 5 standard errors of it, nearly everywhere."""
    truth, features = room(6, 6)
    mean = build(truth, features, spp=4000, seed=1).radiance.mean(axis=2)
    assert np.abs(mean / truth - 1).max() < 5 / np.sqrt(4000)


def test_seeds_are_independent_and_repeatable():
    one, again, other = (plain(Settings.quick(), seed).samples.radiance for seed in (0, 0, 1))
    np.testing.assert_array_equal(one, again)
    assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1] - np.corrcoef(one.ravel(), one[::-1].ravel())[0, 1]) < 0.2


def test_a_finished_study_is_read_and_not_run_again(found, path):
    assert study(Settings.quick(), path, progress=False) == found


def test_tables_show_every_entry_and_the_target(found):
    text = "\n".join(lines(found))
    for case in CATALOGUE.values():
        assert case.title in text
    assert "guarantees held. Not held:" in text
    assert " above 3, of these " in text
    for name, limits in LIMITS.items():
        assert f"  {name}, " in text or not any(limit.quick for limit in limits)


def test_breakdown_names_the_noise_where_a_fixed_bandwidth_does_harm(found):
    harmed, slope = breakdown(found)["gaussian"]
    assert harmed[0] == 0.01
    assert 1 not in harmed
    assert 1.5 < slope < 2.5
    assert breakdown(found)["nlm"][0] == []


def test_a_firefly_that_stays_costs_what_it_costs_unfiltered(found):
    """The bilateral family leaves it where it is; a bell spreads the same energy over more pixels, which has smaller squares."""
    damage = {name: added for name, (_, added) in firefly_damage(found).items()}
    assert damage["bilateral"] == pytest.approx(damage["unfiltered"], rel=0.01)
    assert damage["gaussian"] < 0.5 * damage["unfiltered"]


def test_charts_are_made_from_the_stored_numbers(found):
    made = charts(found)
    assert sorted(made) == ["bias_variance", "breakdown", "fireflies", "overview", "times"]
    FigureCanvasAgg(made["fireflies"])
    made["fireflies"].draw_without_rendering()
    cells = [text.get_text() for text in made["overview"].axes[0].texts]
    assert len(cells) == len(CATALOGUE) * len(METHODS)
    broken = copy.deepcopy(found)
    broken["entries"]["flat"]["levels"][0]["methods"]["nlm"] |= {"value": None, "held": False, "failure": "a message"}
    cells = [text.get_text() for text in charts(broken)["overview"].axes[0].texts]
    assert cells.count("× no image") == 1
    assert "NL-means: a message" in "\n".join(lines(broken))


def test_a_page_of_pictures():
    figure = pictures("firefly_value", replace(Settings.quick(), size=12))
    FigureCanvasAgg(figure)
    figure.savefig(stream := BytesIO(), dpi=150)
    assert stream.tell() < 200_000
    titles = [axes.get_title().split("\n")[0] for axes in figure.axes]
    assert titles == ["unfiltered", *(method.label for method in METHODS.values()), "truth"]


def test_what_has_no_pictures_says_so():
    with pytest.raises(ValueError, match="name must be one of 'firefly_count'"):
        pictures("threads", Settings.quick())
    assert "threads" not in PICTURED
