"""The limits of a process that works for a command line, which another process waits for.

`become` makes a process such a child; in all others, as in a user's Python, nothing here has an effect. A child binds
itself to the limits of `process_limits` before it opens a document, and notes which one that is, so that the process
that waits for it can say what it died of.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from typing import TYPE_CHECKING

from mrm_mtlx.system import process_limits

if TYPE_CHECKING:
    from pathlib import Path

# The file in the scratch folder with the path of the document at work.
NOTE = "document"

# That somebody waits for this process, the scratch folder that is removed after it, the document that it works on and
# the seconds that this may take.
_waited_for = False
_scratch: Path | None = None
_opened: Path | None = None
_limit_s = process_limits.TIME_LIMIT_S


def become(parent: int, scratch: Path | None) -> None:
    """Make this process a child, which ends with its parent.

    Its temporary files, and those of what it starts, lie in the scratch folder, which the parent removes.
    """
    global _waited_for, _scratch
    process_limits.die_with(parent)
    _waited_for, _scratch = True, scratch
    if scratch is not None:
        tempfile.tempdir = str(scratch)
        os.environ["TMPDIR"] = str(scratch)


def limit(seconds: float) -> None:
    """Set what a document may take, from when it is opened on."""
    global _limit_s
    _limit_s = seconds


def opening(path: Path) -> None:
    """Bind a child to its limits before it opens a document; a process that nobody waits for stays as it is."""
    global _opened
    if not _waited_for:
        return
    _opened = path
    if _scratch is not None:
        with contextlib.suppress(OSError):
            (_scratch / NOTE).write_text(str(path), encoding="utf-8", errors="backslashreplace")
    process_limits.limit_memory()
    renew()


def allow(size: int) -> None:
    """Allow a child so many bytes more than a document may take: for what its user asked for, a picture of any size."""
    if _opened is not None:
        process_limits.limit_memory(process_limits.MAXIMUM_MEMORY + size)


def opened() -> Path | None:
    """The document that this process opened last, if somebody waits for it."""
    return _opened


def renew() -> None:
    """Count the time from now on again: a part of long work was done."""
    if _opened is not None:
        process_limits.limit_time(_limit_s)
