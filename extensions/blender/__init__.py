"""The ready retroreflective materials of mrm-mtlx in Blender.

They are in the Add menus and the asset browser, and retroreflect in Hydra Storm, where a USD hook writes their
MaterialX, and in Cycles, where a Script node runs their OSL. EEVEE and Workbench show their colour by day.

* `catalogue`: the materials as `tools.blender_extension` has described them in `data`.
* `environment`: tells MaterialX of the node library.
* `node_groups`: a material's nodes; `engines`: what the engines need of a scene.
* `storm_hook`: a material's network, when Blender writes USD.
* `asset_library`, `operators`, `menus`: what a user sees.

It runs in Blender alone; the package `mrm_mtlx` knows nothing of it.
"""

from . import asset_library, environment, menus, operators, storm_hook

# In the order that Blender gets them; the variable comes before anything that may use MaterialX.
_PARTS = (environment, storm_hook, operators, menus, asset_library)


def register():
    """Add everything to Blender."""
    for part in _PARTS:
        part.register()


def unregister():
    """Take everything out of Blender again."""
    for part in reversed(_PARTS):
        part.unregister()
