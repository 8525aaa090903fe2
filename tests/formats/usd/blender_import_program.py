"""Opens a stage as Blender's users do, and says what it made of its first material: for an interpreter with bpy.

Arguments are the stage and an image to write. The image is of a square of that material, seen along its normal and lit
at 45 degrees by a sun of irradiance 1 on a plane that faces it. The last line that is printed is JSON: by input of the
Principled node, its value, or what it is connected to.
"""

from __future__ import annotations

import json
import math
import sys
from typing import Any

import bpy

INPUTS = ("Base Color", "Metallic", "Roughness", "IOR", "Coat Weight", "Coat Roughness", "Alpha", "Emission Color")
SIDE = 8


def value_of(given: Any) -> Any:
    """The number, or numbers, of a node's input, or the name of the image that it is connected to."""
    if given.is_linked:
        node = given.links[0].from_node
        return node.image.name if node.type == "TEX_IMAGE" else node.type
    value = given.default_value
    return list(value) if hasattr(value, "__len__") else value


def photograph(material: Any, path: str) -> None:
    """Render the square into a file of OpenEXR, in linear radiance."""
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=4.0)
    bpy.context.object.data.materials.append(material)
    bpy.ops.object.light_add(type="SUN", rotation=(0.0, math.radians(45.0), 0.0))
    bpy.context.object.data.energy = 1.0
    bpy.ops.object.camera_add(location=(0.0, 0.0, 5.0))
    bpy.context.object.data.type = "ORTHO"
    bpy.context.object.data.ortho_scale = 2.0
    scene.camera = bpy.context.object
    scene.world = None
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 64, False
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    stage, picture = sys.argv[1:]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=stage, import_all_materials=True)
    (found, *_) = bpy.data.materials
    nodes = [node for node in found.node_tree.nodes if node.type == "BSDF_PRINCIPLED"]
    photograph(found, picture)
    print(json.dumps({name: value_of(nodes[0].inputs[name]) for name in INPUTS} if nodes else None))
