"""Where the guarantees of the catalogue are not given: which methods, at which levels, why, and the number seen."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Limit:
    """A guarantee that is not given.

    Attributes
    ----------
    methods : which
    levels : labels; (): all
    seen : the largest number that the quick study saw among them; infinity: a message in place of an image
    reason : why
    quick : False: the quick study holds it, by being small; `seen` is from the full one
    """

    methods: tuple[str, ...]
    levels: tuple[str, ...]
    seen: float
    reason: str
    quick: bool = True


FIXED_SPACE = "the bell over space does not see what it averages"
BLURS = "next to no noise is left to remove, and what blurring costs does not fall with the noise"
NO_VARIANCE = "one sample has no variance: differences between neighbours stand in for it, and an edge is one"
REPORT = (
    "alpha = max(1 - 2 W, 0) is 0 almost everywhere, so radiance has no say: what no feature knows is averaged over boxes of "
    "up to 55 pixels"
)
SPREAD_VARIANCE = (
    "a firefly widens the variance around it, in units of which patches are compared, so neighbours accept it"
)
BLENDS = "it blends samples, so a pixel stays within the range of the samples, and not of the pixels"
IN_RADIANCE = "its bandwidth is in radiance: another unit is another filter"

LIMITS: dict[str, tuple[Limit, ...]] = {
    "firefly_count": (
        Limit(("gaussian",), (), 1.7e5, FIXED_SPACE),
        Limit(("nlm", "joint_nlm"), (), 1.4e5, SPREAD_VARIANCE),
        Limit(("rpf_report",), (), 4.0e4, REPORT),
        Limit(
            ("lbf", "lbf_nlm"),
            ("20000 / Mpx",),
            3.0e3,
            "its variance is despiked at 10 deviations, which no pixel reaches where more than one in a hundred is a firefly",
        ),
        Limit(("rpf",), ("20000 / Mpx",), 250.0, "three or more in one box of 5 x 5 pixels reach the pixel beside", quick=False),
    ),
    "firefly_value": (
        Limit(("gaussian",), ("10000", "1e+06"), 1.5e4, FIXED_SPACE + ": damage grows with the value"),
        Limit(("nlm", "joint_nlm"), ("10000", "1e+06"), 1.2e4, SPREAD_VARIANCE),
        Limit(("rpf_report",), ("10000", "1e+06"), 8.1e3, REPORT),
    ),
    "black": (
        Limit(("gaussian",), (), 0.18, FIXED_SPACE),
        Limit(("bilateral",), ("0",), 0.024, "noise hides the edge of light from radiance alone"),
        Limit(("nlm",), ("0",), 0.011, "noise hides the edge of light from radiance alone"),
    ),
    "scale": (
        Limit(("bilateral", "cross_bilateral", "cross_bilateral_prefiltered"), (), 0.72, IN_RADIANCE),
        Limit(("lbf", "lbf_nlm"), (), 0.95, "its network sees log(1 + c), which has a unit"),
    ),
    "high_range": (
        Limit(("gaussian",), ("4 decades", "8 decades"), 18.0, FIXED_SPACE),
        Limit(("cross_bilateral",), ("4 decades", "8 decades"), 1.2, IN_RADIANCE + ", too wide for the dark bands"),
        Limit(("cross_bilateral_prefiltered",), ("8 decades",), 1.2, IN_RADIANCE + ", too wide for the dark bands"),
        Limit(("rpf_report",), ("8 decades",), 5.9, REPORT),
        Limit(("rpf_report",), ("4 decades",), 2.7, REPORT, quick=False),
        Limit(
            ("joint_nlm", "lbf", "lbf_nlm"), ("8 decades",), 2.8,
            "bias at the steps: bright noise hides dark bands", quick=False,
        ),
    ),
    "noise_free": (
        Limit(("gaussian", "bilateral"), (), 3.4e-3, "bandwidths are fixed, however little noise there is"),
        Limit(("cross_bilateral_prefiltered", "nlm", "joint_nlm", "rpf", "lbf", "lbf_nlm"), ("1 spp",), 8.1e-3, NO_VARIANCE),
    ),
    "texture": (
        Limit(("gaussian",), (), 8.4, FIXED_SPACE),
        Limit(("bilateral",), ("1 px", "2 px"), 2.7, "noise hides the texture from radiance alone"),
        Limit(("nlm",), ("4 px",), 1.2, "its window of 7 pixels is narrower than the period of 8: no other patch is like"),
    ),
    "noisy_features": (
        Limit(("gaussian", "bilateral"), ("8 spp",), 1.6, BLURS),
        Limit(("cross_bilateral",), ("8 spp",), 1.8, "raw features are too noisy for a narrow bandwidth, and a wide one blurs"),
        Limit(("rpf",), ("8 spp",), 1.3, "few pixels across the blur: what the lens explains is edge, too"),
        Limit(("rpf_report",), (), 3.1, REPORT),
    ),
    "missing_features": (Limit(("rpf_report",), (), 3.9, REPORT),),
    "constant_feature": (
        Limit(("lbf", "lbf_nlm"), (), 0.12, "its network sees a feature that is there, and has learnt what its absence means"),
    ),
    "misleading_features": (
        Limit(("gaussian",), ("radiance edges",), 1.2, FIXED_SPACE),
        Limit(
            ("cross_bilateral", "cross_bilateral_prefiltered"), ("radiance edges",), 2.5,
            "where features know no edge, a wide bandwidth of radiance blurs it",
        ),
        Limit(("rpf_report",), ("radiance edges",), 8.9, REPORT, quick=False),
        Limit(("lbf_nlm",), ("radiance edges",), 1.01, "stripes of 4 pixels in patches of 7", quick=False),
    ),
    "second_hit": (Limit(("rpf_report",), ("8 spp", "4 spp"), 1.3, REPORT),),
    "penumbra": (
        Limit(("gaussian", "bilateral"), ("8 spp", "4 spp"), 2.5, BLURS),
        Limit(("cross_bilateral",), ("8 spp",), 1.4, BLURS),
        Limit(("rpf_report",), ("8 spp", "4 spp"), 2.4, REPORT),
    ),
    "bokeh": (Limit(("rpf_report",), ("8 spp",), 1.1, REPORT),),
    "mutual_information": (
        Limit(("gaussian",), ("8 spp",), 2.6, BLURS),
        Limit(
            ("cross_bilateral", "cross_bilateral_prefiltered"), ("2 spp", "8 spp"), 6.0,
            "where features know no edge, a wide bandwidth of radiance blurs it",
        ),
        Limit(("rpf",), ("8 spp",), 1.1, "chance passes for dependency; with chance=1 it is taken off, and the ratio halves"),
        Limit(("rpf_report",), (), 17.0, REPORT),
        Limit(("lbf", "lbf_nlm"), ("1 spp",), 2.8, NO_VARIANCE),
    ),
    "small_image": (
        Limit(("rpf",), (), 0.032, BLENDS),
        Limit(("rpf_report",), ("2 x 3",), 0.042, BLENDS),
        Limit(("lbf", "lbf_nlm"), ("2 x 3",), 9.4e-4, "it averages colour / albedo, and multiplies by another albedo"),
        Limit(("rpf_report",), ("1 x 1", "5 x 5"), 0.24, BLENDS, quick=False),
    ),
    "noise_level": (
        Limit(("gaussian", "bilateral"), ("0.01", "0.03", "0.1"), 310.0, BLURS),
        Limit(("cross_bilateral",), ("0.01", "0.03"), 33.0, BLURS),
        Limit(("cross_bilateral_prefiltered", "lbf"), ("0.01",), 7.6, BLURS),
    ),
}  # fmt: skip


# What the small images of the quick study break, and the full study holds.
HELD_IN_FULL: dict[str, dict[str, tuple[str, ...]]] = {  # entry -> level -> methods
    "black": {
        "0": ("nlm",),
        "0.1": ("gaussian",),
    },
    "high_range": {
        "4 decades": (
            "gaussian",
            "cross_bilateral",
        ),
        "8 decades": (
            "cross_bilateral",
            "cross_bilateral_prefiltered",
        ),
    },
    "noise_free": {
        "1 spp": (
            "bilateral",
            "cross_bilateral_prefiltered",
            "joint_nlm",
        ),
        "8 spp": ("bilateral",),
    },
    "noisy_features": {
        "8 spp": (
            "gaussian",
            "bilateral",
            "cross_bilateral",
            "rpf",
        ),
        "2 spp": ("rpf_report",),
    },
    "missing_features": {
        "none": ("rpf_report",),
        "constant": ("rpf_report",),
        "noise": ("rpf_report",),
    },
    "second_hit": {
        "8 spp": ("rpf_report",),
        "4 spp": ("rpf_report",),
    },
    "penumbra": {
        "8 spp": (
            "gaussian",
            "bilateral",
            "cross_bilateral",
        ),
        "4 spp": (
            "gaussian",
            "bilateral",
            "rpf_report",
        ),
    },
    "noise_level": {
        "0.01": (
            "cross_bilateral_prefiltered",
            "lbf",
        ),
    },
}


def limit_of(name: str, method: str, level: str) -> Limit | None:
    """Why an entry's guarantee is not given for a method at a level; None where it is given."""
    for one in LIMITS.get(name, ()):
        if method in one.methods and (not one.levels or level in one.levels):
            return one
    return None


def broken_in(study: str, name: str, method: str, level: str) -> Limit | None:
    """The limit that one of the two studies must show, ``"quick"`` or ``"full"``; None where it must hold the guarantee."""
    limit = limit_of(name, method, level)
    held = method in HELD_IN_FULL.get(name, {}).get(level, ()) if study == "full" else limit and not limit.quick
    return None if held else limit
