"""Files that a document names, as another file names them."""

from __future__ import annotations

import glob
import os
import re
import shutil
from typing import TYPE_CHECKING

from mrm_mtlx.library.files import resolve_inside

if TYPE_CHECKING:
    from pathlib import Path

    from mrm_mtlx.interchange.imported import Imported


def name_beside(name: str, source: Imported, path: Path) -> str:
    """A file's name as seen from the folder of `path`, "/" between folders.

    What was inside of the source, as in a package, is copied into a folder beside `path` that has its stem as name.
    A name of several files, with "<UDIM>" or the like in it, stays one.

    Raises
    ------
    OSError
        If a file cannot be copied.
    """
    target = resolve_inside(name, source.folder, source.root)
    if target is None:  # a checked document has none
        return name
    if source.packed:
        inner = target.relative_to(source.root.resolve())
        pattern = re.sub(r"<[^>]*>", "*", glob.escape(target.name))
        for file in sorted(target.parent.glob(pattern)):
            copy = path.parent / path.stem / inner.with_name(file.name)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, copy)
        target = path.parent.resolve() / path.stem / inner
    return os.path.relpath(target, path.parent.resolve()).replace(os.sep, "/")
