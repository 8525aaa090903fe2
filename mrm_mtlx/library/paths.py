"""Folders of the project's data: in a checkout or editable install beside the package, in a wheel inside it."""

from __future__ import annotations

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
