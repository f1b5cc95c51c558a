"""The figures of chapter 10: stored numbers are those of the studies, the page shows and quotes them, tables are whole."""

import json
import re

import numpy as np
import pytest

import mcdenoise as mcd
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.advise import advise
from mcdenoise.study.advise_lines import advice_lines
from mcdenoise.study.entries import json_ready
from mcdenoise.study.figures import _ch10_data as data
from mcdenoise.study.figures import _ch10_failures as failures
from mcdenoise.study.figures import _ch10_needs as needs
from mcdenoise.study.figures import _ch10_price as price
from mcdenoise.study.figures.__main__ import rounded
from mcdenoise.study.figures.ch10 import FIGURES
from mcdenoise.study.methods import METHODS
from mcdenoise.study.speed_accuracy_results import UNFILTERED, MonteCarlo, Point, pooled, pooled_monte_carlo
from mcdenoise.study.stability_catalogue import CATALOGUE
from mcdenoise.study.stability_limits import LIMITS
from stored_figures import (
    assert_quoted_numbers_exist,
    assert_same_numbers,
    assert_stored_shown_and_small,
    page_of,
    stored_numbers,
)

pytestmark = pytest.mark.ch10

STORED = stored_numbers("ch10")
CHEAP = ("reading", "price", "times", "information", "dropping", "boxes", "simplest")


@pytest.mark.parametrize("name", CHEAP)
def test_stored_numbers_are_those_of_the_studies(name):
    assert_same_numbers(rounded(FIGURES[name]()[1], name), STORED[name])


def test_every_figure_is_stored_shown_and_small():
    assert_stored_shown_and_small("ch10", FIGURES)


def test_the_page_quotes_numbers_that_exist():
    assert_quoted_numbers_exist("ch10", at_least=100)


def test_nothing_is_quoted_where_nothing_is_replaced():
    """Within code, and in a formula, a page keeps the brackets."""
    page = page_of("ch10")
    outside = re.sub(r"^```\{figure\}.*?^```", "", page, flags=re.DOTALL | re.MULTILINE)
    for code in re.findall(r"^```.*?^```|^\$\$.*?^\$\$|`[^`\n]*`", outside, re.DOTALL | re.MULTILINE):
        assert "{{" not in code


@pytest.mark.parametrize("path", ["pooled.table", "slopes.table", "growth.table", "simplest.table", "together.table"])
def test_a_table_is_one_block_with_a_row_a_method_or_case(path):
    figure, key = path.split(".")
    lines = STORED[figure][key].splitlines()
    assert {line.count("|") for line in lines} == {lines[0].count("|")}
    expected = needs.entries() if figure == "simplest" else METHODS
    assert len(lines) - 2 >= len(expected)
    assert f"\n{{{{ ch10.{path} }}}}\n" in page_of("ch10")  # alone on its line: a table is a block


def test_the_front_is_what_nobody_beats():
    found = data.study("speed-accuracy")
    spp, rival = found["settings"]["chart_spp"], pooled_monte_carlo(found)
    points = {p.label: (p.seconds, p.relmse) for p in pooled(found, spp).values() if p.curve != UNFILTERED}
    others = [*points.values(), *zip(rival.seconds, rival.relmse, strict=True)]
    beaten = {
        label for label, (s, e) in points.items() if any(a <= s and b <= e and (a, b) != (s, e) for a, b in others)
    }
    assert STORED["pooled"]["front"].count("(") >= 1
    assert STORED["pooled"]["front"] == data.words(sorted(points.keys() - beaten, key=lambda label: points[label]))
    rows = [row for key in ("table", "peers") for row in STORED["pooled"][key].splitlines()]
    yes = {row.split(" |")[0].strip("| ") for row in rows if row.endswith("| yes |")}
    usual = {label for label, point in data.usual_points(found).items() if point.label not in beaten}
    assert yes == usual


def test_a_filter_pays_from_the_price_of_the_samples_that_it_saves():
    for one in STORED["pooled"]["methods"].values():
        saved = one["equal_spp"] - STORED["pooled"]["spp"]
        if saved > 0.5:
            assert one["pays_from_ms"] == pytest.approx(1e3 * one["seconds"] / saved, rel=0.01)
        elif saved < 0:
            assert one["pays_from_ms"] == "infinity"


def test_where_samples_are_costly_accuracy_alone_decides():
    rival = MonteCarlo(np.array([8.0, 64.0]), np.array([[0.08], [0.01]]), 0.0, 1.0)
    point = Point("blur", "", True, False, 8, 8.0, 1.0, (0.02,))
    assert price.gain_at(1e6, point, rival) == pytest.approx(4.0, rel=1e-5)  # Monte Carlo is at 8 spp, too
    assert price.gain_at(1.0, point, rival) == pytest.approx(4.0 * 8 / 9)
    assert price.gain_at(0.125, point, rival) == pytest.approx(2.0)  # 8 more samples in the time of the filter
    found = data.study("speed-accuracy")
    unfiltered = STORED["pooled"]["unfiltered"]
    for name, gain in STORED["price"]["gain"].items():
        ratio = unfiltered / STORED["pooled"]["methods"][name]["relmse"]
        assert gain["costly"] == pytest.approx(ratio, rel=0.03), name
        assert gain["cheap"] < gain["own"] < gain["costly"]
    assert "Monte Carlo" in price.front_by_price(found, pooled_monte_carlo(found))


