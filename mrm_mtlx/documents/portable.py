"""A document in nodes of the standard library alone: ordinary lobes that are turned toward the viewer.

It needs no node library, no source and no flag, so that any host draws it that has MaterialX 1.39; how near it comes is
in docs/portable.md.
"""

from __future__ import annotations

from itertools import chain, count
from typing import TYPE_CHECKING, Any

import MaterialX as mx

from mrm_mtlx.documents.elements import location, nodes_of
from mrm_mtlx.documents.flattening import flatten
from mrm_mtlx.findings import rules
from mrm_mtlx.library import Origin, load_library
from mrm_mtlx.library.load import definitions_for, set_data_library
from mrm_mtlx.library.portable.expressions import Expressions
from mrm_mtlx.library.portable.lobes import is_on, is_weighed, replace_lobe, weigh_mixture
from mrm_mtlx.library.surface_models import MICROFACET_NODES, PARTIAL_NODES, SURFACE_MODELS, amount_input

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.findings.finding import Finding

# Of the node library, by graphs.
_OWN_NODES = (*PARTIAL_NODES, "mrm_prismatic_weight", "mrm_cube_corner_share")
_OWN_MODELS = {model.definition for model in SURFACE_MODELS}
# Inputs without which there is no thin film.
_FILMS = {
    **dict.fromkeys((*MICROFACET_NODES, *PARTIAL_NODES), "thinfilm_thickness"),
    "open_pbr_surface": "thin_film_weight",
    "standard_surface": "thin_film_thickness",
    "gltf_pbr": "iridescence",
}
# Names of the nodes that are made begin with it.
_PREFIX = "retro"
# Up to this width, accuracy is promised, for equal widths; MaterialX holds numbers in single precision.
WIDEST_ALPHA = 0.1
_ROUNDED = 1e-6


def portable(document: mx.Document) -> tuple[mx.Document, list[Finding]]:
    """A copy of a valid document without anything that is not in the standard library, and what it has lost.

    Nodes of the node library and surface models with an amount are replaced by the nodes that they are made of, and
    retroreflective lobes by `library.portable.lobes.replace_lobe`. All else stays.

    Raises
    ------
    ValueError
        If nodes cannot be replaced by those of their graphs, as `documents.flattening.flatten`.
    """
    copy = document.copy()
    set_data_library(copy, definitions_for(document))
    lost = [found for node in nodes_of(copy) for found in _lost(node)]
    for graph in [copy, *(child for child in copy.getChildren() if child.isA(mx.NodeGraph))]:
        _open_own(graph)
        _replace_lobes(graph)
    set_data_library(copy, load_library(Origin.UPSTREAM).document)
    return copy, lost


def _open_own(graph: Any) -> None:
    """Replace what is not in the standard library by the nodes that it is made of, under names of their own."""
    before = {str(node.getName()) for node in graph.getNodes()}
    flatten(graph, _is_own)
    made = [node for node in graph.getNodes() if node.getName() not in before]
    prefix = _free_prefix(graph)
    names = {str(node.getName()): graph.createValidChildName(f"{prefix}_{node.getName()}") for node in made}
    for node in made:
        node.setName(names[str(node.getName())])
    # Graphs of other names take nothing of what is inside of this one but by its outputs.
    for child in (*graph.getNodes(), *graph.getOutputs()):
        for port in child.getInputs() if child.isA(mx.Node) else [child]:
            if port.getNodeName() in names:
                port.setNodeName(names[port.getNodeName()])


def _replace_lobes(graph: Any) -> None:
    """Replace the retroreflective lobes of a graph, and what is mixed of them."""
    nodes = Expressions(graph, _free_prefix(graph))
    lobes = [node for node in graph.getNodes() if node.getCategory() in MICROFACET_NODES]
    todo = [node for node in lobes if replace_lobe(node, nodes)]
    while todo:
        mixtures = [port.getParent() for node in todo for port in node.getDownstreamPorts() if port.isA(mx.Input)]
        todo = list({node.getName(): node for node in mixtures if is_weighed(node)}.values())
        for node in todo:
            weigh_mixture(node, nodes)


def _free_prefix(graph: Any) -> str:
    """A prefix of which no name in the document begins: a shader has the nodes of all graphs under their own names."""
    names = [str(element.getName()) for element in graph.getDocument().traverseTree()]
    prefixes = chain([_PREFIX], (f"{_PREFIX}{number}" for number in count(2)))
    return next(prefix for prefix in prefixes if not any(name.startswith(f"{prefix}_") for name in names))


def _is_own(node: Any) -> bool:
    """True for a node of the node library, and for a surface model with an amount."""
    if node.getCategory() in _OWN_NODES:
        return True
    definition = node.getNodeDef() if amount_input(node) else None
    return definition is not None and definition.getName() in _OWN_MODELS


def _lost(node: Any) -> Iterator[Finding]:
    """Findings on what a retroreflective node says and its portable form does not."""
    if not (_is_own(node) or (node.getCategory() in MICROFACET_NODES and is_on(node))):
        return
    film = node.getInput(_FILMS.get(node.getCategory(), ""))
    if film is not None and not (film.getValueString() and film.getValue() == 0.0):
        message = "its thin film is left out: the portable form reflects as the surface under the film does"
        yield rules.INTERCHANGE_LOST.at(location(film), message)
    tops = [port for port in node.getDownstreamPorts() if port.getName() == "top"]
    if tops and node.getCategory().endswith("conductor_bsdf"):
        message = "a metal hides what it covers, and its portable form lets through what it does not reflect"
        yield rules.INTERCHANGE_LOST.at(location(node), message)
    widths = node.getInput("roughness")
    if widths is None or not widths.getValueString() or widths.getType() != "vector2":
        return
    along, across = widths.getValue().asTuple()
    if max(along, across) > WIDEST_ALPHA + _ROUNDED:
        message = f"a width of {max(along, across):g} is beyond {WIDEST_ALPHA:g}, up to which the portable form is near"
        yield rules.INTERCHANGE_LOST.at(location(widths), f"{message} (docs/portable.md)")
    elif along != across:
        message = "a lobe of two widths keeps its energy in the portable form, and not its shape (docs/portable.md)"
        yield rules.INTERCHANGE_LOST.at(location(widths), message)
