"""One material on its way into an asset: the inputs of gltf_pbr, as terms, become factors and textures."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.documents.graph import shader_node
from mrm_mtlx.formats.gltf import properties as gltf
from mrm_mtlx.formats.gltf.exporter.ranges import bring_into_range, leave_out_idle
from mrm_mtlx.formats.gltf.exporter.texture_slots import Channel
from mrm_mtlx.formats.pbr.inputs import UNLIT
from mrm_mtlx.formats.pbr.normals import normal_map
from mrm_mtlx.formats.pbr.placement import InexpressibleError, Transform, transform, written
from mrm_mtlx.formats.pbr.term import Lookup, Term
from mrm_mtlx.formats.pbr.terms import look_up, scalar

if TYPE_CHECKING:
    from mrm_mtlx.formats.gltf.exporter.asset import Asset
    from mrm_mtlx.formats.gltf.exporter.texture_slots import Images
    from mrm_mtlx.formats.pbr.inputs import Inputs

_WRAPS = {name: number for number, name in gltf.WRAPS.items()}
# Always written, though they may be glTF's defaults: what a material is at first sight.
_PLAIN = ("base_color", "metallic", "roughness")


class Material:
    """A material of an asset, made of a renderable element and its inputs, see `formats.pbr.inputs`.

    Raises
    ------
    InexpressibleError
        If glTF has no form for it.

    Attributes
    ----------
    data
        It, as glTF has it.
    losses
        What of it glTF cannot say: the place in the material, "/input", and why.
    """

    def __init__(self, element: Any, inputs: Inputs, asset: Asset, images: Images) -> None:
        node = shader_node(element)
        self.data: dict[str, Any] = {"name": element.getName()}
        if node.getCategory() == UNLIT:
            self.data["extensions"] = {gltf.UNLIT: {}}
        self.losses = list(inputs.losses)
        self._asset, self._images, self._document = asset, images, element.getDocument()
        self._inputs = dict(inputs.values)
        self._opaque = self._inputs.get("alpha_mode", 0) == 0
        self._place_emission()
        for path in dict.fromkeys(prop.texture for prop in gltf.PROPERTIES if prop.texture):
            self._fill([prop for prop in gltf.PROPERTIES if prop.texture == path], path)
        for prop in gltf.PROPERTIES:
            if not prop.texture:
                self._set_factor(prop, self._constant(prop))
        self._set_normals()
        self._set_occlusion()
        self._set_thickness()
        self._set_anisotropy()
        if not self._opaque:
            is_mask = self._inputs["alpha_mode"] == gltf.ALPHA_MODES.index("MASK")
            self.data["alphaMode"] = "MASK" if is_mask else "BLEND"  # as gltf_pbr takes any other number
        self._set_attenuation()
        leave_out_idle(self.data)
        self.losses += bring_into_range(self.data)

    def _lost(self, name: str, message: str) -> None:
        self.losses.append((f"/{name}", message))

    def _place_emission(self) -> None:
        """Emission beyond 1 is a matter of its strength."""
        color, strength = self._inputs.get("emissive"), self._inputs.get("emissive_strength", Term.constant(1.0))
        if color is None:
            return
        largest = float(max(np.max(np.abs(color.offset + color.scale)), np.max(np.abs(color.scale))))
        if strength.value is not None and np.all(strength.value == 0.0):
            self._inputs = {n: v for n, v in self._inputs.items() if n not in ("emissive", "emissive_strength")}
        elif largest > 1.0 and strength.value is not None:
            self._inputs |= {"emissive": color * (1.0 / largest), "emissive_strength": strength * largest}

    def _fill(self, props: list[gltf.Property], path: gltf.Path) -> None:
        """Set the factors of all that share a texture, and the texture."""
        terms = {prop: self._term(prop) for prop in props}
        textured = {prop: value for prop, value in terms.items() if value.lookup is not None}
        if self._opaque:
            textured = {prop: value for prop, value in textured.items() if prop.input != "alpha"}
        for prop, value in list(textured.items()):
            reason = self._unlike(value, next(iter(textured.values())))
            if reason:
                self._lost(prop.input, reason)
                del textured[prop]
                terms[prop] = Term.constant(prop.default)
        factors = {prop: value.scale if prop in textured else value.offset for prop, value in terms.items()}
        if textured:
            wanted = _wanted(terms, textured, ignored="alpha" if self._opaque else "")
            lookup = next(value.lookup for value in textured.values() if value.lookup is not None)
            info = self._texture(wanted, lookup, path, next(iter(textured)).input)
            if info is None:
                factors |= {prop: np.atleast_1d(prop.default) for prop in textured}
            else:
                _put(self.data, path, info)
        for prop, factor in factors.items():
            self._set_factor(prop, factor)

    def _term(self, prop: gltf.Property) -> Term:
        value = self._inputs.get(prop.input)
        return value if isinstance(value, Term) else Term.constant(prop.default)

    def _constant(self, prop: gltf.Property) -> Any:
        value = self._term(prop)
        if value.value is None:
            self._lost(prop.input, "it varies, and glTF has one number for it")
            return np.atleast_1d(prop.default)
        return value.value

    def _unlike(self, value: Term, first: Term) -> str:
        """The reason why an image cannot be in the texture that begins with another, "" if it can."""
        if np.any(value.offset != 0.0):
            return "a number is added to the image, and glTF has a factor alone"
        if value.lookup is not None and value.lookup._replace(file="", encoded=False) != (
            first.lookup and first.lookup._replace(file="", encoded=False)
        ):
            return "it would share a texture with an image that is looked up at another place"
        return ""

    def _texture(
        self, wanted: dict[int, Channel | None], lookup: Lookup, path: gltf.Path, name: str
    ) -> dict[str, Any] | None:
        """The textureInfo of a slot, None if it cannot be made, which is a loss."""
        stem = re.sub(r"[^A-Za-z0-9_]", "_", f"{self.data['name'][:100]}_{path[-1]}")
        try:
            placed = transform(lookup.placement)
            image = self._images.slot(wanted, stem)
        except InexpressibleError as error:
            self._lost(name, str(error))
            return None
        closest = lookup.filter == "closest"
        sampler = {
            "magFilter": 9728 if closest else 9729,
            "minFilter": 9728 if closest else 9987,
            "wrapS": _WRAPS[lookup.modes[0]],
            "wrapT": _WRAPS[lookup.modes[1]],
        }
        info: dict[str, Any] = {"index": self._asset.texture(image, sampler)}
        if lookup.texcoord:
            info["texCoord"] = lookup.texcoord
        neutral = Transform()
        moved = {key: value for key, value in placed._asdict().items() if value != getattr(neutral, key)}
        if moved:
            plain = {key: list(value) if isinstance(value, tuple) else value for key, value in moved.items()}
            info["extensions"] = {gltf.TRANSFORM: plain}
        return info

    def _set_factor(self, prop: gltf.Property, factor: Any) -> None:
        values = [written(x) for x in np.atleast_1d(factor)]
        default = list(np.atleast_1d(prop.default))
        values = values * (len(default) // len(values))
        if prop.components:
            whole = gltf.found(self.data, prop.factor) or [1.0, 1.0, 1.0, 1.0]
            for component, value in zip(prop.components, values, strict=True):
                whole[component] = value
            _put(self.data, prop.factor, whole)
        elif values != default or prop.input in _PLAIN:
            _put(self.data, prop.factor, values if len(values) > 1 else values[0])

    def _set_normals(self) -> None:
        for name, path in gltf.NORMALS:
            if name in self._inputs:
                self._set_normal(name, path)

    def _set_normal(self, name: str, path: gltf.Path) -> None:
        try:
            found = normal_map(self._document, self._inputs[name])
        except InexpressibleError as error:
            self._lost(name, str(error))
            return
        wanted: dict[int, Channel | None] = {
            k: Channel(found.lookup, channel, False) for k, channel in enumerate(found.channels)
        }
        info = self._texture(wanted, found.lookup, path, name)
        if info is not None:
            _put(self.data, path, info | ({"scale": written(found.scale)} if found.scale != 1.0 else {}))

    def _set_occlusion(self) -> None:
        value = self._inputs.get("occlusion")
        if value is None or (value.value is not None and np.all(value.value == 1.0)):
            return
        strength = float(value.scale[0])
        if value.lookup is None or abs(float(value.offset[0]) + strength - 1.0) > 1e-6 or not 0.0 <= strength <= 1.0:
            self._lost("occlusion", "glTF has an image that is weakened, 1 + strength (image - 1), and nothing else")
            return
        info = self._texture(
            {0: Channel(value.lookup, value.channels[0], False)}, value.lookup, gltf.OCCLUSION, "occlusion"
        )
        if info is not None:
            self.data["occlusionTexture"] = info | ({"strength": written(strength)} if strength != 1.0 else {})

    def _set_thickness(self) -> None:
        value = self._inputs.get("iridescence_thickness")
        if value is None:
            return
        thinnest, thickest = float(value.offset[0]), float(value.offset[0] + value.scale[0])
        if value.lookup is not None:
            wanted: dict[int, Channel | None] = {1: Channel(value.lookup, value.channels[0], False)}
            info = self._texture(wanted, value.lookup, gltf.THICKNESS_TEXTURE, "iridescence_thickness")
            if info is None:
                return
            _put(self.data, gltf.THICKNESS_TEXTURE, info)
            _put(self.data, gltf.THINNEST[0], written(thinnest))
        _put(self.data, gltf.THICKEST[0], written(thickest))

    def _set_anisotropy(self) -> None:
        strength, rotation = (self._inputs.get(f"anisotropy_{name}") for name in ("strength", "rotation"))
        if strength is None and rotation is None:
            return
        node = strength if strength is not None and not isinstance(strength, Term) else None
        if node is not None:
            if rotation is None or isinstance(rotation, Term) or rotation.getName() != node.getName():
                self._lost("anisotropy_rotation", "strength and rotation do not come from the same anisotropy image")
                return
            self._set_anisotropy_image(node)
            return
        for value, path, name in ((strength, gltf.STRENGTH, "strength"), (rotation, gltf.ROTATION, "rotation")):
            if isinstance(value, Term) and value.value is not None:
                if value.value[0] != 0.0:
                    _put(self.data, path, written(value.value[0]))
            elif value is not None:
                self._lost(f"anisotropy_{name}", "it is neither a number nor an output of gltf_anisotropy_image")

    def _set_anisotropy_image(self, node: Any) -> None:
        try:
            lookup = look_up(node)
            numbers = [scalar(node, name) for name in ("anisotropy_strength", "anisotropy_rotation")]
        except InexpressibleError as error:
            self._lost("anisotropy_strength", str(error))
            return
        wanted: dict[int, Channel | None] = {k: Channel(lookup, k, False) for k in range(3)}
        info = self._texture(wanted, lookup, gltf.ANISOTROPY_TEXTURE, "anisotropy_strength")
        if info is not None:
            _put(self.data, gltf.ANISOTROPY_TEXTURE, info)
            for path, number in zip((gltf.STRENGTH, gltf.ROTATION), numbers, strict=True):
                _put(self.data, path, written(number))

    def _set_attenuation(self) -> None:
        distance = self._inputs.get("attenuation_distance")
        if distance is not None and distance.value is not None and distance.value[0] > 0.0:
            _put(self.data, gltf.ATTENUATION_DISTANCE, written(distance.value[0]))


def _wanted(
    terms: dict[gltf.Property, Term], textured: dict[gltf.Property, Term], ignored: str
) -> dict[int, Channel | None]:
    """The channels that a texture has to have for the properties that share it."""
    wanted: dict[int, Channel | None] = {}
    for prop, value in terms.items():
        if prop in textured and value.lookup is not None:
            channels = value.channels * (len(prop.channels) // len(value.channels))
            for target, channel in zip(prop.channels, channels, strict=True):
                wanted[target] = Channel(value.lookup, channel, prop.encoded and target < 3)
        elif prop.input != ignored and np.any(value.offset != 0.0):  # its factor is multiplied by the channel
            wanted |= dict.fromkeys(prop.channels)
    return wanted


def _put(data: dict[str, Any], path: gltf.Path, value: Any) -> None:
    for key in path[:-1]:
        data = data.setdefault(key, {})
    data[path[-1]] = value
