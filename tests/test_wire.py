"""The exchange with the process of a student's function: what crosses, what does not, and garbage."""

import io
import itertools
import struct
import tracemalloc
from contextlib import suppress
from decimal import Decimal
from enum import IntEnum
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from mcdenoise.classroom.grading import wire

arrays = hnp.arrays(
    dtype=st.sampled_from([np.dtype(name) for name in wire.DTYPES]), shape=hnp.array_shapes(min_dims=0, min_side=0)
)
plain = (
    st.none()
    | st.booleans()
    | st.integers(1 - wire.INTEGER_LIMIT, wire.INTEGER_LIMIT - 1)
    | st.floats()
    | st.text(st.characters(exclude_categories=["Cs"]))
)
values = st.recursive(
    plain | arrays | arrays.filter(lambda array: array.size).map(lambda array: array.reshape(-1)[0]),
    lambda inner: st.lists(inner) | st.lists(inner).map(tuple) | st.dictionaries(plain, inner),
    max_leaves=12,
)


def same(a, b):
    """Equal in type, dtype, shape and every bit."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray | np.generic):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if isinstance(a, float):
        return a.hex() == b.hex()
    if isinstance(a, dict):
        return same(list(a.items()), list(b.items()))
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(same, a, b))
    return a == b


@given(values)
def test_what_crosses_comes_back_the_same(value):
    assert same(wire.unpack(wire.pack(value)), value)


class Own(np.ndarray):
    """A subclass, such as a student may hand back."""


def test_arrays_of_any_layout_cross_as_plain_ones():
    image = np.arange(24.0).reshape(4, 6)
    for array in (image.T, image[::-1, ::2], image.astype(">f4"), np.asfortranarray(image), image.view(Own)):
        back = wire.unpack(wire.pack(array))
        assert type(back) is np.ndarray
        assert back.flags.c_contiguous
        assert back.flags.writeable
        assert np.array_equal(back, np.asarray(array))


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (object(), "an object of type object"),
        (print, "an object of type builtin_function"),
        (np.array([1, "a"], dtype=object), "Python objects"),
        (np.array([b"a"]), "bytes8"),
        (np.broadcast_to("a", 1 << 40), "8 MB of lists and text"),
        (itertools.count(), "8 MB of lists and text"),
        ((1 // x for x in (1, 0)), "a generator that stops with ZeroDivisionError"),
        (Fraction(10**400), "a Fraction that stops with OverflowError"),
        (Decimal("sNaN"), "a Decimal that stops with ValueError"),
        (np.array([1j]), "complex128"),
        ({1, 2}, "an object of type set"),
        (1 << 256, "256 bits"),
        ("x" * (2 << 20), "a text of"),
        (np.zeros(wire.BODY_LIMIT // 8 + 1), "64 MB of arrays"),
        (["x" * 1_000_000] * 9, "8 MB of lists and text"),
    ],
)
def test_what_does_not_cross_is_named(value, words):
    with pytest.raises(wire.WireError, match=words):
        wire.pack(value)


class Level(IntEnum):
    """An enumeration, such as a student may hand back."""

    HIGH = 3


@pytest.mark.parametrize(
    ("value", "nearest"),
    [
        (np.array([["a", "bc"], ["", "d"]]), [["a", "bc"], ["", "d"]]),
        (np.str_("a"), "a"),
        (np.array("a"), "a"),
        ({"a": 1, "b": 2}.keys(), ["a", "b"]),
        ({"a": 1, "b": 2}.values(), [1, 2]),
        ({"a": 1, "b": 2}.items(), [("a", 1), ("b", 2)]),
        ((x * x for x in range(3)), [0, 1, 4]),
        (map(abs, (-1, 2)), [1, 2]),
        (range(3), [0, 1, 2]),
        ({"sums": zip("ab", (1, 2.5), strict=True)}, {"sums": [("a", 1), ("b", 2.5)]}),
        (Fraction(1, 4), 0.25),
        (Decimal("0.1"), 0.1),
        (Level.HIGH, 3),
        (np.longdouble(0.5), np.float64(0.5)),
        (np.array([[0.5, 2]], np.longdouble), np.array([[0.5, 2]])),
    ],
)
def test_what_is_close_crosses_as_its_nearest(value, nearest):
    assert same(wire.unpack(wire.pack(value)), nearest)


def test_a_long_double_beyond_float64_is_infinite():
    largest = np.finfo(np.longdouble).max
    with np.errstate(over="ignore"):
        expected = np.array([largest]).astype(np.float64)
    assert same(wire.unpack(wire.pack(np.array([largest]))), expected)


def test_generators_within_generators_have_an_end():
    def nested():
        yield nested()

    with pytest.raises(wire.WireError, match="nested deeper"):
        wire.pack(nested())


def test_nesting_has_an_end():
    inner = []
    for _ in range(wire.DEPTH_LIMIT):
        inner = [inner]
    with pytest.raises(wire.WireError, match="nested deeper"):
        wire.pack(inner)
    inner.append(inner)  # a list that holds itself
    with pytest.raises(wire.WireError, match="nested deeper"):
        wire.pack(inner)


def test_text_that_utf8_lacks_is_replaced():
    assert wire.unpack(wire.pack("a\ud800b")) == "a?b"
    assert wire.unpack(frame(b'"\\ud800"')) == "?"


def frame(header, body=b""):
    return wire.HEAD.pack(wire.MAGIC, len(header), len(body)) + header + body


@pytest.mark.parametrize(
    "header",
    [
        b"",
        b"{}",
        b"[]",
        b"NaN",
        b"1.5",
        b"\xff",
        b"[" * 200_000,
        b'["list",' * 40 + b"1" + b"]" * 40,
        b"9" * 5000,
        b"9" * 100,
        b'["float","x"]',
        b'["float","0x1p99999"]',
        b'["float",1]',
        b'["array","object",[1]]',
        b'["array","float64",[-1]]',
        b'["array","float64",[1]]',
        b'["array","float64",[true]]',
        b'["array","float64",[0,9223372036854775807]]',
        b'["array","float64",[4611686018427387904,4611686018427387904]]',
        b'["array","float64",[2147483647,2147483647,0,2147483647,2147483647]]',
        b'["array","float64",[' + b"1," * 40 + b"1]]",
        b'["dict",[1]]',
        b'["dict",[["list"],1]]',
        b'["pickle","cos"]',
    ],
)
def test_headers_that_nobody_packs_are_refused(header):
    with pytest.raises(wire.WireError):
        wire.unpack(frame(header))


def test_bytes_that_are_no_bool_are_refused():
    with pytest.raises(wire.WireError, match="neither true nor false"):
        wire.unpack(frame(b'["array","bool",[1]]', b"\x07"))


@pytest.mark.parametrize("tail", [b"x", bytes(8)])
def test_bytes_too_many_are_refused(tail):
    with pytest.raises(wire.WireError):
        wire.unpack(wire.pack(1) + tail)
    with pytest.raises(wire.WireError):
        wire.unpack(frame(b"1", tail))


@given(st.binary(max_size=300) | st.binary(max_size=300).map(lambda tail: wire.MAGIC + tail))
def test_random_bytes_raise_our_own_error(data):
    with pytest.raises(wire.WireError):
        wire.unpack(data)


@given(values, st.data())
def test_damaged_frames_raise_our_own_error_or_give_a_value(value, data):
    damaged = bytearray(wire.pack(value))
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    with suppress(wire.WireError):
        wire.pack(wire.unpack(bytes(damaged)))


@given(values, st.integers(1, 200))
def test_a_frame_cut_short_has_ended(value, cut):
    whole = wire.pack(value)
    with pytest.raises(wire.Ended):
        wire.unpack(whole[: max(0, len(whole) - cut)])


@pytest.mark.parametrize(
    "lengths", [(2**32 - 1, 0), (10, 2**64 - 1), (wire.HEADER_LIMIT + 1, 0), (1, wire.BODY_LIMIT + 1)]
)
def test_lengths_are_checked_before_anything_is_stored(lengths):
    asked = []

    def read(count):
        asked.append(count)
        return source.read(count)

    source = io.BytesIO(struct.pack("<4sIQ", wire.MAGIC, *lengths))
    tracemalloc.start()
    try:
        with pytest.raises(wire.WireError, match="no head"):
            wire.read_frame(read)
        assert tracemalloc.get_traced_memory()[1] < 100_000
    finally:
        tracemalloc.stop()
    assert asked == [wire.HEAD.size]
