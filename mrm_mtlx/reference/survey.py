"""A survey beforehand: whatever the reference does not know of all that a node depends on."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from typing import Any

from mrm_mtlx.documents.graph import connected_node, defining_graph
from mrm_mtlx.library.color_spaces import is_handled
from mrm_mtlx.reference.nodes import NODES
from mrm_mtlx.system.limits import MAXIMUM_NODES

# Graphs deeper than this are refused. Counted are nodes, and what a graph's interface depends on comes on top of the
# graph: the deepest of the standard library, `ramp`, has 269.
MAXIMUM_DEPTH = 400
# A level takes up to sixteen of the interpreter's frames, of which it allows 1000 by default.
sys.setrecursionlimit(max(sys.getrecursionlimit(), 20 * MAXIMUM_DEPTH + 1000))

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
    """Whatever the reference does not know of all that a node depends on.

    `heights` are the lengths of the longest chains that end at the nodes already seen, `trail` the nodes on the way.
    """

    unknown: set[str] = field(default_factory=set)
    heights: dict[str, int] = field(default_factory=dict)
    trail: list[str] = field(default_factory=list)
    sizes: dict[str, int] = field(default_factory=dict)  # by definition

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
        if path not in self.heights and len(self.trail) < MAXIMUM_DEPTH:
            self.trail.append(path)
            # A graph's interface is evaluated from inside of the graph: what it depends on comes on top of it.
            inner = max((self.visit(n) for n in self._inside(node)), default=0)
            self.heights[path] = 1 + inner + max((self.visit(n) for n in self._sources(node)), default=0)
            self.trail.pop()
        if len(self.trail) + self.heights.get(path, MAXIMUM_DEPTH) > MAXIMUM_DEPTH:
            msg = f"the graph is deeper than {MAXIMUM_DEPTH} nodes at {path}"
            raise RecursionError(msg)
        return self.heights[path]

    def _sources(self, node: Any) -> list[Any]:
        """Nodes that a node's inputs take values from; what they need and the reference lacks is noted."""
        definition = node.getNodeDef()
        if definition is None:
            self.unknown.add(str(node.getCategory()))
            return []
        sources = []
        for given in node.getInputs():
            if given.getType() in _NOT_SEEN:
                continue
            elements = [element for element in (given, given.getInterfaceInput()) if element is not None]
            for element in elements:
                self._check_color_space(element)
            sources += [connected_node(element) for element in elements]
        for declared in definition.getActiveInputs():
            geometry = declared.getDefaultGeomPropString()
            if geometry not in ("", *GEOMETRY) and node.getInput(declared.getName()) is None:
                self.unknown.add(f"geometric property {geometry}")
        return sources

    def _inside(self, node: Any) -> list[Any]:
        """The nodes that give the outputs of the graph that defines a node; none for one with a function."""
        definition = node.getNodeDef()
        if definition is None or definition.getName() in NODES:
            return []
        graph = defining_graph(definition)
        if graph is None:
            self.unknown.add(str(definition.getName()))
            return []
        if self._size(definition) > MAXIMUM_NODES:
            self.unknown.add(f"{definition.getName()} (its graphs have more than {MAXIMUM_NODES} nodes in all)")
            return []
        made = [output.getConnectedNode() for output in graph.getOutputs()]
        if None in made:
            self.unknown.add(f"{definition.getName()} (its graph has an output that nothing is connected to)")
        return made

    def _size(self, definition: Any) -> int:
        """Number of nodes that evaluating a node of this definition comes to, graphs inside of graphs counted out."""
        name = str(definition.getName())
        if name not in self.sizes:
            graph = None if name in NODES else defining_graph(definition)
            self.sizes[name] = MAXIMUM_NODES  # of a definition inside of itself
            inside = [] if graph is None else [n.getNodeDef() for n in graph.getNodes()]
            self.sizes[name] = 1 + sum(self._size(d) for d in inside if d is not None)
        return self.sizes[name]

    def _check_color_space(self, given: Any) -> None:
        if not given.getValueString() or not (given.getType().startswith("color") or given.getType() == "filename"):
            return
        space = given.getActiveColorSpace()
        if not is_handled(given.getDocument(), space):
            self.unknown.add(f"colour space {space}")
