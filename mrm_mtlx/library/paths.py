"""Where the project's data lies: in a checkout or editable install beside the package, in a wheel inside it."""

from __future__ import annotations

import shutil
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def _data_folder(name: str) -> Path:
    for root in (_PACKAGE / "data", _PACKAGE.parent):
        if (root / name).is_dir():
            return root / name
    msg = f"the folder '{name}' of the package is missing; the installation is incomplete, reinstall mrm-mtlx"
    raise FileNotFoundError(msg)


def node_library_folder() -> Path:
    """Folder that holds `pbrlib/`, the node library; a search path for any MaterialX host."""
    return _data_folder("libraries")


def materials_folder() -> Path:
    """Folder of the ready materials."""
    return _data_folder("materials")


def class_materials_folder() -> Path:
    """Folder of the materials of known performance, one for each class of a standard."""
    return _data_folder("materials_classes")


def install_library(destination: Path) -> list[Path]:
    """Copy the node library to `destination/mrm`, for other MaterialX hosts.

    The copy is named `mrm` and not `pbrlib`, because MaterialX stops at the first folder of a name on its search path:
    a second `pbrlib` would hide the standard one or be hidden by it.

    Returns the files written, sorted. Existing files of the same name are overwritten; nothing else is touched.

    Raises
    ------
    OSError
        If the destination cannot be written.
    """
    source = node_library_folder() / "pbrlib"
    shutil.copytree(source, destination / "mrm", dirs_exist_ok=True)
    return sorted(destination / "mrm" / path.relative_to(source) for path in source.rglob("*") if path.is_file())
