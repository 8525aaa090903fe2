"""Microfacet nodes in a graph, replaced by the ordinary ones that stand for them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mrm_mtlx.library.load import definitions_for
from mrm_mtlx.library.portable.aligned import aligned_lobe, conductor, dielectric, schlick
from mrm_mtlx.library.surface_models import FLAG

if TYPE_CHECKING:
    from mrm_mtlx.library.portable.aligned import AlignedLobe, Part
    from mrm_mtlx.library.portable.expressions import Expressions, Value

_METAL = "conductor_bsdf"
_REFLECTANCES = {_METAL: conductor, "dielectric_bsdf": dielectric, "generalized_schlick_bsdf": schlick}
# Inputs whose default is no number, and the nodes that give it.
_GEOMETRY = ("normal", "tangent")
# Inputs that do nothing at their default, or are no numbers.
_LEFT_OUT = ("color82", "thinfilm_thickness", "thinfilm_ior", "distribution", "scatter_mode", FLAG)
_MODE = "scatter_mode"


def is_on(lobe: Any) -> bool:
    """True if the flag of a microfacet node is on, or the value of something else; and if the node reflects."""
    given = lobe.getInput(FLAG)
    return given is not None and given.getValueString() != "false" and _scatters(lobe) != "T"


def replace_lobe(lobe: Any, nodes: Expressions, *, of_standard_library: bool = False) -> None:
    """Make a microfacet node what stands for it as its flag says, of nodes of the standard library alone.

    With the flag on it becomes the sum of two ordinary lobes, see `aligned_lobe`; off, it loses the flag; of a flag that
    comes from elsewhere, both, of which one has no weight. What transmits stays as it is, and a thin film is left out.

    Parameters
    ----------
    lobe
        The node. Its name stays, and with it what is connected to it.
    nodes
        Of the same graph or document.
    of_standard_library
        Whether ordinary nodes name their definition, because another one of the same category is there.
    """
    replaced = is_on(lobe)
    flag = lobe.getInput(FLAG)
    if replaced:
        _replace(lobe, nodes, None if flag.getValueString() else nodes.given(flag), of_standard_library)
    elif flag is not None:
        lobe.removeInput(FLAG)


def _replace(lobe: Any, nodes: Expressions, flag: Value | None, of_standard_library: bool) -> None:
    """With a flag, that is a boolean by which the lobe is the aligned one or the ordinary one."""
    inputs = _inputs(lobe, nodes)
    found = aligned_lobe(nodes, inputs, _REFLECTANCES[lobe.getCategory()])
    weight, mode = inputs["weight"], _scatters(lobe)
    parts = []
    if flag is not None:
        zero = nodes.constant(0.0)
        parts.append(_ordinary(lobe, nodes, _chosen(nodes, flag, zero, weight), mode))
        weight = _chosen(nodes, flag, weight, zero)
    if mode == "RT":
        parts.append(_ordinary(lobe, nodes, weight, "T"))
    lobes = [_ordinary_lobe(lobe, nodes, found, part, weight) for part in (found.core, found.wing)]
    if of_standard_library:
        for node in (*parts, *lobes):
            node.setNodeDefString(f"ND_{node.getCategory()}")
    _become_sum(lobe, nodes, [*parts, *_colored(lobe, nodes, lobes, found.color)])


def _scatters(lobe: Any) -> str:
    mode = lobe.getInput(_MODE)
    return "R" if mode is None else str(mode.getValueString()) or "R"


def _inputs(lobe: Any, nodes: Expressions) -> dict[str, Value]:
    """The numbers that the node is given or has by default, colours as vectors."""
    found = {}
    for declared in definitions_for(lobe).getNodeDef(f"ND_{lobe.getCategory()}").getActiveInputs():
        name, kind = str(declared.getName()), str(declared.getType())
        given = lobe.getInput(name)
        value = None if given is None else nodes.given(given)
        if value is not None and not (value.source.keys() - {"value"} or (value.source and name not in _GEOMETRY)):
            value = None  # generators pass over numbers where a direction is due
        if value is not None and name not in _LEFT_OUT[1:]:
            found[name] = value.converted("vector3") if kind == "color3" else value
        elif value is None and name in _GEOMETRY:
            found[name] = nodes.node(name, kind, {}, space="world")
        elif value is None and name not in _LEFT_OUT:
            number = declared.getValue()
            numbers = float(number) if kind == "float" else tuple(number.asTuple())
            found[name] = nodes.constant(numbers, "vector3" if kind == "color3" else kind)
    return found


def _chosen(nodes: Expressions, flag: Value, then: Value, otherwise: Value) -> Value:
    inputs = {"value1": flag, "value2": nodes.yes(), "in1": then, "in2": otherwise}
    return nodes.node("ifequal", then.kind, inputs)


def _ordinary(lobe: Any, nodes: Expressions, weight: Value, mode: str) -> Any:
    """A copy of the node without the flag, with another weight and scatter mode."""
    made = nodes.added(lobe.getCategory(), "BSDF")
    for given in lobe.getInputs():
        if given.getName() not in ("weight", FLAG, _MODE):
            made.addInput(given.getName(), given.getType()).copyContentFrom(given)
    weight.given_to(made, "weight")
    if lobe.getCategory() != _METAL:
        made.setInputValue(_MODE, mode)
    return made


def _ordinary_lobe(lobe: Any, nodes: Expressions, found: AlignedLobe, part: Part, weight: Value) -> Any:
    """One part: a lobe of the same reflectance at every angle; of a metal, which hides what it covers, a white metal."""
    is_metal = lobe.getCategory() == _METAL
    made = nodes.added(_METAL if is_metal else "generalized_schlick_bsdf", "BSDF")
    (weight * part.share).given_to(made, "weight")
    if is_metal:
        # An index of 0 + 1i reflects everything.
        made.setInputValue("ior", (0.0, 0.0, 0.0), "color3")
        made.setInputValue("extinction", (1.0, 1.0, 1.0), "color3")
    else:
        color = found.color.converted("color3")
        color.given_to(made, "color0")
        color.given_to(made, "color90")
    part.roughness.given_to(made, "roughness")
    part.normal.given_to(made, "normal")
    part.tangent.given_to(made, "tangent")
    distribution = lobe.getInput("distribution")
    if distribution is not None:
        made.addInput("distribution", "string").copyContentFrom(distribution)
    return made


def _colored(lobe: Any, nodes: Expressions, lobes: list[Any], color: Value) -> list[Any]:
    """White lobes of a metal, times their colour; others as they are."""
    if lobe.getCategory() != _METAL:
        return lobes
    product = nodes.added("multiply", "BSDF")
    product.addInput("in1", "BSDF").setNodeName(_sum(nodes, lobes))
    color.converted("color3").given_to(product, "in2")
    return [product]


def _sum(nodes: Expressions, parts: list[Any]) -> str:
    """Name of a node that is the sum of BSDFs."""
    last = parts[0]
    for part in parts[1:]:
        made = nodes.added("add", "BSDF")
        made.addInput("in1", "BSDF").setNodeName(last.getName())
        made.addInput("in2", "BSDF").setNodeName(part.getName())
        last = made
    return str(last.getName())


def _become_sum(lobe: Any, nodes: Expressions, parts: list[Any]) -> None:
    """Let the node itself be the sum of BSDFs."""
    for given in lobe.getInputs():
        lobe.removeInput(given.getName())
    lobe.removeAttribute("nodedef")
    if len(parts) == 1:  # the product of a metal
        lobe.setCategory(parts[0].getCategory())
        for given in parts[0].getInputs():
            lobe.addInput(given.getName(), given.getType()).copyContentFrom(given)
        parts[0].getParent().removeNode(parts[0].getName())
        return
    lobe.setCategory("add")
    lobe.addInput("in1", "BSDF").setNodeName(_sum(nodes, parts[:-1]))
    lobe.addInput("in2", "BSDF").setNodeName(parts[-1].getName())

