"""Chapter 06: the constants of random parameter filtering. Each published version is a set of numbers, so it is data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from mcdenoise.samples.gate import check_bandwidth, check_choice, check_count, check_share

BOXES = (55, 35, 17, 7)
PUBLISHED = 0.5  # M as a share of box^2 spp
ENOUGH = 64  # M / spp at the knee of the curve of speed against accuracy
SPIKES = ("none", "mean", "joint", "clamp")
MOST_LEVELS = 31
NOISY, SMOOTH = 0.02, 0.002  # sigma_8 squared


@dataclass(frozen=True)
class RPFConfig:
    """Every constant of `mcd.rpf`. Start from a preset, and name what is to differ: ``RPFConfig.lecture(clustering=False)``.

    `preset_table` prints where the presets differ.

    Attributes
    ----------
    boxes : side of the neighbourhood in each pass, pixels, odd
    sample_fraction : M, the samples drawn a pixel, as a share of box^2 spp; one number, or one a pass; None: 1/2, as
        published, but no more than 64 spp samples
    passes : places in `boxes` of the passes that are run; None: all
    deterministic : take every sample of the box, and weight it by its distance on the screen, with sigma_p = box / 4
    sigma_8_squared : sigma^2 = 8 sigma_8^2 / spp
    sigma_by_spp : False: sigma^2 = sigma_8^2 at any spp
    sigma_step : sigma^2 is divided by 1 + sigma_step t in pass t
    alpha_start, alpha_step : alpha_k = max(1 - (alpha_start + alpha_step t) W_{c,k}^r, 0)
    beta_start, beta_step : beta_k = max(1 - (beta_start + beta_step t) W_{f,k}^r, 0), times W_c^{f,k} if `by_feature_share`
    by_feature_share : see above
    one_share : alpha from W_c^r, one for all channels
    ratio_of_sums : W_c^r = D_c^r / (D_c^r + D_c^p), else the mean of W_{c,k}^r over the channels
    feature_gains : name and factor of beta, for features that have one
    alpha, beta : fixed for all channels and all features; None: from the dependency
    clustering : leave out samples whose features are far from those of the pixel
    spikes : after each pass, samples of a pixel further than spike_limit standard deviations from its mean: ``"none"``, keep
        them; ``"mean"``, set them to the mean, channel by channel; ``"joint"``, if they are far in all channels, and give what
        is missing to all samples of the pixel; ``"clamp"``, bring only the bright ones to the limit
    spike_limit : standard deviations
    levels : bins of a histogram, odd: one standard deviation each, with what lies beyond in the outermost
    chance : how many times the mutual information that chance alone gives is taken off
    radiance_cap : input samples are cut off here
    noise_gain : how much the noise within pixels widens bandwidths, see `adaptive`; 0: not at all
    random_params : names of those that are asked; None: all that the samples have

    Examples
    --------
    >>> RPFConfig.technical_report(clustering=False).clustering
    False
    >>> RPFConfig(boxes=(8,))
    Traceback (most recent call last):
    ValueError: boxes must be odd, so that a pixel is in the middle of its box, got (8,). Take 7 or 9 for 8.
    """

    boxes: tuple[int, ...] = BOXES
    sample_fraction: float | tuple[float, ...] | None = None
    passes: tuple[int, ...] | None = None
    deterministic: bool = False
    sigma_8_squared: float = SMOOTH
    sigma_by_spp: bool = True
    sigma_step: float = 0.0
    alpha_start: float = 1.0
    alpha_step: float = 0.0
    beta_start: float = 1.0
    beta_step: float = 0.0
    by_feature_share: bool = False
    one_share: bool = False
    ratio_of_sums: bool = False
    feature_gains: tuple[tuple[str, float], ...] = ()
    alpha: float | None = None
    beta: float | None = None
    clustering: bool = True
    spikes: str = "none"
    spike_limit: float = 1.0
    levels: int = 15
    chance: float = 0.0
    radiance_cap: float = field(default=np.inf)
    noise_gain: float = 0.0
    random_params: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        """Check every number."""
        set_ = lambda name, value: object.__setattr__(self, name, value)  # noqa: E731 (frozen)
        set_("boxes", _check_boxes(self.boxes))
        if self.sample_fraction is not None:
            set_("sample_fraction", _check_fractions(self.sample_fraction, len(self.boxes)))
        if self.passes is not None:
            set_("passes", _check_passes(self.passes, len(self.boxes)))
        for name in ("sigma_8_squared", "spike_limit", "radiance_cap"):
            set_(name, check_bandwidth(getattr(self, name), name))
        for name in ("sigma_step", "alpha_start", "alpha_step", "beta_start", "beta_step", "chance", "noise_gain"):
            set_(name, _check_not_negative(getattr(self, name), name))
        for name in ("alpha", "beta"):
            if getattr(self, name) is not None:
                set_(name, check_share(getattr(self, name), name))
        check_choice(self.spikes, SPIKES, "spikes")
        if check_count(self.levels, "levels") % 2 == 0 or self.levels > MOST_LEVELS:
            raise ValueError(f"levels must be an odd number up to {MOST_LEVELS}, so that 0 is one, got {self.levels}.")

    @classmethod
    def lecture(cls, **changes: Any) -> RPFConfig:
        """Return the formulas as the lecture writes them: alpha = 1 - W_{c,k}^r, beta = 1 - W_{f,k}^r.

        It leaves sigma_8 and spikes open: here 0.002 and none.
        """
        return cls(**changes)

    @classmethod
    def technical_report(cls, *, noisy: bool = True, **changes: Any) -> RPFConfig:
        """Return the constants of Sen and Darabi's technical report EECE-TR-11-0004.

        `noisy` chooses sigma_8^2 = 0.02, for noisy (path-traced) scenes, or 0.002, for all others. The published M is
        sample_fraction=0.5.
        """
        preset = {
            "sigma_8_squared": NOISY if noisy else SMOOTH,
            "alpha_start": 2.0,
            "alpha_step": 0.2,
            "beta_step": 0.1,
            "by_feature_share": True,
            "spikes": "mean",
        }
        return cls(**{**preset, **changes})

    @classmethod
    def nvidia(cls, **changes: Any) -> RPFConfig:
        """Return the constants of the independent implementation that came with NVIDIA's indirect light field reconstruction."""
        preset = {
            "sigma_8_squared": NOISY,
            "alpha_step": 0.1,
            "one_share": True,
            "ratio_of_sums": True,
            "beta_step": 0.1,
            "by_feature_share": True,
            "spikes": "joint",
            "levels": 5,
        }
        return cls(**{**preset, **changes})

    @classmethod
    def authors_release(cls, **changes: Any) -> RPFConfig:
        """Return the constants of the code that the authors released. Published M: sample_fraction=(1/3, 1/3, 1/2, 1/2).

        Its second box, 30 pixels, has no middle; here it is 31. At most 10 bins become 9, so that 0 is one.
        """
        preset = {
            "boxes": (45, 31, 15, 5),
            "sigma_8_squared": 0.025,
            "sigma_by_spp": False,
            "sigma_step": 0.05,
            "alpha_start": 5.2,
            "alpha_step": 0.2,
            "beta_start": 1.3,
            "beta_step": 0.05,
            "by_feature_share": True,
            "ratio_of_sums": True,
            "feature_gains": (("albedo", 25.0), ("shading_normal", 10.0)),
            "spikes": "clamp",
            "spike_limit": 0.5,
            "levels": 9,
            "radiance_cap": 10.0,
        }
        return cls(**{**preset, **changes})

    @classmethod
    def adaptive(cls, **changes: Any) -> RPFConfig:
        """Return our own: bandwidths that follow the noise of each pixel. The default of `mcd.rpf`.

        In place of one sigma^2 each standardised scalar k has

            sigma_k^2 = sigma^2 + noise_gain W_k^r v_k

        with v_k its variance within pixels, mean over 3 x 3 of them. The variance says how much a scalar varies where the
        place on the screen hardly does; the share says how much of that is the fault of the random parameters. So noise
        passes and edges do not. Boxes can be small then, every sample of them is taken, and none is left out beforehand.
        """
        preset = {
            "boxes": (5, 3),
            "deterministic": True,
            "clustering": False,
            "noise_gain": 12.0,
        }
        return cls(**{**preset, **changes})

    @property
    def turns(self) -> tuple[int, ...]:
        """The passes that are run: their places in `boxes`."""
        return tuple(range(len(self.boxes))) if self.passes is None else self.passes

    def fraction(self, turn: int) -> float:
        """Return M in pass `turn` as a share of box^2 spp.

        Examples
        --------
        >>> [round(RPFConfig.lecture().fraction(turn), 3) for turn in range(4)]
        [0.021, 0.052, 0.221, 0.5]
        """
        if self.sample_fraction is None:
            return min(PUBLISHED, ENOUGH / self.boxes[turn] ** 2)
        return self.sample_fraction if isinstance(self.sample_fraction, float) else self.sample_fraction[turn]

    def draws(self, turn: int, spp: int) -> int:
        """Return how many samples of other pixels are drawn in pass `turn`: M - spp, 0 at least."""
        return max(round(self.fraction(turn) * self.boxes[turn] ** 2 * spp) - spp, 0)

    def precision(self, turn: int, spp: int) -> float:
        """Return 1 / (2 sigma^2) in pass `turn`, for standardised scalars.

        Examples
        --------
        >>> RPFConfig.technical_report().precision(turn=0, spp=8)
        25.0
        """
        scale = 8 / spp if self.sigma_by_spp else 1.0
        return (1 + self.sigma_step * turn) / (2 * scale * self.sigma_8_squared)


