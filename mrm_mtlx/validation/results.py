"""What a validation run returns; plain data that crosses processes and turns into JSON."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mrm_mtlx.findings.finding import Finding, Severity


@dataclass
class TargetResult:
    """How far one renderable element got on one target.

    Attributes
    ----------
    stage
        Last stage reached: "read" (it never got to a generator), "generate", "compile" or "compare".
    status
        "pass", "fail" or "skip"; a skip has a `reason`.
    samples, max_error, median_error, tolerance, worst
        Of the comparison, where there was one; see `comparison.Comparison`.
    """

    stage: str
    status: str
    reason: str | None = None
    samples: int | None = None
    max_error: float | None = None
    median_error: float | None = None
    tolerance: float | None = None
    worst: dict[str, Any] | None = None


@dataclass
class RenderableResult:
    """One renderable element: its path in the document, and its result per target."""

    name: str
    targets: dict[str, TargetResult] = field(default_factory=dict)


@dataclass
class DocumentResult:
    """One document: its path as it is shown, its findings and its renderable elements."""

    path: str
    findings: list[Finding] = field(default_factory=list)
    renderables: list[RenderableResult] = field(default_factory=list)


@dataclass
class ValidationResult:
    """A run.

    `versions` and `engines` say what it was run with; `documents` are sorted by path.
    """

    versions: dict[str, str]
    engines: dict[str, dict[str, Any]]
    documents: list[DocumentResult]

    def count(self, severity: Severity) -> int:
        """Number of findings of a severity."""
        return sum(f.severity is severity for d in self.documents for f in d.findings)

    def results(self) -> list[tuple[str, TargetResult]]:
        """All results as (target, result)."""
        return [item for d in self.documents for r in d.renderables for item in r.targets.items()]

    @property
    def checked(self) -> int:
        """Number of results that are a verdict."""
        return sum(result.status != "skip" for _, result in self.results())

    @property
    def skipped(self) -> int:
        """Number of results that are not."""
        return sum(result.status == "skip" for _, result in self.results())
