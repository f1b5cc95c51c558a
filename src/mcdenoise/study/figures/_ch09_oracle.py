"""Chapter 09, what are the optimal parameters? A search for each pixel, with the reference."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.lbf import shipped_model
from mcdenoise.nn import RPROP
from mcdenoise.study.figures._ch04_data import error, picture
from mcdenoise.study.figures._ch09_data import (
    ROWS,
    STEPS,
    analysis,
    bandwidth_bar,
    bandwidth_picture,
    best_theta,
    error_in_rows,
    layer_of,
    noisy,
    sigma,
    symbol,
    way,
)
from mcdenoise.study.figures._references import reference

CAPTURES = 4  # whose dials are searched together; the next one judges


def oracle() -> tuple[Figure, dict]:
    """dof at 4 spp: noisy, the model, the best single setting, the best of every pixel; and the bandwidths of that."""
    found, names = best_theta("dof", whole=True), layer_of("dof").names
    images = {
        "input, 4 spp": noisy("dof"),
        "best for all pixels": found.shared_image,
        "LBF": analysis("dof").image,
        "best for each pixel": found.image,
        "reference": reference("dof"),
    }
    figure = Figure(figsize=(9.8, 4.9), layout="constrained")
    grid = figure.subplots(2, 5)
    for axes, (title, image) in zip(grid[0], images.items(), strict=True):
        picture(axes, image, title if title == "reference" else f"{title}\n{error(image, 'dof'):.4f}")
        axes.title.set_fontsize(9.5)
    shown = [name for name in names if name != "colour"]
    for axes in grid[1]:
        axes.axis("off")
    for axes, name in zip(grid[1], shown, strict=False):
        axes.axis("on")
        bandwidth_picture(axes, sigma(found.theta[..., names.index(name)]), symbol(name))
    grid[1, 0].set_ylabel("best for each pixel")
    bandwidth_bar(
        figure, None, "bandwidth: α in pixels,\nγ in deviations", cax=grid[1, 4].inset_axes((0.05, 0.0, 0.09, 1.0))
    )
    errors = [error(image, "dof") for image in images.values()]
    numbers = dict(zip(("noisy", "shared", "model", "oracle"), errors, strict=False))
    numbers |= {
        "steps": len(found.errors) - 1,
        "errors": found.errors,
        "last_step": found.errors[-2] / found.errors[-1],
    }
    numbers["shared_sigma"] = {name: sigma(one) for name, one in zip(names, found.shared_theta, strict=True)}
    numbers["way"] = way(numbers["noisy"], numbers["model"], numbers["oracle"])
    numbers["shared_way"] = way(numbers["noisy"], numbers["shared"], numbers["oracle"])
    return figure, numbers | {"other_noise": other_noise(), "captures": CAPTURES}


def other_noise() -> dict[str, float]:
    """RelMSE on samples that nothing was chosen by, every eighth row: how much of the oracle's gain was noise?"""
    layer, found, rows = layer_of("dof", seed=CAPTURES, rows=ROWS), best_theta("dof", whole=True), list(ROWS)
    together, own = best_together()
    fresh = np.stack([analysis("dof", seed=CAPTURES).theta[name][rows] for name in layer.names], axis=-1)
    thetas = {"oracle": found.theta[rows], "shared": np.broadcast_to(found.shared_theta, layer.shape)}
    thetas |= {"together": together, "model": fresh}
    errors = {name: error_in_rows(layer.forward(theta)[0], "dof") for name, theta in thetas.items()}
    return errors | {"together_own": own, "noisy": error_in_rows(layer.noisy, "dof")}


def best_together() -> tuple[np.ndarray, float]:
    """Theta of every pixel that is best for several captures at once, and its mean relMSE on these; every eighth row."""
    layers = [layer_of("dof", seed=seed, rows=ROWS) for seed in range(CAPTURES)]
    truth, names = reference("dof")[list(ROWS)].astype(np.float64), layers[0].names
    scale, fixed = truth**2 + 0.01, names.index("colour") if shipped_model().colour_theta is not None else None
    logs = {"theta": np.log(np.maximum(best_theta("dof", whole=True).theta[list(ROWS)], 1e-6))}
    optimizer, lowest = RPROP(0.3, largest=2.0), np.full(truth.shape[:2], np.inf)
    state, best = optimizer.start(logs), np.exp(logs["theta"])
    for _ in range(STEPS):
        theta, error_here, slope = np.exp(logs["theta"]), 0.0, 0.0
        for layer in layers:
            image, saved = layer.forward(theta)
            error_here = error_here + ((image - truth) ** 2 / scale).mean(axis=-1) / CAPTURES
            slope = slope + layer.backward((image - truth) / scale, saved) * theta
        better = error_here < lowest
        lowest[better], best[better] = error_here[better], theta[better]
        if fixed is not None:
            slope[..., fixed] = 0
        logs, state = optimizer.step(logs, {"theta": slope}, state)
        logs = {"theta": np.clip(logs["theta"], np.log(1e-6), np.log(400.0))}
    return best, float(lowest.mean())
