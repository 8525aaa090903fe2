"""Loads OSL into Blender's Script node as a user does, and renders a sphere with it: a program of its own, for bpy.

The command line has a request in JSON: "sources", a list of files of OSL: each is pasted into a text of Blender's, or
opened where it lies if it is named `*.external.osl`; and "pictures", where to write the renders, an .npz archive with
an array per source, (height, width, 4), by its number. Inputs for texture coordinates are linked to the node UV Map.
What was seen is printed as JSON: the inputs and outputs of each node, in their order.
"""

import json
import os
import sys
from pathlib import Path

import bpy
import numpy as np

SIZE, SAMPLES = 48, 4


def main(request):
    """Answer a request."""
    answer = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # Blender's own words are none of the answer's
    bpy.utils.expose_bundled_modules()
    seen, pictures = [], {}
    for number, source in enumerate(request["sources"]):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.cycles.shading_system = True
        script = show(Path(source))
        seen.append({"inputs": [described(s) for s in script.inputs], "outputs": [s.name for s in script.outputs]})
        pictures[str(number)] = rendered(scene, Path(request["pictures"]).with_suffix(".exr"))
    np.savez(request["pictures"], **pictures)
    answer.write(json.dumps(seen))


def described(socket):
    """A socket as plain data."""
    default = getattr(socket, "default_value", None)
    plain = default if isinstance(default, bool | int | float | str | None) else list(default)
    return {"name": socket.name, "identifier": socket.identifier, "kind": socket.bl_idname, "default": plain}


def show(source):
    """A sphere with a material of one Script node; the node."""
    material = bpy.data.materials.new("material")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    script = tree.nodes.new("ShaderNodeScript")
    if source.name.endswith(".external.osl"):
        script.mode, script.filepath = "EXTERNAL", str(source)
    else:
        text = bpy.data.texts.new(source.name)
        text.write(source.read_text(encoding="utf-8"))
        script.mode, script.script = "INTERNAL", text
    script.update()
    for socket in script.inputs:
        if socket.identifier == "mrm_uv":
            tree.links.new(socket, tree.nodes.new("ShaderNodeUVMap").outputs["UV"])
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(output.inputs["Surface"], script.outputs[0])
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(material)
    return script


def rendered(scene, path):
    """The picture of the scene, lit from beside the camera and a little from everywhere."""
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.data.angle = (0.0, 0.0, 6.0), 0.4
    lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "POINT"))
    lamp.location, lamp.data.energy, lamp.data.shadow_soft_size = (0.03, 0.0, 6.0), 500.0, 0.0
    for each in (camera, lamp):
        scene.collection.objects.link(each)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.1, 0.1, 1.0)
    scene.cycles.device, scene.cycles.samples, scene.cycles.seed = "CPU", SAMPLES, 0
    scene.render.threads_mode, scene.render.threads = "FIXED", 1  # or a picture depends on which one was first
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.view_settings.view_transform = "Raw"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    import OpenImageIO as oiio

    return oiio.ImageInput.open(str(path)).read_image("float")


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
