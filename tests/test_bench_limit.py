"""Necessary operations, counted by running the formulas with numbers that count; and the words made of them."""

from itertools import combinations

import pytest

from mcdenoise.study import bench_limit
from mcdenoise.study.bench_filters import NLM, count_taps
from mcdenoise.study.bench_guided import CROSS, CROSS_RADIUS, SEARCH_RADIUS
from mcdenoise.study.bench_limit import (
    Operations,
    cross_bilateral_operations,
    limit_lines,
    nlm_operations,
    peak_rates,
    share_words,
)
from mcdenoise.study.bench_measure import Contestant, Work

pytestmark = pytest.mark.ch10


class Counter:
    """How often numbers met."""

    def __init__(self):
        self.multiply_adds = self.exponentials = 0

    def number(self):
        return Number(self)


class Number:
    """A number without a value: a product that is added to something costs nothing beyond the product."""

    def __init__(self, counter, product=False):
        self.counter, self.product = counter, product

    def __mul__(self, other):
        self.counter.multiply_adds += 1
        return Number(self.counter, product=True)

    def __add__(self, other):
        self.counter.multiply_adds += not (self.product or other.product)
        return Number(self.counter)

    __sub__ = __add__

    def exp(self):
        self.counter.exponentials += 1
        return Number(self.counter)


def near_pairs(size, radius):
    """Pairs of different pixels that see each other, once each."""
    pixels = [(y, x) for y in range(size) for x in range(size)]
    return [(p, q) for p, q in combinations(pixels, 2) if max(abs(p[0] - q[0]), abs(p[1] - q[1])) <= radius]


def gather(counter, weight, colours):
    """Add one weighted pixel to one total and one norm."""
    for _ in range(colours):
        counter.number() + weight * counter.number()
    counter.number() + weight


@pytest.mark.parametrize(("size", "radius", "guides", "colours"), [(4, 2, 9, 3), (3, 5, 2, 1)])
def test_cross_bilateral_operations_are_those_of_the_formula(size, radius, guides, colours):
    counter, pairs = Counter(), near_pairs(size, radius)
    for _ in pairs:
        exponent = counter.number()  # of the spatial weight, from a table
        for _ in range(guides + colours):
            difference = counter.number() - counter.number()
            exponent = exponent - difference * difference
        weight = exponent.exp()
        for _ in range(2):
            gather(counter, weight, colours)
    assert len(pairs) == (count_taps(size, radius) - size**2) // 2
    assert cross_bilateral_operations(len(pairs), guides, colours) == tuple(vars(counter).values())


@pytest.mark.parametrize(("size", "radius", "colours"), [(4, 2, 3), (3, 5, 1)])
def test_nlm_operations_are_those_of_the_formula(size, radius, colours):
    counter, pairs = Counter(), near_pairs(size, radius)
    for _ in pairs:
        reciprocal = counter.number() + counter.number()  # of the sum of variances; the division is not counted
        square = counter.number() * counter.number()  # the smaller variance, times the share taken off
        for _ in range(colours):
            difference = counter.number() - counter.number()
            square = square + difference * difference
        for _ in range(2):
            _ = (square - counter.number() * counter.number()) * reciprocal
            column = counter.number() + Number(counter) - counter.number()  # a row comes, a row goes
            patch = counter.number() + column - counter.number()  # a column comes, a column goes
            gather(counter, patch.exp(), colours)
    assert nlm_operations(len(pairs), colours) == tuple(vars(counter).values())


def test_shares_are_work_over_peak_over_time():
    words = share_words(Operations(3e9, 1e9), Operations(30e9, 4e9), seconds=0.5)
    assert words == "3.00 billion multiply-adds are 20 % and 1.00 billion exponentials 50 % of 500 ms at the peaks"


def test_each_filter_gets_a_line_with_what_was_counted():
    works = [Work("a", [Contestant(CROSS, print, seconds=[1.0])]), Work("b", [Contestant(NLM, print, seconds=[1.0])])]
    title, cross, nlm = limit_lines(works, 512, Operations(40e9, 2e9))
    assert "40.0 billion float32 multiply-adds, 2.00 billion exponentials" in title
    pairs = (count_taps(256, CROSS_RADIUS) - 256**2) // 2
    assert f"{32 * pairs / 1e9:.2f} billion multiply-adds are {100 * 32 * pairs / 40e9:.0f} %" in cross
    assert "(32 and 1 a pair of pixels;" in cross
    pairs = (count_taps(512, SEARCH_RADIUS) - 512**2) // 2
    assert f"{2 * pairs / 1e9:.2f} billion exponentials {100 * 2 * pairs / 2e9:.0f} %" in nlm
    assert "(28 and 2 a pair of pixels;" in nlm


def test_a_run_that_others_disturb_is_no_peak(monkeypatch):
    """The first timed call is slow, the rest take a millisecond a round."""
    taken = [5.0]
    monkeypatch.setattr(bench_limit, "_seconds", lambda run, rounds: taken.pop() if taken else 1e-3 * rounds)
    assert bench_limit.most_rounds(lambda rounds: None, tries=3, seconds=0.01) == pytest.approx(1000)


def test_peaks_are_measured():
    assert min(peak_rates(tries=2, seconds=1e-4)) > 0