PRESETS = {
    "lecture": RPFConfig.lecture,
    "technical report": RPFConfig.technical_report,
    "NVIDIA": RPFConfig.nvidia,
    "authors' release": RPFConfig.authors_release,
    "adaptive": RPFConfig.adaptive,
}


def preset_table(configs: dict[str, RPFConfig] | None = None) -> str:
    """Return a table, to be printed, of where configurations differ; by default, the presets.

    Examples
    --------
    >>> print(preset_table({"lecture": RPFConfig.lecture(), "NVIDIA": RPFConfig.lecture(levels=5)}))
               lecture NVIDIA
    levels     15      5
    """
    configs = {name: make() for name, make in PRESETS.items()} if configs is None else configs
    rows = []
    for one in fields(RPFConfig):
        values = [getattr(config, one.name) for config in configs.values()]
        if any(value != values[0] for value in values):
            rows.append([one.name, *(_word(value) for value in values)])
    table = [["", *configs], *rows]
    widths = [max(10 if column == 0 else 0, *(len(row[column]) for row in table)) for column in range(len(table[0]))]
    return "\n".join(
        " ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in table
    )


def _word(value: object) -> str:
    """A value in few characters."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple):
        return " ".join(_word(one) for one in value) or "-"
    return "-" if value is None else f"{value:g}" if isinstance(value, (int, float)) else str(value)


def _check_boxes(boxes: object) -> tuple[int, ...]:
    """Odd sides, one at least."""
    if isinstance(boxes, (str, bytes)) or not isinstance(boxes, Sequence) or not boxes:
        raise ValueError(f"boxes must be the sides of one or more boxes, such as (55, 35, 17, 7), got {boxes!r}.")
    sides = tuple(check_count(box, "each of boxes") for box in boxes)
    for box in sides:
        if box % 2 == 0:
            raise ValueError(
                f"boxes must be odd, so that a pixel is in the middle of its box, got {sides}. Take {box - 1} or {box + 1} "
                f"for {box}."
            )
    return sides


def _check_fractions(fraction: object, passes: int) -> float | tuple[float, ...]:
    """One fraction, or one a pass."""
    if not isinstance(fraction, Sequence) or isinstance(fraction, (str, bytes)):
        return _finite(fraction, "sample_fraction")
    if len(fraction) != passes:
        raise ValueError(
            f"sample_fraction must be one number, or one for each of the {passes} boxes, got {len(fraction)} of them."
        )
    return tuple(_finite(one, "each sample_fraction") for one in fraction)


def _finite(value: object, name: str) -> float:
    """Above 0, and finite."""
    number = check_bandwidth(value, name)
    if np.isinf(number):
        raise ValueError(f"{name} must be finite, got {number}. For every sample of the box pass deterministic=True.")
    return number


def _check_passes(passes: object, number: int) -> tuple[int, ...]:
    """Places in the list of boxes, in order."""
    if isinstance(passes, (str, bytes)) or not isinstance(passes, Sequence) or not passes:
        raise ValueError(f"passes must be a list of passes, such as (2, 3), or None for all, got {passes!r}.")
    turns = tuple(check_count(one, "each of passes", least=0) for one in passes)
    if list(turns) != sorted(set(turns)) or turns[-1] >= number:
        raise ValueError(f"passes must be in ascending order, from 0 to {number - 1} for {number} boxes, got {turns}.")
    return turns


def _check_not_negative(value: object, name: str) -> float:
    """A number from 0 on, finite."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ValueError(f"{name} must be a number, got {value!r} ({type(value).__name__}).")
    if not 0 <= value < np.inf:
        raise ValueError(f"{name} must be 0 or greater, and finite, got {value}.")
    return float(value)
