"""Things that tests of several rooms use."""

import numpy as np
import pytest
from hypothesis import settings

from mcdenoise.samples import SampleBuffer

pytest_plugins = [
    "mcdenoise.classroom.checking.pytest_plugin",
    "pytester",
]  # `impl` and --impl; pytest to be tested itself

# Files that run in one process where there are several (pytest-xdist): they share the executed notebooks.
TOGETHER = {"test_site.py": "test_notebooks.py"}

# The same examples in every run; no deadline, because the first example may compile a kernel.
settings.register_profile("house", derandomize=True, deadline=None)
settings.load_profile("house")


def pytest_collection_modifyitems(config, items):
    """A file is not divided between processes: its fixtures are made once."""
    if config.pluginmanager.hasplugin("xdist"):
        for item in items:
            item.add_marker(pytest.mark.xdist_group(TOGETHER.get(item.path.name, item.path.name)))


@pytest.fixture
def rng():
    return np.random.default_rng(20260101)


@pytest.fixture(params=["numpy", "numba"])
def engine(request):
    """Both engines of a filter: the reference and its fast twin."""
    return request.param


def noise(*shape, seed=3):
    """Uniform noise in [0, 1)."""
    return np.random.default_rng(seed).random(shape)


def assert_close(precision, engine, actual, expected):
    """Equal up to `precision[engine]`, relative to each value and to the largest."""
    bound = precision[engine]
    np.testing.assert_allclose(actual, expected, rtol=bound, atol=bound * np.abs(expected).max())


def make_samples(rng, height=5, width=7, spp=4, **changes):
    """Samples of a made-up scene: every block random, positions inside their pixels."""
    corner = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)[:, :, np.newaxis]
    size = (height, width, spp)
    arrays = {
        "radiance": rng.gamma(2.0, 0.3, (*size, 3)),
        "screen_position": corner + rng.random((*size, 2)),
        "random_params": {"lens_u": rng.random(size), "lens_v": rng.random(size)},
        "features": {
            "world_position": rng.normal(size=(*size, 3)),
            "visibility": rng.integers(0, 2, size),
            "albedo": rng.random((*size, 3)),
        },
        "provenance": {"scene": "made up", "seed": 1},
    }
    return SampleBuffer.from_arrays(**{**arrays, **changes})


@pytest.fixture
def samples(rng):
    return make_samples(rng)
