"""Does in Blender what a user clicks: a program of its own, for an interpreter that has bpy.

The command line has a request in JSON, a list of steps: the name of a function below and its arguments. What the steps
return is printed as JSON, one value per step; Blender's own words go to stderr. Steps never reach into the extension:
all goes through Blender's operators and data.
"""

import json
import os
import subprocess
import sys
import types
import warnings
from pathlib import Path

warnings.simplefilter("ignore", DeprecationWarning)  # Material.use_nodes, until Blender 6

import bpy  # noqa: E402

REPOSITORY, NAME = "user_default", "mrm_materials"
VARIABLE = "PXR_MTLX_PLUGIN_SEARCH_PATHS"
MENUS = ("VIEW3D_MT_add", "MATERIAL_MT_context_menu", "NODE_MT_add")


def install(archive):
    """Preferences > Get Extensions > Install from Disk."""
    return list(bpy.ops.extensions.package_install_files(filepath=archive, repo=REPOSITORY, enable_on_install=True))


def block_library():
    """A planted obstacle: a file where the asset library is to be."""
    folder = Path(bpy.utils.user_resource("EXTENSIONS"), ".user", REPOSITORY, NAME)
    folder.mkdir(parents=True)
    (folder / "library").touch()


def uninstall():
    """Preferences > Get Extensions > Uninstall."""
    repositories = list(bpy.context.preferences.extensions.repos)
    index = next(number for number, each in enumerate(repositories) if each.module == REPOSITORY)
    return list(bpy.ops.extensions.package_uninstall(repo_index=index, pkg_id=NAME))


def enabled(value):
    """The check box of the add-on."""
    operator = bpy.ops.preferences.addon_enable if value else bpy.ops.preferences.addon_disable
    return list(operator(module=f"bl_ext.{REPOSITORY}.{NAME}"))


def state():
    """Everything of Blender that an extension may leave something in."""
    folder = Path(bpy.utils.resource_path("USER"))
    drawn = {name: [f.__module__ for f in getattr(getattr(bpy.types, name).draw, "_draw_funcs", ())] for name in MENUS}
    return {
        "addons": sorted(bpy.context.preferences.addons.keys()),
        "libraries": [[each.name, each.path] for each in bpy.context.preferences.filepaths.asset_libraries],
        "types": sorted(name for name in dir(bpy.types) if "mrm" in name.lower()),
        "hooks": sorted(each.__name__ for each in bpy.types.USDHook.__subclasses__() if each.is_registered),
        "operators": sorted(dir(bpy.ops.mrm)),
        "menus": {name: sum("mrm" in module for module in modules) for name, modules in drawn.items()},
        "variable": os.environ.get(VARIABLE),
        "files": sorted(
            p.relative_to(folder).as_posix() for p in folder.rglob("*") if "mrm" in p.as_posix() and p.is_file()
        ),
        "modules": sorted(name for name in sys.modules if NAME in name),
    }


