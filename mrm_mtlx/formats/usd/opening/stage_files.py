"""The files of a stage by their names in its layers: beside a layer, in folders of the search path, in packages."""

from __future__ import annotations

import os
import posixpath
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path

from pxr import Ar, Sdf

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.findings import rules
from mrm_mtlx.findings.finding import shortened
from mrm_mtlx.findings.source_location import SourceLocation
from mrm_mtlx.formats.usd.opening.composition_size import MAXIMUM_DEPTH, too_deep
from mrm_mtlx.formats.usd.opening.layers import MAXIMUM_STAGE_BYTES, PACKAGE_SUFFIX, check_file
from mrm_mtlx.formats.usd.opening.packages import Package, unpack

MAXIMUM_LAYERS = 1024


@dataclass(frozen=True)
class Origin:
    """The origin of a layer: its file, and the package that it was in, if it was in one."""

    file: Path
    package: Package | None


class StageFiles:
    """The files of a stage, none of them outside of its reach, and what of them has been read.

    Attributes
    ----------
    shown
        The path of the stage as findings show it.
    scratch
        Packages are unpacked there.
    packages
        Those that have been unpacked, by their files.
    first_package
        The one that the stage itself is in, if it is in one.
    layers
        The number of layers that have been read.
    """

    def __init__(self, path: Path, shown: str, reach: Reach, scratch: Path) -> None:
        self._path, self._reach, self.scratch = path, reach.at(path.parent), scratch
        self.shown = shown
        self.packages: dict[Path, Package] = {}
        self.first_package: Package | None = None
        self.layers = 0
        self._bytes = 0
        self._known: set[Path] = set()

    def first(self) -> Origin:
        """The first layer of the stage."""
        found = self.whole(Origin(self._path, None), "")
        self.first_package = found.package
        return found

    @property
    def document_reach(self) -> Reach:
        """The reach of names in a document of the stage: what is in a package leads nowhere else."""
        if self.first_package is not None:
            return Reach.only(self.scratch)
        return replace(self._reach, search=(*self._reach.search, self.scratch)) if self.packages else self._reach

    def reach_of(self, origin: Origin) -> Reach:
        """The reach of the names in one of the files."""
        reach = self._reach if origin.package is None else Reach.only(origin.package.folder)
        return reach.at(origin.file.parent)

    def beside(self, origin: Origin, name: str) -> Path:
        """The absolute path that a name in a layer means, which may lead anywhere.

        What is not beside the layer is looked for in the folders of the search path, and in a package at its top, as
        USD does. USD's own search path does not count.
        """
        near = Path(os.path.normpath(origin.file.parent / name))
        if os.path.lexists(near) or name.startswith(("./", "../")):
            return near
        others = self._reach.search if origin.package is None else (origin.package.folder,)
        found = (Path(os.path.normpath(folder / name)) for folder in others)
        return next((path for path in found if os.path.lexists(path)), near)

    def origin(self, file: Path) -> Origin:
        """A file with the package that it was unpacked from, if it was."""
        around = [package for package in self.packages.values() if file.is_relative_to(package.folder)]
        return Origin(file, max(around, key=lambda package: len(package.folder.parts), default=None))

    def source(self, origin: Origin | None, place: str) -> SourceLocation:
        """A place in a layer, or in one that is not known."""
        file, layer = self._names(origin) if origin else (self.shown, None)
        return SourceLocation(file, layer=layer, prim=shortened(place) if place.startswith("/") else "")

    def _names(self, origin: Origin) -> tuple[str, str]:
        """The path of a layer's file as findings show it, or of the package around it; and the layer's name."""
        file, package = origin.file, origin.package
        if package is not None:
            outer = self.origin(next(path for path, known in self.packages.items() if known is package))
            name, layer = self._names(outer)
            return name, f"{layer}[{file.relative_to(package.folder).as_posix()}]"
        if file == self._path:
            name = self.shown
        elif file.is_relative_to(self._path.parent):
            name = posixpath.join(posixpath.dirname(self.shown), file.relative_to(self._path.parent).as_posix())
        else:
            name = self._reach.shown(file)
        return name, name

    def count(self, file: Path, place: str) -> None:
        """Count a file to the size of the stage; refuse it if it makes that too large."""
        if file.is_file() and file not in self._known:
            self._known.add(file)
            self._bytes += file.stat().st_size
        if self._bytes > MAXIMUM_STAGE_BYTES or self.layers > MAXIMUM_LAYERS:
            bounds = f"more than {MAXIMUM_LAYERS} layers or {MAXIMUM_STAGE_BYTES // 2**20} MiB"
            raise ReadError(rules.READ_TOO_LARGE.at(place, f"the stage consists of {bounds}"))

    def located(self, origin: Origin, name: str, place: str) -> Origin:
        """The file that a name in a layer means, which lies inside; it need not be there."""
        path, inner = Ar.SplitPackageRelativePathOuter(Sdf.Layer.SplitIdentifier(name)[0])
        found = self.inside(origin, path)
        while found is not None and inner and found.file.exists():
            path, inner = Ar.SplitPackageRelativePathOuter(inner)
            package = self._unpacked(found.file, place)
            file = Reach.only(package.folder).inside(Path(path))
            found = None if file is None else Origin(file, package)
        if found is None:
            message = f"the file '{name}' lies outside the folder being checked"
            raise ReadError(rules.READ_OUTSIDE.at(place, message))
        return found

    def inside(self, origin: Origin, name: str) -> Origin | None:
        """The file that a plain name means; None for one outside. Names in a package mean what is in it."""
        package = None if Path(name).is_absolute() else origin.package
        reach = self._reach if package is None else Reach.only(package.folder)
        file = reach.inside(self.beside(origin, name))
        return None if file is None else Origin(file, package)

    def whole(self, found: Origin, place: str) -> Origin:
        """A layer's file: that of a package is its first."""
        for _ in range(MAXIMUM_DEPTH):
            if found.file.suffix.lower() != PACKAGE_SUFFIX:
                return found
            package = self._unpacked(found.file, place)
            found = Origin(package.first, package)
        raise ReadError(too_deep(place))

    def _unpacked(self, path: Path, place: str) -> Package:
        if path not in self.packages:
            self.count(path, place)
            check_file(path, place)
            folder = self.scratch
            if self.packages or path != self._path:
                names = (f"{path.name}.{number}" for number in count(len(self.packages)))
                places = (self._path.parent, self.scratch)
                folder /= next(name for name in names if not any((place / name).exists() for place in places))
                folder.mkdir()
            self.packages[path] = unpack(path, folder, place)
        return self.packages[path]
