"""Materials as Storm is given them."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pxr import Sdf

from mrm_mtlx.engines.base import EngineFailure
from mrm_mtlx.system.writing import replacing

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from numpy.typing import NDArray

    from mrm_mtlx.shadergen import Shader

_PAIR, _NUMBER, _COMBINED = "ND_geompropvalue_vector2", "ND_geompropvalue_float", "ND_combine2_vector2"
_PROPERTY = "inputs:geomprop"
_PARTS = ("in1", "in2")


@dataclass(frozen=True)
class Material:
    """A material as Storm takes it.

    Attributes
    ----------
    source
        A layer of USD in text, whose default prim has the material as its only child.
    values
        Inputs of its shaders that are to have other values: path below the material, type of USD, value.
    """

    source: str
    values: tuple[tuple[str, str, Any], ...] = ()

    def written(self, folder: Path) -> Path:
        """The file of the layer in a folder; a material keeps its name, by which Storm knows it again.

        Raises
        ------
        EngineFailure
            If it cannot be written.
        """
        path = folder / f"material_{hashlib.sha256(self.source.encode()).hexdigest()}.usda"
        try:
            if not path.is_file():
                with replacing(path) as unfinished:
                    unfinished.write_text(self.source, encoding="utf-8")
        except OSError as error:
            raise EngineFailure(f"the material could not be written for Storm: {error.strerror}") from error
        return path


def for_facets(shader: Shader) -> Material:
    """The material of a shader, with two numbers in the place of each property that is a pair.

    Storm takes the first pair of numbers that a mesh has for its texture coordinates, and makes tangents of them.
    """
    layer = _layer(shader.sources["pixel"])
    for prim in list(_prims(layer.pseudoRoot)):
        name = prim.attributes.get(_PROPERTY)
        if _id(prim) == _PAIR and name is not None and name.default:
            _split(prim, str(name.default))
    return Material(layer.ExportToString())


def properties(given: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """The properties of points under the names that `for_facets` has for them."""
    found: dict[str, NDArray[Any]] = {}
    for name, values in given.items():
        if values.ndim == 2 and values.shape[1] == len(_PARTS):
            found |= {_part(name, part): values[:, index] for index, part in enumerate(_PARTS)}
        else:
            found[name] = values
    return found


def place_in(source: str, variable: str) -> str:
    """The path of a shader's attribute below the material of a layer."""
    layer = _layer(source)
    (material,) = layer.GetPrimAtPath(Sdf.Path.absoluteRootPath.AppendChild(layer.defaultPrim)).nameChildren
    return str(Sdf.Path(variable).MakeRelativePath(material.path))


def _layer(source: str) -> Sdf.Layer:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(source)
    return layer


def _prims(spec: Sdf.PrimSpec) -> Iterator[Sdf.PrimSpec]:
    for child in spec.nameChildren:
        yield child
        yield from _prims(child)


def _id(prim: Sdf.PrimSpec) -> str:
    attribute = prim.attributes.get("info:id")
    return "" if attribute is None else str(attribute.default)


def _split(pair: Sdf.PrimSpec, name: str) -> None:
    """Make of the node of a pair one that combines the nodes of its parts."""
    pair.attributes["info:id"].default = _COMBINED
    pair.RemoveProperty(pair.attributes[_PROPERTY])
    for part in _PARTS:
        number = Sdf.PrimSpec(pair.nameParent, f"{pair.name}_mrm_{part}", Sdf.SpecifierDef, "Shader")
        identity = Sdf.AttributeSpec(number, "info:id", Sdf.ValueTypeNames.Token, Sdf.VariabilityUniform)
        identity.default = _NUMBER
        Sdf.AttributeSpec(number, _PROPERTY, Sdf.ValueTypeNames.String).default = _part(name, part)
        output = Sdf.AttributeSpec(number, "outputs:out", Sdf.ValueTypeNames.Float)
        given = Sdf.AttributeSpec(pair, f"inputs:{part}", Sdf.ValueTypeNames.Float)
        given.connectionPathList.explicitItems = [output.path]


def _part(name: str, part: str) -> str:
    return f"{name}_mrm_{part}"
