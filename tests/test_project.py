"""House rules as tests: the same requirements everywhere, one version, a quick front door, documented public names."""

import ast
import inspect
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

import mcdenoise as mcd

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
SOURCES = sorted((ROOT / "src").rglob("*.py"))
CONDA_NAMES = {"matplotlib": "matplotlib-base"}  # the same library without a window system
# conda-forge has no Mitsuba, builds OpenCV under another name, and was not seen to hold the last two.
FROM_PIP = {"mitsuba", "opencv-contrib-python-headless", "sphinx-mathjax-offline", "sphinx-revealjs"}


def _split(requirement):
    """Split name and version: numpy>=2.0, and conda's numpy >=2.0."""
    name, bounds = re.fullmatch(r"([A-Za-z0-9_.-]+?)\s*((?:[<>=!~].*)?)", requirement).groups()
    return name, bounds


def test_environment_yml_asks_for_what_pyproject_asks_for():
    environment = yaml.safe_load((ROOT / "environment.yml").read_text())
    assert environment["name"] == PROJECT["name"]
    assert environment["channels"] == ["conda-forge"]
    conda = dict(_split(one) for one in environment["dependencies"] if isinstance(one, str))
    (pip,) = (one["pip"] for one in environment["dependencies"] if isinstance(one, dict))
    wanted = {name: extra for name, extra in PROJECT["optional-dependencies"].items() if name != "peers"}
    extras = [one for extra in wanted.values() for one in extra]
    needed = dict(_split(one) for one in [*PROJECT["dependencies"], *extras])
    from_conda = {CONDA_NAMES.get(name, name): bounds for name, bounds in needed.items() if name not in FROM_PIP}
    own = {"python": PROJECT["requires-python"], "pip": "", "libllvm19": ""}
    assert conda == from_conda | own
    assert pip == [*(name + needed[name] for name in sorted(FROM_PIP)), "--editable ."]


def test_citation_has_the_version_and_licence_of_the_package():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert str(citation["version"]) == PROJECT["version"]
    assert citation["license"] == PROJECT["license"]


def test_the_front_door_opens_without_the_heavy_libraries():
    code = (
        "import sys, mcdenoise; print([m for m in ('mitsuba', 'numba', 'matplotlib', 'skimage') if m in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


@pytest.mark.parametrize("name", mcd.__all__)
def test_public_names_are_documented_with_an_example(name):
    text = inspect.getdoc(getattr(mcd, name))
    assert text, f"mcd.{name} needs a docstring"
    assert ">>> " in text, f"mcd.{name} needs a runnable example"


def test_the_front_door_is_sorted_and_whole():
    assert sorted(mcd.__all__) == mcd.__all__
    assert all(hasattr(mcd, name) for name in mcd.__all__)


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.stem)
def test_no_except_hides_a_failure(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ExceptHandler):
            assert node.type is not None, f"{path.name}:{node.lineno}: bare except"
            assert "BaseException" not in ast.unparse(node.type), f"{path.name}:{node.lineno}: catches everything"


def test_every_name_of_the_sample_layout_is_in_the_notation():
    notation = (ROOT / "NOTATION.md").read_text()
    from mcdenoise.samples.layout import FEATURES, RANDOM_PARAMS

    missing = [name for name in (*RANDOM_PARAMS, *FEATURES) if f"`{name}`" not in notation]
    assert not missing
