"""A glTF asset in the making: materials, images and a sphere for each material, as .gltf with files or as .glb."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import quote

import numpy as np

from mrm_mtlx.system.versions import __version__

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from mrm_mtlx.system.writing import FileSet

# Steps of the sphere around and along: 1,500 triangles, which look round at the size of a thumbnail.
_AROUND, _ALONG = 48, 24
# Spheres have radius 1; this far apart, in rows of so many.
_DISTANCE, _ROW = 2.5, 8
# OpenGL's numbers: component types and the use of a buffer.
_FLOAT, _USHORT, _VERTICES, _INDICES = 5126, 5123, 34962, 34963


class ImageFile(NamedTuple):
    """An image of an asset: its name, its bytes, and where it lies already beside the asset, "" for nowhere."""

    name: str
    content: bytes
    uri: str = ""

    @property
    def media_type(self) -> str:
        """As glTF calls it."""
        return "image/png" if self.content.startswith(b"\x89PNG") else "image/jpeg"


@dataclass
class Asset:
    """An asset that is to be written; indices are those of glTF."""

    materials: list[dict[str, Any]] = field(default_factory=list)
    textures: list[dict[str, Any]] = field(default_factory=list)
    samplers: list[dict[str, Any]] = field(default_factory=list)
    images: list[ImageFile] = field(default_factory=list)

    def texture(self, image: ImageFile, sampler: dict[str, Any]) -> int:
        """Index of a texture, which is there once."""
        texture = {"sampler": _index(self.samplers, sampler), "source": self._image(image)}
        return _index(self.textures, texture)

    def _image(self, image: ImageFile) -> int:
        for index, known in enumerate(self.images):
            if known.content == image.content and known.uri == image.uri:
                return index
        stem, _, suffix = image.name.rpartition(".")
        names, number = {known.name for known in self.images}, 2
        while image.name in names:
            image, number = image._replace(name=f"{stem}_{number}.{suffix}"), number + 1
        return _index(self.images, image)

    def save(self, path: Path, files: FileSet, *, beside: bool = True) -> None:
        """Write the asset into a set of files.

        Parameters
        ----------
        path
            Its name ends in .gltf or .glb. Images and geometry of a .gltf go into files of their own: those of images
            into a folder that has the asset's stem as name.
        files
            Where they are written to.
        beside
            Whether images stay where they are if they lie beside the asset already.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        views = Views()
        data = self._data(views)
        if path.suffix.lower() == ".glb":
            data["images"] = [
                {"name": image.name, "mimeType": image.media_type, "bufferView": views.add(image.content)}
                for image in self.images
            ]
            data |= views.data()
            files.named(path).write_bytes(_packed(_pruned(data), views.content))
            return
        data["images"] = []
        for image in self.images:
            stays = image.uri and beside
            uri = image.uri if stays else f"{path.stem}/{image.name}"
            data["images"].append({"name": image.name, "uri": quote(uri)})
            if not stays:
                files.beside(path.parent / uri).write_bytes(image.content)
        data |= views.data(quote(f"{path.stem}.bin"))
        files.beside(path.with_suffix(".bin")).write_bytes(views.content)
        text = json.dumps(_pruned(data), indent=2, ensure_ascii=False) + "\n"
        files.named(path).write_text(text, encoding="utf-8")

    def _data(self, views: Views) -> dict[str, Any]:
        count = len(self.materials)
        attributes, indices, accessors = _accessors(views)
        used = sorted(set(_extensions(self.materials)))
        meshes = [
            {"primitives": [{"attributes": _used(attributes, m), "indices": indices, "mode": 4, "material": index}]}
            for index, m in enumerate(self.materials)
        ]
        nodes = [
            {
                "name": material["name"],
                "mesh": index,
                "translation": [_DISTANCE * (index % _ROW), 0.0 - _DISTANCE * (index // _ROW), 0.0],
            }
            for index, material in enumerate(self.materials)
        ]
        return {
            "asset": {"version": "2.0", "generator": f"mrm-mtlx {__version__}"},
            "extensionsUsed": used,
            "scene": 0,
            "scenes": [{"nodes": list(range(count))}],
            "nodes": nodes,
            "meshes": meshes,
            "accessors": accessors,
            "materials": self.materials,
            "textures": self.textures,
            "samplers": self.samplers,
        }


class Views:
    """Buffer views in the one buffer."""

    def __init__(self) -> None:
        self.content = b""
        self._views: list[dict[str, Any]] = []

    def add(self, content: bytes, **more: Any) -> int:
        """Index of a view with this content."""
        self.content += bytes(-len(self.content) % 4)
        self._views.append({"buffer": 0, "byteOffset": len(self.content), "byteLength": len(content), **more})
        self.content += content
        return len(self._views) - 1

    def data(self, uri: str = "") -> dict[str, Any]:
        """The arrays of the asset."""
        self.content += bytes(-len(self.content) % 4)
        buffer = {"byteLength": len(self.content), **({"uri": uri} if uri else {})}
        return {"bufferViews": self._views, "buffers": [buffer]}


def _index(elements: list[Any], element: Any) -> int:
    """The index of an element, which is appended if it is not there."""
    if element not in elements:
        elements.append(element)
    return elements.index(element)


def _pruned(data: dict[str, Any]) -> dict[str, Any]:
    """Without empty arrays, which glTF does not allow."""
    return {name: value for name, value in data.items() if value != []}


def _extensions(value: Any) -> list[str]:
    """Names of the extensions that are used somewhere in a value."""
    if isinstance(value, list):
        return [name for element in value for name in _extensions(element)]
    if not isinstance(value, dict):
        return []
    return [*value.get("extensions", {}), *(name for element in value.values() for name in _extensions(element))]


def _used(attributes: dict[str, int], material: dict[str, Any]) -> dict[str, int]:
    """The attributes that a material wants: tangents where it turns about them, and as many sets of coordinates."""
    wanted = dict(attributes)
    turning = ("normalTexture", "clearcoatNormalTexture", "KHR_materials_anisotropy")
    if not any(_values(name, material) for name in turning):
        del wanted["TANGENT"]
    sets = max(_values("texCoord", material), default=0)
    return wanted | {f"TEXCOORD_{k}": attributes["TEXCOORD_0"] for k in range(sets + 1)}


def _values(name: str, value: Any) -> list[Any]:
    """The values of a name anywhere in a value."""
    if not isinstance(value, dict):
        return []
    found = [value[name]] if name in value else []
    return [*found, *(hit for child in value.values() for hit in _values(name, child))]


def _packed(data: dict[str, Any], content: bytes) -> bytes:
    """A .glb with a chunk for each."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (-len(text) % 4)
    length = 12 + 8 + len(text) + 8 + len(content)
    head = struct.pack("<4sII", b"glTF", 2, length)
    return head + struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(content), b"BIN\0") + content


def _accessors(views: Views) -> tuple[dict[str, int], int, list[dict[str, Any]]]:
    """Accessors of the sphere: attributes, the indices', and all of them."""
    vertices, indices = _sphere()
    attributes: dict[str, int] = {}
    accessors: list[dict[str, Any]] = []
    for name, values in vertices.items():
        content = np.ascontiguousarray(values, dtype="<f4")
        accessor: dict[str, Any] = {
            "bufferView": views.add(content.tobytes(), target=_VERTICES),
            "componentType": _FLOAT,
            "count": len(content),
            "type": f"VEC{content.shape[1]}",
        }
        if name == "POSITION":
            accessor |= {"min": content.min(axis=0).tolist(), "max": content.max(axis=0).tolist()}
        attributes[name] = len(accessors)
        accessors.append(accessor)
    view = views.add(np.ascontiguousarray(indices, dtype="<u2").tobytes(), target=_INDICES)
    accessors.append({"bufferView": view, "componentType": _USHORT, "count": indices.size, "type": "SCALAR"})
    return attributes, len(accessors) - 1, accessors


@cache
def _sphere() -> tuple[dict[str, NDArray[np.float64]], NDArray[np.integer]]:
    """Vertices and triangles of a sphere: u runs eastward, v southward, so that an image stands upright on it."""
    u, v = (a.ravel() for a in np.meshgrid(np.linspace(0.0, 1.0, _AROUND + 1), np.linspace(0.0, 1.0, _ALONG + 1)))
    longitude, colatitude = (u - 0.5) * 2.0 * np.pi, v * np.pi
    east = np.stack([np.cos(longitude), np.zeros_like(u), -np.sin(longitude)], axis=1)
    sine = np.sin(colatitude)
    place = np.stack([sine * np.sin(longitude), np.cos(colatitude), sine * np.cos(longitude)], axis=1)
    vertices = {
        "POSITION": place,
        "NORMAL": place,
        "TANGENT": np.concatenate([east, np.ones((len(u), 1))], axis=1),
        "TEXCOORD_0": np.stack([u, v], axis=1),
    }
    corner = np.arange(u.size).reshape(_ALONG + 1, _AROUND + 1)
    upper, right, lower, far = (a.ravel() for a in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, :-1], corner[1:, 1:]))
    # A row of triangles at each pole has no area, and is left out.
    north = np.stack([lower, far, right], axis=1)[: _AROUND * _ALONG]
    south = np.stack([upper, lower, right], axis=1)[_AROUND:]
    triangles = np.concatenate([north[:-_AROUND], south])
    return vertices, triangles
