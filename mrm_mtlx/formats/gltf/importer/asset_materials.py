"""Reads the materials of a glTF asset as a MaterialX document of gltf_pbr."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.document import Document
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.gltf import properties as gltf
from mrm_mtlx.formats.gltf.container import INVALID, LOST, open_container
from mrm_mtlx.formats.gltf.importer.texture_graph import Graph
from mrm_mtlx.formats.gltf.importer.textures import Textures
from mrm_mtlx.formats.gltf.schema import RETROREFLECTION, known_extensions, problems
from mrm_mtlx.formats.json_text import pointer
from mrm_mtlx.system.text import shown

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.formats.gltf.container import Container
    from mrm_mtlx.library import DataLibrary

# Materials that these make something else of, which retroreflection must not be used with.
_UNLIT, _SPECULAR = gltf.UNLIT, "KHR_materials_pbrSpecularGlossiness"
# What is said of textures and is read; what is images that are not read; and what is said of nothing but geometry,
# animation and scenes.
_OF_TEXTURES = ("KHR_texture_transform", "EXT_texture_webp")
_OF_IMAGES = ("KHR_texture_basisu", "EXT_texture_avif", "MSFT_texture_dds")
_OF_OTHERS = re.compile(
    r"KHR_(draco|mesh|lights|animation|node|xmp|materials_variants|gaussian)\w*|EXT_(mesh|meshopt|lights|instance)\w*"
)
_CORRECT = "Correct the name; there is no extension of that one that is read."
# Reflectance of a dielectric at normal incidence below which retroreflection is hardly seen: twice that of index 1.5.
_FAINT = 0.08


def read(path: Path, reach: Reach, library: DataLibrary, scratch: Path) -> Document:
    """The materials of a .gltf or .glb as a document; see `formats.format`.

    A material that breaks glTF's rules is left out; what MaterialX cannot say is left out of its material. Both are
    findings, with JSON pointers as locations.
    """
    container = open_container(path, reach)
    materialx = mx.createDocument()
    materialx.setColorSpace("lin_rec709")
    document = Document(materialx=materialx, path=path, reach=reach, locations=container.locations)
    known: set[Finding] = set()

    def report(found: Finding) -> None:
        if found not in known:  # two materials may use one texture
            known.add(found)
            document.findings.append(found)

    textures = Textures(container, scratch, report)
    if textures.packed:
        document.reach = Reach.only(scratch)
        document.packed = True
    _check_extensions(container, report)
    colored = dict(_colored(container.data))
    for index in range(len(container.data.get("materials", []))):
        _Material(container, index, textures, report).add_to(document)
        if index in colored:
            message = f"the vertex colours of {colored[index]} multiply its base colour; a document has none"
            report(LOST.at(pointer("materials", index), message))
    materialx.setDataLibrary(library.document)
    return document


class _Material:
    """One material on its way into a document."""

    def __init__(self, container: Container, index: int, textures: Textures, report: Callable[[Finding], None]) -> None:
        self._container, self._index = container, index
        self._textures, self._report = textures, report
        self._place = pointer("materials", index)

    def add_to(self, document: Document) -> None:
        """Add the material, unless it breaks the rules, and say what of it is lost."""
        self._material = self._container.data["materials"][self._index]
        wrong = problems("material", self._material, self._place)
        for problem in wrong:
            self._report(problem)
        if any(problem.rule is INVALID for problem in wrong):
            return
        if not self._allowed():
            return
        self._extensions = self._material.get("extensions", {})
        self._report_losses()
        self._source_locations = document.source_locations
        materialx = document.materialx
        given = str(self._material.get("name", "")) or f"material_{self._index}"
        name = re.sub(r"[^A-Za-z0-9_]", "_", given)[:100]
        if name[0].isdigit():  # generated code has variables of this name
            name = f"_{name}"
        if materialx.getChild(name) is not None:  # with its index, as counting up takes long for thousands of one name
            name = f"{name}_{self._index}"
        name = materialx.createValidChildName(name)
        # The shader's name is found first, so that the three are taken together.
        category = "surface_unlit" if _UNLIT in self._extensions else "gltf_pbr"
        self._shader = materialx.addNode(category, materialx.createValidChildName(f"SR_{name}"), "surfaceshader")
        self._graph = Graph(materialx, materialx.createValidChildName(f"NG_{name}"), self._source_locations)
        material = materialx.addNode("surfacematerial", name, "material")
        material.addInput("surfaceshader", "surfaceshader").setNodeName(self._shader.getName())
        for element in (material, self._shader):
            self._source_locations[element.getNamePath()] = self._place
        if _UNLIT in self._extensions:
            self._fill_unlit()
        else:
            self._fill()
        self._graph.finish(self._place)

    def _allowed(self) -> bool:
        extensions = self._material.get("extensions", {})
        wrong = [name for name in (_UNLIT, _SPECULAR) if name in extensions and RETROREFLECTION in extensions]
        for name in wrong:
            message = f"{RETROREFLECTION} must not be used together with {name}"
            self._report(INVALID.at(self._at(("extensions",)), message, "Remove one of the two extensions."))
        return not wrong

    def _report_losses(self) -> None:
        for name in sorted(set(self._extensions) - set(known_extensions())):
            message = f"{shown(name)} is not read{_meant(name)}"
            self._lost(("extensions", name), message, _CORRECT if _meant(name) else "")
        extras = self._material.get("extras")
        for name in extras if isinstance(extras, dict) else ():
            if _meant(name):
                self._lost(("extras", name), f"{shown(name)} is not read{_meant(name)}", _CORRECT)
        if self._material.get("doubleSided"):
            self._lost(("doubleSided",), "a document does not say which sides are shown")
        retro = self._extensions.get(RETROREFLECTION, {})
        if retro.get("retroreflectionFactor", 0.0) > 0.0 and self._reflectance() < _FAINT:
            message = (
                f"a dielectric that reflects {self._reflectance():.2g} at normal incidence is hardly seen to do so"
            )
            hint = (
                "Raise specularColorFactor (KHR_materials_specular), the index (KHR_materials_ior) or metallicFactor."
            )
            self._report(rules.RETRO_INVISIBLE.at(self._at(("extensions", RETROREFLECTION)), message, hint))

    def _reflectance(self) -> float:
        """Reflectance at normal incidence, textures taken as white."""
        if self._number((*gltf.CORE, "metallicFactor"), 1.0) > 0.0:
            return 1.0
        value = {p.input: self._value(p) for p in gltf.PROPERTIES if p.input in ("ior", "specular", "specular_color")}
        (ior,), (weight,), color = value["ior"], value["specular"], value["specular_color"]
        return min(1.0, ((1.0 - ior) / (1.0 + ior)) ** 2 * max(color)) * weight

    def _fill(self) -> None:
        for prop in gltf.PROPERTIES:
            self._set_property(prop)
        for name, path in gltf.NORMALS:
            if use := self._use(path):
                self._connect(name, self._graph.normal(use, self._number((*path, "scale"), 1.0)), path)
        self._set_occlusion()
        self._set_thickness()
        self._set_anisotropy()
        if not self._is_opaque():
            self._set("alpha_mode", "integer", (gltf.ALPHA_MODES.index(self._material["alphaMode"]),), ("alphaMode",))
        distance = gltf.found(self._material, gltf.ATTENUATION_DISTANCE)
        if distance is not None:
            self._set("attenuation_distance", "float", (float(distance),), gltf.ATTENUATION_DISTANCE)

    def _fill_unlit(self) -> None:
        """Give what is unlit its base colour, whatever the light, and its alpha; the rest is for other readers."""
        by_input = {prop.input: prop for prop in gltf.PROPERTIES}
        alpha, color = by_input["alpha"], by_input["base_color"]
        if not self._is_opaque():
            self._set_opacity(alpha)
        factor = self._value(color)
        if use := self._use(color.texture):
            value = self._graph.multiplied(self._graph.channels(use, color.channels), factor, "base_color_scaled")
            self._connect("emission_color", value, color.texture)
        else:
            self._set("emission_color", "color3", factor, color.factor)

    def _set_opacity(self, alpha: gltf.Property) -> None:
        """The alpha; of a mask, whether it reaches the cutoff."""
        factor, use = self._value(alpha), self._use(alpha.texture)
        is_mask = self._material["alphaMode"] == "MASK"
        cutoff = self._number(("alphaCutoff",), 0.5)
        if use is None:
            self._set("opacity", "float", (float(factor[0] >= cutoff) if is_mask else factor[0],), alpha.factor)
            return
        value = self._graph.multiplied(self._graph.channels(use, alpha.channels), factor, "alpha_scaled")
        if is_mask:
            value = self._graph.reaching(value, cutoff, "alpha_masked")
        self._connect("opacity", value, alpha.texture)

    def _is_opaque(self) -> bool:
        return bool(self._material.get("alphaMode", gltf.ALPHA_MODES[0]) == gltf.ALPHA_MODES[0])

    def _set_property(self, prop: gltf.Property) -> None:
        factor, use = self._value(prop), self._use(prop.texture) if prop.texture else None
        if prop.input == "alpha" and self._is_opaque():  # which is without its alpha
            use = None
        if use is not None:
            value = self._graph.channels(use, prop.channels)
            self._connect(prop.input, self._graph.multiplied(value, factor, f"{prop.input}_scaled"), prop.texture)
        elif self._is_said(prop):
            self._set(prop.input, prop.type, factor, prop.factor)

    def _is_said(self, prop: gltf.Property) -> bool:
        """True if a factor is written down: an extension's all are, as the input's default may be another."""
        if prop.extension:
            return prop.extension in self._extensions
        return gltf.found(self._material, prop.factor) is not None

    def _value(self, prop: gltf.Property) -> tuple[float, ...]:
        given = gltf.found(self._material, prop.factor)
        value = prop.default if given is None else given
        if given is not None and prop.components:
            value = [given[component] for component in prop.components]
        return tuple(float(x) for x in value) if isinstance(value, list | tuple) else (float(value),)

    def _number(self, path: gltf.Path, default: float) -> float:
        given = gltf.found(self._material, path)
        return default if given is None else float(given)

    def _set_occlusion(self) -> None:
        if use := self._use(gltf.OCCLUSION):
            value, strength = self._graph.channels(use, (0,)), self._number((*gltf.OCCLUSION, "strength"), 1.0)
            if strength != 1.0:  # glTF: 1 + strength (r - 1)
                value = self._graph.between((1.0,), value, (strength,), "occlusion_weakened")
            self._connect("occlusion", value, gltf.OCCLUSION)

    def _set_thickness(self) -> None:
        if "KHR_materials_iridescence" not in self._extensions:
            return
        thinnest, thickest = self._number(*gltf.THINNEST), self._number(*gltf.THICKEST)
        if use := self._use(gltf.THICKNESS_TEXTURE):
            # Not gltf_iridescence_thickness, whose ends are exchanged (MaterialX 1.39.5).
            green = self._graph.channels(use, (1,))
            value = self._graph.between((thinnest,), (thickest,), green, "iridescence_between")
            self._connect("iridescence_thickness", value, gltf.THICKNESS_TEXTURE)
        else:
            self._set("iridescence_thickness", "float", (thickest,), gltf.THICKEST[0])

    def _set_anisotropy(self) -> None:
        if "KHR_materials_anisotropy" not in self._extensions:
            return
        strength, rotation = (self._number(path, 0.0) for path in (gltf.STRENGTH, gltf.ROTATION))
        if use := self._use(gltf.ANISOTROPY_TEXTURE):
            if use.modes != ("periodic", "periodic"):
                self._lost(gltf.ANISOTROPY_TEXTURE, "gltf_anisotropy_image repeats its image, whatever the wrap mode")
            node = self._graph.anisotropy(use, strength, rotation)
            for name in ("anisotropy_strength", "anisotropy_rotation"):
                self._connect(name, node, gltf.ANISOTROPY_TEXTURE, f"{name}_out")
        else:
            self._set("anisotropy_strength", "float", (strength,), gltf.STRENGTH)
            self._set("anisotropy_rotation", "float", (rotation,), gltf.ROTATION)

    def _use(self, path: gltf.Path) -> Any:
        info = gltf.found(self._material, path)
        if info is None:
            return None
        for name in sorted(set(info.get("extensions", {})) - {gltf.TRANSFORM}):
            self._lost((*path, "extensions", name), f"the extension {shown(name)} is not read")
        return self._textures.use(info, self._at(path))

    def _set(self, name: str, kind: str, value: tuple[float, ...], path: gltf.Path) -> None:
        self._shader.addInput(name, kind).setValueString(", ".join(f"{x:.9g}" for x in value))
        self._source_locations[f"{self._shader.getName()}/{name}"] = self._at(path)

    def _connect(self, name: str, node: Any, path: gltf.Path, which: str = "") -> None:
        output = self._graph.output(name, node, which)
        given = self._shader.addInput(name, output.getType())
        given.setNodeGraphString(output.getParent().getName())
        given.setOutputString(output.getName())
        self._source_locations[f"{self._shader.getName()}/{name}"] = self._at(path)

    def _lost(self, path: gltf.Path, message: str, hint: str = "") -> None:
        self._report(LOST.at(self._at(path), message, hint))

    def _at(self, path: gltf.Path) -> str:
        return self._place + pointer(*path)


def _check_extensions(container: Container, report: Callable[[Finding], None]) -> None:
    """Report what an asset says it cannot be read without, and what it names by a wrong name."""
    required = container.data.get("extensionsRequired", [])
    if not isinstance(required, list) or not all(isinstance(name, str) for name in required):
        report(INVALID.at("/extensionsRequired", "expected an array of names"))
        return
    for index, name in enumerate(required):
        place = pointer("extensionsRequired", index)
        if name == RETROREFLECTION:
            report(LOST.at(place, f"{name} should not be required: a material is of use without it"))
        elif name in _OF_IMAGES:
            report(LOST.at(place, f"the asset requires {name}; its images are not read, and left out"))
        elif name not in (*known_extensions(), *_OF_TEXTURES) and not _OF_OTHERS.fullmatch(name):
            message = f"the asset requires {shown(name)}, which is not read{_meant(name)}"
            report(INVALID.at(place, message, "Convert the asset to one without this extension."))


def _meant(name: str) -> str:
    """The name that one which is not known probably means, as the end of a message."""
    if name != RETROREFLECTION and "retroreflect" in name.lower():
        return f"; {RETROREFLECTION} is probably meant"
    return ""


def _colored(data: dict[str, Any]) -> Iterator[tuple[int, str]]:
    """Materials of meshes with vertex colours, and the pointers to the primitives."""
    for mesh_index, mesh in enumerate(_list(data, "meshes")):
        for index, primitive in enumerate(_list(mesh, "primitives")):
            if not isinstance(primitive, dict) or not isinstance(primitive.get("attributes"), dict):
                continue
            material = primitive.get("material")
            if "COLOR_0" in primitive["attributes"] and isinstance(material, int):
                yield material, pointer("meshes", mesh_index, "primitives", index)


def _list(parent: Any, name: str) -> list[Any]:
    value = parent.get(name) if isinstance(parent, dict) else None
    return value if isinstance(value, list) else []
