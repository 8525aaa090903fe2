"""Types, values, colour spaces and terminals of MaterialX in USD, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Gf, Sdf

from mrm_mtlx.library.color_spaces import canonical

if TYPE_CHECKING:
    import MaterialX as mx

# The form of UsdMtlx. Types that are not here (BSDF, surfaceshader) hold no value: tokens, to be connected.
SDF_TYPES = {
    "boolean": Sdf.ValueTypeNames.Bool,
    "integer": Sdf.ValueTypeNames.Int,
    "float": Sdf.ValueTypeNames.Float,
    "color3": Sdf.ValueTypeNames.Color3f,
    "color4": Sdf.ValueTypeNames.Color4f,
    "vector2": Sdf.ValueTypeNames.Float2,
    "vector3": Sdf.ValueTypeNames.Float3,
    "vector4": Sdf.ValueTypeNames.Float4,
    "matrix33": Sdf.ValueTypeNames.Matrix3d,
    "matrix44": Sdf.ValueTypeNames.Matrix4d,
    "string": Sdf.ValueTypeNames.String,
    "geomname": Sdf.ValueTypeNames.String,
    "filename": Sdf.ValueTypeNames.Asset,
    "booleanarray": Sdf.ValueTypeNames.BoolArray,
    "integerarray": Sdf.ValueTypeNames.IntArray,
    "floatarray": Sdf.ValueTypeNames.FloatArray,
    "color3array": Sdf.ValueTypeNames.Color3fArray,
    "color4array": Sdf.ValueTypeNames.Color4fArray,
    "vector2array": Sdf.ValueTypeNames.Float2Array,
    "vector3array": Sdf.ValueTypeNames.Float3Array,
    "vector4array": Sdf.ValueTypeNames.Float4Array,
    "stringarray": Sdf.ValueTypeNames.StringArray,
}
_MATERIALX_TYPES = {str(sdf): kind for kind, sdf in SDF_TYPES.items() if kind != "geomname"}
_VECTORS = {"float2": Gf.Vec2f, "float3": Gf.Vec3f, "float4": Gf.Vec4f, "color3f": Gf.Vec3f, "color4f": Gf.Vec4f}

# Inputs of a material node, and the node's category, by the material's terminal.
TERMINALS = {
    "surface": ("surfaceshader", "surfacematerial"),
    "displacement": ("displacementshader", "surfacematerial"),
    "volume": ("volumeshader", "volumematerial"),
}
# Types that MaterialX converts colours of, and images.
COLORED = ("color3", "color4", "filename")

# Names of colour spaces that MaterialX does not take: of USD's own vocabulary (Gf.ColorSpaceNames), and of texture
# settings in use.
_COLOR_SPACES = {
    "sRGB": "srgb_texture",
    "raw": "none",
    "data": "none",
    "identity": "none",
    "unknown": "none",
}


def sdf_type(kind: str) -> Sdf.ValueTypeName:
    """The type of an attribute for a MaterialX type; a token for what holds no value."""
    return SDF_TYPES.get(kind, Sdf.ValueTypeNames.Token)


def to_usd(kind: str, value: Any, scale: float = 1.0) -> Any:
    """A MaterialX value for an attribute of `sdf_type(kind)`, numbers times `scale` and in float32."""
    if kind in ("string", "geomname", "filename"):
        return str(value)
    if kind in ("boolean", "integer"):
        return bool(value) if kind == "boolean" else int(value)
    if kind == "float":
        return float(np.float32(value * scale))
    if kind.startswith("matrix"):
        size = range(value.numRows())
        rows = [[float(value[row, column]) for column in size] for row in size]
        return Gf.Matrix3d(*(x for row in rows for x in row)) if len(size) == 3 else Gf.Matrix4d(rows)
    if kind.endswith("array"):
        return [to_usd(kind.removesuffix("array"), item, scale) for item in value]
    return _VECTORS[str(sdf_type(kind))](*(float(np.float32(x * scale)) for x in value.asTuple()))


def materialx_type(sdf: Sdf.ValueTypeName, declared: str) -> str:
    """The MaterialX type that an attribute has for an input that is declared so; the name in USD if there is none.

    Roles do not count (a normal is a vector, a colour is three numbers): writers differ in them. Tokens stand for
    strings and for what holds no value.
    """
    wanted = sdf_type(declared)
    token = sdf == Sdf.ValueTypeNames.Token
    if sdf.type == wanted.type or (token and (wanted == Sdf.ValueTypeNames.String or not declared)):
        return declared or "string"
    return "string" if token else _MATERIALX_TYPES.get(str(sdf), str(sdf))


def to_text(value: Any) -> str:
    """A value of an attribute as MaterialX writes it; float32 in the fewest digits that give it back."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Sdf.AssetPath):
        return str(value.path)
    if isinstance(value, float):
        return str(np.float32(value))
    if isinstance(value, int | str):
        return str(value)
    if isinstance(value, Gf.Matrix3d | Gf.Matrix4d):
        return ", ".join(to_text(float(x)) for row in value for x in row)
    return ", ".join(to_text(item) for item in value)


def color_space(name: str) -> str:
    """MaterialX's name of a colour space of USD; unknown ones as they are."""
    return _COLOR_SPACES.get(name, canonical(name))


def outputs_of(definition: mx.NodeDef) -> list[str]:
    """Names of a definition's outputs."""
    return [str(output.getName()) for output in definition.getActiveOutputs()]
