"""Fitting a material to samples: bounded, robust least squares from many starts, and which layers the data ask for.

What is minimised is the sum of rho(r^2) over the residuals r of `samples.Samples`, with rho(s) = s, or "soft_l1",
rho(s) = 2 c^2 (sqrt(1 + s / c^2) - 1): squares up to c, absolute values beyond. Layer stacks are compared by

    BIC = N ln(S / N) + p ln N            AICc = N ln(S / N) + 2 p N / (N - p - 1)

with S that sum, N the number of residuals and p that of free numbers (Schwarz 1978; Hurvich and Tsai 1989). A layer has
to lower the criterion by more than 10 to be taken in, "very strong" evidence (Kass and Raftery 1995). Neighbouring
samples share their errors, which neither knows: with many samples, layers pay more than they should.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mrm_mtlx.fitting.model import Evaluator, LayerStack, albedos
from mrm_mtlx.fitting.samples import RESIDUALS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.fitting.samples import Samples

LOSSES = ("soft_l1", "linear")
# By how much a layer has to lower the criterion.
DECISIVE = 10.0
# Correlations beyond this are reported.
CORRELATED = 0.95
# Relative standard errors beyond this are reported.
_UNKNOWN = 0.5
# Where samples are many, starts are tried on so many of them.
_TRIED = 1000
# Evaluations of a start that is tried.
_ROUGH = 15
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
        """C, in the units of the residual."""
        return RESIDUALS[samples.residual] if self.scale is None else self.scale


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


@dataclass(frozen=True)
class Step:
    """The gain by a layer: the fit with it, or without it, and the criterion's change by it."""

    what: str
    fit: Fit
    change: float


@dataclass(frozen=True)
class Selection:
    """The material that the data ask for, and how it was found.

    Attributes
    ----------
    fit
    criterion
        "BIC" or "AICc".
    steps
        What was fitted first, then each layer as it was taken in.
    refused
        The best of what was not taken in.
    without
        The final material less each of its layers: what each pays in it.
    agreeing, starts
        How many of the random starts of the final stack ended within a thousandth of the best cost.
    """

    fit: Fit
    criterion: str
    steps: list[Step]
    refused: list[Step]
    without: list[Step]
    agreeing: int
    starts: int


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
    best, _ = _search(stack, samples, options, starts or _random_starts(stack, options), evaluations)
    return best


