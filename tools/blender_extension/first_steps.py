"""The steps of docs/hosts/blender.md in Blender, as its page has them: a program for an interpreter that has bpy.

The command line has a request in JSON: "archive", the zip; "folder", where the pictures go; "width" of a picture;
"samples" of Cycles; and "materials", names of materials that are to be shown on spheres besides.
"""

import json
import os
import sys
from pathlib import Path

import bpy


def main(request):
    """Do the steps; pictures of the first, and of each material."""
    folder, width, samples = Path(request["folder"]), request["width"], request["samples"]
    # Preferences > Get Extensions > Install from Disk; Add-ons > Hydra Storm.
    bpy.ops.extensions.package_install_files(filepath=request["archive"], repo="user_default", enable_on_install=True)
    bpy.ops.preferences.addon_enable(module="hydra_storm")
    bpy.ops.wm.read_homefile(load_ui=False)
    cube = bpy.context.object
    # Add > Retroreflective > Traffic cone collar
    bpy.ops.mrm.add_material(material="traffic_cone_collar")
    _both(folder, "aside", width, samples)
    # The lamp is deleted; Add > Retroreflective > Light at the Camera
    bpy.data.objects.remove(bpy.data.objects["Light"])
    bpy.ops.mrm.add_headlight()
    _both(folder, "camera", width, samples)
    # Shader editor: Encapsulated beads > Retroreflective
    node = next(each for each in cube.active_material.node_tree.nodes if each.type == "GROUP")
    node.inputs["Retroreflective"].default_value = False
    _both(folder, "off", width, samples)
    for name in request["materials"]:
        _sphere(name)
        _render(folder / f"{name}.png", "CYCLES", width, samples)


def _sphere(name):
    """The camera sees a sphere of a material, lit from the camera alone."""
    for each in list(bpy.data.objects):
        if each.type in {"MESH", "LIGHT"}:
            bpy.data.objects.remove(each)
    bpy.context.scene.world = None
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=1.4)
    bpy.ops.object.shade_smooth()
    bpy.ops.mrm.add_material(material=name)
    bpy.ops.mrm.add_headlight()


def _both(folder, name, width, samples):
    """Pictures of the scene as it is, by the engines that retroreflect."""
    for engine in ("CYCLES", "HYDRA_STORM"):
        _render(folder / f"{name}.{engine}.png", engine, width, samples)


def _render(path, engine, width, samples):
    """Render > Render Image."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.cycles.samples, scene.cycles.use_denoising = samples, False
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = (
        width,
        width * 3 // 4,
        100,
    )
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
    sys.stdout.flush()
    os._exit(0)  # Blender 4.5 as a module may hang in its last destructors
