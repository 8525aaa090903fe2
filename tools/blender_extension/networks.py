"""A ready material as a USD network for Hydra Storm."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.documents.graph import defining_graph
from mrm_mtlx.library.surface_models import SURFACE_MODELS
from mrm_mtlx.shadergen.usd.network import generate_network

if TYPE_CHECKING:
    from mrm_mtlx.api.opening import OpenDocument


def network(opened: OpenDocument) -> str:
    """The only material of a document as the text of a layer, below `/Materials`.

    An extended surface model becomes its graph: a Blender has no definition of it, and if it had, would use that for
    each OpenPBR of its own.

    Raises
    ------
    GenerationError
        If the network would be less than the material.
    """
    (element,) = opened.elements
    document = opened.document.copy()
    document.setDataLibrary(opened.library.document)
    for definition in map(opened.library.document.getNodeDef, (model.definition for model in SURFACE_MODELS)):
        if definition is not None and any(node.getNodeDef() == definition for node in document.getNodes()):
            graph = defining_graph(definition)
            document.addChildOfCategory("nodedef", definition.getName()).copyContentFrom(definition)
            document.addNodeGraph(graph.getName()).copyContentFrom(graph)
    return generate_network(document.getChild(element), "storm").sources["pixel"]
