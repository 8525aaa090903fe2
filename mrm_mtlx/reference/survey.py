"""Says beforehand what the reference does not know of everything that a node depends on."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from mrm_mtlx.reference.graph import LINEAR_SPACES, color_transform, connected_node, defining_graph
from mrm_mtlx.reference.nodes import NODES

# Graphs deeper than this are refused with a message instead of running into the interpreter's own limit of 1000 frames,
# of which a node takes six.
MAXIMUM_DEPTH = 120

# Geometric properties that inputs have by default.
GEOMETRY = ("Nworld", "Tworld", "Bworld", "Pworld", "Vworld", "Nobject", "Tobject", "Bobject", "Pobject", "UV0")


# Inputs of a material that have no part in its colour.
_NOT_SEEN = ("displacementshader", "volumeshader")


class UnsupportedError(Exception):
    """The reference does not know something that the surface is made of.

    `names` are the node definitions, colour spaces and geometric properties it lacks, sorted.
    """

    def __init__(self, names: list[str]) -> None:
        super().__init__(f"the reference does not know {', '.join(names)}")
        self.names = names


@dataclass
class Survey:
    """What the reference does not know in everything that a node depends on.

    `heights` are the lengths of the longest chains that end at the nodes already seen, `trail` the nodes on the way.
    """

    unknown: set[str] = field(default_factory=set)
    heights: dict[str, int] = field(default_factory=dict)
    trail: list[str] = field(default_factory=list)

    def visit(self, node: Any) -> int:
        """Survey a node; the length of the longest chain of nodes that ends at it.

        Raises
        ------
        RecursionError
            If the graph is cyclic, or deeper than `MAXIMUM_DEPTH`.
        """
        if node is None:
            return 0
        path = node.getNamePath()
        if path in self.trail:
            msg = f"the graph is cyclic at {path}"
            raise RecursionError(msg)
        if len(self.trail) + self.heights.get(path, 1) > MAXIMUM_DEPTH:
            msg = f"the graph is deeper than {MAXIMUM_DEPTH} nodes at {path}"
            raise RecursionError(msg)
        if path not in self.heights:
            self.trail.append(path)
            self.heights[path] = 1 + max((self.visit(n) for n in self._sources(node)), default=0)
            self.trail.pop()
        return self.heights[path]

    def _sources(self, node: Any) -> list[Any]:
        """Nodes that a node takes values from; what it needs and the reference lacks is noted."""
        definition = node.getNodeDef()
        if definition is None:
            self.unknown.add(str(node.getCategory()))
            return []
        sources = []
        for given in node.getInputs():
            if given.getType() in _NOT_SEEN:
                continue
            self._check_color_space(given)
            sources += [
                connected_node(element) for element in (given, given.getInterfaceInput()) if element is not None
            ]
        if definition.getName() in NODES:
            for declared in definition.getActiveInputs():
                geometry = declared.getDefaultGeomPropString()
                if geometry not in ("", *GEOMETRY) and node.getInput(declared.getName()) is None:
                    self.unknown.add(f"geometric property {geometry}")
            return sources
        graph = defining_graph(definition)
        if graph is None:
            self.unknown.add(str(definition.getName()))
            return sources
        made = [output.getConnectedNode() for output in graph.getOutputs()]
        if None in made:
            self.unknown.add(f"{definition.getName()} (its graph has an output that nothing is connected to)")
        return sources + made

    def _check_color_space(self, given: Any) -> None:
        if not given.getValueString() or not (given.getType().startswith("color") or given.getType() == "filename"):
            return
        space = given.getActiveColorSpace()
        if space not in LINEAR_SPACES and color_transform(given.getDocument(), space) is None:
            self.unknown.add(f"colour space {space}")
