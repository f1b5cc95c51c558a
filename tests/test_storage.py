"""Samples on disk: the same back, nothing unchecked, never half a file."""

import json
import zipfile

import numpy as np
import pytest

from conftest import make_samples
from mcdenoise.samples import load_samples
from mcdenoise.samples.storage import ARRAYS, cache_folder, write_beside

pytestmark = pytest.mark.ch01


def test_round_trip(samples, tmp_path):
    samples.save(tmp_path / "a.npz")
    loaded = load_samples(tmp_path / "a.npz")
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(loaded, name), getattr(samples, name))
    assert loaded.layout == samples.layout
    assert dict(loaded.provenance) == dict(samples.provenance)
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]


def test_round_trip_without_features(rng, tmp_path):
    samples = make_samples(rng, features=None, random_params=None, hit=np.zeros((5, 7, 4), bool))
    samples.save(str(tmp_path / "a.npz"))
    loaded = load_samples(str(tmp_path / "a.npz"))
    assert loaded.features.shape == (5, 7, 4, 0)
    assert not loaded.hit.any()


def test_loading_needs_no_pickle(samples, tmp_path):
    path = tmp_path / "a.npz"
    samples.save(path)
    with np.load(path, allow_pickle=False) as stored:
        assert set(stored) == {*ARRAYS, "about"}


def _stored(samples, path, **changes):
    samples.save(path)
    with np.load(path) as stored:
        arrays = {**stored, **changes}
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radiance": None}, "not a whole file of samples"),
        ({"about": np.array({"a": 1}, dtype=object)}, "not a whole file of samples"),
        ({"about": np.array("no json")}, "lacks a readable description"),
        ({"about": np.array("[1]")}, "lacks a readable description"),
        ({"radiance": np.full((5, 7, 4, 3), np.nan)}, "radiance must be finite"),
        ({"radiance": np.ones((5, 7, 3, 3))}, "screen_position must have shape"),
        ({"features": np.ones((5, 7, 4, 8))}, "features names 7 numbers a sample, got shape"),
        ({"features": np.ones((4, 7, 4, 7))}, "must have shape"),
    ],
)
def test_a_file_that_does_not_fit_is_refused(samples, tmp_path, changes, message):
    _stored(samples, tmp_path / "a.npz", **changes)
    with pytest.raises(ValueError, match=message):
        load_samples(tmp_path / "a.npz")


def test_another_format_is_refused(samples, tmp_path):
    about = {"format": "mcdenoise-samples-9", "random_params": {}, "features": {}, "provenance": {}}
    _stored(samples, tmp_path / "a.npz", about=np.array(json.dumps(about)))
    with pytest.raises(ValueError, match="must have the format mcdenoise-samples-1, got 'mcdenoise-samples-9'"):
        load_samples(tmp_path / "a.npz")


def test_nan_in_a_file_can_be_zeroed(samples, tmp_path):
    _stored(samples, tmp_path / "a.npz", radiance=np.full((5, 7, 4, 3), np.nan))
    assert not load_samples(tmp_path / "a.npz", nonfinite="zero").radiance.any()


def test_a_missing_a_cut_and_a_foreign_file_are_refused(samples, tmp_path):
    with pytest.raises(ValueError, match="there is no file"):
        load_samples(tmp_path / "none.npz")
    samples.save(tmp_path / "cut.npz")
    whole = (tmp_path / "cut.npz").read_bytes()
    (tmp_path / "cut.npz").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ValueError, match="not a whole file"):
        load_samples(tmp_path / "cut.npz")
    (tmp_path / "text.npz").write_text("hello")
    with pytest.raises(ValueError, match="not a whole file"):
        load_samples(tmp_path / "text.npz")
    np.save(tmp_path / "array.npy", np.ones(3))
    with pytest.raises(ValueError, match="not a whole file"):
        load_samples(tmp_path / "array.npy")
    with zipfile.ZipFile(tmp_path / "other.npz", "w") as other:
        other.writestr("radiance.npy", b"no array")
    with pytest.raises(ValueError, match="not a whole file"):
        load_samples(tmp_path / "other.npz")


def test_saving_refuses_other_names_and_missing_folders(samples, tmp_path):
    with pytest.raises(ValueError, match=r"stored as .npz, got the name 'a.pkl'"):
        samples.save(tmp_path / "a.pkl")
    with pytest.raises(ValueError, match=r"folder .* must exist"):
        samples.save(tmp_path / "none" / "a.npz")


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fail_half_way():
        with write_beside(path) as temporary:
            temporary.write_text("ne")
            raise RuntimeError("power cut")

    with pytest.raises(RuntimeError, match="power cut"):
        fail_half_way()
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.txt"]


def test_writing_to_a_folder_is_refused(tmp_path):
    with pytest.raises(ValueError, match="A file name is needed"), write_beside(tmp_path):
        pass


def test_cache_folder_follows_the_environment(monkeypatch, tmp_path):
    monkeypatch.setenv("MCDENOISE_CACHE", str(tmp_path / "mine"))
    assert cache_folder() == tmp_path / "mine"
    monkeypatch.delenv("MCDENOISE_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "mcdenoise"
