"""What does our network cost? Forward and backward beside a plain transcription, scikit-learn, and what BLAS allows.

The network is that of chapter 09, 36-10-6 with sigmoid and softplus, and a squared error. The transcription is the same
mathematics written down once, without layers, as one writes it in a notebook.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mcdenoise.nn import MLP, SGD, Softplus, SquaredError, loss_and_gradients
from mcdenoise.study.bench_measure import Contestant, Target, Work, measure, table

WIDTHS, ROWS, FEW_ROWS = (36, 10, 6), 65_536, 64
REST, STEPS, SMALL_STEPS = 0.1, 20, 500  # seconds before each run, and steps of training in a run
OURS, OURS_NUMPY = "mcdenoise.nn", "mcdenoise.nn, engine numpy"
PLAIN, SKLEARN = "plain NumPy, two layers", "sklearn MLPRegressor"
PRODUCTS, SQUARE, COPY = "its five matrix products alone", "a product of 1024 x 1024", "a copy of 64 MB"
SQUARE_SIDE, COPY_BYTES = 1024, 64_000_000

# What engine numpy reads and writes for each row, in numbers, with d inputs, h hidden and o outputs; tests count again.
TRAFFIC = {
    "linear, layer 1": lambda d, h, o: d + h + 2 * h,  # product, bias
    "sigmoid": lambda d, h, o: 8 * h,  # minus, exp, + 1, 1 / .
    "linear, layer 2": lambda d, h, o: h + o + 2 * o,
    "softplus": lambda d, h, o: 23 * o,  # 7 operations with one input, 3 with two
    "loss": lambda d, h, o: 6 * o,  # difference, its squares added up, / n
    "softplus_backward": lambda d, h, o: 9 * o,  # minus, exp, + 1, d_y / .
    "linear_backward, layer 2": lambda d, h, o: 2 * (o + h) + o + 1,  # d_x, d_weight, d_bias
    "sigmoid_backward": lambda d, h, o: 8 * h,  # 1 - s, times s, times d_y
    "gradients, layer 1": lambda d, h, o: h + d + h + 1,  # d_weight, d_bias
}


def plain_step(x: np.ndarray, target: np.ndarray, parameters: dict[str, np.ndarray]) -> tuple[float, dict]:
    """Loss and gradients of the two-layer network, line by line.

    Examples
    --------
    >>> mlp, x, target = _problem(3)
    >>> ours, plain = loss_and_gradients(mlp, x, target, SquaredError()), plain_step(x, target, mlp.parameters)
    >>> np.allclose(ours[0], plain[0]), all(np.allclose(ours[1][name], plain[1][name], atol=1e-6) for name in plain[1])
    (True, True)
    """
    weight_1, bias_1, weight_2, bias_2 = parameters.values()
    hidden = 1 / (1 + np.exp(-(x @ weight_1.T + bias_1)))
    before = hidden @ weight_2.T + bias_2
    y = np.maximum(before, 0) + np.log1p(np.exp(-np.abs(before)))
    difference = y - target
    loss = 0.5 * np.mean(np.sum(difference**2, axis=1))
    d_before = difference / len(x) * (1 / (1 + np.exp(-before)))
    d_hidden = (d_before @ weight_2) * hidden * (1 - hidden)
    gradients = {
        "weight_1": d_hidden.T @ x,
        "bias_1": d_hidden.sum(axis=0),
        "weight_2": d_before.T @ hidden,
        "bias_2": d_before.sum(axis=0),
    }
    return float(loss), gradients


def nn_lines(repeats: int, rows: int = ROWS) -> list[str]:
    """Measure everything in turns, and return the tables, the traffic and the shares of both limits."""
    whole = Work(
        f"forward + backward of 36-10-6, {rows} rows, float32; {STEPS} in a row, time of one",
        [_in_a_row(one, STEPS) for one in (*_contestants(rows), *_limits(rows))],
        targets=[
            Target(OURS, rival=PLAIN, times=1),
            Target(OURS_NUMPY, rival=PLAIN, times=1),
            Target(OURS, rival=SKLEARN, times=3),
        ],
    )
    small = Work(
        f"the same, {FEW_ROWS} rows: here the engine's own steps count; {SMALL_STEPS} in a row, time of one",
        [_in_a_row(one, SMALL_STEPS) for one in _contestants(FEW_ROWS)],
    )
    measure([whole, small], repeats, "network", rest=REST)
    return [*table(whole, repeats), *limit_words(whole, rows), "", *table(small, repeats)]


def _in_a_row(contestant: Contestant, times: int) -> Contestant:
    """The contestant so many times in a row, as in training: waking threads up is paid for once."""
    if contestant.run is None:
        return contestant

    def run() -> None:
        for _ in range(times):
            contestant.run()

    return replace(contestant, run=run, scale=1 / times)


def limit_words(work: Work, rows: int) -> list[str]:
    """Say how many bytes move and how many operations the products have, as shares of what the machine can do."""
    seconds = {one.name: one.median() for one in work.contestants if one.run}
    d, h, o = WIDTHS
    operations = 2.0 * rows * (2 * d * h + 3 * h * o)  # d_x of the first layer is not needed
    peak = 2.0 * SQUARE_SIDE**3 / seconds[SQUARE]
    by_numpy = 4.0 * rows * sum(count(d, h, o) for count in TRAFFIC.values())
    by_kernel = 4.0 * rows * (2 * d + 2 * o + 6 * o)  # x twice, y, d_y; the loss
    bandwidth = 2.0 * COPY_BYTES / seconds[COPY]
    return [
        f"  matrix products: {operations / 1e6:.0f} million operations; alone, by BLAS, they run at "
        f"{operations / seconds[PRODUCTS] / 1e9:.0f} GFLOP/s, {SQUARE} at {peak / 1e9:.0f}",
        *(
            f"  {name}: {operations / seconds[name] / 1e9:.1f} GFLOP/s, {100 * operations / seconds[name] / peak:.1f} % of the "
            f"BLAS limit; {moved / 1e6:.0f} MB read and written, {moved / seconds[name] / 1e9:.1f} GB/s"
            for name, moved in ((OURS, by_kernel), (OURS_NUMPY, by_numpy))
        ),
        f"  a large copy moves {bandwidth / 1e9:.1f} GB/s",
    ]


def _problem(rows: int) -> tuple[MLP, np.ndarray, np.ndarray]:
    """A network of random weights, random inputs and targets."""
    rng = np.random.default_rng(0)
    mlp = MLP.random(WIDTHS, output=Softplus(), rng=rng, dtype=np.float32)
    x = rng.standard_normal((rows, WIDTHS[0]), np.float32)
    return mlp, x, rng.random((rows, WIDTHS[-1]), np.float32)


def _contestants(rows: int) -> list[Contestant]:
    """Both engines with one step of descent, the transcription, and an epoch of scikit-learn."""
    mlp, x, target = _problem(rows)
    loss, descent = SquaredError(), SGD(0.01)
    state = descent.start(mlp.parameters)

    def ours(engine: str) -> object:
        gradients = loss_and_gradients(mlp, x, target, loss, engine=engine)[1]
        return mlp.replace(descent.step(mlp.parameters, gradients, state)[0])

    parameters = mlp.parameters
    return [
        Contestant(OURS, lambda: ours("numba"), "with a step of SGD"),
        Contestant(OURS_NUMPY, lambda: ours("numpy"), "with a step of SGD"),
        Contestant(PLAIN, lambda: plain_step(x, target, parameters), "without a step"),
        Contestant(SKLEARN, _sklearn(x, target), "one epoch, full batch; no softplus at its output"),
    ]


def _sklearn(x: np.ndarray, target: np.ndarray) -> Callable[[], object] | None:
    """An epoch of MLPRegressor, or None if it is not installed."""
    if importlib.util.find_spec("sklearn") is None:
        return None
    from sklearn.neural_network import MLPRegressor

    model = MLPRegressor(
        hidden_layer_sizes=WIDTHS[1:-1],
        activation="logistic",
        solver="sgd",
        alpha=0.0,
        batch_size=len(x),
        shuffle=False,
        random_state=0,
    )
    return lambda: model.partial_fit(x, target)


def _limits(rows: int) -> list[Contestant]:
    """What is measured beside: the products of both passes alone, a large product, a large copy."""
    mlp, x, target = _problem(rows)
    weight_1, _, weight_2, _ = mlp.parameters.values()
    hidden = np.ones((rows, WIDTHS[1]), np.float32)
    square = np.random.default_rng(0).random((SQUARE_SIDE, SQUARE_SIDE), np.float32)
    source, goal = np.ones(COPY_BYTES // 4, np.float32), np.zeros(COPY_BYTES // 4, np.float32)

    def products() -> object:
        return x @ weight_1.T, hidden @ weight_2.T, target.T @ hidden, target @ weight_2, hidden.T @ x

    return [
        Contestant(PRODUCTS, products),
        Contestant(SQUARE, lambda: square @ square),
        Contestant(COPY, lambda: np.copyto(goal, source)),
    ]
