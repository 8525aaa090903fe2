"""What C++ writes to the process's descriptors can be dropped, and comes back afterwards."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from mrm_mtlx.system.console import silenced


def write(text: str) -> None:
    """To both descriptors, past Python's streams, as native code does."""
    os.write(1, f"{text} out\n".encode())
    os.write(2, f"{text} err\n".encode())


def test_what_is_written_meanwhile_is_dropped_and_the_rest_is_not(capfd):
    write("before")
    with silenced():
        write("meanwhile")
    write("after")
    captured = capfd.readouterr()
    assert captured.out == "before out\nafter out\n"
    assert captured.err == "before err\nafter err\n"


# To a pipe, Python keeps what it prints until there is enough of it.
BUFFERED = """
import os
from mrm_mtlx.system.console import silenced
print("before")
with silenced():
    os.write(1, b"meanwhile")
print("after")
"""

TIME_LIMIT_S = 60


def test_what_python_has_buffered_before_is_not_lost():
    run = subprocess.run(
        [sys.executable, "-c", BUFFERED], capture_output=True, text=True, check=True, timeout=TIME_LIMIT_S
    )
    assert run.stdout == "before\nafter\n"


def test_an_exception_restores_the_descriptors_and_none_stays_open(capfd):
    def descriptors() -> int:
        return sum(1 for n in range(256) if _is_open(n))

    count = descriptors()
    with pytest.raises(ZeroDivisionError), silenced():
        raise ZeroDivisionError
    write("after")
    assert capfd.readouterr().out == "after out\n"
    assert descriptors() == count


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError:
        return False
    return True
