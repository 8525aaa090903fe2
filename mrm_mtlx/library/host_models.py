"""Definitions that a host needs beside the node library: the extended surface models, and the flag where it is new."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.library.dialects import dialect
from mrm_mtlx.library.hosts import Choice
from mrm_mtlx.library.surface_models import (
    MICROFACET_NODES,
    SURFACE_MODELS,
    default_definition,
    extend,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from mrm_mtlx.library.standard_library import StandardLibrary
    from mrm_mtlx.library.surface_models import Extension

MODELS_FILE, FLAG_FILE = "mrm_surface_models.mtlx", "mrm_flagged_defs.mtlx"
# In the first line of the comment, where `models_version` looks for it.
_WRITTEN = "Written by `mrm library install` from MaterialX "

_MODELS_COMMENT = """
    {written}{version} (Copyright Contributors to the MaterialX Project, Apache
    License 2.0): its definitions and graphs of {models}.
    Changed: each has one input more, and the reflecting microfacet nodes of its base are those of the node library
    beside this file. {chosen} With another version of MaterialX, write it anew.
  """
_CHOSEN = {
    Choice.INPUTS: (
        "A node that has no such input gets the definition of MaterialX: a copy of each comes first, so that\n"
        "    the order in which the libraries are loaded does not matter."
    ),
    Choice.NAME: (
        "A document asks for one by the name of its definition: each has a category of its own, and the\n"
        "    standard ones stay as they are."
    ),
}
_FLAG_COMMENT = """
    The three microfacet nodes with their flag under other names. The MaterialX of this host has no such flag; where its
    definitions are found before those of the node library, documents that have the flag get these.
  """


@dataclass(frozen=True)
class HostModels:
    """The surface models of a host.

    Attributes
    ----------
    text
        Their definitions and graphs as a document; "" if there are none.
    extensions
        Which models have the new input, or why not.
    """

    text: str
    extensions: tuple[Extension, ...]


def surface_models_for(standard: StandardLibrary, choice: Choice) -> HostModels:
    """The extended surface models of a standard library, so that its MaterialX reads them.

    Every other document of the host keeps the standard models, in whatever order the host loads its libraries. With
    `Choice.NAME`, the definition `ND_mrm_open_pbr_surface_surfaceshader` is of a node `mrm_open_pbr_surface`; a
    document names it by its `nodedef`, a shader of USD by its `info:id`.

    Raises
    ------
    StandardLibraryError
        If a file cannot be read.
    """
    document = standard.surface_models()
    stock = {model.node: default_definition(document, model.node) for model in SURFACE_MODELS}
    extensions = extend(document)
    models = [model for model in SURFACE_MODELS if document.getNodeDef(model.definition) is not None]
    if not models:
        return HostModels("", extensions)
    alone = mx.createDocument()
    alone.addChildOfCategory("comment").setDocString(
        _MODELS_COMMENT.format(
            written=_WRITTEN,
            version=standard.version,
            models=", ".join(model.node for model in models),
            chosen=_CHOSEN[choice],
        )
    )
    for model in models:
        if choice is Choice.INPUTS:
            _copy(stock[model.node], alone)
        definition = _copy(document.getNodeDef(model.definition), alone)
        if choice is Choice.NAME:
            definition.setNodeString(f"mrm_{model.node}")
        _copy(document.getNodeGraph(model.graph), alone)
    return HostModels(_xml(alone), extensions)


def with_standard_nodes(files: Mapping[str, bytes], standard: StandardLibrary) -> dict[str, bytes]:
    """The portable form, with the standard definitions of its nodes before its own.

    A node without the flag gets the first definition of its category: else a graph of ours would serve each BSDF in the
    standard surface models, where it lets another amount of light through to the layers below.

    Raises
    ------
    StandardLibraryError
        If a file cannot be read.
    """
    stock = standard.nodes()
    return {name: _with_standard(text, stock) if name.endswith(".mtlx") else text for name, text in files.items()}


def without_standard_nodes(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """What `with_standard_nodes` was given, in MaterialX's own formatting."""
    return {name: _without_standard(text) if name.endswith(".mtlx") else text for name, text in files.items()}


def _without_standard(text: bytes) -> bytes:
    part = _parsed(text)
    for name in (f"ND_{node}" for node in MICROFACET_NODES):
        if part.getNodeDef(name) is not None:
            part.removeNodeDef(name)
    return _xml(part).encode()


def _with_standard(text: bytes, stock: mx.Document) -> bytes:
    part, merged = _parsed(text), mx.createDocument()
    categories = {definition.getNodeString() for definition in part.getNodeDefs()} & set(MICROFACET_NODES)
    if not categories:
        return text
    for definition in stock.getNodeDefs():
        if definition.getNodeString() in categories:
            _copy(definition, merged)
    for element in part.getChildren():
        _copy(element, merged)
    return _xml(merged).encode()


def models_version(text: str) -> str:
    """The version of MaterialX that a file of surface models was made from; "" for another text."""
    _, found, rest = text.partition(_WRITTEN)
    return rest.split(" ", 1)[0] if found else ""


def flagged_definitions(files: Mapping[str, bytes], version: str) -> str:
    """The microfacet nodes with their flag as definitions of other names, of a node library; "" if there is no need.

    A host that resolves a document's nodes by the standard library before ours, as UsdMtlx does, knows no definition
    with the flag before MaterialX 1.39.5, and drops the node.
    """
    if dialect(version).has_retroreflective:
        return ""
    alone = mx.createDocument()
    alone.addChildOfCategory("comment").setDocString(_FLAG_COMMENT)
    parts = {PurePosixPath(name): _parsed(text) for name, text in files.items() if name.endswith(".mtlx")}
    names = {f"ND_{node}": f"ND_mrm_flagged_{node}" for node in MICROFACET_NODES}
    for part in parts.values():
        for definition in (part.getNodeDef(name) for name in names):
            if definition is not None:
                for known in part.getTypeDefs():
                    if alone.getTypeDef(known.getName()) is None:
                        _copy(known, alone)
                _copy(definition, alone, names[definition.getName()])
    for path, part in parts.items():
        for implementation in part.getImplementations():
            name = names.get(implementation.getNodeDefString())
            if name:
                added = _copy(implementation, alone, f"{implementation.getName()}_flagged")
                added.setNodeDefString(name)
                added.setFile(str(path.parent / implementation.getFile()))
    return _xml(alone)


def _parsed(text: bytes) -> mx.Document:
    document = mx.createDocument()
    mx.readFromXmlString(document, text.decode())
    return document


def _copy(element: Any, document: mx.Document, name: str = "") -> Any:
    added = document.addChildOfCategory(element.getCategory(), name or element.getName())
    added.copyContentFrom(element)
    return added


def _xml(document: mx.Document) -> str:
    options = mx.XmlWriteOptions()
    options.writeXIncludeEnable = False  # the copies still name the files that they come from
    return str(mx.writeToXmlString(document, options))
