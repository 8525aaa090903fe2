"""A node of a surface model in a document of its own, with terms as inputs: for the reference to evaluate."""

from __future__ import annotations

from typing import TYPE_CHECKING

import MaterialX as mx
import numpy as np

from mrm_mtlx.formats.pbr.term import ENCODED, Term

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike

    from mrm_mtlx.formats.pbr.placement import Placement
    from mrm_mtlx.formats.pbr.term import Lookup


# The name of the node.
MODEL = "model"


def model_document(library: mx.Document, category: str, inputs: Mapping[str, Term | int]) -> mx.Document:
    """A document with a node of a surface model, `MODEL`, that has these inputs."""
    document = mx.createDocument()
    document.setDataLibrary(library)
    node = document.addNode(category, MODEL, "surfaceshader")
    definitions = document.getMatchingNodeDefs(category)  # this library's has an input more
    for name, value in inputs.items():
        kind = next(found.getType() for each in definitions if (found := each.getActiveInput(name)) is not None)
        given = node.addInput(name, kind)
        if isinstance(value, Term) and value.lookup is not None:
            given.setNodeName(_node_of(document, value, value.lookup, kind))
        else:
            given.setValueString(text_of(value.offset if isinstance(value, Term) else value))
    return document


def text_of(value: ArrayLike) -> str:
    """Numbers as documents have them, with all digits."""
    return ", ".join(repr(x) for x in np.atleast_1d(np.asarray(value)).tolist())


def _node_of(document: mx.Document, value: Term, lookup: Lookup, kind: str) -> str:
    """The name of the node that an image times a number plus a number is."""
    image = document.addNode("image", document.createValidChildName("image"), "color4")
    file = image.addInput("file", "filename")
    file.setValueString(lookup.file)
    file.setColorSpace(ENCODED if lookup.encoded else "lin_rec709")
    for name, mode in zip(("uaddressmode", "vaddressmode", "filtertype"), (*lookup.modes, lookup.filter), strict=True):
        image.addInput(name, "string").setValueString(mode)
    image.addInput("texcoord", "vector2").setNodeName(_place(document, lookup.placement))
    numbers = zip(value.channels, value.scale, value.offset, strict=True)
    parts = [_channel(document, image.getName(), *part) for part in numbers]
    if len(parts) == 1:
        return parts[0]
    joined = document.addNode("combine3", document.createValidChildName("joined"), kind)
    for k, part in enumerate(parts):
        joined.addInput(f"in{k + 1}", "float").setNodeName(part)
    return str(joined.getName())


def _channel(document: mx.Document, image: str, channel: int, scale: float, offset: float) -> str:
    """The name of the node that is a channel of an image times a number plus a number."""
    part = document.addNode("extract", document.createValidChildName("channel"), "float")
    part.addInput("in", "color4").setNodeName(image)
    part.addInput("index", "integer").setValueString(str(channel))
    for category, number in (("multiply", scale), ("add", offset)):
        made = document.addNode(category, document.createValidChildName(category), "float")
        made.addInput("in1", "float").setNodeName(part.getName())
        made.addInput("in2", "float").setValueString(text_of(number))
        part = made
    return str(part.getName())


def _place(document: mx.Document, placement: Placement) -> str:
    """The name of the node of texture coordinates (a u + b v + c, d u + e v + f)."""
    texcoord = document.addNode("texcoord", document.createValidChildName("texcoord"), "vector2")
    place = document.addNode("combine2", document.createValidChildName("place"), "vector2")
    rows = ((placement.a, placement.b, placement.c), (placement.d, placement.e, placement.f))
    for k, (along, across, moved) in enumerate(rows):
        product = document.addNode("dotproduct", document.createValidChildName("product"), "float")
        product.addInput("in1", "vector2").setNodeName(texcoord.getName())
        product.addInput("in2", "vector2").setValueString(text_of([along, across]))
        added = document.addNode("add", document.createValidChildName("sum"), "float")
        added.addInput("in1", "float").setNodeName(product.getName())
        added.addInput("in2", "float").setValueString(text_of(moved))
        place.addInput(f"in{k + 1}", "float").setNodeName(added.getName())
    return str(place.getName())
