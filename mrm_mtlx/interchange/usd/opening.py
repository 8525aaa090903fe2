"""Opening a stage that nobody vouches for: its layers are looked at one by one before USD composes them.

USD opens whatever a layer names, parses nested prims by recursion, and expands references without a bound. So the files
are found, read and weighed here first; what USD opens then are the same files.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pxr import Ar, Sdf, Tf, Usd, UsdUtils

from mrm_mtlx.interchange.imported import Remark, UnreadableError
from mrm_mtlx.interchange.usd.weighing import MAXIMUM_DEPTH, Arc, Layer, refuse_heavy, too_deep
from mrm_mtlx.library.console import silenced

if TYPE_CHECKING:
    from collections.abc import Iterator

    from mrm_mtlx.library.files import Reach

# Of all layers together. Geometry may lie beside the materials, so that these are larger than for documents.
MAXIMUM_BYTES = 256 * 2**20
MAXIMUM_LAYERS = 1024

# How files of USD begin, what such a file is called, and what is expected of an ending.
_TEXT, _CRATE, _PACKAGE = b"#usda", b"PXR-USDC", b"PK\x03\x04"
_NAMES = {_TEXT: "USD text", _CRATE: "USD crate", _PACKAGE: "a package"}
_CONTENT = {".usda": (_TEXT,), ".usdc": (_CRATE,), ".usd": (_TEXT, _CRATE), ".usdz": (_PACKAGE,)}
# The endings of layers.
SUFFIXES = tuple(_CONTENT)
# What opens and closes a prim, and what may contain such signs: strings, asset paths, paths, and comments of the three
# kinds that USD knows. What is not closed, which USD refuses, goes on to the end: nothing is scanned twice.
_TOKENS = re.compile(
    rb'"""(?:[^"\\]++|\\.|"(?!""))*+(?:"""|\\?\Z)'
    rb"|'''(?:[^'\\]++|\\.|'(?!''))*+(?:'''|\\?\Z)"
    rb'|"(?:[^"\\\r\n]++|\\.)*+"?'
    rb"|'(?:[^'\\\r\n]++|\\.)*+'?"
    rb"|@@@(?:[^@\\]++|\\@@@|\\|@(?!@@))*+(?:@{3,5}|\Z)|@[^@\r\n]*@|<[^<>\r\n]*>"
    rb"|#[^\r\n]*|//[^\r\n]*|/\*(?:.*?\*/|.*)|[{}]",
    re.DOTALL,
)


def open_stage(path: Path, reach: Reach) -> tuple[Usd.Stage, list[Remark]]:
    """Open a stage, all of whose files lie within reach.

    Returns
    -------
    tuple
        The stage, and remarks about what was not opened.

    Raises
    ------
    UnreadableError
        If a file of it cannot be read or lies outside, or if it is too large.
    """
    scan = _Scan(path.resolve(), reach)
    with silenced():
        scan.run()
        try:
            stage = Usd.Stage.Open(str(path.resolve()))
        except Tf.ErrorException as error:
            raise UnreadableError(Remark("READ_FORMAT", "", f"USD cannot read it: {said(error)}")) from error
    return stage, scan.remarks


def said(error: object) -> str:
    """What USD says is wrong, on one line, without places in its own source and folders of this machine."""
    text = str(error).strip()
    found = re.search(r"in file \S+ : '(.*?)'\s*(?:Error in|$)", text, re.DOTALL)
    text = re.sub(r",?@anon:[^@]*@", "", " ".join((found[1] if found else text).split()))
    text = re.sub(r" <0x[0-9a-f]+>", "", text)
    return re.sub(r"[^\s@'<(]*/([^/\s@]+\.usd[acz]?)", r"\1", text)[:300]


def folder_of(layer: Sdf.Layer) -> Path:
    """The folder in which a layer, or the package that holds it, lies."""
    return Path(Ar.SplitPackageRelativePathOuter(layer.realPath)[0]).parent


class _Scan:
    """The layers of a stage, each read once; names are absolute paths, those inside of packages as "file[inner]"."""

    def __init__(self, path: Path, reach: Reach) -> None:
        self._first, self._reach = str(path), reach
        self._layers: dict[str, Layer] = {}
        self._acyclic: set[str] = set()
        self._bytes = 0
        self.remarks: list[Remark] = []

    def run(self) -> None:
        """Read everything that the stage is made of.

        Raises
        ------
        UnreadableError
            See `open_stage`.
        """
        waiting = [(self._first, "")]
        while waiting:
            name, place = waiting.pop()
            if name not in self._layers:
                entry = self._layers[name] = Layer(self._open(name, place))
                waiting += self._named_by(name, entry)
        for name in self._layers:
            self._refuse_circles(name, ())
        refuse_heavy(self._layers)

    def _open(self, name: str, place: str) -> Sdf.Layer:
        file = Path(Ar.SplitPackageRelativePathOuter(name)[0])
        self._check(file, place)
        try:
            layer = Sdf.Layer.Find(name)
            if layer is None:
                layer = Sdf.Layer.FindOrOpen(name)
            else:  # another stage has it open; the file may have changed since
                layer.Reload(force=True)
        except Tf.ErrorException as error:
            raise UnreadableError(Remark("READ_FORMAT", place, f"{file.name}: {said(error)}")) from error
        if layer is None:
            raise UnreadableError(Remark("READ_FORMAT", place, f"USD cannot read {file.name}"))
        return layer

    def _check(self, file: Path, place: str) -> None:
        """Refuse a file that is too large, nested too deeply, or none of USD's."""
        if not file.is_file():  # a pipe or a device would never end
            raise UnreadableError(Remark("READ_FAILED", place, f"{file.name} is not a regular file"))
        try:
            self._bytes += file.stat().st_size
            if self._bytes > MAXIMUM_BYTES or len(self._layers) > MAXIMUM_LAYERS:
                bounds = f"more than {MAXIMUM_LAYERS} layers or {MAXIMUM_BYTES // 2**20} MiB"
                raise UnreadableError(Remark("READ_TOO_LARGE", place, f"the stage consists of {bounds}"))
            with file.open("rb") as stream:
                head = stream.read(8)
                kind = next((kind for kind in _NAMES if head.startswith(kind)), None)
                if kind == _TEXT:
                    _refuse_depth(head + stream.read(MAXIMUM_BYTES), place)
        except OSError as error:
            raise UnreadableError(Remark("READ_FAILED", place, f"{file.name}: {error.strerror}")) from error
        expected = _CONTENT.get(file.suffix.lower(), tuple(_NAMES))
        if kind not in expected:
            found = "is empty" if not head else f"holds {_NAMES[kind]}" if kind else "is no file of USD"
            message = f"{file.name} {found}; expected {' or '.join(_NAMES[k] for k in expected)}"
            raise UnreadableError(Remark("READ_FORMAT", place, message))

    def _named_by(self, name: str, entry: Layer) -> list[tuple[str, str]]:
        """Layers that a layer names, and where; its prims and arcs are noted on the way."""
        entry.sublayers = [found for path in entry.layer.subLayerPaths for found in self._layer(entry.layer, path, "")]
        waiting = [(sublayer, "") for sublayer in entry.sublayers]
        for number, spec in entry.prims():
            place, instance = str(spec.path), bool(spec.instanceable)
            for arc in (*_items(spec.referenceList), *_items(spec.payloadList)):
                targets = list(self._layer(entry.layer, arc.assetPath, place)) if arc.assetPath else [name]
                entry.arcs += [Arc(number, target, arc.primPath, instance) for target in targets]
                waiting += [(target, place) for target in targets]
            for path in (*_items(spec.inheritPathList), *_items(spec.specializesList)):
                entry.arcs.append(Arc(number, "", path, instance))
            if spec.HasInfo("clips"):
                self._check_clips(entry.layer, spec.GetInfo("clips"), place)
                message = "value clips are not opened; values are those of the default time"
                self.remarks.append(Remark("INTERCHANGE_LOST", place, message))
        return [(target, "") for target in self._also_named(entry.layer)] + waiting  # the last is opened first

    def _also_named(self, layer: Sdf.Layer) -> Iterator[str]:
        """Layers that a layer names otherwise, as by an attribute: USD's validators open them."""
        for names in UsdUtils.ExtractExternalReferences(layer.identifier):
            for name in names:
                if Path(name).suffix.lower() in _CONTENT:
                    target = self._located(layer, name, "")
                    if Path(target).is_file():
                        yield target

    def _check_clips(self, layer: Sdf.Layer, clips: Any, place: str) -> None:
        """Refuse clips that lie outside: USD looks for their files when it composes."""
        for clip in clips.values() if isinstance(clips, dict) else ():
            if isinstance(clip, dict):
                names = [*clip.get("assetPaths", ()), clip.get("manifestAssetPath"), clip.get("templateAssetPath")]
                for name in filter(None, names):
                    self._located(layer, getattr(name, "path", name), place)

    def _layer(self, layer: Sdf.Layer, name: str, place: str) -> Iterator[str]:
        """The layer that a name means, if it is one of USD's."""
        if "`" in name:
            message = f"the file name {name} is an expression, which could mean any file; expected a name"
            raise UnreadableError(Remark("READ_INCLUDE", place, message))
        name = Sdf.Layer.SplitIdentifier(name)[0]
        target = self._located(layer, name, place)
        outer, inner = Ar.SplitPackageRelativePathOuter(target)
        if not Path(outer).exists():
            raise UnreadableError(Remark("READ_INCLUDE", place, f"the file '{name}' does not exist"))
        if Path(inner or outer).suffix.lower() in _CONTENT:
            yield target
        else:
            message = f"'{name}' is no file of USD and is not opened; check it by itself"
            self.remarks.append(Remark("INTERCHANGE_LOST", place, message))

    def _located(self, layer: Sdf.Layer, name: str, place: str) -> str:
        """The absolute path that a name in a layer means."""
        outer, inner = Ar.SplitPackageRelativePathOuter(layer.ComputeAbsolutePath(name))
        file = self._reach.at(folder_of(layer)).inside(Path(outer))
        if file is None:
            message = f"the file '{name}' lies outside the folder being checked"
            raise UnreadableError(Remark("READ_OUTSIDE", place, message))
        return str(Ar.JoinPackageRelativePath([str(file), inner])) if inner else str(file)

    def _refuse_circles(self, name: str, parents: tuple[str, ...]) -> None:
        """Refuse sublayers that contain themselves, or lie too deep in each other."""
        if name in self._acyclic:
            return
        if len(parents) > MAXIMUM_DEPTH:
            message = f"layers include each other more than {MAXIMUM_DEPTH} levels deep"
            raise UnreadableError(Remark("READ_INCLUDE", "", message))
        if name in parents:
            circle = " -> ".join(Path(n).name for n in (*parents[parents.index(name) :], name))
            raise UnreadableError(Remark("READ_INCLUDE", "", f"the layer includes itself: {circle}"))
        for sublayer in self._layers[name].sublayers:
            self._refuse_circles(sublayer, (*parents, name))
        self._acyclic.add(name)


def _items(arcs: Any) -> list[Any]:
    """All references (or the like) of a list that may add to another list."""
    return list(arcs.GetAddedOrExplicitItems())


def _refuse_depth(text: bytes, place: str) -> None:
    """Refuse text that is nested too deeply for USD's parser; dictionaries and variants are nested, too."""
    depth = 0
    for match in _TOKENS.finditer(text):
        depth += {b"{": 1, b"}": -1}.get(match[0], 0)
        if depth > 2 * MAXIMUM_DEPTH:
            line = text.count(b"\n", 0, match.start()) + 1
            raise UnreadableError(too_deep(place or f"line {line}"))
