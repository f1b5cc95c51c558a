"""What the study of speed against accuracy runs over."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """What the study runs over.

    Attributes
    ----------
    scenes : toy scenes
    size : height and width, pixels
    spps : samples per pixel that filters get, ascending
    chart_spp : one of them: the settings that are marked slow run there alone
    seeds : how many captures are judged
    monte_carlo_spps : where plain Monte Carlo is rendered, beyond `spps`
    reference_spp : of the reference
    few_settings : two settings a curve are enough
    repeats : runs of a setting on one seed, fewer where they are slow
    growth_sizes : heights of the square images whose filtering is timed, at `chart_spp`
    growth_scene : the scene that growth is measured on
    """

    scenes: tuple[str, ...] = ("dof", "pinhole", "soft_shadow", "glossy", "motion")
    size: int = 128
    spps: tuple[int, ...] = (2, 4, 8, 16, 32)
    chart_spp: int = 8
    seeds: int = 3
    monte_carlo_spps: tuple[int, ...] = (64, 128, 256)
    reference_spp: int = 1024
    few_settings: bool = False
    repeats: int = 3
    growth_sizes: tuple[int, ...] = (64, 96, 128, 192, 256)
    growth_scene: str = "dof"

    def __post_init__(self) -> None:
        """Check what fits together."""
        if self.chart_spp not in self.spps:
            raise ValueError(
                f"chart_spp must be one of spps = {self.spps}, got {self.chart_spp}. Add it, or take another."
            )
        if list(self.spps) != sorted(set(self.spps)) or self.spps[0] < 2 or len(self.spps) < 2:
            raise ValueError(
                f"spps must be at least two different spp from 2 on, ascending, got {self.spps}. Halves of the samples "
                f"need 2 spp, a slope needs two points."
            )
        later = [*self.spps[-1:], *self.monte_carlo_spps, self.reference_spp]
        if later != sorted(set(later)) or len(later) < 4:
            raise ValueError(
                f"monte_carlo_spps must be at least two spp, ascending, between spps and reference_spp, got "
                f"{self.monte_carlo_spps} between {self.spps[-1]} and {self.reference_spp}."
            )

    @classmethod
    def quick(cls) -> Settings:
        """Return the study that tests can run."""
        return cls(
            scenes=("dof", "soft_shadow"),
            size=32,
            spps=(2, 8),
            seeds=2,
            monte_carlo_spps=(16, 64),
            reference_spp=256,
            few_settings=True,
            repeats=1,
            growth_sizes=(16, 32),
        )
