"""Retroreflectivity of whole surface models: the installed library's own definitions and graphs, with one input more.

OpenPBR 1.2 (draft) blends the BRDFs of its base with their retroreflective twins, (1 - w) f + w f_retro, and leaves
transmission, coat and fuzz alone. A model's copy does so: in its graph, the reflecting microfacet nodes of the base are
nodes of partial retroreflection (mrm_ng.mtlx), and their amount is the new input. Nothing else of the copy differs from
what is installed, so that it follows the MaterialX version at hand.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import MaterialX as mx

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

MICROFACET_NODES = ("conductor_bsdf", "dielectric_bsdf", "generalized_schlick_bsdf")
# Of the node library: the same with an amount in the place of the flag.
PARTIAL_NODES = tuple(f"mrm_{name}" for name in MICROFACET_NODES)
FLAG, AMOUNT = "retroreflective", "retroreflectivity"

_DOC = (
    "Share of the base's specular reflection, of metal and of dielectric, that goes back to where the light comes "
    "from, from 0 (ordinary) to 1 (all); 0.5 is the average of both. Transmission, coat and {cloth} stay as they are. "
    "Can be connected to an image; no unit."
)


@dataclass(frozen=True)
class SurfaceModel:
    """A surface model, and the input that it gets.

    Attributes
    ----------
    node
        Category of its node.
    amount
        Name of the new input: float, 0 to 1, by default 0.
    roughness
        Its input on which the widths of the base's lobes depend, and those of no other reflecting lobe.
    cloth
        What the model calls its outermost layer, for the documentation of the input.
    """

    node: str
    amount: str
    roughness: str
    cloth: str

    @property
    def definition(self) -> str:
        """Name of the extended node definition."""
        return f"ND_mrm_{self.node}_surfaceshader"

    @property
    def graph(self) -> str:
        """Name of the extended graph."""
        return f"NG_mrm_{self.node}_surfaceshader"


SURFACE_MODELS = (
    # The name is that of OpenPBR's branch dev_1.2; the other two models have no specification of it.
    SurfaceModel("open_pbr_surface", "specular_retroreflectivity", "specular_roughness", "fuzz"),
    SurfaceModel("standard_surface", AMOUNT, "specular_roughness", "sheen"),
    SurfaceModel("gltf_pbr", AMOUNT, "roughness", "sheen"),
)


@dataclass(frozen=True)
class Extension:
    """A surface model with its input or without: `reason` says why it lacks the input, "" if it has it."""

    model: SurfaceModel
    reason: str = ""


def amount_input(node: Any) -> str:
    """Name of the input by which a node is retroreflective to an amount, "" if its definition has none."""
    names = [AMOUNT] if node.getCategory() in PARTIAL_NODES else amounts_of(node.getCategory())
    definition = node.getNodeDef() if names else None
    return next((name for name in names if definition is not None and definition.getActiveInput(name) is not None), "")


def amounts_of(category: str) -> list[str]:
    """Names of the amounts of surface models of a node category, whether or not a library has them."""
    return [model.amount for model in SURFACE_MODELS if model.node == category]


def extend(document: mx.Document, models: Iterable[SurfaceModel] = SURFACE_MODELS) -> tuple[Extension, ...]:
    """Add the extended definitions and graphs to a loaded library that has the standard one and ours.

    They come after the standard ones. A document's node takes the first definition that has all of its inputs, so that
    one without the new input keeps the standard definition, and its cost.

    A model whose graph is not as expected is left out, and its `Extension` says why.
    """
    # All are looked up before any is added: a search after a change reads the whole library again.
    plans = [_plan(document, model) for model in models]
    for plan in plans:
        if plan.base:
            _add_definition(document, plan)
            _add_graph(document, plan)
    return tuple(Extension(plan.model, plan.reason) for plan in plans)


@dataclass(frozen=True)
class _Plan:
    """Definition and graph to copy, and the nodes that change in it; nothing where there is a reason against it."""

    model: SurfaceModel
    reason: str = ""
    definition: Any = None
    graph: Any = None
    base: tuple[str, ...] = ()


def _plan(document: mx.Document, model: SurfaceModel) -> _Plan:
    definition = default_definition(document, model.node)
    if definition is None:
        return _Plan(model, f"this MaterialX has no '{model.node}'")
    if definition.getActiveInput(model.amount) is not None:
        return _Plan(model)  # a MaterialX that knows it: its own meaning counts
    if definition.getActiveInput(model.roughness) is None:
        return _Plan(model, f"its definition has no input '{model.roughness}'")
    graph = definition.getImplementation("")
    if graph is None or not graph.isA(mx.NodeGraph):
        return _Plan(model, "it is not defined by a graph")
    base = _base_lobes(graph, model.roughness)
    if not base:
        return _Plan(model, f"no reflecting microfacet node of its graph takes its width from '{model.roughness}'")
    flagged = [str(node.getName()) for node in base if node.getInput(FLAG) is not None]
    if flagged:
        return _Plan(model, f"its graph gives '{flagged[0]}' an input '{FLAG}' already")
    return _Plan(model, "", definition, graph, tuple(str(node.getName()) for node in base))


def default_definition(document: mx.Document, node: str) -> Any:
    """The definition that a document gets which asks for no version, or None."""
    found = [d for d in document.getMatchingNodeDefs(node) if d.getType() == "surfaceshader"]
    return next((d for d in found if d.getDefaultVersion() or not d.getVersionString()), None)


def _base_lobes(graph: Any, roughness: str) -> list[Any]:
    """The reflecting microfacet nodes of a graph whose width depends on an input of the graph's interface."""
    lobes = [node for node in graph.getNodes() if node.getCategory() in MICROFACET_NODES]
    return [node for node in lobes if _reflects(node) and roughness in _interface_names(node.getInput("roughness"))]


