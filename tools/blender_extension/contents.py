"""The files of the Blender extension: its modules, the ready materials, and the node library in each dialect."""

from __future__ import annotations

import json
from pathlib import Path

from mrm_mtlx.api.opening import open_document
from mrm_mtlx.library import materials_folder
from mrm_mtlx.library.assembly import node_library_files
from mrm_mtlx.system.versions import __version__
from tools.blender_extension.materials import describe, script
from tools.blender_extension.networks import network

REPOSITORY = Path(__file__).parents[2]
SOURCES = REPOSITORY / "extensions" / "blender"
# Versions of MaterialX whose form of the node library lies in the extension; a Blender takes the newest that is no
# newer than its own. 4.5 has 1.39.2, 5.0 has 1.39.3, 5.1 to 5.3 have 1.39.4; the last is for those to come.
VERSIONS = ("1.39.0", "1.39.3", "1.39.5")
_PLACEHOLDER = 'version = "0.0.0"'


def contents() -> dict[str, bytes]:
    """Contents of the extension's files, by their names in the zip."""
    files = {**_sources(), "LICENSE": (REPOSITORY / "LICENSE").read_bytes()}
    for version in VERSIONS:
        files |= {f"data/libraries/{version}/mrm/{name}": text for name, text in node_library_files(version).items()}
    descriptions = []
    for path in sorted(materials_folder().glob("*.mtlx")):
        opened = open_document(path)
        descriptions.append(describe(opened))
        files[f"data/scripts/{path.stem}.osl"] = script(opened).encode()
        files[f"data/networks/{path.stem}.usda"] = network(opened).encode()
    files["data/materials.json"] = f"{json.dumps(descriptions, indent=1)}\n".encode()
    return files


def _sources() -> dict[str, bytes]:
    """The modules, the pictures and the manifest, which gets the version of the package."""
    files = {
        path.relative_to(SOURCES).as_posix(): path.read_bytes()
        for suffix in ("py", "png", "toml")
        for path in sorted(SOURCES.rglob(f"*.{suffix}"))
    }
    manifest = files["blender_manifest.toml"].decode()
    if _PLACEHOLDER not in manifest:
        msg = f"blender_manifest.toml has no line '{_PLACEHOLDER}' for the version"
        raise ValueError(msg)
    files["blender_manifest.toml"] = manifest.replace(_PLACEHOLDER, f'version = "{__version__}"').encode()
    return files
