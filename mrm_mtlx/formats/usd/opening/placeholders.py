"""Empty layers for files that are not opened, so that what depends on them can be told by USD's composition."""

from __future__ import annotations

from pxr import Sdf, Usd

# The prim of a layer whose own are not known.
_DEFAULT = Sdf.Path("/missing")


class Placeholders:
    """Layers without content, by their identifiers; each lives as long as this."""

    def __init__(self) -> None:
        self._layers: dict[str, Sdf.Layer] = {}
        self._missing: dict[str, str] = {}

    def add(self, name: str, *, missing: bool) -> str:
        """Identifier of a new one; `missing` ones are those that `lacking` finds."""
        layer = Sdf.Layer.CreateAnonymous(".usda")
        self._layers[layer.identifier] = layer
        if missing:
            self._missing[layer.identifier] = name
        return str(layer.identifier)

    def define(self, identifier: str, path: Sdf.Path) -> None:
        """Let one have the prim that a reference names: one to what is not there would be an error of its own."""
        layer = self._layers.get(identifier)
        if layer is not None:
            layer.defaultPrim = _DEFAULT.name
            Sdf.CreatePrimInLayer(layer, path if path.IsPrimPath() else _DEFAULT)

    def lacking(self, prim: Usd.Prim) -> str:
        """Name of a file that is missing and to which a prim, or one around or in it, refers; "" for none.

        A sublayer that is missing might say something of any prim: it does not count.
        """
        if not self._missing:
            return ""
        above = []
        around = prim.GetParent()
        while around and not around.IsPseudoRoot():
            above.append(around)
            around = around.GetParent()
        for around in (*above, *Usd.PrimRange(prim, Usd.TraverseInstanceProxies())):
            for spec in around.GetPrimStack():
                if spec.layer.identifier in self._missing:
                    return self._missing[spec.layer.identifier]
        return ""
