"""What the study of stability is run with."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """What must be the same for a study of stability to go on.

    Attributes
    ----------
    size : height and width of what is filtered, pixels
    spp : of most entries
    seeds : how many draws of the noise
    picture : height and width of the toy scenes, of which a part of `size` pixels is taken
    reference_spp : of their references
    variant : of Mitsuba, see `mcd.capture`
    normal_runs : how often a method's normal time is measured; the shortest counts
    draws : of RPF with the report's constants, see `report_config`
    """

    size: int = 64
    spp: int = 8
    seeds: int = 10
    picture: int = 128
    reference_spp: int = 1024
    variant: str = "auto"
    normal_runs: int = 3
    draws: float = 0.25

    @classmethod
    def quick(cls) -> Settings:
        """Small and few, for tests: a variant that gives the same numbers on every machine.

        Examples
        --------
        >>> Settings.quick().seeds
        2
        """
        return cls(size=24, seeds=2, picture=40, reference_spp=256, variant="scalar_rgb", normal_runs=1, draws=0.1)
