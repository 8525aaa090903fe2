"""Microfacet nodes in a graph, replaced by the ordinary ones that stand for them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mrm_mtlx.library.load import definitions_for
from mrm_mtlx.library.portable.aligned import aligned_lobe, conductor, dielectric, schlick
from mrm_mtlx.library.surface_models import FLAG

if TYPE_CHECKING:
    from mrm_mtlx.library.portable.aligned import AlignedLobe, Part
    from mrm_mtlx.library.portable.expressions import Expressions, Value

_SCHLICK = "generalized_schlick_bsdf"
_REFLECTANCES = {"conductor_bsdf": conductor, "dielectric_bsdf": dielectric, _SCHLICK: schlick}
_MODE = "scatter_mode"
# Inputs whose default is no number, and the nodes that give it.
_GEOMETRY = ("normal", "tangent")
# Inputs of which the aligned lobe takes no value.
_UNUSED = ("thinfilm_thickness", "thinfilm_ior", "distribution", _MODE, FLAG)
# Inputs that do nothing at their default.
_OPTIONAL = ("color82",)


def is_on(lobe: Any) -> bool:
    """True if the flag of a microfacet node is on, or the value of something else; and if the node reflects."""
    given = lobe.getInput(FLAG)
    return given is not None and given.getValueString() != "false" and _scatters(lobe) != "T"


def replace_lobe(lobe: Any, nodes: Expressions, *, of_standard_library: bool = False) -> bool:
    """Make a microfacet node what stands for it as its flag says, of nodes of the standard library alone.

    With the flag on it becomes the sum of two ordinary lobes, see `aligned_lobe`; off, it loses the flag; with a flag
    that comes from elsewhere, both, of which one has no weight. What transmits stays as it is, unless the scatter mode
    comes from elsewhere, too; a thin film is left out.

    Parameters
    ----------
    lobe
        The node. Its name stays, and with it what is connected to it.
    nodes
        Of the same graph or document.
    of_standard_library
        Whether ordinary nodes name their definition, because another one of the same category is there.

    Returns
    -------
    bool
        Whether it became a sum.
    """
    flag = lobe.getInput(FLAG)
    if not is_on(lobe):
        if flag is not None:
            lobe.removeInput(FLAG)
        return False
    inputs = _inputs(lobe, nodes)
    found = aligned_lobe(nodes, inputs, _REFLECTANCES[lobe.getCategory()])
    weight = inputs["weight"]
    parts = []
    if not flag.getValueString():
        given, zero = nodes.given(flag), nodes.constant(0.0)
        parts.append(_ordinary(lobe, nodes, nodes.if_true(given, zero, weight)))
        weight = nodes.if_true(given, weight, zero)
    if _scatters(lobe) == "RT":
        transmitting = _ordinary(lobe, nodes, weight)
        transmitting.setInputValue(_MODE, "T")
        parts.append(transmitting)
    parts += [_aligned(lobe, nodes, found, part, weight) for part in (found.core, found.wing)]
    if of_standard_library:
        for part in parts:
            part.setNodeDefString(f"ND_{part.getCategory()}")
    _become_sum(lobe, nodes, parts)
    return True


def is_weighed(mixture: Any) -> bool:
    """True for a mixture of BSDFs by an amount that is connected."""
    amount = mixture.getInput("mix") if mixture.getCategory() == "mix" and mixture.getType() == "BSDF" else None
    return amount is not None and not amount.getValueString()


def weigh_mixture(mixture: Any, nodes: Expressions) -> None:
    """Make a mixture of BSDFs by an amount that is connected the sum of both with their weights multiplied.

    Generators do so where its parts are nodes with a weight, and spoil what a sum lets through where one is a sum
    (docs/upstream-notes.md, premultiplied-mix).
    """
    amount = nodes.given(mixture.getInput("mix"))
    names = []
    for name, factor in (("fg", amount), ("bg", 1.0 - amount)):
        part = mixture.getConnectedNode(name)
        names.append("" if part is None else _weighted(part, nodes, factor))
    for given in mixture.getInputs():
        mixture.removeInput(given.getName())
    mixture.setCategory("add")
    mixture.removeAttribute("nodedef")
    for number, name in enumerate(filter(None, names), start=1):
        mixture.addInput(f"in{number}", "BSDF").setNodeName(name)


def _weighted(part: Any, nodes: Expressions, factor: Value) -> str:
    """Name of a node that is a BSDF times a factor: the node itself if nothing else uses it."""
    if part.getCategory() != "add" and part.getNodeDef().getActiveInput("weight") is None:
        product = nodes.added("multiply", "BSDF")
        product.addInput("in1", "BSDF").setNodeName(part.getName())
        factor.given_to(product, "in2")
        return str(product.getName())
    if len(part.getDownstreamPorts()) > 1:
        copied = nodes.added(part.getCategory(), "BSDF")
        name = str(copied.getName())
        copied.copyContentFrom(part)
        part = part.getParent().getNode(name)
    if part.getCategory() == "add":
        for given in part.getInputs():
            given.setNodeName(_weighted(given.getConnectedNode(), nodes, factor))
        return str(part.getName())
    given = part.getInput("weight")
    weight = factor if given is None else nodes.given(given) * factor
    if given is not None:
        part.removeInput("weight")
    weight.given_to(part, "weight")
    return str(part.getName())


def _scatters(lobe: Any) -> str:
    """The scatter mode, "" if it comes from elsewhere."""
    mode = lobe.getInput(_MODE)
    return "R" if mode is None else str(mode.getValueString())


def _inputs(lobe: Any, nodes: Expressions) -> dict[str, Value]:
    """The numbers that the node is given or has by default, colours as vectors."""
    found = {}
    for declared in definitions_for(lobe).getNodeDef(f"ND_{lobe.getCategory()}").getActiveInputs():
        name, kind = str(declared.getName()), str(declared.getType())
        if name in _UNUSED:
            continue
        given = lobe.getInput(name)
        value = nodes.given(given) if given is not None else None
        # Generators pass over a number where a direction is due.
        if value is not None and value.source and not (name in _GEOMETRY and value.number is not None):
            found[name] = value.converted("vector3") if kind == "color3" else value
        elif name in _GEOMETRY:
            found[name] = nodes.node(name, kind, {}, space="world")
        elif name not in _OPTIONAL:
            number = declared.getValue()
            numbers = float(number) if kind == "float" else tuple(number.asTuple())
            found[name] = nodes.constant(numbers, "vector3" if kind == "color3" else kind)
    return found


def _ordinary(lobe: Any, nodes: Expressions, weight: Value) -> Any:
    """A copy of the node without the flag, with another weight."""
    made = nodes.added(lobe.getCategory(), "BSDF")
    for given in lobe.getInputs():
        if given.getName() not in ("weight", FLAG):
            made.addInput(given.getName(), given.getType()).copyContentFrom(given)
    weight.given_to(made, "weight")
    return made


def _aligned(lobe: Any, nodes: Expressions, found: AlignedLobe, part: Part, weight: Value) -> Any:
    """One part: a lobe of the same reflectance at every angle, Schlick's curve with equal ends."""
    made = nodes.added(_SCHLICK, "BSDF")
    (weight * part.share).given_to(made, "weight")
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


def _become_sum(lobe: Any, nodes: Expressions, parts: list[Any]) -> None:
    """Let the node itself be the sum of two or more BSDFs."""
    for given in lobe.getInputs():
        lobe.removeInput(given.getName())
    lobe.removeAttribute("nodedef")
    lobe.setCategory("add")
    first, *others = (str(part.getName()) for part in parts)
    for other in others[:-1]:
        between = nodes.added("add", "BSDF")
        between.addInput("in1", "BSDF").setNodeName(first)
        between.addInput("in2", "BSDF").setNodeName(other)
        first = str(between.getName())
    lobe.addInput("in1", "BSDF").setNodeName(first)
    lobe.addInput("in2", "BSDF").setNodeName(others[-1])
