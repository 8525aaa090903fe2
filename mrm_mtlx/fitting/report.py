"""The report of a fit: plain data, and the same as text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.fitting.selection import DECISIVE, Criterion

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.fitting.fit import Fit, FitOptions
    from mrm_mtlx.fitting.samples import Samples
    from mrm_mtlx.fitting.selection import Selection

SCHEMA = "mrm.fit/1"


@dataclass(frozen=True)
class FitReport:
    """A fit and what it was made from.

    Attributes
    ----------
    data
        Name of the data.
    samples, options
    fit
    selection
        How it was chosen; None where the stack was given.
    warnings
    """

    data: str
    samples: Samples
    options: FitOptions
    fit: Fit
    selection: Selection | None
    warnings: Sequence[str]

    @property
    def residual(self) -> str:
        """The residual as a formula."""
        if self.samples.weights is not None:
            return "ln(R_A of the model / R_A)"
        return self.samples.residual.formula.format(floor=self.samples.floor)

    @property
    def loss(self) -> str:
        """The loss, with its scale."""
        if self.options.loss == "linear":
            return "squares"
        return f"{self.options.loss}, scale {self.options.scale_for(self.samples):g}"

    def rows(self) -> list[dict[str, Any]]:
        """Free numbers, then given ones."""
        stack, values = self.fit.stack, self.fit.values
        found = [
            {
                "name": p.label,
                "value": float(values[p.name][max(p.channel, 0)]),
                "error": float(e) if np.isfinite(e) else None,
                "free": True,
            }
            for p, e in zip(stack.parameters, self.fit.errors, strict=True)
        ]
        for name, value in stack.fixed.items():
            part = name.partition(".")[0]
            if part in stack.parts:
                for label, x in zip(_labels(name, len(value)), value, strict=True):
                    found.append({"name": label, "value": float(x), "error": None, "free": False})
        return found

    def steps(self) -> list[dict[str, Any]]:
        """The gain by each layer: as it was taken in, in order, as it was refused, and in the final material."""
        if self.selection is None:
            return []
        groups = (
            ("added", self.selection.steps),
            ("refused", self.selection.refused),
            ("left out", self.selection.without),
        )
        return [
            {
                "step": group if i or group != "added" else "start",
                "what": step.what,
                "numbers": step.fit.free,
                "rms": step.fit.rms,
                "change": step.change,
            }
            for group, steps in groups
            for i, step in enumerate(steps)
        ]

    def coefficients(self) -> list[dict[str, float]]:
        """Values of the model beside the coefficients that were given."""
        if self.samples.weights is None:
            return []
        return [
            {"observation_deg": o, "entrance_deg": e, "ra": given, "model": model}
            for o, e, given, model in zip(
                *_geometry(self.samples), self.samples.value[:, 0], self.modelled()[:, 0], strict=True
            )
        ]

    def modelled(self) -> Array:
        """The quantity of the fitted material at the samples."""
        from mrm_mtlx.fitting.model import Evaluator

        evaluator = Evaluator(self.fit.stack, self.samples.v, self.samples.l)
        return self.samples.modelled(evaluator.eval(self.fit.values))

    def to_json(self, versions: dict[str, str], output: str) -> dict[str, Any]:
        """The report as plain data; keys are stable."""
        fit, selection = self.fit, self.selection
        criterion = selection.criterion if selection else Criterion.BIC
        return {
            "schema": SCHEMA,
            "versions": versions,
            "data": {"name": self.data, "samples": len(self.samples), "channels": self.samples.value.shape[1]},
            "residual": self.residual,
            "loss": self.loss,
            "document": output,
            "parameters": self.rows(),
            "rms": fit.rms,
            "median": fit.median,
            "criterion": criterion.value,
            "criterion_value": criterion.of(fit),
            "steps": self.steps(),
            "agreeing_starts": [selection.agreeing, selection.starts] if selection else None,
            "coefficients": self.coefficients(),
            "warnings": list(self.warnings),
        }

    def text(self) -> str:
        """The report as tables; without the verdict."""
        return "\n".join([*self._head(), "", *self._parameters(), *self._layers(), *self._values(), *self._warnings()])

    def verdict(self) -> str:
        """The last line."""
        count = len(self.warnings)
        warned = f", {count} warning{'s' if count != 1 else ''}" if count else ""
        return f"FITTED  {self.fit.free} numbers to {self.fit.count} values, RMS {self.fit.rms:.3g}{warned}"

    def notes(self, versions: dict[str, str]) -> list[str]:
        """Paragraphs of provenance for the document; the command stands at the material, where hyphens may."""
        known = ", ".join(f"{name} {version}" for name, version in versions.items())
        fitted = "; ".join(
            f"{row['name']} {row['value']:.4g}" + (f" ± {row['error']:.2g}" if row["error"] else "")
            for row in self.rows()
            if row["free"]
        )
        given = "; ".join(f"{row['name']} {row['value']:g}" for row in self.rows() if not row["free"])
        found = [
            f"Fitted to: {self.data}, {self.fit.count} values. Versions: {known}.",
            f"Residual {self.residual}, loss {self.loss}: RMS {self.fit.rms:.4g}, median {self.fit.median:.3g}.",
            f"Fitted, with standard errors from the scatter alone: {fitted}.",
        ]
        found += [f"Not fitted, but given: {given}."] if given else []
        return found + [f"Warning: {warning}." for warning in self.warnings]

    def _head(self) -> list[str]:
        fit = self.fit
        return [
            f"data      {self.data}: {fit.count} values",
            f"residual  {self.residual}; loss: {self.loss}",
            f"result    RMS {fit.rms:.4f}, median {fit.median:.4f}",
        ]

    def _parameters(self) -> list[str]:
        lines = [f"{'parameter':<18}{'value':>12}{'error':>12}"]
        for row in self.rows():
            error = "given" if not row["free"] else f"{row['error']:.2g}" if row["error"] is not None else "-"
            lines.append(f"{row['name']:<18}{row['value']:>12.5g}{error:>12}")
        return lines

    def _layers(self) -> list[str]:
        if self.selection is None:
            return []
        name = self.selection.criterion
        lines = ["", f"{'':<10}{'layer':<34}{'numbers':>8}{'RMS':>9}{name + ' by it':>14}"]
        for row in self.steps():
            change = f"{row['change']:.1f}" if row["step"] != "start" else "-"
            lines.append(f"{row['step']:<10}{row['what']:<34}{row['numbers']:>8}{row['rms']:>9.4f}{change:>14}")
        lines.append(f"A layer is taken in if it lowers {name} by more than {DECISIVE:g}.")
        if self.selection.starts:
            lines.append(
                f"Random starts that end at the same material: {self.selection.agreeing} of {self.selection.starts}."
            )
        return lines

    def _values(self) -> list[str]:
        rows = self.coefficients()
        if not rows:
            return []
        lines = ["", f"{'observation':>12}{'entrance':>10}{'R_A given':>12}{'of the fit':>12}"]
        return lines + [
            f"{r['observation_deg']:>12.4g}{r['entrance_deg']:>10.4g}{r['ra']:>12.5g}{r['model']:>12.5g}" for r in rows
        ]

    def _warnings(self) -> list[str]:
        return ["", *(f"warning: {warning}" for warning in self.warnings)] if self.warnings else []


def _labels(name: str, count: int) -> list[str]:
    return [name] if count == 1 else [f"{name}.{channel}" for channel in "rgb"]


def _geometry(samples: Samples) -> tuple[list[float], list[float]]:
    """Observation and entrance angle (beta1) of each sample in degrees, without what rounding leaves of them."""
    from mrm_mtlx.photometry import goniometer

    observation, beta1, _, _ = goniometer.angles(samples.v, samples.l)
    return tuple([round(float(x), 6) for x in np.rad2deg(angle)] for angle in (observation, beta1))  # type: ignore[return-value]
