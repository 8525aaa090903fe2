"""The shading languages that MaterialX can generate, and the hosts that do so themselves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any


@dataclass(frozen=True)
class Target:
    """One shading language.

    Attributes
    ----------
    name
        What the command line calls it.
    module, generator
        Where MaterialX keeps its generator class.
    hardware
        True for the GLSL family: rasterising shaders with a light loop, which share the `genglsl` implementations.
    suffixes
        File suffix per stage; targets without a vertex stage have a pixel stage alone.
    closures
        True for renderers that evaluate closures themselves: the node library makes a retroreflective lobe there in one
        of the ways of `OslMode`.
    flag_module
        Where the lobes are in a module that the host has: a pattern of the module's version in the source, and the
        first version that honours the retroreflective flag. None where the source has its lobes itself.
    """

    name: str
    module: str
    generator: str
    hardware: bool
    suffixes: dict[str, str]
    closures: bool = False
    flag_module: tuple[str, int] | None = None

    def create(self) -> Any:
        """A new MaterialX shader generator.

        Raises
        ------
        ImportError
            If the installed MaterialX lacks the target.
        """
        module = import_module(f"MaterialX.{self.module}")
        if not hasattr(module, self.generator):
            msg = f"the installed MaterialX has no generator for {self.name}"
            raise ImportError(msg)
        return getattr(module, self.generator).create()


def _hardware(name: str, module: str, generator: str, suffix: str) -> Target:
    return Target(name, module, generator, True, {"vertex": f".vert{suffix}", "pixel": f".frag{suffix}"})


TARGETS: dict[str, Target] = {
    target.name: target
    for target in (
        _hardware("glsl", "PyMaterialXGenGlsl", "GlslShaderGenerator", ".glsl"),
        _hardware("essl", "PyMaterialXGenGlsl", "EsslShaderGenerator", ".essl"),
        _hardware("vulkan", "PyMaterialXGenGlsl", "VkShaderGenerator", ".vk.glsl"),
        _hardware("msl", "PyMaterialXGenMsl", "MslShaderGenerator", ".metal"),
        Target("slang", "PyMaterialXGenSlang", "SlangShaderGenerator", True, {"pixel": ".slang"}),
        _hardware("wgsl", "PyMaterialXGenGlsl", "WgslShaderGenerator", ".wgsl.glsl"),
        Target("osl", "PyMaterialXGenOsl", "OslShaderGenerator", False, {"pixel": ".osl"}, closures=True),
        Target(
            "mdl",
            "PyMaterialXGenMdl",
            "MdlShaderGenerator",
            False,
            {"pixel": ".mdl"},
            flag_module=(r"materialx::pbrlib_1_(\d+)", 11),
        ),
    )
}


def lacking_targets() -> tuple[str, ...]:
    """Names of the targets that the installed MaterialX has no generator for, as one of another version has."""
    return tuple(name for name in TARGETS if name not in available_targets())


@dataclass(frozen=True)
class HostTarget:
    """A host that takes materials and generates its shaders itself, with a MaterialX of its own.

    `name` and `suffixes` are as those of a `Target`; its one stage is the material, as a layer of USD.
    """

    name: str
    suffixes: dict[str, str]


HOST_TARGETS: dict[str, HostTarget] = {"storm": HostTarget("storm", {"pixel": ".usda"})}


def suffixes_of(target: str) -> dict[str, str]:
    """File suffix per stage of any target."""
    return HOST_TARGETS[target].suffixes if target in HOST_TARGETS else TARGETS[target].suffixes


def all_targets() -> tuple[str, ...]:
    """Names of the targets that can be asked for: those that are available, and the hosts, which take their time."""
    return (*available_targets(), *HOST_TARGETS)


def closure_targets() -> tuple[str, ...]:
    """Names of the targets of closures, which have an `OslMode`."""
    return tuple(name for name, target in TARGETS.items() if target.closures)


@cache
def available_targets() -> tuple[str, ...]:
    """Names of the targets that the installed MaterialX generates, in the order of `TARGETS`."""
    names = []
    for target in TARGETS.values():
        try:
            target.create()
        except ImportError:
            continue
        names.append(target.name)
    return tuple(names)
