"""What is asked of the check of one document; plain data that crosses processes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from mrm_mtlx.library import Origin

if TYPE_CHECKING:
    from pathlib import Path

    from mrm_mtlx.documents.files import Reach


@dataclass(frozen=True)
class Request:
    """One document to check, and how.

    Attributes
    ----------
    path, reach
        The document, and where the names of files in it lead.
    shown
        The document's path in reports.
    targets
        Names of the targets to generate.
    samples, seed
        Samples per comparison; the seed fixes them.
    origin
        Whose implementation of the flag is checked.
    retro_sweep
        Whether specular nodes whose flag is off are checked with it on as well, one at a time.
    """

    path: Path
    reach: Reach
    shown: str
    targets: tuple[str, ...]
    samples: int = 16384
    seed: int = 0
    origin: Origin = Origin.MRM
    retro_sweep: bool = False
