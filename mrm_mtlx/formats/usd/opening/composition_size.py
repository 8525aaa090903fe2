"""The size limits of a composed stage, before it is composed: references within references multiply prims."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from pxr import Sdf

from mrm_mtlx.documents.document import ReadError
from mrm_mtlx.findings import rules

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from mrm_mtlx.findings.finding import Finding

# Prims of the composed stage, each as often as layers and references contribute to it: that is what USD has to hold.
MAXIMUM_PRIMS = 1_000_000
# Prims within prims. The parser takes some ten thousand before it exhausts the stack; real stages have tens.
MAXIMUM_DEPTH = 256
# References that lead to references; composing a thousand takes half a minute, real stages have some ten.
MAXIMUM_CHAIN = 100
# Arcs that are followed to find the size.
_MAXIMUM_STEPS = 5_000_000


class Arc(NamedTuple):
    """An arc by which the prim `number` of a layer has all of another prim below it; `layer` is "" for any layer.

    Instances share what they have.
    """

    number: int
    layer: str
    path: Sdf.Path
    instance: bool


@dataclass
class Layer:
    """A layer that was read: its prims in depth-first order, where each one's subtree ends, its arcs and sublayers.

    `targets` has, by its name in the layer, what stands for each file that it names, and `referring` are the prims with
    references and payloads.
    """

    layer: Sdf.Layer
    targets: dict[str, str] = field(default_factory=dict)
    referring: list[Sdf.PrimSpec] = field(default_factory=list)
    sublayers: list[str] = field(default_factory=list)
    index: dict[Sdf.Path, int] = field(default_factory=dict)
    ends: list[int] = field(default_factory=list)
    arcs: list[Arc] = field(default_factory=list)

    def prims(self) -> Iterator[tuple[int, Sdf.PrimSpec]]:
        """All prims, those in variants included, with their numbers in depth-first order.

        Raises
        ------
        ReadError
            If they are nested too deeply, or damaged.
        """
        waiting: list[tuple[Sdf.PrimSpec | None, int]] = [(self.layer.pseudoRoot, -1)]
        while waiting:
            spec, number = waiting.pop()
            if number >= 0:
                self.ends[number] = len(self.ends)
                continue
            if spec is None:
                raise ReadError(rules.READ_FORMAT.at("", "the file is damaged: it lists a prim that it lacks"))
            if spec.path.pathElementCount > MAXIMUM_DEPTH:
                raise ReadError(too_deep(f"{str(spec.path)[:80]}..."))
            number = self.index[spec.path] = len(self.ends)
            self.ends.append(0)
            yield number, spec
            waiting.append((spec, number))
            for variants in spec.variantSets.values():
                listed = [None] if variants is None else variants.variants.values()
                # One that a damaged file lists and lacks comes as None.
                waiting += [(None if variant is None else variant.primSpec, -1) for variant in listed]
            waiting += [(child, -1) for child in spec.nameChildren]


def too_deep(place: str) -> Finding:
    """The finding about prims that are nested too deeply."""
    return rules.READ_TOO_DEEP.at(place, f"prims are nested more than {MAXIMUM_DEPTH} levels deep")


def refuse_large(layers: Mapping[str, Layer]) -> None:
    """Refuse a stage whose arcs make more prims than `MAXIMUM_PRIMS`; an upper bound is taken.

    Raises
    ------
    ReadError
        If it is so.
    """
    composition = _Composition(layers)
    for name in layers:
        composition.size(name, Sdf.Path.absoluteRootPath)


class _Composition:
    """Numbers of prims by layer and prim, each counted once."""

    def __init__(self, layers: Mapping[str, Layer]) -> None:
        self._layers = layers
        self._sizes: dict[tuple[str, Sdf.Path], int] = {}
        self._chains: dict[tuple[str, Sdf.Path], int] = {}
        self._stacks: dict[str, list[str]] = {}
        self._above = 0
        self._instanced: set[tuple[str, Sdf.Path]] = set()
        self._steps = 0

    def size(self, name: str, path: Sdf.Path) -> int:
        """Number of prims that a reference to this prim of a layer adds."""
        key = (name, path)
        if key not in self._sizes:
            self._sizes[key], self._chains[key] = 0, 0  # a circle of references, which USD refuses
            self._above += 1
            self._refuse_chain(self._above, path)
            self._sizes[key] = sum(self._own(self._layers[member], path, key) for member in self._stack(name))
            self._above -= 1
        return self._sizes[key]

    def _refuse_chain(self, length: int, path: Sdf.Path) -> None:
        if length > MAXIMUM_CHAIN:
            message = f"its references follow each other in a chain of more than {MAXIMUM_CHAIN}"
            raise ReadError(rules.READ_TOO_LARGE.at(str(path), message))

    def _stack(self, name: str) -> list[str]:
        """A layer and its sublayers; all layers for ""."""
        if name not in self._stacks:
            found: dict[str, None] = {}
            waiting = [name] if name else list(self._layers)
            while waiting:
                member = waiting.pop()
                if member in self._layers and member not in found:
                    found[member] = None
                    waiting += self._layers[member].sublayers
            self._stacks[name] = list(found)
        return self._stacks[name]

    def _own(self, entry: Layer, path: Sdf.Path, key: tuple[str, Sdf.Path]) -> int:
        start = entry.index.get(path)
        if start is None:
            return 0
        end = entry.ends[start]
        total = end - start
        first, last = (bisect_left(entry.arcs, number, key=lambda arc: arc.number) for number in (start, end))
        for arc in entry.arcs[first:last]:
            self._steps += 1
            target = (arc.layer, arc.path or self._default(arc.layer))
            if not (arc.instance and target in self._instanced):
                total += self.size(*target)
            self._chains[key] = max(self._chains[key], 1 + self._chains[target])
            self._refuse_chain(self._chains[key], path)
            if arc.instance:
                self._instanced.add(target)
            if total > MAXIMUM_PRIMS or self._steps > _MAXIMUM_STEPS:
                message = f"its references multiply to more than {MAXIMUM_PRIMS} prims"
                raise ReadError(rules.READ_TOO_LARGE.at(str(path), message))
        return total

    def _default(self, name: str) -> Sdf.Path:
        """The prim that a reference without a path means."""
        prim = self._layers[name].layer.defaultPrim if name in self._layers else ""
        return Sdf.Path.absoluteRootPath.AppendPath(prim) if prim else Sdf.Path.absoluteRootPath
