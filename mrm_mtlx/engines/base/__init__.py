"""The contract of engines, and the types that cross it.

`Engine` says what an engine is, `Program` what it makes of a shader, `Capabilities` what that can be asked for. An
engine that renders says so by the objects that it has: a `ClosureBench`, a `SceneRenderer`. All above asks
`engines.registry` for an engine that can do what it wants, and names none.
"""

from mrm_mtlx.engines.base.availability import Availability
from mrm_mtlx.engines.base.closures import ClosureBench, ClosureProgram
from mrm_mtlx.engines.base.engine import Engine
from mrm_mtlx.engines.base.errors import CompileError, CompileMessage, EngineFailure
from mrm_mtlx.engines.base.lighting import DirectionalLight, Environment, Lighting, PointLight
from mrm_mtlx.engines.base.program import FLOAT32_BITS, Capabilities, CompiledOnly, Program, SurfacePoints, evaluate_all
from mrm_mtlx.engines.base.scenes import Scene, SceneRenderer, Take, looking_along, point, sun

__all__ = [
    "FLOAT32_BITS",
    "Availability",
    "Capabilities",
    "ClosureBench",
    "ClosureProgram",
    "CompileError",
    "CompileMessage",
    "CompiledOnly",
    "DirectionalLight",
    "Engine",
    "EngineFailure",
    "Environment",
    "Lighting",
    "PointLight",
    "Program",
    "Scene",
    "SceneRenderer",
    "SurfacePoints",
    "Take",
    "evaluate_all",
    "looking_along",
    "point",
    "sun",
]
