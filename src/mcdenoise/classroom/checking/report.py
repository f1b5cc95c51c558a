"""The answer of `check`: which tests hold, what is wrong and how far off, as text and as HTML with a picture."""

from __future__ import annotations

import base64
import html
import re
import sys
import textwrap
from dataclasses import dataclass

from mcdenoise.classroom.checking.exercise import Outcome

_GREEN, _RED, _GREY = "#1a7f37", "#b3261e", "#59636e"  # white text on each has a contrast of 5 or more, in any theme
_BADGE = "display:inline-block;min-width:4.6em;text-align:center;color:#fff;border-radius:.3em;padding:0 .4em;"


@dataclass(eq=False)
class Report:
    """What `check` found out.

    Attributes
    ----------
    name : of the exercise. outcomes : one Outcome per public test, in order.
    problem : why nothing could be tested, or "". notes : further remarks.
    image : the picture as PNG, or None.
    """

    name: str
    outcomes: tuple[Outcome, ...] = ()
    problem: str = ""
    notes: tuple[str, ...] = ()
    image: bytes | None = None
    shown_in: int | None = None  # the notebook's execution count when it was displayed

    @property
    def passed(self) -> bool:
        """Whether every test holds."""
        return bool(self.outcomes) and all(one.passed for one in self.outcomes)

    @property
    def headline(self) -> str:
        """The whole result in one line, without the name."""
        if self.problem:
            return self.problem
        if self.passed:
            return "all tests hold." if len(self.outcomes) > 1 else "the test holds."
        if all(one.unwritten for one in self.outcomes):
            return f"{self.outcomes[0].message} Fill in the cell of `{self.name}`, run it, and check again."
        right = sum(one.passed for one in self.outcomes)
        return (
            f"{right} of {len(self.outcomes)} tests hold." if len(self.outcomes) > 1 else "the test does not hold yet."
        )

    @property
    def _rows(self) -> list[tuple[Outcome, str]]:
        """The outcomes to list, with their messages; a message that repeats is given once."""
        if self.outcomes and all(one.unwritten for one in self.outcomes):
            return []
        rows: list[tuple[Outcome, str]] = []
        for one in self.outcomes:
            repeats = any(one.message == earlier.message for earlier, _ in rows)
            rows.append((one, "(as above)" if one.message and repeats else one.message))
        return rows

    def __str__(self) -> str:
        lines = [f"{self.name}: {self.headline.replace('`', '')}"]
        for one, message in self._rows:
            lines.append(f"  {'holds' if one.passed else 'wrong'}  {one.sentence}")
            lines += textwrap.wrap(message, 110, initial_indent=" " * 9, subsequent_indent=" " * 9)
        for note in self.notes:
            lines += textwrap.wrap(f"note   {note}", 116, initial_indent="  ", subsequent_indent=" " * 9)
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<Report {self.name}: {'passed' if self.passed else 'not passed'}>"

    def _repr_html_(self) -> str:
        colour, symbol, word = self._state
        head = f"<b><code>{html.escape(self.name)}</code></b> {_marked(self.headline)}"
        rows = "".join(_row(one, message) for one, message in self._rows)
        notes = "".join(
            f'<p style="margin:.4em 0 0 0">{_badge(_GREY, "!", "note")} {_marked(one)}</p>' for one in self.notes
        )
        return (
            f'<div style="border-left:.3em solid {colour};padding:.2em 0 .2em .8em;max-width:60em">'
            f'<p style="margin:0">{_badge(colour, symbol, word)} {head}</p>{rows}{notes}{self._picture}</div>'
        )

    @property
    def _state(self) -> tuple[str, str, str]:
        if self.passed:
            return _GREEN, "✓", "right"
        if self.problem or all(one.unwritten for one in self.outcomes):
            return _GREY, "○", "open"
        return _RED, "✗", "not yet"

    @property
    def _picture(self) -> str:
        if self.image is None:
            return ""
        data = base64.b64encode(self.image).decode("ascii")
        words = f"The result of {self.name}, what it should be, and their difference"
        return f'<img style="max-width:100%;margin-top:.6em" alt="{words}" src="data:image/png;base64,{data}">'

    def _ipython_display_(self) -> None:
        """Show it in a notebook, but not twice in the cell that called `check`."""
        shell = running_shell()
        if shell is None or shell.execution_count != self.shown_in:
            self.show()

    def show(self) -> None:
        """Display it in a notebook; print it elsewhere."""
        shell = running_shell()
        if shell is None:
            print(self)
            return
        from IPython.display import display

        self.shown_in = shell.execution_count
        display({"text/html": self._repr_html_(), "text/plain": str(self)}, raw=True)


def running_shell() -> object | None:
    """Return the IPython shell that runs this, if any; IPython is not imported for the question."""
    ipython = sys.modules.get("IPython")
    return ipython.get_ipython() if ipython is not None else None


def _row(one: Outcome, message: str) -> str:
    badge = _badge(_GREEN, "✓", "holds") if one.passed else _badge(_RED, "✗", "wrong")
    below = f'<div style="margin:.1em 0 .3em 6em">{_marked(message)}</div>' if message else ""
    return f'<div style="margin-top:.4em">{badge} {_marked(one.sentence)}{below}</div>'


def _badge(colour: str, symbol: str, word: str) -> str:
    return f'<span style="{_BADGE}background:{colour}">{symbol} {word}</span>'


def _marked(text: str) -> str:
    """Escape text for HTML; what stands in `backticks` becomes code."""
    return re.sub(r"`([^`]+)`", r"<code>\1</code>", html.escape(text))
