"""A slider over pictures made beforehand: plain HTML and JavaScript, the same in a notebook and on a static page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Slider:
    """An HTML fragment that a notebook shows and a page includes."""

    html: str

    def _repr_html_(self) -> str:
        return self.html


def slider(draw: Callable, *, title: str = "", **values: Sequence) -> Slider:
    """Draw a figure for each value of one parameter (``sigma_space=[0.5, 1, 2]``) and put them under a slider."""
    raise NotImplementedError
