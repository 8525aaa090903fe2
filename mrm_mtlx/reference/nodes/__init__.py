"""One function per node definition that MaterialX implements in source; what it defines by a graph needs none.

`registry` has the registry and what a function may ask for; each other module has one group of the standard library's
nodes and registers them when it is imported here.
"""

from mrm_mtlx.reference.nodes import pbr, sources
from mrm_mtlx.reference.nodes.registry import NODES, Inputs, ShaderValue, Value, node

__all__ = ["NODES", "Inputs", "ShaderValue", "Value", "node", "pbr", "sources"]
