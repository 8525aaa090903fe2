"""What Storm says against a material: errors of USD, and warnings in the log of its process."""

from __future__ import annotations

import re
from pathlib import PurePosixPath
from typing import TYPE_CHECKING

from mrm_mtlx.engines.base import CompileMessage

if TYPE_CHECKING:
    from collections.abc import Iterable

# Folders of OpenUSD's source in which a material becomes a shader: what is said there is about the material.
_FOLDERS = ("hdMtlx", "hdSt", "hgiGL")
_WARNING = re.compile(r"^Warning: in .+? at line \d+ of (\S+) -- (.+)$", re.MULTILINE)


def is_about_material(file: str) -> bool:
    """True for a file of OpenUSD's source that makes shaders of materials."""
    return PurePosixPath(file).parent.name in _FOLDERS


def complaints(errors: Iterable[tuple[str, str]], log: str) -> list[CompileMessage]:
    """What was said against a material, each once: a log's warnings, and errors (file of the source, message).

    The warnings come first: they have the reason, and the error that there is no shader.
    """
    found = [*_WARNING.findall(log), *errors]
    texts = [" ".join(message.split()) for file, message in found if is_about_material(file)]
    return [CompileMessage(0, "", text) for text in dict.fromkeys(texts)]
