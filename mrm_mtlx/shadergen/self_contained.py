"""Self-contained OSL: generated source with MaterialX's headers in it, for hosts that have none of them.

Headers that a compiler adds by itself, `stdosl.h` and what that includes, stay out: each renderer has its own.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import MaterialX as mx

from mrm_mtlx.shadergen.generate import GenerationError

if TYPE_CHECKING:
    from mrm_mtlx.shadergen.generate import Shader

# The folder, below a MaterialX root, of the headers that generated OSL includes.
_HEADERS = "libraries/stdlib/genosl/include"
_COMPILERS_OWN = "stdosl.h"

_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*["<]([^">\n]*)[">].*$', re.MULTILINE)
# Means nothing in the source itself, and the compiler warns of it.
_ONCE = re.compile(r"^[ \t]*#[ \t]*pragma[ \t]+once.*\n?", re.MULTILINE)


def header_folder() -> Path:
    """The folder of the headers that generated OSL includes, of the installed MaterialX."""
    return Path(mx.getDefaultDataSearchPath().find(_HEADERS).asString())


def self_contained(shader: Shader) -> Shader:
    """A generated OSL shader with each header in the place where it is included first; no `#include` is left.

    It compiles with no include path, and to the same shader.

    Raises
    ------
    GenerationError
        If it includes anything but MaterialX's headers and the compiler's own.
    """
    return replace(shader, sources={stage: _inlined(source, set()) for stage, source in shader.sources.items()})


def _inlined(source: str, known: set[str]) -> str:
    """A source with its headers in it, but for those that are known; they become known."""

    def content(include: re.Match[str]) -> str:
        name = include[1]
        if name in known or name == _COMPILERS_OWN:
            return ""
        known.add(name)
        return _inlined(_ONCE.sub("", _header(name)), known).rstrip("\n")

    return _INCLUDE.sub(content, source)


def _header(name: str) -> str:
    """The text of a header of MaterialX: none else is read, whatever a document's own source may include."""
    for header in header_folder().glob("*.h"):
        if header.name == name:
            return header.read_text(encoding="utf-8")
    msg = f"the source includes '{name}', which is no header of MaterialX and cannot become a part of it"
    raise GenerationError(msg)
