"""Contestants in turns, medians, and targets judged rightly; times themselves are never asserted."""

import pytest

from mcdenoise.study.bench_measure import Contestant, Target, Work, measure, table

pytestmark = pytest.mark.ch10


def test_contestants_take_turns_and_the_median_is_scaled():
    order = []

    def contestant(name, **changes):
        return Contestant(name, lambda: order.append(name), **changes)

    ours, theirs, slow = contestant("ours"), contestant("theirs"), contestant("slow", once=True, scale=4.0)
    measure([Work("work", [ours, theirs, slow, Contestant("absent", None)])], repeats=3)
    assert order == ["ours", "theirs", "slow", "ours", "theirs", "slow", "ours", "theirs", "ours", "theirs"]
    assert [len(one.seconds) for one in (ours, theirs, slow)] == [3, 3, 1]
    slow.seconds = [0.5, 1.0, 9.0]
    assert slow.median() == 4.0


@pytest.mark.parametrize(
    ("target", "words"),
    [
        (Target("ours", seconds=0.35), "ours under 0.35 s: 0.300 s, reached"),
        (Target("ours", seconds=0.3), "ours under 0.3 s: 0.300 s, missed"),
        (Target("slower", seconds=0.35), "slower under 0.35 s: 0.400 s, missed"),
        (Target("ours", rival="theirs", times=6), "ours at least 6 x faster than theirs: 6.0 x, reached"),
        (Target("slower", rival="theirs", times=6), "slower at least 6 x faster than theirs: 4.5 x, missed"),
        (
            Target("ours", rival="gone", times=2),
            "ours at least 2 x faster than gone: not measured, it is not installed",
        ),
    ],
)
def test_targets_stand_beside_what_was_measured(target, words):
    contestants = [
        Contestant("ours", print, seconds=[0.3]),
        Contestant("slower", print, seconds=[0.4, 0.4, 9.0]),
        Contestant("theirs", print, scale=2.0, seconds=[0.9]),
        Contestant("gone", None),
    ]
    assert table(Work("work", contestants, targets=[target]), 1)[-1] == f"  target: {words}"
