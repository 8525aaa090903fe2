"""Draws materials in OpenUSD's Storm, without a window, in a process of Blender's module.

* `engine`: the engine; `program`: a material at points, over `facets`, where a camera sees them.
* `material`: materials as Storm takes them; `drawing`: pictures of them, and `messages`, what Storm has against them.
* `process`: the process, which runs the operations of `storm_server`.
"""

from mrm_mtlx.engines.storm.engine import ENGINE

__all__ = ["ENGINE"]
