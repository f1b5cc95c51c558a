"""The benchmark of the network: it runs, the contestants do the same, the traffic is what NumPy really moves."""

import re

import numpy as np
import pytest

from mcdenoise.nn import Linear, SquaredError, loss_and_gradients
from mcdenoise.nn.layers import linear, linear_backward, sigmoid, sigmoid_backward, softplus, softplus_backward
from mcdenoise.study import bench, bench_nn
from mcdenoise.study.bench_measure import Contestant, Work

pytestmark = pytest.mark.ch10


def test_prints_times_targets_and_limits(capsys, monkeypatch):
    monkeypatch.setattr(bench_nn, "SQUARE_SIDE", 16)
    monkeypatch.setattr(bench_nn, "COPY_BYTES", 4000)
    monkeypatch.setattr(bench_nn, "STEPS", 2)
    monkeypatch.setattr(bench_nn, "SMALL_STEPS", 2)
    monkeypatch.setattr(bench_nn, "REST", 0.0)
    monkeypatch.setattr(bench, "nn_lines", lambda repeats: bench_nn.nn_lines(repeats, rows=200))
    assert bench.main(["nn", "--repeats", "1"]) == 0
    output = capsys.readouterr().out
    for name in (bench_nn.OURS, bench_nn.OURS_NUMPY, bench_nn.PLAIN, bench_nn.SKLEARN):
        assert len(re.findall(rf"^  {re.escape(name)} +[\d.]+ ms", output, re.MULTILINE)) == 2
    assert "36-10-6, 200 rows, float32; 2 in a row, time of one; median of 1" in output
    assert re.search(r"at least 1 x faster than plain NumPy, two layers: [\d.]+ x, (reached|missed)", output)
    assert re.search(r"at least 3 x faster than sklearn MLPRegressor: [\d.]+ x, (reached|missed)", output)
    assert len(re.findall(r"[\d.]+ GFLOP/s, [\d.]+ % of the BLAS limit; \d+ MB read and written", output)) == 2


def test_the_transcription_is_the_same_network():
    mlp, x, target = bench_nn._problem(300)
    ours, plain = loss_and_gradients(mlp, x, target, SquaredError()), bench_nn.plain_step(x, target, mlp.parameters)
    assert ours[0] == pytest.approx(plain[0], rel=1e-5)
    for name, gradient in plain[1].items():
        np.testing.assert_allclose(ours[1][name], gradient, rtol=1e-4, atol=1e-6)


def test_shares_of_the_limits_are_worked_out():
    """A million rows in 2 s: 2 (2 36 10 + 3 10 6) operations a row, 4 (2 36 + 8 6) bytes."""
    seconds = {
        bench_nn.OURS: 2.0,
        bench_nn.OURS_NUMPY: 4.0,
        bench_nn.PRODUCTS: 1.0,
        bench_nn.SQUARE: 1.0,
        bench_nn.COPY: 1.0,
    }
    work = Work("made up", [Contestant(name, print, seconds=[one]) for name, one in seconds.items()])
    products, kernel, plain, copy = bench_nn.limit_words(work, rows=10**6)
    assert "1800 million operations; alone, by BLAS, they run at 2 GFLOP/s" in products
    assert "mcdenoise.nn: 0.9 GFLOP/s, 41.9 % of the BLAS limit; 480 MB read and written, 0.2 GB/s" in kernel
    assert "engine numpy: 0.5 GFLOP/s, 21.0 % of the BLAS limit" in plain
    assert "a large copy moves 0.1 GB/s" in copy


class Counting(np.ndarray):
    """An array that counts what ufuncs read and write, in numbers of 4 bytes."""

    moved = 0

    def __array_ufunc__(self, ufunc, method, *inputs, out=(), **settings):
        plain = [np.asarray(one) if isinstance(one, np.ndarray) else one for one in inputs]
        settings |= {"out": tuple(map(np.asarray, out))} if out else {}
        done = np.asarray(getattr(ufunc, method)(*plain, **settings))
        both = [one for one in (*plain, done) if isinstance(one, np.ndarray)]
        rows = max(len(one) for one in both if one.ndim == 2)
        Counting.moved += sum(one.nbytes / 4 for one in both if rows in one.shape)  # not weights, biases, sums
        return out[0] if out else done.view(Counting) if done.ndim else done[()]

    def __array_function__(self, function, types, given, settings):
        if function is np.einsum:
            Counting.moved += sum(one.nbytes / 4 for one in {id(one): one for one in given[1:]}.values())
        return function(*(np.asarray(one) if isinstance(one, Counting) else one for one in given), **settings)


def count(run):
    Counting.moved = 0
    with np.errstate(all="ignore"):
        run()
    return Counting.moved


def test_the_traffic_is_what_numpy_moves(rng):
    n, (d, h, o) = 1000, bench_nn.WIDTHS

    def rows(columns):
        return rng.random((n, columns), np.float32).view(Counting)

    weight_1, bias_1, weight_2, bias_2 = bench_nn._problem(1)[0].parameters.values()
    loss, saved = SquaredError(), rows(o)
    runs = {
        "linear, layer 1": lambda: linear(rows(d), weight_1, bias_1),
        "sigmoid": lambda: sigmoid(rows(h)),
        "linear, layer 2": lambda: linear(rows(h), weight_2, bias_2),
        "softplus": lambda: softplus(rows(o)),
        "loss": lambda: (loss.forward(rows(o), np.ones((n, o), np.float32)), loss.backward(saved)),
        "softplus_backward": lambda: softplus_backward(rows(o), rows(o)),
        "linear_backward, layer 2": lambda: linear_backward(rows(o), rows(h), weight_2),
        "sigmoid_backward": lambda: sigmoid_backward(rows(h), rows(h)),
        "gradients, layer 1": lambda: Linear(weight_1, bias_1).gradients(rows(h), rows(d)),
    }
    assert runs.keys() == bench_nn.TRAFFIC.keys()
    for name, run in runs.items():
        assert count(run) / n == pytest.approx(bench_nn.TRAFFIC[name](d, h, o), abs=0.5), name
