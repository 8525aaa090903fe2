"""Renders a sphere in the first material of a stage, as Blender imports it: `python tools/look_in_blender.py`.

For an interpreter with bpy. Arguments are the stage, the image to write in linear radiance (.exr), its side in pixels,
and the angle of the light from the eye in degrees. Camera, sphere and light are those of `mrm render --shape sphere`.
"""

from __future__ import annotations

import math
import sys

import bpy
from mathutils import Matrix, Vector

EYE, HALF_FIELD_DEG = Vector((0.0, 1.1, 6.0)), 12.0
UP = Vector((0.0, 1.0, 0.0))


def turned_to(backward: Vector) -> Matrix:
    """The rotation of a camera or a sun that looks against a direction, with y up."""
    backward = backward.normalized()
    right = UP.cross(backward).normalized()
    return Matrix((right, backward.cross(right), backward)).transposed().to_4x4()


def main(stage: str, picture: str, side: int, angle_deg: float) -> None:
    """Import the stage and render."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=stage, import_all_materials=True)
    scene, (material, *_) = bpy.context.scene, bpy.data.materials
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=1.0)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(material)
    bpy.ops.object.light_add(type="SUN")
    bpy.context.object.data.energy, bpy.context.object.data.angle = math.pi, 0.0
    right = UP.cross(EYE).normalized()
    angle = math.radians(angle_deg)
    bpy.context.object.matrix_world = turned_to(EYE.normalized() * math.cos(angle) + right * math.sin(angle))
    bpy.ops.object.camera_add()
    bpy.context.object.data.angle = 2.0 * math.radians(HALF_FIELD_DEG)
    bpy.context.object.matrix_world = Matrix.Translation(EYE) @ turned_to(EYE)
    scene.camera, scene.world = bpy.context.object, None
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 64, False
    scene.render.resolution_x = scene.render.resolution_y = side
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = picture
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), float(sys.argv[4]))
