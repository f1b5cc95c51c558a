"""What `mcdenoise train` does and shows: the training itself stands in `lbf`; here are its chart, its card, and its files."""

from __future__ import annotations

import argparse
from pathlib import Path

from matplotlib.figure import Figure

from mcdenoise.lbf.dataset import DataConfig
from mcdenoise.lbf.storage import card_text, save_model
from mcdenoise.lbf.training import LBFTraining, TrainConfig, train_lbf
from mcdenoise.samples.storage import write_beside
from mcdenoise.study.charts import save_figure


def run_train(options: argparse.Namespace) -> int:
    """Run `mcdenoise train`."""
    out = options.out or Path("out") / f"{options.variant}.npz"
    if out.suffix != ".npz":
        raise ValueError(f"A model is stored as .npz, got the name {out.name!r}. Call it {out.stem}.npz.")
    out.parent.mkdir(parents=True, exist_ok=True)
    shared = {name: getattr(options, name) for name in ("variant", "hidden", "epochs", "seed", "groups")}
    spread = {name: getattr(options, name) for name in ("scenes", "validation", "size", "spp", "reference_spp")}
    done = train_lbf(
        TrainConfig(**shared), DataConfig(**spread), folder=options.data, checkpoint=out.with_suffix(".checkpoint.npz"),
        resume=options.resume,
    )  # fmt: skip
    save_model(done.model, out)
    with write_beside(out.with_suffix(".md")) as temporary:
        temporary.write_text(card_text(done.model), encoding="utf-8")
    save_figure(training_figure(done), out.with_suffix(".png"))
    print("\n".join(lines(done)))
    print(f"\nWrote {out}, its card {out.with_suffix('.md').name} and its chart {out.with_suffix('.png').name}.")
    return 0


def lines(done: LBFTraining) -> list[str]:
    """A table of what a training reached: loss of the noisy images, and of the filtered ones.

    Examples
    --------
    >>> import numpy as np
    >>> from mcdenoise.lbf import LBFModel
    >>> model = LBFModel.random(["albedo"], hidden=[2], rng=np.random.default_rng(0))
    >>> losses, seen = np.array([0.5, 0.4]), np.array([[0, 0.6], [2, 0.45]])
    >>> print("\\n".join(lines(LBFTraining(model, losses, seen, (1.0, 1.2)))))
    41 parameters, 2 epochs; relative error n/2 sum_q, mean over pixels
      scenes       noisy     at the start  best      share of the noise left
      training       1.0000        0.5000    0.4000  40 %
      validation     1.2000        0.6000    0.4500  38 %
    """
    found = [
        f"{done.model.network.size} parameters, {len(done.losses)} epochs; relative error n/2 sum_q, mean over pixels",
        "  scenes       noisy     at the start  best      share of the noise left",
    ]
    rows = (("training", done.losses), ("validation", done.validation[:, 1]))
    for (name, losses), noisy in zip(rows, done.unfiltered, strict=True):
        found.append(
            f"  {name:10s}  {noisy:9.4f}  {losses[0]:12.4f}  {losses.min():8.4f}  {100 * losses.min() / noisy:.0f} %"
        )
    return found


def training_figure(done: LBFTraining) -> Figure:
    """Loss against epochs, for the scenes learnt from and those watched, each as a share of the loss of the noisy images."""
    figure = Figure(figsize=(7.5, 4.2), layout="constrained")
    axes = figure.subplots()
    looks, seen = done.validation[:, 0], done.validation[:, 1] / done.unfiltered[1]
    axes.plot(done.losses / done.unfiltered[0], color="#4477AA", label="training scenes")
    axes.plot(looks, seen, "o-", ms=4, color="#EE6677", label="validation scenes")
    best = int(seen.argmin())
    axes.plot(looks[best], seen[best], "*", ms=16, color="#CCBB44", mec="black", label=f"kept: epoch {looks[best]:.0f}")
    axes.set(
        title=f"Training through the filter: {done.model.variant}, {done.model.network.size} parameters",
        xlabel="epochs of RPROP", ylabel="loss / loss of the noisy images", ylim=(0, None),
    )  # fmt: skip
    axes.grid(color="#e5e5e5", which="both")
    axes.legend(frameon=False)
    return figure
