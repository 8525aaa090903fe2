"""The layers of a stage: each is read once, and named by the others as USD will know it."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pxr import Sdf

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.usd.opening.asset_values import AssetValues, refuse_expressions
from mrm_mtlx.formats.usd.opening.composition_size import MAXIMUM_DEPTH, Arc, Layer, refuse_large, too_deep
from mrm_mtlx.formats.usd.opening.document_layers import MATERIALS, open_document
from mrm_mtlx.formats.usd.opening.document_layers import SUFFIX as DOCUMENT_SUFFIX
from mrm_mtlx.formats.usd.opening.layers import SUFFIXES, open_layer
from mrm_mtlx.formats.usd.opening.placeholders import Placeholders
from mrm_mtlx.formats.usd.opening.stage_files import Origin

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.formats.usd.opening.layers import Opened
    from mrm_mtlx.formats.usd.opening.stage_files import StageFiles
    from mrm_mtlx.library import DataLibrary


class StageLayers:
    """The layers of a stage, by the absolute paths of their files.

    Attributes
    ----------
    origins
        Where each comes from, by its identifier.
    values
        What was found among their values.
    naming
        Which of them names a file among its values that leads nowhere.
    placeholders
        Those that stand for files that are not opened.
    findings
        What was not opened.
    """

    def __init__(self, files: StageFiles, library: DataLibrary) -> None:
        self._files, self._library = files, library
        self._documents: dict[str, str] = {}
        self._layers: dict[str, Layer] = {}
        self._acyclic: set[str] = set()
        self.origins: dict[str, Origin] = {}
        self.values = AssetValues(files)
        self.naming: dict[Path, Origin] = {}
        self.placeholders = Placeholders()
        self.findings: list[Finding] = self.values.findings

    def read(self) -> Sdf.Layer:
        """Read everything that the stage is made of, and return its first layer.

        Raises
        ------
        ReadError
            See `stage.open_stage`.
        """
        with self._told_of(None):
            first = self._files.first()
            waiting: list[tuple[Origin, str, Origin | None]] = [(first, "", None)]
            while waiting:
                origin, place, naming = waiting.pop()
                if str(origin.file) not in self._layers:
                    with self._told_of(naming):
                        self._files.count(origin.file, place)
                        opened = open_layer(origin.file, place)
                    with self._told_of(origin):
                        waiting += [(*named, origin) for named in self._read(origin, opened)]
            for name in self._layers:
                self._refuse_circles(name, ())
            refuse_large(self._layers)
            for entry in self._layers.values():
                self._connect(entry)
        return self._layers[str(first.file)].layer

    @contextmanager
    def _told_of(self, origin: Origin | None) -> Iterator[None]:
        """Tell findings that are made within as findings of a layer."""
        told, unresolved = len(self.findings), len(self.values.unresolved)
        try:
            yield
        except ReadError as error:
            raise ReadError(self._located(error.finding, origin)) from error
        self.findings[told:] = [self._located(found, origin) for found in self.findings[told:]]
        if origin is not None:
            self.naming |= dict.fromkeys(islice(self.values.unresolved, unresolved, None), origin)

    def _located(self, found: Finding, origin: Origin | None) -> Finding:
        return found if found.source else replace(found, source=self._files.source(origin, found.location))

    def _add(self, origin: Origin, layer: Sdf.Layer) -> Layer:
        """Note a layer that was read."""
        entry = self._layers[str(origin.file)] = Layer(layer)
        self.origins[layer.identifier] = origin
        self._files.layers = len(self._layers)
        return entry

    def _read(self, origin: Origin, opened: Opened) -> list[tuple[Origin, str]]:
        """Look at a layer, and return those that it names, with where it does; the last is to be opened first."""
        entry = self._add(origin, opened.layer)
        refuse_expressions(opened.layer)
        waiting: list[tuple[Origin, str]] = []

        def target(name: str, place: str) -> str:
            if name not in entry.targets:
                found = self._target(origin, name, place)
                if isinstance(found, Origin):
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
                self.values.leave_clips(origin, spec)
            for attribute in spec.attributes:
                self.values.look_at(origin, attribute, opened.is_crate)
        return waiting

    def _arcs(self, number: int, spec: Sdf.PrimSpec, own: str, target: Callable[[str, str], str]) -> Iterator[Arc]:
        """The arcs that a prim is composed by; `own` is its layer, and `target` gives others by their names."""
        place, instance = str(spec.path), bool(spec.instanceable)
        for arc in (*_items(spec.referenceList), *_items(spec.payloadList)):
            if arc.primPath.pathElementCount > MAXIMUM_DEPTH:
                raise ReadError(too_deep(place))
            found = target(arc.assetPath, place) if arc.assetPath else own
            self.placeholders.define(found, arc.primPath)
            self._define_in_document(found, arc.primPath, place)
            yield Arc(number, found, arc.primPath, instance)
        for path in (*_items(spec.inheritPathList), *_items(spec.specializesList)):
            yield Arc(number, "", path, instance)

    def _target(self, origin: Origin, name: str, place: str) -> Origin | str:
        """The layer that a name means, or the identifier of what stands in for one that is not opened."""
        if "`" in name:
            message = f"the file name {name} is an expression, which could mean any file; expected a name"
            raise ReadError(rules.READ_INCLUDE.at(place, message))
        found = self._files.located(origin, name, place)
        if not found.file.exists():
            message = f"the file '{name}' does not exist; what it says is left out"
            self.findings.append(rules.USD_MISSING.at(place, message))
            return self.placeholders.add(name, missing=True)
        if found.file.suffix.lower() in SUFFIXES:
            return self._files.whole(found, place)
        if found.file.suffix.lower() == DOCUMENT_SUFFIX:
            return self._document(found, name, place)
        message = f"'{name}' is no file of USD and is not opened; check it by itself"
        self.findings.append(rules.INTERCHANGE_LOST.at(place, message))
        return self.placeholders.add(name, missing=False)

    def _document(self, found: Origin, name: str, place: str) -> str:
        """The layer for a document of MaterialX: its materials, or a placeholder if it cannot be read."""
        key = str(found.file)
        if key not in self._documents:
            self._documents[key] = self._opened_document(found, name, place)
        return self._documents[key]

    def _opened_document(self, found: Origin, name: str, place: str) -> str:
        self._files.count(found.file, place)
        reach = self._files.reach_of(found)

        def named(path: str) -> str:
            return self.values.name(found, path, place)

        try:
            layer, findings = open_document(found.file, reach, self._library, named)
        except ReadError as error:
            where = f"{error.finding.location}: " if error.finding.location else ""
            message = f"the document '{name}' is wrong: {where}{error.finding.message}; check it by itself"
            self.findings.append(rules.USD_MISSING.at(place, message))
            return self.placeholders.add(name, missing=True)
        except ValueError as error:
            self.findings.append(rules.INTERCHANGE_LOST.at(place, f"the document '{name}' is left out: {error}"))
            return self.placeholders.add(name, missing=False)
        self.findings += [
            found.rule.at(place, f"'{name}' at {found.location}: {found.message}", found.hint) for found in findings
        ]
        for _ in self._add(found, layer).prims():
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

    def _taken_away(self, origin: Origin, name: str) -> str:
        """The layer that a name means which a layer takes away, and so does not follow: one that is here, or none."""
        try:
            found = self._files.located(origin, name, "").file
        except ReadError:
            found = None
        if found in self._files.packages:
            found = self._files.packages[found].first
        return str(found) if str(found) in self._layers else self.placeholders.add(name, missing=False)

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
    """The arguments of an arc beside the name of the file."""
    return (arc.primPath, arc.layerOffset, *((arc.customData,) if isinstance(arc, Sdf.Reference) else ()))
