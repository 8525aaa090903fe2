"""The listener of a call: progress, findings and files, as they come."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from mrm_mtlx.api.errors import MrmError
    from mrm_mtlx.findings.finding import Finding


class Listener:
    """Told of what happens during a call, as it happens; this one does nothing with it. Override what is of interest.

    What is told is in the result, or in the exception, as well.
    """

    def findings(self, found: Sequence[Finding]) -> None:
        """Take what was found in a document, before anything is done with it."""

    def image_findings(self, found: Sequence[Finding]) -> None:
        """Take what is wrong with images, which is known once they are read."""

    def not_measured(self, path: str, error: MrmError) -> None:
        """Take the path, as reports show it, of a document that is left out of a measurement, and why."""

    def progress(self, finished: int, total: int) -> None:
        """Take how many parts of the work are finished, of all."""

    def wrote(self, path: Path, what: str = "") -> None:
        """Take the path of a file that was written, and what of the document is in it, if it is a part."""


SILENT = Listener()
