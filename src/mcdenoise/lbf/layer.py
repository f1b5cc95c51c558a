"""Chapter 09: the filter is a layer. Bandwidths of every pixel in, filtered colour out, and a gradient back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from mcdenoise.filters.window import window_offsets
from mcdenoise.lbf.distances import COLOUR_EPSILON, LEAST_VARIANCE, offset_distances
from mcdenoise.lbf.primary import Primary
from mcdenoise.samples.gate import ENGINES, check_choice, check_count, check_float_array, check_nonfinite

VARIANTS = ("cross_bilateral", "nlm")
RADIUS = 27  # a window of 55 x 55 pixels
PATCH_RADIUS = 3
LARGEST_THETA = 1e8
LARGEST = 1e12  # magnitude of a feature, beyond which it is cut off: squares must stay in float32

Saved = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class FilterLayer:
    """A cross-bilateral filter whose bandwidths belong to the pixel, as a layer with forward and backward.

    c_hat_i = sum_j w_ij c_j / sum_j w_ij,   w_ij = exp(-sum_m theta_m,i E_m,ij)

    with j over the window, c the noisy colours, and the distances E_m of

    - position: (x_i - x_j)^2 + (y_i - y_j)^2, pixels squared,
    - colour: sum over channels of (c_i - c_j)^2 / (v_i + v_j + 1e-10), v the variance of a pixel's colour; or with the
      variant ``"nlm"`` the distance of the patches around both, `patch_distance` of `nlm` with k = 1,
    - each group k of features: sum over channels of (f_i - f_j)^2 / max(psi_i^2, 1e-4), psi^2 the variance that
      prefiltering left, of the centre i alone.

    theta = 1 / (2 sigma^2) is the inverse bandwidth. Everything but theta is fixed when the layer is made.

    Attributes
    ----------
    primary : what the filter looks at, from `primary_features`
    variant : ``"cross_bilateral"``: colours of pixels are compared; ``"nlm"``: of patches
    radius : of the window, pixels
    patch_radius : of the patches of ``"nlm"``, pixels
    albedo : (h, w, 3), above 0: what the colours of `primary` were divided by, see `untextured`; the filtered colours are
        multiplied by it. None: they were not.
    rows : image rows that are filtered; None: all. The window reaches over all rows of the image in any case.
    engine : ``"numba"``, in float32, or ``"numpy"``, the formula as it reads and in float64

    References
    ----------
    Kalantari, Bako and Sen, TOG 34(4), 2015, https://doi.org/10.1145/2766977; constants of the authors' released code,
    those of ``"nlm"`` are ours.

    Examples
    --------
    >>> image = np.array([[[0.0] * 3, [1.0] * 3]], np.float32)
    >>> primary = Primary(image, np.ones_like(image), {}, {}, {}, spp=4)
    >>> layer = FilterLayer(primary, engine="numpy")
    >>> layer.names
    ('position', 'colour')
    >>> filtered, saved = layer.forward(np.full((1, 2, 2), 0.5))
    >>> filtered[0, :, 0].round(3)  # the weight of the other is exp(-0.5 * 1 - 0.5 * 3 / 2)
    array([0.223, 0.777])
    >>> layer.backward(np.ones((1, 2, 3)), saved)[0, :, 0].round(3)
    array([-0.519,  0.519])
    """

    primary: Primary
    variant: str = "cross_bilateral"
    radius: int = RADIUS
    patch_radius: int = PATCH_RADIUS
    albedo: np.ndarray | None = None
    rows: Sequence[int] | None = None
    engine: str = "numba"

    def __post_init__(self) -> None:
        check_choice(self.variant, VARIANTS, "variant")
        check_choice(self.engine, ENGINES, "engine")
        check_count(self.radius, "radius", least=0)
        check_count(self.patch_radius, "patch_radius", least=0)
        height = self.primary.colour.shape[0]
        rows = np.arange(height) if self.rows is None else np.asarray(self.rows)
        if rows.ndim != 1 or rows.size == 0 or rows.dtype.kind not in "iu" or rows.min() < 0 or rows.max() >= height:
            raise ValueError(f"rows must be a list of row numbers from 0 to {height - 1}, got {self.rows!r}.")
        object.__setattr__(self, "rows", rows.astype(np.int64))
        if self.albedo is not None and (self.albedo.shape != self.primary.colour.shape or not self.albedo.min() > 0):
            raise ValueError(
                f"albedo must have the shape of the colours, {self.primary.colour.shape}, and be above 0; got shape "
                f"{self.albedo.shape}. Take both from `untextured`."
            )

    @property
    def names(self) -> tuple[str, ...]:
        """What each column of theta belongs to."""
        return ("position", "colour", *self.primary.groups)

    @property
    def shape(self) -> tuple[int, int, int]:
        """The shape that theta must have: (rows, w, names)."""
        return len(self.rows), self.primary.colour.shape[1], len(self.names)

    @property
    def noisy(self) -> np.ndarray:
        """The unfiltered colours of the rows, (rows, w, 3)."""
        return self.primary.colour[self.rows] * self._factor

    @cached_property
    def _factor(self) -> np.ndarray | np.float32:
        """What filtered colours are multiplied by."""
        return np.float32(1) if self.albedo is None else self.albedo[self.rows]

    def forward(self, theta: object) -> tuple[np.ndarray, Saved]:
        """Filter.

        Parameters
        ----------
        theta : (rows, w, names), inverse bandwidths, in [0, 1e8]

        Returns
        -------
        filtered : (rows, w, 3), scene-linear radiance; float32 or, by ``"numpy"``, float64
        saved : for `backward`; no weights: they are computed again

        Raises
        ------
        ValueError
            For theta of another shape, not finite, or outside [0, 1e8].
        """
        theta = self._check(theta)
        total, norm = self._sums(theta)
        mean = total / norm[..., np.newaxis]
        return mean * self._factor, (theta, mean, norm)

    def backward(self, d_filtered: np.ndarray, saved: Saved) -> np.ndarray:
        """Gradient of a loss with respect to theta, from that with respect to the filtered colour.

        d c_hat_q / d theta_m = -(1 / S) sum_j w_ij E_m,ij (c_jq - c_hat_q),   S = sum_j w_ij

        minus the weighted covariance of distance and colour.

        Parameters
        ----------
        d_filtered : (rows, w, 3). saved : what `forward` returned.

        Returns
        -------
        d_theta : (rows, w, names)
        """
        theta, mean, norm = saved
        pull = d_filtered * self._factor / norm[..., np.newaxis]
        level = np.sum(pull * mean, axis=-1)
        if self.engine == "numpy":
            return reference_backward(self, theta, pull, level)
        from mcdenoise.kernels.lbf import layer_backward

        arrays = (np.ascontiguousarray(one, np.float32) for one in (pull, level))
        return layer_backward(*self._planes, _in_log_2(theta), self.rows, *arrays)

    def _sums(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sum of w c and sum of w."""
        if self.engine == "numpy":
            return reference_forward(self, theta)
        from mcdenoise.kernels.lbf import layer_forward

        return layer_forward(*self._planes, _in_log_2(theta), self.rows)

    def _check(self, theta: object) -> np.ndarray:
        """Return theta, checked, in the dtype of the engine."""
        theta = check_nonfinite(check_float_array(theta, "theta"), "theta")
        if theta.shape != self.shape:
            raise ValueError(
                f"theta must have shape {self.shape}: rows, columns and {', '.join(self.names)}; got {theta.shape}."
            )
        if theta.min() < 0 or theta.max() > LARGEST_THETA:
            raise ValueError(
                f"theta = 1 / (2 sigma^2) must lie in [0, {LARGEST_THETA:g}], got {theta.min():g} to {theta.max():g}."
            )
        return theta.astype(np.float64 if self.engine == "numpy" else np.float32, copy=False)

    @cached_property
    def _planes(self) -> tuple[Any, Any]:
        """Everything that does not depend on theta, laid out for the kernels."""
        from mcdenoise.kernels.lbf import layer_planes

        groups = self.primary.groups
        features = [np.clip(self.primary.features[name], -LARGEST, LARGEST) for name in groups]
        scales = [1 / np.maximum(self.primary.variances[name], LEAST_VARIANCE) for name in groups]
        colour, spread = self.primary.colour, self.primary.colour_variance + COLOUR_EPSILON / 2
        patch_radius = self.patch_radius if self.variant == "nlm" else None
        return layer_planes(colour, spread, features, scales, self.radius, patch_radius)


