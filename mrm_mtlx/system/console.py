"""The console of C++ libraries: they write to the process's descriptors, whatever Python does with its streams."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator


# Descriptors that are put aside while anything in this process is silenced, by how many threads, and who may look.
_saved: list[int] = []
_silent = 0
_lock = threading.Lock()


@contextlib.contextmanager
def silenced() -> Iterator[None]:
    """Drop what is written to the descriptors of stdout and stderr meanwhile, by whatever thread.

    Contexts may be within each other, and overlap in several threads: the descriptors are back after the last.
    """
    _begin()
    try:
        yield
    finally:
        _end()


def _begin() -> None:
    global _silent  # the descriptors are the process's
    with _lock:
        if not _silent:
            sys.stdout.flush()
            sys.stderr.flush()
            _saved[:] = [os.dup(1), os.dup(2)]
            with Path(os.devnull).open("w") as sink:
                os.dup2(sink.fileno(), 1)
                os.dup2(sink.fileno(), 2)
        _silent += 1


def _end() -> None:
    global _silent
    with _lock:
        _silent -= 1
        if not _silent:
            for number, copy in zip((1, 2), _saved, strict=True):
                os.dup2(copy, number)
                os.close(copy)
