"""Mutations of USD: text, crate files and packages."""

from __future__ import annotations

import io
import re
import struct
import zipfile
from typing import TYPE_CHECKING

from tools.fuzz import odd, raw

if TYPE_CHECKING:
    from random import Random

_TOKENS = re.compile(rb'@[^@\n]*@|<[^>\n]*>|"[^"\n]*"|[A-Za-z_][\w:.]*|[-+]?[\d.]+(?:e[-+]?\d+)?|\S')
_WORDS = (
    "def", "over", "class", "Material", "Shader", "token", "asset", "float", "color3f", "int", "string", "rel",
    "uniform", "custom", "references", "payload", "inherits", "specializes", "variants", "variantSets", "subLayers",
    "instanceable = true", "None", "1e999", "nan", "inf", "-1", "()", "[]", "{}", "(", ")", "[", "]", "{", "}", "=",
    ".connect", ".timeSamples", "outputs:surface", "outputs:mtlx:surface", "outputs:out", "inputs:file", "info:id",
    "info:mtlx:version", '"ND_standard_surface_surfaceshader"', '"UsdPreviewSurface"', '"UsdUVTexture"',
    '"ND_image_color3"', "@i.png@", "@./i.usda@", "@part.usda@", "@p.usdz@", "@p.usdz[s.usda]@",
    "@part.usda:SDF_FORMAT_ARGS:a=b@", "@../outside/secret.usda@", "@@@x@@@", "@/etc/hostname@", "@pipe.usda@",
    "@anon:0x1@", "@`${X}`@", "@i.<UDIM>.png@", "@part.mtlx@", "</a>", "</M>", "<../..>", "</>", "<>",
    "offset = 1e300", "clips = {}", "apiSchemas", "doc", "1" * 300, '"' + "x" * 300 + '"', "'''", '"""', "#", "//",
    "/*", "*/", "\\", "\0", "\u202e", "prepend", "delete", "reorder nameChildren", "permission = private", "kind",
    "hidden",
)  # fmt: skip


def text(data: bytes, rng: Random, other: bytes) -> bytes:
    """USD text with one to four changes."""
    for _ in range(rng.choice((1, 1, 2, 4))):
        kind = rng.randrange(6)
        if kind == 0:
            data = raw.mutated(data, rng, other)
        elif kind < 4:
            data = _token(data, rng)
        else:
            data = _lines(data, rng, other)
    return data


def _token(data: bytes, rng: Random) -> bytes:
    """Another token somewhere: mostly one of the same sort, so that what is read is not at an end there."""
    found = list(_TOKENS.finditer(data))
    if not found:
        return data
    chosen = rng.choice(found)
    if rng.random() < 0.15:
        new = rng.choice(_WORDS).encode()
    else:
        sort = _sort(chosen.group())
        alike = [match.group() for match in found if _sort(match.group()) == sort]
        new = rng.choice((*alike, *_ODD.get(sort, ())))
    return data[: chosen.start()] + new + data[chosen.end() :]


def _sort(token: bytes) -> str:
    """What a token is: "@", "<", a quotation mark, "0" for a number, "a" for a name, or itself."""
    first = chr(token[0])
    if first in "+-.0123456789":
        return "0"
    return "a" if first.isalpha() or first == "_" else first


_ODD: dict[str, list[bytes]] = {
    "@": [f"@{name}@".encode() for name in odd.FILES] + [w.encode() for w in _WORDS if w.startswith("@")],
    "<": [w.encode() for w in _WORDS if w.startswith("<")],
    '"': [f'"{name}"'.encode() for name in (*odd.NAMES, *odd.COLOR_SPACES, *odd.FILES)],
    "0": [
        w.encode() for w in ("0", "-1", "2", "nan", "inf", "-inf", "1e308", "1e-320", "1e999", "99999999999999999999")
    ],
    "a": [w.encode() for w in (*odd.TYPES, *_WORDS) if w.isidentifier()],
}


