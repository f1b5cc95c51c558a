"""Words for a result of the wrong shape."""

from __future__ import annotations

from math import prod


def explain_shape(yours: tuple[int, ...], needed: tuple[int, ...]) -> str:
    """Say what is wrong with a shape.

    Examples
    --------
    >>> explain_shape((9, 8), (8, 9))
    'transposed: shape (9, 8) came back, (8, 9) is needed; rows (y) come first, then columns (x).'
    >>> explain_shape((8, 9), (8, 9, 3))
    'shape (8, 9) came back, (8, 9, 3) is needed: the last axis (channels) is missing.'
    """
    both = f"shape {yours} came back, {needed} is needed"
    if len(yours) == len(needed) >= 2 and yours == (needed[1], needed[0], *needed[2:]):
        return f"transposed: {both}; rows (y) come first, then columns (x)."
    return f"{both}{_difference(yours, needed)}."


def _difference(yours: tuple[int, ...], needed: tuple[int, ...]) -> str:
    if not needed:
        return ": one number" + (", not an array with one entry" if prod(yours) == 1 else "")
    if yours == needed[:-1]:
        return ": the last axis (channels) is missing" if len(needed) == 3 else ": the last axis is missing"
    if yours == needed[1:]:
        return ": the first axis is missing"
    if yours[:-1] == needed:
        channels = " (channels)" if len(yours) == 3 else ""
        return f": the last axis{channels} is one too many"
    if yours[1:] == needed:
        return ": the first axis is one too many"
    if len(yours) > len(needed) and _squeezed(yours) == _squeezed(needed):
        more = len(yours) - len(needed)
        return f": {'an axis' if more == 1 else f'{more} axes'} of length 1 too many (keepdims?)"
    if prod(yours) == prod(needed):
        return ": as many entries in another shape"
    if len(yours) != len(needed):
        return f": {len(yours)} axes instead of {len(needed)}"
    return _border(yours, needed)


def _squeezed(shape: tuple[int, ...]) -> list[int]:
    return [length for length in shape if length != 1]


def _border(yours: tuple[int, ...], needed: tuple[int, ...]) -> str:
    more = {a - b for a, b in zip(yours[:2], needed[:2], strict=True)}
    if len(more) != 1 or yours[2:] != needed[2:]:
        return ""
    extra = more.pop()
    where = "at each border" if extra % 2 == 0 else "along each axis"
    pixels = abs(extra) // 2 if extra % 2 == 0 else abs(extra)
    unit = "pixel" if pixels == 1 else "pixels"
    return f": {pixels} {unit} {'too many' if extra > 0 else 'missing'} {where}"
