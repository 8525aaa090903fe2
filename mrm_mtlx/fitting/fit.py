"""Fitting a layer stack to samples: bounded, robust least squares from many starts.

What is minimised is the sum of rho(r^2) over the residuals r of `samples.Samples`, with rho(s) = s, or "soft_l1",
rho(s) = 2 c^2 (sqrt(1 + s / c^2) - 1): squares up to c, absolute values beyond.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.fitting.model import Evaluator, Kind, LayerStack, albedos

if TYPE_CHECKING:
    from collections.abc import Mapping

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.fitting.samples import Samples

LOSSES = ("soft_l1", "linear")
# Correlations beyond this are reported.
CORRELATED = 0.95
# Relative standard errors beyond this are reported.
_UNKNOWN = 0.5
# Smallest root of the mean square that is told from an exact fit: no coefficient is known better.
_EXACT = 0.02
# Factor on residuals of energy: a gain of a hundredth counts as one bad sample.
_ENERGY = 100.0
# Cosines of v at which energy is looked at: 0, 60, 75 and 85 degrees.
_COSINES = np.cos(np.deg2rad([0.0, 60.0, 75.0, 85.0]))

# Relative change of the cost and of the numbers at which a search ends.
_PRECISION = 1e-7


@dataclass(frozen=True)
class FitOptions:
    """Options of a fit: `loss` of `LOSSES`, its scale c (None: that of the residual), seed and number of starts."""

    loss: str = "soft_l1"
    scale: float | None = None
    seed: int = 0
    starts: int = 4

    def scale_for(self, samples: Samples) -> float:
        """The scale c, in the units of the residual."""
        return samples.residual.loss_scale if self.scale is None else self.scale


@dataclass(frozen=True)
class Fit:
    """A stack fitted to samples.

    Attributes
    ----------
    stack
    values
        By parameter, as a document has them.
    errors
        Standard errors of the free numbers, in the order of `stack.parameters`; NaN where a number is at a bound. They
        come from the scatter of the residuals alone, as if these were independent.
    correlations : shape (numbers, numbers)
        NaN where a number is at a bound.
    cost
        The sum that was minimised.
    rms
        Root of the mean square residual.
    median
        Of the absolute residuals.
    count
        The number of residuals.
    """

    stack: LayerStack
    values: dict[str, Array]
    errors: Array
    correlations: Array
    cost: float
    rms: float
    median: float
    count: int

    @property
    def free(self) -> int:
        """The number of free numbers."""
        return len(self.stack.parameters)

    @property
    def bic(self) -> float:
        """Bayesian information criterion."""
        return self.count * self._log_scatter + self.free * float(np.log(self.count))

    @property
    def aicc(self) -> float:
        """Akaike's information criterion for few samples; infinite where there are none to spare."""
        spare = self.count - self.free - 1
        return self.count * self._log_scatter + 2.0 * self.free * self.count / spare if spare > 0 else float("inf")

    @property
    def _log_scatter(self) -> float:
        floor = _EXACT**2 if self.count < 100 else 1e-12
        return float(np.log(max(self.cost / self.count, floor)))


def fit_stack(
    stack: LayerStack,
    samples: Samples,
    options: FitOptions,
    starts: list[Array] | None = None,
    *,
    evaluations: int = 100,
) -> Fit:
    """Fit one stack, from given starts (vectors), or from random ones.

    Raises
    ------
    ValueError
        If there are fewer values than free numbers.
    """
    best, _ = search(stack, samples, options, starts or random_starts(stack, options), evaluations)
    return best


def warnings(fit: Fit, samples: Samples) -> list[str]:
    """Gaps in the data: numbers at their bounds, numbers that cannot be told apart, and lobes without samples."""
    found = []
    parameters = fit.stack.parameters
    if fit.count == fit.free:
        found.append(f"as many numbers as values, {fit.free}: nothing is left to judge the fit by")
    for i, parameter in enumerate(parameters):
        value = fit.values[parameter.name][max(parameter.channel, 0)]
        if value in (parameter.lower, parameter.upper):
            found.append(f"{parameter.label} is at its bound, {value:g}")
        elif fit.errors[i] > _UNKNOWN * abs(value):
            found.append(f"{parameter.label} is hardly known: {value:.3g} ± {fit.errors[i]:.2g}")
        for k in range(i):
            together = fit.correlations[i, k]
            if abs(together) > CORRELATED:
                found.append(
                    f"{parameters[k].label} and {parameter.label} cannot be told apart by these data: "
                    f"correlation {together:.3f}"
                )
    for part in fit.stack.parts:
        if part.kind is Kind.DIFFUSE or samples.weights is not None:
            continue
        alpha = float(fit.values[f"{part}.alpha"][0])
        inside = _within_lobe(samples, alpha, mirror=part.kind is Kind.CLEAR)
        if inside < 3 and f"{part}.alpha" not in fit.stack.fixed:
            found.append(f"{part}: {inside} samples are within the width of this lobe, alpha {alpha:.3g}")
    return found


def _within_lobe(samples: Samples, alpha: float, *, mirror: bool) -> int:
    """Samples with facets within alpha of the normal, where half of the lobe's height and most of its width is."""
    v = samples.v * np.array([1.0, 1.0, 1.0] if mirror else [-1.0, -1.0, 1.0])
    h = v + samples.l
    return int(np.count_nonzero(np.hypot(h[:, 0], h[:, 1]) <= alpha * h[:, 2]))