def scene():
    """Two spheres side by side before a camera, in the dark; the right one is the active object."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.context.scene.world = None
    for x in (-1.1, 1.1):
        bpy.ops.mesh.primitive_uv_sphere_add(radius=1.0, segments=32, ring_count=16, location=(x, 0.0, 0.0))
        bpy.ops.object.shade_smooth()
    bpy.ops.object.camera_add(location=(0.0, -8.0, 0.0), rotation=(1.570796, 0.0, 0.0))
    bpy.context.scene.camera = bpy.context.object
    bpy.context.scene.camera.data.lens = 60.0


def click(operator, sphere=None, **arguments):
    """What an operator says, with one of the spheres (0, 1) or no object active."""
    spheres = [each for each in bpy.data.objects if each.type == "MESH"]
    bpy.context.view_layer.objects.active = None if sphere is None else spheres[sphere]
    function = getattr(bpy.ops.mrm, operator)
    try:
        return list(function(**arguments))
    except RuntimeError as error:
        return str(error).strip()


def headlight(irradiance):
    """Light at the camera, of this strength at the right sphere."""
    click("add_headlight", 1, irradiance=irradiance)
    light = next(each for each in bpy.data.objects if each.type == "LIGHT")
    return {"parent": light.parent.type, "offset": list(light.location), "energy": light.data.energy}


def group(sphere):
    """The node of the group on a sphere."""
    material = [each for each in bpy.data.objects if each.type == "MESH"][sphere].active_material
    return next(node for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeGroup")


def set_sockets(sphere, label, value):
    """Set all sockets of a name on a sphere; how many there are."""
    found = [socket for socket in group(sphere).inputs if socket.name == label]
    for socket in found:
        socket.default_value = value
    return len(found)


def describe(sphere):
    """What a user sees of the material on a sphere."""
    node = group(sphere)
    items = node.node_tree.interface.items_tree
    material = [each for each in bpy.data.objects if each.type == "MESH"][sphere].active_material
    return {
        "name": material.name,
        "colour": list(material.diffuse_color),
        "panels": [item.name for item in items if item.item_type == "PANEL"],
        "sockets": [
            [item.parent.name, item.name] for item in items if item.item_type == "SOCKET" and item.in_out == "INPUT"
        ],
        "values": [[round(x, 6) for x in v] if hasattr(v := s.default_value, "__len__") else v for s in node.inputs],
        "shading_system": bpy.context.scene.cycles.shading_system,
        "export_method": bpy.context.scene.hydra.export_method,
    }


def counts():
    """How many data blocks there are."""
    return {kind: len(getattr(bpy.data, kind)) for kind in ("materials", "node_groups", "texts", "images", "lights")}


def assets():
    """The assets of the library that the extension has entered in the preferences."""
    entry = next(each for each in bpy.context.preferences.filepaths.asset_libraries if "mrm" in each.path)
    (file,) = Path(entry.path).glob("*.blend")
    with bpy.data.libraries.load(str(file), assets_only=True) as (there, taken):
        names = list(there.materials)
        taken.materials = list(names)  # Blender puts the materials in the place of the names
    found = {
        name: {
            "preview": list(material.preview.image_size),
            "tags": material.asset_data.tags.keys(),
            "catalog": material.asset_data.catalog_id,
        }
        for name, material in zip(names, taken.materials, strict=True)
    }
    for material in taken.materials:
        bpy.data.materials.remove(material)
    return found


def add_node():
    """Shader editor > Add > Retroreflective: how many nodes the material of the right sphere then has."""
    window = bpy.context.window_manager.windows[0]
    area = window.screen.areas[0]
    area.type, area.ui_type = "NODE_EDITOR", "ShaderNodeTree"
    region = next(each for each in area.regions if each.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.context.space_data.path.append(group(1).id_data)
        return click("add_node", 1, material="licence_plate")


class Layout:
    """Notes what is drawn, and refuses what Blender's own layout does not know; a module has no window to draw in."""

    def __init__(self):
        self.items = []

    def __getattr__(self, name):
        known = bpy.types.UILayout.bl_rna.functions[name].parameters

        def draw(*arguments, **named):
            names = [each.identifier for each in known if not each.is_output]
            given = {**dict(zip(names, arguments, strict=False)), **named}
            for key, value in given.items():
                assert key in names, f"{name} has no {key}"
                assert known[key].type != "ENUM" or value in known[key].enum_items, f"{name}: no {value}"
            if name == "row":
                return self
            options = types.SimpleNamespace()
            self.items.append([name, given, options])
            return options

        return draw


def drawn():
    """What a user sees of the extension: items of the menus, and of the panel for the right sphere."""
    click("set_mode", 1, mode="aligned")
    window = bpy.context.window_manager.windows[0]
    area = window.screen.areas[0]
    area.type, area.ui_type = "NODE_EDITOR", "ShaderNodeTree"
    seen = {}
    with bpy.context.temp_override(window=window, area=area, material=bpy.context.object.active_material):
        for name in MENUS:
            parts = (f for f in getattr(bpy.types, name).draw._draw_funcs if NAME in f.__module__)
            seen[name] = _items(next(parts))
        for name in ("MRM_MT_materials", "MRM_MT_nodes", "MRM_PT_material"):
            cls = getattr(bpy.types, name)
            assert not hasattr(cls, "poll") or cls.poll(bpy.context)
            seen[name] = _items(cls.draw)
    return seen


