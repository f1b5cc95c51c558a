"""Choosing a back end: nothing may crash the process, whatever lies on the disk under the name of LLVM."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from mcdenoise.render import capture, choose_variant, variants

pytestmark = pytest.mark.ch01


@pytest.fixture(autouse=True)
def clean(monkeypatch, tmp_path):
    """No remembered verdicts, no choice from outside, a cache folder of our own."""
    variants._verdict.cache_clear()
    monkeypatch.delenv("MCDENOISE_VARIANT", raising=False)
    monkeypatch.setenv("MCDENOISE_CACHE", str(tmp_path / "cache"))
    yield
    variants._verdict.cache_clear()


@pytest.fixture
def library(monkeypatch, tmp_path):
    """A file that DRJIT_LIBLLVM_PATH names, but no library."""
    path = tmp_path / "libLLVM.so.19.1"
    path.write_text("no library")
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(path))
    return path


def test_scalar_needs_no_probe(monkeypatch):
    monkeypatch.setattr(variants, "candidate_libraries", lambda: pytest.fail("looked for LLVM"))
    assert choose_variant("scalar_rgb") == "scalar_rgb"
    monkeypatch.setenv("MCDENOISE_VARIANT", "scalar_rgb")
    assert choose_variant() == "scalar_rgb"


@pytest.mark.parametrize("bad", ["llvm", "cuda_ad_rgb", None, 3])
def test_unknown_variant(bad):
    with pytest.raises(ValueError, match=r"variant must be one of 'auto', 'scalar_rgb', 'llvm_ad_rgb', got"):
        choose_variant(bad)


def test_unknown_variant_in_the_environment(monkeypatch):
    monkeypatch.setenv("MCDENOISE_VARIANT", "fast")
    with pytest.raises(ValueError, match=r"environment variable MCDENOISE_VARIANT must be one of .* got 'fast'"):
        choose_variant()


def test_missing_library_means_no_llvm(monkeypatch, tmp_path):
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(tmp_path / "nowhere.so"))
    assert choose_variant() == "scalar_rgb"
    with pytest.raises(ValueError, match=r"tried: none found\. Install LLVM 17 or newer .*scalar_rgb"):
        choose_variant("llvm_ad_rgb")


def test_file_that_is_no_library(library):
    assert choose_variant() == "scalar_rgb"
    with pytest.raises(ValueError, match=r"tried: .*libLLVM\.so\.19\.1 \(does not render\)"):
        choose_variant("llvm_ad_rgb")


@pytest.mark.skipif(os.name == "nt", reason="Windows has no signals to tell an abort by")
def test_library_that_aborts_the_process(library, monkeypatch):
    monkeypatch.setattr(variants, "_PROBE", "import os; os.abort()")
    with pytest.raises(ValueError, match="killed the process, signal 6"):
        choose_variant("llvm_ad_rgb")


def test_library_that_hangs_is_asked_again_next_time(library, monkeypatch, tmp_path):
    monkeypatch.setattr(variants, "_PROBE", "import time; time.sleep(30)")
    monkeypatch.setattr(variants, "PROBE_SECONDS", 0.2)
    with pytest.raises(ValueError, match="took too long"):
        choose_variant("llvm_ad_rgb")
    assert not (tmp_path / "cache").exists()


def test_verdict_is_kept_on_disk_until_the_library_changes(library, monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr(variants, "_probe", lambda path: asked.append(path) or "does not render")
    for _ in range(2):
        choose_variant()
        variants._verdict.cache_clear()
    assert asked == [str(library)]
    kept = json.loads((tmp_path / "cache" / "llvm_probes.json").read_text())
    assert list(kept.values()) == ["does not render"]
    library.write_text("another build")
    choose_variant()
    assert len(asked) == 2


@pytest.mark.parametrize("broken", ["{", "[]", '"text"'])
def test_broken_verdicts_are_replaced(library, monkeypatch, tmp_path, broken):
    monkeypatch.setattr(variants, "_probe", lambda path: "does not render")
    shelf = tmp_path / "cache" / "llvm_probes.json"
    shelf.parent.mkdir()
    shelf.write_text(broken)
    assert choose_variant() == "scalar_rgb"
    assert len(json.loads(shelf.read_text())) == 1


def test_cache_that_can_not_be_written(library, monkeypatch, tmp_path):
    monkeypatch.setattr(variants, "_probe", lambda path: "does not render")
    (tmp_path / "file").touch()
    monkeypatch.setenv("MCDENOISE_CACHE", str(tmp_path / "file"))
    assert choose_variant() == "scalar_rgb"


def test_candidates_are_libraries_newest_first(monkeypatch, tmp_path):
    names = [
        "libLLVM-14.so.1",
        "libLLVM.so.19.1",
        "libLLVM-17.so",
        "libLLVMCore.a",
        "libLLVM.so.22.1",
        "libLLVM.so.txt",
    ]
    (tmp_path / "lib").mkdir()
    for name in names:
        (tmp_path / "lib" / name).touch()
    monkeypatch.delenv("DRJIT_LIBLLVM_PATH", raising=False)
    for place in ("prefix", "base_prefix"):
        monkeypatch.setattr(sys, place, str(tmp_path))
    monkeypatch.setenv("CONDA_PREFIX", str(tmp_path))
    monkeypatch.setattr(variants, "_FOLDERS", (str(tmp_path / "nowhere*"),))
    found = [path.name for path in variants.candidate_libraries()]
    assert found == ["libLLVM.so.22.1", "libLLVM.so.19.1", "libLLVM-17.so", "libLLVM-14.so.1"]


@pytest.mark.parametrize(
    ("path", "major"),
    [
        ("/usr/lib/llvm-14/lib/libLLVM.so", 14),
        ("/opt/homebrew/Cellar/llvm@18/18.1.8/lib/libLLVM.dylib", 18),
        ("/opt/homebrew/Cellar/llvm/21.1.0/lib/libLLVM.dylib", 21),
        ("/env/lib/libLLVM.dylib", 16.5),
    ],
)
def test_version_of_a_library(path, major):
    assert variants._llvm_version(Path(path)) == major


def test_user_gets_their_own_variant_back():
    import mitsuba as mi

    before = mi.variant()
    try:
        mi.set_variant("scalar_spectral")
        with variants.use_variant("scalar_rgb"):
            assert mi.variant() == "scalar_rgb"
        assert mi.variant() == "scalar_spectral"
        with pytest.raises(ValueError, match="refuses"):
            capture({"type": "scene", "camera": {"type": "perspective"}, "x": {"type": "cub"}}, variant="scalar_rgb")
        assert mi.variant() == "scalar_spectral"
    finally:
        mi.set_variant(before or "scalar_rgb")


def in_child(code, **environment):
    child = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert child.returncode == 0, child.stderr
    return child.stdout.split()


def test_importing_the_room_does_not_import_mitsuba():
    code = "import sys, mcdenoise.render; print('mitsuba' in sys.modules, 'drjit' in sys.modules)"
    assert in_child(code) == ["False", "False"]


def test_capture_without_any_llvm(tmp_path):
    code = (
        "from mcdenoise.render import capture; s = capture('dof', 8, 8, 2); "
        "print(s.provenance['variant'], s.radiance.mean() > 0)"
    )
    assert in_child(code, DRJIT_LIBLLVM_PATH=str(tmp_path / "nowhere.so")) == ["scalar_rgb", "True"]
