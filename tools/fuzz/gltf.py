"""Mutations of glTF: its JSON, the chunks of .glb, and data URIs."""

from __future__ import annotations

import base64
import copy
import json
import struct
from typing import TYPE_CHECKING, Any

from tools.fuzz import odd, raw

if TYPE_CHECKING:
    from collections.abc import Iterator
    from random import Random

_KEYS = (
    "extensions", "extras", "materials", "textures", "images", "samplers", "buffers", "bufferViews", "accessors",
    "uri", "name", "mimeType", "byteLength", "byteOffset", "buffer", "bufferView", "index", "texCoord", "scale",
    "strength", "source", "sampler", "pbrMetallicRoughness", "baseColorTexture", "baseColorFactor", "normalTexture",
    "emissiveFactor", "alphaMode", "alphaCutoff", "asset", "version", "minVersion", "extensionsUsed",
    "extensionsRequired", "KHR_texture_transform", "KHR_materials_unlit", "KHR_materials_clearcoat",
    "KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_ior", "KHR_materials_sheen",
    "KHR_materials_specular", "KHR_materials_iridescence", "KHR_materials_anisotropy", "KHR_materials_dispersion",
    "KHR_materials_emissive_strength", "KHR_materials_retroreflection", "KHR_materials_pbrSpecularGlossiness",
    "EXT_texture_webp", "EXT_meshopt_compression", "__proto__", "", "meshes", "primitives", "attributes", "material",
    "nodes", "scenes", "scene",
)  # fmt: skip
_VALUES: tuple[Any, ...] = (
    None, True, False, 0, 1, -1, 2, 1e308, -1e308, 1e-320, 2**31, 2**53, 2**64, 0.5, 1.5, "", "x", "2.0", "MASK", [],
    {}, [[]], [1], [0.5, 0.5, 0.5], [1, 1, 1, 1], ["x"], {"index": 0}, {"index": 99}, {"index": -1}, {"index": "0"},
    {"index": 0, "texCoord": 1},
    {"extensions": {"KHR_texture_transform": {"offset": [1, 1], "rotation": 1e9, "scale": [0, 0]}}}, "data:,",
    "data:;base64,@@@", "data:image/png;base64,iVBORw0KGgo=", "data:application/octet-stream;base64,AAAA",
    float("nan"), float("inf"),
)  # fmt: skip


def text(data: bytes, rng: Random, other: bytes) -> bytes:
    """A .gltf with one to four changes."""
    try:
        asset = json.loads(data)
    except ValueError:
        return raw.mutated(data, rng, other)
    if rng.random() < 0.12:
        return raw.mutated(data, rng, other)
    for _ in range(rng.choice((1, 1, 2, 4))):
        _change(asset, rng)
    return json.dumps(asset).encode()


def binary(data: bytes, rng: Random, other: bytes) -> bytes:
    """A .glb with changed bytes, a changed chunk or changed JSON in it."""
    chunks = list(_chunks(data))
    if not chunks or rng.random() < 0.25:
        return raw.mutated(data, rng, other)
    kind = rng.randrange(6)
    if kind < 3:
        chunks[0] = chunks[0][0], text(chunks[0][1], rng, other)
    elif kind == 3:
        which = rng.randrange(len(chunks))
        chunks.insert(rng.randrange(len(chunks) + 1), chunks[which])
    elif kind == 4:
        which = rng.randrange(len(chunks))
        chunks[which] = rng.choice((b"JSON", b"BIN\0", b"XXXX", b"\0\0\0\0")), raw.mutated(chunks[which][1], rng, other)
    else:
        chunks.pop()
    whole = joined(chunks)
    if kind > 2 and rng.random() < 0.3:
        return whole[:8] + struct.pack("<I", rng.choice((0, 2**31, 2**32 - 1))) + whole[12:]
    return whole


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    at = 12
    while at + 8 <= len(data):
        (length,) = struct.unpack_from("<I", data, at)
        yield data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        at += 8 + length


def _change(asset: Any, rng: Random) -> None:
    places = list(_places(asset))
    if not places:
        return
    holder, key = rng.choice(places)
    kind = rng.randrange(9)
    if kind < 3:
        holder[key] = _odd(holder[key], rng)
    elif kind == 3:
        del holder[key]
    elif kind == 4:
        there, other = rng.choice(places)
        holder[key], there[other] = copy.deepcopy(there[other]), copy.deepcopy(holder[key])
    elif kind == 5 and isinstance(holder, dict):
        holder[rng.choice(_KEYS)] = copy.deepcopy(rng.choice(_VALUES))
    elif kind == 6:
        there, other = rng.choice(places)
        _add(there[other], copy.deepcopy(holder[key]), rng)
    elif kind == 7:
        _nest(holder, key, rng)
    else:
        _extend(asset, rng)


def _places(value: Any) -> Iterator[tuple[Any, Any]]:
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in list(items)[:400]:
        yield value, key
        yield from _places(inner)


