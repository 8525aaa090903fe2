"""The source of a renderable element for any target: generated code, or the material for a host that generates it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mrm_mtlx.shadergen.generate import OslMode
from mrm_mtlx.shadergen.generate import generate as generate_code
from mrm_mtlx.shadergen.targets import HOST_TARGETS

if TYPE_CHECKING:
    from mrm_mtlx.library import DataLibrary
    from mrm_mtlx.shadergen.generate import Shader


def generate(element: Any, target_name: str, library: DataLibrary, osl_mode: OslMode = OslMode.ALIGNED) -> Shader:
    """The source of a renderable element for a target; `osl_mode` is for OSL alone.

    Of a target of `TARGETS` it is code, see `generate.generate`; of one of `HOST_TARGETS`, the material as a network of
    USD, whose host has a node library of its own.

    Raises
    ------
    MissingCodeError
        If the libraries have no code for the target of nodes that they define, or the target no form for the element.
    GenerationError
        If MaterialX refuses; the message is its own.
    """
    if target_name in HOST_TARGETS:
        from mrm_mtlx.shadergen.usd.network import generate_network

        return generate_network(element, target_name)
    return generate_code(element, target_name, library, osl_mode)