def _items(draw):
    """What a function draws: names of menus and texts, and operators with their options, all of which there are."""
    layout = Layout()
    draw(types.SimpleNamespace(layout=layout), bpy.context)
    found = []
    for name, given, options in layout.items:
        if name == "operator":
            space, operator = given["operator"].split(".")
            properties = getattr(getattr(bpy.ops, space), operator).get_rna_type().properties
            for key, value in vars(options).items():
                assert value in properties[key].enum_items
        found.append([given.get("operator") or given.get("menu") or given.get("text") or name, vars(options)])
        assert "menu" not in given or hasattr(bpy.types, given["menu"])
    return found


def validate(archive):
    """The exit status of Blender's own command that looks at extensions."""
    command = Path(bpy.utils.system_resource("SCRIPTS"), "addons_core", "bl_pkg", "cli", "blender_ext.py")
    return subprocess.run([sys.executable, command, "validate", archive], stdout=2, check=False).returncode


def undefined(folder):
    """Nodes of the networks in a folder that this Blender's MaterialX and the node library do not define, by input."""
    import MaterialX as mx
    from pxr import Sdf

    library = mx.createDocument()
    ours = os.environ[VARIABLE].split(os.pathsep)[-1]
    mx.loadLibraries(["mrm"], mx.FileSearchPath(ours), library)
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)
    found = []

    def look(prim, name):
        identifier = prim.attributes["info:id"].default if "info:id" in prim.attributes else None
        definition = library.getNodeDef(identifier) if identifier else None
        if identifier and definition is None:
            found.append(f"{name}: {identifier}")
        if definition is not None:
            known = {each.getName() for each in definition.getActiveInputs()}
            given = (each.name.removeprefix("inputs:") for each in prim.attributes if each.name.startswith("inputs:"))
            found.extend(f"{name}: {identifier} {each}" for each in given if each not in known)
        for child in prim.nameChildren:
            look(child, name)

    networks = sorted(Path(folder).glob("*.usda"))
    for path in networks:
        layer = Sdf.Layer.FindOrOpen(str(path))  # its prims do not keep it alive
        look(layer.pseudoRoot, path.name)
    return [len(networks), found]


def leave_something():
    """A planted error: what an extension might forget in the preferences."""
    bpy.context.preferences.filepaths.asset_libraries.new(name="forgotten", directory=str(Path.home()))


def hook_off():
    """A planted error: Blender's own materials go to Storm."""
    for each in bpy.types.USDHook.__subclasses__():
        if each.is_registered:
            bpy.utils.unregister_class(each)


def render(engine, picture, width=96, samples=4, transform="Raw"):
    """The picture, as the mean radiance of each half and whether all of it is finite."""
    if engine == "HYDRA_STORM":  # the check box of the add-on that Blender brings
        bpy.ops.preferences.addon_enable(module="hydra_storm")
    here = bpy.context.scene
    here.render.engine = engine
    if engine == "CYCLES":
        here.cycles.samples, here.cycles.use_denoising = samples, False
    here.render.resolution_x, here.render.resolution_y, here.render.filepath = width, width // 2, picture
    here.view_settings.view_transform = transform
    here.render.image_settings.file_format = "OPEN_EXR" if picture.endswith(".exr") else "PNG"
    bpy.ops.render.render(write_still=True)
    bpy.utils.expose_bundled_modules()
    import numpy as np
    import OpenImageIO as oiio

    pixels = oiio.ImageInput.open(picture).read_image("float")[..., :3]
    halves = pixels[:, : width // 2], pixels[:, width // 2 :]
    finite = bool(np.isfinite(pixels).all())
    return {"means": [half.mean(axis=(0, 1)).tolist() for half in halves], "finite": finite}


def main(steps):
    """Do the steps."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    bpy.utils.expose_bundled_modules()
    said = [globals()[name](**arguments) for name, arguments in steps]
    answers.write(json.dumps(said))
    answers.flush()
    os._exit(0)  # Blender 4.5 as a module may hang in its last destructors


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
