"""Compiles OSL and renders with Cycles: the operations of `blender_server` for the OSL engine.

Not part of the import package: the interpreter that has `bpy` runs it, and nothing imports it.
"""

import math
import os
from pathlib import Path

import bpy
import numpy as np

# Columns of the map by which directions to the environment are drawn, at the least.
LEAST_MAP = 64


def versions():
    """Versions of Blender and of its OSL, and the id of this process."""
    import _cycles

    osl = {"osl": str(_cycles.osl_version_string), "with_osl": _cycles.with_osl}
    return {"blender": bpy.app.version_string, **osl, "pid": os.getpid()}


def compile_shader(source, target):
    """Compile a file; what the compiler said is in the log."""
    import _cycles

    return {"ok": bool(_cycles.osl_compile(source, target))}


def render(arrays, shader, camera, takes, world, samples, bounces, seed, threads):
    """Render a mesh with a shader to multi-layer EXR files of 32-bit floats, one per take.

    A take has its own "lights" and, where only a part of the rows is wanted, "rows": the fractions of the height, from
    the bottom, between which it is rendered.

    `arrays`: "vertices" (n, 3), "faces" (m, corners); optionally "normals" (m, corners, 3) for a smooth surface, "uv"
    (m, corners, 2) for the shader's inputs mrm_uv and mrm_tangent, and "environment" (height, width, 3). Those named
    "input:NAME", (m,) or (m, 3), are inputs of the shader that are constant on each face.
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    settings = scene.cycles
    settings.shading_system = True  # OSL
    settings.device = "CPU"
    settings.samples = samples
    settings.seed = seed
    settings.use_adaptive_sampling = False
    settings.use_denoising = False
    settings.use_light_tree = False
    settings.light_sampling_threshold = 0.0
    settings.sample_clamp_direct = settings.sample_clamp_indirect = 0.0
    settings.blur_glossy = 0.0
    # A box is as wide as the pixel, whatever its width is set to.
    settings.pixel_filter_type = "BOX" if camera["filter_width"] == 1.0 else "BLACKMAN_HARRIS"
    settings.filter_width = camera["filter_width"]
    settings.max_bounces = settings.diffuse_bounces = settings.glossy_bounces = bounces
    settings.transmission_bounces = bounces
    settings.transparent_max_bounces = 16
    settings.caustics_reflective = settings.caustics_refractive = True
    scene.render.threads_mode, scene.render.threads = "FIXED", threads
    scene.render.use_compositing = scene.render.use_sequencer = False
    scene.view_settings.view_transform = "Raw"
    if "environment" in arrays:
        world = {"image": write_image(arrays["environment"], Path(takes[0]["output"]).with_name("environment.exr"))}
    scene.render.film_transparent = not world
    set_world(scene, world)
    add_mesh(scene, arrays, make_material(shader, arrays), camera["alone"])
    add_camera(scene, camera)
    picture = scene.render.image_settings
    if hasattr(picture, "media_type"):  # since Blender 5.0
        picture.media_type = "MULTI_LAYER_IMAGE"
    picture.file_format, picture.color_depth, picture.exr_codec = "OPEN_EXR_MULTILAYER", "32", "NONE"
    # Between takes only the lights change: mesh and compiled shader stay, which is most of the time.
    scene.render.use_persistent_data = len(takes) > 1
    for take in takes:
        for old in [o for o in scene.objects if o.type == "LIGHT"]:
            bpy.data.objects.remove(old)
        for light in take["lights"]:
            add_light(scene, light)
        bottom, top = take.get("rows", (0.0, 1.0))
        scene.render.use_border = "rows" in take
        scene.render.border_min_y, scene.render.border_max_y = bottom, top
        scene.render.filepath = take["output"]
        bpy.ops.render.render(write_still=True)
    return {}


def make_material(shader, arrays):
    """A material of one script node, whose inputs come from the mesh's attributes of the same name."""
    material = bpy.data.materials.new("surface")
    material.use_nodes = True
    # Emission would make the mesh a light, which halves the sampling of the others.
    material.cycles.emission_sampling = "NONE"
    tree = material.node_tree
    tree.nodes.clear()
    script = tree.nodes.new("ShaderNodeScript")
    script.mode = "EXTERNAL"
    script.filepath = shader
    script.update()
    for name, array in arrays.items():
        if not name.startswith("input:"):
            continue
        socket = script.inputs.get(name[len("input:") :])
        if socket is None:
            raise KeyError(f"the shader has no input {name[len('input:') :]}; it has {list(script.inputs.keys())}")
        attribute = tree.nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = name
        tree.links.new(socket, attribute.outputs["Vector" if array.ndim == 2 else "Fac"])
    if "uv" in arrays:
        link_mesh(tree, script)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    closures = [socket for socket in script.outputs if socket.type == "SHADER"]
    tree.links.new(output.inputs["Surface"], closures[0])
    return material


def link_mesh(tree, script):
    """Give a shader the texture coordinates of its mesh, and the tangent along u, if it asks for them."""
    if "mrm_uv" in script.inputs:
        tree.links.new(script.inputs["mrm_uv"], tree.nodes.new("ShaderNodeUVMap").outputs["UV"])
    if "mrm_tangent" in script.inputs:
        tangent = tree.nodes.new("ShaderNodeTangent")
        tangent.direction_type = "UV_MAP"
        tree.links.new(script.inputs["mrm_tangent"], tangent.outputs["Tangent"])


