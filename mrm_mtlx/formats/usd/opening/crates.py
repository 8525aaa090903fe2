"""Untrusted crates: what one claims to hold is compared with what its bytes can hold.

USD makes room for whatever count a crate states before it reads, and follows the tree of its paths wherever it leads: a
file of 3 kB can ask for any amount of memory. Here its sections are decoded as far as they say how much there is: the
table of contents, the six sections that it lists, the tree of paths, and the sizes of the values that fields point to.
The format is that of OpenUSD (pxr/usd/sdf/crateFile.h), from version 0.4.0 on, the first that USD still reads.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.usd.opening.crate_packing import LZ4_PER_BYTE, Cursor, DamagedError
from mrm_mtlx.formats.usd.opening.crate_values import refuse_oversized

if TYPE_CHECKING:
    from mrm_mtlx.formats.usd.opening.crate_packing import Words

# Identifier, version, offset of the table of contents; a section of it: name, start and size.
_BOOTSTRAP, _SECTION = struct.Struct("<8s3B5xq64x"), struct.Struct("<16sqq")
_OLDEST = (0, 4, 0)
# Most sections of a table of contents; USD writes six.
_MOST_SECTIONS = 64
# What an entry of the tree of paths says that has neither child nor sibling.
_LEAF = -2


def refuse_damaged(stream: BinaryIO, name: str, place: str) -> None:
    """Refuse a crate that claims more than it has.

    Raises
    ------
    ReadError
        With the section that does.
    """
    stream.seek(0)
    try:
        _Crate(stream.read()).check()
    except DamagedError as error:
        raise ReadError(rules.READ_FORMAT.at(place, f"{name}: the crate is damaged: {error}")) from None


class _Crate:
    """A crate's bytes, and what its sections hold."""

    def __init__(self, data: bytes) -> None:
        self._data = memoryview(data)
        self._version = (0, 0, 0)
        self._sections: dict[str, memoryview] = {}

    def check(self) -> None:
        """Look at all sections.

        Raises
        ------
        DamagedError
            If one claims what it cannot hold.
        """
        if not self._read_contents():
            return  # too old: USD refuses it with that reason
        tokens = self._tokens()
        self._strings()
        fields = self._fields()
        sets = self._sets()
        paths = self._paths(tokens)
        self._specs(paths, sets)
        if fields is not None:
            refuse_oversized(self._data, fields.tolist(), self._version)

    def _read_contents(self) -> bool:
        """Find the sections; False for a version that USD does not read."""
        if len(self._data) < _BOOTSTRAP.size:
            msg = f"it has {len(self._data)} bytes, fewer than its header"
            raise DamagedError(msg)
        _, *version, contents = _BOOTSTRAP.unpack_from(self._data)
        self._version = tuple(version)
        if self._version < _OLDEST:
            return False
        if not 0 <= contents <= len(self._data):
            msg = f"its table of contents begins at {contents}, and it has {len(self._data)} bytes"
            raise DamagedError(msg)
        cursor = Cursor(self._data, "the table of contents", contents)
        count = cursor.number()
        if count > _MOST_SECTIONS:
            msg = f"the table of contents claims {count} sections"
            raise DamagedError(msg)
        for _ in range(count):
            label, start, size = _SECTION.unpack(cursor.take(_SECTION.size))
            name = label.rstrip(b"\0").decode("ascii", "replace")
            if start < 0 or size < 0 or start + size > len(self._data):
                msg = f"section {name} claims {size} bytes from {start} on, and the file has {len(self._data)}"
                raise DamagedError(msg)
            self._sections.setdefault(name, self._data[start : start + size])
        return True

    def _section(self, name: str) -> Cursor | None:
        return Cursor(self._sections[name], f"section {name}") if name in self._sections else None

    def _tokens(self) -> int:
        cursor = self._section("TOKENS")
        if cursor is None:
            return 0
        count, size = cursor.number(), cursor.number()
        packed = cursor.take(cursor.number())
        if size > LZ4_PER_BYTE * len(packed) or count > size:
            msg = f"section TOKENS claims {count} tokens of {size} bytes, packed in {len(packed)}"
            raise DamagedError(msg)
        return count

    def _strings(self) -> None:
        cursor = self._section("STRINGS")
        if cursor is not None:
            cursor.take(4 * cursor.number())

    def _fields(self) -> Words | None:
        cursor = self._section("FIELDS")
        if cursor is None:
            return None
        count = cursor.count()
        cursor.integers(count)
        values = cursor.packed(8 * count)
        if len(values) != 8 * count:
            msg = f"section FIELDS claims {count} fields, and has values of {len(values) // 8}"
            raise DamagedError(msg)
        return np.frombuffer(values, "<u8")

    def _sets(self) -> int:
        cursor = self._section("FIELDSETS")
        if cursor is None:
            return 0
        count = cursor.count()
        cursor.integers(count)
        return count

    def _paths(self, tokens: int) -> int:
        cursor = self._section("PATHS")
        if cursor is None:
            return 0
        count = cursor.count()
        encoded = cursor.count()
        indices, elements, jumps = (cursor.integers(encoded) for _ in range(3))
        if encoded > count or np.any((indices < 0) | (indices >= count)) or len(np.unique(indices)) < encoded:
            msg = f"section PATHS names {encoded} paths, not each once, of {count}"
            raise DamagedError(msg)
        if np.any(np.abs(elements) >= max(tokens, 1)):
            msg = f"section PATHS uses tokens beyond the {tokens} that there are"
            raise DamagedError(msg)
        _refuse_no_tree(jumps)
        return count

    def _specs(self, paths: int, sets: int) -> None:
        cursor = self._section("SPECS")
        if cursor is None:
            return
        count = cursor.count()
        of, fields, _ = (cursor.integers(count) for _ in range(3))
        if np.any((of < 0) | (of >= paths)) or np.any((fields < 0) | (fields >= sets)):
            msg = f"section SPECS uses more than the {paths} paths and {sets} sets of fields that there are"
            raise DamagedError(msg)


def _refuse_no_tree(jumps: Words) -> None:
    """Refuse paths that are no tree in depth-first order: USD would follow branches that meet again and again.

    An entry has a child (the next entry), a sibling, both (the sibling is `jump` entries on), or neither.
    """
    siblings: list[int] = []
    last = len(jumps) - 1
    for number, jump in enumerate(jumps.tolist()):
        if jump > 0:
            siblings.append(number + jump)
        follows = jump != _LEAF or bool(siblings)
        if jump < _LEAF or (jump == _LEAF and siblings and siblings.pop() != number + 1) or follows != (number < last):
            msg = f"section PATHS is no tree: entry {number} of {last + 1} leads nowhere, or where another does"
            raise DamagedError(msg)
