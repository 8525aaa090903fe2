"""Options of a check, and the request for one document; plain data that crosses processes."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING

from mrm_mtlx.library import Origin
from mrm_mtlx.shadergen import available_targets
from mrm_mtlx.system.process_limits import TIME_LIMIT_S

if TYPE_CHECKING:
    from pathlib import Path

    from mrm_mtlx.documents.files import Reach


@dataclass(frozen=True, kw_only=True)
class CheckOptions:
    """Options of the check of a document.

    Attributes
    ----------
    targets
        Names of the targets to generate; by default, all that the installed MaterialX generates.
    samples, seed
        Samples per comparison; the seed fixes them.
    origin
        Whose implementation of the flag is checked.
    retro_sweep
        Whether specular nodes whose flag is off are checked with it on as well, one at a time.
    only_check
        Whether documents are read and their structure is checked, and nothing is evaluated or generated.
    """

    targets: tuple[str, ...] = field(default_factory=available_targets)
    samples: int = 16384
    seed: int = 0
    origin: Origin = Origin.MRM
    retro_sweep: bool = False
    only_check: bool = False


@dataclass(frozen=True, kw_only=True)
class ValidationOptions(CheckOptions):
    """Options of a run over documents; the defaults are those of the command line.

    Attributes
    ----------
    jobs
        Processes; 0 is one per processor.
    timeout_s
        Seconds that reading a document may take, and then each of its surfaces on each target.
    roots
        Folders from which files may be read beside the one that is checked, and in which they are looked for.
    exclude
        Patterns of files and folders that are passed over where a folder is searched; `collecting.documents_of` says
        how they are read.
    select, ignore
        Beginnings of codes: only the findings of these rules, and none of those.
    """

    jobs: int = 0
    timeout_s: float = TIME_LIMIT_S
    roots: tuple[Path, ...] = ()
    exclude: tuple[str, ...] = ()
    select: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()


@dataclass(frozen=True)
class Request(CheckOptions):
    """One document to check.

    Attributes
    ----------
    path, reach
        The document, and where the names of files in it lead.
    shown
        The document's path in reports.
    """

    path: Path
    reach: Reach
    shown: str

    @classmethod
    def of(cls, options: CheckOptions, path: Path, reach: Reach, shown: str) -> Request:
        """The request for a document, with the options for all."""
        return cls(path, reach, shown, **{each.name: getattr(options, each.name) for each in fields(CheckOptions)})
