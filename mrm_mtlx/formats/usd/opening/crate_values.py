"""Values of an untrusted crate: how large they say they are, and how deeply they lie in each other."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.formats.usd.opening.crate_packing import INTEGERS_PER_BYTE, MAXIMUM_ENTRIES, Cursor, DamagedError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

# Values within values, as of dictionaries; USD follows them by recursion.
MAXIMUM_DEPTH = 128
# Values that a value may consist of: one may stand in several places, as often as these are followed.
MAXIMUM_PARTS = 1_000_000
# Bytes of one array, unpacked.
MAXIMUM_ARRAY_BYTES = 256 * 2**20

# A value is a number of 64 bits: flags, type, and the value itself if it is small, or else where in the file it stands.
_ARRAY, _INLINED, _PACKED = 1 << 63, 1 << 62, 1 << 61
_OFFSET = (1 << 48) - 1
_DICTIONARY, _SAMPLES, _VALUE = 31, 46, 52
# Bytes of an element of an array, by type: numbers, then strings, names of files, matrices, quaternions, vectors.
_ELEMENTS = dict(enumerate((1, 1, 4, 4, 8, 8, 2, 4, 8, 4, 4, 4, 32, 72, 128, 32, 16, 8), 1))
_ELEMENTS |= dict(enumerate((16, 8, 4, 8, 24, 12, 6, 12, 32, 16, 8, 16), 19)) | {56: 8}
# Arrays of these many elements and more may be packed.
_LEAST_PACKED = 16
# Those of fractions begin with this where each element is the number of one in a table.
_FRACTIONS, _TABLE = (7, 8, 9), b"t"
# Bytes of an item, by type: of what is a count and items of one size,
_ITEMS = {40: 4, 41: 4, 45: 8, 48: 8, 49: 16, 50: 4, 58: 8, 59: 1}
# and of lists that edit others: a byte with a bit for each list that is there, and these one behind the other.
_LISTS = {32: 4, 33: 4, 34: 4, 35: 8, 36: 4, 37: 8, 38: 4, 39: 8, 54: 4, 55: 8}
_NUMBER_OF_LISTS = 6
_VARIABLE = (35, 54, 55)


def refuse_oversized(data: memoryview, values: Iterable[int], version: tuple[int, ...]) -> None:
    """Refuse values that claim more than the file has, lie in themselves, or are larger than the bounds.

    Parameters
    ----------
    data
        The file.
    values
        Of its fields.
    version
        Of its format.

    Raises
    ------
    DamagedError
        If it is so.
    """
    looking = _Values(data, version)
    for value in set(values):
        looking.parts(value, 0)


class _Values:
    """The values of a file; each is looked at once."""

    def __init__(self, data: memoryview, version: tuple[int, ...]) -> None:
        self._data, self._version = data, version
        self._parts: dict[int, int] = {}

    def parts(self, value: int, depth: int) -> int:
        """Number of values that one consists of, with itself."""
        if value & _INLINED or not value & _OFFSET:
            return 1
        if value in self._parts:
            if not self._parts[value]:
                msg = "a value lies in itself"
                raise DamagedError(msg)
            return self._parts[value]
        if depth > MAXIMUM_DEPTH:
            msg = f"values lie more than {MAXIMUM_DEPTH} deep in each other"
            raise DamagedError(msg)
        self._parts[value] = 0
        found = 1
        for inner in self._inside(value):
            found += self.parts(inner, depth + 1)
            if found > MAXIMUM_PARTS:
                msg = f"a value consists of more than {MAXIMUM_PARTS} others"
                raise DamagedError(msg)
        self._parts[value] = found
        return found

    def _inside(self, value: int) -> Iterator[int]:
        """The values that one consists of, if it is no plain one; its size is looked at."""
        kind, at = value >> 48 & 0xFF, value & _OFFSET
        if value & _ARRAY:
            self._check_array(kind, at, packed=bool(value & _PACKED))
        elif kind in _ITEMS:
            self._count(at, _ITEMS[kind])
        elif kind in _LISTS:
            self._check_lists(kind, at)
        elif kind == _VALUE:
            yield self._followed(at)[0]
        elif kind == _SAMPLES:
            times, at = self._followed(at)
            yield times
            at += self._number(at, "<q")
            yield from self._numbers(at + 8, self._count(at, 8))
        elif kind == _DICTIONARY:
            count, at = self._count(at, 12), at + 8
            for _ in range(count):
                inner, at = self._followed(at + 4)
                yield inner

    def _number(self, at: int, form: str = "<Q") -> int:
        size = struct.calcsize(form)
        if not 0 <= at <= len(self._data) - size:
            msg = f"a value stands at {at}, and the file has {len(self._data)} bytes"
            raise DamagedError(msg)
        return int(struct.unpack_from(form, self._data, at)[0])

    def _numbers(self, at: int, count: int) -> tuple[int, ...]:
        return struct.unpack_from(f"<{count}Q", self._data, at)

    def _followed(self, at: int) -> tuple[int, int]:
        """A value that stands elsewhere, as far away as is said here; and what is behind it."""
        at += self._number(at, "<q")
        return self._number(at), at + 8

    def _count(self, at: int, size: int) -> int:
        """A count of items of a size, which the file has to have."""
        count = self._number(at)
        if count * size > len(self._data) - at - 8:
            msg = f"a value claims {count} items, for which the file has {len(self._data) - at - 8} bytes"
            raise DamagedError(msg)
        return count

    def _check_array(self, kind: int, at: int, *, packed: bool) -> None:
        if self._version < (0, 5, 0):
            at += 4  # the number of dimensions, which is 1
        wide = self._version >= (0, 7, 0)
        count = self._number(at, "<Q" if wide else "<I")
        left, size = len(self._data) - at - (8 if wide else 4), _ELEMENTS.get(kind, 1)
        packed = packed and count >= _LEAST_PACKED
        if count > (INTEGERS_PER_BYTE * left if packed else left // size):
            msg = f"an array claims {count} elements of {size} bytes, for which the file has {left} bytes"
            raise DamagedError(msg)
        if count * size > MAXIMUM_ARRAY_BYTES:
            msg = f"an array of {count * size / 2**20:.0f} MiB; {MAXIMUM_ARRAY_BYTES // 2**20} MiB are read"
            raise DamagedError(msg)
        if packed and kind in _FRACTIONS:
            self._check_table(Cursor(self._data, "an array", at + (8 if wide else 4)), count, size)

    def _check_table(self, cursor: Cursor, count: int, size: int) -> None:
        """Refuse an array whose elements are not all in its table: USD reads what is behind it."""
        if cursor.take(1) != _TABLE:
            return
        if count > MAXIMUM_ENTRIES:
            msg = f"an array of {count} elements in a table; {MAXIMUM_ENTRIES} are read"
            raise DamagedError(msg)
        entries = int.from_bytes(cursor.take(4), "little")
        cursor.take(entries * size)
        numbers = cursor.integers(count)
        if np.any((numbers < 0) | (numbers >= entries)):
            msg = f"an array has elements beyond its table of {entries}"
            raise DamagedError(msg)

    def _check_lists(self, kind: int, at: int) -> None:
        bits = self._number(at, "<B") >> 1 & 2**_NUMBER_OF_LISTS - 1
        at += 1
        for _ in range(min(bits.bit_count(), 1 if kind in _VARIABLE else _NUMBER_OF_LISTS)):
            at += 8 + self._count(at, _LISTS[kind]) * _LISTS[kind]
