"""Chapter 03, figures about what misleads the weights: a noisy guide against an oracle, and fireflies."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from mcdenoise.filters import bilateral, cross_bilateral, gaussian
from mcdenoise.metrics import relmse
from mcdenoise.study.figures._ch03_data import (
    BILATERAL,
    GAUSSIAN,
    NOISY,
    ORACLE,
    best,
    best_bilateral,
    best_gaussian,
    noisy,
    picture,
)
from mcdenoise.study.figures._references import reference

SPP = (1, 2, 4, 8, 16, 32)


def best_oracle(scene: str, image: np.ndarray) -> tuple[float, ...]:
    """RelMSE, sigma_space and sigma_radiance of the best bilateral whose weights come from the reference."""

    def guided(space: float, sigma: float) -> np.ndarray:
        guide, bandwidth = {"truth": reference(scene)}, {"truth": sigma}
        return cross_bilateral(image, guide, sigma_space=space, sigma_radiance=np.inf, sigma_features=bandwidth)

    return best(guided, scene, (1.4, 2.8, 4.0), (0.025, 0.05, 0.1, 0.2, 0.4))


def guide() -> tuple[Figure, dict]:
    """Error against spp: Gaussian, bilateral guided by its own noisy pixels, bilateral guided by the reference."""
    figure = Figure(figsize=(8.8, 3.9), layout="constrained")
    numbers = {"spp": list(SPP)}
    for axes, scene in zip(figure.subplots(1, 2, sharey=True), ("dof", "soft_shadow"), strict=True):
        images = [noisy(scene, spp) for spp in SPP]
        own = [best_bilateral(scene, image) for image in images]
        curves = {
            "unfiltered": ([relmse(image, reference(scene)) for image in images], NOISY, "x"),
            "Gaussian": ([best_gaussian(scene, image)[0] for image in images], GAUSSIAN, "s"),
            "bilateral, its own guide": ([error for error, *_ in own], BILATERAL, "o"),
            "bilateral, guided by the reference": ([best_oracle(scene, image)[0] for image in images], ORACLE, "^"),
        }
        for name, (errors, colour, marker) in curves.items():
            axes.loglog(SPP, errors, marker + "-", color=colour, label=name)
        axes.set_xticks(SPP, [str(spp) for spp in SPP])
        axes.minorticks_off()
        axes.set(title=f"{scene}, best parameters of each", xlabel="samples per pixel (spp)")
        axes.grid(color="#e5e5e5")
        keys = ("noisy", "gaussian", "own", "oracle")
        numbers[scene] = dict(zip(keys, (errors for errors, *_ in curves.values()), strict=True))
        numbers[scene]["own_sigma_radiance"] = [sigma for *_, sigma in own]
        for other in ("gaussian", "oracle"):
            numbers[scene][f"own_over_{other}"] = np.divide(numbers[scene]["own"], numbers[scene][other])
    figure.axes[0].set_ylabel("relMSE")
    figure.axes[0].legend(frameon=False, fontsize=9, loc="lower left")
    return figure, numbers


def neighbour_differences(image: np.ndarray, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """|c_i - c_j| of horizontal neighbours two pixels apart: where the truth is the same, and where an edge lies between."""
    real = np.linalg.norm(truth[:, 2:] - truth[:, :-2], axis=-1)
    seen = np.linalg.norm(image[:, 2:] - image[:, :-2], axis=-1)
    return seen[real < 0.02], seen[real > 0.3]


def confusion(same: np.ndarray, across: np.ndarray) -> float:
    """Share of pairs on the wrong side of the best threshold, both kinds counted alike: 0.5 is a coin toss."""
    thresholds = np.linspace(0, 2, 401)[:, np.newaxis]
    return float((((same > thresholds).mean(axis=1) + (across <= thresholds).mean(axis=1)) / 2).min())


def differences(scene: str = "dof") -> tuple[Figure, dict]:
    """What the range kernel sees: differences between alike and between unlike neighbours, at 1 and at 32 spp."""
    figure = Figure(figsize=(8.8, 3.4), layout="constrained")
    numbers, bins = {}, np.linspace(0, 1.2, 49)
    for axes, spp in zip(figure.subplots(1, 2, sharey=True), (1, 32), strict=True):
        same, across = neighbour_differences(noisy(scene, spp), reference(scene))
        for values, colour, name in ((same, GAUSSIAN, "same radiance"), (across, BILATERAL, "across an edge")):
            share = np.full(len(values), 100 / len(values))
            axes.hist(np.minimum(values, 1.19), bins, weights=share, color=colour, alpha=0.65, label=name)
        wrong = confusion(same, across)
        axes.set(xlabel="difference $|c_i - c_j|$ that the weight sees", ylim=(0, 20))
        axes.set_title(f"{scene}, {spp} spp: at best {100 * wrong:.0f} % on the wrong side")
        axes.grid(color="#e5e5e5")
        numbers[f"spp_{spp}"] = {"same": np.median(same), "across": np.median(across), "wrong_percent": 100 * wrong}
    figure.axes[0].set_ylabel("share of pairs (%)")
    figure.axes[1].legend(frameon=False)
    return figure, numbers


def firefly() -> tuple[Figure, dict]:
    """The pixels that are most too bright, before and after: the bilateral leaves them as they are."""
    image, truth = noisy("glossy"), reference("glossy")
    space, radiance = 1.4, 0.3
    images = {
        "8 spp": image,
        f"Gaussian, {space} px": gaussian(image, sigma_space=space),
        f"bilateral, {space} px, {radiance}": bilateral(image, sigma_space=space, sigma_radiance=radiance),
        "reference": truth,
    }
    excess = (image - truth).mean(axis=-1)
    brightest = np.unravel_index(np.argsort(excess, axis=None)[-50:], excess.shape)
    figure = Figure(figsize=(8.8, 2.9), layout="constrained")
    numbers = {"pixels": 50, "excess": excess[brightest].mean()}
    for axes, (name, one) in zip(figure.subplots(1, 4), images.items(), strict=True):
        left = ((one - truth).mean(axis=-1)[brightest] / excess[brightest]).mean()
        picture(axes, one[30:94, 64:128], name if name == "reference" else f"{name}\nexcess left {100 * left:.0f} %")
        numbers[name.split(",")[0].lower().replace(" ", "_")] = left
    return figure, numbers
