"""Tells the MaterialX of this Blender where the node library is, in the form of its version."""

import os

import bpy

from .catalogue import DATA

VARIABLE = "PXR_MTLX_PLUGIN_SEARCH_PATHS"
_LIBRARIES = DATA / "libraries"


def register():
    """Add the library to what USD searches; that happens when it first uses MaterialX, and never again."""
    folder = library_folder()
    if folder is not None:
        _set([*_others(), str(folder)])


def unregister():
    """Take it out, and leave what else is there."""
    _set(_others())


def library_folder():
    """The folder of the node library for the MaterialX of this Blender; None if it has no MaterialX."""
    bpy.utils.expose_bundled_modules()
    try:
        import MaterialX
    except ImportError:
        print("Retroreflective Materials: this Blender has no MaterialX; Hydra Storm will not show them")
        return None
    here = _numbers(MaterialX.getVersionString())
    served = [folder for folder in _LIBRARIES.iterdir() if _numbers(folder.name) <= here]
    return max(served, key=lambda folder: _numbers(folder.name), default=None)


def _numbers(version):
    return tuple(int(number) for number in version.split("."))


def _others():
    """What others have put into the variable."""
    return [path for path in os.environ.get(VARIABLE, "").split(os.pathsep) if path and not _is_ours(path)]


def _is_ours(path):
    return os.path.normpath(path).startswith(str(_LIBRARIES))


def _set(paths):
    if paths:
        os.environ[VARIABLE] = os.pathsep.join(paths)
    else:
        os.environ.pop(VARIABLE, None)
