"""What a user can have done: give a material, light it, and choose how OSL retroreflects."""

import math

import bpy

from .asset_library import write_library
from .catalogue import ProblemError, materials
from .engines import prepare
from .node_groups import MODE, MODES, add_node, ensure_group, group_node, make_material, set_mode

_MATERIALS = tuple((described["name"], described["label"], described["doc"]) for described in materials())
_MODES = tuple(mode[:3] for mode in MODES)
# Irradiance of the headlight where it shines on [W/m2]: bright sheeting is near white, a white wall dark.
_IRRADIANCE = 0.003
_DISTANCE_M = 10.0


class _Reporting:
    """Reports a ProblemError instead of raising it."""

    def execute(self, context):
        """Do it; what cannot be done is reported."""
        try:
            said = self.work(context)
        except (ProblemError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if said:
            self.report({"INFO"}, said)
        return {"FINISHED"}


class MRM_OT_add_material(_Reporting, bpy.types.Operator):
    """Give the active object this retroreflective material."""

    bl_idname = "mrm.add_material"
    bl_label = "Add Retroreflective Material"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    material: bpy.props.EnumProperty(name="Material", items=_MATERIALS)
    mode: bpy.props.EnumProperty(name="In Cycles", items=_MODES)

    @classmethod
    def description(cls, context, properties):
        """What the material is."""
        return next(doc for name, _, doc in _MATERIALS if name == properties.material)

    def work(self, context):
        """Make the material and put it into the object's active slot."""
        target = context.object
        if target is None or not hasattr(target.data, "materials"):
            raise ProblemError("Select an object that can have a material, such as a mesh")
        if target.data.library is not None:
            raise ProblemError(f"{target.data.name} comes from another file and cannot be changed here")
        target.active_material = make_material(bpy.data, self.material, self.mode)
        return "; ".join(prepare(context.scene))


class MRM_OT_add_node(_Reporting, bpy.types.Operator):
    """Add this retroreflective material as a node."""

    bl_idname = "mrm.add_node"
    bl_label = "Add Retroreflective Node"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    material: bpy.props.EnumProperty(name="Material", items=_MATERIALS)
    mode: bpy.props.EnumProperty(name="In Cycles", items=_MODES)

    @classmethod
    def poll(cls, context):
        """In the shader editor."""
        space = context.space_data
        return space is not None and space.type == "NODE_EDITOR" and space.tree_type == "ShaderNodeTree"

    def work(self, context):
        """Add the node where the cursor is, and select it alone."""
        owner = context.space_data.edit_tree
        if owner is None:
            raise ProblemError("Give the object a material first, or use Add in the 3D viewport")
        node = add_node(owner, ensure_group(bpy.data, self.material, self.mode))
        node.location = context.space_data.cursor_location
        for other in owner.nodes:
            other.select = other == node
        owner.nodes.active = node
        return "; ".join(prepare(context.scene))


class MRM_OT_set_mode(_Reporting, bpy.types.Operator):
    """Choose how the material of the active object retroreflects in Cycles."""

    bl_idname = "mrm.set_mode"
    bl_label = "Retroreflection in Cycles"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    mode: bpy.props.EnumProperty(name="In Cycles", items=_MODES)

    @classmethod
    def poll(cls, context):
        """With one of our materials."""
        return context.object is not None and group_node(context.object.active_material) is not None

    def work(self, context):
        """Put the group of that mode into the material."""
        node = group_node(context.object.active_material)
        if node.node_tree[MODE] != self.mode:
            set_mode(bpy.data, node, self.mode)
        return "; ".join(prepare(context.scene))


class MRM_OT_add_headlight(_Reporting, bpy.types.Operator):
    """Put a light at the camera, which retroreflectors send back to it."""

    bl_idname = "mrm.add_headlight"
    bl_label = "Light at the Camera"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    irradiance: bpy.props.FloatProperty(
        name="Irradiance", description="At the active object [W/m2]", default=_IRRADIANCE, min=0.0, precision=4
    )

    def work(self, context):
        """Make the light and hang it on the camera."""
        camera = context.scene.camera
        if camera is None:
            raise ProblemError("The scene has no camera; add one first")
        lit = context.object
        distance = _DISTANCE_M
        if lit is not None and lit != camera:
            distance = (lit.matrix_world.translation - camera.matrix_world.translation).length or _DISTANCE_M
        light = bpy.data.lights.new("Headlight", "POINT")
        light.energy, light.shadow_soft_size = 4.0 * math.pi * distance**2 * self.irradiance, 0.0
        holder = bpy.data.objects.new(light.name, light)
        holder.parent = camera
        context.collection.objects.link(holder)


class MRM_OT_write_library(_Reporting, bpy.types.Operator):
    """Write the asset library of the retroreflective materials, where it is missing."""

    bl_idname = "mrm.write_library"
    bl_label = "Write the Retroreflective Asset Library"

    def work(self, context):
        """Write it."""
        write_library()


_CLASSES = (MRM_OT_add_material, MRM_OT_add_node, MRM_OT_set_mode, MRM_OT_add_headlight, MRM_OT_write_library)
register, unregister = bpy.utils.register_classes_factory(_CLASSES)
