"""The gate: every check of input that comes from outside stands here, once.

Each function returns the value in the form the rest of the house works with, or raises `ValueError` with a message of
three parts: what is needed, what came, what to do about it. Behind the gate nobody checks again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

NONFINITE_CHOICES = ("raise", "zero")
ENGINES = ("numba", "numpy")


def check_nonfinite(values: np.ndarray, name: str, nonfinite: str = "raise") -> np.ndarray:
    """Refuse NaN and infinity in `values`, or replace them by 0 when the caller asked for it.

    Parameters
    ----------
    values : ndarray of float, any shape. Never changed: a copy is made if something has to be replaced.
    name : what to call the array in the message.
    nonfinite : ``"raise"`` or ``"zero"``.

    Raises
    ------
    ValueError
        If `nonfinite` is neither choice, or is ``"raise"`` and some value is not finite.

    Examples
    --------
    >>> check_nonfinite(np.array([1.0, np.inf]), "radiance", "zero")
    array([1., 0.])
    """
    check_choice(nonfinite, NONFINITE_CHOICES, "nonfinite")
    bad = ~np.isfinite(values)
    if not bad.any():
        return values
    if nonfinite == "zero":
        return np.where(bad, values.dtype.type(0), values)
    first = tuple(int(i) for i in np.argwhere(bad)[0])
    raise ValueError(
        f"{name} must be finite: {int(bad.sum())} of {values.size} values are NaN or infinite, the first at index "
        f"{first} ({values[first]}). Renderers do emit such samples: pass nonfinite='zero' when you build or load "
        f"the samples (np.nan_to_num for a finished image) to set them to 0."
    )


def check_float_array(value: object, name: str) -> np.ndarray:
    """Return `value` as an array of float32 or float64; anything else real is converted to float32.

    Raises
    ------
    ValueError
        If `value` is no real-valued numeric array (text, objects, complex numbers, ragged lists).

    Examples
    --------
    >>> check_float_array([1, 2], "image").dtype
    dtype('float32')
    """
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise ValueError(f"{name} must be a rectangular numeric array, got something ragged ({error}).") from error
    if array.dtype.kind not in "buif":
        raise ValueError(
            f"{name} must be a real-valued numeric array, got dtype {array.dtype} from a {type(value).__name__}. "
            f"Pass a NumPy array of float32 or float64."
        )
    if array.dtype in (np.float32, np.float64):
        return array
    return array.astype(np.float32)


def check_image(image: object, name: str = "image") -> np.ndarray:
    """Return `image` as a finite float32 or float64 array of shape (h, w) or (h, w, c).

    Raises
    ------
    ValueError
        For another shape, an empty image, a non-numeric dtype, NaN or infinity.

    Examples
    --------
    >>> check_image(np.ones((2, 3), np.uint8)).dtype
    dtype('float32')
    """
    array = check_float_array(image, name)
    if array.ndim not in (2, 3):
        raise ValueError(
            f"{name} must have shape (h, w) or (h, w, c), got {array.shape}. For samples of shape (h, w, spp, c) take "
            f"mcd.pixel_mean(samples) first."
        )
    if array.size == 0:
        raise ValueError(f"{name} must hold at least one pixel and one channel, got shape {array.shape}.")
    return check_nonfinite(array, name)


def check_same_size(array: np.ndarray, name: str, image: np.ndarray, image_name: str = "image") -> np.ndarray:
    """Return `array` if its height and width are those of `image`.

    Raises
    ------
    ValueError
        If they differ.

    Examples
    --------
    >>> check_same_size(np.ones((2, 3, 1)), "albedo", np.ones((2, 3))).shape
    (2, 3, 1)
    """
    if array.shape[:2] != image.shape[:2]:
        raise ValueError(
            f"{name} must have the height and width of {image_name}, {image.shape[:2]}, got {array.shape[:2]}. "
            f"Crop or render both at the same size."
        )
    return array


def check_bandwidth(value: object, name: str) -> float:
    """Return a bandwidth (sigma) as a float: above 0, infinity allowed (it switches that term off).

    Raises
    ------
    ValueError
        If `value` is no number, NaN, zero or negative.

    Examples
    --------
    >>> check_bandwidth(2, "sigma_space")
    2.0
    """
    number = _real(value, name)
    if not number > 0:
        raise ValueError(f"{name} must be greater than 0 (infinity switches the term off), got {number}.")
    return number


def check_share(value: object, name: str) -> float:
    """Return a share as a float in [0, 1].

    Raises
    ------
    ValueError
        If `value` is no number, NaN, or outside.

    Examples
    --------
    >>> check_share(1, "cancellation")
    1.0
    """
    number = _real(value, name)
    if not 0 <= number <= 1:
        raise ValueError(f"{name} must lie in [0, 1], got {number:g}.")
    return number


def check_radius(radius: object, sigma_space: float) -> int:
    """Return the window radius in pixels: `radius` itself, or ceil(3 sigma_space) if it is None.

    Raises
    ------
    ValueError
        If `radius` is no whole number or negative, or if it is None while 3 `sigma_space` is infinite.

    Examples
    --------
    >>> check_radius(None, 1.5)
    5
    """
    if radius is None:
        if np.isinf(3 * sigma_space):
            raise ValueError("radius must be given when sigma_space is infinite (the default is ceil(3 sigma_space)).")
        return int(np.ceil(3 * sigma_space))
    return check_count(radius, "radius", least=0)


def check_count(value: object, name: str, least: int = 1) -> int:
    """Return `value` as an int of at least `least`.

    Raises
    ------
    ValueError
        If `value` is no whole number (True and False are refused too) or is below `least`.

    Examples
    --------
    >>> check_count(np.int64(8), "spp")
    8
    """
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)):
        raise ValueError(f"{name} must be a whole number, got {value!r} ({type(value).__name__}).")
    if value < least:
        raise ValueError(f"{name} must be at least {least}, got {value}.")
    return int(value)


def check_choice(value: object, choices: Sequence[str], name: str) -> str:
    """Return `value` if it is one of `choices`.

    Raises
    ------
    ValueError
        Otherwise; the message lists the choices.

    Examples
    --------
    >>> check_choice("numba", ENGINES, "engine")
    'numba'
    """
    if not isinstance(value, str) or value not in choices:
        raise ValueError(f"{name} must be one of {', '.join(map(repr, choices))}, got {value!r}.")
    return value


def check_names(names: object, known: Sequence[str], name: str) -> tuple[str, ...]:
    """Return `names` as a tuple if each is in `known` and none comes twice.

    Raises
    ------
    ValueError
        For a bare string, an unknown name or a repeated one.

    Examples
    --------
    >>> check_names(["albedo"], ("world_position", "albedo"), "features")
    ('albedo',)
    """
    if isinstance(names, (str, bytes)) or not isinstance(names, (Sequence, Mapping, set, frozenset)):
        raise ValueError(f"{name} must be a list of names, got {names!r}. Write {name}=[...].")
    chosen = tuple(names)
    for one in chosen:
        if one not in known:
            raise ValueError(f"{name} has no {one!r}; there is: {', '.join(known) or 'nothing'}.")
    if len(set(chosen)) != len(chosen):
        raise ValueError(f"{name} must not name anything twice, got {list(chosen)}.")
    return chosen


def _real(value: object, name: str) -> float:
    """Return `value` as a float; NaN, text and arrays are refused."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ValueError(f"{name} must be a number, got {value!r} ({type(value).__name__}).")
    if np.isnan(value):
        raise ValueError(f"{name} must be a number, got NaN.")
    return float(value)
