"""The exchange between the grader and the process of a student's function: JSON headers and raw array bytes, no pickle.

A frame is a fixed head (magic, length of the header, length of the body), a JSON header, and the bytes of its arrays one
after the other. Whoever reads trusts nothing: lengths are checked before a byte is stored, and memory grows only with
bytes that have come. This file runs on both sides; it needs the standard library and NumPy alone.

| Python | in the header |
|---|---|
| None, bool, str, int below 2^256 | as JSON |
| float | ["float", exact hexadecimal text] |
| list, tuple, dict | ["list", ...], ["tuple", ...], ["dict", [key, value], ...] |
| array, NumPy number | ["array", dtype, shape], ["number", dtype], little-endian bytes in the body |

What is none of these but close crosses as its nearest: fractions and decimals as floats, np.longdouble as float64, arrays
of text as nested lists, generators, maps, ranges and the keys, values and items of a dict as lists.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable, ItemsView, Iterator, KeysView, ValuesView
from decimal import Decimal
from itertools import islice
from numbers import Integral, Real
from typing import Any

import numpy as np

HEAD = struct.Struct("<4sIQ")
MAGIC = b"mcd1"
HEADER_LIMIT = 8 << 20
BODY_LIMIT = 64 << 20
ITEM_LIMIT = HEADER_LIMIT // 2  # a list of more has no room in a header
TOO_LONG = f"more than {HEADER_LIMIT >> 20} MB of lists and text"
DEPTH_LIMIT = 32
INTEGER_LIMIT = 1 << 256
DTYPES = {
    np.dtype(code).name: np.dtype(code).newbyteorder("<")
    for code in ("?", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f2", "f4", "f8")
}


class WireError(Exception):
    """What came, or was to be sent, is no frame of this exchange."""


class Ended(WireError):
    """The other side closed its end."""


def pack(value: Any) -> bytes:
    """Return the frame of `value`.

    Raises
    ------
    WireError
        If `value` holds something that does not cross, in words that complete "it returned ...".

    Examples
    --------
    >>> unpack(pack({"norm": np.float32([1, 2]), "radius": (2, 0.5)}))
    {'norm': array([1., 2.], dtype=float32), 'radius': (2, 0.5)}
    """
    body = bytearray()
    header = json.dumps(_encode(value, body, DEPTH_LIMIT), separators=(",", ":")).encode("ascii")
    if len(header) > HEADER_LIMIT:
        raise WireError(TOO_LONG)
    return HEAD.pack(MAGIC, len(header), len(body)) + header + body


def unpack(frame: bytes) -> Any:
    """Return the value of a whole frame; raises `WireError` for anything that `pack` would not have made."""
    position = 0

    def read(count: int) -> bytes:
        nonlocal position
        position += count
        return frame[position - count : position]

    value = read_frame(read)
    if position != len(frame):
        raise WireError(f"{len(frame) - position} bytes more than a frame")
    return value


def read_frame(read: Callable[[int], bytes]) -> Any:
    """Read one frame through `read(count)`, which gives `count` bytes, or fewer where the stream ends.

    Raises
    ------
    Ended
        If the stream ends inside the frame.
    WireError
        If what came is no frame, or longer than the limits.
    """
    magic, header_length, body_length = HEAD.unpack(_exactly(read, HEAD.size))
    if magic != MAGIC or header_length > HEADER_LIMIT or body_length > BODY_LIMIT:
        raise WireError("no head of a frame")
    header = _exactly(read, header_length)
    body = _exactly(read, body_length)
    try:
        tree = json.loads(header.decode("ascii"), parse_float=_refuse, parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        raise WireError("the header is no JSON of this exchange") from error
    value, end = _decode(tree, memoryview(body), 0, DEPTH_LIMIT)
    if end != len(body):
        raise WireError(f"the header names {end} bytes of arrays, the body has {len(body)}")
    return value


def _exactly(read: Callable[[int], bytes], count: int) -> bytes:
    """Read `count` bytes or raise."""
    data = read(count)
    if len(data) != count:
        raise Ended(f"the stream ended {count - len(data)} bytes early")
    return data


def _refuse(text: str) -> None:
    raise ValueError(f"{text[:20]}: floats travel as hexadecimal text")


def _encode(value: Any, body: bytearray, depth: int) -> Any:
    """Return `value` as JSON can hold it; the bytes of arrays are appended to `body`."""
    if depth == 0:
        raise WireError(f"lists nested deeper than {DEPTH_LIMIT}")
    kind = type(value)
    if value is None or kind is bool:
        return value
    if kind is str:
        return _text(value)
    if kind is int:
        if abs(value) >= INTEGER_LIMIT:
            raise WireError("an integer of more than 256 bits")
        return value
    if kind is float:
        return ["float", value.hex()]
    if isinstance(value, (np.ndarray, np.generic)):
        return _encode(_texts(value), body, depth) if value.dtype.kind == "U" else _encode_array(value, body)
    if isinstance(value, (list, tuple)):
        name = "list" if isinstance(value, list) else "tuple"
        return [name, *(_encode(item, body, depth - 1) for item in value)]
    if isinstance(value, dict):
        pairs = value.items()
        return ["dict", *([_encode(k, body, depth - 1), _encode(v, body, depth - 1)] for k, v in pairs)]
    return _encode(_nearest(value), body, depth)


def _nearest(value: Any) -> int | float | list:
    """Return the number or list that a value of another type stands for."""
    name = type(value).__name__[:40]
    if not isinstance(value, (Real, Decimal, Iterator, KeysView, ValuesView, ItemsView, range)):
        raise WireError(f"an object of type {name}")
    try:
        if isinstance(value, (Real, Decimal)):
            return int(value) if isinstance(value, Integral) else float(value)
        items = list(islice(value, ITEM_LIMIT + 1))
    except Exception as error:  # of the student's code: a generator runs only now
        raise WireError(f"a {name} that stops with {type(error).__name__[:40]}") from error
    if len(items) > ITEM_LIMIT:
        raise WireError(TOO_LONG)
    return items


def _text(value: str) -> str:
    """Return text that UTF-8 can hold."""
    if len(value) > HEADER_LIMIT // 8:
        raise WireError(f"a text of {len(value)} characters")
    return value.encode("utf-8", "replace").decode("utf-8")


def _texts(value: np.ndarray | np.generic) -> str | list:
    """Return an array of text as nested lists, or the text of a NumPy string."""
    if value.size > ITEM_LIMIT:
        raise WireError(TOO_LONG)
    return np.asarray(value).tolist()


def _encode_array(value: np.ndarray | np.generic, body: bytearray) -> list:
    """Append the bytes of an array or a NumPy number, and return its place in the header."""
    dtype = value.dtype
    name = "float64" if dtype.char == "g" else dtype.name  # "g" is np.longdouble
    if name not in DTYPES:
        if dtype.hasobject:
            raise WireError("an array of Python objects (often rows of different length)")
        raise WireError(f"an array of {name[:40]} (only text, bool, integers and float16 to float64 can be graded)")
    with np.errstate(over="ignore"):
        plain = np.ascontiguousarray(value, dtype=DTYPES[name])
    if len(body) + plain.nbytes > BODY_LIMIT:
        raise WireError(f"more than {BODY_LIMIT >> 20} MB of arrays")
    body += plain.tobytes()
    if isinstance(value, np.generic):
        return ["number", name]
    return ["array", name, list(value.shape)]


def _decode(tree: Any, body: memoryview, start: int, depth: int) -> tuple[Any, int]:
    """Return the value of a header and where in the body its arrays end."""
    if depth == 0:
        raise WireError(f"lists nested deeper than {DEPTH_LIMIT}")
    if tree is None or isinstance(tree, bool):
        return tree, start
    if isinstance(tree, str):
        return _text(tree), start
    if isinstance(tree, int):
        if abs(tree) >= INTEGER_LIMIT:
            raise WireError("an integer of more than 256 bits")
        return tree, start
    if not isinstance(tree, list) or not tree:
        raise WireError("the header holds something unknown")
    match tree:
        case ["float", str(text)]:
            return _decode_float(text), start
        case ["number", str(name)]:
            array, end = _decode_array(name, [], body, start)
            return array[()], end
        case ["array", str(name), list(shape)]:
            return _decode_array(name, shape, body, start)
        case ["list" | "tuple" as kind, *items]:
            values = []
            for item in items:
                value, start = _decode(item, body, start, depth - 1)
                values.append(value)
            return (values if kind == "list" else tuple(values)), start
        case ["dict", *pairs]:
            return _decode_dict(pairs, body, start, depth)
    raise WireError("the header holds something unknown")


def _decode_float(text: str) -> float:
    try:
        return float.fromhex(text)
    except (ValueError, OverflowError) as error:
        raise WireError("a float that is none") from error


def _decode_dict(pairs: list, body: memoryview, start: int, depth: int) -> tuple[dict, int]:
    result = {}
    for pair in pairs:
        if not isinstance(pair, list) or len(pair) != 2:
            raise WireError("a dict without pairs")
        key, start = _decode(pair[0], body, start, depth - 1)
        value, start = _decode(pair[1], body, start, depth - 1)
        try:
            result[key] = value
        except TypeError as error:
            raise WireError("a dict with a key that cannot be one") from error
    return result, start


def _decode_array(name: str, shape: list, body: memoryview, start: int) -> tuple[np.ndarray, int]:
    """Return an array of its own memory; its shape must use exactly the bytes that are there."""
    whole = all(type(size) is int and 0 <= size < 1 << 31 for size in shape)
    if name not in DTYPES or not whole or len(shape) > DEPTH_LIMIT:
        raise WireError("an array of unknown dtype or shape")
    end = start + math.prod(shape) * DTYPES[name].itemsize
    if end > len(body):
        raise WireError("an array longer than the body")
    flat = np.frombuffer(body[start:end], DTYPES[name])
    if name == "bool" and bool((flat.view(np.uint8) > 1).any()):
        raise WireError("a bool that is neither true nor false")
    try:
        return flat.reshape(shape).copy(), end
    except ValueError as error:
        raise WireError("a shape that no array can have") from error
