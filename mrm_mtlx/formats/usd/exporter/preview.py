"""The look of a material for hosts without MaterialX, as prims: UsdPreviewSurface with its textures."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Gf, Sdf, UsdShade

from mrm_mtlx.documents.document_images import DocumentImages, ImagesTooLargeError
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.pbr import comparison
from mrm_mtlx.formats.pbr.daylight import PREVIEW, daylight
from mrm_mtlx.formats.pbr.model_nodes import MODEL
from mrm_mtlx.formats.pbr.placement import InexpressibleError, transform
from mrm_mtlx.formats.pbr.value_sources import resolved
from mrm_mtlx.reference import UnsupportedError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    import MaterialX as mx

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.formats.pbr.daylight import Look
    from mrm_mtlx.formats.pbr.placement import Placement
    from mrm_mtlx.formats.pbr.term import Lookup, Term

_TYPES = Sdf.ValueTypeNames
# Inputs that are vectors; of all others, three numbers are a colour.
_VECTORS = ("normal",)
_WRAPS = {"periodic": "repeat", "clamp": "clamp", "mirror": "mirror"}
_CHANNELS = "rgba"


class Previews:
    """The looks of a document's materials; `findings` say how far they are from the materials."""

    def __init__(self, document: mx.Document, reach: Reach, anchored: Callable[[str], str]) -> None:
        self._document, self._images, self._anchored = resolved(document), DocumentImages(reach), anchored
        self.findings: list[Finding] = []

    def add(self, material: UsdShade.Material, element: Any) -> None:
        """Add its look to the Material of an element, beside the network that is there."""
        again = self._document.getDescendant(element.getNamePath())
        place = f"/{element.getNamePath()}"
        self._images.start_surface()
        try:
            look = daylight(again, self._images)
            told = self._told(again, look)
            _Network(material, self._anchored).add(look.inputs)
        except (InexpressibleError, UnsupportedError, RecursionError, ImagesTooLargeError) as error:
            reason = f"it has {error}" if isinstance(error, ImagesTooLargeError) else str(error)
            message = f"it gets no look for hosts without MaterialX: {reason}"
            self.findings.append(rules.INTERCHANGE_PREVIEW.at(place, message))
            return
        self.findings += [rules.INTERCHANGE_PREVIEW.at(place + where, message) for where, message in look.losses]
        if told:
            message = f"its look for hosts without MaterialX is that of an ordinary material, in which {told}"
            self.findings.append(rules.INTERCHANGE_PREVIEW.at(place, message))

    def _told(self, element: Any, look: Look) -> str:
        """How far a look is from its element, in words; "" for rounding."""
        document = look.document(element.getDocument().getDataLibrary())
        pair = (element, self._images), (document.getNode(MODEL), self._images)
        apart = comparison.difference(*pair)
        if apart[0] <= comparison.ROUNDING:
            return ""
        return comparison.told(apart, *(comparison.photometry(*each) for each in pair))


class _Network:
    """Writes the shaders of one look into a Material."""

    def __init__(self, material: UsdShade.Material, anchored: Callable[[str], str]) -> None:
        self._material, self._anchored = material, anchored
        self._stage, self._path = material.GetPrim().GetStage(), material.GetPath()

    def add(self, inputs: dict[str, Term]) -> None:
        """The surface, and what its inputs are connected to."""
        shader = self._shader("preview", PREVIEW)
        for name, value in inputs.items():
            count = len(value.offset)
            kind = _TYPES.Float if count == 1 else _TYPES.Normal3f if name in _VECTORS else _TYPES.Color3f
            given = shader.CreateInput(name, kind)
            if value.lookup is None:
                given.Set(float(value.offset[0]) if count == 1 else Gf.Vec3f(*_singles(value.offset)))
            else:
                given.ConnectToSource(self._texture(f"preview_{name}", value, value.lookup))
        surface = shader.CreateOutput("surface", _TYPES.Token)
        self._material.CreateSurfaceOutput().ConnectToSource(surface)

    def _texture(self, name: str, value: Term, lookup: Lookup) -> Any:
        """The output of a texture that is a term."""
        shader = self._shader(name, "UsdUVTexture")
        shader.CreateInput("file", _TYPES.Asset).Set(Sdf.AssetPath(self._anchored(lookup.file)))
        shader.CreateInput("sourceColorSpace", _TYPES.Token).Set("sRGB" if lookup.encoded else "raw")
        for side, mode in zip("ST", lookup.modes, strict=True):
            shader.CreateInput(f"wrap{side}", _TYPES.Token).Set(_WRAPS[mode])
        shader.CreateInput("st", _TYPES.Float2).ConnectToSource(self._place(name, lookup))
        for given, numbers, neutral in (("scale", value.scale, 1.0), ("bias", value.offset, 0.0)):
            if np.any(numbers != neutral):
                four = [neutral] * 4
                for channel, number in zip(value.channels, _singles(numbers), strict=True):
                    four[channel] = number
                shader.CreateInput(given, _TYPES.Float4).Set(Gf.Vec4f(*four))
        if len(value.channels) == 3:
            return shader.CreateOutput("rgb", _TYPES.Float3)
        return shader.CreateOutput(_CHANNELS[value.channels[0]], _TYPES.Float)

    def _place(self, name: str, lookup: Lookup) -> Any:
        """The output of what gives a texture its coordinates."""
        primvar = f"st{lookup.texcoord or ''}"
        path = self._path.AppendChild(f"preview_{primvar}")
        reader = UsdShade.Shader(self._stage.GetPrimAtPath(path))
        if not reader:
            reader = self._shader(path.name, "UsdPrimvarReader_float2")
            reader.CreateInput("varname", _TYPES.String).Set(primvar)
            reader.CreateOutput("result", _TYPES.Float2)
        if lookup.placement == type(lookup.placement)():
            return reader.GetOutput("result")
        moved = self._shader(f"{name}_place", "UsdTransform2d")
        moved.CreateInput("in", _TYPES.Float2).ConnectToSource(reader.GetOutput("result"))
        for given, kind, number in _transform(lookup.placement):
            moved.CreateInput(given, kind).Set(number)
        return moved.CreateOutput("result", _TYPES.Float2)

    def _shader(self, name: str, identifier: str) -> UsdShade.Shader:
        """A shader, whose name may not be one of the material's nodes."""
        while self._stage.GetPrimAtPath(self._path.AppendChild(name)):
            name += "_"
        shader = UsdShade.Shader.Define(self._stage, self._path.AppendChild(name))
        shader.CreateIdAttr(identifier)
        return shader


def _transform(placement: Placement) -> Iterable[tuple[str, Sdf.ValueTypeName, Any]]:
    """The inputs of UsdTransform2d: scale, then rotation, counter-clockwise in degrees, then translation."""
    turned = transform(placement)
    yield "scale", _TYPES.Float2, Gf.Vec2f(*turned.scale)
    yield "rotation", _TYPES.Float, math.degrees(turned.rotation)
    yield "translation", _TYPES.Float2, Gf.Vec2f(*_singles(np.array([placement.c, placement.f])))


def _singles(values: Array) -> list[float]:
    return [float(np.float32(x)) for x in values]