def _odd(value: Any, rng: Random) -> Any:
    if isinstance(value, str) and rng.random() < 0.6:
        if value.startswith("data:"):
            head, _, body = value.partition(",")
            return f"{head},{raw.mutated(body.encode(), rng).decode('latin-1')}"
        return rng.choice((*odd.FILES, *odd.NAMES))
    return copy.deepcopy(rng.choice(_VALUES))


def _add(holder: Any, value: Any, rng: Random) -> None:
    if isinstance(holder, list):
        holder.extend([value] * rng.choice((1, 1, 3, 100)))
    elif isinstance(holder, dict):
        holder[rng.choice(_KEYS)] = value


def _nest(holder: Any, key: Any, rng: Random) -> None:
    inner = holder[key]
    if len(json.dumps(inner)) > 20_000:
        return
    for _ in range(rng.choice((1, 3, 90, 400))):
        inner = {"extras": inner} if rng.random() < 0.5 else [inner]
    holder[key] = inner


def _extend(asset: Any, rng: Random) -> None:
    """An extension of the first material, with textures and numbers at random."""
    materials = asset.get("materials") if isinstance(asset, dict) else None
    if not (isinstance(materials, list) and materials and isinstance(materials[0], dict)):
        return
    name = rng.choice([key for key in _KEYS if key.startswith("KHR_materials")])
    content = {rng.choice(_KEYS): copy.deepcopy(rng.choice(_VALUES)) for _ in range(3)}
    extensions = materials[0].setdefault("extensions", {})
    if isinstance(extensions, dict):
        extensions[name] = content
    asset["extensionsUsed"] = [name, "KHR_texture_transform"]


def embedded(image: bytes, mime: str) -> str:
    """A data URI."""
    return f"data:{mime};base64,{base64.b64encode(image).decode()}"


def assets(picture: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Assets with much in them, as .gltf with data URIs and as .glb with one buffer."""
    transform = {"KHR_texture_transform": {"offset": [0.1, 0.2], "rotation": 0.3, "scale": [2, 2]}}
    extensions: dict[str, Any] = {
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatTexture": {"index": 1}},
        "KHR_materials_transmission": {"transmissionFactor": 0.5},
        "KHR_materials_volume": {"thicknessFactor": 0.1, "attenuationColor": [1, 0.5, 0.5], "attenuationDistance": 1},
        "KHR_materials_ior": {"ior": 1.4},
        "KHR_materials_sheen": {"sheenColorFactor": [0.1, 0.2, 0.3], "sheenRoughnessFactor": 0.4},
        "KHR_materials_specular": {"specularFactor": 0.7, "specularColorTexture": {"index": 0}},
        "KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceThicknessMaximum": 300},
        "KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyTexture": {"index": 0}},
        "KHR_materials_dispersion": {"dispersion": 0.2},
        "KHR_materials_emissive_strength": {"emissiveStrength": 4},
    }
    material = {
        "name": "paint",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.9, 0.5, 0.1, 0.8],
            "metallicFactor": 0.2,
            "roughnessFactor": 0.6,
            "baseColorTexture": {"index": 0, "texCoord": 0, "extensions": transform},
            "metallicRoughnessTexture": {"index": 1},
        },
        "normalTexture": {"index": 0, "scale": 0.5},
        "occlusionTexture": {"index": 1, "strength": 0.7},
        "emissiveTexture": {"index": 0},
        "emissiveFactor": [0.1, 0.1, 0.1],
        "alphaMode": "MASK",
        "alphaCutoff": 0.4,
        "doubleSided": True,
        "extensions": extensions,
    }
    for used in ([material], [{**material, "extensions": {"KHR_materials_unlit": {}}}, {"name": "bare"}]):
        asset: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "extensionsUsed": [*extensions, "KHR_texture_transform", "KHR_materials_unlit"],
            "materials": used,
            "textures": [{"source": 0, "sampler": 0}, {"source": 1}],
            "samplers": [{"magFilter": 9728, "minFilter": 9987, "wrapS": 33648, "wrapT": 33071}],
            "images": [{"uri": embedded(picture, "image/png")}, {"uri": "parts/i.png"}],
        }
        stored = copy.deepcopy(asset)
        stored["buffers"] = [{"byteLength": len(picture)}]
        stored["bufferViews"] = [{"buffer": 0, "byteOffset": 0, "byteLength": len(picture)}]
        stored["images"][0] = {"bufferView": 0, "mimeType": "image/png"}
        yield json.dumps(asset).encode(), joined([(b"JSON", json.dumps(stored).encode()), (b"BIN\0", picture)])


def joined(chunks: list[tuple[bytes, bytes]]) -> bytes:
    """A .glb of chunks, each filled up to a multiple of four bytes."""
    filled = [(tag, body + (b" " if tag == b"JSON" else b"\0") * (-len(body) % 4)) for tag, body in chunks]
    content = b"".join(struct.pack("<I", len(body)) + tag + body for tag, body in filled)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(content)) + content
