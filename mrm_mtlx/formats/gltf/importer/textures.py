"""Textures of an asset: the image file of each, and how it is looked up."""

from __future__ import annotations

import os
import re
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import unquote

from mrm_mtlx.formats.gltf.container import (
    INVALID,
    LOST,
    MAXIMUM_IMAGE_BYTES,
    NO_FILE,
    TOO_LARGE,
    GltfError,
    decoded,
    is_data,
    media_type,
    read_range,
)
from mrm_mtlx.formats.gltf.image_kinds import kind_of
from mrm_mtlx.formats.gltf.properties import FILTERS, TRANSFORM, WRAPS
from mrm_mtlx.formats.json_text import pointer
from mrm_mtlx.system.text import shown

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.formats.gltf.container import Container

# Bytes that are unpacked from one asset.
MAXIMUM_UNPACKED_BYTES = 512 * 2**20
_WEBP = "EXT_texture_webp"
# A name that means the same to MaterialX, which replaces tokens in < > and { }, and to every file system.
_PLAIN_NAME = re.compile(r"[\w .,()+=@~/-]+")


class Texture(NamedTuple):
    """A use of a texture.

    Attributes
    ----------
    file
        Name of its image, relative to the document's folder.
    number
        Index of the texture.
    modes
        Address modes along u and v, as MaterialX names them.
    filter
        Filter type, as MaterialX names it.
    texcoord
        Set of texture coordinates.
    offset, rotation, scale
        Of KHR_texture_transform; the rotation in radians.
    place, image_place
        Pointers to the use, and to the image.
    """

    file: str
    number: int
    modes: tuple[str, str]
    filter: str
    texcoord: int
    offset: tuple[float, float]
    rotation: float
    scale: tuple[float, float]
    place: str
    image_place: str


class Textures:
    """Textures of an asset, by their use; what is wrong with one is said to `report`, once.

    Images that lie inside of the asset are written to `scratch`. If there are any, or one has a name that MaterialX
    does not take as it stands, all are: `packed` says so beforehand.
    """

    def __init__(self, container: Container, scratch: Path, report: Callable[[Finding], None]) -> None:
        self._container, self._scratch, self._report = container, scratch, report
        self._files: dict[int, str | None] = {}
        self._unpacked = 0
        self.packed = any(_is_inside(image) for image in container.data.get("images", []))

    def use(self, info: dict[str, Any], place: str) -> Texture | None:
        """The texture that a textureInfo means; None if it cannot be had, which is reported."""
        try:
            return self._use(info, place)
        except GltfError as error:
            self._report(error.finding)
            return None

    def _use(self, info: dict[str, Any], place: str) -> Texture | None:
        index = int(info["index"])
        texture = self._container.element("textures", index, f"{place}/index")
        texture_place = pointer("textures", index)
        source = self._source(texture, texture_place)
        sampler: dict[str, Any] = {}
        if "sampler" in texture:
            sampler = self._container.element("samplers", int(texture["sampler"]), f"{texture_place}/sampler")
            self._check_filters(sampler, pointer("samplers", int(texture["sampler"])))
        if source not in self._files:
            self._files[source] = None
            self._files[source] = self._file(source, f"{texture_place}/source")
        file = self._files[source]
        if file is None:
            return None
        transform = info.get("extensions", {}).get(TRANSFORM, {})
        return Texture(
            file,
            index,
            (WRAPS[sampler.get("wrapS", 10497)], WRAPS[sampler.get("wrapT", 10497)]),
            FILTERS[sampler.get("magFilter", 9729)],
            int(transform.get("texCoord", info.get("texCoord", 0))),
            tuple(transform.get("offset", (0.0, 0.0))),
            float(transform.get("rotation", 0.0)),
            tuple(transform.get("scale", (1.0, 1.0))),
            place,
            pointer("images", source),
        )

    def _source(self, texture: dict[str, Any], place: str) -> int:
        """Index of a texture's image: glTF's own, or else WebP's."""
        extensions = texture.get("extensions", {})
        other = extensions.get(_WEBP, {}).get("source")
        for name in sorted(set(extensions) - {_WEBP}):
            self._report(LOST.at(f"{place}/extensions/{name}", f"the extension {shown(name)} is not read"))
        if "source" in texture:
            return int(texture["source"])
        if isinstance(other, int) and not isinstance(other, bool) and other >= 0:
            return other
        # What glTF calls undefined: an extension may give an image, and who does not know it has none.
        raise GltfError(
            LOST, place, "it has no image that is read, and is left out: no source, and no EXT_texture_webp"
        )

    def _check_filters(self, sampler: dict[str, Any], place: str) -> None:
        """MaterialX has one filter: for what is larger and what is smaller than the image."""
        larger, smaller = sampler.get("magFilter", 9729), sampler.get("minFilter")
        # 9728, 9984 and 9986 take the closest texel, 9729, 9985 and 9987 blend; how levels are chosen is the host's.
        if smaller is not None and smaller % 2 != larger % 2:
            message = "minFilter and magFilter differ; MaterialX has one filter type, which magFilter sets"
            self._report(LOST.at(place, message))

    def _file(self, index: int, user: str) -> str:
        place = pointer("images", index)
        image = self._container.element("images", index, user)
        if "bufferView" in image:
            content = self._container.view(int(image["bufferView"]), f"{place}/bufferView")
            return self._write(content, image, index, image["mimeType"], place)
        uri = image["uri"]
        if is_data(uri):
            return self._write(decoded(uri, f"{place}/uri"), image, index, media_type(uri), f"{place}/uri")
        target = self._container.file(uri, f"{place}/uri")
        size = target.stat().st_size
        if size > MAXIMUM_IMAGE_BYTES:
            raise GltfError(TOO_LARGE, f"{place}/uri", f"an image of more than {MAXIMUM_IMAGE_BYTES // 2**20} MiB")
        _suffix(read_range(target, 0, 16, f"{place}/uri"), "", f"{place}/uri")
        if self.packed:
            return self._write(read_range(target, 0, size, f"{place}/uri"), image, index, "", f"{place}/uri")
        folder = self._container.path.parent.resolve()
        return os.path.relpath(target, folder).replace(os.sep, "/")

    def _write(self, content: bytes, image: dict[str, Any], index: int, stated: str, place: str) -> str:
        """Name of a file in `scratch` with this content."""
        self._unpacked += len(content)
        if self._unpacked > MAXIMUM_UNPACKED_BYTES:
            msg = f"its images have more than the {MAXIMUM_UNPACKED_BYTES // 2**20} MiB that are unpacked"
            raise GltfError(TOO_LARGE, place, msg)
        suffix = _suffix(content, stated, place)
        stem = re.sub(r"[^A-Za-z0-9]+", "_", str(image.get("name", "")))[:60].strip("_") or "image"
        name = f"{stem}_{index}{suffix}"
        (self._scratch / name).write_bytes(content)
        return name


def _is_inside(image: dict[str, Any]) -> bool:
    uri = image.get("uri")
    return not isinstance(uri, str) or is_data(uri) or not _PLAIN_NAME.fullmatch(unquote(uri))


def _suffix(content: bytes, stated: str, place: str) -> str:
    """Ending of an image file's name, by its first bytes.

    Raises
    ------
    GltfError
        If they are not those of an image that is read, or those of another kind than stated.
    """
    found = kind_of(content)
    if found is None:
        raise GltfError(NO_FILE, place, "its bytes are not those of a PNG, JPEG or WebP image")
    if stated not in ("", found.media_type):
        raise GltfError(
            INVALID, place, f"it is said to be {shown(stated)}, and its bytes are those of {found.media_type}"
        )
    return found.suffix
