"""The document that the materials of a stage become, in the making."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from mrm_mtlx.formats.usd.importer.versions import earlier_definition

if TYPE_CHECKING:
    from collections.abc import Callable

    import MaterialX as mx
    from pxr import Sdf, Usd

    from mrm_mtlx.findings.finding import Finding, Rule
    from mrm_mtlx.findings.source_location import SourceLocation
    from mrm_mtlx.library import DataLibrary


@dataclass
class Translation:
    """A document in the making.

    Attributes
    ----------
    document
        Its data library is set.
    library
        The definitions.
    file_name
        Function from an attribute of type asset to the file's name in the document.
    source_locations, findings
        See `Document`.
    last
        By an element's path and a name: the last that was made of the name for a child.
    definitions
        By category, type and inputs of a node: the definition that it gets.
    is_earlier
        Whether the network is of an earlier MaterialX, whose document is to be upgraded.
    source_of
        Function from the path of a prim or property, as it is composed now, and its place, to where it is said.
    sources
        Where the places are said.
    """

    document: mx.Document
    library: DataLibrary
    file_name: Callable[[Usd.Attribute], str]
    source_locations: dict[str, str] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    last: dict[tuple[str, str], str] = field(default_factory=dict)
    definitions: dict[tuple[str, str, tuple[tuple[str, str], ...]], str] = field(default_factory=dict)
    is_earlier: bool = False
    source_of: Callable[[Sdf.Path, str], SourceLocation] | None = None
    sources: dict[str, SourceLocation] = field(default_factory=dict)

    def noted(self, path: Sdf.Path, place: str) -> str:
        """A place, of which it is noted where it is said."""
        if self.source_of is not None and place not in self.sources:
            self.sources[place] = self.source_of(path, place)
        return place

    def report(self, rule: Rule, path: Sdf.Path, place: str, message: str, hint: str = "") -> None:
        """Add a finding."""
        self.noted(path, place)
        self.findings.append(replace(rule.at(place, message, hint), source=self.sources.get(place)))

    def definition(self, identifier: str) -> Any:
        """The definition of a node, of the version that the network is of; None for none."""
        earlier = earlier_definition(identifier) if self.is_earlier else None
        return self.library.document.getNodeDef(identifier) if earlier is None else earlier

    def free(self, name: str, parent: Any = None) -> str:
        """A name that no element has yet. Of thousands of one name, counting goes on where it was."""
        parent = parent or self.document
        key = (str(parent.getNamePath()), name)
        found = self.last[key] = str(parent.createValidChildName(self.last.get(key, name)))
        return found
