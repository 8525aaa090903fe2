"""Where a user finds the materials: the Add menus, the menu of material slots, and a panel of the material."""

import bpy

from .catalogue import materials
from .engines import lacks
from .node_groups import MODE, MODES, group_node

_TITLE = "Retroreflective"


class MRM_MT_materials(bpy.types.Menu):
    """Each material, for the active object."""

    bl_idname = "MRM_MT_materials"
    bl_label = _TITLE

    def draw(self, context):
        """List them, and the light that shows them."""
        for described in materials():
            self.layout.operator("mrm.add_material", text=described["label"]).material = described["name"]
        self.layout.separator()
        self.layout.operator("mrm.add_headlight", icon="LIGHT_POINT")


class MRM_MT_nodes(bpy.types.Menu):
    """Each material, as a node."""

    bl_idname = "MRM_MT_nodes"
    bl_label = _TITLE

    def draw(self, context):
        """List them."""
        for described in materials():
            self.layout.operator("mrm.add_node", text=described["label"]).material = described["name"]


class MRM_PT_material(bpy.types.Panel):
    """How a material of ours is shown."""

    bl_idname = "MRM_PT_material"
    bl_label = _TITLE
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"

    @classmethod
    def poll(cls, context):
        """With one of our materials."""
        return group_node(context.material) is not None

    def draw(self, context):
        """The mode, what the scene lacks, and the light."""
        now = group_node(context.material).node_tree[MODE]
        row = self.layout.row(align=True)
        for identifier, label, *_ in MODES:
            row.operator("mrm.set_mode", text=label, depress=identifier == now).mode = identifier
        for sentence in lacks(context.scene, now):
            self.layout.label(text=sentence, icon="INFO")
        self.layout.operator("mrm.add_headlight", icon="LIGHT_POINT")


def _draw_materials(menu, context):
    menu.layout.menu(MRM_MT_materials.bl_idname, icon="MATERIAL")


def _draw_nodes(menu, context):
    if context.space_data.tree_type == "ShaderNodeTree":
        menu.layout.menu(MRM_MT_nodes.bl_idname)


_CLASSES = (MRM_MT_materials, MRM_MT_nodes, MRM_PT_material)
# Menus of Blender, and what is added to each.
_ADDED = (
    ("VIEW3D_MT_add", _draw_materials),
    ("MATERIAL_MT_context_menu", _draw_materials),
    ("NODE_MT_add", _draw_nodes),
)


def register():
    """Add the menus and the panel."""
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    for name, draw in _ADDED:
        getattr(bpy.types, name).append(draw)


def unregister():
    """Take them out."""
    for name, draw in _ADDED:
        getattr(bpy.types, name).remove(draw)
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
