"""The type of a toy scene: a Mitsuba dict and what is worth recording when it is rendered."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class ToyScene:
    """A small scene that shows one thing.

    Attributes
    ----------
    name : str
        What the user types.
    idea : str
        One sentence: the one thing the scene shows.
    build : callable
        Returns the Mitsuba dict. It is called only after a variant is set, so it imports Mitsuba inside. Film size,
        sampler and integrator are put in by :func:`mcdenoise.render.capture`.
    random_params : tuple of str
        The random parameters the scene really uses, in the order of ``RANDOM_PARAMS``.
    features : tuple of str
        The features that vary over the image, in the order of ``FEATURES``.
    max_depth : int
        Path length of the path integrator (2: light seen directly and after one bounce).
    motion : mapping
        Object key of the dict -> displacement (scene units) while ``time`` goes from 0 to 1. The motion is centred: at
        time t the object stands at its place in the dict plus (t - 0.5) times the displacement.
    """

    name: str
    idea: str
    build: Callable[[], dict]
    random_params: tuple[str, ...]
    features: tuple[str, ...]
    max_depth: int
    motion: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
