"""Unpacking of what a crate stores: LZ4 blocks, and integers as their differences."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Words = NDArray[np.int64]

# LZ4 makes at most 255 bytes of one. Integers are differences of 0, 1, 2 or 4 bytes, by a code of two bits: at most
# four to a byte before LZ4.
LZ4_PER_BYTE = 255
INTEGERS_PER_BYTE = 4 * LZ4_PER_BYTE
_LENGTHS = np.array([0, 1, 2, 4])
# Most integers that are unpacked at once: half a gigabyte of memory.
MAXIMUM_ENTRIES = 2**24
_U64 = struct.Struct("<Q")


class DamagedError(Exception):
    """A crate claims what its bytes cannot hold."""


class Cursor:
    """Reads forward in a part of a crate."""

    def __init__(self, data: memoryview, name: str, start: int = 0) -> None:
        self.data, self.name, self.at = data, name, start

    def take(self, count: int) -> memoryview:
        """The next bytes."""
        if count < 0 or count > len(self.data) - self.at:
            msg = f"{self.name} claims {count} bytes, of which there are {max(0, len(self.data) - self.at)}"
            raise DamagedError(msg)
        self.at += count
        return self.data[self.at - count : self.at]

    def number(self) -> int:
        """The next number of 64 bits."""
        return int(_U64.unpack(self.take(8))[0])

    def count(self, per_byte: int = INTEGERS_PER_BYTE) -> int:
        """A count of things that follow, at most so many to a byte."""
        number = self.number()
        if number > per_byte * (len(self.data) - self.at):
            msg = f"{self.name} claims {number} entries in {len(self.data) - self.at} bytes"
            raise DamagedError(msg)
        if number > MAXIMUM_ENTRIES:
            msg = f"{self.name} claims {number} entries; {MAXIMUM_ENTRIES} are read"
            raise DamagedError(msg)
        return number

    def packed(self, size: int) -> bytes:
        """The next packed block, unpacked to at most `size` bytes."""
        return unpacked(self.take(self.number()), size, self.name)

    def integers(self, count: int) -> Words:
        """Integers of 32 bits, stored as differences."""
        codes = -(-2 * count // 8)
        if not count:
            self.take(self.number())
            return np.zeros(0, np.int64)
        data = self.packed(4 + codes + 4 * count)
        if len(data) < 4 + codes:
            msg = f"{self.name} has {len(data)} bytes for {count} integers"
            raise DamagedError(msg)
        return summed(data, count, codes, self.name)


def summed(data: bytes, count: int, codes: int, name: str) -> Words:
    """Integers of their differences: the most frequent one, `codes` bytes of codes, and all the others."""
    bits = np.frombuffer(data, np.uint8, codes, 4)
    kinds = np.stack([bits & 3, bits >> 2 & 3, bits >> 4 & 3, bits >> 6], axis=1).ravel()[:count]
    lengths = _LENGTHS[kinds]
    ends = 4 + codes + np.cumsum(lengths)
    if ends[-1] > len(data):
        msg = f"{name} has {len(data)} bytes for {count} integers, which need {ends[-1]}"
        raise DamagedError(msg)
    padded = np.frombuffer(data + b"\0" * 4, np.uint8)
    steps = np.full(count, int.from_bytes(data[:4], "little", signed=True), np.int64)
    for kind, dtype in ((1, "<i1"), (2, "<i2"), (3, "<i4")):
        chosen = np.flatnonzero(kinds == kind)
        starts = ends[chosen] - _LENGTHS[kind]
        found = padded[starts[:, None] + np.arange(_LENGTHS[kind])]
        steps[chosen] = np.ascontiguousarray(found).view(dtype).ravel()
    # Of 32 bits, as USD adds them.
    return (np.cumsum(steps) & 0xFFFFFFFF).astype(np.uint32).view(np.int32).astype(np.int64)


def unpacked(data: memoryview, size: int, name: str) -> bytes:
    """The bytes, at most `size`, that TfFastCompression packed: LZ4 blocks, in several chunks if more than fit."""
    if not data:
        msg = f"{name} has nothing to unpack"
        raise DamagedError(msg)
    if data[0] == 0:
        return bytes(_block(data[1:], size, name))
    found, rest = bytearray(), data[1:]
    for _ in range(data[0]):
        length = int.from_bytes(rest[:4], "little")
        if length > len(rest) - 4:
            msg = f"{name} has a chunk that is cut short"
            raise DamagedError(msg)
        found += _block(rest[4 : 4 + length], size - len(found), name)
        rest = rest[4 + length :]
    return bytes(found)


def _block(data: memoryview, size: int, name: str) -> bytearray:
    """An LZ4 block, unpacked."""
    found, at, end = bytearray(), 0, len(data)
    try:
        while at < end:
            token = data[at]
            at += 1
            length, at = _length(data, at, token >> 4)
            if length > end - at:
                msg = f"{name} is cut short"
                raise DamagedError(msg)
            found += data[at : at + length]
            at += length
            if at < end:
                distance = data[at] | data[at + 1] << 8
                length, at = _length(data, at + 2, token & 15)
                _repeat(found, distance, length + 4, name)
            if len(found) > size:
                msg = f"{name} unpacks to more than {size} bytes"
                raise DamagedError(msg)
    except IndexError:
        msg = f"{name} is cut short"
        raise DamagedError(msg) from None
    return found


def _length(data: memoryview, at: int, length: int) -> tuple[int, int]:
    """A length of four bits, which 15 lets go on in the bytes from `at` on; and where they end."""
    more = 255 if length == 15 else 0
    while more == 255:
        more = data[at]
        at += 1
        length += more
    return length, at


def _repeat(found: bytearray, distance: int, length: int, name: str) -> None:
    """Add `length` bytes, those that stand `distance` before the end."""
    start = len(found) - distance
    if start < 0 or distance == 0:
        msg = f"{name} is packed from what is before its beginning"
        raise DamagedError(msg)
    if distance >= length:
        found += found[start : start + length]
    else:
        pattern = found[start:]
        found += (pattern * (length // distance + 1))[:length]
