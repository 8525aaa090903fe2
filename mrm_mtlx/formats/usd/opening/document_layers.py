"""Documents of MaterialX that a stage refers to, as layers: what UsdMtlx makes of them, as far as materials go."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import MaterialX as mx
from pxr import Sdf, Tf, Usd, UsdShade

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.materialx.importer import read_xml
from mrm_mtlx.formats.usd.exporter.material_prims import write_materials
from mrm_mtlx.formats.usd.messages import said
from mrm_mtlx.shadergen.usd.values import COLORED, TERMINALS, sdf_type

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.library import DataLibrary

SUFFIX = ".mtlx"
# Where UsdMtlx has everything, and the materials.
ROOT = Sdf.Path("/MaterialX")
MATERIALS = ROOT.AppendChild("Materials")


def open_document(
    path: Path, reach: Reach, library: DataLibrary, named: Callable[[str], str]
) -> tuple[Sdf.Layer, list[Finding]]:
    """A document as a layer without a file, in which names of files are absolute paths, and what was lost on the way.

    Parameters
    ----------
    path, reach
        The document, and where the names of files in it lead.
    library
        Its definitions.
    named
        Function from a file's path to what USD may be given for it.

    Raises
    ------
    ReadError
        If it cannot be read, or is wrong.
    ValueError
        If there is nothing to render, or too much.
    """
    document = read_xml(path, reach, library)
    problem = _problem(document.materialx)
    if problem:
        raise ReadError(rules.DOC_INVALID.at("", problem))
    _state_spaces(document.materialx)
    layer = Sdf.Layer.CreateAnonymous(f"{path.name}.usda")
    try:
        lost = write_materials(document.materialx, layer, lambda name: named(str(reach.locate(name))), MATERIALS)
    except Tf.ErrorException as error:
        msg = f"USD cannot hold it: {said(error)}"
        raise ValueError(msg) from error
    layer.ClearDefaultPrim()
    stage = Usd.Stage.Open(layer)
    for prim in stage.GetPrimAtPath(MATERIALS).GetChildren():
        _expose(UsdShade.Material(prim), library)
    return layer, [*document.findings, *lost]


def _problem(document: mx.Document) -> str:
    """The first problem of a document for which its nodes cannot be written; "" for none."""
    is_valid, message = document.validate()
    if not is_valid:
        return " ".join(message.split())
    nodes = (element for element in document.traverseTree() if element.isA(mx.Node))
    unknown = next((node for node in nodes if node.getNodeDef() is None), None)
    return "" if unknown is None else f"nothing defines the node '{unknown.getNamePath()}'"


def _state_spaces(document: mx.Document) -> None:
    """Say the colour space of each value itself: what is so by default in a document is not so in a stage."""
    for element in document.traverseTree():
        if element.isA(mx.ValueElement) and element.getType() in COLORED and element.getValueString():
            space = element.getActiveColorSpace()
            if space and not element.getColorSpace():
                element.setColorSpace(space)
    document.removeAttribute("colorspace")


def _expose(material: UsdShade.Material, library: DataLibrary) -> None:
    """Give a material the inputs of its shaders, and these their values from there, so that a stage can change them."""
    for terminal in TERMINALS:
        output = material.GetOutput(f"mtlx:{terminal}")
        sources = UsdShade.Utils.GetValueProducingAttributes(output) if output else []
        for shader in (UsdShade.Shader(source.GetPrim()) for source in sources):
            definition = library.document.getNodeDef(str(shader.GetIdAttr().Get() or ""))
            if shader.GetPrim().GetParent() == material.GetPrim() and definition is not None:
                for declared in definition.getActiveInputs():
                    _expose_input(material, shader, declared)


def _expose_input(material: UsdShade.Material, shader: UsdShade.Shader, declared: Any) -> None:
    name = declared.getName()
    if material.GetInput(name) or (shader.GetInput(name) and shader.GetInput(name).HasConnectedSource()):
        return
    kind = sdf_type(declared.getType())
    if kind == Sdf.ValueTypeNames.Token:  # closures
        return
    outer = material.CreateInput(name, kind)
    inner = shader.GetInput(name)
    if inner and inner.Get() is not None:
        outer.Set(inner.Get())
        if inner.GetAttr().HasColorSpace():
            outer.GetAttr().SetColorSpace(inner.GetAttr().GetColorSpace())
        inner.GetAttr().Clear()
    shader.CreateInput(name, kind).ConnectToSource(outer)
