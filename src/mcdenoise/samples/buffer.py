"""SampleBuffer: the type that flows through the house. One sample is x_i = {p, r, f, c} (Sen & Darabi 2012)."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from mcdenoise.samples.gate import check_count, check_float_array, check_nonfinite
from mcdenoise.samples.gate_samples import check_field, check_hit, check_provenance, check_ranges
from mcdenoise.samples.layout import Layout


@dataclass(frozen=True, eq=False)
class SampleBuffer:
    """The samples of one image, float32, structure of arrays; build it with `from_arrays` or `mcd.capture`.

    Attributes
    ----------
    screen_position : (h, w, spp, 2), p, pixels: x right, y down, pixel (0, 0) covers [0, 1)^2
    random_params : (h, w, spp, n_r), r, in [0, 1]: only those the scene has
    features : (h, w, spp, n_f), f: only those that vary
    radiance : (h, w, spp, 3), c, scene-linear RGB, unclamped
    hit : (h, w, spp) bool, the camera ray met a surface
    layout : Layout, which name stands in which columns
    provenance : read-only mapping: where the samples come from (scene, seed, renderer, ...)

    All arrays are read-only. ``buffer["albedo"]`` is a view of one field by its name: (h, w, spp, channels), or
    (h, w, spp) for a single number such as ``buffer["lens_u"]``.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(3), np.arange(2)), axis=-1)[:, :, np.newaxis]
    >>> buffer = SampleBuffer.from_arrays(
    ...     radiance=np.ones((2, 3, 8, 3)),
    ...     screen_position=corner + rng.random((2, 3, 8, 2)),
    ...     random_params={"lens_u": rng.random((2, 3, 8)), "lens_v": rng.random((2, 3, 8))},
    ...     features={"albedo": np.full((2, 3, 8, 3), 0.5)},
    ... )
    >>> buffer
    SampleBuffer(2 x 3 pixels, 8 spp; random_params: lens_u, lens_v; features: albedo)
    >>> buffer["albedo"].shape, buffer["lens_u"].shape
    ((2, 3, 8, 3), (2, 3, 8))
    """

    screen_position: np.ndarray
    random_params: np.ndarray
    features: np.ndarray
    radiance: np.ndarray
    hit: np.ndarray
    layout: Layout
    provenance: Mapping[str, Any]

    @classmethod
    def from_arrays(
        cls,
        radiance: object,
        screen_position: object,
        random_params: Mapping[str, object] | None = None,
        features: Mapping[str, object] | None = None,
        hit: object = None,
        provenance: Mapping[str, Any] | None = None,
        nonfinite: str = "raise",
    ) -> SampleBuffer:
        """Build a buffer from plain arrays of any renderer; everything is checked here, once, and copied.

        Parameters
        ----------
        radiance : (h, w, spp, 3)
        screen_position : (h, w, spp, 2), each inside its own pixel
        random_params, features : name -> (h, w, spp) or (h, w, spp, channels); other names than the house's are welcome
        hit : (h, w, spp), default: every ray met a surface
        provenance : what JSON can hold: where the samples come from
        nonfinite : ``"raise"``, or ``"zero"`` to set NaN and infinite values to 0 (renderers do emit them)

        Raises
        ------
        ValueError
            For a wrong shape or dtype, an unusable name, NaN or infinity (with ``"raise"``), random parameters outside
            [0, 1], or screen positions outside their pixel.
        """
        radiance = check_float_array(radiance, "radiance")
        if radiance.ndim != 4 or radiance.shape[3] != 3 or radiance.size == 0:
            raise ValueError(f"radiance must have shape (h, w, spp, 3), none of them 0, got {radiance.shape}.")
        size = radiance.shape[:3]
        position = check_float_array(screen_position, "screen_position")
        if position.shape != (*size, 2):
            raise ValueError(f"screen_position must have shape (h, w, spp, 2) = {(*size, 2)}, got {position.shape}.")
        fields = {
            kind: {
                name: check_field(name, check_float_array(a, name), size, kind) for name, a in dict(given or {}).items()
            }
            for kind, given in (("random_params", random_params), ("features", features))
        }
        if twice := set(fields["random_params"]) & set(fields["features"]):
            raise ValueError(f"A name must be a random parameter or a feature, not both: {', '.join(sorted(twice))}.")
        numbers = {
            "radiance": radiance,
            "screen_position": position,
            **{kind: _side_by_side(given, size) for kind, given in fields.items()},
        }
        columns = {kind: {name: a.shape[3] for name, a in given.items()} for kind, given in fields.items()}
        numbers = {name: _frozen(_single(a, name, nonfinite)) for name, a in numbers.items()}
        check_ranges(numbers["screen_position"], numbers["random_params"])
        return cls(
            **numbers,
            hit=_frozen(check_hit(hit, size)),
            layout=Layout.of(columns["random_params"], columns["features"]),
            provenance=MappingProxyType(check_provenance(provenance)),
        )

    @property
    def height(self) -> int:
        """Rows of pixels."""
        return self.radiance.shape[0]

    @property
    def width(self) -> int:
        """Columns of pixels."""
        return self.radiance.shape[1]

    @property
    def spp(self) -> int:
        """Samples per pixel."""
        return self.radiance.shape[2]

    @property
    def random_param_names(self) -> tuple[str, ...]:
        """Names of the random parameters, in column order."""
        return tuple(field.name for field in self.layout.random_params)

    @property
    def feature_names(self) -> tuple[str, ...]:
        """Names of the features, in column order."""
        return tuple(field.name for field in self.layout.features)

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a read-only view of one field: (h, w, spp, channels), or (h, w, spp) for a single number."""
        if found := self.layout.find(name):
            kind, field = found
            return getattr(self, kind)[..., field.start if field.channels == 1 else field.columns]
        if name in ("radiance", "screen_position", "hit"):
            return getattr(self, name)
        has = ("radiance", "screen_position", "hit", *self.random_param_names, *self.feature_names)
        raise KeyError(f"these samples have no {name!r}; they have: {', '.join(has)}")

    def select(self, random_params: Sequence[str] | None = None, features: Sequence[str] | None = None) -> SampleBuffer:
        """Return the buffer with only the named random parameters and features; None keeps all, [] keeps none.

        Raises
        ------
        ValueError
            For a name that the buffer lacks.

        Examples
        --------
        >>> corner = np.zeros((1, 1, 4, 2))
        >>> buffer = SampleBuffer.from_arrays(np.ones((1, 1, 4, 3)), corner, features={"albedo": np.ones((1, 1, 4, 3))})
        >>> buffer.select(features=[]).feature_names
        ()
        """
        changes = {}
        columns = {}
        for kind, names in (("random_params", random_params), ("features", features)):
            fields = self.layout.chosen(kind, names)
            columns[kind] = {field.name: field.channels for field in fields}
            if names is not None:
                block = getattr(self, kind)
                parts = {field.name: block[..., field.columns] for field in fields}
                changes[kind] = _frozen(_side_by_side(parts, block.shape[:3]))
        return replace(self, **changes, layout=Layout.of(columns["random_params"], columns["features"]))

    def crop(self, y: int, x: int, height: int, width: int) -> SampleBuffer:
        """Return the pixels [y, y + height) x [x, x + width); screen positions are counted from the new corner.

        Raises
        ------
        ValueError
            If the crop is empty or leaves the image.

        Examples
        --------
        >>> corner = np.stack(np.meshgrid(np.arange(3), np.arange(2)), axis=-1)[:, :, np.newaxis]
        >>> buffer = SampleBuffer.from_arrays(np.ones((2, 3, 1, 3)), corner + 0.5)
        >>> buffer.crop(1, 1, 1, 2).screen_position[0, 0, 0]
        array([0.5, 0.5], dtype=float32)
        """
        y, x = check_count(y, "y", least=0), check_count(x, "x", least=0)
        height, width = check_count(height, "height"), check_count(width, "width")
        if y + height > self.height or x + width > self.width:
            raise ValueError(
                f"The crop must lie inside the image of {self.height} rows and {self.width} columns, got rows {y} to "
                f"{y + height} and columns {x} to {x + width}."
            )
        window = (slice(y, y + height), slice(x, x + width))
        blocks = {name: getattr(self, name)[window].copy() for name in ("random_params", "features", "radiance", "hit")}
        position = self.screen_position[window] - np.array([x, y], np.float32)
        origin = [int(a + b) for a, b in zip(self.provenance.get("crop_origin", (0, 0)), (y, x), strict=True)]
        return replace(
            self,
            screen_position=_frozen(position),
            **{name: _frozen(block) for name, block in blocks.items()},
            provenance=MappingProxyType({**self.provenance, "crop_origin": origin}),
        )

    def subset(self, start: int, stop: int) -> SampleBuffer:
        """Return samples `start` to `stop` - 1 of every pixel: the same scene at fewer spp, or one half for validation.

        Raises
        ------
        ValueError
            If no sample is left, or `stop` is beyond the buffer's spp.

        Examples
        --------
        >>> SampleBuffer.from_arrays(np.ones((1, 1, 8, 3)), np.zeros((1, 1, 8, 2))).subset(0, 4).spp
        4
        """
        start, stop = self._check_span(start, stop)
        return self._take(np.s_[start:stop], {"subset": [start, stop]})

    def without(self, start: int, stop: int) -> SampleBuffer:
        """Return all samples of every pixel but `start` to `stop` - 1, which may judge what is made of the others.

        Raises
        ------
        ValueError
            If nothing is left out, nothing is left, or `stop` is beyond the buffer's spp.

        Examples
        --------
        >>> SampleBuffer.from_arrays(np.ones((1, 1, 8, 3)), np.zeros((1, 1, 8, 2))).without(2, 4).spp
        6
        """
        start, stop = self._check_span(start, stop)
        if stop - start == self.spp:
            raise ValueError(f"A sample must be left, got start {start} and stop {stop} of {self.spp} spp.")
        return self._take(np.delete(np.arange(self.spp), np.s_[start:stop]), {"left_out": [start, stop]})

    def _check_span(self, start: object, stop: object) -> tuple[int, int]:
        """Return a span of at least one sample within the spp."""
        start = check_count(start, "start", least=0)
        stop = check_count(stop, "stop", least=start + 1)
        if stop > self.spp:
            raise ValueError(f"stop must be at most the {self.spp} spp of these samples, got {stop}.")
        return start, stop

    def _take(self, places: slice | np.ndarray, about: Mapping[str, Any]) -> SampleBuffer:
        """Some samples of every pixel; `about` joins the provenance."""
        names = ("screen_position", "random_params", "features", "radiance", "hit")
        blocks = {name: _frozen(getattr(self, name)[:, :, places].copy()) for name in names}
        return replace(self, **blocks, provenance=MappingProxyType({**self.provenance, **about}))

    def save(self, path: str | os.PathLike) -> None:
        """Write the samples to `path` (`.npz`); `mcd.load_samples` reads them back.

        Raises
        ------
        ValueError
            If `path` does not end in `.npz` or its folder does not exist.
        """
        from mcdenoise.samples.storage import save_samples

        save_samples(self, path)

    def __repr__(self) -> str:
        """One line: size and names."""
        random_params, features = (", ".join(n) or "none" for n in (self.random_param_names, self.feature_names))
        return (
            f"SampleBuffer({self.height} x {self.width} pixels, {self.spp} spp; "
            f"random_params: {random_params}; features: {features})"
        )


def _side_by_side(fields: Mapping[str, np.ndarray], size: tuple[int, ...]) -> np.ndarray:
    """Join fields along the last axis; no field gives an axis of length 0."""
    return np.concatenate([np.empty((*size, 0), np.float32), *fields.values()], axis=-1)


def _single(array: np.ndarray, name: str, nonfinite: str) -> np.ndarray:
    """Return a float32 copy without NaN and infinity, also none made by the conversion."""
    checked = check_nonfinite(array, name, nonfinite)
    with np.errstate(over="ignore"):
        return check_nonfinite(np.array(checked, np.float32, order="C"), f"{name} as float32", nonfinite)


def _frozen(array: np.ndarray) -> np.ndarray:
    """Return `array`, from now on read-only."""
    array.flags.writeable = False
    return array
