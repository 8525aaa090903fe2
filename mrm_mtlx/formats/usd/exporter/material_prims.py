"""A document's materials as prims of a stage: all that can be rendered, and what of the document is lost."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pxr import Sdf, Usd, UsdGeom, UsdShade

from mrm_mtlx.shadergen import renderable_elements
from mrm_mtlx.shadergen.usd.material_prims import MaterialWriter, material_behind
from mrm_mtlx.shadergen.usd.scope import TERMINALS

if TYPE_CHECKING:
    from collections.abc import Callable

    import MaterialX as mx

    from mrm_mtlx.findings.finding import Finding

# The prim that holds the materials, and is the stage's default.
MATERIALS = Sdf.Path("/Materials")


def write_materials(
    document: mx.Document,
    layer: Sdf.Layer,
    anchored: Callable[[str], str],
    below: Sdf.Path = MATERIALS,
    add_look: Callable[[UsdShade.Material, Any], None] = lambda _material, _element: None,
) -> list[Finding]:
    """Write all renderable elements of a valid document as materials.

    Parameters
    ----------
    document
        Its data library is set.
    layer
        An empty layer.
    anchored
        Function from a file's name in the document to its name in the layer.
    below
        The prim that the materials lie in.
    add_look
        Function that is told each material with a surface that was written, and its element.

    Returns
    -------
    list
        What USD has no form for.

    Raises
    ------
    ValueError
        If there is nothing to render, or too much.
    """
    stage = Usd.Stage.Open(layer)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    root = UsdGeom.Scope.Define(stage, below).GetPrim()
    stage.SetDefaultPrim(stage.GetPrimAtPath(below.GetPrefixes()[0]))
    if document.getColorSpace():  # as UsdMtlx does
        layer.customLayerData = {"colorSpace": document.getColorSpace()}
    # An output of another type is a pattern; what belongs to none of these is told by `findings`.
    shown = [material_behind(element) for element in renderable_elements(document)]
    elements = [e for e in shown if e is not None and (e.getType() == "material" or e.getType() in TERMINALS)]
    elements = list({element.getNamePath(): element for element in elements}.values())
    if not elements:
        msg = "it has no material and no shader"
        raise ValueError(msg)
    elements += [node for node in document.getMaterialNodes() if node.getCategory() == "volumematerial"]
    writer = MaterialWriter(document, stage, anchored)
    for element in elements:
        material = UsdShade.Material(writer.material(root, element))
        if material.GetOutput("mtlx:surface"):
            add_look(material, element)
    return writer.findings()
