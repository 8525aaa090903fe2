"""Writes the network of a material when Blender exports USD, which is how Hydra Storm gets its scene."""

import bpy

from .catalogue import ProblemError, network
from .node_groups import MATERIAL, changed_inputs, group_node

# The prim below a material that holds the network.
_NETWORK = "mrm"
_SURFACE, _VERSION = "mtlx:surface", "config:mtlx:version"


def register():
    """Add the hook, in a Blender with USD."""
    bpy.utils.expose_bundled_modules()
    try:
        import pxr.UsdShade  # noqa: F401  without it, Blender ends when it hands a prim to the hook
    except ImportError:
        print("Retroreflective Materials: this Blender has no USD; Hydra Storm will not show them")
        return
    bpy.utils.register_class(MRM_USD_hook)


def unregister():
    """Take it out."""
    if hasattr(bpy.types, "USDHook") and MRM_USD_hook.is_registered:
        bpy.utils.unregister_class(MRM_USD_hook)


class MRM_USD_hook(bpy.types.USDHook if hasattr(bpy.types, "USDHook") else object):
    """Blender calls it for each material that it exports."""

    bl_idname = "MRM_USD_hook"
    bl_label = "Retroreflective Materials"
    bl_description = "Writes retroreflective materials as MaterialX"

    @staticmethod
    def on_material_export(export_context, bl_material, usd_material):
        """Put the network of a material of ours in the place of Blender's."""
        node = group_node(bl_material)
        if node is None:
            return True
        try:
            write_network(export_context.get_stage(), usd_material, node)
        except (ProblemError, OSError, RuntimeError, ValueError) as error:
            print(f"Retroreflective Materials: {bl_material.name} is exported as Blender has it: {error}")
        return True


def write_network(stage, usd_material, node):
    """Copy a network below a material, with the values of a group's node, and make it the surface."""
    from pxr import Sdf, UsdShade

    name = node.node_tree[MATERIAL]
    source = Sdf.Layer.FindOrOpen(str(network(name)))
    if source is None:
        raise ProblemError(f"the file {network(name).name} of the extension cannot be read; install it again")
    original = source.GetPrimAtPath("/Materials").nameChildren[0]
    prim, layer = usd_material.GetPrim(), stage.GetEditTarget().GetLayer()
    # Blender's own network comes first: what is connected here is stronger than whatever follows.
    prim.RemoveProperty(f"outputs:{_SURFACE}")
    target = prim.GetPath().AppendChild(_NETWORK)
    if not Sdf.CopySpec(source, original.path, layer, target):
        raise ProblemError("USD did not copy its network")
    layer.GetPrimAtPath(target).typeName = "NodeGraph"  # a material may not lie in another
    graph = UsdShade.NodeGraph(stage.GetPrimAtPath(target))
    for attribute, components, value in changed_inputs(node):
        _set(stage, target.AppendPath(attribute), components, value)
    prim.AddAppliedSchema("MaterialXConfigAPI")
    version = graph.GetPrim().GetAttribute(_VERSION).Get()
    prim.CreateAttribute(_VERSION, Sdf.ValueTypeNames.String, custom=False).Set(version)
    surface = usd_material.CreateOutput(_SURFACE, Sdf.ValueTypeNames.Token)
    surface.ConnectToSource(graph.GetOutput(_SURFACE))


def _set(stage, path, components, value):
    """Set an attribute, or some of its components."""
    attribute = stage.GetAttributeAtPath(path)
    if isinstance(value, tuple):  # a colour, whose alpha MaterialX has not
        attribute.Set(value[:3])
        return
    known = attribute.Get()
    if isinstance(known, bool | int | float):
        attribute.Set(type(known)(value))
        return
    changed = list(known)
    for index in components:
        changed[index] = value
    attribute.Set(type(known)(*changed))
