"""Targets of the fuzzer that do one bad thing each, with the second mutant; see test_fuzz.py."""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING

from tools.fuzz.target import Outcome, Verdict

if TYPE_CHECKING:
    from pathlib import Path
    from random import Random

    from tools.fuzz.mutants import Mutant


def dies(mutant: Mutant, place: Path, scratch: Path, rng: Random) -> Verdict:
    if _second(place):
        os.abort()
    return Verdict(Outcome.CLEAN)


def hangs(mutant: Mutant, place: Path, scratch: Path, rng: Random) -> Verdict:
    if _second(place):
        time.sleep(60)
    return Verdict(Outcome.CLEAN)


def takes_memory(mutant: Mutant, place: Path, scratch: Path, rng: Random) -> Verdict:
    if _second(place):
        bytearray(8 * 2**30)
    return Verdict(Outcome.CLEAN)


def raises(mutant: Mutant, place: Path, scratch: Path, rng: Random) -> Verdict:
    if _second(place):
        raise KeyError("planted")
    return Verdict(Outcome.CLEAN)


def _second(place: Path) -> bool:
    """Whether this is the second mutant of the run; workers share no memory, but the folder above their own."""
    mark = place.parent.parent / "calls"
    with mark.open("a", encoding="ascii") as stream:
        stream.write(".")
    return len(mark.read_text(encoding="ascii")) == 2
