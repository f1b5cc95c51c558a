"""Chapter 06, second step: from what depends on what to how much each channel and each feature count."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdenoise.rpf.config import RPFConfig
from mcdenoise.rpf.dependency import Dependency, share


@dataclass(frozen=True, eq=False)
class Weights:
    """What one neighbourhood says about the weights of its samples.

    Attributes
    ----------
    alpha : (3,), of the channels of radiance. beta : (n_f,), of the columns of features.
    share_c_r, share_f_r : (3,), (n_f,), W_{c,k}^r and W_{f,k}^r
    share : W_c^r, over all channels

    Examples
    --------
    >>> Weights(np.ones(3), np.ones(1), np.zeros(3), np.zeros(1), 0.0).share
    0.0
    """

    alpha: np.ndarray
    beta: np.ndarray
    share_c_r: np.ndarray
    share_f_r: np.ndarray
    share: float


def falling(share: np.ndarray, gain: float) -> np.ndarray:
    """max(1 - gain W, 0): full weight where nothing is the fault of the random parameters, none from W = 1 / gain on.

    Examples
    --------
    >>> falling(np.array([0.0, 0.25, 0.75]), gain=2)
    array([1. , 0.5, 0. ])
    """
    return np.maximum(1 - gain * share, 0)


def weights_of(found: Dependency, config: RPFConfig, turn: int, gains: np.ndarray) -> Weights:
    """Alpha and beta of pass `turn`, as the configuration has them.

    Parameters
    ----------
    found : of the neighbourhood.
    gains : (n_f,), factors of beta.

    Examples
    --------
    >>> zero = np.zeros((3, 2))
    >>> found = Dependency(c_r=zero + 0.5, c_p=zero, c_f=np.ones((3, 1)), f_r=zero[:1] + 0.1, f_p=zero[:1] + 0.3)
    >>> weights = weights_of(found, RPFConfig.lecture(), 0, np.ones(1))
    >>> weights.alpha, weights.beta
    (array([0., 0., 0.]), array([0.75]))
    """
    c, f = found.share_c_r, found.share_f_r
    if config.alpha is not None and config.beta is not None:
        return Weights(np.full(3, config.alpha), np.full(len(f), config.beta), 0 * c, 0 * f, 0.0)
    d_r, d_p = found.c_r.sum(), found.c_p.sum()
    whole = float(share(d_r, d_r + d_p)) if config.ratio_of_sums else float(c.mean())
    alpha = falling(np.full(3, whole) if config.one_share else c, config.alpha_start + config.alpha_step * turn)
    beta = gains * falling(f, config.beta_start + config.beta_step * turn)
    if config.by_feature_share:
        beta = beta * found.share_c_f
    alpha = alpha if config.alpha is None else np.full(3, config.alpha)
    beta = beta if config.beta is None else np.full(len(f), config.beta)
    return Weights(alpha, beta, c, f, whole)


def scales_of(weights: Weights, noise: np.ndarray, config: RPFConfig, turn: int, spp: int) -> np.ndarray:
    """Return the factor of each squared difference of standardised features and channels in the exponent, (n_f + 3,).

    weight_k (1 - W_c^r)^2 / (2 sigma_k^2) with sigma_k^2 as in `RPFConfig.adaptive`; there is no division by 0 at W = 1.

    Parameters
    ----------
    noise : (n_f + 3,), v_k: variance within pixels, of standardised features, then channels.

    Examples
    --------
    >>> weights = Weights(np.ones(3), np.ones(1), np.zeros(3), np.zeros(1), share=0.5)
    >>> scales_of(weights, np.zeros(4), RPFConfig.technical_report(), turn=0, spp=8)
    array([6.25, 6.25, 6.25, 6.25])
    """
    shares = np.concatenate([weights.share_f_r, weights.share_c_r])
    precision = config.precision(turn, spp)
    widened = (1 / precision if precision else np.inf) + 2 * config.noise_gain * shares * noise
    return np.concatenate([weights.beta, weights.alpha]) * (1 - weights.share) ** 2 / widened