def test_break_even_is_where_the_two_errors_meet():
    of = STORED["break_even"]
    for name in ("gaussian", "cross_bilateral_prefiltered", "nlm"):
        fit = of["fixed"][name]
        assert fit["crossing"] == pytest.approx((of["noise"] - fit["noise"]) / fit["bias_squared"], rel=0.01)
        assert fit["less_noise"] == pytest.approx(of["noise"] / fit["noise"], rel=0.01)
    reference = data.reference("dof")
    bias = mcd.relmse(mcd.gaussian(reference, sigma_space=0.7), reference)
    assert of["fixed"]["gaussian"]["bias_squared"] == pytest.approx(bias, rel=0.2)  # a linear filter's is known
    assert of["fixed"]["nlm"]["foretold_off"] > of["fixed"]["gaussian"]["foretold_off"]


def test_every_failure_is_in_one_table():
    listed = [name for names in failures.TOPICS.values() for name in names]
    assert sorted(listed) == sorted(CATALOGUE)
    for topic, names in failures.TOPICS.items():
        table = STORED["catalogue"]["tables"][topic]
        assert [row.split(" |")[0].strip("| ") for row in table.splitlines()[2:]] == [CATALOGUE[n].title for n in names]


def test_the_catalogue_adds_up():
    of = STORED["catalogue"]
    assert sum(one["checks"] for one in of["by_method"].values()) == of["checks"]
    assert sum(one["held"] for one in of["by_method"].values()) == of["held"] <= of["checks"]
    for name, one in of["by_method"].items():
        assert STORED["together"]["methods"][name]["held"] == pytest.approx(100 * one["held"] / one["checks"], rel=1e-3)


@pytest.mark.parametrize("method", METHODS)
def test_every_limit_of_a_method_is_on_the_page_with_its_reason(method):
    table = STORED["catalogue"]["limits"][method]
    assert f"\n{{{{ ch10.catalogue.limits.{method} }}}}\n" in page_of("ch10")
    for name, limits in LIMITS.items():
        for limit in limits:
            if method in limit.methods:
                assert CATALOGUE[name].title in table
                assert limit.reason in table


def test_damage_of_a_gaussian_is_the_formula():
    of = STORED["fireflies"]
    for value in ("10000", "1e+06"):
        away, border = of["formula"][value], of["formula_at_border"][value]
        assert 0.99 * away <= of["damage"]["gaussian"][value] <= 1.01 * border**2 / away  # at most in a corner
    assert of["sum_of_squares"] == pytest.approx(of["sum_formula"], rel=0.05)


def test_the_median_bears_what_it_must_and_no_more():
    of = STORED["median"]
    assert of["bears"] == {"1": 0, "4": 1, "5": 2, "16": 7}
    for groups, most in of["bears"].items():
        for count, error in of["relmse"][groups].items():
            assert (error < 1) == (int(count) <= most), (groups, count)
    for light in of["light"].values():
        assert 0 == light["1"] > light["4"] > light["16"]


def test_a_decoy_is_chance_and_a_lens_is_not():
    of = STORED["permutation"]
    assert of["lens_u"]["p"] == of["light_u"]["p"] == of["smallest_p"] == 1 / (1 + of["shuffles"])
    assert of["decoy"]["p"] > 0.05
    assert of["decoy"]["chance"] == pytest.approx(of["lens_u"]["chance"], rel=0.05)
    assert STORED["information"]["decoys_taken"] <= 0.2 * STORED["information"]["decoys"]


def test_fewer_filtered_samples_ask_for_a_wider_bell():
    of = STORED["left_out"]
    assert of["best"]["true"] <= of["best"]["parts"] <= of["best"]["halves"]
    assert of["best"]["true"] < of["best"]["halves"]


def test_a_difference_is_known_better_than_two_errors():
    of = STORED["paired"]
    assert of["paired"] < 0.5 * of["alone"]
    assert of["correlation"] > 0.9
    assert of["methods"]["nlm"]["paired"] < of["methods"]["nlm"]["alone"]


def test_stored_advice_prints_as_it_was_given():
    rng = np.random.default_rng(0)
    corner = np.stack(np.meshgrid(np.arange(16), np.arange(16)), axis=-1)[:, :, np.newaxis]
    light = rng.random((16, 16, 4))
    radiance = 0.5 + 0.5 * np.repeat(light[..., np.newaxis], 3, axis=-1)
    params = {"light_u": light, "lens_u": rng.random(light.shape)}
    samples = SampleBuffer.from_arrays(radiance, corner + rng.random((16, 16, 4, 2)), params)
    given = advise(samples, progress=False)
    stored = json.loads(json.dumps(json_ready(given.numbers())))
    assert advice_lines(needs.advice_of(stored)) == advice_lines(given)


def test_the_printed_advice_is_that_of_its_case():
    printed = STORED["simplest"]["printed"]
    one = next(case for case in needs.entries() if case["scene"] == needs.PRINTED)
    assert METHODS[one["advice"]["method"]].label in printed["recommendation"]
    for kind in needs.ORDER:
        for drop in one["advice"][kind]:
            assert re.search(
                rf"^  {drop['name']} .*{'keep' if drop['keep'] else 'drop'}$", printed["tables"], re.MULTILINE
            )