def random_starts(stack: LayerStack, options: FitOptions) -> list[Array]:
    """Vectors within the bounds, the same for the same seed."""
    rng = np.random.default_rng([options.seed, len(stack.parameters)])
    lower, upper = stack.bounds()
    return [lower + (upper - lower) * u for u in 0.05 + 0.9 * rng.random((options.starts, len(lower)))]


def search(
    stack: LayerStack, samples: Samples, options: FitOptions, starts: list[Array], evaluations: int
) -> tuple[Fit, list[float]]:
    """The best of least squares from all starts, and the cost of each."""
    from scipy.optimize import least_squares

    if samples.count < len(stack.parameters):
        msg = f"{samples.count} values cannot tell {len(stack.parameters)} parameters; expected at least as many values"
        raise ValueError(msg)
    problem = _Problem(stack, samples)
    scale = options.scale_for(samples)
    # The exact solver decomposes the whole Jacobian at each step, which takes longer than everything else.
    solver = "lsmr" if len(stack.parameters) > 1 else "exact"
    results: list[Any] = []
    for start in starts:
        inside = np.clip(start, *(_inside(*stack.bounds())))
        results.append(
            least_squares(
                problem.residuals,
                inside,
                problem.jacobian,
                bounds=stack.bounds(),
                loss=options.loss,
                f_scale=scale,
                x_scale="jac",
                tr_solver=solver,
                ftol=_PRECISION,
                xtol=_PRECISION,
                max_nfev=evaluations,
            )
        )
    best = min(results, key=lambda result: float(result.cost))
    return _finished(stack, samples, problem, best), [float(result.cost) for result in results]


def _inside(lower: Array, upper: Array) -> tuple[Array, Array]:
    """A little inside of the bounds: from a bound itself, the search would not leave."""
    margin = 1e-4 * (upper - lower)
    return lower + margin, upper - margin


class _Problem:
    """Residuals and their derivatives, the last of each kept: the search asks for both at the same place."""

    def __init__(self, stack: LayerStack, samples: Samples) -> None:
        self._stack, self._samples = stack, samples
        self._evaluator = Evaluator(stack, samples.v, samples.l)
        # Layers share out grey light; of coloured, a channel could be given more than it has.
        self._colored = stack.channels == 3 or stack.tint != (1.0, 1.0, 1.0)

    def residuals(self, vector: Array) -> Array:
        values = self._stack.values(vector)
        found = self._samples.residuals(self._evaluator.eval(values))
        return np.concatenate([found, self._gain(vector)]) if self._colored else found

    def jacobian(self, vector: Array) -> Array:
        f, slopes = self._evaluator.eval_with_jacobian(vector)
        _, found = self._samples.residuals_with_jacobian(f, slopes)
        if not self._colored:
            return found
        gain = self._gain(vector)
        moved = [(self._gain(vector + step) - gain) / 1e-6 for step in 1e-6 * np.eye(len(vector))]
        return np.concatenate([found, np.stack(moved, axis=1)])

    def _gain(self, vector: Array) -> Array:
        """Light that is reflected and did not arrive, by channel."""
        found = albedos(self._stack, self._stack.values(vector), _COSINES)
        return _ENERGY * np.ravel(np.maximum(found - 1.0, 0.0))


def _finished(stack: LayerStack, samples: Samples, problem: _Problem, result: Any) -> Fit:
    """A result with its numbers as a document has them, and what they are worth."""
    values = stack.rounded(stack.ordered(stack.snapped(stack.values(result.x))))
    vector = stack.vector(values)
    r = problem.residuals(vector)[: samples.count]
    errors, correlations = _uncertainties(stack, vector, values, result, samples.count, problem)
    return Fit(
        stack,
        values,
        errors,
        correlations,
        2.0 * float(result.cost),
        float(np.sqrt(np.mean(np.square(r)))),
        float(np.median(np.abs(r))),
        samples.count,
    )


def _uncertainties(
    stack: LayerStack, vector: Array, values: Mapping[str, Array], result: Any, count: int, problem: _Problem
) -> tuple[Array, Array]:
    """Standard errors and correlations from the Jacobian, cov = s^2 (J^T J)^-1 with s^2 = S / (N - p)."""
    parameters = stack.parameters
    numbers = [values[p.name][max(p.channel, 0)] for p in parameters]
    free = np.array([x not in (p.lower, p.upper) for p, x in zip(parameters, numbers, strict=True)], dtype=bool)
    errors = np.full(len(parameters), np.nan)
    correlations = np.full((len(parameters), len(parameters)), np.nan)
    spare = count - int(free.sum())
    if not free.any() or spare < 1:
        return errors, correlations
    j = problem.jacobian(vector)[:, free]
    inverse = np.linalg.pinv(j.T @ j)
    unscaled = np.sqrt(np.maximum(np.diag(inverse), 0.0))
    sigma = np.sqrt(2.0 * float(result.cost) / spare) * unscaled
    slopes = np.array([x if p.logarithmic else 1.0 for p, x in zip(parameters, numbers, strict=True)])[free]
    errors[free] = sigma * slopes
    with np.errstate(invalid="ignore", divide="ignore"):
        correlations[np.ix_(free, free)] = inverse / np.outer(unscaled, unscaled)
    return errors, correlations
