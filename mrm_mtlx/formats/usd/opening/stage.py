"""Opening an untrusted stage: its layers are looked at one by one before USD composes them.

USD opens whatever a layer names, parses nested prims by recursion, and expands references without a bound. So the files
are found, read and weighed here, and USD is given what was read: layers without a file, which name each other. Of its
own accord it opens no file then, whatever the form of a name, and whatever the search path of its resolver.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pxr import Ar, Sdf, Tf, Usd

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.documents.files import Reach
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.usd.opening.documents import MATERIALS, open_document
from mrm_mtlx.formats.usd.opening.documents import SUFFIX as DOCUMENT_SUFFIX
from mrm_mtlx.formats.usd.opening.layers import MAXIMUM_STAGE_BYTES, PACKAGE_SUFFIX, SUFFIXES, check_file, open_layer
from mrm_mtlx.formats.usd.opening.packages import Package, unpack
from mrm_mtlx.formats.usd.opening.standins import StandIns
from mrm_mtlx.formats.usd.opening.weighing import MAXIMUM_DEPTH, Arc, Layer, refuse_heavy, too_deep
from mrm_mtlx.formats.usd.texts import said
from mrm_mtlx.system.console import silenced

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.library import DataLibrary

MAXIMUM_LAYERS = 1024
# What USD's validator of names says of one that leads to no file.
_UNRESOLVED = "usdUtilsValidators:MissingReferenceValidator.UnresolvableDependency"
_ASSETS = (Sdf.ValueTypeNames.Asset, Sdf.ValueTypeNames.AssetArray)


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
    _scan: _Scan

    @property
    def packed(self) -> bool:
        """Whether it was opened from a package."""
        return self._scan.first_package is not None

    @property
    def reach(self) -> Reach:
        """Where the names that `name` gives lead."""
        return self._scan.document_reach

    def file(self, layer: Sdf.Layer, name: str) -> Path:
        """The file that a name in a layer means, inside or not, there or not."""
        return self._scan.beside(self._scan.origins[layer.identifier], name)

    def name(self, file: Path) -> str:
        """A file's name in a document: that of one out of a package is relative to where packages are unpacked."""
        scratch = self._scan.scratch
        folder = scratch if file.is_relative_to(scratch) else self.reach.folder
        return os.path.relpath(file, folder).replace(os.sep, "/")

    def lacking(self, prim: Usd.Prim) -> str:
        """Name of a missing layer that might say something of a prim; "" for none."""
        return self._scan.standins.lacking(prim)

    def lacking_at(self, path: Sdf.Path) -> str:
        """The same of what stands at a path, or would."""
        prim = self.stage.GetPrimAtPath(path.GetPrimPath())
        while not prim and path != Sdf.Path.absoluteRootPath:
            path = path.GetParentPath()
            prim = self.stage.GetPrimAtPath(path.GetPrimPath())
        return self.lacking(prim) if prim and not prim.IsPseudoRoot() else ""

    def problems(self, images: set[Path]) -> Iterator[tuple[str, str, str]]:
        """What those of USD's validators that open files would say: kind, place and message; not of `images`."""
        for package in self._scan.packages.values():
            for kind, message in package.problems:
                yield kind, "", message
        for file, (place, name) in self._scan.unresolved.items():
            if file not in images:
                yield _UNRESOLVED, place, f"Found unresolvable external dependency '{name}'."


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
    scan = _Scan(path.resolve(), reach, scratch.resolve(), library)
    with silenced():
        layer = scan.run()
        try:
            stage = Usd.Stage.Open(layer)
        except Tf.ErrorException as error:
            raise ReadError(rules.READ_FORMAT.at("", f"USD cannot read it: {said(error)}")) from error
    return Stage(stage, scan.findings, scan)


@dataclass(frozen=True)
class _Origin:
    """Where a layer comes from: its file, and the package that it was in, if it was in one."""

    file: Path
    package: Package | None


