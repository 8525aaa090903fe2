"""OSL's compiler as an engine, and Cycles as another."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mrm_mtlx.engines.base import CompiledOnly, Engine
from mrm_mtlx.engines.osl import compiler, process
from mrm_mtlx.engines.osl.bench import CyclesBench
from mrm_mtlx.engines.osl.renderer import CyclesRenderer

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from numpy.typing import NDArray

    from mrm_mtlx.engines.base import Availability
    from mrm_mtlx.shadergen import Shader


class OslCompiler(Engine):
    """`oslc`, or the compiler that Cycles has."""

    name = "osl"
    use = "compiles OSL"
    targets = ("osl",)

    def availability(self) -> Availability:
        """As `Engine.availability`; the detail names the compiler."""
        return compiler.availability()

    def compile(self, shader: Shader, images: Mapping[str, NDArray[Any]] | None = None) -> CompiledOnly:
        """As `Engine.compile`."""
        del images  # it has no textures
        compiler.check(shader.sources["pixel"], shader.name)
        return CompiledOnly()

    def stop(self) -> None:
        """As `Engine.stop`."""
        process.stop()


class Cycles(Engine):
    """Cycles, which shows what closures reflect."""

    name = "cycles"
    use = "runs and renders OSL"
    targets = ("osl",)
    bench = CyclesBench(name, *targets)
    scene_renderer = CyclesRenderer(*targets)

    def availability(self) -> Availability:
        """As `Engine.availability`; the detail names the versions of Cycles and OSL."""
        return process.availability()

    def compile(self, shader: Shader, images: Mapping[str, NDArray[Any]] | None = None) -> CompiledOnly:
        """As `Engine.compile`."""
        del images  # its programs do not run over points
        compiler.compile_for_cycles(shader.sources["pixel"], shader.name).unlink(missing_ok=True)
        return CompiledOnly()

    def stop(self) -> None:
        """As `Engine.stop`."""
        process.stop()


COMPILER = OslCompiler()
CYCLES = Cycles()
