"""Failures of engines: a source is refused, or the engine does not work."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CompileMessage:
    """One complaint: the line of the generated source (from 1; 0 if unknown), its text, the message."""

    line: int
    source: str
    message: str

    def __str__(self) -> str:
        """On one line, the way a finding quotes it."""
        return f"{self.message} at line {self.line}: {self.source}" if self.line else self.message


class CompileError(Exception):
    """The compiler refused the source.

    `messages` are its complaints in order, at least one.
    """

    def __init__(self, messages: list[CompileMessage]) -> None:
        super().__init__("; ".join(message.message for message in messages))
        self.messages = messages


class EngineFailure(Exception):  # noqa: N818 -- it is what failed: the engine
    """An engine is missing, refused a request, or died; the message says which and what to do."""