def select(
    samples: Samples,
    options: FitOptions,
    *,
    base: LayerStack | None = None,
    criterion: str = "BIC",
    progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> Selection:
    """Add layers to a stack while the criterion asks for them.

    Parameters
    ----------
    samples
        What is fitted.
    options
        How.
    base
        What to begin with; by default a Lambertian surface.
    criterion
        "BIC" or "AICc".
    progress
        Called with how many candidates were tried, and the most there can be.
    """
    rng = np.random.default_rng(options.seed)
    few = samples
    if samples.count > _TRIED:
        few = samples.chosen(np.sort(rng.choice(len(samples), _TRIED // samples.value.shape[1], replace=False)))
    stack = base or LayerStack(channels=samples.value.shape[1])
    current = fit_stack(stack, samples, options, _grown(None, stack))
    steps, tried = [Step("start", current, 0.0)], 0
    while True:
        found = []
        known = _search(current.stack, few, options, [current.stack.vector(current.values)], 5)[0]
        for what, stack in _larger(current.stack, samples):
            fit, _ = _search(stack, few, options, _grown(current, stack), _ROUGH)
            found.append(Step(what, fit, _criterion(fit, criterion) - _criterion(known, criterion)))
            tried += 1
            progress(tried, _CANDIDATES)
        # What a few samples are decided about, all are: the criterion grows with their number.
        best = min(found, key=lambda step: step.change, default=None)
        step = None if best is None else _confirmed(best, current, samples, options, criterion)
        if step is None or step.change > -DECISIVE:
            refused = [step] if step is not None else []
            break
        steps.append(step)
        current = step.fit
    final, agreeing = _again(current, few, samples, options)
    progress(_CANDIDATES - 2, _CANDIDATES)
    without = []
    for what, smaller, values in _smaller(final):
        if not 0 < len(smaller.parameters) < final.free:
            continue
        fit = fit_stack(smaller, samples, options, [smaller.vector(values)])
        without.append(Step(what, fit, _criterion(final, criterion) - _criterion(fit, criterion)))
    progress(_CANDIDATES, _CANDIDATES)
    return Selection(final, criterion, steps, refused, without, agreeing, options.starts)


# The most candidates that a selection can try, seven steps of up to four, and what comes after.
_CANDIDATES = 30
_MOST_COATS, _MOST_LOBES = 2, 2


def _confirmed(step: Step, current: Fit, samples: Samples, options: FitOptions, criterion: str) -> Step:
    """A step that was tried on a few samples, with all of them."""
    stack = step.fit.stack
    fit = fit_stack(stack, samples, options, [stack.vector(step.fit.values)])
    return Step(step.what, fit, _criterion(fit, criterion) - _criterion(current, criterion))


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
        if part == "diffuse" or samples.weights is not None:
            continue
        alpha = float(fit.values[f"{part}.alpha"][0])
        inside = _within_lobe(samples, alpha, mirror=part in ("coat", "haze"))
        if inside < 3 and f"{part}.alpha" not in fit.stack.fixed:
            found.append(f"{part}: {inside} samples are within the width of this lobe, alpha {alpha:.3g}")
    return found


def _within_lobe(samples: Samples, alpha: float, *, mirror: bool) -> int:
    """Samples with facets within alpha of the normal, where half of the lobe's height and most of its width is."""
    v = samples.v * np.array([1.0, 1.0, 1.0] if mirror else [-1.0, -1.0, 1.0])
    h = v + samples.l
    return int(np.count_nonzero(np.hypot(h[:, 0], h[:, 1]) <= alpha * h[:, 2]))


def coefficient_stack(
    samples: Samples, tint: tuple[float, float, float], base: tuple[float, float, float]
) -> LayerStack:
    """The stack that coefficients of retroreflection can tell: one lobe over a base that is given.

    The width is free where there are two observation angles, the fall-off where there are two entrance angles and a
    number to spare; else they have the values of `USUAL`.
    """
    observation = np.linalg.norm(samples.v - samples.l, axis=1)
    free = {
        "alpha": np.ptp(observation) > 1e-4,
        "exponent": np.ptp(samples.l[:, 2]) > 1e-2 and samples.count > 2,
    }
    fixed = {f"{lobe}.{name}": USUAL[name] for lobe in ("lobe", "lobe2") for name in free if not free[name]}
    return LayerStack(lobes=1, falling=True, tint=tint, fixed={**fixed, "diffuse.color": base})


# What a few coefficients do not tell: the width and fall-off of prismatic tape.
USUAL = {"alpha": (0.005,), "exponent": (0.5,)}


def _larger(stack: LayerStack, samples: Samples) -> list[tuple[str, LayerStack]]:
    """Layer stacks with one thing more, and what that is; coefficients can only tell retroreflective lobes."""
    found = []
    if samples.weights is not None:
        second = replace(stack, lobes=stack.lobes + 1)
        enough = stack.lobes < _MOST_LOBES and samples.count > len(second.parameters) + 1
        return [("second retroreflective lobe", second)] if enough else []
    if stack.coats < _MOST_COATS:
        what = "haze of the coat" if stack.coats else "clear coat"
        found.append((what, replace(stack, coats=stack.coats + 1)))
    if stack.lobes < _MOST_LOBES:
        what = "second retroreflective lobe" if stack.lobes else "retroreflective lobe"
        found.append((what, replace(stack, lobes=stack.lobes + 1)))
    if stack.lobes and not stack.falling:
        found.append(("fall-off with the entrance angle", replace(stack, falling=True)))
    if stack.diffuse and not stack.rough and "diffuse.color" not in stack.fixed:
        found.append(("roughness of the base", replace(stack, rough=True)))
    # What has more numbers than there are values cannot be fitted.
    return [(what, larger) for what, larger in found if len(larger.parameters) < samples.count]


# Starts of what is new in a stack.
_NEW = {
    "weight": (0.5,),
    "share": (0.3,),
    "alpha": (0.004, 0.02, 0.2),
    "color0": (0.1,),
    "exponent": (1.0,),
    "roughness": (0.3,),
    "color": (0.5,),
    "color82": (0.3,),
}


def _grown(fit: Fit | None, stack: LayerStack) -> list[Array]:
    """Starts of a larger stack: what is known, and each of a few values for what is new."""
    known = fit.values if fit else {}
    combinations: list[dict[str, Array]] = [{}]
    for parameter in stack.parameters:
        if parameter.name in known or parameter.channel > 0:
            continue
        options = _NEW[parameter.name.partition(".")[2]]
        combinations = [
            {**one, parameter.name: np.full(stack.channels, option)} for one in combinations for option in options
        ]
    return [stack.vector({**known, **one}) for one in combinations[:8]]


def _smaller(fit: Fit) -> list[tuple[str, LayerStack, dict[str, Array]]]:
    """Layer stacks with one thing less, what that is, and where to begin."""
    stack, values = fit.stack, fit.values
    found = []
    if stack.coats:
        what = "haze of the coat" if stack.coats == 2 else "clear coat"
        found.append((what, replace(stack, coats=stack.coats - 1), values))
    if stack.lobes == 2:
        found.append(("second retroreflective lobe", replace(stack, lobes=1), values))
    elif stack.lobes:
        found.append(("retroreflective lobe", replace(stack, lobes=0, falling=False), values))
    if stack.falling:
        found.append(("fall-off with the entrance angle", replace(stack, falling=False), values))
    if stack.rough:
        found.append(("roughness of the base", replace(stack, rough=False), values))
    if stack.diffuse and stack.parts != ["diffuse"]:
        found.append(("diffuse base", replace(stack, diffuse=False, rough=False), values))
    return found


def _again(current: Fit, few: Samples, samples: Samples, options: FitOptions) -> tuple[Fit, int]:
    """The final stack from random starts as well, and how many of them agree with the best."""
    starts = _random_starts(current.stack, options)
    known = current.stack.vector(current.values)
    best, costs = _search(current.stack, few, options, [known, *starts], 30)
    agreeing = int(np.sum(np.array(costs[1:]) <= min(costs) * 1.001))
    vector = current.stack.vector(best.values)
    fit = fit_stack(current.stack, samples, options, [known, vector])
    return fit, agreeing


def _random_starts(stack: LayerStack, options: FitOptions) -> list[Array]:
    """Vectors within the bounds, the same for the same seed."""
    rng = np.random.default_rng([options.seed, len(stack.parameters)])
    lower, upper = stack.bounds()
    return [lower + (upper - lower) * u for u in 0.05 + 0.9 * rng.random((options.starts, len(lower)))]


def _search(
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
        self._family, self._samples = stack, samples
        self._evaluator = Evaluator(stack, samples.v, samples.l)
        # Layers share out grey light; of coloured, a channel could be given more than it has.
        self._colored = stack.channels == 3 or stack.tint != (1.0, 1.0, 1.0)

    def residuals(self, vector: Array) -> Array:
        values = self._family.values(vector)
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
        found = albedos(self._family, self._family.values(vector), _COSINES)
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


def _criterion(fit: Fit, name: str) -> float:
    return fit.bic if name == "BIC" else fit.aicc
