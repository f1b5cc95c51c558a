"""Every method as a curve: one dial that trades time for error, from fast to slow; all other dials are chosen by halves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from mcdenoise.lbf.denoise import lbf
from mcdenoise.lbf.storage import shipped_model
from mcdenoise.rpf import rpf
from mcdenoise.rpf.config import RPFConfig
from mcdenoise.samples import SampleBuffer
from mcdenoise.study.methods import METHODS, Method, Parameters, report_config, share_of_draws
from mcdenoise.study.peers import user_methods

WINDOWS = (1, 2, 4, 9)  # 9 pixels are 3 sigma of the largest sigma_space that is tried
SEARCHES = (1, 2, 4, 7)
MODEL_WINDOWS = (3, 7, 27)
BOXES = ((3,), (5, 3), (7, 5, 3))
DRAWS = (0.0625, 0.25)  # times the default, whose published M would take minutes
GROWTH_RADII = (1, 2, 4, 8, 16)
GROWTH_BOX_RADII = (1, 2, 3, 4)


@dataclass(frozen=True)
class Setting:
    """One point of a curve.

    Attributes
    ----------
    label : what the dial is set to; "" for the only setting of a method without a dial
    dial : parameters of the method, set over those that halves of the samples chose
    slow : it takes too long to be run at every spp
    """

    label: str = ""
    dial: Parameters = field(default_factory=dict)
    slow: bool = False


@dataclass(frozen=True)
class Curve:
    """One method with its settings, fastest first.

    Attributes
    ----------
    method : its candidates are what halves of the samples choose from; the dial's own value in them does not count
    settings : what is run
    usual : the place of the setting that stands for the method where there is room for one
    peer : it comes from somebody else
    window : radius -> the dial, where the method has one window to be varied
    radii : that the window takes where growth of time is measured
    """

    method: Method
    settings: tuple[Setting, ...] = (Setting(),)
    usual: int = 0
    peer: bool = False
    window: Callable[[int], Parameters] | None = None
    radii: Sequence[int] = ()

    @property
    def name(self) -> str:
        """The name of the method."""
        return self.method.name

    @property
    def label(self) -> str:
        """The label of the method."""
        return self.method.label


def all_curves(*, few: bool = False) -> tuple[list[Curve], list[str]]:
    """Return the curves of our methods, then the peers that are installed, and the labels of those that are not.

    Parameters
    ----------
    few : the fastest setting and the usual one of each curve are enough.

    Examples
    --------
    >>> curves, missing = all_curves(few=True)
    >>> [setting.label for setting in curves[0].settings]
    ['radius 1', 'radius 9']
    """
    users = user_methods()
    curves = [*our_curves(), *(Curve(method, peer=True) for method in users.values() if method)]
    return [_thinned(curve) if few else curve for curve in curves], [name for name, one in users.items() if one is None]


def our_curves() -> list[Curve]:
    """Return a curve for each method of `METHODS`, in that order.

    Examples
    --------
    >>> [curve.name for curve in our_curves()] == list(METHODS)
    True
    """
    windows = [_windowed(name, "radius", "radius", WINDOWS) for name in tuple(METHODS)[:4]]
    searches = [_windowed(name, "search_radius", "search radius", SEARCHES) for name in ("nlm", "joint_nlm")]
    searches[0] = replace(searches[0], method=_searched_widely(searches[0].method))
    models = [
        _windowed(name, "radius", "radius", MODEL_WINDOWS, replace(METHODS[name], filter=partial(_lbf, variant)))
        for name, variant in (("lbf", "cross_bilateral"), ("lbf_nlm", "nlm"))
    ]
    return [*windows, *searches, _rpf_curve(), _report_curve(), *models]


def _windowed(name: str, dial: str, words: str, radii: Sequence[int], method: Method | None = None) -> Curve:
    """A curve over the radius of the window; the widest stands for the method."""
    settings = tuple(Setting(f"{words} {radius}", {dial: radius}) for radius in radii)
    return Curve(
        method or METHODS[name],
        settings,
        usual=len(settings) - 1,
        window=lambda radius: {dial: radius},
        radii=GROWTH_RADII,
    )


def _searched_widely(method: Method) -> Method:
    """NL-means with those candidates alone whose search window is the widest: the dial of the curve is not chosen."""

    def widest(samples: SampleBuffer) -> Sequence[Parameters]:
        found = method.candidates(samples)
        return [one for one in found if one["search_radius"] == max(other["search_radius"] for other in found)]

    return replace(method, candidates=widest)


def _rpf_curve() -> Curve:
    """Our RPF: the boxes of its passes."""
    method = replace(METHODS["rpf"], filter=_rpf_boxes)
    settings = tuple(Setting(_box_words(boxes), {"boxes": boxes}, slow=boxes == BOXES[-1]) for boxes in BOXES)
    usual = BOXES.index(RPFConfig.adaptive().boxes)
    return Curve(method, settings, usual, window=lambda r: {"boxes": (2 * r + 1,)}, radii=GROWTH_BOX_RADII)


def _box_words(boxes: Sequence[int]) -> str:
    """Boxes as a label.

    Examples
    --------
    >>> _box_words((5, 3)), _box_words((3,))
    ('boxes 5, 3', 'box 3')
    """
    return ("box " if len(boxes) == 1 else "boxes ") + ", ".join(str(box) for box in boxes)


def _report_curve() -> Curve:
    """RPF of the technical report: the share of the published M that is drawn, only the cheap ones."""
    settings = tuple(
        Setting(f"{100 * share_of_draws(report_config(draws)):.1f} % of M", {"draws": draws}, slow=draws == DRAWS[-1])
        for draws in DRAWS
    )
    return Curve(replace(METHODS["rpf_report"], candidates=lambda _: [{}]), settings)


def _rpf_boxes(samples: SampleBuffer, boxes: tuple[int, ...]) -> np.ndarray:
    return rpf(samples, RPFConfig.adaptive(boxes=boxes), progress=False)


def _lbf(variant: str, samples: SampleBuffer, radius: int) -> np.ndarray:
    return lbf(samples, replace(shipped_model(variant), radius=radius))


def _thinned(curve: Curve) -> Curve:
    """The curve with its fastest and its usual setting."""
    kept = tuple(dict.fromkeys((0, curve.usual)))
    return replace(curve, settings=tuple(curve.settings[k] for k in kept), usual=len(kept) - 1)
