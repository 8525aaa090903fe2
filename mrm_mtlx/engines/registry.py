"""The engines that there are: those of this package, and those that other packages register.

The one place that names them. An engine of another package is an entry point of the group `mrm_mtlx.engines` whose
value is an instance of `base.Engine`:

    [project.entry-points."mrm_mtlx.engines"]
    metal = "my_package.metal:ENGINE"
"""

from __future__ import annotations

from functools import cache
from importlib import metadata
from typing import TYPE_CHECKING

from mrm_mtlx.engines.base import Availability, CompileError, CompileMessage, Engine

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from typing import Any, NoReturn

    from numpy.typing import NDArray

    from mrm_mtlx.shadergen import Shader

GROUP = "mrm_mtlx.engines"

# In the order of reports, and of choice.
_OWN = {
    "gl": "mrm_mtlx.engines.gl:ENGINE",
    "vulkan": "mrm_mtlx.engines.glslang:ENGINE",
    "slang": "mrm_mtlx.engines.slang:ENGINE",
    "osl": "mrm_mtlx.engines.osl:COMPILER",
    "cycles": "mrm_mtlx.engines.osl:CYCLES",
    "storm": "mrm_mtlx.engines.storm:ENGINE",
}

# Why targets end at the source where no engine takes them.
_UNSERVED = {
    "msl": "no Metal compiler: Apple's tools only",
    "wgsl": "no WGSL compiler: MaterialX writes GLSL to be transpiled",
    "mdl": "no MDL compiler",
}


@cache
def engines() -> Mapping[str, Engine]:
    """All engines by name: first those of this package, then those of others, by their names.

    One that does not load is among them, unavailable, with the reason.
    """
    own = [metadata.EntryPoint(name, value, GROUP) for name, value in _OWN.items()]
    others = sorted(metadata.entry_points(group=GROUP), key=lambda entry: (entry.name, entry.value))
    found: dict[str, Engine] = {}
    for entry in [*own, *others]:
        engine = _load(entry, found)
        found.setdefault(engine.name, engine)
    return found


def engines_for(target: str) -> list[Engine]:
    """The engines that take source of a target; those that run it before those that only compile it."""
    serving = [engine for engine in engines().values() if target in engine.targets]
    return sorted(serving, key=lambda engine: not engine.capabilities.runs)


def engine_for(target: str, fit: Callable[[Engine], bool] | None = None) -> Engine | None:
    """The engine to use for a target, of those that fit: the first that works here.

    If none does, the first, whose availability says what is missing; None if there is none.
    """
    fitting = [engine for engine in engines_for(target) if fit is None or fit(engine)]
    return next((engine for engine in fitting if engine.availability().available), next(iter(fitting), None))


def unserved(target: str) -> str:
    """The reason why the source of a target is not compiled, where no engine takes it."""
    return _UNSERVED.get(target, f"no engine takes {target}")


def runs(engine: Engine) -> bool:
    """True if an engine's programs give colours at points."""
    return engine.capabilities.runs


def measures_closures(engine: Engine) -> bool:
    """True if an engine measures what closures reflect."""
    return engine.bench is not None


def renders(engine: Engine) -> bool:
    """True if an engine can make a picture."""
    return runs(engine) or engine.scene_renderer is not None


def targets(fit: Callable[[Engine], bool]) -> frozenset[str]:
    """The targets of the engines that fit."""
    return frozenset(target for engine in engines().values() if fit(engine) for target in engine.targets)


def survey(targets: Iterable[str]) -> dict[str, Availability]:
    """The engines that are used for targets here and how they are, by name, in the order of the registry."""
    used = {engine.name for target in targets if (engine := engine_for(target)) is not None}
    states = {name: engine.availability() for name, engine in engines().items() if name in used}
    for name in states:
        engines()[name].stop()  # the worker processes have their own
    return states


def _load(entry: metadata.EntryPoint, found: Mapping[str, Engine]) -> Engine:
    try:
        engine = entry.load()
    except Exception as error:  # whatever the modules of other packages raise
        return _Broken(entry, f"it does not load: {type(error).__name__}: {error}")
    if not isinstance(engine, Engine):
        return _Broken(entry, f"{entry.value} is no Engine")
    if engine.name in found:
        return _Broken(entry, f"there is another engine of the name {engine.name}")
    return engine


class _Broken(Engine):
    """An entry point that gives no engine."""

    use = "of another package"
    targets = ()

    def __init__(self, entry: metadata.EntryPoint, reason: str) -> None:
        self.name = entry.value
        self._state = Availability(False, reason, "upgrade or remove the package that registers it")

    def availability(self) -> Availability:
        """As `Engine.availability`; the detail says what is wrong."""
        return self._state

    def compile(self, shader: Shader, images: Mapping[str, NDArray[Any]] | None = None) -> NoReturn:
        """Refuse: it has no targets, and nobody asks."""
        del shader, images
        raise CompileError([CompileMessage(0, "", self._state.detail)])
