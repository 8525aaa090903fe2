"""Source locations in an asset's JSON."""

from __future__ import annotations

import codecs
from functools import cached_property

from mrm_mtlx.findings.source_location import SourceLocation
from mrm_mtlx.formats.json_positions import JsonPositions


class AssetLocations:
    """See `documents.locations.Locations`; places are JSON pointers.

    Parameters
    ----------
    file
        The asset's path as findings show it.
    content
        Its JSON, which can be parsed.
    is_text
        Whether that is the file itself, and not a chunk of a .glb, whose lines nobody sees.
    """

    def __init__(self, file: str, content: bytes, *, is_text: bool) -> None:
        self._file, self._content, self._is_text = file, content, is_text

    @cached_property
    def _positions(self) -> JsonPositions:
        return JsonPositions(self._content.removeprefix(codecs.BOM_UTF8))

    def of(self, place: str) -> SourceLocation:
        """The source of the value with a pointer, or else of the nearest around it that is there."""
        found = self._positions.nearest(place)
        line, column = found.position if self._is_text and found.pointer else (None, None)
        return SourceLocation(self._file, line, column, pointer=found.pointer)
