"""The graph of textures of one material: MaterialX's gltf_* nodes, and arithmetic between them and its outputs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from mrm_mtlx.formats.pbr.term import ENCODED

if TYPE_CHECKING:
    import MaterialX as mx

    from mrm_mtlx.formats.gltf.importer.textures import Texture


class Graph:
    """A node graph that is made when it is first needed.

    Its methods make nodes, once for all that ask for the same; `output` connects one to an input of the surface.
    """

    def __init__(self, document: mx.Document, name: str, source_locations: dict[str, str]) -> None:
        self._document, self._name, self._source_locations = document, name, source_locations
        self._graph: Any = None
        self._made: dict[Any, Any] = {}

    def finish(self, place: str) -> None:
        """Say where in the asset the graph lies as a whole."""
        if self._graph is not None:
            self._source_locations[self._name] = place

    def output(self, name: str, node: Any, which: str = "") -> Any:
        """An output of the graph with what a node gives; `which` of a node with several."""
        output = self._graph.addOutput(self._graph.createValidChildName(name), "float" if which else node.getType())
        output.setNodeName(node.getName())
        if which:
            output.setOutputString(which)
        return output

    def channels(self, use: Texture, channels: tuple[int, ...]) -> Any:
        """Channels of a texture: three as a linear colour, one as a number."""
        if len(channels) == 1:
            return self._channel(use, *channels)
        if _key("color4", use) not in self._made:
            return self._image(use, "color3", encoded=True)
        # Where the alpha is needed as well, the image is read once.
        colors = {"in": self._image(use, "color4", encoded=True)}
        return self._shared(_key("rgb", use), "convert", "color3", f"texture_{use.number}_rgb", colors)

    def multiplied(self, node: Any, factor: tuple[float, ...], name: str) -> Any:
        """A node's value times a factor; the factor stands outside of image nodes, which linearise what they give."""
        if all(x == 1.0 for x in factor):
            return node
        return self._node("multiply", node.getType(), name, {"in1": node, "in2": factor})

    def between(self, low: Any, high: Any, amount: Any, name: str) -> Any:
        """A number from `low` to `high` by an amount; each is a node, or a tuple of one number."""
        return self._node("mix", "float", name, {"bg": low, "fg": high, "mix": amount})

    def reaching(self, node: Any, least: float, name: str) -> Any:
        """1 where a number is at least another, and 0 elsewhere."""
        inputs = {"value1": node, "value2": (least,), "in1": (1.0,), "in2": (0.0,)}
        return self._node("ifgreatereq", "float", name, inputs)

    def normal(self, use: Texture, scale: float) -> Any:
        """The normal of a normal texture, whose x and y are scaled."""
        if scale == 1.0:
            return self._image(use, "vector3", category="gltf_normalmap")
        inputs = {"in": self._image(use, "vector3"), "scale": (scale,)}
        return self._node("normalmap", "vector3", f"texture_{use.number}_normal", inputs)

    def anisotropy(self, use: Texture, strength: float, rotation: float) -> Any:
        """Strength and rotation of an anisotropy texture, a node with two outputs."""
        node = self._image(use, "multioutput", category="gltf_anisotropy_image")
        self._give(node, "anisotropy_strength", "float", (strength,))
        self._give(node, "anisotropy_rotation", "float", (rotation,))
        return node

    def _channel(self, use: Texture, channel: int) -> Any:
        if channel == 0:
            return self._image(use, "float")
        # The encoding of a colour leaves its alpha, whichever the image has.
        image = self._image(use, "color4", encoded=True) if channel == 3 else self._image(use, "vector3")
        name = f"texture_{use.number}_{'rgba'[channel]}"
        return self._shared(_key(channel, use), "extract", "float", name, {"in": image, "index": (channel,)})

    def _image(self, use: Texture, kind: str, encoded: bool = False, category: str = "gltf_image") -> Any:
        key = _key(kind if category == "gltf_image" else category, use)
        if key not in self._made:
            node = self._made[key] = self._add(category, kind, f"texture_{use.number}")
            self._source_locations[node.getNamePath()] = use.place
            file = node.addInput("file", "filename")
            file.setValueString(use.file)
            self._source_locations[file.getNamePath()] = use.image_place
            if encoded:
                file.setColorSpace(ENCODED)
            self._look_up(node, use)
        return self._made[key]

    def _look_up(self, node: Any, use: Texture) -> None:
        if use.texcoord:
            name = f"texcoord_{use.texcoord}"
            place = self._shared(name, "texcoord", "vector2", name, {"index": (use.texcoord,)})
            self._give(node, "texcoord", "vector2", place)
        if use.scale != (1.0, 1.0):
            self._give(node, "scale", "vector2", use.scale)
        if use.rotation:
            self._give(node, "rotate", "float", (math.degrees(use.rotation),))
        if use.offset != (0.0, 0.0):
            self._give(node, "offset", "vector2", use.offset)
        if node.getType() == "color4":
            # KHR_texture_transform scales, rotates, then moves; so do the others by default.
            self._give(node, "operationorder", "integer", (0,))
        for name, mode in zip(("uaddressmode", "vaddressmode"), use.modes, strict=True):
            if mode != "periodic":
                node.addInput(name, "string").setValueString(mode)
        if use.filter != "linear":
            node.addInput("filtertype", "string").setValueString(use.filter)

    def _shared(self, key: Any, category: str, kind: str, name: str, inputs: dict[str, Any]) -> Any:
        if key not in self._made:
            self._made[key] = self._node(category, kind, name, inputs)
        return self._made[key]

    def _node(self, category: str, kind: str, name: str, inputs: dict[str, Any]) -> Any:
        node = self._add(category, kind, name)
        for given, value in inputs.items():
            type_of_numbers = "integer" if given == "index" else "float" if kind == "vector3" else kind
            self._give(node, given, type_of_numbers if isinstance(value, tuple) else value.getType(), value)
        return node

    def _add(self, category: str, kind: str, name: str) -> Any:
        if self._graph is None:
            self._graph = self._document.addNodeGraph(self._name)
        return self._graph.addNode(category, self._graph.createValidChildName(name), kind)

    def _give(self, node: Any, name: str, kind: str, value: Any) -> None:
        given = node.addInput(name, kind)
        if isinstance(value, tuple):
            given.setValueString(", ".join(f"{x:.9g}" for x in value))
        else:
            given.setNodeName(value.getName())


def _key(what: Any, use: Texture) -> tuple[Any, Texture]:
    """The key of a node of a texture, wherever that is used."""
    return what, use._replace(place="")
