"""Files that a document names, as another file names them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.findings import rules

if TYPE_CHECKING:
    from mrm_mtlx.documents.document import Document
    from mrm_mtlx.system.writing import FileSet


def name_beside(name: str, source: Document, path: Path, files: FileSet) -> str:
    """A file's name as seen from the folder of `path`, "/" between folders.

    What lies elsewhere than in or below that folder, or was inside of the source, as in a package, is copied into a
    folder beside `path` that has its stem as name: a file that was written can be moved and checked with all that it
    names. A name of several files, with "<UDIM>" or the like in it, stays one.

    Raises
    ------
    OSError
        If a file cannot be copied.
    ReadError
        If one is a link that leads outside, or no regular file.
    """
    target = source.reach.resolve(name)
    if target is None:  # a checked document has none
        return name
    folder = path.parent.resolve()
    found = source.reach.members(name)
    if found and (source.packed or not target.is_relative_to(folder)):
        inner = source.reach.within(target)
        for file in found:
            files.copied(_checked(file, source), folder / path.stem / _member(inner, source.reach.locate(name), file))
        target = folder / path.stem / inner
    return os.path.relpath(target, folder).replace(os.sep, "/")


def _member(inner: Path, place: Path, file: Path) -> Path:
    """The path that a file of a set is copied to, if the set, which lies at `place`, goes to `inner`."""
    differing = (number for number, pair in enumerate(zip(place.parts, file.parts, strict=True)) if len(set(pair)) > 1)
    count = len(file.parts) - next(differing, len(file.parts) - 1)
    return Path(*inner.parts[:-count], *file.parts[-count:])


def _checked(file: Path, source: Document) -> Path:
    """The path, links followed, of a file that is to be copied."""
    target = source.reach.inside(file)
    if target is None:
        message = f"the file '{file.name}' is a link that leads outside the folder being checked"
        raise ReadError(rules.READ_OUTSIDE.at("", message))
    if not target.is_file():
        raise ReadError(rules.READ_FAILED.at("", f"'{file.name}' is not a regular file"))
    return target
