"""`validate`: documents and folders go in, results come out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mrm_mtlx.findings.catalogue import all_rules
from mrm_mtlx.library.dialects import materialx_version, versions
from mrm_mtlx.validation.collecting import collect
from mrm_mtlx.validation.options import ValidationOptions
from mrm_mtlx.validation.results import ValidationResult
from mrm_mtlx.validation.workers import check_all

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from mrm_mtlx.findings.finding import Finding
    from mrm_mtlx.validation.results import DocumentResult


def validate(
    paths: Sequence[Path],
    options: ValidationOptions | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> ValidationResult:
    """Check documents and folders, and say what they were checked with; as `documents`."""
    options = options or ValidationOptions()
    found = documents(paths, options, progress)
    return ValidationResult(versions(), engines(options.targets), found)


def documents(
    paths: Sequence[Path], options: ValidationOptions, progress: Callable[[int, int], None] | None = None
) -> list[DocumentResult]:
    """Check documents and folders.

    Parameters
    ----------
    paths
        Files, or folders that are searched recursively for files of the formats that are read.
    options
        Targets, samples, seed, processes, filters; by default, those of the command line.
    progress
        Called with (finished, all) after each document.

    Returns
    -------
    list
        Documents sorted by path. A path that does not exist is a document with a finding.

    Raises
    ------
    PluginError
        If a rule that another package registers is of no use.
    ArgumentError
        If an environment variable states no version of MaterialX where it should.
    """
    # What is wrong around the documents is to be known before they are checked: a rule that does not load, a variable.
    all_rules()
    materialx_version()
    missing, requests = collect(paths, options)
    results = missing + check_all(requests, options, progress)
    for result in results:
        wanted = (found for found in result.findings if _is_wanted(found, options))
        result.findings = [found.in_file(result.path) for found in wanted]
    return sorted(results, key=lambda result: result.path)


def engines(targets: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Engines that run or compile source of these targets here, and of glsl: to try the others would only take time."""
    from mrm_mtlx.engines import registry

    report: dict[str, dict[str, Any]] = {}
    for name, state in registry.survey(("glsl", *targets)).items():
        key = "renderer" if state.available else "reason"
        report[name] = {"available": state.available, key: state.detail}
    return report


def _is_wanted(found: Finding, options: ValidationOptions) -> bool:
    is_selected = not options.select or found.rule.is_among(options.select)
    return is_selected and not found.rule.is_among(options.ignore)
