"""A command in a process of its own, and the process that waits for it.

On untrusted documents the libraries of C++ crash, loop for ever or ask for all memory, and then no Python code runs any
more. So a command runs in a child; the parent, which has loaded none of them, says what became of it, removes its files
and ends with the exit status that is promised. Where processes cannot be forked, a command runs without all this.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrm_mtlx.system import child as child_process

if TYPE_CHECKING:
    from collections.abc import Callable

# Signals that end a command; those that are ignored where it was started, as by nohup, stay ignored.
_ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
# Seconds until a signal that the terminal may have sent to the child too is sent on to it, and until it is killed.
_SENT_ON_S, _KILLED_S = 1.0, 5.0


@dataclass(frozen=True)
class Death:
    """A child that a signal ended: which, and the document it worked on, "" for none."""

    status: int
    document: str


class _SignalError(Exception):
    """A signal came; raised out of the parent's waiting."""

    def __init__(self, number: int) -> None:
        self.number = number


def supervised(command: Callable[[], int], tell: Callable[[Death], int]) -> int:
    """Exit status of a command that runs in a child; if it died, of what `tell` says of that.

    Returns in the child, too: the status is for `sys.exit` in both. A process with threads is not forked.
    """
    if not hasattr(os, "fork") or threading.active_count() > 1:
        return command()
    _open_standard_streams()
    try:
        scratch = Path(tempfile.mkdtemp(prefix="mrm-"))
    except OSError:  # whoever needs a scratch folder will say so
        scratch = None
    before = {number: signal.getsignal(number) for number in _ENDING}
    for number in _ENDING:
        if before[number] is not signal.SIG_IGN:
            signal.signal(number, _raise)
    sys.stdout.flush()
    sys.stderr.flush()
    parent = os.getpid()
    child = os.fork()
    if child == 0:
        for number, handler in before.items():
            signal.signal(number, handler)
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # the end that an interrupt has, its tidying included
        child_process.become(parent, scratch)
        return command()
    try:
        return _outcome(child, scratch, tell)
    finally:
        if scratch is not None:
            shutil.rmtree(scratch, ignore_errors=True)


def _open_standard_streams() -> None:
    """Stand in for streams that were closed where the command was started: no other file may take their numbers."""
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        if getattr(sys, name) is None:
            with contextlib.suppress(OSError):
                os.dup2(os.open(os.devnull, os.O_RDWR), number)
                os.set_inheritable(number, True)
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))  # noqa: SIM115  # until the end


def _raise(number: int, _frame: Any) -> None:
    raise _SignalError(number)


def _outcome(child: int, scratch: Path | None, tell: Callable[[Death], int]) -> int:
    try:
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    except _SignalError as signalled:
        return _end(child, signalled.number)
    if status >= 0:
        return status
    note = None if scratch is None else scratch / child_process.NOTE
    document = note.read_text(encoding="utf-8") if note is not None and note.is_file() else ""
    return tell(Death(status, document))


def _end(child: int, number: int) -> int:
    """End the child because of a signal: its exit status, or what the shell makes of the signal."""
    status = _awaited(child, _SENT_ON_S) if number == signal.SIGINT else None
    if status is None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, number if number == signal.SIGINT else signal.SIGTERM)
        status = _awaited(child, _KILLED_S)
    if status is None:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        status = -signal.SIGKILL
    if number == signal.SIGINT and status < 0:
        print("mrm: interrupted", file=sys.stderr)
    return status if status >= 0 and number == signal.SIGINT else 128 + number


def _awaited(child: int, seconds: float) -> int | None:
    """Exit status of the child, if it ends within so many seconds, and no other signal comes."""
    end = time.monotonic() + seconds
    with contextlib.suppress(_SignalError):
        while time.monotonic() < end:
            ended, status = os.waitpid(child, os.WNOHANG)
            if ended:
                return os.waitstatus_to_exitcode(status)
            time.sleep(0.02)
    return None
