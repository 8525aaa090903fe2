"""Results of a validation run: plain data that crosses processes and turns into JSON."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mrm_mtlx.findings.finding import Finding, Severity


class Stage(StrEnum):
    """The stages of a check on a target; `READ` is before any generator."""

    READ = "read"
    GENERATE = "generate"
    COMPILE = "compile"
    COMPARE = "compare"


class Status(StrEnum):
    """Verdicts, and their absence."""

    PASS = "pass"
    FAIL = "fail"
    SKIP = "skip"

    @classmethod
    def of(cls, passed: bool) -> Status:
        """The verdict of a comparison."""
        return cls.PASS if passed else cls.FAIL


@dataclass
class TargetResult:
    """The result of one renderable element on one target.

    Attributes
    ----------
    stage
        The last one reached.
    status
        A skip has a `reason`.
    samples, max_error, median_error, tolerance, worst
        Of the comparison, where there was one; see `comparison.Comparison`.
    """

    stage: Stage
    status: Status
    reason: str | None = None
    samples: int | None = None
    max_error: float | None = None
    median_error: float | None = None
    tolerance: float | None = None
    worst: dict[str, Any] | None = None


@dataclass
class RenderableResult:
    """One renderable element: its path in the document, and its result per target.

    Attributes
    ----------
    path
        Of the element.
    targets
        By the target's name.
    switched
        Path, in the flattened document, of the specular node whose flag was switched on for the check; "" for the
        element as it is.
    """

    path: str
    targets: dict[str, TargetResult] = field(default_factory=dict)
    switched: str = ""

    @property
    def name(self) -> str:
        """The name in reports."""
        return f"{self.path} + retroreflective {self.switched}" if self.switched else self.path

    def to_json(self) -> dict[str, Any]:
        """The entry of a report's list of renderables."""
        return {"name": self.name, "targets": {target: asdict(result) for target, result in self.targets.items()}}


@dataclass
class DocumentResult:
    """One document: its path as it is shown, its findings and its renderable elements."""

    path: str
    findings: list[Finding] = field(default_factory=list)
    renderables: list[RenderableResult] = field(default_factory=list)


@dataclass(frozen=True)
class ValidationResult:
    """A run.

    `versions` and `engines` say what it was run with; `documents` are sorted by path.
    """

    versions: dict[str, str]
    engines: dict[str, dict[str, Any]]
    documents: list[DocumentResult]

    @property
    def findings(self) -> list[tuple[str, Finding]]:
        """All findings as (path of the document, finding)."""
        return [(document.path, found) for document in self.documents for found in document.findings]

    def count(self, severity: Severity) -> int:
        """Number of findings of a severity."""
        return sum(found.severity is severity for _, found in self.findings)

    def results(self) -> list[tuple[str, TargetResult]]:
        """All results as (target, result)."""
        return [item for d in self.documents for r in d.renderables for item in r.targets.items()]

    @property
    def checked(self) -> int:
        """Number of results that are a verdict."""
        return sum(result.status is not Status.SKIP for _, result in self.results())

    @property
    def skipped(self) -> int:
        """Number of results that are not."""
        return sum(result.status is Status.SKIP for _, result in self.results())
