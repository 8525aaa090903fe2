"""Source locations in the layers of a stage."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.findings.source_location import SourceLocation

if TYPE_CHECKING:
    from collections.abc import Mapping


class StageLocations:
    """See `documents.locations.Locations`; places are paths of prims and properties.

    Parameters
    ----------
    file
        The stage's path as findings show it.
    sources
        Where each place is said, of those that elements of the document come from.
    """

    def __init__(self, file: str, sources: Mapping[str, SourceLocation]) -> None:
        self._file, self._sources = file, sources

    def of(self, place: str) -> SourceLocation:
        """The source of a place, or else of the nearest of its parents."""
        while place and place not in self._sources:
            place = place.rpartition("/")[0]
        return self._sources[place] if place else SourceLocation(self._file)
