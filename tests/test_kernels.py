"""The kernels themselves: sums apart, bits at any number of threads, machine code, the cache of compiled code."""

import platform
import re
import subprocess
import sys

import numba
import numpy as np
import pytest
from numba.core import types

from mcdenoise.filters.bilateral import bilateral_sums
from mcdenoise.filters.cross_bilateral import cross_bilateral_sums
from mcdenoise.filters.gaussian import gaussian_sums
from mcdenoise.filters.guides import Guide
from mcdenoise.filters.joint_nlm import joint_nlm_sums
from mcdenoise.filters.nlm import nlm_sums
from mcdenoise.kernels import bilateral as bilateral_kernel
from mcdenoise.kernels import gaussian as gaussian_kernel
from mcdenoise.kernels import jit, lbf_rows, patch_rows, rows
from mcdenoise.kernels import network as network_kernel
from mcdenoise.kernels import nlm as nlm_kernel
from mcdenoise.kernels import rpf as rpf_kernel

pytestmark = pytest.mark.ch03


def scene(height, width, seed=8):
    rng = np.random.default_rng(seed)
    image, normal, depth = (rng.random((height, width, k), dtype=np.float32) for k in (3, 3, 1))
    return image, [Guide(normal, 0.6), Guide(depth, 0.4, 0.1 * depth)]


@pytest.mark.parametrize("size", [(1, 1), (17, 31), (40, 33)])
def test_sums_are_those_of_the_reference_apart(size):
    """Not their quotient: that would hide a pair counted twice, or left out."""
    image, guides = scene(*size)
    pairs = [
        (gaussian_kernel.gaussian_sums(image, 3.0, 9), gaussian_sums(image, 3.0, 9)),
        (bilateral_kernel.bilateral_sums(image, 3.0, 0.5, 9), bilateral_sums(image, 3.0, 0.5, 9)),
        (
            bilateral_kernel.cross_bilateral_sums(image, guides, 9.0, 0.5, 27),
            cross_bilateral_sums(image, guides, 9.0, 0.5, 27),
        ),
        (
            nlm_kernel.nlm_sums(image, image, 0.1 * image, 6, 3, 0.6, 1),
            nlm_sums(image, image, 0.1 * image, 6, 3, 0.6, 1),
        ),
        (
            nlm_kernel.joint_nlm_sums(image, 0.1 * image, guides, 4.0, 6, 3, 0.6),
            joint_nlm_sums(image, 0.1 * image, guides, 4.0, 6, 3, 0.6),
        ),
    ]
    for (total, norm), (total_expected, norm_expected) in pairs:
        assert total.dtype == norm.dtype == np.float32
        np.testing.assert_allclose(total, total_expected, rtol=4e-6)
        np.testing.assert_allclose(norm, norm_expected, rtol=4e-6)
        assert (norm >= 1).all()


def test_same_bits_at_any_number_of_threads():
    if numba.config.NUMBA_NUM_THREADS < 2:
        pytest.skip("numba was started with one thread only")
    image, guides = scene(70, 45)

    def run(threads):
        numba.set_num_threads(threads)
        return [
            *gaussian_kernel.gaussian_sums(image, 3.0, 9),
            *bilateral_kernel.bilateral_sums(image, 3.0, 0.5, 9),
            *bilateral_kernel.cross_bilateral_sums(image, guides, 9.0, 0.5, 27),
            *nlm_kernel.joint_nlm_sums(image, 0.1 * image, guides, 4.0, 10, 3, 0.6, 2),
        ]

    before = numba.get_num_threads()
    try:
        for one, many in zip(run(1), run(numba.config.NUMBA_NUM_THREADS), strict=True):
            np.testing.assert_array_equal(one, many)
    finally:
        numba.set_num_threads(before)


def test_exp2_is_accurate_and_ends_in_zero():
    exponent = np.linspace(-125, 0, 100_001, dtype=np.float32)
    relative = np.array([rows.exp2(t) for t in exponent[::10]]) / np.exp2(exponent[::10].astype(np.float64)) - 1
    assert np.abs(relative).max() < 4e-7
    assert rows.exp2(np.float32(0)) == 1
    assert [rows.exp2(np.float32(t)) for t in (-127, -1e4, -1e38, -np.inf)] == [0, 0, 0, 0]


