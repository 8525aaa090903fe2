"""One function per node definition that MaterialX implements in source; what it defines by a graph needs none.

`registry` has the registry and what a function may ask for; each other module has one group of the standard library's
nodes and registers them when it is imported. Every module of this package is.
"""

from importlib import import_module
from pkgutil import iter_modules

from mrm_mtlx.reference.nodes.registry import NODES, Inputs, ShaderValue, Value, node

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")

__all__ = ["NODES", "Inputs", "ShaderValue", "Value", "node"]
