"""Prints the networks of files' materials as JSON, one object per file; for an interpreter with or without UsdMtlx.

Arguments are files. Nodes are told apart by their names, wherever they live; values come from where they are given.
"""

from __future__ import annotations

import json
import sys
from typing import Any

if __name__ == "__main__" and "--blender" in sys.argv:
    import bpy

    bpy.utils.expose_bundled_modules()

from pxr import Sdf, Sdr, Usd, UsdShade


def networks(path: str) -> dict[str, Any]:
    """By material: what its terminals are, and each node's id and inputs."""
    stage = Usd.Stage.Open(path)
    found = {}
    for prim in stage.Traverse():
        if prim.IsA(UsdShade.Material) and "/Looks/" not in str(prim.GetPath()):
            nodes: dict[str, Any] = {}
            terminals = {}
            for output in UsdShade.Material(prim).GetOutputs():
                for source in UsdShade.Utils.GetValueProducingAttributes(output):
                    terminals[output.GetBaseName()] = source.GetPrim().GetName()
                    _visit(UsdShade.Shader(source.GetPrim()), nodes)
            found[prim.GetName()] = {"terminals": terminals, "nodes": nodes}
    return found


def unknown_ids(path: str) -> list[str]:
    """Ids of a file's shaders that this USD's registry of shaders does not know."""
    registry = Sdr.Registry()
    find = getattr(registry, "GetShaderNodeByIdentifier", None) or registry.GetNodeByIdentifier
    stage = Usd.Stage.Open(path)
    prims = [prim for prim in stage.Traverse() if prim.IsA(UsdShade.Shader)]
    ids = {UsdShade.Shader(prim).GetIdAttr().Get() for prim in prims}
    return sorted(identifier for identifier in ids if not find(identifier))


def _visit(shader: UsdShade.Shader, nodes: dict[str, Any]) -> None:
    name = shader.GetPrim().GetName()
    if name in nodes:
        return
    nodes[name] = {"id": shader.GetIdAttr().Get(), "inputs": {}}
    for given in shader.GetInputs():
        for source in UsdShade.Utils.GetValueProducingAttributes(given):
            if UsdShade.Output.IsOutput(source):
                said = [source.GetPrim().GetName(), UsdShade.Output(source).GetBaseName()]
                _visit(UsdShade.Shader(source.GetPrim()), nodes)
            elif source.Get() is None:
                continue
            else:
                said = [_plain(source.Get()), source.GetColorSpace() if source.HasColorSpace() else ""]
            nodes[name]["inputs"][given.GetBaseName()] = said


def _plain(value: Any) -> Any:
    if isinstance(value, Sdf.AssetPath):
        return value.path.removeprefix("./")
    if isinstance(value, bool | int | float | str):
        return value
    return [_plain(item) for item in value]


if __name__ == "__main__":
    paths = [argument for argument in sys.argv[1:] if argument != "--blender"]
    print(json.dumps({path: {"networks": networks(path), "unknown": unknown_ids(path)} for path in paths}))