def _lines(data: bytes, rng: Random, other: bytes) -> bytes:
    lines = data.split(b"\n")
    a, b = sorted(rng.randrange(len(lines) + 1) for _ in range(2))
    block = lines[a : min(b, a + 60)]
    kind = rng.randrange(5)
    if kind == 0:
        del lines[a : a + rng.choice((1, 1, len(block)))]
    elif kind == 1:
        lines[b:b] = block
    elif kind == 2:
        times = rng.choice((2, 10, 400))
        lines[a:a] = [b'def Scope "n" {'] * times + [b"}"] * rng.choice((times, times, 0))
    elif kind == 3:
        theirs = other.split(b"\n")
        start = rng.randrange(len(theirs))
        lines[a:a] = theirs[start : start + rng.choice((1, 5, 40))]
    else:
        lines[a : a + len(block)] = block[::-1]
    return b"\n".join(lines)


def crate(data: bytes, rng: Random, other: bytes) -> bytes:
    """A crate file with one to three changes, to its table of contents and its numbers more than elsewhere."""
    changed = data
    for _ in range(rng.choice((1, 1, 2, 3))):
        kind = rng.random()
        if len(changed) > 96 and kind < 0.25:
            changed = _section(changed, rng)
        elif kind < 0.8:
            changed = raw.overwritten(changed, rng)
        else:
            changed = raw.mutated(changed, rng, other)
    return changed


def _section(data: bytes, rng: Random) -> bytes:
    """Another number at the beginning of the file, of the table of contents, or of a section."""
    changed = bytearray(data)
    (table,) = struct.unpack_from("<Q", changed, 16)
    if not 88 <= table <= len(changed) - 8 - 32 or rng.random() < 0.1:
        where = rng.randrange(0, 88, 8)
    else:
        (count,) = struct.unpack_from("<Q", changed, table)
        section = table + 8 + 32 * rng.randrange(max(min(count, 8), 1))
        if section + 32 > len(changed):
            section = table
        where = rng.choice((table, section + 16, section + 24))
        if rng.random() < 0.7:  # in the section itself: counts and sizes stand first
            (start,) = struct.unpack_from("<Q", changed, section + 16)
            where = start + rng.choice((0, 0, 8, 8, 16, 24, rng.randrange(256)))
    if where + 8 > len(changed):
        return raw.mutated(data, rng)
    (old,) = struct.unpack_from("<Q", changed, where)
    new = rng.choice(
        (0, 1, old + 1, old - 1, old * 2, old << 16, 1 << 31, 1 << 40, 1 << 63, len(data), rng.getrandbits(24))
    )
    struct.pack_into("<Q", changed, where, new & (1 << 64) - 1)
    return bytes(changed)


def package(data: bytes, rng: Random, other: bytes) -> bytes:
    """A package with changed bytes, or made anew of changed entries."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            entries = [(name, archive.read(name)) for name in archive.namelist()]
    except Exception:  # what another mutation broke
        return raw.mutated(data, rng, other)
    if not entries or rng.random() < 0.4:
        return raw.mutated(data, rng, other)
    chosen = rng.randrange(len(entries))
    name, content = entries[chosen]
    kind = rng.randrange(5)
    if kind == 0:
        entries[chosen] = rng.choice(odd.FILES) or "e", content
    elif kind == 1:
        entries.append((name, content))
    elif kind == 2:
        entries.insert(0, entries.pop(chosen))
    elif kind == 3:
        mutate = crate if content.startswith(b"PXR-USDC") else text if content.startswith(b"#usda") else raw.mutated
        entries[chosen] = name, mutate(content, rng, other)
    else:
        entries.append((rng.choice(("../x.png", "/x.png", "x.usda", "a/" * 40 + "x", "x.mtlx", "pipe.png")), other))
    method = rng.choice((*[zipfile.ZIP_STORED] * 9, zipfile.ZIP_DEFLATED, zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2))
    return packed(entries, method)


def packed(entries: list[tuple[str, bytes]], method: int) -> bytes:
    """A package whose entries begin at multiples of 64 bytes, as USD wants them."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as archive:
        for name, content in entries:
            info = zipfile.ZipInfo(name)
            info.compress_type = method
            offset = out.tell() + 30 + len(name.encode()) + 4
            info.extra = struct.pack("<HH", 0x1986, -offset % 64) + b"\0" * (-offset % 64)
            archive.writestr(info, content)
    return out.getvalue()
