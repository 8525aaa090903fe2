"""Checks of the images that a document names: each is there, regular, within reach, and can be decoded."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mrm_mtlx.documents.document_images import DocumentImages
from mrm_mtlx.documents.files import is_left_open, names_nothing, names_tiles
from mrm_mtlx.findings import rules

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.findings.finding import Finding

# What to do about an image that is there and cannot be taken.
_UNREADABLE = "Save the image again, within the limits that are named, in a format that OpenImageIO reads."


def check_image(name: str, reach: Reach, place: str) -> list[Finding]:
    """Findings on an image, or a set of them, by its name in a document; `place` is the finding's."""
    if names_nothing(name):
        return []
    members = [] if is_left_open(name) else reach.members(name)
    targets = [reach.inside(member) for member in members]
    if reach.resolve(name) is None or None in targets:
        through = f", by the link '{members[targets.index(None)].name}'" if None in targets else ""
        message = f"the image '{name}' lies outside the folder being checked{through}"
        return [rules.READ_OUTSIDE.at(place, message)]
    if any(target is not None and not target.is_file() for target in targets):
        return [rules.DOC_FILE.at(place, f"the image '{name}' is not a regular file")]
    if members or is_left_open(name):
        return []
    message = f"no file of the set '{name}' exists" if names_tiles(name) else f"the image '{name}' does not exist"
    return [rules.DOC_FILE.at(place, message)]


class CheckedImages(DocumentImages):
    """The images of a document, with a finding for each that cannot be read, is missing or lies outside.

    The check of the document's files finds most of the latter before, with their locations; here is all that is asked
    for, by whatever way its name came.
    """

    def __init__(self, reach: Reach, place: str) -> None:
        super().__init__(reach)
        self._place = place
        self._missing: dict[str, list[Finding]] = {}

    @property
    def findings(self) -> list[Finding]:
        """Those of the files that were asked for so far."""
        missing = [found for wrong in self._missing.values() for found in wrong]
        return missing + [rules.DOC_FILE.at(self._place, problem, _UNREADABLE) for problem in self.problems]

    def _read(self, name: str) -> NDArray[Any] | None:
        self._missing[name] = check_image(name, self._reach, self._place)
        return None if self._missing[name] else super()._read(name)
