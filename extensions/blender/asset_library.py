"""The materials in the asset browser: a library that this Blender writes once, and its entry in the preferences."""

from pathlib import Path

import bpy

from .catalogue import ProblemError, materials, preview, version
from .node_groups import make_material

NAME = "Retroreflective Materials"
_CATALOG = "7f0f6ec4-31f0-4b1e-a4d4-52b1c1c7f1d9"
_CATALOGS = f"VERSION 1\n\n{_CATALOG}:Retroreflective:Retroreflective\n"


def register():
    """Enter the library in the preferences, and write it as soon as Blender's data may be used."""
    try:
        folder = library_folder()
        (folder / "blender_assets.cats.txt").write_text(_CATALOGS, encoding="utf-8")
    except (ProblemError, OSError, ValueError) as error:
        print(f"Retroreflective Materials: no asset library: {error}")
        return
    entries = bpy.context.preferences.filepaths.asset_libraries
    if not any(_is_ours(entry) for entry in entries):
        entries.new(name=NAME, directory=str(folder))
    bpy.app.timers.register(_write_later, first_interval=0.5)


def unregister():
    """Take the entry out of the preferences. The files stay until Blender removes the extension."""
    if bpy.app.timers.is_registered(_write_later):
        bpy.app.timers.unregister(_write_later)
    entries = bpy.context.preferences.filepaths.asset_libraries
    for entry in [entry for entry in entries if _is_ours(entry)]:
        entries.remove(entry)


def library_folder():
    """The folder of the library, which Blender removes with the extension."""
    folder = bpy.utils.extension_path_user(__package__, path="library", create=True)
    if not folder:
        raise ProblemError("Blender cannot make the folder of the asset library; its message has the reason")
    return Path(folder)


def library_file():
    """The library of this version of the extension, written by this Blender."""
    return library_folder() / f"mrm-{version()}-blender-{bpy.app.version[0]}.{bpy.app.version[1]}.blend"


def write_library():
    """Write the library, if it is not there yet, in the place of those of other versions."""
    target = library_file()
    if target.exists():
        return
    others = list(target.parent.glob("mrm-*.blend"))
    unfinished = target.with_suffix(".part")
    with bpy.data.temp_data() as data:
        made = {_asset(data, described) for described in materials()}
        try:
            data.libraries.write(str(unfinished), made, compress=True)
        except RuntimeError as error:
            raise ProblemError(f"{target.parent} cannot be written: {error}") from None
    unfinished.replace(target)
    for other in others:
        other.unlink()


def _asset(data, described):
    """A material as an asset, with its picture."""
    material = make_material(data, described["name"])
    material.asset_mark()
    known = material.asset_data
    known.catalog_id, known.description, known.license = _CATALOG, described["doc"], "Apache-2.0"
    known.author = "mrm-mtlx"
    known.tags.new("retroreflective")
    picture = data.images.load(str(preview(described["name"])))
    shown = material.preview_ensure()
    shown.image_size = picture.size
    shown.image_pixels_float[:] = picture.pixels[:]
    data.images.remove(picture)
    return material


def _write_later():
    """Write the library once Blender is idle; None, so that it is not asked again."""
    try:
        write_library()
    except (ProblemError, OSError) as error:
        print(f"Retroreflective Materials: no asset library: {error}")


def _is_ours(entry):
    return Path(entry.path).parts[-2:] == (__package__.rpartition(".")[2], "library")
