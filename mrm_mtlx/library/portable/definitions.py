"""The portable form of the node library: its nodes defined by graphs of standard nodes, without any source."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.library.assembly import node_library_files, served
from mrm_mtlx.library.load import DataLibrary, Origin, load_library, set_data_library
from mrm_mtlx.library.portable.expressions import Expressions
from mrm_mtlx.library.portable.lobes import replace_lobe
from mrm_mtlx.library.surface_models import FLAG, MICROFACET_NODES, PARTIAL_NODES

if TYPE_CHECKING:
    from collections.abc import Iterable

# Of the node library: definitions with the flag, those of nodes that MaterialX has not, and the graphs of these.
_FLAGGED, _NEW, _GRAPHS = "mrm_defs.mtlx", "mrm_node_defs.mtlx", "mrm_ng.mtlx"
_FLAGGED_GRAPHS = "mrm_flag_ng.mtlx"


def portable_library_files(version: str) -> dict[str, bytes]:
    """Contents of the portable form for a version of MaterialX, by path relative to its folder, sorted.

    Its definitions with the flag have names of their own, and the ordinary nodes in their graphs name the standard
    definitions, so that both may be loaded in any order. A node with the flag finds them where the standard definition
    has no such input, before 1.39.5, or where they are loaded first; then they serve nodes without the flag, too, with
    the same reflection. What such a node lets through in a layer is another amount.

    Raises
    ------
    LookupError
        If the library does not serve the version; the message says why.
    ValueError
        If it is no version.
    """
    served(version)
    return {name: mx.writeToXmlString(document).encode() for name, document in sorted(_documents().items())}


@cache
def load_portable_library() -> DataLibrary:
    """The portable form of the node library before the standard library of the installed MaterialX."""
    standard = load_library(Origin.UPSTREAM)
    document = mx.createDocument()
    for part in _documents().values():
        document.importLibrary(part)
    document.importLibrary(standard.document)
    return DataLibrary(Origin.MRM, document, standard.search_path)


@cache
def _documents() -> dict[str, mx.Document]:
    """The files, as documents."""
    files = node_library_files("1.39.5")  # definitions and graphs are those of all versions
    documents = {name: mx.createDocument() for name in (_FLAGGED, _NEW, _GRAPHS, _FLAGGED_GRAPHS)}
    for name in (_FLAGGED, _NEW, _GRAPHS):
        mx.readFromXmlString(documents[name], files[name].decode())
    for category in MICROFACET_NODES:
        definition = documents[_FLAGGED].getNodeDef(f"ND_{category}")
        definition.setName(_definition(category))
        _add_graph(documents[_FLAGGED_GRAPHS], definition)
    for name in PARTIAL_NODES:
        _name_definitions(documents[_GRAPHS].getNodeGraph(f"NG_{name}").getNodes())
    return documents


def _definition(category: str) -> str:
    return f"ND_mrm_portable_{category}"


def _add_graph(document: mx.Document, definition: Any) -> None:
    """Add the graph of a definition with the flag: the aligned lobe, and the ordinary one beside it."""
    # Found while it is made, and not written: what the standard nodes have as defaults.
    workshop = mx.createDocument()
    set_data_library(workshop, load_library(Origin.UPSTREAM).document)
    category = str(definition.getNodeString())
    graph = workshop.addNodeGraph(f"NG_mrm_portable_{category}")
    lobe = graph.addNode(category, "lobe", "BSDF")
    for declared in definition.getInputs():
        lobe.addInput(declared.getName(), declared.getType()).setInterfaceName(declared.getName())
    replace_lobe(lobe, Expressions(graph, "retro"), of_standard_library=True)
    graph.addOutput("out", "BSDF").setNodeName("lobe")
    added = document.addNodeGraph(graph.getName())
    added.copyContentFrom(graph)
    added.setNodeDefString(definition.getName())


def _name_definitions(nodes: Iterable[Any]) -> None:
    """Let the two parts of a partly retroreflective lobe say which definition they mean."""
    for node in nodes:
        flag = node.getInput(FLAG)
        if flag is None:
            continue
        if flag.getValue():
            node.setNodeDefString(_definition(node.getCategory()))
        else:
            node.removeInput(FLAG)
            node.setNodeDefString(f"ND_{node.getCategory()}")
