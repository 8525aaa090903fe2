"""The node library in a folder for other MaterialX hosts, and the folders of the ready materials."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mrm_mtlx.system.arguments import ArgumentError
from mrm_mtlx.system.shown import Shown

if TYPE_CHECKING:
    from mrm_mtlx.api.opening import PathLike


@dataclass(frozen=True, repr=False)
class InstalledLibrary(Shown):
    """The node library in a folder.

    Attributes
    ----------
    folder
        A search path for MaterialX hosts.
    files
        What was written.
    left_out
        Why a surface model of MaterialX is not extended, by its node.
    """

    folder: Path
    files: tuple[Path, ...]
    left_out: dict[str, str]

    def report(self) -> str:
        """The files, a line each."""
        return "\n".join(map(str, self.files))

    def notes(self) -> list[str]:
        """Lines on the models that are left out, and on the use of the folder."""
        from mrm_mtlx.library.install import MODELS_FOLDER, NODES_FOLDER

        left_out = [f"{node} is left out: {reason}" for node, reason in self.left_out.items()]
        use = (
            f"Search path '{self.folder}'. Load the folder '{NODES_FOLDER}' before the standard library, "
            f"'{MODELS_FOLDER}' after it; for example generateshader --path {self.folder} --library {NODES_FOLDER} ..."
        )
        return [*left_out, use]


def install_library(folder: PathLike) -> InstalledLibrary:
    """Copy the node library to folder/mrm, and the extended surface models to folder/mrm_surface_models.

    Raises
    ------
    ArgumentError
        If the folder cannot be written.
    """
    from mrm_mtlx.library import install_library as install
    from mrm_mtlx.library import load_library

    try:
        files = install(Path(folder))
    except OSError as error:
        msg = f"{folder} cannot be written: {error.strerror or error}"
        raise ArgumentError(msg, "folder") from error
    left_out = {x.model.node: x.reason for x in load_library().surface_models if x.reason}
    return InstalledLibrary(Path(folder), tuple(files), left_out)
