"""A renderable element as a layer of USD, for a host that takes materials and generates its shaders itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pxr import Sdf, Tf, Usd, UsdGeom, UsdShade

from mrm_mtlx.shadergen.generate import GenerationError, MissingCodeError, Port, Shader, plain_value
from mrm_mtlx.shadergen.usd.material_prims import MaterialWriter, material_behind
from mrm_mtlx.shadergen.usd.scope import TERMINALS, is_connected
from mrm_mtlx.shadergen.usd.values import sdf_type

if TYPE_CHECKING:
    from collections.abc import Iterator

    import MaterialX as mx

# The prim that the material of a network lies in.
BELOW = Sdf.Path("/Materials")


def generate_network(element: Any, target: str) -> Shader:
    """The material of an element as a layer in text; its default prim is the material.

    The uniforms are the inputs of its nodes that nothing is connected to, by the paths of their attributes; those that
    say nothing have the values of the definition.

    Raises
    ------
    MissingCodeError
        If the element is no surface, or something in it has no form in USD.
    GenerationError
        If USD refuses the material, or it is too large.
    """
    element = material_behind(element)
    if element is None or (element.getType() != "material" and element.getType() not in TERMINALS):
        msg = "it is no shader, and a host that takes materials shows no pattern by itself"
        raise MissingCodeError(msg)
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    if element.getDocument().getColorSpace():  # as UsdMtlx does
        layer.customLayerData = {"colorSpace": element.getDocument().getColorSpace()}
    writer = MaterialWriter(element.getDocument(), stage, lambda name: name)
    try:
        prim = writer.material(UsdGeom.Scope.Define(stage, BELOW).GetPrim(), element)
        stage.SetDefaultPrim(stage.GetPrimAtPath(BELOW))
    except (ValueError, Tf.ErrorException) as error:
        raise GenerationError(str(error)) from error
    if writer.lost:
        raise MissingCodeError(f"{writer.lost[0].location}: {writer.lost[0].message}")
    uniforms = tuple(port for node, at in writer.nodes for port in _ports(node, UsdShade.Shader(at)))
    return Shader(target, str(prim.GetName()), {"pixel": layer.ExportToString()}, uniforms, (), "")


def _ports(node: mx.Node, shader: UsdShade.Shader) -> Iterator[Port]:
    """A port for each input of a node that is not connected and can have a value in USD."""
    for declared in node.getNodeDef().getActiveInputs():
        given = node.getInput(declared.getName())
        kind = str(declared.getType())
        if (given is not None and is_connected(given)) or sdf_type(kind) == Sdf.ValueTypeNames.Token:
            continue
        written = shader.GetInput(declared.getName())
        path = shader.GetPath().AppendProperty(f"inputs:{declared.getName()}")
        if kind == "filename":
            asset = written.Get() if written else None
            value: Any = "" if asset is None else asset.path
        else:
            data = (given if given is not None and given.getValueString() else declared).getValue()
            value = None if data is None else plain_value(data)
        yield Port(str(path), kind, value, f"{node.getNamePath()}/{declared.getName()}")
