"""A small repository with one chapter, for the tests of the build: three exercises, public and hidden tests, data."""

from pathlib import Path

MODULE = '''"""Twice."""

import numpy as np


def doubled_image(image: np.ndarray) -> np.ndarray:
    """Twice the radiance of every pixel."""
    ### BEGIN SOLUTION
    copied_image = image.astype(np.float64)
    return np.add(copied_image, copied_image)
    ### END SOLUTION


def used_elsewhere(image):
    return doubled_image(image)
'''

NOTEBOOK = '''# %% [markdown]
# # 08 Fake
#
# Twice a pixel: $y = 2 x$.

# %% tags=["setup"]
import matplotlib.pyplot as plt
import numpy as np

from mcdenoise.classroom import check
from mcdenoise.filters.window import bell

# %% [markdown]
# Write it.

# %% exercise="doubled_image"
from mcdenoise.twice import doubled_image

# %%
check("doubled_image")

# %% exercise="bell_at_one"
def bell_at_one(sigma_space):
    """The bell at a distance of one pixel."""
    ### BEGIN SOLUTION
    distance_squared = 1.0**2
    return float(np.exp(-distance_squared / (2 * sigma_space**2)))
    ### END SOLUTION

# %%
check("bell_at_one")

# %%
picture = np.ones((2, 2))

# %% exercise="predicted_mean"
predicted_mean = None  # your prediction
### BEGIN SOLUTION
predicted_mean = 0.3125
### END SOLUTION

# %%
check("predicted_mean")
'''

TESTS = '''"""Exercises of chapter 08."""

import math

import numpy as np

from mcdenoise.classroom import assert_matches, graded, picture


def _image():
    # public helper
    return np.arange(6.0).reshape(2, 3)


def _secret_image():
    """A helper that only the hidden test uses."""
    return np.full((3, 3), math.pi)


# Doubling.


@graded("doubled_image", points=1)
def test_every_pixel_is_doubled(impl):
    """Every pixel is twice what it was."""
    assert_matches(impl(_image()), 2 * _image(), "doubled image")


# The hidden twin of the test above.
@graded("doubled_image", points=2, hidden=True)
def test_pi_is_doubled_as_well(impl):
    """Every pixel of another image is doubled."""
    assert_matches(impl(_secret_image()), 2 * _secret_image(), "doubled pi")
    # a last hidden remark


@picture("doubled_image")
def picture_doubled(impl):
    return impl(_image()), 2 * _image()


@graded("bell_at_one", points=1)
def test_the_bell_is_one_for_wide_sigmas(impl):
    """A very wide bell is 1."""
    assert abs(impl(1e6) - 1) < 1e-6, "at sigma_space = 1e6 the bell is 1"


@graded("bell_at_one", points=1.5, hidden=True)
def test_the_bell_at_a_narrow_sigma(impl):
    """The bell at sigma_space = 1."""
    assert abs(impl(1.0) - 0.6065306597) < 1e-9, "the bell: too wide or too narrow; exp(-1/2) at 1"


@graded("predicted_mean", points=1)
def test_the_prediction_is_near(impl):
    """The mean is between 0.3 and 0.4."""
    assert 0.3 < impl < 0.4, "the mean lies elsewhere"
'''

PYPROJECT = '[project]\nname = "fake"\n'


def make_course(root: Path) -> Path:
    """Write the fake repository into `root` and return it."""
    texts = {
        "pyproject.toml": PYPROJECT,
        "src/mcdenoise/twice.py": MODULE,
        "notebooks/ch08_fake.py": NOTEBOOK,
        "tests/exercises/test_ch08.py": TESTS,
    }
    for name, text in texts.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    (root / "notebooks" / "data").mkdir()
    (root / "notebooks" / "data" / "reference.exr").write_bytes(bytes(range(256)))
    return root


def replace(root: Path, name: str, old: str, new: str) -> None:
    """Change one place of a file of the fake repository."""
    text = (root / name).read_text()
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in {name}"
    (root / name).write_text(text.replace(old, new))
