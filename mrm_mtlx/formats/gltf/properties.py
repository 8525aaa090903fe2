"""Properties of a glTF material and the inputs of gltf_pbr that they are: one table for both directions.

Most are a factor times a texture's channels. The rest (normals, occlusion, iridescence's thickness, anisotropy, alpha's
mode) have a function of their own in `importer.asset_materials` and `exporter.material`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

Path = tuple[str, ...]

CORE: Path = ("pbrMetallicRoughness",)


class Property(NamedTuple):
    """A property of a material.

    Attributes
    ----------
    input
        Of gltf_pbr.
    factor
        Path in the material.
    default
        Of the factor, by glTF; a tuple for a colour.
    texture
        Path of the texture that multiplies it; () for none.
    channels
        Which channels of the texture: indices of red, green, blue, alpha.
    encoded
        Whether the texture's colours are sRGB.
    components
        Which components of the factor, where it holds more than this input's.
    """

    input: str
    factor: Path
    default: float | tuple[float, ...]
    texture: Path = ()
    channels: tuple[int, ...] = (0,)
    encoded: bool = False
    components: tuple[int, ...] = ()

    @property
    def type(self) -> str:
        """The input's type."""
        return "color3" if isinstance(self.default, tuple) else "float"

    @property
    def extension(self) -> str:
        """The extension that it belongs to, "" for the core."""
        return self.factor[1] if self.factor[0] == "extensions" else ""


def _of(extension: str, *name: str) -> Path:
    return ("extensions", f"KHR_materials_{extension}", *name)


_RGB = (0, 1, 2)
_WHITE, _BLACK = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
_BASE, _SHARED = (*CORE, "baseColorTexture"), (*CORE, "metallicRoughnessTexture")


def _extended(
    input_name: str,
    extension: str,
    factor: str,
    default: float | tuple[float, ...],
    texture: str = "",
    channels: tuple[int, ...] = (0,),
) -> Property:
    colored = isinstance(default, tuple)
    path = _of(extension, texture) if texture else ()
    return Property(input_name, _of(extension, factor), default, path, _RGB if colored else channels, colored)


# What reads an image's alpha comes before what reads its colours, so that the image is read once for both.
PROPERTIES = (
    Property("alpha", (*CORE, "baseColorFactor"), 1.0, _BASE, (3,), True, (3,)),
    Property("base_color", (*CORE, "baseColorFactor"), _WHITE, _BASE, _RGB, True, _RGB),
    Property("metallic", (*CORE, "metallicFactor"), 1.0, _SHARED, (2,)),
    Property("roughness", (*CORE, "roughnessFactor"), 1.0, _SHARED, (1,)),
    Property("emissive", ("emissiveFactor",), _BLACK, ("emissiveTexture",), _RGB, True),
    Property("alpha_cutoff", ("alphaCutoff",), 0.5),
    _extended("emissive_strength", "emissive_strength", "emissiveStrength", 1.0),
    _extended("clearcoat", "clearcoat", "clearcoatFactor", 0.0, "clearcoatTexture"),
    _extended("clearcoat_roughness", "clearcoat", "clearcoatRoughnessFactor", 0.0, "clearcoatRoughnessTexture", (1,)),
    _extended("sheen_roughness", "sheen", "sheenRoughnessFactor", 0.0, "sheenRoughnessTexture", (3,)),
    _extended("sheen_color", "sheen", "sheenColorFactor", _BLACK, "sheenColorTexture"),
    _extended("transmission", "transmission", "transmissionFactor", 0.0, "transmissionTexture"),
    _extended("thickness", "volume", "thicknessFactor", 0.0, "thicknessTexture", (1,)),
    _extended("attenuation_color", "volume", "attenuationColor", _WHITE),
    _extended("ior", "ior", "ior", 1.5),
    _extended("specular", "specular", "specularFactor", 1.0, "specularTexture", (3,)),
    _extended("specular_color", "specular", "specularColorFactor", _WHITE, "specularColorTexture"),
    _extended("iridescence", "iridescence", "iridescenceFactor", 0.0, "iridescenceTexture"),
    _extended("iridescence_ior", "iridescence", "iridescenceIor", 1.3),
    _extended("dispersion", "dispersion", "dispersion", 0.0),
    _extended("retroreflectivity", "retroreflection", "retroreflectionFactor", 0.0, "retroreflectionTexture"),
)

# Of normals: input, texture.
NORMALS = (
    ("normal", ("normalTexture",)),
    ("clearcoat_normal", _of("clearcoat", "clearcoatNormalTexture")),
)
OCCLUSION: Path = ("occlusionTexture",)
ATTENUATION_DISTANCE = _of("volume", "attenuationDistance")
# Thickness of iridescence [nm]: where the texture's green is 0, where it is 1, and the texture.
THINNEST = (_of("iridescence", "iridescenceThicknessMinimum"), 100.0)
THICKEST = (_of("iridescence", "iridescenceThicknessMaximum"), 400.0)
THICKNESS_TEXTURE = _of("iridescence", "iridescenceThicknessTexture")
STRENGTH, ROTATION = _of("anisotropy", "anisotropyStrength"), _of("anisotropy", "anisotropyRotation")
ANISOTROPY_TEXTURE = _of("anisotropy", "anisotropyTexture")

ALPHA_MODES = ("OPAQUE", "MASK", "BLEND")

# Wrap modes and the filter of a sampler, by their numbers in glTF, which are OpenGL's.
WRAPS = {10497: "periodic", 33071: "clamp", 33648: "mirror"}
FILTERS = {9728: "closest", 9729: "linear"}
TRANSFORM = "KHR_texture_transform"
# What makes a material the same in any light.
UNLIT = "KHR_materials_unlit"


def found(material: dict[str, Any], path: Sequence[str]) -> Any:
    """The value that a path leads to in a material that the schema accepts, or None."""
    value: Any = material
    for key in path:
        value = value.get(key) if isinstance(value, dict) else None
    return value
