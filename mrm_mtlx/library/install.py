"""The node library in folders of their own, for other MaterialX hosts."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

import MaterialX as mx

from mrm_mtlx.library.dialects import materialx_version
from mrm_mtlx.library.load import load_library
from mrm_mtlx.library.paths import node_library_folder
from mrm_mtlx.library.surface_models import SURFACE_MODELS, extensions_alone
from mrm_mtlx.system.writing import FileSet

if TYPE_CHECKING:
    from pathlib import Path

NODES_FOLDER, MODELS_FOLDER = "mrm", "mrm_surface_models"

_COMMENT = """
    Written by `mrm library install` from MaterialX {version} (Copyright Contributors to the MaterialX Project, Apache
    License 2.0): its definitions and graphs of {models}.
    Changed: each has one input more, and the reflecting microfacet nodes of its base are those of the folder
    `{nodes}`, which has to be loaded too. Load this file after the standard library. With another version of MaterialX,
    write it anew.
  """


def install_library(destination: Path) -> list[Path]:
    """Copy the node library to `destination/mrm`, and the extended surface models to `destination/mrm_surface_models`.

    The copy is named `mrm` and not `pbrlib`, because MaterialX stops at the first folder of a name on its search path:
    a second `pbrlib` would hide the standard one or be hidden by it. The models have a folder of their own, because
    MaterialX takes the first definition that fits: nodes have to come before the standard library, models after it, or
    every document would get the models of the MaterialX that is installed here.

    Returns the files written, sorted: all, or none if one cannot be. Existing files of the same name are overwritten;
    nothing else is touched.

    Raises
    ------
    OSError
        If the destination cannot be written.
    """
    source = node_library_folder() / "pbrlib"
    destination.mkdir(parents=True, exist_ok=True)
    written = {destination / NODES_FOLDER / p.relative_to(source): p for p in source.rglob("*") if p.is_file()}
    text = surface_models_text()
    models = destination / MODELS_FOLDER / f"{MODELS_FOLDER}.mtlx"
    with FileSet(destination) as files:
        for target, file in written.items():
            shutil.copyfile(file, files.named(target))
        if text:
            files.named(models).write_text(text, encoding="utf-8")
    return sorted([*written, models] if text else written)


def surface_models_text() -> str:
    """The extended surface models of the installed MaterialX as a document; "" if there are none."""
    document = load_library().document
    models = [model.node for model in SURFACE_MODELS if document.getNodeDef(model.definition) is not None]
    if not models:
        return ""
    comment = _COMMENT.format(version=materialx_version(), models=", ".join(models), nodes=NODES_FOLDER)
    options = mx.XmlWriteOptions()
    options.writeXIncludeEnable = False  # the copies still name the files that they come from
    return str(mx.writeToXmlString(extensions_alone(document, comment), options))