def _reflects(node: Any) -> bool:
    mode = node.getInput("scatter_mode")
    return mode is None or mode.getValueString() != "T"


def _interface_names(given: Any) -> Iterator[str]:
    """Interface inputs of its graph on which a node's input depends."""
    todo, seen = ([] if given is None else [given]), set()
    while todo:
        current = todo.pop()
        if current.getInterfaceName():
            yield str(current.getInterfaceName())
        node = current.getConnectedNode()
        if node is not None and node.getName() not in seen:
            seen.add(node.getName())
            todo += node.getInputs()


def _add_definition(document: mx.Document, plan: _Plan) -> None:
    """A copy with the input, which stands before the output; with the version that was copied."""
    # A document that names another version does not get it: the copy is a model of this version, whatever more it has.
    model, definition = plan.model, plan.definition
    added = document.addChildOfCategory("nodedef", model.definition)
    added.copyContentFrom(definition)
    added.setDocString(f"{definition.getDocString()}, with {model.amount}".removeprefix(", "))
    given = added.addInput(model.amount, "float")
    given.setValue(0.0)
    given.setAttribute("uimin", "0.0")
    given.setAttribute("uimax", "1.0")
    given.setAttribute("uiname", "Retroreflectivity")
    folder = definition.getActiveInput(model.roughness).getAttribute("uifolder")
    if folder:
        given.setAttribute("uifolder", folder)
    given.setDocString(_DOC.format(cloth=model.cloth))
    outputs = added.getOutputs()
    if outputs:
        added.setChildIndex(model.amount, added.getChildIndex(outputs[0].getName()))


def _add_graph(document: mx.Document, plan: _Plan) -> None:
    """A copy in which the nodes of the base are retroreflective to the amount."""
    added = document.addNodeGraph(plan.model.graph)
    added.copyContentFrom(plan.graph)
    added.setNodeDefString(plan.model.definition)
    for name in plan.base:
        node = added.getNode(name)
        node.setCategory(f"mrm_{node.getCategory()}")
        node.removeAttribute("nodedef")  # of the node that it was
        node.addInput(AMOUNT, "float").setInterfaceName(plan.model.amount)
