"""Use of the retroreflective flag in generated code."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from mrm_mtlx.library.surface_models import amount_input
from mrm_mtlx.shadergen import TARGETS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from mrm_mtlx.shadergen import Shader


def ignored_flags(shader: Shader, nodes: Iterable[Any]) -> frozenset[str]:
    """Names of the nodes whose retroreflective flag, or amount, the generated code does not depend on."""
    # An amount has no variable; the graph behind it has flags, which the node library honours wherever it has code.
    in_module = _flag_module(shader) is not None
    names = (str(node.getName()) for node in nodes if in_module or not amount_input(node))
    return frozenset(name for name in names if ignores_flag(shader, name))


def ignores_flag(shader: Shader, node_name: str) -> bool:
    """True if the generated code does not depend on a node's retroreflective flag.

    The flag is a variable, unless it is connected. It is ignored if it is declared and never read again, or handed to
    functions none of which reads the parameter; where a module of the host has the lobes, if its version does.
    """
    source = shader.sources["pixel"]
    if module := _flag_module(shader):
        pattern, first = module
        return max(map(int, re.findall(pattern, source)), default=0) < first
    flag = rf"\b{re.escape(node_name)}_retroreflective\b"
    calls = re.findall(rf"(\w+)\s*\(([^;{{}}]*{flag}[^;{{}}]*)\)\s*;", source)
    is_variable = re.search(flag, source) is not None
    return is_variable and not any(_reads_argument(source, function, arguments, flag) for function, arguments in calls)


def _reads_argument(source: str, function: str, arguments: str, flag: str) -> bool:
    """True if a function that the source defines reads the parameter that the flag is given for."""
    definition = re.search(rf"^\w[\w ]*\b{function}\s*\(([^)]*)\)\s*\{{(.*?)^\}}", source, re.MULTILINE | re.DOTALL)
    if definition is None:  # built into the language: nothing is known against it
        return True
    index = next(i for i, argument in enumerate(arguments.split(",")) if re.search(flag, argument))
    parameter = definition[1].split(",")[index].split()[-1]
    return re.search(rf"\b{parameter}\b", definition[2]) is not None


def _flag_module(shader: Shader) -> tuple[str, int] | None:
    """As `Target.flag_module`; a host that generates its own code has none."""
    return TARGETS[shader.target].flag_module if shader.target in TARGETS else None
