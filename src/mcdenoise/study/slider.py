"""A slider over pictures made beforehand: plain HTML, the same in a notebook, on a static page and on a slide.

All frames stand in the fragment as PNGs and all but one are not displayed; the range input's own handler shows another.
No ids, no script element, no network: any number of sliders can stand on one page, and without JavaScript (or on paper)
the frame of `start` is seen. The attribute data-lm-suppress-shortcuts keeps JupyterLab from taking the arrow keys away.
"""

from __future__ import annotations

import base64
import html
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from tqdm import tqdm

from mcdenoise.study.display import png_data_uri
from mcdenoise.study.show import displayed, indexed_png

LARGEST = 600_000  # bytes of one slider, so that a page with several still opens at once
RESOLUTIONS = (150, 110, 80, 60)  # dots per inch of figures: the first at which the slider is not too large
IMAGE_WIDTH = 384  # an image narrower than that is enlarged by a whole factor
_MOVE = (
    "const s=this.closest('.mcd-slider'),f=s.querySelectorAll('img'),n=+this.value;"
    "f.forEach((p,k)=>{p.style.display=k===n?'block':'none'});"
    "s.querySelector('output').textContent=f[n].dataset.value;"
    "this.setAttribute('aria-valuetext',f[n].dataset.value)"
)


@dataclass(frozen=True)
class Slider:
    """An HTML fragment that a notebook shows and a page includes.

    Examples
    --------
    >>> Slider("<p>one</p>").html
    '<p>one</p>'
    """

    html: str

    def _repr_html_(self) -> str:
        return self.html


def slider(
    draw: Callable, *, title: str = "", unit: str = "", start: object = None, **values: Iterable[object]
) -> Slider:
    """Draw a picture for each value of one parameter and put them under a slider.

    Parameters
    ----------
    draw : function of one value; returns an image (h, w), (h, w, 1) or (h, w, 3) of scene-linear radiance, shown under
        the one tone map, or a matplotlib Figure. All frames should have one size.
    title : a line above the picture.
    unit : unit of the parameter, written behind its value.
    start : the value shown first; without it the one in the middle.
    **values : the parameter's name and its values (two or more), as in ``sigma_space=[0.5, 1, 2]``.

    Returns
    -------
    Slider, whose `html` is the fragment (UTF-8, the same for the same frames); a notebook shows it.

    Raises
    ------
    ValueError
        If there is not exactly one parameter, it has fewer than two values, `start` is none of them, or `draw` returns
        something else.

    Examples
    --------
    >>> import mcdenoise as mcd
    >>> grey = mcd.slider(lambda level: np.full((4, 4), level), title="Grey", level=[0.0, 0.5, 1.0])
    >>> grey.html.count("<img "), "level = 0.5" in grey.html
    (3, True)
    """
    name, chosen, first = _parameter(values, start)
    progress = tqdm(chosen, desc=name, unit="frame", delay=2, leave=False, disable=None)
    frames = [_frame(draw(value), name, value) for value in progress]
    labels = [f"{name} = {_text(value)}{' ' if unit else ''}{unit}" for value in chosen]
    for dots in RESOLUTIONS:
        fragment = _fragment([_source(frame, dots) for frame in frames], labels, title, first)
        if len(fragment) <= LARGEST or not any(isinstance(frame, Figure) for frame in frames):
            break
    return Slider(fragment)


def _parameter(values: dict[str, Iterable[object]], start: object) -> tuple[str, list, int]:
    """Return the parameter's name, its values, and the index of the first one shown."""
    if len(values) != 1:
        raise ValueError(
            f"A slider needs exactly one parameter with its values, as in sigma_space=[0.5, 1, 2]; "
            f"got {', '.join(values) or 'none'}."
        )
    ((name, given),) = values.items()
    chosen = list(given) if isinstance(given, Iterable) and not isinstance(given, str) else [given]
    if len(chosen) < 2:
        raise ValueError(f"{name} needs two or more values to slide over, got {given!r}.")
    if start is None:
        return name, chosen, len(chosen) // 2
    if start not in chosen:
        raise ValueError(f"start must be one of {name}'s values, {chosen}; got {start!r}.")
    return name, chosen, chosen.index(start)


def _frame(picture: object, name: str, value: object) -> Figure | np.ndarray:
    """Return what `draw` returned if it can be a frame: a Figure, or display values (h, w, 3)."""
    return picture if isinstance(picture, Figure) else displayed(picture, f"the frame for {name} = {_text(value)}")


def _source(frame: Figure | np.ndarray, dots: int) -> tuple[str, int, str]:
    """Return a frame as a data URI, the width in CSS pixels at which it is shown, and how it is enlarged."""
    if not isinstance(frame, Figure):
        return png_data_uri(frame), frame.shape[1] * max(1, -(-IMAGE_WIDTH // frame.shape[1])), "pixelated"
    uri = "data:image/png;base64," + base64.b64encode(indexed_png(frame, dots)).decode("ascii")
    return uri, round(frame.get_figwidth() * 100), "auto"


def _fragment(sources: list[tuple[str, int, str]], labels: list[str], title: str, first: int) -> str:
    """Return the HTML."""
    lines = [f'<figure class="mcd-slider" style="margin:1em 0;max-width:{sources[0][1]}px">']
    if title:
        lines.append(f'<figcaption style="margin-bottom:.3em"><strong>{html.escape(title)}</strong></figcaption>')
    for index, ((uri, width, enlarged), label) in enumerate(zip(sources, labels, strict=True)):
        display = "block" if index == first else "none"
        text = html.escape(label)
        lines.append(
            f'<img src="{uri}" alt="{html.escape(title)}{": " if title else ""}{text}" data-value="{text}" '
            f'style="display:{display};width:{width}px;max-width:100%;height:auto;margin:0;image-rendering:{enlarged}">'
        )
    lines.append(
        '<label style="display:flex;flex-wrap:wrap;align-items:center;gap:.3em 1em;margin-top:.4em">'
        f'<input type="range" min="0" max="{len(labels) - 1}" step="1" value="{first}" autocomplete="off" '
        'data-lm-suppress-shortcuts="true" '
        f'aria-valuetext="{html.escape(labels[first])}" style="flex:1 1 12em;min-width:0" oninput="{_MOVE}">'
        f'<output style="min-width:12em;font-variant-numeric:tabular-nums">{html.escape(labels[first])}</output></label>'
    )
    return "\n".join([*lines, "</figure>", ""])


def _text(value: object) -> str:
    """Return a value as a reader writes it: 0.5, 2, infinity as its sign."""
    if isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool):
        return f"{value:g}".replace("inf", "∞")
    return str(value)
