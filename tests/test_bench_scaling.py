"""Laws of growth fitted to made-up times, and every series once, tiny."""

import re

import numpy as np
import pytest

from mcdenoise.study import bench_scaling
from mcdenoise.study.bench_scaling import Series, all_series, law, power_law, scaling_lines, straight_line

pytestmark = pytest.mark.ch10


@pytest.mark.parametrize("exponent", [0.0, 1.0, 1.9])
def test_a_power_is_found_again_through_noise(exponent, rng):
    values = np.array([4, 6, 9, 13, 19, 27])
    seconds = 3e-4 * values**exponent
    np.testing.assert_allclose(power_law(values, seconds), (3e-4, exponent), rtol=1e-9, atol=1e-9)
    _, noisy = power_law(values, seconds * np.exp(rng.normal(0, 0.05, 6)))
    assert noisy == pytest.approx(exponent, abs=0.15)


def test_a_constant_part_is_found_again():
    channels = np.array([0, 3, 6, 9, 18])
    np.testing.assert_allclose(straight_line(channels, 0.02 + 0.003 * channels), (0.02, 0.003))


def test_a_law_says_range_taps_and_share():
    radius = Series("blur", ("radius", "r"), (4, 8, 16), print, taps=lambda r: r**2)
    assert law(radius, [0.001 * r**3 for r in (4, 8, 16)])[0] == (
        "  blur: time ~ radius^3.00 (r = 4 .. 16); taps ~ radius^2.00, so time ~ taps^1.50"
    )
    channels = Series("blur", ("channels", "n"), (0, 9, 18), print, linear=True)
    assert law(channels, [0.009, 0.018, 0.027])[0] == (
        "  blur: time = 9.0 ms + 1.00 ms x channels (n = 0 .. 18); the constant is 50 % of the time at 9 channels"
    )


def test_every_series_runs(monkeypatch):
    for name, values in {
        "CROSS_RADII": (1, 2),
        "CHANNELS": (0, 3),
        "SEARCH_RADII": (1, 2),
        "PATCH_RADII": (1, 2),
    }.items():
        monkeypatch.setattr(bench_scaling, name, values)
    lines = scaling_lines(16, repeats=1)
    assert len(lines) == 1 + 2 * len(all_series(16))
    number = r"-?\d+\.\d\d"
    for quantity in ("radius", "pixels", "search radius", "patch radius"):
        assert re.search(rf": time ~ {quantity}\^{number} \(", "\n".join(lines))
    assert re.search(r"time = -?[\d.]+ ms \+ -?[\d.]+ ms x channels", "\n".join(lines))
