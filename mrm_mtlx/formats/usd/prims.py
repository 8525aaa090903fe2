"""Prims of materials: which of them are MaterialX's, and what can be said of one without its network."""

from __future__ import annotations

from pxr import Usd, UsdShade

from mrm_mtlx.shadergen.usd.values import TERMINALS, color_space

# What the ids of MaterialX's node definitions begin with.
ID_PREFIX = "ND_"


def terminals(material: UsdShade.Material) -> dict[str, UsdShade.Output]:
    """The outputs of a material that MaterialX renders: those of its render context, or else the universal ones.

    A universal output counts if a node of MaterialX feeds it.
    """
    found = {}
    for name in TERMINALS:
        output = material.GetOutput(f"mtlx:{name}")
        if output and output.GetAttr().IsAuthored():
            found[name] = output
            continue
        output = material.GetOutput(name)
        attributes = UsdShade.Utils.GetValueProducingAttributes(output) if output else []
        if any(is_materialx(attribute.GetPrim()) for attribute in attributes):
            found[name] = output
    return found


def is_materialx(prim: Usd.Prim) -> bool:
    """True if a prim is a shader with the id of a MaterialX node."""
    return prim.IsA(UsdShade.Shader) and str(UsdShade.Shader(prim).GetIdAttr().Get() or "").startswith(ID_PREFIX)


def is_closed(graph: Usd.Prim) -> bool:
    """True if a graph can be one of the document: shaders alone, connected among themselves and to its interface."""
    inside = {graph.GetPath()}
    children = list(graph.GetFilteredChildren(Usd.TraverseInstanceProxies()))
    if not all(child.IsA(UsdShade.Shader) for child in children):
        return False
    inside |= {child.GetPath() for child in children}
    attributes = [output.GetAttr() for output in UsdShade.NodeGraph(graph).GetOutputs()]
    for child in children:
        attributes += [given.GetAttr() for given in UsdShade.Shader(child).GetInputs()]
    return all(path.GetPrimPath() in inside for attribute in attributes for path in attribute.GetConnections())


def space_of(attribute: Usd.Attribute) -> str:
    """MaterialX's name of the colour space that an attribute states, "" for none."""
    return color_space(attribute.GetColorSpace()) if attribute.HasColorSpace() else ""
