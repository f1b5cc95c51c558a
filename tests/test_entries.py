"""A study goes on where it stopped, refuses what is not its own, and never leaves half a file."""

import json
import re

import numpy as np
import pytest

from mcdenoise.study.entries import json_ready, read_study, run_entries

pytestmark = pytest.mark.ch10


def test_an_entry_is_run_once(tmp_path):
    path, runs = tmp_path / "s.json", []
    entries = {name: lambda name=name: runs.append(name) or {"name": name} for name in ("a", "b")}
    first = run_entries(path, "s", {"seed": 0}, {"a": entries["a"]}, progress=False)
    second = run_entries(path, "s", {"seed": 0}, entries, progress=False)
    assert runs == ["a", "b"]
    assert second["entries"] == {"a": {"name": "a"}, "b": {"name": "b"}}
    assert second["seconds"]["a"] == first["seconds"]["a"]
    assert json.loads(path.read_text()) == second == read_study(path, "s")


def test_what_was_done_before_a_failure_stays(tmp_path):
    path = tmp_path / "s.json"
    with pytest.raises(ZeroDivisionError):
        run_entries(path, "s", {}, {"good": lambda: 1, "bad": lambda: 1 / 0}, progress=False)
    assert read_study(path, "s")["entries"] == {"good": 1}
    assert [one.name for one in tmp_path.iterdir()] == ["s.json"]


def test_other_settings_are_refused_by_name(tmp_path):
    path = tmp_path / "s.json"
    run_entries(path, "s", {"seed": 0, "size": 8}, {"a": lambda: 1}, progress=False)
    message = "holds a study with another seed. Use the same options, or another --out."
    with pytest.raises(ValueError, match=re.escape(message)):
        run_entries(path, "s", {"seed": 1, "size": 8}, {"a": lambda: 1}, progress=False)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("no json", "must hold the results of the study s as JSON"),
        ("[]", "must hold the results of the study s. Take another file"),
        (json.dumps({"format": "mcdenoise study 1", "study": "other"}), "must hold the results of the study s. Take"),
    ],
)
def test_foreign_files_are_refused(tmp_path, text, message):
    path = tmp_path / "s.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=re.escape(message)):
        run_entries(path, "s", {}, {}, progress=False)
    assert path.read_text() == text


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ValueError, match=re.escape("The results of the study s are needed")):
        read_study(tmp_path / "none.json", "s")


def test_numbers_of_numpy_become_json():
    given = {"a": np.float32(0.5), "b": np.array([1, 2]), "c": (np.inf, [np.nan, True]), 3: None, "d": np.bool_(True)}
    assert json_ready(given) == {"a": 0.5, "b": [1, 2], "c": [None, [None, True]], "3": None, "d": True}
