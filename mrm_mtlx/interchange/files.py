"""Files that a document names, as another file names them."""

from __future__ import annotations

import glob
import os
import re
import shutil
from typing import TYPE_CHECKING

from mrm_mtlx.library.writing import replacing

if TYPE_CHECKING:
    from pathlib import Path

    from mrm_mtlx.interchange.imported import Imported


def name_beside(name: str, source: Imported, path: Path) -> str:
    """A file's name as seen from the folder of `path`, "/" between folders.

    What lies elsewhere than in or below that folder, or was inside of the source, as in a package, is copied into a
    folder beside `path` that has its stem as name: a file that was written can be moved and checked with all that it
    names. A name of several files, with "<UDIM>" or the like in it, stays one.

    Raises
    ------
    OSError
        If a file cannot be copied.
    """
    target = source.reach.resolve(name)
    if target is None:  # a checked document has none
        return name
    folder = path.parent.resolve()
    pattern = re.sub(r"<[^>]*>", "*", glob.escape(target.name))
    found = sorted(target.parent.glob(pattern))
    if found and (source.packed or not target.is_relative_to(folder)):
        inner = source.reach.within(target)
        for file in found:
            copy = folder / path.stem / inner.with_name(file.name)
            copy.parent.mkdir(parents=True, exist_ok=True)
            with replacing(copy) as unfinished:
                shutil.copyfile(file, unfinished)
        target = folder / path.stem / inner
    return os.path.relpath(target, folder).replace(os.sep, "/")
