"""Limits that a process sets itself before it opens what is untrusted: memory, time, and not to outlive its starter.

C++ libraries (MaterialX, USD, OpenImageIO, drivers) exhaust memory and never end on some input, and then no Python code
runs any more: only the operating system can stop them. Where it has no such limit, the function does nothing.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import sys

# Private memory of a process that works on a document [bytes]. All targets of the largest surface models take 0.7 GiB
# with 16,384 samples, most of it for the driver and the reference; a document's images have a bound of their own.
MAXIMUM_MEMORY = 2 * 2**30
# Seconds that a document may take to be opened, and then each of its surfaces on each target.
TIME_LIMIT_S = 300.0

# How a process dies whose time is up: by a signal that nothing catches, whatever library it is in.
TIME_IS_UP = getattr(signal, "SIGALRM", None)

# prctl(2): the signal that a process gets when its parent ends.
_PR_SET_PDEATHSIG = 1


def limit_memory(maximum: int = MAXIMUM_MEMORY) -> None:
    """Let allocations beyond `maximum` bytes of private memory fail (Linux; RLIMIT_DATA, getrlimit(2)).

    The address space is not what counts: drivers and thread pools reserve many times what they use.
    """
    if not sys.platform.startswith("linux"):
        return
    import resource

    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    bound = maximum if hard == resource.RLIM_INFINITY else min(maximum, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (bound, hard))


def memory_reason() -> str:
    """The message where memory ran out."""
    return f"it needs more memory than a process may take ({MAXIMUM_MEMORY / 2**30:g} GiB)"


def limit_time(seconds: float) -> None:
    """Die by `TIME_IS_UP` in so many seconds, counted from now; 0 lifts the limit."""
    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_REAL, seconds)


def can_limit_time() -> bool:
    """True if `limit_time` has an effect here."""
    return hasattr(signal, "setitimer")


def is_time_up(status: int) -> bool:
    """True if a process died because its time was up, by its exit status as Python has it."""
    return TIME_IS_UP is not None and status == -TIME_IS_UP


def die_with(parent: int) -> None:
    """Be killed when the process `parent`, which started this one, ends (Linux), also if it is stopped or in a library.

    The operating system means the thread of the parent that started it.
    """
    if not sys.platform.startswith("linux"):
        return
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:  # it has ended already
        os.kill(os.getpid(), signal.SIGKILL)


def cause_of_death(status: int) -> str:
    """The cause of a process's death, by its exit status as Python has it: negative for signals."""
    if status >= 0:
        return f"exit status {status}"
    try:
        return f"signal {signal.Signals(-status).name}"
    except ValueError:
        return f"signal {-status}"
