"""Opening an untrusted stage: its layers are looked at one by one before USD composes them.

USD opens whatever a layer names, parses nested prims by recursion, and expands references without a bound. So the files
are found, read and counted here, and USD is given what was read: layers without a file, which name each other. Of its
own accord it opens no file then, whatever the form of a name, and whatever the search path of its resolver.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pxr import Sdf, Tf, Usd

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.usd.messages import said
from mrm_mtlx.formats.usd.opening.stage_files import StageFiles
from mrm_mtlx.formats.usd.opening.stage_layers import StageLayers
from mrm_mtlx.system.console import silenced

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from mrm_mtlx.documents.files import Reach
    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.findings.source_location import SourceLocation
    from mrm_mtlx.library import DataLibrary

# What USD's validator of names says of one that leads to no file.
_UNRESOLVED = "usdUtilsValidators:MissingReferenceValidator.UnresolvableDependency"


@dataclass(frozen=True)
class Stage:
    """A stage that was opened.

    Attributes
    ----------
    stage
        All of its layers are without a file.
    findings
        What was not opened.
    """

    stage: Usd.Stage
    findings: list[Finding]
    _files: StageFiles
    _layers: StageLayers

    @property
    def packed(self) -> bool:
        """True if it was opened from a package."""
        return self._files.first_package is not None

    @property
    def reach(self) -> Reach:
        """The reach of the names that `name` gives."""
        return self._files.document_reach

    def file(self, layer: Sdf.Layer, name: str) -> Path:
        """The file that a name in a layer means, inside or not, there or not."""
        return self._files.beside(self._layers.origins[layer.identifier], name)

    def name(self, file: Path) -> str:
        """A file's name in a document: that of one out of a package is relative to where packages are unpacked."""
        scratch = self._files.scratch
        folder = scratch if file.is_relative_to(scratch) else self.reach.folder
        return os.path.relpath(file, folder).replace(os.sep, "/")

    def lacking(self, prim: Usd.Prim) -> str:
        """Name of a missing layer that might say something of a prim; "" for none."""
        return self._layers.placeholders.lacking(prim)

    def lacking_at(self, path: Sdf.Path) -> str:
        """The same of what stands at a path, or would."""
        prim = self.stage.GetPrimAtPath(path.GetPrimPath())
        while not prim and path != Sdf.Path.absoluteRootPath:
            path = path.GetParentPath()
            prim = self.stage.GetPrimAtPath(path.GetPrimPath())
        return self.lacking(prim) if prim and not prim.IsPseudoRoot() else ""

    @property
    def shown(self) -> str:
        """The path of the stage as findings show it."""
        return self._files.shown

    def source(self, path: Sdf.Path, place: str) -> SourceLocation:
        """The source of a prim or property that is called `place` in findings: the strongest layer that has it."""
        stands = self.stage.GetPropertyAtPath(path) if path.IsPropertyPath() else None
        prim = self.stage.GetPrimAtPath(path.GetPrimPath())
        specs = (stands.GetPropertyStack() if stands else ()) or (prim.GetPrimStack() if prim else ())
        origins = (self._layers.origins.get(spec.layer.identifier) for spec in specs)
        return self._files.source(next(filter(None, origins), None), place)

    def said_at(self, place: str) -> SourceLocation:
        """The same of what stands at a place of the stage as it is; in a variant, the layer is not known."""
        path = Sdf.Path(place) if place.startswith("/") and Sdf.Path.IsValidPathString(place) else Sdf.Path.emptyPath
        if path.isEmpty or path.ContainsPrimVariantSelection():
            return self._files.source(None, place)
        return self.source(path, place)

    def problems(self, images: set[Path]) -> Iterator[tuple[str, SourceLocation, str]]:
        """Messages of those of USD's validators that open files: kind, source and message; not of `images`."""
        for path, package in self._files.packages.items():
            for kind, message in package.problems:
                yield kind, self._files.source(self._files.origin(path), ""), message
        for file, (place, name) in self._layers.values.unresolved.items():
            if file not in images:
                source = self._files.source(self._layers.naming.get(file), place)
                yield _UNRESOLVED, source, f"Found unresolvable external dependency '{name}'."


def open_stage(path: Path, reach: Reach, scratch: Path, library: DataLibrary) -> Stage:
    """Open a stage, all of whose files lie within reach.

    Parameters
    ----------
    path, reach
        Its file, and where names of files lead.
    scratch
        Packages are unpacked there.
    library
        The definitions.

    Raises
    ------
    ReadError
        If a file of it cannot be read or lies outside, or if it is too large.
    """
    files = StageFiles(path.resolve(), reach.shown(path), reach, scratch.resolve())
    layers = StageLayers(files, library)
    with silenced():
        layer = layers.read()
        try:
            stage = Usd.Stage.Open(layer)
        except Tf.ErrorException as error:
            raise ReadError(rules.READ_FORMAT.at("", f"USD cannot read it: {said(error)}")) from error
    return Stage(stage, layers.findings, files, layers)
