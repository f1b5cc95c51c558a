"""Chapter 09: learning-based filtering, samples in, image out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdenoise.lbf.despike import despike
from mcdenoise.lbf.model import LBFModel
from mcdenoise.lbf.primary import Primary, primary_features
from mcdenoise.lbf.storage import shipped_model
from mcdenoise.samples import SampleBuffer
from mcdenoise.samples.gate import ENGINES, check_choice

SPIKE_RADIUS, SPIKE_DEVIATIONS = 1, 2.0


@dataclass(frozen=True, eq=False)
class LBFAnalysis:
    """What the filter did, and why.

    Attributes
    ----------
    image : (h, w, 3), the filtered image
    theta : name -> (h, w), the predicted inverse bandwidths 1 / (2 sigma^2): "position", "colour", and each group
    primary : what the filter compared: without texture, where the model divides by albedo

    Examples
    --------
    >>> flat = np.ones((2, 2, 3), np.float32)
    >>> found = LBFAnalysis(flat, {"position": np.full((2, 2), 0.125)}, Primary(flat, 0 * flat, {}, {}, {}, spp=4))
    >>> float(found.bandwidths["position"][0, 0])
    2.0
    """

    image: np.ndarray
    theta: dict[str, np.ndarray]
    primary: Primary

    @property
    def bandwidths(self) -> dict[str, np.ndarray]:
        """Name -> (h, w): sigma = 1 / sqrt(2 theta). Position: alpha_i, pixels; groups: gamma_k,i, standard deviations."""
        with np.errstate(divide="ignore"):
            return {name: 1 / np.sqrt(2 * theta) for name, theta in self.theta.items()}


def lbf(
    samples: SampleBuffer,
    model: LBFModel | None = None,
    *,
    variant: str = "cross_bilateral",
    despiked: bool = False,
    engine: str = "numba",
) -> np.ndarray:
    """Learning-based filtering: a small network sets the bandwidths of a cross-bilateral filter, pixel by pixel.

    Parameters
    ----------
    samples : with any of the features world_position, shading_normal, albedo, albedo_2, visibility; others are not used
    model : from `mcdenoise train`; None: the one that comes with the package
    variant : of that one: ``"cross_bilateral"`` compares the colours of pixels, ``"nlm"`` those of patches
    despiked : replace pixels of the result which deviate from their 8 neighbours by more than 2 standard deviations by
        the median of 3 x 3. Against fireflies; it takes energy away where single bright pixels are true, and details of
        one pixel. Default: off.
    engine : of the filter, ``"numba"`` or ``"numpy"``

    Returns
    -------
    (h, w, 3) float32, scene-linear radiance

    Raises
    ------
    ValueError
        For samples that are no SampleBuffer, a model that is none, an unknown variant or engine.

    Notes
    -----
    With 1 spp there is no variance within pixels: differences between neighbours stand in for it, which widens the
    filter at edges. Without noise every distance is divided by almost nothing: the image hardly changes. A model that
    divides by the albedo averages colour / albedo, so a pixel may come out brighter than any of its neighbours.

    References
    ----------
    Kalantari, Bako and Sen, "A machine learning approach for filtering Monte Carlo noise", TOG 34(4), 2015,
    https://doi.org/10.1145/2766977.

    Examples
    --------
    >>> corner = np.stack(np.meshgrid(np.arange(8), np.arange(8)), axis=-1)[:, :, np.newaxis]
    >>> flat = SampleBuffer.from_arrays(np.ones((8, 8, 4, 3)), np.repeat(corner + 0.5, 4, axis=2))
    >>> bool(np.allclose(lbf(flat, engine="numpy"), 1))
    True
    """
    return lbf_analysis(samples, model, variant=variant, despiked=despiked, engine=engine).image


def lbf_analysis(
    samples: SampleBuffer,
    model: LBFModel | None = None,
    *,
    variant: str = "cross_bilateral",
    despiked: bool = False,
    engine: str = "numba",
) -> LBFAnalysis:
    """As `lbf`, with the maps of the predicted bandwidths.

    Examples
    --------
    >>> corner = np.stack(np.meshgrid(np.arange(8), np.arange(8)), axis=-1)[:, :, np.newaxis]
    >>> flat = SampleBuffer.from_arrays(np.ones((8, 8, 4, 3)), np.repeat(corner + 0.5, 4, axis=2))
    >>> {name: map.shape for name, map in lbf_analysis(flat, engine="numpy").bandwidths.items()}
    {'position': (8, 8), 'colour': (8, 8)}
    """
    check_choice(engine, ENGINES, "engine")
    if model is None:
        model = shipped_model(variant)
    elif not isinstance(model, LBFModel):
        raise ValueError(
            f"model must be an LBFModel, got {type(model).__name__}. Read one with mcd.load_model, or leave it out."
        )
    primary = primary_features(samples)
    layer, theta = model.layer(primary, engine=engine), model.theta(primary)
    image = layer.forward(theta)[0].astype(np.float32)
    if despiked:
        image = despike(image, radius=SPIKE_RADIUS, deviations=SPIKE_DEVIATIONS, together=True)
    return LBFAnalysis(image, {name: theta[..., k] for k, name in enumerate(layer.names)}, layer.primary)
