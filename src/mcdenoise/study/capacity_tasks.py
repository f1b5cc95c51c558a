"""What `capacity` sweeps over: classes of points in the plane, and one step of denoising.

The step of denoising: from the noisy radiance of a pixel and its neighbours and the features at the pixel, predict the
reference. A network without hidden layer is a linear filter with learnt weights; hidden neurons can look at features and
decide. It is a small thing beside the filters of the other chapters, and meant to be: the question is how much of a
network it needs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from mcdenoise.nn import MLP, RPROP, CrossEntropy, Loss, SquaredError, Tanh, checker, rings, train, two_moons, xor
from mcdenoise.render import capture, render_reference
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.study.capacity import Capacity, Hidden, k_folds, sweep

STARTS, EPOCHS, FIRST_STEP = 3, 300, 0.02
PLANE = ((), (1,), (2,), (3,), (4,), (6,), (8,), (16,), (32,), (2, 2), (4, 4), (8, 8))
DENOISE = ((), (1,), (2,), (4,), (8,), (16,), (32,), (4, 4), (8, 8), (16, 16))
SCENE, SIZE, SPP, REFERENCE_SPP, TILE = "dof", 128, 8, 1024, 16
WINDOW = 5  # pixels: side of the neighbourhood that the network sees
DENOISE_PIXELS, DENOISE_EPOCHS, DENOISE_STARTS = 4096, 1000, 1


@dataclass(frozen=True, eq=False)
class Data:
    """What is to be learnt.

    Attributes
    ----------
    title, unit : for table and chart
    x, target : (n, d_in) and (n, d_out)
    groups : (n,), rows with one number stay in one fold
    loss : that training makes small
    error : (y, rows) -> the error that is reported
    epochs, starts : of training; of several random starts that with the smallest loss is kept
    """

    title: str
    unit: str
    x: np.ndarray
    target: np.ndarray
    groups: np.ndarray
    loss: Loss
    error: Callable[[np.ndarray, np.ndarray], float]
    epochs: int = EPOCHS
    starts: int = STARTS


def plane(name: str, points: int | None, seed: int) -> Data:
    """Two classes of points; the error is the share of wrong answers. Two moons and rings overlap, so it is never 0."""
    makers = {
        "two_moons": partial(two_moons, noise=0.25),
        "rings": partial(rings, noise=0.15),
        "xor": partial(xor, noise=0.1),
        "checker": partial(checker, noise=0.05),
    }
    x, labels = makers[name](points or 300, rng=np.random.default_rng([seed, 1]))
    return Data(
        title=f"{name}, {len(x)} points",
        unit="share of wrong answers",
        x=x,
        target=labels[:, np.newaxis].astype(float),
        groups=np.arange(len(x)),
        loss=CrossEntropy(),
        error=lambda y, rows: float(np.mean((y[:, 0] > 0) != labels[rows])),
    )


def denoise(points: int | None, seed: int) -> Data:
    """One step of denoising on `dof`; the error is relMSE. Tiles of 16 x 16 pixels stay together."""
    samples = capture(SCENE, SIZE, SIZE, SPP, seed, variant="scalar_rgb")
    return denoise_data(samples, render_reference(SCENE, SIZE, SIZE, REFERENCE_SPP), points or DENOISE_PIXELS, seed)


def denoise_data(samples: SampleBuffer, reference: np.ndarray, points: int, seed: int) -> Data:
    """Inputs and targets from a buffer and its reference; `points` of its pixels, drawn once.

    Radiance goes in and comes out as log(1 + c), so that a lamp does not drown the rest; each input is standardised.
    """
    noisy = pixel_mean(samples.radiance)
    x = np.concatenate([windows(np.log1p(noisy)), *_features(samples)], axis=-1)
    x = x.reshape(-1, x.shape[-1]).astype(np.float64)
    x = (x - x.mean(axis=0)) / (x.std(axis=0) + 1e-6)
    height, width = noisy.shape[:2]
    rows, columns = np.indices((height, width))
    tiles = rows // TILE * -(-width // TILE) + columns // TILE
    drawn = np.random.default_rng([seed, 2]).permutation(height * width)[:points]
    kept = reference.reshape(-1, 3)[drawn].astype(np.float64)
    return Data(
        title=f"one step of denoising, {samples.provenance.get('scene', 'a scene')}, {len(drawn)} pixels",
        unit="relMSE",
        x=x[drawn],
        target=np.log1p(kept),
        groups=tiles.reshape(-1)[drawn],
        loss=SquaredError(),
        error=lambda y, part: float(np.mean((np.expm1(y) - kept[part]) ** 2 / (kept[part] ** 2 + 0.01))),
        epochs=DENOISE_EPOCHS,
        starts=DENOISE_STARTS,
    )


def windows(image: np.ndarray, side: int = WINDOW) -> np.ndarray:
    """Each pixel's neighbourhood of side x side pixels, (h, w, side^2 c); the border is repeated.

    Examples
    --------
    >>> windows(np.arange(3.0).reshape(1, 3, 1), side=3)[0, :, 3:6]
    array([[0., 0., 1.],
           [0., 1., 2.],
           [1., 2., 2.]])
    """
    half = side // 2
    padded = np.pad(image, ((half, half), (half, half), (0, 0)), mode="edge")
    seen = sliding_window_view(padded, (side, side), axis=(0, 1))
    return np.moveaxis(seen, 2, -1).reshape(*image.shape[:2], -1)


def _features(samples: SampleBuffer) -> list[np.ndarray]:
    """Pixel means of the features that a scene has."""
    means = [pixel_mean(samples[field.name]) for field in samples.layout.features]
    return [mean.reshape(*mean.shape[:2], -1) for mean in means]


TASKS = {name: partial(plane, name) for name in ("two_moons", "rings", "xor", "checker")} | {"denoise": denoise}


def run_task(task: str, points: int | None = None, folds: int = 5, seed: int = 0) -> Capacity:
    """Make the data of a task and sweep over its architectures."""
    return run_data(TASKS[task](points, seed), DENOISE if task == "denoise" else PLANE, folds, seed)


def run_data(data: Data, architectures: tuple[Hidden, ...], folds: int, seed: int) -> Capacity:
    """Sweep over architectures on given data."""

    def fit(hidden: Hidden, rows: np.ndarray) -> tuple[MLP, int]:
        trained = [_train(data, hidden, rows, [seed, start]) for start in range(data.starts if hidden else 1)]
        network = min(trained, key=lambda done: done.losses[-1]).network
        return network, network.size

    def error(network: MLP, rows: np.ndarray) -> float:
        return data.error(network.forward(data.x[rows])[0], rows)

    cut = k_folds(data.groups, folds, np.random.default_rng([seed, 3]))
    return sweep(data.title, data.unit, architectures, cut, fit, error)


def _train(data: Data, hidden: Hidden, rows: np.ndarray, seed: list[int]):
    """One training from a random start."""
    widths = (data.x.shape[1], *hidden, data.target.shape[1])
    start = MLP.random(widths, hidden=Tanh(), rng=np.random.default_rng(seed))
    optimizer = RPROP(FIRST_STEP)
    return train(start, data.x[rows], data.target[rows], loss=data.loss, optimizer=optimizer, epochs=data.epochs)
