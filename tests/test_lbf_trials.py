"""The trials of what closes the gap, on two made-up scenes."""

import json

import numpy as np
import pytest

from mcdenoise.lbf.dataset import SceneData
from mcdenoise.lbf.primary import Primary
from mcdenoise.lbf.training import TrainConfig
from mcdenoise.study.lbf_trials import TRIALS, judge, lines, main, run_trials

pytestmark = pytest.mark.ch09
QUICK = TrainConfig(groups=("albedo",), hidden=(2,), radius=2, rows=4, validation_rows=4, epochs=2, drop=False)


def made_up(seed):
    rng = np.random.default_rng(seed)
    reference = rng.uniform(0.3, 0.6, (12, 12, 3)).astype(np.float32)
    noisy = (reference * (1 + 0.5 * rng.normal(size=reference.shape))).astype(np.float32)
    albedo, none = {"albedo": reference}, {"albedo": 0 * reference}
    primaries = [Primary(noisy, 0.05 + 0 * reference, albedo, albedo, none, spp) for spp in (4, 8)]
    return SceneData(f"made up {seed}", tuple(primaries), reference)


def test_every_trial_is_trained_judged_written_and_not_done_twice(tmp_path):
    path, scenes = tmp_path / "trials.json", ([made_up(k) for k in range(4)], [made_up(9)])
    toys = [("toy", primary, made_up(5).reference) for primary in made_up(5).primaries]
    found = run_trials(scenes, toys, path, QUICK)
    assert list(found) == list(TRIALS)
    assert [one["scenes"] for one in found.values()] == [4, 4, 4, 2, 1]
    # Secondary features of albedo and of colour (7 + 1 + 7), two hidden, three outputs; the paper's lacks colour both times.
    assert [one["parameters"] for one in found.values()] == [24, 41, 41, 41, 41]
    assert json.loads(path.read_text()) == found
    stamp = path.stat().st_mtime_ns
    assert run_trials(scenes, toys, path, QUICK) == found
    assert path.stat().st_mtime_ns == stamp
    assert len(lines(found)) == 1 + len(TRIALS)


def test_errors_are_a_geometric_mean_over_scenes():
    class Same:
        """A model that leaves the image as it is."""

        def layer(self, primary):
            self.primary = primary
            return self

        def theta(self, primary):
            return None

        def forward(self, theta):
            return self.primary.colour, None

    flat = np.ones((4, 4, 3), np.float32)
    toys = [("one", Primary(flat, 0 * flat, {}, {}, {}, 4), scale * flat) for scale in (2.0, 1.5)]
    each = [(scale - 1) ** 2 / (scale**2 + 0.01) for scale in (2.0, 1.5)]
    assert judge(Same(), toys)["4"] == pytest.approx(np.sqrt(each[0] * each[1]), rel=1e-6)


def test_the_command_refuses_in_one_line(tmp_path, capsys):
    assert main(["--json", str(tmp_path / "trials.txt")]) == 2
    assert capsys.readouterr().err == "lbf_trials: The numbers need a name that ends in .json, got 'trials.txt'.\n"
