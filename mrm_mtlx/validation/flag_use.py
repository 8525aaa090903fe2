"""Use of the retroreflective flag in generated code."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mrm_mtlx.shadergen import Shader


def ignores_flag(shader: Shader, node_name: str) -> bool:
    """True if the generated code does not depend on a node's retroreflective flag.

    The flag is a variable, unless it is connected. It is ignored if it is declared and never read again, or handed to
    functions none of which reads the parameter. In MDL it is handed to a module that honours it from version 1.11 on.
    """
    source = shader.sources["pixel"]
    if shader.target == "mdl":
        versions = [int(v) for v in re.findall(r"materialx::pbrlib_1_(\d+)", source)]
        return max(versions, default=0) < 11
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
