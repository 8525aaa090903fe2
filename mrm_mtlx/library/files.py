"""Files: where a name of a document leads, and writing them whole or not at all."""

from __future__ import annotations

import contextlib
import os
import shutil
from typing import TYPE_CHECKING

from mrm_mtlx.limits import MAXIMUM_BYTES, MAXIMUM_INCLUDES

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

__all__ = ["MAXIMUM_BYTES", "MAXIMUM_INCLUDES", "replacing", "resolve_inside"]


def resolve_inside(name: str, folder: Path, root: Path) -> Path | None:
    """The file that `name` means in `folder`, links followed; None if it lies outside `root` or nowhere."""
    try:
        target = (folder / name).resolve()
        target.exists()  # raises OSError of a name that is too long, as whatever asks for the file later would
    except (OSError, RuntimeError, ValueError):  # a link that leads to itself, a name with a zero byte
        return None
    return target if target.is_relative_to(root.resolve()) else None


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A file beside `path`, of the same suffix, to write to; it takes the place of `path` if all went well.

    Whatever happens before that, a full disk or an interrupt, leaves `path` as it was and nothing beside it. What is
    not a plain file (a pipe, /dev/stdout) is written to directly.

    Raises
    ------
    OSError
        If the file cannot take the place of `path`.
    """
    if path.exists() and not path.is_file():
        yield path
        return
    target = path.resolve()  # a link keeps leading where it led
    unfinished = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    try:
        yield unfinished
        if target.exists():
            shutil.copymode(target, unfinished)
        unfinished.replace(target)
    finally:
        unfinished.unlink(missing_ok=True)
