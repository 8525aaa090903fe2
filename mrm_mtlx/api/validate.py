"""Documents compared with the reference on every target, or only read and checked."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from mrm_mtlx.api.generate import check_targets
from mrm_mtlx.api.listener import SILENT, Listener
from mrm_mtlx.api.opening import LibraryName, PathLike, folders, paths_of
from mrm_mtlx.system.arguments import ArgumentError, check_choice, check_range, check_whole, one_or_more
from mrm_mtlx.system.process_limits import TIME_LIMIT_S

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.validation.options import ValidationOptions
    from mrm_mtlx.validation.screen import CheckReport, ValidationReport

# Bounds of the samples of a comparison.
FEWEST_SAMPLES, MOST_SAMPLES = 16, 1 << 22
SHORTEST_TIMEOUT_S = 0.1


def validate(
    paths: PathLike | Sequence[PathLike],
    *,
    target: str | Sequence[str] = (),
    select: str | Sequence[str] = (),
    ignore: str | Sequence[str] = (),
    strict: bool = False,
    samples: int = 16384,
    seed: int = 0,
    jobs: int = 0,
    retro_sweep: bool = False,
    timeout: float = TIME_LIMIT_S,
    library: LibraryName = "mrm",
    root: PathLike | Sequence[PathLike] = (),
    exclude: str | Sequence[str] = (),
    listener: Listener = SILENT,
) -> ValidationReport:
    """Read, check, generate, compile, run and compare documents with the reference.

    They are checked in processes of their own: one that crashes or hangs is a finding on its document.

    Parameters
    ----------
    paths
        Documents, or folders of documents.
    target
        Shading languages, and hosts that take materials (storm). Default: all that MaterialX generates.
    select, ignore
        Beginnings of codes: only findings of these rules, and none of those.
    strict
        Whether warnings and skips count as failures.
    samples
        Per comparison.
    seed
        Of all random numbers.
    jobs
        Processes; 0 is one per processor.
    retro_sweep
        Whether to switch the flag on in each specular node as well, one at a time, and to compare again.
    timeout
        Seconds for reading a document, and for each surface on each target.
    library
        Whose implementation of the flag: this project's or MaterialX's ("upstream").
    root
        Folders from which files may be read besides those of the documents.
    exclude
        Patterns of files and folders that are passed over where a folder is searched: of a name, or of a path relative
        to the folder.
    listener
        Told of progress.

    Raises
    ------
    ArgumentError
        If the call is wrong. What is wrong with documents is a finding; so is a path that does not exist.
    """
    from mrm_mtlx.validation import runner
    from mrm_mtlx.validation.screen import ValidationReport

    check_whole("samples", samples, FEWEST_SAMPLES, MOST_SAMPLES)
    check_whole("seed", seed, 0)
    options = replace(
        _options(select, ignore, jobs, timeout, library, root, exclude),
        targets=check_targets(target, library),
        samples=samples,
        seed=seed,
        retro_sweep=retro_sweep,
    )
    found = runner.validate(paths_of(paths), options, listener.progress)
    return ValidationReport(found.versions, found.engines, found.documents, strict)


def check(
    paths: PathLike | Sequence[PathLike],
    *,
    select: str | Sequence[str] = (),
    ignore: str | Sequence[str] = (),
    strict: bool = False,
    jobs: int = 0,
    timeout: float = TIME_LIMIT_S,
    library: LibraryName = "mrm",
    root: PathLike | Sequence[PathLike] = (),
    exclude: str | Sequence[str] = (),
    listener: Listener = SILENT,
) -> CheckReport:
    """Read documents and check their structure: the quick part of `validate`, without shaders, driver and reference.

    Parameters
    ----------
    paths, select, ignore, jobs, library, root, exclude, listener
        As `validate`.
    strict
        Whether warnings count as failures.
    timeout
        Seconds for each document.

    Raises
    ------
    ArgumentError
        As `validate`.
    """
    from mrm_mtlx.validation import runner
    from mrm_mtlx.validation.screen import CheckReport

    options = replace(_options(select, ignore, jobs, timeout, library, root, exclude), targets=(), only_check=True)
    return CheckReport(runner.documents(paths_of(paths), options, listener.progress), strict)


def _options(
    select: str | Sequence[str],
    ignore: str | Sequence[str],
    jobs: int,
    timeout: float,
    library: LibraryName,
    root: PathLike | Sequence[PathLike],
    exclude: str | Sequence[str],
) -> ValidationOptions:
    from mrm_mtlx.library import Origin
    from mrm_mtlx.validation.options import ValidationOptions

    check_whole("jobs", jobs, 0)
    check_range("timeout", timeout, SHORTEST_TIMEOUT_S)
    check_choice("library", library, tuple(Origin))
    return ValidationOptions(
        origin=Origin(library),
        jobs=jobs,
        timeout_s=timeout,
        roots=folders(root),
        exclude=one_or_more(exclude),
        select=_codes(select, "select"),
        ignore=_codes(ignore, "ignore"),
    )


def _codes(codes: str | Sequence[str], argument: str) -> tuple[str, ...]:
    from mrm_mtlx.findings.catalogue import rules_from

    found = one_or_more(codes)
    for code in found:
        if not rules_from(code):
            msg = f"no rule starts with '{code}'; `mrm rules` lists them"
            raise ArgumentError(msg, argument)
    return found
