"""The check of one document in steps, each under the time limit, and a record of them that outlives the process.

A process that dies in a step (a crash, its time, its memory) loses that step. The next process finds in the record what
was done, takes what stands for the lost step, and goes on behind it.
"""

from __future__ import annotations

import contextlib
import pickle
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from mrm_mtlx.findings import rules
from mrm_mtlx.system import process_limits

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from mrm_mtlx.findings.finding import Finding

T = TypeVar("T")

# Lost steps after which the rest of a document is given up: each of many surfaces could take all of its time.
MAXIMUM_LOST = 3


class Step(NamedTuple):
    """A part of a check: the path of the element that it is about ("" for the document), and what is done with it."""

    element: str
    part: str


# Reading the document and checking its structure: whatever else is known of it is lost with this.
READING = Step("", "reading")


@dataclass
class Record:
    """Record of a check's steps.

    Attributes
    ----------
    done
        Results of the steps that were finished.
    lost
        What is to be said of the steps in which a process died, or an error inside of the check ended them.
    begun
        The step that was under way when the record ended, or None.
    """

    done: dict[Step, Any] = field(default_factory=dict)
    lost: dict[Step, Finding] = field(default_factory=dict)
    begun: Step | None = None


def read_record(path: Path) -> Record:
    """The record in a file; empty if there is none. What a dying process left of a last entry is passed over."""
    record = Record()
    with contextlib.suppress(OSError, EOFError, pickle.UnpicklingError), path.open("rb") as stream:
        while True:
            kind, step, value = pickle.load(stream)
            record.begun = step if kind == "begun" else None
            if kind != "begun":
                getattr(record, kind)[step] = value
    return record


def add_lost(path: Path, step: Step, reason: str, *, timed_out: bool) -> None:
    """Note in a record that a process died in a step, and why.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    _append(path, "lost", step, lost_finding(step, reason, timed_out=timed_out))


def _append(path: Path, kind: str, step: Step, value: Any) -> None:
    with path.open("ab") as stream:
        stream.write(pickle.dumps((kind, step, value)))


def lost_finding(step: Step, reason: str, *, timed_out: bool) -> Finding:
    """The finding on a step that was not finished."""
    part = "" if step == READING else f"{step.part}: "
    place = f"/{step.element}" if step.element else ""
    rule = rules.CHECK_TIMEOUT if timed_out else rules.CHECK_CRASHED
    return rule.at(place, f"{part}{reason}")


class Steps:
    """Does steps, or takes them from the record of a process that did not come to its end.

    Parameters
    ----------
    path
        The record's file; without one, steps are done without a limit, and an error inside of them is raised.
    limit_s
        Seconds that each step may take.
    """

    def __init__(self, path: Path | None = None, limit_s: float = 0.0) -> None:
        self._path, self._limit_s = path, limit_s
        self._record = Record() if path is None else read_record(path)

    def run(self, step: Step, work: Callable[[], T], lost: Callable[[Finding], T], *, kept: bool = True) -> T:
        """The result of `work`, or of `lost` for a step in which a process died or an error occurred.

        A result that cannot be written down is not `kept`: the next process does the step again.
        """
        if step in self._record.done:
            done: T = self._record.done[step]
            return done
        if step in self._record.lost:
            return lost(self._record.lost[step])
        if self._path is None:
            return work()
        self.begin(step)
        try:
            result = work()
        except Exception as error:
            found = lost_finding(step, error_reason(error), timed_out=False)
            self._add("lost", step, found)
            self._record.lost[step] = found
            return lost(found)
        if kept:
            self._add("done", step, result)
        return result

    def begin(self, step: Step) -> None:
        """Start a step whose result is not kept; it lasts until the next one begins."""
        if self._path is not None:
            self._add("begun", step, None)
            process_limits.limit_time(self._limit_s)

    def skips(self, step: Step) -> bool:
        """True if a step is not tried any more, because too many others were lost."""
        known = step in self._record.done or step in self._record.lost
        return len(self._record.lost) >= MAXIMUM_LOST and not known

    def _add(self, kind: str, step: Step, value: Any) -> None:
        assert self._path is not None
        # Without the record (a full disk) a death costs more, and nothing else changes.
        with contextlib.suppress(OSError):
            _append(self._path, kind, step, value)


def error_reason(error: BaseException) -> str:
    """The words for an error inside of the check in a finding."""
    if isinstance(error, MemoryError):
        return process_limits.memory_reason()
    return f"internal error: {type(error).__name__}: {error}"