def reference_forward(layer: FilterLayer, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The reference: sum of w c (rows, w, 3) and sum of w (rows, w), in float64; offset after offset."""
    whole, colour = _on_image(layer, theta), layer.primary.colour.astype(np.float64)
    total, norm = np.zeros_like(colour), np.zeros(colour.shape[:2])
    for dy, dx, here, there in window_offsets(*colour.shape[:2], layer.radius):
        weight = np.exp(-np.sum(whole[here] * offset_distances(layer, dy, dx, here, there), axis=-1))
        total[here] += weight[..., np.newaxis] * colour[there]
        norm[here] += weight
    return total[layer.rows], norm[layer.rows]


def reference_backward(layer: FilterLayer, theta: np.ndarray, pull: np.ndarray, level: np.ndarray) -> np.ndarray:
    """The reference: - sum_j w_ij E_m,ij (pull_i . c_j - level_i), (rows, w, names), in float64."""
    whole, pull, level = _on_image(layer, theta), _on_image(layer, pull), _on_image(layer, level)
    colour, gradient = layer.primary.colour.astype(np.float64), np.zeros(whole.shape)
    for dy, dx, here, there in window_offsets(*colour.shape[:2], layer.radius):
        distance = offset_distances(layer, dy, dx, here, there)
        weight = np.exp(-np.sum(whole[here] * distance, axis=-1))
        away = np.sum(pull[here] * colour[there], axis=-1) - level[here]
        gradient[here] -= (weight * away)[..., np.newaxis] * distance
    return gradient[layer.rows]


def _on_image(layer: FilterLayer, values: np.ndarray) -> np.ndarray:
    """Spread what belongs to the filtered rows over the whole image, 0 elsewhere."""
    whole = np.zeros((layer.primary.colour.shape[0], *values.shape[1:]))
    whole[layer.rows] = values
    return whole


def _in_log_2(theta: np.ndarray) -> np.ndarray:
    """Theta for weights that are powers of 2."""
    return np.ascontiguousarray(theta * np.float32(np.log2(np.e)), np.float32)