def add_mesh(scene, arrays, material, alone):
    """The mesh with its face attributes; `alone`: seen by the camera and not by light that it reflects itself."""
    vertices, faces = arrays["vertices"], arrays["faces"]
    mesh = bpy.data.meshes.new("surface")
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(vertices, np.float32).ravel())
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(faces, np.int32).ravel())
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", np.arange(len(faces), dtype=np.int32) * faces.shape[1])
    mesh.update(calc_edges=True)
    for name, values in arrays.items():
        if name.startswith("input:"):
            kind, field = ("FLOAT_VECTOR", "vector") if values.ndim == 2 else ("FLOAT", "value")
            attribute = mesh.attributes.new(name, kind, "FACE")
            attribute.data.foreach_set(field, np.ascontiguousarray(values, np.float32).ravel())
    if "uv" in arrays:
        layer = mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", np.ascontiguousarray(arrays["uv"], np.float32).ravel())
    if "normals" in arrays:
        mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), dtype=bool))
        mesh.normals_split_custom_set(arrays["normals"].reshape(-1, 3).tolist())
    mesh.materials.append(material)
    object_ = bpy.data.objects.new("surface", mesh)
    object_.visible_diffuse = object_.visible_glossy = object_.visible_transmission = not alone
    scene.collection.objects.link(object_)


def add_camera(scene, camera):
    """A camera looking along -z of `matrix`, orthographic with a `width`, or with a `field` of view in radians."""
    data = bpy.data.cameras.new("camera")
    if "width" in camera:
        data.type, data.ortho_scale = "ORTHO", camera["width"]
    else:
        data.angle = camera["field"]
    data.clip_start, data.clip_end = camera["clip"]
    object_ = bpy.data.objects.new("camera", data)
    place(object_, camera["matrix"])
    scene.collection.objects.link(object_)
    scene.camera = object_
    scene.render.resolution_x, scene.render.resolution_y = camera["resolution"]
    scene.render.resolution_percentage = 100


def add_light(scene, light):
    """A light without extent: a sun with an `irradiance` along -z of its matrix, or a point with an `intensity`."""
    kind = "SUN" if "irradiance" in light else "POINT"
    data = bpy.data.lights.new("light", kind)
    data.use_shadow = light["shadow"]
    if kind == "SUN":
        data.angle, data.energy = 0.0, light["irradiance"]
    else:
        # Blender's energy is the flux into all directions.
        data.shadow_soft_size, data.energy = 0.0, light["intensity"] * 4.0 * math.pi
    object_ = bpy.data.objects.new("light", data)
    place(object_, light["matrix"])
    scene.collection.objects.link(object_)


def set_world(scene, world):
    """The environment: a constant `radiance`, or a latitude-longitude `image`, or black."""
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    background = tree.nodes["Background"]
    background.inputs["Color"].default_value = (*world.get("radiance", (0.0, 0.0, 0.0)), 1.0)
    if "image" in world:
        image = tree.nodes.new("ShaderNodeTexEnvironment")
        image.image = bpy.data.images.load(world["image"])
        image.image.colorspace_settings.name = "Non-Color"
        # Cycles cannot tell the size of an image that OSL reads: left to itself, it takes seconds for a map of any.
        scene.world.cycles.sampling_method = "MANUAL"
        scene.world.cycles.sample_map_resolution = max(LEAST_MAP, image.image.size[0])
        # Blender's latitude is about z and its centre column at x; ours is about y and at -z: (x, y, z) -> (-z, -x, y).
        direction, split = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeSeparateXYZ")
        joined, signs = tree.nodes.new("ShaderNodeCombineXYZ"), tree.nodes.new("ShaderNodeVectorMath")
        signs.operation = "MULTIPLY"
        signs.inputs[1].default_value = (-1.0, -1.0, 1.0)
        tree.links.new(split.inputs[0], direction.outputs["Generated"])
        for target, source in (("X", "Z"), ("Y", "X"), ("Z", "Y")):
            tree.links.new(joined.inputs[target], split.outputs[source])
        tree.links.new(signs.inputs[0], joined.outputs[0])
        tree.links.new(image.inputs["Vector"], signs.outputs[0])
        tree.links.new(background.inputs["Color"], image.outputs["Color"])


def write_image(pixels, path):
    """Write (height, width, 3) radiance, row 0 on top, as an image that Blender loads; its path."""
    height, width, _ = pixels.shape
    image = bpy.data.images.new("environment", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = pixels[::-1]
    image.pixels.foreach_set(rgba.ravel())
    image.file_format = "OPEN_EXR"
    image.filepath_raw = str(path)
    image.save()
    return str(path)


def place(object_, matrix):
    """Set an object's matrix, given as rows."""
    from mathutils import Matrix

    object_.rotation_mode = "QUATERNION"  # of Euler's angles, two turn about the same axis at right angles
    object_.matrix_world = Matrix(matrix)


OPERATIONS = {"versions": versions, "compile": compile_shader, "render": render}
