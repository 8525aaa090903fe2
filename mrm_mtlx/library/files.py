"""Files that are there whole or not at all."""

from __future__ import annotations

import contextlib
import os
import shutil
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


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
