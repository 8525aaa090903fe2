"""The state of an engine on this machine."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Availability:
    """The state of an engine: it works here, or lacks something.

    Attributes
    ----------
    available
        True if it works: it was tried, not only found.
    detail
        What answers (renderer, version) where it works, and the reason where it does not.
    remedy
        The command that adds what is missing; empty where it works.
    """

    available: bool
    detail: str
    remedy: str = ""

    @property
    def reason(self) -> str:
        """The words for a skip: what is missing, and what adds it."""
        return f"{self.detail}; {self.remedy}"
