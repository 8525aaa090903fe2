"""Names of files among the values of a layer, and what else of its values leads to files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pxr import Ar, Sdf

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.findings import rules
from mrm_mtlx.formats.usd.opening.layers import PACKAGE_SUFFIX, SUFFIXES

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.formats.usd.opening.stage_files import Origin, StageFiles

_ASSETS = (Sdf.ValueTypeNames.Asset, Sdf.ValueTypeNames.AssetArray)


class AssetValues:
    """Names of files among values, made such that USD may be given them.

    Attributes
    ----------
    unresolved
        Files that are not there, with where the first of their names stands, and the name.
    findings
        What was left out.
    """

    def __init__(self, files: StageFiles) -> None:
        self._files = files
        self.unresolved: dict[Path, tuple[str, str]] = {}
        self.findings: list[Finding] = []

    def look_at(self, origin: Origin, attribute: Sdf.AttributeSpec, is_crate: bool) -> None:
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

    def leave_clips(self, origin: Origin, spec: Sdf.PrimSpec) -> None:
        """Take value clips away: USD looks for their files when it composes. None may lie outside."""
        place, clips = str(spec.path), spec.GetInfo("clips")
        for clip in clips.values() if isinstance(clips, dict) else ():
            if isinstance(clip, dict):
                names = [*clip.get("assetPaths", ()), clip.get("manifestAssetPath"), clip.get("templateAssetPath")]
                for name in filter(None, names):
                    self._files.located(origin, getattr(name, "path", name), place)
        spec.ClearInfo("clips")
        message = "value clips are not opened; values are those of the default time"
        self.findings.append(rules.INTERCHANGE_LOST.at(place, message))

    def name(self, origin: Origin, name: str, place: str) -> str:
        """A file's name as USD may be given it: the path of one that is there, since its layer has no folder for USD.

        Of a file in a package, which USD would open to look for it, it is the path of the copy.
        """
        if "`" in name:
            _refuse_expression(name, place)
            return name
        outer, inner = Ar.SplitPackageRelativePathOuter(Sdf.Layer.SplitIdentifier(name)[0])
        in_package = bool(inner) and outer.lower().endswith(PACKAGE_SUFFIX)
        if outer.lower().endswith(SUFFIXES):
            found: Origin | None = self._files.located(origin, name, place)
        else:
            found = self._files.inside(origin, outer) if outer else None
        if found is not None and "<" not in name and not found.file.exists():
            self.unresolved.setdefault(found.file, (place, name))
        if found is not None and in_package:
            return str(found.file)
        if found is None or inner or not found.file.is_file():
            return name
        return str(self._files.beside(origin, outer))

    def _named(self, origin: Origin, value: Any, place: str) -> Any:
        """A value whose names of files can be asked of USD; the same object if it is such a value already."""
        if isinstance(value, Sdf.AssetPath):
            name = self.name(origin, value.path, place)
            return value if name == value.path else Sdf.AssetPath(name)
        if isinstance(value, Sdf.AssetPathArray):
            names = [self.name(origin, item.path, place) for item in value]
            if names != [item.path for item in value]:
                return Sdf.AssetPathArray([Sdf.AssetPath(name) for name in names])
        return value


def refuse_expressions(layer: Sdf.Layer) -> None:
    """Refuse a layer whose variables might make a name of a file in a package."""
    for text in _texts(layer.expressionVariables if layer.HasExpressionVariables() else {}):
        _refuse_expression(text, "")


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
