"""Results of cases."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from mrm_mtlx.validation.results import Status

if TYPE_CHECKING:
    from mrm_mtlx.conformance.cases import Case
    from mrm_mtlx.validation.comparison.samples import Comparison

SCHEMA = "mrm.conformance/1"


@dataclass(frozen=True)
class Approximation:
    """The error of an approximate lobe, at one width and view angle.

    Attributes
    ----------
    material
        What reflects.
    alpha, view_deg
        Width, and angle of v from the normal.
    l1
        Integral of |found - exact| over the integral of exact, the cosine of l included; worst channel.
    albedo
        Ratio of the integrals; the channel that is furthest from 1.
    l1_bound, albedo_bound
        What is promised of `l1`, and of the distance of `albedo` from 1.
    """

    material: str
    alpha: float
    view_deg: float
    l1: float
    albedo: float
    l1_bound: float
    albedo_bound: float

    @property
    def passed(self) -> bool:
        """True if both promises hold."""
        return self.l1 <= self.l1_bound and abs(self.albedo - 1.0) <= self.albedo_bound

    @property
    def excess(self) -> float:
        """The larger of the two ratios to what is promised."""
        return max(self.l1 / self.l1_bound, abs(self.albedo - 1.0) / self.albedo_bound)


@dataclass(frozen=True)
class CaseResult:
    """Result of a case on a target.

    Attributes
    ----------
    case, target, engine
        What was run where.
    comparison
        Sample by sample with the oracle; None where it was skipped or is approximate.
    reason
        Why it was skipped, or None.
    variant
        How the target makes the lobe, where it has several ways; "" otherwise.
    approximations
        Of a variant that is approximate by design: one per material, width and angle.
    """

    case: Case
    target: str
    engine: str
    comparison: Comparison | None
    reason: str | None
    variant: str = ""
    approximations: tuple[Approximation, ...] = ()

    @property
    def name(self) -> str:
        """The name in reports."""
        return f"{self.case.name}, {self.variant}" if self.variant else self.case.name

    @property
    def status(self) -> Status:
        """The verdict, or that there is none."""
        if self.approximations:
            return Status.of(all(a.passed for a in self.approximations))
        return Status.SKIP if self.comparison is None else Status.of(self.comparison.passed)

    def to_json(self) -> dict[str, Any]:
        """The entry of the report's list of cases."""
        found = self.comparison
        return {
            "name": self.name,
            "node": self.case.node,
            "target": self.target,
            "engine": self.engine,
            "variant": self.variant,
            "retroreflective": self.case.retroreflective,
            "anisotropic": self.case.anisotropic,
            "film": self.case.film,
            "status": self.status,
            "samples": found.samples if found else 0,
            "max_error": found.max_error if found else None,
            "median_error": found.median_error if found else None,
            "excess": found.excess if found else None,
            "worst": found.worst if found else None,
            "approximations": [vars(a) for a in self.approximations],
            "reason": self.reason,
        }