class _Scan:
    """The layers of a stage, each read once; their names are the absolute paths of their files."""

    def __init__(self, path: Path, reach: Reach, scratch: Path, library: DataLibrary) -> None:
        self._path, self._reach, self.scratch = path, reach.at(path.parent), scratch
        self._library = library
        self._documents: dict[str, str] = {}
        self._layers: dict[str, Layer] = {}
        self.origins: dict[str, _Origin] = {}
        self._acyclic: set[str] = set()
        self._bytes = 0
        self._known: set[Path] = set()
        self.packages: dict[Path, Package] = {}
        self.first_package: Package | None = None
        self.standins = StandIns()
        self.unresolved: dict[Path, tuple[str, str]] = {}
        self.findings: list[Finding] = []

    def run(self) -> Sdf.Layer:
        """Read everything that the stage is made of, and return its first layer.

        Raises
        ------
        ReadError
            See `open_stage`.
        """
        first = self._whole(_Origin(self._path, None), "")
        self.first_package = first.package
        waiting = [(first, "")]
        while waiting:
            origin, place = waiting.pop()
            if str(origin.file) not in self._layers:
                waiting += self._read(origin, place)
        for name in self._layers:
            self._refuse_circles(name, ())
        refuse_heavy(self._layers)
        for entry in self._layers.values():
            self._connect(entry)
        return self._layers[str(first.file)].layer

    @property
    def document_reach(self) -> Reach:
        """Where names in a document of the stage lead: what is in a package leads nowhere else."""
        if self.first_package is not None:
            return Reach.only(self.scratch)
        return replace(self._reach, search=(*self._reach.search, self.scratch)) if self.packages else self._reach

    def beside(self, origin: _Origin, name: str) -> Path:
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

    def _read(self, origin: _Origin, place: str) -> list[tuple[_Origin, str]]:
        """Read a layer, and return those that it names, with where it does; the last is to be opened first."""
        self._weigh(origin.file, place)
        opened = open_layer(origin.file, place)
        entry = self._layers[str(origin.file)] = Layer(opened.layer)
        self.origins[opened.layer.identifier] = origin
        for text in _texts(opened.layer.expressionVariables if opened.layer.HasExpressionVariables() else {}):
            _refuse_expression(text, "")
        waiting: list[tuple[_Origin, str]] = []

        def target(name: str, place: str) -> str:
            if name not in entry.targets:
                found = self._target(origin, name, place)
                if isinstance(found, _Origin):
                    waiting.append((found, place))
                    found = str(found.file)
                entry.targets[name] = found
            return entry.targets[name]

        entry.sublayers = [target(name, "") for name in opened.layer.subLayerPaths]
        for number, spec in entry.prims():
            entry.arcs += self._arcs(number, spec, str(origin.file), target)
            if spec.hasReferences or spec.hasPayloads:
                entry.referring.append(spec)
            if spec.HasInfo("clips"):
                self._leave_clips(origin, spec)
            for attribute in spec.attributes:
                self._look_at(origin, attribute, opened.is_crate)
        return waiting

    def _arcs(self, number: int, spec: Sdf.PrimSpec, own: str, target: Callable[[str, str], str]) -> Iterator[Arc]:
        """What a prim is composed of besides itself; `own` is its layer, and `target` gives others by their names."""
        place, instance = str(spec.path), bool(spec.instanceable)
        for arc in (*_items(spec.referenceList), *_items(spec.payloadList)):
            if arc.primPath.pathElementCount > MAXIMUM_DEPTH:
                raise ReadError(too_deep(place))
            found = target(arc.assetPath, place) if arc.assetPath else own
            self.standins.define(found, arc.primPath)
            self._define_in_document(found, arc.primPath, place)
            yield Arc(number, found, arc.primPath, instance)
        for path in (*_items(spec.inheritPathList), *_items(spec.specializesList)):
            yield Arc(number, "", path, instance)

    def _weigh(self, file: Path, place: str) -> None:
        """Refuse a file that makes the stage too large."""
        if file.is_file() and file not in self._known:
            self._known.add(file)
            self._bytes += file.stat().st_size
        if self._bytes > MAXIMUM_STAGE_BYTES or len(self._layers) > MAXIMUM_LAYERS:
            bounds = f"more than {MAXIMUM_LAYERS} layers or {MAXIMUM_STAGE_BYTES // 2**20} MiB"
            raise ReadError(rules.READ_TOO_LARGE.at(place, f"the stage consists of {bounds}"))

    def _target(self, origin: _Origin, name: str, place: str) -> _Origin | str:
        """The layer that a name means, or the identifier of what stands in for one that is not opened."""
        if "`" in name:
            message = f"the file name {name} is an expression, which could mean any file; expected a name"
            raise ReadError(rules.READ_INCLUDE.at(place, message))
        found = self._located(origin, name, place)
        if not found.file.exists():
            message = f"the file '{name}' does not exist; what it says is left out"
            self.findings.append(rules.USD_MISSING.at(place, message))
            return self.standins.add(name, missing=True)
        if found.file.suffix.lower() in SUFFIXES:
            return self._whole(found, place)
        if found.file.suffix.lower() == DOCUMENT_SUFFIX:
            return self._document(found, name, place)
        message = f"'{name}' is no file of USD and is not opened; check it by itself"
        self.findings.append(rules.INTERCHANGE_LOST.at(place, message))
        return self.standins.add(name, missing=False)

    def _document(self, found: _Origin, name: str, place: str) -> str:
        """What stands for a document of MaterialX: a layer of its materials, if it can be read."""
        key = str(found.file)
        if key not in self._documents:
            self._documents[key] = self._opened_document(found, name, place)
        return self._documents[key]

    def _opened_document(self, found: _Origin, name: str, place: str) -> str:
        self._weigh(found.file, place)
        reach = (self._reach if found.package is None else Reach.only(found.package.folder)).at(found.file.parent)

        def named(path: str) -> str:
            return self._asset(found, path, place)

        try:
            layer, findings = open_document(found.file, reach, self._library, named)
        except ReadError as error:
            where = f"{error.finding.location}: " if error.finding.location else ""
            message = f"the document '{name}' is wrong: {where}{error.finding.message}; check it by itself"
            self.findings.append(rules.USD_MISSING.at(place, message))
            return self.standins.add(name, missing=True)
        except ValueError as error:
            self.findings.append(rules.INTERCHANGE_LOST.at(place, f"the document '{name}' is left out: {error}"))
            return self.standins.add(name, missing=False)
        self.findings += [
            found.rule.at(place, f"'{name}' at {found.location}: {found.message}", found.hint) for found in findings
        ]
        entry = self._layers[str(found.file)] = Layer(layer)
        self.origins[layer.identifier] = found
        for _ in entry.prims():
            pass
        return str(found.file)

    def _define_in_document(self, target: str, path: Sdf.Path, place: str) -> None:
        """Let a document have what a reference names beside its materials, without anything in it."""
        if target not in self._documents or target not in self._layers:
            return
        layer = self._layers[target].layer
        if path.IsPrimPath() and not path.HasPrefix(MATERIALS) and not layer.GetPrimAtPath(path):
            Sdf.CreatePrimInLayer(layer, path)
            message = f"of '{Path(target).name}', {path} is not read; its materials lie in {MATERIALS}"
            self.findings.append(rules.INTERCHANGE_LOST.at(place, message))

    def _located(self, origin: _Origin, name: str, place: str) -> _Origin:
        """The file that a name in a layer means, which lies inside; it need not be there."""
        path, inner = Ar.SplitPackageRelativePathOuter(Sdf.Layer.SplitIdentifier(name)[0])
        found = self._inside(origin, path)
        while found is not None and inner and found.file.exists():
            path, inner = Ar.SplitPackageRelativePathOuter(inner)
            package = self._unpacked(found.file, place)
            file = Reach.only(package.folder).inside(Path(path))
            found = None if file is None else _Origin(file, package)
        if found is None:
            message = f"the file '{name}' lies outside the folder being checked"
            raise ReadError(rules.READ_OUTSIDE.at(place, message))
        return found

    def _inside(self, origin: _Origin, name: str) -> _Origin | None:
        """The file that a plain name means; None for one outside. Names in a package mean what is in it."""
        package = None if Path(name).is_absolute() else origin.package
        reach = self._reach if package is None else Reach.only(package.folder)
        file = reach.inside(self.beside(origin, name))
        return None if file is None else _Origin(file, package)

    def _whole(self, found: _Origin, place: str) -> _Origin:
        """A layer's file: that of a package is its first."""
        for _ in range(MAXIMUM_DEPTH):
            if found.file.suffix.lower() != PACKAGE_SUFFIX:
                return found
            package = self._unpacked(found.file, place)
            found = _Origin(package.first, package)
        raise ReadError(too_deep(place))

    def _unpacked(self, path: Path, place: str) -> Package:
        if path not in self.packages:
            self._weigh(path, place)
            check_file(path, place)
            folder = self.scratch
            if self.packages or path != self._path:
                names = (f"{path.name}.{number}" for number in count(len(self.packages)))
                places = (self._path.parent, self.scratch)
                folder /= next(name for name in names if not any((place / name).exists() for place in places))
                folder.mkdir()
            self.packages[path] = unpack(path, folder, place)
        return self.packages[path]

    def _leave_clips(self, origin: _Origin, spec: Sdf.PrimSpec) -> None:
        """Take value clips away: USD looks for their files when it composes. None may lie outside."""
        place, clips = str(spec.path), spec.GetInfo("clips")
        for clip in clips.values() if isinstance(clips, dict) else ():
            if isinstance(clip, dict):
                names = [*clip.get("assetPaths", ()), clip.get("manifestAssetPath"), clip.get("templateAssetPath")]
                for name in filter(None, names):
                    self._located(origin, getattr(name, "path", name), place)
        spec.ClearInfo("clips")
        message = "value clips are not opened; values are those of the default time"
        self.findings.append(rules.INTERCHANGE_LOST.at(place, message))

    def _look_at(self, origin: _Origin, attribute: Sdf.AttributeSpec, is_crate: bool) -> None:
        """See to the names of files among an attribute's values; a crate may have some whatever the type."""
        is_asset = attribute.typeName in _ASSETS
        if not (is_asset or is_crate):
            return
        place, layer = str(attribute.path), attribute.layer
        value = attribute.default
        named = self._named(origin, value, place)
        if named is not value:
            attribute.ClearDefaultValue()
            if is_asset:
                attribute.default = named
        if attribute.typeName.isArray and not is_asset:
            return
        for time in layer.ListTimeSamplesForPath(attribute.path):
            value = layer.QueryTimeSample(attribute.path, time)
            named = self._named(origin, value, place)
            if named is not value:
                layer.EraseTimeSample(attribute.path, time)
                if is_asset:
                    layer.SetTimeSample(attribute.path, time, named)

    def _named(self, origin: _Origin, value: Any, place: str) -> Any:
        """A value whose names of files can be asked of USD; the same object if it is such a value already."""
        if isinstance(value, Sdf.AssetPath):
            name = self._asset(origin, value.path, place)
            return value if name == value.path else Sdf.AssetPath(name)
        if isinstance(value, Sdf.AssetPathArray):
            names = [self._asset(origin, item.path, place) for item in value]
            if names != [item.path for item in value]:
                return Sdf.AssetPathArray([Sdf.AssetPath(name) for name in names])
        return value

    def _asset(self, origin: _Origin, name: str, place: str) -> str:
        """A file's name as USD may be given it: the path of one that is there, since its layer has no folder for USD.

        Of a file in a package, which USD would open to look for it, it is the path of the copy.
        """
        if "`" in name:
            _refuse_expression(name, place)
            return name
        outer, inner = Ar.SplitPackageRelativePathOuter(Sdf.Layer.SplitIdentifier(name)[0])
        in_package = bool(inner) and outer.lower().endswith(PACKAGE_SUFFIX)
        if outer.lower().endswith(SUFFIXES):
            found: _Origin | None = self._located(origin, name, place)
        else:
            found = self._inside(origin, outer) if outer else None
        if found is not None and "<" not in name and not found.file.exists():
            self.unresolved.setdefault(found.file, (place, name))
        if found is not None and in_package:
            return str(found.file)
        return str(self.beside(origin, outer)) if found is not None and not inner and found.file.is_file() else name

    def _connect(self, entry: Layer) -> None:
        """Let a layer name others by the identifiers that they have here."""

        def identifier(name: str) -> str:
            target = entry.targets.get(name) or self._taken_away(origin, name)
            return str(self._layers[target].layer.identifier) if target in self._layers else target

        def connected(kind: Any) -> Any:
            return lambda arc: kind(identifier(arc.assetPath), *_rest(arc)) if arc.assetPath else arc

        layer = entry.layer
        origin = self.origins[layer.identifier]
        sublayers = dict(
            zip(reversed(list(map(identifier, layer.subLayerPaths))), reversed(layer.subLayerOffsets), strict=True)
        )
        layer.subLayerPaths[:] = list(reversed(sublayers))
        for number, offset in enumerate(reversed(sublayers.values())):
            layer.subLayerOffsets[number] = offset
        for spec in entry.referring:
            spec.referenceList.ModifyItemEdits(connected(Sdf.Reference))
            spec.payloadList.ModifyItemEdits(connected(Sdf.Payload))

    def _taken_away(self, origin: _Origin, name: str) -> str:
        """What a name means that a layer takes away, and so does not follow: a layer that is here, or none."""
        try:
            found = self._located(origin, name, "").file
        except ReadError:
            found = None
        if found in self.packages:
            found = self.packages[found].first
        return str(found) if str(found) in self._layers else self.standins.add(name, missing=False)

    def _refuse_circles(self, name: str, parents: tuple[str, ...]) -> None:
        """Refuse sublayers that contain themselves, or lie too deep in each other."""
        if name in self._acyclic or name not in self._layers:
            return
        if len(parents) > MAXIMUM_DEPTH:
            message = f"layers include each other more than {MAXIMUM_DEPTH} levels deep"
            raise ReadError(rules.READ_INCLUDE.at("", message))
        if name in parents:
            circle = " -> ".join(Path(n).name for n in (*parents[parents.index(name) :], name))
            raise ReadError(rules.READ_INCLUDE.at("", f"the layer includes itself: {circle}"))
        for sublayer in self._layers[name].sublayers:
            self._refuse_circles(sublayer, (*parents, name))
        self._acyclic.add(name)


def _items(arcs: Any) -> list[Any]:
    """All references (or the like) of a list that may add to another list."""
    return list(arcs.GetAddedOrExplicitItems())


def _rest(arc: Sdf.Reference | Sdf.Payload) -> tuple[Any, ...]:
    """What an arc says beside the name of the file."""
    return (arc.primPath, arc.layerOffset, *((arc.customData,) if isinstance(arc, Sdf.Reference) else ()))


def _texts(value: Any) -> Iterator[str]:
    """All texts in the values of a layer's variables."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for item in value.values():
            yield from _texts(item)
    elif not isinstance(value, bool | int | float) and value is not None:
        for item in value:
            yield from _texts(item)


def _refuse_expression(text: str, place: str) -> None:
    """Refuse what might make a name of a file in a package, which USD would open to see whether it is there."""
    if "[" in text:
        message = "an expression has the sign '[', so that it could mean any file in a package; expected a name"
        raise ReadError(rules.READ_INCLUDE.at(place, message))