ROW, PLACE, NUMBER = types.Array(types.float32, 1, "C"), types.uint64, types.float32
THREE = types.UniTuple(types.float32, 3)
HOT = {
    "add_squares": (ROW, PLACE, PLACE, ROW, PLACE, PLACE, PLACE),
    "add_normalised": (ROW, PLACE, PLACE, ROW, ROW, PLACE, PLACE, PLACE),
    "weigh": (ROW, PLACE, PLACE, NUMBER, ROW, PLACE, PLACE, PLACE),
    "weigh_on": (ROW, PLACE, PLACE, NUMBER, ROW, PLACE, PLACE, PLACE),
    "add_two": (ROW, PLACE, PLACE, ROW, PLACE, PLACE),
    "add_two_weighted": (ROW, PLACE, PLACE, ROW, PLACE, PLACE, ROW, PLACE, PLACE),
    "add_pair": (ROW, PLACE, NUMBER, ROW, PLACE, PLACE, PLACE),
    "compare": (ROW, PLACE, PLACE, ROW, ROW, *[PLACE] * 5, NUMBER),
    "compare_on": (ROW, PLACE, PLACE, ROW, ROW, *[PLACE] * 5, NUMBER),
    "pair_up": (ROW, PLACE, PLACE, ROW, PLACE, PLACE),
    "sum_pairs": (ROW, PLACE, PLACE, ROW, PLACE, PLACE, PLACE, ROW, PLACE),
    "weigh_patches": (ROW, PLACE, PLACE, ROW, PLACE, NUMBER),
    "multiply_by_likeness": (ROW, PLACE, PLACE, NUMBER, ROW),
    "add_guide": (ROW, PLACE, PLACE, ROW, PLACE, PLACE, types.float64, types.float64),
    "add_four": (ROW, ROW, PLACE, PLACE, PLACE, PLACE),
    "sums": (ROW, ROW, PLACE, PLACE),
    "add_three_weighted": (ROW, PLACE, PLACE, ROW, PLACE, PLACE, PLACE, ROW, PLACE, PLACE, PLACE),
    "add_four_scaled": (ROW, PLACE, NUMBER, NUMBER, NUMBER, NUMBER, ROW, PLACE),
    "dot_four": (ROW, PLACE, ROW, PLACE),
    "activate": (ROW, PLACE, ROW, PLACE, types.int64),
    "multiply_by_slope": (ROW, PLACE, ROW, PLACE, types.int64),
    "start_row": (ROW, PLACE, ROW, ROW, ROW, PLACE, NUMBER, NUMBER),
    "add_pixel_colour": (ROW, PLACE, PLACE, NUMBER, ROW, ROW, PLACE, PLACE, THREE, THREE),
    "add_patch_colour": (ROW, PLACE, PLACE, NUMBER, ROW, ROW, PLACE, NUMBER),
    "add_feature": (ROW, PLACE, PLACE, ROW, PLACE, PLACE, THREE, THREE),
    "add_times": (ROW, PLACE, PLACE, NUMBER, ROW, PLACE),
    "sum_weighted": (ROW, PLACE, ROW, PLACE, PLACE),
    "turn_to_pull": (ROW, PLACE, ROW, PLACE, PLACE, THREE, NUMBER),
    "inner_product": (ROW, ROW, PLACE, PLACE),
    "position_product": (ROW, ROW, NUMBER, PLACE),
    "add_noisy_difference": (ROW, PLACE, PLACE, ROW, ROW, ROW, PLACE, PLACE, PLACE, THREE, NUMBER),
}


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="reads the names of x86 instructions")
@pytest.mark.parametrize("name", HOT)
def test_hot_loops_are_packed_single_precision(name):
    """One slice, one float64 literal or one more output row, and the loop silently turns scalar: see kernels/rows."""
    options = {"fastmath": jit.FASTMATH, "error_model": jit.ERROR_MODEL, "nogil": True}
    function = next(
        getattr(module, name)
        for module in (rows, patch_rows, rpf_kernel, network_kernel, lbf_rows)
        if hasattr(module, name)
    )
    compiled = numba.njit(HOT[name], **options)(function.py_func)
    (code,) = compiled.inspect_asm().values()
    assert re.search(r"\bv?(fn?m(add|sub)\d+|add|mul)ps\b", code)
    assert not re.search(r"\b(v?cvt(ps2pd|pd2ps)|v?(add|sub|mul|div)[ps]d|vfn?m(add|sub)\d+[ps]d)\b", code)


def test_weights_of_the_padding_are_zero():
    """No row wraps around to its neighbour: one bright pixel at the right edge leaves the left edge alone."""
    image = np.zeros((6, 33, 1), np.float32)
    image[2, 32] = 1.0
    total, _ = bilateral_kernel.bilateral_sums(image, np.inf, np.inf, 5)
    assert (total[:, :27] == 0).all()
    assert (total[:, 27:] == 1).all()


def test_cache_folder_is_named_after_sources_and_numba(monkeypatch, tmp_path):
    monkeypatch.setenv("MCDENOISE_CACHE", str(tmp_path))
    jit.kernel_folder.cache_clear()
    first = jit.kernel_folder()
    assert first.parent == tmp_path
    monkeypatch.setattr(numba, "__version__", "0.0")
    jit.kernel_folder.cache_clear()
    assert jit.kernel_folder() != first
    jit.kernel_folder.cache_clear()


@pytest.mark.parametrize("writable", [True, False])
def test_compiled_kernels_are_kept_only_where_a_folder_can_be_written(writable, tmp_path):
    """In a process of its own; other libraries' numba caches are not redirected."""
    chosen = tmp_path / "cache"
    if not writable:
        chosen.write_text("a file where the folder should be")
    program = (
        "import numba; before = numba.config.CACHE_DIR\n"
        "from mcdenoise.kernels import rows\n"
        "assert numba.config.CACHE_DIR == before\n"
        "assert rows.exp2(rows.np.float32(-1)) == 0.5\n"
    )
    environment = {"MCDENOISE_CACHE": str(chosen), "PATH": "", "HOME": str(tmp_path)}
    subprocess.run([sys.executable, "-W", "error", "-c", program], env=environment, check=True, timeout=60)
    assert bool(list(tmp_path.rglob("*.nbi"))) == writable


def test_the_rooms_import_numba_only_when_a_kernel_is_needed():
    program = (
        "import sys; import numpy as np\n"
        "from mcdenoise.filters import gaussian\n"
        "gaussian(np.ones((3, 3)), sigma_space=1.0, engine='numpy')\n"
        "assert 'numba' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", program], check=True, timeout=60)
