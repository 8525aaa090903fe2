"""Files that a stage names, such as textures, under the names that they have in a document."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pxr import Sdf

if TYPE_CHECKING:
    from pathlib import Path

    from pxr import Usd

    from mrm_mtlx.formats.usd.opening.stage import Stage


class Assets:
    """The files of one stage; `seen` are the absolute paths of those that were asked for."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self.packed, self.reach = stage.packed, stage.reach
        self.seen: set[Path] = set()

    def name(self, attribute: Usd.Attribute) -> str:
        """Name of the file that an attribute means, "" for none."""
        value = attribute.Get(attribute.GetTimeSamples()[0]) if attribute.GetNumTimeSamples() else attribute.Get()
        if not isinstance(value, Sdf.AssetPath) or not value.path:
            return ""
        for spec in attribute.GetPropertyStack():
            if spec.HasInfo("default") or spec.HasInfo("timeSamples"):  # the layer that gives it its value
                file = self._stage.file(spec.layer, value.path)
                self.seen.add(file)
                return self._stage.name(file)
        return str(value.path)
