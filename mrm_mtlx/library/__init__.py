"""The data libraries: where the node library lies, and how it is loaded before the standard one."""

from mrm_mtlx.library.dialects import materialx_version
from mrm_mtlx.library.load import DataLibrary, Origin, load_library
from mrm_mtlx.library.paths import class_materials_folder, materials_folder, node_library_folder

__all__ = [
    "DataLibrary",
    "Origin",
    "class_materials_folder",
    "load_library",
    "materials_folder",
    "materialx_version",
    "node_library_folder",
]
