"""Mutations of bytes, whatever they mean."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from random import Random

_WORDS = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x7FFFFFFFFFFFFFFF)
_TEXT = (
    b"\0", b"\xff\xfe", b"\xc2\x85", b"\xe2\x80\xa8", b"\xf4\x90\x80\x80", b"\r", b"\t", b"<", b">", b'"', b"&",
    b"{", b"}", b"[", b"]", b"@", b"#",
)  # fmt: skip


def mutated(data: bytes, rng: Random, other: bytes = b"") -> bytes:
    """Data with one change; `other` is what may be spliced in."""
    changed = bytearray(data)
    where = rng.randrange(len(changed) + 1)
    length = min(1 << rng.randrange(9), len(changed) - where)
    kind = rng.randrange(9)
    if kind == 0 and where < len(changed):
        changed[where] ^= 1 << rng.randrange(8)
    elif kind == 1 and where < len(changed):
        changed[where] = rng.choice((0, 1, 9, 10, 32, 34, 60, 127, 128, 255, rng.randrange(256)))
    elif kind == 2:
        del changed[where : where + length]
    elif kind == 3:
        changed[where:where] = changed[where : where + length] * rng.choice((1, 1, 2, 50))
    elif kind == 4:
        changed[where:where] = rng.choice(_TEXT)
    elif kind == 5:
        _set_word(changed, where, rng)
    elif kind == 6:
        del changed[where:]
    elif kind == 7 and other:
        start = rng.randrange(len(other))
        changed[where : where + length] = other[start : start + length]
    else:
        a, b = sorted((where, rng.randrange(len(changed) + 1)))
        changed[a:b] = changed[a:b][::-1] if rng.random() < 0.2 else bytes(rng.randbytes(min(b - a, 64)))
    return bytes(changed)


def overwritten(data: bytes, rng: Random) -> bytes:
    """Data with some bits, bytes or numbers changed, and of the same length: offsets stay right."""
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 8)) if changed else 0):
        where, kind = rng.randrange(len(changed)), rng.randrange(3)
        if kind == 0:
            changed[where] ^= 1 << rng.randrange(8)
        elif kind == 1:
            changed[where] = rng.randrange(256)
        else:
            _set_word(changed, where, rng)
    return bytes(changed)


def _set_word(data: bytearray, where: int, rng: Random) -> None:
    """Write a number of a size at an aligned place, as counts and offsets of binary formats have them."""
    size = rng.choice((1, 2, 4, 8))
    where -= where % size
    value = rng.choice((*_WORDS, len(data), rng.getrandbits(32))) & (1 << (8 * size)) - 1
    packed = struct.pack("<Q", value)[:size]
    if where + size <= len(data):
        data[where : where + size] = packed if rng.random() < 0.8 else packed[::-1]
