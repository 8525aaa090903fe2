"""The layers that data ask for: stacks are compared by a criterion, and a layer has to pay for its numbers.

    BIC = N ln(S / N) + p ln N            AICc = N ln(S / N) + 2 p N / (N - p - 1)

with S the sum that a fit minimises, N the number of residuals and p that of free numbers (Schwarz 1978; Hurvich and
Tsai 1989). A layer has to lower the criterion by more than 10 to be taken in, "very strong" evidence (Kass and Raftery
1995). Neighbouring samples share their errors, which neither knows: with many samples, layers pay more than they
should.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from mrm_mtlx.fitting.fit import fit_stack, random_starts, search
from mrm_mtlx.fitting.model import LayerStack, Part

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrm_mtlx.bsdf.arrays import Array
    from mrm_mtlx.fitting.fit import Fit, FitOptions
    from mrm_mtlx.fitting.samples import Samples

# By how much a layer has to lower the criterion.
DECISIVE = 10.0
# Where samples are many, starts are tried on so many of them.
_TRIED = 1000
# Evaluations of a start that is tried.
_ROUGH = 15
# The most candidates that a selection can try, seven steps of up to four, and what comes after.
_CANDIDATES = 30
_MOST_COATS, _MOST_LOBES = 2, 2
# What a few coefficients do not tell: the width and fall-off of prismatic tape.
USUAL = {"alpha": (0.005,), "exponent": (0.5,)}
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


class Criterion(StrEnum):
    """Information criteria, by the names that reports have."""

    BIC = "BIC"
    AICC = "AICc"

    def of(self, fit: Fit) -> float:
        """The criterion of a fit: the lower, the better."""
        return fit.bic if self is Criterion.BIC else fit.aicc


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
        What chose the layers.
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
    criterion: Criterion
    steps: list[Step]
    refused: list[Step]
    without: list[Step]
    agreeing: int
    starts: int


def select(
    samples: Samples,
    options: FitOptions,
    *,
    base: LayerStack | None = None,
    criterion: Criterion = Criterion.BIC,
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
        What chooses the layers.
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
        known = search(current.stack, few, options, [current.stack.vector(current.values)], 5)[0]
        for what, stack in _larger(current.stack, samples):
            fit, _ = search(stack, few, options, _grown(current, stack), _ROUGH)
            found.append(Step(what, fit, criterion.of(fit) - criterion.of(known)))
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
        without.append(Step(what, fit, criterion.of(final) - criterion.of(fit)))
    progress(_CANDIDATES, _CANDIDATES)
    return Selection(final, criterion, steps, refused, without, agreeing, options.starts)


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
    fixed = {f"{lobe}.{name}": USUAL[name] for lobe in (Part.LOBE, Part.LOBE2) for name in free if not free[name]}
    return LayerStack(lobes=1, falling=True, tint=tint, fixed={**fixed, "diffuse.color": base})


def _confirmed(step: Step, current: Fit, samples: Samples, options: FitOptions, criterion: Criterion) -> Step:
    """A step that was tried on a few samples, with all of them."""
    stack = step.fit.stack
    fit = fit_stack(stack, samples, options, [stack.vector(step.fit.values)])
    return Step(step.what, fit, criterion.of(fit) - criterion.of(current))


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
    if stack.diffuse and stack.parts != [Part.DIFFUSE]:
        found.append(("diffuse base", replace(stack, diffuse=False, rough=False), values))
    return found


def _again(current: Fit, few: Samples, samples: Samples, options: FitOptions) -> tuple[Fit, int]:
    """The final stack from random starts as well, and how many of them agree with the best."""
    starts = random_starts(current.stack, options)
    known = current.stack.vector(current.values)
    best, costs = search(current.stack, few, options, [known, *starts], 30)
    agreeing = int(np.sum(np.array(costs[1:]) <= min(costs) * 1.001))
    vector = current.stack.vector(best.values)
    fit = fit_stack(current.stack, samples, options, [known, vector])
    return fit, agreeing
