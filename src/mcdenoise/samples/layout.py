"""The layout of a sample: which name means which numbers, in which unit. Named slices, never numbered columns."""

from __future__ import annotations

from dataclasses import dataclass

from mcdenoise.samples.gate import check_names

# name -> (channels, unit). The house knows these; a buffer carries only those that its scene has.
RANDOM_PARAMS = {
    "lens_u": (1, "[0, 1), point on the aperture"),
    "lens_v": (1, "[0, 1), point on the aperture"),
    "time": (1, "[0, 1), share of the open shutter"),
    "light_u": (1, "[0, 1), point on the light"),
    "light_v": (1, "[0, 1), point on the light"),
    "bsdf_u": (1, "[0, 1), direction of the scattered ray"),
    "bsdf_v": (1, "[0, 1), direction of the scattered ray"),
}
FEATURES = {
    "world_position": (3, "scene units"),
    "shading_normal": (3, "unit vector in world space"),
    "albedo": (3, "[0, 1]"),
    "world_position_2": (3, "scene units, second hit"),
    "shading_normal_2": (3, "unit vector in world space, second hit"),
    "albedo_2": (3, "[0, 1], second hit"),
    "visibility": (1, "1 if the sampled point of the light is seen, else 0"),
}
CHANNELS = {"screen_position": 2, "radiance": 3, "hit": 1} | {
    name: channels for name, (channels, _) in (RANDOM_PARAMS | FEATURES).items()
}
RESERVED = ("screen_position", "radiance", "hit")


@dataclass(frozen=True)
class Field:
    """One name of the layout: `channels` numbers from `start` on, in `unit`.

    Examples
    --------
    >>> Field("albedo", 6, 3, "[0, 1]").columns
    slice(6, 9, None)
    """

    name: str
    start: int
    channels: int
    unit: str

    @property
    def columns(self) -> slice:
        """The slice of the last axis that this field takes."""
        return slice(self.start, self.start + self.channels)


@dataclass(frozen=True)
class Layout:
    """The fields of `random_params` and of `features`, in the order of their columns.

    Examples
    --------
    >>> layout = Layout.of({"lens_u": 1, "lens_v": 1}, {"albedo": 3})
    >>> [field.name for field in layout.random_params], layout.features[0].channels
    (['lens_u', 'lens_v'], 3)
    """

    random_params: tuple[Field, ...]
    features: tuple[Field, ...]

    @classmethod
    def of(cls, random_params: dict[str, int], features: dict[str, int]) -> Layout:
        """Lay out the given names, each with its number of channels, one after another."""
        return cls(_lay(random_params, RANDOM_PARAMS), _lay(features, FEATURES))

    def __str__(self) -> str:
        """A table: kind, name, columns, unit."""
        rows = [("random_params", field) for field in self.random_params] + [
            ("features", field) for field in self.features
        ]
        lines = [
            f"{kind:14}{field.name:18}{field.start:3}:{field.start + field.channels:<4}{field.unit}"
            for kind, field in rows
        ]
        return "\n".join([f"{'kind':14}{'name':18}columns unit", *lines])

    def find(self, name: str) -> tuple[str, Field] | None:
        """Return the kind and the field of a name, None if there is no such name.

        Examples
        --------
        >>> Layout.of({"lens_u": 1}, {"albedo": 3}).find("albedo")[0]
        'features'
        """
        for kind in ("random_params", "features"):
            for field in getattr(self, kind):
                if field.name == name:
                    return kind, field
        return None

    def chosen(self, kind: str, names: object) -> tuple[Field, ...]:
        """Return the fields of `kind` that `names` lists, in that order; all of them for None.

        Raises
        ------
        ValueError
            For a name that this layout lacks, or one named twice.
        """
        fields = {field.name: field for field in getattr(self, kind)}
        return (
            tuple(fields.values())
            if names is None
            else tuple(fields[n] for n in check_names(names, list(fields), kind))
        )


def _lay(channels_of: dict[str, int], known: dict[str, tuple[int, str]]) -> tuple[Field, ...]:
    """Place the fields one after another."""
    fields, start = [], 0
    for name, channels in channels_of.items():
        fields.append(Field(name, start, channels, known[name][1] if name in known else "as given"))
        start += channels
    return tuple(fields)
